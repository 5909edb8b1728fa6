"""Conventions of the mechanical parts: angles, signs of loads, axes of sensors. Mechanisms are in tests/kernel."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fowtlib as fw
from fowtlib.components.blocks import Constant, Sine
from fowtlib.components.mechanics import (
    AccelerationSensor,
    AngleSensor,
    AttitudeSensor,
    Fixed,
    FixedFlange,
    FixedRotation,
    FixedTranslation,
    FreeMotion,
    Inertia,
    LoadSensor,
    PointMass,
    PositionSensor,
    Prismatic,
    RelativeSensor,
    Revolute,
    RigidBody,
    SpeedSensor,
    SpeedSource,
    SpringDamper,
    TorqueSensor,
    TorqueSource,
    TorsionSpringDamper,
    VelocitySensor,
    World,
    WorldForce,
    WorldTorque,
)
from fowtlib.components.mechanics.rotations import axis_rotation, perpendicular_axes
from fowtlib.language.errors import ModelError, ParameterError

G = 9.80665
INERTIA = np.array([[2.0, 0.1, 0.0], [0.1, 3.0, -0.2], [0.0, -0.2, 2.5]])


def simulate(model, t_end=2.0, output_step=0.02, tolerance=1e-9):
    return fw.load(model).compile().simulate(t_end, output_step=output_step, tolerance=tolerance)


def values(result, path):
    return np.asarray(result[path])


def rotations(result, frame):
    """R of a frame at every output point, (n, 3, 3)."""
    return values(result, f"{frame}.R")


def chain(model, *parts):
    """Connect frame_b of each part to frame_a of the next."""
    for a, b in zip(parts, parts[1:], strict=False):
        model.connect(a.frame if "frame" in a.ports else a.frame_b, b.frame_a)


def floating(gravity=0.0, **motion):
    model = fw.Assembly("floating body")
    model.world = World(gravity=gravity)
    model.motion = FreeMotion(**motion)
    model.body = RigidBody(mass=4.0, inertia=INERTIA)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    return model


# --- joints and frames ----------------------------------------------------------------------------------------------


def test_free_motion_turns_by_yaw_then_pitch_then_roll():
    roll, pitch, yaw = 0.3, -0.5, 1.1
    start = {"roll_start": roll, "pitch_start": pitch, "yaw_start": yaw, "surge_start": 3.0, "heave_start": -2.0}
    result = simulate(floating(**start), 0.1)
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    assert np.allclose(rotations(result, "body.frame_a")[0], expected)
    assert np.allclose(values(result, "body.frame_a.r")[0], [3.0, 0.0, -2.0])


def test_free_motion_has_the_angular_velocity_of_its_rates():
    angles, rates, h = np.array([1.1, -0.5, 0.3]), np.array([-0.2, 0.7, 0.4]), 1e-6  # yaw, pitch, roll
    roll_first = {"roll_start": 0.3, "pitch_start": -0.5, "yaw_start": 1.1, "angle_rates_start": (0.4, 0.7, -0.2)}
    result = simulate(floating(**roll_first), 0.1)
    before, after = (Rotation.from_euler("ZYX", angles + s * h * rates) for s in (-1, 1))
    w = (after * before.inv()).as_rotvec() / (2 * h)
    assert np.allclose(values(result, "body.frame_a.w")[0], w, atol=1e-7)


def test_free_motion_is_seen_from_frame_a():
    """On a carrier that is turned and moved, surge is along the carrier's x axis."""
    model = fw.Assembly("turned carrier")
    model.world = World(gravity=0.0)
    model.base = Fixed(r=(1, 2, 3), angles=(0.1, 0.2, 0.3))
    model.motion = FreeMotion(surge_start=2.0, velocity_start=(0.5, 0, 0))
    model.body = RigidBody(mass=1.0, inertia=np.eye(3))
    chain(model, model.base, model.motion)
    model.connect(model.motion.frame_b, model.body.frame_a)
    result = simulate(model, 1.0)
    R = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1]).as_matrix()
    assert np.allclose(rotations(result, "base.frame")[0], R)
    time = np.asarray(result["motion.surge"].time)
    path = np.array([1, 2, 3]) + np.outer(2.0 + 0.5 * time, R[:, 0])
    assert np.allclose(values(result, "body.frame_a.r"), path, atol=1e-8)


def test_free_motion_stops_near_its_singular_pitch():
    model = floating(angle_rates_start=(0.0, 1.0, 0.0))
    model.body.inertia = np.eye(3)
    with pytest.raises(ModelError, match=r"pitch is within about 1 deg of \+-90 deg"):
        simulate(model, 3.0, output_step=0.005)


def test_a_free_body_falls():
    result = simulate(floating(gravity=G, velocity_start=(1.0, 0.5, 2.0)), 1.5)
    time = np.asarray(result["motion.heave"].time)
    assert np.allclose(values(result, "motion.heave"), 2.0 * time - G * time**2 / 2, atol=1e-7)
    assert np.allclose(values(result, "motion.surge"), time, atol=1e-8)


def test_revolute_turns_forward_about_its_axis():
    model = fw.Assembly("hinge")
    model.world = World(gravity=0.0)
    model.hinge = Revolute(n=(0, 0, 3), phi_start=np.pi / 2, w_start=2.0)
    model.arm = FixedTranslation(r=(2, 0, 0))
    model.mass = PointMass(mass=1.0)
    chain(model, model.world, model.hinge, model.arm, model.mass)
    result = simulate(model, 0.5)
    assert np.allclose(values(result, "arm.frame_b.r")[0], [0, 2, 0], atol=1e-12)
    assert np.allclose(values(result, "arm.frame_b.w")[0], [0, 0, 2.0])
    assert np.allclose(values(result, "mass.v")[0], [-4.0, 0, 0])


def test_prismatic_slides_under_its_weight_and_drive():
    model = fw.Assembly("slide")
    slope, mass = 0.4, 3.0
    model.world = World()
    model.ramp = FixedRotation(n=(0, 1, 0), angle=slope, r=(0, 0, 5))  # nose down: x of the ramp points downhill
    model.slide = Prismatic(n=(1, 0, 0), v_start=-1.0)
    model.body = RigidBody(mass=mass, inertia=INERTIA, r_cm=(0.1, 0.2, 0.3))
    model.push = Constant(value=4.0)
    chain(model, model.world, model.ramp, model.slide, model.body)
    model.connect(model.push.y, model.slide.force)
    result = simulate(model)
    time = np.asarray(result["slide.s"].time)
    acceleration = G * np.sin(slope) + 4.0 / mass
    assert np.allclose(values(result, "slide.s"), -time + acceleration * time**2 / 2, atol=1e-7)


def test_fixed_rotation_turns_and_moves():
    model = fw.Assembly("bracket")
    model.world = World()
    model.bracket = FixedRotation(n=(0, 1, 0), angle=np.pi / 2, r=(1, 0, 0))
    model.arm = FixedTranslation(r=(0, 0, 2))
    model.body = RigidBody(mass=2.0, inertia=INERTIA)
    chain(model, model.world, model.bracket, model.arm, model.body)
    result = simulate(model, 0.1)
    assert np.allclose(values(result, "body.frame_a.r")[0], [3, 0, 0])  # z of the bracket is x of the world
    # the ground carries the weight, and its moment about the origin
    assert np.allclose(values(result, "bracket.frame_a.f")[0], [0, 0, 2 * G])
    assert np.allclose(values(result, "bracket.frame_a.t")[0], [0, -3 * 2 * G, 0])


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (1, -2, 0.5)])
def test_rotation_matrices(axis):
    n = np.array(axis) / np.linalg.norm(axis)
    assert np.allclose(np.array(axis_rotation(axis, 0.7), dtype=float), Rotation.from_rotvec(0.7 * n).as_matrix())
    e, f = perpendicular_axes(axis)
    assert np.allclose(np.cross(e, f), n) and abs(e @ f) < 1e-15


def test_an_axis_of_no_length_is_refused():
    model = fw.Assembly("hinge")
    model.world, model.hinge, model.mass = World(), Revolute(n=(0, 0, 0)), PointMass(mass=1.0)
    chain(model, model.world, model.hinge, model.mass)
    with pytest.raises(ParameterError, match=r"the axis n is \(0, 0, 0\)"):
        fw.load(model).compile()


# --- bodies and loads -----------------------------------------------------------------------------------------------


def test_rigid_body_off_its_frame_equals_a_body_at_its_centre():
    """A tumbling body described from two of its points: the same motion of the centre of mass."""
    at_centre = floating(angle_rates_start=(0.4, 0.2, 1.0), velocity_start=(1, 0, 0))
    arm = np.array([0.3, -0.2, 0.5])
    rates = np.array([0.4, 0.2, 1.0])  # equals w at zero angles
    off = fw.Assembly("body off its frame")
    off.world = World(gravity=0.0)
    off.motion = FreeMotion(
        surge_start=-arm[0],
        sway_start=-arm[1],
        heave_start=-arm[2],
        angle_rates_start=rates,
        velocity_start=np.array([1, 0, 0]) - np.cross(rates, arm),
    )
    off.body = RigidBody(mass=4.0, inertia=INERTIA, r_cm=arm)
    off.connect(off.world.frame, off.motion.frame_a)
    off.connect(off.motion.frame_b, off.body.frame_a)
    one, two = simulate(at_centre), simulate(off)
    for angle in ("roll", "pitch", "yaw"):
        assert np.allclose(values(one, f"motion.{angle}"), values(two, f"motion.{angle}"), atol=1e-7)
    assert np.allclose(values(one, "body.v"), values(two, "body.v"), atol=1e-7)
    assert np.allclose(values(two, "body.v"), [1, 0, 0], atol=1e-7)


@pytest.mark.parametrize("axes", ["world", "frame"])
def test_forces_and_moments_accelerate_a_body(axes):
    model = floating(yaw_start=np.pi / 2)
    model.force, model.torque = WorldForce(resolve_in=axes), WorldTorque(resolve_in=axes)
    model.push, model.twist = Constant(value=(8.0, 0, 0)), Constant(value=(0, 0, 0.5))
    model.connect(model.push.y, model.force.force)
    model.connect(model.twist.y, model.torque.torque)
    model.connect(model.force.frame, model.body.frame_a)
    model.connect(model.torque.frame, model.body.frame_a)
    result = simulate(model, 0.02, output_step=0.01)
    v = values(result, "body.v")[-1] / 0.02
    assert np.allclose(v, [2.0, 0, 0] if axes == "world" else [0, 2.0, 0], atol=1e-3)
    w = values(result, "body.frame_a.w")[-1] / 0.02
    R = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    assert np.allclose(w, np.linalg.solve(R @ INERTIA @ R.T, [0, 0, 0.5]), atol=1e-3)


def test_line_spring_hangs_a_mass():
    stiffness, mass, natural = 200.0, 3.0, 0.5
    model = fw.Assembly("hanging mass")
    model.world = World()
    model.slide = Prismatic(n=(0, 0, -1), s_start=natural)
    model.mass = PointMass(mass=mass)
    model.spring = SpringDamper(stiffness=stiffness, damping=2.0, natural_length=natural)
    chain(model, model.world, model.slide, model.mass)
    model.connect(model.world.frame, model.spring.frame_a)
    model.connect(model.mass.frame_a, model.spring.frame_b)
    result = simulate(model, 4.0)
    time = np.asarray(result["spring.tension"].time)
    sag, w0, zeta = mass * G / stiffness, np.sqrt(stiffness / mass), 2.0 / (2 * np.sqrt(stiffness * mass))
    wd = w0 * np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * w0 * time) * (np.cos(wd * time) + zeta * w0 / wd * np.sin(wd * time))
    assert np.allclose(values(result, "slide.s"), natural + sag * (1 - decay), atol=1e-7)
    pull = stiffness * (values(result, "slide.s") - natural) + 2.0 * values(result, "slide.v")
    assert np.allclose(values(result, "spring.tension"), pull, atol=1e-6)


# --- sensors --------------------------------------------------------------------------------------------------------


def carousel(w=3.0, phi=0.0):
    """An arm of 2 m that turns about the vertical, w = 3 rad/s, with a tilted plate at its end."""
    model = fw.Assembly("carousel")
    model.world = World()
    model.hinge = Revolute(n=(0, 0, 1), w_start=w, phi_start=phi)
    model.arm = FixedTranslation(r=(2, 0, 0))
    model.plate = FixedRotation(n=(0, 1, 0), angle=0.3)
    model.body = RigidBody(mass=1.5, inertia=np.diag([1, 1, 4.0]))
    chain(model, model.world, model.hinge, model.arm, model.plate, model.body)
    return model


def test_kinematic_sensors():
    model = carousel()
    model.position, model.attitude = PositionSensor(), AttitudeSensor()
    model.velocity, model.own_velocity = VelocitySensor(), VelocitySensor(resolve_in="frame")
    model.acceleration, model.own_acceleration = AccelerationSensor(), AccelerationSensor(resolve_in="frame")
    for name in ("position", "attitude", "velocity", "own_velocity", "acceleration", "own_acceleration"):
        model.connect(model.body.frame_a, model.parts[name].frame)
    result = simulate(model, 5.0)
    time = np.asarray(result["hinge.phi"].time)
    c, s = np.cos(3 * time), np.sin(3 * time)
    zero = np.zeros_like(time)
    assert np.allclose(values(result, "position.r"), 2 * np.stack([c, s, zero], axis=1), atol=1e-7)
    assert np.allclose(values(result, "velocity.v"), 6 * np.stack([-s, c, zero], axis=1), atol=1e-7)
    assert np.allclose(values(result, "acceleration.a"), -18 * np.stack([c, s, zero], axis=1), atol=1e-6)
    assert np.allclose(values(result, "velocity.w"), [0, 0, 3.0], atol=1e-8)
    tilt = Rotation.from_rotvec([0, 0.3, 0]).as_matrix()
    assert np.allclose(values(result, "own_velocity.v"), [0, 6.0, 0] @ tilt, atol=1e-7)
    assert np.allclose(values(result, "own_velocity.w"), [0, 0, 3.0] @ tilt, atol=1e-7)
    assert np.allclose(values(result, "own_acceleration.a"), [-18.0, 0, 0] @ tilt, atol=1e-6)
    assert np.allclose(values(result, "attitude.pitch"), 0.3, atol=1e-9)
    assert np.allclose(values(result, "attitude.roll"), 0.0, atol=1e-9)
    assert np.allclose(values(result, "attitude.yaw"), 3 * time, atol=1e-7)  # two turns and more


@pytest.mark.parametrize("w, phi, near", [(-2.0, 0.0, 0.0), (2.0, 2.9, 0.0), (-2.0, 10.0, 9.0)])
def test_attitude_sensor_counts_turns_from_its_start(w, phi, near):
    model = carousel(w, phi)
    model.attitude = AttitudeSensor(reference_start=near)
    model.connect(model.body.frame_a, model.attitude.frame)
    result = simulate(model, 8.0)
    time = np.asarray(result["hinge.phi"].time)
    assert np.allclose(values(result, "attitude.yaw"), phi + w * time, atol=1e-6)


def test_attitude_sensor_within_half_a_turn():
    model = carousel()
    model.attitude = AttitudeSensor(continuous_yaw=False)
    model.connect(model.body.frame_a, model.attitude.frame)
    result = simulate(model, 5.0)
    time = np.asarray(result["hinge.phi"].time)
    assert np.allclose(values(result, "attitude.yaw"), np.angle(np.exp(3j * time)), atol=1e-7)


def test_relative_sensor_rides_on_its_first_frame():
    model = carousel()
    model.relative = RelativeSensor()
    model.fixed = Fixed(r=(0, 0, 1))
    model.connect(model.arm.frame_b, model.relative.frame_a)
    model.connect(model.fixed.frame, model.relative.frame_b)
    result = simulate(model)
    assert np.allclose(values(result, "relative.r"), [-2, 0, 1.0], atol=1e-7)
    assert np.allclose(values(result, "relative.v"), 0.0, atol=1e-7)
    assert np.allclose(values(result, "relative.w"), [0, 0, -3.0], atol=1e-7)


def test_load_sensor_measures_what_the_carrier_exerts():
    model = fw.Assembly("cantilever")
    model.world = World()
    model.root, model.arm, model.mass = LoadSensor(), FixedTranslation(r=(2, 0, 0)), PointMass(mass=3.0)
    chain(model, model.world, model.root, model.arm, model.mass)
    result = simulate(model, 0.1)
    assert np.allclose(values(result, "root.force"), [0, 0, 3 * G])
    assert np.allclose(values(result, "root.torque"), [0, -2 * 3 * G, 0])


# --- one-dimensional rotation ---------------------------------------------------------------------------------------


def test_torsion_pendulum():
    stiffness, inertia, damping = 50.0, 2.0, 1.0
    model = fw.Assembly("torsion pendulum")
    model.ground = FixedFlange(phi=0.1)
    model.spring = TorsionSpringDamper(stiffness=stiffness, damping=damping, phi_zero=0.2)
    model.wheel, model.angle = Inertia(inertia=inertia, phi_start=0.8), AngleSensor()
    model.connect(model.ground.flange, model.spring.flange_a)
    model.connect(model.spring.flange_b, model.wheel.flange_a)
    model.connect(model.wheel.flange_b, model.angle.flange)
    result = simulate(model, 3.0)
    time = np.asarray(result["wheel.phi"].time)
    w0, decay = np.sqrt(stiffness / inertia), damping / (2 * inertia)
    wd = np.sqrt(w0**2 - decay**2)
    exact = 0.3 + 0.5 * np.exp(-decay * time) * (np.cos(wd * time) + decay / wd * np.sin(wd * time))
    assert np.allclose(values(result, "angle.phi"), exact, atol=1e-7)


def test_torque_and_power_flow_from_a_to_b():
    model = fw.Assembly("drive")
    model.motor, model.command, model.sensor = TorqueSource(), Constant(value=6.0), TorqueSensor()
    model.near, model.far = Inertia(inertia=1.0, w_start=2.0), Inertia(inertia=2.0, w_start=2.0)
    model.connect(model.command.y, model.motor.torque)
    model.connect(model.motor.flange, model.near.flange_a)
    model.connect(model.near.flange_b, model.sensor.flange_a)
    model.connect(model.sensor.flange_b, model.far.flange_a)
    result = simulate(model)
    time = np.asarray(result["sensor.torque"].time)
    assert np.allclose(values(result, "sensor.torque"), 4.0, atol=1e-9)
    assert np.allclose(values(result, "sensor.power"), 4.0 * (2.0 + 2.0 * time), atol=1e-6)


def test_speed_source_prescribes_the_speed():
    model = fw.Assembly("prescribed speed")
    model.speed, model.source, model.wheel = Sine(frequency=0.5, offset=1.0), SpeedSource(), Inertia(inertia=2.0)
    model.sensor = SpeedSensor()
    model.connect(model.speed.y, model.source.w)
    model.connect(model.source.flange, model.wheel.flange_a)
    model.connect(model.wheel.flange_b, model.sensor.flange)
    result = simulate(model)
    time = np.asarray(result["sensor.w"].time)
    assert np.allclose(values(result, "sensor.w"), 1.0 + np.sin(np.pi * time), atol=1e-8)
    assert np.allclose(values(result, "wheel.flange_a.tau"), 2.0 * np.pi * np.cos(np.pi * time), atol=1e-7)
    assert np.allclose(values(result, "wheel.phi"), time + (1 - np.cos(np.pi * time)) / np.pi, atol=1e-7)
