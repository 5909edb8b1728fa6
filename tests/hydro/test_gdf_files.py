"""GDF files: mirror images, lids, remarks, rounded corners, and a named error with file and line for each fault."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.gdf_files import read_gdf, write_gdf
from fowtlib.components.hydro.panel_mesh import Column, members_mesh
from fowtlib.language.errors import ModelError, ParameterError

OC3 = Column(((-120.0, 9.4), (-12.0, 9.4), (-4.0, 6.5), (10.0, 6.5)))

QUARTER = """\
a quarter of a box of 8 x 4 x 2 m
1.0 9.81   ULEN GRAV
1 1        ISX ISY
3          NPAN
0 0 -2
0 2 -2
4 2 -2
4 0 -2     a remark
4 0 -2  4 2 -2
4 2 0   4 0 0   3
4 2 -2  0 2 -2  0 2 0  4 2 0
0          NPAND
"""


def write(folder, text, name="hull.gdf"):
    path = folder / name
    path.write_text(text)
    return path


QUARTER = QUARTER.replace("     a remark", "  1")


def test_a_quarter_becomes_the_whole(tmp_path):
    hull = read_gdf(write(tmp_path, QUARTER))
    assert len(hull.panels) == 12
    assert hull.volume == pytest.approx(64)
    assert hull.waterplane_area == pytest.approx(32)
    assert hull.symmetry.planes == ("xOz", "yOz")
    half = read_gdf(write(tmp_path, QUARTER.replace("1 1        ISX ISY", "0 1").replace("0 0 -2", "-4 0 -2")
                          .replace("0 2 -2", "-4 2 -2").replace("0 2 0", "-4 2 0").replace("3          NPAN", "4")
                          .replace("0          NPAND", "-4 2 -2  -4 0 -2  -4 0 0  -4 2 0")))  # fmt: skip
    assert half.volume == pytest.approx(64)


def test_what_is_written_is_read_again(tmp_path):
    hull = members_mesh([OC3], [], 3.0, name="OC3 spar\nof 120 m")
    write_gdf(hull, tmp_path / "spar.gdf")
    again = read_gdf(tmp_path / "spar.gdf")
    np.testing.assert_allclose(again.panels, hull.panels, atol=1e-6)
    np.testing.assert_allclose(again.lid, hull.lid, atol=1e-6)
    assert again.symmetry == hull.symmetry
    assert again.volume == pytest.approx(hull.volume, rel=1e-8)


def test_rounded_corners_are_one_point(tmp_path):
    """Millimetres, as in many published files: some corners differ in the last digit."""
    hull = members_mesh([OC3], [], 3.0)
    write_gdf(hull, tmp_path / "spar.gdf")
    lines = (tmp_path / "spar.gdf").read_text().splitlines()
    random = np.random.default_rng(1)
    rows = [" ".join(f"{float(word) + random.uniform(-4e-4, 4e-4) * (abs(float(word)) > 1e-3):.3f}"
                     for word in line.split()) for line in lines[4:]]  # fmt: skip
    again = read_gdf(write(tmp_path, "\n".join([*lines[:4], *rows])))
    assert again.volume == pytest.approx(hull.volume, rel=1e-3)


def test_a_hull_above_the_water_is_cut(tmp_path):
    raised = QUARTER
    for corner in ("4 2 0", "4 0 0", "0 2 0"):
        raised = raised.replace(corner, corner[:-1] + "1")
    hull = read_gdf(write(tmp_path, raised))
    assert hull.volume == pytest.approx(64)
    assert hull.panels[:, :, 2].max() == 0


def test_a_leaking_hull_is_read_where_the_user_says_so(tmp_path):
    """As the published mesh of the VolturnUS-S: small holes, three volumes that differ by 0.08 %."""
    hull = members_mesh([OC3], [], 3.0)
    write_gdf(hull, tmp_path / "spar.gdf")
    lines = (tmp_path / "spar.gdf").read_text().splitlines()
    count, last = int(lines[3].split()[0]), 4 * len(hull.panels)  # the last panel of the hull, at the water
    lines[3] = f"{count - 1}"
    leaking = write(tmp_path, "\n".join([*lines[:last], *lines[last + 4 :]]), "leaking.gdf")
    with pytest.raises(ParameterError, match=r"leaking.gdf: the mesh leaks, along an open rim: 3 edges"):
        read_gdf(leaking)
    with pytest.warns(UserWarning, match="the mesh leaks, along an open rim"):
        again = read_gdf(leaking, leaky=True)
    assert again.volume == pytest.approx(hull.volume, rel=1e-3)
    open_hull = write(tmp_path, "\n".join([*lines[:3], f"{count - 17}", *lines[72:]]), "open.gdf")
    with pytest.warns(UserWarning, match="leaks"), pytest.raises(ParameterError, match="not a closed hull: the vol"):
        read_gdf(open_hull, leaky=True)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1.0 9.81   ULEN GRAV", "1.0", "hull.gdf:2: expected 'ULEN GRAV', found '1.0'"),
        ("1.0 9.81", "1.0 -9.81", "hull.gdf:2: gravity is -9.81"),
        ("1 1        ISX ISY", "2 1", "hull.gdf:3: ISX and ISY are 0 or 1, found 2 1"),
        ("1 1        ISX ISY", "ISX 1", "hull.gdf:3: 'ISX' is not a number, expected 'ISX ISY'"),
        ("3          NPAN", "0", "hull.gdf:4: '0' is not a number of panels"),
        ("3          NPAN", "3 1", "hull.gdf:4: this is a file of patches"),
        ("3          NPAN", "2", "hull.gdf:11: more than the 2 panels of line 4"),
        ("3          NPAN", "5", "hull.gdf:12: '"),
        ("4 2 -2\n", "4 2 *\n", "hull.gdf:7: '*' is not a number"),
        ("4 2 -2\n", "4 2 inf\n", "hull.gdf:7: 'inf' is not a finite number"),
        ("0          NPAND", "2", "hull.gdf:12: more than the 3 panels of line 4; dipole panels"),
        ("4 0 -2  1\n", "4 0 -3  1\n", "the mesh leaks"),
    ],
)
def test_a_fault_is_named_with_its_line(tmp_path, old, new, message):
    assert old in QUARTER
    with pytest.raises(ModelError) as caught:
        read_gdf(write(tmp_path, QUARTER.replace(old, new, 1)))
    assert message in str(caught.value)


def test_what_is_no_mesh_at_all(tmp_path):
    with pytest.raises(HydrodynamicDataError, match="the file ends before its first panel"):
        read_gdf(write(tmp_path, "title\n1 9.81\n"))
    with pytest.raises(HydrodynamicDataError, match="none.gdf: cannot read the GDF file"):
        read_gdf(tmp_path / "none.gdf")
    with pytest.raises(HydrodynamicDataError, match="no panel lies below"):
        read_gdf(write(tmp_path, "dry\n1 9.81\n0 0\n1\n0 0 1 1 0 1 1 1 1 0 1 1\n"))


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=st.integers(0, 10_000), length=st.integers(0, 12), put=st.text(max_size=8))
def test_a_damaged_file_is_read_or_refused_with_a_sentence(tmp_path, at, length, put):
    at %= len(QUARTER)
    path = tmp_path / "damaged.gdf"
    path.write_text(QUARTER[:at] + put + QUARTER[at + length :], encoding="utf-8", errors="replace", newline="")
    try:
        read_gdf(path)
    except ModelError as error:
        assert str(error).startswith(str(path))
