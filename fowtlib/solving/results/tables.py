"""Tables as CSV, with the units in the header line."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fowtlib.language.errors import ModelError


def write_table(path: str | Path, columns: Sequence[str], rows: Iterable[Sequence[Any]], what: str) -> Path:
    """Write rows below their heads; numbers with ten digits. what: how an error calls it, "statistics"."""
    path = Path(path)
    if path.suffix != ".csv":
        raise ModelError(f"{path}: {what}: saved as .csv, not as '{path.suffix or 'no ending'}'.")
    try:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([f"{v:.10g}" if isinstance(v, float) else v for v in row] for row in rows)
    except OSError as error:
        raise ModelError(f"{path}: cannot be written: {error.strerror}.") from error
    return path
