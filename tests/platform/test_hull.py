"""The geometry of hulls of members against closed forms, and against itself in other orders and directions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fowtlib.components.hydro.panel_mesh import Column, Pontoon, floater_mesh, hydrostatics
from fowtlib.components.platform.convex import gap, inside
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.members import Fill, Lump, MemberShape, Plate, below, enclosed
from fowtlib.components.platform.solids import piece, point, together
from fowtlib.language.errors import ParameterError

RHO, G = 1025.0, 9.80665
POLYGON = 1e-5  # error of second moments of the polygon that stands for a circle: (2 pi / 32)^4 / 180 = 8.3e-6


def member(name, start, end, sizes, walls=(), stations=None, **more):
    """A member with as many stations as sizes, equally far apart, or at the fractions given."""
    length = math.dist(start, end)
    sizes = [(size, size) if np.ndim(size) == 0 else tuple(size) for size in sizes]
    fractions = np.linspace(0, 1, len(sizes)) if stations is None else np.array(stations)
    places = tuple(float(s) for s in fractions * length)
    walls = tuple(np.broadcast_to(walls, len(sizes))) if np.size(walls) else ()
    ends = (tuple(map(float, point)) for point in (start, end))
    return MemberShape(name, *ends, places, tuple(sizes), walls=walls, **more)


def tube(name, start, end, diameter, **more):
    return member(name, start, end, (diameter, diameter), **more)


def box(name, start, end, width, height, **more):
    return member(name, start, end, [(width, height)] * 2, is_round=False, **more)


# --- closed forms of pieces ------------------------------------------------------------------------------------------


def test_a_solid_cone_has_the_volume_centre_and_inertia_of_the_textbook():
    """V = pi r^2 h / 3, centre at h / 4, I = 3/10 m r^2 and 3/80 m (4 r^2 + h^2) about the centre."""
    cone = piece((0, 0, 0), (0, 0, 9), np.eye(3), ((4, 4), (0, 0)), True, density=2.0)
    mass = 2 * math.pi * 4 * 9 / 3
    assert cone.mass == pytest.approx(mass)
    assert cone.centre == pytest.approx([0, 0, 9 / 4])
    assert np.diag(cone.inertia) == pytest.approx([3 / 80 * mass * (16 + 81)] * 2 + [3 / 10 * mass * 4])


def test_a_frustum_is_a_large_cone_less_a_small_one():
    large = piece((0, 0, 0), (0, 0, 12), np.eye(3), ((6, 6), (0, 0)), True)
    small = piece((0, 0, 8), (0, 0, 12), np.eye(3), ((2, 2), (0, 0)), True)
    found = piece((0, 0, 0), (0, 0, 8), np.eye(3), ((6, 6), (2, 2)), True)
    wanted = together([large, small.times(-1)])
    assert found.mass == pytest.approx(math.pi * 8 / 12 * (36 + 12 + 4))
    assert found.centre == pytest.approx(wanted.centre)
    np.testing.assert_allclose(found.inertia, wanted.inertia, rtol=1e-12, atol=1e-9)


def test_a_box_and_a_pyramid_have_the_inertia_of_the_textbook():
    axes = np.eye(3)
    brick = piece((1, 2, 3), (1, 2, 8), axes, ((2, 4), (2, 4)), False)
    assert brick.mass == pytest.approx(40) and brick.centre == pytest.approx([1, 2, 5.5])
    assert np.diag(brick.inertia) == pytest.approx([40 * (16 + 25) / 12, 40 * (4 + 25) / 12, 40 * (4 + 16) / 12])
    pyramid = piece((0, 0, 0), (0, 0, 6), axes, ((2, 2), (0, 0)), False)
    assert pyramid.mass == pytest.approx(8) and pyramid.centre[2] == pytest.approx(1.5)
    assert pyramid.inertia[2, 2] == pytest.approx(8 * 4 / 10)  # m a^2 / 10


def test_the_inertia_about_another_point_is_steiner_s():
    moved = together([point(2.0, (3, 0, 0)), point(2.0, (-3, 0, 0)), point(1.0, (0, 0, 5))])
    assert moved.centre == pytest.approx([0, 0, 1])
    assert np.diag(moved.about((0, 0, 0))) == pytest.approx([25, 36 + 25, 36])


def test_a_polyhedron_has_the_inertia_of_the_piece_that_it_stands_for():
    for one in (member("cone", (1, 2, -9), (5, 2, -3), (6.0, 3.0)), box("pontoon", (0, 0, -5), (3, 9, 2), 4.0, 2.0)):
        exact, flat = one.solid(0, math.inf), enclosed([facet.corners for facet in one.bodies(0)[0].facets])
        assert flat.mass == pytest.approx(exact.mass, rel=1e-12)
        assert flat.centre == pytest.approx(exact.centre, abs=1e-9)
        np.testing.assert_allclose(flat.inertia, exact.inertia, atol=POLYGON * np.abs(exact.inertia).max())


# --- structure and ballast -------------------------------------------------------------------------------------------


def test_the_wall_of_a_tube_and_its_bulkhead():
    one = tube("leg", (0, 0, -10), (0, 0, 10), 6.0, walls=0.05, density=7850.0,
               plates=(Plate("plate", 5.0, 0.02, 8000.0),), lumps=(Lump("pump", 3e3, (1.0, 0, 4.0)),))  # fmt: skip
    hull = Hull((one,))
    wall, plate = 7850 * math.pi / 4 * (6**2 - 5.9**2) * 20, 8000 * math.pi / 4 * 5.9**2 * 0.02
    assert hull.structure.mass == pytest.approx(wall + plate + 3e3)
    assert hull.structure.centre * hull.structure.mass == pytest.approx([3e3, 0, -5 * plate + 4 * 3e3])


@pytest.mark.parametrize("upright", [True, False])
def test_ballast_in_a_cylinder(upright):
    """Upright to a third of its height; lying, to half of its diameter, the centre of which is at 4 r / 3 pi."""
    if upright:
        one = tube("leg", (0, 0, -9), (0, 0, 3), 4.2, walls=0.1, fills=(Fill("leg.w", 1000.0, -5.0, 0.0, 12.0),))
        volume, centre = math.pi * 4 * 4, [0, 0, -7.0]
    else:
        one = tube("leg", (0, 0, -9), (12, 0, -9), 4.2, walls=0.1, fills=(Fill("leg.w", 1000.0, -9.0, 2.0, 12.0),))
        volume, centre = math.pi * 2 * 10, [7.0, 0, -9 - 8 / (3 * math.pi)]
    water = Hull((one,)).fills["leg.w"]
    assert water.mass == pytest.approx(1000 * volume, rel=1e-6)
    assert water.centre == pytest.approx(centre, abs=2e-3)
    full = Hull((replace(one, fills=(replace(one.fills[0], level=3.0 if upright else -7.0),)),))
    volume = math.pi * 4 * (12 if upright else 10)
    assert full.fills["leg.w"].mass == pytest.approx(1000 * volume, rel=1e-6)


def test_ballast_above_its_tank_is_named_with_its_numbers():
    one = tube("leg", (0, 0, -9), (0, 0, 3), 4.2, walls=0.1, fills=(Fill("leg.w", 1000.0, -1.0, 0.0, 6.0),))
    with pytest.raises(ParameterError, match=r"leg.w.*z = -1 m is above its tank.*z = -9 m to -3 m"):
        Hull((one,)).mass  # noqa: B018
    with pytest.raises(ParameterError, match=r"from 0 m to 13 m is not within"):
        Hull((replace(one, fills=(replace(one.fills[0], high=13.0),)),)).mass  # noqa: B018


# --- hydrostatics ----------------------------------------------------------------------------------------------------


def test_an_upright_cylinder_in_the_water():
    water = Hull((tube("leg", (3, -2, -20), (3, -2, 10), 6.0),)).buoyancy
    area, second = math.pi * 9, math.pi * 81 / 4
    assert water.volume == pytest.approx(20 * area)
    assert water.centre == pytest.approx([3, -2, -10])
    W = water.waterplane
    assert [W[2, 2], W[2, 3], W[2, 4]] == pytest.approx([area, -2 * area, -3 * area])
    assert [W[3, 3], W[4, 4], W[3, 4]] == pytest.approx([second + 4 * area, second + 9 * area, 6 * area], rel=POLYGON)
    C = water.stiffness(RHO, G)
    assert C[2, 2] == pytest.approx(RHO * G * area) and C[4, 4] == pytest.approx(RHO * G * (W[4, 4] - 200 * area))
    assert [C[3, 5], C[4, 5]] == pytest.approx([-RHO * G * 20 * area * 3, RHO * G * 20 * area * 2])


@pytest.mark.parametrize("angle", [20.0, 50.0])
def test_an_inclined_cylinder_cut_by_the_water(angle):
    """Its wet length along the axis counts for the volume; the waterplane is an ellipse, a = r / cos(angle)."""
    lean = np.radians(angle)
    direction = np.array([math.sin(lean), 0, math.cos(lean)])
    water = Hull((tube("brace", tuple(-20 * direction), tuple(15 * direction), 2.0),)).buoyancy
    area = math.pi / math.cos(lean)
    assert water.volume == pytest.approx(20 * math.pi)
    # the wet length is L + x' tan(angle), x' across the axis and downwards: moments of it over the section
    along = -10 + math.tan(lean) ** 2 / (8 * 20)
    across = math.tan(lean) / (4 * 20)
    wanted = along * direction + across * np.array([math.cos(lean), 0, -math.sin(lean)])
    assert water.centre == pytest.approx(wanted, abs=POLYGON)
    W = water.waterplane
    assert W[2, 2] == pytest.approx(area)
    assert [W[3, 3], W[4, 4]] == pytest.approx([area / 4, area / 4 / math.cos(lean) ** 2], rel=POLYGON)


def test_a_tapered_column_and_a_step():
    spar = member("spar", (0, 0, -120), (0, 0, 10), (9.4, 9.4, 6.5, 6.5), stations=(0, 108 / 130, 116 / 130, 1))
    water = Hull((spar,)).buoyancy
    cone = math.pi / 12 * 8 * (9.4**2 + 9.4 * 6.5 + 6.5**2)
    assert water.volume == pytest.approx(math.pi / 4 * (9.4**2 * 108 + 6.5**2 * 4) + cone, rel=1e-9)  # 8029 m^3, OC3
    assert water.waterplane[2, 2] == pytest.approx(math.pi / 4 * 6.5**2)
    stepped = member("column", (0, 0, -20), (0, 0, 12), (24.0, 24.0, 12.0, 12.0), stations=(0, 6 / 32, 6 / 32, 1))
    assert Hull((stepped,)).buoyancy.volume == pytest.approx(math.pi * (144 * 6 + 36 * 14), rel=1e-9)
    two = (tube("base", (0, 0, -20), (0, 0, -14), 24.0), tube("upper", (0, 0, 12), (0, 0, -14), 12.0))
    assert Hull(two).buoyancy.volume == pytest.approx(math.pi * (144 * 6 + 36 * 14), rel=1e-9)


def test_a_barge():
    barge = box("barge", (-20, 0, -1), (20, 0, -1), 10.0, 6.0)  # from z = -4 m to 2 m
    water = Hull((barge,)).buoyancy
    assert water.volume == pytest.approx(40 * 10 * 4) and water.centre == pytest.approx([0, 0, -2])
    assert water.waterplane[3, 3] == pytest.approx(40 * 10**3 / 12)
    assert water.waterplane[4, 4] == pytest.approx(10 * 40**3 / 12)
    turned = Hull((replace(barge, turn=math.pi / 2),)).buoyancy  # 6 m wide, 10 m high: from -6 m
    assert turned.volume == pytest.approx(40 * 6 * 6)


def test_a_pontoon_into_a_column_counts_once():
    """A round pontoon through the middle of a wide column: the part within it is exact by quadrature."""
    column, pontoon = tube("column", (0, 0, -30), (0, 0, 5), 10.0), tube("pontoon", (0, 0, -20), (30, 0, -20), 4.0)
    together_ = Hull((column, pontoon)).buoyancy.volume
    y, weight = np.polynomial.legendre.leggauss(200)
    y, weight = 2 * y, 2 * weight
    shared = float(weight @ (2 * np.sqrt(4 - y**2) * np.sqrt(25 - y**2)))
    assert together_ == pytest.approx(math.pi * 25 * 30 + math.pi * 4 * 30 - shared, rel=1e-4)
    mesh = floater_mesh([Column(((-30, 10), (5, 10)))], [Pontoon((0, 0, -20), (30, 0, -20), diameter=4)], 0.5)
    assert together_ == pytest.approx(hydrostatics(mesh)[0], rel=1e-3)


def test_boxes_that_cross_count_once():
    """Two bars of 20 x 4 x 4 m across each other share a cube of 4 m."""
    bars = (box("one", (-10, 0, -9), (10, 0, -9), 4.0, 4.0), box("two", (0, -10, -9), (0, 10, -9), 4.0, 4.0))
    hull = Hull(tuple(replace(bar, walls=(0.1, 0.1), density=1e3) for bar in bars))
    assert hull.buoyancy.volume == pytest.approx(2 * 320 - 64, rel=1e-9)
    assert hull.buoyancy.centre == pytest.approx([0, 0, -9])
    wall = 1e3 * (16 - 3.8**2)
    assert hull.structure.mass == pytest.approx(wall * (2 * 16 + 4))  # half of the crossing for each


def semi(order=None, flip=False, turn=0.0):
    """Three columns with heave plates, pontoons and inclined braces to a central column, turned about z."""
    spin = Rotation.from_euler("z", turn).as_matrix()
    parts = [tube("centre", (0, 0, -18), (0, 0, 8), 7.0, walls=0.04, density=7850.0)]
    for k in range(3):
        x, y = 25 * math.cos(2 * math.pi * k / 3), 25 * math.sin(2 * math.pi * k / 3)
        parts += [
            tube(f"column {k}", (x, y, -16), (x, y, 9), 10.0, walls=0.05, density=7850.0,
                 fills=(Fill(f"column {k}.water", RHO, -9.0, 0.0, 25.0),)),
            tube(f"plate {k}", (x, y, -18), (x, y, -16), 18.0, walls=0.05, density=7850.0),
            box(f"pontoon {k}", (0, 0, -14), (x, y, -14), 3.0, 2.5, walls=0.03, density=7850.0),
            tube(f"brace {k}", (0, 0, -8), (x, y, 7), 1.8, walls=0.02, density=7850.0),
        ]  # fmt: skip
    moved = []
    for part in parts:
        start, end = (tuple(map(float, spin @ np.array(p))) for p in (part.start, part.end))
        part = replace(part, start=start, end=end)
        if flip:
            fills = tuple(replace(f, low=part.length - f.high, high=part.length - f.low) for f in part.fills)
            part = replace(part, start=part.end, end=part.start, fills=fills)
        moved.append(part)
    return Hull(tuple(moved if order is None else [moved[i] for i in order]))


@pytest.mark.parametrize("change", [{"order": [*range(12, -1, -1)]}, {"flip": True}, {"turn": 2 * math.pi / 3}])
def test_order_and_direction_of_members_and_the_name_of_a_column_make_no_difference(change):
    one, other = semi(), semi(**change)
    a, b = one.buoyancy, other.buoyancy
    assert b.volume == pytest.approx(a.volume, rel=1e-6)
    assert b.centre == pytest.approx(a.centre, abs=1e-5)
    np.testing.assert_allclose(b.waterplane, a.waterplane, rtol=1e-6, atol=2e-3)
    assert other.mass.mass == pytest.approx(one.mass.mass, rel=1e-9)
    np.testing.assert_allclose(other.mass.inertia, one.mass.inertia, atol=1e-7 * one.mass.inertia[2, 2])


def test_a_hull_that_is_turned_has_turned_numbers():
    one, other, spin = semi(), semi(turn=0.3), Rotation.from_euler("z", 0.3).as_matrix()
    assert other.buoyancy.volume == pytest.approx(one.buoyancy.volume, rel=1e-6)
    np.testing.assert_allclose(other.mass.inertia, spin @ one.mass.inertia @ spin.T, rtol=1e-9, atol=10.0)
    assert other.metacentric_height() == pytest.approx(one.metacentric_height(), abs=1e-4)


@pytest.mark.parametrize("size", [1.0, 1.5, 3.0])
def test_panels_close_and_have_the_volume_of_the_members(size):
    """`hydrostatics` refuses panels that leak: the volumes by x, y and z are equal to 1e-6."""
    hull = semi()
    volume, centre, C = hydrostatics(hull.panels(size))
    assert volume == pytest.approx(hull.buoyancy.volume, rel=5e-3 if size > 2 else 1e-3)
    assert centre[2] == pytest.approx(hull.buoyancy.centre[2], abs=0.05)
    lids = hull.lids(size)
    up = np.cross(lids[:, 2] - lids[:, 0], lids[:, 3] - lids[:, 1])[:, 2] / 2
    assert (up <= 1e-9).all() and -up.sum() == pytest.approx(C[2, 2], rel=1e-9)
    assert np.abs(lids[:, :, 2]).max() < 1e-9


def test_lids_of_members_that_end_at_the_water_level():
    """A column that ends there has a lid; what stands on it, above the water, takes nothing off it."""
    parts = (tube("tower", (0, 0, 0), (0, 0, 9), 4.0), tube("leg", (0, 0, -9), (0, 0, 0), 6.0))
    for hull in (Hull(parts), Hull(parts[::-1])):
        lids = hull.lids(1.5)
        area = -np.cross(lids[:, 2] - lids[:, 0], lids[:, 3] - lids[:, 1])[:, 2].sum() / 2
        assert area == pytest.approx(9 * math.pi) == hydrostatics(hull.panels(1.5))[2][2, 2]


@pytest.mark.parametrize("seed", range(12))
def test_hulls_of_members_that_cross_anyhow_close(seed):
    """Random members, many of them on a grid, so that faces and axes lie on each other."""
    random = np.random.default_rng(seed)
    members: list[MemberShape] = []
    while len(members) < 4:
        ends = random.uniform(-15, 15, (2, 3)) - [0, 0, 5]
        if random.random() < 0.7:
            ends = 5 * np.round(ends / 5)
        kind = random.integers(3)  # any direction, upright, level
        ends[1, :2], ends[1, 2] = (ends[0, :2] if kind == 1 else ends[1, :2]), (ends[0, 2] if kind == 2 else ends[1, 2])
        if np.linalg.norm(ends[1] - ends[0]) > 3:
            width, height = random.choice([2.0, 4.0, 5.0, 10.0], 2)
            one = tube if random.random() < 0.5 else box
            sizes = (width,) if one is tube else (width, height)
            members.append(one(f"member {len(members)}", *ends, *sizes))
    hull = Hull(tuple(members))
    if hull.wet:
        volume, _, C = hydrostatics(hull.panels(2.5))  # which refuses what leaks
        assert volume == pytest.approx(hull.buoyancy.volume, rel=0.02)
        lids = hull.lids(2.5)
        area = -np.cross(lids[:, 2] - lids[:, 0], lids[:, 3] - lids[:, 1])[:, 2].sum() / 2
        assert area == pytest.approx(C[2, 2], rel=1e-3, abs=1e-6)


# --- what counts of a member -----------------------------------------------------------------------------------------


def test_a_pontoon_counts_from_the_wall_of_its_column():
    hull = semi()
    names = [member.name for member in hull.members]
    (low, high, share), = hull.wet_spans(names.index("pontoon 0"))  # fmt: skip
    assert (low, high, share) == pytest.approx((3.5, 20.0, 1.0))
    strips = hull.strips(names.index("pontoon 0"), 5)
    assert strips.across_1.sum() == pytest.approx(16.5 * 2.5)  # a flow from aside meets its height
    assert strips.across_2.sum() == pytest.approx(16.5 * 3.0)
    assert strips.volume.sum() == pytest.approx(16.5 * 7.5)
    assert strips.ends == pytest.approx(np.zeros(7))
    (low, high, _), = hull.wet_spans(names.index("column 1"))  # fmt: skip
    assert (low, high) == pytest.approx((0, 16))
    ring = hull.strips(names.index("plate 1"), 3).ends[-2:]
    assert ring == pytest.approx(math.pi * np.array([81, 81 - 25]), rel=2e-3)


def test_a_member_above_the_water_has_empty_strips():
    hull = Hull((tube("leg", (0, 0, -9), (0, 0, 9), 5.0), tube("deck", (0, 0, 6), (9, 0, 6), 2.0)))
    strips = hull.strips(1, 4)
    assert not strips.across_1.any() and not strips.ends.any() and not strips.waterline
    assert hull.strips(0, 4).waterline == pytest.approx(math.pi * 6.25)


def test_a_line_in_a_body():
    body = tube("leg", (0, 0, -9), (0, 0, 9), 5.0).bodies(0)[0]
    assert inside(np.array([[0.0, 0, -20], [0, 0, 20]]), body) == pytest.approx((11 / 40, 29 / 40))
    assert inside(np.array([[0.0, 4, -20], [0, 4, 20]]), body) is None
    assert inside(np.array([[0.0, 0, 9], [0, 0, 20]]), body) is None


def test_the_tlp_of_el_beshbichi():
    """PhD thesis, University of Stavanger (2023), tables 7.3 and 7.5: 1.13e4 m^3, 25.83 m deep, 201 m^2, 3.22e3 m^4.

    One column of 16 m and three square pontoons of 6 m, 32.5 m to the axis, their centres 40 m below the water.
    """
    parts = [tube("column", (0, 0, -43), (0, 0, 10), 16.0)]
    for k in range(3):
        x, y = 32.5 * math.cos(2 * math.pi * k / 3), 32.5 * math.sin(2 * math.pi * k / 3)
        parts.append(box(f"pontoon {k}", (0, 0, -40), (x, y, -40), 6.0, 6.0))
    water = Hull(tuple(parts)).buoyancy
    assert water.volume == pytest.approx(1.13e4, rel=5e-3)
    assert water.centre == pytest.approx([0, 0, -25.83], rel=2e-3, abs=1e-4)
    assert water.waterplane[2, 2] == pytest.approx(201, abs=0.5)
    assert np.diag(water.waterplane)[3:5] == pytest.approx([3.22e3] * 2, rel=2e-3)
    # C33 2.02e6 N/m, C44 = C55 -1.42e9 N m with 8.82e6 kg at -13.01 m
    C = water.stiffness(RHO, 9.81)
    assert C[2, 2] == pytest.approx(2.02e6, rel=2e-3)


# --- balance and mistakes --------------------------------------------------------------------------------------------


def test_hulls_that_differ_inside_alone_are_the_same_from_outside():
    """Their surface is cut once; another diameter or place makes another one."""
    given = {"walls": 0.05, "density": 7850.0, "fills": (Fill("water", 1025.0, -5.0, 0.0, 20.0),)}
    hull = Hull((tube("column", (0, 0, -20), (0, 0, 10), 8.0, **given),))
    fuller, bare = hull.with_level(["water"], -2.0), Hull((tube("column", (0, 0, -20), (0, 0, 10), 8.0),))
    assert fuller.union is hull.union and bare.union is hull.union
    assert fuller.mass.mass - hull.mass.mass == pytest.approx(1025 * 3 * math.pi / 4 * 7.9**2) and not bare.mass.mass
    for other in (hull.raised(1.0), Hull((tube("column", (0, 0, -20), (0, 0, 10), 8.1, **given),))):
        assert other.union is not hull.union and other.buoyancy.volume != hull.buoyancy.volume


def test_ballast_to_a_draft_and_the_draft_of_a_ballast_are_inverse():
    parts = semi().members  # a column, its plate and two braces of the semi
    hull, names = Hull((*parts[:3], parts[4], parts[8])), ["column 0.water"]
    level = hull.ballast_level(names, 0.3e6, RHO)
    loaded = hull.with_level(names, level)
    assert loaded.mass.mass + 0.3e6 == pytest.approx(RHO * hull.buoyancy.volume, rel=1e-9)
    assert loaded.rise(0.3e6, RHO) == pytest.approx(0.0, abs=1e-6)
    lighter = loaded.rise(0.2e6, RHO)
    area = hull.buoyancy.waterplane[2, 2]
    assert lighter == pytest.approx(0.1e6 / (RHO * area), rel=0.02)  # walls are upright but for the braces
    with pytest.raises(ParameterError, match="too light with full tanks for this draft, by"):
        hull.ballast_level(names, -1e8, RHO)
    with pytest.raises(ParameterError, match="there is no ballast 'column 9.water'; there is column 0.water"):
        hull.ballast_level(["column 9.water"], 0.0)
    with pytest.raises(ParameterError, match="sinks: it and its load weigh"):
        hull.rise(1e9, RHO)


def test_members_that_do_not_meet_are_named_with_their_gap():
    semi().check_joined()
    apart = (tube("column", (0, 0, -30), (0, 0, 5), 10.0), tube("pontoon", (6.5, 0, -20), (30, 0, -20), 4.0),
             tube("leg", (30, 0, -20), (30, 0, 5), 5.0))  # fmt: skip
    with pytest.raises(ParameterError, match=r"pontoon and column do not meet.*the gap is 1.5 m"):
        Hull(apart).check_joined()
    joined = (apart[0], replace(apart[1], start=(5.01, 0.0, -20.0), stations=(0.0, 24.99)), apart[2])
    Hull(joined).check_joined()  # a centimetre is within the rounding of plans
    beside = [box(name, (x, 0, -9), (x, 0, 9), 4.0, 2.0) for name, x in (("a", 0), ("b", 7))]
    assert gap(beside[0].bodies(0)[0], beside[1].bodies(1)[0]) == pytest.approx(3.0)


def test_a_hull_that_turns_over_is_refused_with_its_metacentric_height():
    tall = tube("leg", (0, 0, -20), (0, 0, 20), 6.0, walls=0.2, density=7850.0)
    hull = Hull((tall,))
    height = 9 / 4 / 20 - 10.0 - 0.0  # I / V + z_B - z_G
    assert hull.metacentric_height() == pytest.approx(height, rel=1e-4)
    with pytest.raises(ParameterError, match=r"cannot float upright.*-9.89 m.*held_upright"):
        hull.check_upright()


def test_the_smallest_metacentric_height_is_that_of_the_narrow_side():
    for turn in (0.0, 0.7):
        direction = np.array([math.cos(turn), math.sin(turn), 0.0])
        start, end = (tuple(map(float, s * direction + [5.0, 0, -1])) for s in (-20, 20))
        barge = box("barge", start, end, 10.0, 6.0, walls=0.01, density=7850.0)
        hull = Hull((barge,))
        assert hull.metacentric_height() == pytest.approx(100 / 12 / 4 - 2.0 + 1.0, rel=1e-6)


def test_a_hull_above_the_water_and_one_without_members_are_refused():
    with pytest.raises(ParameterError, match=r"lies above the water: its lowest point is at z = 1 m"):
        Hull((tube("leg", (0, 0, 1), (0, 0, 5), 2.0),)).buoyancy  # noqa: B018
    with pytest.raises(ParameterError, match="has no members"):
        Hull(())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"end": (0, 0, -9)}, "the same point"),
        ({"walls": 3.1}, "thicker than half"),
        ({"stations": (0, 0.5)}, "from 0 to its length, 18 m"),
        ({"plates": (Plate("leg.plate", 20.0, 0.1, 1.0),)}, "off its member, which is 18 m long"),
    ],
)
def test_mistakes_in_a_member_are_told(change, message):
    given = {"start": (0, 0, -9), "end": (0, 0, 9), "sizes": (5.0, 5.0), **change}
    with pytest.raises(ParameterError, match=message):
        member("leg", **given)


def test_what_of_a_body_lies_below_a_level():
    cube = box("cube", (-1, 0, 0), (1, 0, 0), 2.0, 2.0).bodies(0)[0]
    half = below(cube, 0.0)
    assert half.mass == pytest.approx(4) and half.centre == pytest.approx([0, 0, -0.5])
    assert np.diag(half.inertia) == pytest.approx([4 * (4 + 1) / 12, 4 * (4 + 1) / 12, 4 * 8 / 12])
