"""Water inside: tanks with a free surface, pipes, valves and pumps between them, openings to the sea, trapped air."""

from fowtlib.components.flooding.compartments import CompartmentRing
from fowtlib.components.flooding.connectors import Air, Water
from fowtlib.components.flooding.floating_piston import FloatingPiston
from fowtlib.components.flooding.lifting_command import LiftingCommand
from fowtlib.components.flooding.pipe import Pipe
from fowtlib.components.flooding.pump import Pump
from fowtlib.components.flooding.tank import Tank
from fowtlib.components.flooding.tanks import BoxTank, RoundTank

__all__ = [
    "Air",
    "BoxTank",
    "CompartmentRing",
    "FloatingPiston",
    "LiftingCommand",
    "Pipe",
    "Pump",
    "RoundTank",
    "Tank",
    "Water",
]
