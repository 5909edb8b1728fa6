"""Tower walls and control together on the optimised 10-MW spar: `python benchmarks/p4_design.py FOLDER [--sequential]`.

For each strategy of benchmarks/p4_control.py, in turns: the gains with which fatigue asks for the least steel, then the
eleven walls at the joints of the tower that fatigue in fifteen states and buckling in three 50-year states ask for,
with the responses of the spar that has them, until the walls stay. Diameters, hull and mooring stay as printed; ballast
makes up for the steel. The search starts with the gains of FOLDER/control; with --sequential they stay. Kept in
FOLDER/*.json. With --hull diameters of hull and tower and the draft take part by three numbers (Shape).
"""

from __future__ import annotations

import json
import sys
import warnings
from dataclasses import dataclass
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
    compiled,
    label,
    row,
)
from pages import markdown
from scipy.optimize import brentq, linprog, minimize

import fowtlib as fw
from fowtlib.design import rules

GRAVITY, ROTOR, LOADS, LEAST = 9.80665, 676.7e3, 1.35, 0.010
RINGS = 0.115  # cost of ring frames over that of the wall of the hull
TURNS, SETTLED, ROUNDS = 4, 3e-3, 3


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


@dataclass
class Shape:
    """Three numbers of a hull and tower, and the sizes that they make; the printed ones are (1, 1, 0).

    lower: factor of the hull's diameters below 10 m of depth; upper: of those above and of the whole tower; longer:
    what the lowest section is longer [m].
    """

    lower: float = 1.0
    upper: float = 1.0
    longer: float = 0.0

    def sizes(self, values: dict[str, Any], walls: np.ndarray) -> dict[str, Any]:
        z, D = (np.array(values[f"hull_{n}"], float) for n in ("heights", "diameters"))
        D = D * np.where(z < -10.0, self.lower, self.upper)
        z[0] -= self.longer
        tower = np.array(values["tower_diameters"], float) * self.upper
        return {"hull_heights": z, "hull_diameters": D, "tower_diameters": tower, "tower_walls": walls}


def measures(sizes: dict[str, Any], hull_walls: np.ndarray) -> dict[str, float]:
    """Cost of the hull [EUR], heave period [s], largest taper over its limit."""
    z, D = sizes["hull_heights"], sizes["hull_diameters"]
    cost = float(rules.steel_cost(rules.tube_sections(ca.DM(z), ca.DM(D), ca.DM(hull_walls))).cost)
    at = np.append(z[:-1], 0.0)
    wet = np.append(D[:-1], np.interp(0.0, z, D))
    volume = float(np.sum(np.pi / 12 * np.diff(at) * (wet[:-1] ** 2 + wet[:-1] * wet[1:] + wet[1:] ** 2)))
    taper = np.abs(np.diff(D)) / (2 * np.diff(z)) / np.tan(np.pi / 18)
    return {"hull": (1 + RINGS) * cost, "heave": float(rules.heave_period(1025.0 * volume, D[0], wet[-1])),
            "taper": float(taper.max())}  # fmt: skip


def shaped(shape: Shape, walls: np.ndarray) -> tuple[Spar, dict[str, float]]:
    """A spar with a shape and walls of its tower, afloat, and its measures."""
    values = compiled("dtu10mw_p4").parameter_values()
    hull_walls = np.array(values["hull_walls"], float)
    sizes = shape.sizes(values, walls)
    spar = Spar(dict(sizes))
    spar.balance()
    return spar, measures(sizes, hull_walls)


def outcome(spar: Spar, name: str, gains: Gains, more: dict[str, float], search: bool = True) -> dict[str, Any]:
    """The best gains of a strategy on a spar, the walls that they ask for, cost and pitch."""
    if search:
        gains = best(spar, name, [gains], (SPEED_LIMIT, DUTY_LIMIT))
    found = row(spar, gains)
    asked, used = buckling_walls(spar, gains)
    walls = least_walls(spar, np.array(found["walls"]), asked)
    pitch = max(found["largest"][e]["pitch"] for e in EXTREMES)
    tower = cost(spar, walls)
    return found | more | {"gains": gains, "tower": walls.tolist(), "mass": spar.steel(walls), "tower_cost": tower,
                           "cost": tower + more["hull"], "largest_pitch": pitch, "buckling": used.tolist(),
                           "ballast": spar.sizes.get("ballast")}  # fmt: skip


CENTRE, STEPS = np.array([0.93, 0.97, 2.0]), np.array([0.06, 0.05, 4.0])


def points() -> np.ndarray:
    """Centre, and both sides of each number (7, 3)."""
    return CENTRE + STEPS * np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])


def quadratic(x: np.ndarray) -> np.ndarray:
    """Terms of the three numbers and their squares, about the centre."""
    u = (np.atleast_2d(x) - CENTRE) / STEPS
    return np.column_stack([np.ones(len(u)), u, u**2])


def surveyed(folder: Path, walls: np.ndarray, start: dict[str, Gains]) -> dict[str, list[dict[str, Any]]]:
    """The outcome of each strategy at each point, where all have the same walls; one response of a state serves all."""
    found: dict[str, list[dict[str, Any]]] = {name: [] for name in start}
    for k, x in enumerate(points()):
        file = folder / f"point_{k}.json"
        if not file.exists():
            shape = Shape(*x)
            spar, more = shaped(shape, walls / shape.upper**2)
            each = {name: outcome(spar, name, gains, more) for name, gains in start.items()}
            file.write_text(json.dumps(each))
            print(k, x, {n: (round(o["cost"] / 1e6, 3), round(o["largest_pitch"], 2)) for n, o in each.items()},
                  more, flush=True)  # fmt: skip
        for name, one in json.loads(file.read_text()).items():
            found[name].append(one)
    return found


def least_shape(rows: list[dict[str, Any]], last: dict[str, Any] | None, values: dict[str, Any]) -> np.ndarray:
    """The numbers of the shape of least cost, by squares through the rows, moved so that they meet the last outcome."""
    fit = {}
    for key in ("tower_cost", "largest_pitch"):
        found = np.linalg.lstsq(quadratic(points()), np.array([r[key] for r in rows]), rcond=None)[0]
        if last is not None:
            found[0] += last[key] - float((quadratic(np.array(last["shape"])) @ found)[0])
        fit[key] = found
    hull_walls, any_walls = np.array(values["hull_walls"], float), np.ones(11)

    def at(x: np.ndarray, key: str) -> float:
        return float((quadratic(x) @ fit[key])[0])

    def sized(x: np.ndarray) -> dict[str, float]:
        return measures(Shape(*x).sizes(values, any_walls), hull_walls)

    found = minimize(
        lambda x: (at(x, "tower_cost") + sized(x)["hull"]) / 1e6, CENTRE, method="SLSQP",
        bounds=[(c - 1.2 * h, c + 1.2 * h) for c, h in zip(CENTRE, STEPS, strict=True)],
        constraints={"type": "ineq", "fun": lambda x: np.array([
            (15 - at(x, "largest_pitch")) / 15, sized(x)["heave"] / 25 - 1, 1 - sized(x)["taper"]])},
    )  # fmt: skip
    if not found.success:
        raise fw.ModelError(f"no shape: {found.message}")
    return np.asarray(found.x)


def with_hull(folder: Path) -> None:
    """Cost of hull and tower of each strategy at least: by squares through seven shapes, and what is found there."""
    start = {n: json.loads((folder / f"{n}.json").read_text()) for n in FEEDBACK}
    folder = folder / "hull"
    folder.mkdir(exist_ok=True)
    survey = surveyed(folder, np.array(start["CS1"]["tower"]), {n: one["gains"] for n, one in start.items()})
    lines, base, values = [], None, compiled("dtu10mw_p4").parameter_values()
    for name, rows in survey.items():
        one, last = start[name] | {"shape": [1.0, 1.0, 0.0]}, None
        for again in range(ROUNDS):
            file = folder / f"{name}_{again}.json"
            if not file.exists():
                shape, upper = Shape(*least_shape(rows, last, values)), one["shape"][1]
                for _ in range(2 if again == 0 else 1):
                    spar, more = shaped(shape, np.array(one["tower"]) * (upper / shape.upper) ** 2)
                    one, upper = outcome(spar, name, one["gains"], more), shape.upper
                one["shape"] = [shape.lower, shape.upper, shape.longer]
                print(name, again, shape, more, one["cost"] / 1e6, one["largest_pitch"], max(one["use"]),
                      max(one["buckling"]), label(one["gains"]), flush=True)  # fmt: skip
                file.write_text(json.dumps(one, indent=1))
            one = last = json.loads(file.read_text())
        base = base or one
        share = lambda key, one=one, base=base: f"({100 * (one[key] / base[key] - 1):+.1f} %)"  # noqa: E731
        lines.append((name, label(one["gains"]), *(f"{v:.3f}" for v in one["shape"]),
                      f"{one['mass'] / 1e3:.0f} {share('mass')}",
                      f"{one['tower_cost'] / 1e6:.3f} {share('tower_cost')}",
                      f"{one['hull'] / 1e6:.3f} {share('hull')}", f"{one['cost'] / 1e6:.3f} {share('cost')}",
                      f"{one['largest_pitch']:.1f}", f"{one['heave']:.1f}", f"{one['speed']:.4f}",
                      f"{1e3 * one['duty']:.2f}"))  # fmt: skip
    heads = ("strategy", "gains", "lower", "upper", "longer [m]", "tower [t]", "tower [MEUR]", "hull [MEUR]",
             "both [MEUR]",
             "pitch [deg]", "heave [s]", "rotor speed [rad/s]", "duty cycle [1e-3]")  # fmt: skip
    print(markdown((heads, lines), 3))


def main() -> None:
    warnings.simplefilter("ignore")
    if "--hull" in sys.argv:
        with_hull(Path(sys.argv[1]))
        return
    folder, sequential = Path(sys.argv[1]), "--sequential" in sys.argv
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
