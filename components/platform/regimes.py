"""In which regime of wave loads a member is: what `fowt check` says of it.

Keulegan-Carpenter number KC = U T / D and diameter over wave length D / L. U and T are those of the water across the
member where it moves most: U = sqrt(2) times the standard deviation of the velocity, T = 2 pi times the standard
deviation of the way over it, the mean period, and L is the wave length of that period; in a regular wave they are its
own. D is the larger size of the section.
Limits: DNV-RP-C205 (2010), 6.2 and 7.1; O.M. Faltinsen, Sea Loads on Ships and Offshore Structures (1990), ch. 3 and 7.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fowtlib.components.environment.waves import WaveComponents, wave_number
from fowtlib.components.platform.hull import Hull

LARGE = 0.2  # diameter over wave length above which a member scatters the waves
ATTACHED, SEPARATED = 2.0, 25.0  # KC below which drag is small, and above which it governs


@dataclass(frozen=True)
class Regime:
    """Numbers of one member: KC and D / L; both are None for a member above the water."""

    keulegan_carpenter: float | None
    diameter_over_length: float | None

    def says(self, in_database: bool, has_inertia: bool) -> str:
        """One sentence, with advice where the model has no load that the regime asks for."""
        if self.keulegan_carpenter is None or self.diameter_over_length is None:
            return "above the water"
        number, ratio, advice = self.keulegan_carpenter, self.diameter_over_length, ""
        if ratio > LARGE:
            what = "it scatters the waves"
            advice = "" if in_database else "; Morison's formula does not hold, give the floater a database"
        elif number < SEPARATED:
            what = (
                "inertia of the water governs, drag is small" if number < ATTACHED else "inertia and drag both matter"
            )
            if not (in_database or has_inertia):
                advice = "; give it an added_mass_coefficient, or the floater a database"
        else:
            what = "drag governs"
        return f"KC {number:.3g}, diameter over wave length {ratio:.3g}: {what}{advice}"


def regime(hull: Hull, number: int, waves: WaveComponents, gravity: float) -> Regime:
    """The regime of member `number` of a hull in a sea."""
    spans = hull.wet_spans(number)
    if not spans or not len(waves):
        return Regime(None, None)
    member = hull.members[number]
    places = [member.at(s) for a, b, _ in spans for s in np.linspace(a, b, 5)]
    places = np.minimum(np.array(places), [np.inf, np.inf, 0.0])
    across = member.axes[:, :2]
    energy = waves.amplitude**2 / 2
    velocity = waves.velocity_transfer(places) @ across
    variance = np.einsum("n,npi->p", energy, np.abs(velocity) ** 2)
    ways = np.einsum("n,npi->p", energy / waves.omega**2, np.abs(velocity) ** 2)
    most = int(np.argmax(variance))
    speed, way = math.sqrt(variance[most]), math.sqrt(ways[most])
    if not speed:
        return Regime(0.0, 0.0)
    omega = speed / way
    s = float((places[most] - member.start) @ member.axes[:, 2])
    size = float(member.size_at(min(max(s, 0.0), member.length)).max())
    length = 2 * math.pi / float(wave_number(omega, waves.depth, gravity))
    return Regime(math.sqrt(2) * speed * 2 * math.pi / omega / size, size / length)
