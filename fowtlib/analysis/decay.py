"""Free decay: period and damping of one motion from its oscillation about rest, and the run that produces it.

Damping comes from the logarithmic decrement of successive ranges (crest to trough), which needs no rest position and is
exact for a linear oscillator. The dependence on amplitude is the line zeta(A) = zeta_0 + zeta_1 A through the half
cycles: for x'' + 2 zeta w x' + beta x' |x'| + w^2 x = 0, equal energy loss per cycle gives zeta_1 = 4 beta / (3 pi)
(Faltinsen 1990, Sea Loads on Ships and Offshore Structures, section 7, equivalent linearisation).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.plants import chosen_outputs, compiled, state_behind
from fowtlib.analysis.series import Series, as_series
from fowtlib.language.errors import ModelError
from fowtlib.solving.results.tables import write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fowtlib.analysis.series import SeriesLike
    from fowtlib.solving.results import Result

_EXTREMA_NEEDED = 4
_CROSSINGS_NEEDED = 5


@dataclass(frozen=True)
class Decay:
    """Outcome of a free decay. Amplitudes in the unit of the series, about ``rest``.

    period               mean damped period, s; period_std its scatter from cycle to cycle
    damping_ratio        overall, from the regression of the logarithm of all ranges
    amplitude, damping   damping ratio of every half cycle and the amplitude it belongs to
    damping_at_zero, damping_slope    the line damping = damping_at_zero + damping_slope * amplitude
    result               the whole run, when free_decay made it
    """

    series: Series
    rest: float
    period: float
    period_std: float
    damping_ratio: float
    extrema_time: np.ndarray
    extrema: np.ndarray
    amplitude: np.ndarray
    damping: np.ndarray
    damping_at_zero: float
    damping_slope: float
    result: Result | None = None

    def plot(self, path: str | Path | None = None) -> Figure:
        """The series with its fitted envelope, and damping over amplitude."""
        from fowtlib.solving.results.plots import plot_decay

        return plot_decay(self, path)

    def save(self, path: str | Path) -> Path:
        """Write amplitude and damping ratio of every half cycle as CSV."""
        heads = (f"amplitude [{self.series.unit}]", "damping ratio [1]")
        return write_table(path, heads, zip(self.amplitude.tolist(), self.damping.tolist(), strict=True), "a decay")

    @property
    def frequency(self) -> float:
        """Damped frequency, Hz."""
        return 1.0 / self.period

    @property
    def natural_frequency(self) -> float:
        """Undamped frequency, Hz."""
        return self.frequency / np.sqrt(1.0 - self.damping_ratio**2)

    @property
    def logarithmic_decrement(self) -> float:
        """Logarithm of the ratio of two crests one period apart."""
        return float(2.0 * np.pi * self.damping_ratio / np.sqrt(1.0 - self.damping_ratio**2))

    def envelope(self, time: np.ndarray) -> np.ndarray:
        """Amplitude over time [s] by the fitted damping line, from the first extremum on.

        Solves dA/dt = -w (zeta_0 + zeta_1 A) A with w the natural frequency in rad/s.
        """
        first = abs(self.extrema[0] - self.rest)
        turns = 2.0 * np.pi * self.natural_frequency * (np.asarray(time, dtype=float) - self.extrema_time[0])
        slope = self.damping_slope * first
        if abs(self.damping_at_zero) < 1e-9:
            return first / (1.0 + slope * turns)
        faded = np.exp(-self.damping_at_zero * turns)
        return first * faded / (1.0 + slope * (1.0 - faded) / self.damping_at_zero)

    def __repr__(self) -> str:
        return (
            f"<Decay of {self.series.name}: period {self.period:.4g} s, frequency {self.frequency:.4g} Hz, "
            f"damping ratio {100 * self.damping_ratio:.3g} % over {self.amplitude.size} half cycles>"
        )


def free_decay(
    model: Any,
    dof: str,
    offset: float,
    *,
    duration: float | None = None,
    output_step: float | None = None,
    parameters: Mapping[str, Any] | None = None,
    hold: Mapping[str, Any] | None = None,
    **simulate: Any,
) -> Decay:
    """Let one motion go from an offset at rest, and take period and damping from what follows.

    model        a compiled model, used as it is; or a model, which is first put into still water without wind
    dof          a result that follows one state, such as "surge" or "pitch"
    offset       from equilibrium, in the unit of that result (10 m, 10 deg); everything else starts at equilibrium
    duration     of the run, s; None takes eight periods of the linear mode in which the motion has the largest part
    output_step  s; None takes 1/200 of the period, at most 0.1 s
    hold         states that the equilibrium keeps at given values
    Further arguments go to ``plant.simulate``.
    """
    plant = compiled(model)
    chosen_outputs(plant, [dof])
    rest = plant.equilibrium(parameters=parameters, hold=hold)
    linear = plant.linearize(rest, outputs=[dof])
    state, slope = state_behind(plant, linear, dof)
    moved = {state: float(np.asarray(rest[state])) + offset / slope}
    start = plant.initial_state(parameters=parameters, start=moved, base=rest)
    period = _linear_period(linear, state)
    if duration is None:
        duration = 8.0 * period if period else 600.0
    if output_step is None:
        output_step = min(0.1, period / 200.0) if period else 0.1
    result = plant.simulate(duration, output_step=output_step, start=start, parameters=parameters, **simulate)
    return replace(analyse_decay(result[dof], rest=float(np.asarray(rest[dof]))), result=result)


def _linear_period(linear: Any, state: str) -> float:
    """Period [s] of the oscillating mode in which a state has its largest part; 0 when there is none."""
    modes = [mode for mode in linear.modes() if np.isfinite(mode.period) and mode.damping_ratio < 1.0]
    best = max(modes, key=lambda mode: mode.participation.get(state, 0.0), default=None)
    return best.period if best is not None and best.participation.get(state, 0.0) > 0.05 else 0.0


def analyse_decay(series: SeriesLike, *, rest: float | None = None, smallest: float = 0.02, name: str = "") -> Decay:
    """Period and damping ratio of a free decay.

    series    ``result["surge"]`` or (time, values)
    rest      position of rest; None finds it from three successive extrema (exact for a linear oscillator)
    smallest  half cycles below this fraction of the first range are left out (noise, other motions)
    """
    record = as_series(series, name)
    span = float(record.time[-1] - record.time[0])
    if np.ptp(record.values) <= 1e-12 * max(1.0, float(np.abs(record.values).max())):
        raise ModelError(f"free decay of {record.name}: nothing moves. Is the offset zero, or the motion locked?")
    middle = _middle(record.values) if rest is None else float(rest)
    for _ in range(6):
        crossings = _crossings(record, middle)
        when, extrema = _extrema(record, crossings, middle)
        if rest is not None or extrema.size < 3:
            break
        better = _rest_of(extrema)
        if abs(better - middle) < 1e-9 * np.ptp(record.values):
            break
        middle = better
    if extrema.size < _EXTREMA_NEEDED or crossings.size < _CROSSINGS_NEEDED:
        raise ModelError(
            f"free decay of {record.name}: in {span:g} s it passes its rest position {_rounded(middle, record)} "
            f"{crossings.size} times, {_CROSSINGS_NEEDED} are needed. Simulate longer; a motion that only creeps back "
            "is overdamped and has no period."
        )
    ranges = np.abs(np.diff(extrema))
    used = _leading(ranges >= smallest * ranges[0])
    used = max(used, _EXTREMA_NEEDED - 1)
    when, extrema, ranges = when[: used + 1], extrema[: used + 1], ranges[:used]
    last = np.searchsorted(crossings, when[-1])
    cycles = (crossings[2:] - crossings[:-2])[: max(last - 2, 1)]
    half_decrements = np.log(ranges[:-1] / ranges[1:])
    damping = _ratio(half_decrements)
    amplitude = np.abs(extrema[1:-1] - middle)
    overall = _ratio(-np.polyfit(np.arange(ranges.size), np.log(ranges), 1)[0])
    slope, at_zero = np.polyfit(amplitude, damping, 1) if _spread(amplitude) else (0.0, float(damping.mean()))
    return Decay(
        record,
        float(middle),
        float(cycles.mean()),
        float(cycles.std()),
        float(overall),
        when,
        extrema,
        amplitude,
        damping,
        float(at_zero),
        float(slope),
    )


def _rounded(rest: float, record: Series) -> str:
    """The rest position for a message, without rounding errors about zero."""
    rest = 0.0 if abs(rest) < 1e-6 * float(np.ptp(record.values)) else rest
    return f"{rest:.4g}" if record.unit in ("", "1") else f"{rest:.4g} {record.unit}"


def _ratio(half_decrement: np.ndarray | float) -> np.ndarray | float:
    """Damping ratio of the logarithm of two ranges half a period apart."""
    return half_decrement / np.sqrt(np.pi**2 + np.square(half_decrement))


def _spread(amplitude: np.ndarray) -> bool:
    return amplitude.size >= 3 and np.ptp(amplitude) > 0.05 * amplitude.max()


def _leading(flags: np.ndarray) -> int:
    """How many of the first flags are true."""
    return int(flags.size if flags.all() else np.argmin(flags))


def _middle(values: np.ndarray) -> float:
    """First guess of the rest position: the middle of the last third."""
    tail = values[-max(values.size // 3, 2) :]
    return 0.5 * float(tail.max() + tail.min())


def _rest_of(extrema: np.ndarray) -> float:
    """Rest position from successive extrema p: (p_i p_i+2 - p_i+1^2) / (p_i + p_i+2 - 2 p_i+1), the median."""
    a, b, c = extrema[:-2], extrema[1:-1], extrema[2:]
    return float(np.median((a * c - b**2) / (a + c - 2.0 * b)))


def _crossings(record: Series, rest: float) -> np.ndarray:
    """Times at which the series passes the rest position, by linear interpolation."""
    y, t = record.values - rest, record.time
    sign = np.where(y >= 0.0, 1, -1)
    i = np.flatnonzero(np.diff(sign))
    return t[i] - y[i] * (t[i + 1] - t[i]) / (y[i + 1] - y[i])


def _extrema(record: Series, crossings: np.ndarray, rest: float) -> tuple[np.ndarray, np.ndarray]:
    """Time and value of the largest departure between two crossings, by a parabola through three points.

    The start counts as an extremum when the series begins there without speed.
    """
    if crossings.size == 0:
        return np.zeros(0), np.zeros(0)
    t, y = record.time, record.values - rest
    edges = np.searchsorted(t, crossings)
    found = []
    first = edges[0]
    if first >= 3:
        peak = int(np.argmax(np.abs(y[:first])))
        if peak > 0:
            found.append(_vertex(t, y, peak))
        else:
            quarter = crossings[0] - t[0]
            speed = abs(np.polyfit(t[:3] - t[0], y[:3], 2)[1])
            if speed * quarter < 0.1 * abs(y[0]):
                found.append((t[0], y[0]))
    for begin, end in zip(edges[:-1], edges[1:], strict=True):
        if end - begin >= 3:
            found.append(_vertex(t, y, begin + int(np.argmax(np.abs(y[begin:end])))))
    times, values = np.array(found).reshape(-1, 2).T
    return times, values + rest


def _vertex(t: np.ndarray, y: np.ndarray, i: int) -> tuple[float, float]:
    """Vertex of the parabola through the points i - 1, i, i + 1."""
    a, b, c = np.polyfit(t[i - 1 : i + 2] - t[i], y[i - 1 : i + 2], 2)
    shift = 0.0 if a == 0.0 else float(np.clip(-0.5 * b / a, t[i - 1] - t[i], t[i + 1] - t[i]))
    return float(t[i] + shift), float(c + shift * (b + shift * a))
