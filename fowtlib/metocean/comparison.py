"""The methods of the long term beside each other, from the same laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fowtlib.language.errors import ParameterError
from fowtlib.metocean.contours import cut_off, distance, radius
from fowtlib.metocean.fits import Fits
from fowtlib.metocean.joint import ConditionalModel
from fowtlib.metocean.long_term import LongTerm, Modified, OnContour, full_long_term, on_contour
from fowtlib.metocean.short_term import known
from fowtlib.metocean.states import YEAR, State, States

_NEAR = 0.01  # of the radius: how far a point may lie beside its contour, for states are written with some digits only


@dataclass(frozen=True)
class Answers:
    """What each method says of one response; None where there are no runs for it.

    Values are those of the laws: `fits.sign` times a value is the response, of a minimum its negative.
    """

    fits: Fits
    years: float
    flta: LongTerm | None
    contours: tuple[OnContour, ...]

    @property
    def ecm(self) -> OnContour | None:
        """The contour of the return period itself."""
        return next((each for each in self.contours if abs(each.return_period / self.years - 1) < 1e-6), None)

    @property
    def mecm(self) -> Modified | None:
        """All contours, if there is one beside that of ECM."""
        return Modified(self.contours) if self.ecm is not None and len(self.contours) > 1 else None


def compare_methods(
    joint: ConditionalModel,
    fits: Mapping[str, Fits],
    *,
    years: float = 50.0,
    duration: float = 3600.0,
    cut_offs: Sequence[float] = (),
    fractile: float = 0.9,
    cut_off_fractile: float = 0.5,
) -> list[Answers]:
    """FLTA from the bins of each response, ECM and MECM from its points of contours.

    Points must lie on the contour of `years`, or on one that ends at a wind speed of cut_offs [m/s]; `joint` is to be
    the distribution at the height of the wind speeds.
    """
    levels = {years: (radius(years, duration), fractile)}
    for speed in cut_offs:
        beta, period = cut_off(joint, speed, duration)
        levels[period] = (beta, cut_off_fractile)
    return [
        Answers(each, years, _flta(each, duration), tuple(_on_contours(joint, each, years, levels, duration)))
        for each in fits.values()
    ]


def worst_states(answers: Sequence[Answers], count: int) -> States:
    """The worst states of each contour, so many for each response and each once: those that deserve more seeds.

    ParameterError where no response has points of a contour.
    """
    if count < 1:
        raise ParameterError(f"one worst state or more is to be found, not {count}.")
    found: dict[State, None] = {}
    for each in answers:
        for line in each.contours:
            states = list(line.states)
            found.update(dict.fromkeys(states[index] for index in np.argsort(-line.values, kind="stable")[:count]))
    if not found:
        raise ParameterError("there are no runs on a contour, whose worst states could be found.")
    return States(*np.array(list(found)).T)


def _flta(fits: Fits, duration: float) -> LongTerm | None:
    if fits.bins is None:
        return None
    states, laws = fits.bins
    return full_long_term(states, lambda _: laws, duration=duration)


def _on_contours(
    joint: ConditionalModel,
    fits: Fits,
    years: float,
    levels: Mapping[float, tuple[float, float]],
    duration: float,
) -> list[OnContour]:
    if fits.points is None:
        return []
    states, laws = fits.points
    far = distance(joint, states)
    near = {period: abs(far / beta - 1) < _NEAR for period, (beta, _) in levels.items()}
    lost = ~np.any(list(near.values()), axis=0)
    if lost.any():
        u, h, t = list(states)[int(np.argmax(lost))]
        there = ", ".join(f"{beta:.3f} ({_period(period)})" for period, (beta, _) in levels.items())
        found = far[int(np.argmax(lost))]
        raise ParameterError(
            f"{u:.5g} m/s, Hs {h:.5g} m, Tp {t:.5g} s has no probability and lies on no contour: its distance is "
            f"{found:.3f}, and the contours have {there}. Are height and shear exponent of the wind those of the run "
            "list, and the cut-out speeds named?",
            where=joint.name,
        )
    find = known(states, laws)
    return [
        on_contour(states[near[period]], find, years=years, beta=beta, fractile=fractile, duration=duration)
        for period, (beta, fractile) in levels.items()
        if near[period].any()
    ]


def _period(years: float) -> str:
    return f"{years:g} years" if years >= 1 else f"{years * YEAR / 3600:.4g} h"
