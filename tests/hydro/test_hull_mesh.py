"""Meshes of hulls: leaks by place, symmetry found, lids, clipping at the water, volumes, and limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.components.hydro.hull_mesh import HullMesh, Symmetry, clipped, waterlines
from fowtlib.components.hydro.mesh_leaks import check_closed
from fowtlib.components.hydro.mesh_mirror import with_mirrored_panels
from fowtlib.components.hydro.panel_limits import coarse_from, irregular_frequency, warnings_of
from fowtlib.components.hydro.panel_mesh import Column, Pontoon, members_mesh, members_volume
from fowtlib.language.errors import ParameterError

OC3 = Column(((-120.0, 9.4), (-12.0, 9.4), (-4.0, 6.5), (10.0, 6.5)))


def grid(corner, along, aside, n, m):
    """Panels of a parallelogram, normal along x aside."""
    corner, along, aside = (np.array(v, dtype=float) for v in (corner, along, aside))
    s, t = np.meshgrid(np.arange(n) / n, np.arange(m) / m, indexing="ij")
    start = corner + s[..., None] * along + t[..., None] * aside
    u, v = along / n, aside / m
    return np.stack([start, start + u, start + u + v, start + v], axis=2).reshape(-1, 4, 3)


def barge(length=8.0, width=4.0, draft=2.0, n=(8, 4, 2), x=0.0, y=0.0):
    """Wetted panels of a box, its middle at (x, y)."""
    a, b = x - length / 2, y - width / 2
    L, B, T = (length, 0, 0), (0, width, 0), (0, 0, draft)
    lx, ly, lz = n
    return np.concatenate([
        grid((a, b, -draft), B, L, ly, lx),
        grid((a, b, -draft), L, T, lx, lz), grid((a + length, b + width, -draft), (-length, 0, 0), T, lx, lz),
        grid((a + length, b, -draft), B, T, ly, lz), grid((a, b + width, -draft), (0, -width, 0), T, ly, lz),
    ])  # fmt: skip


def triangle(**section):
    angles = np.radians([0, 120, 240])
    columns = [Column(((-20.0, 12.0), (12.0, 12.0)), x=30 * np.cos(a), y=30 * np.sin(a)) for a in angles]
    ends = [(c.x, c.y, -15.0) for c in columns]
    return columns, [Pontoon(ends[i], ends[(i + 1) % 3], **section) for i in range(3)]


def test_a_barge_by_hand():
    hull = HullMesh(barge())
    assert hull.volume == pytest.approx(64)
    assert hull.waterplane_area == pytest.approx(32)
    assert hull.draft == pytest.approx(2)
    np.testing.assert_allclose(hull.centre_of_buoyancy, (0, 0, -1), atol=1e-12)
    assert hull.stiffness[3, 3] == pytest.approx(8 * 4**3 / 12 - 64)
    assert hull.stiffness[4, 4] == pytest.approx(4 * 8**3 / 12 - 64)
    np.testing.assert_allclose(hull.widths, 1.0)


# --- leaks ------------------------------------------------------------------------------------------------------


def without_a_panel():
    panels = barge()
    lowest = int(np.flatnonzero(np.abs(panels.mean(axis=1) - (0.5, 0.5, -2)).max(axis=1) < 1e-9)[0])
    return np.delete(panels, lowest, axis=0)


def with_a_moved_corner():
    panels = barge()
    panels[0, 2] += (0, 0, 0.02)
    return panels


def without_a_wall():
    panels = barge()
    return panels[np.abs(panels[:, :, 0] - 4).max(axis=1) > 1e-9]


def with_a_slit_between_halves():
    panels = barge()
    panels[panels.mean(axis=1)[:, 0] > 0] += (0.05, 0, 0)
    return panels


@pytest.mark.parametrize(
    ("panels", "message"),
    [
        (without_a_panel, r"leaks, along an open rim: 4 edges .* longest from .*-2\) .* nearest two corners 1 m apart"),
        (with_a_moved_corner, r"leaks, .* the nearest two corners 0\.02 m apart, at \(-3, -1, -(1\.98|2)\) and"),
        (without_a_wall, r"leaks, along an open rim: 8 edges .* from \(4, .*, -\d\) to \(4, "),
        (with_a_slit_between_halves, r"leaks, along 2 open rims: 8 edges .* the nearest two corners 0\.05 m apart"),
    ],
)
def test_a_mesh_that_leaks_is_named_with_the_place(panels, message):
    with pytest.raises(ParameterError, match="raft: the mesh " + message):
        HullMesh(panels(), name="raft")


def test_two_leaks_are_two():
    panels = without_a_panel()
    panels = panels[np.abs(panels.mean(axis=1) - (-2.5, -0.5, -2)).max(axis=1) > 1e-9]
    with pytest.raises(ParameterError, match=r"leaks, along 2 open rims: .*; "):
        HullMesh(panels)


def test_a_turned_panel_is_named():
    panels = barge()
    panels[5] = panels[5, ::-1]
    with pytest.raises(ParameterError, match=r"two panels run the same way along the edge from .* into the hull"):
        HullMesh(panels)
    with pytest.raises(ParameterError, match="raft: the normals of the panels point into the hull"):
        HullMesh(barge()[:, ::-1], name="raft")


def test_an_edge_divided_on_one_side_is_no_leak():
    """A bottom in long strips under walls of short panels closes; one corner off the line by a millimetre does not."""
    panels = barge()
    walls = panels[np.abs(panels[:, :, 2] + 2).max(1) > 0.1]
    strips = np.concatenate([grid((-4, -2, -2), (0, 4, 0), (8, 0, 0), 4, 1), walls])
    assert HullMesh(strips).volume == pytest.approx(64)
    wall = int(np.flatnonzero((strips[:, :, 1] < -1.99).all(axis=1))[0])
    corner = int(np.flatnonzero(strips[wall, :, 2] < -1.99)[0])
    off = strips[wall, corner].copy()
    if abs(off[0]) > 3.99:
        corner = int(np.flatnonzero(strips[wall, :, 2] < -1.99)[1])
        off = strips[wall, corner].copy()
    strips[(np.abs(strips - off).max(axis=2) < 1e-9)] += (0, 0, 1e-3)
    with pytest.raises(ParameterError, match="leaks"):
        HullMesh(strips)


def test_what_is_not_a_wetted_hull_is_said():
    with pytest.raises(ParameterError, match=r"reaches 1 m above the still water level; cut it at z = 0"):
        HullMesh(barge() + [0, 0, 1])
    with pytest.raises(ParameterError, match=r"an array \(n, 4, 3\)"):
        HullMesh(np.zeros((3, 3, 3)))
    with pytest.raises(ParameterError, match="finite"):
        HullMesh(np.full((3, 4, 3), np.nan))


@settings(max_examples=30)
@given(lift=st.floats(-3, 1.999), heel=st.floats(-0.5, 0.5), turn=st.floats(0, 6.28))
def test_a_clipped_hull_is_closed_and_displaces_what_lies_below(lift, heel, turn):
    """A closed box of 4 x 4 x 4 m, moved and heeled: its volume below z = 0 by slices."""
    box = barge(4, 4, 4, (3, 3, 3))
    box = np.concatenate([box, grid((-2, -2, 0), (4, 0, 0), (0, 4, 0), 3, 3)]) + (0, 0, 2)
    c, s, ct, stn = np.cos(heel), np.sin(heel), np.cos(turn), np.sin(turn)
    R = np.array([[ct, -stn, 0], [stn, ct, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    check_closed(box @ R.T - (0, 0, 50))
    wet = clipped(box @ R.T + (0, 0, lift))
    hull = HullMesh(wet)
    y = (np.arange(4000) + 0.5) / 1000 - 2  # in the box: below where lift + s y + c z < 0, with z from -2 to 2
    height = np.clip((-lift - s * y) / c + 2, 0, 4)
    assert hull.volume == pytest.approx(4 * height.mean() * 4, rel=1e-4)


# --- formulas ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("section", [{"width": 4.0, "height": 3.0}, {"diameter": 4.0}])
def test_members_by_formulas(section):
    columns, pontoons = triangle(**section)
    across = np.linspace(-2, 2, 40_001)
    height = 3.0 if "width" in section else 2 * np.sqrt(4 - across**2)
    outside = np.trapezoid((30 * np.sqrt(3) - 2 * np.sqrt(36 - across**2)) * height, across)
    assert members_volume(columns, pontoons) == pytest.approx(3 * np.pi * 36 * 20 + 3 * outside, rel=1e-6)
    assert members_mesh(columns, pontoons, 2.0).volume == pytest.approx(members_volume(columns, pontoons), rel=5e-4)


def test_a_mesh_that_is_not_what_is_expected_is_refused():
    hull = members_mesh([OC3], [], 4.0, name="spar")
    hull.expect(volume=8029.21, waterplane_area=np.pi / 4 * 6.5**2)
    with pytest.raises(ParameterError, match=r"spar: the mesh displaces 8029.21 m\^3, and 8100 m\^3 are expected"):
        hull.expect(volume=8100)
    with pytest.raises(ParameterError, match=r"spar: the mesh has a waterplane of 33.1831 m\^2, and 69.4 m\^2"):
        hull.expect(waterplane_area=69.4)
    with pytest.raises(ParameterError, match="expected"):  # pontoons through each other: the panels count twice
        HullMesh(np.concatenate([barge(), barge(y=0.7)])).expect(volume=64 * 4.7 / 4)


# --- symmetry ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "found", "fold"),
    [
        (lambda: HullMesh(barge()), Symmetry(planes=("xOz", "yOz")), 4),
        (lambda: HullMesh(barge(x=1.0)), Symmetry(planes=("xOz",)), 2),
        (lambda: HullMesh(barge(y=1.0)), Symmetry(planes=("yOz",)), 2),
        (lambda: HullMesh(barge(x=1.0, y=1.0)), Symmetry(), 1),
        (lambda: HullMesh(barge(n=(7, 4, 2))), Symmetry(planes=("xOz",)), 2),  # panels lie across x = 0
        (lambda: members_mesh([OC3], [], 3.0), Symmetry(rotation=16, round=True), 16),
        (lambda: members_mesh(*triangle(diameter=4.0), 4.0), Symmetry(rotation=3), 3),
        (lambda: members_mesh([Column(((-9.0, 6.0), (1.0, 6.0)), x=8.0)], [], 2.0), Symmetry(planes=("xOz",)), 2),
        (lambda: members_mesh(
            [Column(((-20.0, 12.0), (2.0, 12.0)), x=x) for x in (-20, 20)],
            [Pontoon((-20, 0, -15), (20, 0, -15), width=4, height=4)], 3.0), Symmetry(planes=("xOz", "yOz")), 4),
    ],
)  # fmt: skip
def test_symmetry_is_found(make, found, fold):
    hull = make()
    assert hull.symmetry == found
    assert hull.symmetry.fold == fold
    assert len(hull.part(hull.panels)) * fold == len(hull.panels)
    assert len(hull.part(hull.lid)) * fold == len(hull.lid)


def test_one_panel_apart_is_not_symmetric():
    panels = barge()
    panels[0] = np.roll(panels[0], 1, axis=0)  # another first corner is the same panel
    assert HullMesh(panels).symmetry.planes == ("xOz", "yOz")
    inner = np.flatnonzero(np.abs(panels.mean(axis=1) - (2.5, 0.5, -2)).max(axis=1) < 1e-9)
    corner = panels[inner[0], 0].copy()
    panels[np.abs(panels - corner).max(axis=2) < 1e-9] += (0.05, 0, 0)
    hull = HullMesh(panels)
    assert hull.symmetry.planes in (("xOz",), ("yOz",), ())
    assert hull.symmetry.fold < 4


# --- lids and limits --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hull", [lambda: HullMesh(barge(x=3.0)), lambda: HullMesh(members_mesh([OC3], [], 3.0).panels),
                                  lambda: HullMesh(members_mesh(*triangle(diameter=4.0), 3.0).panels)])  # fmt: skip
def test_a_lid_covers_the_waterplane(hull):
    hull = hull()
    lid = hull.lid
    area = np.cross(lid[:, 2] - lid[:, 0], lid[:, 3] - lid[:, 1])[:, 2] / 2
    assert np.abs(area).sum() == pytest.approx(hull.waterplane_area, rel=1e-9)
    assert abs(area.sum()) == pytest.approx(hull.waterplane_area, rel=1e-9)  # all of one side
    assert np.abs(lid[:, :, 2]).max() < 1e-9


def test_no_lid_where_there_is_no_waterplane_or_a_moon_pool():
    assert not len(HullMesh(members_mesh([Column(((-20, 9.0), (-5, 9.0)))], [], 2.0).panels).lid)
    ring = members_mesh([Column(((-5.0, 20.0), (1.0, 20.0)))], [], 2.5).panels
    assert len(waterlines(ring)) == 1
    inner = barge(6, 6, 1.0, (3, 3, 1))[:, ::-1] * (1, 1, 1)
    pool = HullMesh(np.concatenate([ring, inner]))  # a pool of 6 x 6 m, 1 m deep, in its deck
    assert pool.volume == pytest.approx(np.pi * 100 * 5 - 36)
    assert len(waterlines(pool.panels)) == 2
    assert not len(pool.lid)


def test_irregular_frequencies_are_named():
    """A cylinder of radius a: k a = 2.405 (first zero of J0), omega^2 = g k coth(k T); the box is a little below."""
    hull = members_mesh([Column(((-10.0, 20.0), (1.0, 20.0)))], [], 2.0)
    k = 2.405 / 10
    exact = np.sqrt(9.81 * k / np.tanh(k * 10))
    assert 0.93 * exact < irregular_frequency(hull, 9.81) < exact
    omega = np.arange(0.4, 2.0, 0.1)
    assert not warnings_of(hull, omega, np.inf, 9.81)[1:]
    bare = hull.without_lid()
    sentence = warnings_of(bare, omega, np.inf, 9.81)[-1]
    assert "without a lid there can be irregular frequencies from 1.49" in sentence
    assert "5 of 16 frequencies lie there, 1.5 to 1.9 rad/s" in sentence
    assert not warnings_of(bare, omega[:5], np.inf, 9.81)
    assert irregular_frequency(members_mesh([Column(((-20, 9.0), (-5, 9.0)))], [], 2.0), 9.81) == np.inf


def test_panels_wide_for_their_waves_are_named_with_frequency_and_place():
    hull = HullMesh(barge()).without_lid()  # panels of 1 m: good for waves of 4 m or longer
    good = np.sqrt(9.81 * 2 * np.pi / 4.0)
    assert coarse_from(hull, np.array([0.5, 0.999 * good]), np.inf, 9.81) is None
    frequency, length, panel = coarse_from(hull, np.array([0.5, 1.001 * good, 9.0]), np.inf, 9.81)
    assert (frequency, length) == (pytest.approx(1.001 * good), pytest.approx(4 / 1.001**2))
    assert panel[3] == pytest.approx(1)
    assert "from 3.9" in warnings_of(hull, np.array([0.5, 1.001 * good]), np.inf, 9.81)[0]
    deep = members_mesh([Column(((-60.0, 9.0), (-50.0, 9.0)))], [], 3.0)  # short waves do not reach it
    assert coarse_from(deep, np.array([0.3, 3.0]), np.inf, 9.81) is None


# --- panels that are made mirror images ---------------------------------------------------------------------------


def skewed(panels, seed=3):
    """The same surface with panels cut along one diagonal or the other, as it comes."""
    random = np.random.default_rng(seed)
    triangles = []
    for panel in panels:
        a, b, c, d = panel if random.random() < 0.5 else np.roll(panel, 1, axis=0)
        triangles += [[a, b, c, c], [a, c, d, d]]
    return np.array(triangles)


@pytest.mark.parametrize(
    ("panels", "planes"),
    [
        (lambda: barge(n=(7, 4, 2)), ("xOz", "yOz")),
        (lambda: skewed(barge(n=(7, 5, 2))), ("xOz", "yOz")),
        (lambda: skewed(barge(x=1.0, n=(7, 5, 2))), ("xOz",)),
        (lambda: skewed(members_mesh(*triangle(diameter=4.0), 3.0).panels), ("xOz",)),
    ],
)
def test_a_symmetric_hull_of_other_panels_gets_mirror_images(panels, planes):
    hull = HullMesh(panels())
    found = with_mirrored_panels(hull)
    assert hull.symmetry.fold < found.symmetry.fold
    assert found.symmetry.planes == planes
    assert found.volume == pytest.approx(hull.volume, rel=1e-3)
    assert found.waterplane_area == pytest.approx(hull.waterplane_area, rel=1e-3)
    np.testing.assert_allclose(found.stiffness, hull.stiffness, atol=2e-3 * np.abs(hull.stiffness).max())
    assert len(found.panels) < 1.3 * len(hull.panels)


@pytest.mark.parametrize(
    "panels",
    [
        lambda: skewed(barge(x=1.0, y=1.0)),
        # a second, small hull on one side only, then one of another shape and the same volume on the other side
        lambda: np.concatenate([skewed(barge()), barge(2, 1, 1, (2, 1, 1), y=4.0)]),
        lambda: np.concatenate([skewed(barge()), barge(2, 1, 1, (2, 1, 1), y=4.0), barge(1, 1, 2, (1, 1, 2), y=-4.0)]),
    ],
)
def test_a_hull_that_is_not_symmetric_stays(panels):
    hull = HullMesh(panels())
    found = with_mirrored_panels(hull)
    assert "xOz" not in found.symmetry.planes
    assert found.volume == pytest.approx(hull.volume, rel=1e-12)


def test_what_is_symmetric_already_stays_as_it_is():
    hull = HullMesh(barge())
    assert with_mirrored_panels(hull) is hull
    spar = members_mesh([OC3], [], 4.0)
    assert with_mirrored_panels(spar) is spar
