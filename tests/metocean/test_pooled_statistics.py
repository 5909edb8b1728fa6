"""Tails from what a registry keeps of each run, against those from the series themselves."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis import Spectrum
from fowtlib.analysis.kept import kept_runs
from fowtlib.analysis.spectra import realisation
from fowtlib.language.errors import ModelError
from fowtlib.metocean.pooled_tails import EXPONENTIAL, Pool


def records(count):
    f = np.linspace(0.0, 0.2, 401)
    slow = Spectrum(f, np.exp(-(((f - 0.03) / 0.01) ** 2)), "m", "surge")
    return [realisation(slow, 3600.0, 0.5, seed=seed) for seed in range(count)]


def test_tails_from_statistics_are_those_from_series():
    series, kept = Pool(), Pool()
    for number, record in enumerate(records(40)):
        series.add(number, 12.0, [record])
        result = fw.Result(record.time, {"surge": record.values}, {"surge": "m"})
        told = fw.case_statistics(result)["channels"]["surge"]
        kept.add_kept(number, 12.0, kept_runs([told], [float(record.time[-1] - record.time[0])], "surge"))
    one, other = sum(series.counts[12.0]), sum(kept.counts[12.0])
    assert np.abs(one - other).max() <= 0.02 * one.max()  # passages between two pieces are counted in neither
    assert kept.lowest[12.0] == pytest.approx(series.lowest[12.0], rel=1e-9)
    whole, _ = series.tails(lambda key: 12.0)
    short, _ = kept.tails(lambda key: 12.0)
    for level in (2.0, 3.0, 3.5):
        rates = [tail.q * np.exp(-tail.a * max(level * own.std + own.mean - tail.b, 0.0) ** tail.c)
                 for tail, own in ((whole[3], series.states[3]), (short[3], kept.states[3]))]  # fmt: skip
        assert rates[1] == pytest.approx(rates[0], rel=0.15), level


def test_levels_that_are_not_kept_are_refused():
    kept = {"mean": 0.0, "std": 1.0, "min": -3.0, "crossings": {"step": 0.25, "above": [10, 5]}}
    with pytest.raises(ModelError, match="do not count passages at the levels"):
        kept_runs([kept], [3600.0], "surge")


@pytest.mark.parametrize("side", ["max", "min"])
def test_passages_of_runs_with_means_of_their_own(side):
    """Two runs: mean and deviation are those of both together, and passages those of the series, below the mean too."""
    sign = 1.0 if side == "max" else -1.0
    series = [record.values + shift for record, shift in zip(records(2), (0.0, 0.7), strict=True)]
    told = [fw.case_statistics(fw.Result(np.arange(values.size) * 0.5, {"surge": values}, {"surge": "m"}))
            for values in series]  # fmt: skip
    runs = kept_runs([each["channels"]["surge"] for each in told], [3600.0, 3600.0], "surge", side)
    together = sign * np.concatenate(series)
    assert runs.mean == pytest.approx(together.mean(), abs=1e-3) and runs.lowest == together.min()
    assert runs.std == pytest.approx(together.std(), rel=1e-3)
    for row, values in enumerate(sign * each for each in series):
        own = values.mean() + values.std() * np.array([-1.2, -0.4, 0.0, 0.3, 1.5, 2.0])
        counted = [np.count_nonzero((values[:-1] <= level) & (values[1:] > level)) for level in own]
        assert np.abs(runs.passages(own)[row] - counted).max() <= 1  # upward for downward ones
        between = runs.passages(own + 0.05 * values.std())[row]
        further = runs.passages(own + 0.1 * values.std())[row]
        assert np.all((between - runs.passages(own)[row]) * (between - further) <= 1e-9)
    assert runs.passages([together.max() + 1.0]).tolist() == [[0.0], [0.0]]


def test_a_constant_is_refused_alike():
    time = np.arange(0.0, 3600.0, 0.5)
    result = fw.Result(time, {"surge": np.full(time.size, 0.1)}, {"surge": "m"})
    told = fw.case_statistics(result)["channels"]["surge"]
    with pytest.raises(ModelError, match="it does not change"):
        Pool("surge").add_kept(0, 12.0, kept_runs([told], [3600.0], "surge"))
    with pytest.raises(ModelError, match="surge does not change"):
        Pool("surge").add(0, 12.0, [result["surge"]])


def test_warnings_of_a_tail_name_the_response():
    """The sixth power of a Gaussian value lies beyond y with a probability like exp(-y^(1/3) / 2)."""
    pool, time = Pool("surge"), np.arange(0.0, 3600.0, 0.5)
    for seed in range(10):
        values = np.random.default_rng(seed).standard_normal(time.size)
        pool.add(seed, 12.0, [(time, np.sign(values) * values**6)])
    with pytest.warns(UserWarning, match="^surge: the power c of the tail lies at its least"):
        _, kinds = pool.tails(lambda key: 12.0)
    assert kinds == {EXPONENTIAL: 1}
