"""Floor 2: from a component tree to one flat DAE."""

from fowtlib.flattening.assembler import flatten
from fowtlib.flattening.flat_dae import FlatDAE

__all__ = ["FlatDAE", "flatten"]
