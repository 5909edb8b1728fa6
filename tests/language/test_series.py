"""Series of time: against SciPy, the C code against its twin, derivatives against differences."""

import ctypes
import os
import zlib

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from fowtlib.language import Series
from fowtlib.language.errors import ModelError
from fowtlib.language.native import compiler
from fowtlib.language.series import series_function

RNG = np.random.default_rng(3)
VALUES = RNG.normal(size=(12, 3))
TIMES = np.linspace(-3, 12, 301)
GRID = 1.0 + 0.5 * np.arange(12)
WAVES = Series.harmonics([0.5, 1.5], RNG.normal(size=(2, 3)), RNG.normal(size=(2, 3)))
SERIES = {
    "constant": Series.constant([1.0, -2.0, 0.5]),
    "cubic": Series.samples(VALUES, 0.5, 1.0),
    "periodic cubic": Series.samples(VALUES, 0.5, 1.0, periodic=True),
    "linear": Series.samples(VALUES, 0.5, 1.0, interpolation="linear"),
    "periodic linear": Series.samples(VALUES, 0.5, 1.0, interpolation="linear", periodic=True),
    "monotone": Series.samples(VALUES, 0.5, 1.0, interpolation="monotone"),
    "periodic monotone": Series.samples(VALUES, 0.5, 1.0, interpolation="monotone", periodic=True),
    "harmonics": WAVES,
    "build-up": Series.harmonics([0.5, 1.5], RNG.normal(size=(2, 3)), build_up=4.0),
    "transition": Series.transition(2.0, 3.0, [0, 1, 2], [5, 4, 3], polynomial=RNG.normal(size=(4, 3)),
                                    harmonics=[(2.0, np.array([1, 2j, 1 + 1j])), (5.0, -0.3)]),
}  # fmt: skip


def expected(name, t):
    inside = np.clip(t, GRID[0], GRID[-1])
    if name == "cubic":
        return CubicSpline(GRID, VALUES, bc_type="natural")(inside)
    if name == "periodic cubic":
        return CubicSpline(np.append(GRID, 7.0), np.vstack([VALUES, VALUES[:1]]), bc_type="periodic")(t)
    if name == "linear":
        return np.stack([np.interp(inside, GRID, column) for column in VALUES.T], axis=1)
    if name == "monotone":
        return PchipInterpolator(GRID, VALUES)(inside)
    return None


@pytest.mark.parametrize("name", SERIES)
def test_c_code_and_twin(name):
    series, function = SERIES[name], series_function(3)
    held = series.open_in(function)
    values = np.array([function.function([series.handle, t]).full().ravel() for t in TIMES])
    np.testing.assert_allclose(values, series(TIMES), rtol=0, atol=1e-12)
    slopes = np.array([function.function.jacobian()([series.handle, t], 0).full() for t in TIMES])
    assert not slopes[:, :, 0].any()
    np.testing.assert_allclose(slopes[:, :, 1], series.rate(TIMES), rtol=0, atol=1e-11)
    known = expected(name, TIMES)
    if known is not None:
        np.testing.assert_allclose(values, known, rtol=0, atol=1e-12)
    assert np.isnan(function.function([series.handle, np.nan]).full()).all()
    assert not function.function([0, 1.0]).full().any()
    del held
    with pytest.raises(RuntimeError):
        function.function([series.handle, 1.0])
    assert "not opened in this process" in function_problem(function)


def function_problem(function):
    from fowtlib.language.handed_numbers import problem

    return problem(function)


@pytest.mark.parametrize("name", SERIES)
def test_rates_are_differences(name):
    series, h = SERIES[name], 1e-6
    edges = np.concatenate([GRID, [2.0, 5.0]])
    smooth = TIMES[np.min(np.abs((TIMES[:, None] - edges[None]) % 0.5), axis=1) > 1e-3]
    difference = (series(smooth + h) - series(smooth - h)) / (2 * h)
    np.testing.assert_allclose(series.rate(smooth), difference, rtol=0, atol=2e-8)


FILED = SERIES | {
    "measured": Series.samples(np.round(VALUES, 2), 0.5, interpolation="linear"),
    "far apart": Series.samples(VALUES * [1e9, 0.0, 1e-300], 0.5, interpolation="cubic"),
}


@pytest.mark.skipif(not compiler(), reason="the file is read by C code")
@pytest.mark.parametrize("name", FILED)
def test_a_file_holds_the_same_numbers(name, tmp_path, monkeypatch):
    """Packed numbers come back to the last bit; a file that is cut off is refused."""
    series, function = FILED[name], series_function(3)
    held = series.open_in(function)
    told = [function.function([series.handle, t]).full().tobytes() for t in TIMES]
    del held
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path))
    path, more = series.file_for(function)
    assert more == ()
    library = ctypes.CDLL(str(function.library))
    close, handle = library.series_3_close, ctypes.c_double(series.handle)
    close.restype = None
    assert library.series_3_open(handle, os.fsencode(path)) == 0
    assert [function.function([series.handle, t]).full().tobytes() for t in TIMES] == told
    close(handle)
    whole = path.read_bytes()
    for length in (0, 40, 80, len(whole) - 8):
        path.write_bytes(whole[:length])
        assert library.series_3_open(handle, os.fsencode(path)) == 1
        assert str(path) in function_problem(function)


def test_smooth_series_make_small_files():
    """Waves with periods of 5 to 20 s take less than two thirds of what an archive needs for the plain numbers."""
    t = 0.25 * np.arange(16384)
    wave = sum(np.cos(2 * np.pi * k * t / 4096 + k * k) for k in range(205, 820, 5))
    series = Series.samples(wave, 0.25, periodic=True)
    path, _ = series.file_for(series_function(1))
    assert 3 * len(zlib.compress(path.read_bytes(), 9)) < 2 * len(zlib.compress(series.block.tobytes(), 9))


def test_closed_forms():
    t = np.linspace(0, 20, 401)
    np.testing.assert_allclose(
        Series.harmonics([0.7], [[2.0]], [[0.3]])(t)[:, 0], 2 * np.cos(0.7 * t + 0.3), rtol=0, atol=1e-13
    )
    assert Series.harmonics([0.7], [2.0], build_up=5.0)(0.0)[0] == 0
    assert Series.samples(VALUES, 0.5, 1.0).covers == (1.0, 6.5)
    assert SERIES["transition"].breaks == (2.0, 5.0)
    monotone = Series.samples([0.0, 0, 0, 1, 1, 1], 1.0, interpolation="monotone")(np.linspace(0, 5, 101))
    assert monotone.min() == 0
    assert monotone.max() == 1


def test_many_series_are_told_apart():
    function = series_function(1)
    every = [Series.constant([float(k)]) for k in range(500)]
    held = [series.open_in(function) for series in every]
    held += [every[7].open_in(function)]
    for k in range(0, 500, 2):
        held[k] = None
    held[7] = None  # it was opened twice
    for k in range(1, 500, 2):
        assert float(function.function([every[k].handle, 0.0])) == k
    with pytest.raises(RuntimeError):
        function.function([every[8].handle, 0.0])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Series.samples([1, 2, 3], 1.0), "4 samples or more, and 3 are given"),
        (lambda: Series.samples(VALUES, 0.0), "the step must be above zero"),
        (lambda: Series.samples([1, np.nan, 3, 4], 1.0), "finite numbers"),
        (lambda: Series.samples(VALUES, 1.0, interpolation="smooth"), "no interpolation 'smooth'"),
        (lambda: Series.transition(0, 0, [1], [1]), "transition of 0 s"),
    ],
)
def test_wrong_series(make, words):
    with pytest.raises(ModelError, match=words):
        make()
