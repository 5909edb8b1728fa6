"""`fowt hydro` on the shipped spars: meshes, databases, WAMIT files, studies, pictures, mistakes."""

import csv
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest

from fowtlib.cli import main
from fowtlib.components.hydro import HydrodynamicDatabase
from fowtlib.components.hydro.gdf_files import read_gdf

OC3 = Path(__file__).parents[2] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc"
SOLVE = ["hydro", "oc3_spar_rigid", "--size", "4", "--omega", "0.3,0.6", "--headings", "0,90"]


def run(capsys, *words):
    status = main([*map(str, words)])
    out, err = capsys.readouterr()
    return status, out, err


def test_the_mesh_of_a_model(capsys, tmp_path):
    status, out, err = run(capsys, "hydro", "oc3_spar_rigid", "--mesh-only", "--size", "3", "-o", tmp_path / "oc3.gdf")
    assert status == 0
    assert "512, at most 6.3 m wide, watertight" in out
    assert "body of revolution (16 wedges); a part of 32 panels is solved" in out
    assert "8029.21 m^3 (-0.00% of the 8029.21 m^3 expected), its centre at (0, 0, -62.07) m" in out
    assert "irregular frequencies could begin at 2.57 rad/s" in out
    assert err == f"saved {tmp_path / 'oc3.gdf'}\n"
    assert read_gdf(tmp_path / "oc3.gdf").volume == pytest.approx(8029.21, rel=1e-6)
    status, out, _ = run(capsys, "hydro", tmp_path / "oc3.gdf", "--mesh-only", "--volume", "8029.21")
    assert status == 0 and "(-0.00% of the 8029.21 m^3 expected)" in out


def damaged(tmp_path, capsys, *damages):
    """The mesh of OC3 with panels of its column at the sides y = 2 m and -2 m changed, and where they lie."""
    assert main(["hydro", "oc3_spar_rigid", "--mesh-only", "--size", "1.5", "-o", str(tmp_path / "tight.gdf")]) == 0
    capsys.readouterr()
    lines = (tmp_path / "tight.gdf").read_text().splitlines()
    head, body = lines[:3], lines[4:]
    panels = np.array([[float(x) for x in line.split()] for line in body]).reshape(-1, 4, 3)
    centre = panels.mean(axis=1)
    first = int(np.argmin(np.linalg.norm(centre - [3, 2, -60], axis=1)))
    image = int(np.argmin(np.linalg.norm(centre - centre[first] * [1, -1, 1], axis=1)))
    assert first != image
    gone = []
    for side, damage in damages:
        k = first if side > 0 else image
        if damage == "hole":
            gone.append(k)
        elif damage == "turned":
            panels[k] = panels[k][::-1]
        else:
            panels[k, 0, 2] += damage
    panels = np.delete(panels, gone, axis=0)
    path = tmp_path / "hull.gdf"
    rows = [" ".join(f"{x:.9e}" for x in corner) for corner in panels.reshape(-1, 3)]
    path.write_text("\n".join([*head, str(len(panels)), *rows]) + "\n")
    return path, centre[first]


def test_a_mesh_that_leaks_is_refused_with_the_place_and_the_ways_out(capsys, tmp_path):
    path, at = damaged(tmp_path, capsys, (1, "hole"))
    status, out, err = run(capsys, "hydro", path, "--mesh-only")
    assert status == 2 and not out
    assert "hull.gdf: the mesh leaks, along an open rim: 4 edges" in err and "--leaky" in err
    places = np.array([[float(x) for x in place.split(",")] for place in re.findall(r"\(([-\d., ]+)\)", err)])
    assert len(places) == 4 and np.linalg.norm(places - at, axis=1).max() < 3.0  # corners of the hole


@pytest.mark.parametrize(("damages", "says"), [
    ([(1, "hole")], "leaking"), ([(-1, "hole")], "leaking"), ([(1, "hole"), (-1, "hole")], "leaking"),
    ([(1, 0.02)], "watertight"), ([(-1, 0.02)], "watertight"), ([(1, 0.02), (-1, 0.03)], "watertight"),
])  # fmt: skip
def test_a_mesh_that_leaks_and_is_taken_is_not_called_watertight(capsys, tmp_path, damages, says):
    """Where one half has no gap, x < 0 in the last case, it is taken twice, which makes a tight hull."""
    path, _ = damaged(tmp_path, capsys, *damages)
    status, out, err = run(capsys, "hydro", path, "--mesh-only", "--leaky")
    assert status == 0 and "hull.gdf: the mesh leaks" in err
    assert f"m wide, {says}" in out


def test_a_turned_panel_is_named(capsys, tmp_path):
    path, _ = damaged(tmp_path, capsys, (1, "turned"))
    status, _, err = run(capsys, "hydro", path, "--mesh-only")
    assert status == 2 and "hull.gdf: two panels run the same way along the edge" in err
    assert "List the corners of the one in the other order" in err and "--leaky" not in err


def test_several_meshes_for_machines(capsys):
    words = ["hydro", "two_rotor_spar_rigid", "--mesh-only", "--size", "4,2"]
    status, out, _ = run(capsys, *words, "--json")
    rows = json.loads(out)
    assert status == 0 and [row["size [m]"] for row in rows] == [4, 2]
    assert rows[1]["panels"] == 1020 and rows[1]["part"] == 51
    assert rows[0]["volume [m^3]"] == pytest.approx(11784, rel=1e-3)
    assert rows[0]["good up to [rad/s]"] < rows[1]["good up to [rad/s]"]
    status, out, _ = run(capsys, *words, "--csv")
    assert status == 0 and len(list(csv.DictReader(io.StringIO(out)))) == 2


def test_the_database_of_a_model_and_of_a_file(capsys, tmp_path):
    status, out, _ = run(capsys, "hydro", "oc3_spar_rigid", "--database")
    assert status == 0
    assert "OC3 Hywind, WAMIT output" in out and "volume 8029.21 m^3, depth 320 m, 37 headings" in out
    status, again, _ = run(capsys, "hydro", OC3)
    assert status == 0 and again == out
    status, table, err = run(capsys, "hydro", OC3, "--json")
    rows = json.loads(table)
    data = HydrodynamicDatabase.read(OC3)
    assert [row["limit"] for row in (rows[0], rows[1], rows[-1])] == ["zero", "", "infinite"]
    assert rows[-1]["A11 [kg]"] == data.A_inf[0, 0] and rows[-1]["B11 [N s/m]"] is None
    middle = next(row for row in rows if row["omega [rad/s]"] == pytest.approx(0.5, rel=1e-4))
    at = int(np.argmin(np.abs(data.omega - 0.5)))
    assert middle["|X1| [N/m]"] == pytest.approx(abs(data.X[at, 18, 0]))
    assert middle["B55 [N m s]"] == pytest.approx(data.B[at, 4, 4])


def test_wamit_files_and_back(capsys, tmp_path):
    """From netCDF to WAMIT with ULEN = 9.4 m and to netCDF again."""
    picture = tmp_path / "a.png"
    status, _, err = run(capsys, "hydro", OC3, "-o", tmp_path / "spar.1", "--length", "9.4", "--plot", picture)
    assert status == 0
    assert [line for line in err.splitlines() if "saved" in line] == [
        f"saved {tmp_path / name}" for name in ("spar.1", "spar.3", "spar.hst", "a.png")]
    assert (tmp_path / "a.png").stat().st_size > 20_000
    words = ["hydro", tmp_path / "spar.3", "--volume", "8029.21", "--centre", "0,0,-62.0657", "--depth", "320",
             "--length", "9.4", "-o", tmp_path / "spar.nc"]  # fmt: skip
    status, out, err = run(capsys, *words)
    assert status == 0
    one, two = HydrodynamicDatabase.read(tmp_path / "spar.nc"), HydrodynamicDatabase.read(OC3)
    np.testing.assert_allclose(one.A, two.A, rtol=1e-8, atol=1)
    np.testing.assert_allclose(one.X, two.X, atol=1e-8 * np.abs(two.X).max())
    status, _, err = run(capsys, *words[:-2], "-o", tmp_path / "spar.hst")
    assert status == 2
    assert f"{tmp_path / 'spar.1'} is there already" in err and "--force" in err


def test_a_database_is_computed_saved_and_drawn(capsys, tmp_path):
    pytest.importorskip("capytaine")
    files = [tmp_path / name for name in ("oc3.nc", "oc3.1", "oc3.gdf")]
    words = [word for path in files for word in ("-o", path)]
    status, out, err = run(capsys, *SOLVE, *words, "--plot", tmp_path / "oc3.svg")
    assert status == 0
    assert "volume: 8029.21 m^3 (-0.00% of the 8029.21 m^3 expected)" in out
    assert "416 panels: volume 8029.21 m^3, depth 320 m, 2 headings from 0 to 90 deg" in out
    assert err.count("saved") == 6
    data, wamit = HydrodynamicDatabase.read(tmp_path / "oc3.nc"), HydrodynamicDatabase.read(OC3)
    assert data.omega.tolist() == [0.3, 0.6]
    assert (data.rho, data.g, data.water_depth) == (1025, 9.80665, 320)
    at = [int(np.argmin(np.abs(wamit.omega - omega))) for omega in data.omega]
    assert data.A[:, 0, 0] == pytest.approx(wamit.A[at, 0, 0], rel=0.06)
    assert np.abs(data.X[:, 0, 0]) == pytest.approx(np.abs(wamit.X[at, 18, 0]), rel=0.03)
    assert "added mass" in (tmp_path / "oc3.svg").read_text()
    status, table, err = run(capsys, *SOLVE, "--depth", "inf", "--density", "1000", "--json")
    assert status == 0 and "deep water" in err
    assert json.loads(table)[1]["A11 [kg]"] == pytest.approx(data.A[0, 0, 0] * 1000 / 1025, rel=0.01)


def test_a_study_of_the_mesh_size(capsys):
    pytest.importorskip("capytaine")
    words = ["hydro", "oc3_spar_rigid", "--size", "3,4", "--omega", "0.3,0.6", "--headings", "0,90", "--json"]
    status, out, _ = run(capsys, *words)
    rows = json.loads(out)
    assert status == 0 and [row["panels [m]"] for row in rows] == [4, 3]
    assert 0 < rows[0]["A11 [%]"] < 3
    assert all(rows[1][name] == 0 for name in rows[1] if name.endswith("[%]"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nrel5mw_land"], "nrel5mw_land has no hull that can be meshed: a Floater, upright columns"),
        (["oc3_spar_rigid", "--part", "platfrom"], "--part: 'platfrom' is not a hull that can be meshed"),
        (["nrel5mw_land", "--database"], "has no part that reads a database (class LinearPotentialFlow)"),
        (["oc3_spar_rigid", "--mesh-only", "--size", "0.01"], "--size: panels of 0.01 m would be more than 1.9e+07"),
        (["oc3_spar_rigid", "--mesh-only", "--database"], "--database shows the database that a model reads, without"),
        (["hull.gdf", "--database"], "--database shows the database that a model reads, without a mesh"),
        (["oc3_spar_rigid", "--mesh-only", "-o", "a.nc"], "a.nc: --mesh-only solves nothing"),
        (["oc3_spar_rigid", "--size", "2,4", "-o", "a.nc"], "a.nc: a study of the mesh has several results"),
        (["oc3_spar_rigid", "--size", "2,4", "--plot", "a.png"], "--plot a.png: there is no single database to draw"),
        (["oc3_spar_rigid", "--mesh-only", "--size", "2,4", "-o", "a.gdf"], "a.gdf: a mesh file takes one mesh"),
        (["oc3_spar_rigid", "-o", "a.txt"], "a.txt: the file must end in '.nc', '.1', '.3', '.hst' or '.gdf'"),
        (["spar.1"], "spar.1: WAMIT files do not have all that a database needs: give --volume and --centre and --dep"),
        (["spar.1", "--volume", "9", "--centre", "0,0,-1", "--depth", "9"], "spar.1: cannot read the WAMIT file"),
        (["spar.gdf"], "spar.gdf: cannot read the GDF file"),
        (["spar.gdf", "--size", "2,1"], "spar.gdf: a mesh in a file has the panels that it has"),
        (["spar.nc"], "spar.nc"),
        (["oc3_spar_rigid", "--omega", "0.01,1"], "two frequencies or more are needed, finite and at least 0.0433"),
        (["oc3_spar_rigid", "--omega", "0.5"], "two frequencies or more are needed"),
    ],
)
def test_a_mistake_gets_a_sentence(capsys, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    status, _, err = run(capsys, "hydro", *words)
    assert status == 2
    assert message in err and "Traceback" not in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--omega", "a:b:c"], "'a:b:c' is not first:last:step"),
        (["--omega", "1,0.5"], "'1,0.5' is not first:last:step"),
        (["--size", "-2"], "'-2' is not a size of panels"),
        (["--depth", "-3"], "'-3' is not a positive number"),
        (["--centre", "0,0"], "'0,0' is not a point X,Y,Z"),
    ],
)
def test_an_option_that_is_no_number(capsys, words, message):
    with pytest.raises(SystemExit) as left:
        main(["hydro", "oc3_spar_rigid", *words])
    assert left.value.code == 2
    assert message in capsys.readouterr().err


def test_without_capytaine_the_extra_is_named(capsys, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "capytaine", None)
    status, _, err = run(capsys, *SOLVE)
    assert status == 2
    assert 'the panel method needs Capytaine, which is not installed: pip install "fowtlib[hydro]"' in err


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (["oc3_spar", "--database", "--omega", "0.4,0.8"], "--omega: the database that the model reads"),
        (["oc3_spar", "--database", "--size", "2"], "--size: the database that the model reads"),
        (["spar.nc", "--headings", "0"], "--headings: spar.nc"),
        (["spar.nc", "--no-lid"], "--no-lid: spar.nc"),
        (["spar.1", "--size", "4,2"], "--size: spar.1"),
    ],
)
def test_a_database_that_is_only_shown_takes_no_options_of_the_panel_method(words, option, capsys):
    """They used to be ignored, so that one took what was shown for what had been asked for."""
    assert main(["hydro", *words]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert f"{option} is shown as it is, and nothing is solved" in said
