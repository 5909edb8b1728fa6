"""Water inside: tanks with a free surface, pipes, valves and pumps between them, openings to the sea, trapped air."""

from fowtlib.components.flooding.compartments import CompartmentRing
from fowtlib.components.flooding.connectors import Air, Water
from fowtlib.components.flooding.duct import Duct
from fowtlib.components.flooding.floating_piston import FloatingPiston
from fowtlib.components.flooding.lifting_command import LiftingCommand
from fowtlib.components.flooding.openings import Doorway, SeaOpening
from fowtlib.components.flooding.pipe import Pipe
from fowtlib.components.flooding.pump import Pump
from fowtlib.components.flooding.tank import Tank
from fowtlib.components.flooding.tanks import BoxTank, PrismaticTank, RoundTank, TabulatedTank
from fowtlib.components.flooding.throttle import Valve, Vent

__all__ = ["Air", "BoxTank", "CompartmentRing", "Doorway", "Duct", "FloatingPiston", "LiftingCommand", "Pipe",
           "PrismaticTank", "Pump", "RoundTank", "SeaOpening", "TabulatedTank", "Tank", "Valve", "Vent",
           "Water"]  # fmt: skip
