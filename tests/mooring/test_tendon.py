"""Tendon: stiffness along and across, set-down, periods of a mass on it, its weight against the catenary, slackness."""

import re

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import Fixed, FreeMotion, RigidBody, World, WorldForce
from fowtlib.components.mooring import Tendon
from fowtlib.components.mooring.catenary import Line, fairlead_tension
from fowtlib.fmi.guards import guarded
from fowtlib.language import Assembly
from fowtlib.language.errors import ModelError, SimulationError

LENGTH, EA, PULL = 150.0, 1.5e9, 4e6


def between(right=(0, 0, -50), left=(0, 0, -200), **tendon):
    model = Assembly("tendon between two points")
    model.world = World(water_depth=200)
    model.left, model.right = Fixed(r=left), Fixed(r=right)
    model.line = Tendon(**{"length": LENGTH, "axial_stiffness": EA, "weight_per_length": 0.0, **tendon})
    model.connect(model.left.frame, model.line.anchor)
    model.connect(model.right.frame, model.line.fairlead)
    return fw.load(model).compile()


def pull(plant, place):
    return -np.ravel(plant.initial_state({"right.r": place})["line.fairlead.f"])


@pytest.mark.parametrize("weight", [0.0, 1000.0, -800.0])
def test_pretension_is_the_tension_at_the_fairlead_of_the_given_length(weight):
    state = between(pretension=PULL, weight_per_length=weight).initial_state()
    unstretched = state["line.unstretched"]
    assert unstretched == pytest.approx(LENGTH / (1 + (PULL - weight * LENGTH / 2) / EA), rel=1e-12)
    elongation = LENGTH - unstretched
    assert state["line.mean_tension"] == pytest.approx(EA * elongation / unstretched, rel=1e-9)
    assert state["line.tension"] == pytest.approx(PULL, rel=1e-3 if weight else 1e-6)  # w of the unstretched length
    assert state["line.tension"] - state["line.anchor_tension"] == pytest.approx(weight * unstretched)
    f = np.ravel(state["line.fairlead.f"]) + np.ravel(state["line.anchor.f"])
    assert f == pytest.approx([0, 0, weight * unstretched], abs=1e-6)


def test_tension_of_the_mit_nrel_tlp():
    """3833.3 kN at the fairlead and 3680.0 kN at the anchor: OpenFAST r-test 5MW_TLP, one of its eight tendons."""
    state = between(right=(0, 0, -47.89), length=151.73, mass_per_length=116.027, diameter=0.127,
                    weight_per_length=None).initial_state()  # fmt: skip
    assert [state["line.tension"], state["line.anchor_tension"]] == pytest.approx([3833.3e3, 3680.0e3], rel=5e-4)


@pytest.mark.parametrize("direction", [(0, 0, 1), (0.3, -0.2, 1), (1, 1, 0.5)])
def test_stiffness_along_and_across(direction):
    along = np.array(direction) / np.linalg.norm(direction)
    plant = between(
        right=(-200 + 200 + LENGTH * along[0], LENGTH * along[1], -200 + LENGTH * along[2]), pretension=PULL
    )
    state = plant.initial_state()
    forces = [f"line.fairlead.f[{i}]" for i in range(3)]
    slopes = plant.linearize(state, inputs=["right.r"], outputs=forces).matrices["D"]
    expected = EA / state["line.unstretched"] * np.outer(along, along)
    expected += PULL / LENGTH * (np.eye(3) - np.outer(along, along))
    assert slopes == pytest.approx(expected, rel=1e-6, abs=1.0)


@pytest.mark.parametrize("offset", [2.0, 8.0, 15.0])
def test_set_down(offset):
    """An inextensible tendon sets its fairlead down by L - sqrt(L^2 - x^2) and pulls back with T x / L."""
    plant = between(pretension=PULL, axial_stiffness=1e13, slack_tension=1.0)
    down = LENGTH - np.sqrt(LENGTH**2 - offset**2)
    force = pull(plant, (offset, 0, -50 - down))
    assert force == pytest.approx([-PULL * offset / LENGTH, 0, -PULL * (LENGTH - down) / LENGTH], rel=1e-5, abs=1)


def platform(count=1, mass=4e6, lift=4e6 * 9.80665 + PULL, weight=0.0, start=0.0, **tendon):
    """A mass that is lifted by a constant force, on tendons below each other in one place."""
    model = Assembly("a mass on tendons")
    model.world = World(water_depth=200)
    model.motion = FreeMotion(heave_start=start)
    model.body = RigidBody(mass=mass, inertia=np.eye(3) * 1e9)
    model.lift, model.force = Constant(value=(0, 0, lift)), WorldForce()
    for i in range(count):
        line = Tendon(length=200.0, axial_stiffness=EA, weight_per_length=weight, anchor_position=(0, 0, -200),
                      **{"pretension": PULL / count, **tendon})  # fmt: skip
        setattr(model, f"tendon_{i + 1}", line)
        model.connect(model.motion.frame_b, line.fairlead)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.lift.y, model.force.force)
    for frame in (model.body.frame_a, model.force.frame):
        model.connect(model.motion.frame_b, frame)
    return model


@pytest.mark.parametrize(("count", "weight"), [(1, 0.0), (2, 0.0), (1, 3000.0)])
def test_periods_of_a_mass_on_tendons(count, weight):
    """Surge sqrt(m L / T) and heave sqrt(m L / EA) of 2 pi s, T the mean tension of all and L their length."""
    plant = fw.load(platform(count, weight=weight)).compile()
    state = plant.equilibrium()
    assert sum(state[f"tendon_{i + 1}.tension"] for i in range(count)) == pytest.approx(PULL, rel=1e-6)
    mean = sum(state[f"tendon_{i + 1}.mean_tension"] for i in range(count))
    length, unstretched = state["tendon_1.distance"], state["tendon_1.unstretched"]
    surge = np.sqrt(mean / length / 4e6) / (2 * np.pi)
    heave = np.sqrt(count * EA / unstretched / 4e6) / (2 * np.pi)
    found = [mode.frequency_hz for mode in plant.linearize(state).modes() if mode.frequency_hz > 1e-6]
    assert found == pytest.approx([surge, surge, heave], rel=1e-5)


@pytest.mark.parametrize("ratio", [0.1, 0.35, 1.0])
def test_what_the_sag_takes_from_the_stiffness_across(ratio):
    """(w L / T)^2 / 12 of it, by the exact catenary of the same ends and mean tension."""
    weight, mean = ratio * PULL / LENGTH, PULL
    exact = Line(LENGTH / (1 + mean / 1e10), weight, 1e10)
    x = 0.01
    H, V = fairlead_tension(x, LENGTH, exact)
    straight = (V - weight * exact.length / 2) / LENGTH
    assert 1 - (H / x) / straight == pytest.approx(ratio**2 / 12, rel=0.1)
    plant = between(pretension=mean + weight * LENGTH / 2, weight_per_length=weight, axial_stiffness=1e10)
    assert -pull(plant, (x, 0, -50))[0] / x == pytest.approx(mean / LENGTH, rel=1e-3)


def test_a_tendon_that_is_heavier_than_its_pull_warns():
    plant = between(pretension=PULL, weight_per_length=0.7 * PULL / LENGTH)
    with pytest.warns(UserWarning, match=r"line: the tendon pulls with 2\.6\d*e\+06 N, less than its weight: it sags"):
        plant.equilibrium({"line.weight_per_length": 0.7 * PULL / LENGTH})


@pytest.mark.parametrize("solver", ["idas", "fixed"])
@pytest.mark.parametrize("weight", [0.0, 2000.0])
def test_slack_is_an_event_with_its_time(solver, weight):
    """A mass let go above its place swings up, and down until the tendon is slack: a cosine until then."""
    start, mean = 0.9, PULL - 200 * weight / 2
    plant = fw.load(platform(weight=weight, start=start, slack_tension=10.0)).compile()
    options = {"step": 0.002} if solver == "fixed" else {"tolerance": 1e-9}
    with pytest.warns(UserWarning, match=r"tendon_1: the tendon went slack at t = 1\.\d+ s"):
        result = plant.simulate(8.0, 0.01, solver=solver, **options,
                                outputs=["motion.heave", "tendon_1.tension", "tendon_1.slack_events",
                                         "tendon_1.first_slack", "tendon_1.mean_tension"])  # fmt: skip
    unstretched = 200 / (1 + mean / EA)
    stiffness = EA / unstretched
    rest = (mean - (mean - 0)) / stiffness  # the lift is what mass and pretension weigh
    omega, slack_at = np.sqrt(stiffness / 4e6), -(mean - weight * unstretched / 2) / stiffness
    expected = np.arccos((slack_at - rest) / (start - rest)) / omega
    first = result["tendon_1.first_slack"].to_numpy()[-1]
    assert first == pytest.approx(expected, rel=2e-4)
    assert result["tendon_1.slack_events"].to_numpy()[-1] >= 2
    tension = result["tendon_1.tension"].to_numpy()
    assert tension.min() >= 0 and tension[np.abs(result.time - first - 0.05).argmin()] < 0.1 * PULL
    slack = result["tendon_1.mean_tension"].to_numpy() < -1e5
    if not weight:
        assert slack.sum() > 50 and tension[slack].max() < 10.0


def test_both_engines_agree_where_a_tendon_goes_slack():
    plant = fw.load(platform(start=0.9)).compile()
    heave = []
    for solver, options in (("idas", {"tolerance": 1e-9}), ("fixed", {"step": 0.002})):
        with pytest.warns(UserWarning, match="went slack"):
            result = plant.simulate(8.0, 0.01, solver=solver, outputs=["motion.heave"], **options)
        heave.append(result["motion.heave"].to_numpy())
    assert heave[1] == pytest.approx(heave[0], abs=2e-2 * np.abs(heave[0]).max())


def test_a_tendon_that_is_slack_from_the_start_says_so():
    with pytest.warns(UserWarning, match=r"tendon_1: the tendon is slack from the start on, by -3\.52e\+06 N"):
        fw.load(platform(start=-1.0)).compile().simulate(0.05, 0.01)


@pytest.mark.parametrize("lift", [3.9e7, 3.5e7])
def test_a_tendon_that_is_slack_at_rest_is_an_error(lift):
    """The mass hangs on a wire, a metre too low for its tendon."""
    model = platform(lift=lift)
    model.up, model.hold = Tendon(length=10, axial_stiffness=1e8, weight_per_length=0), Fixed(r=(0, 0, 9.0))
    model.connect(model.motion.frame_b, model.up.anchor)
    model.connect(model.hold.frame, model.up.fairlead)
    plant = fw.load(model).compile()
    heave = -1 - (4e6 * 9.80665 - lift) / 1e7
    tension = EA * ((200 + heave) / (200 / (1 + PULL / EA)) - 1)
    with pytest.raises(SimulationError, match="tendon_1: the tendon is slack at rest: its least ten") as error:
        plant.equilibrium()
    said = re.search(r"would be (\S+) N", str(error.value))
    assert said and float(said[1]) == pytest.approx(tension, rel=1e-3)
    assert "Give the platform more buoyancy or less ballast" in str(error.value)
    with pytest.warns(UserWarning, match="slack from the start"):  # a run may begin so, and pass through
        plant.simulate(0.05, 0.01, start={"motion.heave": heave})


def test_dimensions_agree():
    assert "nothing wrong" in str(fw.load(platform(2)).check())


def test_an_fmu_has_no_condition_of_an_equilibrium():
    plant = fw.load(platform()).compile()
    levels = [[check.level for check in item.dae.checks] for item in (plant, guarded(plant, plant.binding(), 0.0125))]
    assert levels[0].count("rest") == 1 and "rest" not in levels[1]
    assert [level for level in levels[0] if level != "rest"] == levels[1][: len(levels[0]) - 1]


def test_a_lost_tendon_leaves_the_others_and_is_not_called_slack(recwarn):
    plant = fw.load(platform(2)).compile()
    result = plant.simulate(1.0, 0.1, start=plant.equilibrium(), outputs=["tendon_1.tension", "tendon_2.tension"],
                            events=["tendon_1.loss at 0.5 s"])  # fmt: skip
    assert result["tendon_1.tension"][-1] == 0 < result["tendon_2.tension"][-1]
    assert not [warning for warning in recwarn if "tendon_1" in str(warning.message)]


@pytest.mark.parametrize(
    ("tendon", "message"),
    [
        ({"weight_per_length": None}, "needs its weight once"),
        ({"length": 0.0}, "below its minimum"),
        ({"pretension": -1.0}, "below its minimum"),
    ],
)
def test_mistakes(tendon, message):
    with pytest.raises(ModelError, match=message):
        between(**tendon)
