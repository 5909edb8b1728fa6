"""Structure of the turbine: tower, blades, hub, nacelle, drive train, against the definition and against statics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.blocks import Step
from fowtlib.components.mechanics import Fixed, RigidBody, World
from fowtlib.components.support import FlexibleTower, RigidTower
from fowtlib.components.turbine import (
    ActuatedBearing,
    Drivetrain,
    FlexibleBlade,
    Hub,
    Nacelle,
    RigidBlade,
    RotorNacelleAssembly,
)
from fowtlib.language.errors import ParameterError

DATA = Path(fowtlib.models.__file__).parent / "data"
BLADE, TOWER = str(DATA / "nrel5mw" / "blade_structure.csv"), str(DATA / "oc3_hywind" / "tower.csv")
G = 9.80665
NACELLE = {"mass": 240e3, "centre_of_mass": (1.9, 0, 1.75), "inertia": np.diag([0, 0, 1741490.0]),
           "shaft_height": 1.96256, "tilt": "5 deg", "overhang": 5.0191}  # fmt: skip
HUB = {"precone": "2.5 deg", "radius": 1.5, "mass": 56780.0, "inertia": 115926.0}
DRIVETRAIN = {"gear_ratio": 97.0, "stiffness": 867637000.0, "damping": 6215000.0, "generator_inertia": 534.116}


def turbine(*, tower=2, hinges=2, gravity=G, speed=0.0, base=(0, 0, 10), **assembly):
    model = fw.Assembly("turbine on a fixed base")
    model.world, model.base = World(gravity=gravity), Fixed(r=base)
    model.tower = FlexibleTower(properties=TOWER, hinges=tower)
    parts = {"nacelle": Nacelle(**NACELLE), "hub": Hub(**HUB), "drivetrain": Drivetrain(**DRIVETRAIN)}
    model.turbine = RotorNacelleAssembly(
        **{**parts, "blade_properties": BLADE, "blade_hinges": hinges, "rotor_speed_start": speed, **assembly}
    )
    model.connect(model.base.frame, model.tower.frame_a)
    model.connect(model.tower.frame_b, model.turbine.frame)
    return model


def compiled(model):
    return fw.load(model).compile()


@pytest.fixture(scope="module")
def rigid():
    plant = compiled(turbine(tower=0, hinges=0, speed=1.0))
    return plant, plant.initial_state()


def test_the_hub_is_where_the_definition_has_it(rigid):
    """NREL/TP-500-38060: 90 m above the water, 5 m upwind of the tower."""
    _, state = rigid
    assert np.ravel(state["turbine.hub.frame.r"]) == pytest.approx([-5.0, 0, 90.0], abs=2e-3)


def test_blade_tips_follow_the_cone_and_the_sense_of_rotation(rigid):
    """Blade 1 is up and moves to starboard (-y); in the axes of the shaft the tips are 63 m sin(2.5 deg) upwind."""
    _, state = rigid
    hub, shaft = np.ravel(state["turbine.hub.frame.r"]), np.array([np.cos(np.radians(5)), 0, -np.sin(np.radians(5))])
    tips = [np.ravel(state[f"turbine.blade_{k}.beam.frame_b.r"]) - hub for k in (1, 2, 3)]
    assert [tip @ shaft for tip in tips] == pytest.approx([-63 * np.sin(np.radians(2.5))] * 3)
    assert [np.linalg.norm(tip) for tip in tips] == pytest.approx([63.0] * 3)
    assert tips[0][2] > 62 and tips[1][1] < -54 and tips[2][1] > 54
    w = np.ravel(state["turbine.hub.frame.w"])
    assert np.cross(w, tips[0])[1] == pytest.approx(-63 * np.cos(np.radians(2.5)), rel=1e-3)


def test_the_weight_arrives_at_the_tower_base(rigid):
    """Mass and moment of the whole: 350 t at -0.4138 m by the definition."""
    _, state = rigid
    moment = 350e3 * G * -0.413771
    assert state["tower.top_fore_aft_moment"] == pytest.approx(moment, rel=0.01)
    assert -np.ravel(state["tower.frame_a.f"])[2] == pytest.approx(-(350e3 + 249718) * G, rel=1e-3)


def test_rotor_inertia_by_its_acceleration():
    """A torque of the generator brakes the rotor: 38,759,227 kg m^2 about the shaft and 97^2 that of the generator."""
    model = turbine(tower=0, hinges=0, gravity=0.0)
    model.step = Step(height=1e4, start_time=0.0)
    model.connect(model.step.y, model.turbine.generator_torque)
    result = compiled(model).simulate(4.0, output_step=0.01)
    speed = np.asarray(result["turbine.nacelle.rotor_speed"])
    time = np.asarray(result["turbine.nacelle.rotor_speed"].time)
    slope = np.polyfit(time[50:], speed[50:], 1)[0]
    assert slope == pytest.approx(-97e4 / (38759227 + 97**2 * 534.116), rel=0.005)


def test_drive_train_frequency(rigid):
    """Free-free torsion of the definition's rotor and generator: 1/(2 pi) sqrt(k (1/J_r + 1/J_g)); published 1.7 Hz."""
    plant, state = rigid
    found = [mode for mode in plant.linearize(state).modes() if "drivetrain" in mode.label and mode.frequency_hz > 0.1]
    expected = np.sqrt(867637000 * (1 / 38759227 + 1 / (97**2 * 534.116))) / (2 * np.pi)
    assert found[0].frequency_hz == pytest.approx(expected, rel=0.005)


def test_bearing_follows_its_command():
    """Step response of the pitch drive: overshoot exp(-pi zeta / sqrt(1 - zeta^2)), 5 Hz."""
    model = fw.Assembly("bearing")
    model.world, model.base = World(), Fixed()
    model.bearing = ActuatedBearing(natural_frequency=5, damping_ratio=0.02)
    model.step = Step(height=0.1, start_time=0.1)
    model.body = RigidBody(mass=1.0, inertia=np.eye(3))
    model.connect(model.base.frame, model.bearing.frame_a)
    model.connect(model.bearing.frame_b, model.body.frame_a)
    model.connect(model.step.y, model.bearing.command)
    result = compiled(model).simulate(0.4, output_step=0.002, tolerance=1e-8)
    angle = np.asarray(result["bearing.angle"])
    assert angle.max() == pytest.approx(0.1 * (1 + np.exp(-np.pi * 0.02 / np.sqrt(1 - 0.0004))), rel=1e-3)
    acceleration = (2 * np.pi * 5) ** 2 * (0.1 * (np.asarray(result["bearing.angle"].time) > 0.1) - angle)
    torque = np.asarray(result["bearing.torque"]) + 0.02 * 2 * 2 * np.pi * 5 * np.gradient(angle, 0.002)
    assert torque[60:-1] == pytest.approx(acceleration[60:-1], abs=0.05)


def test_static_blade_deflection_and_loads():
    """A blade held level, z along world x and flapwise upward: root moment = weight times lever, tip goes down."""
    moments = []
    for part in (FlexibleBlade(properties=BLADE), RigidBlade(mass=17740, centre_of_mass=20.52, inertia=11.78e6)):
        model = fw.Assembly("level blade")
        model.world, model.base = World(gravity=G), Fixed(angles=(0, np.pi / 2, 0))
        model.blade = part
        model.connect(model.base.frame, model.blade.frame_a)
        state = compiled(model).equilibrium() if isinstance(part, FlexibleBlade) else compiled(model).initial_state()
        moments.append(float(state["blade.flapwise_moment"]))
    assert moments[1] == pytest.approx(17740 * 20.52 * G, rel=1e-6)
    assert moments[0] == pytest.approx(moments[1], rel=0.005)


def test_a_rotor_that_turns_the_other_way_is_the_mirror_image():
    plants = [compiled(turbine(tower=1, hinges=1, speed=1.2, rotation=sign)) for sign in (1, -1)]
    found = []
    for plant in plants:
        result = plant.simulate(3.0, output_step=0.5, tolerance=1e-7, start=plant.initial_state())
        names = ("turbine.nacelle.rotor_speed", "turbine.out_of_plane[0]", "turbine.in_plane[0]",
                 "tower.top_fore_aft_displacement", "tower.top_side_side_displacement")  # fmt: skip
        found.append(np.array([np.asarray(result[name]) for name in names]))
    sign = np.array([1, 1, 1, 1, -1])[:, None]
    assert found[0] == pytest.approx(sign * found[1], abs=2e-5)


def test_any_number_of_blades():
    plant = compiled(turbine(tower=0, hinges=1, blades=2, gravity=0.0, speed=1.0))
    state = plant.initial_state()
    tips = [np.ravel(state[f"turbine.blade_{k}.beam.frame_b.r"]) for k in (1, 2)]
    assert tips[0][1] == pytest.approx(-tips[1][1], abs=1e-9)


def test_tower_loads():
    """A body of 350 t, 2 m off the axis: the moments at top and base follow from the weights, rigid and flexible."""
    for part in (RigidTower(height=77.6, mass=249718, centre_of_mass=33.35), FlexibleTower(properties=TOWER)):
        model = fw.Assembly("tower with a head")
        model.world, model.base, model.tower = World(gravity=G), Fixed(), part
        model.head = RigidBody(mass=350e3, inertia=1e7 * np.eye(3), r_cm=(2.0, 1.0, 0.0))
        model.connect(model.base.frame, model.tower.frame_a)
        model.connect(model.tower.frame_b, model.head.frame_a)
        plant = compiled(model)
        state = plant.equilibrium() if isinstance(part, FlexibleTower) else plant.initial_state()
        x, y = (float(state[f"tower.top_{side}_displacement"]) for side in ("fore_aft", "side_side"))
        lever = 2.0 + x
        assert state["tower.base_fore_aft_moment"] == pytest.approx(350e3 * G * lever, rel=0.01)
        assert state["tower.base_side_side_moment"] == pytest.approx(-350e3 * G * (1.0 + y), rel=0.01)
        assert state["tower.top_fore_aft_moment"] == pytest.approx(350e3 * G * 2.0, rel=0.002)


def test_tower_from_diameters():
    tube = {"heights": [10.0, 87.6], "diameters": [6.5, 3.87], "wall_thicknesses": [0.027, 0.019]}
    with pytest.raises(ParameterError, match="either properties, or heights"):
        FlexibleTower(properties=TOWER, **tube)
    found = []
    for given in (tube, {"properties": TOWER}):
        model = fw.Assembly("tower")
        model.world, model.base, model.tower = World(gravity=0.0), Fixed(), FlexibleTower(hinges=3, **given)
        model.connect(model.base.frame, model.tower.frame_a)
        plant = compiled(model)
        found.append(plant.linearize(plant.initial_state()).modes()[0].frequency_hz)
    assert found[0] == pytest.approx(found[1], rel=1e-3)
