"""Tables as CSV, with the units in the header line; or as markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_text


def write_table(
    path: str | Path,
    columns: Sequence[str],
    rows: Iterable[Sequence[Any]],
    what: str,
    markdown: Callable[[], str] | None = None,
) -> Path:
    """Write rows below their heads; numbers with ten digits.

    what: how an error calls it, "statistics". markdown: gives what is written to a path with .md.
    """
    path = Path(path)
    if markdown and path.suffix == ".md":
        return write_text(path, markdown())
    if path.suffix != ".csv":
        endings = ".csv or .md" if markdown else ".csv"
        raise ModelError(f"{path}: {what}: saved as {endings}, not as '{path.suffix or 'no ending'}'.")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([f"{v:.10g}" if isinstance(v, float) else v for v in row] for row in rows)
    return write_text(path, text.getvalue())
