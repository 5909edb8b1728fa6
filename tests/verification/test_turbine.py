"""The complete NREL 5-MW turbine, on land and on the OC3 spar, against its definition, NREL's results and mechanics.

[D] J. Jonkman, S. Butterfield, W. Musial, G. Scott, Definition of a 5-MW Reference Wind Turbine, NREL/TP-500-38060
(2009). [T] O. El Beshbichi, PhD thesis, University of Stavanger (2023), table 3.2: FAST v8 and a Modelica model of 2
tower hinges and 6 blade hinges. docs/verification.md and docs/load_cases.md have the tables.
"""

import numpy as np
import pytest
import verification_by_hand as by_hand
import verification_cases as cases
import verification_modes as modes

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.mechanics import Fixed, RigidBody
from fowtlib.components.mechanics.beam_division import divide
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.components.support import FlexibleTower
from fowtlib.components.turbine import Drivetrain, Hub, Nacelle, RotorNacelleAssembly
from fowtlib.modelfile import data_path

BLADE, TOWER = data_path("nrel5mw/blade_structure.csv"), data_path("oc3_hywind/tower.csv")
CONE, TILT, G = np.radians(2.5), np.radians(5.0), 9.80665


# --- natural frequencies, [T] table 3.2 ---

FAST_PLATFORM = {"surge": 0.008, "sway": 0.008, "heave": 0.032, "roll": 0.034, "pitch": 0.034, "yaw": 0.121}
FAST_LOCKED = {"tower fore-aft 1": 0.473, "tower side-side 1": 0.457, "blade flap 1": 0.666, "blade edge 1": 1.080}


@pytest.fixture(scope="module")
def locked():
    return modes.frequencies("oc3_spar", 2, 6, locked=True)


@pytest.fixture(scope="module")
def free():
    return modes.frequencies("oc3_spar", 2, 6, locked=False)


@pytest.mark.parametrize("motion", FAST_PLATFORM)
def test_platform_frequencies(free, motion):
    """Within 2 % of FAST, or within the last digit printed."""
    assert free[motion][0] == pytest.approx(FAST_PLATFORM[motion], rel=0.02, abs=5e-4)


@pytest.mark.parametrize("mode", FAST_LOCKED)
def test_first_tower_and_blade_frequencies(locked, mode):
    """With a locked generator, as in FAST's eigenanalysis; of the blades the lowest of the three modes."""
    assert locked[mode][0] == pytest.approx(FAST_LOCKED[mode], rel=0.03)


def test_a_free_generator_raises_side_side_bending_only(free, locked):
    """The rotor follows the nacelle in roll unless it is locked; fore-aft does not know the difference."""
    assert free["tower side-side 1"][0] > 1.06 * locked["tower side-side 1"][0]
    assert free["tower fore-aft 1"][0] == pytest.approx(locked["tower fore-aft 1"][0], rel=1e-3)


def test_drive_train_torsion(free, locked):
    """Free at both ends 1.700 Hz [T]; against the locked generator 0.6205 Hz on land, [D] table 9-1 (ADAMS: 0.6094)."""
    assert free["drivetrain"][0] == pytest.approx(1.700, rel=0.02)
    assert locked["drivetrain"][0] == pytest.approx(0.6205, rel=0.04)


@pytest.mark.parametrize(("motion", "hertz", "time"), [("surge", 0.00807, 400.0), ("pitch", 0.0335, 120.0)])
def test_damping_of_every_half_cycle_of_the_platform_with_its_turbine(motion, hertz, time):
    """From 10 m and 10 deg against an independent rigid spar; vacuum, rigid blades, flexible tower."""
    calm = {**cases.CALM, "world.air_density": 0.0, "turbine.assembly.blade_hinges": 0}
    plant = fw.load("oc3_spar", set=calm).compile()
    decay = cases.free_decay(plant, motion, 10.0, duration=time, tolerance=1e-4, hold=modes.HELD)
    spar = by_hand.SurgeAndPitch(fw.load("oc3_spar_rigid"), 2 * np.pi * hertz)
    offset = {"surge": (10.0, 0.0), "pitch": (0.0, 10.0)}[motion]
    own = dict(zip(("surge", "pitch"), spar.decay(*offset, duration=1.5 * time), strict=True))[motion]
    count = min(decay.damping.size, own.damping.size)
    assert count >= 3
    assert decay.damping[:count] == pytest.approx(own.damping[:count], rel=0.06)
    assert decay.damping_ratio == pytest.approx({"surge": 0.097, "pitch": 0.063}[motion], rel=0.15)  # FAST, [T] LC 2.3


# --- masses, [D] tables 2-2 and 1-1 ---


@pytest.mark.parametrize("hinges", range(13))
def test_blade_and_rotor_inertia(hinges):
    """17,740 kg, 363,231 kg m, 11,776,047 kg m^2 about the root; 38,759,227 kg m^2 of the coned rotor and its hub."""
    own = cases.rotor_masses(hinges)
    assert own == pytest.approx((17740, 363231, 11776047, 38759227), rel=0.005)


# --- steady operation ---

# NREL's table of steady operation by FAST (NREL/turbine-models, Offshore/NREL_5MW_126_RWT.csv): electrical power [kW]
# and force on the shaft [kN], with the weight of the rotor along the tilted shaft; without influence of the tower,
# which is off here, too. Pitch [deg]: [D] table 7-1; rpm.
# At 11.4 m/s rigid blades already give more than rated power and pitch a little: there FAST's row of 11.5 m/s is taken.
STEADY = {8.0: (1771.1, 478.0, 0.0), 11.4: (5000.02, 771.67, 0.0), 18.0: (5000.0, 448.4, 14.92)}
ROTOR_WEIGHT = 110e3 * G * np.sin(TILT) / 1e3  # kN


def steady_run(speed, tower_hinges, blade_hinges, time):
    conditions = {"wind.kind": "steady", "wind.mean_speed": speed, "wind.shear_exponent": 0.0,
                  "tower.hinges": tower_hinges, "turbine.assembly.blade_hinges": blade_hinges,
                  "tower_drag.active": False, "tower_flow.active": False}  # fmt: skip
    result = fw.load("nrel5mw_land", set=conditions).compile().simulate(time, 0.1, tolerance=1e-4)
    return {name: row.mean for name, row in result.statistics(discard=time - 15.0).items()}


@pytest.mark.parametrize("speed", STEADY)
def test_steady_operation_with_rigid_blades(speed):
    power, force, pitch = STEADY[speed]
    mean = steady_run(speed, 0, 0, 60.0)
    assert mean["generator_power"] == pytest.approx(power, rel=0.03)
    assert mean["thrust"] + ROTOR_WEIGHT == pytest.approx(force, rel=0.03)
    if speed == 11.4:
        assert 0 < mean["blade_pitch"] < 2
    else:
        assert mean["blade_pitch"] == pytest.approx(pitch, abs=0.05)
    if speed > 11:
        assert mean["rotor_speed"] == pytest.approx(12.1, rel=1e-3)


def test_steady_operation_with_flexible_blades():
    """At 11.4 m/s the tips bend 5.5 m downwind (read from figure 9-2 of [D], to 0.3 m)."""
    mean = steady_run(11.4, 2, 4, 40.0)
    assert mean["generator_power"] == pytest.approx(5000, rel=0.03)
    assert mean["thrust"] + ROTOR_WEIGHT == pytest.approx(805, rel=0.03)
    tips = [mean[f"blade_tip_out_of_plane_{k}"] for k in (1, 2, 3)]
    assert np.mean(tips) == pytest.approx(5.5, abs=0.3)


# --- mechanics ---


def turbine(*, tower_hinges=0, blade_hinges=3, gravity=0.0, speed=0.0, azimuth=0.0, hinge_damping=0.0):
    """Rotor, nacelle and tower of the OC3 turbine on a fixed base, without any damping unless given."""
    model = fw.Assembly("turbine on a fixed base")
    model.world, model.base = World(gravity=gravity), Fixed()
    model.tower = FlexibleTower(properties=str(TOWER), hinges=tower_hinges, damping_fore_aft=hinge_damping)
    model.turbine = RotorNacelleAssembly(
        nacelle=Nacelle(mass=240e3, centre_of_mass=(1.9, 0, 1.75), inertia=np.diag([0, 0, 1741490.0]),
                        shaft_height=1.96256, tilt=TILT, overhang=5.0191, azimuth_start=azimuth),
        hub=Hub(precone=CONE, radius=1.5, mass=56780.0, inertia=115926.0),
        drivetrain=Drivetrain(gear_ratio=97.0, stiffness=867637000.0, damping=0.0, generator_inertia=534.116),
        blade_properties=str(BLADE), blade_hinges=blade_hinges, damping_flapwise=hinge_damping, rotor_speed_start=speed,
    )  # fmt: skip
    model.connect(model.base.frame, model.tower.frame_a)
    model.connect(model.tower.frame_b, model.turbine.frame)
    return model


def bodies(root, path=""):
    """(path, mass, centre, inertia) of every body of a model, in its frame."""
    for name, one in root.parts.items():
        where = f"{path}.{name}" if path else name
        if isinstance(one, RigidBody):
            yield where, float(one.mass), np.array(one.r_cm, float), np.array(one.inertia, float)
        yield from bodies(one, where)


def springs(chain, path, hinges):
    """(path of the angle, stiffness) of the hinges of a beam."""
    for i in range(hinges):
        for axis, stiffness in (("x", chain.stiffness_x), ("y", chain.stiffness_y)):
            yield f"{path}.beam.hinge_{i + 1}.bending.phi_{axis}", stiffness[i]


def energy(result, root, tower_hinges, blade_hinges):
    """Kinetic and elastic energy over time, of bodies, hinges, shaft and generator, in plain numpy."""
    total = np.zeros(result.time.size)
    for path, mass, _, inertia in bodies(root):
        v, w, R = (np.asarray(result[f"{path}.{name}"]) for name in ("v", "frame_a.w", "frame_a.R"))
        local = np.einsum("tij,ti->tj", R.reshape(-1, 3, 3), w)
        total += mass / 2 * (v**2).sum(axis=1) + np.einsum("ti,ij,tj->t", local, inertia, local) / 2
    found = list(springs(divide(read_beam(str(TOWER)), tower_hinges, "loaded_tip"), "tower", tower_hinges))
    for k in (1, 2, 3):
        chain = divide(read_beam(str(BLADE)), blade_hinges, "free_tip")
        found += springs(chain, f"turbine.blade_{k}", blade_hinges)
    total += sum(stiffness / 2 * np.asarray(result[path]) ** 2 for path, stiffness in found)
    twist = np.asarray(result["turbine.drivetrain.torsion.twist"])
    generator = np.asarray(result["turbine.drivetrain.generator_speed"])
    return total + 867637000 / 2 * twist**2 + 534.116 / 2 * generator**2


def test_energy_of_a_turning_turbine_in_vacuum():
    """Unbent blades that begin to turn at 12 rpm bend, tower and shaft swing: no damping, no gravity, no loss."""
    plant = fw.load(turbine(tower_hinges=2, blade_hinges=3, speed=1.27)).compile()
    result = plant.simulate(3.0, 0.05, tolerance=1e-9)
    total = energy(result, plant.root, 2, 3)
    assert np.ptp(np.asarray(result["turbine.out_of_plane[0]"])) > 0.1  # m; there is elastic energy to speak of
    assert np.ptp(total) < 1e-6 * total[0]


@pytest.mark.parametrize("azimuth", [0.0, np.pi / 2, 2.0])
def test_moments_of_a_parked_blade_are_statics(azimuth):
    """The root of a blade at rest carries its first moment times gravity, by rotations of its own: tilt, azimuth, cone.

    Bending shifts the weight by 0.3 m at most: 1 % of the moment.
    """
    model = turbine(blade_hinges=4, gravity=G, azimuth=azimuth)
    plant = fw.load(model).compile()
    hold = {"turbine.nacelle.bearing.phi": azimuth, "turbine.nacelle.bearing.w": 0.0}
    state = plant.equilibrium(hold=hold)
    down = rotation_y(-CONE).T @ rotation_x(azimuth).T @ rotation_y(TILT).T @ [0, 0, -G]
    expected = 364043 * np.cross([0, 0, 1], down)  # first moment of the table, models/SOURCES.md
    size = 364043 * G
    assert state["turbine.blade_1.edgewise_moment"] == pytest.approx(expected[0], abs=0.01 * size)
    assert state["turbine.blade_1.flapwise_moment"] == pytest.approx(expected[1], abs=0.01 * size)


def rotation_x(angle):
    s, c = np.sin(angle), np.cos(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def rotation_y(angle):
    s, c = np.sin(angle), np.cos(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
