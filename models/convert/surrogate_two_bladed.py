"""Compute the coefficients of a rotor of two blades from those of the DTU 10-MW turbine, and write its definition.

    python models/convert/surrogate_two_bladed.py

Two blades of 1.5 times the chord have the solidity of three, and so the same tip speed ratio at their best; what two
blades lose is their tips. fowtlib's blade-element momentum theory, as convert/dtu10mw_rotor_coefficients.py.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from fowtlib.components.aero import BladeElementRotor, coefficient_table, read_blade, read_coefficients
from fowtlib.components.aero.coefficient_table import CoefficientTable, write_coefficients
from fowtlib.design.rules.turbine import DTU_10MW, NREL_5MW, between

MODELS = Path(__file__).parents[1]
DATA = MODELS / "data"
PRECONE = np.radians(2.5)
RATIOS = np.concatenate([np.arange(-1, 2, 0.25), np.arange(2, 14, 0.5), np.arange(14, 30, 1.0), np.arange(30, 60, 5.0),
                         np.arange(60, 180.1, 20.0)])  # fmt: skip
PITCHES = np.radians(np.concatenate([np.arange(-5.0, 30.0, 1.0), np.arange(30.0, 100.1, 5.0)]))
ABOUT = (
    "Two blades of 1.5 times the chord of the DTU 10-MW turbine: steady coefficients over tip speed ratio and pitch.",
    "fowtlib's blade-element momentum theory (SOURCES.md).",
)


def best(table: CoefficientTable) -> float:
    """Largest C_q/lambda^2 of where the power is largest, with which the optimal torque goes."""
    ratios = np.linspace(5.0, 12.0, 701)
    torque = np.asarray(table(ratios, np.zeros(701))[1])
    k = int(np.argmax(ratios * torque))
    return float(torque[k] / ratios[k] ** 2)


def text(table: CoefficientTable) -> str:
    """The definition file."""
    turbine = between(NREL_5MW, DTU_10MW, 85.6, 7.0e6)
    three = read_coefficients(str(DATA / "dtu10mw" / "rotor_coefficients.csv"))
    constant = turbine.optimal_constant / turbine.gear_ratio**3 * best(table) / best(three)
    return f"""# The surrogate 7-MW turbine with two blades of 1.5 times the chord: the same solidity, mass and inertia, other coefficients.
# Made by models/convert/surrogate_two_bladed.py. A rigid rotor by coefficients: that two blades have no constant moment of
# inertia about a diameter is left out.
fowtlib: 1
title: Surrogate 7-MW turbine with two blades
use: turbines/surrogate_7mw
parts:
  rotor: {{coefficients: "data:surrogate_7mw/two_bladed_coefficients.csv"}}
  control:
    parts:
      torque: {{region_2_constant: {constant:.6g} N*m*s^2/rad^2}}
"""  # noqa: E501


def main() -> None:
    """Write the coefficients and the definition."""
    blade = read_blade(str(DATA / "dtu10mw/blade_aerodynamics.csv"), str(DATA / "dtu10mw/airfoils.csv"), 2.8, 89.1655)
    wide = replace(blade, chord=1.5 * blade.chord)
    table = coefficient_table(BladeElementRotor(wide, blades=2), RATIOS, PITCHES, precone=PRECONE)
    write_coefficients(DATA / "surrogate_7mw" / "two_bladed_coefficients.csv", table, PRECONE, ABOUT)
    (MODELS / "turbines" / "surrogate_7mw_two_bladed.yaml").write_text(text(table))


if __name__ == "__main__":
    main()
