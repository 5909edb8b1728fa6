"""Loads in the sections of a frame, at rest and in motion, and the stiffness that loads give it, in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fowtlib.components.hydro.deformation import pressure_stiffness, quadrature
from fowtlib.components.platform.frame_loads import (
    SectionRecovery,
    check_on_axes,
    stiffness_by_loads,
    water_at_rest,
    weight_at_rest,
)
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.members import Lump
from fowtlib.components.platform.space_frame import Beam, NodeMass, Section, SpaceFrame, rigid_motions
from fowtlib.language.errors import ParameterError
from tests.platform.test_member_frame import semi, tube

G, RHO = 9.80665, 1025.0


def shapes_of(frame, count):
    return frame.modes(6 + count).shapes[6:]


@pytest.fixture(scope="module")
def rod():
    return MemberFrame(Hull((tube("rod", (-40, 0, 0), (40, 0, 0), 2.0),)), 2.0)


def test_a_free_beam_that_is_pushed_has_the_loads_of_its_inertia(rod):
    """A force F across at the end: Q = F (3 s^2 - 2 s), M = F L s^2 (1 - s), with s from the other end."""
    places = [[x, 0, 0] for x in (-31.0, -11.0, 1.0, 21.0, 39.0)]
    for count in (1, 5):  # whatever the shapes leave is added
        shapes = shapes_of(rod.frame, count)
        recovery = SectionRecovery(rod, shapes, places)
        on_shapes = shapes[:, rod.node_at((40, 0, 0)), 2]  # of modal mass 1
        stiffness = np.einsum("ki,ij,kj->k", shapes.reshape(count, -1), rod.frame.stiffness.toarray(),
                              shapes.reshape(count, -1))  # fmt: skip
        q = 1e5 * on_shapes / stiffness
        found = np.einsum("k,ksa->sa", q, recovery.by_shapes()) + 1e5 * recovery.by_points([[40.0, 0, 0]])[0, 2]
        for (x, _, _), axes, load in zip(places, recovery.axes(), found, strict=True):
            share = (x + 40) / 80  # of what is before the section
            ahead = 1 - share
            force = 1e5 * (3 * share**2 - 2 * share)
            assert (axes @ load[:3])[2] == pytest.approx(force, abs=0.002 * 1e5)
            # the end accelerates by 4 F / m upwards, the other by 2 F / m downwards
            moment = 1e5 * 80 * ahead * share**2
            assert (axes @ load[3:])[1] == pytest.approx(-moment, rel=0.01, abs=2e3)


def test_the_mode_displacement_alone_converges_to_it(rod):
    """Without what the shapes leave, the moment in the middle comes closer with their number, slowly."""
    apart = []
    for count in (4, 24):
        shapes = shapes_of(rod.frame, count)
        recovery = SectionRecovery(rod, shapes, [[0.0, 0, 0]])
        on_shapes = shapes[:, rod.node_at((40, 0, 0)), 2]
        stiffness = np.diag(shapes.reshape(count, -1) @ (rod.frame.stiffness @ shapes.reshape(count, -1).T))
        moment = np.einsum("k,ka->a", on_shapes / stiffness, recovery.by_shapes()[:, 0])[4]
        apart.append(abs(abs(moment) / (80 / 8) - 1))
    assert apart[1] < 0.5 * apart[0] < 0.5


def test_a_hull_at_rest_hangs_in_its_buoyancy():
    """Load by load: pressure carries the volume at its centre; still water bends a barge that is heavy at its ends."""
    hull = semi()
    structure = MemberFrame(hull, 6.0)
    water = water_at_rest(structure, hull.panels(5.0))
    moments = (np.cross(structure.frame.nodes, water[:, :3]) + water[:, 3:]).sum(axis=0)
    total = np.concatenate([water[:, :3].sum(axis=0), moments])
    volume = hull.buoyancy.volume
    points, normal = quadrature(hull.panels(5.0))
    assert total[2] == pytest.approx(points[:, 2] @ normal[:, 2], rel=1e-9)
    assert total[2] == pytest.approx(volume, rel=0.12)  # facets of 5 m are not round
    assert np.abs(total[[0, 1, 3, 4, 5]]).max() < 1e-4 * volume * 30
    weight = weight_at_rest(structure.frame, G)
    assert weight[:, 2].sum() == pytest.approx(-hull.mass.mass * G, rel=1e-9)


def test_still_water_bends_a_beam_with_heavy_ends():
    """Even buoyancy of a rod, and half of the weight in each end: M = W L / 8 in the middle, in hogging."""
    heavy = [Lump(f"end {x:g}", 4e5, (x, 0.0, -1.0)) for x in (-40.0, 40.0)]
    hull = Hull((tube("rod", (-40, 0, -1.0), (40, 0, -1.0), 2.0, 1e-4, lumps=tuple(heavy)),))
    structure = MemberFrame(hull, 2.0)
    water = water_at_rest(structure, hull.panels(1.0))
    scale = 8e5 * G / water[:, 2].sum()
    loads = scale * water + weight_at_rest(structure.frame, G)
    recovery = SectionRecovery(structure, structure.frame.modes(7).shapes[6:], [[0.0, 0, -1.0], [20.0, 0, -1.0]])
    shapes = structure.frame.modes(7).shapes[6:]
    q = (shapes * loads).sum() / float(shapes.reshape(-1) @ (structure.frame.stiffness @ shapes.reshape(-1)))
    found = q * recovery.by_shapes()[0] + recovery.by_loads(loads[None])[0]
    moment = 8e5 * G * 80 / 8
    assert abs(found[0, 4]) == pytest.approx(moment, rel=0.02)
    assert abs(found[1, 4]) == pytest.approx(moment * 0.75, rel=0.02)


def test_a_column_under_its_top_weight_buckles_where_euler_says():
    """Free at both ends of its turns: pushed by weight from above and water from below, pi^2 EI / L^2."""
    section = Section(0.2, 0.1, 0.1, 0.2, 210e9, 80e9, 1e-3, 1e-3)
    length = 60.0
    nodes = np.linspace(0, length, 13)[:, None] * [0.0, 0.0, 1.0]
    euler = math.pi**2 * section.young_modulus * section.about_first / length**2
    frame = SpaceFrame(nodes, [Beam(k, k + 1, section) for k in range(12)], [NodeMass(0, 1e3), NodeMass(12, 1e3)])
    held = np.zeros((13, 6), dtype=bool)
    held[[0, -1], :2] = True
    held[0, [2, 5]] = True
    loads = np.zeros((13, 6))
    loads[0, 2], loads[-1, 2] = euler, -euler
    free = ~held.reshape(-1)
    added = stiffness_by_loads(frame, loads, 0.0)
    for share, sign in ((0.999, 1), (1.001, -1)):
        lowest = np.linalg.eigvalsh((frame.stiffness + share * added).toarray()[np.ix_(free, free)])[0]
        assert np.sign(lowest) == sign


def test_a_mass_above_its_node_topples_it():
    frame = SpaceFrame([[0, 0, 0], [5, 0, 0]], [Beam(0, 1, Section.tube(2.0, 0.03, 1.0, 210e9, 80e9))],
                       [NodeMass(1, 1e4, (1.0, 0.0, 3.0))])  # fmt: skip
    added = stiffness_by_loads(frame, np.zeros((2, 6)), G).toarray()[9:, 9:]

    def energy(turn):
        angle = np.linalg.norm(turn)
        axis, arm = np.asarray(turn) / angle, np.array([1.0, 0.0, 3.0])
        moved = (
            arm * math.cos(angle) + np.cross(axis, arm) * math.sin(angle) + axis * (axis @ arm) * (1 - math.cos(angle))
        )
        return 1e4 * G * (moved[2] - arm[2] - np.cross(turn, arm)[2])

    for turn in ([1e-3, 0, 0], [0, 1e-3, 0], [1e-3, 2e-4, 3e-4]):
        assert np.array(turn) @ added @ turn / 2 == pytest.approx(energy(turn), rel=1e-3)


def resting(structure, shapes, size):
    """Stiffness (m, m) that still water on panels of a size and all at rest give shapes: of the water, and the sum."""
    panels = structure.hull.panels(size)
    water = RHO * G * pressure_stiffness(panels, lambda points: structure.field(points, shapes))
    loads = RHO * G * water_at_rest(structure, panels) + weight_at_rest(structure.frame, G)
    rows = shapes.reshape(len(shapes), -1)
    return water, water + rows @ (stiffness_by_loads(structure.frame, loads, G) @ rows.T)


def floating_rod(start, end, share=1.0, **others):
    """A thin closed tube of 4 m and 50 m, as heavy as so much of the water that it displaces."""
    outer, inner = math.pi / 4 * 4.0**2, math.pi / 4 * 3.9**2
    one = tube("rod", start, end, 4.0, **others)
    return MemberFrame(Hull((replace(one, density=share * RHO * outer / (outer - inner)),)), 2.0)


def by_effective_tension(rod, shapes, tension):
    """Of a round rod of 4 m: int T_e v' v' ds in both planes, less int p A g g where beams shear by g = v' - turn.

    Bent, it displaces less on its inner side: rho g I of the circle on the turns of its lower end, minus above.
    The moment of the pressure on a section that is not level, rho g I, stands where it is; that of the walls, which
    bears it, rolls with the section: M int theta b' ds of the roll theta and the turn b about the rising direction.
    """
    expected, area, second = np.zeros((len(shapes), len(shapes))), math.pi / 4 * 4.0**2, math.pi / 64 * 4.0**4
    for beam in range(len(rod.frame.beams)):
        one, two = (rod.frame.place(beam, share) for share in (0.0, 1.0))
        along = np.linalg.norm(two - one)
        for share in (0.5 - 0.5 / math.sqrt(3), 0.5 + 0.5 / math.sqrt(3)):
            place, motion, rate = rod.frame.section_motion(beam, share, shapes)
            axis = rod.frame.direction(beam)
            slope = rate[:, :3] - np.outer(rate[:, :3] @ axis, axis)
            shear = slope - np.cross(motion[:, 3:], axis)
            pull, squeeze = tension(place), -RHO * G * place[2] * area
            expected += along / 2 * (pull * slope @ slope.T - squeeze * shear @ shear.T)
            rising = np.array([0, 0, 1.0]) - axis * axis[2]
            rolled = RHO * G * second * np.outer(motion[:, 3:] @ axis, rate[:, 3:] @ rising)
            expected += along / 2 * (rolled + rolled.T)
    for beam, share, sign in ((0, 0.0, 1), (len(rod.frame.beams) - 1, 1.0, -1)):
        turn = np.cross(rod.frame.section_motion(beam, share, shapes)[1][:, 3:], rod.frame.direction(beam))
        expected += sign * RHO * G * rod.frame.direction(beam)[2] * second * turn @ turn.T
    return expected


@pytest.mark.parametrize(
    ("start", "end"), [((0, 0, -260), (0, 0, -210)), ((0, 0, -60), (30, 20, -20)), ((-25, 0, -40), (25, 0, -40))]
)
def test_a_rod_as_heavy_as_the_water_bends_at_any_depth_as_without(start, end):
    """Its effective tension is zero (C.P. Sparks, 1984): pressure adds nothing to bending and torsion, at any lean.

    Within 0.1 % of what the pressure alone does. Without what it does around the sections half of that was left, and
    all of it in torsion; without the walls' moment that rolls, up to 0.5 % off the diagonal, with panels of any size.
    Between the first and the second pair panels of 2, 1 and 0.5 m leave 0.21, 0.08 and 0.02 %.
    """
    rod = floating_rod(start, end)
    shapes = shapes_of(rod.frame, 5)
    water, both = resting(rod, shapes, 1.0)
    assert water[0, 0] > 0.004 * rod.frame.modes(7).frequencies[6] ** 2
    expected = by_effective_tension(rod, shapes, lambda place: 0.0)
    np.testing.assert_allclose(both, expected, atol=0.001 * np.abs(water).max())
    assert np.abs(expected).max() < 0.03 * np.abs(water).max()


def test_a_rod_with_a_weight_below_has_its_effective_tension():
    """T_e = W - (b - w) s upwards from the weight, W a fifth of the buoyancy: 0.5 %.

    Of the first pair of shapes. Between it and the second pair 1.2 % is left, 0.4 % with panels half as wide.
    """
    extra = 0.2 * RHO * math.pi / 4 * 4.0**2 * 50
    rod = floating_rod((0, 0, -70), (0, 0, -20), 0.8, lumps=(Lump("weight", extra, (0.0, 0.0, -70.0)),))
    shapes = shapes_of(rod.frame, 2)
    _, found = resting(rod, shapes, 1.0)
    expected = by_effective_tension(rod, shapes, lambda place: extra * G * (1 - (place[2] + 70) / 50))
    np.testing.assert_allclose(found, expected, atol=0.005 * expected.max())


def test_a_frame_that_turns_as_one_has_the_restoring_of_the_rigid_hull():
    """Pressure, weight and the stresses by both: rho g (I + V z_B) - m g z_G in roll and pitch, nothing in yaw."""
    hull = semi()
    body, water, foot = hull.mass, hull.buoyancy, hull.members[-1]
    lump = Lump("tower", foot.lumps[0].mass + RHO * water.volume - body.mass, (0.0, 0.0, 20.0))
    hull = Hull((*hull.members[:-1], replace(foot, lumps=(lump,))))
    structure = MemberFrame(hull, 4.0)
    alone, found = resting(structure, rigid_motions(structure.frame.nodes), 2.5)
    moment = RHO * G * water.volume * water.centre[2] - hull.mass.mass * G * hull.mass.centre[2]
    expected = RHO * G * water.waterplane + np.diag([0, 0, 0, moment, moment, 0])
    np.testing.assert_allclose(found, expected, atol=0.01 * alone[3, 3])
    assert found[3, 3] == pytest.approx(expected[3, 3], rel=0.01)


def test_sections_are_on_members():
    structure = MemberFrame(semi(), 6.0)
    check_on_axes(structure, [[15.0, 0, 9.0]], "floater.section_points")
    with pytest.raises(ParameterError, match=r"floater.section_points: the point \(15, 0, 10\) m lies on no beam"):
        check_on_axes(structure, [[15.0, 0, 10.0]], "floater.section_points")
    with pytest.raises(ParameterError, match=r"^floater.section_points: the point \(0, 90, 0\) m lies on no beam"):
        check_on_axes(structure, [[0, 90.0, 0]], "floater.section_points")  # off the hull
