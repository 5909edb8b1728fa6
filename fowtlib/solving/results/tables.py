"""Tables as CSV, with the units in the header line."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_text


def write_table(path: str | Path, columns: Sequence[str], rows: Iterable[Sequence[Any]], what: str) -> Path:
    """Write rows below their heads; numbers with ten digits. what: how an error calls it, "statistics"."""
    path = Path(path)
    if path.suffix != ".csv":
        raise ModelError(f"{path}: {what}: saved as .csv, not as '{path.suffix or 'no ending'}'.")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([f"{v:.10g}" if isinstance(v, float) else v for v in row] for row in rows)
    return write_text(path, text.getvalue())
