"""Wave loads on a hull that turns about the vertical: by its heading relative to the waves, now.

With the yaw psi of the hull and the heading beta of the waves the load per unit amplitude, in the heading axes of the
hull, is a function G(omega, theta) of the relative heading theta = beta - psi: X of the database, with the phase of the
place of the hull. G is periodic in theta, so that

    G = sum_m g_m(omega) exp(i m theta),    load(t, psi) = sum_m cos(m psi) C_m(t) + sin(m psi) D_m(t)

with time functions C_m, D_m that do not depend on the motion: they are series of the sea as any other load of waves
(`Sea.signal`), bound when a run starts, exact for every psi and smooth in it.

A hull that turns about a mooring far from its reference point moves this point by more than a wave length. What stays
is the pivot: the waves have their phase there, and the phase between pivot and reference point is in G.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.environment.waves import WaveComponents
from fowtlib.components.hydro.linear_loads import WaveExcitation
from fowtlib.language import Vector, param
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

_LOST = 0.02  # of the motion of a free mass under a load (rms over all headings), beyond which harmonics are too few


class TurningWaveExcitation(WaveExcitation):
    """The wave load on a hull that turns slowly and far, as one that weathervanes: by its yaw now. See the module.

    Yaw may be any, with time; surge and sway of the pivot still change nothing, nor do roll and pitch. A turn counts as
    slow against the waves: X is that of a hull at rest at this heading. In linear models the waves of the sea act at
    the yaw of their state; `wave_transfer`, for response operators, is of yaw zero, with the waves turned instead.
    Raises ParameterError where the harmonics that are left out hold more than 2 % of the motion which one of the loads
    would give a free mass (root mean square over all headings); short waves need most harmonics and move a hull least.
    """

    pivot: Vector = param(
        default=(0, 0, 0), unit="m", bound=True, doc="point about which the hull turns, resolved in its frame"
    )
    harmonics: int = param(default=24, min=0, doc="of the load over the heading; about wave number times half width")

    def equations(self):
        scale, count, size = self.world.water_density / self.database.rho, 2 * self.harmonics + 1, self.motions()
        parts = scale * self.sea.signal(_over_headings, size * count, "wave load over headings", "", of=self)
        axes = self.heading_axes()
        own = _turned([parts[size * i : size * (i + 1)] for i in range(count)], axes)
        load = m.vertcat(axes @ own[:3], axes @ own[3:6], own[6:])
        return [self.driven(load), self.push(self.load())]


def _turned(parts, axes):
    """The sum of C_0, C_1, D_1, C_2, ... with the cosines and sines of multiples of the yaw of the axes."""
    cosine, sine = axes[0, 0], axes[1, 0]
    total, c, s = parts[0], 1, 0
    for C, D in zip(parts[1::2], parts[2::2], strict=True):
        c, s = c * cosine - s * sine, s * cosine + c * sine
        total = total + c * C + s * D
    return total


def _over_headings(waves: WaveComponents, part: TurningWaveExcitation) -> NDArray[np.complex128]:
    """Transfers (n, motions (2 M + 1)) of C_0, C_1, D_1, ... of the waves of a run."""
    M, omega = part.harmonics, waves.omega
    count = max(128, 4 * M)
    heading = 2 * np.pi * np.arange(count) / count
    place, pivot = (np.asarray(part.parameter_value(name), dtype=float) for name in ("position", "pivot"))
    along = pivot[0] * np.cos(heading) + pivot[1] * np.sin(heading)
    load = np.stack([part.database.excitation_at(omega, angle) for angle in heading])
    load = load * np.exp(1j * along[:, None] * waves.wave_number)[:, :, None]
    g = np.fft.fft(load, axis=0) / count
    if np.isfinite(waves.period):
        _check(part, np.abs(g) ** 2, waves.amplitude**2 / omega**4)
    order = np.arange(1, M + 1)
    plus = g[order] * np.exp(1j * order * waves.heading)[:, None, None]
    minus = g[-order] * np.exp(-1j * order * waves.heading)[:, None, None]
    both = np.stack([plus + minus, -1j * (plus - minus)], axis=1).reshape(2 * M, len(omega), part.motions())
    table = np.concatenate([g[:1], both]) * waves.elevation_transfer(place + pivot).reshape(1, -1, 1)
    return table.transpose(1, 0, 2).reshape(len(omega), -1)


def _check(part: TurningWaveExcitation, power: NDArray[np.float64], weight: NDArray[np.float64]) -> None:
    order = np.abs(np.fft.fftfreq(len(power), 1 / len(power)))
    by_order = np.array([np.einsum("jkn,k->n", power[order == k], weight) for k in np.unique(order)])
    left = 1 - np.cumsum(by_order, axis=0) / np.maximum(by_order.sum(axis=0), 1e-300)
    small = np.sqrt(np.maximum(left.max(axis=1), 0.0)) <= _LOST
    if not small[min(part.harmonics, len(small) - 1)]:
        raise ParameterError(
            f"{part.label}.harmonics is {part.harmonics}, too few for the loads of these waves over the heading; "
            f"take {int(np.argmax(small))}, or longer waves."
        )
