"""DynamicLine: balances, joints, bending, fibre ropes, loss: against closed forms and a second formulation."""

import numpy as np
import pytest
from scipy.special import jn_zeros

import fowtlib as fw
from fowtlib.components.environment import Current
from fowtlib.components.mechanics import Fixed, World
from fowtlib.components.mechanics.forced_motion import ForcedOscillation
from fowtlib.components.mooring import CrowFoot, DragAnchor, DynamicLine, LineJoint, SectionedLine
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError, SimulationError

CHAIN = {"axial_stiffness": 384.243e6, "mass_per_length": 77.7066, "diameter": 0.09}


def held(line, left, right, depth=320.0, **world):
    model = Assembly("line between two points")
    model.world = World(water_depth=depth, **world)
    model.left, model.right = Fixed(r=left), Fixed(r=right)
    model.line = line
    model.connect(model.left.frame, model.line.anchor)
    model.connect(model.right.frame, model.line.fairlead)
    return model


def test_energy_of_a_line_that_swings_in_air_goes_into_its_damping():
    """Kinetic, elastic and potential energy by hand from the nodes; what is missing is the work of the dampers."""
    n, L, ratio = 12, 100.0, 10.0
    line = DynamicLine(lengths=L, elements=n, damping_ratio=ratio, **CHAIN)
    plant = fw.load(held(line, (0, 0, -60), (95, 0, -60), water_density=0.0)).compile()
    kick = {f"line.offset_rates[1,{k}]": 8 * np.sin(np.pi * (k + 1) / n) for k in range(n - 1)}
    result = plant.simulate(4.0, output_step=0.001, start=kick, tolerance=1e-9)
    x, v = np.asarray(result["line.positions"]), np.asarray(result["line.offset_rates"])
    m, EA = 77.7066, 384.243e6
    ways = np.diff(x, axis=2)
    lengths = np.linalg.norm(ways, axis=1)
    strain = lengths / (L / n) - 1
    speeds = np.pad(v, ((0, 0), (0, 0), (1, 1)))
    rate = np.sum(ways / lengths[:, None, :] * np.diff(speeds, axis=2), axis=1) / (L / n)
    pull = np.asarray(result["line.tensions"])
    energy = m * L / n * (np.sum(v**2, axis=(1, 2)) / 2 + 9.80665 * np.sum(x[:, 2, 1:-1], axis=1))
    energy += np.sum(EA * L / n / 2 * np.maximum(strain, 0) ** 2, axis=1)
    elastic = EA * np.maximum(strain, 0)  # what the springs take up; the rest of the pull is lost
    lost = np.sum((pull - elastic) * rate * L / n, axis=1)
    work = np.concatenate([[0], np.cumsum((lost[1:] + lost[:-1]) / 2 * np.diff(result.time))])
    assert np.min(lost) > -1e-2 * np.max(lost)
    exchanged = np.ptp(m * L / n * np.sum(v**2, axis=(1, 2)) / 2)
    assert energy + work == pytest.approx(energy[0], abs=1e-5 * exchanged)
    assert work[-1] > 50e-5 * exchanged


def test_momentum_is_what_the_ends_and_the_weight_give():
    n, L, m = 10, 100.0, 77.7066
    line = DynamicLine(lengths=L, elements=n, **CHAIN)
    plant = fw.load(held(line, (0, 0, -60), (95, 0, -60), water_density=0.0)).compile()
    kick = {f"line.offset_rates[1,{k}]": 1.0 for k in range(n - 1)}
    result = plant.simulate(2.0, output_step=0.002, start=kick, tolerance=1e-9)
    momentum = m * L / n * np.sum(np.asarray(result["line.offset_rates"]), axis=2)
    force = np.asarray(result["line.fairlead.f"]) + np.asarray(result["line.anchor.f"])
    force = force.reshape(len(result.time), 3) + np.array([0, 0, -m * L * 9.80665])
    given = np.concatenate([np.zeros((1, 3)), np.cumsum((force[1:] + force[:-1]) / 2 * 0.002, axis=0)])
    assert momentum - momentum[0] == pytest.approx(given, abs=3e-3 * np.max(np.abs(momentum)))


def test_a_turned_and_shifted_line_is_the_same():
    def tension(angle, shift):
        c, s = np.cos(angle), np.sin(angle)
        turn = lambda x, z: (c * x + shift[0], s * x + shift[1], z)  # noqa: E731
        model = Assembly("turned")
        model.world = World(water_depth=320)
        model.sea_current = Current(speed=0.5, direction=angle + 0.6)
        model.drive = ForcedOscillation(r=turn(858.67, -70), n=(c, s, 0), speed_amplitude=2.0, period=10)
        model.line = DynamicLine(lengths=902.2, elements=10, anchor_position=turn(0, -320), friction=0.5, **CHAIN)
        model.connect(model.drive.frame, model.line.fairlead)
        result = fw.load(model).compile().simulate(25.0, output_step=0.5, solver="fixed", step=0.0125)
        return np.asarray(result["line.tension"])

    assert tension(1.1, (300.0, -50.0)) == pytest.approx(tension(0.0, (0, 0)), rel=1e-5)


def test_modes_of_a_hanging_chain():
    """Free at its lower end: those of masses on a string, by their matrices; the lowest are j / 2 sqrt(g / L).

    j: the zeros of the Bessel function of order 0.
    """
    L, n = 50.0, 40
    model = Assembly("hanging chain")
    model.world = World(water_depth=200, water_density=0.0)
    model.top, model.end = Fixed(r=(0, 0, -20)), LineJoint(position=(0, 0, -20 - L * 1.0001))
    model.line = DynamicLine(lengths=L, elements=n, **CHAIN | {"axial_stiffness": 1e9})
    model.connect(model.top.frame, model.line.fairlead)
    model.connect(model.end.frame, model.line.anchor)
    plant = fw.load(model).compile()
    found = np.sort([mode.frequency_hz for mode in plant.linearize(plant.equilibrium(), outputs=[]).modes()])
    expected = jn_zeros(0, 2) / 2 * np.sqrt(9.80665 / L) / (2 * np.pi)
    assert found[[0, 2]] == pytest.approx(expected, rel=5e-3)
    mass = np.ones(n)
    mass[-1] = 0.5  # over m l, from the top on
    pull = np.cumsum(mass[::-1])[::-1] * 9.80665 / (L / n)  # over m l, of the elements, per length
    K = np.diag(pull) + np.diag(np.append(pull[1:], 0)) - np.diag(pull[1:], 1) - np.diag(pull[1:], -1)
    masses = np.sqrt(np.linalg.eigvalsh(K / np.sqrt(np.outer(mass, mass)))) / (2 * np.pi)
    assert found[[0, 2, 4, 6]] == pytest.approx(masses[:4], rel=1e-3)
    assert found[[1, 3, 5, 7]] == pytest.approx(masses[:4], rel=1e-3)


def test_modes_of_a_stiff_cable():
    """Pinned, taut and stiff: (k pi / L)^2 (T + EI (k pi / L)^2) / m; 40 elements."""
    L, n, EA, EI, m, stretch = 100.0, 40, 5e8, 4e7, 80.0, 1e-4
    line = DynamicLine(lengths=L, elements=n, axial_stiffness=EA, mass_per_length=m, diameter=0.2, bending_stiffness=EI)
    plant = fw.load(held(line, (0, 0, -50), (L * (1 + stretch), 0, -50), 100, gravity=0.0, water_density=0.0)).compile()
    found = [mode.frequency_hz for mode in plant.linearize(plant.equilibrium(), outputs=[]).modes()]
    k = np.arange(1, 4) * np.pi / L
    expected = np.sqrt(k**2 * (EA * stretch + EI * k**2) / m) / (2 * np.pi)
    assert np.sort(found)[[0, 2, 4]] == pytest.approx(expected, rel=5e-3)


def test_curvature_of_a_cable_that_sags_little():
    """A pinned beam under its weight, so long that it is not pulled: w x (L - x) / 2 EI."""
    L, n, EI = 40.0, 20, 5e7
    weight = (30 - 1025 * np.pi / 4 * 0.1**2) * 9.80665
    longer = (weight / (24 * EI)) ** 2 * L**7 * 17 / 70
    line = DynamicLine(lengths=L + longer, elements=n, axial_stiffness=1e9, mass_per_length=30, diameter=0.1,
                       bending_stiffness=EI)  # fmt: skip
    plant = fw.load(held(line, (0, 0, -50), (L, 0, -50), 100)).compile()
    found = np.asarray(plant.equilibrium()["line.curvatures"])
    x = np.arange(1, n) * L / n
    assert found == pytest.approx(weight * x * (L - x) / (2 * EI), rel=0.01)


# --- sections, points, joints -----------------------------------------------------------------------------------------


def test_sections_with_a_clump_weight_and_a_buoy_at_rest():
    """Against SectionedLine, whose sections are catenaries: tensions at the ends, heights of the points."""
    given = {
        "lengths": [350.0, 300.0, 110.0], "mass_per_length": [113.35, 40.0, 113.35],
        "diameter": [0.0766, 0.06, 0.0766], "axial_stiffness": [754e6, 600e6, 754e6],
        "point_mass": [20e3, 2e3], "point_volume": [2.5, 8.0],
    }  # fmt: skip
    ends = ((-720, 0, -200), (0, 0, -14))
    one = fw.load(held(SectionedLine(**given), *ends, 200.0)).compile().initial_state()
    line = DynamicLine(elements=60, seabed_stiffness=1e7, **given)
    many = fw.load(held(line, *ends, 200.0)).compile().initial_state()
    assert many["line.tension"] == pytest.approx(one["line.tension"], rel=3e-3)
    assert many["line.anchor_tension"] == pytest.approx(one["line.anchor_tension"], rel=3e-3)
    nodes = np.cumsum(line.shared_out()[:-1])
    assert np.asarray(many["line.clearances"])[nodes] == pytest.approx(np.asarray(one["line.heights"]), abs=0.3)


def crow_foot(angle=0.0):
    """Two legs of 50 m to fairleads 10 m apart, and a line of 800 m from the anchor to their node."""
    model = Assembly("crow-foot")
    model.world = World(water_depth=320)
    c, s = np.cos(angle), np.sin(angle)
    node = (805 * c, 805 * s, -85)
    model.node = LineJoint(position=node)
    model.line = DynamicLine(lengths=852.2, elements=12, anchor_position=(0, 0, -320), **CHAIN)
    model.connect(model.node.frame, model.line.fairlead)
    for side, y in (("left", 5.0), ("right", -5.0)):
        end = model.add(f"{side}_end", Fixed(r=(853.87 * c - y * s, 853.87 * s + y * c, -70)))
        leg = model.add(side, DynamicLine(lengths=50.0, elements=6, **CHAIN))
        model.connect(model.node.frame, leg.anchor)
        model.connect(end.frame, leg.fairlead)
    return fw.load(model).compile()


def test_a_crow_foot_is_in_balance_and_like_one_with_straight_legs():
    plant = crow_foot()
    state = plant.equilibrium()
    pulls = [np.ravel(state[f"{name}.f"]) for name in ("line.fairlead", "left.anchor", "right.anchor")]
    assert sum(pulls) == pytest.approx(np.zeros(3), abs=1e-3)
    left, right = (np.ravel(state[f"{side}.fairlead.f"]) for side in ("left", "right"))
    assert left == pytest.approx(right * [1, -1, 1], rel=1e-9, abs=1e-3)

    model = Assembly("straight legs")
    model.world = World(water_depth=320)
    model.left, model.right = Fixed(r=(853.87, 5, -70)), Fixed(r=(853.87, -5, -70))
    model.delta = CrowFoot(length=50.0, node_start=(-45, 0, -15), **CHAIN)
    model.line = DynamicLine(lengths=852.2, elements=12, anchor_position=(0, 0, -320), fairlead_start=(805, 0, -85),
                             **CHAIN)  # fmt: skip
    for side in ("left", "right"):
        model.connect(getattr(model, side).frame, getattr(model.delta, side))
    model.connect(model.delta.node, model.line.fairlead)
    other = fw.load(model).compile().equilibrium()
    assert np.ravel(state["node.r"]) == pytest.approx(np.ravel(other["line.fairlead.r"]), abs=0.3)
    assert np.mean(state["left.tensions"]) == pytest.approx(other["delta.left_tension"], rel=5e-3)


def test_a_crow_foot_settles_in_a_run_and_does_not_care_where_it_looks():
    one, other = crow_foot(), crow_foot(0.7)
    tensions = [plant.equilibrium()["line.tension"] for plant in (one, other)]
    assert tensions[1] == pytest.approx(tensions[0], rel=1e-8)
    result = one.simulate(5.0, output_step=1.0, start=one.equilibrium(), solver="fixed", step=0.0125)
    assert np.asarray(result["line.tension"]) == pytest.approx(tensions[0], rel=1e-6)


# --- fibre ropes, loss, friction --------------------------------------------------------------------------------------


def test_a_fibre_rope_follows_its_table():
    """Taut, so light that its tension is that of the table at its strain; stiffer where it is stretched more."""
    table = [(-0.01, -2e5), (0.0, 0.0), (0.01, 2e5), (0.03, 1.4e6)]
    line = DynamicLine(lengths=100.0, elements=8, axial_stiffness=2e7, mass_per_length=8.0, diameter=0.1,
                       strain_table=table)  # fmt: skip
    plant = fw.load(held(line, (0, 0, -60), (101.0, 0, -60), 100, gravity=0.0)).compile()
    for strain, expected in ((0.005, 1e5), (0.02, 0.8e6), (0.03, 1.4e6)):
        state = plant.initial_state({"right.r": (100 * (1 + strain), 0, -60)})
        assert np.asarray(state["line.tensions"]) == pytest.approx(expected, rel=1e-3)
    with pytest.raises(SimulationError, match="its strain_table ends at 0.03"):
        plant.simulate(1.0, parameters={"right.r": (103.5, 0, -60)})
    with pytest.raises(ParameterError, match="both rising"):
        flat = DynamicLine(lengths=100.0, strain_table=[(0, 0), (0.01, 0)], **CHAIN)
        fw.load(held(flat, (0, 0, -60), (100, 0, -60))).compile()


def test_a_line_breaks_at_its_fairlead_during_a_run_and_falls():
    line = DynamicLine(lengths=902.2, elements=12, **CHAIN)
    plant = fw.load(held(line, (0, 0, -320), (848.67, 0, -70))).compile()
    result = plant.simulate(120.0, output_step=0.5, solver="fixed", step=0.0125,
                            events=["line.loss at 5 s"])  # fmt: skip
    before, after = result.time < 4.9, result.time > 5.1
    tension, lowest = np.asarray(result["line.tension"]), np.asarray(result["line.clearances"])[:, 1:-1]
    assert tension[before] == pytest.approx(tension[0], rel=1e-6)
    assert np.max(tension[after]) == 0
    assert np.max(np.abs(np.ravel(np.asarray(result["line.fairlead.f"])[-1])[:2])) < 1e2
    assert np.max(lowest[-1, :]) < 0.2 * np.max(lowest[0, :])  # it lies on the seabed, or nearly
    assert np.min(lowest) > -1.0


def test_friction_of_a_line_that_is_drawn_over_the_seabed():
    """Tension at the fairlead less that at the anchor, where it is fastest: mu N v / sqrt(v^2 + creep^2)."""
    n, speed, friction = 10, 0.2, 0.6
    model = Assembly("drawn over the seabed")
    model.world = World(water_depth=50)
    model.drive = ForcedOscillation(r=(202.0, 0, -50), speed_amplitude=speed, period=40)
    model.line = DynamicLine(lengths=200.0, elements=n, anchor_position=(0, 0, -50), drag_coefficient=0.0,
                             axial_drag_coefficient=0.0, friction=friction, seabed_stiffness=1e7, **CHAIN)  # fmt: skip
    model.connect(model.drive.frame, model.line.fairlead)
    result = fw.load(model).compile().simulate(130.0, output_step=0.1, solver="fixed", step=0.0125)
    tensions, last = np.asarray(result["line.tensions"]), result.time > 90
    weight = (77.7066 - 1025 * np.pi / 4 * 0.09**2) * 9.80665 * 200 / n
    v = speed * np.arange(1, n) / n
    expected = friction * weight * np.sum(v / np.hypot(v, 0.01))
    assert np.max((tensions[:, -1] - tensions[:, 0])[last]) == pytest.approx(expected, rel=0.03)


def test_an_anchor_is_dragged_where_the_pull_is_more_than_it_holds():
    """It holds one that is pulled with less, and goes until the line pulls with its capacity."""
    H = 736.1e3  # of this line at rest

    def dragged(capacity):
        model = Assembly("an anchor that gives way")
        model.world = World(water_depth=320)
        model.anchor = DragAnchor(position=(0, 0, -320), holding_capacity=capacity)
        model.fairlead = Fixed(r=(848.67, 0, -70))
        model.line = DynamicLine(lengths=902.2, elements=8, **CHAIN)
        model.connect(model.anchor.frame, model.line.anchor)
        model.connect(model.fairlead.frame, model.line.fairlead)
        return fw.load(model).compile().simulate(120.0, output_step=0.5, solver="fixed", step=0.0125)

    held = dragged(1.5 * H)
    assert float(held["anchor.way"][-1]) == pytest.approx(0.16, abs=0.01)  # 0.2 H / C, and less stiff near C
    with pytest.warns(UserWarning, match="the anchor is dragged"):
        gone = dragged(0.8 * H)
    assert float(gone["anchor.way"][-1]) > 3.0
    assert float(gone["line.anchor_tension"][-1]) == pytest.approx(0.8 * H, rel=0.02)
    assert np.asarray(gone["anchor.dragged"])[-1][1:] == pytest.approx(0, abs=1e-6)


def test_points_are_counted():
    with pytest.raises(ParameterError, match="point_mass has 2 values for 1 points"):
        line = DynamicLine(lengths=[100.0, 100.0], point_mass=[1.0, 2.0], **CHAIN)
        fw.load(held(line, (0, 0, -100), (150, 0, -20), 100)).compile()
