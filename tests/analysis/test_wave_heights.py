"""Heights of waves and the acceptance of realisations; the case set of a tank programme."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.comparison import compare_over_time
from fowtlib.analysis.wave_heights import HIGHEST, accepted_seeds, check_realisation, wave_heights
from fowtlib.components.environment.waves import irregular_waves
from fowtlib.language.errors import ModelError
from fowtlib.language.units import to_si

HS, TP, DEPTH = 6.75, 9.46, 90.0


def three_hours(seed: int) -> tuple[np.ndarray, np.ndarray]:
    size, period = 65536, 16384.0
    waves = irregular_waves(HS, TP, DEPTH, seed=seed, repetition_period=period)
    lines = np.zeros(size // 2 + 1, dtype=complex)
    lines[np.rint(waves.omega * period / (2 * np.pi)).astype(int)] = waves.complex_amplitude * size / 2
    time = np.arange(size) * period / size
    return time[time <= 10800.0], np.fft.irfft(lines, size)[time <= 10800.0]


def test_waves_of_a_known_record():
    time = np.arange(0.0, 200.0, 0.05)
    found = wave_heights((time, 0.5 + np.sin(time) * (1 + 0.5 * (time > 100))))
    assert found.highest == pytest.approx(3.0, rel=1e-3)
    assert np.median(found.periods) == pytest.approx(2 * math.pi, rel=1e-3)
    assert found.heights.min() == pytest.approx(2.0, rel=1e-3)
    with pytest.raises(ModelError, match="there are 0 waves in the record"):
        wave_heights((time[:20], np.sin(time[:20])))


def test_realisations_of_three_hours():
    """m0 = Hs^2/16, and Hmax/Hs about sqrt(ln(N)/2) = 1.86 of 1000 waves, of which a broad spectrum has less.

    Forristall (1978): heights of wind seas are 0.93 of Rayleigh's.
    """
    checks = [check_realisation(three_hours(seed), HS) for seed in range(1, 25)]
    assert np.mean([check.variance_ratio for check in checks]) == pytest.approx(1.0, abs=0.02)
    ratio = float(np.mean([check.highest_ratio for check in checks]))
    assert 0.9 * 1.86 < ratio < 1.05 * 1.86
    waves = np.mean([check.waves for check in checks])
    assert 1200 < waves < 1600
    third = wave_heights(three_hours(1))
    assert third.third == pytest.approx(third.significant, rel=0.07)
    assert third.expected_ratio == pytest.approx(math.sqrt(math.log(third.heights.size) / 2))
    assert any(check.accepted for check in checks) and not all(check.accepted for check in checks)


def test_seeds_that_are_accepted():
    seeds = accepted_seeds(HS, TP, DEPTH, count=3)
    assert len(seeds) == 3 and seeds == sorted(seeds)
    for seed in seeds:
        assert check_realisation(three_hours(seed), HS).highest_ratio >= HIGHEST - 0.02
    with pytest.raises(ModelError, match="of 5 seeds 0 have a wave of 4 Hs"):
        accepted_seeds(HS, TP, DEPTH, limit=4.0, tries=5)
    with pytest.raises(ModelError, match="need a repetition period of as much"):
        accepted_seeds(HS, TP, DEPTH, repetition_period=4096.0)


def test_the_programme_is_three_states_three_headings_six_seeds():
    from fowtlib.modelfile.files import models_folder

    cases = fw.read_cases(models_folder() / "cases" / "tank_programme.yaml")
    assert len(cases) == 54
    assert {case.duration - case.discard for case in cases} == {10800.0}
    headings = {round(math.degrees(to_si(case.parameters["sea.heading"], "rad"))) for case in cases}
    assert headings == {0, 45, 90}
    fw.check_cases(cases)


def test_a_short_programme_runs(tmp_path):
    from fowtlib.modelfile.files import models_folder

    cases = fw.read_cases(models_folder() / "cases" / "tank_programme_short.yaml")
    assert len(cases) == 3
    batch = fw.run_batch([replace(case, duration=40.0) for case in cases], tmp_path / "batch", workers=1)
    assert [row.state for row in batch] == ["done"] * 3
    sway = [row.statistics["sway"]["std"] for row in batch]
    assert sway[0] < 1e-3 * sway[2] and sway[0] < sway[1]


def test_a_measured_record_drives_the_model(tmp_path):
    """A run in a sea; the elevation 40 m before the platform is written down and imposed: the same motions.

    The band is that of the sea, and both seas grow in a minute: a sudden start leaves a free heave that lasts for
    minutes (resonance at 0.032 Hz, damping 4 %), and is another one where the ends of the record are tapered.
    """
    sea = {"wind.kind": "none", "sea.significant_wave_height": 4.5, "sea.peak_period": 9.5, "sea.heading": "30 deg",
           "sea.build_up": 60.0}  # fmt: skip
    plant = fw.load("oc3_spar_rigid", set=sea).compile()
    test = plant.simulate(260.0, output_step=0.25)
    waves = irregular_waves(4.5, 9.5, 320.0, heading=math.radians(30), seed=1)
    time, place = np.arange(0.0, 300.0, 0.25), -40.0 * math.cos(math.radians(30))
    turned = np.exp(1j * (np.outer(time, waves.omega) - waves.wave_number * place))
    gauge = (turned @ waves.complex_amplitude).real
    rows = "".join(f"{t},{x:.6f}\n" for t, x in zip(time, gauge, strict=True))
    (tmp_path / "gauge.csv").write_text("time [s],elevation [m]\n" + rows)
    record = {
        "sea.spectrum": "record", "sea.file": str(tmp_path / "gauge.csv"), "sea.gauge": (-40.0, 0.0, 0.0),
        "sea.taper": 5.0, "sea.build_up": 60.0, "sea.heading": "30 deg", "sea.highest_frequency": 2 * math.pi * 0.5,
        "sea.lowest_frequency": 2 * math.pi * 0.04,
    }  # fmt: skip
    run = fw.load("oc3_spar_rigid", set={"wind.kind": "none", **record}).compile().simulate(260.0, output_step=0.25)
    found = {row.name: row for row in compare_over_time(run, test, discard=120.0)}
    assert found["wave_elevation"].correlation > 0.995
    assert found["wave_elevation"].rmse_of_std < 0.1
    for name in ("heave", "pitch"):
        assert found[name].correlation > 0.98, name


def test_the_programme_at_model_scale_has_seeds_with_a_highest_wave():
    from fowtlib.modelfile.files import models_folder

    cases = fw.read_cases(models_folder() / "cases" / "tank_programme_flowave.yaml")
    assert len(cases) == 54
    fw.check_cases(cases)
    seeds: dict[tuple[float, float], set[int]] = {}
    for case in cases:
        state = tuple(float(case.parameters[f"sea.{name}"]) for name in ("significant_wave_height", "peak_period"))
        seeds.setdefault(state, set()).add(int(case.parameters["sea.seed"]))
        assert case.duration - case.discard == 1610.0
    for (height, period), chosen in seeds.items():
        found = accepted_seeds(height, period, 2.0, duration=1610.0, discard=60.0, repetition_period=2442.0)
        assert chosen == set(found)
