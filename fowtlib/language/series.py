"""Series: signals of time as data, which a model finds by a number, its handle, when a run starts.

The equations of a model hold the call of one external function of (handle, time), the same for all series with as many
values; see series.c. What the series is made of is no part of the model, nor of its generated code.
"""

from __future__ import annotations

import hashlib
import math
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from fowtlib.language.errors import ParameterError
from fowtlib.language.externals import ExternalFunction, with_interface
from fowtlib.language.handed_numbers import kept_file, load, problem
from fowtlib.language.native import compiler
from fowtlib.language.tables import cardinal, cardinal_of_spectrum, cardinal_periodic

KINDS = ("constant", "cubic", "linear", "monotone", "harmonics", "transition")
MAGIC = float.fromhex("0x1.fee1badp+40")  # as in series.c
DIFFERENCES = 6  # of the numbers in a file, as in series.c
DIGITS = 42  # binary ones of the coefficients of a spline; an inverse Fourier transform leaves noise beyond them


@dataclass(frozen=True, eq=False)
class Series:
    """`size` signals of time [s]; made by one of the functions below, and never changed.

    covers: first and last time for which it has values, infinite where it goes on for ever; a run past them stops.
    breaks: instants at which a solver has to stop and start again, because a derivative jumps or a short event begins.
    """

    kind: str
    size: int
    rows: np.ndarray
    start: float = 0.0
    step: float = 1.0
    count: int = 0
    order: int = 0
    periodic: bool = False
    build_up: float = 0.0
    covers: tuple[float, float] = (-math.inf, math.inf)
    breaks: tuple[float, ...] = ()

    # --- how a series is made ------------------------------------------------------------------------------------

    @classmethod
    def constant(cls, values: ArrayLike) -> Series:
        """The same values (m,) at all times."""
        row = _finite(np.atleast_1d(np.asarray(values, dtype=float)))
        return cls("constant", len(row), row)

    @classmethod
    def samples(cls, values: ArrayLike, step: float, start: float = 0.0, *, periodic: bool = False,
                interpolation: str = "cubic", build_up: float = 0.0) -> Series:  # fmt: skip
        """Values (n,) or (n, m) at start, start + step, ...; a periodic series repeats itself after n steps.

        interpolation: "cubic", the spline with two continuous derivatives; "linear"; "monotone", the cubic of Fritsch
        and Carlson (1980), which stays between the samples. build_up: time [s] after t = 0 in which the signals grow
        from nothing, by 10 s^3 - 15 s^4 + 6 s^5.
        """
        table = _finite(np.asarray(values, dtype=float))
        table = table[:, None] if table.ndim == 1 else table
        least = {"cubic": 4, "linear": 2, "monotone": 3}
        if interpolation not in least:
            raise ParameterError(f"there is no interpolation '{interpolation}'; take cubic, linear or monotone.")
        n, m = table.shape
        if n < least[interpolation]:
            needs = f"{interpolation} interpolation needs {least[interpolation]} samples or more"
            raise ParameterError(f"{needs}, and {n} are given.")
        if not (math.isfinite(step) and step > 0 and math.isfinite(start)):
            raise ParameterError(
                f"samples every {step:g} s from {start:g} s on: the step must be above zero."
            )
        if interpolation == "cubic":
            rows = _rounded(cardinal_periodic(table) if periodic else cardinal(table))
        elif interpolation == "monotone":
            rows = np.stack([table, _slopes(table, step, periodic)], axis=1).reshape(-1, m)
        else:
            rows = table
        covers = (-math.inf, math.inf) if periodic else (start, start + step * (n - 1))
        count = n if interpolation == "monotone" else len(rows)
        timing = float(start), float(step)
        return cls(interpolation, m, rows.ravel(), *timing, count, 0, periodic, float(build_up), covers)

    @classmethod
    def fourier(cls, spectrum: ArrayLike, n: int, step: float, *, build_up: float = 0.0) -> Series:
        """The periodic series of n samples from t = 0 on with this discrete Fourier transform (m, n // 2 + 1).

        As `samples` of its inverse transform, which saves two transforms.
        """
        table = np.atleast_2d(np.asarray(spectrum, dtype=complex))
        if not (math.isfinite(step) and step > 0 and n >= 4):
            raise ParameterError(f"{n} samples every {step:g} s: four or more are needed, and a step above zero.")
        rows = _rounded(cardinal_of_spectrum(_finite(table), n))
        return cls("cubic", len(table), rows.ravel(), 0.0, float(step), len(rows), 0, True, float(build_up))

    @classmethod
    def harmonics(cls, omega: ArrayLike, amplitude: ArrayLike, phase: ArrayLike = 0.0, *,
                  build_up: float = 0.0) -> Series:  # fmt: skip
        """sum_k Re(a_kj exp(i (omega_k t + phase_kj))): omega (k,) [rad/s], amplitude (k, m), real or complex."""
        frequencies = _finite(np.atleast_1d(np.asarray(omega, dtype=float)))
        complex_amplitude = np.asarray(amplitude) * np.exp(1j * np.asarray(phase, dtype=float))
        table = complex_amplitude.reshape(len(frequencies), -1)
        rows = np.hstack([frequencies[:, None], table.real, table.imag])
        return cls("harmonics", table.shape[1], _finite(rows.ravel()), count=len(frequencies), build_up=float(build_up))

    @classmethod
    def transition(cls, start: float, duration: float, before: ArrayLike, after: ArrayLike, *,
                   polynomial: ArrayLike = (),
                   harmonics: Sequence[tuple[float, ArrayLike]] = ()) -> Series:  # fmt: skip
        """`before` (m,), then for `duration` [s] something else, then `after` (m,).

        With s from 0 to 1 in between, that is the sum of polynomial[i] s^i, rows of (m,), and of Re(a exp(i omega s))
        for harmonics (omega, a), a (m,) complex. A solver stops at the start and at the end;
        the signals should be continuous there.
        """
        if not (math.isfinite(duration) and duration > 0 and math.isfinite(start)):
            raise ParameterError(f"a transition of {duration:g} s from {start:g} s on cannot be.")
        first, last = (np.atleast_1d(np.asarray(row, dtype=float)) for row in (before, after))
        m = len(first)
        powers = np.asarray(polynomial, dtype=float).reshape(-1, m)
        waves = [np.broadcast_to(np.asarray(a), (m,)) for _, a in harmonics]
        parts = [np.concatenate([[w], a.real, a.imag]) for (w, _), a in zip(harmonics, waves, strict=True)]
        rows = _finite(np.concatenate([first, last, powers.ravel(), *parts]))
        breaks = (float(start), float(start + duration))
        return cls("transition", m, rows, float(start), float(duration), len(parts), len(powers), breaks=breaks)

    # --- numbers -------------------------------------------------------------------------------------------------

    @cached_property
    def block(self) -> np.ndarray:
        """All of it as numbers, which is what the C code reads."""
        head = [MAGIC, KINDS.index(self.kind), self.size, self.periodic, self.start, self.step, self.count, self.order,
                self.build_up]  # fmt: skip
        return np.concatenate([np.asarray(head, dtype=float), self.rows])

    @cached_property
    def handle(self) -> float:
        """The number by which a model finds it; it comes from the contents alone."""
        digest = hashlib.sha256(self.block.tobytes()).digest()
        return float(int.from_bytes(digest[:6], "little") or 1)  # 48 bits: exact in a double

    @property
    def steady(self) -> bool:
        """The same at all times."""
        return self.kind == "constant"

    @property
    def numbers(self) -> tuple[float, float, float]:
        """What a model gets: handle, first and last time that are covered."""
        return self.handle, *self.covers

    def __call__(self, t: ArrayLike) -> np.ndarray:
        """Values (m,) at a time [s], or (n, m) at n times."""
        times = np.asarray(t, dtype=float)
        values = self._evaluate(np.atleast_1d(times))[0]
        return values if times.ndim else values[0]

    def rate(self, t: ArrayLike) -> np.ndarray:
        """Time derivatives, as the values."""
        times = np.asarray(t, dtype=float)
        values = self._evaluate(np.atleast_1d(times))[1]
        return values if times.ndim else values[0]

    def _evaluate(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        bad = ~np.isfinite(t)
        inside = np.where(bad, 0.0, t)
        function = {"constant": self._constant, "harmonics": self._waves, "transition": self._between}
        values, rates = function.get(self.kind, self._sampled)(inside)
        if self.build_up > 0:
            p = np.clip(inside / self.build_up, 0, 1)[:, None]
            share, growth = p**3 * (10 + p * (6 * p - 15)), 30 * p**2 * (1 - p) ** 2 / self.build_up
            values, rates = share * values, share * rates + growth * values
        values[bad], rates[bad] = np.nan, np.nan
        return values, rates

    def _constant(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.tile(self.rows, (len(t), 1)), np.zeros((len(t), self.size))

    def _waves(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return _harmonics(self.rows.reshape(self.count, -1), t, 1.0)

    def _between(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        m, s = self.size, (t - self.start) / self.step
        before, after = self.rows[:m], self.rows[m : 2 * m]
        powers = self.rows[2 * m : (2 + self.order) * m].reshape(-1, m)
        p, i = np.clip(s, 0, 1)[:, None], np.arange(self.order)
        waves = self.rows[(2 + self.order) * m :].reshape(self.count, 1 + 2 * m)
        values, rates = _harmonics(waves, p[:, 0], 1 / self.step)
        values = values + p**i @ powers
        rates = rates + (i[1:] * p ** (i[1:] - 1)) @ powers[1:] / self.step
        outside = ((s <= 0) | (s >= 1))[:, None]
        return np.where(outside, np.where(s[:, None] <= 0, before, after), values), np.where(outside, 0.0, rates)

    def _sampled(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        table, wraps = self.rows.reshape(-1, self.size), self.periodic
        n = self.count - (3 if wraps else 2) if self.kind == "cubic" else self.count
        cells = n if wraps else n - 1
        place = (t - self.start) / self.step
        inside = np.mod(place, cells) if wraps else np.clip(place, 0, cells)
        per = np.where(wraps | (place == inside), 1 / self.step, 0.0)[:, None]
        low = np.minimum(np.floor(inside).astype(int), cells - 1)
        s = (inside - low)[:, None]
        r, after = 1 - s, (low + 1) % n if wraps else low + 1
        if self.kind == "cubic":
            weights = [r**3 / 6, (s * s * (3 * s - 6) + 4) / 6, (r * r * (3 * r - 6) + 4) / 6, s**3 / 6]
            slopes = [-r * r / 2, s * (1.5 * s - 2), r * (2 - 1.5 * r), s * s / 2]
            terms = [(table[low + k], w, d) for k, (w, d) in enumerate(zip(weights, slopes, strict=True))]
        elif self.kind == "linear":
            terms = [(table[low], r, -1.0), (table[after], s, 1.0)]
        else:
            h, bend = self.step, 6 * s * r
            terms = [
                (table[2 * low], r * r * (1 + 2 * s), -bend), (table[2 * after], s * s * (3 - 2 * s), bend),
                (table[2 * low + 1], h * s * r * r, h * r * (1 - 3 * s)),
                (table[2 * after + 1], -h * s * s * r, h * s * (3 * s - 2)),
            ]  # fmt: skip
        return sum(row * w for row, w, _ in terms), sum(row * d * per for row, _, d in terms)

    # --- made known to a function --------------------------------------------------------------------------------

    def open_in(self, function: ExternalFunction) -> Any:
        """Make it known to a function of `series_function`; it is forgotten when what is returned here is."""
        held = _Held(self, function)
        _known[self.handle] = self
        if function.library is None:
            return held
        held.finalizer = load(function, self.handle, self.block, held)
        return held

    def file_for(self, function: ExternalFunction) -> tuple[Path, tuple[float | int, ...]]:
        """A file with its numbers for `<name>_open(handle, path)` of the function's library, and further arguments."""
        return kept_file(f"series_{int(self.handle):012x}", "packed", self._packed()), ()

    def _packed(self) -> bytes:
        """The numbers of a file, so that they compress well: see `unpack` in series.c."""
        columns = self.size if self.kind in ("constant", "cubic", "linear", "monotone") else 1
        table = self.rows.reshape(-1, columns)
        scale = _grain(table)
        with np.errstate(over="ignore", invalid="ignore"):
            whole = np.where(np.rint(table / scale) * scale == table, 1, 0).all(axis=0)
        scale = np.where(whole & (table != 0).any(axis=0), scale, 0.0)
        bits = np.where(scale > 0, table / np.where(scale > 0, scale, 1.0), 0.0).astype(np.int64)
        bits = np.where(scale > 0, bits, table.view(np.int64))
        for _ in range(DIFFERENCES):
            bits = np.diff(bits, axis=0, prepend=np.zeros((1, columns), np.int64))
        planes = np.ascontiguousarray(bits.T.astype("<i8")).view(np.uint8).reshape(-1, 8).T.tobytes()
        return np.concatenate([self.block[: len(self.block) - len(self.rows)], scale]).astype("<f8").tobytes() + planes


class _Held:
    """Keeps a series known."""

    def __init__(self, series: Series, function: ExternalFunction):
        self.series, self.function = series, function
        self.finalizer: Any = None


_known: weakref.WeakValueDictionary[float, Series] = weakref.WeakValueDictionary()  # for NumPy, by handle


@lru_cache(maxsize=256)
def series_function(size: int) -> ExternalFunction:
    """The external function of handle and time [s] for all series of so many values."""
    return _function(size, compiler())


@lru_cache(maxsize=256)
def _function(size: int, command: tuple[str, ...]) -> ExternalFunction:
    name = f"series_{size}"
    text = (Path(__file__).parent / "series.c").read_text(encoding="utf-8")

    def evaluate(column: np.ndarray) -> np.ndarray:
        return _of(column[0], size)(column[1])

    def slope(column: np.ndarray) -> np.ndarray:
        return np.column_stack([np.zeros(size), _of(column[0], size).rate(column[1])])

    def explain() -> str:
        return problem(function) if function.library else ""

    pattern = ca.Sparsity(size, 2, [0, 0, size], list(range(size)))
    function = ExternalFunction(
        name, {"handle": 1, "time": 1}, {"values": size}, source=with_interface(name, pattern, text), beside=True,
        python=evaluate, jacobian=slope, sparsity=pattern, explain=explain,
    )  # fmt: skip
    return function


def _of(handle: float, size: int) -> Series:
    if not handle:
        return Series.constant(np.zeros(size))
    if handle not in _known:
        raise RuntimeError("a time series is used that was not opened in this process; compile the model again.")
    return _known[handle]


def _harmonics(rows: np.ndarray, t: np.ndarray, per: float) -> tuple[np.ndarray, np.ndarray]:
    """Of rows (omega, real parts, imaginary parts) at t, and their rates where dt is `per` of a second."""
    omega, parts = rows[:, 0], rows[:, 1:]
    m = parts.shape[1] // 2
    c, s = np.cos(np.outer(t, omega)), np.sin(np.outer(t, omega))
    values = c @ parts[:, :m] - s @ parts[:, m:]
    return values, -per * ((s * omega) @ parts[:, :m] + (c * omega) @ parts[:, m:])


def _slopes(table: np.ndarray, step: float, periodic: bool) -> np.ndarray:
    """Slopes [1/s] of the monotone cubic at the samples."""
    from scipy.interpolate import PchipInterpolator

    n = len(table)
    if periodic:
        table = np.concatenate([table[-2:], table, table[:2]])
    slope = PchipInterpolator(step * np.arange(len(table)), table, axis=0).derivative()(step * np.arange(len(table)))
    return slope[2 : n + 2] if periodic else slope


def _grain(table: np.ndarray) -> np.ndarray:
    """Of each column the power of two of which rounded numbers are whole multiples, DIGITS below its largest one."""
    largest = np.maximum(np.maximum(table.max(axis=0), -table.min(axis=0)), 1e-200)
    return np.ldexp(1.0, np.frexp(largest)[1] - DIGITS)


def _rounded(table: np.ndarray) -> np.ndarray:
    """Whole multiples of the grain of each column, within 2e-13 of its largest number: they make small files."""
    grain = _grain(table)
    rounded = table / grain
    np.rint(rounded, out=rounded)
    rounded *= grain
    return rounded


def _finite(array: np.ndarray) -> np.ndarray:
    if not np.all(np.isfinite(array)):
        raise ParameterError("the values of a time series must be finite numbers.")
    return array
