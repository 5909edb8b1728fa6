"""Rings of water: what lies between a wall and a narrower one in it."""

from __future__ import annotations

from typing import Any

from fowtlib.language import Component, assert_
from fowtlib.language.errors import ParameterError


def refuse_inside_out(part: Component, inner: str, outer: str) -> None:
    """Raise ParameterError where the inner diameter of a part, by its parameters' names, is not below the outer one."""
    one, other = (float(part.parameter_value(name)) for name in (inner, outer))
    if not one < other:
        raise ParameterError(
            f"{part.label}.{inner} = {one:g} m must be below its {outer}, {other:g} m: no water fits between them."
        )


class AroundAPiston(Component):
    """Partial: water between a shaft of a `diameter` and a piston of a `piston_diameter`, which must be narrower."""

    def build(self):
        refuse_inside_out(self, "piston_diameter", "diameter")

    def stays_a_ring(self) -> Any:
        """The same for values that a run is given."""
        inner, outer = self.piston_diameter, self.diameter
        said = "its piston_diameter, {inner} m, must be below its diameter, {outer} m"
        return assert_(inner < outer, said, inner=inner, outer=outer)
