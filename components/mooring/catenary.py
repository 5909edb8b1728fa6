"""Elastic catenary, free or over a flat seabed: the equations, a solver and the shape of the line, in NumPy.

The component CatenaryLine uses `lateral_stiffness` and `state` with CasADi expressions; tests and pre-processing the
rest.

The line lies in a vertical plane with its anchor at the origin, x towards the fairlead, z up; the seabed lies the
clearance D >= 0 below the anchor. At the fairlead the line has the tensions H (horizontal) and V (vertical, positive:
the line pulls down), at the anchor V_a (positive: the line pulls up). With w the weight in water per length, of either
sign, L the unstretched length, B the length on the seabed and l = L - B what hangs, V - V_a = w l. With T and T_a the
tensions at both ends of what hangs,

    x = B + stretch of B + H l [2 artanh(u) / (u (T + T_a)) + 1 / EA],   u = w l / (T + T_a)
    z = l (V + V_a) [1 / (T + T_a) + 1 / (2 EA)]

This is the textbook catenary: artanh(u) is half of asinh(V/H) - asinh(V_a/H), and (V^2 - V_a^2) / (T + T_a) is T - T_a.
Written so, nothing divides by w or by H: a line without weight in water is the straight elastic line, a line that
floats is an arch, and a vertical line has the lateral stiffness H / x = 1 / (l [...]).

The line touches the seabed where its lowest point would lie deeper than D: then V_a = -P, the pull of what hangs from
the anchor to the seabed, T_P - H + P^2 / (2 EA) = w D, and B = L - (V + P) / w. For an anchor on the seabed D = P = 0.
Friction holds a line on the seabed that lies towards its anchor (D = 0) and takes its tension up.

A line with length to spare hangs vertically: no catenary reaches its fairlead, the excess lies on the seabed, and H = 0
leaves V alone to tell where it is. Here every line is drawn aside, square to its plane, by a constant horizontal force
h (`scales`), which moves it by the distance d it takes: the catenary of the horizontal tension T_h = sqrt(H^2 + h^2)
spans sqrt(x^2 + d^2), and H / x = h / d = k, the lateral stiffness. A line in service does not feel it (x grows by
(h / H)^2 / 2 of itself, 1e-12 or so); of a slack one d is what makes up for the excess, and it pulls with H = h x / d.
A line under a constant force has a potential, so this one has.
Source: J. Jonkman, NREL/TP-500-41958 (2007), eq. 2-35 to 2-38, for D = 0 and w > 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fowtlib.language.errors import ModelError

ASIDE = 1e-6
"""Constant horizontal force that draws every line aside, as a share of its weight; see the module docstring."""

LIGHT = 1e-6
"""Weight in water, as a share of the axial stiffness, below which a line counts as one without weight; see `scales`."""


@dataclass(frozen=True)
class Line:
    """Unstretched length [m], weight in water [N/m], axial stiffness EA [N], seabed friction [-], clearance [m].

    The clearance is the height of the anchor above the seabed; math.inf where there is no seabed.
    """

    length: float
    weight: float
    axial_stiffness: float
    friction: float = 0.0
    clearance: float = 0.0


def weight_in_water(mass_per_length: Any, diameter: Any, gravity: Any = 9.80665, water_density: Any = 1025.0) -> Any:
    """Weight less buoyancy [N/m] of a line with the volume of a round bar of this diameter."""
    return (mass_per_length - water_density * np.pi / 4 * diameter**2) * gravity


# --- the equations, for numbers and expressions -----------------------------------------------------------------------


def scales(line: Any, xp: Any = np) -> tuple[Any, Any, Any]:
    """Forces [N]: the measure of the tensions of a line, the force that draws it aside, the share of a light line.

    The first is the weight in water; for a line whose weight is less than LIGHT of its stiffness, LIGHT of its
    stiffness. The second keeps all derivatives finite where a line carries nothing: ASIDE of the weight; of a light
    line 0.3 LIGHT of the stiffness, which makes up for the shape that such a line has no weight to take.
    """
    weight, floor = line.weight * line.length, LIGHT * line.axial_stiffness
    light = floor**3 / (floor**2 + weight**2)
    return xp.abs(weight) + light, ASIDE * xp.abs(weight) + 0.3 * light, light


class State(NamedTuple):
    """What the tensions at the fairlead say of a line; see the module docstring."""

    force: Any
    """The force of `scales` [N]."""
    anchor: Any
    """Vertical tension V_a at the anchor [N]."""
    grounded: Any
    """Length B on the seabed [m]."""
    held: Any
    """Horizontal tension that friction could take, over the line's; from 1 on, nothing of it reaches the anchor."""
    flexibility: Any
    """What the horizontal tension draws out of the line, per newton [m/N], besides what lies on the seabed."""
    height: Any
    """Height of the fairlead above the anchor [m]."""


def state(horizontal: Any, vertical: Any, line: Any, xp: Any = np) -> State:
    """The line with these tensions at the fairlead [N], the horizontal one above 0: that of the catenary, T_h.

    `line` has the attributes of Line; `xp` is the mathematics of the arguments: numpy, or fowtlib.language.math.
    """
    w, length, stiffness, T, V = line.weight, line.length, line.axial_stiffness, horizontal, vertical
    force, aside, _ = scales(line, xp)
    sinks = w > 0
    heavy = _if(xp, sinks, w, force / length)  # what does not sink touches no seabed
    drop = 2 * stiffness * heavy * xp.fmin(line.clearance, 10 * length)
    rise = drop / (xp.sqrt((stiffness + T) ** 2 + drop) + stiffness + T)  # T_P - T
    P = xp.sqrt(rise * (2 * T + rise) + (0.01 * aside) ** 2) - 0.01 * aside
    free, below = V - w * length, xp.fmin(V, 0)  # only an iteration tries a fairlead under the seabed
    V_anchor = _if(xp, sinks, xp.fmax(free, below - P), free)
    grounded = _if(xp, sinks, xp.fmax(length - (V - below + P) / heavy, 0), 0)
    slope, climb = hanging_piece(T**2, V_anchor, V, stiffness, xp)
    # friction holds only what lies towards its anchor
    held = _if(xp, line.clearance > 0, 0, line.friction * w * grounded / T)
    stretched = grounded * _if(xp, held < 1, 1 - held / 2, 0.5 / xp.fmax(held, 1)) / stiffness
    sinking = grounded * below / force  # below the seabed it falls on: no second solution
    hanging = length - grounded
    return State(force, V_anchor, grounded, held, hanging * slope + stretched, hanging * climb + sinking)


def span(horizontal: Any, vertical: Any, line: Any, xp: Any = np) -> tuple[Any, Any]:
    """Distances (x, z) [m] from anchor to fairlead for fairlead tensions H > 0 and V [N]: the catenary by itself."""
    now = state(horizontal, vertical, line, xp)
    return now.grounded + horizontal * now.flexibility, now.height


def lateral_stiffness(coordinate: Any, line: Any, xp: Any = np) -> Any:
    """Lateral stiffness k = H / x > 0 [N/m] of any real coordinate p.

    With the force F of `scales`, p is k L / F of a taut line, and -q of a slack one, where (d / L)^2 = q (1 + d / L):
    numbers that are in proportion to the tension of the first, and to the length that the second has to spare. Where
    k L / F is about e = (h / F)^(2/3), one passes smoothly into the other.
    """
    force, aside, _ = scales(line, xp)
    share = aside / force
    e = share ** (2 / 3)
    # (root + p) / 2 and (root - p) / 2 without the difference of equal numbers; their product is e^2
    larger = (xp.sqrt(coordinate**2 + 4 * e**2) + xp.abs(coordinate)) / 2
    taut = _if(xp, coordinate > 0, larger, e**2 / larger)
    q = e**2 / taut
    distance = (q + xp.sqrt(q**2 + 4 * q)) / 2
    return xp.sqrt(taut**2 + (share / distance) ** 2) * force / line.length


def catenary_tension(horizontal: Any, line: Any, xp: Any = np) -> Any:
    """T_h [N] of a line that pulls its fairlead with H >= 0."""
    return xp.sqrt(horizontal**2 + scales(line, xp)[1] ** 2)


def reached(horizontal: Any, vertical: Any, line: Any, xp: Any = np) -> tuple[Any, Any]:
    """Distances (x, z) [m] from anchor to fairlead of the line that is drawn aside, for H >= 0 and V [N]."""
    T = catenary_tension(horizontal, line, xp)
    now = state(T, vertical, line, xp)
    return horizontal * (now.grounded / T + now.flexibility), now.height


def _if(xp: Any, condition: Any, then: Any, otherwise: Any) -> Any:
    return getattr(xp, "if_else", np.where)(condition, then, otherwise)


def hanging_piece(square: Any, V_start: Any, V_end: Any, axial_stiffness: Any, xp: Any) -> tuple[Any, Any]:
    """A hanging piece, per unstretched length: horizontal distance per newton [1/N], and height [-].

    square: of the horizontal tension; V_start, V_end: the vertical tensions at its ends.
    """
    T_start, T_end = xp.sqrt(square + V_start**2), xp.sqrt(square + V_end**2)
    total, change = T_start + T_end, xp.abs(V_end - V_start)
    u, sign = change / total, _if(xp, V_end < V_start, -1, 1)

    def less(T: Any, V: Any) -> Any:  # T - V, without the loss of digits where both are large
        high = T + xp.abs(V)
        return _if(xp, V > 0, square / high, high)

    small, large = xp.fmin(u, 0.1) ** 2, xp.fmax(u, 0.1)
    series = 1 / 15
    for k in (13, 11, 9, 7, 5, 3, 1):
        series = 1 / k + small * series
    log = xp.log((total + change) / (less(T_end, sign * V_end) + less(T_start, -sign * V_start)))
    slope = 2 * _if(xp, u < 0.1, series, log / (2 * large)) / total + 1 / axial_stiffness
    return slope, (V_start + V_end) * (1 / total + 1 / (2 * axial_stiffness))


# --- numbers ----------------------------------------------------------------------------------------------------------


def fairlead_tension(x: float, z: float, line: Line) -> tuple[float, float]:
    """Fairlead tensions (H, V) [N] of a line whose fairlead is x >= 0 away from and z above its anchor [m].

    Both spans increase with their tension, so that two nested bracketed searches find the only solution, however far
    from any estimate. Raises ModelError for a fairlead that is under the seabed or at an undefined distance.
    """
    from scipy.optimize import brentq

    if not (x >= 0 and z > -line.clearance):
        raise ModelError(
            f"the fairlead is at x = {x} m, z = {z} m from the anchor, and the seabed is {line.clearance} m below the "
            "anchor; a catenary needs x not below 0, and a fairlead above the seabed."
        )
    force = float(scales(line)[0])

    def rising_root(function: Any, low: float, step: float) -> float:
        while function(low) > 0:
            low, step = low - step, 2 * step
        step = force
        while function(low + step) < 0:
            low, step = low + step, 2 * step
        return brentq(function, low, low + step, xtol=1e-14 * force, rtol=1e-14)

    def vertical(horizontal: float) -> float:
        return rising_root(lambda V: float(reached(horizontal, V, line)[1]) - z, 0.0, force)

    if x == 0:
        return 0.0, vertical(0.0)
    horizontal = rising_root(lambda H: float(reached(H, vertical(H), line)[0]) - x, 1e-30 * force, force)
    return horizontal, vertical(horizontal)


def stiffness(horizontal: float, vertical: float, line: Line) -> np.ndarray:
    """Derivative of (H, V) by (x, z) [N/m], 2 x 2, at these fairlead tensions; symmetric without friction."""
    import casadi as ca

    from fowtlib.language import math as m

    H, V = ca.SX.sym("H"), ca.SX.sym("V")
    jacobian = ca.jacobian(ca.vertcat(*reached(H, V, line, m)), ca.vertcat(H, V))
    return np.linalg.inv(np.array(ca.Function("flexibility", [H, V], [jacobian])(horizontal, vertical)))


def profile(horizontal: Any, vertical: Any, line: Line, points: int = 100, drawn: Any = None) -> dict[str, np.ndarray]:
    """Shape of a line with these fairlead tensions [N], from the anchor to the fairlead.

    drawn: the tension T_h of the catenary, where the line is a section of another that is drawn aside as a whole.
    Returns arrays of `points` values: "arc_length" (unstretched), "x", "z" [m] and "tension" [N]; for tensions (n,)
    arrays (n, points) of the last three. Seen in its plane: the excess length of a slack line, which lies aside, is
    drawn shortened.
    """
    w, s = line.weight, np.linspace(0.0, line.length, points)
    H, V = (np.asarray(value, dtype=float)[..., None] for value in (horizontal, vertical))
    T = catenary_tension(H, line) if drawn is None else np.asarray(drawn, dtype=float)[..., None]
    now = state(T, V, line)
    grounded, divisor = now.grounded, np.where(now.grounded > 0, now.grounded, 1.0)
    touch = np.where(grounded > 0, np.maximum(-now.anchor, 0) / (w if w > 0 else 1), 0.0)
    lying = np.clip(s - touch, 0.0, grounded)
    hanging = s - lying
    V_s = now.anchor + w * hanging
    left = H * np.maximum(1 - now.held * (1 - lying / divisor), 0.0)
    pulled = grounded / np.maximum(now.held, 1)
    u = np.clip(lying - (grounded - pulled), 0.0, pulled)
    stretch = T * u * (1 - now.held / divisor * (pulled - u / 2)) / line.axial_stiffness
    slope, climb = hanging_piece(T**2, now.anchor, V_s, line.axial_stiffness, np)
    x, z = H / T * (lying + stretch + T * hanging * slope), hanging * climb
    return {"arc_length": s, "x": x, "z": z, "tension": np.hypot(left, V_s)}


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
