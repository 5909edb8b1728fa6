"""Mechanisms with analytic solutions or conserved quantities: the kernel as a multibody program."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import (
    Crank,
    Fixed,
    FixedFlange,
    FixedTranslation,
    FreeMotion,
    PlanarLoopRevolute,
    PointMass,
    Revolute,
    RigidBody,
    Spherical,
    TorqueSource,
    TorsionSpringDamper,
    World,
)

G = 9.80665
TIGHT = 1e-10


def simulate(model, t_end=10.0, output_step=0.05, tolerance=TIGHT):
    return fw.load(model).compile().simulate(t_end, output_step=output_step, tolerance=tolerance)


def values(result, path):
    return np.asarray(result[path])


def rotations(result, frame):
    """R of a frame at every output point, (n, 3, 3)."""
    return values(result, f"{frame}.R")


def body_energy(result, name, mass, inertia, r_cm=(0, 0, 0), gravity=G):
    """Kinetic plus potential energy of a rigid body at every output point."""
    R, w, v = rotations(result, f"{name}.frame_a"), values(result, f"{name}.frame_a.w"), values(result, f"{name}.v")
    w_a = np.einsum("tij,ti->tj", R, w)
    height = values(result, f"{name}.frame_a.r")[:, 2] + (R @ np.asarray(r_cm, float))[:, 2]
    spin = np.einsum("ti,ij,tj->t", w_a, np.asarray(inertia, float), w_a)
    return 0.5 * mass * np.sum(v**2, axis=1) + 0.5 * spin + mass * gravity * height


def momentum(result, name, mass, inertia, r_cm=(0, 0, 0)):
    """Linear momentum and angular momentum about the origin, world."""
    R, w, v = rotations(result, f"{name}.frame_a"), values(result, f"{name}.frame_a.w"), values(result, f"{name}.v")
    centre = values(result, f"{name}.frame_a.r") + R @ np.asarray(r_cm, float)
    spin = np.einsum("tij,jk,tlk,tl->ti", R, np.asarray(inertia, float), R, w)
    return mass * v, spin + np.cross(centre, mass * v)


def drift(quantity):
    """Largest change since the start, relative to the size of the motion."""
    return np.max(np.abs(quantity - quantity[0])) / np.max(np.abs(quantity))


@pytest.mark.parametrize("amplitude_deg", [1.0, 60.0, 170.0])
def test_pendulum_follows_the_elliptic_integral(amplitude_deg):
    mass, length, inertia = 2.0, 0.7, 0.05
    model = fw.Assembly("pendulum")
    model.world = World()
    model.hinge = Revolute(n=(0, 1, 0), phi_start=np.radians(amplitude_deg))
    model.body = RigidBody(mass=mass, inertia=np.diag([0.02, inertia, 0.03]), r_cm=(0, 0, -length))
    model.connect(model.world.frame, model.hinge.frame_a)
    model.connect(model.hinge.frame_b, model.body.frame_a)
    result = simulate(model, tolerance=1e-11)

    time, phi, w = np.asarray(result["hinge.phi"].time), values(result, "hinge.phi"), values(result, "hinge.w")
    total = inertia + mass * length**2
    slow, k = np.sqrt(mass * G * length / total), np.sin(np.radians(amplitude_deg) / 2)
    _, cn, dn, _ = ellipj(slow * time, k**2)
    assert np.max(np.abs(phi - 2 * np.arcsin(k * cn / dn))) < 1e-5

    energy = 0.5 * total * w**2 + mass * G * length * (1 - np.cos(phi))
    assert drift(energy) < 1e-6

    before = np.flatnonzero(np.diff(np.sign(phi)))
    crossings = time[before] - phi[before] * (time[1] - time[0]) / (phi[before + 1] - phi[before])
    period = 2 * (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    assert period == pytest.approx(4 * ellipk(k**2) / slow, rel=1e-4)
    if amplitude_deg == 1.0:
        assert 4 * ellipk(k**2) / slow == pytest.approx(2 * np.pi / slow, rel=1e-4)
        assert np.max(np.abs(phi - np.radians(1.0) * np.cos(slow * time))) < 1e-4


@pytest.mark.parametrize("joint", ["two hinges", "ball joint"])
def test_spherical_pendulum_keeps_energy_and_vertical_angular_momentum(joint):
    """Thrown sideways: compared with Newton's equations of a bead on a sphere."""
    mass, length, angle, rate = 1.5, 2.0, 0.8, 1.1
    model = fw.Assembly("spherical pendulum")
    model.world = World()
    if joint == "two hinges":
        model.outer = Revolute(n=(1, 0, 0), w_start=rate)
        model.inner = Revolute(n=(0, 1, 0), phi_start=angle)
        model.connect(model.world.frame, model.outer.frame_a)
        model.connect(model.outer.frame_b, model.inner.frame_a)
        top = model.inner.frame_b
        body = PointMass(mass=mass)
    else:  # the same throw, angular velocity rate * ex, as rates of roll, pitch, yaw
        rates = (rate / np.cos(angle), 0.0, rate * np.tan(angle))
        model.joint = Spherical(pitch_start=angle, angle_rates_start=rates)
        model.connect(model.world.frame, model.joint.frame_a)
        top = model.joint.frame_b
        # a slender rod without inertia about its own axis would leave the spin undetermined
        body = RigidBody(mass=mass, inertia=np.diag([1e-3, 1e-3, 1e-3]))
    model.arm = FixedTranslation(r=(0, 0, -length))
    model.body = body
    model.connect(top, model.arm.frame_a)
    model.connect(model.arm.frame_b, model.body.frame_a)
    result = simulate(model)

    r, v = values(result, "body.frame_a.r"), values(result, "body.v")
    assert np.max(np.abs(np.linalg.norm(r, axis=1) - length)) < 1e-9
    own = 0.0 if joint == "two hinges" else 0.5e-3 * np.sum(values(result, "body.frame_a.w") ** 2, axis=1)
    energy = 0.5 * mass * np.sum(v**2, axis=1) + mass * G * (r[:, 2] + length) + own
    assert drift(energy) < 1e-6
    vertical = mass * (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0])
    if joint == "two hinges":
        assert drift(vertical) < 1e-6

        def newton(_, y):
            p, q = y[:3], y[3:]
            pull = (np.dot(q, q) - G * p[2]) / length**2
            return np.concatenate([q, np.array([0, 0, -G]) - pull * p])

        start = np.concatenate([r[0], v[0]])
        time = np.asarray(result["body.v"].time)
        exact = solve_ivp(newton, (0, time[-1]), start, t_eval=time, rtol=1e-11, atol=1e-12, method="DOP853").y[:3].T
        assert np.max(np.abs(r - exact)) < 1e-5


def double_pendulum(axis_2=(1, 0, 0), base=(0, 0, 0), gravity=G, w_start=0.0):
    """Two rigid bodies on hinges with skew axes: chaotic, three-dimensional."""
    model = fw.Assembly("double pendulum")
    model.world = World(gravity=gravity)
    model.base = Fixed(angles=base)
    model.hinge_1 = Revolute(n=(0, 1, 0), phi_start=1.2, w_start=w_start)
    model.link = FixedTranslation(r=(0, 0, -1.0))
    model.body_1 = RigidBody(mass=1.0, inertia=np.diag([0.1, 0.12, 0.02]), r_cm=(0, 0, -0.5))
    model.hinge_2 = Revolute(n=axis_2, phi_start=-0.7, w_start=2 * w_start)
    model.body_2 = RigidBody(mass=0.6, inertia=np.diag([0.04, 0.05, 0.01]), r_cm=(0.05, 0.1, -0.4))
    model.connect(model.base.frame, model.hinge_1.frame_a)
    model.connect(model.hinge_1.frame_b, model.link.frame_a)
    model.connect(model.hinge_1.frame_b, model.body_1.frame_a)
    model.connect(model.link.frame_b, model.hinge_2.frame_a)
    model.connect(model.hinge_2.frame_b, model.body_2.frame_a)
    return model


def test_double_pendulum_in_space_keeps_its_energy():
    result = simulate(double_pendulum())
    energy = body_energy(result, "body_1", 1.0, np.diag([0.1, 0.12, 0.02]), (0, 0, -0.5))
    energy += body_energy(result, "body_2", 0.6, np.diag([0.04, 0.05, 0.01]), (0.05, 0.1, -0.4))
    span = np.ptp(values(result, "body_1.frame_a.w"))
    assert span > 2.0  # it does move
    assert drift(energy) < 1e-6


def test_planar_double_pendulum_of_point_masses_follows_lagrange():
    m1, m2, l1, l2 = 1.0, 0.7, 1.0, 0.8
    model = fw.Assembly("double pendulum in a plane")
    model.world = World()
    model.hinge_1, model.hinge_2 = Revolute(n=(0, 1, 0), phi_start=1.0), Revolute(n=(0, 1, 0), phi_start=0.5)
    model.link_1, model.link_2 = FixedTranslation(r=(0, 0, -l1)), FixedTranslation(r=(0, 0, -l2))
    model.mass_1, model.mass_2 = PointMass(mass=m1), PointMass(mass=m2)
    chain = [model.world.frame]
    for hinge, link, mass in ((model.hinge_1, model.link_1, model.mass_1), (model.hinge_2, model.link_2, model.mass_2)):
        model.connect(chain[-1], hinge.frame_a)
        model.connect(hinge.frame_b, link.frame_a)
        model.connect(link.frame_b, mass.frame_a)
        chain.append(link.frame_b)
    result = simulate(model, t_end=5.0)

    def lagrange(_, y):
        a, b, wa, wb = y  # absolute angles from the vertical
        c, s = np.cos(a - b), np.sin(a - b)
        mass = np.array([[(m1 + m2) * l1**2, m2 * l1 * l2 * c], [m2 * l1 * l2 * c, m2 * l2**2]])
        turning = m2 * l1 * l2 * s * np.array([-(wb**2), wa**2])
        weight = G * np.array([(m1 + m2) * l1 * np.sin(a), m2 * l2 * np.sin(b)])
        return [wa, wb, *np.linalg.solve(mass, turning - weight)]

    time = np.asarray(result["hinge_1.phi"].time)
    exact = solve_ivp(lagrange, (0, 5.0), [1.0, 1.5, 0, 0], t_eval=time, rtol=1e-11, atol=1e-12, method="DOP853").y
    assert np.max(np.abs(values(result, "hinge_1.phi") - exact[0])) < 1e-5
    assert np.max(np.abs(values(result, "hinge_1.phi") + values(result, "hinge_2.phi") - exact[1])) < 1e-5


def test_a_rotated_mechanism_moves_alike_without_gravity():
    plain = simulate(double_pendulum(gravity=0.0, w_start=1.5), t_end=5.0)
    turned = simulate(double_pendulum(gravity=0.0, w_start=1.5, base=(0.4, -1.1, 2.3)), t_end=5.0)
    for name in ("hinge_1.phi", "hinge_2.phi"):
        assert np.max(np.abs(values(plain, name) - values(turned, name))) < 1e-6
    R = rotations(turned, "base.frame")[0]
    # The same motion seen from the turned base, loads included.
    assert np.max(np.abs(values(turned, "body_2.frame_a.r") - values(plain, "body_2.frame_a.r") @ R.T)) < 1e-6
    assert np.max(np.abs(values(turned, "hinge_1.frame_a.t") - values(plain, "hinge_1.frame_a.t") @ R.T)) < 1e-4


def test_a_mechanism_turned_about_the_vertical_moves_alike_under_gravity():
    plain = simulate(double_pendulum(), t_end=3.0)
    turned = simulate(double_pendulum(base=(0, 0, 1.0)), t_end=3.0)
    for name in ("hinge_1.phi", "hinge_2.phi"):
        assert np.max(np.abs(values(plain, name) - values(turned, name))) < 1e-6


def four_bar(a=0.4, b=1.2, c=1.0, d=1.1, w_start=6.0, gravity=G, base=(0, 0, 0)):
    """Crank and rocker in the plane x-z, angles from x towards z; the hinge of coupler and rocker closes the loop."""
    model = fw.Assembly("four-bar")
    model.world, model.base = World(gravity=gravity), Fixed(angles=base)
    axis = (0, -1, 0)
    crank, guess = 0.6, four_bar_angles(0.6, a, b, c, d)
    model.ground = FixedTranslation(r=(d, 0, 0))
    model.crank_hinge = Crank(n=axis, phi_start=crank, w_start=w_start)
    model.coupler_hinge = Revolute(n=axis, phi_start=guess[0] - crank)
    model.rocker_hinge = Revolute(n=axis, phi_start=guess[1])
    model.crank, model.coupler, model.rocker = (FixedTranslation(r=(length, 0, 0)) for length in (a, b, c))
    for name, mass, length in (("crank", 2.0, a), ("coupler", 1.0, b), ("rocker", 1.5, c)):
        rod = RigidBody(mass=mass, inertia=np.eye(3) * mass * length**2 / 12, r_cm=(length / 2, 0, 0))
        model.add(f"{name}_body", rod)
    model.closing = PlanarLoopRevolute(n=axis)
    for start, hinge, link in (
        (model.base.frame, model.crank_hinge, "crank"),
        (model.crank.frame_b, model.coupler_hinge, "coupler"),
        (model.ground.frame_b, model.rocker_hinge, "rocker"),
    ):
        model.connect(start, hinge.frame_a)
        model.connect(hinge.frame_b, model.parts[link].frame_a)
        model.connect(hinge.frame_b, model.parts[f"{link}_body"].frame_a)
    model.connect(model.base.frame, model.ground.frame_a)
    model.connect(model.coupler.frame_b, model.closing.frame_a)
    model.connect(model.rocker.frame_b, model.closing.frame_b)
    return model


def four_bar_angles(crank, a, b, c, d):
    """Angles of coupler and rocker from the x axis (open branch)."""
    x, z = a * np.cos(crank), a * np.sin(crank)
    gap = np.hypot(d - x, z)
    along = np.arctan2(-z, d - x)
    inner = np.arccos((gap**2 + b**2 - c**2) / (2 * gap * b))
    coupler = along + inner
    tip = np.array([x, z]) + b * np.array([np.cos(coupler), np.sin(coupler)])
    return coupler, np.arctan2(tip[1], tip[0] - d)


def test_four_bar_linkage_keeps_its_loop_closed_and_its_energy():
    a, b, c, d = 0.4, 1.2, 1.0, 1.1
    result = simulate(four_bar(a, b, c, d), t_end=5.0, output_step=0.01)
    crank, rocker = values(result, "crank_hinge.phi"), values(result, "rocker_hinge.phi")
    assert abs(crank[-1] - crank[0]) > 2 * np.pi  # full turns

    gap = values(result, "coupler.frame_b.r") - values(result, "rocker.frame_b.r")
    assert np.max(np.abs(gap)) < 1e-8

    k1, k2, k3 = d / a, d / c, (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    freudenstein = k1 * np.cos(rocker) - k2 * np.cos(crank) + k3 - np.cos(crank - rocker)
    assert np.max(np.abs(freudenstein)) < 1e-7

    energy = sum(
        body_energy(result, f"{name}_body", mass, np.eye(3) * mass * length**2 / 12, (length / 2, 0, 0))
        for name, mass, length in (("crank", 2.0, a), ("coupler", 1.0, b), ("rocker", 1.5, c))
    )
    assert drift(energy) < 1e-6


def test_four_bar_accelerations_are_those_of_one_degree_of_freedom():
    """Without gravity: T = J(phi) w^2 / 2 is constant, so w(phi) is known in closed form."""
    a, b, c, d = 0.4, 1.2, 1.0, 1.1
    result = simulate(four_bar(a, b, c, d, gravity=0.0), t_end=2.0, output_step=0.01)
    crank, w = values(result, "crank_hinge.phi"), values(result, "crank_hinge.w")

    def reduced_inertia(phi, h=1e-6):
        before, at, after = (four_bar_angles(angle, a, b, c, d) for angle in (phi - h, phi, phi + h))
        coupler_rate, rocker_rate = (np.array(after) - before) / (2 * h)
        v = a * np.array([-np.sin(phi), np.cos(phi)]) + b / 2 * coupler_rate * np.array([-np.sin(at[0]), np.cos(at[0])])
        return 2.0 * a**2 / 3 + 1.0 * (v @ v + b**2 / 12 * coupler_rate**2) + 1.5 * c**2 / 3 * rocker_rate**2

    inertia = np.array([reduced_inertia(phi) for phi in crank])
    assert np.max(np.abs(w - w[0] * np.sqrt(inertia[0] / inertia))) < 1e-5 * w[0]

    turned = simulate(four_bar(a, b, c, d, gravity=0.0, base=(0.4, -1.1, 2.3)), t_end=2.0, output_step=0.01)
    assert np.max(np.abs(values(turned, "crank_hinge.phi") - crank)) < 1e-6


def floating_pair(gravity):
    """A platform and an arm on a hinge with a spring, both tumbling; nothing outside acts but gravity."""
    model = fw.Assembly("two bodies afloat")
    model.world = World(gravity=gravity)
    model.motion = FreeMotion(
        surge_start=1.0,
        heave_start=2.0,
        pitch_start=0.2,
        velocity_start=(0.3, -0.2, 0.5),
        angle_rates_start=(0.4, 0.1, -0.5),
    )
    model.platform = RigidBody(mass=5.0, inertia=np.array(PLATFORM), r_cm=(0.1, -0.05, -0.2))
    model.mast = FixedTranslation(r=(0.0, 0.3, 0.8))
    model.hinge = Revolute(n=(0, 1, 0.5), phi_start=0.4)
    model.spring = TorsionSpringDamper(stiffness=3.0)
    model.arm = RigidBody(mass=2.0, inertia=np.diag([0.3, 0.2, 0.15]), r_cm=(0.0, 0.1, 0.5))
    model.housing = FixedFlange()
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.platform.frame_a)
    model.connect(model.motion.frame_b, model.mast.frame_a)
    model.connect(model.mast.frame_b, model.hinge.frame_a)
    model.connect(model.hinge.frame_b, model.arm.frame_a)
    model.connect(model.hinge.flange, model.spring.flange_b)
    model.connect(model.spring.flange_a, model.housing.flange)
    return model


PLATFORM = [[1.0, 0.1, 0.0], [0.1, 1.4, -0.05], [0.0, -0.05, 0.9]]


@pytest.mark.parametrize("gravity", [0.0, G])
def test_a_floating_pair_keeps_its_momentum(gravity):
    result = simulate(floating_pair(gravity))
    time = np.asarray(result["hinge.phi"].time)
    p1, h1 = momentum(result, "platform", 5.0, PLATFORM, (0.1, -0.05, -0.2))
    p2, h2 = momentum(result, "arm", 2.0, np.diag([0.3, 0.2, 0.15]), (0.0, 0.1, 0.5))
    linear = p1 + p2
    assert np.ptp(values(result, "hinge.phi")) > 0.3  # the arm swings against the platform
    fall = np.outer(time, (0, 0, -7.0 * gravity))
    assert np.max(np.abs(linear - linear[0] - fall)) < 1e-6 * max(1.0, np.max(np.abs(linear)))

    R1, R2 = rotations(result, "platform.frame_a"), rotations(result, "arm.frame_a")
    centre = 5.0 * (values(result, "platform.frame_a.r") + R1 @ np.array([0.1, -0.05, -0.2]))
    centre = (centre + 2.0 * (values(result, "arm.frame_a.r") + R2 @ np.array([0.0, 0.1, 0.5]))) / 7.0
    spin = h1 + h2 - np.cross(centre, linear)  # about the common centre of mass: gravity has no moment
    assert np.max(np.abs(spin - spin[0])) < 1e-6 * np.max(np.abs(spin))

    energy = body_energy(result, "platform", 5.0, PLATFORM, (0.1, -0.05, -0.2), gravity)
    energy += body_energy(result, "arm", 2.0, np.diag([0.3, 0.2, 0.15]), (0.0, 0.1, 0.5), gravity)
    energy += 0.5 * 3.0 * values(result, "hinge.phi") ** 2
    assert np.max(np.abs(energy - energy[0])) < 1e-6 * max(np.max(np.abs(energy)), 1.0)


def test_a_torque_free_symmetric_body_precesses_as_euler_says():
    """W in the body turns about the symmetry axis at (I3 - I1) / I1 w3 (L. Euler; Goldstein, section 5.6)."""
    i1, i3 = 2.0, 3.0
    w = np.array([0.3, 0.0, 1.2])  # body axes and world axes coincide at the start
    model = fw.Assembly("free top")
    model.world = World(gravity=0.0)
    model.motion = FreeMotion(angle_rates_start=tuple(w))
    model.body = RigidBody(mass=1.0, inertia=np.diag([i1, i1, i3]))
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.body.frame_a)
    result = simulate(model)
    time = np.asarray(result["motion.yaw"].time)
    w_a = np.einsum("tij,ti->tj", rotations(result, "body.frame_a"), values(result, "body.frame_a.w"))
    rate = (i3 - i1) / i1 * w[2]
    exact = np.stack([w[0] * np.cos(rate * time), w[0] * np.sin(rate * time), np.full_like(time, w[2])], axis=1)
    assert np.max(np.abs(w_a - exact)) < 1e-6


def test_a_heavy_top_precesses_steadily():
    """Without nutation: I1 W^2 cos(theta) - I3 w3 W + m g l = 0 (Goldstein, section 5.7)."""
    mass, arm, i1, i3, theta, precession = 1.2, 0.15, 0.02, 0.005, 0.5, 3.0
    total = i1 + mass * arm**2
    w3 = (total * precession**2 * np.cos(theta) + mass * G * arm) / (i3 * precession)
    model = fw.Assembly("heavy top")
    model.world = World()
    model.precession = Revolute(n=(0, 0, 1), w_start=precession)
    model.nutation = Revolute(n=(0, 1, 0), phi_start=theta)
    model.spin = Revolute(n=(0, 0, 1), w_start=w3 - precession * np.cos(theta))
    model.top = RigidBody(mass=mass, inertia=np.diag([i1, i1, i3]), r_cm=(0, 0, arm))
    model.connect(model.world.frame, model.precession.frame_a)
    model.connect(model.precession.frame_b, model.nutation.frame_a)
    model.connect(model.nutation.frame_b, model.spin.frame_a)
    model.connect(model.spin.frame_b, model.top.frame_a)
    result = simulate(model)
    time = np.asarray(result["spin.phi"].time)
    assert np.max(np.abs(values(result, "nutation.phi") - theta)) < 1e-6
    assert np.max(np.abs(values(result, "precession.phi") - precession * time)) < 1e-5
    assert np.max(np.abs(values(result, "spin.w") / (w3 - precession * np.cos(theta)) - 1)) < 1e-6


def test_a_driven_hinge_reacts_on_its_carrier():
    """A torque inside turns both bodies against each other: J1 w1 + J2 w2 = 0 about the common axis."""
    model = fw.Assembly("reaction wheel")
    model.world = World(gravity=0.0)
    model.bearing, model.hinge = Revolute(n=(0, 0, 2)), Revolute(n=(0, 0, 1))
    model.carrier = RigidBody(mass=1.0, inertia=np.diag([1, 1, 4.0]))
    model.wheel = RigidBody(mass=1.0, inertia=np.diag([1, 1, 0.5]))
    model.motor, model.command = TorqueSource(), Constant(value=2.0)
    model.connect(model.world.frame, model.bearing.frame_a)
    model.connect(model.bearing.frame_b, model.carrier.frame_a)
    model.connect(model.bearing.frame_b, model.hinge.frame_a)
    model.connect(model.hinge.frame_b, model.wheel.frame_a)
    model.connect(model.hinge.flange, model.motor.flange)
    model.connect(model.command.y, model.motor.torque)
    result = simulate(model, t_end=2.0)
    time = np.asarray(result["hinge.w"].time)
    assert np.allclose(values(result, "carrier.frame_a.w")[:, 2], -2.0 / 4.0 * time, atol=1e-7)
    assert np.allclose(values(result, "wheel.frame_a.w")[:, 2], 2.0 / 0.5 * time, atol=1e-7)
