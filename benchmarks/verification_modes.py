"""Modes of a complete turbine with flexible tower and blades, by name, for docs/verification.md and its tests.

A turbine without wind, its rotor held at azimuth 0 while it finds its rest. `locked` keeps the generator from turning,
as NREL's published analyses do (J. Jonkman et al., NREL/TP-500-38060 (2009), table 9-1).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import block_diag, null_space

import fowtlib as fw
from fowtlib.components.mechanics.beam_division import divide
from fowtlib.components.mechanics.beam_properties import BeamProperties, read_beam
from fowtlib.components.mechanics.tube_beam import tube_table
from fowtlib.modelfile import data_path
from fowtlib.solving.linear import LinearModel, Mode
from fowtlib.solving.plant import Plant
from fowtlib.solving.state import State

Changes = tuple[tuple[str, object], ...]  # (parameter path, value)
BEARING = "turbine.assembly.nacelle.bearing"
HELD = {f"{BEARING}.phi": 0.0, f"{BEARING}.w": 0.0}
LOCK = {"turbine.assembly.drivetrain.generator_inertia": 1e9}  # kg m^2 on the high speed shaft: it does not turn
BLADE = ".blade_"
DAMPING = ("tower.damping_fore_aft", "turbine.assembly.damping_flapwise", "turbine.assembly.damping_edgewise")
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
VELOCITIES = ("velocity[0]", "velocity[1]", "velocity[2]", "angle_rates[0]", "angle_rates[1]", "angle_rates[2]")

# Shape functions of FAST (coefficients of x^2 to x^6 of the relative height or span), as distributed with FAST:
# OC3Hywind_ElastoDyn_Tower.dat, NRELOffshrBsline5MW_Onshore_ElastoDyn_Tower.dat, NRELOffshrBsline5MW_Blade.dat.
# Its towers and blades bend in no other way.
FAST_TOWER = {
    "oc3_spar": {
        "x": [(0.8689, 0.2205, -0.0908, 0.1167, -0.1154), (42.5859, -18.6419, -20.357, -23.2686, 20.6816)],
        "y": [(0.834, 0.2216, -0.0571, 0.0934, -0.0918), (60.2285, -27.5868, -30.3887, -33.6738, 32.4208)],
    },
    "nrel5mw_land": {
        "x": [(0.7004, 2.1963, -5.6202, 6.2275, -2.504), (-70.5319, -63.7623, 289.737, -176.513, 22.0706)],
        "y": [(1.385, -1.7684, 3.0871, -2.2395, 0.5357), (-121.21, 184.415, -224.904, 298.536, -135.838)],
    },
}
FAST_BLADE = {
    "x": [(0.0622, 1.7254, -3.2452, 4.7131, -2.2555), (-0.5809, 1.2067, -15.5349, 29.7347, -13.8255)],
    "y": [(0.3627, 2.5337, -3.5772, 2.376, -0.6952)],
}


@lru_cache(maxsize=2)
def turbine_at_rest(name: str, tower_hinges: int, blade_hinges: int, changes: Changes = ()) -> tuple[Plant, State]:
    """A shipped turbine with so many beam hinges and other changes in calm water and vacuum, and its rest."""
    calm = {"wind.kind": "none", "world.air_density": 0.0}
    if "sea" in fw.load(name).root.parts:
        calm["sea.spectrum"] = "still"
    hinges = {"tower.hinges": tower_hinges, "turbine.assembly.blade_hinges": blade_hinges}
    plant = fw.load(name, set={**calm, **hinges, **dict(changes)}).compile()
    return plant, plant.equilibrium(hold=HELD)


@lru_cache(maxsize=8)
def linear(
    name: str, tower_hinges: int, blade_hinges: int, locked: bool, damping_factor: float = 1.0, changes: Changes = ()
) -> LinearModel:
    """The linear model about rest, the generator free or locked, the damping of all hinges times a factor."""
    plant, rest = turbine_at_rest(name, tower_hinges, blade_hinges, changes)
    values = plant.parameter_values()
    changed = {path: damping_factor * float(values[path]) for path in DAMPING if damping_factor != 1}
    changed |= LOCK if locked else {}
    return plant.linearize(plant.initial_state(parameters=changed, base=rest) if changed else rest, outputs=[])


def part_of(path: str) -> str:
    """What a state belongs to: a motion of the platform, a direction of tower or blades, the drive train, or ""."""
    last = path.rpartition(".")[2]
    if path.startswith("platform.motion."):
        return last if last in MOTIONS else MOTIONS[VELOCITIES.index(last)]
    if path.startswith("tower.") or BLADE in path:
        names = ("fore-aft", "side-side") if path.startswith("tower.") else ("flap", "edge")
        return f"{'tower' if path.startswith('tower.') else 'blade'} {names[last.endswith('y')]}"
    return "drivetrain" if "drivetrain" in path or path.startswith(BEARING) else ""


def shares(mode: Mode) -> dict[str, float]:
    """Share of each part in a mode, by the participation of its states."""
    found: dict[str, float] = {}
    for path, share in mode.participation.items():
        found[part_of(path)] = found.get(part_of(path), 0.0) + share
    return found


def blade_order(mode: Mode, direction: str) -> int:
    """1 for the first bending of the blades, 2 for the second: changes of sign along the leading blade."""
    angles: dict[str, dict[int, complex]] = {}
    for path, amplitude in mode.shape.items():
        hinge = re.search(rf"blade_(\d+)\.beam\.hinge_(\d+)\.bending\.phi_{direction}$", path)
        if hinge:
            angles.setdefault(hinge[1], {})[int(hinge[2])] = amplitude
    leading = max(angles.values(), key=lambda blade: max(map(abs, blade.values())))
    along = np.array([leading[i] for i in sorted(leading)])
    largest = along[np.argmax(abs(along))]
    real = (along / largest).real
    real = real[abs(real) > 0.02]
    return 1 + int(np.sum(np.sign(real[1:]) != np.sign(real[:-1])))


def shape_order(mode: Mode, direction: str) -> int:
    """The same for a model in shape functions: which of them has the largest share; see `with_fast_shapes`."""
    shares = mode.participation.items()
    ours = {path: share for path, share in shares if BLADE in path and path.endswith(f"phi_{direction}")}
    return int(re.search(r"hinge_(\d+)", max(ours, key=ours.__getitem__))[1])


def named(modes: list[Mode], order: Callable[[Mode, str], int] = blade_order) -> dict[str, list[Mode]]:
    """Modes by name, lowest first: "surge", "tower fore-aft 1", "blade flap 2", "drivetrain", ...

    A mode belongs to the part with the largest share. Modes of the tower count upward in frequency. The three modes of
    the blades of one order (two asymmetric, one collective) share a name.
    """
    found: dict[str, list[Mode]] = {}
    for mode in modes:
        if mode.eigenvalue.imag <= 1e-3:  # no oscillation, or the free turn of the shaft
            continue
        parts = shares(mode)
        leading = max(parts, key=parts.__getitem__)
        if leading.startswith("tower"):
            leading += f" {1 + sum(name.startswith(leading) for name in found)}"
        elif leading.startswith("blade"):
            leading += f" {order(mode, 'x' if leading.endswith('flap') else 'y')}"
        if leading:
            found.setdefault(leading, []).append(mode)
    for motion in MOTIONS:  # a mode of the water's memory may be led by a motion
        if motion in found:
            found[motion] = [max(found[motion], key=lambda mode: shares(mode)[motion])]
    return found


def frequencies(
    name: str, tower_hinges: int, blade_hinges: int, locked: bool, changes: Changes = ()
) -> dict[str, list[float]]:
    """Natural frequencies [Hz] by the names of `named`."""
    return _frequencies(linear(name, tower_hinges, blade_hinges, locked, changes=changes))


def _frequencies(model: LinearModel, order: Callable[[Mode, str], int] = blade_order) -> dict[str, list[float]]:
    return {key: [float(mode.frequency_hz) for mode in group] for key, group in named(model.modes(), order).items()}


@dataclass(frozen=True)
class Hinges:
    """The hinges of one beam in one direction: states of angle and rate, stiffness [N m/rad], FAST's shapes there."""

    angles: list[str]
    stiffness: np.ndarray
    shapes: np.ndarray

    @classmethod
    def of(cls, path: str, beam: BeamProperties, hinges: int, quadrature: str, shapes: dict[str, list]) -> list[Hinges]:
        """Both directions. A hinge turns by curvature times EI / k, since its moment is k times the angle."""
        chain = divide(beam, hinges, quadrature)
        found = []
        for axis in "xy":
            stiffness = np.asarray(getattr(chain, f"stiffness_{axis}"))
            lever = np.array([float(beam.at(f"stiffness_{axis}", s)) for s in chain.s]) / stiffness
            curvature = [
                sum(c * k * (k - 1) * (chain.s / beam.length) ** (k - 2) for k, c in enumerate(shape, start=2))
                for shape in shapes[axis]
            ]
            names = [f"{path}.hinge_{i + 1}.bending.phi_{axis}" for i in range(hinges)]
            found.append(cls(names, stiffness, np.array(curvature).T * lever[:, None]))
        return found


def with_fast_shapes(
    name: str, tower_hinges: int, blade_hinges: int, tower: bool = True, blades: bool = True
) -> dict[str, list[float]]:
    """Frequencies [Hz] of a turbine with locked generator when tower or blades bend in the shapes of FAST alone.

    Rates are A x + W f with moments f in the hinges. A change of the hinge damping gives W exactly. Moments that forbid
    every bending but the shapes make the constrained model. Its lowest modes cannot lie below those of the free one.
    """
    plant, _ = turbine_at_rest(name, tower_hinges, blade_hinges)
    values = plant.parameter_values()
    free, damped = (linear(name, tower_hinges, blade_hinges, True, factor) for factor in (1.0, 2.0))
    groups = []
    if tower:
        part = plant.root.find("tower.beam")
        beam = part.table or tube_table(part)
        groups += Hinges.of("tower.beam", beam, tower_hinges, "loaded_tip", FAST_TOWER[name])
    for k in (1, 2, 3) if blades else ():
        beam = read_beam(str(data_path("nrel5mw/blade_structure.csv")))
        groups += Hinges.of(f"turbine.assembly.blade_{k}.beam", beam, blade_hinges, "free_tip", FAST_BLADE)
    number = {path: i for i, path in enumerate(free.states)}
    angles = [path for group in groups for path in group.angles]
    at = [number[path] for path in angles]
    rates = [number[path.replace("phi_", "w_")] for path in angles]
    which = [DAMPING[0] if path.startswith("tower") else DAMPING[1 + path.endswith("y")] for path in angles]
    added = np.array([float(values[path]) for path in which]) * np.concatenate([group.stiffness for group in groups])
    A = free.matrices["A"]
    W = (A - damped.matrices["A"])[:, rates] / added
    N = block_diag(*[null_space(group.shapes.T) for group in groups])
    constrained = A - W @ N @ np.linalg.solve(N.T @ W[rates] @ N, N.T @ A[rates])
    kept = [i for i in range(len(A)) if i not in {*at, *rates}]
    columns, labels = list(np.eye(len(A))[kept]), [free.states[i] for i in kept]
    for group in groups:  # a shape goes by the name of a hinge, so that `part_of` knows whose it is
        for k, shape in enumerate(group.shapes.T):
            for place in (group.angles, [path.replace("phi_", "w_") for path in group.angles]):
                column = np.zeros(len(A))
                column[[number[path] for path in place]] = shape / np.abs(shape).max()
                columns.append(column)
                labels.append(place[k])
    basis = np.array(columns).T
    return _frequencies(
        LinearModel(
            np.linalg.pinv(basis) @ constrained @ basis, np.zeros((len(labels), 0)), basis, np.zeros((len(A), 0)),
            labels, [], free.states, {},
        ),
        shape_order if blades else blade_order,
    )  # fmt: skip
