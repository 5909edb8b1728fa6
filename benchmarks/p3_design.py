"""Optimisation of the DTU 10-MW spar: `python benchmarks/p3_design.py FOLDER [--iterations 20] [--method slsqp]`.

Fifty variables: diameters and walls at the joints of hull and tower, chain, lines, fairlead, gains. Heights stay, and
hull walls are not thinner than printed, since ring frames and buckling of the shell are not among the limits. Least is
cost + 1.4e7 EUR s/rad times the weighted deviation of the rotor speed, the objective of Hegseth et al. (2020); limits
are those of docs/p3_design.md. Journal and design are kept in FOLDER; a search that was cut off goes on from its best.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import casadi as ca
import numpy as np

import fowtlib as fw
from fowtlib.design import Statistics, rules
from fowtlib.metocean import likely_states, site

CONTROL = "rna.turbine.control."
HULL = [f"hull_moment_node_{k}" for k in (8, 9, 10)]  # those below are far from their limits
TOWER = ["tower_base_moment", *(f"tower_moment_node_{k}" for k in range(1, 11))]
GRAVITY, WATER, LIFE = 9.80665, 1025.0, 20 * 365.25 * 86400.0
RINGS = 0.115  # cost of ring frames over that of the wall: what the cheapest ones of the printed hull cost
SPEEDS = {8.5: (4.0, 10.5), 13.0: (10.5, 15.5), 18.5: (15.5, 25.5)}


def cases() -> list[fw.DesignCase]:
    """EC1, and fatigue in three states with the probabilities of the winds about them."""
    law = site("northern_north_sea").at(119)
    whole, some = likely_states(law, range(1, 31)), likely_states(law, list(SPEEDS))
    found = [fw.DesignCase("EC1", {"wind.mean_speed": 11.0, "wind.turbulence_intensity": 0.18,
                                   "sea.significant_wave_height": 7.5, "sea.peak_period": 12.0}, 0.0)]  # fmt: skip
    for (u, h, t), (low, high) in zip(some, SPEEDS.values(), strict=True):
        share = float(whole.weights[(whole.wind_speed >= low) & (whole.wind_speed < high)].sum())
        weather = {"wind.mean_speed": u, "wind.turbulence_intensity": 0.14 * (0.75 * u + 5.6) / u,
                   "sea.significant_wave_height": h, "sea.peak_period": t}  # fmt: skip
        found.append(fw.DesignCase(f"wind {u:g}", weather, share))
    return found


def fatigue(results: list[str], tube: str, factor: float, heights: np.ndarray, at: np.ndarray):
    """Damage of 20 years times a factor at the places `at` of a tube, D curve of m = 5, of ranges at 1 Hz."""
    weights = np.array([np.interp(at, heights, unit) for unit in np.eye(len(heights))]).T

    def function(v):
        D, t = weights @ v[f"{tube}_diameters"], weights @ v[f"{tube}_walls"]
        section = np.pi * ((D - t) / 2) ** 2 * t
        ranges = ca.vertcat(*(v[f"range of {name}"] for name in results)) / section
        return factor * LIFE * (ranges * (ca.fmax(t, 0.025) / 0.025) ** 0.2) ** 5 / 10**15.606

    return fw.Function(
        f"{tube} fatigue", function, [f"range of {n}" for n in results] + [f"{tube}_diameters", f"{tube}_walls"]
    )


def functions(plant) -> list[fw.Function]:
    values = plant.parameter_values()
    z, zt = (np.array(values[name], dtype=float) for name in ("hull_heights", "tower_heights"))
    weight = float(np.ravel(values["chain_weight"])[0])

    def cost(v):
        hull = rules.steel_cost(rules.tube_sections(ca.DM(z), v["hull_diameters"], v["hull_walls"])).cost
        tower = rules.steel_cost(
            rules.tube_sections(ca.DM(zt), v["tower_diameters"], v["tower_walls"]), density=8500.0
        ).cost
        line = rules.mooring_cost(weight * v["chain_diameter"] ** 2 / GRAVITY, v["line_length"], 3)
        return ((1 + RINGS) * hull + tower + line) / 1e6

    def buckling(v):
        D, t = v["tower_diameters"], v["tower_walls"]
        r, wall = (D[1:] - t[1:] + D[:-1] - t[:-1]) / 4, (t[1:] + t[:-1]) / 2
        steel = np.pi * 8500.0 * np.diff(zt) / 2 * ((D[1:] - t[1:]) * t[1:] + (D[:-1] - t[:-1]) * t[:-1])
        used = []
        for k in range(10):
            load = GRAVITY * (676.7e3 + ca.sum1(steel[k:]))
            axial, bending, _ = rules.cylinder_stress(r[k], wall[k], -load, -1e6 * v[f"largest {TOWER[k]}"])
            used.append(rules.tower_buckling(1.35 * (axial + bending), r[k], wall[k], zt[k + 1] - zt[k]).utilisation)
        return ca.vertcat(*used)

    def strength(v):
        d, mean, largest = v["chain_diameter"], 1e3 * v["upwind_tension"], 1e3 * v["largest upwind_tension"]
        return rules.mooring_strength(mean, largest - mean, 27.4e6 * (44 - 80 * d) * d**2).utilisation

    def lifted(v):
        d = v["chain_diameter"]
        limit = rules.uplift_limit(
            v["line_length"], weight * d**2, 9e10 * d**2, 320.0 - v["fairlead_depth"], v["line_distance"]
        )
        return v["largest fairlead_offset"] - limit.offset

    def heave(v):
        D = v["hull_diameters"]
        at = np.append(z[:-1], 0.0)
        wet = ca.vertcat(D[:-1], D[-2] + (D[-1] - D[-2]) * (0.0 - z[-2]) / (z[-1] - z[-2]))
        a, b = wet[:-1], wet[1:]
        volume = ca.sum1(np.pi / 12 * np.diff(at) * (a**2 + a * b + b**2))
        return rules.heave_period(WATER * volume, D[0], wet[-1])

    def taper(tube, heights):
        return lambda v: (
            (v[f"{tube}_diameters"][1:] - v[f"{tube}_diameters"][:-1]) / (2 * np.diff(heights)) / np.tan(np.pi / 18)
        )

    sizes = ["hull_diameters", "hull_walls", "tower_diameters", "tower_walls"]
    return [
        fw.Function("cost", cost, [*sizes, "chain_diameter", "line_length"], "MEUR"),
        fw.Function("tower buckling", buckling,
                    ["tower_diameters", "tower_walls", *(f"largest {n}" for n in TOWER[:10])]),
        fw.Function("line strength", strength, ["chain_diameter", "upwind_tension", "largest upwind_tension"]),
        fw.Function("uplift", lifted, ["chain_diameter", "line_length", "line_distance", "fairlead_depth",
                                       "largest fairlead_offset"], "m"),
        fw.Function("heave period", heave, ["hull_diameters"], "s"),
        fw.Function("hull taper", taper("hull", z), ["hull_diameters"]),
        fw.Function("tower taper", taper("tower", zt), ["tower_diameters"]),
        fw.Function("joint", lambda v: ca.vertcat(v["hull_diameters"][-1] - v["tower_diameters"][0],
                                                  100 * (v["hull_walls"][-1] - v["tower_walls"][0])),
                    sizes, "m"),
        fatigue(HULL, "hull", 3.0, z, np.array([*z[8:10], 0.0])),
        fatigue(TOWER, "tower", 2.0, zt, zt),
    ]  # fmt: skip


def design() -> fw.Design:
    plant = fw.load("dtu10mw_spar_3_design").compile()
    values = plant.parameter_values()
    printed = {name: np.array(values[name], dtype=float) for name in ("hull_diameters", "hull_walls")}
    # damages in the fifth root, which is nearly linear in the sizes
    made = functions(plant)
    roots = [fw.Function(f"{tube} use", lambda v, n=f"weighted {tube} fatigue": v[n] ** 0.2,
                         [f"weighted {tube} fatigue"])
             for tube in ("hull", "tower")]  # fmt: skip
    made.append(
        fw.Function(
            "value", lambda v: v["cost"] + 14 * v["std of rotor_speed"] * np.pi / 30, ["cost", "std of rotor_speed"]
        )
    )
    gain, integral = CONTROL + "proportional_gain", CONTROL + "integral_gain"
    return fw.Design(
        plant,
        variables=[
            fw.Variable("hull_diameters", 0.8 * printed["hull_diameters"], 1.2 * printed["hull_diameters"]),
            fw.Variable("hull_walls", printed["hull_walls"], 1.8 * printed["hull_walls"]),
            fw.Variable("tower_diameters", 5.0, 17.0), fw.Variable("tower_walls", 0.012, 0.09),
            fw.Variable("line_length", 1200.0, 1900.0), fw.Variable("line_distance", 1130.0, 1830.0),
            fw.Variable("chain_diameter", 0.06, 0.11), fw.Variable("fairlead_depth", 9.5, 18.0),
            fw.Variable(gain, 0.001, 0.012), fw.Variable(integral, 5e-5, 1.2e-3),
        ],
        objective="value",
        constraints=[
            "largest pitch @ EC1 < 15 deg", "largest surge @ EC1 < 32 m",
            fw.Constraint("line strength", upper=1.0, cases=["EC1"]),
            fw.Constraint("uplift", upper=0.0, cases=["EC1"], scale=10.0),
            fw.Constraint("tower buckling", upper=1.0, cases=["EC1"]),
            fw.Constraint("heave period", lower=25.0), fw.Constraint("hull taper", lower=-1.0, upper=1.0),
            fw.Constraint("tower taper", lower=-1.0, upper=1.0),
            fw.Constraint("joint", lower=0.0, upper=0.0, scale=10.0),
            fw.Constraint("hull use", upper=1.0), fw.Constraint("tower use", upper=1.0),
        ],
        cases=cases(), functions=[*made, *roots], free=["ballast"], targets={"heave": 0.0},
        statistics=Statistics(quantile=float(np.exp(-1)), exponent=5.0), slopes="adjoint",
        title="Optimised DTU 10-MW spar",
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--iterations", type=int, default=20)
    parser.add_argument("--method", default="slsqp")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    begun = time.perf_counter()

    def say(line: str) -> None:
        print(f"{time.perf_counter() - begun:7.0f} s {time.process_time():6.0f} s  {line}", flush=True)

    asked = design()
    print(asked.evaluate() if hasattr(asked, "evaluate") else "", flush=True)
    say("the start")
    found = asked.optimise(arguments.method, tolerance=1e-3, iterations=arguments.iterations, resume=True,
                           journal=str(arguments.folder / "journal.jsonl"), say=say)  # fmt: skip
    print(found)
    found.save(arguments.folder / "design.json")
    found.plot(arguments.folder / "design.png")


if __name__ == "__main__":
    main()
