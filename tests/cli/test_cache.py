"""`fowt cache` shows what is kept, and deletes it."""

from __future__ import annotations

import json

import pytest

from fowtlib.cli.app import main
from fowtlib.language.cache import cached


@pytest.fixture
def kept(tmp_path, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path))
    monkeypatch.setenv("FOWTLIB_CACHE_LIMIT", "12.5")
    for k in range(3):
        cached("thing", [str(k)], lambda: list(range(1000)))
    cached("other", ["a"], lambda: 1)
    return tmp_path


def test_it_shows_and_clears(kept, capsys):
    assert main(["cache"]) == 0
    said = capsys.readouterr().out
    assert f"{kept}: 4 files, 0.0 MB; the limit is 12.5 MB." in said
    assert main(["cache", "--json"]) == 0
    rows = {row["kind"]: row for row in json.loads(capsys.readouterr().out)}
    assert (rows["thing"]["contents"], rows["other"]["files"]) == (3, 1)
    assert main(["cache", "--clear"]) == 0
    assert "deleted 4 files" in capsys.readouterr().out
    assert list(kept.iterdir()) == []
    assert main(["cache"]) == 0
    assert "0 files" in capsys.readouterr().out


def test_a_relative_folder_is_refused(monkeypatch, capsys):
    monkeypatch.setenv("FOWTLIB_CACHE", "somewhere")
    assert main(["cache"]) == 2
    assert "somewhere: FOWTLIB_CACHE is not an absolute path" in capsys.readouterr().err
