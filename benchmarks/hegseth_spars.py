"""The spars of Hegseth and Bachynski (2019), and that of Hegseth et al. (2020): tables for docs/elastic_spars.md.

`python benchmarks/hegseth_spars.py extremes`   the four 50-year states beside the printed ones and beside runs
`python benchmarks/hegseth_spars.py runs`       deviations beside runs, of spars 1 and 2 and of the optimised spar
`python benchmarks/hegseth_spars.py fatigue`    damage of an hour in five states, Dirlik beside rainflow of runs
`python benchmarks/hegseth_spars.py life`       fatigue in 546 states, Dirlik beside rainflow of runs
`python benchmarks/hegseth_spars.py shift`      fatigue of spar 2 with its bending of 1.85 s, and with that of 1.79 s
`python benchmarks/hegseth_spars.py shapes`     a picture of the modes of the optimised spar, and their periods

Runs are hours with a wind and a sea of their own (`--seeds 6`), after 600 s from the mean position. Bounds are those of
the mean of the seeds at 95 % (Student). What runs gave is kept in `--folder`, so that a stopped benchmark goes on.
`--spars 1,2` chooses the spars of runs, fatigue and life, `--cases 9,EC1` the states of runs, and `--set PATH=VALUE`
switches off a cause there, in runs and response.
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from pages import markdown
from scipy.stats import t as student

import fowtlib as fw
from fowtlib.analysis.fatigue import SNCurve, TubeSection, rainflow_cycles, sn_curve
from fowtlib.analysis.spectra import power_spectrum
from fowtlib.metocean import centre_bins, likely_states, site
from fowtlib.solving.results.drawing import COLORS, INK, drawing, drawing_style, save_figure

DISCARD, HOUR, STEP = 600.0, 3600.0, 0.1
MODE = np.exp(-1)  # quantile of the most probable largest value
BASE = {1: TubeSection(8.3, 0.038), 2: TubeSection(8.3, 0.057), 3: TubeSection(12.66, 0.061)}  # of the tower, m
CURVES = {
    spar: {
        "D, one slope of 3": SNCurve(3.0, 12.164, thickness_exponent=0.2).with_thickness(section.wall_thickness),
        "D, two slopes": sn_curve("D", thickness=section.wall_thickness),
    }
    for spar, section in BASE.items()
}
FAST = 0.3  # Hz, between the waves and what the blades do in passing the tower
SHAPES = {"surge": 147.6, "pitch": 34.0, "first bending": 1.31, "second bending": 0.4}  # s, about
FEATHERED = 61.0  # N/(m/s)^2, drag of the idling rotor, by dtu10mw_land in 50 m/s: 152.4 kN
OF_50_YEARS = {  # mean wind speed [m/s], significant wave height [m], peak period [s]
    "EC1": (11.0, 6.9, 10.0), "EC2": (25.0, 10.3, 12.5), "EC3": (36.0, 12.9, 14.0), "EC4": (50.0, 15.1, 16.0),
}  # fmt: skip
LIKELY = {"9": (9.0, 2.5, 9.3), "13": (13.0, 3.3, 9.7), "15": (15.0, 3.7, 9.9), "21": (21.0, 5.0, 10.6)}
RESULTS = ("surge", "heave", "pitch", "rotor_speed", "blade_pitch", "thrust", "tower_base_moment", "upwind_tension")
# mean, deviation and extreme of an hour, printed in tables 6 to 11 for EC1 to EC4: nonlinear runs and frequency domain
PRINTED = {
    (1, "tower_base_moment"): (
        ((247.2, 89.1, 534.2), (123.0, 101.0, 480.6), (50.3, 106.5, 418.7), (105.2, 118.8, 509.8)),
        ((260.8, 89.4, 575.7), (127.8, 100.8, 491.7), (52.3, 106.3, 415.4), (101.3, 115.1, 491.3)),
    ),
    (2, "tower_base_moment"): (
        ((305.7, 103.8, 624.1), (152.9, 106.2, 529.6), (63.6, 115.5, 462.6), (132.8, 129.7, 577.4)),
        ((329.4, 104.8, 699.3), (161.4, 110.6, 562.0), (66.5, 118.4, 469.9), (128.9, 128.5, 563.3)),
    ),
    (1, "surge"): (
        ((27.3, 6.9, 44.2), (13.8, 2.4, 21.4), (8.0, 2.9, 17.8), (15.1, 4.6, 29.4)),
        ((28.6, 5.4, 43.8), (14.1, 2.3, 21.4), (7.9, 2.5, 16.1), (15.3, 3.5, 26.6)),
    ),
    (2, "surge"): (
        ((23.7, 6.2, 38.6), (12.0, 2.2, 19.0), (6.6, 2.7, 15.7), (13.7, 3.9, 26.4)),
        ((26.1, 5.2, 40.7), (12.8, 2.2, 20.0), (7.0, 2.5, 15.1), (13.6, 3.5, 24.9)),
    ),
    (1, "pitch"): (
        ((6.7, 1.8, 10.7), (3.4, 1.0, 6.7), (1.7, 1.2, 5.5), (3.4, 1.7, 9.1)),
        ((7.2, 1.7, 12.3), (3.5, 1.0, 6.6), (1.7, 1.0, 5.0), (3.2, 1.4, 7.7)),
    ),
    (2, "pitch"): (
        ((9.2, 2.4, 14.4), (4.6, 1.3, 8.6), (2.2, 1.3, 6.6), (4.4, 2.1, 11.3)),
        ((10.0, 2.3, 16.7), (4.9, 1.3, 8.7), (2.2, 1.2, 6.0), (4.3, 1.7, 9.8)),
    ),
}


def weather(speed: float, height: float, period: float) -> dict[str, Any]:
    """Parameters of a state."""
    given = {
        "wind.kind": "ntm", "wind.turbulence_class": "B", "wind.mean_speed": speed, "sea.spectrum": "jonswap",
        "sea.significant_wave_height": height, "sea.peak_period": period,
    }  # fmt: skip
    return given | ({"thrust": FEATHERED * speed**2} if speed > 25.0 else {})


_plants: dict[str, Any] = {}


def plant_of(spar: int, speed: float, tower_drag: bool = False) -> tuple[str, Any]:
    """Name and plant of the model for a wind: in operation, with drag of the tower or without it, or at rest."""
    name = f"dtu10mw_spar_{spar}" + ("_operating" if speed <= 25.0 else "")
    label = name + ("_with_drag" if tower_drag and speed <= 25.0 else "")
    if label not in _plants:
        _plants[label] = fw.load(name, set={} if label == name else {"tower_drag.active": True}).compile()
    return label, _plants[label]


def hours(
    folder: Path, spar: int, state: tuple[float, float, float], seeds: int, tower_drag: bool = False,
    further: dict[str, float] | None = None,
) -> list[dict[str, Any]]:
    """Of so many seeds at least: (mean, deviation, largest) of each result, and the damage of the tower's base."""
    name, plant = plant_of(spar, state[0], tower_drag)
    found: list[dict[str, Any]] = []
    label = "".join(f"_{path}={value:g}" for path, value in (further or {}).items())
    while True:
        seed = len(found) + 1
        path = folder / f"{name}_{state[0]:g}_{state[1]:g}_{state[2]:g}{label}_{seed}.json"
        if not path.exists():
            if seed > seeds:
                return found
            period = {f"{part}.repetition_period": DISCARD + HOUR for part in ("wind", "sea")}
            seeded = period | {"wind.seed": seed, "sea.seed": seed + 50, "wind.sample_step": STEP}
            given = weather(*state) | (further or {}) | seeded
            run = plant.simulate(DISCARD + HOUR, STEP, start="turning", solver="fixed", parameters=given)
            path.write_text(json.dumps(numbers(run, spar)))
        found.append(json.loads(path.read_text()))


def numbers(run: Any, spar: int) -> dict[str, Any]:
    """What is kept of a run."""
    kept = run.time >= DISCARD
    values = {name: np.asarray(run[name].values)[kept] for name in RESULTS if name in run.names}
    stress = values["tower_base_moment"] * 1e6 * BASE[spar].bending
    cycles = rainflow_cycles((run.time[kept], stress))
    damage = {name: float(curve.damage(cycles)) for name, curve in CURVES[spar].items()}
    fast = float(np.sqrt(power_spectrum((run.time[kept], values["tower_base_moment"]), segment=600.0).moment(0, FAST)))
    return {n: [float(v.mean()), float(v.std()), float(v.max())] for n, v in values.items()} | {
        "damage": damage, "fast": fast,
    }  # fmt: skip


def bound(values: np.ndarray) -> float:
    """Half of the range of 95 % of the mean of the values."""
    if len(values) < 2:
        return np.nan
    return float(student.ppf(0.975, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values)))


def extremes(folder: Path, seeds: int) -> None:
    """Mean, deviation and most probable largest value of an hour, as printed and as found."""
    found, names = {}, ["tower_base_moment", "surge", "pitch"]
    for spar in (1, 2):
        for case, state in OF_50_YEARS.items():
            plant = plant_of(spar, state[0], tower_drag=True)[1]
            found[spar, case] = fw.response(plant, outputs=names, parameters=weather(*state))
    print("| mean; deviation; largest | source, runs | source, linear | response | runs |")
    print("| --- | --- | --- | --- | --- |")
    for (spar, name), (runs, linear) in PRINTED.items():
        for k, (case, state) in enumerate(OF_50_YEARS.items()):
            runs_of = hours(folder, spar, state, seeds, tower_drag=True)
            one, ours = found[spar, case], np.array([run[name] for run in runs_of])
            cells = [runs[k], linear[k], (one.mean_of(name), one.std(name), one.extreme(name, HOUR, MODE))]
            if len(ours) > 1:
                cells.append((*ours[:, :2].mean(axis=0), gumbel_mode(ours[:, 2])))
            else:
                cells.append(())
            places = 1 if name == "tower_base_moment" else 2
            words = ["; ".join(f"{x:.{1 if i < 2 else places}f}" for x in cell) for i, cell in enumerate(cells)]
            print(f"| spar {spar}, {case}, {name} [{one.unit(name)}] | " + " | ".join(words) + " |", flush=True)
    print("\n| response over runs | seeds | deviation, moment | surge | pitch | largest, moment | surge | pitch |")
    print("| --- " * 8 + "|")
    for (spar, case), one in found.items():
        runs_of = hours(folder, spar, OF_50_YEARS[case], seeds, tower_drag=True)
        cells = []
        for column in (1, 2):
            for name in names:
                values = np.array([run[name][column] for run in runs_of])
                mean, own = values.mean(), one.std(name)
                if column == 2:
                    mean, own = gumbel_mode(values), one.extreme(name, HOUR, MODE)
                cells.append(f"{own / mean:.2f} +- {own / mean**2 * bound(values):.2f}")
        print(f"| spar {spar}, {case} | {len(runs_of)} | " + " | ".join(cells) + " |")


def gumbel_mode(values: np.ndarray) -> float:
    """Most probable largest value by the mean and deviation of some largest ones, Gumbel's law."""
    return float(values.mean() - 0.5772 * np.sqrt(6) / np.pi * values.std(ddof=1))


def beside_runs(folder: Path, seeds: int, spars: list[int], chosen: list[str], further: dict[str, float]) -> None:
    """Means and deviations of responses and runs, and the table of ratios."""
    print("| result | mean, response | runs | deviation, response | runs | ratio |")
    print("| --- | --- | --- | --- | --- | --- |")
    cases, rows = {name: (LIKELY | OF_50_YEARS)[name] for name in chosen}, []
    for spar in spars:
        for case, state in cases.items():
            plant = plant_of(spar, state[0])[1]
            names = [n for n in RESULTS if n in plant.outputs]
            one = fw.response(plant, outputs=names, parameters=weather(*state) | further)
            runs, ratios = hours(folder, spar, state, seeds, further=further), {}
            for name in names:
                means, stds, _ = np.array([run[name] for run in runs]).T
                ratio = one.std(name) / stds.mean()
                ratios[name] = f"{ratio:.2f} +- {ratio * bound(stds) / stds.mean():.2f}"
                print(f"| spar {spar}, {case}, {name} [{one.unit(name)}] | {one.mean_of(name):.4g} | {means.mean():.4g}"
                      f" | {one.std(name):.4g} | {stds.mean():.4g} | {ratios[name]} |", flush=True)  # fmt: skip
            rows.append((f"spar {spar}, {case}", len(runs), *(ratios.get(name, "") for name in RESULTS)))
    print("\n" + markdown((("response over runs", "seeds", *RESULTS), rows)))


def fatigue(folder: Path, seeds: int, spars: list[int]) -> None:
    """Damage of an hour at the tower's base in five states, of the likely seas and of EC1."""
    head("state")
    for spar in spars:
        for state in (LIKELY["9"], OF_50_YEARS["EC1"], LIKELY["13"], LIKELY["15"], LIKELY["21"]):
            one = fw.response(plant_of(spar, state[0])[1], outputs=["tower_base_moment"], parameters=weather(*state))
            damages(one, spar, state, hours(folder, spar, state, seeds))


def head(first: str) -> None:
    """Head of a table of damages."""
    print(f"\n| {first} | seeds | curve | Dirlik, an hour | inverse FFT | rainflow of runs | ratio |")
    print("| --- " * 7 + "|")


def damages(one: Any, spar: int, state: tuple[float, float, float], runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Print the damage of an hour by each curve; Dirlik over runs, bound of that, inverse FFT over Dirlik."""
    found = {}
    for name, curve in CURVES[spar].items():
        dirlik, counted = (one.damage("tower_base_moment", curve, BASE[spar], method=method)
                           for method in ("dirlik", "rainflow"))  # fmt: skip
        values = np.array([run["damage"][name] for run in runs])
        ratio, scatter = dirlik / values.mean(), bound(values) / values.mean()
        found[name] = ratio, scatter, counted / dirlik
        words = f"spar {spar}, {state[0]:g} m/s, {state[1]:g} m, {state[2]:g} s | {len(runs)} | {name} | {dirlik:.3e}"
        print(f"| {words} | {counted:.3e} | {values.mean():.3e} | {ratio:.2f} +- {ratio * scatter:.2f} |", flush=True)
    return found


def life(folder: Path, seeds: int, spars: list[int]) -> None:
    """Damage of 20 years at the tower's base, and in the state of each wind that does most of it."""
    joint = site("northern_north_sea").at(119)
    every = centre_bins(joint, np.arange(5, 26, 2), np.arange(0.5, 16), np.arange(0.5, 25), jacobian=False)
    for spar in spars:
        begin = time.process_time()
        found = fw.responses(plant_of(spar, 15.0)[1], every, outputs=["tower_base_moment"])
        spent = time.process_time() - begin
        print(f"\nspar {spar}: {len(found)} states, {1e3 * spent / len(found):.0f} ms each (processor time)\n")
        for name, curve in CURVES[spar].items():
            values = [found.damage("tower_base_moment", curve, BASE[spar], missing=1.0, method=method)
                      for method in ("dirlik", "tovo_benasciutti", "narrow_band")]  # fmt: skip
            print(f"{name}: damage in 20 years {values[0]:.4g} (Dirlik), {values[1]:.4g} (Tovo and Benasciutti), "
                  f"{values[2]:.4g} (narrow band)")  # fmt: skip
        where(found, spar)
        head("state that does most of each wind")
        speeds = np.array([row["wind.mean_speed"] for row in found.states])
        shares = shares_of(found, spar)
        sums = {name: np.zeros(4) for name in shares}  # linear, by runs, its variance, counted in series
        for speed in np.unique(speeds):
            number = int(np.nanargmax(np.where(speeds == speed, shares["D, one slope of 3"], -1.0)))
            row, one = found.states[number], found.found[number]
            state = (float(speed), float(row["sea.significant_wave_height"]), float(row["sea.peak_period"]))
            for name, (ratio, scatter, counted) in damages(one, spar, state, hours(folder, spar, state, seeds)).items():
                share = np.nansum(shares[name][speeds == speed])
                sums[name] += share * np.array([1.0, 1 / ratio, share * (scatter / ratio) ** 2, counted])
        for name, (linear, run, variance, counted) in sums.items():
            print(f"\n{name}: all states over runs, each wind by the ratio of its state: {linear / run:.3f} +- "
                  f"{linear / run**2 * np.sqrt(variance):.3f} (Dirlik), {counted / run:.3f} (inverse FFT)")  # fmt: skip


def shares_of(found: Any, spar: int) -> dict[str, np.ndarray]:
    """Damage of an hour in each state times its probability, by each curve."""
    return {name: found.of_each(lambda one, c=curve: one.damage("tower_base_moment", c, BASE[spar])) * found.probability
            for name, curve in CURVES[spar].items()}  # fmt: skip


def where(found: Any, spar: int) -> None:
    """Which winds do the damage, and in which of them deviations reach over corners of control laws."""
    speeds = np.array([row["wind.mean_speed"] for row in found.states])
    shares = shares_of(found, spar)
    over = np.array([max((corner.probability for corner in one.corners), default=0.0) if one is not None else np.nan
                     for one in found])  # fmt: skip
    print("\n| wind [m/s] | states | probability | " + " | ".join(f"damage, {name}" for name in shares) +
          " | over corners, states | time at most |\n" + "| --- " * (5 + len(shares)) + "|")  # fmt: skip
    for speed in np.unique(speeds):
        at = speeds == speed
        parts = " | ".join(f"{100 * np.nansum(share[at]) / np.nansum(share):.1f} %" for share in shares.values())
        print(f"| {speed:g} | {at.sum()} | {100 * found.probability[at].sum():.1f} % | {parts} | "
              f"{np.sum(over[at] > 0)} | {100 * np.nanmax(over[at]):.0f} % |", flush=True)  # fmt: skip


def shift(folder: Path, seeds: int) -> None:
    """Damage of spar 2 and of the same with its bending as much faster as 1.79 s is than 1.85 s, in likely seas."""
    plant, curve = plant_of(2, 15.0)[1], CURVES[2]["D, one slope of 3"]
    asked = {"outputs": ["tower_base_moment", "rotor_speed"]}
    print(f"| state | bending [s] | 3P [s] | deviation beyond {FAST} Hz [MN m] | faster | damage, an hour | ratio |")
    print("| --- " * 7 + "|")
    sums = np.zeros(2)
    likely = likely_states(site("northern_north_sea").at(119), np.arange(5.0, 26.0, 2.0))
    for state, probability in zip(likely, likely.weights, strict=True):
        speed, height, period = (float(x) for x in state[:3])
        given = weather(speed, height, period)
        own = fw.response(plant, parameters=given, **asked)
        bending = min((mode.period for mode in own.linear.modes() if mode.label.endswith("_x")),
                      key=lambda found: abs(found - 1.85))  # fore and aft; sideways it is another  # fmt: skip
        change = {f"{bending:.4f} s": f"{bending * 1.79 / 1.85:.4f} s"}
        both = own, fw.response(plant, parameters=given, shifted=change, **asked)
        damage = np.array([one.damage("tower_base_moment", curve, BASE[2]) for one in both])
        fast = [np.sqrt(one["tower_base_moment"].moment(0, FAST)) for one in both]
        sums += probability * damage
        passing = 20 / own.mean_of("rotor_speed")
        print(f"| {speed:g} m/s, {height:.1f} m, {period:.1f} s | {bending:.3f} | {passing:.2f} | {fast[0]:.2f} | "
              f"{fast[1]:.2f} | {damage[0]:.3e} | {damage[1] / damage[0]:.3f} |", flush=True)  # fmt: skip
    print(f"\nall, by the density of the wind: {sums[1] / sums[0]:.3f}\n")
    for spar in (1, 2):
        one = fw.response(plant_of(spar, 21.0)[1], parameters=weather(*LIKELY["21"]), **asked)
        found = [run["fast"] for run in hours(folder, spar, LIKELY["21"], seeds) if "fast" in run]
        if found:
            ours = np.sqrt(one["tower_base_moment"].moment(0, FAST))
            mean = np.mean(found)
            print(f"spar {spar}, 21 m/s: deviation beyond {FAST} Hz {ours:.2f} MN m, in {len(found)} runs {mean:.2f}, "
                  f"ratio {ours / mean:.2f} +- {ours / mean**2 * bound(np.array(found)):.2f}")  # fmt: skip


def shapes(folder: Path, seeds: int) -> None:
    """How far the axis of hull and tower moves along the waves in each mode, over the height, 1 at the farthest."""
    plant = fw.load("dtu10mw_spar_3").compile()
    state = plant.equilibrium(parameters={"sea.spectrum": "still"})
    frames = [f"{beam}.hinge_{k}.frame_b" for beam in ("hull", "tower.beam")
              for k in range(1, int(plant.root.find(beam).hinges) + 1)]  # fmt: skip
    frames = ["hull.frame_a", *frames, "tower.frame_b"]
    heights = np.array([float(np.squeeze(state[f"{frame}.r[2]"])) for frame in frames])
    linear = plant.linearize(state, outputs=[f"{frame}.r[{axis}]" for axis in (0, 1) for frame in frames])
    roots, vectors = np.linalg.eig(linear.matrices["A"])
    moved, across = np.split(linear.matrices["C"] @ vectors, 2)
    order, along = np.argsort(heights), np.abs(moved).max(axis=0) > np.abs(across).max(axis=0)
    periods = 2 * np.pi / np.maximum(np.abs(roots), 1e-9)
    with drawing_style():
        figure = drawing(9.0, 4.6)
        axes = figure.subplots(1, len(SHAPES), sharey=True)
        for axis, (name, period) in zip(axes, SHAPES.items(), strict=True):
            k = min(np.flatnonzero((roots.imag > 0) & along), key=lambda k: abs(np.log(periods[k] / period)))
            shape = moved[:, k] / moved[np.abs(moved[:, k]).argmax(), k]
            print(f"{name}: {periods[k]:.4g} s; out of phase {np.abs(shape.imag).max():.3f}")
            axis.axvline(0.0, color=INK, lw=0.6)
            axis.axhline(0.0, color=COLORS[0], lw=0.8, ls="--")
            axis.plot(shape.real[order], heights[order], color=COLORS[1], marker="o", ms=2.5)
            axis.set(title=f"{name}, {periods[k]:.3g} s", xlabel="displacement [1]", xlim=(-1.15, 1.15))
        axes[0].set_ylabel("height above the still water level [m]")
    print(save_figure(figure, folder / "spar_mode_shapes.png"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", choices=["extremes", "runs", "fatigue", "life", "shift", "shapes"])
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--spars", default="1,2,3", help="of runs, fatigue and life")
    parser.add_argument("--cases", default="9,15,21,EC1,EC4", help=f"of runs: {', '.join(LIKELY | OF_50_YEARS)}")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE", help="of runs")
    parser.add_argument("--folder", type=Path, default=Path("output/hegseth_spars"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    study, spars = (given.folder, given.seeds), [int(text) for text in given.spars.split(",")]
    if given.study == "runs":
        further = {path: float(value) for path, _, value in (item.partition("=") for item in given.set)}
        beside_runs(*study, spars, given.cases.split(","), further)
    elif given.study in ("fatigue", "life"):
        {"fatigue": fatigue, "life": life}[given.study](*study, spars)
    else:
        {"extremes": extremes, "shift": shift, "shapes": shapes}[given.study](*study)


if __name__ == "__main__":
    main()
