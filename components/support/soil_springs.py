"""Springs of the soil around a piece of a pile, by the p-y laws of sand and clay."""

from __future__ import annotations

from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, Scalar, Vector, der, eq, param, port, var
from fowtlib.language import math as m
from fowtlib.language.bounds import POSITIVE

_APART = 1e-6  # m; within it of the place at rest a spring is linear


class SoilSpring(Component):
    """Partial: the soil around a piece of a pile, as a lateral spring in any direction and linear ones along and about.

    The lateral force on the frame points back to its place at rest, p(y) per length of the piece by the distance y from
    it; a subclass says p / y. The soil keeps no memory: no gap, no loss of energy but by damping_time, no cyclic
    degradation beyond that of the law.
    """

    place: Vector = param(unit="m", doc="place of the frame at rest, world; z < mudline")
    length: Scalar = param(unit="m", min=0, doc="length of pile for which it stands")
    axial_stiffness: Scalar = param(unit="N/m^2", min=0, doc="vertical stiffness per length of pile")
    torsional_stiffness: Scalar = param(unit="N*m/rad/m", min=0, doc="stiffness about the vertical per length of pile")
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over the secant stiffness")

    frame: Frame = port(doc="on the axis of the pile; z up")

    distance: Scalar = var(unit="m", doc="lateral distance from the place at rest")
    resistance: Scalar = var(unit="N/m", doc="lateral force per length of pile")

    def secant(self, distance):
        """Lateral stiffness per length p / y [N/m^2] at a distance y > 0 [m]."""
        raise NotImplementedError

    def equations(self):
        moved, R = self.frame.r - self.place, self.frame.R
        across = self.secant(self.distance)
        stiffness = self.length * m.vertcat(across, across, self.axial_stiffness)
        turn = m.atan2(R[1, 0], R[0, 0]) + self.damping_time * self.frame.w[2]
        return [
            eq(self.distance, m.smooth_norm(moved[:2], _APART)),
            eq(self.resistance, across * self.distance),
            eq(self.frame.f, stiffness * (moved + self.damping_time * der(self.frame.r))),
            eq(self.frame.t, m.vertcat(0, 0, self.length * self.torsional_stiffness * turn)),
        ]


class LinearSoilSpring(SoilSpring):
    """Soil of one lateral stiffness, that of Winkler."""

    lateral_stiffness: Scalar = param(unit="N/m^2", min=0, doc="lateral stiffness per length of pile")

    def secant(self, distance):
        return self.lateral_stiffness


class SandSpring(SoilSpring):
    """Sand around a pile: p = A p_u tanh(k z y / (A p_u)).

    p_u is the lesser of a wedge (C_1 z + C_2 D) gamma z and of flow around the pile C_3 D gamma z, with coefficients by
    the friction angle phi (alpha = phi / 2, beta = 45 deg + phi / 2, K_0 = 0.4). A = max(3 - 0.8 z / D, 0.9), or 0.9
    for cyclic loads. Sources: L.C. Reese, W.R. Cox and F.D. Koop, OTC 2080 (1974); M.W. O'Neill and J.M. Murchison
    (1983); API RP 2A. They were made for slender piles of up to some 2 m.
    """

    depth: Scalar = param(unit="m", min=0, doc="depth below the mudline")
    diameter: Scalar = param(unit="m", min=POSITIVE, doc="diameter of the pile")
    friction_angle: Scalar = param(unit="rad", min=POSITIVE, max=0.9, doc="angle of internal friction")
    unit_weight: Scalar = param(unit="N/m^3", min=POSITIVE, doc="weight of the soil in water per volume")
    modulus_gradient: Scalar = param(unit="N/m^3", min=POSITIVE, doc="k: growth of the subgrade modulus with depth")
    cyclic: bool = param(default=True, doc="cyclic loads; else static ones")

    def strength(self):
        """p_u [N/m]."""
        z, d, (c1, c2, c3) = self.depth, self.diameter, sand_coefficients(self.friction_angle)
        return self.unit_weight * z * m.fmin(c1 * z + c2 * d, c3 * d)

    def secant(self, distance):
        factor = 0.9 if self.cyclic else m.fmax(3 - 0.8 * self.depth / self.diameter, 0.9)
        most = factor * self.strength()
        return most * m.tanh(self.modulus_gradient * self.depth * distance / most) / distance


def sand_coefficients(friction_angle):
    """C_1, C_2 and C_3 of the resistance of sand by its friction angle [rad]; see SandSpring."""
    phi, alpha, beta = friction_angle, friction_angle / 2, m.pi / 4 + friction_angle / 2
    rest, active, tan = 0.4, m.tan(m.pi / 4 - friction_angle / 2) ** 2, m.tan(beta)
    ahead = tan**2 * m.tan(alpha) / m.tan(beta - phi)
    beside = m.tan(phi) * m.sin(beta) / (m.cos(alpha) * m.tan(beta - phi))
    below = tan * (m.tan(phi) * m.sin(beta) - m.tan(alpha))
    return (
        ahead + rest * (beside + below),
        tan / m.tan(beta - phi) - active,
        active * (tan**8 - 1) + rest * m.tan(phi) * tan**4,
    )


class ClaySpring(SoilSpring):
    """Soft clay around a pile: p = p_u / 2 (y / y_50)^(1/3) up to p_u at 8 y_50, y_50 = 2.5 epsilon_50 D.

    p_u = min(3 + gamma z / c + J z / D, 9) c D. Near y = 0 the law is a line of the slope `initial_stiffness` p_u /
    (D epsilon_50^0.25) up to where it meets the cube root. Both corners are rounded: 6 % less at the first, 3 % less at
    8 y_50. Static loads. Sources: H. Matlock,
    OTC 1204 (1970); the slope at 0: DNV-OS-J101, appendix F.
    """

    depth: Scalar = param(unit="m", min=0, doc="depth below the mudline")
    diameter: Scalar = param(unit="m", min=POSITIVE, doc="diameter of the pile")
    shear_strength: Scalar = param(unit="Pa", min=POSITIVE, doc="c: undrained shear strength")
    unit_weight: Scalar = param(unit="N/m^3", min=POSITIVE, doc="weight of the soil in water per volume")
    strain_50: Scalar = param(default=0.01, min=1e-4, doc="epsilon_50: strain at half of the strength")
    shape: Scalar = param(default=0.5, min=0, doc="J: 0.25 to 0.5")
    initial_stiffness: Scalar = param(default=10.0, min=0.1, doc="10 for normally, 30 for over-consolidated clay")

    def strength(self):
        """p_u [N/m]."""
        z, d, c = self.depth, self.diameter, self.shear_strength
        return m.fmin(3 + self.unit_weight * z / c + self.shape * z / d, 9) * c * d

    def secant(self, distance):
        half = 2.5 * self.strain_50 * self.diameter
        slope = self.initial_stiffness / (self.diameter * self.strain_50**0.25)
        rounded = (0.5 / (slope * half ** (1 / 3))) ** 1.5
        x = 0.5 * distance / (half ** (1 / 3) * (distance**8 + rounded**8) ** (1 / 12))
        return self.strength() * x / (1 + x**20) ** 0.05 / distance
