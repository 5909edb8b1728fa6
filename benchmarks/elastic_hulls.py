"""What the bending of a hull does to the OO-Star with the DTU 10-MW turbine and to a TLP with the NREL 5-MW turbine.

`python benchmarks/elastic_hulls.py` prints the tables of docs/elastic_floaters.md: natural frequencies at rated wind,
deviations and the damage at the foot of the tower by Dirlik's law, each with the hull as it is and ten thousand times
as stiff. States: the likeliest sea of each wind in the northern North Sea, with the probability of the wind.
Printed: J.M. Hegseth's thesis (NTNU, 2020), where the OO-Star's first bending is 25 % slower with its hull elastic (K.
Mueller, 2018), and the weighted damage at the foot of the tower of a 5-MW TLP 12.7 % smaller with elastic pontoons.
"""

from __future__ import annotations

import argparse
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from pages import markdown

import fowtlib as fw
from fowtlib.analysis.fatigue import SNCurve, TubeSection
from fowtlib.metocean import likely_states, site

STIFFER = 1e4
RESULTS = ("heave", "pitch", "tower_base_moment", "tower_top_displacement")
CURVES = {3.0: SNCurve(3.0, 12.164), 5.0: SNCurve(5.0, 15.606)}  # curve D in air, DNV-RP-C203, its two branches
WINDS = (5.0, 9.0, 13.0, 17.0, 21.0, 25.0)
STILL = {"wind.kind": "steady", "sea.spectrum": "still"}


@dataclass(frozen=True)
class Case:
    """A model, the modulus of its hull, the foot of its tower and the height of its hub."""

    model: str
    modulus: float
    foot: TubeSection
    hub: float
    rated: float


CASES = {
    "oo_star": Case("oo_star_dtu10mw", 35e9, TubeSection(12.05, 0.0728), 119.0, 11.4),
    "tlp": Case("tlp_elastic", 210e9, TubeSection(6.5, 0.027), 90.0, 11.4),
}


def frequencies(plant: Any, case: Case, modulus: float, below: float) -> list[tuple[float, float]]:
    """Frequencies [Hz] and damping of the modes of the motions and of bending, without those of memory and filters."""
    given = {**STILL, "wind.mean_speed": case.rated, "platform.young_modulus": modulus}
    modes = plant.linearize(fw.mean_state(plant, parameters=given), outputs=[]).modes()
    return sorted(
        (m.frequency_hz, m.damping_ratio) for m in modes if 0 < m.frequency_hz < below and m.damping_ratio < 1
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", default=list(CASES))
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    for case in (CASES[name] for name in given.cases):
        plant = fw.load(case.model).compile()
        for modulus in (STIFFER * case.modulus, case.modulus):
            found = frequencies(plant, case, modulus, 1.0)
            print(case.model, f"{modulus:g} Pa:", ", ".join(f"{f:.4f} ({d:.3f})" for f, d in found), flush=True)
        rows, total = [], np.zeros((2, len(CURVES)))
        seas = likely_states(site("northern_north_sea").at(case.hub), WINDS)
        assert seas.probability is not None
        for speed, height, period, share in zip(
            WINDS, seas.wave_height, seas.peak_period, seas.probability, strict=True
        ):
            weather = {"wind.mean_speed": speed, "sea.significant_wave_height": height, "sea.peak_period": period}
            both = [fw.response(plant, outputs=RESULTS, parameters=weather | {"platform.young_modulus": modulus})
                    for modulus in (STIFFER * case.modulus, case.modulus)]  # fmt: skip
            damage = np.array([[one.damage("tower_base_moment", curve, case.foot) for curve in CURVES.values()]
                               for one in both])  # fmt: skip
            total += share * damage
            change = [f"{100 * (both[1].std(name) / both[0].std(name) - 1):+.1f}" for name in RESULTS]
            rows.append((f"{speed:g} m/s, {height:.1f} m, {period:.1f} s", f"{share:.3f}", *change,
                         *(f"{100 * (b / a - 1):+.1f}" for a, b in damage.T)))  # fmt: skip
            print(rows[-1], flush=True)
        rows.append(("weighted", "1", *[""] * len(RESULTS), *(f"{100 * (b / a - 1):+.1f}" for a, b in total.T)))
        heads = ("state", "share", *RESULTS, *(f"damage, m = {m:g}" for m in CURVES))
        print(markdown((heads, rows)))


if __name__ == "__main__":
    main()
