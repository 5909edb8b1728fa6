"""Laws of extremes from the runs of a batch: here a batch of series whose law is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import xarray

import fowtlib.cases
from fowtlib.cases import Case, Row
from fowtlib.cli.app import main
from fowtlib.language.errors import ModelError
from fowtlib.metocean import (
    State,
    States,
    UpCrossings,
    bins,
    fits_of_batch,
    full_long_term,
    one_by_one,
    read_fits,
    site,
    states_to_cases,
)

STATES = bins(site("norway_5").at(90), [8, 12, 16], [2, 4], [8, 12], keep=None)
SPAN, STEP = 3600.0, 0.5


def gaussian(mean: float, std: float, period: float, seed: int) -> np.ndarray:
    """A narrow band of 60 harmonics about a period [s]."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, SPAN, STEP)
    omega = 2 * np.pi / period * (1 + 0.15 * rng.standard_normal(60))
    phase = rng.uniform(0, 2 * np.pi, 60)
    return mean + std * np.sqrt(2 / 60) * np.cos(np.outer(time, omega) + phase).sum(axis=1)


@dataclass
class Made:
    """What `fits_of_batch` asks of a batch."""

    rows_: list[Row]
    series: dict[str, np.ndarray]
    folder: Path = Path("made.batch")

    def rows(self) -> list[Row]:
        return self.rows_

    def path(self, name: str) -> Path:
        return self.folder / f"{name}.nc"

    def result(self, name: str) -> dict[str, xarray.DataArray]:
        time = {"time": np.arange(0, SPAN, STEP)}
        return {"surge": xarray.DataArray(self.series[name], time, ["time"], "surge", {"units": "m"})}


def made(seeds: int, monkeypatch, failed: tuple[int, ...] = (), states: States = STATES) -> Made:
    rows, series = [], {}
    for index, plain in enumerate(states_to_cases(states, "oc3_spar_rigid", seeds=seeds, duration=4000, discard=400)):
        case = Case.from_plain(plain)
        values = gaussian(case.labels["wind_speed"], case.labels["Hs"], case.labels["Tp"], index)
        statistics = {"surge": {"unit": "m", "max": float(values.max())}}
        state = "failed" if index in failed else "done"
        rows.append(Row(case, state=state, simulated=4000.0, statistics=statistics))
        series[case.name] = values
    batch = Made(rows, series)
    monkeypatch.setattr(fowtlib.cases.Batch, "open", classmethod(lambda _, folder: batch))
    return batch


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "made.batch").mkdir()


def median(state: State) -> float:
    """Of the largest value in an hour: mean + s sqrt(2 ln(T / (period ln 2)))."""
    return state.wind_speed + state.wave_height * np.sqrt(2 * np.log(SPAN / state.peak_period / np.log(2)))


@pytest.mark.filterwarnings("ignore:surge")
@pytest.mark.parametrize(("law", "within"), [("gaussian", 0.05), ("rates", 0.12), (None, 0.06)])
def test_rates_of_one_run_a_state(law, within, monkeypatch):
    batch = made(1, monkeypatch)
    fits = fits_of_batch(batch, ["surge"], law, 3600.0)["surge"]
    states, laws = fits.bins
    assert fits.points is None and fits.unit == "m" and fits.runs is None
    assert states.weights == pytest.approx(STATES.weights)
    expected = np.array([median(state) for state in states])
    assert laws.isf(0.5) == pytest.approx(expected, rel=within)
    if law != "gaussian":
        assert (laws.c >= 1).all()


@pytest.mark.filterwarnings("ignore:surge")
def test_a_shared_shape_is_nearer_to_the_truth_than_tails_of_single_hours(monkeypatch):
    """50-year values of a Gaussian response of which each state has run an hour; exact from its mean and deviation."""
    batch = made(1, monkeypatch)
    laws = [UpCrossings(1 / state.peak_period, 0.5 / state.wave_height**2, state.wind_speed, 2.0) for state in STATES]
    exact = full_long_term(STATES, one_by_one(dict(zip(STATES, laws, strict=True)).__getitem__)).value(50)
    wrong = {}
    for law in ("gaussian", "pooled", "rates"):
        states, fitted = fits_of_batch(batch, ["surge"], law, 3600.0)["surge"].bins
        wrong[law] = full_long_term(states, lambda _, fitted=fitted: fitted).value(50) / exact - 1
    assert abs(wrong["gaussian"]) < 0.03
    assert abs(wrong["pooled"]) < 0.08
    assert abs(wrong["pooled"]) < abs(wrong["rates"])


def test_gumbel_of_several_runs(monkeypatch):
    batch = made(10, monkeypatch, states=STATES[:3])
    fits = fits_of_batch(batch, None, None, 3600.0)["surge"]
    states, laws = fits.bins
    assert fits.runs.tolist() == [10] * 3
    assert laws.isf(0.5) == pytest.approx([median(state) for state in states], rel=0.05)
    first = [row.statistics["surge"]["max"] for row in batch.rows_[:10]]
    assert laws.scale[0] == pytest.approx(np.sqrt(6) / np.pi * np.std(first, ddof=1))
    longer = fits_of_batch(batch, None, "gumbel", 3 * 3600.0)["surge"].bins[1]
    assert longer.location == pytest.approx(laws.location + laws.scale * np.log(3))


def test_the_command_writes_fits_that_it_reads(monkeypatch, capsys):
    made(1, monkeypatch)
    assert main(["extremes", "norway_5", "--batch", "made.yaml", "--save-fits", "fits.csv", "--csv"]) == 0
    first = capsys.readouterr().out
    assert main(["extremes", "norway_5", "--fits", "fits.csv", "--csv"]) == 0
    assert capsys.readouterr().out == first
    assert len(read_fits("fits.csv")["surge"].bins[0]) == len(STATES)


def test_cases_that_are_missing_are_told(monkeypatch):
    batch = made(1, monkeypatch, failed=(0, 5))
    share = 100 * STATES.weights[[0, 5]].sum()
    with pytest.warns(UserWarning, match=rf"2 cases of made.batch are not done; states without any hold {share:.2g} %"):
        fits = fits_of_batch(batch, ["surge"], "gaussian", 3600.0)
    assert len(fits["surge"].bins[0]) == len(STATES) - 2


@pytest.mark.parametrize(("seeds", "law"), [(1, "pooled"), (2, "gumbel"), (1, "gaussian")])
def test_a_response_that_one_case_lacks(seeds, law, monkeypatch):
    """As one with a value that is not finite, of which no statistics are kept."""
    batch = made(seeds, monkeypatch)
    row = batch.rows_[3]
    batch.rows_[3] = replace(row, statistics={"power": row.statistics["surge"]})
    with pytest.raises(ModelError, match=f"the case '{row.name}' has no statistics of 'surge'; name others with"):
        fits_of_batch(batch, None, law, 3600.0)


def test_refusals(monkeypatch):
    batch = made(1, monkeypatch)
    with pytest.raises(ModelError, match="there is no result 'surg'; did you mean 'surge'"):
        fits_of_batch(batch, ["surg"], None, 3600.0)
    with pytest.raises(ModelError, match="a state has one run alone"):
        fits_of_batch(batch, ["surge"], "gumbel", 3600.0)
    batch.series = {name: 0 * values for name, values in batch.series.items()}
    for law in ("rates", "pooled", "gaussian"):
        with pytest.raises(ModelError, match="(?i)name the results to evaluate with --results"):
            fits_of_batch(batch, ["surge"], law, 3600.0)
    batch.rows_ = [Row(Case("a", "oc3_spar_rigid"), state="done")]
    with pytest.raises(ModelError, match="the case 'a' has no label wind_speed, Hs, Tp"):
        fits_of_batch(batch, None, None, 3600.0)
    batch.rows_ = []
    with pytest.raises(ModelError, match="no case is done yet"):
        fits_of_batch(batch, None, None, 3600.0)
