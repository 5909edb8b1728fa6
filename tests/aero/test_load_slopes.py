"""Slopes of a rotor's loads by the wind at its elements: sums, the printed effective winds, files and mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fowtlib.components.aero import RigidRotor, load_slopes, read_load_slopes, write_load_slopes
from fowtlib.components.environment.disc_turbulence import turning_density
from fowtlib.components.environment.turbulence import coherence, kaimal
from fowtlib.language.errors import ParameterError

DTU = Path(__file__).parent / "dtu10mw_load_slopes.csv"
RPM = np.pi / 30


def test_slopes_of_all_elements_together_are_those_of_the_rotor(rotor):
    slopes = load_slopes(rotor, [8.0, 12.0, 18.0], [9.16 * RPM, 12.1 * RPM, 12.1 * RPM], np.radians([0, 3.8, 14.9]))
    for k, wind in enumerate(slopes.wind_speed):
        h, state = 1e-3, (slopes.rotor_speed[k], slopes.blade_pitch[k])
        above, below = (RigidRotor(rotor).thrust_and_torque([wind + s * h, 0, 0], *state, air_density=1.0)
                        for s in (1, -1))  # fmt: skip
        expected = (np.array(above) - np.array(below)) / (2 * h)
        assert 3 * slopes.thrust[k].sum() == pytest.approx(expected[0], rel=1e-5)
        assert 3 * slopes.torque[k].sum() == pytest.approx(expected[1], rel=1e-5)


@pytest.mark.parametrize("rotation", [1, -1])
def test_a_vertical_shear_tilts_the_rotor_by_the_slopes_of_the_moment(blade, rotation):
    from fowtlib.components.aero import BladeElementRotor

    rotor = BladeElementRotor(blade, rotation=rotation)
    slopes, shear = load_slopes(rotor, [12.0], [12.1 * RPM], [np.radians(3.8)], precone=0.04), 1e-4
    rigid, found = RigidRotor(rotor, precone=0.04), []
    for azimuth in np.arange(4) * np.pi / 6:
        inputs = rigid.inputs([12.0, 0, 0], 12.1 * RPM, np.radians(3.8), azimuth, hub=(0, 0, 0), air_density=1.0)
        n, moments = rotor.nodes, []
        for sign in (1, -1):
            sheared = inputs.copy()
            sheared[15 * n : 18 * n : 3] += sign * shear * inputs[2 : 3 * n : 3]
            loads = rigid.loads(sheared)
            place = inputs[: 3 * n].reshape(-1, 3)
            moments.append((np.cross(place, loads[:, :3]) + loads[:, 3:]).sum(axis=0)[1])
        found.append((moments[0] - moments[1]) / (2 * shear))
    expected = 1.5 * slopes.moment[0] @ slopes.radius
    assert np.mean(found) == pytest.approx(expected, rel=2e-3)  # sweep of the blades: radius is no height


def test_slopes_and_effective_winds_of_the_dtu_10_mw_rotor_are_the_published_ones():
    """Hegseth (2020), NTNU 2020:356: his model in its steady state of 15 m/s, and 1.25 kg/m^3."""
    slopes = read_load_slopes(str(DTU)).at(15.0)
    thrust, torque, moment = (values[0] for values in (slopes.thrust, slopes.torque, slopes.moment))
    assert 3 * 1.25 * thrust.sum() == pytest.approx(158.7e3, rel=5e-3)
    assert 3 * 1.25 * torque.sum() == pytest.approx(2.740e6, rel=2e-3)
    assert 1.5 * 1.25 * moment.sum() == pytest.approx(4.30e6, rel=2e-3)
    uniform, once = np.stack([thrust / thrust.sum(), torque / torque.sum()]), moment[None] / moment.sum()

    def spectrum(omega):
        return kaimal(omega / (2 * np.pi), 15.0, 1.0, 119.0) / (2 * np.pi)

    density = turning_density(1e-6, slopes.radius, slopes.rotor_speed[0], spectrum,
                              lambda f, d: coherence(f, d, 15.0, 119.0), 3, uniform, once)[0]  # fmt: skip
    f_T, f_Q, f_M, f_yaw = np.sqrt(np.diag(density).real / spectrum(1e-6))
    assert (f_T, f_M, f_Q) == pytest.approx((0.8605, 0.3766, 0.8581), rel=2e-3)
    assert f_yaw == pytest.approx(f_M)
    coherent = density[0, 1].real / np.sqrt(density[0, 0] * density[1, 1]).real
    assert 0.999 < coherent <= 1.0  # taken as 1 there


def test_written_slopes_are_read_again_and_stand_between_the_rows(tmp_path):
    slopes = read_load_slopes(str(DTU))
    write_load_slopes(tmp_path / "again.csv", slopes, ["a comment"])
    again = read_load_slopes(str(tmp_path / "again.csv"))
    for name in ("wind_speed", "rotor_speed", "blade_pitch", "radius", "thrust", "torque", "moment"):
        assert getattr(again, name) == pytest.approx(getattr(slopes, name), rel=1e-6)
    half = slopes.at(14.0)
    assert half.thrust[0] == pytest.approx((slopes.at(13.0).thrust[0] + slopes.at(15.0).thrust[0]) / 2)
    assert slopes.at(25.0).thrust[0] == pytest.approx(slopes.thrust[-1])
    assert slopes.at(8.0).rotor_speed[0] == pytest.approx(6.43 * RPM)


def test_a_rotor_that_cuts_out_jumps_and_stands_feathered(rotor):
    slopes = load_slopes(rotor, [20.0, 25.0, 25.0, 50.0], np.array([12.1, 12.1, 0, 0]) * RPM,
                         np.radians([17.4, 23.5, 90, 90]))  # fmt: skip
    assert slopes.at(20.0).rotor_speed == pytest.approx(12.1 * RPM)
    assert slopes.at(25.0).rotor_speed == pytest.approx(12.1 * RPM)  # the last wind of operation
    assert slopes.at(25.01).rotor_speed == 0
    thrusts = [RigidRotor(rotor).thrust_and_torque([wind, 0, 0], 0.0, np.pi / 2)[0] for wind in (40.0, 50.0)]
    for wind, thrust in zip((40.0, 50.0), thrusts, strict=True):  # goes with the square of the wind
        assert 3 * 1.225 * slopes.at(wind).thrust.sum() == pytest.approx(2 * thrust / wind, rel=1e-6)
    assert slopes.at(50.0).moment.sum() > 0
    alone = load_slopes(rotor, [12.0], [12.1 * RPM], [np.radians(3.8)])
    assert alone.at(12.0).thrust == pytest.approx(alone.thrust)


def test_mistakes_in_a_table_of_slopes_are_named(tmp_path):
    slopes = read_load_slopes(str(DTU))
    with pytest.raises(ParameterError, match=r"dtu10mw_load_slopes.csv: .* cover winds of 8 to 25 m/s, and not 26"):
        slopes.at(26.0)
    lines = DTU.read_text().splitlines()
    path = tmp_path / "wrong.csv"
    path.write_text("\n".join(lines[:-1]))
    with pytest.raises(ParameterError, match=r"wrong.csv.*same radii"):
        read_load_slopes(str(path))
    path.write_text("\n".join([lines[3], *lines[24:44], *lines[4:24]]))
    with pytest.raises(ParameterError, match="must not fall"):
        read_load_slopes(str(path))
