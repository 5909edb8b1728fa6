"""Water inside: tanks with a free surface, pipes, valves and pumps between them, openings to the sea, trapped air."""

from fowtlib.components.flooding.connectors import Air, Water
from fowtlib.components.flooding.openings import Doorway, SeaOpening
from fowtlib.components.flooding.pipe import Pipe
from fowtlib.components.flooding.pump import Pump
from fowtlib.components.flooding.tank import Tank
from fowtlib.components.flooding.tanks import BoxTank, PrismaticTank, RoundTank, TabulatedTank
from fowtlib.components.flooding.throttle import Valve, Vent

__all__ = ["Air", "BoxTank", "Doorway", "Pipe", "PrismaticTank", "Pump", "RoundTank", "SeaOpening", "TabulatedTank",
           "Tank", "Valve", "Vent", "Water"]  # fmt: skip
