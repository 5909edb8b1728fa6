"""The pictures of docs/statistics.md: 20 seeds of 1000 s of the OC3 spar, and two models of it against each other.

`python benchmarks/statistics_pictures.py` writes them and prints the numbers that the page tells.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fowtlib as fw
from fowtlib.analysis.extremes import gaussian_maximum
from fowtlib.analysis.maximum import Maximum
from fowtlib.analysis.peaks import fit_peaks, peaks
from fowtlib.analysis.tails import fit_crossings

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
STORM = {"wind.kind": "kaimal", "wind.mean_speed": 14.0, "sea.spectrum": "jonswap", "sea.significant_wave_height": 6.0,
         "sea.peak_period": 10.0}  # fmt: skip
CALM = {"wind.kind": "steady", "sea.spectrum": "still"}
HOURS_3 = 10800.0
DISCARD = 400.0


def main() -> None:
    """Run the seeds, fit, draw."""
    plant = fw.load("oc3_spar_rigid", set=STORM).compile()
    start = values(plant.equilibrium(CALM))
    runs = [plant.simulate(1400.0, 0.25, start=start, parameters={"sea.seed": seed, "wind.seed": seed})
            for seed in range(1, 21)]  # fmt: skip
    pitch = [run["pitch"] for run in runs]
    maxima = fw.block_maxima(pitch, 1000.0, discard=DISCARD)
    gumbel = fw.fit_gumbel(maxima, 1000.0, name="platform pitch", unit="deg")
    crossings, gaussian = fit_crossings(pitch, discard=DISCARD), gaussian_maximum(pitch, discard=DISCARD)
    tell("Gumbel, moments", gumbel)
    tell("Gumbel, likelihood", fw.fit_gumbel(maxima, 1000.0, method="likelihood"))
    tell("generalized Pareto", fit_peaks(peaks(pitch, discard=DISCARD)))
    tell("exponential", fit_peaks(peaks(pitch, discard=DISCARD), shape=0.0))
    tell("crossings", crossings)
    tell("Gaussian", gaussian)
    gumbel.plot(FIGURES / "gumbel_pitch.png", duration=HOURS_3)
    crossings.plot(FIGURES / "crossings_pitch.png", duration=HOURS_3, gaussian=gaussian)
    flexible = fw.load("oc3_spar", set=STORM).compile()
    seeds = {"sea.seed": 1, "wind.seed": 1}
    other = flexible.simulate(600.0, 0.25, start=values(fw.mean_state(flexible, CALM, near=True)), parameters=seeds,
                              solver="fixed")  # fmt: skip
    first = plant.simulate(600.0, 0.25, start=start, parameters=seeds)
    comparison = fw.compare_results(first, other, discard=200.0, relative_to="range")
    print(comparison.summary())
    comparison.plot(FIGURES / "lights.png", title="OC3 spar: rigid tower and blades against flexible ones")


def values(state: fw.State) -> dict[str, Any]:
    """Values of the states, to start a run in other wind from."""
    return dict(zip([each.path for each in state.plant.dae.states], state.x, strict=True))


def tell(name: str, fit: Maximum) -> None:
    """The most probable maximum of three hours with its bounds."""
    bounds = fit.bounds(HOURS_3)
    print(f"| {name} | {bounds.value:.2f} | {bounds.low:.2f} to {bounds.high:.2f} |")


if __name__ == "__main__":
    main()
