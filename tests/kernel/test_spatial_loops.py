"""Closed loops in space: ball joints, free spins, constraints that repeat others; against Lagrange's equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import fowtlib as fw
from fowtlib.components.mechanics import (
    Crank,
    FixedRotation,
    FixedTranslation,
    PlanarLoopRevolute,
    Prismatic,
    Revolute,
    RigidBody,
    Spherical,
    TubeBeam,
    World,
)
from fowtlib.language import Scalar, var

G = 9.80665


def simulate(model, t_end, output_step=0.02, **options):
    return fw.load(model).compile().simulate(t_end, output_step=output_step, tolerance=1e-9, **options)


def values(result, path):
    return np.asarray(result[path])


def join(model, first, *others):
    for other in others:
        model.connect(first, other)


def bar_between_ball_joints(roll):
    """A bar whose two ends are ball joints of the world: it can spin about the line between them, and nothing else."""
    model = fw.Assembly("bar between two ball joints")
    model.world = World()
    model.s1 = Spherical() if roll is None else Spherical(roll_start=roll)
    model.s2 = Spherical()
    model.l = FixedTranslation(r=(1, 0, 0))
    model.g = FixedTranslation(r=(1, 0, 0))
    model.b = RigidBody(mass=5.0, r_cm=(0.5, 0, 0.2), inertia=np.eye(3))
    join(model, model.world.frame, model.s1.frame_a, model.g.frame_a)
    join(model, model.s1.frame_b, model.l.frame_a, model.b.frame_a)
    join(model, model.l.frame_b, model.s2.frame_a)
    join(model, model.s2.frame_b, model.g.frame_b)
    return model


def test_a_bar_between_two_ball_joints_rests_upright():
    with pytest.warns(UserWarning, match="is not known for rigid parts; 's1.frame_a.f\\[0\\]' is taken as zero"):
        result = simulate(bar_between_ball_joints(None), 2.0)
    assert np.max(np.abs(values(result, "s1.roll"))) < 1e-9
    weight = values(result, "s1.frame_a.f")[:, 2] + values(result, "g.frame_a.f")[:, 2]
    assert weight == pytest.approx(5 * G, rel=1e-9)
    assert values(result, "s1.frame_a.f")[:, 2] == pytest.approx(2.5 * G, rel=1e-9)  # each end carries a half


@pytest.mark.filterwarnings("ignore:the parts of a closed loop")
def test_a_bar_between_two_ball_joints_spins_as_a_pendulum():
    """I = 1 + 5 0.2^2 about the line of the joints; mass 0.2 m above it."""
    result = simulate(bar_between_ball_joints(0.3), 3.0)
    inertia, moment = 1 + 5 * 0.2**2, 5 * G * 0.2
    pendulum = solve_ivp(lambda t, y: (y[1], moment / inertia * np.sin(y[0])), (0, 3), (0.3, 0.0), rtol=1e-10,
                         atol=1e-12, t_eval=result["s1.roll"].time)  # fmt: skip
    assert np.ptp(pendulum.y[0]) > 4  # it falls over
    assert np.max(np.abs(values(result, "s1.roll") - pendulum.y[0])) < 1e-5


@pytest.mark.filterwarnings("ignore:the parts of a closed loop")
@pytest.mark.parametrize("diameters", [(0.4, 0.2), (0.4, 0.25), (0.3, 0.3)])
def test_a_tube_between_two_ball_joints_spins(diameters):
    """Its length is computed when a run starts, and counts in the choice of states with the value of now.

    What is exactly zero in it is 1e-16 here and nothing there, by the diameters.
    """
    model = fw.Assembly("tube between two ball joints")
    model.world = World()
    model.s1, model.s2 = Spherical(angle_rates_start=(0, 0, 2.0)), Spherical()
    model.tube = TubeBeam(heights=(0, 3.0), diameters=diameters, wall_thicknesses=(0.01, 0.01), hinges=0)
    model.g = FixedTranslation(r=(0, 0, 3.0))
    join(model, model.world.frame, model.s1.frame_a, model.g.frame_a)
    join(model, model.s1.frame_b, model.tube.frame_a)
    join(model, model.tube.frame_b, model.s2.frame_a)
    join(model, model.s2.frame_b, model.g.frame_b)
    plant = fw.load(model).compile()
    assert {state.path for state in plant.dae.states} == {"s2.yaw", "s1.angle_rates[2]"}
    result = plant.simulate(2.0, output_step=0.1, tolerance=1e-9)
    assert values(result, "s1.yaw") == pytest.approx(2.0 * np.asarray(result["s1.yaw"].time), abs=1e-7)


def parallel_pendulums(roll):
    """Two links hang from ball joints 1 m apart; a bar with a ball joint at each end joins their lower ends."""
    model = fw.Assembly("pendulum pair closing by a ball joint")
    model.world = World()
    model.g = FixedTranslation(r=(1, 0, 0))
    model.bar = FixedTranslation(r=(1, 0, 0))
    model.bb = RigidBody(mass=5.0, r_cm=(0.5, 0, 0), inertia=np.eye(3))
    model.s3, model.s4 = Spherical(), Spherical()
    join(model, model.world.frame, model.g.frame_a)
    for k, top in ((1, model.world.frame), (2, model.g.frame_b)):
        ball = model.add(f"s{k}", Spherical() if roll is None else Spherical(roll_start=roll))
        link = model.add(f"l{k}", FixedTranslation(r=(0, 0, -1)))
        body = model.add(f"b{k}", RigidBody(mass=5.0, r_cm=(0, 0, -0.5), inertia=np.eye(3)))
        join(model, top, ball.frame_a)
        join(model, ball.frame_b, link.frame_a, body.frame_a)
    join(model, model.l1.frame_b, model.s3.frame_a)
    join(model, model.s3.frame_b, model.bar.frame_a, model.bb.frame_a)
    join(model, model.bar.frame_b, model.s4.frame_a)
    join(model, model.s4.frame_b, model.l2.frame_b)
    return model


def test_a_pair_of_pendulums_closed_by_ball_joints_swings_as_one():
    """I = 2 (1 + 5 0.5^2) + 5 1^2 about the hinge line, m g l = 5 g (2 0.5 + 1): 1.956 s for small swings."""
    plant = fw.load(parallel_pendulums(0.1)).compile()
    assert {"s1.roll", "s2.roll"} <= {state.path for state in plant.dae.states}  # what has a start is a state
    assert len(plant.dae.states) == 12  # two swings across, one along, the spins of three parts
    result = plant.simulate(5.0, output_step=0.02, tolerance=1e-9)
    inertia, moment = 2 * (1 + 5 * 0.5**2) + 5.0, 5 * G * 2.0
    assert 2 * np.pi * np.sqrt(inertia / moment) == pytest.approx(1.956, abs=5e-4)
    swing = solve_ivp(lambda t, y: (y[1], -moment / inertia * np.sin(y[0])), (0, 5), (0.1, 0.0), rtol=1e-10,
                      atol=1e-12, t_eval=result["s1.roll"].time)  # fmt: skip
    for joint in ("s1", "s2"):
        assert np.max(np.abs(values(result, f"{joint}.roll") - swing.y[0])) < 1e-6
    assert np.max(np.abs(values(result, "bb.frame_a.w"))) < 1e-7  # the bar does not turn


def test_a_pair_of_pendulums_at_rest_has_states_and_stays():
    """No start values: the wishes tie, and the derivatives decide."""
    result = simulate(parallel_pendulums(None), 1.0)
    assert np.max(np.abs(values(result, "l1.frame_b.r") - (0, 0, -1))) < 1e-9


def one_freedom(mass, potential, start, t_eval, h=1e-4):
    """Motion q(t) of M(q) q'' + M'(q) q'^2 / 2 + V'(q) = 0 from start (q, q'), by differences of M and V."""

    def rates(_, y):
        q, v = y
        slope = (mass(q + h) - mass(q - h)) / (2 * h), (potential(q + h) - potential(q - h)) / (2 * h)
        return v, -(0.5 * slope[0] * v**2 + slope[1]) / mass(q)

    return solve_ivp(rates, (t_eval[0], t_eval[-1]), start, t_eval=t_eval, rtol=1e-8, atol=1e-9).y


def rod_between(start, end, spin=0.002):
    """A slender rod of 1 kg along x of its frame, as long as from start to end, and the body of it."""
    length = float(np.linalg.norm(end - start))
    inertia = np.diag([spin, length**2 / 12, length**2 / 12])
    return FixedTranslation(r=(length, 0, 0)), RigidBody(mass=1.0, inertia=inertia, r_cm=(length / 2, 0, 0))


def rod_energies(ends, rates):
    """2 T / q'^2 and V of the rod from its end points and d/dq of them."""
    (a, b), (da, db) = ends, rates
    middle, turn = (da + db) / 2, db - da
    return middle @ middle + turn @ turn / 12, G * (a[2] + b[2]) / 2


CRANK, ROCKER, AXLE = 0.4, 0.9, np.array([1.0, 0.8, 0.2])


def crank_tip(angle):
    return CRANK * np.array([np.cos(angle), 0.0, -np.sin(angle)])


def rocker_tip(angle):
    return AXLE + ROCKER * np.array([0.0, -np.sin(angle), np.cos(angle)])


def add_crank(model, phi, w, hinge=Crank):
    """A crank of 0.4 m that turns about y of the world at the origin."""
    model.world = World()
    model.crank_hinge = hinge(n=(0, 1, 0), phi_start=phi, w_start=w)
    model.crank = FixedTranslation(r=(CRANK, 0, 0))
    model.crank_body = RigidBody(mass=2.0, inertia=np.diag([0.01, 0.03, 0.03]), r_cm=(CRANK / 2, 0, 0))
    join(model, model.world.frame, model.crank_hinge.frame_a)
    join(model, model.crank_hinge.frame_b, model.crank.frame_a, model.crank_body.frame_a)


def spatial_four_bar(phi=0.3, psi=0.2, w=2.0):
    """Crank about y, rocker about x, a rod with ball joints at both ends between their tips (RSSR)."""
    model = fw.Assembly("RSSR")
    add_crank(model, phi, w)
    model.ground = FixedTranslation(r=AXLE)
    model.rocker_hinge = Revolute(n=(1, 0, 0), phi_start=psi)
    model.rocker = FixedTranslation(r=(0, 0, ROCKER))
    model.rocker_body = RigidBody(mass=1.5, inertia=np.diag([0.1, 0.1, 0.01]), r_cm=(0, 0, ROCKER / 2))
    model.ball_1, model.ball_2 = Spherical(yaw_start=0.8, pitch_start=-0.8), Spherical()
    model.rod, model.rod_body = rod_between(crank_tip(phi), rocker_tip(psi))
    join(model, model.world.frame, model.ground.frame_a)
    join(model, model.ground.frame_b, model.rocker_hinge.frame_a)
    join(model, model.rocker_hinge.frame_b, model.rocker.frame_a, model.rocker_body.frame_a)
    join(model, model.crank.frame_b, model.ball_1.frame_a)
    join(model, model.ball_1.frame_b, model.rod.frame_a, model.rod_body.frame_a)
    join(model, model.rod.frame_b, model.ball_2.frame_a)
    join(model, model.ball_2.frame_b, model.rocker.frame_b)
    return model


def test_a_spatial_four_bar_with_two_ball_joints_follows_lagrange():
    """The rod can spin freely about itself: a freedom of its own, which nothing else notices."""
    plant = fw.load(spatial_four_bar()).compile()
    assert [state.path for state in plant.dae.states][:2] == ["crank_hinge.phi", "crank_hinge.w"]
    assert len(plant.dae.states) == 4  # crank and spin
    result = plant.simulate(1.0, output_step=0.01, tolerance=1e-9)
    length = float(np.linalg.norm(rocker_tip(0.2) - crank_tip(0.3)))

    def rocker(phi):
        return brentq(lambda psi: np.linalg.norm(rocker_tip(psi) - crank_tip(phi)) - length, -0.8, 1.6, xtol=1e-14)

    def energies(phi, h=1e-5):
        psi = rocker(phi)
        rate = (rocker(phi + h) - rocker(phi - h)) / (2 * h)
        a, b = crank_tip(phi), rocker_tip(psi)
        da = CRANK * np.array([-np.sin(phi), 0.0, -np.cos(phi)])
        db = rate * ROCKER * np.array([0.0, -np.cos(psi), -np.sin(psi)])
        rod = rod_energies((a, b), (da, db))
        swing = 0.1 + 1.5 * (ROCKER / 2) ** 2
        mass = 0.03 + 2.0 * (CRANK / 2) ** 2 + swing * rate**2 + rod[0]
        return mass, G * (2.0 * a[2] / 2 + 1.5 * (AXLE[2] + ROCKER / 2 * np.cos(psi))) + rod[1]

    t = np.asarray(result["crank_hinge.phi"].time)
    q, v = one_freedom(lambda q: energies(q)[0], lambda q: energies(q)[1], (0.3, 2.0), t)
    assert np.ptp(q) > 3  # from one side to the other
    assert np.max(np.abs(values(result, "crank_hinge.phi") - q)) < 1e-5
    assert np.max(np.abs(values(result, "crank_hinge.w") - v)) < 1e-4
    assert np.max(np.abs(values(result, "rocker_hinge.phi") - [rocker(angle) for angle in q])) < 1e-5


RAIL = np.array([0.0, 0.3, 0.1])


def crank_and_strut(phi=2.2, w=0.0, hinge=Crank):
    """A crank about y drives a slide along x, 0.3 m beside it, by a strut: ball joint here, universal joint there."""
    model = fw.Assembly("RSUP")
    add_crank(model, phi, w, hinge)
    slide = slider(phi)
    model.rail = FixedTranslation(r=RAIL)
    model.slide = Prismatic(n=(1, 0, 0), s_start=slide)
    model.block = RigidBody(mass=3.0, inertia=np.eye(3) * 0.01)
    model.seat, model.ball = FixedRotation(n=(0, 1, 0), angle=-np.pi / 2), Spherical()
    end = RAIL + np.array([slide, 0, 0])
    model.strut, model.strut_body = rod_between(crank_tip(phi), end, spin=1e-9)
    model.yoke, model.cross = Revolute(n=(0, 0, 1)), Revolute(n=(0, 1, 0))
    join(model, model.world.frame, model.rail.frame_a)
    join(model, model.rail.frame_b, model.slide.frame_a)
    join(model, model.slide.frame_b, model.block.frame_a, model.yoke.frame_a)
    join(model, model.yoke.frame_b, model.cross.frame_a)
    join(model, model.cross.frame_b, model.strut.frame_b)
    join(model, model.strut.frame_a, model.ball.frame_b, model.strut_body.frame_a)
    join(model, model.crank.frame_b, model.seat.frame_a)
    join(model, model.seat.frame_b, model.ball.frame_a)
    return model


STRUT = 1.2


def slider(phi):
    across = RAIL - crank_tip(phi)
    return float(np.sqrt(STRUT**2 - across[1] ** 2 - across[2] ** 2) - across[0])


@pytest.mark.parametrize("hinge", [Crank, Revolute])
def test_a_strut_between_a_crank_and_a_slide_follows_lagrange(hinge):
    result = simulate(crank_and_strut(hinge=hinge), 1.2, output_step=0.01)

    def energies(phi, h=1e-5):
        rate = (slider(phi + h) - slider(phi - h)) / (2 * h)
        a, b = crank_tip(phi), RAIL + np.array([slider(phi), 0, 0])
        da, db = CRANK * np.array([-np.sin(phi), 0.0, -np.cos(phi)]), np.array([rate, 0.0, 0.0])
        rod = rod_energies((a, b), (da, db))
        return 0.03 + 2.0 * (CRANK / 2) ** 2 + 3.0 * rate**2 + rod[0], G * a[2] + rod[1]

    t = np.asarray(result["crank_hinge.phi"].time)
    q, _ = one_freedom(lambda q: energies(q)[0], lambda q: energies(q)[1], (2.2, 0.0), t)
    assert np.ptp(q) > 1.2  # to the other side
    assert np.max(np.abs(values(result, "crank_hinge.phi") - q)) < 1e-5
    assert np.max(np.abs(values(result, "slide.s") - [slider(angle) for angle in q])) < 1e-5


def bennett(phi, a=0.5, b=0.8, alpha=0.6, w=1.5):
    """Four axes in a ring, links a, b, a, b with twists alpha, beta, alpha, beta: sin(alpha) / a = sin(beta) / b.

    It moves with hinges only; here the last one is a ball joint. Six coordinates in six closing equations:
    counting says that it is rigid, but one of the equations repeats the others.
    """
    beta = np.arcsin(b / a * np.sin(alpha))
    model = fw.Assembly("Bennett's linkage")
    model.world = World(gravity=0.0)
    ratio = np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)
    other = 2 * np.arctan2(ratio, np.tan(phi / 2))
    here = model.world.frame
    links = (a, alpha, phi), (b, beta, other), (a, alpha, -phi), (b, beta, -other)
    for k, (length, twist, angle) in enumerate(links):
        hinge = Revolute(n=(0, 0, 1), phi_start=angle, w_start=w) if k < 3 else Spherical(yaw_start=angle)
        hinge = model.add(f"hinge_{k}", hinge)
        link = model.add(f"link_{k}", FixedRotation(n=(1, 0, 0), angle=twist, r=(length, 0, 0)))
        join(model, here, hinge.frame_a)
        join(model, hinge.frame_b, link.frame_a)
        here = link.frame_b
        if k < 3:
            body = RigidBody(mass=1.0, inertia=np.eye(3) * 0.02, r_cm=(length / 2, 0, 0))
            join(model, link.frame_a, model.add(f"body_{k}", body).frame_a)
    join(model, here, model.world.frame)
    return model, ratio


def test_bennetts_linkage_moves_although_counting_says_it_is_rigid():
    """tan(first / 2) tan(second / 2) = sin((beta + alpha) / 2) / sin((beta - alpha) / 2) (G. T. Bennett, 1903)."""
    model, ratio = bennett(0.9)
    with pytest.warns(UserWarning, match="hold each other more often than they need to"):
        plant = fw.load(model).compile()
    assert len(plant.dae.states) == 2
    result = plant.simulate(1.0, output_step=0.01, tolerance=1e-9)
    first, second, third = (values(result, f"hinge_{k}.phi") for k in range(3))
    assert np.ptp(first) > 1
    assert np.max(np.abs(np.tan(first / 2) * np.tan(second / 2) - ratio)) < 1e-6
    assert np.max(np.abs(np.sin((first + third) / 2))) < 1e-6
    energy = 0.0
    for k in range(3):
        w, v = values(result, f"body_{k}.frame_a.w"), values(result, f"body_{k}.v")
        energy = energy + 0.5 * np.sum(v**2, axis=1) + 0.01 * np.sum(w**2, axis=1)
    assert np.max(np.abs(energy / energy[0] - 1)) < 1e-6


def slider_crank(slide, phi, rod_phi, s):
    """In the plane: crank 0.4 m about y, rod 1 m, slide along x."""
    model = fw.Assembly("slider crank")
    add_crank(model, phi, 0.0, Revolute)
    model.slide = slide
    model.rod_hinge, model.end = Revolute(n=(0, 1, 0), phi_start=rod_phi), PlanarLoopRevolute(n=(0, 1, 0))
    model.rod, model.rod_body = rod_between(np.zeros(3), np.array([1.0, 0.0, 0.0]))
    model.block = RigidBody(mass=3.0, inertia=np.eye(3) * 0.01)
    join(model, model.world.frame, model.slide.frame_a)
    join(model, model.slide.frame_b, model.block.frame_a, model.end.frame_b)
    join(model, model.crank.frame_b, model.rod_hinge.frame_a)
    join(model, model.rod_hinge.frame_b, model.rod.frame_a, model.rod_body.frame_a)
    join(model, model.rod.frame_b, model.end.frame_a)
    return model


class Driver(Prismatic):
    """A slide that insists on being the state."""

    s: Scalar = var(unit="m", start=Prismatic.s_start, state="always", doc="position")
    v: Scalar = var(unit="m/s", start=Prismatic.v_start, state="always", doc="velocity")


def test_a_state_that_cannot_lead_from_the_start_is_named():
    """At a dead centre the slide does not tell which way the crank goes; elsewhere it does."""
    with pytest.raises(fw.ModelError) as error:
        fw.load(slider_crank(Driver(n=(1, 0, 0), s_start=1.4), 0.0, 0.0, 1.4)).compile()
    text = str(error.value)
    assert text.startswith("slide.s is declared to be a state (state='always'), and at the start the constraint of ")
    assert "'end'" in text
    assert text.endswith(
        "(a dead point). Start it elsewhere, or make rod_hinge.phi the state (state='always', as in a Crank)."
    )
    phi = -0.5
    rod = -phi + np.arcsin(0.4 * np.sin(phi))
    s = 0.4 * np.cos(phi) + np.cos(phi + rod)
    plant = fw.load(slider_crank(Driver(n=(1, 0, 0), s_start=s), phi, rod, s)).compile()
    assert [state.path for state in plant.dae.states] == ["slide.s", "slide.v"]
    free = fw.load(slider_crank(Prismatic(n=(1, 0, 0), s_start=1.4), 0.0, 0.0, 1.4)).compile()
    assert len(free.dae.states) == 2 and "slide.s" not in {state.path for state in free.dae.states}


def test_a_start_where_a_linkage_may_go_two_ways_is_named():
    """A parallelogram laid flat: it may go on as a parallelogram or crossed."""
    model = fw.Assembly("flat parallelogram")
    add_crank(model, 0.0, 0.0, Revolute)
    model.ground = FixedTranslation(r=(1, 0, 0))
    model.rocker_hinge, model.rod_hinge = Revolute(n=(0, 1, 0)), Revolute(n=(0, 1, 0))
    model.rocker, model.rod = FixedTranslation(r=(CRANK, 0, 0)), FixedTranslation(r=(1, 0, 0))
    model.rocker_body, model.rod_body = (RigidBody(mass=1.0, inertia=np.eye(3)) for _ in range(2))
    model.end = PlanarLoopRevolute(n=(0, 1, 0))
    join(model, model.world.frame, model.ground.frame_a)
    join(model, model.ground.frame_b, model.rocker_hinge.frame_a)
    join(model, model.rocker_hinge.frame_b, model.rocker.frame_a, model.rocker_body.frame_a)
    join(model, model.crank.frame_b, model.rod_hinge.frame_a)
    join(model, model.rod_hinge.frame_b, model.rod.frame_a, model.rod_body.frame_a)
    join(model, model.rod.frame_b, model.end.frame_a)
    join(model, model.rocker.frame_b, model.end.frame_b)
    with pytest.raises(fw.ModelError) as error:
        fw.load(model).compile()
    assert str(error.value) == (
        "at the start the constraint of 'end' does not say how the loop moves on (a dead point: parts in line). "
        "Start it a little away from there: other start values for 'crank_hinge.phi', 'rocker_hinge.phi' or "
        "'rod_hinge.phi'."
    )


def test_a_loop_that_cannot_close_is_named():
    """A bar of 1 m between ball joints 1.2 m apart."""
    model = bar_between_ball_joints(None)
    model.g.r = (1.2, 0, 0)
    with pytest.raises(fw.ModelError, match="do not meet at the start, however its joints turn: .* stays open"):
        fw.load(model).compile()
