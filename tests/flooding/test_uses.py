"""Tanks in model files, in both solvers, in equilibria, in FMUs; damage of a floating box."""

from __future__ import annotations

import math
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.optimize import brentq

import fowtlib as fw
from fowtlib.components import flooding
from fowtlib.components.environment import Sea, World
from fowtlib.components.flooding import BoxTank, Doorway, RoundTank, SeaOpening, TabulatedTank
from fowtlib.components.hydro.linear_loads import LinearDamping
from fowtlib.components.mechanics import Fixed
from fowtlib.language.native import compiler
from fowtlib.modelfile import dump
from tests.flooding.floating import DRAFT, KG, LENGTH, VOLUME, WIDTH, floating_box

FILE = """
fowtlib: 1
title: a barge that pumps water from side to side
world: {class: World}
parts:
  motion: {class: FreeMotion}
  hull: {class: RigidBody, mass: 800 t, r_cm: [0, 0, -1], inertia: [[1.1e7, 0, 0], [0, 6.6e7, 0], [0, 0, 7.5e7]]}
  buoyancy:
    class: Hydrostatics
    volume: 1080
    centre_of_buoyancy: [0, 0, -1.5]
    stiffness:
      - [0, 0, 0, 0, 0, 0]
      - [0, 0, 0, 0, 0, 0]
      - [0, 0, 3618654, 0, 0, 0]
      - [0, 0, 0, 43423841, 0, 0]
      - [0, 0, 0, 0, 271399009, 0]
      - [0, 0, 0, 0, 0, 0]
  damping: {class: LinearDamping, translation: [1e4, 1e4, 1e6], rotation: [3e7, 1e8, 1e6]}
  port_tank:
    {class: BoxTank, length: 12 m, width: 3 m, height: 4 m, volume_start: 70, place: [0, 4, -3], walls_wet: true}
  starboard_tank: {class: RoundTank, diameter: 4 m, height: 6 m, volume_start: 30, place: [0, -4, -3], walls_wet: true}
  bell:
    {class: BoxTank, length: 2 m, width: 2 m, height: 4 m, volume_start: 4, sealed: true, place: [8, 0, -3],
     walls_wet: true}
  pump: {class: Pump, rated_flow: 0.2, rated_head: 4 m, shutoff_head: 9 m, in_line: true}
  pipe: {class: Pipe, length: 9 m, diameter: 0.3 m, inertia: true}
  valve: {class: Valve, area: 0.01}
connect:
  - [world.frame, motion.frame_a]
  - [motion.frame_b, hull.frame_a, buoyancy.frame, damping.frame, port_tank.frame, starboard_tank.frame, bell.frame]
  - ["port_tank.water[0]", pump.water_a, valve.water_a]
  - [pump.water_b, pipe.water_a]
  - [pipe.water_b, "starboard_tank.water[0]"]
  - [valve.water_b, "bell.water[0]"]
"""
EVERYTHING = """
fowtlib: 1
title: everything
world: {class: World}
parts:
  ground: {class: Fixed, r: [0, 0, 2]}
  sea: {class: Sea, spectrum: regular, wave_height: 1, wave_period: 8}
  a:
    {class: TabulatedTank, levels: [0, 2, 4], areas: [8, 9, 10], second_moments: [[4, 5, 0], [5, 5, 0], [6, 5, 0]],
     first_moments: [[1, 0], [1, 0], [1, 0]], volume_start: 9, sealed: true, density: 1000}
  b:
    {class: RoundTank, diameter: 3, inner_diameter: 1, height: 4, volume_start: 9, sealed: true,
     polytropic_exponent: 1.4}
  c: {class: BoxTank, length: 3, width: 2, height: 4, volume_start: 9, sloshing: true, places: [[0, 0, 0], [0, 1, 1]]}
  d:
    {class: PrismaticTank, area: 8, second_moments: [4, 5, 0], half_length: 2, half_width: 1, height: 4,
     volume_start: 9}
  e: {class: RoundTank, diameter: 3, height: 4, volume_start: 9, sloshing: true, walls_wet: true}
  p1: {class: Pump, rated_flow: 0.01, mode: flow}
  p2: {class: Pump, rated_flow: 0.01, rated_head: 2, shutoff_head: 4, in_line: true}
  pipe: {class: Pipe, length: 9 m, diameter: 0.3 m, inertia: true}
  pipe2: {class: Pipe, length: 9 m, diameter: 0.3 m}
  v: {class: Valve, area: 0.01, in_line: true}
  v2: {class: Valve, area: 0.01}
  vent: {class: Vent, area: 0.001}
  door: {class: Doorway, area: 0.1, height: 0.2, place: [0, 0, 2]}
  hole: {class: SeaOpening, area: 0.1, height: 0.2, place: [0, 0, -2], waves: true, opening_start: 0}
  duct: {class: Duct, points: [[0, 1, 1], [0, 2, 1], [0, 3, 0]], area: 0.05}
connect:
  - [ground.frame, a.frame, b.frame, c.frame, d.frame, e.frame, door.frame, hole.frame, duct.frame]
  - ["a.water[0]", p1.water_a, v2.water_a]
  - [p1.water_b, pipe2.water_a]
  - [pipe2.water_b, "b.water[0]", v2.water_b]
  - ["c.water[0]", p2.water_a]
  - [p2.water_b, pipe.water_a]
  - [pipe.water_b, v.water_a]
  - [v.water_b, "d.water[0]", door.water_a, hole.water]
  - [door.water_b, "e.water[0]"]
  - [a.air, vent.air]
  - ["c.water[1]", duct.water_a]
  - [duct.water_b, "e.water[0]"]
"""
NAMES = ["motion.roll", "motion.pitch", "motion.heave", "port_tank.volume", "starboard_tank.level", "bell.air_pressure"]


@pytest.fixture(scope="module")
def barge(tmp_path_factory) -> fw.Plant:
    file = tmp_path_factory.mktemp("barge") / "barge.yaml"
    file.write_text(FILE)
    return fw.load(file).compile()


def test_both_solvers_agree_on_a_barge_from_a_file(barge):
    events = ["pump.failure at 60 s"]
    a = barge.simulate(120, 1, tolerance=1e-8, outputs=NAMES, events=events)
    b = barge.simulate(120, 1, solver="fixed", step=0.02, outputs=NAMES, events=events)
    for name in NAMES:
        x, y = a[name].values, b[name].values
        assert np.max(np.abs(x - y)) < 2e-4 * np.max(np.abs(x)), name
    assert abs(a["motion.roll"].values[-1]) > 0.01
    assert a["port_tank.volume"].values[-1] < 65


def test_a_barge_with_tanks_survives_being_written(barge, tmp_path):
    file = tmp_path / "barge.yaml"
    file.write_text(FILE)
    model = fw.load(file)
    text = dump(model)
    (tmp_path / "again.yaml").write_text(text)
    again = fw.load(tmp_path / "again.yaml")
    assert again.tree() == model.tree()
    assert dump(again) == text


OF_THE_RAISABLE_TOWER = {"CompartmentRing", "FloatingPiston", "LiftingCommand"}  # in test_raisable_tower.py


def test_every_part_in_one_file_in_both_solvers_and_written_again(tmp_path):
    (tmp_path / "all.yaml").write_text(EVERYTHING)
    model = fw.load(tmp_path / "all.yaml")
    there = {type(part).__name__ for part in model.root.parts.values()}
    assert there >= set(flooding.__all__) - {"Air", "Tank", "Water"} - OF_THE_RAISABLE_TOWER
    (tmp_path / "again.yaml").write_text(dump(model))
    plant = fw.load(tmp_path / "again.yaml").compile()
    events = ["hole.turn at 2 s, to=0.3", "vent.shut at 3 s", "p2.failure at 5 s"]
    a = plant.simulate(8, 0.5, events=events, tolerance=1e-8)
    b = plant.simulate(8, 0.5, events=events, solver="fixed", step=0.01)
    for name in ("a.volume", "d.volume", "b.air_pressure", "p2.volume_flow", "hole.volume_flow"):
        x, y = a[name].values, b[name].values
        assert np.max(np.abs(x - y)) < 1e-4 * np.ptp(x), name


@pytest.mark.skipif(not (find_spec("fmpy") and compiler()), reason="needs fmpy and a compiler")
def test_an_fmu_of_a_barge_with_tanks_does_what_the_solver_inside_does(barge, tmp_path):
    import fmpy

    path = fw.export_fmu(barge, tmp_path / "barge.fmu", kind="cs", step=0.05)
    names = ["motion.roll", "motion.heave", "port_tank.volume", "bell.air_mass", "pump.volume_flow"]
    rows = fmpy.simulate_fmu(str(path), stop_time=20, output_interval=1.0, output=names, fmi_type="CoSimulation")
    here = barge.simulate(20, 1, solver="fixed", step=0.05, outputs=names)
    for name in names:
        assert np.max(np.abs(rows[name] - here[name].values)) < 1e-6 * np.max(np.abs(here[name].values)), name


def test_a_damaged_compartment_floods_to_a_new_equilibrium():
    """Lost buoyancy: the box sinks and trims until the water in the open compartment is at the level of the sea.

    By hand with the box as a body of vertical walls: what floats are the waterplane and volume without the compartment.
    """
    a, b, height, x = 5.0, 12.0, 6.0, 9.0  # from the keel up, across the whole box, forward
    model = floating_box(("hold", BoxTank(length=a, width=b, height=height, volume_start=0.0, place=(x, 0, -DRAFT))))
    model.damping = LinearDamping(translation=(1e5, 1e5, 1e6), rotation=(1e8, 3e8, 1e8))
    model.connect(model.motion.frame_b, model.damping.frame)
    model.hole = SeaOpening(area=2.0, height=0.5, place=(x, b / 2, -2), opening_start=0)
    model.connect(model.motion.frame_b, model.hole.frame)
    model.connect(model.hole.water, model.hold.water[0])
    plant = fw.load(model).compile()
    whole = plant.equilibrium()
    assert float(whole["motion.pitch"]) == pytest.approx(0, abs=1e-9)
    state = plant.equilibrium(parameters={"hole.opening_start": 1.0})
    assert float(state["hold.surface"]) == pytest.approx(0, abs=1e-6)
    # heave and slope of the box: forces and moments about the origin of weight, buoyancy and water inside, level at 0
    area, inertia = LENGTH * WIDTH, WIDTH * LENGTH**3 / 12

    def residual(heave: float, pitch: float) -> tuple[float, float]:
        c, s, t = math.cos(pitch), math.sin(pitch), math.tan(pitch)
        keel = heave - DRAFT * c - x * s  # of the middle of the floor of the hold, z in the world
        level = -keel / c  # on its axis
        volume = a * b * level
        first_x = a**3 * b / 12 * t  # of its wedge: deeper where x is greater, bow down
        first_z = (a * b * level**2 + a**3 * b / 12 * t**2) / 2
        along = c * (volume * x + first_x) + s * (volume * -DRAFT + first_z)  # world x of volume times centre
        lift = VOLUME - area * heave - VOLUME - volume
        moment = VOLUME * (-DRAFT / 2) * s - VOLUME * KG * s - along
        return lift, -moment - inertia * t

    found, step = np.array([float(state["motion.heave"]), float(state["motion.pitch"])]), 1e-7
    J = np.array([(np.array(residual(*(found + step * e))) - residual(*found)) / step for e in np.eye(2)]).T
    away = np.linalg.solve(J, residual(*found))
    assert np.max(np.abs(away)) < 1e-6
    assert found[0] < -0.4 and found[1] > 0.02
    result = plant.simulate(250, 2, events=["hole.turn at 5 s"], outputs=["hold.volume", "motion.pitch"])  # and in time
    assert result["hold.volume"].values[2] == pytest.approx(0, abs=1e-9)
    assert result["hold.volume"].values[-1] == pytest.approx(float(state["hold.volume"]), rel=1e-3)
    assert result["motion.pitch"].values[-1] == pytest.approx(found[1], rel=1e-3)


def test_water_comes_in_with_the_waves_at_an_opening_above_the_still_water_level():
    def run(waves: bool, z: float) -> fw.Result:
        model = fw.Assembly("a hole above the water")
        model.world = World(water_depth=100)
        model.sea = Sea(spectrum="regular", wave_height=1.0, wave_period=6.0)
        model.ground = Fixed()
        model.tank = BoxTank(length=5, width=5, height=6, volume_start=0.0, place=(0, 0, -3))
        model.hole = SeaOpening(area=0.05, height=0.1, place=(3, 0, z), waves=waves)
        model.connect(model.ground.frame, model.tank.frame)
        model.connect(model.ground.frame, model.hole.frame)
        model.connect(model.hole.water, model.tank.water[0])
        return fw.load(model).compile().simulate(12, 0.1, tolerance=1e-8)

    assert run(False, 0.3)["tank.volume"].values[-1] == 0
    k = brentq(lambda k: 9.80665 * k * math.tanh(100 * k) - (2 * math.pi / 6) ** 2, 1e-3, 1)
    t = np.linspace(0, 12, 200_001)
    z = 0.3 + 0.1 * ((np.arange(8) + 0.5) / 8 - 0.5)[:, None]
    head = np.maximum(0.5 * np.cos(2 * math.pi * t / 6 - 3 * k) - z, 0)
    expected = np.trapezoid((0.61 * 0.05 * np.sqrt(2 * 9.80665 * head)).mean(axis=0), t)
    assert run(True, 0.3)["tank.volume"].values[-1] == pytest.approx(expected, rel=2e-3)
    deep = run(True, -2.0)["hole.outside"]
    head = 0.5 * math.cosh(98 * k) / math.cosh(100 * k) * np.cos(2 * math.pi * deep["time"].values / 6 - 3 * k)
    assert deep.values == pytest.approx(head, abs=1e-6)


def test_masses_of_the_water_are_on_the_sheet():
    table = TabulatedTank(levels=(0, 4), areas=(1, 1), second_moments=((1, 1, 0), (1, 1, 0)), volume_start=2)
    round_tank = RoundTank(diameter=2, height=4, volume_start=math.pi, density=1000, place=(0, 2, 1))
    for tank, centre, mass in (
        (BoxTank(length=4, width=2, height=4, volume_start=8, place=(1, 0, 0)), (1, 0, 0.5), 8200),
        (round_tank, (0, 2, 1.5), 1000 * math.pi), (table, (0, 0, 1), 2050),
    ):  # fmt: skip
        model = fw.Assembly("tank")
        model.world = World(water_density=1025)
        model.add("tank", tank)
        model.connect(model.world.frame, model.tank.frame)
        found = model.tank.facts()[0]
        assert found.mass == pytest.approx(mass) and found.centre == pytest.approx(np.array(centre), abs=1e-6)


def test_an_overflow_between_compartments_keeps_the_level_of_its_sill():
    model = fw.Assembly("overflow")
    model.world = World()
    model.high = BoxTank(length=4, width=2, height=4, volume_start=30)
    model.low = BoxTank(length=4, width=2, height=4, volume_start=0)
    model.sill = Doorway(area=1.0 * 1.5, height=1.5, place=(0, 0, 3.25))  # from 2.5 m to 4 m
    for frame in (model.high.frame, model.low.frame, model.sill.frame):
        model.connect(model.world.frame, frame)
    model.connect(model.high.water[0], model.sill.water_a)
    model.connect(model.sill.water_b, model.low.water[0])
    result = fw.load(model).compile().simulate(600, 5)
    assert result["high.level"].values[-1] == pytest.approx(2.5 + 1.5 / 16, abs=0.01)  # the middle of its lowest slice
    assert result["high.volume"].values + result["low.volume"].values == pytest.approx(30, abs=1e-12)


def test_pictures_show_the_water_level_on_the_walls(tmp_path):
    """The line of a box that leans: level in the world, on the walls, at the height of the surface."""
    model = fw.Assembly("leaning tank")
    model.world = World()
    model.ground = Fixed(r=(1, 2, 3), angles=(0.1, -0.2, 0.5))
    model.tank = BoxTank(length=4, width=2, height=4, volume_start=16, place=(1, 0, 1), walls_wet=True)
    model.connect(model.ground.frame, model.tank.frame)
    plant = fw.load(model).compile()
    state = plant.initial_state()
    line = model.tank.drawing()[1]
    values = {key: np.atleast_1d(state[of]) for key, of in line.of.items() if isinstance(of, str)}
    values["r"] = np.array([[1.0, 2.0, 3.0]])
    points = line.points(values)[0]
    assert points[:, 2] == pytest.approx(float(state["tank.surface"]), abs=1e-9)
    R = np.array(state["tank.frame.R"])
    local = (points - (1, 2, 3)) @ R - (1, 0, 1)
    assert np.abs(local[:, :2]) == pytest.approx(np.array([[2, 1]] * 5), abs=1e-9)
    assert fw.view(plant.simulate(1, 0.5), tmp_path / "tank.html").path.stat().st_size > 1e4


def test_empty_and_full_tanks_roll_in_both_solvers():
    """Through the upright, where the level of a last drop goes from corner to corner."""
    model = floating_box(
        ("box", BoxTank(length=8, width=5, height=4, volume_start=0, place=(6, 1, -3))),
        ("round", RoundTank(diameter=5, height=4, volume_start=0, place=(-6, -1, -3))),
        water=60,
    )
    plant = fw.load(model).compile()
    start = {"motion.roll_start": 0.1, "motion.pitch_start": 0.05}
    for box, round_tank in ((0.0, 25 * math.pi), (160.0, 0.0)):
        given = start | {"box.volume_start": box, "round.volume_start": round_tank}
        a = plant.simulate(10, 0.25, tolerance=1e-7, parameters=given, outputs=["motion.roll"])["motion.roll"]
        b = plant.simulate(10, 0.25, solver="fixed", step=0.01, parameters=given, outputs=["motion.roll"])[
            "motion.roll"
        ]
        assert np.max(np.abs(a.values - b.values)) < 2e-3 * np.max(np.abs(a.values))
