"""Responses of what turns with a rotor, from those of the frame that does not turn.

A load of one blade is y_0 + y_c cos(psi) + y_s sin(psi), psi = Omega t, with y_0, y_c and y_s of the linear model in
multi-blade coordinates. With w = (y_c - i y_s) / 2 its two-sided spectrum, averaged over the azimuths of the start, is

    S(omega) = S_0(omega) + S_w(omega - Omega) + S_w(-omega - Omega),

what the tower feels at omega being in a blade at the sum and the difference with the rotor speed. What goes round in
steady wind, by gravity, shear, tilt and the dam of the tower, is no random process: it stands beside the others as the
share `rotation`, with its mean square about each multiple of the rotor speed. Since the speed itself is random, these
are no lines but bands, and modes answer to each part of them (frequency.lines). The forces are those at the mean speed.
A rotor that idles lingers at some azimuths (frequency.lingering): then harmonics go together, and means are others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fowtlib.analysis.spectra import mean_square_below
from fowtlib.frequency.driven import frequency_widths
from fowtlib.frequency.found import Response
from fowtlib.frequency.lines import RandomSpeed
from fowtlib.frequency.lingering import Lingering
from fowtlib.solving.excited import ExcitedModel
from fowtlib.solving.linear import LinearModel
from fowtlib.solving.mean_linear import RotatingLinearModel, Turning
from fowtlib.solving.rates import rate_states
from fowtlib.solving.rotation import HARMONICS, Driven, Rotation

ROTATION = "rotation"
LEAST = 1e-12  # of the largest mean square of a result in a part of the axis


@dataclass(frozen=True, eq=False)
class Turned:
    """How rotors turn in a state: the linear model with its drag, densities (q,) of the speeds [(rad/s)^2/Hz].

    by_states: the speeds [rad/s] by the states (rotors, states).
    """

    linear: LinearModel
    speeds: Sequence[np.ndarray]
    by_states: np.ndarray


def speeds_by_states(rotating: RotatingLinearModel) -> np.ndarray:
    """Speeds of the rotors [rad/s] by the states of the linear model, (rotors, states).

    In coordinates that do not turn an azimuth has no rate: the speed is the state that is its rate in the model.
    """
    average = rotating.average
    if average is None:
        return np.zeros((0, len(rotating.linear.states)))
    rates = rate_states(average.at.dae)
    return np.array([average.free == rates.get(turn.azimuth, -1) for turn in average.turns], dtype=float)


def with_varying_speeds(excited: ExcitedModel, speeds: np.ndarray, frequency: np.ndarray) -> ExcitedModel:
    """The model whose fields know of the deviations of the speeds (rotors, q) [(rad/s)^2/Hz] that they turn with."""
    spreads = np.sqrt(np.trapezoid(speeds, frequency, axis=1))
    fields = tuple((columns, tuple(replace(item, spread=float(spreads[item.turn])) if item.turn >= 0 else item
                                   for item in places)) for columns, places in excited.fields)  # fmt: skip
    return replace(excited, fields=fields)


def with_rotation(found: Response, rotating: RotatingLinearModel, rotation: Rotation | None,
                  turned: Turned) -> Response:  # fmt: skip
    """The response of the results, from one that has also what these have of the turning, as outputs behind them.

    rotation: what goes round in steady wind; None, and the response unchanged, where nothing turns.
    """
    if rotation is None:
        return found
    own = rotating.results
    shares = {path: density[:own].copy() for path, density in found.shares.items()}
    for path, H in found.transfer.items():
        for turning in rotating.turning:
            shares[path][list(turning.of)] += turned_spectra(found.frequency, H, found.driving[path], turning)
    lines, shift = _turning_parts(found.frequency, rotation, turned)
    if lines.any():
        shares[ROTATION] = lines
    transfer = {path: H[:, :own] for path, H in found.transfer.items()}
    return replace(found, outputs=found.outputs[:own], units=found.units[:own], mean=rotation.mean + shift,
                   shares=shares, transfer=transfer)  # fmt: skip


def turned_spectra(frequency: np.ndarray, H: np.ndarray, S: np.ndarray, turning: Turning) -> np.ndarray:
    """Spectra (k, q) of what turns with a rotor, from transfer functions to its cosine and sine parts."""
    cosine, sine = H[:, turning.cosine], H[:, turning.sine]
    ahead, behind = (_quadratic((cosine - sign * 1j * sine) / 2, S) for sign in (1, -1))
    shift = abs(turning.speed) / (2 * np.pi)
    if turning.speed < 0:
        ahead, behind = behind, ahead
    return (moved_spectrum(frequency, ahead, shift, 1) + moved_spectrum(frequency, behind, shift, -1)
            + mirrored_spectrum(frequency, behind, shift))  # fmt: skip


def _quadratic(H: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Spectra (m, q)."""
    return ((H @ S) * H.conj()).sum(axis=2).real.T


def moved_spectrum(frequency: np.ndarray, density: np.ndarray, shift: float, sense: int) -> np.ndarray:
    """Densities (m, q) that stand at `frequency`, moved up (sense 1) or down (-1) by a frequency.

    The mean square between two frequencies moves as it is; what would go below zero is left out.
    """
    edges = _edges(frequency)
    return _between(frequency, density, edges - sense * shift)


def mirrored_spectrum(frequency: np.ndarray, density: np.ndarray, shift: float) -> np.ndarray:
    """Densities (m, q) below a frequency, mirrored: what stands at f goes to shift - f."""
    return -_between(frequency, density, shift - _edges(frequency))


def _edges(frequency: np.ndarray) -> np.ndarray:
    """Limits (q + 1,) of the parts of the axis that belong to each frequency in the rule of the trapezoid."""
    return np.concatenate([frequency[:1], (frequency[1:] + frequency[:-1]) / 2, frequency[-1:]])


def _between(frequency: np.ndarray, density: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Mean squares between ends that follow each other, over the width of the part of the axis that they go to."""
    below = mean_square_below(frequency, density)
    at = np.array([np.interp(ends, frequency, row) for row in below]).reshape(len(below), len(ends))
    return np.diff(at, axis=1) / frequency_widths(frequency)


def _turning_parts(frequency: np.ndarray, rotation: Rotation, turned: Turned) -> tuple[np.ndarray, np.ndarray]:
    """Spectra (m, q) of all harmonics, and what lingering rotors add to the means (m,)."""
    m = rotation.mean.size
    squares, shift = np.zeros((frequency.size, m)), np.zeros(m)
    A, C = turned.linear.matrices["A"], turned.linear.matrices["C"][:m]
    for driven, density, row in zip(rotation.driven, turned.speeds, turned.by_states, strict=True):
        speed = RandomSpeed(driven.speed, frequency, density)
        outputs, own = np.vstack([C, row]), _with_speed(driven)
        lines = [speed.line(n) for n in range(1, HARMONICS + 1)]
        answers = [own.harmonic(n, line.omega, A, outputs) for n, line in enumerate(lines, 1)]
        speeds = np.array([line.share @ c[:, m] for line, c in zip(lines, answers, strict=True)])
        lingering = Lingering(speed, speeds)
        if lingering.matters:
            more, mean = _of_lingering(frequency, lingering, partial(own.harmonic, A=A, outputs=outputs))
            squares, shift = squares + more[:, :m], shift + mean[:m]
            continue
        for line, c in zip(lines, answers, strict=True):
            np.add.at(squares, line.where, 2 * np.abs(c[:, :m]) ** 2 * line.share[:, None])
    squares = squares.T
    kept = squares > LEAST * squares.max(axis=1, initial=0.0)[:, None]
    return np.where(kept, squares, 0.0) / frequency_widths(frequency), shift


def _with_speed(driven: Driven) -> Driven:
    """With one more result, which has only what the states have: the speed of the rotor."""
    none = np.zeros((1, driven.outputs.shape[1]))
    return replace(driven, direct=np.hstack([driven.direct, np.zeros((len(driven.direct), 1))]),
                   outputs=np.vstack([driven.outputs, none]), turning=np.vstack([driven.turning, none]))  # fmt: skip


def _of_lingering(frequency: np.ndarray, lingering: Lingering, harmonic: Callable[[int, np.ndarray], np.ndarray],
                  ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Mean squares (q, m) of results by the parts of the axis, and means (m,); harmonic: see Driven.harmonic."""
    q, edges = frequency.size, _edges(frequency)
    omega = 2 * np.pi * np.concatenate([-frequency[::-1], frequency])
    answers = {n: harmonic(n, omega) for n in range(1, lingering.orders + 1)}
    answers |= {-n: c[::-1].conj() for n, c in answers.items()} | {0: np.zeros_like(answers[1])}
    squares = np.zeros(answers[0].shape)
    for orders, covariance in lingering.spectra(np.concatenate([-edges[::-1], edges])):
        by_order = np.stack([answers[n] for n in orders.tolist()], axis=1)  # (2 q, k, m)
        parts = np.delete(covariance, q, axis=0)  # what lies between the lowest frequency and its negative one
        squares += ((parts.transpose(0, 2, 1) @ by_order) * by_order.conj()).sum(axis=1).real
    slowest = np.array([(answers[n][q - 1] + answers[n][q]) / 2 for n in range(1, lingering.orders + 1)])
    mean = 2 * (lingering.means[1 : lingering.orders + 1] @ slowest).real
    return squares[q:] + squares[q - 1 :: -1], mean
