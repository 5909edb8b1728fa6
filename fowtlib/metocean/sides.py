"""Which extreme of a response is meant: its largest value, its smallest one, or its largest absolute value."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from fowtlib.language.errors import ParameterError, did_you_mean

SIDES = ("max", "min", "abs")

Sides = str | Mapping[str, str]
"""One side for all responses, or sides by name; that of "" is for those that are not named, else "max"."""


def label(response: str, side: str) -> str:
    """How a side of a response is called: surge, heave (min), |yaw|."""
    return {"max": response, "min": f"{response} (min)", "abs": f"|{response}|"}[side]


def side_of(sides: Sides, response: str) -> str:
    """The side of one response."""
    return sides if isinstance(sides, str) else sides.get(response, sides.get("", "max"))


def check_sides(sides: Sides, responses: Collection[str], where: str) -> None:
    """Refuse sides that there are not, and names that no response has."""
    for name, side in {"": sides}.items() if isinstance(sides, str) else sides.items():
        if name and name not in responses:
            raise ParameterError(f"a side is given for '{name}'{did_you_mean(name, responses)}", where=where)
        if side not in SIDES:
            raise ParameterError(f"the side of an extreme is max, min or abs, not '{side}'.", where=where)
