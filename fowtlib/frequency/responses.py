"""The stationary response of a model to random waves and wind, about its mean, without a run.

The mean position and the mean loads come from the equilibrium with all nonlinear equations and the controllers in the
loop; the model is linear about it, exactly, with the radiation of the database itself. Signals that the parts take from
waves and wind have transfer functions from the process (the elevation at the origin, the turbulence at each station),
so that S_y = H S H^H over each process, and the processes are independent. Drag is the best linear law of the response
itself (frequency.drag), found by a fixed point on the relative velocities at each place.

Left out: what is of second order in the waves, the mean of drag in waves, and, without the equivalent linearisation
(frequency.equivalent), controllers that change their region within the turbulence, dead bands and limits.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from fowtlib.analysis.plants import checked_frequencies, chosen_outputs, plant_of, refuse_unstable
from fowtlib.flattening import FlatDAE
from fowtlib.frequency.corners import covariance, laws_of, reached, warn_of_corners, with_states
from fowtlib.frequency.coverage import warn_of_ends
from fowtlib.frequency.driven import Grid, Process, Processes
from fowtlib.frequency.equivalent import equivalent
from fowtlib.frequency.few_channels import Sums, with_few_channels
from fowtlib.frequency.found import Response
from fowtlib.frequency.known_rows import Known, OfFrequency
from fowtlib.frequency.products import fed_back
from fowtlib.frequency.rotation import Turned, speeds_by_states, with_rotation, with_varying_speeds
from fowtlib.frequency.settling import settled_gains
from fowtlib.frequency.shifts import Shifts
from fowtlib.frequency.shifts import shifted as with_shifts
from fowtlib.frequency.studies import study_of
from fowtlib.language.component import Component
from fowtlib.language.errors import ModelError
from fowtlib.language.expressions import one_evaluation
from fowtlib.language.series import Series
from fowtlib.solving import State
from fowtlib.solving.excited import ExcitedModel, Signal
from fowtlib.solving.random_fields import blows
from fowtlib.solving.random_fields import density as field_density

Members = dict[str, tuple[Any, list[Signal]]]
"""Processes that drive signals, with these, by path."""


TANGENT, EQUIVALENT, QUADRATIC = "tangent", "equivalent", "quadratic"
ALONE = (
    "products of fluctuations are in this response as loads of their own, but not with what they make of products "
    "again: with that no response was found near it. Deviations may be too small; check them with runs."
)
NONE_TURN = (
    "varying_speed: no rotor of blade elements turns through a field of turbulence here (--wind turbulence:8), so that "
    "nothing is met at multiples of its speed. Leave it out."
)
SOME = np.geomspace(1e-2, 10.0, 50)  # rad/s, at which a process has a spectrum if it has one


class ProductsWarning(UserWarning):
    """A quadratic response without a part of what products of fluctuations do."""


def _unknown(name: Hashable, function: OfFrequency) -> OfFrequency:
    """A function of which nothing is known."""
    return function


def response(
    model: Any,
    *,
    outputs: Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    frequencies: Sequence[float] | np.ndarray | None = None,
    state: State | None = None,
    tolerance: float = 1e-4,
    shifted: Shifts | None = None,
    linearisation: str = TANGENT,
    varying_speed: bool = False,
) -> Response:
    """The response of a model, or of a compiled one, to its waves and its wind (see the module).

    outputs      results; None: all
    parameters   as for a run: what wind and what waves, for instance
    frequencies  [Hz], rising; None: chosen by the modes (frequency.grid)
    state        mean state; None: found
    tolerance    of the gains of drag, relative, at which the fixed point ends; at 1e-8 or less where rounding ends it
    linearisation  "tangent": about the mean in mean wind; "equivalent": of the least mean square error for the response
                 itself, of mean and equations, which knows of corners and of curved tables; see frequency.equivalent;
                 "quadratic": that, and what products of fluctuations add as loads of their own, the share "products"
    varying_speed  whether what blades meet at multiples of the rotor speed is as wide as the deviation of that speed in
                 the response makes it (solving.random_fields.density); a second pass, for rotors of blade elements
    shifted      modes that an artificial stiffness gives another period, as {"1.85 s": "1.79 s"}; see frequency.shifts
    Raises SimulationError where there is no mean, where it is unstable, and where the drag or the equivalent
    linearisation does not settle; ModelError for a varying speed where no rotor turns through a field.
    """
    plant = plant_of(model)
    _check_numbers(tolerance, state)
    if linearisation not in (TANGENT, EQUIVALENT, QUADRATIC):
        raise ModelError(f"linearisation: '{linearisation}' is not '{TANGENT}' or '{EQUIVALENT}' or '{QUADRATIC}'.")
    if linearisation != TANGENT and shifted:
        raise ModelError("shifted: modes are shifted about the mean in mean wind, with linearisation='tangent'.")
    names = list(plant.outputs) if outputs is None else chosen_outputs(plant, outputs)
    study = study_of(plant)
    with study.tree(parameters) as root:
        state = study.mean(parameters, root, names) if state is None else state
        excited = study.excited(state, names)
        if varying_speed and not any(item.turn >= 0 for _, places in excited.fields for item in places):
            raise ModelError(NONE_TURN)
        given = None if frequencies is None else _checked(frequencies)
        with one_evaluation():  # from here on nothing sets a parameter
            known = study.rows(parameters, root)
            signals = _signals(excited, root, known)
            if linearisation == TANGENT:
                excited = with_few_channels(excited, root, signals)
            processes = _processes(excited, root, signals, known)
            _refuse_without_spectrum(plant.dae, root, processes)
            if not processes:
                raise ModelError(
                    "no part of this model takes anything from random waves or wind; there is no response."
                )
            if shifted:
                excited = with_shifts(excited, settled_gains(excited, processes, given, tolerance)[0], shifted)
            expected, through, alone = None, dict[str, np.ndarray](), False
            if linearisation != TANGENT:

                sums: Sums = {}

                def driven(model: ExcitedModel, anew: bool) -> tuple[ExcitedModel, Processes]:
                    if anew:
                        sums.clear()
                    if model.rotating.average is not None:
                        model = with_few_channels(model, root, signals, sums)
                    return model, _processes(model, root, signals, known)

                found = equivalent(plant, state, names, driven, given, tolerance, linearisation == QUADRATIC)
                state, excited, gains, grid, iterations = (found.state, found.excited, found.gains, found.grid,
                                                           found.iterations)  # fmt: skip
                expected, through, alone = found.shown, dict(found.through), found.alone
            else:
                gains, grid, iterations = settled_gains(excited, processes, given, tolerance, study.gains(excited))
                study.keep_gains(excited, gains)
            linear = excited.with_gains(gains)
        refuse_unstable(linear)
        laws = laws_of(plant, plant.at(state.parameters))
        known = [k for k in laws.states if plant.dae.states[k].path in linear.states]
        paths = [plant.dae.states[k].path for k in known]
        by_states = speeds_by_states(excited.rotating)
        rows = np.vstack([np.eye(len(linear.states))[[linear.states.index(path) for path in paths]], by_states])
        names_of = [*paths, *(f"speed of rotor {k}" for k in range(len(by_states)))]
        answers = fed_back(grid.answers(with_states(linear, excited.results, rows, names_of)), through)
        if varying_speed:
            speeds = _speeds(answers, grid, len(by_states))
            excited = with_varying_speeds(excited, speeds, grid.frequency)
            with one_evaluation():
                processes = _processes(excited, root, signals)
                gains, grid, _ = settled_gains(excited, processes, grid.frequency, tolerance, gains)
            linear = excited.with_gains(gains)
            answers = grid.answers(with_states(linear, excited.results, rows, names_of))
    H = {path: values[:, : excited.results] for path, values in answers.items()}
    own = {path: values[:, excited.results :] for path, values in answers.items()}
    of_laws = {path: values[:, : len(paths)] for path, values in own.items()}
    corners = ()  # an equivalent linearisation knows of them
    if linearisation == TANGENT:
        corners = reached(plant, state, laws, known, covariance(of_laws, grid.spectra, grid.frequency))
    speeds = _speeds(answers, grid, len(by_states))
    shares = {path: _spectra(H[path], grid.spectra[path]) for path in H}
    mean = study.shown(state, names) if expected is None else expected
    labels = linear.outputs[: excited.results]
    units = tuple(linear.units.get(name, "1") for name in labels)
    driving = dict(grid.spectra)
    found = Response(grid.frequency, tuple(labels), units, mean, shares, H, linear, state, iterations, driving, corners,
                     linearisation)  # fmt: skip
    rotation = study.rotation(state, names, excited.rotating)
    found = with_rotation(found, excited.rotating, rotation, Turned(linear, speeds, by_states))
    warn_of_ends(found, frequencies is not None)
    warn_of_corners(corners)
    if alone:
        warnings.warn(ALONE, ProductsWarning, stacklevel=2)
    return found


def _speeds(answers: Mapping[str, np.ndarray], grid: Grid, count: int) -> np.ndarray:
    """Spectra (rotors, q) of the last outputs, by so many transfer functions."""
    return sum((_spectra(H[:, H.shape[1] - count :], grid.spectra[path]) for path, H in answers.items()),
               start=np.zeros((count, grid.frequency.size)))  # fmt: skip


def _check_numbers(tolerance: Any, state: Any) -> None:
    """ModelError for a tolerance that is not above zero, and what is no mean state."""
    if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float, np.number)) or not tolerance > 0:
        raise ModelError(f"tolerance is a number above 0, as 1e-4, not {tolerance!r}.")
    if state is not None and not isinstance(state, State):
        raise ModelError(f"state is a mean, as plant.equilibrium() gives it, or None, not {state!r}.")


def _checked(frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
    """Frequencies [Hz] of a user: positive, rising, two or more."""
    frequency = checked_frequencies(frequencies)
    if frequency.size < 2 or not np.all(np.diff(frequency) > 0):
        raise ModelError("the frequencies of a response are two or more rising numbers above 0 Hz.")
    return frequency


def _processes(excited: ExcitedModel, root: Component, members: Members | None = None,
               known: Known = _unknown) -> dict[str, Process]:  # fmt: skip
    """The random processes that drive the signals, and the fields.

    members: the signals, where these are there already. known: see KnownRows.
    """
    members, n = _signals(excited, root) if members is None else members, excited.driven
    found = {path: Process(known(("density", path), process.spectral_density),
                           np.concatenate([_numbers(signal.columns) for signal in signals]),
                           known(("amplitudes", path), partial(_of_signals, signals, root)), n)
             for path, (process, signals) in members.items()}  # fmt: skip
    for number, (columns, places) in enumerate(excited.fields):
        if not blows(places, root):
            continue
        path = places[0].process(root)
        driven, ones = _numbers(columns), partial(_ones, columns.stop - columns.start)
        if path in members:  # signals and places of one turbulence
            beside, own = members[path][0].places, found[path]
            density = partial(field_density, places, root, beside=beside)
            both = partial(_side_by_side, (own.amplitudes, ones))
            found[path] = Process(density, np.concatenate([own.driven, driven]), both, n)
        else:
            density = partial(field_density, places, root, basis=excited.bases.get(number))
            found[path] = Process(density, driven, ones, n)
    return found


def _signals(excited: ExcitedModel, root: Component, known: Known = _unknown) -> Members:
    """The processes that drive signals, with these, by path."""
    members: Members = {}
    there: dict[str, bool] = {}
    for signal in excited.signals:
        process = signal.process(root)
        if process.path not in there:
            density = known(("some density", process.path), process.spectral_density)
            there[process.path] = bool(np.any(density(SOME)))
        if there[process.path]:
            members.setdefault(process.path, (process, []))[1].append(signal)
    return members


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


def _numbers(columns: slice) -> np.ndarray:
    return np.arange(columns.start, columns.stop)


def _of_signals(signals: Sequence[Signal], root: Component, omega: np.ndarray) -> np.ndarray:
    responses = [signal.response(root, omega) for signal in signals]
    return np.concatenate(responses, axis=1, dtype=complex)


def _side_by_side(drives: Sequence[Callable[[np.ndarray], np.ndarray]], omega: np.ndarray) -> np.ndarray:
    """Those of inputs one after the other, each by channels of its own."""
    blocks = [drive(omega) for drive in drives]
    whole = np.zeros((omega.size, *(sum(block.shape[k] for block in blocks) for k in (1, 2))), dtype=complex)
    row = column = 0
    for block in blocks:
        whole[:, row : row + block.shape[1], column : column + block.shape[2]] = block
        row, column = row + block.shape[1], column + block.shape[2]
    return whole


def _ones(count: int, omega: np.ndarray) -> np.ndarray:
    return np.broadcast_to(np.eye(count, dtype=complex), (omega.size, count, count))


def _spectra(H: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Spectra (m, q) of outputs, from transfer functions and the spectra of what drives them."""
    return ((H @ S) * H.conj()).sum(axis=2).real.T
