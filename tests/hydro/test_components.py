"""Loads of the water in simulated models, against formulas and the coefficients they are made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro import (
    AddedMass,
    HydrodynamicDatabase,
    Hydrostatics,
    LinearDamping,
    LinearPotentialFlow,
    MorisonDrag,
    Radiation,
    WaveExcitation,
    retardation_kernel,
    waterplane_stiffness,
)
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.morison import member_quadrature
from fowtlib.components.mechanics import FreeMotion, RigidBody, WorldForce, WorldTorque
from fowtlib.language.errors import ParameterError

OC3 = str(Path(__file__).parents[2] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc")
DATA = HydrodynamicDatabase.read(OC3)
G, RHO = 9.80665, 1025.0
MASS = RHO * DATA.volume  # floats at rest without moorings
INERTIA = np.diag([1.2e10, 1.2e10, 1.9e8])
SPAR = {"points": [(0, 0, -120), (0, 0, -12), (0, 0, -4), (0, 0, 10)], "diameters": (9.4, 9.4, 6.5, 6.5)}


def body(*loads, mass=MASS, inertia=INERTIA, r_cm=(0, 0, -78.0), sea=None, world=None, **motion):
    """A free body in the water with loads on its reference point; the loads are named load_1, load_2, ..."""
    model = fw.Assembly("body in water")
    model.world = world or World()
    model.sea = sea or Sea()
    model.motion = FreeMotion(**motion)
    model.body = RigidBody(mass=mass, inertia=inertia, r_cm=r_cm)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    for number, load in enumerate(loads, 1):
        model.add(f"load_{number}", load)
        model.connect(model.motion.frame_b, load.frame)
    return model


def compiled(*loads, **options):
    return fw.load(body(*loads, **options)).compile()


def at_start(*loads, **options):
    """The state at t = 0."""
    return compiled(*loads, **options).initial_state()


def values(result, path):
    return np.asarray(result[path])


def hydrostatics(**changes):
    given = {"volume": DATA.volume, "centre_of_buoyancy": DATA.centre_of_buoyancy, "reference_density": DATA.rho}
    return Hydrostatics(**{**given, "stiffness": waterplane_stiffness(DATA), **changes})


def with_push(model, force=(0.0, 0.0, 0.0), torque=(0.0, 0.0, 0.0)):
    """The body pushed by a constant force and moment at its reference point."""
    model.force, model.force_value = WorldForce(), Constant(value=force)
    model.torque, model.torque_value = WorldTorque(), Constant(value=torque)
    model.connect(model.force_value.y, model.force.force)
    model.connect(model.torque_value.y, model.torque.torque)
    model.connect(model.motion.frame_b, model.force.frame)
    model.connect(model.motion.frame_b, model.torque.frame)
    return model


# --- hydrostatics and added mass -------------------------------------------------------------------------------------


def test_heave_period_of_a_free_body():
    result = compiled(hydrostatics(), AddedMass(matrix=DATA.A_inf), heave_start=1.0).simulate(100.0, output_step=0.05)
    time, heave = np.asarray(result["motion.heave"].time), values(result, "motion.heave")
    period = 2 * np.pi * np.sqrt((MASS + DATA.A_inf[2, 2]) / DATA.C[2, 2])
    np.testing.assert_allclose(heave, np.cos(2 * np.pi * time / period), atol=1e-3)


def test_static_heave_of_an_extra_weight():
    extra = 20_000.0
    plant = compiled(hydrostatics(), LinearDamping(translation=(1e5,) * 3, rotation=(1e8,) * 3), mass=MASS + extra)
    state = plant.equilibrium(hold={"motion.surge": 0, "motion.sway": 0, "motion.yaw": 0})
    assert state["motion.heave"] == pytest.approx(-extra * G / DATA.C[2, 2], rel=1e-6)


def test_static_pitch_follows_the_metacentric_formula():
    torque = 1.0e8
    model = with_push(body(hydrostatics()), torque=(0.0, torque, 0.0))
    state = fw.load(model).compile().equilibrium(hold={"motion.surge": 0, "motion.sway": 0, "motion.yaw": 0})
    stiffness = DATA.C[4, 4] + MASS * G * 78.0  # of the file, plus the weight
    assert state["motion.pitch"] == pytest.approx(torque / stiffness, rel=0.01)
    assert np.degrees(state["motion.pitch"]) > 4


def test_stiffness_of_the_file_is_recovered_by_small_displacements():
    C = DATA.C.copy()
    C[3, 5], C[4, 5] = -3.0e8, 2.0e8  # moments of a buoyancy off the axis
    centre = (3.0e8 / (RHO * G * DATA.volume), -2.0e8 / (RHO * G * DATA.volume), DATA.centre_of_buoyancy[2])
    fields = {name: getattr(DATA, name) for name in HydrodynamicDatabase.__dataclass_fields__}
    other = HydrodynamicDatabase(**{**fields, "C": C, "centre_of_buoyancy": centre})
    load = Hydrostatics(volume=other.volume, centre_of_buoyancy=centre, stiffness=waterplane_stiffness(other))
    plant, small = compiled(load), 1e-6

    def loads(**motion):
        state = plant.initial_state(start={f"motion.{name}": value for name, value in motion.items()})
        return -np.concatenate([state["load_1.frame.f"].ravel(), state["load_1.frame.t"].ravel()])

    found = [-(loads(**{name: small}) - loads(**{name: -small})) / (2 * small)
             for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")]  # fmt: skip
    np.testing.assert_allclose(np.array(found).T, C, atol=1e-6 * np.abs(C).max())


def test_a_tilt_means_the_same_for_a_body_that_has_yawed():
    tilt, turn = Rotation.from_euler("y", 8, degrees=True), Rotation.from_euler("z", 35, degrees=True)
    loads = []
    for attitude in (tilt, tilt * turn):
        yaw, pitch, roll = attitude.as_euler("ZYX")
        state = at_start(hydrostatics(), roll_start=roll, pitch_start=pitch, yaw_start=yaw)
        loads.append(state["load_1.frame.t"].ravel())
    np.testing.assert_allclose(loads[1], loads[0], atol=1e-9 * np.abs(loads[0]).max())


def test_added_mass_resists_acceleration():
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = np.diag([3.0, 4.0, 5.0])
    matrix[4, 4], matrix[0, 4], matrix[4, 0] = 20.0, 2.0, 2.0
    model = body(AddedMass(matrix=matrix), mass=2.0, inertia=np.eye(3), r_cm=(0, 0, 0), world=World(gravity=1e-9))
    state = fw.load(with_push(model, (10.0, 12.0, 7.0), (0.0, 3.0, 0.0))).compile().initial_state()
    wanted = np.linalg.solve([[5.0, 2.0], [2.0, 21.0]], [10.0, 3.0])
    assert state["motion.acceleration"].ravel() == pytest.approx([wanted[0], 2.0, 1.0])
    assert state["motion.angle_accelerations"].ravel() == pytest.approx([0.0, wanted[1], 0.0])


def test_loads_scale_with_the_density_of_the_water():
    light = World(water_density=1000.0)
    state = at_start(hydrostatics(), LinearDamping(), heave_start=-1.0, world=light)
    wanted = 1000 / 1025 * (MASS * G + DATA.C[2, 2])
    assert -state["load_1.frame.f"].ravel()[2] == pytest.approx(wanted, rel=1e-9)


def test_linear_damping():
    matrix = np.zeros((6, 6))
    matrix[0, 4] = 5.0
    load = LinearDamping(translation=(1, 2, 3), rotation=(4, 5, 6), matrix=matrix)
    state = at_start(load, velocity_start=(1.0, 10.0, 100.0), angle_rates_start=(0.1, 0.2, 0.3))
    assert state["load_1.frame.f"].ravel() == pytest.approx([1.0 + 5.0 * 0.2, 20.0, 300.0])
    assert state["load_1.frame.t"].ravel() == pytest.approx([0.4, 1.0, 1.8])


def whole_load(result, part):
    """Force and moment of a load, (n, 6)."""
    return np.hstack([values(result, f"{part}.force"), values(result, f"{part}.moment")])


# --- radiation -------------------------------------------------------------------------------------------------------


def test_radiation_load_is_the_convolution_with_the_kernel():
    radiation = Radiation(database=OC3, order=6)
    plant = compiled(hydrostatics(), AddedMass(matrix=DATA.A_inf), radiation, velocity_start=(0.5, 0, 0),
                     heave_start=2.0, pitch_start=0.1)  # fmt: skip
    result = plant.simulate(60.0, output_step=0.05, tolerance=1e-8)
    time, load = np.asarray(result["motion.heave"].time), whole_load(result, "load_3")
    turning = np.einsum("tij,ti->tj", values(result, "body.frame_a.R"), values(result, "body.frame_a.w"))
    velocity = np.hstack([values(result, "motion.velocity"), turning])  # turning about the axes of the hull; no yaw
    own = convolution(radiation.model().kernel(time), velocity, time[1])
    exact = convolution(retardation_kernel(DATA.omega, DATA.B, time), velocity, time[1])
    assert not load[0].any()
    for i in (0, 2, 4):
        largest = np.abs(load[:, i]).max()
        np.testing.assert_allclose(load[::100, i], own[:, i], atol=2e-3 * largest)
        np.testing.assert_allclose(load[::100, i], exact[:, i], atol=0.05 * largest)


def convolution(kernel, velocity, step):
    """Load at every hundredth sample, by the trapezoidal rule."""
    loads = []
    for k in range(0, len(velocity), 100):
        weight = np.where(np.isin(np.arange(k + 1), (0, k)), 0.5, 1.0) * (k > 0)
        loads.append(-step * np.einsum("tij,tj,t->i", kernel[k::-1], velocity[: k + 1], weight))
    return np.array(loads)


def test_radiation_takes_energy_out():
    still = compiled(hydrostatics(), AddedMass(matrix=DATA.A_inf), Radiation(database=OC3), heave_start=3.0)
    result = still.simulate(300.0, output_step=0.5)
    heave = values(result, "motion.heave")
    assert np.abs(heave[-70:]).max() < np.abs(heave[:70]).max()
    power = np.sum(whole_load(result, "load_3")[:, 2] * values(result, "motion.velocity")[:, 2]) * 0.5
    assert power < 0


def test_radiation_reports_its_fit():
    radiation = Radiation(database=OC3, order=2)
    assert radiation.model().states == 10
    assert "K11: R2 0.99" in str(radiation.model())


# --- waves -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading", [0.0, np.radians(37.0)])
def test_excitation_in_a_regular_wave_has_the_amplitude_and_phase_of_X(heading):
    period, height = 10.0, 3.0
    sea = Sea(spectrum="regular", wave_height=height, wave_period=period, heading=heading)
    result = compiled(WaveExcitation(database=OC3), hydrostatics(), sea=sea).simulate(20.0, output_step=0.1)
    time, load = np.asarray(result["motion.heave"].time), whole_load(result, "load_1")
    omega = 2 * np.pi / period
    X = DATA.excitation_at([omega], heading)[0]
    wanted = height / 2 * (np.exp(1j * omega * time)[:, None] * X).real
    np.testing.assert_allclose(load, wanted, atol=1e-6 * np.abs(wanted).max())
    np.testing.assert_allclose(-values(result, "load_1.frame.f"), load[:, :3], atol=1.0)
    size = np.hypot(load[:, 0], load[:, 1]).max()
    assert np.abs(load[:, 0]).max() == pytest.approx(size * np.cos(heading), rel=0.01)  # a round hull


def test_a_platform_down_the_waves_feels_them_later():
    period, distance = 12.0, 300.0
    sea = Sea(spectrum="regular", wave_height=2.0, wave_period=period)
    loads = [WaveExcitation(database=OC3), WaveExcitation(database=OC3, position=(distance, 0, 0))]
    result = compiled(*loads, sea=sea).simulate(40.0, output_step=0.1)
    delay = sea.components().wave_number[0] * distance / (2 * np.pi / period)
    time = np.asarray(result["motion.heave"].time)
    first, second = whole_load(result, "load_1")[:, 0], whole_load(result, "load_2")[:, 0]
    late = time > delay
    np.testing.assert_allclose(np.interp(time[late] - delay, time, first), second[late], atol=0.005 * first.max())


def test_excitation_in_irregular_waves_has_the_spectrum_of_X():
    sea = Sea(spectrum="jonswap", significant_wave_height=4.0, peak_period=10.0, repetition_period=512.0)
    result = compiled(WaveExcitation(database=OC3), hydrostatics(), sea=sea).simulate(512.0, output_step=0.5)
    waves, load = sea.components(), whole_load(result, "load_1")[:-1]
    X = DATA.excitation_at(waves.omega, 0.0)
    for i in (0, 2, 4):
        variance = np.sum(np.abs(waves.amplitude * X[:, i]) ** 2) / 2
        assert load[:, i].var() == pytest.approx(variance, rel=2e-3)


def test_a_long_wave_lifts_the_body_with_the_water():
    period = 200.0
    omega = 2 * np.pi / period
    sea = Sea(spectrum="regular", wave_height=2.0, wave_period=period, build_up=600.0)
    water = LinearPotentialFlow(database=OC3, radiation_order=2)
    damping = LinearDamping(translation=(1e5, 1e5, 1.3e5), rotation=(1e9, 1e9, 1e7))
    result = compiled(water, damping, sea=sea).simulate(1400.0, output_step=2.0)
    heave = values(result, "motion.heave")[-100:]
    inertia = omega**2 * (MASS + DATA.A_inf[2, 2])
    expected = abs(DATA.excitation_at([omega], 0.0)[0, 2]) / abs(DATA.C[2, 2] - inertia + 1j * omega * 1.3e5)
    amplitude = (heave.max() - heave.min()) / 2
    assert amplitude == pytest.approx(expected, rel=0.01)
    assert amplitude == pytest.approx(1.0, abs=0.04)


# --- drag ------------------------------------------------------------------------------------------------------------


def cylinder(**changes):
    given = {"points": [(0, 0, -100), (0, 0, 0)], "diameters": (8.0, 8.0), "drag_coefficient": 0.7, **changes}
    return MorisonDrag(**given)


def test_drag_of_a_cylinder_that_moves_and_turns():
    moving = at_start(cylinder(), velocity_start=(1.5, -2.0, 0.7))
    speed = np.hypot(1.5, 2.0)
    whole = RHO / 2 * 0.7 * 8.0 * 100.0 * speed
    assert moving["load_1.force"].ravel() == pytest.approx([-whole * 1.5, whole * 2.0, 0.0], rel=1e-5, abs=1.0)
    assert moving["load_1.moment"].ravel() == pytest.approx([whole * 2.0 * 50, whole * 1.5 * 50, 0.0], rel=1e-5, abs=10)

    w = 0.02
    turning = at_start(cylinder(), angle_rates_start=(0.0, w, 0.0))  # velocity w z along x
    unit = RHO / 2 * 0.7 * 8.0 * w**2
    assert turning["load_1.force"].ravel()[0] == pytest.approx(unit * 100**3 / 3, rel=1e-5)
    assert turning["load_1.moment"].ravel()[1] == pytest.approx(-unit * 100**4 / 4, rel=1e-5)


def test_drag_on_a_tapered_member_uses_the_local_diameter():
    state = at_start(cylinder(points=[(0, 0, -20), (0, 0, 0)], diameters=(12.0, 6.0)), velocity_start=(1.0, 0, 0))
    assert state["load_1.force"].ravel()[0] == pytest.approx(-RHO / 2 * 0.7 * 9.0 * 20.0, rel=1e-5)
    assert state["load_1.moment"].ravel()[1] == pytest.approx(RHO / 2 * 0.7 * 20.0 * 20.0 * (6 / 2 + 6 / 3), rel=1e-5)


def test_drag_across_an_inclined_member_and_along_a_heave_plate():
    axis = np.array([3.0, 0.0, -4.0]) / 5
    member = cylinder(points=[(0, 0, -10), 25 * axis - [0, 0, 10]], end_drag=(0, 2.0))
    v = np.array([1.0, 0.5, 0.0])
    along = v @ axis
    across = v - along * axis
    plate = -RHO / 2 * 2.0 * np.pi / 4 * 64 * abs(along) * along * axis
    wanted = -RHO / 2 * 0.7 * 8.0 * 25 * np.linalg.norm(across) * across + plate
    state = at_start(member, velocity_start=v)
    assert state["load_1.force"].ravel() == pytest.approx(wanted, rel=1e-5)


def test_drag_turns_with_the_body():
    """The same motion relative to the body gives the same load in the axes of the body."""
    v, w = np.array([0.8, -0.3, 0.4]), np.array([0.01, -0.02, 0.03])
    member = {"points": [(0, 0, -60), (20, 5, -80)], "diameters": (5.0, 9.0), "end_drag": (1.0, 1.5)}
    upright = at_start(cylinder(**member), velocity_start=v, angle_rates_start=w)
    R = Rotation.from_euler("ZYX", [0.6, -0.2, 0.3])
    rates = np.linalg.solve(rate_matrix(-0.2, 0.6), R.apply(w))
    turned = at_start(cylinder(**member), velocity_start=R.apply(v), angle_rates_start=rates,
                      roll_start=0.3, pitch_start=-0.2, yaw_start=0.6)  # fmt: skip
    for name in ("force", "moment"):
        assert R.inv().apply(turned[f"load_1.{name}"].ravel()) == pytest.approx(upright[f"load_1.{name}"].ravel())


def rate_matrix(pitch, yaw):
    """Angular velocity (world) from the rates of roll, pitch, yaw."""
    cp, sp, cy, sy = np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    return np.array([[cy * cp, -sy, 0], [sy * cp, cy, 0], [-sp, 0, 1]])


def test_drag_of_waves_on_a_body_at_rest():
    period, height = 8.0, 4.0
    sea = Sea(spectrum="regular", wave_height=height, wave_period=period)
    state = at_start(MorisonDrag(**SPAR, drag_coefficient=0.6, slices=30), sea=sea)
    z = np.linspace(-120, 0, 24001)
    k = sea.components().wave_number[0]
    u = height / 2 * 2 * np.pi / period * np.cosh(k * (z + 320)) / np.sinh(k * 320)  # a crest at t = 0
    slices = RHO / 2 * 0.6 * np.interp(z, [-120, -12, -4, 0], [9.4, 9.4, 6.5, 6.5]) * u**2
    assert state["load_1.force"].ravel()[0] == pytest.approx(np.trapezoid(slices, z), rel=1e-4)
    assert state["load_1.moment"].ravel()[1] == pytest.approx(np.trapezoid(slices * z, z), rel=1e-4)


def test_twelve_slices_are_enough_for_the_spar():
    sea = Sea(spectrum="jonswap", significant_wave_height=6.0, peak_period=10.0, repetition_period=256.0)
    few = MorisonDrag(**SPAR, drag_coefficient=0.6)
    many = MorisonDrag(**SPAR, drag_coefficient=0.6, slices=60)
    result = compiled(few, many, hydrostatics(), sea=sea, velocity_start=(0.5, 0, 0)).simulate(100.0, output_step=0.5)
    for name in ("force", "moment"):
        coarse, fine = values(result, f"load_1.{name}"), values(result, f"load_2.{name}")
        assert np.std(coarse - fine) < 1e-3 * np.std(fine)


def test_quadrature_covers_the_wet_part_exactly():
    wet = member_quadrature([(0, 0, -30), (0, 0, -10), (0, 0, 20)], 9, height=-5.0)
    assert wet.lengths.sum() == pytest.approx(20 + 15)
    assert wet.places[:, 2].max() < 5.0
    np.testing.assert_allclose(wet.weights.sum(axis=1), 1.0)
    np.testing.assert_array_equal(wet.places[wet.ends.any(axis=1)], [[0, 0, -30]])  # the other end is dry


def test_a_member_above_the_water_is_a_mistake():
    with pytest.raises(ParameterError, match="load_1.points: the member lies above the still water level"):
        at_start(cylinder(points=[(0, 0, 1), (0, 0, 20)]))


# --- the composite ---------------------------------------------------------------------------------------------------


def test_potential_flow_floats_and_needs_no_waves():
    water = LinearPotentialFlow(database=OC3, excitation=False, radiation_order=0)
    assert set(water.parts) == {"hydrostatics", "added_mass"}
    state = at_start(water)
    assert np.abs(state["motion.acceleration"]).max() < 1e-6


def test_potential_flow_of_another_depth_or_gravity_is_refused():
    with pytest.raises(ParameterError, match=r"world.water_depth is 50 m, and load_1.database was computed for 320 m"):
        compiled(LinearPotentialFlow(database=OC3), world=World(water_depth=50.0))
    with pytest.raises(ParameterError, match=r"world.gravity is 9.6 m/s\^2"):
        compiled(LinearPotentialFlow(database=OC3), world=World(gravity=9.6))


def test_a_missing_database_is_named():
    with pytest.raises(HydrodynamicDataError, match="nowhere.nc: cannot be read: No such file"):
        LinearPotentialFlow(database="nowhere.nc")


@pytest.mark.parametrize(("path", "degrees", "told"), [("pitch", 80, True), ("roll", -60, True), ("pitch", 30, False)])
def test_a_hull_that_lies_on_its_side_is_warned_of(path, degrees, told, recwarn):
    import fowtlib as fw

    plant = fw.load("oc3_spar_rigid").compile()
    plant.simulate(0.1, 0.1, start={f"platform.motion.{path}": f"{degrees} deg"})
    assert any("tilted by more than 45 deg" in str(item.message) for item in recwarn) == told
