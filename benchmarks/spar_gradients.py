"""How long gradients of the elastic 10-MW spar take beside its response: `python benchmarks/spar_gradients.py`.

Processor time of a state at its rated wind at new designs: 50 sizes and gains, and 80 with other parameters of parts.
Those of the lines stay where they are: a deeper anchor would lie below the seabed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gradients import processor_time

import fowtlib as fw
from fowtlib.frequency import EquivalentLoad, PreparedGradient
from fowtlib.solving.tuned import tuned_elements

CONTROL = "rna.turbine.control."
SIZES = ["hull_diameters", "hull_walls", "tower_diameters", "tower_walls", "line_length", "line_distance",
         "chain_diameter", "fairlead_depth", CONTROL + "proportional_gain", CONTROL + "integral_gain"]  # fmt: skip
WEATHER = {"wind.mean_speed": 11.0, "wind.turbulence_intensity": 0.18, "sea.significant_wave_height": 7.5,
           "sea.peak_period": 12.0}  # fmt: skip
TOWER = ["tower_base_moment", *(f"tower_moment_node_{k}" for k in range(1, 10))]
RESULTS = ["std rotor_speed", "max upwind_tension", "max fairlead_offset", "max pitch", "max surge",
           *(EquivalentLoad(name, 5.0) for name in TOWER), "mean upwind_tension"]  # fmt: skip


def variables(plant: Any) -> list[str]:
    """The elements by which results are differentiated: 50 sizes and gains first, then others."""
    others = [path for path, item in plant.dae.parameters.items() if path.startswith(("rna.", "mooring.", "yaw_"))
              and item.max is None and item.value.shape == () and item.value != 0 and path not in SIZES]  # fmt: skip
    return [item.name for path in [*SIZES, *others] for item in tuned_elements(plant, [path])]


def measured(plant: Any, count: int, results: list[Any]) -> tuple[float, float]:
    """Processor time of values, and of values with gradients by so many variables [s]."""
    prepared = PreparedGradient(plant, results, variables(plant)[:count], parameters=WEATHER)
    prepared.evaluate()
    moving = np.array([not name.startswith("mooring.") for name in prepared.parameters])
    values, both = (processor_time(one, prepared.start, moving) for one in (prepared.values, prepared.evaluate))
    return values, both


def main() -> None:
    plant = fw.load("dtu10mw_spar_3_design").compile()
    print("| parameters | results | values | values and gradients | ratio |\n| --- | --- | --- | --- | --- |")
    for count in (50, 80):
        for results in (RESULTS[:1], RESULTS[:6], RESULTS):
            values, both = measured(plant, count, results)
            print(f"| {count} | {len(results)} | {values:.2f} s | {both:.2f} s | {both / values:.1f} |", flush=True)


if __name__ == "__main__":
    main()
