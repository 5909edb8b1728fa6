"""A ladder of resistors and capacitors of any length: a model with many small parts, for measuring the flattening."""

from __future__ import annotations

from fowtlib.language import Assembly, Component, Connector, Scalar, der, eq, flow, param, port, potential, var


class Pin(Connector):
    """Electrical pin."""

    v = potential(unit="V", doc="potential")
    i = flow(unit="A", doc="current into the component")


class TwoPins(Component):
    """A part between two pins."""

    p: Pin = port(doc="positive pin")
    n: Pin = port(doc="negative pin")


class Resistor(TwoPins):
    """Ohm's law: v = R i."""

    resistance: Scalar = param(default=1.0, unit="V/A", doc="resistance")

    def equations(self):
        p, n = self.p, self.n
        return [eq(p.v - n.v, self.resistance * p.i), eq(p.i + n.i, 0)]


class Capacitor(TwoPins):
    """i = C dv/dt."""

    capacitance: Scalar = param(default=1.0, unit="A*s/V", doc="capacitance")

    v: Scalar = var(unit="V", start=0.0, state="prefer", doc="voltage")

    def equations(self):
        p, n = self.p, self.n
        return [eq(self.v, p.v - n.v), eq(p.i, self.capacitance * der(self.v)), eq(p.i + n.i, 0)]


class Source(TwoPins):
    """A constant voltage between its pins; the negative one is the ground."""

    voltage: Scalar = param(default=1.0, unit="V", doc="voltage")

    def equations(self):
        return [eq(self.n.v, 0), eq(self.p.v, self.voltage)]


EQUATIONS_PER_CELL = 13  # 5 of the two parts, 8 of their connections: 5 potentials and 3 flows


def ladder(equations: int) -> Assembly:
    """A ladder of about this many scalar equations."""
    model = Assembly("RC ladder")
    model.source = Source()
    before = model.source.p
    for i in range(max(1, equations // EQUATIONS_PER_CELL)):
        resistor = model.add(f"resistor_{i}", Resistor())
        capacitor = model.add(f"capacitor_{i}", Capacitor())
        model.connect(before, resistor.p)
        model.connect(resistor.n, capacitor.p)
        model.connect(capacitor.n, model.source.n)
        before = resistor.n
    return model
