"""Elastic catenary over a flat seabed: the equations, a solver and the shape of the line, in NumPy.

The component CatenaryLine uses `span` with CasADi expressions; tests, pre-processing and plots use the rest.

The line lies in a vertical plane with the anchor at the origin, x towards the fairlead, z up; the seabed is z = 0. At
the fairlead it has the tensions H (horizontal) and V (vertical: the weight of what hangs). With w the weight in water
per length, L the unstretched length, V_a = max(V - w L, 0) the vertical pull on the anchor, B = max(L - V/w, 0) the
length on the seabed and A the part of B that carries tension against the friction coefficient mu,

    x = B + H/w [asinh(V/H) - asinh(V_a/H)] + [H (L - B) + H A - mu w A^2 / 2] / EA
    z = [sqrt(H^2 + V^2) - sqrt(H^2 + V_a^2)] / w + (V^2 - V_a^2) / (2 w EA)

holds on the seabed and lifted off it: the two cases meet with continuous first derivatives where the line lifts off.
The code writes V |V| for V^2, so that a negative V, which an iteration may try, is no second solution.
Source: J. Jonkman, NREL/TP-500-41958 (2007), eq. 2-35 to 2-38, where the two cases are written separately.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fowtlib.language.errors import ModelError

SLACKNESS = 1e-3
"""Horizontal tension, as a share of the line's weight, below which a line counts as slack; see `slack_length`."""


@dataclass(frozen=True)
class Line:
    """A mooring line: unstretched length [m], weight in water [N/m], axial stiffness EA [N], seabed friction [-]."""

    length: float
    weight: float
    axial_stiffness: float
    friction: float = 0.0


def weight_in_water(mass_per_length: Any, diameter: Any, gravity: Any = 9.80665, water_density: Any = 1025.0) -> Any:
    """Weight less buoyancy [N/m] of a line with the volume of a round bar of this diameter."""
    return (mass_per_length - water_density * np.pi / 4 * diameter**2) * gravity


def span(horizontal: Any, vertical: Any, line: Any, xp: Any = np) -> tuple[Any, Any]:
    """Distances (x, z) [m] from anchor to fairlead for the fairlead tensions H > 0 and V [N]; see the module docstring.

    `line` has the attributes of Line; `xp` is the mathematics of the arguments: numpy, or fowtlib.language.math.
    """
    length, w, stiffness = line.length, line.weight, line.axial_stiffness
    H, V = horizontal, vertical
    V_anchor, grounded = xp.fmax(V - w * length, 0), xp.fmax(length - V / w, 0)
    pulled = xp.fmin(grounded, H / (w * xp.fmax(line.friction, 1e-9)))
    T, T_anchor = xp.sqrt(H**2 + V**2), xp.sqrt(H**2 + V_anchor**2)
    asinh = getattr(xp, "asinh", np.arcsinh)
    bow = H / w * (asinh(V / H) - asinh(V_anchor / H))
    stretch = (H * (length - grounded + pulled) - line.friction * w * pulled**2 / 2) / stiffness
    height = (V * xp.abs(V) - V_anchor**2) / w * (1 / (T + T_anchor) + 1 / (2 * stiffness))
    return grounded + bow + stretch, height


def tension_from(coordinate: Any, line: Any, xp: Any = np) -> Any:
    """Horizontal tension H > 0 [N] of any real coordinate p, where p = H / (w L) - slack_length / L."""
    return line.weight * line.length * (coordinate + xp.sqrt(coordinate**2 + 4 * SLACKNESS**2)) / 2


def slack_length(horizontal: Any, line: Any) -> Any:
    """The excess of line [m] heaped up on the seabed, which makes H > 0 for every position of the fairlead.

    A line with length to spare hangs vertically: H = 0, and no catenary reaches the fairlead. The exact statement,
    H >= 0, slack >= 0, H slack = 0, is replaced by H slack = SLACKNESS^2 w L^2 (the log barrier of optimisation).
    The span of a line in service changes by a few millimetres (1e-6 w L^2 / H), and the horizontal pull of a slack line
    stays below SLACKNESS of its weight.
    """
    return SLACKNESS**2 * line.weight * line.length**2 / horizontal


def fairlead_tension(x: float, z: float, line: Line) -> tuple[float, float]:
    """Fairlead tensions (H, V) [N] of a line whose fairlead is x > 0 away from and z > 0 above its anchor [m].

    Both spans increase with their tension, so that two nested bracketed searches find the only solution, however far
    from any estimate. Raises ModelError for a fairlead that is not above the seabed or at an undefined distance.
    """
    from scipy.optimize import brentq

    if not (x > 0 and z > 0):
        raise ModelError(f"the fairlead is at x = {x} m, z = {z} m from the anchor; a catenary needs both above 0.")

    def rising_root(function: Any, low: float, step: float) -> float:
        while function(low + step) < 0:
            low, step = low + step, 2 * step
        return brentq(function, low, low + step, xtol=1e-14 * line.weight * line.length, rtol=1e-14)

    weight = line.weight * line.length

    def vertical(horizontal: float) -> float:
        return rising_root(lambda V: span(horizontal, V, line)[1] - z, 0.0, weight)

    def excess(horizontal: float) -> float:
        return span(horizontal, vertical(horizontal), line)[0] - slack_length(horizontal, line) - x

    horizontal = rising_root(excess, 1e-9 * weight, weight)
    return horizontal, vertical(horizontal)


def stiffness(horizontal: float, vertical: float, line: Line) -> np.ndarray:
    """Derivative of (H, V) by (x, z) [N/m], 2 x 2, at these fairlead tensions; symmetric without friction."""
    import casadi as ca

    from fowtlib.language import math as m

    H, V = ca.SX.sym("H"), ca.SX.sym("V")
    x, z = span(H, V, line, m)
    jacobian = ca.jacobian(ca.vertcat(x - slack_length(H, line), z), ca.vertcat(H, V))
    return np.linalg.inv(np.array(ca.Function("flexibility", [H, V], [jacobian])(horizontal, vertical)))


def profile(horizontal: Any, vertical: Any, line: Line, points: int = 100) -> dict[str, np.ndarray]:
    """Shape of a line with these fairlead tensions [N], from the anchor to the fairlead.

    Returns arrays of `points` values: "arc_length" (unstretched), "x", "z" [m] and "tension" [N]; for tensions (n,)
    arrays (n, points) of the last three. The excess length of a slack line is drawn shortened on the seabed.
    """
    w, s = line.weight, np.linspace(0.0, line.length, points)
    H, V = (np.asarray(value, dtype=float)[..., None] for value in (horizontal, vertical))
    V_anchor, grounded = np.maximum(V - w * line.length, 0.0), np.maximum(line.length - V / w, 0.0)
    V_s = np.where(s < grounded, 0.0, V - w * (line.length - s))
    along = np.maximum(H - line.friction * w * np.maximum(grounded - s, 0.0), 0.0)
    tension = np.hypot(along, V_s)
    bow = H / w * (np.arcsinh(V_s / H) - np.arcsinh(V_anchor / H))
    pulled = np.minimum(grounded, H / (w * max(line.friction, 1e-9)))
    u = np.clip(s - (grounded - pulled), 0.0, pulled)
    stretch = u * (H - line.friction * w * (pulled - u / 2)) + H * np.maximum(s - grounded, 0.0)
    shortened = 1 - slack_length(H, line) / np.where(grounded > 0, grounded, line.length)
    x = np.minimum(s, grounded) * shortened + bow + stretch / line.axial_stiffness
    z = (np.hypot(H, V_s) - np.hypot(H, V_anchor)) / w + (V_s**2 - V_anchor**2) / (2 * w * line.axial_stiffness)
    return {"arc_length": s, "x": x, "z": z, "tension": tension}


def profile_between(
    anchor: Any, fairlead: Any, horizontal: Any, vertical: Any, line: Line, points: int = 100
) -> np.ndarray:
    """Positions (points, 3) [m] along a line, world, from result values: anchor and fairlead positions and tensions.

    From n moments, positions (n, 3) and tensions (n,), it gives (n, points, 3).
    """
    start, end = np.asarray(anchor, dtype=float), np.asarray(fairlead, dtype=float)
    shape = profile(horizontal, vertical, line, points)
    reach = (end - start)[..., None, :2]
    direction = reach / np.maximum(np.linalg.norm(reach, axis=-1, keepdims=True), 1e-12)
    plan = start[..., None, :2] + shape["x"][..., None] * direction
    return np.concatenate([plan, (start[..., 2, None] + shape["z"])[..., None]], axis=-1)
