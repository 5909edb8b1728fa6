"""The axes of the loads of the water: what is linear in the motion and the wave must agree for a hull that leans.

Beside the models stands a linear computation in numpy: mass matrix of the leaning body, coefficients of the database.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import fowtlib as fw
from fowtlib.analysis.harmonics import harmonic_fit
from fowtlib.analysis.rao import linear_rao
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro import (
    AddedMass,
    HydrodynamicDatabase,
    Hydrostatics,
    LinearDamping,
    LinearPotentialFlow,
    Radiation,
    WaveExcitation,
    waterplane_stiffness,
)
from fowtlib.components.mechanics import FreeMotion, RigidBody, WorldTorque

MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
OC3 = str(Path(__file__).parents[2] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc")
DATA = HydrodynamicDatabase.read(OC3)
G, RHO, DEPTH_OF_MASS = 9.80665, 1025.0, 78.0
MASS, INERTIA = RHO * DATA.volume, np.diag([1.2e10, 1.2e10, 1.9e8])
DAMPING = {"translation": (1.0e5, 1.0e5, 1.3e5), "rotation": (0.0, 0.0, 1.3e7)}
CALM = {"wind.kind": "none", "sea.spectrum": "still"}


def body(*loads, sea=None, world=None, torque=(0.0, 0.0, 0.0), **motion):
    """A free spar with loads on its reference point, load_1 and so on, and a steady moment (world)."""
    model = fw.Assembly("spar in water")
    model.world, model.sea = world or World(), sea or Sea()
    model.motion = FreeMotion(**motion)
    model.body = RigidBody(mass=MASS, inertia=INERTIA, r_cm=(0, 0, -DEPTH_OF_MASS))
    model.torque, model.torque_value = WorldTorque(), Constant(value=torque)
    model.connect(model.torque_value.y, model.torque.torque)
    model.connect(model.world.frame, model.motion.frame_a)
    for number, load in enumerate(loads, 1):
        model.add(f"load_{number}", load)
    for part in (model.body.frame_a, model.torque.frame, *(load.frame for load in loads)):
        model.connect(model.motion.frame_b, part)
    return fw.load(model).compile()


def values(result, path):
    return np.asarray(result[path])


def hydrostatics(stiffness=None):
    stiffness = waterplane_stiffness(DATA) if stiffness is None else stiffness
    return Hydrostatics(volume=DATA.volume, centre_of_buoyancy=DATA.centre_of_buoyancy, stiffness=stiffness)


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def body_mass(mass, arm, inertia):
    """Mass matrix (6, 6) about a point from which the centre of mass is `arm` away; `inertia` about that centre."""
    S = skew(arm)
    return np.block([[mass * np.eye(3), -mass * S], [mass * S, inertia - mass * S @ S]])


# --- the mean of heave -----------------------------------------------------------------------------------------------


def oc3_in_waves(height, conditions, period=10.0):
    """Rest in still water and a run in regular waves from there; its last 200 s are 20 waves."""
    model = fw.load("oc3_spar_rigid")
    calm = model.with_parameters({**CALM, **conditions}).compile()
    rest = calm.equilibrium()
    start = dict(zip((state.path for state in calm.dae.states), rest.x.tolist(), strict=True))
    waves = {"sea.spectrum": "regular", "sea.wave_height": height, "sea.wave_period": period, "sea.build_up": 200.0}
    result = model.with_parameters({**CALM, **conditions, **waves}).compile().simulate(600.0, 0.1, start=start)
    return rest, result


@pytest.mark.parametrize("height", [6.0, 9.0])
def test_waves_do_not_move_the_mean_of_heave(height):
    """First-order loads have no mean: with added mass alone leaning it was -0.045 m at 6 m and -0.10 m at 9 m."""
    rest, result = oc3_in_waves(height, {})
    heave = values(result, "heave")[-2000:]
    assert np.ptp(heave) > 0.08 * height
    assert abs(heave.mean() - float(rest["heave"])) < 2e-3


# --- the phase of heave in wind --------------------------------------------------------------------------------------


def test_heave_in_wind_balances_the_vertical_forces_of_the_linear_theory():
    """8 m/s: heave from the vertical row of the linear equations, with surge and pitch of the run. 7 deg off before."""
    wind = {"wind.kind": "steady", "wind.mean_speed": 8.0, "wind.shear_exponent": 0.0}
    rest, result = oc3_in_waves(6.0, wind)
    omega, amplitude = 2 * np.pi / 10.0, 3.0
    surge, heave, pitch = (harmonic_fit(result[name], 0.1, discard=400.0).coefficients[0]
                           for name in ("surge", "heave", "pitch"))  # fmt: skip
    pitch, lean = np.pi / 180 * pitch, np.radians(float(rest["pitch"]))
    assert np.degrees(lean) > 2
    root = fw.load("oc3_spar_rigid").root
    height = np.array([p.r_cm[2] for p in (root.find("platform.hull"), root.find("tower"))])
    mass = np.array([p.mass for p in (root.find("platform.hull"), root.find("tower"))], dtype=float)
    turbine = root.find("turbine")
    mass, height = np.append(mass, turbine.mass), np.append(height, 90.0 + turbine.centre_of_mass[2])
    A, B = (CubicSpline(DATA.omega, M[:, 2, 2])(omega) for M in (DATA.A, DATA.B))
    mooring, place = root.find("platform.mooring"), np.array([rest["surge"], 0.0, rest["heave"]], dtype=float)
    up, down = (mooring.static_load(place + [0, 0, z])[0][2] for z in (0.1, -0.1))
    ahead, behind = (mooring.static_load(place + [x, 0, 0])[0][2] for x in (0.1, -0.1))
    lines, sideways = (down - up) / 0.2, (behind - ahead) / 0.2
    depth = -70.0  # fairleads
    impedance = DATA.C[2, 2] + lines + 1j * omega * (B + 1.3e5) - omega**2 * (mass.sum() + A)
    falling = -np.sin(lean) * pitch  # vertical velocity of a point one metre up the leaning axis
    load = amplitude * DATA.excitation_at([omega], 0.0)[0, 2]
    load += omega**2 * (mass * height).sum() * falling - sideways * (surge + depth * pitch)
    load -= float(rest["thrust"]) * 1e3 * pitch  # the thrust turns with the rotor
    wanted = load / impedance
    assert abs(np.degrees(np.angle(heave / wanted))) < 1.0
    assert abs(heave) == pytest.approx(abs(wanted), rel=0.02)


@pytest.mark.parametrize("heading", [0.0, 90.0, 35.0])
def test_response_of_a_leaning_spar_is_that_of_the_linear_theory(heading):
    """A free spar that a steady moment leans by 5 deg: six motions against a linear computation in the same axes."""
    lean, heading = np.radians(5.0), np.radians(heading)
    restoring = DATA.C[4, 4] - waterplane_stiffness(DATA)[4, 4] + MASS * G * DEPTH_OF_MASS
    torque = restoring * np.sin(lean) + waterplane_stiffness(DATA)[4, 4] * lean
    loads = (LinearPotentialFlow(database=OC3, radiation_order=6), LinearDamping(**DAMPING))
    plant = body(*loads, pitch_start=lean, torque=(0.0, torque, 0.0))
    state = plant.equilibrium(hold={"motion.surge": 0, "motion.sway": 0, "motion.yaw": 0})
    assert float(state["motion.pitch"]) == pytest.approx(lean, rel=1e-3)
    frequency = np.array([0.05, 0.1, 0.15])
    rao = linear_rao(plant, frequency, state=state, heading=heading, outputs=[f"motion.{name}" for name in MOTIONS])
    R = Rotation.from_euler("y", lean).as_matrix()
    M = body_mass(MASS, R @ [0, 0, -DEPTH_OF_MASS], R @ INERTIA @ R.T)
    T = np.eye(6)  # velocities along the vertical and the horizontals, turning about the axes of the hull
    T[3:, 3:] = R.T
    K = waterplane_stiffness(DATA)
    K[3, 5] -= K[3, 3] * np.tan(lean)
    K[3:, 3:] += restoring * np.array([[np.cos(lean), 0, -np.sin(lean)], [0, np.cos(lean), 0], [0, 0, 0]])
    for f, found in zip(frequency, rao.response, strict=True):
        w = 2 * np.pi * f
        A, B = (CubicSpline(DATA.omega, N)(w) for N in (DATA.A, DATA.B))
        B = B + np.diag([*DAMPING["translation"], *DAMPING["rotation"]])
        X = DATA.excitation_at([w], heading)[0]
        load = np.append(X[:3], R @ X[3:])
        # world components of the motion; the steady moment keeps its direction in the world
        wanted = np.linalg.solve(K + 1j * w * T.T @ B @ T - w**2 * (M + T.T @ A @ T), load)
        roll = wanted[3] / np.cos(lean)  # angles yaw, pitch, roll: rates about z, y and the leaning x axis
        wanted = np.array([*wanted[:3], roll, wanted[4], wanted[5] + np.sin(lean) * roll])
        np.testing.assert_allclose(found[:3], wanted[:3], atol=0.01 * np.abs(wanted[:3]).max())
        np.testing.assert_allclose(found[3:], wanted[3:], atol=0.01 * np.abs(wanted[3:]).max())
        assert abs(np.degrees(np.angle(found[2] / wanted[2]))) < 1.0


# --- the yaw of a leaning spar ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("lean", [(0.0, 5.0, 0.0), (4.0, -7.0, 0.0), (3.0, 5.0, 60.0)])
def test_a_leaning_spar_turns_about_its_own_axis_with_its_own_inertia(lean):
    """No inertia of the water against a turn of a round hull about its axis, whose A66 is zero; A44 is 3.8e10."""
    roll, pitch, yaw = np.radians(lean)
    R = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    state = body(AddedMass(matrix=DATA.A_inf), world=World(gravity=1e-9), torque=R @ [0, 0, 1e6],
                 roll_start=roll, pitch_start=pitch, yaw_start=yaw).initial_state()  # fmt: skip
    turning = np.array([[1, 0, -np.sin(pitch)], [0, np.cos(roll), np.sin(roll) * np.cos(pitch)],
                        [0, -np.sin(roll), np.cos(roll) * np.cos(pitch)]])  # fmt: skip
    found = turning @ state["motion.angle_accelerations"].ravel()  # about the axes of the hull
    assert found == pytest.approx([0, 0, 1e6 / (INERTIA[2, 2] + DATA.A_inf[5, 5])], rel=1e-6, abs=1e-9)
    assert np.abs(state["motion.acceleration"]).max() < 1e-9


# --- a hull that has yawed -------------------------------------------------------------------------------------------


def turned_state(load, yaw, pitch=0.12, roll=-0.07, **motion):
    """Force and moment of a load on a body whose motion has turned about the vertical by `yaw`."""
    turn = Rotation.from_euler("z", yaw).as_matrix()
    v, rates = turn @ [0.8, -0.3, 0.4], np.array([0.02, -0.03, 0.05])
    state = body(load, velocity_start=v, angle_rates_start=rates, roll_start=roll, pitch_start=pitch,
                     yaw_start=yaw, heave_start=0.6).initial_state()  # fmt: skip
    return np.concatenate([turn.T @ state["load_1.frame.f"].ravel(), turn.T @ state["load_1.frame.t"].ravel()])


def barge_stiffness():
    C = np.diag([0.0, 0.0, 4e5, 2e8, 9e8, 0.0])
    C[2, 4] = C[4, 2] = -3e6
    C[3, 4] = C[4, 3] = 5e7
    return C


def test_loads_of_a_hull_that_is_not_round_turn_with_its_yaw():
    rng = np.random.default_rng(3)
    matrix = rng.normal(size=(6, 6))
    for make in (lambda: hydrostatics(stiffness=barge_stiffness()), lambda: LinearDamping(matrix=matrix @ matrix.T)):
        straight = turned_state(make(), 0.0)
        for yaw in (0.7, -2.0):
            np.testing.assert_allclose(turned_state(make(), yaw), straight, rtol=1e-9, atol=1e-9 * abs(straight).max())


def test_hydrostatics_have_no_moment_about_the_vertical():
    moment = turned_state(hydrostatics(stiffness=barge_stiffness()), 0.7)
    assert abs(moment[5]) < 1e-9 * np.abs(moment).max()


def test_waves_on_a_round_hull_do_not_know_its_yaw():
    sea = {"spectrum": "regular", "wave_height": 4.0, "wave_period": 9.0, "heading": 0.5}
    loads = []
    for yaw in (0.0, 0.8):
        state = body(WaveExcitation(database=OC3), sea=Sea(**sea), yaw_start=yaw).initial_state()
        loads.append(np.concatenate([state["load_1.frame.f"].ravel(), state["load_1.frame.t"].ravel()]))
    np.testing.assert_allclose(loads[1], loads[0], atol=1e-9 * np.abs(loads[0]).max())


# --- energy ----------------------------------------------------------------------------------------------------------


def energy(result, mass, inertia, arm, added):
    """Kinetic energy of body and water over time, in the axes of the loads; for motion without yaw."""
    R, v, w = values(result, "body.frame_a.R"), values(result, "motion.velocity"), values(result, "body.frame_a.w")
    hull = np.einsum("tji,tj->ti", R, w)
    at_mass = v + np.cross(w, np.einsum("tij,j->ti", R, arm))
    own = np.hstack([v, hull])
    return (0.5 * mass * np.sum(at_mass**2, axis=1) + 0.5 * np.einsum("ti,ij,tj->t", hull, inertia, hull)
            + 0.5 * np.einsum("ti,ij,tj->t", own, added, own))  # fmt: skip


def test_added_mass_keeps_the_energy_of_a_tumbling_spar():
    """Surge, heave and pitch through a large angle without gravity. In axes of the hull it grew or shrank."""
    plant = body(AddedMass(matrix=DATA.A_inf), world=World(gravity=1e-9), velocity_start=(1.0, 0, -0.5),
                         angle_rates_start=(0, 0.01, 0))  # fmt: skip
    result = plant.simulate(100.0, output_step=1.0, tolerance=1e-9)
    kinetic = energy(result, MASS, INERTIA, np.array([0, 0, -DEPTH_OF_MASS]), DATA.A_inf)
    assert np.ptp(values(result, "motion.pitch")) > 0.5
    np.testing.assert_allclose(kinetic, kinetic[0], rtol=1e-5)


def test_radiation_of_a_leaning_spar_never_gives_energy():
    plant = body(hydrostatics(), AddedMass(matrix=DATA.A_inf), Radiation(database=OC3), pitch_start=0.25,
                         roll_start=-0.1, heave_start=4.0, velocity_start=(2.0, 1.0, 0))  # fmt: skip
    result = plant.simulate(200.0, output_step=0.05, tolerance=1e-8)
    f, t = values(result, "load_3.frame.f"), values(result, "load_3.frame.t")
    v, w = values(result, "motion.velocity"), values(result, "body.frame_a.w")
    power = -np.sum(f * v, axis=1) - np.sum(t * w, axis=1)
    work = np.cumsum(0.5 * (power[1:] + power[:-1])) * 0.05
    assert work.max() < 1e-4 * -work.min()
    own = np.hstack([values(result, "load_3.force"), values(result, "load_3.moment")])
    assert -work[-1] > 0 and np.abs(own).max() > 0
