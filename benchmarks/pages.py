"""Computed tables in pages of the documentation, between the marks of a section."""

from __future__ import annotations

import re


def fill(page: str, name: str, text: str) -> str:
    """The page with the text between `<!-- begin NAME -->` and `<!-- end NAME -->`."""
    marks = rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)"
    filled, count = re.subn(marks, lambda match: f"{match[1]}{text}\n{match[2]}", page, flags=re.S)
    if count != 1:
        raise SystemExit(f"the page has no place for the section {name}")
    return filled
