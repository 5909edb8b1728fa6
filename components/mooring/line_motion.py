"""Inertia and drag of a catenary line, with one degree of freedom.

When its fairlead moves by x along the line, a line in balance takes the part u up by another shape, and the rest by
stretch. Drag and inertia hold the shape back, so that fast motions stretch the line: with the tension T in excess,

    T = k_E (x - u) = m u'' + c |u'| u' + k_G u

k_E = EA/l; l is what hangs, and of what lies on the seabed the part that friction does not hold, by the horizontal
tension that is left at the anchor. The shape moves as that of the line in balance does: a point at the length q below
the fairlead moves by r(q) u square to the line, so that m = int (mass + added mass) r^2 dq and, by virtual work,
c = int 1/2 rho C_d D |r|^3 dq.

The tension T_s of the line in balance is that of the whole catenary, not of a spring k_G. Of u_s, what its shape takes
up, u_s' = x' - T_s'/k_E, and with the lag v = u - u_s of the shape behind it

    v' = u' - u_s',    m u'' = -c |u'| u' - (k_E + k_G) v,    T = T_s - k_E v

which is the same model for small motions: slow ones have the tension of the catenary, fast ones k_E x. k_E + k_G =
k_E^2/(k_E - k), k the slope of T_s by x. To T comes the inertia along the line, of a rod that is stretched, a third of
its mass: (mass l/3) x''. It counts where the shape is held back, and that is where motions are fast. All coefficients,
and r(q), are those of the line as it is now: derivatives of the catenary. At rest u' = v = 0, and nothing has changed.

Left out: waves in the line, drag along the line, current and waves at the line, lift off the seabed with
impact. Source: C.M. Larsen and P.C. Sandvik, Marine Structures 3 (1990); H. Lie and N. Sodahl, Simplified dynamic model
for estimation of extreme anchorline tension, Offshore Australia (1993); J.M. Hegseth et al., Marine Structures 72
(2020) 102771, eq. 10-11.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from fowtlib.components.mooring import catenary
from fowtlib.language import Scalar, assert_, der, eq, quadratic, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

POINTS = 6
"""Points of Gauss-Legendre quadrature along what hangs; see tests/mooring/test_line_motion.py for what they leave."""

STILL = 1e-3
"""Speed [m/s] in |u'| u', sqrt(u'^2 + STILL^2), smooth where the shape rests."""

LEAST = 0.01
"""Least share of the motion along the line that its shape takes up; a taut line takes all by stretch."""


class Coefficients(NamedTuple):
    """Coefficients of a line as it hangs; see the module.

    slope [N/m] (2,): of the tension in balance by the fairlead moving away and up; elastic, geometric stiffness [N/m];
    mass: int mu r^2 dq [kg] for mu; drag: int b |r|^3 dq for b [kg/m^2].
    """

    slope: Any
    elastic: Any
    geometric: Any
    mass: Any
    drag: Any


@cache
def _slopes() -> tuple[ca.Function, ca.Function]:
    """Derivatives by (T, V) of the span of a line, with two lengths of it, and of the span of a piece below the top."""
    T, V, q, w, EA = (ca.SX.sym(name) for name in ("T", "V", "q", "w", "EA"))
    L, friction, clearance = (ca.SX.sym(name) for name in ("L", "friction", "clearance"))
    line = catenary.Line(L, w, EA, friction, clearance)  # type: ignore[arg-type]
    both = ca.vertcat(T, V)
    whole = ca.jacobian(ca.vertcat(*catenary.span(T, V, line, m)), both)
    now = catenary.state(T, V, line, m)
    hanging = L - now.grounded
    stretched = hanging + now.grounded * (1 - m.fmin(now.held, 1))
    slope, climb = catenary.hanging_piece(T**2, V - w * q, V, EA, m)
    piece = ca.jacobian(q * ca.vertcat(T * slope, climb), both)
    return (
        ca.Function("line", [T, V, L, w, EA, friction, clearance], [ca.densify(whole), hanging, stretched]),
        ca.Function("piece", [T, V, q, w, EA], [ca.densify(piece)]),
    )


def coefficients(T: Any, V: Any, line: Any, mass: Any, drag: Any) -> Coefficients:
    """Coefficients of a line with these tensions of the catenary at its fairlead [N]; numbers or expressions.

    line: has the attributes of catenary.Line; mass [kg/m]: with added mass; drag [kg/m^2]: 1/2 rho C_d D.
    """
    of_line, of_piece = _slopes()
    w, EA = line.weight, line.axial_stiffness
    F, hanging, stretched = of_line(T, V, line.length, w, EA, line.friction, line.clearance)
    (xx, xz), (zx, zz) = (F[0, 0], F[0, 1]), (F[1, 0], F[1, 1])
    K = ca.vertcat(ca.horzcat(zz, -xz), ca.horzcat(-zx, xx)) / (xx * zz - xz * zx)  # of (H, V) by (x, z)
    top = ca.sqrt(T**2 + V**2)
    along = ca.vertcat(T, V) / top
    elastic = EA / stretched
    taken = ca.fmax(1 - ca.dot(along, K @ along) / elastic, LEAST)  # by the shape, of a motion along the line
    change = K @ along
    inertia, damping = 0, 0
    for at, weight in zip(*np.polynomial.legendre.leggauss(POINTS), strict=True):
        q = hanging * (1 + at) / 2
        moved = along - of_piece(T, V, q, w, EA) @ change
        up = V - w * q
        r = (T * moved[1] - up * moved[0]) / ca.sqrt(T**2 + up**2) / taken
        size = ca.sqrt(r**2 + 1e-12)
        inertia, damping = inertia + hanging * weight / 2 * r**2, damping + hanging * weight / 2 * size**3
    return Coefficients(K.T @ along, elastic, elastic * (1 / taken - 1), mass * inertia, drag * damping)


class Moving(NamedTuple):
    """What its motion adds to a line: tension above that in balance [N], the pull that its body feels, equations."""

    excess: Any
    felt: Any
    equations: list[Any]


def declare(line: Any) -> None:
    """The variables of a line that moves."""
    for name, unit, doc in (
        ("static_tension", "N", "tension at the fairlead of the line in balance"),
        ("dynamic_tension", "N", "tension in excess of that"),
        ("elastic_stiffness", "N/m", "k_E, of the stretch of the line"),
        ("geometric_stiffness", "N/m", "k_G, of its shape"),
        ("generalised_mass", "kg", "inertia of its shape, with the water around it"),
        ("generalised_drag", "kg/m", "quadratic drag of its shape, c"),
        ("axial_mass", "kg", "a third of the mass of what is stretched"),
    ):
        line.declare(name, Scalar, var(unit=unit, doc=doc))
    line.declare("lag", Scalar, var(unit="m", state="prefer", doc="v: shape against that of the line in balance"))
    line.declare("shape_velocity", Scalar, var(unit="m/s", state="prefer", doc="u': velocity of the shape"))


def laws(at: tuple[Any, Any, Any, Any, Any], line: Any) -> Moving:
    """How a line moves; at: its tensions (T of the catenary, V), their size, its pull (3,), its direction in plan."""
    if line.dynamics == "none":
        return Moving(0, 0, [])
    T, V, size, pull, plan = at
    if line.parameter_value("mass_per_length") is None:
        raise ParameterError(f"{line.label}: dynamics need mass_per_length and diameter, instead of weight_per_length.")
    if line.anchor.connected:
        raise ParameterError(f"{line.label}: its anchor is a body; dynamics are those of a line from a fixed anchor.")
    rho, d = line.world.water_density, line.diameter
    mass = line.mass_per_length + line.added_mass_coefficient * rho * m.pi / 4 * d**2
    shape = catenary.Line(line.length, line.weight, line.axial_stiffness, line.friction, line.clearance)
    now = coefficients(T, V, shape, mass, 0.5 * rho * line.drag_coefficient * d)
    u, along = der(line.fairlead.r), pull / size
    follows = m.dot(along, u) - (now.slope[0] * m.dot(plan, u[:2]) + now.slope[1] * u[2]) / line.elastic_stiffness
    restoring = (line.elastic_stiffness + line.geometric_stiffness) * line.lag
    resisting = line.generalised_drag * quadratic(line.shape_velocity, STILL)
    excess = line.axial_mass * m.dot(along, der(u)) - line.elastic_stiffness * line.lag
    return Moving(excess, excess * along if line.dynamics == "coupled" else 0, [
        [eq(line.static_tension, line.intact * size), eq(line.dynamic_tension, line.intact * excess)],
        [eq(line.elastic_stiffness, now.elastic), eq(line.geometric_stiffness, now.geometric)],
        [eq(line.generalised_mass, now.mass), eq(line.generalised_drag, now.drag)],
        eq(line.axial_mass, line.mass_per_length * line.axial_stiffness / line.elastic_stiffness / 3),
        eq(der(line.lag), line.shape_velocity - line.intact * follows),
        eq(line.generalised_mass * der(line.shape_velocity), -resisting - restoring),
        assert_(line.static_tension + line.dynamic_tension >= 0, "the moving line goes slack at its fairlead; snatch "
                "loads are not modelled", "warning"),
    ])  # fmt: skip
