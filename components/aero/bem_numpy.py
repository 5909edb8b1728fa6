"""The rotor of bem.c once more, in NumPy: the oracle of its tests, and what runs without a compiler.

Written apart from the C text: induction factors and interpolation in a bracket, where the C code has speeds and
Newton's method.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from fowtlib.components.aero.airfoil_models import SectionFlow

if TYPE_CHECKING:
    from fowtlib.components.aero.bem import BladeElementRotor

Loads = Callable[[np.ndarray], np.ndarray]
Coefficients = Callable[[np.ndarray, np.ndarray], np.ndarray]  # c_l, c_d, c_m at angle of attack and speed
PER_NODE = ("position", "orientation", "velocity", "wind", "turn_rate", "airfoil_states")
EDGE = 1e-6
LEAST_SWIRL_LOSS = 0.1
"""Below this factor of the tip and hub loss the swirl no longer grows as one over it, see bem.c."""


def loads(rotor: BladeElementRotor, inputs: np.ndarray) -> np.ndarray:
    """Outputs for the inputs of BladeElementRotor, each as one column."""
    parts = np.split(np.asarray(inputs, dtype=float), np.cumsum(list(rotor.inputs.values()))[:-1])
    n = rotor.nodes
    part = dict(zip(rotor.inputs, parts, strict=True))
    position, velocity, wind = (part[name].reshape(n, 3) for name in ("position", "velocity", "wind"))
    axes = part["orientation"].reshape(n, 3, 3)  # a row of this is a column of the matrix: an axis
    chordwise_normal, span = axes[:, 0], axes[:, 2]
    normal = part["hub_orientation"][:3]
    skew_wind = part["disk_wind"] - part["hub_velocity"]

    tangent = rotor.rotation * _unit(np.cross(span, normal))  # to the trailing edge
    downwind = np.cross(rotor.rotation * tangent, span)
    relative = wind - velocity
    arm = position - part["hub_position"]
    radius = np.sqrt(_dot(arm, arm) - (arm @ normal) ** 2)
    twist = np.arctan2(-_dot(chordwise_normal, tangent), _dot(chordwise_normal, downwind))
    spin = _dot(part["hub_velocity"] - velocity, tangent)
    chord = np.tile(part["chord"], rotor.blades)
    section = _Sections(rotor, _dot(relative, downwind), _dot(relative, tangent), twist, radius, chord)
    section.turning(spin, relative - spin[:, None] * tangent, radius)
    given = np.tile(part["induced"], rotor.blades) if rotor.dynamic_inflow else None
    model, airfoils = rotor.airfoil_model, np.tile(section.airfoil, rotor.blades)
    turn = states = np.zeros((0, n))
    if model.states:
        turn, states = rotor.rotation * part["turn_rate"], part["airfoil_states"].reshape(n, -1).T
    step, rates = float(part["stage_step"][0]) if model.states else 0.0, []

    def flow(angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        told = SectionFlow(angle, speed, chord, turn, states, step, airfoils)
        found, rate = model.flow(section.coefficients, told, section.foils)
        rates.append(rate)
        return found

    axial, tangential, moment, induced = section.loads(_skew(rotor, skew_wind, normal, arm), flow, given)
    scale = (part["air_density"] * np.tile(rotor.lengths, rotor.blades))[:, None]
    force = axial[:, None] * downwind + tangential[:, None] * tangent
    result = np.hstack([scale * force, scale * rotor.rotation * moment[:, None] * span]).ravel()
    more = [induced] if rotor.dynamic_inflow else []
    return np.concatenate([result, *more, *(rate.T.ravel() for rate in rates)])


def jacobian(
    rotor: BladeElementRotor, inputs: np.ndarray, relative_step: float = 1e-6, function: Loads | None = None
) -> np.ndarray:
    """Slope of the outputs, by central differences; the same input of every node is moved at once, (outputs, inputs).

    function: the outputs of the inputs, by default those of this module.
    """
    function, u = function or (lambda x: loads(rotor, x)), np.asarray(inputs, dtype=float)
    n, result = rotor.nodes, np.zeros((sum(rotor.outputs.values()), len(inputs)))
    start, ends = 0, np.cumsum([0, *rotor.outputs.values()])
    rows = [np.arange(first, end).reshape(n, -1) for first, end in zip(ends[:-1], ends[1:], strict=True)]
    for name, size in rotor.inputs.items():
        per_node = size // n if name in PER_NODE else 0
        if name == "stage_step":  # nobody needs it
            continue
        for k in range(per_node or size):
            columns = start + k + per_node * np.arange(n) if per_node else np.array([start + k])
            step = relative_step * max(1.0, np.abs(u[columns]).max())
            move = np.zeros(len(u))
            move[columns] = step
            slope = (function(u + move) - function(u - move)) / (2 * step)
            if per_node:
                for own in rows:
                    result[own, columns[:, None]] = slope[own]
            else:
                result[:, start + k] = slope
        start += size
    return result


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)


def _unit(a: np.ndarray) -> np.ndarray:
    return a / np.linalg.norm(a, axis=1, keepdims=True)


def _smooth(x: np.ndarray | float) -> np.ndarray:
    x = np.clip(x, 0, 1)
    return x**2 * (3 - 2 * x)


def _root(function: Loads, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Where each element of a function changes its sign between low and high, to the last digits.

    Inverse quadratic interpolation where it can be trusted, else bisection: T. R. Chandrupatla, Advances in Engineering
    Software 28 (1997) 145.
    """
    x1, x2, share = low, high, np.full_like(low, 0.5)
    f1, f2 = function(x1), function(x2)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for _ in range(100):
            x = x1 + share * (x2 - x1)
            f = function(x)
            same = (f < 0) == (f1 < 0)
            x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
            x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
            x1, f1 = x, f
            best = np.where(np.abs(f1) < np.abs(f2), x1, x2)
            least = 2 * np.finfo(float).eps * np.abs(best) / np.abs(x2 - x1)
            if np.all((least > 0.5) | (f1 == 0) | (f2 == 0)):
                break
            xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            curved = f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
            share = np.where((phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi), curved, 0.5)
            least = np.minimum(least, 0.5)
            share = np.clip(np.where(np.isfinite(share), share, 0.5), least, 1 - least)
    return np.where(f1 == 0, x1, best)


def _skew(rotor: BladeElementRotor, wind: np.ndarray, normal: np.ndarray, arm: np.ndarray):
    """Skew angle at the rotor, and (r / R) cos(psi) of every node, psi = 0 where the wake goes; fading over 60 deg."""
    along = wind @ normal
    across = wind - along * normal
    size = np.linalg.norm(across)
    if not rotor.skew or along <= 0 or size == 0:
        return 0.0, np.zeros(len(arm))
    angle = np.arctan2(size, along)
    return angle, _smooth(2 * np.cos(angle)) * (arm @ across) / size / rotor.blade.tip_radius


class _Sections:
    """All elements of a rotor at one state: the balance of momentum and blade forces."""

    def __init__(self, rotor: BladeElementRotor, Vx: np.ndarray, Vt: np.ndarray, twist: np.ndarray, r: np.ndarray,
                 chord: np.ndarray):  # fmt: skip
        blade, B = rotor.blade, rotor.blades
        self.rotor, self.Vx, self.Vt, self.twist, self.chord = rotor, Vx, Vt, twist, chord
        self.sigma = B * self.chord / (2 * np.pi * r)
        self.tip, self.hub = (np.tile(loss, B) for loss in rotor.losses)
        self.side = np.where(Vx < 0, -1.0, 1.0)
        used = sorted(set(blade.airfoil))
        self.foils = foils = [blade.airfoils[name] for name in used]
        self.airfoil = np.array([used.index(name) for name in blade.airfoil])
        self.shift = 10.0 * np.tile(self.airfoil, B)  # every airfoil on its own stretch
        self.knots = np.concatenate([foil.angle[:-1] for foil in foils])
        self.shifted = np.concatenate([foil.angle[:-1] + 10.0 * k for k, foil in enumerate(foils)])
        self.cubics = np.concatenate([rotor.airfoil_model.cubics(foil) for foil in foils])

    def turning(self, spin: np.ndarray, wind: np.ndarray, r: np.ndarray) -> None:
        """The share of the induction, by the speed of the rotation at the nodes and the relative wind without it."""
        tip_speed = np.maximum(np.abs(spin) * self.rotor.blade.tip_radius / r, 1e-300)
        slow = np.minimum(np.linalg.norm(wind, axis=1) / tip_speed, 1)
        forward = np.divide(self.Vt, spin, out=np.zeros_like(spin), where=spin != 0)
        self.share = _smooth(np.abs(self.Vx) / tip_speed / 0.02) * _smooth(2 - 2 * slow) * _smooth(4 * forward)

    def coefficients(self, angle: np.ndarray) -> tuple[np.ndarray, ...]:
        """c_l, c_d, c_m of all elements, and what the airfoil model adds to the polars."""
        angle = (angle + np.pi) % (2 * np.pi) - np.pi
        index = np.searchsorted(self.shifted, np.maximum(angle, -3.1415926) + self.shift, side="right") - 1
        powers = (angle - self.knots[index])[:, None] ** np.arange(4)
        return tuple(np.einsum("ijk,ik->ji", self.cubics[index], powers))

    def induction(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """1 / (1 - a) and 1 / (1 + a') at inflow angles: momentum theory, and Buhl's line above k = 2/3."""
        s, c = np.sin(phi), np.cos(phi)
        lift, drag = self.coefficients(phi - self.twist)[:2]
        cn = lift * c + self.rotor.axial_drag * drag * s
        ct = lift * s - self.rotor.tangential_drag * drag * c
        F = np.ones_like(phi)
        for distance in (self.tip, self.hub):
            F *= np.maximum(2 / np.pi * np.arccos(np.exp(-distance / np.abs(s))), 1e-4)
        k = self.side * self.sigma * cn / (4 * F * s**2)
        held = np.where(F < LEAST_SWIRL_LOSS, (LEAST_SWIRL_LOSS + F**2 / LEAST_SWIRL_LOSS) / 2, F)
        swirl = self.sigma * ct / (4 * held * np.abs(s) * c)
        high = np.maximum(k, 2 / 3)
        g1, g2, g3 = 2 * F * high - (10 / 9 - F), 2 * F * high - F * (4 / 3 - F), 2 * F * high - (25 / 9 - 2 * F)
        near = np.abs(g3) < 1e-6
        a = np.where(near, 1 - 1 / (2 * np.sqrt(g2)), (g1 - np.sqrt(g2)) / np.where(near, 1, g3))
        # past a = 1 - 1e-3 digits are lost in 1 - a; there the conjugate form of the same line
        inverse = np.where(near | (a > 0.5), np.sqrt(g2) + 5 / 3 - F, 1 / (1 - np.minimum(a, 0.5)))
        return np.where(k > 2 / 3, inverse, 1 + k), 1 - swirl

    def residual(self, phi: np.ndarray) -> np.ndarray:
        """Ning's residual; it rises with |phi|."""
        axial, tangential = self.induction(phi)
        return self.side * (self.Vt * np.sin(phi) * axial - self.Vx * np.cos(phi) * tangential)

    def angle(self) -> np.ndarray:
        """The inflow angle after induction, in the half that holds a root."""
        quarter = np.full_like(self.Vx, np.pi / 2)
        steep = self.residual(self.side * quarter) < 0
        low, high = np.where(steep, quarter, EDGE), np.where(steep, np.pi - EDGE, quarter)
        low_out, high_out = self.residual(self.side * low) >= 0, self.residual(self.side * high) < 0
        held, end = np.where(steep, high_out, low_out), np.where(steep, high, low)
        return self.side * np.where(held, end, _root(lambda angle: self.residual(self.side * angle), low, high))

    def loads(self, skew: tuple[float, np.ndarray], flow: Coefficients, given: np.ndarray | None = None
              ) -> tuple[np.ndarray, ...]:  # fmt: skip
        """Force downwind and to the trailing edge, and nose-up moment, of each element, per length and air density.

        Last the quasi-steady induced speed; where one is given it takes its place, but for the part of the skew.
        """
        Vx, Vt = self.Vx, self.Vt
        share = self.share
        axial, swirl, yaw = np.zeros_like(Vx), np.zeros_like(Vx), np.ones_like(Vx)
        if np.any(share > 0):
            phi = self.angle()
            X, Y = self.induction(phi)
            X, Y = np.sin(phi) * X, np.cos(phi) * Y
            W = np.hypot(Vx, Vt) / np.hypot(X, Y)
            share = np.where(Vx * X + Vt * Y > 0, share, 0.0)
            axial, swirl = Vx - W * np.sin(phi), W * np.cos(phi) - Vt
            a = np.clip(axial / np.where(Vx == 0, 1, Vx), 0, 1)
            yaw = 1 + self.rotor.skew * np.tan((1 + 0.6 * a) * skew[0] / 2) * skew[1]
        induced = share * axial
        U, T = Vx - induced * yaw, Vt + share * swirl
        if given is not None:
            U += induced - given
        lift, drag, moment = flow(np.arctan2(U, T) - self.twist, np.hypot(U, T))
        phi, pressure = np.arctan2(U, T), self.chord / 2 * (U**2 + T**2)
        s, c = np.sin(phi), np.cos(phi)
        force = pressure * (lift * c + drag * s), pressure * (drag * c - lift * s)
        return *force, pressure * self.chord * moment, induced
