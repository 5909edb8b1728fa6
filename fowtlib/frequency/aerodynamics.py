"""What a rotor and its controller put against a slow motion of the hub: inertia and damping by frequency.

A hub that moves downwind with the velocity v (complex amplitudes, exp(+i omega t)) changes the thrust by H v, and
H = -(b + i omega a): the turbine adds the damping b [N s/m] and the inertia a [kg] to what carries it. With the rotor
speed and the pitch at rest b is dT/dU and a nothing; the speed controller makes both depend on the frequency, and may
turn the damping to the other side. Source: J.M. Hegseth, E.E. Bachynski and B.J. Leira, J. Phys.: Conf. Ser. 1452
(2020) 012040.

`aerodynamic_coefficients` takes H from the linear model of any plant, with all that its controllers measure;
`forced_oscillation` from runs of the nonlinear one, whose hub rides on a ForcedOscillation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.analysis.harmonics import harmonic_fit
from fowtlib.analysis.plants import checked_frequencies, plant_of
from fowtlib.components.mechanics import ForcedOscillation
from fowtlib.language.component import Component
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError, did_you_mean
from fowtlib.solving import LinearModel, State, mean_linear_model, mean_state
from fowtlib.solving.results.tables import write_table
from fowtlib.solving.starts import mean_parameters

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

LINEAR, FORCED = "linear model", "forced oscillation"


@dataclass(frozen=True, eq=False)
class AerodynamicCoefficients:
    """Inertia and damping of a rotor with its controller, against a motion of the hub along the wind.

    frequency (q,) [Hz]; transfer (q,): thrust per velocity of the hub, complex [N s/m]; method: how it was found.
    """

    frequency: np.ndarray
    transfer: np.ndarray
    turbine: str
    method: str = LINEAR

    @property
    def damping(self) -> np.ndarray:
        """b_aer (q,) [N s/m]; negative where the controller drives the motion."""
        return -self.transfer.real

    @property
    def inertia(self) -> np.ndarray:
        """a_aer (q,) [kg]."""
        return -self.transfer.imag / (2 * np.pi * self.frequency)

    def matrices(self, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Added mass and damping (q, 3, 3) in surge, heave and pitch about a point so far [m] below the hub."""
        shape = np.array([[1.0, 0.0, height], [0.0, 0.0, 0.0], [height, 0.0, height**2]])
        return self.inertia[:, None, None] * shape, self.damping[:, None, None] * shape

    @property
    def dataset(self) -> xarray.Dataset:
        """Both over the coordinate ``frequency``."""
        import xarray

        frequency = xarray.Variable("frequency", self.frequency, {"units": "Hz", "long_name": "frequency"})
        columns = {
            "inertia": ("frequency", self.inertia, {"units": "kg", "long_name": "aerodynamic inertia"}),
            "damping": ("frequency", self.damping, {"units": "N s/m", "long_name": "aerodynamic damping"}),
        }
        return xarray.Dataset(columns, {"frequency": frequency}, {"turbine": self.turbine, "method": self.method})

    def save(self, path: str | Path) -> Path:
        """Write a table as CSV, one row per frequency."""
        heads = ("frequency [Hz]", "inertia [kg]", "damping [N s/m]")
        rows = np.column_stack([self.frequency, self.inertia, self.damping]).tolist()
        return write_table(path, heads, rows, "aerodynamic coefficients")

    def plot(self, path: str | Path | None = None, *, beside: Sequence[AerodynamicCoefficients] = ()) -> Figure:
        """Inertia and damping over the frequency, with others beside them; saved where a path is given."""
        from fowtlib.solving.results.plots import plot_coefficients

        return plot_coefficients([self, *beside], path)

    def __repr__(self) -> str:
        lines = [f"<AerodynamicCoefficients of {self.turbine}, {self.method}>"]
        lines += [f"{'period [s]':>12}{'inertia [kg]':>16}{'damping [N s/m]':>18}"]
        lines += [f"{1 / f:>12.4g}{a:>16.4g}{b:>18.4g}"
                  for f, a, b in zip(self.frequency, self.inertia, self.damping, strict=True)]  # fmt: skip
        return "\n".join(lines)


def aerodynamic_coefficients(
    model: Any,
    frequencies: Sequence[float] | np.ndarray,
    *,
    turbine: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    state: State | None = None,
) -> AerodynamicCoefficients:
    """Coefficients at frequencies [Hz] of the linear model about the mean, with its controllers in the loop.

    turbine     path of the turbine; None: the only one
    parameters  as for a run: what wind, for instance; its mean counts
    state       mean state; None: found
    The hub is led along the wind without turning, as far as the model lets it move so, whatever else carries it; where
    it stands fast, the wind takes the place of its velocity, which no controller then measures. Raises ModelError for a
    model without such a turbine.
    """
    plant = plant_of(model)
    frequency = checked_frequencies(frequencies)
    part = _turbine(plant.root, turbine)
    if state is None:
        state = mean_state(plant, mean_parameters(plant, parameters))
    transfer = _led(plant, part, state, 2 * np.pi * frequency)
    if transfer is None:
        transfer = _in_changing_wind(plant, part, state, 2 * np.pi * frequency)
    return AerodynamicCoefficients(frequency, transfer, part.path)


def forced_oscillation(
    model: Any,
    frequencies: Sequence[float] | np.ndarray,
    *,
    speed_amplitude: float = 0.5,
    turbine: str | None = None,
    mount: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    periods: int = 4,
    settle: float = 200.0,
    **run: Any,
) -> AerodynamicCoefficients:
    """The same from runs of a model whose hub rides on a ForcedOscillation, one run for each frequency [Hz].

    speed_amplitude [m/s] of the hub; mount: path of that part, None: the only one; periods: so many are kept of each
    run, after two in which the motion grows and `settle` [s]; run: as for plant.simulate, such as solver="fixed".
    Thrust and velocity are compared in their first harmonic. Raises ModelError where the thrust does not settle.
    """
    plant = plant_of(model)
    frequency = checked_frequencies(frequencies)
    part, moved = _turbine(plant.root, turbine), _mount(plant.root, mount)
    thrust, place = join(part.path, "thrust"), join(moved.path, "displacement")
    found = np.empty(frequency.size, dtype=complex)
    for k, f in enumerate(frequency):
        values = {join(moved.path, "speed_amplitude"): speed_amplitude, join(moved.path, "period"): 1 / f}
        start = (2 + np.ceil(settle * f)) / f
        options = {"output_step": 1 / (64 * f), "outputs": [thrust, place], **run}
        result = plant.simulate(start + periods / f, parameters={**(parameters or {}), **values}, **options)
        force, way = (harmonic_fit(result[name], f, harmonics=2, discard=start) for name in (thrust, place))
        if force.unsteadiness > 0.05:
            raise ModelError(
                f"the thrust in an oscillation of {1 / f:g} s still changes by {force.unsteadiness:.0%} from one half "
                "of the record to the other; take a longer time to settle, and steady wind."
            )
        found[k] = force.coefficients[0] / (2j * np.pi * f * way.coefficients[0])
    return AerodynamicCoefficients(frequency, found, part.path, FORCED)


def _turbine(root: Component, path: str | None) -> Component:
    names = ("carrier", "thrust")
    found = {part.path: part for part in root.walk() if all(hasattr(type(part), name) for name in names)}
    return _one(found, path, "turbine", "a turbine (class Turbine or RotorNacelle)")


def _mount(root: Component, path: str | None) -> Component:
    found = {part.path: part for part in root.walk() if isinstance(part, ForcedOscillation)}
    return _one(found, path, "mount", "a ForcedOscillation that its hub rides on")


def _one(found: Mapping[str, Component], path: str | None, option: str, what: str) -> Component:
    if not found:
        raise ModelError(f"this model has no {what.removeprefix('a ')}.")
    if path is None and len(found) > 1:
        raise ModelError(f"this model has {', '.join(found)}; say which by {option}=.")
    if path is not None and path not in found:
        raise ModelError(f"'{path}' is not {what}{did_you_mean(path, list(found), list_up_to=10)}")
    return found[next(iter(found)) if path is None else path]


def _direction(part: Component, state: State) -> np.ndarray:
    """Along the wind (3,)."""
    bearing = float(np.ravel(state[join(part.wind.path, "bearing")])[0])
    return np.array([np.cos(bearing), np.sin(bearing), 0.0])


def _led(plant: Any, part: Component, state: State, omega: np.ndarray) -> np.ndarray | None:
    """Thrust per velocity of a hub that is pushed by what changes its own speed alone; None: it stands in the wind.

    Pushed are the rates of the states that are velocities of the hub, so that the hub moves along the wind and does not
    turn. What the thrust feels of that is the motion of the hub, and what the controllers measure.
    """
    body, frame = part.carrier
    path = join(body.path, frame)
    names = [*(f"{path}.r[{k}]" for k in range(3)), *(f"{path}.w[{k}]" for k in range(3)), join(part.path, "thrust")]
    linear = mean_linear_model(plant, state, (), names)
    A, C = linear.matrices["A"], linear.matrices["C"]
    if np.abs(_direction(part, state) @ C[:3] @ A).max() <= 1e-9:  # it may still turn, as in the bearing of a yaw drive
        return None
    moves = np.abs(np.vstack([C[:3] @ A, C[3:6]])).max(axis=0)
    pushed = np.flatnonzero(moves > 1e-9 * moves.max())
    E, wanted = np.eye(len(A))[:, pushed], np.concatenate([_direction(part, state), np.zeros(3)])
    found = np.empty(omega.size, dtype=complex)
    for k, w in enumerate(omega):
        answer = C @ np.linalg.solve(1j * w * np.eye(len(A)) - A, E)
        motion = np.vstack([1j * w * answer[:3], answer[3:6]])
        push = np.linalg.pinv(motion, rcond=1e-9) @ wanted
        if np.abs(motion @ push - wanted).max() > 1e-4:  # it turns while it moves
            along = wanted[None, :3] @ motion[:3]
            push = np.linalg.pinv(along) @ np.ones(1)
        found[k] = answer[6] @ push
    return found


def _in_changing_wind(plant: Any, part: Component, state: State, omega: np.ndarray) -> np.ndarray:
    """Less the thrust per change of the wind, at a hub that stands fast."""
    wind = part.wind.path
    speed, base = join(wind, "mean_speed"), join(wind, "base")
    station = next((one.station for one in part.parts.values() if hasattr(type(one), "station")), 0)
    names = [join(part.path, "thrust"), f"{base}[{station}]"]
    linear: LinearModel = mean_linear_model(plant, state, [speed], names)
    answer = linear.frequency_response(omega)[:, :, 0]
    return -answer[:, 0] / answer[:, 1]
