"""Stresses by which towers, arms and wires are sized, from the loads that a model has in them."""

from __future__ import annotations

import math

from fowtlib.language import Component, RealInput, Scalar, eq, param, port, var
from fowtlib.language import math as m


class TubeStress(Component):
    """Greatest bending stress in a section of a round tube, and its share of the yield stress.

    stress = 4 r M / (pi (r^4 - r_i^4)) with the outer and inner radius r and r_i, and M = sqrt(M_1^2 + M_2^2) of the
    two bending moments. Axial force, shear and torsion are left out. A design asks for a utilization of at most 1 over
    its safety factor.
    """

    diameter: Scalar = param(unit="m", min=1e-6, doc="outer diameter")
    wall_thickness: Scalar = param(unit="m", min=1e-9, doc="wall thickness")
    yield_stress: Scalar = param(unit="Pa", min=1e-9, doc="yield stress of the material")

    moment_1: RealInput = port(unit="N*m", doc="bending moment about one axis of the section")
    moment_2: RealInput = port(unit="N*m", doc="bending moment about the other")

    stress: Scalar = var(unit="Pa", doc="greatest bending stress")
    utilization: Scalar = var(doc="stress over yield stress")

    def equations(self):
        outer = self.diameter / 2
        inner = outer - self.wall_thickness
        moment = m.smooth_norm(m.vertcat(self.moment_1, self.moment_2), 1.0)  # N m, for slopes at rest
        return [
            eq(self.stress, 4 * outer * moment / (math.pi * (outer**4 - inner**4))),
            eq(self.utilization, self.stress / self.yield_stress),
        ]


class WireStress(Component):
    """Stress in the metal of a wire rope, its share of the grade, and the smallest diameter that the rope may have.

    stress = 4 T / (pi f d^2). least_diameter = sqrt(4 T gamma / (pi f k R)), with the fill factor f, the spinning
    factor k, the grade R and the partial factor gamma. Source: EN 1993-1-11, 2.3 and 6.2.
    """

    diameter: Scalar = param(unit="m", min=1e-6, doc="diameter of the rope")
    fill_factor: Scalar = param(default=0.8, min=1e-3, max=1.0, doc="metal over the area of the circle")
    spinning_factor: Scalar = param(default=0.9, min=1e-3, max=1.0, doc="strength of the rope over that of its wires")
    grade: Scalar = param(default=1.96e9, unit="Pa", min=1e-9, doc="strength of the wires")
    partial_factor: Scalar = param(default=1.4, min=0, doc="partial factor of the resistance")

    tension: RealInput = port(unit="N", doc="tension of the rope")

    stress: Scalar = var(unit="Pa", doc="stress in the metal")
    utilization: Scalar = var(doc="stress over grade")
    least_diameter: Scalar = var(unit="m", doc="smallest diameter for this tension; 0 for a rope that would be pushed")

    def equations(self):
        metal = math.pi / 4 * self.fill_factor
        strength = metal * self.spinning_factor * self.grade
        return [
            eq(self.stress, self.tension / (metal * self.diameter**2)),
            eq(self.utilization, self.stress / self.grade),
            eq(self.least_diameter, m.sqrt(m.fmax(self.tension, 0) * self.partial_factor / strength)),
        ]
