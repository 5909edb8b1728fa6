"""Aerodynamic inertia and damping of the DTU 10-MW turbine beside published coefficients."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models

PERIODS = np.array([20.0, 31.3, 50.0, 100.0, 181.8])
# From a blade-element model of the turbine of J.M. Hegseth et al., J. Phys.: Conf. Ser. 1452 (2020) 012040, shaft along
# the wind, I_d = 1.6e8 kg m^2: wind [m/s], inertia [1e5 kg], damping [1e4 N s/m] over PERIODS; good to 10 %.
PUBLISHED = [
    (13.0, (1.64, 3.90, 9.09, 22.7, 31.9), (14.9, 13.7, 10.7, 1.38, -6.02)),
    (19.0, (2.25, 3.43, 4.56, 6.52, 9.86), (8.57, 5.57, 3.18, 1.27, 0.15)),
    (25.0, (1.97, 2.37, 2.66, 3.24, 4.59), (4.71, 2.82, 1.79, 1.18, 0.89)),
]
MODEL = """
fowtlib: 1
title: DTU 10-MW turbine on a moved hub
world: {class: World}
wind: {class: Wind, kind: steady, mean_speed: 13 m/s, reference_height: 119 m, stations: [[0, 119]]}
parts:
  mount: {class: ForcedOscillation, r: [0, 0, 119]}
  turbine: {use: turbines/dtu10mw_rigid, parts: {rotor: {filtered: false, tilt: 0}}}
connect:
  - [mount.frame, turbine.frame]
"""


@pytest.fixture(scope="module")
def moved(tmp_path_factory):
    if not (Path(fowtlib.models.__file__).parent / "turbines" / "dtu10mw_rigid.yaml").exists():
        pytest.skip("there is no turbines/dtu10mw_rigid")
    path = tmp_path_factory.mktemp("moved") / "moved.yaml"
    path.write_text(MODEL.lstrip())
    return fw.load(path).compile()


@pytest.mark.parametrize(("wind", "inertia", "damping"), PUBLISHED)
def test_coefficients_of_the_dtu_10_mw_turbine(moved, wind, inertia, damping):
    found = fw.aerodynamic_coefficients(moved, 1 / PERIODS, parameters={"wind.mean_speed": wind})
    assert found.inertia / 1e5 == pytest.approx(inertia, rel=0.1)
    assert found.damping / 1e4 == pytest.approx(damping, rel=0.1, abs=0.2)


def test_a_forced_oscillation_of_the_dtu_10_mw_turbine_gives_the_same(moved):
    frequency, wind = [1 / 50], {"wind.mean_speed": 19.0}
    linear = fw.aerodynamic_coefficients(moved, frequency, parameters=wind)
    forced = fw.forced_oscillation(moved, frequency, parameters=wind, solver="fixed", step=0.05, settle=400.0)
    assert forced.transfer == pytest.approx(linear.transfer, rel=0.02)
