"""Figures and tables of docs/dtif.md: a tower raised by water, in still water and in waves.

    python benchmarks/raisable_tower.py picture     docs/figures/dtif_raising.png
    python benchmarks/raisable_tower.py waves       what waves do to the operation, one line for each sea
    python benchmarks/raisable_tower.py friction    the same in seas of 9 s for several frictions of the guide
    python benchmarks/raisable_tower.py limit       the highest sea in which it is raised, by halving, and what ends it

The limits that the tables look for: the nacelle accelerates by more than 0.3 g (gravity along its axis included), the
water comes over the top of the flotation cylinder, or the tower touches the floor again once it floats.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.analysis.lifting import stroke
from fowtlib.language.errors import SimulationError

FIGURE = Path(__file__).parent.parent / "docs" / "figures" / "dtif_raising.png"
G = 9.80665
LIFT = "platform.lifting.lift at 600 s"


def picture() -> None:
    """The operation in still water over time, and the stability over the way."""
    import matplotlib.pyplot as plt

    plant = fw.load("dtif_raising").compile()
    result = plant.simulate(8500, 2.0, events=["lifting.lift at 10 s", "lifting.drain at 4400 s"])
    way = stroke(plant, 50.0, 0.2)
    t = result.time / 60

    def of(name: str) -> np.ndarray:
        return np.asarray(result[name])

    figure, panels = plt.subplots(2, 3, figsize=(13, 6.4), layout="constrained")
    for name, label in (("position", "foot of the tower"), ("shaft_level", "water in the shaft")):
        panels[0, 0].plot(t, of(name), label=label)
    panels[0, 0].plot(t, of("platform.tanks.surface") + 60, label="water in the tanks")
    panels[0, 0].set_ylabel("above the floor of the shaft [m]")
    for name, label in (("shaft_water", "shaft"), ("tank_water", "tanks")):
        panels[0, 1].plot(t, of(name), label=label)
    panels[0, 1].set_ylabel("water [m$^3$]")
    for name, label in (("floor_force", "floor"), ("lift", "water"), ("latch_force", "latch")):
        panels[0, 2].plot(t, of(name) / 1e3, label=label)
    panels[0, 2].set_ylabel("force on the tower [MN]")
    panels[1, 0].plot(t, 1e3 * of("heave"))
    panels[1, 0].set_ylabel("heave of the hull [mm]")
    panels[1, 1].plot(t, of("pump_power"), label="into the water")
    panels[1, 1].set_ylabel("power of the filling pump [kW]")
    panels[1, 2].plot(way.position, way.metacentric_height)
    panels[1, 2].axhline(1.0, color="0.5", linestyle="--")
    panels[1, 2].set(xlabel="foot of the tower above the floor [m]", ylabel="GM [m]", ylim=(0, None))
    for panel in panels.flat:
        panel.grid(alpha=0.3)
        if panel is not panels[1, 2]:
            panel.set_xlabel("time [min]")
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="center right")
    figure.savefig(FIGURE, dpi=90)


def in_a_sea(plant: fw.Plant, height: float, period: float, seed: int = 1, **values: float) -> dict[str, float] | str:
    """The whole operation in a JONSWAP sea; what it did, or why it stopped."""
    sea = {"spectrum": "jonswap", "significant_wave_height": height, "peak_period": period, "seed": seed,
           "build_up": 300.0, "repetition_period": 8192.0}  # fmt: skip
    parameters = {f"sea.{name}": value for name, value in sea.items()} | values
    try:
        result = plant.simulate(4900, 0.5, parameters=parameters, events=[LIFT])
    except SimulationError as error:
        return str(error)

    def of(name: str) -> np.ndarray:
        return np.asarray(result[name])

    grown, afloat = result.time > 300, of("position") > 0.5
    rings = [np.linalg.norm(of(f"platform.guide.{name}"), axis=1) for name in ("first_ring", "second_ring")]
    felt = of("nacelle_acceleration") + G * np.sin(np.radians(of("pitch")))
    return {
        "acceleration": float(np.abs(felt[grown]).max()),
        "pitch": float(np.abs(of("pitch")[grown]).max()),
        "ring": float(np.max(rings, axis=0)[grown].max() / 1e6),
        "immersion": float(of("immersion")[afloat].max()),
        "floor": float(of("floor_force")[afloat].max()),
        "closed": float(of("platform.latch.closed")[-1]),
    }


def reason(found: dict[str, float] | str) -> str:
    """What is beyond its limit, "" where nothing is."""
    if isinstance(found, str):
        return "water over the top of the cylinder" if "over the top of the piston" in found else found
    limits = {"acceleration over 0.3 g": found["acceleration"] > 0.3 * G, "floor touched again": found["floor"] > 0,
              "not latched": found["closed"] < 1}  # fmt: skip
    return ", ".join(name for name, broken in limits.items() if broken)


def limit(plant: fw.Plant, period: float, low: float = 1.0, high: float = 8.0, **values: float) -> tuple[float, str]:
    """Significant height [m] up to which the tower is raised in seas of a peak period, to 0.1 m; what ends it above."""
    why = ""
    while high - low > 0.1:
        middle = (low + high) / 2
        found = reason(in_a_sea(plant, middle, period, **values))
        low, high, why = (low, middle, found) if found else (middle, high, why)
    return low, why


def table(rows: list[tuple[str, dict[str, float] | str]]) -> None:
    """Print what came out, as rows of a page."""
    print("| sea | nacelle [m/s²] | pitch [deg] | ring [MN] | deepest immersion [m] | floor again [kN] | latched |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name, found in rows:
        if isinstance(found, str):
            print(f"| {name} | stopped: {found} |")
        else:
            latched = "yes" if found["closed"] else "no"
            print(f"| {name} | {found['acceleration']:.2f} | {found['pitch']:.1f} | {found['ring']:.1f} | "
                  f"{found['immersion']:.2f} | {found['floor']:.0f} | {latched} |")  # fmt: skip


def main(what: str) -> None:
    """One of the four."""
    if what == "picture":
        picture()
        return
    plant = fw.load("dtif_raising").compile()
    if what == "waves":
        seas = [(height, period) for period in (7, 9, 11, 13) for height in (2, 4, 5, 6, 7)]
        table([(f"{height} m, {period} s", in_a_sea(plant, height, period)) for height, period in seas])
        return
    if what == "limit":
        for period, friction in [(7, 0.1), (9, 0.1), (11, 0.1), (13, 0.1), (9, 0.2), (9, 0.3)]:
            height, why = limit(plant, period, **{"platform.rubbing.coefficient": friction})
            print(f"| {period} s, friction {friction} | {height:.1f} m | {why} |", flush=True)
        return
    frictions = [(mu, height) for mu in (0.05, 0.1, 0.2, 0.3) for height in (2, 4, 6)]
    table([(f"{height} m, friction {mu}", in_a_sea(plant, height, 9, **{"platform.rubbing.coefficient": mu}))
           for mu, height in frictions])  # fmt: skip


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in ("picture", "waves", "friction", "limit"):
        sys.exit(__doc__)
    main(sys.argv[1])
