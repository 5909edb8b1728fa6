"""Turbines at sea whose run is interrupted and goes on: bit for bit the run that was not, with all that drives them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.environment import FieldGrid, write_field
from fowtlib.language import ModelError

SOLVERS = ({"solver": "idas"}, {"solver": "fixed", "step": 0.025})
GRID = FieldGrid(rows=7, columns=7, steps=160, dz=30.0, dy=30.0, dt=0.25, speed=11.0, hub_height=90.0, bottom=5.0)
SPAR = """
fowtlib: 1
title: spar
world: {class: World, water_depth: 320 m, water_density: 1025 kg/m^3}
sea: {class: Sea, spectrum: jonswap, significant_wave_height: 6 m, peak_period: 10 s, seed: 1}
wind: {class: Wind, kind: field, file: wind.bts}
parts:
  platform: {use: platforms/oc3_hywind}
  tower: {class: RigidBody, mass: 249718 kg, r_cm: [0, 0, 43.348],
          inertia: [[120252000, 0, 0], [0, 120252000, 0], [0, 0, 1818460]]}
  tower_to_hub: {class: FixedTranslation, r: [-5, 0, 90]}
  turbine: {use: turbines/nrel5mw_rigid, rotor_speed_start: 1.2, blade_pitch_start: 0.1,
            parts: {control: {sample_period: 0.1 s}}}
connect:
  - [world.frame, platform.world]
  - [platform.frame, tower.frame_a]
  - [platform.frame, tower_to_hub.frame_a]
  - [tower_to_hub.frame_b, turbine.frame]
outputs: {surge: platform.motion.surge, rotor_speed: turbine.rotor_speed, blade_pitch: turbine.blade_pitch}
"""


def write_wind(folder, calm: float = 1.0) -> None:
    time, z, y = np.meshgrid(np.arange(GRID.steps) * GRID.dt, GRID.z, GRID.y, indexing="ij")
    phase = 2 * np.pi * time / 8 + 0.02 * y + 0.01 * z
    speeds = np.stack([11 + calm * np.sin(phase), 0.5 * np.cos(phase), 0.3 * np.sin(2 * phase)], axis=-1)
    write_field(folder / "wind.bts", GRID, speeds)


@pytest.fixture(scope="module")
def spar(tmp_path_factory):
    """A rigid turbine in a field of wind and in waves, with a controller that is sampled; and its folder."""
    folder = tmp_path_factory.mktemp("spar")
    write_wind(folder)
    (folder / "spar.yaml").write_text(SPAR)
    return fw.load(folder / "spar.yaml").compile(), folder


def goes_on_exactly(plant, folder, end: float, middles, step: float, options) -> fw.Result:
    """Compare a run with the same in pieces, each of which goes on from the file of the one before; the whole run."""
    whole = plant.simulate(end, output_step=step, **options)
    result = None
    for middle in (*middles, end):
        later = plant.simulate(middle, output_step=step, start=result, **options)
        result = later if result is None else result.followed_by(later)
        result = fw.Result.open(result.save(folder / "part.nc"))
    assert result.time.tobytes() == whole.time.tobytes()
    for key in "xzd":
        assert getattr(result.raw, key).tobytes() == getattr(whole.raw, key).tobytes(), key
    for name in whole:
        assert result.array(name).tobytes() == whole.array(name).tobytes(), name
    return whole


@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
def test_a_field_of_wind_waves_and_a_sampled_controller(spar, tmp_path, options):
    plant, _ = spar
    assert plant.dae.samples and plant.dae.externals
    whole = goes_on_exactly(plant, tmp_path, 6.0, (2.03, 4.5), 0.05, options)
    assert np.ptp(whole.array("blade_pitch")) > 0 and np.ptp(whole.array("surge")) > 0


@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
def test_a_drawn_wind_and_waves(tmp_path, options):
    plant = fw.load("oc3_spar_rigid").compile()
    goes_on_exactly(plant, tmp_path, 12.0, (4.0, 7.77), 0.025, options)


def test_a_flexible_turbine(tmp_path):
    plant = fw.load("oc3_spar").compile()
    goes_on_exactly(plant, tmp_path, 2.0, (0.9, 1.31), 0.005, {"solver": "fixed", "step": 0.005})


def test_a_file_of_data_that_has_changed_is_named(spar, tmp_path):
    plant, folder = spar
    before = plant.simulate(1.0, output_step=0.1)
    before.save(tmp_path / "first.nc")
    first = fw.Result.open(tmp_path / "first.nc")
    try:
        write_wind(folder, calm=0.5)
        said = "other parameters: wind.file was wind.bts with the content [0-9a-f]{12}, is wind.bts with the content"
        for start in (before, first):
            with pytest.raises(ModelError, match=said):
                plant.simulate(2.0, output_step=0.1, start=start)
            with pytest.raises(ModelError, match=said):
                fw.load(folder / "spar.yaml").compile().simulate(2.0, output_step=0.1, start=start)
    finally:
        write_wind(folder)
    assert plant.simulate(2.0, output_step=0.1, start=first).time[-1] == pytest.approx(2.0)


def test_a_file_that_the_equations_were_made_from_is_named_too(tmp_path):
    """A table of the rotor: read when the model is made."""
    table = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "rotor_coefficients.csv"
    (tmp_path / "mine.csv").write_text(table.read_text())
    change = {"turbine.rotor.coefficients": str(tmp_path / "mine.csv")}
    first = fw.load("oc3_spar_rigid", set=change).compile().simulate(0.5, output_step=0.1)
    (tmp_path / "mine.csv").write_text(table.read_text() + "\n")
    with pytest.raises(ModelError, match="turbine.rotor.coefficients was mine.csv with the content"):
        fw.load("oc3_spar_rigid", set=change).compile().simulate(1.0, output_step=0.1, start=first)
