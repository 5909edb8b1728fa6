"""Rotors of flexible blades in multi-blade coordinates: modes that a textbook knows, and loads that a run has."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.campbell import campbell
from fowtlib.components.environment import World
from fowtlib.components.mechanics import (
    Fixed,
    FixedFlange,
    FixedRotation,
    FixedTranslation,
    Frame,
    PointMass,
    Prismatic,
    Revolute,
    RigidBody,
    SpringDamper,
    TorsionSpringDamper,
)
from fowtlib.language import Component, cyclic_symmetry, param, port
from fowtlib.language.errors import SimulationError
from fowtlib.solving import mean_state, natural_modes
from fowtlib.solving.mean_linear import rotating_linear_model
from fowtlib.solving.multiblade import multiblade_inverse, multiblade_matrix, multiblade_names
from fowtlib.solving.rotation import steady_rotation

OFFSET, RADIUS, MASS, HUB = 0.4, 3.0, 20.0, 300.0  # m, m from the hinge, kg, kg
HINGE, HINGE_DAMPING = 1500.0, 60.0  # N m/rad, N m s/rad
HOLD_X, HOLD_Y, DAMPING = 9000.0, 14000.0, 500.0  # N/m, N/m, N s/m


class Blade(Component):
    """A mass on a rod that swings in the plane of the rotor about a hinge off the axis, against a spring."""

    angle: float = param(default=0.0, doc="azimuth in the ring [rad]")

    frame: Frame = port(doc="hub")

    def build(self):
        self.turned, self.arm = FixedRotation(angle=self.angle), FixedTranslation(r=(OFFSET, 0, 0))
        self.hinge, self.rod = Revolute(n=(0, 0, 1)), FixedTranslation(r=(RADIUS, 0, 0))
        self.mass, self.wall = PointMass(mass=MASS), FixedFlange()
        self.spring = TorsionSpringDamper(stiffness=HINGE, damping=HINGE_DAMPING)
        for a, b in (
            (self.frame, self.turned.frame_a), (self.turned.frame_b, self.arm.frame_a),
            (self.arm.frame_b, self.hinge.frame_a), (self.hinge.frame_b, self.rod.frame_a),
            (self.rod.frame_b, self.mass.frame_a), (self.wall.flange, self.spring.flange_a),
            (self.spring.flange_b, self.hinge.flange),
        ):  # fmt: skip
            self.connect(a, b)


class Rotor(Component):
    """A hub that turns freely, with blades in a ring."""

    blades: int = param(doc="number of blades")
    speed: float = param(doc="rotor speed [rad/s]")

    frame: Frame = port(doc="what the bearing is on")

    def build(self):
        self.bearing = Revolute(n=(0, 0, 1), w_start=self.speed)
        self.hub = RigidBody(mass=HUB, inertia=np.diag([100.0, 100.0, 100.0]))
        self.connect(self.frame, self.bearing.frame_a)
        self.connect(self.bearing.frame_b, self.hub.frame_a)
        for k in range(self.blades):
            blade = self.add(f"blade_{k + 1}", Blade(angle=2 * np.pi * k / self.blades))
            self.connect(self.bearing.frame_b, blade.frame)

    def equations(self):
        return [cyclic_symmetry(self.bearing.phi, [part for name, part in self.parts.items() if "blade" in name])]


def rotor_on_springs(blades: int, speed: float, hold_x: float = HOLD_X) -> fw.Model:
    """A rotor whose hub is held by springs in its plane, those along y stiffer than those along x."""
    root = fw.Assembly("ground_resonance")
    root.world = World(gravity=0.0)
    root.along, root.across = Prismatic(n=(1, 0, 0)), Prismatic(n=(0, 1, 0))
    root.rotor = Rotor(blades=blades, speed=speed)
    root.connect(root.world.frame, root.along.frame_a)
    root.connect(root.along.frame_b, root.across.frame_a)
    root.connect(root.across.frame_b, root.rotor.frame)
    for name, place, stiffness in (("x", (100, 0, 0), hold_x), ("y", (0, 100, 0), HOLD_Y)):
        wall = root.add(f"wall_{name}", Fixed(r=place))
        spring = root.add(f"spring_{name}", SpringDamper(stiffness=stiffness, damping=DAMPING, natural_length=100.0))
        root.connect(wall.frame, spring.frame_a)
        root.connect(spring.frame_b, root.across.frame_b)
    return fw.Model(root, outputs={"lag_1": fw.Output("rotor.blade_1.hinge.phi"), "hub": fw.Output("along.s")})


def textbook(blades: int, speed: float) -> np.ndarray:
    """Roots of the ground resonance: R. P. Coleman and A. M. Feingold, NACA Report 1351 (1958), hub and lag whirl.

    With I = m r^2, S = m r about the hinge and q = (x, y, cosine, sine) of N blades at the azimuths psi_b:
    I (c'' + 2 W s' - W^2 c) + C (c' + W s) + (K + W^2 e S) c + S y'' = 0, and the like for s with -S x'';
    (M + N m) x'' + d x' + k_x x - N/2 S s'' = 0, and for y with + N/2 S c''.
    """
    inertia, static, W = MASS * RADIUS**2, MASS * RADIUS, speed
    n, k = blades / 2 * static, HINGE + W**2 * OFFSET * static - W**2 * inertia
    M = np.diag([HUB + blades * MASS, HUB + blades * MASS, inertia, inertia])
    M[0, 3], M[1, 2], M[2, 1], M[3, 0] = -n, n, static, -static
    D = np.diag([DAMPING, DAMPING, HINGE_DAMPING, HINGE_DAMPING])
    D[2, 3], D[3, 2] = 2 * W * inertia, -2 * W * inertia
    K = np.diag([HOLD_X, HOLD_Y, k, k])
    K[2, 3], K[3, 2] = W * HINGE_DAMPING, -W * HINGE_DAMPING
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    return np.linalg.eigvals(A)


@pytest.mark.parametrize(("blades", "speed"), [(3, 2.0), (3, 5.5), (4, 5.5), (5, 9.0)])
def test_whirl_and_ground_resonance_of_a_rotor_on_springs(blades, speed):
    """On a hub that is held unlike in its two directions, with the unstable speeds between."""
    plant = rotor_on_springs(blades, speed).compile()
    linear = rotating_linear_model(plant, mean_state(plant), outputs=[]).linear
    found, expected = np.linalg.eigvals(linear.matrices["A"]), textbook(blades, speed)
    for root in expected:
        assert np.abs(found - root).min() < 1e-7 * abs(root)
    assert "rotor.blade_cosine.hinge.phi" in linear.states and "rotor.bearing.phi" not in linear.states


def test_a_mean_is_found_where_nothing_holds_a_position():
    """A hub that damping alone holds along x rests anywhere there: the way over positions of rest has no end then."""
    plant = rotor_on_springs(3, 2.0, hold_x=0.0).compile()
    start = plant.initial_state(None, {"across.s": 0.4, "rotor.bearing.phi": 0.3})
    found = mean_state(plant, start=start)
    assert found.x[[item.path for item in plant.dae.states].index("across.s")] == pytest.approx(0.0, abs=1e-6)
    assert found["hub"] == pytest.approx(0.0, abs=1e-3)  # the spring along y pulls along x, too, while it is aslant


def test_a_campbell_diagram_over_the_rotor_speed_follows_the_modes_and_names_what_grows():
    speeds = [5.0, 6.0, 7.0, 8.0, 9.0]
    found = campbell(rotor_on_springs(3, 5.0), speeds, over="rotor.bearing.w_start")
    np.testing.assert_allclose(found.rotor_speed[:, 0], speeds)
    lines = [line for line in found.lines if np.isfinite(line.frequency).all()]
    assert len(lines) == 5  # two of the hub, two whirls of the blades, and the blades together
    for k, speed in enumerate(speeds):
        roots = textbook(3, speed)
        for line in lines:
            size, ratio = 2 * np.pi * line.frequency[k], line.damping_ratio[k]
            root = size * (-ratio + 1j * np.sqrt(1 - ratio**2))
            if "collective" not in line.name:
                assert np.abs(roots - root).min() < 1e-6 * size, line.name
    (grown,) = found.unstable
    assert grown[1] == 9.0 and textbook(3, 9.0).real.max() > 0 > textbook(3, 8.0).real.max()
    assert min(np.nanmin(line.likeness) for line in lines) > 0.5


def test_two_blades_are_refused_by_name():
    plant = rotor_on_springs(2, 2.0).compile()
    with pytest.raises(SimulationError, match=r"rotor\.blade_1, rotor\.blade_2 turn and bend: a rotor of two blades"):
        natural_modes(plant, mean_state(plant))


@pytest.mark.parametrize("count", [3, 4, 5, 6])
def test_the_coordinates_of_a_ring(count):
    """Their inverse, their derivative by the azimuth, and that what stands still in them turns with the ring."""
    T, slope = multiblade_matrix(count, 0.7)
    ahead, behind = (multiblade_matrix(count, 0.7 + sign * 1e-6)[0] for sign in (1, -1))
    np.testing.assert_allclose(multiblade_inverse(count, 0.7) @ T, np.eye(count), atol=1e-14)
    np.testing.assert_allclose(slope, (ahead - behind) / 2e-6, atol=1e-9)
    next_place = multiblade_matrix(count, 0.7 + 2 * np.pi / count)[0]
    names = multiblade_names(count)
    whirling = [k for k, name in enumerate(names) if name != "differential"]
    np.testing.assert_allclose(next_place[:-1, whirling], T[1:, whirling], atol=1e-14)
    assert len(set(names)) == count


@pytest.fixture(scope="module")
def turbine():
    """A land turbine in steady wind with shear, two hinges in a blade, its mean, and modes and harmonics there."""
    given = {"wind.kind": "steady", "wind.mean_speed": 14.0, "turbine.assembly.blade_hinges": 2}
    plant = fw.load("nrel5mw_land", set=given).compile()
    return plant, mean_state(plant)


def test_what_goes_round_in_steady_wind_is_that_of_a_run(turbine):
    """Gravity, shear and the dam of the tower: the moments of one blade, and the passing of three at the tower."""
    plant, state = turbine
    sizes = {"blade_root_flapwise_moment_1": 0.02, "blade_root_edgewise_moment_2": 0.01, "blade_tip_in_plane_1": 0.01,
             "blade_tip_out_of_plane_3": 0.03, "tower_top_fore_aft_displacement": 0.1}  # fmt: skip
    rotating = rotating_linear_model(plant, state, (), list(sizes), turning=True)
    assert rotating.turning[0].of == (0, 1, 2, 3)
    rotation = steady_rotation(plant, state, list(sizes), rotating)
    run = plant.simulate(45.0, 0.025, start=state, solver="fixed")
    late = run.time > 20.0
    azimuth = np.deg2rad(run["azimuth"].values[late])
    expected = np.array([rotation.values([psi]) for psi in azimuth])
    for k, (name, size) in enumerate(sizes.items()):
        values = run[name].values[late]
        assert np.sqrt(rotation.variance[0][:, k].sum()) == pytest.approx(values.std(), rel=size), name
        assert rotation.mean[k] == pytest.approx(values.mean(), abs=0.05 * values.std()), name
        assert np.std(values - expected[:, k]) < 0.15 * values.std(), name


@pytest.mark.parametrize("name", ["1st tower fore-aft", "1st blade edge regressive", "1st blade edge progressive"])
def test_a_mode_of_a_turning_rotor_rings_down_in_a_run_as_it_should(turbine, name):
    """What a small push along the mode adds to a run is the mode, with its frequency and its damping, for 4 s."""
    plant, state = turbine
    mode = next(mode for mode in natural_modes(plant, state) if mode.name.partition(", with ")[0] == name)
    shape = np.array([mode.shape[item.path] for item in plant.dae.states])
    places = np.array([item.unit == "rad" for item in plant.dae.states]) & (np.abs(shape) > 0)
    size = 1e-4 / np.abs(shape[places]).max()
    paths = [item.path for item in plant.dae.states]
    runs = []
    for push in (size, 0.0):
        start = dict(zip(paths, (state.x + push * shape.real).tolist(), strict=True))
        runs.append(plant.simulate(4.0, 0.05, start=start, solver="fixed", step=0.005))
    seen = [path for path in paths if "tower.beam.hinge_1.bending.phi" in path]
    for path in seen:
        amplitude = size * mode.shape[path]
        expected = (amplitude * np.exp(mode.eigenvalue * runs[0].time)).real
        found = runs[0][path].values - runs[1][path].values
        if abs(amplitude) > 0.3 * max(size * abs(mode.shape[other]) for other in seen):
            assert np.std(found - expected) < 0.1 * np.std(expected), path


def read_lin(path):
    """Matrices and descriptions of a .lin file, as the tools of OpenFAST read them: by its headings."""
    lines, matrices, tables, k = path.read_text().splitlines(), {}, {}, 0
    while k < len(lines):
        if lines[k].startswith("Order of"):
            title, k, rows = lines[k].removeprefix("Order of ").rstrip(":"), k + 3, []
            while lines[k].strip():
                number, value, turning, order, text = lines[k].split(None, 4)
                rows.append((int(number), float(value), turning, int(order), text))
                k += 1
            tables[title] = rows
        elif lines[k][:2] in ("A:", "B:", "C:", "D:"):
            n, m = map(int, lines[k][2:].split("x"))
            matrices[lines[k][0]] = np.array([line.split() for line in lines[k + 1 : k + 1 + n]], dtype=float)
            assert matrices[lines[k][0]].shape == (n, m)
        k += 1
    return matrices, tables


def test_linear_models_leave_and_are_read_back(turbine, tmp_path):
    from scipy.io import loadmat

    plant, state = turbine
    linear = fw.mean_linear_model(plant, state, ["wind.mean_speed"], ["rotor_speed", "blade_root_flapwise_moment_1"])
    matrices, tables = read_lin(linear.save(tmp_path / "land.lin"))
    content = loadmat(linear.save(tmp_path / "land.mat"))
    for name in "ABCD":
        np.testing.assert_array_equal(matrices[name], linear.matrices[name])
        np.testing.assert_array_equal(content[name], linear.matrices[name])
    states = tables["continuous states"]
    assert [row[4].rpartition(",")[0] for row in states] == linear.states and {row[2] for row in states} == {"F"}
    assert {row[4].rpartition(", ")[2] for row in states} >= {"rad", "rad/s", "N*m"}
    (row,) = tables["inputs"]
    assert row[1] == 14.0 and row[4] == "wind.mean_speed, m/s"
    (speed, moment) = tables["outputs"]
    assert speed[4] == "rotor_speed, (rpm)" and speed[1] == pytest.approx(state["rotor_speed"])
    assert [str(text.item()) for text in content["state_units"].ravel()][:2] == ["rad", "rad"]
    one = plant.linearize(state, outputs=["rotor_speed"])
    turning = {row[4]: row[2] for row in read_lin(one.save(tmp_path / "one.lin"))[1]["continuous states"]}
    assert turning["turbine.assembly.blade_1.beam.hinge_1.bending.phi_x, rad"] == "T"
    assert turning["tower.beam.hinge_1.bending.phi_x, rad"] == "F"
    text = (tmp_path / "land.lin").read_text()
    assert float(text.partition("Rotor Speed:")[2].split()[0]) == pytest.approx(state["rotor_speed"] * np.pi / 30)


def test_a_linear_model_without_a_place_is_no_lin_file(turbine, tmp_path):
    from fowtlib.language.errors import ModelError
    from fowtlib.solving import LinearModel

    one = LinearModel(*(np.ones((1, 1)) for _ in "ABCD"), ["x"], ["u"], ["y"], {})
    with pytest.raises(ModelError, match="this linear model has no operating point"):
        one.save(tmp_path / "one.lin")
