"""The engines that integrate a flat DAE, and the compiled code that they share."""

from fowtlib.solving.engines.base import Engine
from fowtlib.solving.engines.choice import create_engine

__all__ = ["Engine", "create_engine"]
