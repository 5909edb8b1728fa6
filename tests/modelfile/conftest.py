"""Model files written for one test, in a folder of their own."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture
def write(tmp_path, monkeypatch) -> Callable[..., Path]:
    """`write(text, "name.yaml")` in the working folder; gives the path relative to it."""
    monkeypatch.chdir(tmp_path)

    def write_file(text: str, name: str = "model.yaml") -> Path:
        path = Path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return path

    return write_file
