"""Stages of building a spar afloat: by hand, against the component, and what is refused."""

import math
from dataclasses import replace

import pytest

import fowtlib as fw
from fowtlib.analysis.stages import Stage, construction_stages
from fowtlib.components.mechanics import FreeMotion, World
from fowtlib.components.platform import CircularMember, Floater
from fowtlib.design.construction import BuildStage, ballast_for, build_stages, hull_sizes
from fowtlib.language import Assembly
from fowtlib.language.errors import ModelError


@pytest.fixture(scope="module")
def model():
    return fw.load("raisable_spar_sizes")


@pytest.fixture(scope="module")
def hull(model):
    return hull_sizes(model)


def test_the_last_stage_is_the_spar_of_the_equations(model, hull):
    """Raised, all ballast in: draft, centres and metacentric height of the component, with water in the base, too."""
    for water in (0.0, 2e5):
        stage = BuildStage("raised", 82.0, 5325e3, water, 970e3, 52.0 + 75.0)
        (row,) = build_stages(hull, [stage])
        state = model.compile().equilibrium({"spar.water_ballast": water, "spar.free_surface": 1.0 if water else 0.0})
        for name in ("draft", "centre_of_mass", "centre_of_buoyancy", "metacentric_height", "concrete_volume"):
            assert getattr(row, name) == pytest.approx(float(state[name]), rel=1e-6), name


def test_the_base_floats_on_shallow_water(hull):
    """Plate, base and cone, by hand: 8.1 m of draft, less than the 10 m in which the thesis casts them."""
    (row,) = build_stages(hull, [BuildStage("base", 12.0)])
    plate = math.pi / 4 * 40**2 * 2
    ring = math.pi / 4 * (30**2 - 29.3**2) * 5 + math.pi / 12 * 5 * (30**2 + 30 * 15 + 15**2)
    ring -= math.pi / 12 * 5 * (29.3**2 + 29.3 * 14.3 + 14.3**2)
    shaft = math.pi / 4 * (7.7**2 - 7.0**2) * 10
    volume = plate + 1.0203 * (ring + shaft)
    assert row.concrete_volume == pytest.approx(volume, rel=1e-12)
    assert row.mass == pytest.approx(2400 * volume)

    # the waterline is in the cone: its diameter falls by 3 m per metre
    def displaced(draft):
        end = 30 - 3 * (draft - 7)
        cone = math.pi / 12 * (draft - 7) * (30**2 + 30 * end + end**2)
        return 1025 * (plate + math.pi / 4 * 30**2 * 5 + cone)

    assert displaced(row.draft) == pytest.approx(row.mass, rel=1e-9)
    assert 8.0 < row.draft < 8.3 and row.water_depth == pytest.approx(row.draft + 2)
    assert row.metacentric_height > 5


def test_rings_without_ballast_turn_over(hull):
    """The higher the rings, the less stable; from some 30 m on they need ballast, which gives what is asked."""
    rows = build_stages(hull, [BuildStage(f"{top} m", float(top)) for top in (22, 32, 47, 62, 82)])
    heights = [row.metacentric_height for row in rows]
    assert heights == sorted(heights, reverse=True) and heights[0] > 2 and heights[2] < 0
    needed = [ballast_for(hull, BuildStage(row.name, row.top), 1.0) for row in rows]
    assert needed[0] == 0 and needed == sorted(needed)
    for row, ballast in zip(rows[1:], needed[1:], strict=True):
        (found,) = build_stages(hull, [BuildStage(row.name, row.top, solid_ballast=ballast)])
        assert found.metacentric_height == pytest.approx(1.0, abs=1e-5)


def test_the_stages_are_those_of_the_surfaces_of_members(hull):
    """Draft, centre of buoyancy and metacentric height by integrals over wetted triangles: another formulation."""
    ours = [BuildStage("base", 12.0), BuildStage("rings", 47.0, 1860e3),
            BuildStage("raised", 82.0, 5325e3, 0.0, 970e3, 127.0)]  # fmt: skip
    rows = build_stages(hull, ours)
    root = Assembly("members")
    root.world = World(water_depth=90, gravity=9.81)
    root.motion, root.floater = FreeMotion(), Floater(held_upright=True)
    places = {"plate": (0, 2, 40, 40), "base": (2, 7, 30, 30), "cone": (7, 12, 30, 15), "lower": (12, 47, 15, 15),
              "upper": (47, 82, 15, 15)}  # fmt: skip
    for name, (low, high, below, above) in places.items():
        part = CircularMember(start=(0, 0, low - 62), end=(0, 0, high - 62), diameters=[below, above])
        setattr(root.floater, name, part)
    root.connect(root.world.frame, root.motion.frame_a)
    root.connect(root.motion.frame_b, root.floater.frame)
    built = (("plate", "base", "cone"), ("lower",), ("upper",))
    stages = [Stage(row.name, members, {}, {"all": (row.mass, (0.0, 0.0, row.centre_of_mass - 62))})
              for row, members in zip(rows, built, strict=True)]  # fmt: skip
    found = construction_stages(fw.load(root).root.floater, stages, clearance=2.0)
    for row, other in zip(rows, found, strict=True):
        assert other.rest.draft == pytest.approx(row.draft, abs=1e-4)
        assert other.upright.metacentric_height == pytest.approx(row.metacentric_height, abs=1e-4)
        assert other.upright.centre_of_buoyancy[2] + 62 == pytest.approx(row.centre_of_buoyancy, abs=1e-4)
        assert other.needed_depth == pytest.approx(row.water_depth, abs=1e-4)


def test_raising_keeps_the_draft(hull):
    low = BuildStage("lowered", 82.0, 5325e3, 0.0, 970e3, 77.0)
    down, up = build_stages(hull, [low, replace(low, name="raised", set_centre=127.0)])
    assert up.draft == down.draft
    assert down.metacentric_height - up.metacentric_height == pytest.approx(970e3 * 50 / up.mass)


@pytest.mark.parametrize(
    ("stage", "words"),
    [
        (BuildStage("high", 90.0), "high: the hull is built from 2 m to 82 m"),
        (BuildStage("heavy", 12.0, 5e6), "heavy: it sinks"),
        (BuildStage("full", 12.0, 5e7), "full: the solid ballast has"),
    ],
)
def test_mistakes(hull, stage, words):
    with pytest.raises(ModelError, match=words):
        build_stages(hull, [stage])
    with pytest.raises(ModelError, match="no ballast gives"):
        ballast_for(hull, BuildStage("short", 47.0, set_mass=4e6, set_centre=150.0), 1.0)
    with pytest.raises(ModelError, match="is not a SteppedSpar"):
        hull_sizes(fw.load("oc3_spar_rigid"), "wind")
