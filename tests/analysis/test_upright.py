"""Whether the whole of a floating model stays upright at rest: boxes by closed forms, a real platform, moored ones."""

from __future__ import annotations

import math
import re
import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.upright import facts_of, metacentre, unstable_motion, upright_faults
from fowtlib.cli import main
from fowtlib.components.environment import World
from fowtlib.components.hydro import Hydrostatics
from fowtlib.components.mechanics import FixedTranslation, FreeMotion, PointMass, RigidBody
from fowtlib.components.mooring import Tendon, YawSpring

STILL = {"wind.kind": "none", "sea.spectrum": "still"}
RHO, G = 1025.0, 9.80665
LENGTH, WIDTH, DRAFT, MASTHEAD = 40.0, 20.0, 10.0, 60.0
MASS = RHO * LENGTH * WIDTH * DRAFT
INERTIA = np.diag([3e9, 5e9, 7e9])


def barge(top: float, *, low: float = 0.0, waterplane: float = 1.0, pull: float = 0.0) -> fw.Assembly:
    """A box that floats, `top` [kg] of its mass on a mast, the rest with its centre `low` [m] below the water level.

    waterplane: factor on C33. pull [N]: of four tendons at the corners of its bottom, its weight less by that.
    """
    rho_g = RHO * G
    stiffness = np.diag([0, 0, waterplane * LENGTH * WIDTH, LENGTH * WIDTH**3 / 12, WIDTH * LENGTH**3 / 12, 0]) * rho_g
    model = fw.Assembly("barge")
    model.world, model.motion = World(water_depth=60.0), FreeMotion()
    model.hull = RigidBody(mass=MASS - top - pull / G, r_cm=(0, 0, -low), inertia=INERTIA.tolist())
    model.water = Hydrostatics(volume=LENGTH * WIDTH * DRAFT, centre_of_buoyancy=(0, 0, -DRAFT / 2),
                               stiffness=stiffness.tolist())  # fmt: skip
    model.mast, model.turbine = FixedTranslation(r=(0, 0, MASTHEAD)), PointMass(mass=top)
    model.station = YawSpring(stiffness=1e8)
    for frame in (model.hull.frame_a, model.water.frame, model.mast.frame_a, model.station.frame):
        model.connect(model.motion.frame_b, frame)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.mast.frame_b, model.turbine.frame_a)
    for k, (x, y) in enumerate([(20, 10), (-20, 10), (-20, -10), (20, -10)] if pull else []):
        corner = model.add(f"corner_{k}", FixedTranslation(r=(x, y, -DRAFT)))
        line = model.add(f"tendon_{k}", Tendon(anchor_position=(x, y, -60), length=50.0, pretension=pull / 4,
                                               axial_stiffness=2e9, weight_per_length=0.0))  # fmt: skip
        model.connect(model.motion.frame_b, corner.frame_a)
        model.connect(corner.frame_b, line.fairlead)
    return model


def at_rest(model):
    plant = fw.load(model).compile()
    return plant, plant.equilibrium(hold={"motion.surge": 0.0, "motion.sway": 0.0})


def height_of(top: float) -> float:
    """Of the barge in roll: I / V + z_B - z_G."""
    return WIDTH**2 / 12 / DRAFT - DRAFT / 2 - top * MASTHEAD / MASS


def test_a_top_that_is_too_heavy_is_named_with_the_height_and_how_fast_it_leans():
    top = 3.4e5
    assert height_of(top) == pytest.approx(-4.15, abs=0.02)
    plant, state = at_rest(barge(top))
    of = metacentre(facts_of(plant.root), state)
    assert of.height == pytest.approx(height_of(top), rel=1e-9) and of.leans == "in roll"
    assert of.centre_of_mass_z == pytest.approx(top * MASTHEAD / MASS)
    assert of.z == pytest.approx(WIDTH**2 / 12 / DRAFT - DRAFT / 2)
    path, motion, growth = unstable_motion(plant, state)
    # roll about the frame, sway free: the mast is carried by both
    turning = INERTIA[0, 0] + top * MASTHEAD**2 - (top * MASTHEAD) ** 2 / MASS
    assert (path, motion) == ("motion", "roll")
    assert growth == pytest.approx(math.sqrt(-MASS * G * height_of(top) / turning), rel=1e-6)
    (text,) = upright_faults(plant, state)
    assert "it leans over in roll" in text and "is -4.1" in text and f"every {math.log(2) / growth:.3g} s" in text


def test_a_barge_that_is_stable_is_not_told_of():
    plant, state = at_rest(barge(1000.0, low=3.0))
    assert metacentre(facts_of(plant.root), state).height == pytest.approx(height_of(1000.0) + 3.0, abs=1e-3)
    assert list(upright_faults(plant, state)) == []


def test_tendons_hold_what_water_alone_does_not():
    """The same heavy top: with tendons of half of the weight it stands, its metacentric height is negative still."""
    plant, state = at_rest(barge(3.4e5, pull=0.5 * MASS * G))
    assert metacentre(facts_of(plant.root), state).height < 0
    assert unstable_motion(plant, state) is None and list(upright_faults(plant, state)) == []


def test_a_motion_of_another_kind_that_nothing_holds():
    """A waterplane that pushes out what comes up: it moves off in heave, which no metacentric height says."""
    (text,) = upright_faults(*at_rest(barge(1000.0, low=4.0, waterplane=-0.1)))
    assert "it moves off in heave" in text and "metacentric" not in text


@pytest.mark.parametrize("command", ["equilibrium", "sheet", "eigen"])
def test_a_semisubmersible_under_a_tower_that_is_too_heavy(capsys, command):
    """The hull alone is stable by 10.7 m; with a tower of 4,000 t, its centre 43 m up, the whole is not."""
    assert main([command, "oc4_semi_rigid", "--wind", "none", "--set", "tower.mass=4000000 kg"]) == 0
    out, err = capsys.readouterr()
    assert "platform.motion: it cannot float upright: with all that holds it, moorings too, it leans over" in err
    height = float(re.search(r"without moorings, is (-[\d.]+) m", err).group(1))
    assert -10 < height < 0
    if command == "sheet":
        line = next(line for line in out.splitlines() if "metacentric height" in line)
        assert float(line.split()[-2]) == pytest.approx(height, rel=5e-3)


@pytest.mark.parametrize("name", ["oc3_spar_rigid", "oc4_semi_rigid", "tlp_two_rotor_rigid", "tlp_nrel5mw_rigid",
                                  "oo_star_rigid", "two_rotor_spar_rigid", "volturnus_iea15_rigid"])  # fmt: skip
def test_no_shipped_model_is_told_of(name):
    plant = fw.load(name, set=STILL).compile()
    assert list(upright_faults(plant, plant.equilibrium())) == []


def test_the_sheet_of_a_platform_that_stands_says_its_metacentric_height():
    """OC4: the report's numbers, waterplane and centres of the whole, by hand."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sheet = fw.model_sheet(fw.load("oc4_semi_rigid", set=STILL))
    lift = RHO * G * sheet["displaced volume"]
    arm = sheet["centre of mass z"] - sheet["heave at rest"]
    by_hand = (sheet["C44"] - sheet["weight"] * arm) / lift
    assert sheet["metacentric height without moorings"] == pytest.approx(by_hand, rel=1e-6)
