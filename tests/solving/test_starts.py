"""Where a run starts by a word: the mean of its own conditions, found once and kept, the same for every asker."""

from __future__ import annotations

import json

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cases import Case
from fowtlib.cli.app import main
from fowtlib.components.environment import InputWind, JonswapSea, KaimalWind, SeriesWind, SteadyWind, StepWind, Wind
from fowtlib.language import ModelError, Series
from fowtlib.solving import starts
from fowtlib.solving.starts import mean_parameters, mean_values, start_values

SEA = {"sea.spectrum": "jonswap", "sea.significant_wave_height": 3.0, "sea.peak_period": 9.0}
WIND = {"wind.kind": "kaimal", "wind.mean_speed": 9.0}
STEADY = {"wind.kind": "steady", "wind.mean_speed": 9.0, "sea.spectrum": "still"}


@pytest.fixture(scope="module")
def plant():
    return fw.load("oc3_spar_rigid", set={**WIND, **SEA}).compile()


@pytest.fixture
def sought(monkeypatch):
    """The means that were sought, and not found among those that are kept."""
    monkeypatch.setenv("FOWTLIB_KEEP_FLAT", "no")  # nor among those of other processes
    calls = []
    found = starts._found
    monkeypatch.setattr(starts, "_found", lambda *given: calls.append(given[2]) or found(*given))
    return calls


def first(plant, parameters, **options):
    result = plant.simulate(0.05, 0.05, solver="fixed", parameters=parameters, **options)
    return float(result["surge"][0]), float(result["rotor_speed"][0])


def test_a_word_a_case_a_model_file_and_the_command_do_the_same(plant, capsys, monkeypatch, tmp_path):
    wanted = plant.equilibrium(STEADY)
    surge, speed = first(plant, {**WIND, **SEA}, start="turning")
    assert surge == pytest.approx(wanted["surge"], abs=1e-9) and speed == pytest.approx(wanted["rotor_speed"], abs=1e-9)
    assert first(plant, {**WIND, **SEA}, start="") == (surge, speed)  # simulation.start of oc3_spar_rigid is turning
    case = Case("one", "oc3_spar_rigid", {**WIND, **SEA}, duration=0.05, output_step=0.05)
    assert float(plant.simulate(conditions=case.conditions(), solver="fixed")["surge"][0]) == surge
    monkeypatch.chdir(tmp_path)
    argv = ["run", "oc3_spar_rigid", "--time", "0.05", "--output-step", "0.05", "--output", "run.nc", "--start"]
    conditions = ["--wind", "kaimal:9", "--waves", "jonswap:Hs=3,Tp=9"]
    assert main([*argv, "turning", *conditions]) == 0
    assert float(fw.Result.open("run.nc")["surge"][0]) == pytest.approx(surge, abs=1e-9)
    assert first(plant, {**WIND, **SEA}, start="run.nc")[0] != surge  # its end
    assert abs(first(plant, {**WIND, **SEA})[0] - surge) > 1  # without a word: the start values of the file
    capsys.readouterr()


def test_one_mean_for_all_seeds_seas_and_kinds_of_a_speed(plant, sought):
    plant.kept_starts.clear()
    for seed in (1, 2):
        sea = {**SEA, "sea.significant_wave_height": 2.0 + seed, "sea.heading": 0.2 * seed, "sea.seed": seed}
        first(plant, {**WIND, **sea, "wind.seed": seed, "wind.turbulence_class": "A"}, start="turning")
    first(plant, {"wind.kind": "gust", "wind.mean_speed": "9 m/s"}, start="turning")
    first(plant, STEADY, start="turning")
    assert len(sought) == len(plant.kept_starts) == 1
    first(plant, {**WIND, "wind.mean_speed": 14.0}, start="turning")
    assert len(sought) == 2 and sought[1]["wind.mean_speed"] == 14.0
    first(plant, {**WIND, "platform.hull.mass": "7500 t"}, start="turning")
    assert len(sought) == 3


def test_kept_means_are_plain_data_for_another_process(plant, sought):
    first(plant, WIND, start="turning")
    sought.clear()
    text = json.dumps(plant.kept_starts)
    other = fw.load("oc3_spar_rigid", set={**WIND, **SEA}).compile()
    other.kept_starts.update(json.loads(text))
    assert first(other, WIND, start="turning") == first(plant, WIND, start="turning")
    assert not sought
    changed = fw.load("oc3_spar_rigid", set={**WIND, **SEA, "platform.hull.mass": 7.5e6}).compile()
    changed.kept_starts.update(json.loads(text))
    first(changed, WIND, start="turning")
    assert len(sought) == 1  # another model has its own


def test_only_so_many_are_kept(plant, monkeypatch):
    monkeypatch.setattr(starts, "KEPT", 2)
    plant.kept_starts.clear()
    for speed in (6.0, 7.0, 8.0):
        start_values(plant, "equilibrium", {**STEADY, "wind.mean_speed": speed})
    assert len(plant.kept_starts) == 2


def test_the_mean_of_each_kind(tmp_path):
    file = tmp_path / "wind.csv"
    file.write_text("time,speed\n" + "\n".join(f"{t},{8 + (t % 2)}" for t in range(20)) + "\n")
    series = SeriesWind(file=str(file), stations=[[0, 120]], reference_height=90, shear_exponent=0.2)
    mean = series.in_the_mean()
    steady = SteadyWind(mean_speed=mean["mean_speed"], stations=[[0, 120]], reference_height=90, shear_exponent=0.2)
    assert steady.mean_at(0) == pytest.approx(series.mean_at(0), abs=0.01)
    steady = {"kind": "steady", "shear_exponent": 0.1}
    assert KaimalWind(mean_speed=9, shear_exponent=0.1).in_the_mean() == steady
    assert StepWind(mean_speed=9, step_speed=12, shear_exponent=0.1).in_the_mean() == steady
    assert Wind(kind="none").in_the_mean() == {}
    assert mean_values(InputWind(mean_speed=9)) == {}  # its equations are others, and do not change in time
    assert JonswapSea(heading=0.3).in_the_mean() == {"spectrum": "still", "heading": 0.0, "build_up": 0.0}


class Slope(Wind, kind="slope of test"):
    """Rises all the time; its mean is what it says."""

    def station_series(self):
        n = len(self.hubs)
        return Series.samples(np.outer([8.0, 10.0, 12.0, 14.0], [1.0] * n + [0.0] * n), 100.0)

    def mean_at(self, station=0):
        return 11.0


def test_the_mean_of_a_kind_of_ones_own_and_of_a_part_of_a_run(plant):
    mean = mean_parameters(plant, {"wind": Slope(), "sea.seed": 4, "sea.build_up": 20})
    assert mean == {"sea.spectrum": "still", "sea.heading": 0.0, "sea.build_up": 0.0, "wind.kind": "steady",
                    "wind.mean_speed": 11.0, "wind.shear_exponent": 0.0}  # fmt: skip
    values, whence = start_values(plant, "turning", {"wind": Slope()})
    assert whence == "from the mean position"
    state = plant.equilibrium({**STEADY, "wind.mean_speed": 11.0})
    for k, item in enumerate(plant.dae.states):
        assert values[item.path] == pytest.approx(state.x[k], abs=1e-6), item.path


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("fast", "start: 'fast' is not 'equilibrium', 'turning', 'stationary', 'rest' or 'file', nor a file"),
        ("absent.nc", "absent.nc: there is no such file"),
        (7, "start: 7 is no State, no Result, no start values by path and no word"),
    ],
)
def test_other_words_are_refused(plant, word, told):
    with pytest.raises(ModelError, match=told):
        first(plant, WIND, start=word)
