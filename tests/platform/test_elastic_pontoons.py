"""Towers on hulls whose pontoons bend: a semi-submersible of concrete and a tension leg platform of steel."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw

REST = {"wind.kind": "none", "sea.spectrum": "still"}
CASES = [("oo_star_dtu10mw", 35e9, 0.4, (0.12, 0.16)), ("tlp_elastic", 210e9, 0.3, (0.03, 0.07))]


@pytest.mark.long
@pytest.mark.parametrize(("name", "modulus", "above", "between"), CASES)
def test_pontoons_that_bend_slow_the_first_bending_of_the_tower(name, modulus, above, between):
    """By 14 and 4 %, of walls that are not printed (docs/elastic_floaters.md), and as springs in series: 5 %.

    Of a tower on a spring, 1/f^2 is that on a stiff hull and a part that goes with the compliance of the hull
    (Dunkerley, who leaves out that the mode changes), so that half the modulus doubles what comes to it.
    """
    memory = {f"platform.hull.{key}": value for key, value in (("radiation_order", 0), ("excitation", False))}
    plant = fw.load(name, set=memory).compile()
    found = []
    for share in (1e4, 1.0, 0.5):
        rest = plant.equilibrium(parameters={**REST, "platform.young_modulus": share * modulus})
        modes = plant.linearize(rest, outputs=[]).modes()
        found.append(min(m.frequency_hz for m in modes if m.frequency_hz > above and m.damping_ratio < 0.3))
    slower = 1 - found[1] / found[0]
    assert between[0] < slower < between[1]
    stiff, soft, softer = (1 / f**2 for f in found)
    np.testing.assert_allclose(softer - stiff, 2 * (soft - stiff), rtol=0.05)
