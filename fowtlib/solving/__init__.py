"""Floor 3: from a flat DAE to numbers."""

from fowtlib.solving.conditions import Conditions
from fowtlib.solving.linear import LinearModel, Mode
from fowtlib.solving.model import Model, Output
from fowtlib.solving.plant import Plant
from fowtlib.solving.results import Result
from fowtlib.solving.state import State

__all__ = ["Conditions", "LinearModel", "Mode", "Model", "Output", "Plant", "Result", "State"]
