"""Floor 2: from a component tree to one flat DAE."""

from fowtlib.flattening.assembler import flatten
from fowtlib.flattening.flat_dae import FlatDAE
from fowtlib.flattening.kept import dimensions_of, flat

__all__ = ["FlatDAE", "dimensions_of", "flat", "flatten"]
