"""The report of a batch: what was run, how the results go with the wind, what is extreme and where, and what failed."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from fowtlib.language.whole_files import write_text
from fowtlib.report import sections
from fowtlib.report.content import page
from fowtlib.report.view import View

if TYPE_CHECKING:
    from fowtlib.cases import Batch


def write_batch_page(batch: Batch, path: str | Path, *, title: str = "", channels: Sequence[str] | None = None,
                     command: str = "") -> Path:  # fmt: skip
    """Write the report of a batch as one HTML file; see `batch_page`."""
    return write_text(path, batch_page(batch, title=title, channels=channels, command=command))


def batch_page(batch: Batch, *, title: str = "", channels: Sequence[str] | None = None, command: str = "") -> str:
    """The report of a batch as HTML that needs no other file.

    channels: names of the results with figures of their own; None takes the usual ones of a floating turbine and the
    loads. command: what to write as the way to make the page again. Raises ModelError where no case is done.
    """
    view = View(batch, list(channels or ()))
    of = sections
    kinds = (of.cases, of.over_the_label, of.statistics, of.extremes, of.ultimate, of.fatigue, of.worst_cases,
             of.spectra, of.failures)  # fmt: skip
    parts = [kind(view) for kind in kinds]
    shown = [part for part in (*parts, sections.provenance(view, command)) if part is not None]
    name = title or view.title
    made = f"Made by fowtlib {version('fowtlib')} on {datetime.now().astimezone():%Y-%m-%d %H:%M %Z}."
    return page(name, view.lead, shown, made)
