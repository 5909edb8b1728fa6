"""Networks of many small parts, of any size, for measuring the flattening: electrical ones and a drive train."""

from __future__ import annotations

import math

from fowtlib.components.mechanics import FixedFlange, IdealGear, Inertia, TorsionSpringDamper
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

    resistance: Scalar = param(default=1.0, unit="ohm", doc="resistance")

    def equations(self):
        p, n = self.p, self.n
        return [eq(p.v - n.v, self.resistance * p.i), eq(p.i + n.i, 0)]


class Capacitor(TwoPins):
    """i = C dv/dt."""

    capacitance: Scalar = param(default=1.0, unit="F", doc="capacitance")

    v: Scalar = var(unit="V", start=0.0, state="prefer", doc="voltage")

    def equations(self):
        p, n = self.p, self.n
        return [eq(self.v, p.v - n.v), eq(p.i, self.capacitance * der(self.v)), eq(p.i + n.i, 0)]


class Source(TwoPins):
    """A constant voltage between its pins; the negative one is the ground."""

    voltage: Scalar = param(default=1.0, unit="V", doc="voltage")

    def equations(self):
        return [eq(self.n.v, 0), eq(self.p.v, self.voltage)]


def ladder(equations: int) -> Assembly:
    """A ladder of resistors along and capacitors to ground; 6 scalar equations in each cell."""
    model = Assembly("RC ladder")
    model.source = Source()
    before = model.source.p
    for i in range(max(1, equations // 6)):
        resistor = model.add(f"resistor_{i}", Resistor())
        capacitor = model.add(f"capacitor_{i}", Capacitor())
        model.connect(before, resistor.p)
        model.connect(resistor.n, capacitor.p)
        model.connect(capacitor.n, model.source.n)
        before = resistor.n
    return model


def sheet(equations: int) -> Assembly:
    """A square sheet: resistors between neighbours, a capacitor from each node to ground; 8 equations at each node."""
    model = Assembly("RC sheet")
    model.source = Source()
    n = max(2, math.isqrt(equations // 8))
    nodes = {}
    for i in range(n):
        for j in range(n):
            capacitor = model.add(f"capacitor_{i}_{j}", Capacitor())
            nodes[i, j] = capacitor.p
            model.connect(capacitor.n, model.source.n)
            for k, name in (((i - 1, j), "down"), ((i, j - 1), "right")):
                if k in nodes:
                    resistor = model.add(f"{name}_{i}_{j}", Resistor())
                    model.connect(nodes[k], resistor.p)
                    model.connect(resistor.n, capacitor.p)
    feed = model.add("feed", Resistor())
    model.connect(model.source.p, feed.p)
    model.connect(feed.n, nodes[0, 0])
    return model


def drive_train(equations: int) -> Assembly:
    """Shafts in a row: two wheels joined by a gear (one degree of freedom, index reduction), a spring to the next pair.

    13 scalar equations in each cell, and 4 more by differentiation.
    """
    model = Assembly("drive train")
    model.ground = FixedFlange()
    before = model.ground.flange
    for i in range(max(1, equations // 13)):
        spring = model.add(f"spring_{i}", TorsionSpringDamper(stiffness=100.0, damping=1.0))
        slow, fast = model.add(f"slow_{i}", Inertia(inertia=5.0)), model.add(f"fast_{i}", Inertia(inertia=0.5))
        gear = model.add(f"gear_{i}", IdealGear(ratio=3.0))
        model.connect(before, spring.flange_a)
        model.connect(spring.flange_b, slow.flange_a)
        model.connect(slow.flange_b, gear.flange_b)
        model.connect(gear.flange_a, fast.flange_a)
        before = fast.flange_b
    return model
