"""SteppedSpar: closed forms against sums over thin slices and members, and the equations for other unknowns."""

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import quad

import fowtlib as fw
from fowtlib.components.platform import layers, solids
from fowtlib.language.errors import SimulationError

SHAPE = layers.stack([2.0, 5.0, 6.0, 70.0], [(40.0, 40.0), (30.0, 30.0), (30.0, 15.0), (15.0, 13.0)])


def diameter(z):
    z0, z1 = [0.0, 2.0, 2.0, 7.0, 7.0, 13.0, 83.0], [40.0, 40.0, 30.0, 30.0, 30.0, 15.0, 13.0]
    return np.interp(z, z0, z1)


@pytest.mark.parametrize("level", [1.2, 6.0, 9.5, 13.0, 62.0, 83.0])
def test_moments_are_those_of_thin_slices(level):
    found = layers.up_to(SHAPE, level)
    breaks = [z for z in (2.0, 7.0, 13.0) if z < level]
    for k, value in enumerate(found):

        def slice_(z, k=k):
            D = diameter(z)
            return np.pi / 4 * D**2 * z**k if k < 3 else np.pi / 64 * D**4

        assert value == pytest.approx(quad(slice_, 0, level, points=breaks, limit=200)[0], rel=1e-8)
    assert float(layers.diameter_at(SHAPE, level + 1e-9)) == pytest.approx(diameter(level + 1e-9), rel=1e-6)


def test_moments_are_those_of_the_solids_of_members():
    """Mass, centre and inertia of a cone, by the three Gauss points that members use."""
    cone = layers.frustum(7.0, 6.0, 30.0, 15.0)
    body = solids.piece((0, 0, 7), (0, 0, 13), np.eye(3), ((30, 30), (15, 15)), True)
    assert (cone.amount, cone.centre) == (pytest.approx(body.mass), pytest.approx(body.centre[2]))
    assert cone.across == pytest.approx(body.about((0, 0, 0))[1, 1])
    assert cone.along == pytest.approx(body.inertia[2, 2])


def test_beyond_their_ends_layers_go_on_as_cylinders():
    """So that a solver has a slope everywhere."""
    level = ca.SX.sym("level")
    area = ca.Function("area", [level], [ca.jacobian(layers.up_to(SHAPE, level).amount, level)])
    assert float(area(90.0)) == pytest.approx(np.pi / 4 * 13.0**2)
    assert float(area(-3.0)) == pytest.approx(np.pi / 4 * 40.0**2)
    assert layers.up_to(SHAPE, -3.0).amount == pytest.approx(-3 * np.pi / 4 * 40.0**2)


def test_the_limits_of_the_added_mass_of_a_plate():
    """A free disc, and half of it; and rising in between as the column gets thinner."""
    assert layers.plate_added_mass(40.0, 0.0) == pytest.approx(1025 * 40.0**3 / 3, rel=1e-12)
    assert layers.plate_added_mass(40.0, 40.0) == pytest.approx(1025 * 40.0**3 / 6, rel=1e-12)
    rows = [layers.plate_added_mass(40.0, D) for D in np.linspace(0, 40, 41)]
    assert np.all(np.diff(rows) < 0)


@pytest.fixture(scope="module")
def spar():
    return fw.load("raisable_spar_sizes").compile()


def test_the_shipped_spar_by_hand(spar):
    """Draft, masses, metacentric height and periods of the shipped sizes, worked out once more from thin slices."""
    state = spar.equilibrium()
    D, wall, shaft, draft = 15.0, 0.35, 7.0, float(state["draft"])
    z = np.linspace(0, 82, 820_001)
    outer = np.interp(z, [0, 2, 2 + 1e-9, 7, 12, 82], [40, 40, 30, 30, 15, 15])
    ring = np.pi / 4 * (outer**2 - (outer - 2 * wall) ** 2) + np.pi / 4 * ((shaft + 2 * wall) ** 2 - shaft**2)
    solid = np.where(z <= 2, np.pi / 4 * outer**2, 1.0203 * ring)
    room = np.where(z > 2, np.pi / 4 * ((outer - 2 * wall) ** 2 - (shaft + 2 * wall) ** 2), 0.0)
    level = float(state["ballast_level"])
    filled = np.where(z <= level, room, 0.0)
    assert np.trapezoid(filled, z) * 2600 == pytest.approx(5325e3, rel=1e-4)
    assert np.trapezoid(solid, z) == pytest.approx(float(state["concrete_volume"]), rel=1e-4)
    weight, moment = 2400 * solid + 2600 * filled, 970e3 * (52 + 75)
    mass = np.trapezoid(weight, z) + 970e3
    centre = (np.trapezoid(weight * z, z) + moment) / mass
    wet = np.where(z <= draft, np.pi / 4 * outer**2, 0.0)
    volume = np.trapezoid(wet, z)
    assert mass == pytest.approx(1025 * volume, rel=1e-4)
    assert centre == pytest.approx(float(state["centre_of_mass"]), rel=1e-4)
    metacentre = np.trapezoid(wet * z, z) / volume + np.pi / 64 * D**4 / volume
    assert metacentre - centre == pytest.approx(float(state["metacentric_height"]), rel=2e-3)
    assert draft == pytest.approx(62.0, abs=1e-3)
    assert float(state["centre_of_mass"]) == pytest.approx(0.447 * 45, abs=1e-3)
    assert float(state["heave_period"]) == pytest.approx(28.5, rel=0.01)


def test_the_same_equations_for_other_unknowns(spar):
    """Period, GM, heel and draft give four sizes, and these sizes give them back."""
    targets = {"draft": 62.0, "heave_period": 28.5, "metacentric_height": 2.4, "heel": "17 deg"}
    free = ["solid_ballast", "column_diameter", "plate_diameter", "base_diameter"]
    found = spar.equilibrium(free=free, targets=targets)
    back = spar.equilibrium({path: found.parameters[path] for path in free})
    for name, value in (("draft", 62.0), ("heave_period", 28.5), ("metacentric_height", 2.4), ("heel", 17.0)):
        assert float(back[name]) == pytest.approx(value, rel=1e-7)
    # and the other way round: the ballast for a draft, and the draft for this ballast
    ballast = spar.equilibrium(free=["solid_ballast"], targets={"draft": 60.0}).parameters["solid_ballast"]
    assert float(spar.equilibrium({"solid_ballast": ballast})["draft"]) == pytest.approx(60.0, rel=1e-9)


def test_what_a_flotation_cylinder_must_be(spar):
    """It bears the set where its capacity is 1: rho A h is the mass of the set; printed: 5.76 m for 800 t."""
    found = spar.equilibrium({"spar.set_mass": 8e5}, free=["flotation_diameter"], targets={"flotation_capacity": 1.0})
    assert float(found.parameters["flotation_diameter"]) == pytest.approx(5.76, abs=0.005)


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"solid_ballast": "20000 t"}, "it sinks"),
        ({"spar.water_ballast": 2e7}, "it sinks"),
        ({"spar.concrete_density": 900.0, "solid_ballast": 0.0, "spar.set_mass": 0.0}, "ends below the column"),
    ],
)
def test_what_is_not_valid_is_refused(spar, parameters, words):
    with pytest.raises(SimulationError, match=words):
        spar.equilibrium(parameters)


def test_a_period_that_there_is_not_is_a_sentence(spar):
    """Upside heavy at the start: no period in pitch from which a search could begin."""
    with pytest.raises(SimulationError, match="is not a number"):
        spar.equilibrium({"solid_ballast": "100 t"}, free=["column_diameter"], targets={"pitch_period": 50.0})
