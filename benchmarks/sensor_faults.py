"""What a failed sensor of a blade root moment does to individual pitch control: the table of docs/faults.md.

`python benchmarks/sensor_faults.py` runs oc3_spar in steady wind of 18 m/s with shear 0.14, half a minute each.
"""

from __future__ import annotations

import numpy as np
from feedback import IPC, PAGE, equipped
from pages import fill, markdown

FAILS, DISCARD, DURATION = 60.0, 120.0, 150.0
CONDITIONS = {"wind.kind": "steady", "wind.mean_speed": 18.0, "wind.shear_exponent": 0.14, "sea.spectrum": "still"}
FAULTS = {
    "without individual pitch": None, "none": "", "stuck": "stuck", "drop-out, 0": "drop_out",
    "offset, 1 MN m": "offset, by=1 MN*m", "scaled, 0.8": "scaled, by=0.8",
}  # fmt: skip
MOMENTS = [f"turbine.assembly.blade_{k}.flapwise_moment" for k in (1, 2, 3)]
SHAFT = "turbine.assembly.nacelle.shaft_bending_moment"
PITCHES = [f"turbine.assembly.individual_pitch[{k}]" for k in range(3)]


def main() -> None:
    plant, rows = equipped("oc3_spar"), []
    for name, fault in FAULTS.items():
        event, _, value = (fault or "").partition(", ")
        events = [f"individual.sensor_1.{event} at {FAILS:g} s{', ' + value if value else ''}"] if event else []
        gains = {IPC: 0.0 if fault is None else 1e-9}
        result = plant.simulate(DURATION, 0.05, parameters=CONDITIONS | gains, events=events,
                                outputs=[*MOMENTS, SHAFT, *PITCHES])  # fmt: skip
        late = np.asarray(result.time) >= DISCARD
        moments = [1e-3 * float(np.asarray(result[path])[late].std()) for path in MOMENTS]
        bending = 1e-3 * float(np.asarray(result[SHAFT])[late].mean())
        pitch = max(float(np.degrees(np.abs(np.asarray(result[path])[late]).max())) for path in PITCHES)
        rows.append((name, *moments, bending, round(pitch, 3)))
        print(rows[-1], flush=True)
    heads = ("fault of sensor 1", *(f"root moment {k} [kN m]" for k in (1, 2, 3)), "shaft bending, mean [kN m]",
             "largest individual pitch [deg]")  # fmt: skip
    PAGE.write_text(fill(PAGE.read_text(), "sensor_faults", markdown((heads, rows), 4)))


if __name__ == "__main__":
    main()
