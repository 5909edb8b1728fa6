"""The optimised 10-MW spar as models for design: the printed one, with the loads of all its sections."""

import numpy as np
import pytest

import fowtlib as fw

CALM = {"sea.spectrum": "still", "wind.kind": "steady", "wind.mean_speed": 0.0, "thrust": 0.0}


@pytest.fixture(scope="module")
def parked():
    return fw.load("dtu10mw_spar_3_parked").compile()


def test_at_rest_it_floats_as_printed_and_forces_along_the_hull_are_weights_less_buoyancy(parked):
    rest = parked.equilibrium(parameters=CALM, free=["ballast"], targets={"heave": 0.0})
    assert float(rest.parameters["ballast"]) == pytest.approx(13.307e6, rel=1e-3)
    assert rest["fairlead_offset"] == pytest.approx(rest["surge"] - 10.7 * np.sin(np.radians(rest["pitch"])), abs=1e-3)
    # at the water line: rotor, nacelle, tower and ten metres of hull with its rings, all above the fairlead
    values = parked.parameter_values()
    D, t = (np.array(values[name])[-2:].mean() for name in ("hull_diameters", "hull_walls"))
    tower = _mass(values["tower_heights"], values["tower_diameters"], values["tower_walls"], 8500.0)
    freeboard = 7850 * np.pi * (D - t) * t * 10 * 1.04
    assert rest["hull_axial_force_node_10"] == pytest.approx(-9.80665e-6 * (676.7e3 + tower + freeboard), rel=2e-3)


def test_the_wind_on_the_tower_bends_it_as_drag_on_four_frames_does(parked):
    steady = {"sea.spectrum": "still", "wind.kind": "steady", "thrust": 192.6e3}
    windy, calm = (parked.equilibrium(parameters={**steady, "wind.mean_speed": speed}) for speed in (50.0, 0.0))
    z, D = (np.array(parked.parameter_values()[name]) for name in ("tower_heights", "tower_diameters"))
    ends = np.array([0.0, 26.25, 52.5, 78.75, 105.63])
    fine = np.linspace(ends[:-1], ends[1:], 5001)  # each quarter has its mean diameter
    means = np.interp(10 + fine, z, D).mean(axis=0)
    assert means[0] == pytest.approx(13.908, abs=1e-3)
    frames = zip(means, np.diff(ends), (13.125, 39.375, 65.625, 92.19), strict=True)
    moment = sum(0.5 * 1.25 * 0.7 * D * length * (50.0 * ((10 + above) / 119) ** 0.14) ** 2 * above
                 for D, length, above in frames)  # fmt: skip
    leans = 1e-6 * 9.80665 * (676.7e3 * 108.4 + 953e3 * 39.1) * np.radians(windy["pitch"] - calm["pitch"])
    bent = windy["tower_base_moment"] - calm["tower_base_moment"]
    # the rest is what the tower bends and its drag turns with it
    assert bent == pytest.approx(1e-6 * moment + leans, rel=0.05)


def _mass(heights, diameters, walls, density):
    """Steel of a tube whose section is linear between its stations."""
    z, D, t = (np.array(values, dtype=float) for values in (heights, diameters, walls))
    fine = np.linspace(z[0], z[-1], 20001)
    D, t = np.interp(fine, z, D), np.interp(fine, z, t)
    return density * np.pi * np.mean((D - t) * t) * (z[-1] - z[0])


def test_a_wider_tower_has_more_wind_and_cuts_stay_at_the_stations(parked):
    steady = {"sea.spectrum": "still", "wind.kind": "steady", "wind.mean_speed": 50.0, "thrust": 0.0}
    values = parked.parameter_values()
    wider = {**steady, "tower_diameters": 1.05 * np.array(values["tower_diameters"])}
    force = [float(np.ravel(parked.equilibrium(parameters=given)["tower_drag.force"])[0]) for given in (steady, wider)]
    assert force[1] == pytest.approx(1.05 * force[0], rel=0.005)  # it leans a little more
    # the weight above a cut that moves up by a metre is less by that of the metre, and its buoyancy is
    z = np.array(values["hull_heights"])
    z[9] += 1.0
    rest = parked.equilibrium(parameters={**CALM, "hull_heights": z})
    at = float(np.ravel(rest["hull_axial_force_node_9"])[0])
    before = float(parked.equilibrium(parameters=CALM)["hull_axial_force_node_9"])
    assert at < before - 0.5  # MN: a metre of hull floats more than it weighs
