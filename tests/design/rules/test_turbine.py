"""Turbines by similarity and by power laws; the surrogate of 7 MW is what the rule says, and runs."""

import csv
import importlib.util
import math
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import read_coefficients, read_load_slopes
from fowtlib.design.rules import turbine as rule
from fowtlib.language.errors import ModelError

MODELS = Path(fowtlib.models.__file__).parent
LAND = """fowtlib: 1
title: the surrogate on a stiff tower
world: {class: World}
wind: {class: Wind, kind: steady, mean_speed: 12 m/s, stations: [[0, 110]], reference_height: 110 m}
parts:
  foot: {class: FixedTranslation, r: [-7, 0, 110]}
  turbine: {use: turbines/surrogate_7mw}
connect:
  - [world.frame, foot.frame_a]
  - [foot.frame_b, turbine.frame]
outputs:
  rotor_speed: {of: turbine.rotor_speed, unit: rpm}
  generator_power: {of: turbine.generator_power, unit: kW}
  thrust: {of: turbine.thrust, unit: kN}
simulation: {solver: fixed, start: turning, duration: 200 s, output_step: 1 s, step: 25 ms}
"""


def surrogate():
    return rule.between(rule.NREL_5MW, rule.DTU_10MW, 85.6, 7e6, "surrogate 7-MW")


def test_similarity_keeps_tip_speed_and_what_follows():
    """Power per area, stress by weight over length, gravity aside: P/R^2, m/R^3, I/R^5, torque/R^3; and back again."""
    known = rule.DTU_10MW
    larger = rule.similar(known, 2 * known.radius)
    assert larger.radius * larger.rated_speed == pytest.approx(known.radius * known.rated_speed)
    assert larger.rated_power == pytest.approx(4 * known.rated_power)
    assert larger.rated_torque == pytest.approx(8 * known.rated_torque)
    assert larger.mass == pytest.approx(8 * known.mass)
    assert np.array(larger.inertia) == pytest.approx(32 * np.array(known.inertia))
    back = asdict(rule.similar(larger, known.radius, known.name))
    assert {k: v for k, v in back.items() if k != "name"} == {
        key: pytest.approx(value) for key, value in asdict(known).items() if key != "name"
    }


def test_the_law_passes_through_what_it_was_made_of():
    first, second = rule.NREL_5MW, rule.DTU_10MW
    again = rule.between(first, second, second.radius, second.rated_power, second.name)
    assert asdict(again) == {k: pytest.approx(v) if k != "name" else v for k, v in asdict(second).items()}
    small = rule.between(first, second, first.radius, first.rated_power)
    for name in rule.ROTOR:
        assert getattr(small, name) == pytest.approx(getattr(first, name)), name
    powers = rule.powers_between(first, second)
    assert powers["rotor_mass"] == pytest.approx(2.13, abs=0.01)  # similarity has 3
    assert powers["rotor_inertia"] == pytest.approx(4.02, abs=0.01)  # and 5


def test_the_known_turbines_have_the_inertia_of_their_definitions():
    assert rule.NREL_5MW.inertia == pytest.approx((183105.0, 23495810.0, 25054195.0, 2065324.0))
    assert rule.DTU_10MW.centre == pytest.approx((6.13190, -0.57966))
    assert all(0.98 < factor < 1.11 for t in (rule.NREL_5MW, rule.DTU_10MW) for factor in (*t.spread, t.lean))


def test_gains_by_similarity():
    """A turbine twice as long: half the frequency, the same damping: K_p twice, K_i the same."""
    known = rule.DTU_10MW
    assert rule.pitch_gains(rule.similar(known, 2 * known.radius), known, 0.2, 0.02) == pytest.approx((0.4, 0.02))


def test_the_definitions_are_what_the_rule_says():
    spec = importlib.util.spec_from_file_location("surrogate", MODELS / "convert" / "surrogate_turbines.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert len(script.ABOUT) == 2
    for (radius, power), about in script.ABOUT.items():
        path = MODELS / "turbines" / f"surrogate_{power / 1e6:g}mw.yaml"
        assert path.read_text() == script.text(script.surrogate(radius, power), about)


def test_the_surrogate_between_both(tmp_path):
    """Rated power from 10.5 m/s on, greatest thrust 1.17 MN at 10 m/s, C_P of the DTU 10-MW rotor below, and steady."""
    path = tmp_path / "land.yaml"
    path.write_text(LAND)
    plant = fw.load(str(path)).compile()
    found = {}
    for speed in (8.0, 10.0, 12.0, 20.0):
        result = plant.simulate(parameters={"wind.mean_speed": speed})
        assert np.ptp(result.array("rotor_speed")[-30:]) < 1e-3
        found[speed] = {name: float(result[name][-1]) for name in plant.outputs}
    turbine = surrogate()
    for speed in (12.0, 20.0):
        assert found[speed]["generator_power"] == pytest.approx(7000.0, rel=1e-4)
        assert found[speed]["rotor_speed"] == pytest.approx(turbine.rated_speed * 30 / math.pi, rel=1e-4)
    assert found[10.0]["thrust"] == pytest.approx(1167.0, rel=0.01)
    assert found[10.0]["thrust"] > found[12.0]["thrust"] > found[20.0]["thrust"]
    area = math.pi * (85.6 * math.cos(math.radians(2.5))) ** 2
    C_p = found[8.0]["generator_power"] * 1e3 / (0.5 * 1.225 * area * 8.0**3)
    assert 0.45 < C_p < 0.5
    assert 1.0 < turbine.mass / rule.NREL_5MW.mass < rule.DTU_10MW.mass / rule.NREL_5MW.mass


def test_fifteen_megawatts_by_the_same_rule_are_heavier_than_those_of_iea():
    """Beyond both: the rotor of the IEA 15-MW turbine has 0.61 of this mass and 0.63 of this inertia."""
    with (MODELS / "data" / "iea15" / "blade_structure.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    r = np.array([float(row["z_m"]) for row in rows])
    mass = np.array([float(row["mass_per_length_kg_per_m"]) for row in rows])
    hub, hub_mass, hub_inertia = 3.97, 69131.0, 969952.0  # turbines/iea15
    rotor_mass = 3 * np.trapezoid(mass, r) + hub_mass
    rotor_inertia = 3 * np.trapezoid(mass * (r + hub) ** 2, r) + hub_inertia
    found = rule.between(rule.NREL_5MW, rule.DTU_10MW, 120.97, 15e6)
    assert rotor_mass / found.rotor_mass == pytest.approx(0.61, abs=0.01)
    assert rotor_inertia / found.rotor_inertia == pytest.approx(0.635, abs=0.01)
    assert found.rated_speed * 30 / math.pi == pytest.approx(7.56, rel=0.15)
    similar = rule.similar(rule.DTU_10MW, 120.97)
    assert similar.rotor_mass > found.rotor_mass and similar.rated_power == pytest.approx(18.4e6, rel=0.01)


def test_fifteen_megawatts_by_scaling_run(tmp_path):
    """Rated power and speed above rated wind, steady; at 8 m/s the power coefficient of the DTU 10-MW rotor."""
    path = tmp_path / "land.yaml"
    path.write_text(LAND.replace("surrogate_7mw", "surrogate_15mw").replace("110", "150"))
    plant = fw.load(str(path)).compile()
    sizes = rule.between(rule.NREL_5MW, rule.DTU_10MW, 120.97, 15e6)
    rated = plant.simulate(parameters={"wind.mean_speed": 18.0})
    assert np.ptp(rated.array("rotor_speed")[-30:]) < 1e-3
    assert float(rated["generator_power"][-1]) == pytest.approx(15e3, rel=1e-4)
    assert float(rated["rotor_speed"][-1]) == pytest.approx(sizes.rated_speed * 30 / math.pi, rel=1e-4)
    below = plant.simulate(parameters={"wind.mean_speed": 8.0})
    area = math.pi * (120.97 * math.cos(math.radians(2.5))) ** 2
    assert 0.45 < float(below["generator_power"][-1]) * 1e3 / (0.5 * 1.225 * area * 8.0**3) < 0.5


def test_mistakes():
    with pytest.raises(ModelError, match="radius is -1"):
        rule.similar(rule.DTU_10MW, -1.0)
    with pytest.raises(ModelError, match="rated_power"):
        rule.between(rule.NREL_5MW, rule.DTU_10MW, 80.0, 0.0)


def test_two_blades_of_the_same_solidity_lose_at_their_tips():
    """The largest power coefficient at pitch 0 falls by 3 to 5 %, at the same tip speed ratio, and so the torque."""
    three = read_coefficients(str(MODELS / "data" / "dtu10mw" / "rotor_coefficients.csv"))
    two = read_coefficients(str(MODELS / "data" / "surrogate_7mw" / "two_bladed_coefficients.csv"))
    ratios = np.linspace(5.0, 11.0, 601)
    powers = [ratios * np.asarray(table(ratios, np.zeros(601))[1]) for table in (three, two)]
    assert 0.95 < powers[1].max() / powers[0].max() < 0.97
    assert ratios[powers[1].argmax()] == pytest.approx(ratios[powers[0].argmax()], abs=0.25)
    texts = [(MODELS / "turbines" / f"surrogate_7mw{end}.yaml").read_text() for end in ("", "_two_bladed")]
    constants = [float(text.partition("region_2_constant: ")[2].split()[0]) for text in texts]
    assert constants[1] / constants[0] == pytest.approx(powers[1].max() / powers[0].max(), abs=0.01)


def test_slopes_of_the_surrogate_are_those_of_its_coefficients():
    """Thrust and torque by the wind at held speed and pitch: 3 blades of elements beside the table of the rotor."""
    slopes = read_load_slopes(str(MODELS / "data" / "surrogate_7mw" / "load_slopes.csv"))
    table = read_coefficients(str(MODELS / "data" / "dtu10mw" / "rotor_coefficients.csv"))
    radius = 85.6

    def loads(wind, speed, pitch):
        thrust, torque = (float(np.ravel(c)[0]) for c in table(np.array([speed * radius / wind]), np.array([pitch])))
        return np.array([thrust, torque * radius]) * 0.5 * math.pi * radius**2 * wind**2

    for wind in (7.0, 9.0, 14.0, 20.0):
        at = slopes.at(wind)
        speed, pitch = float(at.rotor_speed[0]), float(at.blade_pitch[0])
        expected = (loads(wind + 0.05, speed, pitch) - loads(wind - 0.05, speed, pitch)) / 0.1
        found = 3 * np.array([at.thrust[0].sum(), at.torque[0].sum()])
        np.testing.assert_allclose(found, expected, rtol=0.06)
