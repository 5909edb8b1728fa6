"""What unsteady airfoils change on oc3_spar, and what they cost: the tables of docs/unsteady_airfoils.md.

python benchmarks/unsteady_airfoils.py
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from pages import fill, markdown

import fowtlib as fw
from fowtlib.components.aero import AIRFOIL_MODELS

PAGE = Path(__file__).parents[1] / "docs" / "unsteady_airfoils.md"
CASES = {
    "steady 8 m/s": {"wind.kind": "steady", "wind.mean_speed": 8.0, "sea.spectrum": "still"},
    "steady 11.4 m/s": {"wind.kind": "steady", "wind.mean_speed": 11.4, "sea.spectrum": "still"},
    "turbulence, 18 m/s": {"wind.kind": "turbulence", "wind.mean_speed": 18.0},
}
DURATION, DISCARDED = 400.0, 200.0  # [s]
MOMENT = "blade_root_flapwise_moment_1"
SHOWN = (
    ("aero_power", "mean", "mean power"), ("thrust", "mean", "mean thrust"), (MOMENT, "mean", "mean flapwise moment"),
    (MOMENT, "std", "its deviation"), ("tower_base_fore_aft_moment", "std", "deviation of tower base"),
)  # fmt: skip


def of_case(settings: dict) -> tuple[dict[str, dict[tuple[str, str], float]], dict[str, float]]:
    """Statistics of each airfoil model, and its processor time [s]."""
    found, spent = {}, {}
    for word in AIRFOIL_MODELS:
        plant = fw.load("oc3_spar", set={**settings, "turbine.aerodynamics.airfoil_model": word}).compile()
        plant.simulate(0.1, 0.1)  # compiles
        before = time.process_time()
        result = plant.simulate(DURATION, 0.1)
        spent[word] = time.process_time() - before
        after = np.asarray(result.time) >= DISCARDED
        found[word] = {
            (name, what): float(getattr(np.asarray(result[name])[after], what)()) for name, what, _ in SHOWN
        }
    return found, spent


def main() -> None:
    """Run all and fill the page."""
    rows, costs = [], []
    for title, settings in CASES.items():
        found, spent = of_case(settings)
        steady = found["steady"]
        rows.append([title, "steady", *(f"{steady[name, what] / 1e3:.5g} k" for name, what, _ in SHOWN)])
        for word in list(AIRFOIL_MODELS)[1:]:
            change = [f"{100 * (found[word][name, what] / steady[name, what] - 1):+.2f} %" for name, what, _ in SHOWN]
            rows.append([title, word, *change])
        costs.append([title, *(f"{spent[word]:.2f} s, {spent[word] / spent['steady']:.2f}" for word in AIRFOIL_MODELS)])
        print(markdown((("wind", "model", *(head for *_, head in SHOWN)), rows)), flush=True)
        print(markdown((("wind", *AIRFOIL_MODELS), costs)), flush=True)
    page = PAGE.read_text(encoding="utf-8")
    page = fill(page, "effects", markdown((("wind", "airfoils", *(head for *_, head in SHOWN)), rows)))
    page = fill(page, "costs", markdown((("processor time of 400 s", *AIRFOIL_MODELS), costs)))
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
