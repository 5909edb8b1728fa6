"""The states of the airfoils of a rotor in unsteady flow."""

from __future__ import annotations

import casadi as ca

from fowtlib.language import Array, Component, der, eq, initial, param, stage_step, var
from fowtlib.language import math as m


class AirfoilStates(Component):
    """What the flow at each section remembers, as an UnsteadyAirfoil has it; the rates come from the rotor's loads.

    Starts in the steady state. In the steps of the fixed-step engine the function of the loads solves for these states
    itself, so that they add no unknowns there.
    """

    memory = "flow at the airfoils"

    sections: int = param(min=1, doc="number of sections, blade by blade from root to tip")
    units: list = param(doc="units of the states of a section, as its model has them")

    downwash: Array = var(
        unit="m/s", shape=lambda self: (self.sections * self.units.count("m/s"),), state="prefer",
        doc="lags of the shed wake, two for each section"
    )  # fmt: skip
    delayed: Array = var(
        shape=lambda self: (self.sections * self.units.count("1"),), state="prefer",
        doc="delayed lift coefficient, if the model has it, and place of separation, 1: attached, for each section"
    )  # fmt: skip
    downwash_rate: Array = var(
        unit="m/s^2", shape=lambda self: (self.sections * self.units.count("m/s"),), doc="rates of the lags"
    )
    delayed_rate: Array = var(
        unit="1/s", shape=lambda self: (self.sections * self.units.count("1"),), doc="rates of the others"
    )

    def pairs(self):
        """States and their rates, where the model has them."""
        pairs = ((self.downwash, self.downwash_rate), (self.delayed, self.delayed_rate))
        return [(state, rate) for state, rate in pairs if state.numel()]

    def by_section(self):
        """All states, those of a section in a row; and the step of a stage, see stage_step."""
        states = [ca.reshape(state, -1, self.sections) for state, _ in self.pairs()]
        return ca.vec(ca.vertcat(*states)), stage_step(ca.vertcat(*[ca.vec(state) for state in states]))

    def moved(self, rates):
        """Equations of the rates, given section by section."""
        rows = ca.vertsplit(ca.reshape(rates, -1, self.sections), 1)
        found, first = [], 0
        for state, rate in self.pairs():
            count = state.numel() // self.sections
            found.append(eq(rate, ca.vec(ca.vertcat(*rows[first : first + count]))))
            first += count
        return found

    def equations(self):
        return [[eq(der(state), rate), initial(rate, m.zeros(rate.numel()))] for state, rate in self.pairs()]
