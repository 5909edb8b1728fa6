"""The turbulence that turning rotors feel as a few winds each, beside that at the stations: one process of all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.components.environment.wind_file import WindSeries
from fowtlib.language import Component
from fowtlib.language.errors import ParameterError
from fowtlib.language.expressions import value_of
from fowtlib.language.run_time import RestingPlaces, TurningRings
from fowtlib.language.series import Series

if TYPE_CHECKING:
    from fowtlib.components.environment.wind.base import Wind

DISC_WINDS = ("thrust", "torque", "tilt moment", "yaw moment")
"""Winds [m/s] of a disc: more wind for more thrust and torque; moments on the hub, about y and about z up."""


class OnDiscs:
    """What a kind of wind knows of its turbulence away from the stations, for rotors in effective winds; for Wind."""

    of_the_air = True

    kind: str
    label: str
    spectral_density: Callable[[ArrayLike], np.ndarray]

    @property
    def turbulent(self) -> bool:
        """Whether it has a spectrum at the stations."""
        return bool(np.any(self.spectral_density(np.geomspace(1e-2, 10.0, 20))))

    def places_density(self, omega: np.ndarray, places: Sequence[TurningRings | RestingPlaces]) -> np.ndarray:
        """One-sided spectra (k, channels, channels) of the fluctuation at places, see disc_turbulence.places_density.

        For kinds with a spectrum and a coherence all over the plane across the wind.
        """
        raise self._of_points()

    def disc_series(self, places: Sequence[TurningRings | RestingPlaces], number: int) -> WindSeries:
        """Fluctuation of the channels of one of the places, a disc; the stations are the first place."""
        raise self._of_points()

    def _of_points(self) -> ParameterError:
        return ParameterError(
            f"{self.label}: a wind of kind '{self.kind}' has turbulence at its stations alone, and a rotor in "
            "effective winds needs it all over its disk; take a wind of kind 'kaimal', 'ntm', 'etm' or 'turbulence'."
        )


class Turbulence:
    """The fluctuation of a wind at its stations, and then on each disc (parts with `turning_disc`): one process.

    Channels: those of RestingPlaces, then of each TurningRings. The process of RandomSignals in language.run_time.
    """

    def __init__(self, wind: Wind):
        self.wind, self.path = wind, wind.path
        self.rotors = _with_discs([wind, *wind.enclosing()][-1])

    @property
    def places(self) -> list[RestingPlaces | TurningRings]:
        """The stations and the discs."""
        return [self.stations, *(rotor.turning_disc() for rotor in self.rotors)]

    @property
    def channels(self) -> int:
        """Number of them; those of the stations where there is no turbulence."""
        discs = self.rotors if self.wind.turbulent else []
        return len(self.wind.hubs) + sum(rotor.turning_disc().channels for rotor in discs)

    @property
    def stations(self) -> RestingPlaces:
        """The places of the stations."""
        return RestingPlaces(np.insert(self.wind.hubs, 0, 0.0, axis=1))

    def spectral_density(self, omega: ArrayLike) -> np.ndarray:
        """One-sided spectra of all channels (k, n, n) [m^2 s^-2/(rad/s)]."""
        if not self.rotors or not self.wind.turbulent:
            return self.wind.spectral_density(omega)
        return self.wind.places_density(np.atleast_1d(np.asarray(omega, dtype=float)), self.places)

    def columns(self, rotor: Any) -> slice:
        """The channels of the disc of a rotor."""
        first = len(self.wind.hubs) + sum(other.turning_disc().channels for other in self.before(rotor))
        return slice(first, first + rotor.turning_disc().channels)

    def before(self, rotor: Any) -> list[Any]:
        """The rotors whose channels come first."""
        return self.rotors[: next(k for k, other in enumerate(self.rotors) if other.path == rotor.path)]


def _with_discs(root: Component) -> list[Any]:
    """The rotors in effective winds; the same within an evaluation."""
    return value_of(root, "with discs", lambda: [part for part in root.walk() if hasattr(type(part), "turning_disc")])


class DiscSignals:
    """The winds DISC_WINDS of a rotor; see RandomSignals of fowtlib.language.run_time."""

    def __call__(self, rotor: Any) -> Series | None:
        turbulence = Turbulence(rotor.wind)
        if not turbulence.wind.turbulent:
            return None
        found = turbulence.wind.disc_series(turbulence.places, len(turbulence.before(rotor)) + 1)
        values = found.values @ signs(rotor.turning_disc()).T
        return Series.samples(values, found.step, found.start, periodic=found.periodic)

    def process(self, rotor: Any) -> Turbulence:
        return Turbulence(rotor.wind)

    def response(self, rotor: Any, omega: ArrayLike) -> np.ndarray:
        turbulence = Turbulence(rotor.wind)
        response = np.zeros((np.size(omega), len(DISC_WINDS), turbulence.channels), dtype=complex)
        response[:, :, turbulence.columns(rotor)] = signs(rotor.turning_disc())
        return response


def signs(disc: TurningRings) -> np.ndarray:
    """DISC_WINDS (4, 4) of the channels of a disc: uniform twice, once round in two directions.

    With the angle theta from y in the sense of the turning, what grows with sin(theta) is more wind above, for a rotor
    that turns from y to z, and tilts the hub about y; what grows with cos(theta) is more wind at y and yaws it to -z.
    """
    turned = np.zeros((4, 4))
    turned[0, 0] = turned[1, 1] = 1
    turned[2, 3], turned[3, 2] = np.sign(disc.speed) or 1, -1
    return turned
