"""Floor 2: from a component tree to one flat DAE."""

from fowtlib.flattening.flat_dae import FlatDAE
from fowtlib.flattening.assembler import flatten

__all__ = ["FlatDAE", "flatten"]
