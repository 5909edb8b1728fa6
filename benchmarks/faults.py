"""The fault cases of docs/faults.md: maxima over those of operation, and studies over pitch rate and delay.

`python benchmarks/faults.py FOLDER` runs the cases of oo_star_faults.yaml, keeps their maxima in FOLDER, fills the
tables of the page and draws its picture; what FOLDER has already is not run again. `--cases two_rotor_faults` takes
those of the spar. The cases of one wind share the time before the fault. On the OO-Star that begins with its
mean position of rigid bodies: the mean of the flexible model takes minutes to find, and 600 s follow.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from pages import fill, markdown

import fowtlib as fw
from fowtlib.cases import Case

matplotlib.use("Agg")
DOCS = Path(__file__).parent.parent / "docs"
CASES = Path(__file__).parent.parent / "models" / "cases"
FAULT, DETECTED, BEFORE = 600.0, 600.1, 599.5
STUDY_END = 640.0  # all of it is over by then: feather takes 13 s at 6 deg/s
CHANNELS = {
    "surge": "surge", "pitch": "pitch", "yaw": "yaw",
    "flapwise moment, faulty blade": "blade_root_flapwise_moment_1_left",
    "edgewise moment, faulty blade": "blade_root_edgewise_moment_1_left",
    "shaft bending": "shaft_bending_moment_left", "tower base torsion": "tower_base_torsion",
    "arm root torsion": "arm_root_torsion_left", "tower base bending": "tower_base_fore_aft_moment",
}  # fmt: skip
RIGID = {"oo_star_feedback": "oo_star_rigid"}
FAULTS = {"2B": "turbine_left.bearing_1.stuck at 600 s",
          "3B": "turbine_left.bearing_1.runaway at 600 s, to=0 deg, rate=8 deg/s"}  # fmt: skip
NACELLE = "turbine_left.assembly.nacelle."
AT_YAW_AXIS = "shaft bending, yaw axis"
OVERHANG = 5.0191  # [m], of the NREL 5 MW
PITCHES = [f"turbine_left.assembly.hub.pitch[{k}]" for k in range(3)]
RATES = (6.0, 8.0, 10.0, 12.0)
DELAYS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)


class Runs:
    """Maxima of the cases of one wind after the fault, kept as JSON."""

    def __init__(self, folder: Path, plant: fw.Plant, operation: Case, position: dict[str, float]):
        self.file, self.plant, self.operation = folder / f"{operation.name}.json", plant, operation
        self.position = position
        self.known: dict[str, Any] = json.loads(self.file.read_text()) if self.file.exists() else {}
        self.start: fw.Result | None = None

    def peaks(self, result: fw.Result, since: float) -> dict[str, float]:
        """The largest size of each channel, and with a sign for the moment at the tower base."""
        late = np.asarray(result.time) >= since
        values = {label: np.asarray(result[path])[late] for label, path in CHANNELS.items()}
        values[AT_YAW_AXIS] = bending(result, OVERHANG)[late]
        found = {label: float(np.abs(v).max()) for label, v in values.items()}
        return {**found, "least tower base bending": float(values["tower base bending"].min())}

    def maxima(self, name: str, events: Any, end: float) -> dict[str, float]:
        """Those from the fault on, of a case or a study; also kept: those of as long a time before it."""
        if name not in self.known:
            if self.start is None:
                case = replace(self.operation, duration=BEFORE, discard=0.0)
                conditions = case.conditions()
                conditions = replace(conditions, start=self.position or conditions.start)
                self.start = self.plant.simulate(conditions=conditions)
                self.known["before"] = self.peaks(self.start, BEFORE - (800.0 - FAULT))
            case = replace(self.operation, duration=end, discard=0.0)
            conditions = replace(case.conditions(), events=tuple(events), start="")
            result = self.plant.simulate(conditions=conditions, start=self.start)
            ends = [float(np.degrees(np.asarray(result[path])[-1])) for path in PITCHES]
            self.known[name] = {**self.peaks(result, FAULT), "pitch of blades 1 to 3 at the end": ends}
            self.file.write_text(json.dumps(self.known, indent=1))
            print(self.file.stem, name, self.known[name], flush=True)
        return self.known[name]


def mean_position(rigid: str | None, wind: float) -> dict[str, float]:
    """Surge, heave and pitch at rest of a rigid model in steady wind."""
    if rigid is None:
        return {}
    plant = fw.load(rigid).compile()
    at = fw.mean_state(plant, {"wind.kind": "steady", "wind.mean_speed": wind, "sea.spectrum": "still"})
    return {path: float(at[path]) for path in (f"platform.motion.{name}" for name in ("surge", "heave", "pitch"))}


def bending(result: fw.Result, behind: float) -> np.ndarray:
    """Bending moment of the shaft (times,) so far behind the hub: the weight of the rotor acts in front of it."""
    moment, force = (np.asarray(result[f"{NACELLE}cut.{name}"]) for name in ("torque", "force"))
    moment = moment + np.cross([-behind, 0.0, 0.0], force)
    return np.hypot(moment[:, 1], moment[:, 2])


def study_events(fault: str, rate: float, delay: float) -> list[str]:
    stop = "normal_shutdown at {time:g} s, rate={rate:g} deg/s"
    return [FAULTS[fault], "turbine_left." + stop.format(time=DETECTED, rate=rate),
            "turbine_right." + stop.format(time=DETECTED + delay, rate=rate)]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--cases", default="oo_star_faults")
    parser.add_argument("--wind", type=float, nargs="*", default=[14.0, 22.0, 11.5, 8.0])
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    cases = fw.read_cases(CASES / f"{given.cases}.yaml")
    plant = fw.load(cases[0].model).compile()
    paths = [*CHANNELS.values(), f"{NACELLE}cut.torque", f"{NACELLE}cut.force", *PITCHES]
    found: dict[float, dict[str, Any]] = {}
    for wind in given.wind:
        here = {case.name[:2]: replace(case, outputs=tuple(paths)) for case in cases
                if float(case.labels["wind_speed"]) == wind}  # fmt: skip
        runs = Runs(given.folder, plant, here["1A"], mean_position(RIGID.get(cases[0].model), wind))
        for name, case in here.items():
            runs.maxima(name, case.conditions().events or (), 800.0)
        found[wind] = runs.known
        write(found, given.cases)
        if wind == 14.0:
            studies = runs
    for fault in FAULTS:
        for rate in RATES:
            studies.maxima(f"{fault} rate {rate:g}", study_events(fault, rate, 0.0), STUDY_END)
        for delay in DELAYS:
            studies.maxima(f"{fault} delay {delay:g}", study_events(fault, 8.0, delay), STUDY_END)
    draw(studies.known, given.cases)


def write(found: dict[float, dict[str, Any]], cases: str) -> None:
    """Fill the tables of these cases on the page."""
    page = DOCS / "faults.md"
    text = page.read_text()
    names = ("2A", "3A", "2B", "3B")
    known, usual = found[14.0], found[14.0]["1A"]
    rows = [(label, *(known[name][label] / usual[label] for name in names)) for label in (*CHANNELS, AT_YAW_AXIS)]
    least = (known[name]["least tower base bending"] / usual["tower base bending"] for name in names)
    rows.append(("tower base bending, least", *least))
    text = fill(text, f"{cases}_maxima", markdown((("largest", *names), rows), 3))
    winds = sorted(wind for wind, runs in found.items() if all(name in runs for name in names))
    heads = ("case", *(f"{wind:g} m/s" for wind in winds))
    rows = [(f"{label}, {name}", *(found[wind][name][label] / found[wind]["1A"][label] for wind in winds))
            for label in ("flapwise moment, faulty blade", AT_YAW_AXIS, "tower base torsion")
            for name in names]  # fmt: skip
    text = fill(text, f"{cases}_winds", markdown((heads, rows), 3))
    page.write_text(text)


def draw(known: dict[str, Any], cases: str) -> None:
    import matplotlib.pyplot as plt

    labels = [AT_YAW_AXIS, "tower base torsion", "arm root torsion", "flapwise moment, faulty blade",
              "least tower base bending"]  # fmt: skip
    usual = {**known["1A"], labels[-1]: -known["1A"]["tower base bending"]}
    figure, axes = plt.subplots(2, 2, figsize=(9, 6), sharey="row", layout="constrained")
    for column, (fault, title) in enumerate((("2B", "blockage and shutdown"), ("3B", "runaway and shutdown"))):
        for row, (key, values, label) in enumerate((("rate", RATES, "pitch rate [deg/s]"),
                                                    ("delay", DELAYS, "delay of the right rotor [s]"))):  # fmt: skip
            ax = axes[row][column]
            for name in labels:
                ax.plot(values, [known[f"{fault} {key} {v:g}"][name] / usual[name] for v in values], "o-",
                        label=name)  # fmt: skip
            ax.set(xlabel=label, title=title if not row else "", ylabel="over the maximum of operation")
            ax.grid(alpha=0.3)
    axes[0][0].legend(fontsize=8)
    figure.savefig(DOCS / "figures" / f"{cases}.png", dpi=110)


if __name__ == "__main__":
    main()
