"""Continue the rotor coefficients of the NREL 5 MW turbine to parked, idling and fast rotors, by its own blades.

python models/convert/nrel5mw_rotor_coefficients_whole.py

Inside of rotor_coefficients.csv its numbers stay. Outside they are those of blade-element momentum theory, from
blade_aerodynamics.csv and airfoils.csv, plus the difference of the two at the border, which fades out along `FADES`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fowtlib.components.aero import BladeElementRotor, coefficient_table, read_blade, read_coefficients
from fowtlib.components.aero.coefficient_table import CoefficientTable, write_coefficients

DATA = Path(__file__).parent.parent / "data" / "nrel5mw"
PRECONE = np.radians(2.5)
FAST = np.concatenate(
    [np.arange(15, 25, 0.5), np.arange(25, 60, 2.5), np.arange(60, 100, 5.0), np.arange(100, 160.1, 10)]
)
"""Tip speed ratios above the published ones, to rated speed (79.8 m/s) in the least wind of CoefficientRotor (0.5 m/s).

Lulls of 4 m/s reach 94. From 25 on both coefficients are nearly parabolas.
"""
FADES = {"below": 2.0, "above": 10.5, "pitch": np.radians(20.0)}
"""Ways from the border to where the difference is gone: tip speed ratio to rest and to 25, pitch."""

ABOUT = (
    "NREL 5 MW rotor: steady coefficients over tip speed ratio and blade pitch, rigid blades, also parked and idling.",
    "Inside of tip speed ratio 2 to 14.5 and pitch -5 to 30 deg: rotor_coefficients.csv. Outside: fowtlib's blade-",
    "element momentum theory (no induction below tip speed ratio 1); the difference at the border fades (SOURCES.md).",
)


def main() -> None:
    """Write rotor_coefficients_whole.csv."""
    inner = read_coefficients(str(DATA / "rotor_coefficients.csv"))
    blade = read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), 1.5, 63.0)
    low, high = inner.tip_speed_ratio[[0, -1]]
    ratios = np.concatenate([np.arange(-1, low, 0.125), inner.tip_speed_ratio, FAST])
    pitches = np.concatenate([inner.blade_pitch, inner.blade_pitch[-1] + np.radians(np.arange(1.0, 70.1))])
    outer = coefficient_table(BladeElementRotor(blade), ratios, pitches, precone=PRECONE)
    rows = np.isin(ratios, inner.tip_speed_ratio)
    columns = np.isin(pitches, inner.blade_pitch)
    beyond = np.select(
        [ratios < low, ratios > high], [(low - ratios) / FADES["below"], (ratios - high) / FADES["above"]]
    )
    aside = np.maximum(pitches - inner.blade_pitch[-1], 0) / FADES["pitch"]
    share = np.maximum(1 - beyond, 0)[:, None] * np.maximum(1 - aside, 0)

    def joined(inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
        difference = inside - outside[np.ix_(rows, columns)]
        nearest = np.ix_(np.clip(np.searchsorted(inner.tip_speed_ratio, ratios), 0, len(inside) - 1),
                         np.clip(np.searchsorted(inner.blade_pitch, pitches), 0, inside.shape[1] - 1))  # fmt: skip
        return outside + share * difference[nearest]

    whole = CoefficientTable(ratios, pitches, joined(inner.thrust, outer.thrust), joined(inner.torque, outer.torque))
    write_coefficients(DATA / "rotor_coefficients_whole.csv", whole, PRECONE, ABOUT)


if __name__ == "__main__":
    main()
