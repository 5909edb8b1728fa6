"""Floaters that float at any draft and attitude: at rest as the linear ones, capsizing, lying down, with ballast."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import RegularWaves, Sea, World
from fowtlib.components.hydro.linear_loads import Hydrostatics, LinearDamping
from fowtlib.components.mechanics import FreeMotion, Prismatic, RigidBody
from fowtlib.components.platform import (
    Ballast,
    CircularMember,
    Floater,
    LumpedMass,
    MemberHydrostatics,
    RectangularMember,
)
from fowtlib.language.errors import ParameterError
from fowtlib.modelfile import dump

RHO, G = 1025.0, 9.80665
PLATFORMS = Path(__file__).parents[2] / "models" / "platforms"


def afloat(*members, body=None, damping=None, sea=None, hydrostatics=None, motion=None, **given):
    """Members that float freely; body: mass, place and inertia of what they carry."""
    whole = fw.Assembly("afloat")
    whole.world = World(water_depth=200.0, water_density=RHO)
    whole.sea = sea or Sea()
    whole.motion = motion or FreeMotion()
    whole.floater = Floater(**given)
    for k, member in enumerate(members):
        whole.floater.add(f"member_{k + 1}", member)
    whole.floater.hydrostatics = hydrostatics or MemberHydrostatics()
    whole.connect(whole.world.frame, whole.motion.frame_a)
    whole.connect(whole.motion.frame_b, whole.floater.frame)
    if body is not None:
        mass, place, inertia = body
        whole.body = RigidBody(mass=mass, r_cm=place, inertia=np.diag(inertia).tolist())
        whole.connect(whole.floater.frame, whole.body.frame_a)
    if damping is not None:
        whole.damping = LinearDamping(translation=damping[:3], rotation=damping[3:])
        whole.connect(whole.floater.frame, whole.damping.frame)
    return whole


def shell(**given):
    """A member whose wall weighs nothing."""
    return {"wall_thickness": 0.0, "density": 0.0, **given}


def barge(length=20.0, width=6.0, height=10.0, low=-5.0):
    middle = low + height / 2
    return RectangularMember(**shell(start=(-length / 2, 0, middle), end=(length / 2, 0, middle), widths=width,
                                     heights=height))  # fmt: skip


def oc3(hydrostatics=None):
    """Hull of the OC3 spar: J. Jonkman, NREL/TP-500-47535 (2010), table 5-1, 5-2."""
    spar = CircularMember(start=(0, 0, -120), end=(0, 0, 10), diameters=(9.4, 9.4, 6.5, 6.5),
                          stations=(0, 108 / 130, 116 / 130, 1), wall_thickness=0.0, density=0.0)  # fmt: skip
    body = 7466330.0, (0, 0, -89.9155), (4229230000.0, 4229230000.0, 164230000.0)
    whole = afloat(spar, body=body, hydrostatics=hydrostatics, held_upright=True)
    return whole, whole.floater


def oc4(hydrostatics=None):
    whole = fw.Assembly("semi")
    whole.world, whole.sea = World(water_depth=200.0), Sea()
    whole.platform = fw.load(PLATFORMS / "oc4_semi_unmoored.yaml").root
    whole.platform.hull.hydrostatics = hydrostatics or MemberHydrostatics()
    whole.connect(whole.world.frame, whole.platform.world)
    return whole, whole.platform.hull


def linear_part(floater):
    """The linear hydrostatics that a Floater makes of its members."""
    known = floater.hull().buoyancy
    stiffness = RHO * G * known.waterplane
    return Hydrostatics(volume=known.volume, centre_of_buoyancy=known.centre, stiffness=stiffness,
                        reference_density=RHO)  # fmt: skip


# --- at rest ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [oc3, oc4])
def test_small_motions_are_those_of_the_linear_hydrostatics(make):
    """The whole linear model at rest, with weight and inertia, within 1e-6 of that with the stiffness."""
    exact, floater = make(MemberHydrostatics(transition=1e-3))
    found = []
    for model in (exact, make(linear_part(floater))[0]):
        plant = fw.load(model).compile()
        found.append(np.asarray(plant.linearize(plant.initial_state()).A))
    scale = np.abs(found[1]).max(axis=1, keepdims=True)
    assert (np.abs(found[0] - found[1]) <= 1e-6 * scale + 1e-12).all()
    assert np.abs(found[0] - found[1]).max() > 0  # two models


@pytest.mark.parametrize("make", [oc3, oc4])
def test_what_it_says_of_itself_is_what_the_linear_part_says(make):
    exact, floater = make(MemberHydrostatics(transition=1e-3))
    told = {fact.name: fact for fact in floater.hydrostatics.facts()}
    known = floater.hull().buoyancy
    assert float(told["displaced volume"].value) == pytest.approx(known.volume, rel=1e-9)
    assert told["centre of buoyancy"].value == pytest.approx(known.centre, abs=1e-6)
    C = known.stiffness(RHO, G)
    assert told["C"].matrix == pytest.approx(C, rel=1e-6, abs=1e-9 * np.abs(C).max())


# --- large motions ---------------------------------------------------------------------------------------------------


def capsizing(damping):
    """A box of half the density of water with its mass 2 m above its middle: GM = 0.6 - 4.5 = -3.9 m."""
    box = barge()
    box.add("load", LumpedMass(mass=0.5 * RHO * 1200, place=(0, 0, 2.0)))
    return afloat(box, body=(0.0, (0, 0, 0), (2e7, 2e7, 2e7)), damping=damping, motion=FreeMotion(roll_start=0.02))


PATHS = ("motion.roll", "motion.heave", "motion.sway", "floater.hydrostatics.energy", "motion.angle_rates",
         "motion.velocity", "floater.hydrostatics.volume")  # fmt: skip


def total(result, mass, arm, inertia):
    """Energy [J] of a hull that moves in the plane y-z: weight at `arm` above the frame, inertia about its centre."""
    roll, heave = result["motion.roll"], result["motion.heave"]
    rate, velocity = result["motion.angle_rates"][:, 0], result["motion.velocity"]
    v_y, v_z = velocity[:, 1] - arm * np.cos(roll) * rate, velocity[:, 2] - arm * np.sin(roll) * rate
    kinetic = mass / 2 * (v_y**2 + v_z**2) + inertia / 2 * rate**2
    return kinetic + mass * G * (heave + arm * np.cos(roll)) + result["floater.hydrostatics.energy"]


def numbers(result):
    return {path: np.asarray(result[path], dtype=float) for path in PATHS}


def test_a_box_that_capsizes_keeps_its_energy():
    """Through the deck edge, past 90 deg and back: within 1e-6 of what goes from weight to motion."""
    plant = fw.load(capsizing(None)).compile()
    found = numbers(plant.simulate(60.0, 0.05, tolerance=1e-9, outputs=PATHS))
    energy = total(found, 0.5 * RHO * 1200, 2.0, 2e7)
    assert found["motion.roll"].max() > math.pi  # it has gone over
    kinetic = energy - energy[0]
    exchanged = np.ptp(found["floater.hydrostatics.energy"])
    assert np.abs(kinetic).max() < 1e-6 * exchanged


def test_a_box_that_capsizes_comes_to_rest_upside_down():
    """What its damping took is what weight and buoyancy gave; at rest its mass hangs 2 m below its middle."""
    damping = (2e5, 2e5, 2e5, 4e6, 4e6, 4e6)
    plant = fw.load(capsizing(damping)).compile()
    result = plant.simulate(400.0, 0.05, tolerance=1e-8, outputs=PATHS)
    found = numbers(result)
    assert found["motion.roll"][-1] == pytest.approx(math.pi, abs=1e-5)
    assert found["motion.heave"][-1] == pytest.approx(0, abs=1e-5)
    assert found["floater.hydrostatics.volume"][-1] == pytest.approx(600, rel=1e-6)
    energy, time = total(found, 0.5 * RHO * 1200, 2.0, 2e7), np.asarray(result.time)
    power = 4e6 * found["motion.angle_rates"][:, 0] ** 2 + 2e5 * (found["motion.velocity"][:, 1:] ** 2).sum(axis=1)
    lost = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])
    assert lost[-1] > 1e6  # it fell over
    assert np.abs(energy + lost - energy[0]).max() < 2e-4 * lost[-1]
    assert energy[0] - energy[-1] == pytest.approx(0.5 * RHO * 1200 * G * 4.0, rel=1e-3)  # its mass is 4 m lower


@pytest.mark.parametrize("solver", ["fixed", "idas"])
def test_a_square_log_floats_on_its_edge(solver):
    """Of half the density of water a square section turns by 45 deg; with a quarter, to 26.565 deg, tan = 1/2.

    Source: E.N. Gilbert, How things float, American Mathematical Monthly 98 (1991) 201-216.
    """
    for share, angle in ((0.5, 45.0), (0.25, math.degrees(math.atan(0.5)))):
        log = barge(length=10.0, width=1.0, height=1.0, low=-0.5)
        log.add("load", LumpedMass(mass=share * RHO * 10, place=(0, 0, 0)))
        inertia = share * RHO * 10 / 6
        body = (0.0, (0, 0, 0), (inertia, 50 * inertia, 50 * inertia))
        model = afloat(log, body=body, damping=(2e3, 2e3, 2e3, 300.0, 1e4, 1e4), motion=FreeMotion(roll_start=0.1),
                       hydrostatics=MemberHydrostatics(transition=1e-4))  # fmt: skip
        result = fw.load(model).compile().simulate(150.0, 1.0, solver=solver)
        turned = math.degrees(float(result["motion.roll"][-1]))
        assert min(turned % 90, 90 - turned % 90) == pytest.approx(min(angle, 90 - angle), abs=0.05)


def test_a_log_with_its_load_at_one_end_stands_up_from_lying():
    """A tube of 20 m, let go at 80 deg of roll with its mass near the foot: it comes upright."""
    tube = CircularMember(**shell(start=(0, 0, -10), end=(0, 0, 10), diameters=2.0))
    mass = RHO * math.pi * 12
    tube.add("load", LumpedMass(mass=mass, place=(0, 0, -6)))
    model = afloat(tube, body=(0.0, (0, 0, 0), (mass * 20, mass * 20, mass)), damping=(2e4, 2e4, 2e4, 1e6, 1e6, 1e5),
                   motion=FreeMotion(roll_start=1.4, heave_start=-1.0))  # fmt: skip
    result = fw.load(model).compile().simulate(200.0, 1.0)
    assert float(result["motion.roll"][-1]) == pytest.approx(0, abs=1e-4)
    assert float(result["motion.heave"][-1]) == pytest.approx(-2.0, abs=1e-3)  # 12 of 20 m are wet


# --- ballast ---------------------------------------------------------------------------------------------------------


def ballasted():
    column = CircularMember(start=(0, 0, -20), end=(0, 0, 20), diameters=8.0, wall_thickness=0.04)
    column.add("water", Ballast(level="-12 m"))
    column.add("iron", LumpedMass(mass="300 t", place=(0, 0, -20)))
    return afloat(column, motion=Prismatic(n=(0, 0, 1)))


def test_draft_by_ballast_and_ballast_by_draft_are_the_same_equations():
    """The equilibrium at levels of ballast; then the level freed, and the draft wanted."""
    plant = fw.load(ballasted()).compile()
    for level in (-14.0, -8.0):
        state = plant.equilibrium({"floater.member_1.water.level": level})
        draft = float(state["floater.hydrostatics.draft"]) + 20
        weight = plant.binding({"floater.member_1.water.level": level}).tree
        with weight() as root:
            mass = root.floater.hull().mass.mass
        assert draft == pytest.approx(mass / (RHO * math.pi * 16), rel=1e-5)
        back = plant.equilibrium(free={"floater.member_1.water.level": -11.0},
                                 targets={"floater.hydrostatics.draft": draft - 20})  # fmt: skip
        assert float(back.parameters["floater.member_1.water.level"]) == pytest.approx(level, abs=1e-6)


def test_a_diameter_is_found_for_a_draft():
    """The surface of a hull is data of a run; a search that moves it takes differences."""
    plant = fw.load(ballasted()).compile()
    path = "floater.member_1.diameters"
    found = plant.equilibrium(free={path: 8.0}, targets={"floater.hydrostatics.draft": -10.0})
    diameter = float(found.parameters[path])
    steel = 7850 * math.pi * (diameter - 0.04) * 0.04 * 40
    water = RHO * math.pi / 4 * (diameter - 0.08) ** 2 * 8
    assert RHO * math.pi / 4 * diameter**2 * 10 == pytest.approx(steel + water + 300e3, rel=1e-5)
    again = plant.equilibrium({path: diameter})
    assert float(again["floater.hydrostatics.draft"]) == pytest.approx(-10.0, abs=1e-6)


def test_derivatives_by_the_geometry_are_right_or_refused():
    """Against differences; what moves the surface has none in the mean, what leaves it as it is has."""
    plant = fw.load(ballasted()).compile()
    member, draft = "floater.member_1", "floater.hydrostatics.draft"

    def difference(values, path, at, h):
        return (values({path: at + h}) - values({path: at - h})) / (2 * h)

    def mean(parameters):
        return float(plant.equilibrium(parameters)[draft])

    def later(parameters):
        return plant.simulate(1.0, parameters=parameters, solver="fixed", tolerance=1e-10).array(draft)[-1]

    for path in (f"{member}.diameters", f"{member}.start[2]", "floater.raised"):
        for result in (f"mean {draft}", "frequency motion.s"):
            refused = rf"by {re.escape(path)}: floater\.hydrostatics\.surface is computed .* no derivative by it"
            with pytest.raises(ParameterError, match=refused):
                fw.gradient(plant, result, [path])
    for path, at, h in ((f"{member}.wall_thickness", 0.04, 1e-4), (f"{member}.water.level", -12.0, 1e-3)):
        found = fw.gradient(plant, f"mean {draft}", [path])[f"mean {draft}", path]
        assert found == pytest.approx(difference(mean, path, at, h), rel=1e-5)
    for path, at, h in ((f"{member}.diameters", 8.0, 1e-3), (f"{member}.wall_thickness", 0.04, 1e-5)):
        found = fw.sensitivities(plant, [path], [draft], t_end=1.0, tolerance=1e-10).derivatives[-1, 0, 0]
        assert found == pytest.approx(difference(later, path, at, h), rel=1e-5)


# --- waves -----------------------------------------------------------------------------------------------------------


def held(waves, under):
    tube = CircularMember(**shell(start=(0, 0, -2), end=(0, 0, 3), diameters=1.0))
    tube.add("load", LumpedMass(mass=1000.0, place=(0, 0, -2)))
    still = Prismatic(n=(0, 0, 1))
    return afloat(tube, sea=waves, hydrostatics=MemberHydrostatics(under_waves=under), motion=still,
                  damping=(0.0, 0.0, 2e3, 0.0, 0.0, 0.0))  # fmt: skip


def test_a_small_float_rides_a_long_wave_with_the_surface_of_the_sea():
    """Heave over elevation is k / (k - omega^2 m + i omega c), k = rho g A; without `under_waves` nothing moves."""
    omega, k = 2 * math.pi / 20, RHO * G * math.pi / 4
    ratio = k / (k - omega**2 * 1000 + 1j * omega * 2e3)
    for under, wanted in ((True, ratio), (False, 0.0)):
        model = held(RegularWaves(wave_height=2.0, wave_period=20.0), under)
        result = fw.load(model).compile().simulate(80.0, 0.5, start="equilibrium")
        height, time = np.asarray(result["floater.frame.r"])[:, 2], np.asarray(result.time)
        rest = 1000 / (RHO * math.pi / 4)  # its draft; the frame is 2 m above its foot
        moved = (height - (2 - rest))[-80:]
        assert moved == pytest.approx(np.real(wanted * np.exp(1j * omega * time[-80:])), abs=2e-4)


def test_the_pressure_of_the_waves_counts_once():
    tube = CircularMember(**shell(start=(0, 0, -2), end=(0, 0, 3), diameters=1.0), added_mass_coefficient=1.0)
    model = afloat(tube, body=(1e3, (0, 0, -1), (1e3, 1e3, 1e3)), hydrostatics=MemberHydrostatics(under_waves=True))
    with pytest.raises(ParameterError, match="member_1 has the pressure of the waves already"):
        fw.load(model).compile()


def test_it_is_a_part_of_a_floater_alone():
    whole = fw.Assembly("no floater")
    whole.world, whole.motion = World(), FreeMotion()
    whole.body, whole.water = RigidBody(mass=1.0, inertia=np.eye(3).tolist()), MemberHydrostatics()
    whole.connect(whole.world.frame, whole.motion.frame_a)
    whole.connect(whole.motion.frame_b, whole.body.frame_a)
    whole.connect(whole.body.frame_a, whole.water.frame)
    with pytest.raises(ParameterError, match="water is not the hydrostatics of a Floater"):
        fw.load(whole).compile().initial_state()


def test_it_survives_being_written_to_a_file(tmp_path):
    model = capsizing((2e5, 2e5, 2e5, 4e6, 4e6, 4e6))
    model.floater.hydrostatics.transition = "5 mm"
    path = tmp_path / "box.yaml"
    path.write_text(dump(fw.load(model)))
    again = fw.load(path)
    assert type(again.root.floater.hydrostatics) is MemberHydrostatics
    first, second = (one.compile().initial_state()["floater.hydrostatics.volume"] for one in (fw.load(model), again))
    assert float(first) == pytest.approx(float(second), rel=1e-12)
