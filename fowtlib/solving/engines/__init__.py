"""The engines that integrate a flat DAE, and the compiled code that they share."""

from fowtlib.solving.engines.base import Engine
from fowtlib.solving.engines.choice import create_engine
from fowtlib.solving.engines.fixed_step_code import FixedStepCode

__all__ = ["Engine", "FixedStepCode", "create_engine"]
