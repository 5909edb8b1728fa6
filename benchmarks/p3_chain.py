"""The chain of the optimised 10-MW spar, sized for lines that move in a storm: `benchmarks/p3_chain.py FOLDER`.

Hull, tower and gains are those of p3_designs/optimum.json, the fairlead is at `--fairlead` metres. Chain diameter,
length and distance of the anchor become those of the least cost whose line is strong enough in EC1 and EC3. Surge is
kept below 32 m in EC3; in EC1 the response may have `--slack` times that, as it overstates surge near rated wind
(docs/p3_design.md, nonlinear time domain). `--seeds` hours of runs of EC1 to EC3 judge what was found.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from p3_design import STORMS, begun_at
from scipy.optimize import minimize

import fowtlib as fw
from fowtlib.design import rules
from fowtlib.design.file import read_design
from fowtlib.frequency import line_extreme, with_line_results

QUANTILE, HOUR, DISCARD, STEP = float(np.exp(-1)), 3600.0, 600.0, 0.1
IN_STORM = 1.04  # largest surge of runs in EC3, over that of the response; it is 1.02 and 1.03 at the fairlead
LINE = "mooring.line_2"
WATER_LINE = {"hull_diameters": 0.994, "hull_walls": 1.02}  # heavy lines shorten the heave period; and no more stress
CALM = {"sea.spectrum": "still", "wind.kind": "steady", "wind.mean_speed": 0.0, "thrust": 0.0}
UNIT = np.array([0.1, 10.0, 100.0])  # m: chain diameter, length less distance, distance


class Moored:
    """The optimised spar with its fairlead at a depth [m] and any chain."""

    def __init__(self, fairlead: float):
        here = Path(__file__).parent / "p3_designs" / "optimum.json"
        space = begun_at(read_design("dtu10mw_spar").design, here).space
        self.given = {**space.parameters(space.start), "fairlead_depth": np.array(fairlead)}
        for name, factor in WATER_LINE.items():
            sizes = np.array(self.given[name], dtype=float)
            sizes[10] *= factor
            self.given[name] = sizes
        deep = {"fairlead_depth": fairlead}
        self.storm = with_line_results(fw.load("dtu10mw_spar_3_storm", set=deep)).compile()
        self.running = fw.load("dtu10mw_spar_3_design", set={"mooring.dynamics": "coupled", **deep}).compile()

    def chain(self, x: np.ndarray) -> dict[str, Any]:
        """Parameters of a chain of x, over UNIT, with the ballast that makes the spar float at its draft."""
        d, slack, distance = np.asarray(x) * UNIT
        given = {**self.given, "chain_diameter": np.array(d), "line_length": np.array(distance + slack),
                 "line_distance": np.array(distance)}  # fmt: skip
        rest = self.storm.equilibrium(parameters=given_of(self.storm, given) | CALM, free=["ballast"],
                                      targets={"heave": 0.0})  # fmt: skip
        return {**given, "ballast": np.array(float(rest.parameters["ballast"]))}

    def plant(self, state: str) -> Any:
        return self.storm if state == "EC3" else self.running

    def weather(self, state: str) -> dict[str, float]:
        names = ("wind.mean_speed", "sea.significant_wave_height", "sea.peak_period", "wind.turbulence_intensity")
        return dict(zip(names, STORMS[state], strict=True))


def given_of(plant: Any, given: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in given.items() if name in plant.dae.parameters}


def use(mean: float, dynamic: float, given: dict[str, Any]) -> float:
    """Of the strength of the chain; tensions [N]."""
    d = float(given["chain_diameter"])
    return float(rules.mooring_strength(mean, dynamic, 27.4e6 * (44 - 80 * d) * d**2).utilisation)


def by_response(spar: Moored, given: dict[str, Any], state: str) -> dict[str, float]:
    """Largest surge [m], pitch [deg], offset [m], use of the line; by the response."""
    plant = spar.plant(state)
    more = [f"{LINE}.tension", f"{LINE}.shape_velocity"] if state == "EC3" else []
    found = fw.response(plant, outputs=["surge", "pitch", "fairlead_offset", "upwind_tension", *more],
                        parameters=given_of(plant, given) | spar.weather(state))  # fmt: skip
    largest = {name: found.extreme(name, HOUR, QUANTILE) for name in ("surge", "pitch", "fairlead_offset")}
    mean = 1e3 * found.mean_of("upwind_tension")
    dynamic = 1e3 * found.extreme("upwind_tension", HOUR, QUANTILE) - mean
    if more:
        dynamic = line_extreme(found, LINE, HOUR, QUANTILE).dynamic
    return {**largest, "line": use(mean, dynamic, given)}


def by_runs(spar: Moored, given: dict[str, Any], state: str, seeds: range) -> dict[str, float]:
    """The same, as the mean of the largest values of hours of runs."""
    plant, each = spar.plant(state), []
    for seed in seeds:
        own = {"wind.seed": seed, "sea.seed": seed + 50, "wind.repetition_period": DISCARD + HOUR,
               "sea.repetition_period": DISCARD + HOUR, "wind.sample_step": STEP}  # fmt: skip
        names = ["surge", "pitch", "fairlead_offset", "upwind_tension"]
        run = plant.simulate(DISCARD + HOUR, STEP, start="turning", solver="fixed", outputs=names,
                             parameters=given_of(plant, given) | spar.weather(state) | own)  # fmt: skip
        values = [np.asarray(run[name].values)[run.time >= DISCARD] for name in names]
        each.append([*(x.max() for x in values), values[-1].mean()])
    *largest, tension, mean = np.mean(each, axis=0)
    found = dict(zip(("surge", "pitch", "fairlead_offset"), map(float, largest), strict=True))
    return {**found, "line": use(1e3 * mean, 1e3 * (tension - mean), given)}


def uplift(given: dict[str, Any]) -> float:
    """Offset of the fairlead at which an anchor is pulled up [m]."""
    d = float(given["chain_diameter"])
    length, distance, depth = (float(given[name]) for name in ("line_length", "line_distance", "fairlead_depth"))
    return float(rules.uplift_limit(length, 187500 * d**2, 9e10 * d**2, 320 - depth, distance).offset)


def cost(x: np.ndarray) -> float:
    """Of the chain [MEUR]."""
    d, slack, distance = np.asarray(x) * UNIT
    return float(1e-6 * 3.5 * 3 * 187500 * d**2 / 9.80665 * (distance + slack))


def sized(spar: Moored, slack: float) -> np.ndarray:
    """The cheapest chain, over UNIT."""

    def room(x: np.ndarray) -> list[float]:
        given = spar.chain(x)
        first, storm = (by_response(spar, given, state) for state in ("EC1", "EC3"))
        off = max(first["fairlead_offset"] / slack, storm["fairlead_offset"] * IN_STORM)
        surge = max(first["surge"] / slack, storm["surge"] * IN_STORM)
        return [1 - storm["line"], 1 - first["line"], (32 - surge) / 10, (uplift(given) - off) / 10]

    found = minimize(cost, [1.09, 8.7, 9.2], constraints={"type": "ineq", "fun": room}, method="SLSQP",
                     bounds=[(0.7, 1.4), (5, 12), (5, 16)],
                     options={"maxiter": 12, "ftol": 1e-3, "eps": 1e-3})  # fmt: skip
    if not found.success:
        raise SystemExit(f"no chain was found: {found.message}")
    return np.asarray(found.x)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--fairlead", type=float, default=18.0)
    parser.add_argument("--slack", type=float, default=1.25)
    parser.add_argument("--states", nargs="+", choices=STORMS, default=list(STORMS))
    parser.add_argument("--seeds", type=int, default=0)
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    asked.folder.mkdir(parents=True, exist_ok=True)
    spar = Moored(asked.fairlead)
    x = sized(spar, asked.slack)
    given = spar.chain(x)
    print(f"chain {1e3 * given['chain_diameter']:.1f} mm, {given['line_length']:.1f} m to an anchor "
          f"{given['line_distance']:.1f} m away, {cost(x):.3f} MEUR; ballast {1e-6 * given['ballast']:.3f} kt; "
          f"an anchor is pulled up from {uplift(given):.2f} m on")  # fmt: skip
    for state in asked.states:
        print(state, "response:", {name: round(v, 3) for name, v in by_response(spar, given, state).items()})
        if asked.seeds:
            found = by_runs(spar, given, state, range(1, asked.seeds + 1))
            print(state, "runs:", {name: round(v, 3) for name, v in found.items()}, flush=True)
    plain = {name: np.asarray(value).tolist() for name, value in given.items()}
    (asked.folder / "chain.json").write_text(json.dumps(plain, indent=1))


if __name__ == "__main__":
    main()
