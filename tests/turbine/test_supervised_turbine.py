"""A turbine that supervises itself, from a model file: from idling to production, and through a fault back again."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.errors import ModelError

TEXT = """
fowtlib: 1
title: a rigid turbine on the ground that supervises itself
world: {class: World}
wind: {class: Wind, kind: steady, mean_speed: 13 m/s}
parts:
  ground: {class: Fixed, r: [0, 0, 90]}
  turbine:
    use: turbines/nrel5mw_rigid
    parts:
      safety: {class: Supervisor, brake_torque: 28116.2 N*m, idling: 1, averaging_time: 10 s}
connect:
  - [ground.frame, turbine.frame]
outputs:
  state: turbine.safety.state
  entered: turbine.safety.entered
  generator_speed: {of: turbine.generator_speed, unit: rpm}
  blade_pitch: {of: turbine.blade_pitch, unit: deg}
  generator_power: {of: turbine.generator_power, unit: kW}
"""


@pytest.fixture(scope="module")
def turbine(tmp_path_factory):
    path = tmp_path_factory.mktemp("supervised") / "turbine.yaml"
    path.write_text(TEXT)
    return fw.load(path).compile()


def states(result):
    values = np.asarray(result["state"])
    new = np.flatnonzero(np.diff(values, prepend=-1))
    return [int(values[k]) for k in new], [float(np.asarray(result["entered"])[k]) for k in new]


def test_a_tripped_generator_ends_in_overspeed_and_the_turbine_comes_back(turbine):
    runs = [
        turbine.simulate(440, 0.25, solver=solver, events=["generator.trip at 200 s"], **options)
        for solver, options in (("fixed", {"step": 0.025}), ("idas", {"tolerance": 1e-7}))
    ]
    for result in runs:
        assert states(result)[0] == [0, 1, 2, 5, 7, 1, 2]
        speed, power = np.asarray(result["generator_speed"]), np.asarray(result["generator_power"])
        assert 1408 < speed.max() < 1525 and np.all(power[801:1000] == 0)  # tripped, and then at standstill
        assert power[700:800] == pytest.approx(5000, rel=0.05) == power[-40:]
    np.testing.assert_allclose(states(runs[0])[1], states(runs[1])[1], atol=0.02)


def test_a_storm_stops_it(turbine):
    """13 m/s, and 28 m/s from 120 s on."""
    result = turbine.simulate(
        200, 0.5, solver="fixed", step=0.025,
        parameters={"wind.kind": "step", "wind.start_time": 120, "wind.step_speed": 28, "wind.step_duration": 20},
    )  # fmt: skip
    assert states(result)[0] == [0, 1, 2, 3]
    entered = states(result)[1][-1]
    assert 120 < entered < 160 and np.asarray(result["blade_pitch"])[-1] == pytest.approx(90)
    assert abs(np.asarray(result["generator_speed"])[-1]) < 200
    assert np.asarray(result["generator_power"])[-1] == pytest.approx(0, abs=1)


def test_without_wind_enough_it_goes_on_idling(turbine):
    result = turbine.simulate(60, 0.5, solver="fixed", step=0.025, parameters={"wind.mean_speed": 3.0})
    assert states(result)[0] == [0] and not np.asarray(result["generator_power"]).any()


def test_a_station_that_does_not_exist_is_refused(tmp_path):
    path = tmp_path / "turbine.yaml"
    path.write_text(TEXT.replace("idling: 1,", "idling: 1, station: 3,"))
    with pytest.raises(ModelError, match="station 3 of wind does not exist"):
        fw.load(path).compile()
