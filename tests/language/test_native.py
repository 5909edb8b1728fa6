"""C code is compiled once, kept by its content, and says clearly why it cannot be compiled."""

from __future__ import annotations

import shlex
import sys
import threading

import numpy as np
import pytest

from fowtlib.language import ExternalFunction
from fowtlib.language.errors import CompilerError, ParameterError
from fowtlib.language.native import begin_library, compile_library, compiler, say_once

needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")

TWICE = """
typedef long long int casadi_int;
static const casadi_int pattern[] = {1, 1, 1};
EXPORT int twice(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
    if (res[0]) res[0][0] = FACTOR * arg[0][0];
    return 0;
}
EXPORT const casadi_int *twice_sparsity_in(casadi_int i) { return pattern; }
EXPORT const casadi_int *twice_sparsity_out(casadi_int i) { return pattern; }
EXPORT casadi_int twice_n_in(void) { return 1; }
EXPORT casadi_int twice_n_out(void) { return 1; }
"""


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@needs_compiler
def test_a_library_is_made_once_for_each_content(own_cache):
    library = compile_library("#define FACTOR 2.0\n" + TWICE, "twice")
    made = library.stat().st_ino
    assert library.parent == own_cache
    assert compile_library("#define FACTOR 2.0\n" + TWICE, "twice").stat().st_ino == made
    other = compile_library("#define FACTOR 3.0\n" + TWICE, "twice")
    assert other != library
    assert sorted(path.suffix for path in own_cache.iterdir()) == [".c", ".c", ".so", ".so"]


@pytest.fixture
def slow_compiler(tmp_path, monkeypatch):
    """A compiler that notes each text it is given, and waits until there is a file `go`."""
    told, go, script = tmp_path / "told", tmp_path / "go", tmp_path / "slow_cc"
    command = shlex.join(compiler())
    wait = f"while [ ! -e {go} ]; do sleep 0.02; done"
    lines = [f'case "$1" in --version) exec {command} --version;; esac', f"echo text >> {told}", wait]
    script.write_text("\n".join(["#!/bin/sh", *lines, f'exec {command} "$@"', ""]))
    script.chmod(0o700)
    monkeypatch.setenv("FOWTLIB_CC", str(script))
    return told, go


@needs_compiler
@pytest.mark.skipif(sys.platform == "win32", reason="a script of the shell")
def test_a_library_that_was_begun_is_waited_for_and_compiled_once(own_cache, slow_compiler):
    told, go = slow_compiler
    text = f"#define FACTOR 4.0\n{TWICE}"
    begin_library(text, "twice")
    begin_library(text, "twice")
    assert not list(own_cache.glob("*.so"))  # the compiler waits, and nobody waits for it
    threading.Timer(0.3, go.touch).start()
    assert compile_library(text, "twice").is_file()
    assert told.read_text() == "text\n" and len(list(own_cache.glob("*.so"))) == 1
    assert not [path for path in own_cache.iterdir() if path.is_dir()]  # no workshop is left
    begin_library(text, "twice")  # it is there: nothing to do
    compile_library(text, "twice")
    assert told.read_text() == "text\n"


@needs_compiler
@pytest.mark.skipif(sys.platform == "win32", reason="a script of the shell")
def test_a_function_that_is_compiled_beside_is_waited_for_where_it_is_called(slow_compiler):
    told, go = slow_compiler

    def text(factor: float) -> str:
        return f"#define FACTOR {factor}\n{TWICE}"

    waiting = [ExternalFunction("twice", {"x": 1}, {"y": 1}, source=text(f), beside=True) for f in (6.0, 7.0, 8.0)]
    assert not any("function" in vars(function) for function in waiting)  # nobody has waited
    go.touch()
    assert [float(function.function(2.0)) for function in reversed(waiting)] == [16.0, 14.0, 12.0]
    assert told.read_text() == 3 * "text\n"  # each once, whoever compiled it
    wrong = ExternalFunction("broken", {"x": 1}, {"y": 1}, source="int broken(", beside=True)
    for _ in range(2):
        with pytest.raises(CompilerError, match="broken: its C code does not compile"):
            _ = wrong.library
    other = ExternalFunction("twice", {"x": 2}, {"y": 1}, source=text(9.0), beside=True)
    with pytest.raises(ParameterError, match="1 inputs and 1 outputs in its library, 2 and 1 declared"):
        _ = other.function


@needs_compiler
@pytest.mark.skipif(sys.platform == "win32", reason="a script of the shell")
def test_a_wrong_text_that_was_begun_is_said_where_it_is_asked_for(slow_compiler, capfd):
    slow_compiler[1].touch()
    begin_library("int broken(", "broken")
    with pytest.raises(CompilerError, match="broken: its C code does not compile with .*error"):
        compile_library("int broken(", "broken")
    assert capfd.readouterr().err == ""


@needs_compiler
def test_what_is_asked_for_in_another_cache_is_compiled_there(tmp_path, monkeypatch):
    begin_library(TWICE.replace("FACTOR", "5.0"), "twice")
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "other"))
    assert compile_library(TWICE.replace("FACTOR", "5.0"), "twice").parent == tmp_path / "other"


@needs_compiler
def test_two_contents_of_one_name_live_together():
    functions = [
        ExternalFunction("twice", {"x": 1}, {"y": 1}, source=f"#define FACTOR {factor}\n{TWICE}").function
        for factor in (2.0, 3.0)
    ]
    assert [float(function(5.0)) for function in functions] == [10.0, 15.0]


@needs_compiler
def test_wrong_text_gives_the_words_of_the_compiler():
    with pytest.raises(CompilerError, match="broken: its C code does not compile with .*error"):
        compile_library("int broken(", "broken")


@needs_compiler
def test_a_cache_that_cannot_be_written(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "file"))
    with pytest.raises(CompilerError, match="cannot write the compiled library .* FOWTLIB_CACHE names another folder"):
        compile_library(TWICE, "twice")


def test_without_a_compiler_the_way_out_is_named(monkeypatch):
    monkeypatch.setenv("FOWTLIB_CC", "no-such-compiler")
    assert compiler() == ()
    with pytest.raises(CompilerError, match="Install gcc or clang .* FOWTLIB_CC, .*ziglang"):
        ExternalFunction("twice", {"x": 1}, {"y": 1}, source=TWICE)
    say_once.cache_clear()
    with pytest.warns(RuntimeWarning) as told:
        functions = [
            ExternalFunction(name, {"x": 1}, {"y": 1}, source=TWICE, python=lambda x: 2 * x).function
            for name in ("twice", "twice_2", "twice_3")
        ]
    (line,) = [str(warning.message) for warning in told]
    assert "run as Python code, slowly: FOWTLIB_CC names 'no-such-compiler', which is no program here" in line
    function = functions[0]
    assert float(function(np.array([4.0]))) == 8.0
