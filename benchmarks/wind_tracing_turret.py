"""Where the turret of the wind-tracing triangle should be for the stability of its yaw (docs/wind_tracing.md).

    python benchmarks/wind_tracing_turret.py

The slowest pole of the turn, with the friction of the turret, at 8, 11.4 and 18 m/s of steady wind; the place on the
axis of symmetry is sought where the slowest of the three returns fastest.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

import fowtlib as fw

WINDS = (8.0, 11.4, 18.0)  # m/s
PLACES = (-160.0, -100.0)  # m, along the axis; the single column is at -160 m
SLOW = 0.012  # rad/s: slower than all motions but the turn


def returns(place: float) -> list[tuple[float, float]]:
    """Yaw at rest [deg] and time constant [s] of the slowest pole in each wind; negative where yaw grows."""
    plant = fw.load("wind_tracing_rigid", set={"platform.turret_x": place}).compile()
    found = []
    for wind in WINDS:
        steady = {"wind.kind": "steady", "wind.mean_speed": wind, "sea.spectrum": "still"}
        state = fw.mean_state(plant, parameters=steady)
        poles = np.linalg.eigvals(np.asarray(plant.linearize(state, outputs=[]).A))
        slow = poles[(np.abs(poles) > 1e-6) & (np.abs(poles) < SLOW)]
        found.append((float(np.degrees(state["platform.motion.yaw"])), -1 / slow.real.max()))
    return found


def slowest(place: float) -> float:
    """The largest real part [1/s] of the three."""
    found = returns(place)
    rows = (f"{wind:g} m/s {yaw:.2f} deg {time / 60:.2f} min" for wind, (yaw, time) in zip(WINDS, found, strict=True))
    print(f"turret at {place:.2f} m:", "; ".join(rows), flush=True)
    return max(-1 / time for _, time in found)


if __name__ == "__main__":
    slowest(40.05 - 277.2 / np.sqrt(3))  # as printed
    best = minimize_scalar(slowest, bounds=PLACES, method="bounded", options={"xatol": 0.5})
    print(f"best at {best.x:.1f} m: the slowest returns within {-1 / best.fun / 60:.1f} min")
