"""What of a surface lies under a plane, against closed forms, other ways of integrating, and itself in C."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fowtlib.components.platform import MemberShape, WettedSurface
from fowtlib.components.platform.compartments import compartment
from fowtlib.components.platform.union import union
from fowtlib.components.platform.wetted import wetted_function
from fowtlib.language.errors import ParameterError

DOWN = np.array([0.0, 0.0, 1.0])


def tube(*stations, name="tube", walls=(), foot=(0.0, 0.0)):
    """An upright round member through (z, diameter)."""
    z = [height for height, _ in stations]
    sizes = tuple((float(d), float(d)) for _, d in stations)
    places = tuple(float(height - z[0]) for height in z)
    return MemberShape(name, (*foot, float(z[0])), (*foot, float(z[-1])), places, sizes, walls=walls)


def box(length, width, height, low=0.0):
    ends = (-length / 2, 0.0, low + height / 2), (length / 2, 0.0, low + height / 2)
    return MemberShape("box", *ends, (0.0, float(length)), ((width, height),) * 2, is_round=False)


def surface(*members, sides=None, transition=1e-6):
    return WettedSurface(union(tuple(members)).triangles(sides), transition)


def leaned(angle, towards=0.0):
    return np.array([-math.sin(angle) * math.cos(towards), -math.sin(angle) * math.sin(towards), math.cos(angle)])


def by_slices(z, n, diameter, low, high, count=4000):
    """Volume and first moments of an upright round body under a plane: exact circular segments on many slices.

    n = (-sin, 0, cos): the section at height s is wet where x > (z + s cos) / sin. Area and moment of the segment of a
    circle of radius a beyond c: a^2 acos(c/a) - c sqrt(a^2 - c^2), and 2/3 (a^2 - c^2)^(3/2).
    """
    s = low + (high - low) * (np.arange(count) + 0.5) / count
    a = diameter(s) / 2
    c = np.clip((z + s * n[2]) / -n[0], -a, a)
    area = a**2 * np.arccos(c / a) - c * np.sqrt(a**2 - c**2)
    first = 2 / 3 * (a**2 - c**2) ** 1.5
    step = (high - low) / count
    return step * np.array([area.sum(), first.sum(), 0.0, (area * s).sum()])


SPAR = ((-50.0, 12.0), (-20.0, 12.0), (-10.0, 7.0), (15.0, 7.0))


def spar_diameter(s):
    return np.interp(s, [height for height, _ in SPAR], [d for _, d in SPAR])


# --- accuracy --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [10.0, 40.0, 75.0])
@pytest.mark.parametrize("z", [0.0, -12.0, 9.0])
def test_a_stepped_spar_at_an_angle_is_as_by_slices(z, angle):
    """The 32 corners that a floater has, against segments of circles, wherever the cut passes: cone, side, end."""
    n = leaned(math.radians(angle))
    found = surface(tube(*SPAR)).under([z, *n])
    wanted = by_slices(z, n, spar_diameter, -50.0, 15.0, count=20_000)
    assert found.volume == pytest.approx(wanted[0], rel=1e-5)
    assert found.moments == pytest.approx(wanted[1:], rel=2e-5, abs=1e-5 * wanted[0])


def test_more_corners_converge_with_their_fourth_power():
    """Errors of the moments of a spar whose sides are cut: a sixteenth with each doubling of the corners."""
    z, n = -3.0, leaned(math.radians(60.0))
    wanted = by_slices(z, n, spar_diameter, -50.0, 15.0, count=200_000)
    errors = []
    for sides in (16, 32, 64):
        found = surface(tube(*SPAR), sides=sides).under([z, *n])
        errors.append(abs(found.moments[0] / wanted[1] - 1))
    assert errors[0] < 2e-4 and errors[1] < 1e-5 and errors[2] < 6e-7
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.1) and errors[1] / errors[2] == pytest.approx(16, rel=0.1)


def test_a_cone_point_down():
    """V = pi h^3 tan^2 / 3 and centre at 3/4 of the draft above the tip; area of the waterplane pi (h tan)^2."""
    cone = tube((-10.0, 1e-5), (2.0, 12.0))
    found = surface(cone, sides=64, transition=1e-3).under([4.0, *DOWN])  # its tip is 6 m deep
    assert found.volume == pytest.approx(math.pi * 6**3 / 4 / 3, rel=1e-5)
    assert found.centre == pytest.approx([0, 0, -10 + 0.75 * 6], abs=1e-4)
    assert found.area == pytest.approx(math.pi * 9, rel=1e-5)


def test_a_tetrahedron_of_a_corner_of_a_box_is_wet():
    """The corner of a box that dips in to depths d along three edges at right angles: V = d1 d2 d3 / 6."""
    cube = surface(box(2.0, 2.0, 2.0, low=-1.0), transition=1e-7)
    n = np.array([1.0, 2.0, 3.0]) / math.sqrt(14)
    corner = np.array([-1.0, -1.0, -1.0])
    depth = 0.4
    edges = depth / n
    found = cube.under([-depth - corner @ n, *n])
    assert found.volume == pytest.approx(edges.prod() / 6, rel=1e-9)
    assert found.centre == pytest.approx(corner + edges / 4, rel=1e-7)
    assert found.area == pytest.approx(3 * found.volume / depth, rel=1e-6)


def test_a_log_on_its_side_displaces_the_segment_of_its_section():
    """At any depth, in shares of the whole log: 4e-5 with 32 corners, an eighth of that with each doubling of them."""
    log = MemberShape("log", (-10, 0, 0), (10, 0, 0), (0.0, 20.0), ((2.0, 2.0),) * 2)
    depths = np.linspace(-0.9, 0.9, 61)
    wanted = np.arccos(depths) - depths * np.sqrt(1 - depths**2)
    largest = []
    for sides in (32, 64, 128):
        hull = surface(log, sides=sides)
        found = np.array([hull.under([c, *DOWN]).volume for c in depths]) / 20
        largest.append(np.abs(found - wanted).max() / math.pi)
    assert largest[0] < 4e-5 and largest[1] < 5e-6 and largest[2] < 7e-7


# --- potential, smoothness -------------------------------------------------------------------------------------------


def random_planes(count, reach):
    draw = np.random.default_rng(5)
    turns = [Rotation.random(random_state=k).as_matrix()[2] for k in range(count)]
    return [np.array([draw.uniform(-reach, reach), *turn]) for turn in turns]


def semi():
    columns = [tube((-20.0, 12.0), (12.0, 12.0), name=f"c{k}", foot=(25 * math.cos(a), 25 * math.sin(a)))
               for k, a in enumerate((0.0, 2.1, 4.2))]  # fmt: skip
    a, b = columns[0].start, columns[1].start
    brace = MemberShape("brace", (*a[:2], -17.0), (*b[:2], -17.0), (0.0, math.dist(a, b)), ((2.0, 2.0),) * 2)
    return surface(*columns, brace, transition=0.05)


def test_volume_and_moments_are_the_gradient_of_the_integral_of_the_depth():
    """And the slopes are theirs, at any attitude, by central differences."""
    hull, step = semi(), 1e-5
    for u in random_planes(12, 20.0):
        found, around = hull.under(u), np.eye(4) * step
        gradient = [(hull.under(u + d).depth - hull.under(u - d).depth) / (2 * step) for d in around]
        assert gradient == pytest.approx(-np.array([found.volume, *found.moments]), rel=1e-5, abs=0.05)
        for column, d in zip(found.slopes.T, around, strict=True):
            above, below = hull.under(u + d), hull.under(u - d)
            change = np.array([above.volume - below.volume, *(above.moments - below.moments)]) / (2 * step)
            assert column == pytest.approx(change, rel=1e-4, abs=2e-4 * abs(found.slopes).max() + 1e-6)
        assert found.slopes == pytest.approx(found.slopes.T, rel=1e-9, abs=1e-9 * abs(found.slopes).max() + 1e-9)


def test_a_closed_path_gains_nothing():
    """Work of buoyancy along a closed path through heave, roll and pitch, past ends and faces, by Simpson's rule."""
    hull = semi()

    def u(t):
        roll, pitch = 0.8 * math.sin(t), 0.5 * math.sin(2 * t + 1)
        return np.array([6 * math.cos(t) + 3 * math.sin(3 * t),
                         *Rotation.from_euler("ZYX", [0.3, pitch, roll]).as_matrix()[2]])  # fmt: skip

    t = np.linspace(0, 2 * math.pi, 1601)
    planes = np.array([u(time) for time in t])
    rates = np.gradient(planes, t, axis=0, edge_order=2)
    power = [-rate @ [found.volume, *found.moments] for plane, rate in zip(planes, rates, strict=True)
             for found in [hull.under(plane)]]  # fmt: skip
    work = np.trapezoid(power, t)
    assert abs(work) < 1e-4 * np.trapezoid(np.abs(power), t)


def test_a_deck_that_goes_under_does_so_smoothly():
    """The slope of the volume changes from the whole area to nothing over the transition, without a jump."""
    cube = surface(box(2.0, 2.0, 2.0, low=-2.0), transition=0.01)
    areas = [cube.under([z, *DOWN]).area for z in np.linspace(-0.02, 0.02, 401)]
    assert areas[0] == pytest.approx(0, abs=1e-9) and areas[-1] == pytest.approx(4)
    assert np.abs(np.diff(areas)).max() < 1.01 * 4 * 1e-4 / 0.01 and min(np.diff(areas)) > -1e-9
    volumes = [cube.under([z, *DOWN]).volume for z in (-1.0, 1.0)]
    assert volumes == pytest.approx([8.0, 4.0], rel=1e-12)


# --- sums and the linear ones ----------------------------------------------------------------------------------------


def test_under_still_water_it_is_what_the_panels_of_the_hull_displace():
    """The part of a union below z = 0 by `hydrostatics` of clipped panels, another formula: sums over the surface."""
    from fowtlib.components.platform.hull import Hull

    members = tuple(tube((-20.0, 12.0), (12.0, 12.0), name=f"c{k}", foot=(8.0 * k, 0.0)) for k in range(3))
    hull = Hull(members)
    found = WettedSurface(union(members).triangles(), 1e-4).under([0.0, *DOWN])
    assert found.volume == pytest.approx(hull.buoyancy.volume, rel=1e-12)
    assert found.centre == pytest.approx(hull.buoyancy.centre, rel=1e-9, abs=1e-9)
    plane = hull.buoyancy.waterplane
    assert -found.slopes[0, :3] == pytest.approx([plane[2, 2], -plane[2, 4], plane[2, 3]], rel=1e-9, abs=1e-8)
    assert -found.slopes[1, 1] == pytest.approx(plane[4, 4], rel=1e-9)


def test_c_and_numpy_give_the_same():
    hull, function = semi(), wetted_function()
    if function.library is None:
        pytest.skip("no C compiler")
    held = hull.open_in(function)
    slope = function.function.jacobian()
    for u in random_planes(8, 25.0):
        found = hull.under(u)
        values = function.function(np.array([hull.handle, *u])).full().ravel()
        scale = 1e-10 * np.array([1, 20, 20, 20, 20]) * float(hull.whole[0, 0])
        assert (np.abs(values - [found.volume, *found.moments, found.depth]) <= scale).all()
        matrix = slope(np.array([hull.handle, *u]), values).full()
        assert matrix[:4, 1:] == pytest.approx(found.slopes, rel=1e-6, abs=1e-4)
        assert matrix[4, 1:] == pytest.approx(-values[:4], rel=1e-12) and not matrix[:, 0].any()
    del held


def test_a_file_holds_what_c_needs(tmp_path):
    """As an FMU opens it: the same numbers from the file."""
    hull, function = surface(box(2.0, 3.0, 4.0)), wetted_function()
    path, more = hull.file_for(function)
    assert more == () and np.array_equal(np.fromfile(path), hull.block)


def test_a_handle_that_is_not_open_is_refused():
    function = wetted_function()
    hull = surface(box(1.0, 2.0, 7.7))
    with pytest.raises(RuntimeError):
        function.function(np.array([hull.handle, 0.0, *DOWN]))


def test_a_compartment_is_the_inside_of_a_member_between_two_places():
    member = tube((-10.0, 4.0), (0.0, 4.0), walls=(0.5, 0.5))
    assert compartment(member, 2.0, 6.0).whole[0, 0] == pytest.approx(math.pi / 4 * 9 * 4, rel=1e-12)
    with pytest.raises(ParameterError, match="not within the member of 10 m"):
        compartment(member, 2.0, 12.0)
