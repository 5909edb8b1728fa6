"""What a page consists of: sections of sentences, tables and figures; and how it becomes HTML."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from fowtlib.solving.results.drawing import drawing_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

TEMPLATE = "page.html.jinja"


@dataclass(frozen=True)
class Link:
    """A word that leads to a place on the page."""

    text: str
    anchor: str


Cell = str | float | int | Link | None


@dataclass(frozen=True)
class Table:
    """Rows under heads with units. caption: a sentence; folded: shown when one asks for it; anchors: of the rows."""

    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    folded: str = ""
    anchors: Sequence[str] = ()


@dataclass(frozen=True)
class Figure:
    """A drawing as SVG, with a sentence that says its number."""

    svg: str
    caption: str
    anchor: str = ""
    wide: bool = False


@dataclass
class Section:
    """A part of the page: sentences, then figures, then tables."""

    title: str
    sentences: list[str] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)

    @property
    def anchor(self) -> str:
        """Where links lead."""
        return anchor(self.title)


def anchor(text: str) -> str:
    """A text as the name of a place on a page; different for different texts that files can be called by."""
    return re.sub(r"[^A-Za-z0-9_.-]", lambda found: f"-{ord(found.group()):x}-", text.replace(" ", "_"))


def shown(cell: Cell) -> str:
    """A cell as HTML: numbers with four digits."""
    if cell is None:
        return ""
    if isinstance(cell, Link):
        return f'<a href="#{html.escape(cell.anchor)}">{html.escape(cell.text)}</a>'
    return html.escape(cell if isinstance(cell, str) else number(cell))


def number(value: float) -> str:
    """Four digits; whole numbers up to ten millions without a power of ten."""
    if isinstance(value, int) or value == 0:
        return str(int(value))
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"


def time_span(seconds: float) -> str:
    """A time in the unit that suits it."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def drawn(drawing: Drawing, caption: str, name: str, wide: bool = False) -> Figure:
    """A figure of the page from a drawing; name: of its place."""
    return Figure(_svg_of(drawing, name), caption, name, wide)


def _svg_of(drawn: Drawing, name: str) -> str:
    """The drawing as an element of a page, which takes the width that it finds; its text stays text."""
    import matplotlib

    text = io.StringIO()
    with drawing_style(), matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        drawn.savefig(text, format="svg", metadata={"Date": None})
    whole = text.getvalue()
    whole = re.sub(r"<metadata>.*?</metadata>", "", whole[whole.index("<svg") :], flags=re.DOTALL)
    head, rest = whole.split(">", 1)
    whole = re.sub(r'\s(?:width|height)="[^"]*"', "", head) + ">" + rest
    named = set(re.findall(r"#([\w.-]+)", whole))  # names that nothing refers to would stand on a page many times
    return re.sub(r' id="([^"]*)"', lambda found: found.group() if found.group(1) in named else "", whole)


def page(title: str, lead: Sequence[str], sections: Sequence[Section], foot: str) -> str:
    """One HTML page with its own style, figures and links, and nothing from elsewhere."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.filters["shown"] = shown
    numbers = iter(range(1, 10_000))
    return environment.get_template(TEMPLATE).render(title=title, lead=lead, sections=sections, foot=foot,
                                                     next_number=lambda: next(numbers))  # fmt: skip
