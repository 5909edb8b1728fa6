"""Blade-element momentum rotor as an external function: in C (bem.c), or its NumPy twin where there is no compiler."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.aero import bem_numpy
from fowtlib.components.aero.blade_aerodynamics import Airfoil, BladeAerodynamics
from fowtlib.language import ExternalFunction
from fowtlib.language.errors import ParameterError
from fowtlib.language.externals import with_interface

PITT_PETERS = 15 * np.pi / 32
"""Factor of the skewed wake in Ning et al. (2015, AIAA 2015-0215), also AeroDyn's; other texts have 15 pi / 64."""


LINE_LOADS = ("elements", "straight_lines")


@dataclass(frozen=True, eq=False)
class BladeElementRotor:
    """Aerodynamic loads of a rotor by blade-element momentum theory, quasi-steady, at moving and bending blades.

    Every element balances momentum and blade forces in its own annulus (Ning 2014) with the velocities of its own node;
    Prandtl's tip and hub loss, Buhl's high induction (2005), Pitt and Peters' skewed wake. There is no induction in a
    rotor that stands or hardly turns, whatever side the wind is from (tip speed of the rotation below the relative wind
    at the blade without it; it sets in smoothly up to twice that), nor without wind (below 2 % of the tip speed). In
    the last centimetres before a tip, where Prandtl's factor is below 0.1, the swirl no longer grows as one over it.
    What a tower does to the wind is part of the wind that is handed in. Dynamic stall would attach
    where the coefficients are looked up (its states as inputs, as the induced speed is), induction between rotors as a
    further part of the wind.

    blades: any number; rotation 1: turns clockwise seen looking downwind, -1: the other way (mirrored blades).
    line_loads: the load of a node is that per length times the length of its element, "elements"; or it goes in
    "straight_lines" from node to node and to zero at the root and the tip, as in CCBlade and AeroDyn.
    skew: factor of the skewed wake correction, 0 for none. axial_drag, tangential_drag: drag takes part in the
    induction. tip_loss, hub_loss: Prandtl's factors. dynamic_inflow: the axial induced speed of each station, the same
    for all blades, is an input, and the quasi-steady one of each node an output; what the skew adds to it and the swirl
    follow at once.

    Inputs, all in the world, n nodes blade by blade from root to tip: position (3n), orientation (9n, columns of each
    matrix: x downwind and normal to the chord, z along the blade to the tip, y = z x x), velocity (3n), wind at the
    nodes (3n); hub_position, hub_orientation (x along the shaft, downwind), hub_velocity, disk_wind: the wind averaged
    over the disk or at the hub, for the skew; air_density; chord (stations) [m] of all blades; with dynamic inflow
    induced (stations): speed [m/s] against the normal of the sections. A node sits at the aerodynamic centre.
    Outputs: loads (6n): force [N] and moment about the node [N m] of each node; with dynamic inflow quasi_steady (n):
    the induced speed of the balance of momentum [m/s].
    """

    blade: BladeAerodynamics
    blades: int = 3
    rotation: int = 1
    skew: float = PITT_PETERS
    axial_drag: bool = True
    tangential_drag: bool = True
    tip_loss: bool = True
    hub_loss: bool = True
    dynamic_inflow: bool = False
    line_loads: str = "elements"

    def __post_init__(self):
        if self.blades < 1 or self.rotation not in (1, -1):
            raise ParameterError("a rotor has one blade or more, and its sense of rotation is 1 or -1.")
        if self.line_loads not in LINE_LOADS:
            raise ParameterError(f"line_loads is '{self.line_loads}'; choose {' or '.join(LINE_LOADS)}.")

    @property
    def nodes(self) -> int:
        """Number of nodes of all blades."""
        return self.blades * len(self.blade.radius)

    @property
    def lengths(self) -> np.ndarray:
        """Length of the blade [m] that each node stands for, by `line_loads`; (stations,)."""
        if self.line_loads == "elements":
            return self.blade.length
        r = np.concatenate([[self.blade.hub_radius], self.blade.radius, [self.blade.tip_radius]])
        return (r[2:] - r[:-2]) / 2

    @property
    def inputs(self) -> dict[str, int]:
        """Names and lengths of the inputs."""
        n = self.nodes
        return {"position": 3 * n, "orientation": 9 * n, "velocity": 3 * n, "wind": 3 * n, "hub_position": 3,
                "hub_orientation": 9, "hub_velocity": 3, "disk_wind": 3, "air_density": 1, "chord": n // self.blades,
                **({"induced": len(self.blade.radius)} if self.dynamic_inflow else {})}  # fmt: skip

    @property
    def outputs(self) -> dict[str, int]:
        """Names and lengths of the outputs."""
        return {"loads": 6 * self.nodes, **({"quasi_steady": self.nodes} if self.dynamic_inflow else {})}

    @property
    def losses(self) -> tuple[np.ndarray, np.ndarray]:
        """F |sin(phi)| of Prandtl's factors 2/pi acos(exp(-f)) of the tip and of the hub; infinite without the loss."""
        r, b = self.blade.radius, self.blade
        tip = self.blades / 2 * (b.tip_radius - r) / r
        hub = self.blades / 2 * (r - b.hub_radius) / b.hub_radius
        none = np.full(len(r), np.inf)
        return (tip if self.tip_loss else none), (hub if self.hub_loss else none)

    @cached_property
    def sparsity(self) -> ca.Sparsity:
        """Of the Jacobian: own node and hub; the y axes of the nodes do not matter, only the x axis of the hub does."""
        n, stations = self.nodes, len(self.blade.radius)
        loads, nobody = np.arange(6 * n), np.arange(0)
        own = [loads[6 * i : 6 * i + 6] for i in range(n)]
        at_station = [np.concatenate(own[k::stations]) for k in range(stations)]
        everything = np.arange(sum(self.outputs.values()))
        if self.dynamic_inflow:
            own = [np.append(rows, 6 * n + i) for i, rows in enumerate(own)]
        columns = [own[i] for i in range(n) for _ in range(3)]
        columns += [own[i] if axis != 1 else nobody for i in range(n) for axis in range(3) for _ in range(3)]
        columns += 2 * [own[i] for i in range(n) for _ in range(3)]
        columns += 6 * [everything] + 6 * [nobody] + 3 * [everything] + 3 * [loads if self.skew else nobody] + [loads]
        columns += [np.sort(np.concatenate(own[k::stations])) for k in range(stations)]
        columns += at_station if self.dynamic_inflow else []
        starts = np.cumsum([0, *map(len, columns)])
        return ca.Sparsity(len(everything), len(columns), starts.tolist(), np.concatenate(columns).tolist())

    @cached_property
    def external(self) -> ExternalFunction:
        """The function for equations(); compiled once."""
        data = self._data()
        text = (Path(__file__).parent / "bem.c").read_text(encoding="utf-8")
        name = f"bem_{hashlib.sha256((data + text).encode()).hexdigest()[:8]}"
        return ExternalFunction(
            name, self.inputs, self.outputs, source=with_interface(name, self.sparsity, data + text),
            python=lambda u: bem_numpy.loads(self, u), jacobian=lambda u: bem_numpy.jacobian(self, u),
            sparsity=self.sparsity,
        )  # fmt: skip

    def _data(self) -> str:
        """The rotor as C text."""
        b = self.blade
        used = list(dict.fromkeys(b.airfoil))
        foils = [b.airfoils[name] for name in used]
        polar = [used.index(name) for name in b.airfoil]
        sizes = [len(foil.angle) for foil in foils]
        starts = np.cumsum([0, *sizes[:-1]])
        # one cubic per knot; the last knot of an airfoil has none of its own and is never looked up
        cubics = [np.concatenate([foil.cubics, np.zeros((1, 3, 4))]).ravel() for foil in foils]
        degrees = np.radians(np.arange(-180, 180)) - 1e-9
        first_in = [start + np.maximum(np.searchsorted(foil.angle, degrees, side="right") - 1, 0)
                    for start, foil in zip(starts, foils, strict=True)]  # fmt: skip
        most = np.array([np.abs(foil.coefficients).max(axis=0) for foil in foils])[polar]
        lift_lines = np.array([_lift_line(foil) for foil in foils])[polar]
        tip, hub = self.losses
        upright = np.prod([2 / np.pi * np.arccos(np.exp(-x)) for x in (tip, hub)], axis=0)
        numbers = {"length": self.lengths, "tip_loss": tip, "hub_loss": hub,
                   "least_loss": np.minimum(tip, hub), "upright_loss": upright,
                   "most_lift": most[:, 0], "most_drag": most[:, 1],
                   "lift_slope": lift_lines[:, 0], "zero_lift": lift_lines[:, 1],
                   "knot": np.concatenate([foil.angle for foil in foils]), "cubic": np.concatenate(cubics)}  # fmt: skip
        integers = {"polar": polar, "first_in": np.concatenate(first_in), "last_knot": starts + np.array(sizes) - 2}
        macros = {"BLADES": self.blades, "STATIONS": len(b.radius), "SENSE": self.rotation,
                  "TIP_RADIUS": _number(b.tip_radius), "SKEW": _number(self.skew), "SKEWED_WAKE": int(self.skew != 0),
                  "DYNAMIC_INFLOW": int(self.dynamic_inflow), "AXIAL_DRAG": int(self.axial_drag),
                  "TANGENTIAL_DRAG": int(self.tangential_drag)}  # fmt: skip
        lines = [f"#define {key} ({value})" for key, value in macros.items()]
        lines += [_array("int", key, value) for key, value in integers.items()]
        lines += [_array("double", key, value) for key, value in numbers.items()]
        return "\n".join(lines) + "\n"


def _lift_line(foil: Airfoil) -> tuple[float, float]:
    """Slope and zero of a straight line through the lift from -4 to 6 deg: where the search for the inflow begins."""
    angle = np.radians(np.linspace(-4, 6, 101))
    slope, lift = np.polyfit(angle, np.interp(angle, foil.angle, foil.coefficients[:, 0]), 1)
    return (slope, -lift / slope) if slope > 0.1 else (0.0, 0.0)


@cache
def _number(value: float) -> str:
    """A C constant with every digit; infinity is a number that exp(-x) takes to zero."""
    return repr(float(value)) if np.isfinite(value) else "1e300"


def _array(kind: str, name: str, values: Any) -> str:
    items = [_number(float(v)) if kind == "double" else str(int(v)) for v in values]
    body = "\n".join(", ".join(items[i : i + 12]) + "," for i in range(0, len(items), 12))
    return f"static const {kind} {name}[] = {{\n{body}\n}};"
