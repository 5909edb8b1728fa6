"""Floor 2: from a component tree to one flat DAE."""

from fowtlib.flattening.assembler import flatten
from fowtlib.flattening.flat_dae import FlatDAE
from fowtlib.flattening.kept import flat

__all__ = ["FlatDAE", "flat", "flatten"]
