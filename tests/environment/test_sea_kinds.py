"""Kinds of sea: a measured record comes back, and one compiled plant sails through all of them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import (
    InputSea,
    JonswapSea,
    MeasuredSea,
    RegularWaves,
    Sea,
    StillSea,
    World,
    irregular_waves,
)
from fowtlib.components.environment.sea import WaveRecord, read_record, record_waves
from fowtlib.language import ModelError

TRUE = irregular_waves(4.0, 9.0, 320.0, seed=11, repetition_period=2048.0)
BAND = {"lowest_frequency": 0.2, "highest_frequency": 5.0}


def write(path, time, elevation, head="time [s],elevation [m]\n"):
    lines = [f"{t:.4f},{z:.6f}" for t, z in zip(time, elevation, strict=True)]
    path.write_text(head + "\n".join(lines) + "\n")
    return str(path)


def record_file(folder, duration=600.0, step=0.25, first=0.0, offset=0.0, at=(0.0, 0.0), waves=TRUE):
    """A record of a true sea at a point, the times beginning at `first`."""
    time = np.arange(0.0, duration + step / 2, step)
    return write(folder / "buoy.csv", time + first, offset + waves.evaluate(waves.elevation_transfer([at]), time)[:, 0])


def at_sea(**sea):
    top = fw.Assembly("sea")
    top.world = World()
    top.sea = Sea(**sea)
    return top


def elevation(top, duration, step=0.25):
    result = fw.load(top).compile().simulate(duration, output_step=step)
    return np.asarray(result["sea.elevation"].time), np.asarray(result["sea.elevation"])


# --- a record --------------------------------------------------------------------------------------------------------


def test_a_record_comes_back_between_its_tapers(tmp_path):
    """Within 1 % of the standard deviation; what is lost are the ends, the mean, and what lies beyond the band."""
    file = record_file(tmp_path, offset=0.7)
    time, found = elevation(at_sea(spectrum="record", file=file, **BAND), 590.0)
    wanted = TRUE.evaluate(np.ones((len(TRUE), 1)), time)[:, 0]
    inside = (time > 15) & (time < 585)
    assert np.std(found[inside] - wanted[inside]) < 0.01 * wanted.std()
    assert abs(found[0]) < 0.02 * wanted.std()


def test_a_record_without_tapers_comes_back_at_its_samples():
    time = 0.5 * np.arange(1200)
    waves = record_waves(WaveRecord("r", 0.0, 0.5, TRUE.evaluate(np.ones((len(TRUE), 1)), time)[:, 0]), 320.0, 9.8)
    wanted = TRUE.evaluate(np.ones((len(TRUE), 1)), time)[:, 0]
    found = waves.evaluate(np.ones((len(waves), 1)), time)[:, 0]
    np.testing.assert_allclose(found, wanted - wanted.mean(), atol=5e-3 * wanted.std())  # but for the Nyquist frequency


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_a_record_is_that_of_its_gauge(tmp_path, heading):
    true = irregular_waves(4.0, 9.0, 320.0, seed=5, repetition_period=1024.0, heading=heading)
    gauge = (120.0, -60.0)
    file = record_file(tmp_path, duration=1020.0, at=gauge, waves=true)
    waves = MeasuredSea(file=file, gauge=(*gauge, 0.0), heading=heading, **BAND)
    top = at_sea()
    top.sea = waves
    components = top.sea.components()
    time = np.arange(200.0, 800.0, 0.7)
    for place in (gauge, (0.0, 0.0), (-200.0, 50.0)):  # at the gauge, at the origin, elsewhere
        found = components.evaluate(components.elevation_transfer([place]), time)
        wanted = true.evaluate(true.elevation_transfer([place]), time)
        assert np.std(found - wanted) < 0.03 * wanted.std()


def test_a_run_begins_within_the_record(tmp_path):
    file = record_file(tmp_path, first=1000.0)
    time, found = elevation(at_sea(spectrum="record", file=file, start=1200.0, **BAND), 100.0)
    wanted = TRUE.evaluate(np.ones((len(TRUE), 1)), time + 200.0)[:, 0]
    assert np.std(found - wanted) < 0.01 * wanted.std()


def test_after_the_record_comes_still_water_and_a_warning(tmp_path):
    file = record_file(tmp_path, duration=100.0)
    top = at_sea(spectrum="record", file=file, padding=200.0, **BAND)
    with pytest.warns(UserWarning, match="the sea repeats itself after 100 s; take a longer .*record"):
        time, found = elevation(top, 250.0)
    assert found[(time > 130) & (time < 240)].std() < 0.02 * found[time < 100].std()


def test_the_band_leaves_out_what_is_beyond_it(tmp_path):
    time = 0.1 * np.arange(6000)
    slow, swell, chop = (a * np.cos(2 * np.pi * f * time) for a, f in ((0.5, 0.01), (1.0, 0.1), (0.4, 1.2)))
    file = write(tmp_path / "three.csv", time, slow + swell + chop)
    top = at_sea(spectrum="record", file=file)
    with pytest.warns(UserWarning, match=r"sea: \d+.\d% of the variance of .*three.csv lies outside of 0.02 to 0.5 Hz"):
        at, found = elevation(top, 500.0, step=0.1)
    inside = (at > 150) & (at < 450)  # the slow wave is cut off at the ends, which are within the band
    assert np.abs(found[inside] - np.cos(0.2 * np.pi * at[inside])).max() < 0.02


def test_the_spectra_of_seas(tmp_path):
    omega = np.linspace(0.01, 6.0, 60000)
    top = at_sea(spectrum="jonswap", significant_wave_height=4.0, peak_period=9.0)
    assert np.trapezoid(top.sea.spectral_density(omega), omega) == pytest.approx(1.0, rel=2e-3)
    top.sea = MeasuredSea(file=record_file(tmp_path, duration=2000.0), **BAND)
    assert np.trapezoid(top.sea.spectral_density(omega), omega) == pytest.approx(
        top.sea.components().variance, rel=2e-2
    )
    top.sea = StillSea()
    assert not top.sea.spectral_density(omega).any()


@pytest.mark.parametrize(
    ("lines", "sea", "message"),
    [
        ("0,1\n1,2\n2,x\n3,4\n", {}, "buoy.csv:3: column 2 is 'x', expected a number"),
        ("0,1\n1,2\n2,nan\n3,4\n", {}, "buoy.csv:3: column 2 is 'nan', expected a number"),
        ("0,1\n1,2\n2,3\n4,4\n", {}, "buoy.csv:4: time rises by 2 s here and by 1 s elsewhere"),
        ("0\n1\n2\n", {}, "buoy.csv:1: 1 column, expected time and elevation, separated by commas"),
        ("0,1,2\n1,2,2\n2,3,2\n", {}, "buoy.csv:1: 3 columns, expected 2, time and elevation"),
        ("0,1\n1,2\n", {}, "2 lines of data, expected at least 4"),
        (None, {}, "buoy.csv: cannot read the record of waves: No such file"),
        ("long", {"start": 900.0}, "the start 900 s lies outside of the record, 0 to 99 s"),
        ("long", {"taper": 60.0}, "two tapers of 60 s leave nothing of 99 s"),
        ("long", {"lowest_frequency": 4.0}, "no frequency of the record lies between 0.637 and 0.5 Hz; it resolves"),
        ("long", {"file": ""}, "sea.file has no value; a sea of kind 'record' needs it"),
    ],
)
def test_mistakes_with_a_record(tmp_path, lines, sea, message):
    path = tmp_path / "buoy.csv"
    if lines == "long":
        write(path, np.arange(100.0), np.cos(np.arange(100.0)))
    elif lines is not None:
        path.write_text(lines)
    with pytest.raises(ModelError, match=message.replace("(", r"\(")):
        elevation(at_sea(**{"spectrum": "record", "file": str(path), **sea}), 1.0)


def test_a_record_with_a_byte_order_mark_and_windows_line_ends(tmp_path):
    path = tmp_path / "buoy.csv"
    path.write_bytes("\ufefftime,elevation\r\n".encode() + b"".join(b"%d,%d\r\n" % (i, i % 3) for i in range(10)))
    record = read_record(str(path))
    assert (record.step, record.end, len(record.elevation)) == (1.0, 9.0, 10)


# --- one plant -------------------------------------------------------------------------------------------------------

JONSWAP = {"sea.spectrum": "jonswap", "sea.significant_wave_height": 5.0, "sea.peak_period": 9.5}


def seas(file):
    record = {"sea.spectrum": "record", "sea.file": file, "sea.lowest_frequency": 0.2, "sea.highest_frequency": 3.0}
    return [
        {"sea.spectrum": "still"},
        {"sea.spectrum": "regular", "sea.wave_height": 4.0, "sea.wave_period": 9.0},
        {"sea.spectrum": "regular", "sea.wave_height": 2.0, "sea.wave_period": 7.0, "sea.heading": 1.0,
         "sea.build_up": 10.0},
        JONSWAP,
        {**JONSWAP, "sea.seed": 7, "sea.heading": -2.5, "platform.drag.drag_coefficient": 0.9},
        {**JONSWAP, "sea.gamma": 1.0, "sea.random_amplitudes": False, "sea.repetition_period": 1024.0},
        record,
        {**record, "sea.heading": 0.7, "sea.start": 100.0, "platform.water.position": (30.0, 10.0, 0.0)},
    ]  # fmt: skip


def test_one_compiled_spar_in_all_seas(tmp_path, counted):
    file = record_file(tmp_path)
    model = fw.load("oc3_spar_rigid").with_parameters({"wind.kind": "none"})
    plant = model.compile()
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw", "wave_elevation")
    options = {"solver": "fixed", "step": 0.05}
    durations = (5.0, 20.0, 12.0, 20.0, 15.0, 10.0, 20.0, 20.0)
    cases = list(zip(seas(file), durations, strict=True))
    found = [plant.simulate(t, 0.25, parameters=case, **options) for case, t in cases]
    assert counted == {"flattened": 1, "written": 1, "compiled": 1}
    for (case, t), result in zip(cases, found, strict=True):
        fresh = model.with_parameters(case).compile().simulate(t, 0.25, **options)
        for name in names:
            np.testing.assert_allclose(result[name], fresh[name], rtol=1e-10, atol=1e-10, err_msg=f"{case} {name}")
    ends = {round(float(result["surge"][20]), 9) for result in found}
    assert len(ends) == len(cases)  # no two of them are the same


def test_the_code_knows_nothing_of_the_sea(tmp_path):
    file = record_file(tmp_path)
    model = fw.load("oc3_spar_rigid").with_parameters({"wind.kind": "none"})
    texts = {model.with_parameters(case).compile().fixed_step_code.path for case in seas(file)[:4] + seas(file)[6:7]}
    assert len(texts) == 1  # libraries are kept by what their text says


def test_a_sea_takes_the_place_of_another():
    plant = fw.load("oc3_spar_rigid").with_parameters({"wind.kind": "none"}).compile()
    result = plant.simulate(5.0, 0.5, parts={"sea": RegularWaves(wave_height=3.0, wave_period=8.0)})
    wanted = 1.5 * np.cos(2 * np.pi / 8 * np.arange(0, 5.01, 0.5))
    np.testing.assert_allclose(result["wave_elevation"], wanted, atol=1e-9)
    state = plant.equilibrium({"sea": StillSea()})
    assert abs(float(state["heave"])) < 0.01
    with pytest.raises(ModelError, match=r"an? InputSea cannot take the place of a JonswapSea when a run starts"):
        plant.simulate(1.0, 0.5, parts={"sea": InputSea()})


def test_kinds_are_classes():
    assert [type(Sea(spectrum=kind)) for kind in ("still", "regular", "jonswap", "record", "input")] == [
        StillSea, RegularWaves, JonswapSea, MeasuredSea, InputSea]  # fmt: skip
    with pytest.raises(ModelError, match="has no parameter 'seed'; it belongs to the spectrum jonswap"):
        Sea(seed=3)


def test_seas_that_are_read_again_are_not_computed_again(tmp_path):
    file = record_file(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        top = at_sea(spectrum="record", file=file, **BAND)
        assert top.sea.components() is top.sea.components()
    record_file(tmp_path, offset=1.0, duration=700.0)
    assert len(top.sea.record().elevation) == 2801  # the file has changed
