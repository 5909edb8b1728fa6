"""Tables and pictures of docs/three_floaters.md, from what `fowt batch run` makes of models/cases/three_floaters.yaml.

`python benchmarks/three_floaters.py FOLDER ...` reads the results in these folders; the first that has a case counts.
`--end` is the last second that is judged; what lies before 400 s is not.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from pages import fill, markdown
from scipy.signal import welch

matplotlib.use("Agg")
import matplotlib.pyplot as plt

DOCS = Path(__file__).parent.parent / "docs"
NAMES = {"two_rotor_spar": "spar", "oo_star": "OO-Star", "tlp_two_rotor": "TLP", "two_rotor_land": "land"}
WINDS = {1: 8, 2: 11.4, 3: 14, 4: 18, 5: 25, 6: 50}
DISCARD = 400.0
COLUMNS = {
    "surge [m]": "surge", "pitch [deg]": "pitch", "yaw [deg]": "yaw", "power of both [kW]": "power",
    "nacelle [m/s^2]": "nacelle_acceleration_left", "tower base [MN m]": "tower", "upwind tension [MN]": "tension",
}  # fmt: skip


def series(path: Path, end: float) -> dict[str, np.ndarray]:
    """Results of a case behind what is discarded; with the power of both rotors, MN m and MN."""
    with xr.open_dataset(path) as data:
        inside = (data["time"] >= DISCARD) & (data["time"] <= end)
        found = {name: np.asarray(data[name])[np.asarray(inside)] for name in [*data.data_vars, "time"]
                 if data[name].dims == ("time",)}  # fmt: skip
    found["power"] = found["generator_power_left"] + found["generator_power_right"]
    found["tower"] = found["tower_base_fore_aft_moment"] / 1e6
    lines = [found[f"fairlead_tension_{k}"] for k in (1, 2, 3) if f"fairlead_tension_{k}" in found]
    if lines:
        found["tension"] = max(lines, key=lambda line: line.mean()) / 1e3
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--end", type=float, default=4000.0)
    given = parser.parse_args()
    runs: dict[tuple[int, str], dict[str, np.ndarray]] = {}
    for case in WINDS:
        for name, label in NAMES.items():
            paths = [folder / f"LC{case}_{name}.nc" for folder in given.folders]
            if path := next((path for path in paths if path.exists()), None):
                runs[case, label] = series(path, given.end)
                print(case, label, f"{runs[case, label]['time'][-1]:.0f} s", flush=True)
    page = DOCS / "three_floaters.md"
    text = fill(page.read_text(), "three_floaters_statistics", statistics(runs))
    page.write_text(fill(text, "three_floaters_tower", tower(runs)))
    bars(runs)
    spectra(runs)


def statistics(runs) -> str:
    """Mean, standard deviation and the greatest size of each column."""
    rows = []
    for (case, label), run in runs.items():
        if label == "land":
            continue
        values = (run[key] for key in COLUMNS.values())
        cells = [f"{v.mean():.3g}; {v.std():.3g}; {np.abs(v).max():.3g}" for v in values]
        rows.append((f"LC{case}", f"{WINDS[case]:g}", label, *cells, f"{run['time'][-1] - DISCARD:.0f}"))
    return markdown((("case", "wind [m/s]", "floater", *COLUMNS, "time [s]"), rows), 3)


def tower(runs) -> str:
    """Tower base beside that on land: mean, deviation and maximum, and each over that on land."""
    rows = []
    for case, wind in WINDS.items():
        land = _sizes(runs[case, "land"]) if (case, "land") in runs else None
        for label in NAMES.values():
            if (case, label) in runs:
                sizes = _sizes(runs[case, label])
                over = ["" if land is None else f"{a / b:.2f}" for a, b in zip(sizes, land or sizes, strict=True)]
                rows.append((f"LC{case}", f"{wind:g}", label, *(f"{size:.3g}" for size in sizes), *over))
    heads = ("case", "wind [m/s]", "structure", "mean [MN m]", "deviation [MN m]", "greatest [MN m]", "mean over land",
             "deviation over land", "greatest over land")  # fmt: skip
    return markdown((heads, rows), 3)


def _sizes(run) -> list[float]:
    return [run["tower"].mean(), run["tower"].std(), np.abs(run["tower"]).max()]


def bars(runs) -> None:
    keys = {"surge [m]": "surge", "pitch [deg]": "pitch", "yaw [deg]": "yaw", "tower base, fore-aft [MN m]": "tower"}
    figure, axes = plt.subplots(2, 2, figsize=(10, 6.5), layout="constrained")
    for ax, (label, key) in zip(axes.flat, keys.items(), strict=True):
        for k, name in enumerate(NAMES.values()):
            cases = [case for case in WINDS if (case, name) in runs and key in runs[case, name]]
            mean = [runs[case, name][key].mean() for case in cases]
            low = [m - runs[case, name][key].min() for case, m in zip(cases, mean, strict=True)]
            high = [runs[case, name][key].max() - m for case, m in zip(cases, mean, strict=True)]
            std = [runs[case, name][key].std() for case in cases]
            x = np.array(cases) + 0.18 * (k - 1.5)
            ax.errorbar(x, mean, (low, high), fmt="none", lw=1, color=f"C{k}", capsize=2)
            ax.errorbar(x, mean, std, fmt="o", lw=4, ms=4, color=f"C{k}", label=name if cases else None)
        ax.set(xlabel="load case", ylabel=label, xticks=list(WINDS))
        ax.grid(alpha=0.3)
    axes[1, 1].legend(fontsize=8)
    figure.suptitle("Means, standard deviations (thick) and extremes (thin)", fontsize=10)
    figure.savefig(DOCS / "figures" / "three_floaters.png", dpi=110)


def spectra(runs) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained", sharey=True)
    for ax, case in zip(axes, (2, 6), strict=True):
        for k, name in enumerate(NAMES.values()):
            if (run := runs.get((case, name))) is not None:
                f, S = welch(run["tower"], 1 / np.median(np.diff(run["time"])), nperseg=2000)
                ax.loglog(f[1:], S[1:], color=f"C{k}", lw=1, label=name)
        ax.set(xlabel="frequency [Hz]", title=f"LC{case}, {WINDS[case]:g} m/s", xlim=(5e-3, 3), ylim=(1e-3, 1e6))
        ax.grid(alpha=0.3, which="both")
    axes[0].set(ylabel="tower base, fore-aft [(MN m)$^2$/Hz]")
    axes[0].legend(fontsize=8)
    figure.savefig(DOCS / "figures" / "three_floaters_spectra.png", dpi=110)


if __name__ == "__main__":
    main()
