"""Equivalent linearisation of a whole model: mean and linear model that suit the response which they have.

A linear model about the mean in mean wind knows nothing of a corner beside it, of a table that curves, of products of
fluctuations. In its place stands the linear model nearest in the mean square, for states, unknowns and signals that are
Gaussian with the covariance of the response itself: expected values and slopes of all equations and results
(frequency.expectations), about the mean at which the expected rates vanish. Covariance, mean and linear model are found
together: on the same frequencies as soon as they hardly change, and in steps that get shorter, so that near a swing
that hardly decays, which makes a percent of a slope ten of a deviation, the points of the means are averaged out.
With products of fluctuations covariance, slopes and spectra go the same share of a step (frequency.relaxation): one
that goes whole sets off a swing among the others.

Of rotors of blade elements that turn, the laws of controllers and actuators alone are so; see TurningRows.

Products of fluctuations are in it by what they do to the mean and to the slopes. What they add as a load of their own,
at sums and differences of frequencies, is a process beside the others where that is asked for (frequency.products).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fowtlib.analysis.plants import UnstableError, refuse_unstable
from fowtlib.frequency.corners import covariance, with_states
from fowtlib.frequency.driven import Grid, Processes, frequency_widths
from fowtlib.frequency.expected_means import NOWHERE, RestingRows, TurningRows, deviations_of
from fowtlib.frequency.products import PRODUCTS, Products, channels_of, cross_spectra, fed_back, with_channels
from fowtlib.frequency.quadratic_rows import QuadraticRows
from fowtlib.frequency.relaxation import Relaxation
from fowtlib.frequency.settling import settled_gains
from fowtlib.language.eigenvectors import eigenvalues
from fowtlib.language.errors import SimulationError
from fowtlib.solving import State
from fowtlib.solving.excited import ExcitedModel, excited_model
from fowtlib.solving.linear import LinearModel

ITERATIONS, WITH_PRODUCTS = 60, 30  # at most; with products one takes three times as long
WHOLE = 6  # from this iteration on the way to the covariance that is found is shortened, as this over their number
SETTLED = 3e-3  # change of the deviation of a result, and distance from that over the last iterations, to end at
PATIENT, NEARLY = 15, 0.03  # after so many iterations, where a swing hardly decays and the points of the means tell
CLOSE = 0.02  # step of the mean over the deviation of a state
HELD = 0.05  # from which the frequencies stay
FEWEST = 3  # iterations; the first guess has too small a covariance
NEAR = 0.1  # change of a deviation from which products join: those of a tangent response may be far too large
FED_BACK, SWUNG = 20, 3.0  # iterations with what products make of products, and change of a deviation by it, at most
CALM = 0.3  # of the covariance by the tangent, the first guess: near a corner it is far too large
LOOSE = 0.01  # of the last change of a deviation: the tolerance of the drag on the way
THINNED = 8  # of so many frequencies one, for states that only tell how far the mean steps
DAMPED = 1.5  # times the growth of the fastest growing mode, taken off all roots for a first guess
SLOWEST = 1e-4  # 1/s, at least
TURNING = (
    "linearisation='quadratic' does not know the products in rotors of blade elements that turn. Take 'equivalent', or "
    "a rotor of coefficients."
)

Driven = Callable[[ExcitedModel, bool], tuple[ExcitedModel, Processes]]
"""The linear model by the channels that count, and the random processes that drive it; whether they are found anew."""


@dataclass(frozen=True, eq=False)
class Equivalent:
    """What was found: mean state, linear model with gains of its drag, and frequencies.

    shown: expected results in their units; None where they are those of the mean. through: what the inputs of products
    have of each process beside what they are themselves, (q, inputs of products, channels); see frequency.products.
    alone: whether this is left out, since no response with it was found.
    """

    state: State
    excited: ExcitedModel
    gains: list[np.ndarray]
    grid: Grid
    iterations: int
    shown: np.ndarray | None
    through: Mapping[str, np.ndarray] = field(default_factory=dict)
    alone: bool = False


def equivalent(plant: Any, state: State, names: Sequence[str], driven: Driven, frequency: np.ndarray | None,
               tolerance: float, quadratic: bool = False) -> Equivalent:  # fmt: skip
    """The equivalent linearisation that starts from a mean state in mean wind; see the module.

    quadratic: with products of fluctuations as loads of their own as soon as the search is near. When it has settled,
    what they make of products joins; where the search swings out with it, or does not settle, it is that of the loads
    alone. Where rotors of blade elements turn it is that of the laws with corners alone, which are no loads of these
    rotors. SimulationError where the fixed point is not found, or products are asked for there.
    """
    excited = excited_model(plant, state, names)
    turning = excited.rotating.average is not None
    if turning and quadratic:
        raise SimulationError(TURNING)
    rows = TurningRows(plant, state) if turning else RestingRows(plant, state, names, excited.further, quadratic)
    guess, last, given = None, None, frequency
    gains: list[np.ndarray] | None = None
    smooth: np.ndarray | None = None
    response: Answers | None = None
    relaxed, cross = Relaxation(), np.zeros(())
    alone: Equivalent | None = None
    sizes, first, change, near = np.zeros(0), 0, np.inf, not quadratic  # sizes: of the loads alone
    rough, anew = turning and given is None, True  # on fewer frequencies; the channels that count are to be found
    try:
        most = WITH_PRODUCTS if quadratic else ITERATIONS
        for iteration in range(1, most + 1):
            excited, processes = driven(excited, anew)
            products: Products | None = None
            near = near or change < NEAR
            if near and rows.quadratic is not None and response is not None:
                excited, processes, products = _with_products(excited, processes, rows.quadratic, response, cross,
                                                              alone)  # fmt: skip
            loose = min(max(LOOSE * change, tolerance), max(LOOSE, tolerance))
            (excited, gains, grid), damping = _settled(excited, processes, given, loose, gains, rough)
            response = Answers.of(excited, gains, grid, products, rows.wanted(excited), quadratic)
            found, deviations = response.covariance, response.deviations
            if not np.all(np.isfinite(found)):
                raise SimulationError(NOWHERE)
            count = iteration - first
            share = min(1.0, WHOLE / count)
            if products is not None and guess is not None:
                share = relaxed(_of_guess(found, guess))
            if quadratic:
                own = cross_spectra(response.transfer, response.spectra)
                kept = products is not None and given is not None  # the frequencies are those before
                cross = cross + share * (own - cross) if kept else own
            smooth = deviations if smooth is None else smooth + share * (deviations - smooth)
            change = np.inf if last is None else max(_change(deviations, last), _change(deviations, smooth))
            enough = SETTLED if count <= PATIENT else NEARLY
            ends = near and not rough and count > FEWEST and rows.step < CLOSE and change < enough
            if ends and not damping:
                if loose > tolerance:
                    gains, grid, _ = settled_gains(excited, processes, grid.frequency, tolerance, gains)
                shown = None if rows.shown is None else rows.shown[: excited.results]
                whole = Equivalent(state, excited, gains, grid, iteration, shown, response.through)
                if products is None or alone is not None:
                    return whole
                alone, sizes, first, relaxed = replace(whole, alone=True), deviations, iteration, Relaxation()
            if alone is not None and (iteration - first > FED_BACK or _swung(deviations, sizes)):
                return alone
            anew = False
            if last is not None and _change(deviations, last) < HELD:
                given = None if rough else grid.frequency
                rough, anew = False, rough
            guess = CALM * found if guess is None else guess + share * (found - guess)
            last = deviations
            state, off = rows.stepped(excited, state, guess, 1.0 if products is None else share)
            excited = excited_model(plant, state, names, off, () if rows.quadratic is None else rows.quadratic.rows)
        way, other = ("quadratic", "equivalent") if quadratic else ("equivalent", "tangent")
        raise SimulationError(
            f"the {way} linearisation does not settle within {most} iterations; the last change of a deviation is "
            f"{change:.2g}. Take linearisation='{other}', or runs."
        )
    except SimulationError:
        if alone is None:
            raise
        return alone


def _settled(excited: ExcitedModel, processes: Processes, frequency: np.ndarray | None,
             tolerance: float, start: Sequence[np.ndarray] | None, rough: bool,
             ) -> tuple[tuple[ExcitedModel, list[np.ndarray], Grid], float]:  # fmt: skip
    """The model with gains of its drag and frequencies, and what was taken off its roots so that it is stable."""
    try:
        if start is not None:
            refuse_unstable(excited.with_gains(start))
        gains, grid, _ = settled_gains(excited, processes, frequency, tolerance, start, rough)
        return (excited, gains, grid), 0.0
    except UnstableError as error:
        first = error
    damping = max(DAMPED * float(eigenvalues(excited.linear.matrices["A"]).real.max(initial=0.0)), SLOWEST)
    for _ in range(6):
        calm = excited.damped(damping)
        try:
            gains, grid, _ = settled_gains(calm, processes, frequency, tolerance, rough=rough)
            return (calm, gains, grid), damping
        except UnstableError:
            damping *= 2
    raise first


@dataclass(frozen=True, eq=False)
class Answers:
    """Transfer functions (q, n, channels) of states, or of [states; inputs], by process, and their spectra per Hz.

    covariance: of these. deviations, rates: of results and, where products are asked for, of the rates of the states.
    """

    frequency: np.ndarray
    transfer: Mapping[str, np.ndarray]
    spectra: Mapping[str, np.ndarray]
    covariance: np.ndarray
    deviations: np.ndarray
    rates: np.ndarray
    through: Mapping[str, np.ndarray]

    @staticmethod
    def of(excited: ExcitedModel, gains: Sequence[np.ndarray], grid: Grid, products: Products | None,
           wanted: Sequence[int] | None, quadratic: bool) -> Answers:  # fmt: skip
        """Of a model with gains of its drag; inputs: without those of products.

        wanted: states whose covariance is that of all frequencies, and without inputs; None: of all, and of inputs.
        """
        linear = excited.with_gains(gains)
        if wanted is not None:
            return Answers._of_states(excited, linear, grid, wanted)
        n, m = len(linear.states), excited.results
        H = grid.answers(with_states(linear, m, np.eye(n), linear.states))
        both: dict[str, np.ndarray] = {}
        count = excited.driven - sum(name.startswith(f"{PRODUCTS} ") for name in linear.inputs)
        for path, answer in H.items():
            drive = np.zeros((len(answer), excited.driven, answer.shape[2]), dtype=complex)
            drive[:, grid.driving[path].inputs] = grid.driving[path].drive.transpose(1, 0, 2)
            both[path] = np.concatenate([answer[:, m:], drive[:, :count]], axis=1)
        through: dict[str, np.ndarray] = {}
        if products is not None:
            through = products.through(both, grid.frequency)
            both, H = fed_back(both, through), fed_back(H, through)
        shown = {path: answer[:, :m] for path, answer in H.items()}
        of_rates = np.zeros(0)
        if quadratic:
            of_rates = _deviations({path: answer[:, m:] * (1j * grid.omega)[:, None, None]
                                    for path, answer in H.items()}, grid)  # fmt: skip
        return Answers(grid.frequency, both, grid.spectra, covariance(both, grid.spectra, grid.frequency),
                       _deviations(shown, grid), of_rates, through)  # fmt: skip

    @staticmethod
    def _of_states(excited: ExcitedModel, linear: LinearModel, grid: Grid, wanted: Sequence[int]) -> Answers:
        """The covariance of some states by all frequencies, and that of the others by a few."""
        m, one, few = excited.results, np.eye(len(linear.states)), grid.thinned(THINNED)
        found = covariance(few.answers(with_states(linear, 0, one, linear.states)), few.spectra, few.frequency)
        H = grid.answers(with_states(linear, m, one[wanted], [linear.states[k] for k in wanted]))
        own = {path: answer[:, m:] for path, answer in H.items()}
        found[np.ix_(wanted, wanted)] = covariance(own, grid.spectra, grid.frequency)
        shown = {path: answer[:, :m] for path, answer in H.items()}
        return Answers(grid.frequency, own, grid.spectra, found, _deviations(shown, grid), np.zeros(0), {})


def _deviations(H: Mapping[str, np.ndarray], grid: Grid) -> np.ndarray:
    """Of what transfer functions (q, m, channels) are of: (m,)."""
    squares = sum(((h @ grid.spectra[path]) * h.conj()).sum(axis=2).real for path, h in H.items())
    return np.sqrt(np.maximum(frequency_widths(grid.frequency) @ squares, 0.0))


def _with_products(excited: ExcitedModel, processes: Processes, quadratic: QuadraticRows, response: Answers,
                   cross: np.ndarray, alone: Equivalent | None,
                   ) -> tuple[ExcitedModel, Processes, Products | None]:  # fmt: skip
    """The model and its processes with the products of fluctuations of a response.

    cross: spectra (q, n, n) of its [states; inputs]. alone: what was found with their loads alone; None: not yet.
    """
    channels = channels_of(excited, quadratic, response.rates, response.deviations)
    if channels is None:
        return excited, processes, None
    first = excited.driven
    excited = with_channels(excited, channels)
    of_directions = channels.directions @ cross @ channels.directions.T
    products = Products(channels, response.frequency, of_directions, alone is not None)
    own = {path: replace(process, inputs=excited.driven) for path, process in processes.items()}
    return excited, own | {PRODUCTS: products.process(first, excited.driven)}, products


def _of_guess(found: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """What a covariance that is found has more than the guess, over the deviations of that: (n^2,)."""
    sizes = deviations_of(guess)
    sizes[sizes <= 1e-9 * sizes.max(initial=0.0)] = np.inf  # does not move
    return ((found - guess) / np.outer(sizes, sizes)).ravel()


def _swung(new: np.ndarray, old: np.ndarray) -> bool:
    """Whether a deviation that is one has become another by a factor."""
    moves = old > 1e-9 * old.max(initial=0.0)
    return bool(np.any(new[moves] > SWUNG * old[moves]) or not np.all(np.isfinite(new)))


def _change(new: np.ndarray, old: np.ndarray) -> float:
    """The largest relative change of a deviation that is one."""
    moves = new > 1e-9 * new.max(initial=0.0)
    return float(np.max(np.abs(new - old)[moves] / new[moves], initial=0.0))
