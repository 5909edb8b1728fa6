"""The optimised DTU 10-MW spar of Hegseth et al. (2020), evaluated: `python benchmarks/p3_optimum.py [DESIGN.json]`.

Prints the tables of docs/p3_design.md: cost by parts, largest values in the three 50-year states, fatigue over the 30
states of a site, buckling, periods. Beside them what is printed in Marine Structures 72, 102771, tables 3 to 9. With a
file of parameters by path, or one that `Optimum.save` wrote, the same of that design. `--gains` also finds the gains
of the least weighted deviation of the rotor speed for the sizes as they are.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from p3_design import begun_at
from scipy.optimize import minimize

import fowtlib as fw
from fowtlib.analysis.fatigue import SNCurve, TubeSection, sn_curve
from fowtlib.analysis.maps import quantities_at
from fowtlib.design import rules
from fowtlib.design.file import read_design
from fowtlib.frequency import line_extreme, with_line_results
from fowtlib.metocean import likely_states, site

HOUR, CHARACTERISTIC = 3600.0, float(np.exp(-1))  # the most probable largest value of an hour
EXTREMES = {"EC1": (11.0, 7.5, 12.0, 0.18), "EC2": (21.0, 9.9, 14.0, 0.14), "EC3": (50.0, 15.1, 16.0, 0.12)}
RNA, GRAVITY, WATER, LOAD_FACTOR = 676.7e3, 9.80665, 1025.0, 1.35
WEIGHT = 187500.0  # of chain in water, over its length and diameter squared [N/m^3]
BREAKING = lambda d: 27.4e-3 * (44 - 80 * d) * d**2 * 1e9  # noqa: E731 (N, of R4 studless chain; d in m)
GAINS = ("rna.turbine.control.proportional_gain", "rna.turbine.control.integral_gain")
NODES = [*(f"hull_moment_node_{k}" for k in range(1, 11)), "tower_base_moment",
         *(f"tower_moment_node_{k}" for k in range(1, 11))]  # fmt: skip
FORCES = [f"hull_axial_force_node_{k}" for k in range(1, 11)]
CURVES = {  # for tower in air, for hull with cathodic protection
    "m = 5": (SNCurve(5.0, 15.606, thickness_exponent=0.2),) * 2,
    "m = 3": (SNCurve(3.0, 12.164, thickness_exponent=0.2), SNCurve(3.0, 11.764, thickness_exponent=0.2)),
    "two slopes": (sn_curve("D"), sn_curve("D", "cathodic protection")),
}


class Spar:
    """The spar in operation and in a storm, with parameters in place of those of the printed design."""

    def __init__(self, parameters: dict[str, Any]):
        # the model is built with them: no hinge nor joint of the hull may come by its fairlead later
        self.built = {name: np.asarray(value).tolist() for name, value in parameters.items()
                      if name.startswith(("hull_", "tower_", "fairlead_"))}  # fmt: skip
        self.operating = fw.load("dtu10mw_spar_3_design", set=self.built).compile()
        self.parked = fw.load("dtu10mw_spar_3_parked", set=self.built).compile()
        self.given = dict(parameters)
        values = {**self.operating.parameter_values(), **parameters}
        names = ("hull_heights", "hull_diameters", "hull_walls", "tower_heights", "tower_diameters", "tower_walls")
        self.z, self.D, self.t, self.tower_z, self.tower_D, self.tower_t = (
            np.array(values[name], dtype=float) for name in names
        )
        self.values = values
        self._balance()

    def _balance(self) -> None:
        """Ballast for a heave of zero at rest, which all states take."""
        calm = {"sea.spectrum": "still", "wind.kind": "steady", "wind.mean_speed": 0.0, "thrust": 0.0}
        self.rest = self.parked.equilibrium(
            parameters=self._of(self.parked) | calm, free=["ballast"], targets={"heave": 0.0}
        )
        self.given["ballast"] = float(self.rest.parameters["ballast"])
        names = [f"period of {mode}" for mode in ("surge", "heave", "pitch")]
        self.periods = {
            name: float(np.ravel(value)[0]) for name, value, _ in quantities_at(self.parked, self.rest, names)
        }

    def _of(self, plant: Any) -> dict[str, Any]:
        """The given parameters that a plant has."""
        return {path: value for path, value in self.given.items() if path in plant.dae.parameters}

    def response(self, speed: float, height: float, period: float, intensity: float, outputs: list[str]) -> fw.Response:
        weather = {"wind.mean_speed": speed, "wind.turbulence_intensity": intensity,
                   "sea.significant_wave_height": height, "sea.peak_period": period}  # fmt: skip
        if 4.0 <= speed <= 25.0:
            return fw.response(self.operating, outputs=outputs, parameters=self._of(self.operating) | weather)
        thrust = {"thrust": 192.6e3 * (speed / 50.0) ** 2}
        some = [name for name in outputs if name in self.parked.outputs]
        return fw.response(self.parked, outputs=some, parameters=self._of(self.parked) | weather | thrust)

    def states(self) -> tuple[list[tuple[float, float, float, float]], np.ndarray]:
        """The most probable seas in 1 to 30 m/s at the hub, class B, and their probabilities."""
        found = likely_states(site("northern_north_sea").at(119), range(1, 31))
        rows = [(u, h, t, 0.14 * (0.75 * u + 5.6) / u) for u, h, t in found]
        return rows, found.weights

    def line(self) -> dict[str, float]:
        """Weight in water [N/m], stiffness [N], breaking strength [N] of the chain."""
        d = float(self.values["chain_diameter"])
        return {"weight": WEIGHT * d**2, "EA": 9e10 * d**2, "strength": BREAKING(d), "d": d}


def ring_of(
    spar: Spar, k: int, axial: np.ndarray, moment: np.ndarray
) -> tuple[np.ndarray, dict[str, float], list[float]]:
    """The cheapest ring frames of section k that keep the rules; sizes, utilisations; cost [EUR] and mass [kg] of all.

    axial [N] and moment [N m] at the two ends, the larger counts; mean radius and wall, pressure of the lower end.
    """
    import casadi as ca

    r, t = (spar.D[k : k + 2].mean() - spar.t[k : k + 2].mean()) / 2, spar.t[k : k + 2].mean()
    pressure = WATER * GRAVITY * max(0.0, -spar.z[k])
    length = spar.z[k + 1] - spar.z[k]
    stress, bending, _ = rules.cylinder_stress(r, t, axial.min(), -np.abs(moment).max())
    x = ca.SX.sym("x", 5)
    unit = np.array([0.5, 0.015, 0.25, 0.02, 2.5])
    ring = rules.Ring(*(x[i] * unit[i] for i in range(5)))
    hoop = rules.hoop_stress(pressure, stress + bending, r, t, ring.spacing, ring.area, ring.flange_radius(r, t))
    shell = rules.shell_buckling(stress, bending, r, t, ring.spacing, hoop_stress=hoop.between, least_factor=1.10)
    frame = rules.panel_ring(ring, r, t, stress + bending, pressure)
    uses = {"shell": shell.utilisation, "area": frame.area, "inertia": frame.inertia, "stress": frame.stress,
            "web": frame.web, "flange": frame.flange, "torsion": frame.torsion}  # fmt: skip
    section = rules.TubeSections(
        ca.SX([length]), ca.SX([2 * r + t]), ca.SX([t]), ca.SX([np.pi * 2 * r * t * length]), ca.SX([2 * r + t])
    )
    work = rules.ring_fabrication_times(section, ring)
    mass = work.pop("mass of rings [kg]")
    cost = 2.7 * (mass + sum(work.values()))
    solver = ca.nlpsol("ring", "ipopt", {"x": x, "f": cost / 1e4, "g": ca.vertcat(*uses.values())},
                       {"ipopt.print_level": 0, "print_time": 0, "ipopt.max_iter": 400})  # fmt: skip
    best = None
    for start in ([1, 1, 1, 1, 1], [1.5, 1.5, 1.5, 1.5, 0.6], [0.6, 0.8, 0.8, 0.8, 1.5]):
        found = solver(x0=start, lbx=0.1, ubx=[4, 6, 4, 6, length / unit[4]], ubg=1.0)
        if solver.stats()["success"] and (best is None or float(found["f"]) < float(best["f"])):
            best = found
    if best is None:
        at = ca.Function("at", [x], list(uses.values()))(np.ones(5))
        return np.full(5, np.nan), {name: float(v) for name, v in zip(uses, at, strict=True)}, [np.nan, np.nan]
    at = [float(v) for v in ca.Function("at", [x], [*uses.values(), cost, mass])(best["x"])]
    return np.ravel(best["x"]) * unit, dict(zip(uses, at, strict=False)), at[-2:]


def show(title: str, head: list[str], rows: list[list[Any]]) -> None:
    print(f"\n### {title}\n\n| {' | '.join(head)} |\n|{' --- |' * len(head)}")
    for row in rows:
        print("| " + " | ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row) + " |")


def cost(spar: Spar, rings: float) -> float:
    shell = rules.steel_cost(rules.tube_sections(spar.z, spar.D, spar.t)).cost / 1e6
    tower = rules.steel_cost(rules.tube_sections(spar.tower_z, spar.tower_D, spar.tower_t), density=8500.0).cost / 1e6
    line = rules.mooring_cost(spar.line()["weight"] / GRAVITY, float(spar.values["line_length"]), 3) / 1e6
    total = tower + shell + line + rings / 1e6
    show("Cost [MEUR]", ["part", "here", "printed"], [
        ["tower", tower, ""], ["hull, wall", shell, ""], ["hull, ring frames", rings / 1e6, "0.50 (what is left)"],
        ["mooring", line, ""], ["sum", total, 12.17]])  # fmt: skip
    return total


def extremes(spar: Spar) -> dict[str, fw.Response]:
    outputs = ["surge", "fairlead_offset", "pitch", "heave", "upwind_tension", "rotor_speed", *NODES, *FORCES]
    found = {name: spar.response(*state, outputs) for name, state in EXTREMES.items()}
    line, rows = spar.line(), []
    for name, one in found.items():
        largest = {
            result: one.extreme(result, HOUR, CHARACTERISTIC)
            for result in ("surge", "fairlead_offset", "pitch", "upwind_tension")
        }
        mean = one.mean_of("upwind_tension")
        use = rules.mooring_strength(mean * 1e3, (largest["upwind_tension"] - mean) * 1e3, line["strength"])
        speed = one.std("rotor_speed") if "rotor_speed" in one.outputs else float("nan")
        rows.append([name, one.mean_of("surge"), one.std("surge"), largest["surge"], largest["fairlead_offset"],
                     one.mean_of("pitch"),
                     one.std("pitch"), largest["pitch"], largest["upwind_tension"] / 1e3, use.tension / 1e6,
                     float(use.utilisation), speed * np.pi / 30])  # fmt: skip
    show("50-year states: printed in EC1 32.0 m, 15.0 deg, T_d 5.91 MN",
         ["state", "surge mean [m]", "std", "largest", "at the fairlead", "pitch mean [deg]", "std", "largest",
          "tension [MN]",
          "T_d [MN]", "T_d / 0.95 MBS", "std of rotor speed [rad/s]"], rows)  # fmt: skip
    limit = rules.uplift_limit(float(spar.values["line_length"]), line["weight"], line["EA"],
                               320.0 - float(spar.values["fairlead_depth"]),
                               float(spar.values["line_distance"]))  # fmt: skip
    print(f"\nAn anchor is pulled up from {limit.offset:.2f} m on. Breaking strength {line['strength'] / 1e6:.3f} MN.")
    return found


def moving_line(spar: Spar) -> None:
    """T_d in the 50-year states with lines that move, each in one degree of freedom."""
    line, plants = spar.line(), {}
    for name, (speed, height, period, intensity) in EXTREMES.items():
        which = "design" if speed <= 25.0 else "parked"
        if which not in plants:
            plants[which] = with_line_results(
                fw.load(f"dtu10mw_spar_3_{which}", set={"mooring.dynamics": "coupled", **spar.built})
            ).compile()
        plant = plants[which]
        given = {"wind.mean_speed": speed, "wind.turbulence_intensity": intensity,
                 "sea.significant_wave_height": height, "sea.peak_period": period}  # fmt: skip
        storm = {} if which == "design" else {"thrust": 192.6e3 * (speed / 50.0) ** 2}
        one = fw.response(plant, parameters=spar._of(plant) | given | storm)
        found = line_extreme(one, "mooring.line_2", HOUR, CHARACTERISTIC)
        use = rules.mooring_strength(found.mean, found.dynamic, line["strength"])
        print(f"\n{name} with lines that move: tension {found.mean / 1e6:.2f} + {found.dynamic / 1e6:.2f} MN, "
              f"T_d {use.tension / 1e6:.2f} MN, utilisation {float(use.utilisation):.2f}.", flush=True)  # fmt: skip


def fatigue(spar: Spar) -> None:
    rows, shares = spar.states()
    found = [spar.response(*row, [*NODES, "rotor_speed"]) for row in rows]
    speeds = np.array([one.std("rotor_speed") * np.pi / 30 if "rotor_speed" in one.outputs else 0.0 for one in found])
    running = np.array(["rotor_speed" in one.outputs for one in found])
    show("Deviation of the rotor speed [rad/s]", ["wind [m/s]", "Hs [m]", "Tp [s]", "probability", "std"],
         [[*map(float, row[:3]), float(p), float(s)]
          for row, p, s in zip(rows, shares, speeds, strict=True)])  # fmt: skip
    print(f"\nWeighted over all states {shares @ speeds:.4f} rad/s, over those in operation "
          f"{shares[running] @ speeds[running] / shares[running].sum():.4f} rad/s; printed 1.65 to 1.82 times 0.043 = "
          "0.071 to 0.078 rad/s (the larger one with these gains).")  # fmt: skip
    D, t, z = (np.concatenate([hull[1:-1], tower]) for hull, tower in
               ((spar.D, spar.tower_D), (spar.t, spar.tower_t), (spar.z, spar.tower_z)))  # fmt: skip
    life, table = 20 * 365.25 * 86400.0, []
    for k, name in enumerate(NODES):
        tower = k >= 10
        factor, each = (2.0 if tower else 3.0), []
        for air, wet in CURVES.values():
            curve, section = (air if tower else wet).with_thickness(t[k]), TubeSection(D[k], t[k])
            each.append(float(factor * shares @ [one.damage(name, curve, section, duration=life) for one in found]))
        table.append(["tower" if tower else "hull", float(z[k]), float(D[k]), float(1e3 * t[k]), *each])
    show("Fatigue, 20 years, times 2 (tower, in air) or 3 (hull, cathodic protection)",
         ["part", "height [m]", "diameter [m]", "wall [mm]", *CURVES], table)  # fmt: skip


def tower(spar: Spar, found: dict[str, fw.Response]) -> None:
    D, t, z = spar.tower_D, spar.tower_t, spar.tower_z
    cut = 0.5 * np.pi * np.diff(z) * 8500.0 * ((D[1:] - t[1:]) * t[1:] + (D[:-1] - t[:-1]) * t[:-1])
    above = RNA + np.concatenate([np.cumsum(cut[::-1])[::-1], [0.0]])
    rows = []
    for k in range(len(cut)):
        r, wall = (D[k] - t[k] + D[k + 1] - t[k + 1]) / 4, (t[k] + t[k + 1]) / 2
        row: list[Any] = [float(z[k]), float(z[k + 1])]
        for one in found.values():
            moment = max(_largest(one, NODES[10 + k]), _largest(one, NODES[11 + k]))
            axial, bending, _ = rules.cylinder_stress(r, wall, -above[k] * GRAVITY, -moment)
            row.append(
                float(rules.tower_buckling(LOAD_FACTOR * (axial + bending), r, wall, z[k + 1] - z[k]).utilisation)
            )
        rows.append(row)
    show("Buckling of the tower, all loads times 1.35", ["from [m]", "to [m]", *found], rows)


def _largest(one: fw.Response, name: str) -> float:
    """The larger of both sides, N m."""
    return 1e6 * max(one.extreme(name, HOUR, CHARACTERISTIC), -one.extreme(name, HOUR, CHARACTERISTIC, "min"))


def hull(spar: Spar, found: dict[str, fw.Response], ends_pressed: bool = True) -> float:
    """Ring frames: sizes, utilisations, cost [EUR]. ends_pressed: water presses along the hull, too."""
    z, D = spar.z, spar.D
    nodes = z[1:-1]
    rows, total, mass = [], 0.0, 0.0
    for k in range(len(z) - 1):
        ends = [max(0, k - 1), k]  # of NODES: the keel bears less than the node above it
        worst = []
        for one in found.values():
            moments = np.array([_largest(one, NODES[e]) for e in ends])
            axial = []
            for e in ends:
                own = min(e, 9)
                pressed = WATER * GRAVITY * -nodes[own] * np.pi / 4 * np.interp(nodes[own], z, D) ** 2
                axial.append(1e6 * one.mean_of(FORCES[own]) - pressed * ends_pressed)
            worst.append((LOAD_FACTOR * moments.max(), np.array(axial), LOAD_FACTOR * moments))
        _, axial, moments = max(worst, key=lambda item: item[0])
        sizes, uses, price = ring_of(spar, k, axial, moments)
        total, mass = total + price[0], mass + price[1]
        rows.append([float(z[k]), float(z[k + 1]), axial.min() / 1e6, moments.max() / 1e6, *(1e3 * sizes[:4]),
                     float(sizes[4]),
                     *uses.values(), price[0] / 1e3])  # fmt: skip
    if not ends_pressed:
        print(
            f"\nWithout the pressure along the hull ring frames cost {total / 1e6:.3f} MEUR, {mass / 1e3:.0f} t."
        )
        return total
    share = 100 * float(spar.values["stiffener_fraction"])
    print(f"\nRing frames: {mass / 1e3:.0f} t; {share:.1f} % of the wall are in the model.")
    show("Hull: the cheapest ring frames that keep the rules",
         ["from [m]", "to [m]", "axial [MN]", "moment [MN m]", "web height [mm]", "web", "flange width", "flange",
          "spacing [m]", "shell", "area", "inertia", "stress", "web", "flange", "torsion", "kEUR"],
         [[float(v) if not isinstance(v, str) else v for v in row] for row in rows])  # fmt: skip
    return total


def gains(spar: Spar) -> None:
    """The gains with the least weighted deviation of the rotor speed."""
    rows, shares = spar.states()
    start = np.array([float(spar.values[name]) for name in GAINS])
    some = [(row, p) for row, p in zip(rows, shares, strict=True) if 4.0 <= row[0] <= 25.0]

    def deviation(x: np.ndarray) -> float:
        spar.given.update(zip(GAINS, start * np.exp(x), strict=True))
        try:
            total = sum(p * spar.response(*row, ["rotor_speed"]).std("rotor_speed") for row, p in some)
        except fw.ModelError:
            return 1.0
        return float(total * np.pi / 30)

    found = minimize(
        deviation,
        [0.0, 0.0],
        method="Nelder-Mead",
        options={"maxfev": 40, "initial_simplex": [[0, 0], [0.4, 0], [0, 0.4]]},
    )
    best = start * np.exp(found.x) * 50
    print(f"\nGains of the least weighted deviation: {best[0]:.4f} s, {best[1]:.5f} (of the rotor speed), "
          f"{deviation(np.zeros(2)):.4f} -> {found.fun:.4f} rad/s.")  # fmt: skip


def parameters_of(path: Path) -> dict[str, Any]:
    """The parameters in a saved design of models/designs/dtu10mw_spar.yaml, or a plain mapping."""
    saved = json.loads(path.read_text())
    if "variables" in saved:
        space = begun_at(read_design("dtu10mw_spar").design, path).space
        return dict(space.parameters(space.start))
    known = fw.load("dtu10mw_spar_3_design").compile().dae.parameters
    if unknown := [name for name in saved if name not in known]:
        raise SystemExit(f"{path}: the spar has no parameter '{unknown[0]}'.")
    return {name: np.array(value) if isinstance(value, list) else value for name, value in saved.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", nargs="?", type=Path, help="a saved design; without one, the printed one")
    parser.add_argument("--gains", action="store_true", help="also find the best gains")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    spar = Spar({} if arguments.design is None else parameters_of(arguments.design))
    printed = {"period of surge": 144.7, "period of heave": 25.0, "period of pitch": 34.4}
    show("At rest", ["", "here", "printed"], [[name, value, printed[name]] for name, value in spar.periods.items()])
    print(f"\nballast {spar.given['ballast'] / 1e6:.3f} kt")
    found = extremes(spar)
    tower(spar, found)
    hull(spar, found, False)
    cost(spar, hull(spar, found))
    moving_line(spar)
    fatigue(spar)
    if arguments.gains:
        gains(spar)


if __name__ == "__main__":
    main()
