"""What stands for an external function in the equations while it is compiled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class ToCome:
    """Name and lengths of the columns of a function, as CasADi's Function gives them; `made` waits for it."""

    called: str
    inputs: int
    outputs: int
    made: Callable[[], ca.Function]

    def name(self) -> str:
        """Its name."""
        return self.called

    def n_in(self) -> int:
        """One column."""
        return 1

    def n_out(self) -> int:
        """One column."""
        return 1

    def size1_in(self, _: int) -> int:
        """Length of the column of inputs."""
        return self.inputs

    def numel_out(self, _: int) -> int:
        """Length of the column of outputs."""
        return self.outputs

    def size1_out(self, _: int) -> int:
        """Length of the column of outputs."""
        return self.outputs

    def size2_out(self, _: int) -> int:
        """One column."""
        return 1
