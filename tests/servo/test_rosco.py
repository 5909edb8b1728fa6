"""ROSCO (Apache-2.0, NREL) as the controller of the OC3-Hywind spar: pitch, speed and power that a user expects.

Runs where the package rosco is installed, or where the environment variable FOWTLIB_ROSCO names the folder of its
unpacked wheel: pip download --no-deps rosco; unzip.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models


def rosco_folder() -> Path | None:
    """The folder that holds rosco/ and Examples/."""
    if folder := os.environ.get("FOWTLIB_ROSCO"):
        return Path(folder)
    found = importlib.util.find_spec("rosco")
    return Path(found.origin).parents[1] if found and found.origin else None


FOLDER = rosco_folder()
pytestmark = pytest.mark.skipif(FOLDER is None, reason="needs rosco: see the first lines of this file")
CONTROL = """turbine:
    use: turbines/nrel5mw
    rotor_speed_start: {speed} rpm
    blade_pitch_start: {pitch} deg
    parts:
      control:
        class: BladedController
        file: {library}
        input_file: DISCON.IN
        efficiency: 0.944
        torque_start: {torque} kN*m
  anemometer: {{class: Demux, n: 1}}"""
CONNECT = """
  - [wind.speed, anemometer.u]
  - ["anemometer.y[0]", turbine.control.wind_speed]
  - [turbine.rotor_speed, turbine.control.rotor_speed]
outputs:"""


def scaled(text: str, name: str, factor: float) -> str:
    """The input file with one row of numbers multiplied."""
    line = next(line for line in text.splitlines() if re.search(rf"!\s*{name}\b", line))
    numbers, comment = line.split("!", 1)
    row = "  ".join(f"{factor * float(number):.6e}" for number in numbers.split())
    return text.replace(line, f"{row}  !{comment}")


def floating_input(folder: Path) -> None:
    """The input of the package for the NREL 5 MW on land, with the gains of a floating turbine.

    J. Jonkman, NREL/TP-500-47535 (2010), section 6: the gains on land would drive the platform pitch; K_P is a third
    and K_I a ninth of them, and the torque above rated is constant.
    """
    examples = FOLDER / "Examples/Test_Cases/NREL-5MW"
    text = (examples / "DISCON.IN").read_text()
    text = scaled(scaled(text, "PC_GS_KP", 1 / 3), "PC_GS_KI", 1 / 9)
    for name, value in (("VS_ConstPower", 0), ("LoggingLevel", 0)):
        text, count = re.subn(rf"(?m)^\d+(\s*!\s*{name}\b)", rf"{value}\1", text)
        assert count == 1
    (folder / "DISCON.IN").write_text(text)
    shutil.copy(examples / "Cp_Ct_Cq.NREL5MW.txt", folder)


def spar(folder: Path, wind: float, **start):
    """The shipped model oc3_spar with ROSCO in still water and steady wind."""
    text = (Path(fowtlib.models.__path__[0]) / "oc3_spar.yaml").read_text()
    control = CONTROL.format(library=FOLDER / "rosco/lib/libdiscon.so", **start)
    changes = (("turbine: {use: turbines/nrel5mw}", control), ("\noutputs:", CONNECT),
               ("spectrum: jonswap, significant_wave_height: 6 m, peak_period: 10 s, seed: 1", "spectrum: still"),
               ("kind: kaimal, mean_speed: 11.4 m/s, turbulence_class: B, seed: 1",
                f"kind: steady, mean_speed: {wind} m/s"))  # fmt: skip
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "spar.yaml").write_text(text)
    return fw.load(folder / "spar.yaml", trust=True, allow=[str(FOLDER)]).compile()


def test_the_recipe_of_the_documentation_runs(tmp_path, monkeypatch):
    """docs/importing.md, with its files where it puts them; the values of the NREL 5 MW at 13 m/s.

    NREL/TP-500-38060 (2009), table 7-1: 12.1 rpm, 6.60 deg, 5000 kW; ROSCO's rigid turbine needs a little less pitch.
    """
    page = (Path(__file__).parents[2] / "docs" / "importing.md").read_text(encoding="utf-8")
    text = re.search(r'```yaml title="land_with_rosco.yaml"\n(.*?)```', page, re.S)[1]
    copied = re.search(r"^cp (\S+) (\S+) \.$", page, re.M)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rosco_wheel").symlink_to(FOLDER)
    for name in copied.groups():
        shutil.copy(name, tmp_path)
    Path("land_with_rosco.yaml").write_text(text, encoding="utf-8")
    plant = fw.load("land_with_rosco.yaml", trust=True, allow=[str(FOLDER)]).compile()  # a link leads out of the folder
    late = plant.simulate(30.0, 0.5).dataset.isel(time=-1)
    assert float(late["rotor_speed"]) == pytest.approx(12.1, rel=0.002)
    assert float(late["pitch"]) == pytest.approx(6.43, abs=0.05)
    assert float(late["power"]) == pytest.approx(5000, rel=0.002)


# Rotor speed [rpm], blade pitch [deg], electrical power [kW] of the NREL 5 MW. At 18 m/s rated speed and power, and the
# pitch of NREL/TP-500-38060 (2009), table 7-1. At 8 m/s the best tip speed ratio 7.55 and power coefficient 0.482 of
# its section 7.2 with an efficiency of 94.4 %: 9.155 rpm and 0.944 * 0.482 * 1.225/2 pi 63^2 8^3 W = 1779 kW.
EXPECTED = {8: (9.155, 0.0, 1779), 18: (12.1, 14.92, 5000)}
START = {
    8: ({"speed": 9.16, "pitch": 0, "torque": 20.0}, {"surge": 11.74, "pitch": "2.70 deg"}),
    18: ({"speed": 12.1, "pitch": 14.7, "torque": 43.09}, {"surge": 12.6, "pitch": "2.84 deg"}),
}


@pytest.mark.parametrize("wind", [8, 18])
def test_the_spar_runs_where_it_should(tmp_path, wind):
    floating_input(tmp_path)
    at_start, motion = START[wind]
    plant = spar(tmp_path, wind, **at_start)
    start = plant.initial_state(start={f"platform.motion.{name}": value for name, value in motion.items()})
    late = plant.simulate(100.0, 0.1, start=start).dataset.sel(time=slice(60, None))
    speed, pitch, power = EXPECTED[wind]
    assert float(late["rotor_speed"].mean()) == pytest.approx(speed, rel=0.01)
    assert float(late["blade_pitch"].mean()) == pytest.approx(pitch, abs=0.3)
    assert float(late["generator_power"].mean()) == pytest.approx(power, rel=0.02)
    assert np.ptp(late["rotor_speed"].values) < 0.1  # rpm: it is steady
    assert np.ptp(late["pitch"].values) < 0.3  # deg
