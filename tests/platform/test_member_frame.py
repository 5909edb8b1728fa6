"""The frame of a hull: it weighs what the hull does, bends as its beams, and carries what lies on it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.members import Fill, Lump, MemberShape, Plate
from fowtlib.language.errors import ParameterError


def tube(name, start, end, diameter, wall=0.05, **others):
    length = math.dist(start, end)
    sizes = ((diameter, diameter),) * 2
    return MemberShape(name, start, end, (0.0, length), sizes, True, (wall, wall), 7850.0, **others)


def rigid(nodes):
    """Displacements (6, n, 6) of the rigid motions about the origin."""
    moved = np.zeros((6, len(nodes), 6))
    for k in range(3):
        axis = np.eye(3)[k]
        moved[k, :, :3] = axis
        moved[3 + k, :, :3], moved[3 + k, :, 3:] = np.cross(axis, nodes), axis
    return moved


def mass_of(frame):
    """Mass (6, 6) of the frame about the origin."""
    moved = rigid(frame.nodes).reshape(6, -1)
    return moved @ (frame.mass @ moved.T)


def expected_mass(body):
    x, y, z = body.centre
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.block([[body.mass * np.eye(3), -body.mass * skew], [body.mass * skew, body.about((0, 0, 0))]])


def semi():
    """Three columns, a pontoon between each two, and a braced tower foot."""
    columns = [(30 * math.cos(a), 30 * math.sin(a)) for a in np.radians([0, 120, 240])]
    members = [
        tube(f"column {k}", (x, y, -20.0), (x, y, 12.0), 10.0, fills=(Fill(f"water {k}", 1025.0, -14.0, 0.05, 20.0),),
             plates=(Plate(f"floor {k}", 0.0, 0.05, 7850.0), Plate(f"deck {k}", 32.0, 0.05, 7850.0)))
        for k, (x, y) in enumerate(columns)
    ]  # fmt: skip
    for k in range(3):
        (x, y), (u, v) = columns[k], columns[(k + 1) % 3]
        members.append(tube(f"pontoon {k}", (x, y, -17.0), (u, v, -17.0), 3.0, 0.03))
        members.append(tube(f"beam {k}", (x, y, 9.0), (0.0, 0.0, 9.0), 2.5, 0.03))
    members.append(tube("foot", (0.0, 0.0, 5.0), (0.0, 0.0, 14.0), 6.0, lumps=(Lump("tower", 6e5, (0.0, 0.0, 50.0)),)))
    return Hull(tuple(members))


def test_the_frame_weighs_what_the_hull_does():
    hull = semi()
    frame = MemberFrame(hull, 6.0)
    found, expected = mass_of(frame.frame), expected_mass(hull.mass)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=2e-3 * abs(expected[3, 3]))
    assert found[0, 0] == pytest.approx(hull.mass.mass, rel=1e-9)


@pytest.mark.parametrize("name", ["oc4_semi_unmoored", "volturnus_unmoored", "oo_star_unmoored"])
def test_shipped_floaters_have_a_frame_of_their_mass(name):
    from fowtlib import models

    hull = fw.load(str(list(models.__path__)[0]) + f"/platforms/{name}.yaml").root.find("hull").hull()
    frame = MemberFrame(hull, 5.0)
    assert mass_of(frame.frame)[0, 0] == pytest.approx(hull.mass.mass, rel=1e-6)
    modes = frame.frame.modes(8)
    assert modes.frequencies[5] < 1e-3 * modes.frequencies[6] < modes.frequencies[6]


def test_finer_pieces_change_little():
    lowest = [MemberFrame(semi(), longest).frame.modes(8).frequencies[6] for longest in (8.0, 3.0)]
    assert lowest[0] == pytest.approx(lowest[1], rel=0.01)


def test_a_beam_ends_at_the_surface_of_a_column():
    """A pontoon to the axis of a stiff column is a cantilever from its surface, and turns as the column there."""
    column = tube("column", (0, 0, -15.0), (0, 0, 5.0), 8.0, 1.0)
    pontoon = tube("pontoon", (0, 0, -10.0), (40, 0, -10.0), 2.0)
    frame = MemberFrame(Hull((column, pontoon)), 5.0)
    held = np.zeros((len(frame.frame.nodes), 6), dtype=bool)
    held[frame.node_at((0, 0, -15.0))] = held[frame.node_at((0, 0, 5.0))] = True
    tip = frame.node_at((40, 0, -10.0))
    loads = np.zeros((len(frame.frame.nodes), 6))
    loads[tip, 1] = 1e4
    moved = frame.frame.static(loads, held)
    section = frame.frame.beams[-1].section
    assert frame.pieces[-1].member == 1
    bent, sheared = section.young_modulus * section.about_first, section.shear_modulus * section.shear_first
    free = 36.0**3 / (3 * bent) + 36.0 / sheared
    root = moved[frame.node_at((0, 0, -10.0))]
    assert moved[tip, 1] == pytest.approx(1e4 * free + root[1] + 40 * root[5], rel=1e-6)
    assert abs(40 * root[5]) < 0.05 * moved[tip, 1]


def test_points_move_with_the_section_that_carries_them():
    hull = semi()
    frame = MemberFrame(hull, 6.0)
    points = np.array([[35.0, 0, -10.0], [15.0, 0, 9.0 + 1.25], [0, 0, 14.0], [0, 3.0, 7.0]])
    moved = rigid(frame.frame.nodes)
    found = frame.field(points, moved)
    np.testing.assert_allclose(found.displacement, rigid(points)[:, :, :3], atol=1e-9)
    np.testing.assert_allclose(frame.turn(points, moved), rigid(points)[:, :, 3:], atol=1e-9)
    assert np.abs(found.gradient + np.swapaxes(found.gradient, 2, 3)).max() < 1e-9  # no strain
    with pytest.raises(ParameterError, match=r"the point \(0, 0, -60\) m is off the hull"):
        frame.field([[0, 0, -60.0]], moved)


def test_gradients_are_those_of_the_field():
    frame = MemberFrame(semi(), 6.0)
    shapes = frame.frame.modes(9).shapes[6:]
    points = np.array([[33.0, 3.0, -10.3], [15.0, 0.5, 10.0], [1.0, 2.0, 12.0]])
    gradient = frame.field(points, shapes).gradient
    for j in range(3):
        step = 1e-5 * np.eye(3)[j]
        ahead, behind = (frame.field(points + sign * step, shapes).displacement for sign in (1, -1))
        np.testing.assert_allclose(gradient[..., j], (ahead - behind) / 2e-5, rtol=1e-5, atol=1e-10)


def test_mistakes_are_named():
    with pytest.raises(ParameterError, match="pontoon has no wall"):
        column = tube("column", (0, 0, -9.0), (0, 0, 9.0), 8.0)
        MemberFrame(Hull((column, tube("pontoon", (0, 0, 0), (30, 0, 0), 2.0, 0.0))), 5)
    apart = Hull((tube("one", (0, 0, -9.0), (0, 0, 9.0), 8.0), tube("other", (30, 0, -9.0), (30, 0, 9.0), 8.0)))
    with pytest.raises(ParameterError, match="falls into 2 pieces"):
        MemberFrame(apart, 5)
