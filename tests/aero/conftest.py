"""The NREL 5 MW rotor by blade-element momentum theory."""

from dataclasses import replace
from pathlib import Path

import pytest

import fowtlib.models
from fowtlib.components.aero import BladeElementRotor, read_blade

DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"


@pytest.fixture(scope="session")
def blade():
    return read_blade(str(DATA / "blade_aerodynamics.csv"), str(DATA / "airfoils.csv"), 1.5, 63.0)


@pytest.fixture(scope="session")
def rotor(blade):
    return BladeElementRotor(blade)


@pytest.fixture(scope="session")
def plain(blade):
    """Straight blades, no correction for skew: as CCBlade computes."""
    return BladeElementRotor(replace(blade, curve=None, sweep=None), skew=0.0)
