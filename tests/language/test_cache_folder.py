"""The cache folder is the user's alone, nothing of it is used unchecked, and it does not grow without limit."""

from __future__ import annotations

import errno
import gc
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import pytest

from fowtlib.language import cache_folder as store
from fowtlib.language import stand_in
from fowtlib.language.errors import CompilerError, ParameterError
from fowtlib.language.native import compile_library, compiler, load_library, open_library

posix = pytest.mark.skipif(sys.platform == "win32", reason="owners and modes of files")
needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
as_root = pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() != 0, reason="only root gives files away")

TEXT = "EXPORT int number(void) { return 7; }\n"
OTHER = 12345  # a user


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def keep(name: str, content: bytes = b"content", suffix: str = "json") -> Path:
    with store.workshop() as folder:
        (folder / "fresh").write_bytes(content)
        return store.keep(name, suffix, folder / "fresh")


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


KEY = "thing_" + 12 * "0"


# --- the user's alone ----------------------------------------------------------------------------------------------


@posix
def test_folder_and_files_are_closed_to_others(own_cache):
    previous = os.umask(0)
    try:
        path = keep(KEY)
    finally:
        os.umask(previous)
    assert (mode(own_cache), mode(path)) == (0o700, 0o600)
    assert [file.name for file in own_cache.iterdir()] == [path.name]


@posix
@pytest.mark.parametrize("rights", [0o755, 0o750])
def test_what_others_could_only_read_is_closed_and_kept(own_cache, rights):
    path = keep(KEY)
    own_cache.chmod(rights)
    assert store.find(KEY, "json") == path
    assert mode(own_cache) == 0o700


@posix
@pytest.mark.parametrize("rights", [0o777, 0o770, 0o1777])
def test_what_others_could_write_is_made_again(own_cache, rights):
    keep(KEY)
    own_cache.chmod(rights)
    with pytest.warns(UserWarning, match="others could write to this folder; what was kept there is made again"):
        assert store.find(KEY, "json") is None
    assert mode(own_cache) == 0o700


@posix
def test_a_folder_with_other_files_is_not_closed_but_refused(own_cache):
    own_cache.mkdir()
    own_cache.chmod(0o755)
    (own_cache / "thesis.tex").write_text("")
    with pytest.raises(PermissionError, match="files of another kind, such as 'thesis.tex'"):
        store.find(KEY, "json")
    assert mode(own_cache) == 0o755


@posix
@pytest.mark.parametrize("depth", [0, 1])
def test_a_folder_that_others_could_exchange_is_refused(tmp_path, monkeypatch, depth):
    above = tmp_path / "open"
    folder = above.joinpath(*depth * ["middle"], "cache")
    folder.parent.mkdir(parents=True)
    monkeypatch.setenv("FOWTLIB_CACHE", str(folder))
    above.chmod(0o777)
    with pytest.raises(PermissionError, match="everybody can write to .*open"):
        keep(KEY)
    above.chmod(0o1777)  # as /tmp: who does not own it cannot exchange it
    keep(KEY)


@as_root
def test_a_folder_of_another_user_is_refused(own_cache):
    keep(KEY)
    os.chown(own_cache, OTHER, OTHER)
    with pytest.raises(PermissionError, match="it belongs to another user"):
        store.find(KEY, "json")
    if compiler():
        with pytest.raises(CompilerError, match="it belongs to another user; .* FOWTLIB_CACHE names another folder"):
            compile_library(TEXT, "number")


@pytest.mark.parametrize("variable", ["XDG_CACHE_HOME", "HOME"])
@pytest.mark.parametrize("value", ["", ".", "here/cache"])
@posix
def test_a_relative_home_is_not_followed(monkeypatch, tmp_path, variable, value):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("FOWTLIB_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv(variable, value)
    folder = store.cache_folder()
    assert folder.is_absolute()
    assert not folder.is_relative_to(tmp_path)


def test_a_relative_folder_is_refused(monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", "cache")
    with pytest.raises(PermissionError, match="FOWTLIB_CACHE is not an absolute path"):
        store.private_folder()


# --- nothing unchecked ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "damage, words",
    [
        (lambda path: path.write_bytes(b""), "is empty"),
        (lambda path: path.write_bytes(path.read_bytes()[:-100]), "is damaged"),
        (lambda path: path.write_bytes(path.read_bytes()[:-1] + b"\xff"), "is damaged"),
        (lambda path: path.write_bytes(b"\x7fELF of a stranger"), "is damaged"),
        pytest.param(lambda path: path.chmod(0o666), "can be written by others", marks=posix),
        pytest.param(lambda path: os.chown(path, OTHER, OTHER), "belongs to another user", marks=as_root),
        pytest.param(lambda path: _linked(path), "is not a regular file", marks=posix),
        (lambda path: (path.unlink(), path.mkdir(), (path / "inside").touch()), "is not a regular file"),
    ],
)
@needs_compiler
def test_a_library_that_is_not_what_was_kept_is_compiled_again(damage, words):
    path = compile_library(TEXT, "number")
    damage(path)
    with pytest.warns(UserWarning, match=f"number_.*: this file {words}; it is made again"):
        again, library = load_library(TEXT, "number")
    assert library.number() == 7
    assert again.is_file() and not again.is_symlink()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert compile_library(TEXT, "number") == again


def _linked(path: Path) -> None:
    elsewhere = path.rename(path.parent.parent / "elsewhere.so")
    path.symlink_to(elsewhere)


@needs_compiler
def test_two_processes_on_one_cold_cache():
    program = (
        "from fowtlib.language.native import load_library\n"
        f"for k in range(4): assert load_library({TEXT!r} + f'// {{k}}', 'number')[1].number() == 7\n"
    )
    both = [subprocess.Popen([sys.executable, "-W", "error", "-c", program]) for _ in range(2)]
    assert [process.wait(120) for process in both] == [0, 0]
    assert not [path for path in store.cache_folder().iterdir() if path.is_dir()]
    assert len({entry.files for entry in store.entries()}) == 4


@needs_compiler
def test_a_library_that_vanishes_before_it_is_loaded_is_compiled_again(monkeypatch):
    from fowtlib.language import native

    original, calls = native.compile_library, []

    def vanishing(*arguments, **options):
        path = original(*arguments, **options)
        calls.append(path)
        if len(calls) == 1:
            path.unlink()
        return path

    monkeypatch.setattr(native, "compile_library", vanishing)
    assert load_library(TEXT + "// vanishes", "number")[1].number() == 7
    assert len(calls) == 2


@needs_compiler
def test_a_library_is_closed_when_nobody_holds_it():
    def mapped(path: Path) -> bool:
        return str(path) in Path("/proc/self/maps").read_text()

    if not Path("/proc/self/maps").exists():
        pytest.skip("needs /proc")
    path, library = load_library(TEXT + "// closed", "number")
    assert open_library(path) is library
    function = library["number"]
    del library
    open_library(compile_library(TEXT, "number"))
    assert mapped(path) and function() == 7
    del function
    gc.collect()
    open_library(compile_library(TEXT, "number"))
    assert not mapped(path)


# --- its size ------------------------------------------------------------------------------------------------------


def aged(path: Path, seconds: float) -> Path:
    os.utime(path, 2 * (time.time() - seconds,))
    return path


def test_what_was_used_longest_ago_goes_first(monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE_LIMIT", "0.0025")
    paths = [keep(f"thing_{k:012x}", b"%d" % k + bytes(999)) for k in range(4)]
    for k, path in enumerate(paths):
        aged(path, 8000 - 1000 * k)
    store.find("thing_" + f"{0:012x}", "json")  # now it was used last
    store.prune()
    assert [path.exists() for path in paths] == [True, False, False, True]


def test_what_is_in_use_now_stays(monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE_LIMIT", "0")
    young, old = keep(KEY), aged(keep("thing_" + 12 * "1"), 700)
    store.prune()
    assert young.exists() and not old.exists()


def test_what_a_killed_process_left_goes(own_cache):
    keep(KEY)
    for name in ("making_old", "making_new"):
        (own_cache / name).mkdir()
        (own_cache / name / "source.c").write_text("x")
    aged(own_cache / "making_old", 4000)
    store.prune()
    assert sorted(path.name for path in own_cache.iterdir() if path.is_dir()) == ["making_new"]


@pytest.mark.parametrize("text", ["much", "-1", "inf", "nan", ""])
def test_a_limit_that_is_none_is_refused(monkeypatch, text):
    monkeypatch.setenv("FOWTLIB_CACHE_LIMIT", text)
    with pytest.raises(ParameterError, match="FOWTLIB_CACHE_LIMIT is '.*'; a number of MB is expected"):
        store.limit()


def test_clearing_leaves_the_files_of_others(own_cache):
    keep(KEY)
    (own_cache / "notes.txt").write_text("mine")
    assert [entry.kind for entry in store.clear()] == ["thing"]
    assert [path.name for path in own_cache.iterdir()] == ["notes.txt"]


# --- where it cannot be written to -----------------------------------------------------------------------------------


@pytest.fixture
def read_only(own_cache, monkeypatch):
    """The folder as the system shows a file system that is mounted read-only, to root, too."""
    keep(KEY)
    real = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != own_cache and real(path, mode))
    monkeypatch.setenv(stand_in.VARIABLE, "")
    yield own_cache
    shutil.rmtree(store.cache_folder(), ignore_errors=True)


@posix
def test_a_temporary_folder_stands_in_for_one_that_cannot_be_written_to(read_only):
    with pytest.warns(UserWarning, match=f"{read_only}: .* cannot be written to .* FOWTLIB_CACHE names another"):
        path = keep("thing_" + 12 * "1")
    assert path.parent == store.cache_folder() != read_only
    assert mode(path.parent) == 0o700
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # it is said once
        assert store.find("thing_" + 12 * "1", "json") == path
        assert store.find(KEY, "json").parent == read_only  # what is there can be used
        (read_only / store.find(KEY, "json").name).write_text("changed")
        assert store.find(KEY, "json") is None


@posix
def test_processes_share_the_folder_that_stands_in_and_it_goes_with_the_first(tmp_path):
    closed = tmp_path / "file" / "cache"
    say = "from fowtlib.language import cache_folder as s; print(s.private_folder(), flush=True)"
    code = (
        "import errno, os, subprocess, sys\n"
        "from fowtlib.language import cache_folder as s, stand_in\n"
        f"stand_in.make_stand_in(s.named_folder(), OSError(errno.EROFS, 'Read-only file system', {str(closed)!r}))\n"
        f"{say}\n"
        f"subprocess.run([sys.executable, '-c', {say!r}], check=True)\n"
        "assert os.path.isdir(s.cache_folder())\n"
    )
    environment = os.environ | {"FOWTLIB_CACHE": str(closed)}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    first, second = run.stdout.split()
    assert first == second
    assert not Path(first).exists()
    assert run.stderr.count("cannot be written to (Read-only file system)") == 1


@posix
def test_what_is_not_safe_has_no_stand_in(own_cache, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", "here")
    with pytest.raises(PermissionError, match="not an absolute path"):
        store.private_folder()


@posix
@pytest.mark.parametrize("error", [errno.EROFS, errno.EACCES, errno.ENOSPC])
def test_without_any_folder_the_error_is_that_of_the_first(own_cache, monkeypatch, error):
    def refuse(*_, **__):
        raise OSError(errno.ENOENT, "No usable temporary directory found")

    monkeypatch.setattr(tempfile, "mkdtemp", refuse)
    with pytest.raises(OSError, match="the first") as raised:
        stand_in.make_stand_in(own_cache, OSError(error, "the first", str(own_cache)))
    assert raised.value.errno == error
    assert stand_in.stand_in(own_cache) is None
