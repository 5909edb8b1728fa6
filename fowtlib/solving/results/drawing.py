"""How all figures look, and how they are made and saved: no window, no global state of pyplot."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLORS = ("#0b5394", "#d1651b", "#2f7d4f", "#8a3d8f", "#b8860b", "#4d4d4d", "#1a9ba1", "#c2385a")
INK, GRID = "#222222", "#d9d9d9"
_STYLE = {
    "font.size": 9.0,
    "axes.edgecolor": "#888888",
    "axes.labelcolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.titlepad": 4.0,
    "axes.xmargin": 0.0,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "xtick.color": INK,
    "ytick.color": INK,
    "svg.hashsalt": "fowtlib",
}


def drawing_style() -> AbstractContextManager[None]:
    """The settings of matplotlib under which a figure is drawn and saved."""
    import matplotlib

    return matplotlib.rc_context(_STYLE)


def drawing(width: float, height: float, edges: Mapping[str, float] | None = None) -> Figure:
    """An empty figure of so many inches.

    edges: left, right, bottom and top of the axes as parts of the figure; without them all labels find their room.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="none" if edges else "constrained")
    if edges:
        figure.subplots_adjust(**edges)
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Figure, path: str | Path | None, *, dpi: int = 150) -> Figure:
    """Write a figure by the ending of ``path`` (png, pdf, svg); None leaves it unsaved. Returns the figure."""
    if path is None:
        return figure
    path = Path(path)
    known = (".png", ".pdf", ".svg")
    if path.suffix.lower() not in known:
        raise ModelError(f"{path}: a figure is saved as {', '.join(known)}, not as '{path.suffix or 'no ending'}'.")
    if not path.parent.is_dir():
        raise ModelError(f"{path}: the folder {path.parent} does not exist. Make it first, or choose another one.")
    with drawing_style():
        write_whole(path, lambda temporary: figure.savefig(temporary, dpi=dpi))
    return figure
