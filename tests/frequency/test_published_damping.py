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


@pytest.mark.parametrize("wind", [13.0, 19.0, 25.0])
def test_a_hub_that_moves_ever_more_slowly_feels_the_curve_of_the_thrust_over_the_wind(moved, wind):
    """Which falls above rated wind, so that the damping of a slow motion is negative: the sign of the whole loop."""
    found = fw.aerodynamic_coefficients(moved, [1e-5], parameters={"wind.mean_speed": wind})
    up, down = (
        float(fw.mean_state(moved, {"wind.mean_speed": wind + step})["turbine.thrust"]) for step in (0.01, -0.01)
    )
    assert found.damping[0] == pytest.approx((up - down) / 0.02, rel=1e-3) and found.damping[0] < -1e4


ELEMENTS = """
fowtlib: 1
title: DTU 10-MW turbine of blade elements on a moved hub
world: {class: World, air_density: 1.25 kg/m^3}
wind: {class: Wind, kind: steady, mean_speed: 19 m/s, reference_height: 119 m, stations: [[0, 119]]}
parts:
  mount: {class: ForcedOscillation, r: [0, 0, 115.63]}
  turbine:
    use: turbines/dtu10mw
    parts:
      assembly: {blade_hinges: 0, parts: {nacelle: {tilt: 0}}}
      aerodynamics: {airfoil_model: steady}
connect:
  - [mount.frame, turbine.frame]
"""


def test_blade_elements_have_the_same_and_a_dynamic_wake_less_damping(tmp_path):
    """A nacelle that stands fast but for its yaw drive; the wake follows with a delay, and takes damping away."""
    path = tmp_path / "elements.yaml"
    path.write_text(ELEMENTS.lstrip())
    equilibrium, delayed = (
        fw.load(path, set={"turbine.aerodynamics.dynamic_inflow": on}).compile() for on in (False, True)
    )
    for wind, inertia, damping in PUBLISHED[1:]:
        given = {"parameters": {"wind.mean_speed": wind}}
        found, slow = (fw.aerodynamic_coefficients(one, 1 / PERIODS, **given) for one in (equilibrium, delayed))
        assert found.inertia / 1e5 == pytest.approx(inertia, rel=0.15)
        assert found.damping / 1e4 == pytest.approx(damping, rel=0.1, abs=0.2)
        ratio = slow.damping[:3] / found.damping[:3]
        assert np.all((ratio > 0.9) & (ratio < 1.0))
