"""Rules of whole hulls and towers are the single rules at each section, of numbers and of expressions."""

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.maps import quantities_at
from fowtlib.design import rules

Z = np.array([-80.0, -60.0, -35.0, -12.0, 0.0, 10.0])
D = np.array([20.0, 15.0, 20.0, 13.0, 12.7, 12.7])
T = np.array([84.0, 56.0, 68.0, 85.0, 74.0, 61.0]) * 1e-3
M = np.array([1e8, 4.7e8, 8.6e8, 8.0e8, 7.0e8])
N = np.array([8e7, 6e7, -9e6, -1.8e7])
RINGS = (0.5, 0.016, 0.3, 0.02, 2.5)


def test_a_section_of_a_hull_is_checked_at_its_worse_end():
    found = rules.hull_buckling(Z, D, T, M, N, *RINGS)
    k, sea = 1, 1025 * 9.80665
    r, wall = (D[k : k + 2].mean() - T[k : k + 2].mean()) / 2, T[k : k + 2].mean()
    axial = min(N[0] - sea * 60 * np.pi / 4 * 15.0**2, N[1] - sea * 35 * np.pi / 4 * 20.0**2)
    x, m, _ = rules.cylinder_stress(r, wall, axial, -1.35 * 4.7e8)
    ring = rules.Ring(*RINGS)
    hoop = rules.hoop_stress(sea * 60, x + m, r, wall, 2.5, ring.area, ring.flange_radius(r, wall))
    shell = rules.shell_buckling(x, m, r, wall, 2.5, hoop_stress=hoop.between, least_factor=1.10)
    frame = rules.panel_ring(ring, r, wall, x + m, sea * 60)
    assert found.shell[k] == pytest.approx(float(shell.utilisation), rel=1e-12)
    assert found.inertia[k] == pytest.approx(float(frame.inertia), rel=1e-12)
    assert found.column[k] == pytest.approx(float(rules.column_slenderness(90.0, r)), rel=1e-12)
    # the keel bears what the second node does, and the top what is known last
    assert len(found.shell) == 5 and np.all(np.isfinite(found.shell))


def test_by_ends_a_section_is_checked_with_the_sizes_and_loads_of_each():
    found, sea = rules.hull_buckling(Z, D, T, M, N, *RINGS, ends=True), 1025 * 9.80665
    ring, r = rules.Ring(*RINGS), (D - T) / 2
    for k, row in ((2, 2), (2, 5 + 1)):  # the node at -35 m: lower end of the third section, upper end of the second
        x, m, _ = rules.cylinder_stress(r[k], T[k], N[k - 1] - sea * 35 * np.pi / 4 * D[k] ** 2, -1.35 * M[k - 1])
        hoop = rules.hoop_stress(sea * 35, x + m, r[k], T[k], 2.5, ring.area, ring.flange_radius(r[k], T[k]))
        shell = rules.shell_buckling(x, m, r[k], T[k], 2.5, hoop_stress=hoop.between, least_factor=1.10)
        frame = rules.panel_ring(ring, r[k], T[k], x + m, sea * 35)
        assert found.shell[row] == pytest.approx(float(shell.utilisation), rel=1e-12)
        assert found.stress[row] == pytest.approx(float(frame.stress), rel=1e-12)
    mean = rules.hull_buckling(Z, D, T, M, N, *RINGS)
    assert found.web == pytest.approx(mean.web) and found.column == pytest.approx(mean.column)
    teeth = T * [1.3, 0.7, 1.3, 0.7, 1.3, 0.7]  # the mean hides thin ends
    thin = rules.hull_buckling(Z, D, teeth, M, N, *RINGS, ends=True)
    assert max(thin.shell) > 1.2 * max(rules.hull_buckling(Z, D, teeth, M, N, *RINGS).shell)


def test_control_points_of_rings_lie_between_their_ends():
    even = rules.hull_buckling(Z, D, T, M, N, *RINGS)
    same = rules.hull_buckling(Z, D, T, M, N, [0.5] * 4, *RINGS[1:4], [2.5] * 5)
    assert same.web == pytest.approx(even.web, rel=1e-12) and same.shell == pytest.approx(even.shell, rel=1e-12)
    higher = rules.hull_buckling(Z, D, T, M, N, [0.5, 0.5, 0.7, 0.7], *RINGS[1:])
    assert higher.web[0] == pytest.approx(even.web[0]) and higher.web[-1] == pytest.approx(1.4 * even.web[-1])


def test_costs_and_the_share_of_rings():
    steel = rules.steel_cost(rules.tube_sections(Z, D, T), rules.Ring(*RINGS))
    assert rules.hull_cost(Z, D, T, *RINGS).cost == pytest.approx(float(steel.cost), rel=1e-12)
    sections = rules.tube_sections(Z, D, T)
    r = (sections.diameter - sections.thickness) / 2
    ring = rules.Ring(*RINGS)
    rings = 7850 * 2 * np.pi * ring.centroid_radius(r, sections.thickness) * ring.area * sections.length / 2.5
    assert rules.ring_fraction(Z, D, T, *RINGS) == pytest.approx(rings.sum() / (7850 * sections.volume.sum()), rel=1e-9)


def test_a_tower_bears_what_stands_above_each_section():
    z, d, t, m = [10.0, 20.0, 40.0], [12.0, 11.0, 9.0], [0.05, 0.04, 0.03], [6e8, 5e8, 1e8]
    found = rules.tower_use(z, d, t, m, 7e5)
    steel = 8500 * np.pi * 20 / 2 * ((11 - 0.04) * 0.04 + (9 - 0.03) * 0.03)
    r, wall = (10 - 0.035) / 2, 0.035
    stress = 1.35 * (-9.80665 * (7e5 + steel) / (2 * np.pi * r * wall) - 5e8 / (np.pi * r**2 * wall))
    assert found[1] == pytest.approx(float(rules.tower_buckling(stress, r, wall, 20.0).utilisation), rel=1e-12)


def test_damage_of_a_range_is_that_of_the_curve():
    # 100 MPa once a second for 20 years, 10^15.606 / 100^5 cycles allowed; half of it at a wall of 25 mm or less
    section = np.pi * ((5.0 - 0.02) / 2) ** 2 * 0.02
    found = rules.tube_fatigue([100e6 * section], [9.0, 5.0], [0.05, 0.02], 2.0, first=1)
    assert found[0] == pytest.approx(2 * 20 * 365.25 * 86400 * 1e10 / 10**15.606, rel=1e-9)
    thick = rules.tube_fatigue([100e6 * np.pi * ((5.0 - 0.05) / 2) ** 2 * 0.05], [5.0], [0.05], 2.0)
    assert thick[0] == pytest.approx(found[0] * 2, rel=1e-9)  # (2^0.2)^5


def test_a_straight_cone_is_even_and_a_kink_counts_by_its_square():
    z = np.array([0.0, 1.0, 3.0, 7.0])
    assert rules.unevenness(z, 9.0 - 0.2 * z) == pytest.approx(0.0, abs=1e-28)
    assert rules.unevenness(z, [1.0, 2.0, 2.0, 4.0]) == pytest.approx((0 - 1) ** 2 + (0.5 - 0) ** 2)
    teeth = np.array([0.0, 0.1, 0.0, 0.1])
    assert float(rules.unevenness(z, ca.DM(teeth))) == pytest.approx((-0.05 - 0.1) ** 2 + (0.025 + 0.05) ** 2)


def test_sizes_at_heights_are_linear_between_those_that_are_known_and_go_on():
    at = np.array([-80.0, -47.5, -10.0, 4.0])
    assert rules.sizes_at(at, Z, T) == pytest.approx(np.interp(at, Z, T), rel=1e-14)
    below, above = T[0] - 5 * (T[1] - T[0]) / 20, T[-1] + 2 * (T[-1] - T[-2]) / 10
    assert rules.sizes_at([-85.0, 12.0], Z, T) == pytest.approx([below, above], rel=1e-14)
    z = ca.MX.sym("z", 4)
    found = ca.Function("t", [z], [rules.sizes_at(z, Z, T), ca.diag(ca.jacobian(rules.sizes_at(z, Z, T), z))])(at + 1.0)
    assert np.ravel(found[0]) == pytest.approx(np.interp(at + 1.0, Z, T), rel=1e-14)
    pieces = np.diff(T) / np.diff(Z)
    assert np.ravel(found[1]) == pytest.approx(pieces[[0, 1, 3, 4]], rel=1e-12)
    with pytest.raises(fw.ModelError, match="heights 6, sizes 5"):
        rules.sizes_at(at, Z, T[1:])
    with pytest.raises(fw.ModelError, match="from the lowest to the highest"):
        rules.sizes_at(at, Z[::-1], T)


@pytest.mark.parametrize("which", ["diameters", "walls"])
def test_expressions_have_the_values_and_slopes_of_numbers(which):
    x = ca.MX.sym("x", 6)
    sizes = {"diameters": ca.DM(D), "walls": ca.DM(T)} | {which: x}
    d, t = sizes["diameters"], sizes["walls"]
    rows = ca.vertcat(*rules.hull_buckling(ca.DM(Z), d, t, ca.DM(M), ca.DM(N), *RINGS).__dict__.values(),
                      rules.hull_cost(ca.DM(Z), d, t, *RINGS).cost, rules.spar_heave_period(ca.DM(Z), d),
                      rules.tapers(ca.DM(Z), d))  # fmt: skip
    function = ca.Function("f", [x], [rows, ca.jacobian(rows, x)])

    def numbers(values):
        d, t = (values, T) if which == "diameters" else (D, values)
        use = rules.hull_buckling(Z, d, t, M, N, *RINGS)
        return np.concatenate([*use.__dict__.values(), [rules.hull_cost(Z, d, t, *RINGS).cost],
                               [rules.spar_heave_period(Z, d)], rules.tapers(Z, d)])  # fmt: skip

    at = {"diameters": D, "walls": T}[which]
    value, slope = (np.array(item) for item in function(at))
    assert value.ravel() == pytest.approx(numbers(at), rel=1e-10, abs=1e-12)
    for k in range(6):
        h = 1e-6 * at[k]
        step = np.eye(6)[k] * h
        by = (numbers(at + step) - numbers(at - step)) / (2 * h)
        assert slope[:, k] == pytest.approx(by, rel=1e-5, abs=1e-6 * max(1.0, np.abs(by).max()))


def test_the_ballast_is_that_of_the_model_at_rest():
    """The printed spar in its model needs 13.30671 kt for a heave of zero at rest."""
    z = [-80.427, -75.064, -68.117, -62.249, -56.242, -50.677, -44.312, -31.584, -18.829, -8.741, 0.0, 10.0]
    d = [21.365, 19.505, 17.055, 15.003, 12.940, 14.070, 16.314, 20.681, 16.212, 12.784, 12.726, 12.660]
    t = np.array([84, 75, 64, 56, 51, 54, 61, 68, 60, 85, 73.8, 61]) * 1e-3
    zt = [10, 20.5, 31, 41.5, 52, 62.5, 73, 83.5, 94, 104.5, 115.63]
    dt = [12.660, 14.377, 14.096, 13.827, 12.742, 11.422, 10.473, 9.892, 8.904, 7.789, 6.774]
    tt = np.array([61, 37, 33, 30, 29, 29, 27, 24, 21, 18, 15]) * 1e-3
    line = rules.hanging_line(1497.2, 187500 * 0.081**2, 9e10 * 0.081**2, 320 - 10.7, 1433.0)
    found = rules.spar_ballast(z, d, t, 0.04, zt, dt, tt, 676.7e3, line.vertical)
    assert found == pytest.approx(13.30671e6, rel=2e-5)


def test_the_heave_period_is_that_of_the_model():
    """Lines pull down by weight that does not move with the spar, and more as it rises; 2 % less than without them."""
    plant = fw.load("dtu10mw_spar_3_parked").compile()
    sizes, values = {"line_length": 1520.0, "line_distance": 1450.0, "chain_diameter": 0.085}, plant.parameter_values()
    calm = {"sea.spectrum": "still", "wind.kind": "steady", "wind.mean_speed": 0.0, "thrust": 0.0}
    z, d = (np.array(values[f"hull_{name}"], dtype=float) for name in ("heights", "diameters"))
    for given in ({}, sizes):
        L, X, c = ({**values, **given}[name] for name in ("line_length", "line_distance", "chain_diameter"))
        rest = plant.equilibrium(parameters=calm | given, free=["ballast"], targets={"heave": 0.0})
        [(_, period, unit)] = quantities_at(plant, rest, ["period of heave"])
        line = rules.hanging_line(L, 187500 * c**2, 9e10 * c**2, 320 - 10.7, X)
        found = rules.spar_heave_period(z, d, line.vertical, line.vertical_stiffness)
        assert unit == "s" and found == pytest.approx(float(np.ravel(period)[0]), rel=1e-6)
        assert rules.spar_heave_period(z, d) / found == pytest.approx(1.017, abs=2e-3)


@pytest.mark.parametrize("length, distance, h, w, EA", [
    (1497.2, 1433.0, 309.3, 1230.0, 5.9e8), (900.0, 700.0, 300.0, 800.0, 1e9), (902.2, 848.67, 250.0, 698.0, 3.8e8),
])  # fmt: skip
def test_a_hanging_line_is_a_catenary(length, distance, h, w, EA):
    found = rules.hanging_line(length, w, EA, h, distance)
    H, V = float(found.horizontal), float(found.vertical)
    # step by step along the line from where it leaves the seabed
    s = np.linspace(0.0, V / w, 200_001)
    T = np.hypot(H, w * s)
    x = np.trapezoid(H / T * (1 + T / EA), s) + (length - V / w) * (1 + H / EA)
    z = np.trapezoid(w * s / T * (1 + T / EA), s)
    assert x == pytest.approx(distance, rel=1e-8) and z == pytest.approx(h, rel=1e-8)
    up, down = (rules.hanging_line(length, w, EA, h + step, distance).vertical for step in (0.01, -0.01))
    assert found.vertical_stiffness == pytest.approx((up - down) / 0.02, rel=1e-6)
    e = ca.MX.sym("L")
    of_length = ca.Function("V", [e], [rules.hanging_line(e, w, EA, h, distance).vertical])
    assert float(of_length(length)) == pytest.approx(V, rel=1e-12)


def test_a_line_that_hangs_as_a_whole_is_refused():
    with pytest.raises(Exception, match="length_on_the_seabed"):
        rules.hanging_line(760.0, 1000.0, 1e10, 300.0, 690.0)
