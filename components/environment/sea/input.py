"""Waves from outside of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fowtlib.components.environment.sea.base import Sea, Transfer
from fowtlib.language import math as m
from fowtlib.language import open_input

if TYPE_CHECKING:
    import casadi as ca


class InputSea(Sea, kind="input"):
    """All that the parts ask of the sea is an input of the model, which a wave generator drives.

    The elevation, each wave load, the velocity of the water at each point. It has other equations than the other kinds,
    and takes their place before the model is compiled only.
    """

    def signal(
        self, transfer: Transfer, columns: int, name: str = "wave signal", unit: str = "1", *, of: Any = None
    ) -> ca.SX:
        return open_input(name.replace(" ", "_"), columns, unit, f"{name} from outside")

    def loads(self, transfer: Transfer, name: str = "wave load", *, motions: int = 6, of: Any = None) -> ca.SX:
        parts = [self.signal(transfer, 3, f"{name} force", "N"), self.signal(transfer, 3, f"{name} moment", "N*m")]
        if motions > 6:
            parts.append(self.signal(transfer, motions - 6, f"{name} on shapes", "N"))
        return m.vertcat(*parts)
