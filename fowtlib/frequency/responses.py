"""The stationary response of a model to random waves and wind, about its mean, without a run.

The mean position and the mean loads come from the equilibrium with all nonlinear equations and the controllers in the
loop; the model is linear about it, exactly, with the radiation of the database itself. Signals that the parts take from
waves and wind have transfer functions from the process (the elevation at the origin, the turbulence at each station),
so that S_y = H S H^H over each process, and the processes are independent. Drag is the best linear law of the response
itself (frequency.drag), found by a fixed point on the relative velocities at each place.

Left out: what is of second order in the waves, the mean of drag in waves, controllers that change their region within
the turbulence, dead bands and limits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from fowtlib.analysis.plants import checked_frequencies, chosen_outputs, plant_of, refuse_unstable
from fowtlib.flattening import FlatDAE
from fowtlib.frequency.coverage import warn_of_ends
from fowtlib.frequency.drag import best_gain, best_gains
from fowtlib.frequency.found import Response
from fowtlib.frequency.grid import response_frequencies
from fowtlib.frequency.mixing import Mixing
from fowtlib.frequency.rotation import with_rotation
from fowtlib.frequency.shifts import Shifts
from fowtlib.frequency.shifts import shifted as with_shifts
from fowtlib.frequency.studies import study_of
from fowtlib.language.component import Component
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.language.expressions import one_evaluation
from fowtlib.language.series import Series
from fowtlib.solving import LinearModel, State
from fowtlib.solving.excited import ExcitedModel, Signal
from fowtlib.solving.linear import Resolvent, times
from fowtlib.solving.random_fields import blows
from fowtlib.solving.random_fields import density as field_density

ITERATIONS = 60
GUESS = 1.0  # m/s; deviation of the velocities of drag before the first iteration
ROUNDING = 1e-8  # change of the gains from which it need not get smaller
SMALL = 0.1  # of the largest gain of drag
REGRIDDED = 1e-2  # change of the gains below which the frequencies are chosen for good


def response(
    model: Any,
    *,
    outputs: Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    frequencies: Sequence[float] | np.ndarray | None = None,
    state: State | None = None,
    tolerance: float = 1e-4,
    shifted: Shifts | None = None,
) -> Response:
    """The response of a model, or of a compiled one, to its waves and its wind (see the module).

    outputs      results; None: all
    parameters   as for a run: what wind and what waves, for instance
    frequencies  [Hz], rising; None: chosen by the modes (frequency.grid)
    state        mean state; None: found
    tolerance    of the gains of drag, relative, at which the fixed point ends; at 1e-8 or less where rounding ends it
    shifted      modes that an artificial stiffness gives another period, as {"1.85 s": "1.79 s"}; see frequency.shifts
    Raises SimulationError where there is no mean, where it is unstable, and where the drag does not settle.
    """
    plant = plant_of(model)
    names = list(plant.outputs) if outputs is None else chosen_outputs(plant, outputs)
    study = study_of(plant)
    with study.tree(parameters) as root:
        state = study.mean(parameters, root) if state is None else state
        excited = study.excited(state, names)
        given = None if frequencies is None else _checked(frequencies)
        with one_evaluation():  # from here on nothing sets a parameter
            processes = _processes(excited, root)
            _refuse_without_spectrum(plant.dae, root, processes)
            if not processes:
                raise ModelError(
                    "no part of this model takes anything from random waves or wind; there is no response."
                )
            if shifted:
                excited = with_shifts(excited, _settled_gains(excited, processes, given, tolerance)[0], shifted)
            linear, grid, iterations = _settled(excited, processes, given, tolerance)
        refuse_unstable(linear)
        H = grid.answers(linear, excited.results)
    shares = {path: _spectra(H[path], grid.spectra[path]) for path in H}
    mean = np.concatenate([np.ravel(value) for value in state.values(names)])
    labels = linear.outputs[: excited.results]
    units = tuple(linear.units.get(name, "1") for name in labels)
    driving = dict(grid.spectra)
    found = Response(grid.frequency, tuple(labels), units, mean, shares, H, linear, state, iterations, driving)
    found = with_rotation(found, excited.rotating, study.rotation(state, names, excited.rotating))
    warn_of_ends(found, frequencies is not None)
    return found


def _checked(frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
    """Frequencies [Hz] of a user: positive, rising, two or more."""
    frequency = checked_frequencies(frequencies)
    if frequency.size < 2 or not np.all(np.diff(frequency) > 0):
        raise ModelError("the frequencies of a response are two or more rising numbers above 0 Hz.")
    return frequency


Processes = Mapping[str, "Process"]
"""The random processes by path."""


@dataclass(frozen=True, eq=False)
class Process:
    """A random process: its spectrum [unit^2 s/rad] and what it drives, complex (q, inputs, channels), over omega."""

    density: Callable[[np.ndarray], np.ndarray]
    drive: Callable[[np.ndarray], np.ndarray]


def _settled(excited: ExcitedModel, processes: Processes, frequency: np.ndarray | None,
             tolerance: float) -> tuple[LinearModel, Grid, int]:  # fmt: skip
    """The linear model with the drag of its own response, the frequencies, and the count of iterations."""
    gains, grid, iterations = _settled_gains(excited, processes, frequency, tolerance)
    return excited.with_gains(gains), grid, iterations


def _settled_gains(excited: ExcitedModel, processes: Processes, frequency: np.ndarray | None,
                   tolerance: float) -> tuple[list[np.ndarray], Grid, int]:  # fmt: skip
    """The gains of drag that suit the response with them, the frequencies, and the count of iterations.

    A coarse grid serves until the gains change little, then the final one of the modes that the model has with them.
    """
    gains = [best_gain(GUESS**2 * np.eye(place.stop - place.start), excited.means[place]) for _, place in excited.laws]
    linear = excited.with_gains(gains)
    refuse_unstable(linear)
    final = frequency is not None or not excited.laws
    grid = Grid(excited, processes, response_frequencies(linear.modes(), coarse=not final)
                if frequency is None else frequency)  # fmt: skip
    if not excited.laws:
        return gains, grid, 1
    mixing, last = Mixing(), np.inf
    for iteration in range(1, ITERATIONS + 1):
        found = grid.gains(gains)
        change = _change(gains, found)
        if final and (change < tolerance or last <= change < ROUNDING):
            return found, grid, iteration
        if not final and change < REGRIDDED:
            final, gains = True, found
            grid = Grid(excited, processes, response_frequencies(excited.with_gains(found).modes()))
            continue
        gains, last = mixing(gains, found), change
    raise SimulationError(
        f"the linearised drag does not settle within {ITERATIONS} iterations; the last change is {last:.2g}."
    )


def _change(gains: Sequence[np.ndarray], found: Sequence[np.ndarray]) -> float:
    """The largest relative change of a gain; one below a tenth of the largest counts as that much."""
    sizes = np.array([np.linalg.norm(new) for new in found])
    steps = np.array([np.linalg.norm(new - old) for new, old in zip(found, gains, strict=True)])
    return float(np.max(steps / np.maximum(sizes, max(SMALL * sizes.max(), 1e-12))))


def _processes(excited: ExcitedModel, root: Component) -> dict[str, Process]:
    """The random processes that drive the signals, and the fields."""
    members: dict[str, tuple[Any, list[Signal]]] = {}
    for signal in excited.signals:
        process = signal.process(root)
        if np.any(process.spectral_density(np.geomspace(1e-2, 10.0, 50))):
            members.setdefault(process.path, (process, []))[1].append(signal)
    found = {path: Process(process.spectral_density, partial(_of_signals, excited.driven, signals, root))
             for path, (process, signals) in members.items()}  # fmt: skip
    for columns, places in excited.fields:
        if not blows(places, root):
            continue
        path = places[0].compute.process(root.find(places[0].owner)).path
        drive = partial(_of_field, excited.driven, columns)
        if path in members:  # signals and places of one turbulence
            beside, own = members[path][0].places, found[path].drive
            density = partial(field_density, places, root, beside=beside)
            found[path] = Process(density, partial(_side_by_side, (own, drive)))
        else:
            found[path] = Process(partial(field_density, places, root), drive)
    return found


def _refuse_without_spectrum(dae: FlatDAE, root: Component, processes: Processes) -> None:
    """ModelError where a run has signals of time that no spectrum stands for: regular waves, a gust, a file."""
    for _, item in dae.with_data:
        if item.owner in processes or hasattr(item.compute, "density"):
            continue
        part = root.find(item.owner)
        if hasattr(item.compute, "process") and item.compute.process(part).path in processes:
            continue
        series = item.compute(part)
        if isinstance(series, Series) and not series.steady:
            family = part.family
            kind = f" of kind '{family.kind_of(type(part))}'" if family is not None else ""
            raise ModelError(
                f"{part.label}{kind}: its signals have no spectrum, and the response would be without them. Take what "
                "is random, as in --wind kaimal:12 or turbulence:12, --waves jonswap:Hs=3,Tp=10, or none of it."
            )


def _of_signals(driven: int, signals: Sequence[Signal], root: Component, omega: np.ndarray) -> np.ndarray:
    responses = [signal.response(root, omega) for signal in signals]
    drive = np.zeros((omega.size, driven, responses[0].shape[2]), dtype=complex)
    for signal, values in zip(signals, responses, strict=True):
        drive[:, signal.columns] = values
    return drive


def _side_by_side(drives: Sequence[Callable[[np.ndarray], np.ndarray]], omega: np.ndarray) -> np.ndarray:
    return np.concatenate([drive(omega) for drive in drives], axis=2)


def _of_field(driven: int, columns: slice, omega: np.ndarray) -> np.ndarray:
    chosen = np.eye(driven, dtype=complex)[:, columns]
    return np.broadcast_to(chosen, (omega.size, *chosen.shape))


class Grid:
    """What does not change with the gains of drag, at frequencies (q,) [Hz].

    spectra: of the processes (q, channels, channels) per Hz. drive: the inputs by the channels of all processes,
    (q, inputs, channels).
    """

    def __init__(self, excited: ExcitedModel, processes: Processes, frequency: np.ndarray):
        self.excited, self.frequency, self.omega = excited, frequency, 2 * np.pi * frequency
        steps = np.diff(frequency)
        self.widths = (np.append(steps, 0.0) + np.append(0.0, steps)) / 2
        operators = excited.linear.operators
        self.errors = operators.errors(self.omega) if operators is not None else None
        self.spectra: dict[str, np.ndarray] = {}
        self.columns: dict[str, slice] = {}
        drives, first = [], 0
        for path, process in processes.items():
            density = 2 * np.pi * np.asarray(process.density(self.omega))
            self.spectra[path] = density.reshape(len(density), *(density.shape[1:] or (1, 1)))
            channels = self.spectra[path].shape[1]
            drives.append(process.drive(self.omega))
            self.columns[path] = slice(first, first + channels)
            first += channels
        self.drive = np.concatenate(drives, axis=2)

    def answers(self, linear: LinearModel, outputs: int | None = None) -> dict[str, np.ndarray]:
        """Transfer functions (q, outputs, channels) by process, of the first outputs or of all."""
        H = linear.first(outputs).driven(self.omega, self.drive, self.errors)
        return {path: H[:, :, columns] for path, columns in self.columns.items()}

    @cached_property
    def _weighted(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Rates of the states, inputs of the laws and of the operators by the drive alone, without any law, (n, q, k).

        For a drive whose channels are independent and have a variance of one at each frequency.
        """
        parts = [self.drive[:, :, columns] @ _roots(self.spectra[path] * self.widths[:, None, None])
                 for path, columns in self.columns.items()]  # fmt: skip
        inputs, n, m = np.concatenate(parts, axis=2).transpose(1, 0, 2), self.excited.driven, self.excited.results
        linear = self.excited.linear
        operators = linear.operators
        own = times(operators.D_input[:, :n], inputs) if operators is not None else None
        return times(linear.matrices["B"][:, :n], inputs), times(linear.matrices["D"][m:, :n], inputs), own

    def gains(self, gains: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Gains of the laws of drag that suit the response with these gains: from the covariance of their inputs."""
        excited, linear = self.excited, self.excited.linear
        n, m = excited.driven, excited.results
        A, B, C, D = (linear.matrices[name] for name in "ABCD")
        loop = excited.loop(gains)
        rates, u, own = self._weighted
        resolvent = Resolvent(self.omega, A + B[:, n:] @ loop @ C[m:])
        amplitudes = resolvent.amplitudes(rates + times(B[:, n:] @ loop, u))
        through = D[m:, n:] @ loop
        velocity = u + times(through, u) if through.any() else u
        if linear.operators is not None:
            closed = linear.operators.fed_back(loop, n, m, linear.matrices)
            direct = own + times(linear.operators.D_input[:, n:] @ loop, u)
            more, signals = closed.added(resolvent, amplitudes, direct, self.errors)
            amplitudes = amplitudes + more
            if closed.D_output[m:].any():
                velocity = velocity + times(closed.D_output[m:], signals)
        velocity = velocity + times((C[m:] + through @ C[m:]) @ resolvent.shapes, amplitudes)
        flat = velocity.reshape(len(velocity), -1).view(float)
        places = [place for _, place in excited.laws]
        return best_gains([flat[place] for place in places], [excited.means[place] for place in places])


def _roots(S: np.ndarray) -> np.ndarray:
    """R (q, k, k) with R R^H = S, of Hermitian S without negative eigenvalues."""
    if S.shape[1] == 1:
        return np.sqrt(np.maximum(S.real, 0.0))
    values, vectors = np.linalg.eigh(S)
    return vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]


def _spectra(H: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Spectra (m, q) of outputs, from transfer functions and the spectra of what drives them."""
    return ((H @ S) * H.conj()).sum(axis=2).real.T
