"""Reader of the WAMIT output files .1 (radiation), .3 (excitation) and .hst (hydrostatics).

WAMIT writes numbers without dimension. With the length scale L (ULEN of the WAMIT run, OpenFAST: WAMITULEN), the water
density rho and gravity g:

=====  ==========================  =======================================================================
file   line                        quantity with dimension
=====  ==========================  =======================================================================
.1     PER I J A [B]               A rho L^k, B rho L^k omega; k = 3 + (rotations among the modes I and J)
.3     PER BETA I MOD PHA RE IM    X rho g L^m per unit wave amplitude; m = 2, for rotations 3
.hst   I J C                       C rho g L^(2 + rotations among the modes I and J)
=====  ==========================  =======================================================================

PER is the period in seconds (IPEROUT = 1, the default of WAMIT). In .1 a negative PER means the limit of zero frequency
(infinite period) and PER = 0 the limit of infinite frequency; these lines carry A only. BETA is the direction in
degrees in which the waves travel (0: along +x). X goes with exp(+i omega t) and an incident wave of zero phase at the
origin of the body axes: load = Re(a X exp(i omega t)) for the elevation a cos(omega t) at the origin. Modes: 1 surge,
2 sway, 3 heave, 4 roll, 5 pitch, 6 yaw, about the origin of the body axes, which this library takes on the still water
level.

The matrix of .hst contains buoyancy and waterplane terms only if the WAMIT run had no mass (as the files that OpenFAST
uses); the weight belongs to the rigid bodies here.

A heading in the first line (NUMHDR = 1) and a byte order mark are skipped.

Pairs (I, J) that WAMIT leaves out by symmetry are zero, but a pair must be there for every period or for none. All
results are in SI units, in the order of rising omega [rad/s] and heading [rad].

Source: WAMIT User Manual, version 7, sections 4.2, 4.3, 4.9 (output of forces, optional numeric output files).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.fortran_numbers import number_of, wrong
from fowtlib.language.data_files import is_number, text_of

_MODES = range(1, 7)
_PHASE_MISMATCH = 2e-3  # RE, IM against MOD, PHA, relative to MOD: a file with columns in another order is far above
_NOISE = 1e-9  # loads below this part of the largest one are zero but for rounding; their phase means nothing


@dataclass(frozen=True, eq=False)
class Radiation:
    """Added mass A and radiation damping B (n, 6, 6) at omega (n), and the limits of A (6, 6) if the file has them."""

    omega: np.ndarray
    A: np.ndarray
    B: np.ndarray
    A_zero: np.ndarray | None
    A_inf: np.ndarray | None


@dataclass(frozen=True, eq=False)
class Excitation:
    """Complex wave load X (n, nh, 6) per unit amplitude at omega (n) [rad/s] and heading (nh) [rad]."""

    omega: np.ndarray
    heading: np.ndarray
    X: np.ndarray


def read_radiation(path: str | Path, *, rho: float, length: float = 1.0) -> Radiation:
    """Read a .1 file: added mass [kg, kg m, kg m^2] and damping [N s/m, N s, N m s] about the origin.

    Raises HydrodynamicDataError, with file and line, for anything that is not a complete and consistent table.
    """
    path = Path(path)
    zero: dict[tuple[int, int], float] = {}
    infinite: dict[tuple[int, int], float] = {}
    finite: dict[float, dict[tuple[int, int], tuple[float, float]]] = {}
    for line, words in _lines(path):
        limit = number_of(path, line, words[0]) <= 0
        expected = (4, 5) if limit else (5,)
        if len(words) not in expected:
            what = "PER I J A" if limit else "PER I J A B"
            raise wrong(path, line, f"expected '{what}', found {len(words)} columns")
        period = number_of(path, line, words[0])
        pair = _mode(path, line, words[1]), _mode(path, line, words[2])
        values = [number_of(path, line, word) for word in words[3:]]
        table = zero if period < 0 else infinite if period == 0 else finite.setdefault(period, {})
        if pair in table:
            raise wrong(path, line, f"the pair {_pair(pair)} is given twice for the period {period:g} s")
        table[pair] = values[0] if limit else (values[0], values[1])
    if not finite:
        raise wrong(path, None, "no line with a positive period: there is no radiation damping in this file")
    periods = sorted(finite, reverse=True)
    _check_pairs(path, {f"the period {p:g} s": set(finite[p]) for p in periods}
                 | ({"zero frequency (PER < 0)": set(zero)} if zero else {})
                 | ({"infinite frequency (PER = 0)": set(infinite)} if infinite else {}))
    omega = np.array([2 * math.pi / period for period in periods])
    A = np.stack([_matrix({pair: v[0] for pair, v in finite[p].items()}) for p in periods])
    B = np.stack([_matrix({pair: v[1] for pair, v in finite[p].items()}) for p in periods])
    scale = rho * length ** (3 + _rotations())
    return Radiation(
        omega=omega,
        A=A * scale,
        B=B * scale * omega[:, None, None],
        A_zero=_matrix(zero) * scale if zero else None,
        A_inf=_matrix(infinite) * scale if infinite else None,
    )


def read_excitation(path: str | Path, *, rho: float, g: float, length: float = 1.0) -> Excitation:
    """Read a .3 file: complex wave load per unit amplitude [N/m, N m/m] about the origin.

    Raises HydrodynamicDataError, with file and line, for anything that is not a complete and consistent table.
    """
    path = Path(path)
    table: dict[tuple[float, float, int], complex] = {}
    suspicious: list[tuple[float, int, list[str]]] = []
    for line, words in _lines(path):
        if len(words) != 7:
            raise wrong(path, line, f"expected 'PER BETA I MOD PHA RE IM', found {len(words)} columns")
        period, beta, modulus, phase, real, imaginary = (
            number_of(path, line, words[i]) for i in (0, 1, 3, 4, 5, 6)
        )
        if period <= 0:
            raise wrong(path, line, f"the period must be positive, found {words[0]}")
        key = period, beta, _mode(path, line, words[2])
        if key in table:
            raise wrong(path, line, f"mode {key[2]} is given twice for the period {period:g} s, heading {beta:g} deg")
        table[key] = complex(real, imaginary)
        polar = modulus * complex(math.cos(math.radians(phase)), math.sin(math.radians(phase)))
        mismatch = abs(polar - table[key])
        if mismatch > _PHASE_MISMATCH * abs(modulus):
            suspicious.append((mismatch, line, words))
    if not table:
        raise wrong(path, None, "the file is empty")
    largest = max(abs(value) for value in table.values())
    for mismatch, line, words in suspicious:
        if mismatch > _NOISE * largest:
            raise wrong(path, line, f"modulus and phase ({words[3]}, {words[4]}) contradict the real and imaginary "
                                    f"part ({words[5]}, {words[6]}): are the columns in the order of WAMIT?")
    periods = sorted({key[0] for key in table}, reverse=True)
    headings = sorted({key[1] for key in table})
    modes = sorted({key[2] for key in table})
    X = np.zeros((len(periods), len(headings), 6), dtype=complex)
    for i, period in enumerate(periods):
        for j, beta in enumerate(headings):
            for mode in modes:
                if (period, beta, mode) not in table:
                    raise wrong(path, None, f"mode {mode} is missing for the period {period:g} s, "
                                             f"heading {beta:g} deg, but present elsewhere in the file")
                X[i, j, mode - 1] = table[period, beta, mode]
    X *= rho * g * length ** np.array([2.0, 2.0, 2.0, 3.0, 3.0, 3.0])
    return Excitation(np.array([2 * math.pi / p for p in periods]), np.radians(headings), X)


def read_hydrostatics(path: str | Path, *, rho: float, g: float, length: float = 1.0) -> np.ndarray:
    """Read a .hst file: hydrostatic stiffness (6, 6) [N/m, N, N m] about the origin; all 36 lines are required.

    Raises HydrodynamicDataError, with file and line.
    """
    path = Path(path)
    table: dict[tuple[int, int], float] = {}
    for line, words in _lines(path):
        if len(words) != 3:
            raise wrong(path, line, f"expected 'I J C', found {len(words)} columns")
        pair = _mode(path, line, words[0]), _mode(path, line, words[1])
        if pair in table:
            raise wrong(path, line, f"the pair {_pair(pair)} is given twice")
        table[pair] = number_of(path, line, words[2])
    missing = [(i, j) for i in _MODES for j in _MODES if (i, j) not in table]
    if missing:
        raise wrong(path, None, f"{len(missing)} of the 36 pairs are missing, the first is {_pair(missing[0])}")
    return _matrix(table) * rho * g * length ** (2 + _rotations())


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    text = text_of(path, "the WAMIT file", HydrodynamicDataError)
    for number, line in enumerate(text.split("\n"), start=1):
        words = line.split()
        if words and not (number == 1 and _header(words)):
            yield number, words


def _header(words: list[str]) -> bool:
    """Whether a first line is a heading (NUMHDR = 1 of WAMIT): half of its words or more are no numbers."""
    return sum(is_number(word.replace("D", "E").replace("d", "e")) for word in words) <= len(words) / 2


def _mode(path: Path, line: int, word: str) -> int:
    value = number_of(path, line, word)
    if value not in _MODES:
        raise wrong(path, line, f"'{word}' is not a mode: one rigid body has the modes 1 to 6 (surge to yaw)")
    return int(value)


def _check_pairs(path: Path, groups: dict[str, set[tuple[int, int]]]) -> None:
    every = set().union(*groups.values())
    for name, pairs in groups.items():
        if missing := sorted(every - pairs):
            raise wrong(path, None, f"the pair {_pair(missing[0])} is missing for {name}, but present elsewhere "
                                     "in the file")


def _matrix(table: dict[tuple[int, int], float]) -> np.ndarray:
    matrix = np.zeros((6, 6))
    for (i, j), value in table.items():
        matrix[i - 1, j - 1] = value
    return matrix


def _rotations() -> np.ndarray:
    rotation = np.array([0, 0, 0, 1, 1, 1])
    return (rotation[:, None] + rotation[None, :]).astype(float)


def _pair(pair: tuple[int, int]) -> str:
    return f"({pair[0]}, {pair[1]})"
