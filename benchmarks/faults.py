"""The fault cases of docs/faults.md: maxima over those of operation, and studies over pitch rate and delay.

`python benchmarks/faults.py FOLDER` runs the cases of two_rotor_faults.yaml, keeps their maxima in FOLDER, fills the
tables of the page and draws its picture; what FOLDER has already is not run again. `--model NAME` takes another model
with two turbines. The cases of one wind share the time before the fault.
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
CASES = Path(__file__).parent.parent / "models" / "cases" / "two_rotor_faults.yaml"
FAULT, DETECTED, BEFORE = 600.0, 600.1, 599.5
STUDY_END = 700.0
CHANNELS = {
    "surge": "surge", "pitch": "pitch", "yaw": "yaw",
    "flapwise moment, faulty blade": "blade_root_flapwise_moment_1_left",
    "edgewise moment, faulty blade": "blade_root_edgewise_moment_1_left",
    "shaft bending": "shaft_bending_moment_left", "tower base torsion": "tower_base_torsion",
    "arm root torsion": "arm_root_torsion_left", "tower base bending": "tower_base_fore_aft_moment",
}  # fmt: skip
FAULTS = {"2B": "turbine_left.bearing_1.stuck at 600 s",
          "3B": "turbine_left.bearing_1.runaway at 600 s, to=0 deg, rate=8 deg/s"}  # fmt: skip
RATES = (6.0, 8.0, 10.0, 12.0)
DELAYS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)


class Runs:
    """Maxima of the cases of one wind after the fault, kept as JSON."""

    def __init__(self, folder: Path, plant: fw.Plant, operation: Case):
        self.file, self.plant, self.operation = folder / f"{operation.name}.json", plant, operation
        self.known: dict[str, Any] = json.loads(self.file.read_text()) if self.file.exists() else {}
        self.start: fw.Result | None = None

    def maxima(self, name: str, events: Any, end: float) -> dict[str, float]:
        """The largest size of each channel behind the fault, and with a sign for the moment at the tower base."""
        if name not in self.known:
            if self.start is None:
                case = replace(self.operation, duration=BEFORE, discard=0.0)
                self.start = self.plant.simulate(conditions=case.conditions())
            case = replace(self.operation, duration=end, discard=0.0)
            conditions = replace(case.conditions(), events=tuple(events), start="")
            result = self.plant.simulate(conditions=conditions, start=self.start)
            late = np.asarray(result.time) >= FAULT
            values = {label: np.asarray(result[path])[late] for label, path in CHANNELS.items()}
            self.known[name] = {label: float(np.abs(v).max()) for label, v in values.items()}
            self.known[name]["least tower base bending"] = float(values["tower base bending"].min())
            pitches = [np.degrees(np.asarray(result[f"turbine_left.assembly.hub.pitch[{k}]"])[late]) for k in range(3)]
            self.known[name]["pitch of blades 1 to 3 at the end"] = [float(v[-1]) for v in pitches]
            self.file.write_text(json.dumps(self.known, indent=1))
            print(self.file.stem, name, self.known[name], flush=True)
        return self.known[name]


def study_events(fault: str, rate: float, delay: float) -> list[str]:
    stop = "normal_shutdown at {time:g} s, rate={rate:g} deg/s"
    return [FAULTS[fault], "turbine_left." + stop.format(time=DETECTED, rate=rate),
            "turbine_right." + stop.format(time=DETECTED + delay, rate=rate)]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--model", default="")
    parser.add_argument("--wind", type=float, nargs="*", default=[14.0, 22.0, 11.5, 8.0])
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    cases = fw.read_cases(CASES)
    cases = [replace(case, model=given.model or case.model) for case in cases]
    plant = fw.load(cases[0].model).compile()
    paths = [*plant.outputs, *(f"turbine_left.assembly.hub.pitch[{k}]" for k in range(3))]
    found: dict[float, dict[str, Any]] = {}
    for wind in given.wind:
        here = {case.name[:2]: replace(case, outputs=tuple(paths)) for case in cases
                if float(case.labels["wind_speed"]) == wind}  # fmt: skip
        runs = Runs(given.folder, plant, here["1A"])
        for name, case in here.items():
            runs.maxima(name, case.conditions().events or (), 800.0)
        if wind == 14.0:
            for fault in FAULTS:
                for rate in RATES:
                    runs.maxima(f"{fault} rate {rate:g}", study_events(fault, rate, 0.0), STUDY_END)
                for delay in DELAYS:
                    runs.maxima(f"{fault} delay {delay:g}", study_events(fault, 8.0, delay), STUDY_END)
        found[wind] = runs.known
        write(found)


def write(found: dict[float, dict[str, Any]]) -> None:
    """Fill the page and draw the picture."""
    page = DOCS / "faults.md"
    text = page.read_text()
    names = ("2A", "3A", "2B", "3B")
    known, usual = found[14.0], found[14.0]["1A"]
    rows = [(label, *(known[name][label] / usual[label] for name in names)) for label in CHANNELS]
    least = (known[name]["least tower base bending"] / usual["tower base bending"] for name in names)
    rows.append(("tower base bending, least", *least))
    text = fill(text, "fault_maxima", markdown((("largest", *names), rows), 3))
    winds = sorted(wind for wind, runs in found.items() if all(name in runs for name in names))
    heads = ("case", *(f"{wind:g} m/s" for wind in winds))
    rows = [(f"{label}, {name}", *(found[wind][name][label] / found[wind]["1A"][label] for wind in winds))
            for label in ("flapwise moment, faulty blade", "shaft bending", "tower base torsion") for name in names]
    text = fill(text, "fault_winds", markdown((heads, rows), 3))
    page.write_text(text)
    draw(found[14.0])


def draw(known: dict[str, Any]) -> None:
    import matplotlib.pyplot as plt

    labels = ["shaft bending", "tower base torsion", "tower base bending", "arm root torsion",
              "flapwise moment, faulty blade"]  # fmt: skip
    figure, axes = plt.subplots(2, 2, figsize=(9, 6), sharey="row", layout="constrained")
    for column, (fault, title) in enumerate((("2B", "blockage and shutdown"), ("3B", "runaway and shutdown"))):
        for row, (key, values, label) in enumerate((("rate", RATES, "pitch rate [deg/s]"),
                                                    ("delay", DELAYS, "delay of the right rotor [s]"))):  # fmt: skip
            ax = axes[row][column]
            for name in labels:
                ax.plot(values, [known[f"{fault} {key} {v:g}"][name] / known["1A"][name] for v in values], "o-",
                        label=name)  # fmt: skip
            ax.set(xlabel=label, title=title if not row else "", ylabel="maximum over that of operation")
            ax.grid(alpha=0.3)
    axes[0][0].legend(fontsize=8)
    figure.savefig(DOCS / "figures" / "fault_studies.png", dpi=110)


if __name__ == "__main__":
    main()
