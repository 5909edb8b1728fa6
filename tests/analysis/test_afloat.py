"""How hulls float, heel and come to rest: closed forms, free surfaces, lost buoyancy, a model basin's spar, stages."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.afloat import Afloat, Liquid
from fowtlib.analysis.afloat_models import afloat, compartment_of
from fowtlib.analysis.masses import placed_bodies
from fowtlib.analysis.righting import righting_curve
from fowtlib.analysis.stages import Stage, construction_stages
from fowtlib.analysis.upright import facts_of, upright_faults
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, PrismaticTank, RoundTank, Tank
from fowtlib.components.mechanics import FreeMotion, RigidBody
from fowtlib.components.platform import (
    Ballast,
    Bulkhead,
    CircularMember,
    Floater,
    LumpedMass,
    MemberHydrostatics,
    MemberShape,
    RectangularMember,
    WettedSurface,
)
from fowtlib.components.platform.union import union
from fowtlib.language import facts
from fowtlib.language.errors import ModelError, ParameterError

RHO = 1025.0
ROLL = math.pi / 2


def box(length, width, height, low=0.0, x=0.0, y=0.0):
    ends = (x - length / 2, y, low + height / 2), (x + length / 2, y, low + height / 2)
    shape = MemberShape("box", *ends, (0.0, float(length)), ((width, height),) * 2, is_round=False)
    return WettedSurface(union((shape,)).triangles(), 1e-4)


def cylinder(diameter, height, low=0.0):
    ends = (0.0, 0.0, low), (0.0, 0.0, low + height)
    shape = MemberShape("cylinder", *ends, (0.0, float(height)), ((diameter, diameter),) * 2)
    return WettedSurface(union((shape,)).triangles(), 1e-4)


def wall_sided(phi, GM, BM):
    """Righting arm of upright walls, until a deck goes under or a bilge comes out."""
    return np.sin(phi) * (GM + BM / 2 * np.tan(phi) ** 2)


# --- righting arms ---------------------------------------------------------------------------------------------------


def test_arms_of_a_box_are_those_of_upright_walls_until_its_deck_goes_under():
    hull = Afloat(box(40, 8, 10, low=-5), 0.5 * RHO * 3200, (0, 0, -2.6))
    phi = np.radians(np.arange(0, 76, 5.0))
    curve = righting_curve(hull, phi, ROLL)
    BM = 8**2 / 12 / 5
    GM = BM - 2.5 + 2.6
    dry = np.tan(phi) < 5 / 4  # the deck edge is 5 m over the water and 4 m off the axis
    assert curve.metacentric_height == pytest.approx(GM, rel=1e-6)
    assert curve.arm[dry] == pytest.approx(wall_sided(phi, GM, BM)[dry], abs=1e-8)
    assert (curve.arm[~dry] < wall_sided(phi, GM, BM)[~dry]).all() and (~dry).sum() > 3
    assert np.abs(curve.trim).max() < 1e-9
    assert curve.area(phi[8]) == pytest.approx(
        hull.potential([0, -math.sin(phi[8]), math.cos(phi[8])]) - hull.potential([0, 0, 1]), rel=1e-4
    )


def test_arms_of_a_cylinder_are_those_of_upright_walls():
    """The moments of the polygon that stands for the circle are 8e-6 too large."""
    hull = Afloat(cylinder(10, 40, low=-20), 0.5 * RHO * math.pi * 1000, (0, 0, -12))
    phi = np.radians(np.arange(0, 61, 5.0))
    curve = righting_curve(hull, phi)
    BM = 10**2 / 16 / 20
    assert curve.arm == pytest.approx(wall_sided(phi, BM - 10 + 12, BM), abs=2e-5 * BM * 4)


def test_a_wide_barge_trims_where_it_heels_askew():
    """Leaning over a corner, a free hull trims towards its weaker side, and its arm is less than held in trim."""
    hull = Afloat(box(40, 10, 6, low=-3), 0.5 * RHO * 2400, (1.0, 0, 0.5))
    phi = np.radians(np.arange(0, 31, 3.0))
    free, held = (righting_curve(hull, phi, math.radians(60), free_to_trim=free) for free in (True, False))
    assert np.abs(free.trim[-1]) > 0.05
    assert np.abs(held.trim).max() == 0
    rest = hull.at_rest()
    assert rest.heel > 0.01 and rest.arm == pytest.approx([0, 0], abs=1e-8)


def test_a_vanishing_angle_and_the_largest_arm():
    """A box with its centre low: past the largest arm it comes to 180 deg, where it would stand on its head."""
    hull = Afloat(box(40, 14, 10, low=-5), 0.5 * RHO * 5600, (0, 0, 0.0))
    curve = righting_curve(hull, np.radians(np.arange(0, 121, 5.0)), ROLL)
    at, arm = curve.largest
    assert arm == pytest.approx(curve.arm.max(), rel=0.02) and 0 < at < curve.vanishing
    assert curve.vanishing == pytest.approx(math.pi / 2, abs=1e-3)  # by symmetry: half of it is wet on any side


def test_the_wind_must_leave_thirty_percent():
    """Areas of a curve that is a sine by construction against the integral of cos^2."""
    hull = Afloat(cylinder(10, 200, low=-100), 0.5 * RHO * math.pi * 25 * 200, (0, 0, -70.0))
    curve = righting_curve(hull, np.radians(np.arange(0, 61, 4.0)))
    weight = hull.total_mass * hull.gravity
    force, lever = 2e6, 120.0
    found = curve.wind_area(force, lever)
    righting = weight * np.trapezoid(np.interp(fine := np.linspace(0, found.end, 4001), curve.heel, curve.arm), fine)
    assert found.righting == pytest.approx(righting, rel=3e-3)
    assert found.wind == pytest.approx(force * lever * np.trapezoid(np.cos(fine) ** 2, fine), rel=1e-6)
    assert found.enough and math.isnan(found.second)
    start = curve.wind_area(force, lever, flooding=math.radians(10))
    assert start.end == pytest.approx(math.radians(10)) and start.ratio < found.ratio
    with pytest.raises(ParameterError, match="it turns over"):
        curve.wind_area(1e9, 120.0)


# --- at rest ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("share", "angle"), [(0.1, 0.0), (0.25, math.degrees(math.atan(0.5))), (0.3, 45.0), (0.5, 45.0), (0.85, 0.0)]
)
def test_a_square_log_turns_by_its_density(share, angle):
    """Upright below (3 - sqrt 3)/6 = 0.2113 of the density of water, on its edge above 9/32, between at an angle.

    And so from the other side, with what is dry. Source: E.N. Gilbert, American Mathematical Monthly 98 (1991) 201-216.
    """
    rest = Afloat(box(10, 1, 1, low=-0.5), share * RHO * 10, (0, 0, 0)).at_rest()
    assert math.degrees(rest.heel) == pytest.approx(angle, abs=0.01)
    assert rest.metacentric_height > 0


def test_a_box_that_is_top_heavy_comes_to_rest_upside_down():
    hull = Afloat(box(20, 6, 10, low=-5), 0.5 * RHO * 1200, (0, 0, 2.0))
    assert hull.at().metacentric_height == pytest.approx(0.6 - 4.5, rel=1e-4)
    rest = hull.at_rest()
    assert rest.normal == pytest.approx([0, 0, -1], abs=1e-6) and rest.metacentric_height > 0


def test_a_hull_that_is_too_heavy_sinks():
    with pytest.raises(ParameterError, match="sinks: it weighs 2e\\+06 kg, and all of it displaces 1.23e\\+06 kg"):
        Afloat(box(20, 6, 10), 2e6, (0, 0, 0)).at()


# --- liquids, compartments -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("inside", [box(10, 5, 4, low=-5), cylinder(6, 4, low=-5)])
def test_a_free_surface_takes_off_its_second_moment(inside):
    """GM less rho_k i_k / (rho V); and a full tank takes nothing."""
    hull, water = box(30, 12, 8, low=-5), 0.5 * float(inside.whole[0, 0])
    steel = RHO * 30 * 12 * 4 - RHO * water
    slack = Afloat(hull, steel, (0, 0, -1), liquids=(Liquid(inside, water),)).at()
    first = inside.under([3.0, 0, 0, 1]).moments  # half of it: to z = -3
    centre = (RHO * first + steel * np.array([0, 0, -1.0])) / (steel + RHO * water)
    solid = Afloat(hull, steel + RHO * water, centre).at()
    i = np.diag(inside.under([3.0, 0, 0, 1]).slopes)[1:3]
    assert slack.metacentric - solid.metacentric == pytest.approx(np.diag(i) / slack.volume, abs=1e-6)
    full = Afloat(hull, steel - RHO * water, (0, 0, -1), liquids=(Liquid(inside, 2 * water),)).at()
    assert full.metacentric_height == pytest.approx(
        Afloat(hull, steel + RHO * water, full.centre_of_mass).at().metacentric_height, rel=1e-9
    )


def test_a_flooded_end_of_a_box_by_lost_buoyancy_and_by_added_weight():
    """A barge of 60 x 10 m with 10 m open at an end: sinkage and trim of both methods; the text book's first guess.

    By added weight: the water that stands in it at rest, as a liquid in a tank.
    """
    hull = Afloat(box(60, 10, 8, low=-4), RHO * 60 * 10 * 4, (0, 0, 0))
    room = box(10, 10, 8, low=-4, x=25.0)
    lost = hull.with_flooded(room).at_rest()
    inside = room.under([lost.height, *lost.normal]).volume
    added = Afloat(hull.surface, hull.mass, hull.centre, liquids=(Liquid(room, inside),)).at_rest()
    assert added.normal == pytest.approx(lost.normal, abs=1e-7) and added.height == pytest.approx(lost.height, abs=1e-5)
    assert lost.volume == pytest.approx(hull.mass / RHO) and added.volume == pytest.approx(lost.volume + inside)
    # small angles: sinkage by the lost area, trim by the lost moment about the centroid of what is left (50 x 10 m)
    sink = 10 * 10 * 4 / (50 * 10)
    GM = 50**3 * 10 / 12 / 2400 + (-4 + (4 + sink) / 2) - 0
    assert math.tan(lost.heel) == pytest.approx(5.0 / GM, rel=0.03)  # G is 5 m ahead of B
    half = hull.with_flooded(room, permeability=0.5).at_rest()
    assert 0 < half.heel < lost.heel


# --- the model of a basin --------------------------------------------------------------------------------------------


def spar(scale=1.0, **given):
    """Heave plate, base cylinder, frustum and column [mm at model scale]: 889 x 44, 667 x 111, 111 to 333, 333 x 1556.

    Source: table 5.3 of a thesis on a raisable tower on a concrete spar, 1:45; keel at z = 0 of its own, here -1.32 m.
    """
    k = 1e-3 * scale
    steps = [(0, 889), (44, 889), (44, 667), (155, 667), (266, 333), (1822, 333)]
    length = steps[-1][0] * k
    member = CircularMember(
        start=(0, 0, -1320 * k), end=(0, 0, -1320 * k + length), stations=[z * k / length for z, _ in steps],
        diameters=[d * k for _, d in steps], wall_thickness=0.0, density=0.0,
    )  # fmt: skip
    floater = Floater(**given)
    floater.column = member
    return floater


def at_sea(floater, density=RHO, gravity=9.80665, **more):
    floater.hydrostatics = MemberHydrostatics()
    whole = fw.Assembly("spar")
    whole.world = World(water_depth=90.0, water_density=density, gravity=gravity)
    whole.motion, whole.floater = FreeMotion(), floater
    whole.connect(whole.world.frame, whole.motion.frame_a)
    whole.connect(whole.motion.frame_b, floater.frame)
    for name, part in more.items():
        whole.add(name, part)
        whole.connect(floater.frame, part.frame)
    return whole


def test_the_spar_of_a_basin_displaces_180_5_kg_and_floats_deeper_with_its_mass():
    """180.5 kg at 1320 mm and 186 kg at 1383 mm, fresh water: what its geometry says, whatever was weighed."""
    for mass, draft in ((180.5, 1.320), (186.0, 1.383)):
        floater = spar()
        floater.column.add("all", LumpedMass(mass=mass, place=(0, 0, -1.32 + 0.403)))
        found = afloat(fw.load(at_sea(floater, density=1000.0))).at()
        assert found.draft == pytest.approx(draft, abs=1e-3)
    bottom, top = (math.pi / 4 * d**2 for d in (0.889, 0.667))
    cone = math.pi * 0.111 / 12 * (0.667**2 + 0.667 * 0.333 + 0.333**2)
    column = math.pi / 4 * 0.333**2
    wanted = 1000 * (bottom * 0.044 + top * 0.111 + cone + column * (1.32 - 0.266))
    assert wanted == pytest.approx(180.5, abs=0.05)
    floater = spar()
    assert 1000 * fw.load(at_sea(floater)).root.floater.hull().buoyancy.volume == pytest.approx(wanted, rel=1e-9)


def test_its_metacentric_height_says_that_the_centre_of_mass_was_not_measured_from_the_keel():
    """447 mm over the keel: GM 9 mm; 489 mm: it turns over; 403 mm: 53 mm. Closed forms z_B + I / V - z_G."""
    heights = {}
    for z in (0.447, 0.489, 0.403):
        floater = spar(held_upright=True)
        floater.column.add("all", LumpedMass(mass=180.5, place=(0, 0, -1.32 + z)))
        heights[z] = afloat(fw.load(at_sea(floater, density=1000.0))).at().metacentric_height
    assert heights[0.447] == pytest.approx(0.009, abs=1e-3) and heights[0.489] < 0
    assert heights[0.403] == pytest.approx(heights[0.447] + 0.044, abs=1e-5)


# --- models, stages --------------------------------------------------------------------------------------------------


def caisson():
    """A concrete spar, full scale: a plate, a base with ore in it, a column in two parts, water in the lower one."""
    floater = Floater()
    floater.base = CircularMember(start=(0, 0, -62), end=(0, 0, -55), diameters=(40.0, 40.0, 30.0, 30.0),
                                  stations=(0, 2 / 7, 2 / 7, 1), wall_thickness=0.35, density=2500)  # fmt: skip
    floater.base.floor = Bulkhead(place=1.0, thickness=2.0, density=1250)  # with ribs
    floater.base.roof = Bulkhead(place=6.8, thickness=0.35, density=2500)
    floater.base.ore = Ballast(level=-57.0, tank_start=2.0, tank_end=6.6, density=3000)
    column = {"diameters": 15.0, "wall_thickness": 0.35, "density": 2500}
    floater.column = CircularMember(start=(0, 0, -55), end=(0, 0, -20), **column)
    floater.column.water = Ballast(level=-50.0)
    floater.top = CircularMember(start=(0, 0, -20), end=(0, 0, 20), **column)
    return floater


def test_stages_of_construction_add_what_is_built_and_pumped_in():
    """Each draft by hand: masses over the sections of the hull; a base that floats alone, then column, then ballast."""
    floater = fw.load(at_sea(caisson())).root.floater
    found = construction_stages(floater, [
        Stage("base afloat", members=("base",)),
        Stage("column cast", members=("column",), levels={"base.ore": -57.0}),
        Stage("top cast", members=("top",)),
        Stage("turbine on", masses={"turbine": (400e3, (0, 0, 60.0))}, levels={"column.water": -45.0}),
    ], clearance=2.0, slack="column.water")  # fmt: skip
    hull = floater.hull()
    masses = [stage.rest.mass for stage in found]
    base = hull.members[0].structure(hull.spans[0])
    assert masses[0] == pytest.approx(sum(part.mass for part in base), rel=1e-6)
    tank = math.pi / 4 * 14.3**2 * RHO
    wall = 2500 * math.pi * 14.65 * 0.35
    assert masses[1] - masses[0] == pytest.approx(3000 * math.pi / 4 * 29.3**2 * 3 + wall * 35, rel=1e-6)
    assert masses[2] - masses[1] == pytest.approx(wall * 40, rel=1e-6)
    assert masses[3] - masses[2] == pytest.approx(400e3 + tank * 10, rel=1e-6)
    for stage in found:
        below = stage.rest.draft
        sections = [(0, 2, 40), (2, 7, 30), (7, 82, 15)]
        volume = sum(math.pi / 4 * d**2 * max(min(below, b) - a, 0) for a, b, d in sections)
        assert RHO * volume == pytest.approx(stage.rest.mass, rel=1e-5)
        assert stage.needed_depth == pytest.approx(below + 2.0) and stage.upright.metacentric_height > 0
    assert found[0].row()[0] == "base afloat"


def test_a_stage_that_would_turn_over_is_refused_with_its_name():
    floater = fw.load(at_sea(caisson())).root.floater
    with pytest.raises(ParameterError, match="at stage 'tower first': the metacentric height is -.* it turns over"):
        construction_stages(floater, [
            Stage("afloat", levels={"base.ore": -57.0}),
            Stage("tower first", masses={"tower": (3e6, (0, 0, 80.0))}),
        ], slack=())  # fmt: skip
    with pytest.raises(ModelError, match="stage 'typo': there is no ballast of floater 'base.or'; did you mean"):
        construction_stages(floater, [Stage("typo", levels={"base.or": -60.0})])
    with pytest.raises(ModelError, match="floater has no ballast 'ore'"):
        construction_stages(floater, [Stage("afloat")], slack=["ore"])


def test_ballast_and_tanks_of_a_model_are_liquids():
    """Base full of nothing to half: slack ballast as in `Afloat`, a ring and a box of components.flooding beside it."""
    tanks = {"ring": RoundTank(place=(0, 0, -60.0), diameter=29.0, inner_diameter=8.0, height=4.0, volume_start=900.0),
             "box": BoxTank(place=(0, 0, -50.0), length=6.0, width=5.0, height=20.0, volume_start=150.0)}  # fmt: skip
    model = fw.load(at_sea(caisson(), **tanks))
    solid, slack = afloat(model), afloat(model, slack="all")
    assert solid.total_mass == pytest.approx(afloat(fw.load(at_sea(caisson()))).total_mass + RHO * 1050, rel=1e-12)
    assert [liquid.mass for liquid in solid.liquids] == pytest.approx([RHO * 900, RHO * 150])
    assert slack.total_mass == pytest.approx(solid.total_mass, rel=1e-12)
    upright = solid.at(), slack.at()
    assert upright[1].centre_of_mass == pytest.approx(upright[0].centre_of_mass, abs=1e-5)
    lost = math.pi / 64 * (3000 / RHO * 29.3**4 + 14.3**4) / upright[0].volume
    assert upright[0].metacentric_height - upright[1].metacentric_height == pytest.approx(lost, rel=1e-4)
    by_tanks = math.pi / 64 * (29**4 - 8**4) + np.array([5 * 6**3, 6 * 5**3]) / 12
    dry = Afloat(solid.surface, solid.total_mass, upright[0].centre_of_mass, RHO).at()
    assert np.diag(dry.metacentric - upright[0].metacentric) == pytest.approx(by_tanks / upright[0].volume, rel=1e-4)


def test_a_tank_of_any_kind_is_a_liquid():
    """A prism as a box of its section, free surface and all, at 20 deg as upright."""
    whole = {"length": 6.0, "width": 5.0, "height": 20.0}
    given = {"place": (1, 2, -50.0), "height": 20.0, "volume_start": 300.0}
    prism = PrismaticTank(area=30.0, second_moments=(90.0, 62.5, 0.0), half_length=3.0, half_width=2.5, **given)
    kinds = (BoxTank(**{**given, **whole}), prism)
    hulls = [afloat(fw.load(at_sea(caisson(), tank=kind))) for kind in kinds]
    for normal in ((0, 0, 1.0), (0.2, -0.3, 0.93)):
        first, second = (hull.at(normal) for hull in hulls)
        assert second.centre_of_mass == pytest.approx(first.centre_of_mass, abs=1e-6)
        assert second.metacentric == pytest.approx(first.metacentric, abs=1e-5)
    with pytest.raises(ParameterError, match="tank: its axis is turned by more than 80 deg"):
        hulls[1].at((1.0, 0, 0.1))


def test_the_water_of_a_raisable_tower_counts_once():
    """As `stroke` does: tanks and shaft with what is in them at the start, 17369 t less the pull of the lines."""
    plant = fw.load("dtif_raising").compile()
    state = plant.initial_state()
    dry = sum(body.mass for body in placed_bodies([(part, fact) for part, fact in facts_of(plant.root)
                                                   if isinstance(fact, facts.Mass)
                                                   and not isinstance(part, Tank)], state))  # fmt: skip
    assert afloat(plant).total_mass == pytest.approx(dry + RHO * (40 + 2100), rel=1e-9)


def test_a_compartment_of_a_member_floods():
    model = fw.load(at_sea(caisson()))
    hull, floater = afloat(model), model.root.floater
    flooded = hull.with_flooded(compartment_of(floater, "base", 2.0, 6.6)).at()
    assert flooded.draft > hull.at().draft
    with pytest.raises(ParameterError, match="not within the member"):
        compartment_of(floater, "base", 2.0, 20.0)
    barge = Floater()
    barge.pontoon = RectangularMember(start=(-5, 0, 0), end=(5, 0, 0), widths=4.0, heights=2.0, wall_thickness=0.0)
    assert compartment_of(fw.load(at_sea(barge)).root.floater, "pontoon", 0, 5).whole[0, 0] == pytest.approx(40)


def test_a_hull_that_leans_over_is_told_of_with_the_metacentric_height_at_its_own_draft():
    """A column drawn with 10 m of draft, which comes to 20 m: GM = d^2 / 16 / 20 + z_B - z_G, -10 m and -9 m."""
    floater = Floater()
    floater.column = CircularMember(start=(0, 0, -10), end=(0, 0, 30), diameters=8.0, wall_thickness=0.0)
    floater.column.load = LumpedMass(mass=RHO * math.pi * 16 * 20, place=(0, 0, 1.0))
    model = at_sea(floater)
    model.spin = RigidBody(mass=0.0, inertia=np.diag([1e7, 1e7, 1e6]).tolist())
    model.connect(floater.frame, model.spin.frame_a)
    plant = fw.load(model).compile()
    state = plant.equilibrium(start={"motion.heave": -9.0})
    assert float(state["motion.heave"]) == pytest.approx(-10.0, abs=1e-3)
    (told,) = upright_faults(plant, state)
    assert "metacentric height of the whole, without moorings, is -0.8 m" in told


def test_the_full_scale_spar_displaces_17_370_t_at_62_m():
    """Plate 40 x 2 m, base 30 x 5 m, frustum of 5 m, column of 15 m in sea water: the stated 17 370 t within 0.1 %."""
    floater = Floater()
    steps = [(0, 40), (2, 40), (2, 30), (7, 30), (12, 15), (82, 15)]
    floater.column = CircularMember(start=(0, 0, -62), end=(0, 0, 20), stations=[z / 82 for z, _ in steps],
                                    diameters=[d for _, d in steps], wall_thickness=0.0)  # fmt: skip
    floater.column.load = LumpedMass(mass=17_370e3, place=(0, 0, -45))
    hull = afloat(fw.load(at_sea(floater)))
    assert hull.at().draft == pytest.approx(62.0, abs=17_370 * 1e-3 / 181)  # 181 t/m
    base = Afloat(hull.surface, 12_000e3, (0, 0, -50.0), RHO)  # towed without ballast and turbine
    plate, cylinder_, cone = math.pi * 400 * 2, math.pi * 225 * 5, math.pi * 5 / 12 * (900 + 450 + 225)
    column = (12_000e3 / RHO - plate - cylinder_ - cone) / (math.pi / 4 * 225)
    assert base.at().draft == pytest.approx(12 + column, abs=1e-3)
