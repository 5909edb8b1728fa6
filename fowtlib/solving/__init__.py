"""Floor 3: from a flat DAE to numbers."""

from fowtlib.solving.conditions import Conditions
from fowtlib.solving.linear import LinearModel, Mode
from fowtlib.solving.mean_linear import mean_linear_model
from fowtlib.solving.model import Model, Output
from fowtlib.solving.modes import NaturalMode, natural_modes
from fowtlib.solving.plant import Plant
from fowtlib.solving.results import Result
from fowtlib.solving.state import State
from fowtlib.solving.tangents import Sensitivities, sensitivities
from fowtlib.solving.timeline import Event
from fowtlib.solving.turning import mean_state

__all__ = [
    "Conditions",
    "Event",
    "LinearModel",
    "Mode",
    "Model",
    "NaturalMode",
    "Output",
    "Plant",
    "Result",
    "Sensitivities",
    "State",
    "mean_linear_model",
    "mean_state",
    "natural_modes",
    "sensitivities",
]
