"""The catenary equations against tables, an independent integration, a lumped chain, and their own derivatives."""

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import quad

from fowtlib.components.mooring import catenary
from fowtlib.components.mooring.catenary import Line, fairlead_tension, span
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError
from fowtlib.solving.newton import newton

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
        catenary.stiffness(H, V * (1 + 1e-9), OC3), rel=5e-5
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
    assert np.linalg.eigvalsh((stiffness + stiffness.T) / 2).min() > 0
    flexibility = np.column_stack(
        [
            (np.array(span(H + h, V + v, OC3)) - span(H - h, V - v, OC3)) / (2 * (h + v))
            for h, v in ((1e-4 * H, 0.0), (0.0, 1e-5 * V))
        ]
    )
    assert flexibility[0, 1] == pytest.approx(flexibility[1, 0], rel=1e-4)


@pytest.mark.parametrize("kind", ["on the seabed", "above the seabed", "in mid-water", "floating", "without weight"])
def test_every_stiffness_without_friction_is_symmetric(kind):
    for x, z, line in lines(kind, 40, seed=2):
        free = Line(line.length, line.weight, line.axial_stiffness, clearance=line.clearance)
        stiffness = catenary.stiffness(*fairlead_tension(x, z, free), free)
        least = 1e-9 * np.sqrt(stiffness[0, 0] * stiffness[1, 1])
        assert stiffness[0, 1] == pytest.approx(stiffness[1, 0], rel=1e-6, abs=least), (x, z, free)


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
    assert 1e-5 * OC3.weight * OC3.length > H > 0


def unknowns(line, x, z, start, iterations=None):
    """The residual of CatenaryLine in its unknowns, solved by the plain or (without a limit) the damped Newton."""
    p, q = ca.SX.sym("p"), ca.SX.sym("q")
    force = float(catenary.scales(line)[0])
    lateral = catenary.lateral_stiffness(p, line, m)
    distance = np.hypot(x, 1e-5 * line.length)
    H, V, spanned = lateral * distance, q * force, ca.sqrt(distance**2 + (catenary.scales(line)[1] / lateral) ** 2)
    now = catenary.state(lateral * spanned, V, line, m)
    drawn = now.grounded + lateral * spanned * now.flexibility
    residual = ca.vertcat(drawn - spanned, now.height - z) / line.length
    both = ca.vertcat(p, q)
    function = ca.Function("residual", [both], [residual, ca.jacobian(residual, both), ca.vertcat(H, V)])
    guess = np.array(start)
    if iterations is None:
        solution = newton(
            lambda values: np.array(function(values)[0]).ravel(), lambda values: np.array(function(values)[1]), guess
        )
        guess = solution.values
    for _ in range(iterations or 0):
        r, slope, _ = (np.array(value) for value in function(guess))
        guess = guess - np.linalg.solve(slope, r.ravel())
    r, _, forces = function(guess)
    return np.abs(np.array(r)).max(), *np.array(forces).ravel()


@pytest.mark.parametrize("z", [125.0, 200.0, 250.0, 300.0, 375.0])
def test_newton_needs_no_good_start(z):
    """Plain Newton on the unknowns of CatenaryLine converges from its fixed start at every distance."""
    for distance in np.arange(300.0, 1000.0, 20.0):
        residual, H, V = unknowns(OC3, distance, z, [1.0, 0.6], iterations=14)
        assert residual < 1e-10
        H_exact, V_exact = fairlead_tension(distance, z, OC3)
        assert (pytest.approx(H_exact, rel=1e-6, abs=1e-3), pytest.approx(V_exact, rel=1e-6)) == (H, V)


def lines(kind, count, seed=1):
    """Lines of every length, weight, stiffness and friction, slack to stretched by 5 %, with their fairleads."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        length, stiffness = 10 ** rng.uniform(1.3, 3.5), 10 ** rng.uniform(6.5, 10)
        weight = stiffness * 10 ** rng.uniform(-5, -1.7) / length
        share = rng.uniform(0.05, 1.0) if rng.random() < 0.6 else 1 + 10 ** rng.uniform(-5, -1.3)
        angle, friction, clearance = rng.uniform(0.02, np.pi / 2), 0.0, 10 * length
        if kind == "on the seabed":
            friction, clearance = rng.choice([0.0, 0.2, 1.0, 3.0]), 0.0
        elif kind == "above the seabed":
            clearance = length * 10 ** rng.uniform(-3, 0)
            angle = np.arcsin(np.clip(rng.uniform(-min(clearance / length / share, 1.0), 1.0), -1, 1))
        else:
            angle = rng.uniform(-1, 1) * np.pi / 2
            light = 10 ** rng.uniform(-9, -3) * rng.choice([-1, 1])
            weight *= {"in mid-water": 1, "floating": -1, "without weight": light}[kind]
        if rng.random() < 0.1:
            angle = np.pi / 2
        yield (share * length * np.cos(angle), share * length * np.sin(angle),
               Line(length, weight, stiffness, friction, clearance))  # fmt: skip


@pytest.mark.parametrize("kind", ["on the seabed", "above the seabed", "in mid-water", "floating", "without weight"])
def test_every_line_is_solved_from_the_fixed_start(kind):
    """By the damped Newton of the start of a simulation, and to what two nested bracketed searches find."""
    for x, z, line in lines(kind, 60):
        force = float(catenary.scales(line)[0])
        residual, H, V = unknowns(line, x, z, [1.0, 0.6 * line.weight * line.length / force])
        assert residual < 1e-8, (x, z, line)
        exact = np.array(fairlead_tension(float(np.hypot(x, 1e-5 * line.length)), z, line))
        assert np.array([H, V]) == pytest.approx(exact, rel=1e-6, abs=1e-6 * max(force, *abs(exact)))
        assert catenary.profile(H, V, line, 30)["x"][-1] == pytest.approx(x, abs=1e-5 * line.length)
        assert catenary.profile(H, V, line, 30)["z"][-1] == pytest.approx(z, abs=1e-6 * line.length)


# x, z, length, weight in water, EA, friction, clearance: H and V at the fairlead, upward pull on the anchor [kN],
# length on the seabed [m] from MoorPy 1.3.0, moorpy.Catenary.catenary (Hall et al., NREL; CB < 0: seabed below).
MOORPY = [
    ((848.67, 250, 902.2, 698.09, 384.243e6, 1.0, 0), (737.372, 535.866, 0, 134.58)),
    ((0.1, 200, 199.4, 1000, 1.5e9, 0, 0), (2.2565, 4613.43, 4414.03, 0)),
    ((0.5, 200, 199.4, 1000, 1.5e9, 0, 0), (11.2937, 4617.93, 4418.53, 0)),
    ((20, 200, 199.4, 1000, 1.5e9, 0, 0), (1195.77, 12057.6, 11858.2, 0)),
    ((1000, 500, 1100, -217.7, 50e6, 0, 0), (830.826, 297.924, 537.394, 0)),
    ((1000, 500, 1100, -0.023, 50e6, 0, 0), (733.186, 366.580, 366.606, 0)),
    ((400, 100, 600, -217.7, 50e6, 0, 1000), (27.3014, -53.504, 77.116, 0)),
    ((500, 16, 520, 1000, 7.5e8, 0, 290), (511.428, 277.646, -242.354, 0)),
    ((500, 0, 520, 1000, 7.5e8, 0, 290), (508.396, 260.0, -260.0, 0)),
    ((500, -16, 520, 1000, 7.5e8, 0, 290), (511.428, 242.354, -277.646, 0)),
    ((500, 16, 620, 1000, 7.5e8, 0, 290), (215.364, 319.737, -300.263, 0)),
    ((500, 16, 620, 1000, 7.5e8, 0, 100), (47.4529, 156.396, -139.595, 324.01)),
    ((848.67, 245, 902.2, 698.09, 384.243e6, 0, 5), (741.235, 537.117, -71.9489, 29.725)),
    ((800, 240, 902.2, 698.09, 384.243e6, 0, 10), (183.192, 307.104, -51.0405, 389.17)),
    ((796.732, 186, 835.35, 1065.2613, 753.6e6, 0, 0), (907.499, 631.107, 0, 242.91)),
]


@pytest.mark.parametrize(("place", "expected"), MOORPY)
def test_against_moorpy(place, expected):
    line = Line(*place[2:])
    H, V = fairlead_tension(*place[:2], line)
    now = catenary.state(H, V, line)
    assert [H, V, float(now.anchor)] == pytest.approx(np.array(expected[:3]) * 1e3, rel=1e-4)
    assert float(now.grounded) == pytest.approx(expected[3], abs=0.02)


# Elastic catenaries without friction that others solved: x, z, line, and what is known of H, V, tensions at the ends
# [kN]. Chains in three depths of the MoorDyn tests (FloatingArrayDesign; OrcaFlex has 991.6, 2065.4 and 5232.6 kN at
# the fairlead), the flexible jumper of Lowe and Langley (2006) without its bending, a chain of MoorDyn, the OC4 line.
CHAIN = catenary.weight_in_water(390.0, 0.252)
JUMPER = catenary.weight_in_water(165.0, 0.396, 9.807, 1000.0)
PUBLISHED = [
    ((400, 50, Line(410, CHAIN, 1.674e9)), {"tension": 1001.7, "anchor": 835.6}),
    ((700, 200, Line(760, CHAIN, 1.674e9)), {"tension": 2070.1, "anchor": 1406.2}),
    ((1500, 600, Line(1700, CHAIN, 1.674e9)), {"tension": 5236.2, "anchor": 3247.3}),
    ((100, 50, Line(170, JUMPER, 5e8, clearance=45)), {"H": 11.47, "V": 45.72, "V_anchor": -24.03}),
    ((1600, 600, Line(1800, catenary.weight_in_water(286.56, 0.216), 1.22976e9)),
     {"H": 2380.9, "V": 3015.7, "tension": 3842.3}),
    ((796.732, 186, Line(835.35, catenary.weight_in_water(113.35, 0.0766), 753.6e6)),
     {"H": 907.8, "V": 631.3, "tension": 1105.7, "grounded": 0.2429}),
]  # fmt: skip


@pytest.mark.parametrize(("place", "expected"), PUBLISHED)
def test_published_lines(place, expected):
    H, V = fairlead_tension(*place)
    now = catenary.state(H, V, place[2])
    values = {
        "H": H, "V": V, "tension": np.hypot(H, V), "anchor": np.hypot(H, now.anchor), "V_anchor": float(now.anchor),
        "grounded": float(now.grounded),
    }  # fmt: skip
    assert {name: values[name] / 1e3 for name in expected} == pytest.approx(expected, rel=1e-3)


def test_a_vertical_line_has_the_stiffness_of_a_string():
    """(T - w L / 2) / length, through zero offset without a corner; along it, E A / L."""
    line = Line(199.4, 1000, 1.5e9)
    V = fairlead_tension(0.0, 200.0, line)[1]
    string = (V - line.weight * line.length / 2) / 200.0
    for x in (1e-6, 1e-3, 0.1):
        H, _ = fairlead_tension(x, 200.0, line)
        assert pytest.approx(string, rel=3e-4) == H / x
    assert catenary.stiffness(0.0, V, line) == pytest.approx(
        np.diag([string, line.axial_stiffness / 199.4]), rel=3e-4, abs=1e-2
    )


def test_a_line_without_weight_is_straight():
    line = Line(1110.0, 0.0, 50e6)
    H, V = fairlead_tension(1000.0, 500.0, line)
    distance = np.hypot(1000, 500)
    assert np.hypot(H, V) == pytest.approx(50e6 * (distance / 1110 - 1), rel=1e-6)
    assert pytest.approx(2 * V) == H
    shape = catenary.profile(H, V, line, 11)
    assert shape["z"] == pytest.approx(shape["x"] / 2)


@pytest.mark.parametrize("x", [600.0, 640.0, 650.0, 653.0, 655.0, 660.0, 700.0])
@pytest.mark.parametrize("friction", [0.2, 1.0, 3.0])
def test_almost_slack_with_friction(x, friction):
    """What friction takes up never exceeds the pull; the line grows slack without a jump, and its shape ends right."""
    line = Line(OC3.length, OC3.weight, OC3.axial_stiffness, friction)
    H, V = fairlead_tension(x, 250.0, line)
    residual, H_newton, V_newton = unknowns(line, x, 250.0, [1.0, 0.6])
    assert residual < 1e-9
    assert (pytest.approx(H, rel=1e-5, abs=1e-2), pytest.approx(V, rel=1e-6)) == (H_newton, V_newton)
    free = fairlead_tension(x, 250.0, OC3)  # what is not stretched on the seabed is a millimetre
    assert pytest.approx(free[0], rel=1e-2, abs=2.0) == H
    shape = catenary.profile(H, V, line, 50)
    assert [shape["x"][-1], shape["z"][-1]] == pytest.approx([x, 250.0], abs=1e-6)
    assert 0 <= shape["tension"][0] <= H


@pytest.mark.parametrize(("x", "friction"), [(600.0, 0.0), (800.0, 0.0), (800.0, 1.0), (860.0, 0.5), (900.0, 0.0)])
def test_profile_ends_at_the_fairlead(x, friction):
    line = Line(OC3.length, OC3.weight, OC3.axial_stiffness, friction)
    H, V = fairlead_tension(x, 250.0, line)
    shape = catenary.profile(H, V, line, 50)
    assert [shape["x"][-1], shape["z"][-1]] == pytest.approx([x, 250.0], abs=1e-6)
    assert shape["z"][0] == 0 and np.all(np.diff(shape["x"]) > 0)
    assert shape["tension"][-1] == pytest.approx(np.hypot(H, V))
    points = catenary.profile_between((0, -10, -320), (0, -10 - x, -70), H, V, line, 50)
    assert points[-1] == pytest.approx([0, -10 - x, -70], abs=1e-6)


def test_place_without_a_catenary():
    with pytest.raises(ModelError, match=r"the fairlead is at x = 800\.0 m, z = -5\.0 m from the anchor, and"):
        fairlead_tension(800.0, -5.0, OC3)
    with pytest.raises(ModelError, match=r"the seabed is 4\.0 m below the anchor"):
        fairlead_tension(800.0, -5.0, Line(902.2, 698.0, 384e6, clearance=4.0))
