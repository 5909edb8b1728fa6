"""Airfoils in unsteady flow: balance at the polar, closed forms, Theodorsen and Wagner, stall."""

from dataclasses import replace

import numpy as np
import pytest

from fowtlib.components.aero import (
    AIRFOIL_MODELS,
    BladeElementRotor,
    RigidRotor,
)
from fowtlib.components.aero.airfoil_models import SectionFlow
from fowtlib.language.native import compiler

needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
PRECONE, TILT = np.radians(2.5), np.radians(5.0)
UNSTEADY = {word: model for word, model in AIRFOIL_MODELS.items() if model.states}


def sections(foil, model, angle, speed=50.0, chord=2.0, turn=0.0, states=None, step=1e15):
    """C_l, c_d, c_m (3, n) and rates of sections of one airfoil, by the twin; in equilibrium unless told otherwise."""
    angle = np.atleast_1d(np.asarray(angle, dtype=float))
    full = np.ones_like(angle)
    states = np.zeros((model.states, len(angle))) if states is None else states
    told = SectionFlow(angle, speed * full, chord * full, turn * full, states, step, np.zeros(len(angle), int))
    cubics = model.cubics(foil)

    def look(at):
        at = (at + np.pi) % (2 * np.pi) - np.pi
        i = np.clip(np.searchsorted(foil.angle, at, side="right") - 1, 0, len(foil.angle) - 2)
        return tuple(np.einsum("ijk,ik->ji", cubics[i], (at - foil.angle[i])[:, None] ** np.arange(4)))

    return model.flow(look, told, [foil])


@pytest.mark.parametrize("word", UNSTEADY)
def test_the_balance_is_the_polar_at_all_angles(blade, word):
    angle = np.radians(np.arange(-180, 180, 0.25))
    for foil in blade.airfoils.values():
        steady, _ = sections(foil, AIRFOIL_MODELS["steady"], angle)
        found, rates = sections(foil, UNSTEADY[word], angle)
        assert np.abs(found - steady).max() < 1e-13
        assert np.abs(rates).max() < 1e-9  # of 50 m/s and 25 chords a second


@needs_compiler
@pytest.mark.parametrize("word", UNSTEADY)
def test_a_rotor_in_equilibrium_has_the_loads_of_its_polars(blade, word):
    generator = np.random.default_rng(3)
    rotor = BladeElementRotor(blade)
    other = replace(rotor, airfoil_model=UNSTEADY[word])
    for wind, speed, pitch in ((8.0, 1.0, 0.0), (18.0, 1.267, 0.26), (50.0, 0.0, 1.5), (25.0, 0.1, 0.0)):
        wind = [wind, generator.normal() * 3, 0]
        steady, unsteady = (RigidRotor(r, PRECONE, TILT) for r in (rotor, other))
        loads = steady.loads(steady.inputs(wind, speed, pitch))
        assert unsteady.loads(unsteady.inputs(wind, speed, pitch)) == pytest.approx(loads, abs=1e-12 * abs(loads).max())
