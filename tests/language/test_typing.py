"""What runs passes a strict type checker, and what does not is marked on its line: in user scripts and in the docs."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("basedpyright", reason="the type checker of the extra 'dev'")

ROOT = Path(__file__).parents[2]
SCRIPT = '''
from __future__ import annotations

from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.components.aero import CoefficientRotor
from fowtlib.components.environment import Sea, Wind, World
from fowtlib.components.mechanics import BeamProperties, FixedTranslation, Frame, PointMass, Prismatic
from fowtlib.components.mooring import CatenaryLine, MooringSystem
from fowtlib.components.servo import BaselineController, BladedController
from fowtlib.components.support import FlexibleTower
from fowtlib.components.turbine import RotorNacelle
from fowtlib.control import (
    Margins, OperatingPoints, PitchLoop, Regulator, compensator, discretized, gain_table, kalman, lqi, lqr, margins,
    reduced, shave_peak, tune_pi,
)
from fowtlib.language import (
    Array, Component, Number, RealInput, RealOutput, Scalar, Vector, der, eq, outer, param, part, port, var,
)


class Plate(Component):
    """A class of the user's own."""

    diameter: Scalar = param(unit="m", min=0, doc="diameter")
    depth: Number = param(default=10.0, unit="m", doc="depth")
    offset: Vector = param(default=(0, 0, 0), unit="m", doc="offset")
    sides: int = param(default=4, doc="number of sides")
    weights: Array = param(default=(1.0, 2.0), shape=(2,), doc="weights")
    world: World = outer(World)
    frame: Frame = port(doc="centre")
    u: RealInput = port(default=0.0, doc="input")
    y: RealOutput = port(doc="output")
    v: Scalar = var(unit="m/s", doc="speed")
    inner: PointMass = part(PointMass, mass=1000 * diameter**2)

    def build(self) -> None:
        self.connect(self.frame, self.inner.frame_a)

    def equations(self) -> list[object]:
        area = np.pi / 4 * self.diameter**2
        turning = self.frame.w[2] * self.offset[0]
        return [eq(self.y, area * self.u / 100 + self.depth), eq(der(self.v), turning - self.v / 3)]


class MassOfAll(Component):
    """Parts in an array of ports."""

    frames: Frame = port(size=2, doc="frames")
    body: Component = part(PointMass, mass=3)

    def build(self) -> None:
        for i in range(2):
            mass = self.add(f"mass_{i + 1}", PointMass(mass=f"{i + 1} t"))
            self.connect(self.frames[i], mass.frame_a)


plate = Plate(diameter="8 m")
Plate(diameter=8, depth="3 m", offset=["1 m", 0, 0], weights=[3, 4], inner=PointMass(mass=2))
Plate(diameter=np.float64(3), offset=np.zeros(3), weights=np.ones(2))
Plate(diameter=2 * plate.diameter, depth=3)
plate.diameter = "9 m"
plate.offset = (0, 0, "1 m")
plate.inner = PointMass(mass=3)
half: float = plate.depth / 2

root = fw.Assembly("two ways of saying the same")
root.world = World(water_depth="320 m", gravity=9.81)
root.wind = Wind(kind="steady", mean_speed="12 m/s")
root.sea = Sea(spectrum="jonswap", significant_wave_height="6 m", peak_period=10, seed=2)
root.slide = Prismatic(n=(0, 0, 1))
root.plate = plate
root.connect(root.world.frame, root.slide.frame_a)
root.connect(root.slide.frame_b, plate.frame)
link = FixedTranslation(r=(0, 0, "3 m"))
root.add("link", link)
root.tip = PointMass(mass=3.0)
root.connect(plate.frame, link.frame_a)
root.connect(link.frame_b, root.tip.frame_a)
root.connect(plate.y, plate.u)
MooringSystem(
    headings=["60 deg", "180 deg"], length="902 m", axial_stiffness=[3e8, "384 MN"], mass_per_length=77.7,
    fairlead_radius=5, fairlead_depth="70 m", anchor_radius="0.8 km", anchor_depth=320,
)
CatenaryLine(length=1, axial_stiffness=1, mass_per_length=1, anchor_position=(0, 0, "-320 m"))
FlexibleTower(properties="tower.csv", hinges=2)  # needs files
FlexibleTower(properties=BeamProperties.uniform(80.0, 4000.0, 5e11), table=None, hinges=2)
CoefficientRotor(coefficients=Path("rotor.csv"), radius="63 m", inertia=3.9e7)
control = BaselineController(proportional_gain="0.006 s", integral_gain=0.0009, sample_period="10 ms")
RotorNacelle(mass="350 t", gear_ratio=97, generator_inertia=534.116, control=control)  # needs files
RotorNacelle(mass=1, gear_ratio=97, generator_inertia=1, control=BladedController(file="libdiscon.so"))  # needs files
model = fw.load(root, set={"plate.diameter": "10 m"})
speed = model.compile().simulate(10.0)["plate.v"]
print(float(speed[-1]), half)

linear = fw.LinearModel(-np.eye(1), np.eye(1), np.eye(1), np.zeros((1, 1)), ["x"], ["u"], ["y"], {})
regulator: Regulator = lqi(linear, {"x": 1}, {"u": 100}, {"y": 0.1})
estimator = kalman(linear, {"x": 1.0}, {"y": 0.01})
lqr(reduced(linear, ["x"]), 1, np.eye(1), used=["u"])
loop: dict[str, Margins] = margins(discretized(linear, 0.1, method="tustin"))
print(regulator.poles.real, compensator(regulator, estimator).modes()[0].period, loop["u"].disk_gain[0])
points = OperatingPoints(model, {"pitch": "rotor.blade_pitch"}, ["rotor.w"], over="depth")  # needs files
gain_table([points.at(13, held={"pitch": 0.1})], [regulator]).save(Path("gains.json"))  # needs files
pitch = PitchLoop(model, "turbine.control.pitch")  # needs files
print(tune_pi(pitch, [13, 15.0], 0.2).at(0.1)[0], shave_peak(pitch, (11, 12), 0.9)[0].thrust)  # needs files

Plate()  # wrong
Plate(diameter=8, diametre=8)  # wrong
Plate(diameter=[1, 2])  # wrong
Plate(diameter=8, depth=[1, 2])  # wrong
Plate(diameter=8, offset=3)  # wrong
Plate(diameter=8, sides="four")  # wrong
Plate(diameter=8, sides=4.5)  # wrong
Plate(diameter=8, frame=plate.frame)  # wrong
Plate(diameter=8, v=0.0)  # wrong
Plate(diameter=8, world=World())  # wrong
Plate(diameter=8, inner=World())  # wrong
plate.diameter = None  # wrong
plate.sides = "four"  # wrong
plate.inner = World()  # wrong
plate.frame = 3  # wrong
root.connect(plate, plate.frame)  # wrong
root.connect(plate.frame, 3)  # wrong
RotorNacelle(mass=1, gear_ratio=97, generator_inertia=1, control=World())  # wrong
FixedTranslation(r="3 m", length=3)  # wrong
FlexibleTower(properties=3.0, hinges=2)  # wrong
FlexibleTower(properties=World(), hinges=2)  # wrong
lqr(linear, plate, 1)  # wrong
kalman(linear, {"x": 1.0}, ["y"])  # wrong
'''


def problems(folder: Path, mode: str) -> list[tuple[str, int, str]]:
    """File, line and message of everything the checker finds in the Python files of a folder."""
    settings = {"include": ["."], "typeCheckingMode": mode, "pythonVersion": "3.11", "pythonPlatform": "Linux"}
    (folder / "pyrightconfig.json").write_text(json.dumps(settings))
    command = [sys.executable, "-m", "basedpyright", "--outputjson", "-p", str(folder), "--pythonpath", sys.executable]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    found = json.loads(run.stdout)
    assert found["summary"]["filesAnalyzed"] > 0
    return [
        (Path(item["file"]).name, item["range"]["start"]["line"] + 1, item["message"])
        for item in found["generalDiagnostics"]
        if item["severity"] == "error"
    ]


def test_a_user_script(tmp_path):
    """Strict: everything that runs passes, and each wrong line is marked."""
    (tmp_path / "script.py").write_text(SCRIPT)
    expected = [i for i, line in enumerate(SCRIPT.splitlines(), 1) if line.endswith("# wrong")]
    found = problems(tmp_path, "strict")
    assert {line for _, line, _ in found} == set(expected), found


def test_what_the_checker_accepts_runs(tmp_path):
    """The lines that are not marked."""
    keep = [line for line in SCRIPT.splitlines() if not line.endswith(("# wrong", "# needs files"))]
    (path := tmp_path / "script.py").write_text("\n".join(keep))
    run = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split()[1] == "5.0"


def test_examples_of_the_docs(tmp_path):
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        found = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)
        (tmp_path / f"{page.stem}.py").write_text("\n".join(found), encoding="utf-8")
    assert problems(tmp_path, "standard") == []


def test_the_installed_package_says_that_it_is_typed():
    import fowtlib

    assert (Path(fowtlib.__file__).parent / "py.typed").is_file()
