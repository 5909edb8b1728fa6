"""A turbine between two others, or beyond: geometric similarity, and power laws through two turbines that are known.

Similarity at equal tip speed: with the length l, power ~ l^2, torque ~ l^3, mass ~ l^3, moment of inertia ~ l^5, speed
~ 1/l, time ~ l (P. Jamieson, Innovation in Wind Turbine Design (2011), chapter 4). Real turbines grow slower than that.
Between two that are known, what belongs to the rotor goes with a power of its radius, and what belongs to nacelle and
drive train with a power of the rated torque; the powers are those that pass through both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fowtlib.design.rules.either import demand

ROTOR = {"rotor_mass": 3.0, "rotor_inertia": 5.0, "overhang": 1.0, "drop": 1.0, "roll_inertia": 5.0}
"""What goes with the radius, and the power that similarity has for it."""

DRIVE = {"nacelle_mass": 1.0, "generator_inertia": 5 / 3, "gear_ratio": 0.0}
"""What goes with the rated torque, and the power that similarity has for it."""


@dataclass(frozen=True)
class TurbineSizes:
    """A turbine above its tower, in SI.

    rated_speed: of the rotor [rad/s]; optimal_constant: torque over speed^2 of the rotor at its best [N m s^2/rad^2];
    rotor_inertia: about the shaft; generator_inertia: on the side of the rotor; overhang, drop: centre of mass of the
    nacelle behind and below the hub; roll_inertia: of nacelle and rotor about x through their centre, without that of
    the rotor; spread, lean: their other moments of inertia over those of a disk and two points (see `inertia`).
    """

    name: str
    radius: float
    rated_power: float
    rated_speed: float
    optimal_constant: float
    rotor_mass: float
    nacelle_mass: float
    rotor_inertia: float
    generator_inertia: float
    gear_ratio: float
    overhang: float
    drop: float
    roll_inertia: float
    spread: tuple[float, float] = (1.0, 1.0)
    lean: float = 1.0
    tilt: float = math.radians(5)

    @property
    def mass(self) -> float:
        return self.rotor_mass + self.nacelle_mass

    @property
    def rated_torque(self) -> float:
        """On the side of the rotor."""
        return self.rated_power / self.rated_speed

    @property
    def centre(self) -> tuple[float, float]:
        """Its centre of mass, x and z from the hub, where the rotor counts as a point."""
        share = self.nacelle_mass / self.mass
        return share * self.overhang, -share * self.drop

    @property
    def inertia(self) -> tuple[float, float, float, float]:
        """I_xx, I_yy, I_zz and I_xz [kg m^2] about the centre of mass, without the rotor about its shaft.

        Of a disk with half of its moment of inertia about its diameters, and two points: I_yy and I_zz times `spread`,
        I_xz times `lean`.
        """
        half, apart = self.rotor_inertia / 2, self.rotor_mass * self.nacelle_mass / self.mass
        y, z = half + apart * (self.overhang**2 + self.drop**2), half + apart * self.overhang**2
        xz = half * math.sin(self.tilt) * math.cos(self.tilt) + apart * self.overhang * self.drop
        return self.roll_inertia, self.spread[0] * y, self.spread[1] * z, self.lean * xz


def similar(turbine: TurbineSizes, radius: float, name: str = "") -> TurbineSizes:
    """The turbine, larger or smaller, by similarity at equal tip speed."""
    demand("a turbine", 0.0, radius=radius)
    s = radius / turbine.radius
    powers = {**ROTOR, **{key: 3 * power for key, power in DRIVE.items()}, "optimal_constant": 5.0}
    scaled = {key: getattr(turbine, key) * s**power for key, power in powers.items()}
    return replace(turbine, name=name or f"{turbine.name}, {radius:g} m", radius=radius,
                   rated_power=turbine.rated_power * s**2, rated_speed=turbine.rated_speed / s, **scaled)  # fmt: skip


def powers_between(first: TurbineSizes, second: TurbineSizes) -> dict[str, float]:
    """The powers of radius and rated torque with which each quantity goes from one turbine to the other."""
    by_radius, by_torque = second.radius / first.radius, second.rated_torque / first.rated_torque
    found = {key: math.log(getattr(second, key) / getattr(first, key)) / math.log(by_radius) for key in ROTOR}
    return found | {key: math.log(getattr(second, key) / getattr(first, key)) / math.log(by_torque) for key in DRIVE}


def between(
    first: TurbineSizes, second: TurbineSizes, radius: float, rated_power: float, name: str = ""
) -> TurbineSizes:  # fmt: skip
    """A turbine of a radius [m] and a rated power [W] by the power laws through two others.

    Its rotor is as good as that of the second: optimal_constant ~ R^5. Its rated speed is such that the rated power is
    the same share of what the rotor at its best would give there, (P/R^5)^(1/3). spread and lean go evenly with radius.
    """
    demand("a turbine", 0.0, radius=radius, rated_power=rated_power)
    powers = powers_between(first, second)
    constant = second.optimal_constant * (radius / second.radius) ** 5
    share = second.rated_power / (second.optimal_constant * second.rated_speed**3)
    speed = (rated_power / (share * constant)) ** (1 / 3)
    s, t = radius / second.radius, rated_power / speed / second.rated_torque
    sizes = {key: getattr(second, key) * s ** powers[key] for key in ROTOR}
    sizes |= {key: getattr(second, key) * t ** powers[key] for key in DRIVE}
    x = (radius - first.radius) / (second.radius - first.radius)

    def evenly(a: float, b: float) -> float:
        return a + x * (b - a)

    spread = (evenly(first.spread[0], second.spread[0]), evenly(first.spread[1], second.spread[1]))
    return TurbineSizes(name or f"{rated_power / 1e6:g} MW", radius, rated_power, speed, constant, spread=spread,
                        lean=evenly(first.lean, second.lean), tilt=second.tilt, **sizes)  # fmt: skip


def pitch_gains(
    turbine: TurbineSizes, known: TurbineSizes, proportional: float, integral: float
) -> tuple[float, float]:  # fmt: skip
    """Gains [s] and [-] on the speed of the rotor, of the same damping, and of a frequency that goes with 1/R.

    proportional, integral: those of the known turbine. K_p ~ omega I Omega/P and K_i ~ omega^2 I Omega/P, where the
    slope of the power by the pitch goes with the rated power; M. Hansen et al., Risoe-R-1500 (2005), for this form.
    """

    def measure(t: TurbineSizes) -> float:
        return (t.rotor_inertia + t.generator_inertia) * t.rated_speed / t.rated_power

    ratio, faster = measure(turbine) / measure(known), known.radius / turbine.radius
    return proportional * ratio * faster, integral * ratio * faster**2


def _known(name: str, mass: float, centre: tuple[float, float], inertia: tuple[float, float, float, float],
           **sizes: float) -> TurbineSizes:  # fmt: skip
    """From the mass, centre and inertia of nacelle and rotor together: overhang, drop, spread and lean follow."""
    share = sizes["nacelle_mass"] / mass
    bare = TurbineSizes(name, overhang=centre[0] / share, drop=-centre[1] / share, roll_inertia=inertia[0], **sizes)
    _, y, z, xz = bare.inertia
    return replace(bare, spread=(inertia[1] / y, inertia[2] / z), lean=inertia[3] / xz)


NREL_5MW = _known(
    "NREL 5-MW", 350e3, (4.586229, -0.433011), (183105.0, 23495810.0, 25054195.0, 2065324.0),
    radius=63.0, rated_power=5.0e6, rated_speed=12.1 * math.pi / 30, optimal_constant=2.332287 * 97.0**3,
    rotor_mass=110e3, nacelle_mass=240e3, rotor_inertia=38759227.0, generator_inertia=534.116 * 97.0**2,
    gear_ratio=97.0,
)  # fmt: skip
"""J. Jonkman et al., NREL/TP-500-38060 (2009); centre and inertia as in models/turbines/nrel5mw_rigid.yaml."""

DTU_10MW = _known(
    "DTU 10-MW", 676753.0, (6.13190, -0.57966), (1158891.0, 100106215.0, 99357924.0, 8439504.0),
    radius=89.1655, rated_power=10.0e6, rated_speed=9.6 * math.pi / 30, optimal_constant=100.461 * 50.0**3,
    rotor_mass=230717.0, nacelle_mass=446036.0, rotor_inertia=156420266.0, generator_inertia=1500.4 * 50.0**2,
    gear_ratio=50.0,
)  # fmt: skip
"""C. Bak et al., DTU Vindenergi-I-0092 (2013); centre and inertia as in models/turbines/dtu10mw_rigid.yaml."""
