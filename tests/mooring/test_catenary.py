"""The catenary equations against tables, an independent integration, a lumped chain, and their own derivatives."""

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import quad

from fowtlib.components.mooring import catenary
from fowtlib.components.mooring.catenary import Line, fairlead_tension, span
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError

OC3 = Line(902.2, catenary.weight_in_water(77.7066, 0.09), 384.243e6)
HEAVY = Line(902.2, catenary.weight_in_water(200.0, 0.09), 384.243e6)

# Distance, H, V, tension [kN], seabed length [m] of an OC3-Hywind line with the fairlead 250 m above the anchor,
# solved separately from Jonkman's two-case equations and the line data of NREL/TP-500-47535, table 5-1.
TABLE = [
    (800.0, 179.1, 304.8, 353.5, 465.6),
    (820.0, 300.4, 367.6, 474.8, 375.6),
    (840.0, 546.9, 470.0, 721.1, 228.9),
    (848.67, 736.9, 535.7, 911.1, 134.8),
    (855.0, 933.9, 596.2, 1107.9, 48.2),
    (865.0, 1509.0, 756.8, 1688.1, 0.0),
    (880.0, 5353.0, 1837.0, 5660.0, 0.0),
]


@pytest.mark.parametrize(("x", "horizontal", "vertical", "tension", "seabed"), TABLE)
def test_oc3_line(x, horizontal, vertical, tension, seabed):
    H, V = fairlead_tension(x, 250.0, OC3)
    assert pytest.approx(horizontal * 1e3, rel=5e-4) == H
    assert pytest.approx(vertical * 1e3, rel=5e-4) == V
    assert np.hypot(H, V) == pytest.approx(tension * 1e3, rel=5e-4)
    assert max(OC3.length - V / OC3.weight, 0) == pytest.approx(seabed, abs=0.2)


def test_weight_in_water_and_pretension():
    assert pytest.approx(698.09, abs=0.01) == OC3.weight
    assert 3 * fairlead_tension(848.67, 250.0, OC3)[1] == pytest.approx(1.607e6, rel=1e-3)  # NREL/TP-500-47535


def test_heavy_line():
    H, V = fairlead_tension(848.67, 250.0, HEAVY)
    assert (pytest.approx(1803.8e3, rel=1e-3), pytest.approx(1387.7e3, rel=1e-3)) == (H, V)
    assert HEAVY.length - V / HEAVY.weight == pytest.approx(171.1, abs=0.2)


@pytest.mark.parametrize(("mass", "lift_off"), [(77.7066, 858.04), (170, 861.6), (190, 862.4), (200, 862.8)])
def test_lift_off(mass, lift_off):
    line = Line(902.2, catenary.weight_in_water(mass, 0.09), 384.243e6)
    on_seabed = [fairlead_tension(lift_off + step, 250.0, line)[1] < line.weight * line.length for step in (-0.1, 0.1)]
    assert on_seabed == [True, False]


@pytest.mark.parametrize(
    ("H", "V", "friction"),
    [(7e5, 5.4e5, 0), (3e5, 3.7e5, 0.8), (5e4, 2.2e5, 1.5), (1.5e6, 7.6e5, 0.4), (5e6, 1.9e6, 0), (1e3, 1.8e5, 0)],
)
def test_span_is_the_integral_of_the_line(H, V, friction):
    """Each element points along its tension and is stretched by it; on the seabed friction takes the tension up."""
    line = Line(OC3.length, OC3.weight, OC3.axial_stiffness, friction)
    grounded = max(line.length - V / line.weight, 0.0)

    def element(s):
        if s < grounded:
            return np.array([1 + max(H - friction * line.weight * (grounded - s), 0) / line.axial_stiffness, 0.0])
        vertical = V - line.weight * (line.length - s)
        tension = np.hypot(H, vertical)
        return np.array([H, vertical]) * (1 / tension + 1 / line.axial_stiffness)

    breaks = [grounded, max(grounded - H / (line.weight * max(friction, 1e-9)), 0.0)]
    expected = [
        quad(lambda s, i=i: element(s)[i], 0, line.length, points=breaks, epsabs=1e-9, epsrel=1e-12, limit=400)[0]
        for i in (0, 1)
    ]
    assert span(H, V, line) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("x", [790.0, 848.67, 866.0])
def test_lumped_chain(x):
    """The least potential energy of 100 elastic links with weights at their ends, on or above a hard seabed."""
    n = 100
    link, weight = OC3.length / n, OC3.weight * OC3.length / n
    inner = ca.SX.sym("inner", 2, n - 1)
    step = ca.diff(ca.horzcat(ca.DM([0, 0]), inner, ca.DM([x, 250])), 1, 1)
    sizes = ca.sqrt(ca.sum1(step**2))
    energy = OC3.axial_stiffness / (2 * link) * ca.sumsqr(sizes - link) + weight * ca.sum2(inner[1, :])
    solver = ca.nlpsol(
        "chain", "ipopt", {"x": ca.vec(inner), "f": energy / 1e8}, {"print_time": 0, "ipopt.print_level": 0}
    )
    H, V = fairlead_tension(x, 250.0, OC3)
    shape = catenary.profile(H, V, OC3, n + 1)
    start = np.column_stack([shape["x"], shape["z"] + 3.0])[1:-1].ravel()
    last = np.array([x, 250.0]) - np.array(solver(x0=start, lbx=np.tile([-ca.inf, 0.0], n - 1))["x"]).ravel()[-2:]
    assert solver.stats()["success"]
    pull = OC3.axial_stiffness * (np.hypot(*last) / link - 1)
    horizontal, vertical = pull * last / np.hypot(*last)
    assert [horizontal, vertical + weight / 2] == pytest.approx([H, V], rel=5e-3)


def test_derivatives_are_continuous_at_lift_off():
    V, H = OC3.weight * OC3.length, 1.0e6
    step = 1e-3 * V
    before, at, after = (np.array(span(H, value, OC3)) for value in (V - step, V, V + step))
    assert (at - before) / (after - at) == pytest.approx([1, 1], rel=5e-3)
    assert catenary.stiffness(H, V * (1 - 1e-9), OC3) == pytest.approx(
        catenary.stiffness(H, V * (1 + 1e-9), OC3), rel=1e-6
    )


@pytest.mark.parametrize("x", [500.0, 660.0, 800.0, 850.0, 870.0, 900.0])
def test_stiffness_is_the_derivative_of_a_potential(x):
    H, V = fairlead_tension(x, 250.0, OC3)
    stiffness, step = catenary.stiffness(H, V, OC3), 1e-3
    difference = np.column_stack(
        [
            (np.array(fairlead_tension(x + dx, 250 + dz, OC3)) - fairlead_tension(x - dx, 250 - dz, OC3)) / (2 * step)
            for dx, dz in ((step, 0.0), (0.0, step))
        ]
    )
    assert stiffness == pytest.approx(difference, rel=1e-4, abs=1e-3)
    assert stiffness[0, 1] == pytest.approx(stiffness[1, 0], rel=1e-9)
    assert np.linalg.eigvalsh(stiffness).min() > 0


def test_work_round_a_closed_path_is_zero():
    corners = np.array([[830.0, 240.0], [870.0, 240.0], [870.0, 262.0], [830.0, 262.0], [830.0, 240.0]])
    nodes, weights = np.polynomial.legendre.leggauss(12)
    sides = []
    for start, end in zip(corners[:-1], corners[1:], strict=True):
        points = start + (end - start) * (nodes[:, None] + 1) / 2
        forces = np.array([fairlead_tension(*point, OC3) for point in points])
        sides.append(weights @ (forces @ (end - start)) / 2)
    assert abs(sum(sides)) < 1e-4 * max(np.abs(sides))


def test_slack_line_hangs_vertically():
    H, V = fairlead_tension(500.0, 250.0, OC3)
    assert pytest.approx(OC3.weight * 250.0, rel=1e-3) == V
    assert catenary.SLACKNESS * OC3.weight * OC3.length / 100 > H > 0


@pytest.mark.parametrize("z", [125.0, 200.0, 250.0, 300.0, 375.0])
def test_newton_needs_no_good_start(z):
    """Plain Newton on the unknowns of CatenaryLine converges from its fixed start at every distance."""
    p, q, x = ca.SX.sym("p"), ca.SX.sym("q"), ca.SX.sym("x")
    weight = OC3.weight * OC3.length
    H = catenary.tension_from(p, OC3, m)
    reached = ca.vertcat(*span(H, q * weight, OC3, m)) - ca.vertcat(catenary.slack_length(H, OC3), 0)
    residual = (reached - ca.vertcat(x, z)) / OC3.length
    unknowns = ca.vertcat(p, q)
    step = ca.Function("step", [unknowns, x], [ca.solve(ca.jacobian(residual, unknowns), residual), residual])
    for distance in np.arange(300.0, 1000.0, 20.0):
        guess = ca.DM([1.0, 0.6])
        for _ in range(12):
            guess = guess - step(guess, distance)[0]
        assert np.abs(np.array(step(guess, distance)[1])).max() < 1e-10
        H_exact, V_exact = fairlead_tension(distance, z, OC3)
        assert float(catenary.tension_from(float(guess[0]), OC3)) == pytest.approx(H_exact, rel=1e-6, abs=1e-3)
        assert float(guess[1]) * weight == pytest.approx(V_exact, rel=1e-6)


@pytest.mark.parametrize(("x", "friction"), [(600.0, 0.0), (800.0, 0.0), (800.0, 1.0), (860.0, 0.5), (900.0, 0.0)])
def test_profile_ends_at_the_fairlead(x, friction):
    line = Line(OC3.length, OC3.weight, OC3.axial_stiffness, friction)
    H, V = fairlead_tension(x, 250.0, line)
    shape = catenary.profile(H, V, line, 50)
    assert [shape["x"][-1], shape["z"][-1]] == pytest.approx([x, 250.0], abs=2e-3)
    assert shape["z"][0] == 0 and np.all(np.diff(shape["x"]) > 0)
    assert shape["tension"][-1] == pytest.approx(np.hypot(H, V))
    points = catenary.profile_between((0, -10, -320), (0, -10 - x, -70), H, V, line, 50)
    assert points[-1] == pytest.approx([0, -10 - x, -70], abs=2e-3)


def test_place_without_a_catenary():
    with pytest.raises(ModelError, match=r"the fairlead is at x = 800\.0 m, z = -5\.0 m from the anchor"):
        fairlead_tension(800.0, -5.0, OC3)
