"""A disk without room while something is saved: a sentence, what stood there stays, and no half file is left."""

from __future__ import annotations

import errno
import os
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from fowtlib.analysis.rao import Rao
from fowtlib.analysis.static import StaticCurve
from fowtlib.design.journal import Journal
from fowtlib.fmi.export import _scratch
from fowtlib.frequency.found import Response
from fowtlib.language import cache_folder as store
from fowtlib.language import native, stand_in
from fowtlib.language.errors import ModelError
from fowtlib.language.handed_numbers import kept_file
from fowtlib.language.native import compile_library, compiler, run_compiler

resource = pytest.importorskip("resource")
FULL = "/dev/full"
MANY = 2000
LINE = np.arange(float(MANY))


@contextmanager
def room_of(size: int):
    """No file of this process may become larger [bytes], as on a disk that fills up on the way."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


SAVED = {
    "spectra.nc": Response(LINE, ("surge",), ("m",), np.zeros(1), {"sea": np.ones((1, MANY))}, {}, None, None),
    "spectra.csv": Response(LINE, ("surge",), ("m",), np.zeros(1), {"sea": np.ones((1, MANY))}, {}, None, None),
    "curve.csv": StaticCurve("x", LINE, ("surge",), np.ones((MANY, 1)), ("m",)),
    "rao.csv": Rao(LINE, ("surge",), np.ones((MANY, 1), dtype=complex), ("m",)),
}


@pytest.mark.parametrize("name", SAVED)
def test_what_stood_there_stays_and_nothing_half_is_left(name, tmp_path):
    path = tmp_path / name
    path.write_text("of an earlier run")
    with room_of(4000), pytest.raises(ModelError, match=f"{name}: cannot be written: File too large"):
        SAVED[name].save(path)
    assert [file.name for file in tmp_path.iterdir()] == [name]
    assert path.read_text() == "of an earlier run"
    assert SAVED[name].save(path) == path
    assert path.stat().st_size > 4000


@pytest.mark.skipif(not Path(FULL).exists(), reason="needs /dev/full")
def test_a_journal_without_room_says_so_once():
    journal = Journal(FULL, {"of": "a design"})
    with pytest.raises(ModelError, match=f"{FULL}: cannot be written: No space left on device"):
        journal.begin(resume=False)
    journal.close()


@pytest.mark.parametrize("name", ["oscillator.fmu", "other.fmu"])
def test_no_room_for_what_goes_into_an_fmu(name, tmp_path):
    wanted = pytest.raises(ModelError, match=f"{name}: cannot be written: File too large")
    with wanted, _scratch(tmp_path / name) as made, room_of(100):
        (made / "tables.h").write_text("double" * 100)
    assert not made.exists()


# --- the cache ------------------------------------------------------------------------------------------------------


@pytest.fixture
def full(tmp_path, monkeypatch):
    """A cache folder in which nothing finds room, but in the one that stands in for it."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("FOWTLIB_CACHE", str(folder))
    monkeypatch.setenv(stand_in.VARIABLE, "")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    put = store.keep

    def keep(name: str, suffix: str, made: Path) -> Path:
        if made.is_relative_to(folder):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(made))
        return put(name, suffix, made)

    monkeypatch.setattr(store, "keep", keep)
    return folder


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_a_library_is_put_elsewhere(full):
    with pytest.warns(UserWarning, match="cannot be written to .No space left on device.; .* is used until"):
        library = compile_library("EXPORT int seven(void) { return 7; }\n", "seven")
    assert native.open_library(library).seven() == 7
    assert library.parent == store.cache_folder() != full


def test_numbers_are_put_elsewhere(full):
    with pytest.warns(UserWarning, match="cannot be written to .No space left on device.; .* is used until"):
        path = kept_file("numbers_" + 12 * "0", "packed", b"12")
    assert path.read_bytes() == b"12"
    assert not list(full.iterdir())


def test_a_compiler_without_room_is_not_a_mistake_in_the_text(tmp_path):
    says = tmp_path / "gcc"
    says.write_text("#!/bin/sh\necho 'ld: error: final link failed: No space left on device' >&2\nexit 1\n")
    says.chmod(0o700)
    with pytest.raises(OSError, match="No space left on device") as raised:
        run_compiler([str(says), "-o", "out.so", "-lm"], "thing")
    assert (raised.value.errno, raised.value.filename) == (errno.ENOSPC, "out.so")
