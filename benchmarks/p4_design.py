"""Tower walls and control together on the optimised 10-MW spar: `python benchmarks/p4_design.py FOLDER [--sequential]`.

For each strategy of benchmarks/p4_control.py, in turns: the gains with which fatigue asks for the least steel, then the
eleven walls at the joints of the tower that fatigue in fifteen states and buckling in three 50-year states ask for,
with the responses of the spar that has them, until the walls stay. Diameters, hull and mooring stay as printed; ballast
makes up for the steel. The search starts with the gains of FOLDER/control; with --sequential they stay. Kept in
FOLDER/*.json.
"""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from p4_control import (
    DUTY_LIMIT,
    EXTREMES,
    FEEDBACK,
    SPEED_LIMIT,
    Gains,
    Spar,
    best,
    label,
    row,
)
from pages import markdown
from scipy.optimize import brentq, linprog

from fowtlib.design import rules

GRAVITY, ROTOR, LOADS, LEAST = 9.80665, 676.7e3, 1.35, 0.010
TURNS, SETTLED = 4, 3e-3


def buckling_walls(spar: Spar, gains: Gains) -> tuple[np.ndarray, np.ndarray]:
    """Mean walls [m] that buckling asks for in the ten sections, and the utilisation with those that are."""
    D, t, z = spar.D, spar.t, spar.z
    steel = 0.5 * np.pi * np.diff(z) * 8500.0 * ((D[1:] - t[1:]) * t[1:] + (D[:-1] - t[:-1]) * t[:-1])
    above = ROTOR + np.cumsum(steel[::-1])[::-1]
    moments = np.max([spar.moments(state, gains) for state in EXTREMES.values()], axis=0)
    asked, used = [], []
    for k, load in enumerate(above):
        middle, wall, length = (D[k] + D[k + 1]) / 2, (t[k] + t[k + 1]) / 2, z[k + 1] - z[k]
        moment = max(moments[k], moments[k + 1])

        def use(wall: float, middle=middle, load=load, moment=moment, length=length) -> float:
            r = (middle - wall) / 2
            axial, bending, _ = rules.cylinder_stress(r, wall, -load * GRAVITY, -moment)
            return float(rules.tower_buckling(LOADS * (axial + bending), r, wall, length).utilisation)

        used.append(use(wall))
        asked.append(brentq(lambda w: use(w) - 1, 0.3 * wall, 3 * wall))
    return np.array(asked), np.array(used)


def least_walls(spar: Spar, fatigue: np.ndarray, buckling: np.ndarray) -> np.ndarray:
    """The walls of least mass at the joints, none below those of fatigue, on the mean not below those of buckling."""
    mass = np.array([spar.steel(np.eye(11)[k] * 1e-6) for k in range(11)])
    rows = -0.5 * (np.eye(11)[:-1] + np.eye(11)[1:])
    found = linprog(mass / mass.sum(), A_ub=rows, b_ub=-buckling, bounds=[(max(f, LEAST), None) for f in fatigue])
    return np.asarray(found.x)


def cost(spar: Spar, walls: np.ndarray) -> float:
    """Of the tower [EUR]."""
    return float(rules.steel_cost(rules.tube_sections(ca.DM(spar.z), ca.DM(spar.D), ca.DM(walls)), density=8500.0).cost)


def turned(name: str, printed: Spar, gains: Gains, sequential: bool) -> dict[str, Any]:
    """A strategy with its tower; the gains are sought again in every turn but the first, or stay."""
    history: list[dict[str, Any]] = []
    ballast = float(np.ravel(printed.above.parameter_values()["ballast"])[0])
    spar, walls = printed, printed.t
    while True:
        if history and not sequential:
            gains = best(spar, name, [gains], (SPEED_LIMIT, DUTY_LIMIT))
        found = row(spar, gains)
        asked, used = buckling_walls(spar, gains)
        fatigue = np.array(found["walls"])
        new = least_walls(spar, fatigue, asked)
        history.append({"walls": walls.tolist(), "steel": spar.steel(walls), "use": found["use"],
                        "buckling": used.tolist()})  # fmt: skip
        print(f"{name} turn {len(history)}: {spar.steel(walls) / 1e3:.1f} t, fatigue {max(found['use']):.3f}, buckling "
              f"{used.max():.3f}, next {spar.steel(new) / 1e3:.1f} t; {label(gains)}", flush=True)  # fmt: skip
        moved = np.abs(new / walls - 1).max()
        if moved < SETTLED or len(history) == TURNS:
            break
        walls = new
        spar = Spar({"tower_walls": walls, "ballast": ballast + printed.steel(printed.t) - spar.steel(walls)})
    return found | {"gains": gains, "tower": new.tolist(), "mass": spar.steel(new), "cost": cost(spar, new),
                    "moved": moved, "by_buckling": (new > fatigue + 1e-6).tolist(), "turns": history}  # fmt: skip


def main() -> None:
    folder, sequential = Path(sys.argv[1]), "--sequential" in sys.argv
    warnings.simplefilter("ignore")
    printed, found = Spar(), {}
    for name in [n for n in FEEDBACK if n in sys.argv] or list(FEEDBACK):
        file = folder / f"{name}{'_sequential' if sequential else ''}.json"
        if not file.exists():
            begin = json.loads((folder / "control" / f"{name}.json").read_text())["gains"]
            file.write_text(json.dumps(turned(name, printed, begin, sequential), indent=1))
        found[name] = json.loads(file.read_text())
    base, lines = next(iter(found.values())), []
    for name, one in found.items():
        change = 100 * (np.array(one["tower"]) / np.array(base["tower"]) - 1)
        lines.append((
            f"{name}: {label(one['gains'])}",
            f"{one['mass'] / 1e3:.1f} ({100 * (one['mass'] / base['mass'] - 1):+.1f} %)",
            f"{one['cost'] / 1e6:.3f}",
            ", ".join(f"{1e3 * t:.1f}" for t in one["tower"]),
            f"{change.min():+.1f} to {change.max():+.1f} %",
            f"{one['speed']:.4f}", f"{1e3 * one['duty']:.2f}",
            ", ".join(f"{one['largest'][e]['pitch']:.1f}" for e in EXTREMES),
        ))  # fmt: skip
    heads = ("strategy", "tower [t]", "cost [MEUR]", "walls [mm]", "walls", "rotor speed [rad/s]", "duty cycle [1e-3]",
             "pitch in EC1, EC2, EC3 [deg]")  # fmt: skip
    print(markdown((heads, lines), 3))


if __name__ == "__main__":
    main()
