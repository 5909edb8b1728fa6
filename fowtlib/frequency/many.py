"""Responses in many states of wind and sea, with their probabilities: what a life is made of.

One state after the other, so that the mean of the last one is near that of the next; sorted by the caller, best by wind
speed. A state that has no response leaves the others as they are; a Ctrl-C ends the list, and what was found is kept.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.fatigue import SNCurve, lifetime_damage, lifetime_equivalent_load
from fowtlib.analysis.fatigue.lifetime import YEAR
from fowtlib.analysis.plants import plant_of
from fowtlib.frequency.corners import CornerWarning, warn_of_states
from fowtlib.frequency.found import Response
from fowtlib.frequency.responses import response
from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_whole
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    import xarray

    from fowtlib.analysis.fatigue import TubeSection

PROBABILITY = "probability"

States = Sequence[Mapping[str, Any]] | Mapping[str, Sequence[Any]] | Any


@dataclass(frozen=True, eq=False)
class Responses:
    """Responses in states, each with its parameters and its probability; None where a state has none.

    failures: why, by the number of the state (from 0). complete: False where the list was stopped before its end.
    Weighted results need all states, or `missing`, the largest share of the probability that may lack; a mean is then
    one of the others, and in a sum over a life it is time without a load.
    """

    states: tuple[Mapping[str, Any], ...]
    probability: np.ndarray
    found: tuple[Response | None, ...]
    failures: Mapping[int, str] = field(default_factory=dict)
    complete: bool = True

    def __len__(self) -> int:
        return len(self.states)

    def __getitem__(self, number: int) -> Response:
        """The response in a state."""
        one = self.found[number]
        if one is None:
            why = self.failures.get(number, "the list was stopped before it")
            raise ModelError(f"state {number + 1} ({words(self.states[number])}) has no response: {why}")
        return one

    def __iter__(self) -> Iterator[Response | None]:
        return iter(self.found)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the results."""
        return self._first.outputs

    def unit(self, name: str) -> str:
        """Unit of a result."""
        return self._first.unit(name)

    @property
    def _first(self) -> Response:
        one = next((one for one in self.found if one is not None), None)
        if one is None:
            raise ModelError("there is no response in any state." + self._why())
        return one

    def of_each(self, number: Callable[[Response], float]) -> np.ndarray:
        """A number of the response in each state (n,), nan where there is none."""
        return np.array([np.nan if one is None else number(one) for one in self.found], dtype=float)

    def mean(self, name: str) -> np.ndarray:
        """Mean of a result in each state (n,)."""
        return self.of_each(lambda one: one.mean_of(name))

    def std(self, name: str, process: str | None = None) -> np.ndarray:
        """Standard deviation of a result in each state (n,)."""
        return self.of_each(lambda one: one.std(name, process))

    def weighted(self, number: Callable[[Response], float], missing: float = 0.0) -> float:
        """Mean of a number over the states, by their probabilities: sum p_i y_i / sum p_i."""
        values, shares = self._weights(self.of_each(number), missing)
        return float(shares @ values / shares.sum())

    def weighted_std(self, name: str, missing: float = 0.0) -> float:
        """Mean of the standard deviation of a result over the states, by their probabilities."""
        return self.weighted(lambda one: one.std(name), missing)

    def weighted_duty_cycle(self, name: str, limit: float | str, missing: float = 0.0) -> float:
        """Mean of `Response.duty_cycle` over the states, by their probabilities."""
        return self.weighted(lambda one: one.duty_cycle(name, limit), missing)

    def damage(self, name: str, curve: SNCurve, section: TubeSection | None = None, *, lifetime: float = 20 * YEAR,
               design_fatigue_factor: float = 1.0, missing: float = 0.0, **options: Any) -> float:  # fmt: skip
        """Miner's sum of a life [s], sum p_i D_i lifetime / T, times the design fatigue factor.

        Time in no state, a rest of the probabilities to 1, counts as time without damage. section: of a tube, where
        the result is its bending moment. options: of `Response.damage`.
        """
        shares = self._shares()
        each = self.of_each(lambda one: one.damage(name, curve, section, duration=3600.0, **options))
        values, shares = self._weights(each, missing, shares)
        total = lifetime_damage(values, 3600.0, shares, lifetime=lifetime, design_fatigue_factor=design_fatigue_factor)
        return float(total)

    def tube_damage(self, section: TubeSection, curve: SNCurve, moment_x: str, moment_y: str,
                    axial_force: str | None = None, *, points: int = 24, lifetime: float = 20 * YEAR,
                    design_fatigue_factor: float = 1.0, missing: float = 0.0) -> np.ndarray:  # fmt: skip
        """Miner's sum of a life [s] at points around a tube (points,); see `Response.tube_damage`."""
        shares = self._shares()
        each = np.array([np.full(points, np.nan) if one is None else
                         one.tube_damage(section, curve, moment_x, moment_y, axial_force, points=points).damage
                         for one in self.found])  # fmt: skip
        values, shares = self._weights(each, missing, shares)
        total = lifetime_damage(values, 3600.0, shares, lifetime=lifetime, design_fatigue_factor=design_fatigue_factor)
        return np.asarray(total)

    def equivalent_load(self, name: str, exponent: float = 4.0, frequency: float = 1.0, *,
                        lifetime: float | None = None, equivalent_cycles: float | None = None, missing: float = 0.0,
                        **options: Any) -> float:  # fmt: skip
        """Damage-equivalent range of a life: of `frequency` [Hz] cycles, or of so many cycles in a lifetime [s]."""
        shares = self._shares()
        each = self.of_each(lambda one: one.equivalent_load(name, exponent, frequency, **options))
        values, shares = self._weights(each, missing, shares)
        return float(lifetime_equivalent_load(values, exponent, shares, frequency=frequency, lifetime=lifetime,
                                              equivalent_cycles=equivalent_cycles))  # fmt: skip

    def extreme(self, name: str, duration: float = 3600.0, quantile: float = 0.5,
                side: str = "max") -> tuple[float, int]:  # fmt: skip
        """The most extreme of the extremes of the states, see `Response.extreme`, and the number of its state."""
        values = self.of_each(lambda one: one.extreme(name, duration, quantile, side))
        if np.isnan(values).all():
            self._first  # noqa: B018 (says why there is none)
        worst = int(np.nanargmax(values) if side == "max" else np.nanargmin(values))
        return float(values[worst]), worst

    def long_term_extreme(self, name: str, years: float = 50.0, side: str = "max", missing: float = 0.0) -> float:
        """The level that is crossed once in so many years on average, of all states together.

        sum p_i nu_i exp(-(y - mu_i)^2 / (2 s_i^2)) years = 1, with the rates nu of up-crossings of the means (Rice).
        """
        from scipy.optimize import brentq

        sign = {"max": 1.0, "min": -1.0}.get(side)
        if sign is None or not years > 0:
            raise ModelError(f"a side 'max' or 'min' and a time above 0 years; not '{side}' and {years:g}.")
        rows = [(one.mean_of(name), one.std(name), one.spectrum(name).up_crossing_rate if one.std(name) > 0 else 0.0)
                if one is not None else (np.nan,) * 3 for one in self.found]  # fmt: skip
        rows, shares = self._weights(np.array(rows), missing, self._shares())
        moving = rows[:, 1] > 0
        mean, std, rate = rows[moving].T if moving.any() else np.zeros((3, 0))
        count = shares[moving] * rate * years * YEAR
        if not count.sum() > 1:
            raise ModelError(f"{name}: in {years:g} years these states have less than one up-crossing of the mean.")

        def excess(y: float) -> float:
            above = np.maximum(sign * (y - mean), 0.0)  # below the mean it is crossed as often as the mean
            return float(np.log(count @ np.exp(-0.5 * (above / std) ** 2)))

        low, high = float(np.min(sign * mean)), float(np.max(sign * mean + std * np.sqrt(2 * np.log(count.sum() + 1))))
        return sign * float(brentq(lambda y: excess(sign * y), low - 1e-9, high + 1e-9))

    def _shares(self) -> np.ndarray:
        """Probabilities that a life can be made of."""
        if self.probability.sum() > 1 + 1e-6:
            raise ModelError(
                f"the probabilities of the states have the sum {self.probability.sum():.6g}; of a life they have 1 at "
                "most. Divide them by their sum if the states stand for all of it."
            )
        return self.probability

    def _weights(self, values: np.ndarray, missing: float,
                 shares: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Values and probabilities of the states that have a response."""
        shares = self.probability if shares is None else shares
        there = np.array([one is not None for one in self.found])
        lost = float(shares[~there].sum() / shares.sum())
        if lost > missing + 1e-12:
            raise ModelError(
                f"{100 * lost:.3g} % of the states by probability have no response.{self._why()} Say missing="
                f"{lost:.2g} to go on without them."
            )
        return values[there], shares[there]

    def _why(self) -> str:
        number = next(iter(self.failures), None)
        if number is None:
            return "" if self.complete else " The list was stopped before its end."
        others = f", and {len(self.failures) - 1} more" if len(self.failures) > 1 else ""
        return f" State {number + 1} ({words(self.states[number])}{others}): {self.failures[number]}"

    # --- tables -------------------------------------------------------------------------------------------------------

    @property
    def dataset(self) -> xarray.Dataset:
        """Mean and deviation of each result over the coordinate ``state``, with the parameters of the states."""
        import xarray

        columns: dict[str, Any] = {PROBABILITY: ("state", self.probability)}
        for path in self._paths():
            values = [state.get(path, np.nan) for state in self.states]
            columns[path] = ("state", np.array(values, dtype=float if all(map(_is_number, values)) else object))
        for name in self.outputs:
            attrs = {"units": self.unit(name)}
            columns[f"mean of {name}"] = ("state", self.mean(name), attrs)
            columns[f"std of {name}"] = ("state", self.std(name), attrs)
        return xarray.Dataset(columns, {"state": np.arange(1, len(self) + 1)})

    def save(self, path: str | Path) -> Path:
        """Write a row for each state: its parameters, and mean and deviation of each result; .csv or netCDF (.nc)."""
        path = Path(path)
        if path.suffix == ".nc":
            return write_whole(path, lambda temporary: temporary.write_bytes(self.dataset.to_netcdf(engine="scipy")))
        paths = self._paths()
        heads = ["state", *paths, PROBABILITY]
        heads += [f"{what} of {name} [{self.unit(name)}]" for name in self.outputs for what in ("mean", "std")]
        rows: list[list[Any]] = []
        columns = [values for name in self.outputs for values in (self.mean(name), self.std(name))]
        for k, state in enumerate(self.states):
            numbers = [float(values[k]) if self.found[k] is not None else "" for values in columns]
            rows.append([k + 1, *(state.get(p, "") for p in paths), float(self.probability[k]), *numbers])
        return write_table(path, heads, rows, "responses in states")

    def _paths(self) -> list[str]:
        return list(dict.fromkeys(path for state in self.states for path in state))

    def __repr__(self) -> str:
        done = sum(one is not None for one in self.found)
        return f"<Responses: {done} of {len(self)} states, probability {self.probability.sum():.4g}>"


def responses(
    model: Any,
    states: States,
    *,
    outputs: Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    probability: Sequence[float] | np.ndarray | None = None,
    frequencies: Sequence[float] | np.ndarray | None = None,
    tolerance: float = 1e-4,
    progress: Callable[[int, int], None] | bool = False,
    keep_transfer: bool = False,
) -> Responses:
    """The responses of a model, or of a compiled one, in many states.

    states       parameters of each state: a list of mappings by path; or a mapping of lists; one of which may be called
                 "probability" in both; or states of fowtlib.metocean, which hold their probabilities
    outputs      results; None: all. What is not asked for is not kept
    parameters   of all states, as for `response`; those of a state count more
    probability  of each state; None: those of the states, else all alike
    frequencies, tolerance  as for `response`
    keep_transfer  the transfer functions of each state too, for sums of results as in `tube_damage`
    progress     True: a line a second on stderr; or `progress(done, total)`
    Raises ModelError for what is wrong in all states, such as an output that there is not. A state that has no response
    (no mean, unstable) is told by `failures`, with a warning.
    """
    plant = plant_of(model)
    rows, shares = _rows(states, probability)
    told = progress if callable(progress) else _teller() if progress else lambda done, total: None
    dropped: dict[str, Any] = {} if keep_transfer else {"transfer": {}, "driving": {}}  # they would fill the memory
    found: list[Response | None] = []
    failures: dict[int, str] = {}
    complete = True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CornerWarning)  # those of all states are told together
        try:
            for number, row in enumerate(rows):
                told(number, len(rows))
                try:
                    one = response(plant, outputs=outputs, parameters={**(parameters or {}), **row},
                                   frequencies=frequencies, tolerance=tolerance)  # fmt: skip
                    found.append(replace(one, linear=None, state=None, **dropped))
                except ModelError as error:
                    if number == 0 and not _of_a_state(error):
                        raise
                    failures[number] = str(error)
                    found.append(None)
                    warnings.warn(f"state {number + 1} ({words(row)}) has no response: {error}", stacklevel=2)
            told(len(rows), len(rows))
        except KeyboardInterrupt:
            if all(one is None for one in found):
                raise
            complete = False
            warnings.warn(f"stopped after {len(found)} of {len(rows)} states; what was found is kept.", stacklevel=2)
    warn_of_states({k: one.corners for k, one in enumerate(found) if one is not None}, len(found))
    found += [None] * (len(rows) - len(found))
    return Responses(tuple(rows), shares, tuple(found), failures, complete)


def _of_a_state(error: ModelError) -> bool:
    """Whether an error may be that of one state alone: where numbers do not settle, or a model is unstable."""
    from fowtlib.language.errors import SimulationError

    return isinstance(error, SimulationError)


def _rows(states: States, probability: Sequence[float] | np.ndarray | None) -> tuple[list[dict[str, Any]], np.ndarray]:
    """Parameters of each state, and the probabilities."""
    if hasattr(states, "run_parameters"):
        probability = states.probability if probability is None else probability
        rows = states.run_parameters()
    elif isinstance(states, Mapping):
        columns = {path: list(values) for path, values in states.items()}
        if len({len(values) for values in columns.values()}) != 1:
            sizes = ", ".join(f"{path}: {len(values)}" for path, values in columns.items())
            raise ModelError(f"the states have columns of different lengths: {sizes or 'none'}.")
        own = columns.pop(PROBABILITY, None)
        probability = own if probability is None else probability
        count = len(own) if own is not None else len(next(iter(columns.values())))
        rows = [{path: values[k] for path, values in columns.items()} for k in range(count)]
    else:
        known = isinstance(states, Iterable) and not isinstance(states, str)
        if not known or not all(isinstance(row, Mapping) for row in states):
            raise ModelError("states are mappings of parameters, such as {'wind.mean_speed': 12.0}, columns of a "
                             f"table, or states of a site; not {states!r}.")  # fmt: skip
        rows = [dict(row) for row in states]
        if rows and all(PROBABILITY in row for row in rows):
            own = [row.pop(PROBABILITY) for row in rows]
            probability = own if probability is None else probability
    if not rows:
        raise ModelError("there are no states.")
    shares = np.full(len(rows), 1 / len(rows)) if probability is None else np.asarray(probability, dtype=float)
    if shares.shape != (len(rows),):
        raise ModelError(f"there are {len(rows)} states and {shares.size} probabilities; give one of each state.")
    wrong = np.flatnonzero(~(np.isfinite(shares) & (shares >= 0)))
    if wrong.size:
        k = int(wrong[0])
        raise ModelError(f"state {k + 1} has the probability {shares[k]:g}; a probability is 0 or more.")
    if not shares.sum() > 0:
        raise ModelError("the probabilities of all states are 0; give at least one above it.")
    return [{path: _plain(value) for path, value in row.items()} for row in rows], shares


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def words(state: Mapping[str, Any]) -> str:
    """A state in a message."""
    return ", ".join(f"{path.rpartition('.')[2]} {v:g}" if _is_number(v) else f"{path.rpartition('.')[2]} {v}"
                     for path, v in state.items())  # fmt: skip


def _teller() -> Callable[[int, int], None]:
    import sys
    import time

    began = time.monotonic()
    last = [began]

    def tell(done: int, total: int) -> None:
        now = time.monotonic()
        if now - last[0] > 1.0 or (done == total and last[0] > began):
            last[0] = now
            print(f"{done} of {total} states", file=sys.stderr, flush=True)

    return tell
