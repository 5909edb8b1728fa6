"""The shipped definitions: every quantity has a unit and a source, and the numbers agree with each other."""

import csv
from pathlib import Path

import numpy as np
import pytest
import yaml

from fowtlib.language.units import dimension

DATA = Path(__file__).parents[2] / "models" / "data"
FILES = [DATA / "nrel5mw" / "turbine.yaml", DATA / "oc3_hywind" / "platform.yaml"]


def table(path):
    with path.open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def values(name):
    groups = yaml.safe_load((DATA / name).read_text())
    return {key: quantity["value"] for group in groups.values() for key, quantity in group.items()}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.parent.name)
def test_every_quantity_has_a_unit_and_a_source(path):
    for group in yaml.safe_load(path.read_text()).values():
        for name, quantity in group.items():
            assert set(quantity) == {"value", "unit", "source"}, name
            assert np.isfinite(quantity["value"]).all(), name
            assert quantity["source"], name
            dimension(quantity["unit"])


def test_every_data_file_has_an_entry_in_the_sources():
    text = (DATA.parent / "SOURCES.md").read_text()
    for path in DATA.rglob("*.*"):
        assert path.relative_to(DATA.parent).as_posix() in text


def test_the_tower_weighs_what_its_sections_weigh():
    tower, platform = table(DATA / "oc3_hywind" / "tower.csv"), values("oc3_hywind/platform.yaml")
    z = np.linspace(10, 87.6, 5001)
    m = np.interp(z, tower["z_m"], tower["mass_per_length_kg_per_m"])
    assert np.trapezoid(m, z) == pytest.approx(249_718, rel=1e-5)
    assert np.trapezoid(m * z, z) / np.trapezoid(m, z) == pytest.approx(43.348, abs=1e-3)
    assert platform["displaced_volume"] == 8029.21


def test_the_rotor_inertia_follows_from_the_blades():
    t = values("nrel5mw/turbine.yaml")
    r, cone = t["hub_radius"], np.radians(t["precone"])
    blade = t["blade_inertia"] + 2 * r * t["blade_first_moment"] + r**2 * t["blade_mass"]
    axial = 3 * blade * np.cos(cone) ** 2 + t["hub_inertia"]
    assert t["rotor_axial_inertia"] == pytest.approx(axial, rel=1e-6)
    assert t["drivetrain_inertia"] == pytest.approx(axial + t["gear_ratio"] ** 2 * t["generator_inertia"], rel=1e-6)
    power = t["rated_generator_torque"] * t["rated_generator_speed"] * np.pi / 30
    assert power == pytest.approx(t["rated_mechanical_power"], rel=1e-4)
    assert power * t["generator_efficiency"] == pytest.approx(5e6, rel=1e-3)
    assert 3 * t["blade_mass"] + t["hub_mass"] == t["rotor_mass"]


def test_the_rotor_coefficients_are_a_full_table():
    t = table(DATA / "nrel5mw" / "rotor_coefficients.csv")
    ratio, pitch = np.unique(t["tip_speed_ratio"]), np.unique(t["blade_pitch_deg"])
    assert (ratio[0], ratio[-1], pitch[0], pitch[-1]) == (2, 14.5, -5, 30)
    assert t["power_coefficient"].size == ratio.size * pitch.size
    power = t["tip_speed_ratio"] * t["torque_coefficient"] * np.cos(np.radians(2.5))
    np.testing.assert_allclose(t["power_coefficient"], power, atol=1e-5)
    assert t["power_coefficient"].max() == pytest.approx(0.4659, abs=1e-4)
