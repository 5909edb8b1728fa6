"""The spar with velocity feedback as a design: its start, and slopes by gains and sizes."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.design.file import read_design

NAMES = ("range of tower_base_moment", "std of blade_pitch_rate")


@cache
def asked():
    return read_design("dtu10mw_p4").design


def one_state(variables, slopes):
    """Two results in one state, and nothing else."""
    kept = [item for item in asked().variables if item.name in variables]
    case = next(case for case in asked().cases if case.name == "wind 17")
    return replace(asked(), variables=kept, cases=[replace(case, weight=1.0)], functions=[], objective=NAMES[0],
                   constraints=[fw.Constraint(NAMES[1], upper=1.0)], slopes=slopes)  # fmt: skip


def test_the_printed_spar_keeps_what_no_controller_changes():
    """Equalities hold where the search begins, within the printed digits; ballast is that of the model at rest."""
    start = {item.name: np.array(item.start) for item in asked().space.placed}
    held = ("other walls", "straight", "joint diameter", "balance", "heave period", "hull taper")
    functions = {item.name: item for item in asked().functions}
    found = {name: np.ravel(np.asarray(functions[name].function(functions_of(name, functions, start)), dtype=float))
             for name in held}  # fmt: skip
    assert np.abs(found["other walls"]).max() < 1e-12 and np.abs(found["joint diameter"]).max() < 1e-12
    assert abs(found["straight"][0]) < 5e-4  # m: printed to the millimetre
    assert abs(found["balance"][0]) < 1e3  # kg of 13.3e6: the model fills to a heave of zero
    assert found["heave period"][0] == pytest.approx(25.09, abs=0.01)  # docs/p3_design.md
    assert np.abs(found["hull taper"]).max() < 1.0001  # cones of 10 deg


def functions_of(name, functions, start):
    """Values that a function needs, of variables and of other functions."""
    return {own: functions[own].function(functions_of(own, functions, start)) if own in functions else start[own]
            for own in functions[name].of}  # fmt: skip


def test_the_weights_of_six_states_are_those_of_the_factor_of_fatigue():
    """Damage of a range of 1e8 N m at 1 Hz over 20 years, times 2, by hand: D curve of m = 5 in air, 30 mm."""
    weights = sum(case.weight for case in asked().cases)
    fatigue = next(item for item in asked().functions if item.name == "tower fatigue")
    sizes = {"tower_diameters": np.full(11, 10.0), "tower_walls": np.full(11, 0.03)}
    found = np.ravel(fatigue.function({**dict.fromkeys(fatigue.of[:11], 1e8), **sizes}))
    stress = 1e2 / (np.pi * ((10.0 - 0.03) / 2) ** 2 * 0.03)  # MPa, of a thin tube
    cycles = 10**15.606 * (stress * (30 / 25) ** 0.2) ** -5.0
    assert found[0] == pytest.approx(2 * weights * 20 * 365.25 * 86400.0 / cycles, rel=1e-4)


def test_slopes_by_gains_and_walls_are_those_of_differences():
    names = ("proportional_gain", "filtered_gain", "filter_frequency", "velocity_gain")
    exact, near = (one_state(names, slopes) for slopes in ("adjoint", "differences"))
    x = exact.space.start
    one, other = (item.results.evaluate(x, jacobian=True) for item in (exact, near))
    for name in NAMES:
        assert one.values["wind 17", name] == pytest.approx(other.values["wind 17", name], rel=1e-7)
        slope, by = other.jacobian["wind 17", name], one.jacobian["wind 17", name]
        assert by == pytest.approx(slope, rel=1e-4, abs=1e-5 * np.abs(slope).max())
