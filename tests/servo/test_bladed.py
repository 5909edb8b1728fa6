"""A controller library with the Bladed interface: what it is told, what it answers, and what goes wrong."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.servo import BladedController
from fowtlib.components.servo.bladed import MEASURED
from fowtlib.language import Component, RealInput, RealOutput, Scalar, der, eq, port, var
from fowtlib.language.errors import ModelError, ParameterError, SimulationError
from fowtlib.language.native import compiler

pytestmark = pytest.mark.skipif(not compiler(), reason="no C compiler")
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> str:
    target = tmp_path_factory.mktemp("discon") / f"libdiscon{SUFFIX}"
    source = Path(__file__).parent / "discon.c"
    subprocess.run([*compiler(), "-O1", "-fPIC", "-shared", str(source), "-o", str(target), "-lm"], check=True)
    return str(target)


@pytest.fixture(autouse=True)
def temporary_files_of_its_own(tmp_path_factory, monkeypatch):
    """What a test leaves there is its own, whatever runs beside it."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path_factory.mktemp("temporary")))


class Shaft(Component):
    """A generator that speeds up by itself."""

    torque: RealInput = port(unit="N*m")
    speed: RealOutput = port(unit="rad/s")
    w: Scalar = var(unit="rad/s", start=100.0, fixed=True)

    def equations(self):
        return [eq(der(self.w), 8 - self.torque / 1000), eq(self.speed, self.w)]


def turbine(library: str, folder: Path, word: str = "none", gain: float = 0.02, **values) -> fw.Assembly:
    (folder / "DISCON.IN").write_text(f"{gain} {word}\n")
    model = fw.Assembly("turbine")
    values = {"period": 0.1, **values}
    model.control = BladedController(file=library, input_file=str(folder / "DISCON.IN"), **values)
    model.shaft = Shaft()
    for name, value in (("rotor_speed", 1.25), ("wind_speed", 8.5)):
        model.add(name, Constant(value=value))
        model.connect(model.parts[name].y, getattr(model.control, name))
    model.connect(model.shaft.speed, model.control.generator_speed)
    model.connect(model.control.generator_torque, model.shaft.torque)
    return model


def run(model: fw.Assembly, *outputs: str, t_end: float = 1.0, **options):
    return fw.load(model).compile().simulate(t_end, 0.1, outputs=list(outputs) or ["shaft.w"], **options)


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_its_demands_hold_from_the_sample_on(library, tmp_path, solver):
    """In each interval w' = 8 - 0.01 w_k; pitch and torque follow the speed of the same instant."""
    names = ("shaft.w", "control.blade_pitch", "control.generator_torque")
    result = run(turbine(library, tmp_path), *names, solver=solver)
    speed = [100.0]
    for _ in range(10):
        speed.append(speed[-1] + 0.1 * (8 - 0.01 * speed[-1]))
    np.testing.assert_allclose(result["shaft.w"], speed, rtol=1e-6)  # the records are of single precision
    np.testing.assert_allclose(result["control.blade_pitch"], 0.02 * (np.array(speed) - 100), atol=1e-6)
    np.testing.assert_allclose(result["control.generator_torque"], 10 * np.array(speed), rtol=1e-6)


def test_the_records_it_is_given(library, tmp_path):
    """OpenFAST 3.5, ServoDyn, Bladed interface."""
    further = {"measured_pitch_1": 4, "platform_surge": 1001}
    read = [1, 2, 3, 4, 10, 14, 15, 20, 21, 23, 24, 27, 28, 33, 34, 35, 37, 49, 50, 53, 54, 60, 61, 83, 101]
    model = turbine(
        library, tmp_path, efficiency=0.9, torque_start=500.0, pitch_start=0.04, measurements=further, records={7: 1.5},
        demands={f"record_{number}": 2000 + number for number in [*read, 7]} | {"calls": 48},
    )  # fmt: skip
    values = {"yaw_error": 0.1, "yaw": 0.2, "azimuth": 7.0, "fore_aft_acceleration": 0.3, "side_side_acceleration": 0.4,
              "nacelle_pitch_acceleration": 0.5, "measured_pitch_1": 0.6, "platform_surge": 0.7}  # fmt: skip
    for name, value in values.items():
        model.add(name, Constant(value=value))
        model.connect(model.parts[name].y, getattr(model.control, name))
    result = run(model, *(f"control.record_{number}" for number in [*read, 7]), "control.calls", t_end=0.2)

    def records(row: int) -> dict[int, float]:
        return {number: float(result[f"control.record_{number}"][row]) for number in [*read, 7]}

    input_length = len(str(tmp_path / "DISCON.IN")) + 1
    first = {
        1: 0, 2: 0, 3: 0.1, 4: 0.6, 7: 1.5, 10: 0, 14: 50000, 15: 45000, 20: 100, 21: 1.25, 23: 500, 24: 0.1, 27: 8.5,
        28: 0, 33: 0.04, 34: 0.04, 35: 1, 37: 0.2, 49: 1024, 50: input_length, 53: 0.3, 54: 0.4,
        60: 7.0 - 2 * np.pi, 61: 3, 83: 0.5, 101: 0.7,
    }  # fmt: skip
    assert records(0) == pytest.approx(first, rel=1e-6)
    later = first | {1: 1, 2: 0.2, 20: 101.3993, 23: 10 * 100.7, 33: 0.02 * 0.7, 34: 0.02 * 0.7}
    later |= {14: later[20] * later[23], 15: 0.9 * later[20] * later[23]}
    assert records(2) == pytest.approx(later, rel=1e-5)
    assert result["control.calls"].values.tolist() == [1, 2, 3]


def test_every_port_has_its_record():
    ports = {name for name, field in BladedController.ports.items() if field.annotation is RealInput}
    assert ports == set(MEASURED)


def test_first_later_and_last_call(library, tmp_path):
    run(turbine(library, tmp_path, output_root=str(tmp_path / "out")), t_end=0.3)
    assert (tmp_path / "out.log").read_text() == "0 0\n1 0.1\n1 0.2\n1 0.3\n-1 0.3\n"


def test_individual_pitch(library, tmp_path):
    names = ["control.blade_pitch", *(f"control.individual_pitch[{k}]" for k in range(3))]
    result = run(turbine(library, tmp_path, individual=True), *names, t_end=0.1)
    np.testing.assert_allclose([result[name][0] for name in names], [0.01, -0.01, 0, 0.01], atol=1e-7)


def test_an_open_contactor_means_no_torque(library, tmp_path):
    result = run(turbine(library, tmp_path, "off"), "control.generator_torque")
    assert (result["control.generator_torque"].values == 0).tolist() == [False] * 5 + [True] * 6


def test_two_controllers_and_two_runs_share_nothing(library, tmp_path):
    model = fw.Assembly("two")
    for name, gain in (("one", 0.02), ("two", 0.05)):
        (tmp_path / name).mkdir()
        model.add(name, turbine(library, tmp_path / name, gain=gain, demands={"calls": 48}))
    plant = fw.load(model).compile()
    names = [f"{name}.control.{what}" for name in ("one", "two") for what in ("calls", "blade_pitch")]
    first, second = (plant.simulate(1.0, 0.1, outputs=names) for _ in range(2))
    assert first["one.control.calls"][-1] == first["two.control.calls"][-1] == 11
    np.testing.assert_allclose(first["two.control.blade_pitch"], 2.5 * first["one.control.blade_pitch"], rtol=1e-5)
    for name in names:
        np.testing.assert_array_equal(first[name], second[name])


# --- what goes wrong -------------------------------------------------------------------------------------------------

FAILURES = [
    ("fail", "control: the controller library reports an error: the generator is too hot (t = 0.5 s)."),
    ("crash", "control: the controller library cannot be called: it crashed (SIGABRT); it printed: hello from the "
              "controller (t = 0.5 s)."),
    ("leave", "control: the controller library cannot be called: it ended its process with the code 3; it printed: "
              "hello from the controller (t = 0.5 s)."),
    ("brake", "control: the controller asks for the shaft brake (record 36), which the model has not (t = 0.5 s)."),
    ("nan", "control.torque is nan: the process behind it has failed (t = 0.5 s)."),
]  # fmt: skip


def left() -> set[str]:
    return {name for name in os.listdir(tempfile.gettempdir()) if name.startswith(("fowtlib_session_", "fowtlib_new_"))}


@pytest.mark.parametrize(("word", "text"), FAILURES)
def test_a_library_that_fails_stops_the_run_with_its_words(library, tmp_path, word, text):
    if word == "crash" and sys.platform == "win32":
        pytest.skip("no signals")
    before = left()
    with pytest.raises(SimulationError) as caught:
        run(turbine(library, tmp_path, word))
    assert str(caught.value) == text
    assert caught.value.result.dataset.sizes["time"] == 6
    assert left() == before


def test_a_library_that_hangs(library, tmp_path):
    words = r"it took longer than 0\.5 s, its 'patience'; it printed: hello from the controller"
    with pytest.raises(SimulationError, match=words):
        run(turbine(library, tmp_path, "hang", patience=0.5))


def test_in_this_process_it_gives_the_same(library, tmp_path):
    """Run after run it is loaded anew; two at once would share one memory, and are refused."""
    names = ["shaft.w", "control.blade_pitch", "control.calls"]
    here = os.getcwd()
    outside, *inside = (
        run(turbine(library, tmp_path, in_process=where, demands={"calls": 48}), *names)
        for where in (False, True, True)
    )
    for result in inside:
        for name in names:
            np.testing.assert_array_equal(result[name], outside[name])
    assert os.getcwd() == here
    model = fw.Assembly("two")
    for name in ("one", "two"):
        model.add(name, turbine(library, tmp_path, in_process=True))
    with pytest.raises(SimulationError, match="is at work in this process already"):
        run(model, "one.shaft.w")


def test_a_warning_is_said_once(library, tmp_path):
    with pytest.warns(UserWarning, match="the controller library says: the wind is strong") as said:
        run(turbine(library, tmp_path, "warn"))
    assert len(said) == 1


def test_an_input_file_it_cannot_read(library, tmp_path):
    model = turbine(library, tmp_path)
    (tmp_path / "DISCON.IN").write_text("nothing")
    with pytest.raises(SimulationError, match=r"the controller library reports an error: cannot read '.*DISCON"):
        run(model)


@pytest.mark.skipif(sys.platform != "linux", reason="how Linux finds the libraries that a library needs")
def test_a_library_taken_from_those_beside_it(tmp_path):
    """Built as in a wheel, with its needs found relative to itself; it loads where it is and says why not elsewhere."""
    wheel = tmp_path / "wheel"
    (wheel / "libs").mkdir(parents=True)
    (wheel / "lib").mkdir()
    (wheel / "needed.c").write_text("double gain() { return 2.0; }\n")
    build = [*compiler(), "-O1", "-fPIC", "-shared"]
    needed = wheel / "libs" / "libneeded_by_discon.so"
    subprocess.run([*build, str(wheel / "needed.c"), "-o", str(needed)], check=True)
    source = wheel / "discon.c"
    source.write_text("double gain();\nvoid DISCON(float *r, int *fail, char *a, char *b, char *c) {r[46] = gain();}\n")
    target = wheel / "lib" / "libdiscon.so"
    beside = [f"-L{needed.parent}", "-lneeded_by_discon", "-Wl,-rpath,$ORIGIN/../libs"]
    subprocess.run([*build, str(source), "-o", str(target), *beside], check=True)
    run(turbine(str(target), tmp_path))
    shutil.copy(target, tmp_path)
    with pytest.raises(SimulationError) as caught:
        run(turbine(str(tmp_path / "libdiscon.so"), tmp_path))
    assert "cannot be loaded: libneeded_by_discon.so" in str(caught.value)
    assert "leave it in its folder" in str(caught.value)


def test_a_file_that_is_no_library(library, tmp_path):
    (tmp_path / "no.so").write_bytes(b"no library")
    with pytest.raises(SimulationError, match=r"control: the controller library cannot be loaded: .*no\.so"):
        run(turbine(str(tmp_path / "no.so"), tmp_path))
    with pytest.raises(SimulationError, match="control: the controller library cannot be loaded: .*REGULATE"):
        run(turbine(library, tmp_path, procedure="REGULATE"))


REFUSED = [
    ({"file": "nowhere.so"}, "file: there is no file 'nowhere.so'."),
    ({"input_file": "nowhere.IN"}, "input_file: there is no file 'nowhere.IN'."),
    ({"output_root": "/no/where/out"}, "output_root: there is no folder '/no/where'."),
    ({"blades": 4}, "blades: the Bladed interface has 3 at most, not 4."),
    ({"measurements": {"speed": 20}}, "measurements: record 20 is the port 'generator_speed'."),
    ({"measurements": {"speed": 5000}}, "measurements: 5000 is not the number of a record, 1 to 3300."),
    ({"measurements": {"time": 2}}, "measurements: record 2 is set by the interface itself."),
    ({"measurements": {"azimuth": 1001}}, "azimuth is declared already"),
    ({"demands": {"x": "yaw"}}, "demands: 'yaw' is not the number of a record, 1 to 3300."),
    ({"demands": [48]}, "demands: got [48], and a mapping is expected."),
    ({"records": {7: "much"}}, "records: record 7 is 'much', and a finite number is expected."),
]


@pytest.mark.parametrize(("values", "text"), REFUSED)
def test_values_that_cannot_be(library, values, text):
    with pytest.raises(ParameterError) as caught:
        BladedController(**{"file": library, **values})
    assert text in str(caught.value)


def test_it_takes_the_place_of_the_controller_of_a_turbine(library, tmp_path):
    (tmp_path / "DISCON.IN").write_text("0.02 none\n")
    (tmp_path / "land.yaml").write_text(f"""
fowtlib: 1
title: a turbine on land
world: {{class: World}}
wind: {{class: Wind, kind: steady, mean_speed: 9 m/s}}
parts:
  top: {{class: FixedTranslation, r: [-5, 0, 90]}}
  anemometer: {{class: Demux, n: 1}}
  turbine:
    use: turbines/nrel5mw_rigid
    rotor_speed_start: 10.3 rpm
    blade_pitch_start: 2 deg
    parts:
      control: {{class: BladedController, file: "{library}", input_file: DISCON.IN, torque_start: 25 kN*m}}
connect:
  - [world.frame, top.frame_a]
  - [top.frame_b, turbine.frame]
  - [wind.speed, anemometer.u]
  - ["anemometer.y[0]", turbine.control.wind_speed]
  - [turbine.rotor_speed, turbine.control.rotor_speed]
""")
    plant = fw.load(tmp_path / "land.yaml", trust=True).compile()
    state = plant.initial_state()
    assert np.degrees(state["turbine.blade_pitch"]) == pytest.approx(2)
    assert state["turbine.generator_torque"] == pytest.approx(25e3)
    result = plant.simulate(0.2, 0.1, outputs=["turbine.blade_pitch", "turbine.generator_speed"])
    expected = 0.02 * (result["turbine.generator_speed"].values - 100)
    np.testing.assert_allclose(result["turbine.blade_pitch"], expected, atol=1e-6)


def test_a_model_file_says_where_a_file_is_missing(tmp_path):
    (tmp_path / "m.yaml").write_text("fowtlib: 1\ncontrol: {class: BladedController, file: libno.so}\n")
    with pytest.raises(ModelError, match=r"m\.yaml:2: control\.file: there is no file 'libno\.so'"):
        fw.load(tmp_path / "m.yaml")
