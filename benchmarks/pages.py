"""Computed tables in pages of the documentation, between the marks of a section."""

from __future__ import annotations

import re

Table = tuple[tuple[str, ...], list[tuple[object, ...]]]  # heads, rows


def fill(page: str, name: str, text: str) -> str:
    """The page with the text between `<!-- begin NAME -->` and `<!-- end NAME -->`."""
    marks = rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)"
    filled, count = re.subn(marks, lambda match: f"{match[1]}{text}\n{match[2]}", page, flags=re.S)
    if count != 1:
        raise SystemExit(f"the page has no place for the section {name}")
    return filled


def markdown(table: Table, digits: int = 5) -> str:
    """A table as text of a page; numbers with so many digits."""
    heads, rows = table
    lines = [heads, tuple("---" for _ in heads), *rows]
    cells = [[f"{cell:.{digits}g}" if isinstance(cell, float) else str(cell) for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)
