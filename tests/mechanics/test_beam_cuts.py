"""Section loads at cuts of a beam: statics, inertia of what lies beyond, continuity to the root."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import (
    Beam,
    BeamProperties,
    Fixed,
    FixedRotation,
    FreeMotion,
    PointMass,
    Revolute,
    RigidBody,
    World,
)
from fowtlib.components.mechanics.beam_division import divide, pieces
from fowtlib.language.errors import ParameterError

G = 9.80665
TAPERED = BeamProperties(np.array([0.0, 3.0, 10.0]), np.array([90.0, 50.0, 20.0]), np.array([9e7, 5e7, 1e7]),
                         np.array([7e7, 4e7, 2e7]), rotary_inertia_x=3.0, rotary_inertia_y=5.0)  # fmt: skip
CUTS = [0.0, 2.0, 9.0, 5.5, 10.0, 5.5]


def beyond(beam, s):
    """Mass and first moment about s of what lies beyond s, by the trapezoidal rule between the kinks of the table."""
    x = np.unique(np.concatenate([np.linspace(s, beam.length, 20001), [z for z in beam.z if z > s]]))
    mass = beam.at("mass_per_length", x)
    return np.trapezoid(mass, x), np.trapezoid(mass * (x - s), x)


def level(hinges, head=0.0, **beam):
    """A beam held level, z along world x and x down (gravity along +x of the root), with a mass at its tip."""
    model = fw.Assembly("level beam")
    model.world, model.base = World(gravity=G), Fixed(angles=(0, np.pi / 2, 0))
    model.beam, model.head = Beam(table=TAPERED, hinges=hinges, **beam), PointMass(mass=head)
    model.connect(model.base.frame, model.beam.frame_a)
    model.connect(model.beam.frame_b, model.head.frame_a)
    return model


@pytest.mark.parametrize("hinges", [0, 3])
def test_weight_beyond_the_cut(hinges):
    """Shear = weight beyond, moment = weight times lever. 1e4 stiffer than steel: the geometry is the undeflected."""
    model = level(hinges, head=30.0, cuts=CUTS, stiffness_factor=1e4)
    plant = fw.load(model).compile()
    state = plant.equilibrium() if hinges else plant.initial_state()
    for k, s in enumerate(CUTS):
        mass, moment = beyond(TAPERED, s)
        force = G * (mass + 30.0)
        assert state[f"beam.cut_force[{k}]"] == pytest.approx([-force, 0, 0], abs=2e-3 * force)
        expected = -G * (moment + 30.0 * (10.0 - s))
        assert state[f"beam.cut_moment[{k}]"] == pytest.approx([0, expected, 0], abs=2e-4 * 30 * 10 * G + 1e-6)
    assert state["beam.cut_force[0]"] == pytest.approx(np.ravel(state["beam.root_force"]), rel=1e-9, abs=1e-9)
    assert state["beam.cut_moment[0]"] == pytest.approx(np.ravel(state["beam.root_moment"]), rel=1e-9, abs=1e-9)


def test_pieces_are_the_whole_beam():
    """Mass, first moment and inertia about the root do not change with the cuts."""
    chain = divide(TAPERED, 3, "loaded_tip")

    def sums(segments):
        steiner = [s.centre @ s.centre * np.eye(3) - np.outer(s.centre, s.centre) for s in segments]
        moved = sum(s.inertia + s.mass * shift for s, shift in zip(segments, steiner, strict=True))
        return sum(s.mass for s in segments), sum(s.mass * s.centre for s in segments), moved

    for mine, whole in zip(sums([p.segment for p in pieces(TAPERED, chain, CUTS)]), sums(chain.segments), strict=True):
        assert mine == pytest.approx(whole, rel=1e-9, abs=1e-9)


def swinging(**beam):
    """A flexible pendulum: a beam hinged about y at its root, let go from the horizontal with bent hinges."""
    model = fw.Assembly("flexible pendulum")
    model.world, model.joint = World(gravity=G), Revolute(n=(0, 1, 0), phi_start=np.pi / 2)
    model.tilt = FixedRotation(n=(0, 0, 1), angle=0.4)
    model.beam, model.head = Beam(table=TAPERED, hinges=3, **beam), RigidBody(mass=40.0, inertia=2.0 * np.eye(3))
    for a, b in ((model.world.frame, model.joint.frame_a), (model.joint.frame_b, model.tilt.frame_a),
                 (model.tilt.frame_b, model.beam.frame_a), (model.beam.frame_b, model.head.frame_a)):  # fmt: skip
        model.connect(a, b)
    return model


START = {"beam.hinge_1.bending.phi_x": 0.05, "beam.hinge_2.bending.phi_y": -0.04, "beam.hinge_3.bending.w_x": 0.5,
         "joint.w": 1.5}  # fmt: skip


def test_dynamic_loads_are_the_rate_of_momentum_beyond_the_cut():
    """Force and moment at a cut of a swinging, bending beam: d/dt of the momentum beyond it, less its weight.

    The momenta are summed here from positions and velocities of the pieces; the moment is about the moving cut, so that
    dL/dt + v_cut x P = M - weight moment. Derivatives by differences of fourth order in a fine output grid.
    """
    cut, h = 4.2, 5e-4
    model = swinging(cuts=[cut], stiffness_factor=0.1)
    plant = fw.load(model).compile()
    result = plant.simulate(0.05, output_step=h, start=plant.initial_state(start=START), tolerance=1e-10)
    chain = pieces(TAPERED, divide(TAPERED, 3, "loaded_tip"), [cut])
    origins, origin = [], np.zeros(3)
    for piece in chain:
        origin = piece.root if piece.hinge or piece.cut else origin
        origins.append(origin)
    first = next(i for i, p in enumerate(chain) if p.cut)
    bodies = [(f"beam.{p.name}", p.segment.mass, p.segment.inertia, p.segment.centre - o)
              for p, o in zip(chain[first:], origins[first:], strict=True)]  # fmt: skip
    bodies.append(("head", 40.0, 2.0 * np.eye(3), np.zeros(3)))
    here = np.asarray(result["beam.cut_1.frame_a.r"])
    P, L, mass, weight = 0.0, 0.0, 0.0, 0.0
    for path, m, inertia, r_cm in bodies:
        v, w, R, r = (np.asarray(result[f"{path}.{name}"]) for name in ("v", "frame_a.w", "frame_a.R", "frame_a.r"))
        arm = r + R @ r_cm - here
        P = P + m * v
        L = L + np.einsum("tij,tj->ti", R @ inertia @ R.transpose(0, 2, 1), w) + m * np.cross(arm, v)
        mass, weight = mass + m, weight + m * np.cross(arm, (0, 0, -G))

    def rate(y):
        return (8 * (y[3:-1] - y[1:-3]) - (y[4:] - y[:-4])) / (12 * h)

    R = np.asarray(result["beam.cut_1.frame_a.R"])[2:-2].transpose(0, 2, 1)
    force = np.einsum("tij,tj->ti", R, rate(P) - mass * np.array([0, 0, -G]))
    moment = np.einsum("tij,tj->ti", R, rate(L) + np.cross(rate(here), P[2:-2]) - weight[2:-2])
    for found, expected in (("force", force), ("moment", moment)):
        values = np.asarray(result[f"beam.cut_{found}[0]"])[2:-2]
        assert np.ptp(values, axis=0)[:2].min() > 0.05 * np.abs(values).max()  # it moves
        assert values == pytest.approx(expected, abs=2e-5 * np.abs(expected).max())


def test_cuts_change_nothing_else():
    """The same motion with and without cuts, and the loads of a cut just beyond the root are those of the root."""
    plants = [fw.load(swinging(cuts=cuts)).compile() for cuts in ([], [1e-9, 6.0, 7.0])]
    runs = [p.simulate(0.3, output_step=0.1, start=p.initial_state(start=START), tolerance=1e-9) for p in plants]
    assert plants[0].dae.x.shape == plants[1].dae.x.shape
    for name in ("joint.phi", "beam.deflection", "beam.root_moment"):
        whole, parted = (np.asarray(run[name]) for run in runs)
        assert parted == pytest.approx(whole, rel=1e-5, abs=1e-6 * np.abs(whole).max())
    root, near = (np.asarray(runs[1][f"beam.{name}"]) for name in ("root_moment", "cut_moment[0]"))
    assert near == pytest.approx(root, rel=1e-6, abs=1e-6 * np.abs(root).max())


def test_a_spinning_rod_pulls_at_its_cuts():
    """A free rod that spins about its middle: tension at s from its end is mu w^2 (L s - s^2) / 2."""
    mu, length, spin = 3.0, 8.0, 2.0
    model = fw.Assembly("spinning rod")
    model.world, model.motion = World(gravity=0.0), FreeMotion(
        angle_rates_start=(0, spin, 0), velocity_start=(-spin * length / 2, 0, 0)
    )
    model.rod = Beam(table=BeamProperties.uniform(length, mu, 1e9), hinges=0, cuts=[1.0, 4.0, 7.5])
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.rod.frame_a)
    state = fw.load(model).compile().initial_state()
    for k, s in enumerate([1.0, 4.0, 7.5]):
        assert state[f"rod.cut_force[{k}]"] == pytest.approx([0, 0, -mu * spin**2 * (length - s) * s / 2], abs=1e-6)


def test_loads_in_the_axes_of_the_section():
    """A twisted, swept beam: principal axes and tangent at the cut, against the same loads in the segment's axes."""
    z = np.linspace(0, 10, 21)
    table = BeamProperties(z, 50.0, 9e7, 7e7, twist=np.linspace(0.6, 0.0, 21), reference_x=0.01 * z**2)
    loads = {}
    for axes in ("segment", "section"):
        model = fw.Assembly("bent beam")
        model.world, model.base = World(gravity=G), Fixed(angles=(0.3, np.pi / 2, 0))
        model.beam = Beam(table=table, hinges=0, cuts=[5.0], cut_axes=axes)
        model.connect(model.base.frame, model.beam.frame_a)
        state = fw.load(model).compile().initial_state()
        loads[axes] = np.ravel(state["beam.cut_moment[0]"])
    tangent = np.array([0.1, 0, 1]) / np.hypot(0.1, 1)
    x = np.array([np.cos(0.3), -np.sin(0.3), 0])
    x = x - tangent * (x @ tangent)
    x /= np.linalg.norm(x)
    expected = [axis @ loads["segment"] for axis in (x, np.cross(tangent, x), tangent)]
    assert loads["section"] == pytest.approx(expected, rel=1e-5, abs=1e-5 * np.abs(expected).max())


def test_a_node_at_a_cut_belongs_to_the_root_side():
    found = []
    for node in (5.0, 5.0 + 1e-9):
        model = level(0, cuts=[5.0], node_points=[node])
        model.load = PointMass(mass=7.0)
        model.connect(model.beam.nodes[0], model.load.frame_a)
        state = fw.load(model).compile().initial_state()
        found.append(float(state["beam.cut_force[0]"][0]))
        assert state["beam.root_force"][0] == pytest.approx(-G * (beyond(TAPERED, 0)[0] + 7.0), rel=1e-6)
    assert found[0] - found[1] == pytest.approx(7.0 * G, rel=1e-6)


def test_a_cut_off_the_beam():
    with pytest.raises(ParameterError, match=r"cut 2 at 10\.5 m is off the beam of 10 m"):
        Beam(table=TAPERED, cuts=[1.0, 10.5])
