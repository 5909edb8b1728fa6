"""SectionedLine: against CatenaryLine, MoorPy, a lumped chain over the seabed, and its own potential."""

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Fixed, Prismatic, RigidBody, World
from fowtlib.components.mooring import CatenaryLine, SectionedLine
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError, SimulationError

CHAIN = {"axial_stiffness": 384.243e6, "mass_per_length": 77.7066, "diameter": 0.09}
OC3 = {"left": (0, 0, -320), "right": (848.67, 0, -70), "depth": 320.0}


def between(line, left, right, depth):
    """The plant of a line between two points that are parameters."""
    model = Assembly("line between two points")
    model.world = World(water_depth=depth)
    model.left, model.right = Fixed(r=left), Fixed(r=right)
    model.line = line
    model.connect(model.left.frame, model.line.anchor)
    model.connect(model.right.frame, model.line.fairlead)
    return fw.load(model).compile()


def forces(state):
    """Pull of the line on its fairlead, and on its anchor."""
    return -np.ravel(state["line.fairlead.f"]), -np.ravel(state["line.anchor.f"])


NAMES = ("horizontal_tension", "vertical_tension", "tension", "anchor_tension")


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("lengths", [[902.2], [451.1, 451.1], [100.0, 300.0, 502.2]])
def test_sections_of_equal_properties_are_one_line(lengths, friction):
    one = between(CatenaryLine(length=902.2, friction=friction, **CHAIN), **OC3)
    many = between(SectionedLine(lengths=lengths, friction=friction, **CHAIN), **OC3)
    for x, z in [(660, -70), (700, -70), (800, -70), (848.67, -70), (848.67, -20), (870, -90), (900, -70)]:
        place = {"right.r": (0.8 * x, -0.6 * x, z)}
        expected, state = one.initial_state(place), many.initial_state(place)
        for name in NAMES:
            assert state[f"line.{name}"] == pytest.approx(expected[f"line.{name}"], rel=1e-8, abs=1e-3), (x, name)
        assert np.sum(state["line.seabed_lengths"]) == pytest.approx(expected["line.seabed_length"], abs=1e-5)
        assert forces(state)[0] == pytest.approx(forces(expected)[0], rel=1e-8, abs=1e-3)
        assert forces(state)[1] == pytest.approx(forces(expected)[1], rel=1e-8, abs=1e-3)


@pytest.mark.parametrize(("left", "right"), [((0, 0, -30), (500, 0, -14)), ((0, 0, -14), (300, 400, -30))])
@pytest.mark.parametrize("length", [520.0, 620.0])
def test_sections_between_two_bodies(left, right, length):
    """In mid-water, and on the seabed between the ends, which no point touches.

    The pull down to the seabed is rounded by 1e-8 of the weight of what touches it, which is a section here.
    """
    line = {"axial_stiffness": 7.5e8, "weight_per_length": 1000}
    one = between(CatenaryLine(length=length, **line), left, right, 130.01).initial_state()
    many = between(SectionedLine(lengths=[length - 50, 50], **line), left, right, 130.01).initial_state()
    for name in NAMES:
        assert many[f"line.{name}"] == pytest.approx(one[f"line.{name}"], rel=1e-7)


# lengths, weights in water, EA; masses and volumes of points; ends, depth: pull on fairlead and anchor [N], tensions at
# upper ends [N], points, from MoorPy 1.3.0, moorpy.System.solveEquilibrium (Hall et al., NREL). MoorPy holds up
# points within 2 m of the seabed in part; none is here.
MOORPY = {
    "chain, wire, chain": (
        ([150, 550, 100], [1800, 300, 1500], [1e9, 5e8, 9e8]), ([0, 0], [0, 0]), (0, 0, -320), (730, 0, -14), 320,
        (-663673.57, 0, -537450.27), (663673.5, 0, 0), (699961.87, 768492.16, 853999.65), (20.17395, 248.94368),
    ),
    "clump weights": (
        ([300, 200, 200], [700, 700, 700], 4e8), ([20000, 30000], [2.5, 4]), (0, 0, -250), (620, 100, -20), 250,
        (-763616.6, -123163.97, -809509.4), (763616.6, 123163.96, 0), (780514.44, 878028.59, 1119636.17),
        (10.060978, 91.57405),
    ),
    "a clump weight on the seabed": (
        ([300, 200, 200], [700, 700, 700], 4e8), ([20000, 30000], [2.5, 4]), (0, 0, -250), (560, 100, -20), 250,
        (-178599.19, -31892.71, -505996.69), (178599.19, 31892.71, 0), (181424.41, 213213.07, 537538.34),
        (0, 45.434772),
    ),
    "a buoy": (
        ([250, 150, 200], [800, 600, 600], 6e8), ([5000, 0], [45, 0]), (0, 0, -200), (480, 0, -10), 200,
        (-148140.11, 0, -103232.83), (148140.11, 0, 96531.31), (331475.96, 149085.98, 180561.65),
        (193.40723, 137.52614),
    ),
    "a weight between two bodies": (
        ([100, 100], [5, 5], 2e7), (40000, 5), (0, 0, -60), (180, 0, -60), 1000,
        (-323537.66, 0, -171503.46), (323537.66, 0, -171503.46), (365949.18, 366183.09), (892.36162,),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MOORPY)
def test_against_moorpy(name):
    (lengths, weights, stiffness), (mass, volume), left, right, depth, fairlead, anchor, tensions, points = MOORPY[name]
    line = SectionedLine(lengths=lengths, weight_per_length=weights, axial_stiffness=stiffness, point_mass=mass,
                         point_volume=volume)  # fmt: skip
    state = between(line, left, right, depth).initial_state()
    at_fairlead, at_anchor = forces(state)
    assert at_fairlead == pytest.approx(fairlead, rel=2e-5, abs=1)
    assert at_anchor == pytest.approx(anchor, rel=2e-5, abs=1)
    assert np.ravel(state["line.tensions"]) == pytest.approx(tensions, rel=2e-5)
    assert np.ravel(state["line.heights"]) == pytest.approx(points, abs=0.012)  # ends lie on the seabed up to 1 cm


def lumped(lengths, weights, stiffness, points, x, z, n=40):
    """Tensions (H, V) [N] at the fairlead by the least potential energy of elastic links over a hard seabed."""
    link = np.repeat(np.array(lengths) / n, n)
    w, EA = (np.repeat(values, n) for values in (weights, stiffness))
    load = (w * link)[:-1] / 2 + (w * link)[1:] / 2
    load[np.arange(1, len(lengths)) * n - 1] += points
    inner = ca.SX.sym("inner", 2, link.size - 1)
    step = ca.diff(ca.horzcat(ca.DM([0, 0]), inner, ca.DM([x, z])), 1, 1)
    sizes = ca.sqrt(ca.sum1(step**2)).T
    energy = ca.sum1(ca.DM(EA / (2 * link)) * (sizes - ca.DM(link)) ** 2) + ca.dot(ca.DM(load), inner[1, :].T)
    solver = ca.nlpsol("chain", "ipopt", {"x": ca.vec(inner), "f": energy / (np.sum(np.abs(load)) * z)},
                       {"print_time": 0, "ipopt.print_level": 0, "ipopt.max_iter": 2000})  # fmt: skip
    way = np.cumsum(link)[:-1] / link.sum()
    start = np.column_stack([x * way, z * way]).ravel()
    found = solver(x0=start, lbx=np.tile([-ca.inf, 0.0], link.size - 1))
    assert solver.stats()["success"]
    last = np.array([x, z]) - np.array(found["x"]).ravel()[-2:]
    pull = EA[-1] * (np.hypot(*last) / link[-1] - 1)
    return pull * last / np.hypot(*last) + [0, w[-1] * link[-1] / 2]


@pytest.mark.parametrize(
    ("weights", "points", "x"),
    [
        ([700, 700, 700], [30000, 60000], 590.0),  # both points hang
        ([700, 700, 700], [30000, 200000], 560.0),  # the first lies on the seabed
        ([900, 400, 700], [0, -120000], 540.0),  # a lazy wave, its sag free
        ([900, -200, 500], [0, 0], 540.0),  # a section that floats
        ([900, 500, 900], [-150000, 0], 500.0),  # the sag behind the buoy touches the seabed
        ([900, 500, 700], [-150000, 150000], 560.0),  # and a point with it
    ],
)
def test_against_a_lumped_chain(weights, points, x):
    lengths, stiffness, z = [250.0, 200.0, 210.0], [6e8, 4e8, 5e8], 200.0
    expected = lumped(lengths, weights, stiffness, points, x, z)
    line = SectionedLine(lengths=lengths, weight_per_length=weights, axial_stiffness=stiffness,
                         point_mass=np.maximum(points, 0) / 9.80665,
                         point_volume=np.maximum(np.negative(points), 0) / 9.80665 / 1025)  # fmt: skip
    plant = between(line, (0, 0, -220.01), (x, 0, -20), 220)
    state = plant.initial_state({"left.r": (0, 0, -220)})
    found = [state["line.horizontal_tension"], state["line.vertical_tension"]]
    assert found == pytest.approx(expected, rel=1e-2)


SETS = [
    {"lengths": [250, 200, 210], "weight_per_length": [900, 400, 700], "point_mass": [3000, 10000]},
    {"lengths": [250, 200, 210], "weight_per_length": [900, 400, 700], "point_mass": 0, "point_volume": [0, 12]},
    {"lengths": [330, 330], "weight_per_length": [900, -100]},
]


@pytest.mark.parametrize("line", SETS)
def test_stiffness_is_symmetric_and_the_derivative_of_the_pull(line):
    plant = between(SectionedLine(axial_stiffness=5e8, **line), (0, 0, -220), (540, 120, -20), 220)
    state = plant.initial_state()
    pulls = [f"line.fairlead.f[{i}]" for i in range(3)]
    slopes = plant.linearize(state, inputs=["right.r"], outputs=pulls).matrices["D"]
    assert slopes == pytest.approx(slopes.T, rel=1e-6, abs=1e-6 * np.abs(slopes).max())
    assert np.linalg.eigvalsh(slopes).min() > 0
    step = 1e-3
    for i in range(3):
        ends = [plant.initial_state({"right.r": np.array([540, 120, -20]) + sign * step * np.eye(3)[i]})
                for sign in (1, -1)]  # fmt: skip
        difference = -(forces(ends[0])[0] - forces(ends[1])[0]) / (2 * step)
        assert slopes[:, i] == pytest.approx(difference, rel=1e-4, abs=1e-4 * np.abs(slopes).max())


@pytest.mark.parametrize("line", SETS)
def test_every_sensible_place_is_solved_from_the_fixed_start(line):
    """From a line that hangs down to one that is stretched by 2 %; its weight is what its ends carry with the bed."""
    plant = between(SectionedLine(axial_stiffness=5e8, **line), (0, 0, -220), (540, 0, -20), 220)
    whole = sum(line["lengths"])
    for share in (0.4, 0.7, 0.9, 0.98, 1.0, 1.02):
        for z in (-150.0, -20.0):
            x = np.sqrt((share * whole) ** 2 - (220 + z) ** 2)
            state = plant.initial_state({"right.r": (x, 0, z)})
            fairlead, anchor = forces(state)
            assert fairlead[0] + anchor[0] == pytest.approx(0, abs=1e-3)
            weights = np.ravel(state["line.weights"])
            points = np.zeros(weights.size - 1) + np.array(line.get("point_mass", 0)) * 9.80665
            points -= 1025 * 9.80665 * np.array(line.get("point_volume", 0))
            hanging = weights @ (line["lengths"] - np.ravel(state["line.seabed_lengths"]))
            heights = np.ravel(state["line.heights"])
            if np.all(heights > 0.01):
                assert -fairlead[2] - anchor[2] == pytest.approx(hanging + points.sum(), rel=1e-6, abs=1)


def moored(**line):
    """A body that slides between two lines."""
    model = Assembly("a body on two lines")
    model.world = World(water_depth=220)
    model.hold, model.slide = Fixed(r=(0, 0, -20)), Prismatic(s_start=30.0)
    model.body = RigidBody(mass=4e5, inertia=np.eye(3))
    model.left = SectionedLine(**{"anchor_position": (-540, 0, -220), "axial_stiffness": 5e8, **SETS[0], **line})
    model.right = SectionedLine(anchor_position=(540, 0, -220), axial_stiffness=5e8, **SETS[0])
    model.connect(model.hold.frame, model.slide.frame_a)
    for frame in (model.body.frame_a, model.left.fairlead, model.right.fairlead):
        model.connect(model.slide.frame_b, frame)
    return model


def test_what_is_drawn_goes_through_the_points_and_ends_at_the_frames(tmp_path):
    """Also with a point on the seabed, and of a line that is lost."""
    model = fw.load(moored())
    plant, line = model.compile(), model.root.left
    curve = line.drawing()[0]
    paths = {key: f"{source.path}.r" if hasattr(source, "path") else source for key, source in curve.of.items()}
    result = plant.simulate(2.0, 0.5, outputs=[*paths.values(), "left.seabed_lengths"], events=["left.loss at 1.9 s"])
    columns = {key: result.array(path) for key, path in paths.items()}
    points = curve.points(columns)
    assert points.shape == (5, 91, 3) and np.all(np.isfinite(points))
    assert points[:4, 0] == pytest.approx(columns["anchor"][:4], abs=1e-6)
    assert points[:4, -1] == pytest.approx(columns["fairlead"][:4], abs=1e-6)
    for i in (0, 1):
        assert points[:4, 30 * (i + 1), 2] + 220 == pytest.approx(columns[f"heights[{i}]"][:4], abs=0.02)
    assert points[:4, :, 2].min() >= -220.011
    assert np.ptp(points[-1], axis=0).max() == 0
    steps = np.linalg.norm(np.diff(points[0], axis=0), axis=1).sum()
    assert steps == pytest.approx(660, rel=2e-3)
    fw.view(result, tmp_path / "lines.html")
    assert (tmp_path / "lines.html").stat().st_size > 1000


def test_both_engines_lift_a_clump_weight_off_the_seabed_and_agree():
    plant = fw.load(moored()).compile()
    names = ["slide.s", "left.tension", "right.tension", "right.heights[1]"]
    results = [plant.simulate(40.0, 0.1, solver=solver, outputs=names, tolerance=1e-8) for solver in ("idas", "fixed")]
    height = results[0]["right.heights[1]"].to_numpy()
    assert height[0] == pytest.approx(0, abs=1e-6) and height.max() > 20
    for name in names:
        a, b = (result[name].to_numpy() for result in results)
        assert b == pytest.approx(a, abs=5e-3 * np.abs(a).max()), name


def test_a_lost_line_pulls_no_more():
    plant = fw.load(moored()).compile()
    result = plant.simulate(2.0, 0.1, outputs=["left.tension", "right.tension"], events=["left.loss at 1 s"])
    assert result["left.tension"][5] > 1e5 and result["left.tension"][-1] == 0 < result["right.tension"][-1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ({"point_mass": [1, 2, 3]}, "point_mass has 3 values for 2 points between the sections; give one for all"),
        ({"friction": [1, 2]}, "friction has 2 values for 3 sections; give one for all of them, or one for each"),
        ({"mass_per_length": 100}, "needs its weight once"),
        ({"anchor_position": (-540, 0, -230)}, "has its anchor at z = -230 m, below the seabed"),
        ({"anchor_position": (-540, 0, 220)}, "has its anchor at z = 220 m, above the water, where"),
    ],
)
def test_mistakes(line, message):
    with pytest.raises(ParameterError, match=message):
        fw.load(moored(**line)).compile()


def test_a_buoy_at_the_surface_is_refused():
    plant = between(SectionedLine(axial_stiffness=5e8, **SETS[1]), (0, 0, -220), (400, 0, -20), 220)
    with pytest.raises(SimulationError, match=r"line: the line comes up to z = \d+\.?\d* m between its ends"):
        plant.equilibrium({"line.point_volume": (0, 60), "right.r": (450, 0, -20)})


def test_warnings_of_a_slack_and_of_a_loaded_line():
    plant = between(SectionedLine(axial_stiffness=5e8, breaking_load=[1e9, 1e9, 2e5], **SETS[0]), (0, 0, -220),
                    (540, 0, -20), 220)  # fmt: skip
    with pytest.warns(UserWarning, match="N in section 3 is above its breaking load"):
        plant.equilibrium()
    with pytest.warns(UserWarning, match="the line is slack"):
        plant.equilibrium({"right.r": (100, 0, -20), "line.breaking_load": 1e9})


def test_dimensions_agree():
    assert "nothing wrong" in str(fw.load(moored()).check())
