"""The panel method against published numbers of simple hulls, and against itself with and without symmetry.

A. Hulme, The wave forces acting on a floating hemisphere undergoing forced periodic oscillations, J. Fluid Mech. 121
(1982) 443-463, tables 1 and 2: added mass over 2/3 pi rho a^3, damping over that and omega, in deep water.
"""

import itertools

import numpy as np
import pytest

pytest.importorskip("capytaine")

from fowtlib.components.hydro.hull_mesh import HullMesh, Symmetry
from fowtlib.components.hydro.panel import mesh_study
from fowtlib.components.hydro.panel_mesh import Column, Pontoon, members_mesh, round_factor
from fowtlib.components.hydro.panel_solver import PanelSolver

RADIUS, G = 10.0, 9.81
MASS = 2 * np.pi / 3 * RADIUS**3

# k a: added mass and damping of heave, of surge
HULME = {
    0.2: (0.7938, 0.2793, 0.5515, 0.0082),
    0.5: (0.5861, 0.3391, 0.6439, 0.0987),
    1.0: (0.4284, 0.2484, 0.5740, 0.3535),
    1.4: (0.3924, 0.1756, 0.4038, 0.4060),
}


def hemisphere(rings, sides):
    """Panels of equal angles, enlarged until the volume is that of the hemisphere."""
    theta = np.linspace(0, np.pi / 2, rings + 1)
    around = np.arange(sides) * 2 * np.pi / sides
    r, z = np.sin(theta) * round_factor(sides), -np.cos(theta)
    z[-1] = 0.0
    points = np.stack([r[:, None] * np.cos(around), r[:, None] * np.sin(around), z[:, None] + 0 * around], axis=2)
    ahead = np.roll(points, -1, axis=1)
    panels = np.stack([points[:-1], ahead[:-1], ahead[1:], points[1:]], axis=2).reshape(-1, 4, 3)
    return HullMesh(panels * (MASS / HullMesh(panels).volume) ** (1 / 3))


def coefficients(hull, ka):
    omega = np.sqrt(ka * G / RADIUS)
    flow = PanelSolver(hull, np.inf, G).solve(omega, [0.0])
    A, B = np.diag(flow.A) / MASS, np.diag(flow.B) / MASS / omega
    return np.array([A[2], B[2], A[0], B[0]]), flow.X[0], omega


@pytest.fixture(scope="module")
def hemispheres():
    """A mesh, and one with panels of half the size."""
    return hemisphere(8, 16), hemisphere(16, 32)


@pytest.mark.parametrize("ka", list(HULME))
def test_the_hemisphere_of_hulme(hemispheres, ka):
    """The error falls with the area of the panels, and is gone in the limit (0.3 %, or 0.0015 of the small)."""
    coarse, fine = (coefficients(hull, ka)[0] for hull in hemispheres)
    published = np.array(HULME[ka])
    assert (np.abs(fine - published) < 0.5 * np.abs(coarse - published) + 0.0005).all()
    np.testing.assert_allclose(fine, published, rtol=0.01, atol=0.0006)
    np.testing.assert_allclose(fine + (fine - coarse) / 3, published, rtol=3e-3, atol=0.0015)


def test_the_limits_of_the_hemisphere(hemispheres):
    """Heave: 0.8310 at zero, 1/2 at infinite frequency; surge: 1/2 and 0.2732."""
    limits = []
    for hull in hemispheres:
        solver = PanelSolver(hull, np.inf, G)
        flows = [solver.solve(omega, []) for omega in (0.0, np.inf)]
        limits.append(np.array([flow.A[mode, mode] / MASS for flow in flows for mode in (2, 0)]))
    coarse, fine = limits
    published = [0.8310, 0.5, 0.5, 0.2732]
    np.testing.assert_allclose(fine, published, rtol=0.016)
    np.testing.assert_allclose(fine + (fine - coarse) / 3, published, rtol=4e-3)


@pytest.mark.parametrize("ka", [0.5, 1.4])
def test_the_load_of_a_wave_follows_from_the_damping(hemispheres, ka):
    """Haskind and Newman, body of revolution in deep water: |X3|^2 = 2 rho g^3 B33 / omega^3; |X1|^2 twice B11."""
    (_, b3, _, b1), X, omega = coefficients(hemispheres[1], ka)
    assert abs(X[2]) ** 2 == pytest.approx(2 * G**3 * b3 * MASS / omega**2, rel=0.01)
    assert abs(X[0]) ** 2 == pytest.approx(4 * G**3 * b1 * MASS / omega**2, rel=0.01)


def test_the_lid_removes_the_irregular_frequency():
    """A cylinder, radius and draft 10 m: k a = 2.405, the first zero of J0, omega^2 = g k coth(k T): 1.5486 rad/s."""
    hull = members_mesh([Column(((-10.0, 20.0), (1.0, 20.0)))], [], 2.5)
    k = 2.404826 / RADIUS
    omega = np.sqrt(G * k / np.tanh(k * 10))
    assert omega == pytest.approx(1.5486, abs=1e-4)
    damping = {}
    for name, mesh in (("lid", hull), ("none", hull.without_lid())):
        solver = PanelSolver(mesh, np.inf, G)
        damping[name] = np.array([solver.solve(factor * omega, []).B[2, 2] for factor in (0.95, 1.0, 1.05)])
    before, at, after = damping["lid"]
    assert after < at < before
    assert at == pytest.approx(np.sqrt(before * after), rel=0.03)
    assert damping["none"][1] < 0  # a body that gives energy to the waves
    assert damping["none"][0] == pytest.approx(damping["lid"][0], rel=0.02)


def two_columns():
    columns = [Column(((-12.0, 8.0), (2.0, 8.0)), x=x) for x in (-14.0, 14.0)]
    return members_mesh(columns, [Pontoon((-14, 0, -9), (14, 0, -9), width=4, height=3)], 4.0)


def three_columns():
    angles = np.radians([0, 120, 240])
    columns = [Column(((-12.0, 8.0), (2.0, 8.0)), x=16 * np.cos(a), y=16 * np.sin(a)) for a in angles]
    ends = [(c.x, c.y, -9.0) for c in columns]
    return members_mesh(columns, [Pontoon(ends[i], ends[i - 1], width=3, height=3) for i in range(3)], 5.0)


def test_numbers_are_the_same_each_time():
    first, second = (PanelSolver(hemisphere(4, 12), 30.0, G)._solve(omega, np.zeros(1)) for omega in (0.8, 0.8))
    for name, values in first.items():
        np.testing.assert_array_equal(second[name], values)


@pytest.mark.parametrize(
    ("make", "fold"), [(two_columns, 4), (three_columns, 3), (lambda: hemisphere(5, 16), 16)],
    ids=["planes", "thirds", "round"],
)  # fmt: skip
def test_symmetry_changes_nothing_but_the_time(make, fold):
    hull, whole = make(), make()
    whole.__dict__["symmetry"] = Symmetry()
    assert hull.symmetry.fold == fold
    parts, full = PanelSolver(hull, 60.0, G), PanelSolver(whole, 60.0, G)
    assert parts.unknowns * fold == full.unknowns
    headings = np.radians([0, 35, 200])
    one, two = parts.solve(0.9, headings), full.solve(0.9, headings)
    for name in ("A", "B", "X"):
        a, b = getattr(one, name), getattr(two, name)
        np.testing.assert_allclose(a, b, atol=2e-5 * np.abs(b).max(), err_msg=name)


def test_in_deep_water_symmetry_changes_nothing_at_all():
    """At a depth the flow between two panels is interpolated, with errors of 1e-5 by where they lie."""
    hull, whole = hemisphere(6, 16), hemisphere(6, 16)
    whole.__dict__["symmetry"] = Symmetry()
    one, two = (PanelSolver(mesh, np.inf, G).solve(0.9, np.radians([0, 35, 200])) for mesh in (hull, whole))
    for name in ("A", "B", "X"):
        a, b = getattr(one, name), getattr(two, name)
        np.testing.assert_allclose(a, b, atol=1e-12 * np.abs(b).max(), err_msg=name)


def test_a_study_of_the_mesh_size():
    columns, done = [Column(((-10.0, 8.0), (4.0, 8.0)))], []
    rows = mesh_study(
        lambda size: members_mesh(columns, [], size), [1.0, 4.0, 2.0], omega=[0.5, 0.9], headings=[0.0],
        water_depth=100.0, progress=lambda k, n: done.append(k / n),
    )  # fmt: skip
    assert [row.size for row in rows] == [4.0, 2.0, 1.0]
    assert [len(row.hull.panels) for row in rows] == sorted(len(row.hull.panels) for row in rows)
    A = [row.database.A[1, 0, 0] for row in rows]
    assert A[2] < min(A[:2])  # with more sides of the polygon the added mass falls, here by 2.6 %
    assert A[:2] == pytest.approx([A[2]] * 2, rel=0.04)
    assert done[-1] == 1 and all(a < b for a, b in itertools.pairwise(done))
