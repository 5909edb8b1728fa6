"""The MIT/NREL tension leg platform, against its OpenFAST input files and what is published of it.

[deck] OpenFAST/r-test, 5MW_TLP_DLL_WTurb_WavesIrr_WavesMulti: ElastoDyn, HydroDyn, MoorDyn files and MAP++ summary.
[fast] the linear tendons of the same platform in the source of FAST 8 (HydroDyn, UserLine): stiffness and pull.
Natural frequencies follow from these by closed forms. Those that are quoted of D. Matha, NREL/SR-500-45891 (2010), are
surge 0.0165, heave 0.4375, pitch 0.223 and yaw 0.097 Hz; the report itself was not at hand.
"""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Fixed, World
from fowtlib.components.mooring import Tendon
from fowtlib.language import Assembly
from fowtlib.language.errors import SimulationError
from fowtlib.solving.modes import natural_modes

STILL = {"sea.spectrum": "still", "wind.kind": "none"}
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@pytest.fixture(scope="module")
def plant():
    return fw.load("tlp_nrel5mw_rigid", set=STILL).compile()


@pytest.fixture(scope="module")
def modes(plant):
    return named_modes(plant)


def named_modes(plant):
    """Frequencies [Hz] by motion of the platform."""
    found = natural_modes(plant, plant.equilibrium())
    return {name: mode.frequency for name in MOTIONS for mode in found
            if mode.motion and mode.oscillates and mode.name.partition(",")[0] == f"platform {name}"}  # fmt: skip


def test_mass_and_inertia():
    """Mass, centre and inertias of [deck], 8,600,410 kg at -40.612 m, 571.624e6 and 361.408e6 kg m^2.

    The description has round numbers, as many as these are: walls of 15 mm, 5 m of freeboard, 12.6 m of concrete of
    2562.5 kg/m^3.
    """
    hull = fw.load("tlp_nrel5mw_rigid").root.platform.hull.hull()
    assert hull.mass.mass == pytest.approx(8600410, rel=2e-5)
    assert hull.mass.centre == pytest.approx([0, 0, -40.612], abs=1e-3)
    assert np.diag(hull.mass.inertia) == pytest.approx([571.624e6, 571.624e6, 361.408e6], rel=5e-5)
    assert hull.buoyancy.volume == pytest.approx(12179.6, rel=6e-4)  # of panels, which lie within the round column


def test_pull_of_the_tendons_at_the_drawn_draft(plant):
    """[deck] 3833.3 kN at the platform and 3680.0 kN at the anchor of each tendon, [fast] 30.69 MN of all."""
    state = plant.initial_state({"platform.motion.heave_start": 0.0})
    assert state["platform.tendons.tendon_4.tension"] == pytest.approx(3833.3e3, rel=5e-4)
    assert state["platform.tendons.tendon_4.anchor_tension"] == pytest.approx(3680.0e3, rel=5e-4)
    pull = sum(state[f"platform.tendons.tendon_{k}.tension"] for k in range(1, 9))
    assert pull == pytest.approx(30.69e6, rel=2e-3)


def test_stiffness_of_the_tendons():
    """[fast] 197,700 N/m across, 79.09e6 N/m along, 3.075e10 and 1.441e8 N m/rad, -9.468e6 N m/m of surge on pitch."""
    tendon = fw.load("tlp_nrel5mw_rigid").root.platform.tendons.tendon_1
    numbers = {name: tendon.parameter_value(name) for name in
               ("length", "axial_stiffness", "mass_per_length", "diameter", "damping")}  # fmt: skip
    points = 27 * np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    model = Assembly("tendons")
    model.world = World(water_depth=200.0)
    for k, (x, y) in enumerate(points):
        end = model.add(f"end_{k}", Fixed(r=(x, y, -47.89)))
        line = model.add(f"line_{k}", Tendon(anchor_position=(x, y, -200), **numbers))
        model.connect(end.frame, line.fairlead)
    plant = fw.load(model).compile()

    def load(surge=0.0, heave=0.0, pitch=0.0, yaw=0.0):
        places = {}
        for k, (x, y) in enumerate(points):
            (c, s), (cy, sy) = (np.cos(pitch), np.sin(pitch)), (np.cos(yaw), np.sin(yaw))
            px, py, pz = cy * x - sy * y, sy * x + cy * y, -47.89
            places[f"end_{k}.r"] = (c * px + s * pz + surge, py, -s * px + c * pz + heave)
        state = plant.initial_state(places)
        frame = np.array([surge, 0, heave])
        pulls = [(np.array(places[f"end_{k}.r"]) - frame, -np.ravel(state[f"line_{k}.fairlead.f"])) for k in range(4)]
        return 2 * np.concatenate([sum(f for _, f in pulls), sum(np.cross(r, f) for r, f in pulls)])

    def slope(**motion):
        ((name, step),) = motion.items()
        return -(load(**{name: step}) - load(**{name: -step})) / (2 * step)

    surge, heave, pitch, yaw = slope(surge=1e-2), slope(heave=1e-3), slope(pitch=1e-5), slope(yaw=1e-3)
    assert surge[0] == pytest.approx(197700, rel=2e-3) and surge[4] == pytest.approx(-9.468e6, rel=2e-3)
    assert heave[2] == pytest.approx(79.09e6, rel=2e-3)
    assert pitch[4] == pytest.approx(3.075e10, rel=5e-3)
    assert yaw[5] == pytest.approx(1.441e8, rel=2e-3)


def test_frequencies(modes):
    """Closed forms of [fast] and [deck]; pitch is that of this model, for the tower bends in what is published."""
    mass, density = 9297870.0, 1025.0  # of the platform, tower, nacelle, hub and blades of [deck]
    ball = density * 2 / 3 * np.pi * 9.0**3  # the axial added mass that [deck] gives the bottom
    heave = np.sqrt((79.09e6 + density * 9.81 * np.pi * 81) / (mass + ball)) / (2 * np.pi)
    assert modes["heave"] == pytest.approx(heave, rel=3e-3)
    turning = 361.408e6 + 2.607890e6 + 3 * 11.776e6 / 2  # platform and nacelle about their axes, rotor across its shaft
    assert modes["yaw"] == pytest.approx(np.sqrt(1.441e8 / turning) / (2 * np.pi), rel=0.02)
    within = [np.sqrt(197700 / (mass + share * density * 12179.6)) / (2 * np.pi) for share in (1.0, 0.85)]
    assert within[0] < modes["surge"] < within[1]  # added mass of 1, that of a long cylinder, and of 0.85
    assert modes["sway"] == pytest.approx(modes["surge"], rel=1e-3)
    assert modes["pitch"] == pytest.approx(0.288, rel=0.01)


@pytest.fixture(scope="module")
def flexible():
    """The flexible model with stiff blades."""
    return fw.load("tlp_nrel5mw", set={**STILL, "blade_hinges": 0}).compile()


def test_frequencies_with_the_flexible_tower(flexible, modes):
    """Those quoted: heave 0.4375, pitch and roll 0.223, yaw 0.097, surge 0.0165 Hz.

    The bending takes a quarter off the frequency of pitch with a rigid tower: 0.221 Hz. Surge is 4.3 % lower than
    quoted, docs/floaters.md.
    """
    found = named_modes(flexible)
    assert found["heave"] == pytest.approx(0.4375, rel=2e-3)
    assert found["pitch"] == pytest.approx(0.223, rel=0.015) and found["roll"] == pytest.approx(0.223, rel=0.015)
    assert found["yaw"] == pytest.approx(0.097, rel=0.015)
    assert found["surge"] == pytest.approx(0.0165, rel=0.05)
    assert found["pitch"] < 0.8 * modes["pitch"]


def test_the_flexible_model_rests_as_the_rigid_one(flexible, plant):
    """The same mass, and every result of the other flexible turbines but one: it has four tensions."""
    one, other = flexible.equilibrium(), plant.equilibrium()
    assert one["platform.motion.heave"] == pytest.approx(other["platform.motion.heave"], abs=1e-4)
    assert set(flexible.outputs) - set(fw.load("oc3_spar").outputs) == {"fairlead_tension_4"}
    assert set(fw.load("oc3_spar").outputs) < set(flexible.outputs)


def test_draft_gives_the_length_of_the_tendons(plant):
    """The buoyancy of the column is 2 % larger than the pull of the tendons of [deck] takes: it rises by that."""
    heave = plant.equilibrium()["platform.motion.heave"]
    surplus = 12186.5 * 1025 * 9.80665 - 9297870 * 9.80665 - 30.66e6
    assert heave == pytest.approx(surplus / (79.09e6 + 2.56e6), rel=0.05)
    state = plant.equilibrium(free=["platform.tendon_length"], targets={"heave": 0.0})
    assert state.parameters["platform.tendon_length"] == pytest.approx(151.73 - heave * 81.65 / 79.09, abs=1e-3)
    assert state["platform.tendons.tendon_1.tension"] > 3833.3e3


def test_tendons_are_slack_with_too_much_concrete(plant):
    with pytest.raises(SimulationError, match=r"platform.tendons.tendon_\d: the tendon is slack at rest"):
        plant.equilibrium({"platform.concrete_height": 17.5})
