"""An artificial stiffness: the mode that is asked for has the period that is asked for, and nothing else moves."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.frequency import response
from fowtlib.frequency.shifts import shifted
from fowtlib.frequency.studies import study_of
from fowtlib.language.errors import ModelError
from tests.frequency.conftest import LINEAR, MASS, STIFFNESS, oscillator


def test_a_shifted_oscillator_is_the_one_with_another_spring():
    # the period of 3.143 s, with the same rate of decay
    root = complex(-LINEAR / (2 * MASS), np.sqrt(STIFFNESS / MASS - (LINEAR / (2 * MASS)) ** 2))
    frequency = np.linspace(0.01, 2.0, 400)
    found = response(oscillator(), frequencies=frequency, shifted={1: "3 s"})
    (mode,) = found.linear.modes()
    assert mode.eigenvalue == pytest.approx(complex(root.real, 2 * np.pi / 3.0), rel=1e-9)
    spring = MASS * abs(mode.eigenvalue) ** 2
    omega = 2 * np.pi * frequency
    by_hand = 2.0 / np.abs(spring - MASS * omega**2 + 1j * LINEAR * omega) ** 2 * 2 * np.pi
    by_hand[omega >= 60] = 0.0
    assert found["x"].density == pytest.approx(by_hand, rel=1e-6)


@pytest.fixture(scope="module")
def spar():
    return fw.load("oc3_spar_rigid").compile()


def poles(found):
    return np.array(sorted(np.linalg.eigvals(found.linear.matrices["A"]), key=lambda root: (root.imag, root.real)))


@pytest.mark.filterwarnings("ignore:the frequencies")
def test_only_the_mode_that_is_asked_for_moves(spar):
    given = {"wind.mean_speed": 18.0, "sea.significant_wave_height": 1.0}
    asked = {"outputs": ["pitch", "surge", "thrust"], "parameters": given, "frequencies": np.geomspace(0.003, 0.4, 300)}
    before = response(spar, tolerance=1e-9, **asked)
    pitch = next(mode for mode in before.linear.modes() if 25 < mode.period < 40 and mode.damping_ratio < 0.3)
    after = response(spar, tolerance=1e-9, shifted={f"{pitch.period:.3f} s": f"{0.95 * pitch.period} s"}, **asked)
    old, new = poles(before), poles(after)
    moved = complex(pitch.eigenvalue.real, pitch.eigenvalue.imag / 0.95)
    assert np.abs(new - moved).min() < 2e-3 * abs(moved)  # as near as its drag is the same
    for root in old:
        if min(abs(root - pitch.eigenvalue), abs(root - np.conj(pitch.eigenvalue))) > 1e-9:
            assert np.abs(new - root).min() < 2e-3 * max(abs(root), 0.05)


def test_with_the_same_drag_no_other_pole_moves_at_all(spar):
    acceleration, velocity = "der(der(platform.motion.surge))", "platform.motion.velocity"
    study = study_of(spar)
    with study.tree({"wind.mean_speed": 18.0}) as root:
        excited = study.excited(study.mean({"wind.mean_speed": 18.0}, root), [acceleration, velocity])
    gains = [0.3 * np.eye(place.stop - place.start) for _, place in excited.laws]
    before = excited.with_gains(gains)
    mode = next(m for m in before.modes() if 25 < m.period < 40 and m.damping_ratio < 0.3)
    after = shifted(excited, gains, {f"{mode.period:.6g} s": 0.9 * mode.period}).with_gains(gains)
    roots = np.linalg.eigvals(after.matrices["A"])
    assert np.abs(roots - complex(mode.eigenvalue.real, mode.eigenvalue.imag / 0.9)).min() < 1e-9
    for root in np.linalg.eigvals(before.matrices["A"]):
        if abs(root - mode.eigenvalue) > 1e-6 and abs(root - np.conj(mode.eigenvalue)) > 1e-6:
            assert np.abs(roots - root).min() < 1e-6 * max(abs(root), 1.0)
    # the artificial force is one of the equations of motion: outputs with accelerations know of it
    omega = np.linspace(0.1, 1.0, 20)
    drive = np.ones((omega.size, len(after.inputs), 1))
    by_time = after.driven(omega, drive)
    assert by_time[:, 0] == pytest.approx(1j * omega[:, None] * by_time[:, 1], rel=1e-7)


def test_mistakes_of_shifts_are_told():
    for shifts, words in (
        ({2: "3 s"}, "there is no mode 2; there are 1 of 3.143 s"),
        ({"9 s": "3 s"}, "no mode near a period of 9 s; there are 1 of 3.143 s"),
        ({"bending": "3 s"}, "'bending' takes part most in no oscillating mode"),
        ({1: "3 m"}, "the new period of 1: '3 m' is not a period"),
        ({1: -2.0}, "is not a period"),
    ):
        with pytest.raises(ModelError, match=words):
            response(oscillator(), outputs=["x"], shifted=shifts)


def test_a_filter_is_no_motion(spar):
    given = {"wind.mean_speed": 18.0, "sea.significant_wave_height": 1.0}
    with pytest.raises(ModelError, match="431.5 s, is no motion .0.041 % of it is.: a stiffness does not move it"):
        response(spar, outputs=["pitch"], parameters=given, shifted={1: "430 s"})
