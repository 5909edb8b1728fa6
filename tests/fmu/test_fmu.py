"""An FMU as a sampled part: the same as the controller written in equations, and what goes wrong with it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.fmu import FMU
from fowtlib.language import Component, RealInput, RealOutput, Scalar, der, eq, param, port, var
from fowtlib.language.errors import ModelError, ParameterError, SimulationError
from fowtlib.solving.run import Interrupted

VERSIONS = (2, 3)
PITCH, ROTOR, TORQUE = 0.12, 1.267, 43093.55
NAMES = '{"generator.speed": generator_speed, "pitch[1]": blade_pitch, torque: generator_torque}'
BUILT_IN = f"""
      control:
        class: BaselineController
        proportional_gain: 0.006275604 s
        integral_gain: 0.0008965149
        sample_period: 12.5 ms
        pitch_start: {PITCH}
        speed_start: {97 * ROTOR}
        parts: {{torque: {{torque_start: {TORQUE}}}}}
"""
IMPORTED = f"""
      control:
        class: FMU
        file: FILE
        names: {NAMES}
        start:
          pitch_start: {PITCH}
          torque_start: {TORQUE}
          speed_start: {97 * ROTOR}
          "pitch[1]": {PITCH} rad
          torque: {TORQUE} N*m
          mode: 3
          enabled: true
          MORE
"""
SPAR = f"""
fowtlib: 1
title: spar
world: {{class: World, water_depth: 320 m, water_density: 1025 kg/m^3}}
sea: {{class: Sea, spectrum: regular, wave_height: 4 m, wave_period: 9 s}}
wind: {{class: Wind, kind: steady, mean_speed: 13 m/s}}
parts:
  platform: {{use: platforms/oc3_hywind}}
  tower: {{class: RigidBody, mass: 249718 kg, r_cm: [0, 0, 43.348],
          inertia: [[120252000, 0, 0], [0, 120252000, 0], [0, 0, 1818460]]}}
  tower_to_hub: {{class: FixedTranslation, r: [-5, 0, 90]}}
  turbine:
    use: turbines/nrel5mw_rigid
    rotor_speed_start: {ROTOR}
    blade_pitch_start: {PITCH}
    parts:CONTROL
connect:
  - [world.frame, platform.world]
  - [platform.frame, tower.frame_a]
  - [platform.frame, tower_to_hub.frame_a]
  - [tower_to_hub.frame_b, turbine.frame]
outputs: {{surge: platform.motion.surge, pitch: platform.motion.pitch, rotor_speed: turbine.rotor_speed,
          blade_pitch: turbine.blade_pitch, generator_torque: turbine.generator_torque}}
"""


def spar(folder: Path, control: str):
    path = folder / "spar.yaml"
    path.write_text(SPAR.replace("CONTROL", control))
    return fw.load(path, trust=True).compile()


class Rotor(Component):
    """A rotor that an FMU brakes."""

    inertia: Scalar = param(default=43.0e6 / 97**2, unit="kg*m^2")
    torque: RealInput = port(unit="N*m")
    speed: RealOutput = port(unit="rad/s")
    w: Scalar = var(unit="rad/s", start=97 * ROTOR, fixed=True)

    def equations(self):
        return [eq(self.inertia * der(self.w), TORQUE - self.torque), eq(self.speed, self.w)]


OPEN = {"mode": 2, "enabled": True}


def braked(path: str, **start) -> fw.Assembly:
    model = fw.Assembly("braked")
    more = {"array_in": 0.0} if "array_in" in FMU(file=path).ports else {}
    model.unit, model.rotor = FMU(file=path, start={**OPEN, **more, **start}), Rotor()
    model.connect(model.rotor.speed, model.unit.generator_speed)
    model.connect(model.unit.torque, model.rotor.torque)
    return model


@pytest.mark.parametrize("version", VERSIONS)
def test_the_made_fmu_is_valid(fmu, version):
    from fmpy.validation import validate_fmu

    assert validate_fmu(fmu(version)) == []


@pytest.fixture(scope="module")
def built_in(tmp_path_factory):
    return spar(tmp_path_factory.mktemp("built_in"), BUILT_IN).simulate(10.0, 0.1, solver="fixed", step=0.0125)


@pytest.mark.parametrize("version", VERSIONS)
def test_it_drives_the_spar_as_the_controller_of_the_library_does(fmu, tmp_path, built_in, version):
    """The model file stands beside the FMU; 0.02 s after the first sample already both follow the waves."""
    Path(tmp_path / "controller.fmu").write_bytes(Path(fmu(version)).read_bytes())
    text = IMPORTED.replace("FILE", "controller.fmu").replace("MORE", "array_in: 0" if version == 3 else "")
    result = spar(tmp_path, text).simulate(10.0, 0.1, solver="fixed", step=0.0125)
    for name in built_in.dataset:
        scale = np.abs(built_in[name].values).max()
        np.testing.assert_allclose(result[name].values, built_in[name].values, rtol=0, atol=1e-9 * scale)
    assert np.ptp(result["blade_pitch"].values) > 0.02  # it has controlled something
    assert result["turbine.control.samples"][-1] == 801  # 10 s of 12.5 ms and the one at the start
    assert result["turbine.control.mode_out"][-1] == 3


def test_named_in_a_model_file_it_runs_with_leave_only(fmu, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    Path(tmp_path / "controller.fmu").write_bytes(Path(fmu(2)).read_bytes())
    spar(tmp_path, IMPORTED.replace("FILE", "controller.fmu").replace("MORE", ""))
    for run in (lambda plant: plant.simulate(0.1, 0.1), lambda plant: plant.simulate(0.1, 0.1, solver="fixed")):
        with pytest.raises(ModelError, match=r"spar\.yaml:\d+: turbine\.control\.file names native code"):
            run(fw.load(tmp_path / "spar.yaml").compile())


def test_both_solvers_call_it_once_in_a_sample(fmu):
    plant = fw.load(braked(fmu())).compile()
    names = ["unit.samples", "unit.torque", "rotor.w", "unit.instances"]
    runs = [plant.simulate(1.0, 0.1, solver=solver, outputs=names) for solver in ("idas", "fixed", "fixed")]
    for run in runs:
        assert run["unit.samples"].values.tolist() == [1 + 8 * k for k in range(11)]
        assert run["unit.instances"][-1] == 1  # each run loads a library of its own
    np.testing.assert_allclose(runs[0]["rotor.w"], runs[1]["rotor.w"], rtol=1e-7)
    np.testing.assert_array_equal(runs[1]["rotor.w"], runs[2]["rotor.w"])


def test_two_instances_share_nothing(fmu):
    model = fw.Assembly("two")
    for k in (1, 2):
        model.add(f"unit_{k}", FMU(file=fmu(), start={**OPEN, "torque_start": 9e3 * k, "generator.speed": 900.0}))
    result = fw.load(model).compile().simulate(0.5, 0.1, outputs=[f"unit_{k}.{n}" for k in (1, 2) for n in NAMES_READ])
    assert result["unit_1.instances"][-1] == result["unit_2.instances"][-1] == 1
    assert result["unit_1.samples"][-1] == result["unit_2.samples"][-1] == 41
    assert result["unit_1.torque"][-1] != result["unit_2.torque"][-1]


NAMES_READ = ("instances", "samples", "torque")


@pytest.mark.parametrize("version", VERSIONS)
def test_ports_have_the_units_and_shapes_of_the_description(fmu, version):
    unit = FMU(file=fmu(version))
    units = {name: (field.annotation, field.unit, unit.shape_of(field)) for name, field in unit.ports.items()}
    expected = {
        "generator_speed": (RealInput, "rad/s", ()), "mode": (RealInput, "1", ()), "enabled": (RealInput, "1", ()),
        "pitch_1": (RealOutput, "rad", ()), "torque": (RealOutput, "N*m", ()), "mode_out": (RealOutput, "1", ()),
        "samples": (RealOutput, "1", ()), "active": (RealOutput, "1", ()), "instances": (RealOutput, "1", ()),
    }  # fmt: skip
    if version == 3:
        expected |= {"array_in": (RealInput, "1", (2, 2)), "array_out": (RealOutput, "1", (2, 2))}
    assert units == expected
    assert FMU.ports == {}  # other instances have their own


def test_numbers_that_are_no_reals_and_arrays(fmu):
    """A whole number is the nearest one, true begins at one half; a matrix keeps its rows and columns."""
    model = fw.Assembly("values")
    model.unit = FMU(file=fmu(3), start={"generator.speed": 0, "array_in": [1, 2, 3, 4]})
    model.mode, model.enabled = Constant(value=6.6), Constant(value=0.4)
    model.connect(model.mode.y, model.unit.mode)
    model.connect(model.enabled.y, model.unit.enabled)
    names = ["unit.mode_out", "unit.active", "unit.array_in", "unit.array_out"]
    result = fw.load(model).compile().simulate(0.1, 0.05, outputs=names)
    assert (result["unit.mode_out"][-1], result["unit.active"][-1]) == (7, 0)
    assert result["unit.array_in"].values[-1].tolist() == [[1, 2], [3, 4]]
    assert result["unit.array_out"].values[-1].tolist() == [[1, 4], [9, 16]]


def test_a_whole_number_that_the_type_does_not_have(fmu):
    model = fw.Assembly("large")
    model.unit = FMU(file=fmu(3), start={"generator.speed": 0, "array_in": 0, "enabled": True})
    model.mode = Constant(value=3e9)
    model.connect(model.mode.y, model.unit.mode)
    with pytest.raises(SimulationError, match="unit: the input 'mode' is 3000000000, and -2147483648 to 2147483647 is"):
        fw.load(model).compile().simulate(0.1, 0.05)


def test_start_values_are_in_the_unit_of_the_fmu_unless_they_carry_one(fmu):
    for given, expected in ((12.0, 12.0), ("12", 12.0), ("0.5 rad", np.degrees(0.5)), ("3 arcmin", 0.05)):
        unit = FMU(file=fmu(), start={"pitch[1]": given, "generator.speed": given if given == 12.0 else 1})
        (signal,) = (signal for signal in unit._outputs if signal.port == "pitch_1")
        assert np.degrees(float(signal.start)) == pytest.approx(expected)


def test_an_open_input_is_an_error(fmu):
    model = fw.Assembly("open")
    model.unit = FMU(file=fmu(), start={"mode": 1, "enabled": True})
    with pytest.raises(ModelError, match=r"unit\.generator_speed"):
        fw.load(model).compile()


REFUSED = [
    ({"start": {"k_q": 1}}, "start: there is no variable 'k_q'; did you mean 'k_p' or 'k_i'?"),
    ({"start": {"k_p": "1 m"}}, "start: k_p: got '1 m', which is a length; a number without a unit is expected"),
    ({"start": {"mode": float("inf")}}, "start: mode: got inf, and a whole number from"),
    ({"start": {"mode": 1.5}}, "start: mode: got 1.5, and a whole number from -2147483648 to 2147483647 is expected."),
    ({"start": {"enabled": 3}}, "start: enabled: got 3, and true or false is expected."),
    ({"start": {"k_p": [1, 2]}}, "start: k_p: got 2 values, and 1 are expected."),
    ({"names": {"torque": "mode_out"}}, "the outputs 'torque' and 'mode_out' would both be the port 'mode_out'"),
    ({"names": {"torque": "file"}}, "the variable 'torque' cannot be the port 'file', which is taken"),
    ({"names": {"torque": "a b"}}, "names: torque: 'a b' is not a name; use letters, digits and underscores"),
    ({"names": "torque"}, "names: got 'torque', and a mapping is expected."),
    ({"ignore": {"torque": 1}}, "ignore: got {'torque': 1}, and a list is expected."),
    ({"start": [1]}, "start: got [1], and a mapping is expected."),
    ({"ignore": ["torqe"]}, "ignore: there is no variable 'torqe'; did you mean 'torque'?"),
    ({"units": {"torque": "frlng"}}, "units: torque: "),
    ({"period": 0.0}, "period"),
]


@pytest.mark.parametrize(("values", "text"), REFUSED)
def test_values_that_do_not_fit_the_file(fmu, values, text):
    with pytest.raises(ModelError) as caught:
        model = fw.Assembly("refused")
        model.unit = FMU(file=fmu(), **{"start": {**OPEN, "generator.speed": 0}, **values})
        fw.load(model).compile()
    assert text in str(caught.value)


def test_the_error_stands_at_its_line_of_the_model_file(fmu, tmp_path):
    text = IMPORTED.replace("FILE", str(fmu())).replace("MORE", "k_q: 1")
    with pytest.raises(ModelError, match=r"spar\.yaml:\d+.*turbine\.control.*no variable 'k_q'"):
        spar(tmp_path, text)


# --- runs that fail --------------------------------------------------------------------------------------------------


def left() -> set[str]:
    return {name for name in os.listdir(tempfile.gettempdir()) if name.startswith(("fowtlib_session_", "fowtlib_new_"))}


FAILURES = [
    (2, 1, "unit: the FMU fails: fmi2DoStep failed with status 3 (error): the pitch drive is gone (t = 0.5 s)."),
    (2, 2, "unit: the FMU fails: fmi2DoStep failed with status 4 (fatal): the pitch drive is gone (t = 0.5 s)."),
    (2, 3, "unit.pitch_1_held is nan: the process behind it has failed (t = 0.5 s)."),
    (3, 1, "unit: the FMU fails: fmi3DoStep failed with status 3 (error): the pitch drive is gone (t = 0.5 s)."),
    (3, 2, "unit: the FMU fails: fmi3DoStep failed with status 4 (fatal): the pitch drive is gone (t = 0.5 s)."),
    (3, 4, "unit: the FMU asks to end the simulation (t = 0.5 s)."),
]


@pytest.mark.parametrize(("version", "trouble", "text"), FAILURES)
def test_a_failure_says_where_and_keeps_the_results(fmu, version, trouble, text):
    before = left()
    plant = fw.load(braked(fmu(version), trouble=trouble, trouble_time=0.5)).compile()
    with pytest.raises(SimulationError) as caught:
        plant.simulate(1.0, 0.1, solver="fixed", outputs=["rotor.w"])
    assert str(caught.value) == text
    assert caught.value.result.dataset.sizes["time"] == 5  # 0 to 0.4 s
    assert left() == before


def test_its_files_are_deleted_after_a_run_and_after_ctrl_c(fmu):
    before = left()
    plant = fw.load(braked(fmu())).compile()
    plant.simulate(0.2, 0.1)

    def stop(t: float, t_end: float) -> None:
        if t > 0.1:
            assert left() != before
            raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        plant.simulate(1.0, 0.1, progress=stop)
    assert left() == before


def test_a_run_does_not_go_on_from_a_result(fmu):
    plant = fw.load(braked(fmu())).compile()
    result = plant.simulate(0.2, 0.1)
    with pytest.raises(SimulationError, match="cannot go on from an earlier result: unit has a memory of its own"):
        plant.simulate(0.4, 0.1, start=result)


KEEPS = {
    2: ("<CoSimulation ", '<CoSimulation canGetAndSetFMUstate="true" canSerializeFMUstate="true" '),
    3: ("<CoSimulation ", '<CoSimulation canGetAndSetFMUState="true" canSerializeFMUState="true" '),
}


@pytest.mark.parametrize("options", [{"solver": "idas"}, {"solver": "fixed", "step": 0.0125}], ids=("idas", "fixed"))
@pytest.mark.parametrize(("version", "middle"), [(2, 0.23), (2, 0.4), (3, 0.31)])
def test_a_run_with_an_fmu_that_keeps_its_state_goes_on_exactly(fmu, tmp_path, version, middle, options):
    plant = fw.load(braked(fmu(version, KEEPS[version]))).compile()
    names = ["rotor.w", "unit.torque", "unit.samples"]
    before = left()
    whole = plant.simulate(1.0, 0.02, outputs=names, **options)
    plant.simulate(middle, 0.02, outputs=names, **options).save(tmp_path / "first.nc")
    first = fw.Result.open(tmp_path / "first.nc")
    joined = first.followed_by(plant.simulate(1.0, 0.02, start=first, outputs=names, **options))
    assert joined.time.tobytes() == whole.time.tobytes()
    assert all(joined.array(name).tobytes() == whole.array(name).tobytes() for name in names)
    assert joined["unit.samples"][-1] == 81 and left() == before


def test_an_fmu_does_not_go_on_without_its_checkpoint(fmu):
    plant = fw.load(braked(fmu(2, KEEPS[2]))).compile()
    result = plant.simulate(0.3, 0.1)
    with pytest.raises(SimulationError, match="unit has a memory .* does not fit: tolerance was 1e-06, is 1e-07"):
        plant.simulate(0.4, 0.1, start=result, tolerance=1e-7)
    object.__setattr__(result.raw, "checkpoint", b"")
    with pytest.raises(SimulationError, match="unit has a memory of its own, which only a checkpoint holds, and"):
        plant.simulate(0.4, 0.1, start=result)


def test_an_fmu_that_cannot_save_what_it_says_it_can(fmu, monkeypatch):
    plant = fw.load(braked(fmu(2, KEEPS[2]))).compile()

    def fails(self) -> bytes:
        raise SimulationError("the FMU fails: fmi2GetFMUstate failed with status 3.")

    monkeypatch.setattr("fowtlib.components.fmu.running.FmuSession.saved_state", fails)
    with pytest.warns(UserWarning, match="unit: what it remembers cannot be saved, so that this run cannot be resumed"):
        result = plant.simulate(0.3, 0.1)
    assert result.time[-1] == 0.3
    with pytest.raises(SimulationError, match="cannot go on from an earlier result"):
        plant.simulate(0.4, 0.1, start=result)


def test_a_run_may_start_later(fmu):
    plant = fw.load(braked(fmu())).compile()
    result = plant.simulate(2.1, 0.1, start=plant.initial_state(t=2.0), outputs=["unit.samples"])
    assert result["unit.samples"][-1] == 9


def test_a_library_that_cannot_be_loaded(fmu_files, archive, tmp_path):
    files = fmu_files()
    binary = next(name for name in files if name.startswith("binaries"))
    path = archive(tmp_path / "bad.fmu", {**files, binary: b"this is no library"})
    here, before = os.getcwd(), left()
    with pytest.raises(SimulationError, match="unit: the FMU fails: Failed to load shared library"):
        fw.load(braked(str(path))).compile().simulate(0.1, 0.05)
    assert os.getcwd() == here
    assert left() == before


def test_a_file_that_has_changed_since(fmu, fmu_files, archive, tmp_path):
    path = archive(tmp_path / "changing.fmu", fmu_files())
    plant = fw.load(braked(str(path))).compile()
    path.write_bytes(Path(fmu(2, ('guid="fowtlib-test-controller"', 'guid="another"'))).read_bytes())
    with pytest.raises(SimulationError, match="has changed since the model was made"):
        plant.simulate(0.1, 0.05)


def test_an_instance_that_is_refused(fmu):
    path = fmu(2, ('guid="fowtlib-test-controller"', 'guid="another"'))
    with pytest.raises(SimulationError, match="unit: the FMU fails: Failed to instantiate"):
        fw.load(braked(path)).compile().simulate(0.1, 0.05)


def test_the_period(fmu):
    without = fmu(2, ('<DefaultExperiment stepSize="0.0125"/>', ""))
    with pytest.raises(ParameterError, match="does not name a communication step; give 'period'"):
        FMU(file=without)
    change = ('canHandleVariableCommunicationStepSize="true"', 'fixedInternalStepSize="0.01"')
    with pytest.raises(ParameterError, match=r"the period is 0\.0125 s, and this FMU steps by multiples of 0\.01 s"):
        FMU(file=fmu(3, change))
    model = fw.Assembly("slow")
    model.unit = FMU(file=fmu(3, change), period=0.05, start={**OPEN, "generator.speed": 0, "array_in": 0})
    result = fw.load(model).compile().simulate(1.0, 0.5, outputs=["unit.samples"])
    assert result["unit.samples"].values.tolist() == [1, 11, 21]


def test_seconds_of_an_fmu_may_pass_faster(fmu):
    """A rotor with a ninth of its inertia, and an FMU of which 9 s pass in one of the model: all is 9 times as fast."""
    path = str(fmu(2))
    slow, fast = braked(path), braked(path)
    fast.unit.time_factor = 9.0
    fast.rotor.inertia = 43.0e6 / 97**2 / 9
    runs = [fw.load(model).compile().simulate(end, step, tolerance=1e-9)["rotor.speed"].values
            for model, end, step in ((slow, 9.0, 0.9), (fast, 1.0, 0.1))]  # fmt: skip
    assert runs[1] == pytest.approx(runs[0], rel=1e-6)
    assert abs(runs[0][-1] / runs[0][0] - 1) > 1e-3
