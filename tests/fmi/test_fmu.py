"""Exported FMUs in fmpy: the same numbers as a run in Python, in both versions and kinds, and an orderly life.

The machine of conftest.py has an event, a sampled controller, a loop, a table, an initial equation and checks.
"""

from __future__ import annotations

import ctypes
import math
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

import fowtlib as fw
from fowtlib.components.environment import generate_field
from fowtlib.language import ExternalFunction, Scalar, call, der, eq, param, sampled, var
from fowtlib.language.errors import ModelError
from fowtlib.language.units import from_si

NAMES = ["height", "place", "loop", "command", "bounces", "machine.speed", "machine.lag"]
STATES = ["machine.height", "machine.speed", "machine.place", "machine.lag"]


def in_si(plant, result, name):
    """A result of a run in the unit of its variable in an FMU."""
    path, unit, _ = plant.outputs.get(name) or (name, *plant.describe(name))
    return np.asarray(result[name]).ravel() / from_si(1.0, plant.describe(path)[0], unit)


def distance(plant, result, rows, name):
    """Largest difference, relative to the largest value."""
    reference = in_si(plant, result, name)
    return np.max(np.abs(rows[name] - reference)) / (np.max(np.abs(reference)) or 1.0)


# --- the archive ----------------------------------------------------------------------------------------------------


def test_archive_is_valid_and_holds_its_sources(unit):
    assert validate_fmu(str(unit.path)) == []
    with zipfile.ZipFile(unit.path) as archive:
        names = archive.namelist()
        assert not archive.testzip()
    assert {"modelDescription.xml", "sources/fmu.c", "sources/model.c", "sources/tables.h"} <= set(names)
    assert any(name.startswith("binaries/") for name in names)
    assert ("sources/buildDescription.xml" in names) == (unit.version == "3")


def test_description_says_what_the_model_says(unit):
    described = unit.described
    by_name = {v.name: v for v in described.modelVariables}
    gravity = by_name["machine.gravity"]
    assert (gravity.causality, gravity.variability, gravity.unit) == ("parameter", "tunable", "m/s^2")
    assert (float(gravity.min), float(gravity.max), float(gravity.start)) == (0.0, 30.0, 9.81)
    assert gravity.description == "gravity"
    assert (by_name["machine.push"].causality, float(by_name["machine.push"].start)) == ("input", 0.1)
    place = by_name["place"]
    assert (place.causality, place.unit, place.displayUnit, place.description) == ("output", "m", "mm", "of the cart")
    units = {u.name: u for u in described.unitDefinitions}
    assert (units["m/s^2"].baseUnit.m, units["m/s^2"].baseUnit.s) == (1, -2)
    assert float(units["m"].displayUnits[0].factor) == 1000.0
    assert by_name["machine.speed"].causality == "output"  # a state that is a result
    assert by_name["der(machine.lag)"].derivative is by_name["machine.lag"]
    assert described.defaultExperiment.stepSize in (0.05, "0.05")


def test_model_structure_has_the_true_dependencies(unit):
    unknowns = unit.described.outputs + unit.described.derivatives
    known = {u.variable.name: {v.name for v in u.dependencies} for u in unknowns}
    assert known["der(machine.height)"] == {"machine.speed"}
    assert known["der(machine.speed)"] == set()
    assert known["der(machine.place)"] == {"machine.place", "machine.push"}  # through the loop and the table
    assert known["der(machine.lag)"] == {"machine.place", "machine.lag"}
    assert known["loop"] == {"machine.place", "machine.push"}
    assert known["height"] == {"machine.height"}
    assert known["command"] == set()


def test_terminals_and_build_description_follow_their_schemas(spar_unit):
    """FMI 3.0: the results and inputs of each part are one bus."""
    from lxml import etree

    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    for schema, file in (
        ("fmi3TerminalsAndIcons.xsd", "terminalsAndIcons/terminalsAndIcons.xml"),
        ("fmi3BuildDescription.xsd", "sources/buildDescription.xml"),
    ):
        document = etree.parse(str(Path(spar_unit.folder, file)))
        etree.XMLSchema(etree.parse(str(schemas / schema))).assertValid(document)
    document = etree.parse(str(Path(spar_unit.folder, "terminalsAndIcons", "terminalsAndIcons.xml")))
    buses = {bus.get("name"): [member.get("variableName") for member in bus] for bus in document.iter("Terminal")}
    assert set(buses) == {"platform", "turbine", "sea", "wind"}
    assert "surge" in buses["platform"] and "turbine.yaw" in buses["turbine"]
    assert set().union(*buses.values()) <= spar_unit.reference.keys()


def test_symbols_are_hidden(unit):
    (library,) = Path(unit.folder, "binaries").rglob("*.so")
    loaded = ctypes.CDLL(str(library))
    assert hasattr(loaded, "fmi3DoStep" if unit.version == "3" else "fmi2DoStep")
    for name in ("fs_advance", "model", "outputs", "fmu_create", "level_0"):
        assert not hasattr(loaded, name)


# --- the same numbers -----------------------------------------------------------------------------------------------


def test_co_simulation_repeats_the_run(plant, unit):
    run = plant.simulate(3.0, tolerance=1e-9)
    rows = unit.simulate("cs", 3.0, 0.05, NAMES, start_values={"solver.tolerance": 1e-9})
    for name in NAMES:  # the loop is solved at output points to 30 times the tolerance
        assert distance(plant, run, rows, name) < (3e-8 if name == "loop" else 1e-9), name
    assert rows["bounces"][-1] == 6  # sqrt(2/g) (1 + 2 (0.8 + ... + 0.8^5)) = 2.88 s


def test_model_exchange_agrees_with_idas(plant, unit):
    run = plant.simulate(2.0, solver="idas", tolerance=1e-10)
    rows = unit.simulate("me", 2.0, 0.05, NAMES, relative_tolerance=1e-9)
    for name in NAMES:
        assert distance(plant, run, rows, name) < 1e-5, name
    assert rows["bounces"][-1] == 3


def test_parameters_and_start_values_act_as_in_python(plant, unit):
    given = {"machine.gravity": 3.0, "machine.gain": 1.0, "machine.height_start": 0.4}
    run = plant.simulate(1.0, parameters=given, start={"machine.place": -0.3}, tolerance=1e-9)
    values = {**given, "machine.place": -0.3, "solver.tolerance": 1e-9}
    rows = unit.simulate("cs", 1.0, 0.05, NAMES, start_values=values)
    for name in NAMES:  # the loop is solved at output points to 30 times the tolerance
        assert distance(plant, run, rows, name) < (1e-6 if name == "loop" else 1e-8), name


def test_export_takes_parameters_and_start_values(plant, as_unit):
    given, start = {"machine.gravity": 3.0}, {"machine.place": -0.3}
    unit = as_unit(plant, parameters=given, start=start)
    run = plant.simulate(0.5, parameters=given, start=start)
    rows = unit.simulate("cs", 0.5, 0.05, NAMES)
    for name in NAMES:
        assert distance(plant, run, rows, name) < 1e-7, name


def test_inputs_are_held_over_a_step_as_in_python(plant, instance):
    one = instance().begin(machine__push=0.7, solver__tolerance=1e-9)
    rows = one.run(["place", "loop"], 20, 0.05)
    run = plant.simulate(1.0, inputs={"machine.push": 0.7}, tolerance=1e-9)
    assert rows[:, 0] == pytest.approx(in_si(plant, run, "place")[1:], rel=1e-8)
    one.set(machine__push=-0.7)
    assert one.get("loop")[0] ** 3 + one.get("loop")[0] == pytest.approx(-0.7 - one.get("place")[0], abs=1e-4)


def test_any_communication_step(plant, instance):
    """A step that is no multiple of the engine's is divided evenly; the sampled controller stays on its beat."""
    run = plant.simulate(0.9, 0.033, step=0.01, tolerance=1e-9)
    rows = instance().begin(solver__tolerance=1e-9).run(["place", "height"], 27, 0.033)
    assert rows[:, 0] == pytest.approx(in_si(plant, run, "place")[1:28], rel=1e-8)
    fine = instance().begin(solver__tolerance=1e-9).run(["place"], 450, 0.002)
    assert fine[-1, 0] == pytest.approx(float(np.interp(0.9, run.time, in_si(plant, run, "place"))), rel=1e-4)


def test_rigid_spar_in_both_kinds(spar, spar_unit):
    unit, names = spar_unit, list(spar.outputs)
    assert validate_fmu(str(unit.path)) == []
    run = spar.simulate(20.0)
    rows = unit.simulate("cs", 20.0, 0.1, names)
    assert max(distance(spar, run, rows, name) for name in names) < 1e-9
    run = spar.simulate(10.0, solver="idas", tolerance=1e-9)
    rows = unit.simulate("me", 10.0, 0.1, names, relative_tolerance=1e-8)
    assert max(distance(spar, run, rows, name) for name in names) < 1e-4


def test_mooring_length_and_gain_need_no_new_export(spar, spar_unit):
    given = {"platform.mooring.length": 900.0, "turbine.control.proportional_gain": 0.004}
    run = spar.simulate(2.0, parameters=given)
    rows = spar_unit.simulate("cs", 2.0, 0.1, ["surge", "fairlead_tension_1", "blade_pitch"], start_values=given)
    for name in ("surge", "fairlead_tension_1", "blade_pitch"):
        assert distance(spar, run, rows, name) < 1e-7, name


# --- inputs ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def driven():
    """The rigid spar whose wind, waves, blade pitch and torque come from outside."""
    model = fw.load("oc3_spar_rigid").with_parameters(
        {"wind.kind": "input", "wind.mean_speed": 9.0, "sea.spectrum": "input"}
    )
    return model.compile(["turbine.blade_pitch", "turbine.generator_torque"])


def test_inputs_that_a_user_opens(driven):
    inputs = driven.dae.inputs
    units = {path: (item.unit, item.symbol.shape[0]) for path, item in inputs.items()}
    assert units["wind.speed_input"] == ("m/s", 1)
    assert units["sea.wave_elevation"] == ("m", 1)
    assert units["platform.water.waves.wave_load_force"] == ("N", 3)
    assert units["platform.water.waves.wave_load_moment"] == ("N*m", 3)
    assert units["platform.drag.water_velocity"][0] == "m/s"
    assert (units["turbine.blade_pitch"], units["turbine.generator_torque"]) == (("rad", 1), ("N*m", 1))
    closed = fw.load("oc3_spar_rigid").with_parameters({"wind.kind": "steady", "wind.mean_speed": 9.0})
    torque = closed.compile().initial_state()["turbine.generator_torque"]  # what the controller gives at the start
    assert inputs["turbine.generator_torque"].default == pytest.approx([torque])
    assert inputs["wind.speed_input"].default == pytest.approx([9.0])


@pytest.fixture(scope="module")
def driven_unit(driven, as_unit):
    return as_unit(driven)


def test_an_importer_drives_wind_waves_and_commands(driven, driven_unit, instance_of):
    assert validate_fmu(str(driven_unit.path)) == []
    one = instance_of(driven_unit).begin()
    given = {
        "turbine.blade_pitch": 0.05, "wind.speed_input": 12.0, "sea.wave_elevation": 1.5,
        "platform.water.waves.wave_load_force[0]": 1e6, "turbine.generator_torque": 3e4,
    }  # fmt: skip
    one.set(**given)
    names = ["surge", "rotor_speed", "blade_pitch", "wind_speed", "wave_elevation", "generator_torque"]
    rows = one.run(names, 30, 0.1)
    inputs = {name: value for name, value in given.items() if "[" not in name}
    inputs["platform.water.waves.wave_load_force"] = [1e6, 0, 0]
    start = zip([s.path for s in driven.dae.states], driven.initial_state().x, strict=True)
    run = driven.simulate(3.0, start=dict(start), inputs=inputs)  # begun before the inputs were given
    for k, name in enumerate(names):
        assert rows[:, k] == pytest.approx(in_si(driven, run, name)[1:], rel=1e-6), name
    assert rows[-1, 2:] == pytest.approx([0.05, 12.0, 1.5, 3e4])


def test_model_exchange_bears_any_tolerance(driven, driven_unit):
    """CVode takes differences of the derivatives, so that the algebraic loops are solved to rounding."""
    run = driven.simulate(10.0, solver="idas", tolerance=1e-9)
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
        rows = driven_unit.simulate("me", 10.0, 0.1, ["surge", "rotor_speed"], relative_tolerance=tolerance)
        for name in ("surge", "rotor_speed"):
            assert distance(driven, run, rows, name) < 20 * tolerance, (name, tolerance)


def test_a_signal_that_cannot_be_opened():
    model = fw.load("oc3_spar_rigid")
    for path, message in (
        ("turbine.blade_pich", "there is no signal 'turbine.blade_pich'; did you mean 'turbine.blade_pitch' or "
         "'turbine.rotor.blade_pitch'?"),
        ("turbine.control.pitch.blade_pitch", "turbine.control.pitch.blade_pitch drives this signal; to give it from "
         "outside, name 'turbine.control.blade_pitch' or 'turbine.safety.pitch.demand' instead."),
    ):  # fmt: skip
        with pytest.raises(ModelError) as refused:
            model.compile([path])
        assert str(refused.value) == message


def test_a_wind_field_travels_in_the_archive(as_unit, tmp_path):
    """The file of the field lies in the resources, and is not needed where it came from."""
    path = tmp_path / "gusty wind.bts"
    generate_field(
        path, mean_speed=9.0, width=160.0, height=160.0, columns=9, rows=9, duration=30.0, time_step=0.2, seed=2
    )
    model = fw.load("oc3_spar_rigid").with_parameters({"wind.kind": "field", "wind.file": str(path)})
    plant = model.compile()
    unit = as_unit(plant)
    run = plant.simulate(5.0)
    path.unlink()
    rows = unit.simulate("cs", 5.0, 0.1, ["surge", "rotor_speed", "wind_speed"])
    for name in ("surge", "rotor_speed", "wind_speed"):
        assert distance(plant, run, rows, name) < 1e-8, name
    assert np.std(rows["wind_speed"]) > 0.1


# --- states that are saved ------------------------------------------------------------------------------------------


def test_saved_state_repeats_a_trajectory_bit_for_bit(instance):
    one = instance().begin()
    one.run(NAMES, 8, 0.05)
    saved = one.save()
    first = one.run(NAMES, 30, 0.05, first=8)
    one.load(saved)
    assert np.array_equal(one.run(NAMES, 30, 0.05, first=8), first)
    data = one.bytes_of(saved)
    one.forget(saved)
    other = instance().begin(machine__gravity=2.0)
    other.run(NAMES, 3, 0.05)
    other.load(other.of_bytes(data))
    assert np.array_equal(other.run(NAMES, 30, 0.05, first=8), first)


def test_saved_state_of_model_exchange(instance):
    one = instance("me").begin()
    saved = one.save()
    before = one.array("Derivatives")
    one.put(0.3, [0.2, -1.0, 0.1, 0.0])
    assert not np.array_equal(one.array("Derivatives"), before)
    one.load(saved)
    assert np.array_equal(one.array("Derivatives"), before)


def test_saved_state_of_another_kind_is_refused(instance):
    one, two = instance().begin(), instance("me").begin()
    data = one.bytes_of(one.save())
    state = two.of_bytes(data)
    with pytest.raises(FMICallException):
        two.load(state)
    assert "machine: the saved state is of another model or another kind of instance." in [text for _, text in two.said]
    with pytest.raises(FMICallException):
        one.of_bytes(data[:-8])


def test_spoilt_bytes_of_a_saved_state_are_refused(instance):
    one = instance().begin()
    data = one.bytes_of(one.save())
    for place in (50, len(data) // 2, len(data) - 1):
        spoilt = bytearray(data)
        spoilt[place] ^= 1
        with pytest.raises(FMICallException):
            one.of_bytes(bytes(spoilt))
        assert one.said[-1][1] == "machine: the bytes of the saved state are spoilt."


def test_two_instances_side_by_side_equal_each_alone(instance):
    alone = [instance().begin(machine__gravity=g).run(NAMES, 20, 0.05) for g in (9.81, 5.0)]
    a, b = instance().begin(machine__gravity=9.81), instance().begin(machine__gravity=5.0)
    rows = []
    for k in range(20):
        a.step(k * 0.05, 0.05)
        b.step(k * 0.05, 0.05)
        rows.append([a.get(*NAMES), b.get(*NAMES)])
    assert np.array_equal(np.array(rows)[:, 0], alone[0])
    assert np.array_equal(np.array(rows)[:, 1], alone[1])


def test_instances_in_two_threads_equal_each_alone(instance):
    """Each thread has its own instance; the calls of fmpy leave Python's lock, so that they run at the same time."""
    from concurrent.futures import ThreadPoolExecutor

    given = (9.81, 5.0)
    alone = [instance().begin(machine__gravity=g).run(NAMES, 60, 0.05) for g in given]
    begun = [instance().begin(machine__gravity=g) for g in given]
    with ThreadPoolExecutor(2) as pool:
        rows = list(pool.map(lambda one: one.run(NAMES, 60, 0.05), begun))
    assert all(np.array_equal(a, b) for a, b in zip(rows, alone, strict=True))


def test_reset_is_a_new_instance(instance):
    one = instance().begin(machine__gravity=5.0)
    first = one.run(NAMES, 10, 0.05)
    one.fmu.reset()
    assert np.array_equal(one.begin(machine__gravity=5.0).run(NAMES, 10, 0.05), first)
    one.fmu.terminate()
    with pytest.raises(FMICallException):
        one.step(0.5, 0.05)


def test_creating_and_freeing_does_not_take_memory(unit):
    """A thousand instances, begun and freed."""
    import resource

    from fmpy.simulation import instantiate_fmu

    keep = instantiate_fmu(unit.folder, unit.described, "CoSimulation")

    def cycle():
        if unit.version == "3":
            folder = (unit.folder + "/resources/").encode()
            c = keep.fmi3InstantiateCoSimulation(
                b"x", keep.guid.encode(), folder, False, False, False, False, None, 0, None, keep.logMessage,
                keep.intermediateUpdate,
            )  # fmt: skip
            keep.fmi3EnterInitializationMode(c, False, 0.0, 0.0, False, 0.0)
            keep.fmi3ExitInitializationMode(c)
            keep.fmi3FreeInstance(c)
        else:
            location = Path(unit.folder, "resources").as_uri().encode()
            c = keep.fmi2Instantiate(b"x", 1, keep.guid.encode(), location, ctypes.byref(keep.callbacks), 0, 0)
            keep.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0)
            keep.fmi2EnterInitializationMode(c)
            keep.fmi2ExitInitializationMode(c)
            keep.fmi2FreeInstance(c)

    for _ in range(1000):  # the heap grows once, at times after some hundred
        cycle()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(1000):
        cycle()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 500  # kB; an instance takes more than 10
    keep.freeInstance()


# --- model exchange -------------------------------------------------------------------------------------------------


def test_directional_derivatives_are_exact(plant, instance):
    """Against the exact linear model of the plant, which eliminates the loop by CasADi's derivatives."""
    state = plant.initial_state()
    linear = plant.linearize(state, ["machine.push", "machine.gain"], ["loop", "machine.lag"])
    one = instance("me").begin()
    one.fmu.enterEventMode()
    rates = [f"der({name})" for name in STATES]
    order = [state.path for state in plant.dae.states]
    held = np.array([order.index(name) for name in STATES])
    a = np.array(linear.A)[np.ix_(held, held)]
    assert np.transpose([one.slope(rates, [name], [1.0]) for name in STATES]) == pytest.approx(a, rel=1e-12, abs=1e-12)
    b = np.array(linear.B)[held, 0]
    assert one.slope(rates, ["machine.push"], [1.0]) == pytest.approx(b, rel=1e-12, abs=1e-12)
    seed = np.array([0.3, -1.0, 2.0, 0.7])
    expected = np.array(linear.C)[0, held] @ seed + 0.5 * np.array(linear.D)[0, 0]
    assert one.slope(["loop"], [*STATES, "machine.push"], [*seed, 0.5])[0] == pytest.approx(expected, rel=1e-12)


def test_derivatives_and_indicators_at_a_point(plant, instance):
    one = instance("me").begin()
    one.put(0.4, [0.3, -2.0, 0.2, 0.1])
    loop = one.get("loop")[0]
    assert loop + loop**3 == pytest.approx(0.1 - 0.2, rel=1e-9)
    command, paths = one.get("command")[0], [state.path for state in plant.dae.states]
    rates = dict(zip(paths, one.array("Derivatives"), strict=True))
    table = 0.3 * math.sin(0.2)
    assert rates["machine.place"] == pytest.approx(command + 0.2 * loop - table, abs=1e-5)  # the spline of a sine
    assert one.array("EventIndicators") == pytest.approx([0.3], abs=1e-8)
    assert one.array("ContinuousStates")[0] == 0.3


def test_time_events_come_at_the_samples(instance):
    one = instance("me")
    one.begin()
    one.fmu.enterEventMode()
    *_, defined, when = one.update()
    assert defined and when == pytest.approx(0.07)
    one.fmu.setTime(0.07)
    *_, defined, when = one.update()
    assert defined and when == pytest.approx(0.14)


# --- messages and mistakes ------------------------------------------------------------------------------------------


def test_messages_are_those_of_python(plant, instance):
    one = instance().begin(machine__place=0.7)
    with pytest.warns(UserWarning) as told:
        plant.simulate(0.2, start={"machine.place": 0.7})
    one.run(["place"], 4, 0.05)
    assert [text for _, text in one.said] == [str(w.message) for w in told]
    assert one.said[0][1] == "machine: the cart is beyond 0.6 m, 50% more than it should be (t = 0 s)."
    one = instance().begin(machine__limit=1.0)
    with pytest.raises(fw.ModelError) as stopped:
        plant.simulate(1.0, parameters={"machine.limit": 1.0})
    with pytest.raises(FMICallException):
        one.run(["place"], 20, 0.05)
    assert one.said[-1][1] == str(stopped.value)
    with pytest.raises(FMICallException):
        one.step(0.9, 0.05)  # nothing goes on after an error
    one.fmu.reset()
    one.begin().run(["place"], 2, 0.05)


def test_a_table_left_at_its_edge_stops_as_in_python(plant, instance):
    one = instance()
    with pytest.raises(fw.ModelError) as stopped:
        plant.simulate(0.1, start={"machine.place": 4.25})
    with pytest.raises(FMICallException):
        one.begin(machine__place=4.25)
    assert one.said[-1][1] == str(stopped.value)
    assert "4.25" in one.said[-1][1]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("machine.gravity", 40.0, "machine.gravity = 40 is above its maximum 30 m/s^2 (gravity)."),
        ("machine.gravity", -1.0, "machine.gravity = -1 is below its minimum 0 m/s^2 (gravity)."),
        ("machine.gravity", math.nan, "machine.gravity = nan is not a finite number."),
        ("machine.push", math.inf, "machine.push = inf is not a finite number."),
        ("machine.place", math.nan, "machine.place = nan is not a finite number."),
        ("solver.step", 0.0, "solver.step = 0 is below its minimum 1e-09 s (longest step of the fixed-step engine in "
         "co-simulation)."),
    ],
)  # fmt: skip
def test_values_out_of_range_are_refused_and_change_nothing(instance, name, value, message):
    one = instance()
    before = one.get(name)
    with pytest.raises(FMICallException):
        one.set(**{name: value})
    assert one.said[-1][1] == message
    assert one.get(name) == before
    one.begin().run(["place"], 2, 0.05)


def test_calls_at_the_wrong_time(instance):
    one = instance()
    with pytest.raises(FMICallException):
        one.step(0.0, 0.05)
    step = "fmi3DoStep" if one.three else "fmi2DoStep"
    assert one.said[-1][1] == f"{step} cannot be called now."
    one.begin()
    with pytest.raises(FMICallException):
        one.set(machine__place=0.1)
    assert one.said[-1][1] == (
        "machine.place = 0.1 comes too late: a state is set before the end of the initialisation."
    )
    with pytest.raises(FMICallException):
        one.fmu.exitInitializationMode()


@pytest.mark.parametrize("step", [0.0, -0.1, math.nan, math.inf])
def test_steps_that_cannot_be(instance, step):
    one = instance().begin()
    with pytest.raises(FMICallException):
        one.step(0.0, step)
    assert one.said[-1][1].endswith("cannot be done; it must be above zero.")


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (1e300, "a communication step of 1e+300 s cannot be done: it takes more than 1e+09 steps of the engine, which "
         "are 0.01 s long (parameter solver.step)."),
        (1e-300, "a communication step of 1e-300 s at t = 0.05 s cannot be done: the time would stay where it is, by "
         "rounding."),
    ],
)  # fmt: skip
def test_steps_without_an_end(instance, step, message):
    one = instance().begin()
    one.step(0.0, 0.05)
    with pytest.raises(FMICallException):
        one.step(0.05, step)
    assert one.said[-1][1] == message


@pytest.mark.parametrize("kind", ["cs", "me"])
def test_times_that_cannot_be(instance, kind):
    one = instance(kind)
    for t in (math.nan, -math.inf, 1e17):
        with pytest.raises(FMICallException):
            one.begin(t)
        assert one.said[-1][1] == f"startTime = {t:g} s cannot be; a time lies between -1e+10 and 1e+10 s."


@pytest.mark.parametrize(
    ("period", "message"),
    [
        (0.0, "machine: the period of a sampled part is 0 s; it must be above zero."),
        (1e-12, "machine: a sampled part has the period 1e-12 s and the offset 0 s; the period must be at least 1e-09 "
         "s, and the offset lie between -1e+10 and 1e+10 s."),
    ],
)  # fmt: skip
def test_periods_without_an_end(instance, period, message):
    one = instance()
    with pytest.raises(FMICallException):
        one.begin(machine__period=period)
    assert one.said[-1][1] == message


def test_a_step_begins_where_the_last_one_ended(instance):
    one = instance().begin()
    one.step(0.0, 0.05)
    with pytest.raises(FMICallException):
        one.step(0.2, 0.05)
    assert one.said[-1][1] == "a communication step begins at t = 0.2 s, and the instance is at 0.05 s."


def test_unknown_references(instance):
    one = instance().begin()
    for reference in (10_000, 2**32 - 1):
        with pytest.raises(FMICallException):
            (one.fmu.getFloat64 if one.three else one.fmu.getReal)([reference])
        with pytest.raises(FMICallException):
            (one.fmu.setFloat64 if one.three else one.fmu.setReal)([reference], [1.0])
    assert one.said[-1][1] == "there is no variable with the value reference 4294967295 that can be set."
    with pytest.raises(FMICallException):
        one.set(time=1.0)
    with pytest.raises(FMICallException):
        one.fmu.getBoolean([1])


def test_wild_states_end_in_an_error_and_not_in_a_crash(instance):
    rng = np.random.default_rng(3)
    for _ in range(30):
        one = instance("me").begin()
        x = rng.normal(size=4) * 10.0 ** rng.uniform(0, 300, size=4)
        try:
            one.put(float(rng.uniform(0, 10)), x)
            values = one.array("Derivatives")
        except FMICallException:
            assert one.said
            continue
        assert values.shape == (4,)
    with pytest.raises(FMICallException):
        instance("me").begin().put(0.0, [math.nan, 0, 0, 0])


def test_missing_tables_are_named(spar_unit, tmp_path):
    import shutil

    unit, broken = spar_unit, tmp_path / "x"
    shutil.copytree(unit.folder, broken)
    (broken / "resources" / "tables.bin").unlink()
    from fmpy.simulation import instantiate_fmu

    heard = []
    with pytest.raises(Exception, match="Failed to instantiate"):
        instantiate_fmu(str(broken), unit.described, "CoSimulation", logger=lambda *w: heard.append(w[-1].decode()))
    assert heard[0].startswith("oc3_spar_rigid: cannot read ") and "tables.bin" in heard[0]


def test_intermediate_points_and_early_return(unit):
    """FMI 3.0: the importer sees each step of the engine, and stops at the third."""
    from fmpy.simulation import instantiate_fmu

    if unit.version == "2":
        return
    seen = []

    def update(environment, t, may_set, may_get, finished, may_return, asked, when):
        seen.append((t, fmu.getFloat64([unit.reference["place"]])[0]))
        if len(seen) == 3:
            asked[0] = True
            when[0] = t

    fmu = instantiate_fmu(
        unit.folder, unit.described, "CoSimulation", early_return_allowed=True, intermediate_update=update
    )
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    _, _, early, last = fmu.doStep(0.0, 0.05)
    assert early and last == pytest.approx(0.03)
    assert [t for t, _ in seen] == pytest.approx([0.01, 0.02, 0.03])
    assert fmu.getFloat64([unit.reference["place"]])[0] == seen[-1][1]
    _, _, early, last = fmu.doStep(last, 0.02)
    assert not early and last == pytest.approx(0.05)
    fmu.freeInstance()


def test_calls_within_a_communication_step(as_unit, plant):
    """FMI 3.0: an intermediate update reads variables, and does not pull the instance away from under the step."""
    from fmpy.simulation import instantiate_fmu

    unit, told, refused = as_unit(plant), [], set()

    def update(environment, t, may_set, may_get, finished, may_return, asked, when):
        for name, action in {
            "fmi3Reset": fmu.reset, "fmi3Terminate": fmu.terminate, "fmi3GetFMUState": fmu.getFMUState,
            "fmi3SetFloat64": lambda: fmu.setFloat64([unit.reference["machine.push"]], [1.0]),
        }.items():  # fmt: skip
            try:
                action()
            except FMICallException:
                refused.add(name)
        fmu.fmi3FreeInstance(fmu.component)

    fmu = instantiate_fmu(
        unit.folder, unit.described, "CoSimulation", early_return_allowed=True, intermediate_update=update,
        logger=lambda *w: told.append(w[-1].decode()),
    )  # fmt: skip
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.doStep(0.0, 0.05)
    assert refused == {"fmi3Reset", "fmi3Terminate", "fmi3GetFMUState", "fmi3SetFloat64"}
    assert set(told) == {f"{name} cannot be called now." for name in [*refused, "fmi3FreeInstance"]}
    options = {"early_return_allowed": True, "intermediate_update": lambda *_: None}
    alone = instantiate_fmu(unit.folder, unit.described, "CoSimulation", **options)
    alone.enterInitializationMode()
    alone.exitInitializationMode()
    alone.doStep(0.0, 0.05)
    place = [unit.reference["place"]]
    assert fmu.getFloat64(place) == alone.getFloat64(place)
    fmu.freeInstance()
    alone.freeInstance()


# --- what cannot be exported ----------------------------------------------------------------------------------------


def test_python_code_is_refused_by_path(tmp_path):
    class Own(fw.Component):
        """Grows by a function in Python."""

        rate: Scalar = param(default=1.0, doc="rate")
        x: Scalar = var(start=1.0, state="prefer", doc="x")

        def equations(self):
            square = ExternalFunction("square", {"x": 1}, {"y": 1}, python=lambda v: v**2, jacobian=lambda v: [2 * v])
            return [eq(der(self.x), -self.rate * square(x=self.x)["y"])]

    root = fw.Assembly("a")
    root.own = Own()
    with pytest.raises(ModelError) as refused:
        fw.export_fmu(fw.load(root).compile(), tmp_path / "x.fmu")
    assert str(refused.value) == (
        "own: the external function square is Python code, which cannot go into an FMU. Give it a C source or a shared "
        "library with its source beside it."
    )


def test_a_process_at_samples_is_refused_by_path(tmp_path):
    class Outside(fw.Component):
        """Calls something with a memory of its own, which is never started here."""

        x: Scalar = var(start=1.0, state="prefer", doc="x")
        held: Scalar = var(discrete=True, doc="what it gives")

        def equations(self):
            return [eq(der(self.x), self.held - self.x), sampled(0.1, call(self.held, object(), self.x))]

    root = fw.Assembly("a")
    root.outside = Outside()
    with pytest.raises(ModelError) as refused:
        fw.export_fmu(fw.load(root).compile(), tmp_path / "x.fmu")
    assert str(refused.value) == (
        "outside: what is called at its samples runs outside of the equations, and cannot go into an FMU. Leave the "
        "part out, and give its outputs as inputs of the FMU (--input)."
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fmi": "1"}, "there is no FMI version '1'; there are '2' and '3'."),
        ({"kind": "sc"}, "there is no kind of FMU 'sc'; did you mean 'cs'?"),
        ({"fmi": 2, "platforms": ["linux64", "linux-arm64"]},
         "FMI 2.0 has one place for 'linux64' and 'linux-arm64'; choose one of them, or FMI 3.0."),
        ({"platforms": ["linux32"]}, "there is no platform 'linux32'; did you mean 'linux64'?"),
        ({"step": 0}, "the step of the engine is 0 s; it must be above zero, usually 0.01 s."),
        ({"tolerance": 2}, "the tolerance is 2; it must lie between 0 and 0.1, usually 1e-6."),
    ],
)
def test_wrong_options_are_named(plant, tmp_path, options, message):
    with pytest.raises(ModelError) as refused:
        fw.export_fmu(plant, tmp_path / "x.fmu", **options)
    assert str(refused.value) == message
    assert not list(tmp_path.iterdir())


def test_wrong_targets_are_named(plant, tmp_path):
    for path, message in (
        (tmp_path / "x.zip", f"{tmp_path}/x.zip: the file must end in '.fmu'."),
        (tmp_path / "no" / "x.fmu", f"{tmp_path}/no/x.fmu: the folder {tmp_path}/no does not exist; make it first, or "
         "choose another one."),
    ):  # fmt: skip
        with pytest.raises(ModelError) as refused:
            fw.export_fmu(plant, path)
        assert str(refused.value) == message


def test_no_compiler_names_the_extra_that_helps(plant, tmp_path, monkeypatch):
    plant.at()
    monkeypatch.setenv("FOWTLIB_CC", "no-such-compiler")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ModelError, match=r"an FMU holds a compiled library, and .*no C compiler.*fowtlib\[compiler\]"):
        fw.export_fmu(plant, tmp_path / "x.fmu")
    monkeypatch.delenv("FOWTLIB_CC")
    with pytest.raises(ModelError, match=r"a library for win64 .* pip install 'fowtlib\[compiler\]'"):
        fw.export_fmu(plant, tmp_path / "x.fmu", platforms=["win64"])
    assert not list(tmp_path.iterdir())
