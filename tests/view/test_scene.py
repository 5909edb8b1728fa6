"""Views in 3-D: the page carries everything, and what it carries agrees with the model."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from scipy.spatial.transform import Rotation

import fowtlib as fw
from fowtlib.cli import main
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import World
from fowtlib.components.mechanics import (
    Fixed,
    FixedTranslation,
    PointMass,
    Revolute,
    RigidBody,
    SpringDamper,
    VisualBox,
    VisualTube,
)
from fowtlib.language import shapes
from fowtlib.language.errors import ModelError
from fowtlib.solving.modes import natural_modes
from fowtlib.solving.results import Result
from fowtlib.view import meshes, view
from fowtlib.view.recording import moments_of, product, quaternions, turn

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
STEADY = {"wind.kind": "steady", "wind.mean_speed": "9 m/s", "sea.spectrum": "regular", "sea.wave_height": "4 m",
          "sea.wave_period": "10 s"}  # fmt: skip


def pendulum() -> fw.Assembly:
    """A double pendulum in the x-z plane, its end on a spring."""
    root = fw.Assembly("double pendulum")
    root.world = World(gravity=9.81)
    root.upper, root.lower = Revolute(n=(0, 1, 0), phi_start="40 deg"), Revolute(n=(0, 1, 0), phi_start="20 deg")
    root.rod_1, root.rod_2 = FixedTranslation(r=(0, 0, -1)), FixedTranslation(r=(0, 0, -0.7))
    root.bob_1, root.bob_2 = PointMass(mass=1.0), PointMass(mass=0.5)
    root.wall, root.spring = Fixed(r=(1.5, 0, -1)), SpringDamper(stiffness=2.0, natural_length=0.5)
    for a, b in (
        (root.world.frame, root.upper.frame_a), (root.upper.frame_b, root.rod_1.frame_a),
        (root.rod_1.frame_b, root.bob_1.frame_a), (root.rod_1.frame_b, root.lower.frame_a),
        (root.lower.frame_b, root.rod_2.frame_a), (root.rod_2.frame_b, root.bob_2.frame_a),
        (root.wall.frame, root.spring.frame_a), (root.rod_2.frame_b, root.spring.frame_b),
    ):  # fmt: skip
        root.connect(a, b)
    return root


@pytest.fixture(scope="module")
def swing() -> Result:
    return fw.load(pendulum()).compile().simulate(2.0, 0.05)


@pytest.fixture(scope="module")
def spar():
    """The rigid OC3 spar: plant and two seconds of it."""
    plant = fw.load("oc3_spar_rigid", set=STEADY).compile()
    return plant, plant.simulate(2.0, 0.1, tolerance=1e-5)


def scene_of(page: Path) -> dict:
    return json.loads(re.search(r'id="scene">(.*?)</script>', page.read_text(), re.S)[1])


def unpacked(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def poses_of(scene: dict) -> dict[str, np.ndarray]:
    """Poses (n_time, 7) by the name of the frame."""
    poses = unpacked(scene["poses"], "<f4").reshape(unpacked(scene["time"], "<f8").size, len(scene["frames"]), 7)
    return dict(zip(scene["frames"], poses.transpose(1, 0, 2), strict=True))


def volume(mesh: meshes.Mesh) -> float:
    """By the theorem of Gauss, with the normals deciding what is outside."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    area = np.cross(b - a, c - a) / 2
    outside = np.sign(np.einsum("ij,ij->i", area, mesh.normals[mesh.triangles].sum(axis=1)))
    return float(np.sum(outside * np.einsum("ij,ij->i", area, (a + b + c) / 3)) / 3)


def test_meshes_are_closed_and_face_outwards():
    n = meshes.SIDES
    polygon = n / (2 * np.pi) * np.sin(2 * np.pi / n)  # area of the polygon over that of its circle
    cone = meshes.tube(np.array([[1.0, 2, 3], [1, 2, 7]]), np.array([4.0, 2.0]))
    assert volume(cone) == pytest.approx(polygon * np.pi * 4 / 3 * (4 + 2 + 1))
    step = meshes.tube(np.array([[0.0, 0, 0], [0, 3, 0], [0, 3, 0], [0, 5, 0]]), np.array([2.0, 2, 4, 4]))
    assert volume(step) == pytest.approx(polygon * np.pi * (3 * 1 + 2 * 4))
    assert volume(meshes.box(np.array([1.0, 1, 1]), np.array([2.0, 3, 4]))) == pytest.approx(24)
    assert volume(meshes.ball(np.array([5.0, 0, 0]), 2.0)) == pytest.approx(4 / 3 * np.pi, rel=0.03)
    around = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    rings = np.array([[(2 * np.cos(a), np.sin(a), z) for a in around] for z in (0.0, 1, 2)])
    for sections in (rings, rings[:, ::-1]):  # either sense of the points
        assert volume(meshes.loft(sections)) == pytest.approx(2 * 40 / 2 * 2 * np.sin(2 * np.pi / 40))
    assert np.linalg.norm(meshes.loft(rings).normals, axis=1) == pytest.approx(1.0)


def test_quaternions_are_those_of_the_matrices():
    turns = Rotation.random(50, random_state=1)
    special = Rotation.from_euler("xyz", [[180, 0, 0], [0, 180, 0], [0, 0, 180], [0, 0, 0]], degrees=True)
    for rotation in (turns, special):
        found = Rotation.from_quat(quaternions(rotation.as_matrix()))
        assert (found * rotation.inv()).magnitude() == pytest.approx(0, abs=1e-7)
    axis, angle = (1.0, 2.0, -1.0), np.linspace(-4, 4, 50)
    after = turns * Rotation.from_rotvec(angle[:, None] * np.array(axis) / np.sqrt(6))
    found = Rotation.from_quat(product(turns.as_quat(), turn(axis, angle)))
    assert (found * after.inv()).magnitude() == pytest.approx(0, abs=1e-7)


def test_moments_are_thinned_evenly_and_keep_both_ends():
    time = np.arange(0, 100.05, 0.1)
    assert np.array_equal(moments_of(time, None, 10**6), np.arange(1001))
    assert np.array_equal(np.diff(time[moments_of(time, 2.0, 10**6)]).round(9), np.full(200, 0.5))
    few = moments_of(time, 10.0, 50)
    assert few.size <= 51 and few[0] == 0 and few[-1] == 1000 and np.ptp(np.diff(few)[:-1]) <= 1
    assert moments_of(np.array([3.0]), None, 10).tolist() == [0] and moments_of(np.zeros(0), None, 10).size == 0
    assert moments_of(np.arange(0, 1, 0.001), None, 10**6).size == pytest.approx(600, abs=2)  # a short run


def test_the_page_is_complete_and_asks_for_nothing(swing, tmp_path):
    made = fw.view(swing, tmp_path / "swing.html")
    text = made.path.read_text()
    assert not re.search(r"https?:|//cdn|\bsrc=|<link|@import|\bimport\(|fetch\(|XMLHttpRequest", text)
    assert made.size == made.path.stat().st_size and made.moments == 41 and made.rate == pytest.approx(20)
    assert str(made) == f"{tmp_path}/swing.html (41 moments, 20 per simulated second, {made.size / 1e6:.1f} MB)"
    assert "<title>double pendulum</title>" in text and "<h1>double pendulum</h1>" in text


def test_frames_lines_and_readings_agree_with_the_result(swing, tmp_path):
    scene = scene_of(fw.view(swing, tmp_path / "swing.html").path)
    assert unpacked(scene["time"], "<f8") == pytest.approx(swing.time)
    for name, pose in poses_of(scene).items():
        assert pose[:, :3] == pytest.approx(swing.array(f"{name}.r"), abs=1e-6)
        assert Rotation.from_quat(pose[:, 3:]).as_matrix() == pytest.approx(swing.array(f"{name}.R"), abs=1e-6)
    (spring,) = scene["curves"]
    steps = unpacked(spring["points"], "<u2").reshape(-1, 2, 3)
    ends = np.array(spring["low"]) + steps * np.array(spring["step"])
    assert ends[:, 0] == pytest.approx(np.tile([1.5, 0, -1], (41, 1)), abs=1e-4)
    assert ends[:, 1] == pytest.approx(swing.array("rod_2.frame_b.r"), abs=1e-4)
    (angle,) = [item for item in scene["readings"] if item["name"] == "upper.phi"]
    assert unpacked(angle["values"], "<f4") == pytest.approx(swing.array("upper.phi"), abs=1e-6)
    assert angle["unit"] == "rad"


def test_a_model_is_drawn_at_its_start_and_at_rest(tmp_path):
    model = fw.load(pendulum())
    scene = scene_of(fw.view(model, tmp_path / "start.html").path)
    end = poses_of(scene)["rod_2.frame_a"][0, :3]
    assert end == pytest.approx([-np.sin(np.radians(40)), 0, -np.cos(np.radians(40))], abs=1e-6)
    rest = scene_of(fw.view(model, tmp_path / "rest.html", equilibrium=True).path)
    state = model.compile().equilibrium()
    assert poses_of(rest)["rod_2.frame_a"][0, :3] == pytest.approx(np.ravel(state["rod_2.frame_a.r"]), abs=1e-6)
    assert "at its mean position." in rest["status"]


def test_a_mode_moves_as_its_shape_says(tmp_path):
    """One period, first and last moment alike; the bobs move in the ratio of the mode, about the place of rest."""
    model = fw.load(pendulum())
    plant = model.compile()
    rest = plant.equilibrium()
    for mode in natural_modes(plant, rest):
        page = fw.view(model, tmp_path / "mode.html", mode=mode.number).path
        scene = scene_of(page)
        assert scene["loop"] and scene["status"].startswith(f"mode {mode.number}, {mode.name}: {mode.frequency:.4g} Hz")
        poses = poses_of(scene)
        angles = {}
        for name, frame in (("upper", "rod_1.frame_a"), ("lower", "rod_2.frame_a")):
            quaternion = poses[frame][:, 3:]
            angles[name] = 2 * np.arctan2(quaternion[:, 1], quaternion[:, 3])
        np.testing.assert_allclose(angles["upper"][0], angles["upper"][-1], atol=1e-6)
        moved = {name: values - values.mean() for name, values in angles.items()}
        first, second = mode.shape["upper.phi"], mode.shape["upper.phi"] + mode.shape["lower.phi"]
        assert np.ptp(moved["lower"]) / np.ptp(moved["upper"]) == pytest.approx(abs(second / first), rel=1e-4)
        assert (moved["lower"] @ moved["upper"] > 0) == ((second / first).real > 0)
    with pytest.raises(ModelError, match=r"the model has no oscillating mode 3; there are 1 to 2, see `fowt eigen`\."):
        fw.view(model, tmp_path / "mode.html", mode=3)


def test_the_camera_does_not_look_along_a_mooring_line(spar, tmp_path):
    scene = scene_of(fw.view(spar[1], tmp_path / "spar.html").path)
    for azimuth in scene["azimuths"].values():
        for line in (60, 180, 300):
            assert abs((azimuth - line + 90) % 180 - 90) >= 20 - 1e-9


def test_changed_parameters_change_the_drawing(tmp_path):
    plant = fw.load(pendulum()).compile()
    result = plant.simulate(0.2, 0.1, parameters={"rod_1.r": (0, 0, -3)})
    scene = scene_of(fw.view(result, tmp_path / "long.html").path)
    rod = next(m for m in scene["meshes"] if scene["frames"][m["frame"]] == "rod_1.frame_a")
    assert unpacked(rod["points"], "<f4").reshape(-1, 3)[:, 2].min() == pytest.approx(-3)


def test_the_spar_is_drawn_where_it_is(spar, tmp_path):
    """Hub, blade tips by the azimuth, fairlead and anchor of a line, hull: against the definition of OC3."""
    _, result = spar
    scene = scene_of(fw.view(result, tmp_path / "spar.html").path)
    poses = poses_of(scene)
    assert poses["turbine.frame"][:, :3] == pytest.approx(result.array("turbine.frame.r"), abs=1e-4)
    assert poses["turbine.frame"][0, :3] == pytest.approx([-5, 0, 90], abs=1e-4)  # NREL/TP-500-38060, table 1-1

    blades = [m for m in scene["meshes"] if m["material"] == "blade"]
    tips = [unpacked(m["points"], "<f4").reshape(-1, 3) for m in blades]
    tips = [points[np.argmax(np.linalg.norm(points, axis=1))] for points in tips]
    assert [np.linalg.norm(tip) for tip in tips] == pytest.approx([63.0] * 3, rel=1e-3)
    tip, frame = tips[0], scene["frames"][blades[0]["frame"]]
    assert frame == "turbine.rotor.frame turned by turbine.rotor.phi turned by turbine.rotor.blade_pitch"
    place = poses[frame][:, :3] + Rotation.from_quat(poses[frame][:, 3:]).apply(tip)
    phi = result.array("turbine.rotor.phi")
    assert phi[-1] > 1.5  # the rotor has turned a quarter
    azimuth = Rotation.from_euler("x", phi[:, None])
    along = Rotation.from_euler("y", np.radians(5)) * azimuth * Rotation.from_euler("y", -np.radians(2.5))
    body = Rotation.from_matrix(result.array("turbine.frame.R"))
    expected = result.array("turbine.frame.r") + (body * along).apply([0, 0, 63])
    assert np.linalg.norm(place - expected, axis=1).max() < 0.4  # the chord of the tip is 0.3 m

    line = scene["curves"][0]
    points = unpacked(line["points"], "<u2").reshape(result.time.size, -1, 3) * np.array(line["step"]) + line["low"]
    assert points[:, -1] == pytest.approx(result.array("platform.mooring.line_1.fairlead.r"), abs=0.02)
    anchor = 853.87 * np.array([0.5, np.sqrt(0.75)])
    assert points[0, 0] == pytest.approx([*anchor, -320], abs=0.02)  # NREL/TP-500-47535, table 5-1
    assert points[..., 2].min() == pytest.approx(-320, abs=0.02)

    hull = next(m for m in scene["meshes"] if m["material"] == "hull")
    hull = unpacked(hull["points"], "<f4").reshape(-1, 3)
    assert (hull[:, 2].min(), hull[:, 2].max()) == pytest.approx((-120, 10))
    assert np.hypot(hull[:, 0], hull[:, 1]).max() == pytest.approx(4.7)


def test_the_sea_is_that_of_the_result(spar, tmp_path):
    _, result = spar
    water = scene_of(fw.view(result, tmp_path / "spar.html").path)["water"]
    omega, amplitude, phase = (unpacked(water[name], "<f8") for name in ("omega", "amplitude", "phase"))
    waves = amplitude * np.cos(np.outer(result.time, omega) + phase)
    assert waves.sum(axis=1) == pytest.approx(result.array("wave_elevation"), abs=1e-6)
    assert water["depth"] == 320


def test_the_arrow_of_the_wind_turns_with_it(tmp_path):
    turned = {"wind.kind": "edc", "wind.mean_speed": 12.0, "wind.direction": 0.2, "sea.spectrum": "still"}
    result = fw.load("oc3_spar_rigid").compile().simulate(8.0, 1.0, solver="fixed", parameters=turned)
    (arrow,) = scene_of(fw.view(result, tmp_path / "turned.html").path)["arrows"]
    assert arrow["direction"] == pytest.approx([np.cos(0.2), np.sin(0.2), 0])
    assert unpacked(arrow["lengths"], "<f4") == pytest.approx(36.0)
    bearings = unpacked(arrow["bearings"], "<f4")
    np.testing.assert_allclose(bearings, np.asarray(result["wind.bearing"]), atol=1e-6)
    assert bearings[-1] - bearings[0] > 0.5


def test_a_small_file_shows_fewer_moments(spar, tmp_path):
    _, result = spar
    whole = fw.view(result, tmp_path / "whole.html")
    small = fw.view(result, tmp_path / "small.html", size_limit=5e3)
    assert whole.moments == 21 and 2 <= small.moments < 12 and small.size < whole.size


def test_forms_for_what_has_none():
    """Visual parts change no equation of motion, and give a mass a form."""
    root = fw.Assembly("block")
    root.world, root.hinge, root.body = World(), Revolute(n=(1, 0, 0)), RigidBody(mass=1.0, inertia=np.eye(3))
    root.box = VisualBox(centre=(0, 0, -1), size=(1, 2, 3), material="nacelle")
    root.tube = VisualTube(points=[(0, 0, 0), (0, 0, 1)], diameters=0.5)
    for a, b in ((root.world.frame, root.hinge.frame_a), (root.hinge.frame_b, root.body.frame_a),
                 (root.hinge.frame_b, root.box.frame), (root.hinge.frame_b, root.tube.frame)):  # fmt: skip
        root.connect(a, b)
    drawn = root.drawing()
    assert [type(shape) for shape in drawn] == [shapes.Ball, shapes.Box, shapes.Tube]
    assert drawn[2].diameters.tolist() == [0.5, 0.5]
    plant = fw.load(root).compile()
    assert len(plant.dae.states) == 2 and np.ravel(plant.initial_state()["box.frame.f"]) == pytest.approx(np.zeros(3))


def test_a_rod_may_be_hidden():
    assert FixedTranslation(r=(0, 0, 1), diameter=0).drawing() == []
    assert FixedTranslation(r=(0, 0, 0)).drawing() == []
    (rod,) = FixedTranslation(r=(0, 0, 2), diameter="30 cm").drawing()
    assert rod.diameters.tolist() == [0.3, 0.3]


def test_a_compiled_plant_is_drawn_as_its_model(tmp_path):
    model = fw.load(pendulum())
    scenes = [scene_of(fw.view(subject, tmp_path / "it.html").path) for subject in (model, model.compile())]
    assert scenes[0]["frames"] == scenes[1]["frames"]
    for key in ("poses", "meshes", "curves", "readings"):
        assert scenes[0][key] == scenes[1][key]


@pytest.mark.parametrize("first", ["import fowtlib.view", "from fowtlib.view import plot_modes", "fw.view", "pass"])
def test_the_face_is_a_function_whatever_was_imported_first(first):
    """Python puts a package that is imported into its parent, under the name of the function."""
    call = "fw.view('a text')"
    script = f"import fowtlib as fw\n{first}\ntry:\n    {call}\nexcept fw.ModelError as error:\n    print(error)\n"
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert said == "view: a Model, a Plant or a Result can be drawn, not a str.\n"


def test_mistakes_are_told(swing, tmp_path):
    empty = fw.Assembly("numbers")
    empty.source = Constant(value=1.0)
    with pytest.raises(ModelError, match=r"^the model has no part with a form: bodies, .* anything with a frame\.$"):
        fw.view(fw.load(empty), tmp_path / "no.html")
    with pytest.raises(ModelError, match=r"^this result does not know its model: open it with the compiled model"):
        fw.view(Result([0.0, 1.0], {"x": [0, 1]}), tmp_path / "no.html")
    with pytest.raises(ModelError, match=r"no.pdf: a view is saved as \.html, not as '\.pdf'\.$"):
        fw.view(swing, tmp_path / "no.pdf")
    with pytest.raises(ModelError, match=r"^view: 0 moments per second cannot be shown"):
        fw.view(swing, tmp_path / "no.html", rate=0)
    with pytest.raises(ModelError, match=r"^view: a Model, a Plant or a Result can be drawn, not a str\.$"):
        view("oc3_spar_rigid", tmp_path / "no.html")
    with pytest.raises(ModelError, match=r"a shape is made of structure, .*, not of 'cheese'\."):
        shapes.Ball(None, material="cheese")
    with pytest.raises(ModelError, match=r"3 diameters for 2 points"):
        shapes.Tube(None, [(0, 0, 0), (0, 0, 1)], (1, 2, 3))
    assert not list(tmp_path.iterdir())


# --- the command -----------------------------------------------------------------------------------------------------


def test_the_command_finds_the_model_of_a_result(spar, tmp_path, monkeypatch, capsys):
    """Wind and waves of the run were others than those of the shipped model: they are set again."""
    _, result = spar
    monkeypatch.chdir(tmp_path)
    result.save("run.nc")
    assert main(["view", "run.nc"]) == 0
    shown = capsys.readouterr()
    assert shown.err.startswith("saved run.html (21 moments, 10 per simulated second, ")
    assert shown.out.startswith("wind ") and shown.out.count(" (of the run)") == 2 and "H=4" in shown.out
    scene = scene_of(Path("run.html"))
    assert poses_of(scene)["turbine.frame"][:, :3] == pytest.approx(result.array("turbine.frame.r"), abs=1e-4)
    assert unpacked(scene["water"]["amplitude"], "<f8") == pytest.approx([2.0])

    def refused(*arguments: str) -> str:
        assert main(["view", *arguments]) == 2
        return capsys.readouterr().err

    result.save("run.csv")
    assert refused("run.csv") == (
        "fowt view: run.csv: a CSV file holds the series only, not the states: save the run as .nc.\n"
    )
    assert refused("run.nc", "--waves", "still") == (
        "fowt view: --waves changes a model; a result is shown as it was computed.\n"
    )
    assert "the model of this result is another one: arm_left.diameter was absent" in refused(
        "two_rotor_spar_rigid", "--result", "run.nc"
    )
    result.attributes["model"] = "mine"
    result.save("mine.nc")
    result.attributes["model"] = "oc3_spar_rigid"
    assert refused("mine.nc") == (
        "fowt view: mine.nc: 'mine' is not a shipped model; give the model too: fowt view MODEL --result mine.nc\n"
    )
    assert main(["view", "oc3_spar_rigid", "--result", "mine.nc", "-o", "again.html"]) == 0
    assert scene_of(Path("again.html"))["frames"] == scene["frames"]


# --- the browser -----------------------------------------------------------------------------------------------------


def chromium(page: Path, tmp_path: Path, *options: str, part: str = "") -> str:
    """What headless Chromium prints of a page."""
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
        "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
        "--ignore-gpu-blocklist", "--hide-scrollbars", "--window-size=900,600", "--virtual-time-budget=2000",
        f"--user-data-dir={tmp_path / 'profile'}", *options, page.as_uri() + part,
    ]  # fmt: skip
    return subprocess.run(command, capture_output=True, text=True, timeout=120).stdout


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine to open the page in")
def test_the_browser_shows_what_the_result_says(spar, tmp_path):
    """Poses, lines and waves as the page's own program computes them between moments; the picture is not empty."""
    _, result = spar
    page = fw.view(result, tmp_path / "spar.html").path
    asked = tmp_path / "asked.html"
    question = """<script>
      const hub = scene.frames.indexOf("turbine.frame"), t = 1.23;
      document.title = JSON.stringify({ hub: fowtView.pose(hub, t)[0], turn: fowtView.pose(hub, t)[1],
        fairlead: [...fowtView.linePoints(scene.curves[0], t).slice(-3)],
        waves: [...fowtView.elevations(t, -50, 25, 5)],
        ready: document.documentElement.dataset.ready, shown: document.getElementById("time").textContent,
        surge: document.getElementById("readings").textContent.match(/surge(-?[0-9.]+)m/)[1] });
    </script></body>"""
    asked.write_text(page.read_text().replace("</body>", question))
    dom = chromium(asked, tmp_path, "--dump-dom", part="#t=1.5")
    found = json.loads(re.search(r"<title>(\{.*?\})</title>", dom)[1])
    assert found["ready"] == "yes" and found["shown"] == "1.5 / 2 s"

    def at(name: str, t: float) -> np.ndarray:
        values = result.array(name)
        return np.array([np.interp(t, result.time, column) for column in values.reshape(len(values), -1).T])

    assert found["hub"] == pytest.approx(at("turbine.frame.r", 1.23), abs=1e-3)
    matrix = at("turbine.frame.R", 1.23).reshape(3, 3)
    assert Rotation.from_quat(found["turn"]).as_matrix() == pytest.approx(matrix, abs=1e-4)
    assert found["fairlead"] == pytest.approx(at("platform.mooring.line_1.fairlead.r", 1.23), abs=0.03)
    k = 2 * np.pi / 156.0  # deep water: 9.80665 m/s^2 (10 s)^2 / 2 pi = 156.1 m
    assert found["waves"] == pytest.approx(2 * np.cos(0.2 * np.pi * 1.23 - k * np.arange(-50, 51, 25)), abs=0.02)
    assert float(found["surge"]) == pytest.approx(at("surge", 1.5)[0], abs=0.01)

    picture = tmp_path / "picture.png"
    chromium(page, tmp_path, f"--screenshot={picture}", part="#t=1.5&theme=light&view=side")
    pixels = imread(picture)[..., :3]
    yellow = (pixels[..., 0] > 0.6) & (pixels[..., 1] > 0.45) & (pixels[..., 2] < 0.35)  # the hull above the water
    rows, columns = np.nonzero(yellow)
    assert yellow.sum() > 50 and abs(np.median(columns) - 450) < 60 and abs(np.median(rows) - 300) < 120
    blue = pixels[550:, :300].reshape(-1, 3).mean(axis=0)
    assert blue[2] > blue[0]  # the water below
