"""Blade-element momentum rotor as an external function: in C (bem.c), or its NumPy twin where there is no compiler."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import casadi as ca
import numpy as np

from fowtlib.components.aero import bem_numpy
from fowtlib.components.aero.airfoil_models import STEADY, AirfoilModel
from fowtlib.components.aero.bem_data import c_text
from fowtlib.components.aero.blade_aerodynamics import BladeAerodynamics
from fowtlib.components.aero.vectors import in_vectors, only_lanes
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
    What a tower does to the wind is part of the wind that is handed in; induction between rotors would be a further
    part of it.

    blades: any number; rotation 1: turns clockwise seen looking downwind, -1: the other way (mirrored blades).
    line_loads: the load of a node is that per length times the length of its element, "elements"; or it goes in
    "straight_lines" from node to node and to zero at the root and the tip, as in CCBlade and AeroDyn.
    skew: factor of the skewed wake correction, 0 for none. axial_drag, tangential_drag: drag takes part in the
    induction. tip_loss, hub_loss: Prandtl's factors. dynamic_inflow: the axial induced speed of each station, the same
    for all blades, is an input, and the quasi-steady one of each node an output; what the skew adds to it and the swirl
    follow at once. airfoil_model: what the airfoils make of the flow; momentum balances their polars all the same.

    Inputs, all in the world, n nodes blade by blade from root to tip: position (3n), orientation (9n, columns of each
    matrix: x downwind and normal to the chord, z along the blade to the tip, y = z x x), velocity (3n), wind at the
    nodes (3n); hub_position, hub_orientation (x along the shaft, downwind), hub_velocity, disk_wind: the wind averaged
    over the disk or at the hub, for the skew; air_density; chord (stations) [m] of all blades; with dynamic inflow
    induced (stations): speed [m/s] against the normal of the sections; with a model that has states turn_rate (n):
    angular velocity [rad/s] of each node about its z axis, without what the turning of the rotor about its shaft has of
    it; airfoil_states, those of a node in a row; stage_step, see stage_step in the language. A node sits at the
    aerodynamic centre.
    Outputs: loads (6n): force [N] and moment about the node [N m] of each node; with dynamic inflow quasi_steady (n):
    the induced speed of the balance of momentum [m/s]; airfoil_rates: of the states.
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
    airfoil_model: AirfoilModel = STEADY

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
        n, states = self.nodes, self.airfoil_model.states
        own = {"turn_rate": n, "airfoil_states": states * n, "stage_step": 1} if states else {}
        return {"position": 3 * n, "orientation": 9 * n, "velocity": 3 * n, "wind": 3 * n, "hub_position": 3,
                "hub_orientation": 9, "hub_velocity": 3, "disk_wind": 3, "air_density": 1, "chord": n // self.blades,
                **({"induced": len(self.blade.radius)} if self.dynamic_inflow else {}), **own}  # fmt: skip

    @property
    def outputs(self) -> dict[str, int]:
        """Names and lengths of the outputs."""
        states = self.airfoil_model.states
        return {"loads": 6 * self.nodes, **({"quasi_steady": self.nodes} if self.dynamic_inflow else {}),
                **({"airfoil_rates": states * self.nodes} if states else {})}  # fmt: skip

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
        n, stations, states = self.nodes, len(self.blade.radius), self.airfoil_model.states
        loads, nobody, all_rows = np.arange(6 * n), np.arange(0), np.arange(sum(self.outputs.values()))
        first = len(all_rows) - states * n  # of the rates
        own_loads = [loads[6 * i : 6 * i + 6] for i in range(n)]
        moved = [np.append(own_loads[i], first + states * i + np.arange(states)) for i in range(n)]  # with their rates
        own = [np.sort(np.append(rows, 6 * n + i)) for i, rows in enumerate(moved)] if self.dynamic_inflow else moved
        both = np.append(loads, all_rows[first:])
        columns = [own[i] for i in range(n) for _ in range(3)]
        columns += [own[i] if axis != 1 else nobody for i in range(n) for axis in range(3) for _ in range(3)]
        columns += 2 * [own[i] for i in range(n) for _ in range(3)]
        columns += 6 * [all_rows] + 6 * [nobody] + 3 * [all_rows] + 3 * [both if self.skew else nobody] + [loads]
        columns += [np.sort(np.concatenate(own[k::stations])) for k in range(stations)]
        if self.dynamic_inflow:
            columns += [np.sort(np.concatenate(moved[k::stations])) for k in range(stations)]
        if states:
            columns += moved + [moved[i] for i in range(n) for _ in range(states)] + [nobody]
        starts = np.cumsum([0, *map(len, columns)])
        return ca.Sparsity(len(all_rows), len(columns), starts.tolist(), np.concatenate(columns).tolist())

    @cached_property
    def external(self) -> ExternalFunction:
        """The function for equations(); compiled once."""
        text = c_text(self) + _texts("polar.c", self.airfoil_model.source, "bem.c")
        text += in_vectors(_texts("vector_math.c", "bem_lanes.c")) + _texts("bem_rotor.c")
        name = f"bem_{hashlib.sha256(text.encode()).hexdigest()[:8]}"
        return ExternalFunction(
            name, self.inputs, self.outputs, source=with_interface(name, self.sparsity, text),
            here=lambda: only_lanes(self.nodes),
            python=lambda u: bem_numpy.loads(self, u), jacobian=lambda u: bem_numpy.jacobian(self, u),
            sparsity=self.sparsity,
        )  # fmt: skip


def _texts(*names: str) -> str:
    """The C texts of these files beside this one, one after the other."""
    return "".join((Path(__file__).parent / name).read_text(encoding="utf-8") for name in names)
