"""Vectors in the fixed-step engine: sums, and with them runs, are the same to the last bit at every width."""

from __future__ import annotations

import ctypes as c
import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.native import compiler, load_library
from fowtlib.solving.engines import c_lanes, fixed_step, fixed_step_code
from fowtlib.solving.engines.c_lanes import ANY_PROCESSOR, word_here

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")

DOT = "\nEXPORT double dot(const double *a, const double *b, int n) { return fs_dot(a, b, n); }\n"
VECTORS = "#ifdef __GNUC__\n  typedef double four"


def text_of(monkeypatch, word: int) -> str:
    """The text of the runtime for vectors of so many numbers; of 0: for compilers that have none."""
    for module in (c_lanes, fixed_step_code):
        monkeypatch.setattr(module, "word_here", lambda: word or ANY_PROCESSOR)
    text = fixed_step_code._runtime_text()
    assert text.count("clang attribute push") == text.count("clang attribute pop") == (word > ANY_PROCESSOR)
    assert text.count(VECTORS) == 1
    return text if word else text.replace(VECTORS, VECTORS.replace("#ifdef __GNUC__", "#if 0"))


def test_a_sum_has_one_order(monkeypatch):
    """Of numbers that cancel, where every order has another last digit; beside the exact sum."""
    random, sums = np.random.default_rng(5), []
    pairs = [[random.normal(size=n) * 10.0 ** random.integers(-3, 4, n) for _ in range(2)] for n in range(100)]
    for word in sorted({0, ANY_PROCESSOR, word_here()}):
        _, library = load_library(text_of(monkeypatch, word) + DOT, "sums", optimization="-O1")
        library.dot.restype, library.dot.argtypes = c.c_double, [c.c_void_p, c.c_void_p, c.c_int]
        sums.append([library.dot(a.ctypes.data, b.ctypes.data, a.size) for a, b in pairs])
    assert all(found == sums[0] for found in sums)
    for found, (a, b) in zip(sums[0], pairs, strict=True):
        size = math.fsum(abs(a * b))
        assert found == pytest.approx(math.fsum(a * b), rel=0, abs=1e-15 * size)  # 10 roundings of 1.1e-16 at most
    backwards = [float(np.dot(a[::-1].copy(), b[::-1].copy())) for a, b in pairs]
    assert backwards != sums[0]  # the order shows


def test_a_run_is_the_same_at_every_width(monkeypatch):
    """Text of the model and runtime, two numbers side by side or as many as there are here."""
    results, anew = [], fixed_step_code.runtime.__wrapped__
    for where in (fixed_step, fixed_step_code):
        monkeypatch.setattr(where, "runtime", anew)
    for word in sorted({ANY_PROCESSOR, word_here()}):
        monkeypatch.setattr(fixed_step_code, "word_here", lambda word=word: word)
        plant = fw.load("two_rotor_spar_rigid").compile()
        results.append(plant.simulate(5.0, 0.5, start=plant.initial_state(), solver="fixed", step=0.05))
    for name in results[0].names:
        np.testing.assert_array_equal(results[0][name], results[-1][name])
