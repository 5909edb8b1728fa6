"""Laws of extremes from the runs of a batch: here a batch of series whose law is known."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import xarray

import fowtlib as fw
import fowtlib.cases
from fowtlib.cases import Case, Row
from fowtlib.cli.app import main
from fowtlib.language.errors import ModelError, ParameterError
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


@lru_cache(maxsize=512)
def run(sign: float, *process: float) -> tuple[np.ndarray, dict]:
    """Values of a process and their statistics."""
    values = sign * gaussian(*process)
    return values, fw.case_statistics(fw.Result(np.arange(0, SPAN, STEP), {"surge": values}, {"surge": "m"}))


@dataclass
class Made:
    """What `fits_of_batch` and the command ask of a batch."""

    rows_: list[Row]
    series: dict[str, np.ndarray]
    folder: Path = Path("made.batch")
    kept: bool = False  # statistics alone
    about: dict = field(default_factory=dict)

    def rows(self) -> list[Row]:
        return self.rows_

    def path(self, name: str) -> Path | None:
        return None if self.kept else self.folder / f"{name}.nc"

    def result(self, name: str) -> dict[str, xarray.DataArray]:
        assert not self.kept
        time = {"time": np.arange(0, SPAN, STEP)}
        return {"surge": xarray.DataArray(self.series[name], time, ["time"], "surge", {"units": "m"})}


def made(
    seeds: int, monkeypatch, failed: tuple[int, ...] = (), states: States = STATES, *,
    kept: bool = False, sign: float = 1.0, mean: float = 1.0,
) -> Made:  # fmt: skip
    """A batch whose surge has the mean wind speed [m], the deviation Hs, and periods about Tp, times a sign."""
    rows, series = [], {}
    for index, plain in enumerate(states_to_cases(states, "oc3_spar_rigid", seeds=seeds, duration=4000, discard=400)):
        case = Case.from_plain(plain)
        values, told = run(sign, mean * case.labels["wind_speed"], case.labels["Hs"], case.labels["Tp"], index)
        state = "failed" if index in failed else "done"
        rows.append(Row(case, state=state, simulated=4000.0, statistics=told["channels"]))
        series[case.name] = values
    batch = Made(rows, series, kept=kept)
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
    with pytest.raises(ParameterError, match="made.batch: a side is given for 'surg'; did you mean 'surge'"):
        fits_of_batch(batch, ["surge"], None, 3600.0, side={"surg": "abs"})
    with pytest.raises(ParameterError, match="max, min or abs, not 'both'"):
        fits_of_batch(batch, ["surge"], None, 3600.0, side="both")
    batch.series = {name: 0 * values for name, values in batch.series.items()}
    still = fw.Result(np.arange(0, SPAN, STEP), {"surge": np.zeros(int(SPAN / STEP))}, {"surge": "m"})
    rows = batch.rows_
    for batch.kept in (False, True):
        for law in ("rates", "pooled", "gaussian"):
            with pytest.raises(ModelError, match="(?i)does not change|all .* equal|name the results to evaluate"):
                fits_of_batch(batch, ["surge"], law, 3600.0)
        batch.rows_ = [replace(row, statistics=fw.case_statistics(still)["channels"]) for row in rows]
    batch.rows_ = [rows[0], replace(rows[1], statistics={})]
    with pytest.raises(ModelError, match="there are no statistics of 'surge'. Name the results"):
        fits_of_batch(batch, ["surge"], "gaussian", 3600.0)
    batch.rows_ = [Row(Case("a", "oc3_spar_rigid"), state="done")]
    with pytest.raises(ModelError, match="the case 'a' has no label wind_speed, Hs, Tp"):
        fits_of_batch(batch, None, None, 3600.0)
    batch.rows_ = []
    with pytest.raises(ModelError, match="no case is done yet"):
        fits_of_batch(batch, None, None, 3600.0)


FEW = STATES[:4]


def factor(sides: int) -> float:
    """Median of the extreme of an hour of FEW[0], in deviations: sqrt(2 ln(sides T / (period ln 2)))."""
    return float(np.sqrt(2 * np.log(sides * SPAN / FEW.peak_period[0] / np.log(2))))


@pytest.mark.filterwarnings("ignore:surge", "ignore:.surge")
@pytest.mark.parametrize(("law", "within"), [("gaussian", 0.04), ("gumbel", 0.1), ("rates", 0.1), ("pooled", 0.06)])
@pytest.mark.parametrize("kept", [False, True])
def test_a_symmetric_process_is_as_deep_as_high(law, within, kept, monkeypatch):
    """About 0: the minimum is the negative of the maximum, and |x| passes each level twice as often.

    The median of 8 maxima has a standard error of 3.5 %.
    """
    batch = made(8, monkeypatch, states=FEW, kept=kept, mean=0.0)
    found = {side: fits_of_batch(batch, None, law, 3600.0, side=side) for side in ("max", "min", "abs")}
    (high,), (low,), (both,) = (fits.values() for fits in found.values())
    assert [each.label for each in (high, low, both)] == ["surge", "surge (min)", "|surge|"]
    assert (high.sign, low.sign, both.sign) == (1.0, -1.0, 1.0)
    for each, sides in ((high, 1), (low, 1), (both, 2)):
        expected = [factor(sides) * state.wave_height for state in each.bins[0] if state.peak_period == 8]
        value = each.bins[1].isf(0.5)[each.bins[0].peak_period == 8]
        assert value == pytest.approx(expected, rel=within), (each.label, sides)


@pytest.mark.filterwarnings("ignore:surge", "ignore:.surge")
@pytest.mark.parametrize("law", ["gaussian", "gumbel", "rates", "pooled"])
@pytest.mark.parametrize("kept", [False, True])
def test_turning_the_sign_turns_the_sides(law, kept, monkeypatch):
    options = {"states": FEW, "kept": kept}
    plain, turned = (made(3, monkeypatch, sign=sign, **options) for sign in (1.0, -1.0))
    q = np.array([0.9, 0.5, 1e-3, 1e-6])
    for side, other in (("max", "min"), ("min", "max"), ("abs", "abs")):
        one, two = (
            next(iter(fits_of_batch(batch, None, law, 3600.0, side=which).values())).bins[1]
            for batch, which in ((plain, side), (turned, other))
        )
        for each in q:
            assert one.isf(each) == pytest.approx(two.isf(each), rel=1e-9), side
    wide = {side: next(iter(fits_of_batch(plain, None, law, 3600.0, side=side).values())).bins[1]
            for side in ("max", "abs")}  # fmt: skip
    assert wide["abs"].isf(1e-3) == pytest.approx(wide["max"].isf(1e-3), rel=1e-3)  # surge lies far above 0


@pytest.mark.filterwarnings("ignore:surge", "ignore:.surge")
@pytest.mark.parametrize(("law", "within"), [("gaussian", 5e-4), ("pooled", 0.015), ("rates", 0.03)])
def test_several_runs_of_which_statistics_are_kept(law, within, monkeypatch):
    """As from their files; what differs is that levels lie elsewhere and that the runs are not cut into pieces."""
    batch = made(6, monkeypatch, states=FEW)
    for number, (name, row) in enumerate(zip(batch.series, batch.rows_, strict=True)):  # means that differ by the run
        batch.series[name] = values = batch.series[name] + number % 3
        told = fw.case_statistics(fw.Result(np.arange(0, SPAN, STEP), {"surge": values}, {"surge": "m"}))
        batch.rows_[number] = replace(row, statistics=told["channels"])
    for side in ("max", "min"):
        of_files, batch.kept = fits_of_batch(batch, None, law, 3600.0, side=side), True
        of_kept, batch.kept = fits_of_batch(batch, None, law, 3600.0, side=side), False
        one, two = (next(iter(fits.values())).bins[1] for fits in (of_files, of_kept))
        means = np.array([state.wind_speed + 1 for state in FEW])
        away = one.isf(0.5) - means * (1 if side == "max" else -1)
        assert two.isf(0.5) == pytest.approx(one.isf(0.5), abs=within * away.max())


@pytest.mark.filterwarnings("ignore:surge", "ignore:.surge")
@pytest.mark.parametrize("law", ["gaussian", "gumbel"])
def test_the_command_says_sides(law, monkeypatch, capsys):
    made(6, monkeypatch, states=FEW, kept=True, mean=0.0)
    command = ["extremes", "norway_5", "--batch", "made.yaml", "--law", law, "--csv"]
    values = {}
    for side in ("max", "min", "surge=abs"):
        assert main([*command, "--side", side, "--save-fits", "fits.csv", "--force"]) == 0
        first = capsys.readouterr().out
        assert main(["extremes", "norway_5", "--fits", "fits.csv", "--csv"]) == 0
        assert capsys.readouterr().out == first
        (row,) = csv.DictReader(first.splitlines())
        values[row["response"]] = float(row["FLTA"])
    assert list(values) == ["surge", "surge (min)", "|surge|"]
    assert values["surge"] > 0 > values["surge (min)"]
    if law == "gaussian":  # Gumbel laws of 6 maxima scatter by a fifth so far out
        assert values["surge (min)"] == pytest.approx(-values["surge"], rel=0.05)
        assert max(values["surge"], -values["surge (min)"]) < values["|surge|"] < 1.1 * values["surge"]
    assert main(["extremes", "norway_5", "--fits", "fits.csv", "--side", "min"]) == 2
    assert "a table of --fits has a column for it" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main([*command, "--side", "surge=min,surge=max"])
    assert "is neither max, min or abs of all results" in capsys.readouterr().err
