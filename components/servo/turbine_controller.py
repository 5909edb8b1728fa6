"""What every controller of a turbine has."""

from __future__ import annotations

from fowtlib.language import Component, RealInput, RealOutput, port


class TurbineController(Component):
    """Partial: from the generator speed to the blade pitch and the generator torque.

    A class derived from it takes the place of the controller of a turbine, with any further ports of its own.
    """

    generator_speed: RealInput = port(unit="rad/s", doc="generator speed")
    blade_pitch: RealOutput = port(unit="rad", doc="blade pitch")
    generator_torque: RealOutput = port(unit="N*m", doc="generator torque")
