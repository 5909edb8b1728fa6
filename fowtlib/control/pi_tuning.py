"""PI gains of blade pitch control for a wanted frequency and damping, from the model's own linearisation.

The rotor alone, with the platform and the other rotors held, answers at the wanted frequency like w' = a w + b pitch
for small changes of the generator speed w; drive train, blades, wake and generator torque of its turbine take part. The
gains k_P = -(2 zeta omega + a) / b and k_I = -omega^2 / b give it the wanted frequency omega and damping ratio zeta in
each wind. J. Jonkman et al., NREL/TP-500-38060 (2009), section 7.3 has the same without a, and fits b linearly in the
pitch, as here: the gains of a PitchController are those at zero pitch over 1 + 2 pitch / doubling_pitch, or, with
`scheduled: gains`, over 1 + pitch / doubling_pitch.

On a floating platform the rotor is not alone: the poles of the whole model in each wind say whether pitch or yaw of the
platform lose their damping (T. J. Larsen and T. D. Hanson, J. Phys.: Conf. Ser. 75 (2007) 012073).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fowtlib.components.servo import LeastPitch, PitchController
from fowtlib.control.points import OVER, rest_at
from fowtlib.control.reduction import opened
from fowtlib.language.declarations import join
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.language.operators import transfer_matrix
from fowtlib.solving import Model, NaturalMode, Plant, State, natural_modes

LEAST_PITCH = np.radians(0.5)
"""Blade pitch below which a rotor is not in the region where pitch holds its speed."""
LEAST_EFFECT = 0.25
"""Share of the effect of pitch in the weakest wind with pitch below which that at zero pitch is not taken."""
SLOPES = {"pitch": 2, "gains": 1}
"""How much faster than 1 / G the gains for small changes fall, by what PitchController.scheduled multiplies by G."""
WATCHED = ("platform pitch", "platform yaw")


@dataclass(frozen=True)
class RotorResponse:
    """w' = a w + b pitch of the generator speed, at a wind [m/s] and blade pitch [rad]: a [1/s], b [1/s^2]."""

    wind: float
    pitch: float
    a: float
    b: float

    def gains(self, frequency: float, damping: float) -> tuple[float, float]:
        """k_P [s] and k_I for a frequency [rad/s] and a damping ratio of the rotor alone."""
        return -(2 * damping * frequency + self.a) / self.b, -(frequency**2) / self.b

    def closed(self, proportional: float, integral: float) -> tuple[float, float]:
        """Frequency [rad/s] and damping ratio of the rotor alone under these gains."""
        omega = float(np.sqrt(max(-self.b * integral, 0.0)))
        return omega, float(-(self.a + self.b * proportional) / (2 * omega)) if omega else float("nan")


@dataclass(frozen=True)
class Tuned:
    """PI gains at zero pitch, and the pitch at which they are halved: parameters of PitchController.

    responses: of the rotor at the winds they come from. error: largest deviation of b from its straight line, as a
    share of b. scheduled: that of the PitchController.
    """

    proportional_gain: float
    integral_gain: float
    doubling_pitch: float
    responses: Sequence[RotorResponse]
    error: float
    scheduled: str = "pitch"

    def at(self, pitch: float) -> tuple[float, float]:
        """k_P and k_I for small changes about a blade pitch [rad]."""
        factor = 1 / (1 + SLOPES[self.scheduled] * pitch / self.doubling_pitch)
        return self.proportional_gain * factor, self.integral_gain * factor


@dataclass(frozen=True)
class Poles:
    """The modes of the whole model in a wind [m/s], by fowtlib.natural_modes, and the blade pitch [rad] there."""

    wind: float
    pitch: float
    modes: Sequence[NaturalMode] = field(repr=False)

    def mode(self, name: str) -> NaturalMode | None:
        """The mode of this name; the first where it is told apart by others."""
        return next((mode for mode in self.modes if mode.name.split(",")[0] == name), None)

    def growing(self) -> list[NaturalMode]:
        """Motions and controllers that do not decay."""
        return [mode for mode in self.modes if mode.eigenvalue.real > 1e-6 * abs(mode.eigenvalue)]


class PitchLoop:
    """The blade pitch control of one turbine in a model: what it looks like to its PitchController.

    path: of the PitchController; None: the only one, or the first of several equal turbines.
    Raises ModelError where the model has none, or one that is sampled.
    """

    def __init__(self, model: Model, path: str | None = None):
        self.model = model.in_the_mean()
        self.paths = [part.path for part in self.model.root.walk() if isinstance(part, PitchController)]
        if not self.paths:
            raise ModelError("the model has no PitchController, the part whose gains are tuned.")
        if path is not None and path not in self.paths:
            raise ModelError(f"'{path}' is no PitchController; there are {', '.join(self.paths)}.")
        self.path = path or self.paths[0]
        self.plant: Plant = self.model.compile()
        if f"{self.path}.pitch" not in self.plant.layout.x:
            raise ModelError(f"{self.path}: a sampled controller has no linear model; leave sample_period out to tune.")

    @property
    def scheduled(self) -> str:
        """What the schedule of the PitchController multiplies: `pitch` or `gains`."""
        return str(self.model.root.find(self.path).scheduled)

    @property
    def speed(self) -> str:
        """Path of the generator speed before its filter."""
        owner = self.path.rpartition(".")[0]
        part = self.model.root.find(owner) if owner else self.model.root
        return f"{owner}.generator_speed" if "generator_speed" in part.ports else f"{self.path}.speed"

    @property
    def turbine(self) -> str:
        """Path of the turbine, the nearest part around the PitchController that has a thrust; empty for the model."""
        path = self.path
        while path and "thrust" not in self.model.root.find(path).ports:
            path = path.rpartition(".")[0]
        return path

    def parameter(self, name: str, path: str | None = None) -> str:
        """Where a parameter of the PitchController is set: its own path, or the one that it is taken from."""
        path = path or self.path
        owner = path.rpartition(".")[0]
        known = self.plant.layout.p
        return next(place for place in (f"{owner}.{name}", f"{path}.{name}") if place in known)

    def parameters(self, tuned: Tuned) -> dict[str, float]:
        """The tuned gains by path, of all PitchControllers of the model."""
        names = ("proportional_gain", "integral_gain", "doubling_pitch")
        values, given = self.plant.parameter_values(), {}
        for path in self.paths:
            given |= {self.parameter(name, path): getattr(tuned, name) for name in names}
            if np.any(values[f"{path}.schedule_curvature"]):
                given[f"{path}.schedule_curvature"] = 0.0
        return given

    def shifted_region_3(self, pitch: float) -> dict[str, float]:
        """The pitch [rad] from which the torque is that of region 3, raised: that of peak shaving does not count."""
        values, given = self.plant.parameter_values(), {}
        for path in self.paths:
            name = f"{path.rpartition('.')[0]}.torque.region_3_pitch"
            if name in values:
                given[name] = float(np.ravel(values[name])[0]) + pitch
        return given

    def state(self, wind: float, parameters: Mapping[str, Any] | None = None) -> State:
        """The model at rest in a wind [m/s]. Raises SimulationError that names it."""
        return rest_at(self.plant, OVER, wind, parameters)

    def response(self, wind: float, frequency: float = 0.2) -> RotorResponse:
        """How the rotor answers in a wind at a frequency [rad/s]; the turbine is at its own operating point there."""
        state = self.state(wind)
        cut = opened(self.plant.linearize(state, outputs=[self.speed]), [f"{self.path}.pitch"])
        own = [k for k, name in enumerate(cut.states) if name.startswith(join(self.turbine, ""))]
        A, B, C, D = (cut.matrices[name] for name in "ABCD")
        to_speed = transfer_matrix(1j * frequency, A[np.ix_(own, own)], B[own, -1:], C[:, own], D[:, -1:])
        inverse = 1 / to_speed[0, 0, 0]  # (i omega - a) / b
        b = frequency / inverse.imag
        return RotorResponse(wind, float(state[f"{self.path}.pitch"]), float(-b * inverse.real), float(b))

    def poles(self, winds: Iterable[float], tuned: Tuned | None = None) -> list[Poles]:
        """The modes of the whole model in each wind, with the gains of the model or with tuned ones."""
        found, given = [], self.parameters(tuned) if tuned else {}
        for wind in winds:
            state = self.state(wind, given)
            found.append(Poles(float(wind), float(state[f"{self.path}.pitch"]), natural_modes(self.plant, state)))
        return found


@dataclass(frozen=True)
class Shaved:
    """Least blade pitch [rad] in a wind [m/s] that keeps the thrust at its limit; thrust [N] and power [W] of both.

    shaft_power, blade_pitch: mechanical power of the generator [W] and blade pitch [rad] with it.
    """

    wind: float
    least_pitch: float
    thrust: tuple[float, float]
    power: tuple[float, float]
    shaft_power: float
    blade_pitch: float


def shave_peak(loop: PitchLoop, winds: Iterable[float], share: float) -> list[Shaved]:
    """The least pitch over the wind with which the steady thrust stays below a share of its largest, at rest.

    For the winds given, of which the one with the largest thrust sets the limit. Raises ParameterError for a share
    outside of 0.5 to 1, and where no pitch below 20 deg is enough.
    """
    from scipy.optimize import brentq

    if not 0.5 <= share <= 1:
        raise ParameterError(f"peak shaving to {share:g} of the largest thrust; give 0.5 to 1.")
    least = loop.parameter("least_pitch")
    own = float(np.ravel(loop.plant.parameter_values()[least])[0])

    def at(wind: float, pitch: float) -> tuple[float, float, float, float]:
        given = {loop.parameter("least_pitch", path): pitch for path in loop.paths}
        given |= loop.shifted_region_3(pitch - own)
        state = loop.state(wind, given)
        names = ("thrust", "generator_power", "generator_torque", "generator_speed")
        thrust, power, torque, speed = (float(np.ravel(state[join(loop.turbine, name)])[0]) for name in names)
        return thrust, power, torque * speed, float(state[f"{loop.path}.pitch"])

    before = {float(wind): at(float(wind), own) for wind in winds}
    limit = share * max(thrust for thrust, *_ in before.values())
    rows = []
    for wind, (thrust, power, *rest) in before.items():
        if thrust <= limit:
            rows.append(Shaved(wind, own, (thrust, thrust), (power, power), *rest))
            continue
        highest = float(np.radians(20.0))
        if at(wind, highest)[0] > limit:
            raise ParameterError(f"at {wind:g} m/s no pitch below 20 deg keeps the thrust at {limit / 1e3:.0f} kN.")
        pitch = float(brentq(lambda value, wind=wind: at(wind, value)[0] - limit, own, highest, xtol=1e-5))
        after = at(wind, pitch)
        rows.append(Shaved(wind, pitch, (thrust, after[0]), (power, after[1]), *after[2:]))
    return rows


def least_pitch(rows: Iterable[Shaved], own: float = 0.0) -> LeastPitch:
    """Rows of shave_peak as the table of the part PeakShaving: what is added to the controller's own least pitch [rad].

    Up to the wind in which the shaved power is largest; there, and beyond, the controller pitches by itself, and the
    least pitch is what it takes there. Raises ParameterError where fewer than two winds have different powers.
    """
    powers: list[float] = []
    raised: list[float] = []
    for row in sorted(rows, key=lambda row: row.wind):
        if powers and row.shaft_power <= 1.001 * powers[-1]:
            continue
        powers.append(row.shaft_power)
        shaved = row.thrust[1] < row.thrust[0]
        by_itself = row.blade_pitch if any(raised) and not shaved else row.least_pitch
        raised.append(max([by_itself - own, *raised[-1:]]))
    if len(powers) < 2:
        raise ParameterError("peak shaving needs two winds or more with different powers; give winds below rated too.")
    return LeastPitch(np.array(powers), np.array(raised))


def tune_pi(loop: PitchLoop, winds: Iterable[float], frequency: float, damping: float = 0.7) -> Tuned:
    """PI gains for a frequency [rad/s] and a damping ratio of the rotor alone, and their schedule over the pitch.

    One schedule serves k_I, so that the frequency is met in all winds as well as b is a straight line over the pitch;
    k_P is the least with which no wind has less damping. Winds in which the blades are not pitched do not count; two
    others are needed. Raises ParameterError.
    """
    if not (np.isfinite(frequency) and frequency > 0 and np.isfinite(damping) and damping > 0):
        raise ParameterError(f"frequency {frequency:g} rad/s and damping ratio {damping:g}: both must be positive.")
    winds = [float(wind) for wind in winds]
    responses = [response for wind in winds if (response := loop.response(wind, frequency)).pitch > LEAST_PITCH]
    if len(responses) < 2:
        raise ParameterError(
            f"of the winds {', '.join(f'{wind:g}' for wind in winds)} m/s the blades are pitched in {len(responses)}; "
            "give at least two above rated wind."
        )
    pitch, b = (np.array([getattr(item, name) for item in responses]) for name in ("pitch", "b"))
    if np.any(b >= 0):
        wind = responses[int(np.argmax(b))].wind
        raise ParameterError(f"at {wind:g} m/s the rotor speeds up with the blade pitch; no PI control holds it.")
    zero, slope = _line(pitch, -b)
    share = SLOPES[loop.scheduled]
    doubling = share * zero / slope
    factor = 1 + share * pitch / doubling
    met = np.sqrt(-b * frequency**2 / zero / factor)
    needed = [item.gains(float(omega), damping)[0] for item, omega in zip(responses, met, strict=True)]
    proportional = max(float(np.max(np.array(needed) * factor)), 0.0)
    error = float(np.max(np.abs(zero * factor + b) / -b))
    return Tuned(proportional, float(frequency**2 / zero), float(doubling), tuple(responses), error, loop.scheduled)


def _line(pitch: np.ndarray, effect: np.ndarray) -> tuple[float, float]:
    """Zero and slope of a line with the least relative error; zero at least LEAST_EFFECT of the first effect.

    In the steady wake of a table a rotor hardly answers to pitch near its best pitch; gains that are the inverse of
    that would be without bounds there, where the wake of a real rotor does not follow at once.
    """
    first = int(np.argmin(pitch))
    columns = np.column_stack([np.ones_like(pitch), pitch]) / effect[:, None]
    zero, slope = np.linalg.lstsq(columns, np.ones_like(effect), rcond=None)[0]
    least = LEAST_EFFECT * effect[first]
    if zero < least:
        zero = least
        weighted = pitch / effect
        slope = weighted @ (1 - zero / effect) / (weighted @ weighted)
    if slope <= 0:
        raise ParameterError("the rotor does not answer more to pitch in stronger wind; give winds further apart.")
    return float(zero), float(slope)
