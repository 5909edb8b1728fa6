"""Harmonic fits and statistics of known signals."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.analysis.harmonics import harmonic_fit
from fowtlib.analysis.statistics import normalized_maxima, over_seeds, up_crossings
from fowtlib.language.errors import ModelError
from fowtlib.solving.results import Result

TIME = np.arange(0.0, 300.05, 0.1)


def test_amplitude_phase_and_harmonics():
    angle = 2 * np.pi * 0.093 * TIME
    values = 5.0 + 2.0 * np.cos(angle + 0.7) + 0.3 * np.cos(2 * angle - 1.1)
    fit = harmonic_fit((TIME, values), 0.093, harmonics=2, discard=50)
    assert fit.mean == pytest.approx(5.0)
    assert (fit.amplitude, fit.phase) == (pytest.approx(2.0), pytest.approx(0.7))
    assert fit.coefficients[1] == pytest.approx(0.3 * np.exp(-1.1j))
    assert fit.residual == pytest.approx(0.0, abs=1e-10)
    assert fit.unsteadiness == pytest.approx(0.0, abs=1e-10)


def test_a_growing_motion_is_not_steady():
    values = (1 + TIME / 300) * np.cos(2 * np.pi * 0.1 * TIME)
    assert harmonic_fit((TIME, values), 0.1).unsteadiness == pytest.approx(1 / 3, rel=0.05)


def test_too_short_or_too_coarse():
    with pytest.raises(ModelError) as caught:
        harmonic_fit((TIME, TIME), 0.005, name="surge")
    assert str(caught.value) == (
        "surge: 300 s hold 1.5 periods of 0.005 Hz, two are needed. Simulate longer, or discard less."
    )
    with pytest.raises(ModelError) as caught:
        harmonic_fit((TIME, TIME), 4.0, name="surge")
    assert str(caught.value) == "surge: fewer than four points per period of the harmonics; take a smaller output step."


def result(amplitude: float, mean: float = 1.0) -> Result:
    return Result(TIME, {"surge": mean + amplitude * np.sin(2 * np.pi * 0.1 * TIME)}, {"surge": "m"})


def test_statistics_over_seeds():
    row = over_seeds([result(1.0, 0.0), result(2.0, 4.0)])["surge"]
    assert row.mean == pytest.approx(2.0, abs=1e-3)
    assert row.max == pytest.approx((1.0 + 6.0) / 2, rel=1e-4)
    assert row.std == pytest.approx(np.sqrt((0.5 + 2.0) / 2), rel=1e-3)
    with pytest.raises(ModelError, match=r"^there are no results to take statistics of\.$"):
        over_seeds([])


def test_maxima_of_a_fault_over_normal_operation():
    assert normalized_maxima(result(5.0), result(2.0))["surge"] == pytest.approx(2.0, rel=1e-4)


def test_crossings():
    crossings = up_crossings(result(3.0)["surge"])
    assert crossings.count == 30 and crossings.mean_period == pytest.approx(10.0)
    assert up_crossings(result(3.0)["surge"], level=10.0).count == 0
