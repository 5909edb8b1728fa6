"""Is one run of an hour enough for each state of the long term? Tables of docs/long_term.md from batches that were run.

python benchmarks/long_term.py choose bins.batch        lists 20 bins to be run with 20 seeds each
python benchmarks/long_term.py fill bins.batch check.batch

The law of one run takes its tail from all runs at its wind speed, but mean, deviation and rate from itself. Against it
stand a Gumbel law of the maxima of 20 seeds, and the same tail with mean, deviation and rate of these 20 runs, so that
what comes from the tail and what from the scatter of one run can be told apart.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pages import fill, markdown
from scipy.optimize import nnls

from fowtlib.cases import Batch
from fowtlib.metocean import Fits, Gumbel, LongTerm, State, UpCrossings, fits_of_batch
from fowtlib.metocean.states import COLUMNS

PAGE = Path(__file__).parents[1] / "docs" / "long_term.md"
RESPONSES = ("surge", "pitch", "yaw")
WIND_SPEEDS = (4, 8, 10, 20, 24, 28)
YEARS = 50


class Moments(NamedTuple):
    """Means, deviations and rates of passages of the mean [1/s] of one response in states; arrays."""

    mean: np.ndarray
    std: np.ndarray
    rate: np.ndarray


def choose(bins: Batch) -> list[State]:
    """The five bins that matter most for each response, and the most frequent ones at other wind speeds."""
    chosen: dict[State, None] = {}
    fits = fits_of_batch(bins, RESPONSES, "pooled")
    for name in RESPONSES:
        found = LongTerm(*fits[name].bins)
        shares, states = found.shares(found.value(YEARS)), list(found.states)
        chosen |= dict.fromkeys(states[i] for i in np.argsort(-shares)[:5])
    every = fits[RESPONSES[0]].bins[0]
    for speed in WIND_SPEEDS:
        at = np.flatnonzero(every.wind_speed == speed)
        chosen |= {list(every)[at[every.weights[at].argmax()]]: None}
    return list(chosen)


def runs_of(batch: Batch) -> dict[State, list[Any]]:
    """The runs of each state that are done."""
    found: dict[State, list[Any]] = {}
    for row in batch.rows("done"):
        found.setdefault(State(*(float(row.case.labels[name]) for name in COLUMNS)), []).append(row)
    return found


def moments(rows: list[Any], name: str) -> tuple[float, float, float]:
    """Mean, deviation and rate of passages of the mean of all runs of a state together."""
    kept = [row.statistics[name] for row in rows]
    mean = float(np.mean([one["mean"] for one in kept]))
    std = np.sqrt(np.mean([one["std"] ** 2 + (one["mean"] - mean) ** 2 for one in kept]))
    span = sum(row.simulated - row.case.discard for row in rows)
    return mean, float(std), sum(one["crossings"]["above"][0] for one in kept) / span


def moved(law: UpCrossings, old: Moments, new: Moments) -> UpCrossings:
    """The same tails over the mean, in deviations, of states with other moments."""
    unit = new.std / old.std
    with np.errstate(divide="ignore", invalid="ignore"):
        q = np.where(old.rate > 0, law.q * new.rate / old.rate, law.q)
    shifted = [new.mean + (np.asarray(x) - old.mean) * unit for x in (law.b, law.threshold)]
    return UpCrossings(q, law.a / unit**law.c, shifted[0], law.c, law.duration, shifted[1])


def compared(fits: Fits, one: dict[State, list[Any]], many: dict[State, list[Any]]) -> dict[State, np.ndarray]:
    """By state, median and 90 % fractile of the law of one run and of its tail with all moments, over those of Gumbel.

    Then the deviation of the one run over that of all.
    """
    states, law = fits.bins
    own = Moments(*np.array([moments(one[state], fits.response) for state in states]).T)
    again = [moments(many.get(state, one[state]), fits.response) for state in states]
    better, ratios = moved(law, own, Moments(*np.array(again).T)), {}
    for state, rows in many.items():
        i = list(states).index(state)
        gumbel = Gumbel.of_maxima([row.statistics[fits.response]["max"] for row in rows])
        expected = [float(gumbel.isf(q)) for q in (0.5, 0.1)]
        ratios[state] = np.array(
            [*(each.isf(q)[i] / x for each in (law, better) for q, x in zip((0.5, 0.1), expected, strict=True)),
             own.std[i] / again[i][1]]
        )  # fmt: skip
    return ratios


def smooth(fits: Fits, one: dict[State, list[Any]]) -> tuple[float, float]:
    """The value of FLTA, and that with moments that do not scatter from bin to bin.

    Mean and rate: of all bins at a wind speed. Deviation: s^2 = w(U)^2 + Hs^2 g(Tp)^2 by least squares, then the same
    mean square as the runs at each wind speed. Large deviations that a single run has by chance are gone.
    """
    states, law = fits.bins
    own = Moments(*np.array([moments(one[state], fits.response) for state in states]).T)
    speeds, periods = (np.unique(x, return_inverse=True) for x in (states.wind_speed, states.peak_period))
    parts = np.hstack([np.eye(speeds[0].size)[speeds[1]],
                       np.eye(periods[0].size)[periods[1]] * states.wave_height[:, None] ** 2])  # fmt: skip
    std = np.sqrt(parts @ nnls(parts / own.std[:, None] ** 2, np.ones(len(states)))[0])
    mean, rate = own.mean.copy(), own.rate.copy()
    for k in range(speeds[0].size):
        at = speeds[1] == k
        std[at] *= np.sqrt(np.mean((own.std[at] / std[at]) ** 2))
        mean[at], rate[at] = own.mean[at].mean(), own.rate[at].mean()
    return LongTerm(states, law).value(YEARS), LongTerm(states, moved(law, own, Moments(mean, std, rate))).value(YEARS)


def tables(bins: Batch, check: Batch, names: tuple[str, ...] = RESPONSES) -> dict[str, str]:
    """The ratios of all bins that were checked, and what they make of the values of FLTA."""
    one = runs_of(bins)
    many = {state: rows for state, rows in runs_of(check).items() if len(rows) > 1}
    fits = fits_of_batch(bins, names, "pooled")
    ratios = {name: compared(fits[name], one, many) for name in names}
    heads = ["wind [m/s]", "Hs [m]", "Tp [s]", "seeds"]
    heads += [f"{name}, {what}" for name in names for what in ("median", "90 %", "deviation")]
    rows = [[f"{x:g}" for x in (*state, len(many[state]))]
            + [f"{x:.2f}" for name in names for x in ratios[name][state][[0, 1, 4]]]
            for state in many]  # fmt: skip
    values = []
    for name in names:
        every = np.array(list(ratios[name].values()))
        single, flat = smooth(fits[name], one)
        spread = [f"{every[:, i].min():.2f} to {every[:, i].max():.2f}" for i in (1, 3)]
        values.append([f"{name} [{fits[name].unit}]", *spread, f"{single:.4g}", f"{flat:.4g}", f"{single / flat:.3f}"])
    told = ("response", "90 %, one run", "90 %, with all moments", "FLTA", "FLTA with smooth moments", "ratio")
    return {"bins": markdown((heads, rows)), "values": markdown((told, values))}


def main() -> None:
    """Choose bins, or fill the page from the folders that are named."""
    word, *folders = sys.argv[1:]
    batches = [Batch.open(folder) for folder in folders]
    if word == "choose":
        for state in choose(*batches):
            print(*state)
        return
    page = PAGE.read_text(encoding="utf-8")
    for name, text in tables(*batches).items():
        page = fill(page, name, text)
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
