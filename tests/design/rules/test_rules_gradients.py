"""Each rule of expressions: the same values as of numbers and of arrays, and derivatives as by differences."""

from dataclasses import astuple, is_dataclass

import casadi as ca
import numpy as np
import pytest

from fowtlib.design import rules


def ring_of(x):
    return rules.Ring(*x[:5])


def flat(found):
    """All numbers of what a rule gives."""
    if is_dataclass(found):
        found = astuple(found)
    if isinstance(found, dict):
        found = tuple(found.values())
    if isinstance(found, tuple):
        return [number for item in found for number in flat(item)]
    return [found]


SHELL = [-60e6, -70e6, 7.0, 0.05, 2.5, -90e6, 20e6]


def shell(x):
    return rules.shell_buckling(*x[:5], hoop_stress=x[5], shear_stress=x[6])


def uplift(x):
    return rules.uplift_limit(*x)


def column(x):
    return rules.column_buckling(*x[:6], hoop_stress=x[6])


def tower(x):
    return rules.tower_buckling(*x)


RING = [0.5, 0.014, 0.25, 0.02, 2.5]


def moving(x):
    names = ("elastic_stiffness", "geometric_stiffness", "mass", "drag", "axial_mass")
    return rules.harmonic_extreme(*x[:4], **dict(zip(names, x[4:], strict=True)))


CASES = {
    "stresses of a tube": (lambda x: rules.cylinder_stress(*x), [7.0, 0.05, -1e8, -5e8, 1e7, 2e7]),
    "hoop stress": (lambda x: rules.hoop_stress(*x), [0.6e6, -50e6, 7.0, 0.05, 1.2, 0.03, 6.3]),
    "hoop stress, rings far apart": (lambda x: rules.hoop_stress(*x), [0.6e6, -50e6, 7.0, 0.05, 2.5, 0.03, 6.3]),
    "slender shell": (shell, SHELL),
    "shell of medium slenderness": (shell, [*SHELL[:4], 1.0, *SHELL[5:]]),
    "stocky shell": (shell, [*SHELL[:4], 0.2, *SHELL[5:]]),
    "shell in tension and pressure": (shell, [50e6, 20e6, *SHELL[2:]]),
    "long shell": (shell, [*SHELL[:4], 900.0, *SHELL[5:]]),
    "ring": (lambda x: rules.panel_ring(ring_of(x), *x[5:]), [*RING, 7.0, 0.05, -80e6, 0.6e6]),
    "ring in shear": (
        lambda x: rules.panel_ring(ring_of(x), *x[5:9], shear_stress=x[9], length=x[10]),
        [*RING, 7.0, 0.05, -80e6, 0.6e6, 15e6, 30.0],
    ),
    "rings close together": (
        lambda x: rules.panel_ring(ring_of(x), *x[5:]), [*RING[:4], 0.4, 7.0, 0.05, 80e6, 0.6e6],
    ),
    "ring that yields": (lambda x: rules.panel_ring(ring_of(x), *x[5:]), [*RING, 7.0, 0.05, -80e6, 4e6]),
    "slender column": (column, [-20e6, -30e6, 0.5, 0.02, 0.5, 60.0, -10e6]),
    "stocky column": (column, [-50e6, -30e6, 7.0, 0.05, 2.5, 100.0, -40e6]),
    "slenderness of a column": (lambda x: rules.column_slenderness(*x), [90.4, 6.0]),
    "tower": (tower, [-120e6, 4.0, 0.03, 10.5]),
    "thin tower": (tower, [-20e6, 4.0, 0.003, 4.0]),
    "short tower": (tower, [-20e6, 4.0, 0.03, 0.3]),
    "long tower": (tower, [-20e6, 4.0, 0.03, 40.0]),
    "squat tower": (tower, [-20e6, 0.5, 0.02, 1.0]),
    "fatigue": (lambda x: rules.fatigue_utilisation(*x), [0.4, 2.0]),
    "mooring": (lambda x: rules.mooring_strength(*x), [3.2e6, 1e6, 6.745e6]),
    "line that moves": (moving, [3.3, 1.1e6, 0.7, 0.44, 4.5e5, 1.2e5, 8e5, 1.2e6, 6e4]),
    "uplift": (uplift, [1497.2, 1230.2, 590.5e6, 309.3, 1433.0]),
    "limits": (lambda x: (rules.at_most(x[0], x[1]), rules.at_least(x[2], x[3])), [-0.2, 0.26, 27.0, 25.0]),
    "periods": (lambda x: (rules.heave_period(x[0], x[1], x[2]), *rules.period_ratio(x[3], x[4])),
                [1.7e7, 20.0, 12.7, 25.0, 34.4]),
    "taper": (lambda x: (rules.taper_utilisation(x[0], x[1], x[2]), rules.power_lost_by_tilt(x[3])),
              [21.4, 19.5, 5.36, 0.1]),
    "cost of chain": (lambda x: rules.mooring_cost(x[0], x[1], 3, x[2]), [125.0, 1497.0, 3.5]),
}  # fmt: skip


def differences(function, x):
    """Jacobian by central differences, Richardson-extrapolated."""
    columns = []
    for k, value in enumerate(x):
        step, estimates = 1e-4 * max(abs(value), 1e-3), []
        for h in (step, step / 2):
            up, down = (np.array(flat(function([*x[:k], value + s, *x[k + 1 :]])), dtype=float) for s in (h, -h))
            estimates.append((up - down) / (2 * h))
        columns.append((4 * estimates[1] - estimates[0]) / 3)
    return np.array(columns).T


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("kind", [ca.SX, ca.MX])
def test_derivatives_of_expressions(name, kind):
    function, at = CASES[name]
    numbers = np.array(flat(function(at)), dtype=float)
    x = kind.sym("x", len(at))
    out = ca.vertcat(*flat(function([x[k] for k in range(len(at))])))
    evaluate = ca.Function("rule", [x], [out, ca.densify(ca.jacobian(out, x))])
    values, jacobian = (np.array(item) for item in evaluate(at))
    assert np.ravel(values) == pytest.approx(numbers, rel=1e-11, abs=1e-11)
    assert np.all(np.isfinite(jacobian))
    expected = differences(function, at)
    scale = np.maximum(np.abs(numbers), 1e-9)[:, None] / np.abs(at)  # of a change by the whole of an argument
    assert np.max(np.abs(jacobian - expected) / (scale + np.abs(expected))) < 1e-7


@pytest.mark.parametrize("name", CASES)
def test_arrays_go_element_by_element(name):
    """Two places at once, as arrays and as columns of expressions."""
    function, at = CASES[name]
    one, two = flat(function(at)), flat(function([1.0001 * value for value in at]))
    both = flat(function([np.array([value, 1.0001 * value]) for value in at]))
    for first, second, pair in zip(one, two, both, strict=True):
        assert np.shape(pair) == (2,)
        assert pair == pytest.approx([first, second], rel=1e-12)
    for kind in (ca.SX, ca.MX):
        columns = kind.sym("x", 2, len(at))
        found = flat(function([columns[:, k] for k in range(len(at))]))
        evaluate = ca.Function("rule", [columns], found)
        values = evaluate(np.array([[value, 1.0001 * value] for value in at]).T)
        values = values if isinstance(values, tuple) else (values,)
        for value, pair in zip(values, both, strict=True):
            assert np.array(value).ravel() == pytest.approx(pair, rel=1e-11, abs=1e-11)


def tube_cost(x, stack):
    """Mass, cost and minutes of a tube of two sections with rings."""
    tube = rules.tube_sections(stack(x[:3]), stack(x[3:6]), stack(x[6:9]))
    found = rules.steel_cost(tube, rules.Ring(*x[9:13], stack(x[13:15])), density=x[15])
    return [found.mass, found.cost, *found.minutes.values()]


TUBE = [-80.0, -60.0, -45.0, 20.0, 15.0, 18.0, 0.08, 0.05, 0.06, 0.5, 0.014, 0.25, 0.02, 2.2, 2.6, 7850.0]


@pytest.mark.parametrize("kind", [ca.SX, ca.MX])
def test_derivatives_of_cost(kind):
    x = kind.sym("x", len(TUBE))
    out = ca.vertcat(*tube_cost([x[k] for k in range(len(TUBE))], lambda items: ca.vertcat(*items)))
    values, jacobian = (np.array(v) for v in ca.Function("cost", [x], [out, ca.densify(ca.jacobian(out, x))])(TUBE))
    numbers = np.array(tube_cost(TUBE, np.array))
    assert np.ravel(values) == pytest.approx(numbers, rel=1e-12)
    expected = differences(lambda y: tuple(tube_cost(y, np.array)), TUBE)
    scale = numbers[:, None] / np.abs(TUBE)
    assert np.max(np.abs(jacobian - expected) / (scale + np.abs(expected))) < 1e-7


def test_partial_derivatives_of_the_period_in_closed_form():
    """dT/dM = dT/dA = pi/(C q), dT/dC = -pi q/C, q = sqrt((M + A)/C)."""
    x = ca.SX.sym("x", 3)
    T = rules.rigid_period(x[0], x[1], x[2])
    M, A, C = 1.737e7, 2.92e6, 1.28e6
    q = np.sqrt((M + A) / C)
    jacobian = np.array(ca.Function("T", [x], [ca.jacobian(T, x)])([M, A, C]))
    assert np.ravel(jacobian) == pytest.approx([np.pi / (C * q), np.pi / (C * q), -np.pi * q / C], rel=1e-12)


def test_derivatives_are_finite_where_nothing_is_loaded():
    """At zero stress, on the tensile side, and at an impossible line no NaN reaches an optimiser."""
    for function, at in (
        (shell, [0.0, 0.0, 7.0, 0.05, 2.5, 0.0, 0.0]),
        (tower, [0.0, 4.0, 0.03, 10.5]),
        (column, [0.0, 0.0, 7.0, 0.05, 2.5, 100.0, 0.0]),
        (column, [-900e6, -1e6, 0.5, 0.02, 0.5, 60.0, -400e6]),
        (uplift, [1497.2, 1230.2, 1e6, 309.3, 1433.0]),
    ):
        x = ca.SX.sym("x", len(at))
        out = ca.vertcat(*flat(function([x[k] for k in range(len(at))])))
        values, jacobian = ca.Function("rule", [x], [out, ca.jacobian(out, x)])(at)
        assert np.all(np.isfinite(np.array(values))) and np.all(np.isfinite(np.array(jacobian)))
