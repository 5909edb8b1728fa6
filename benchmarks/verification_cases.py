"""What docs/verification.md and tests/verification compute: models in the conditions of a published case, and numbers.

Independent solutions (`surge_pitch`) are plain numpy and share no equation with the components.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import eigh

import fowtlib as fw
from fowtlib.analysis import Decay, Rao, free_decay, linear_rao, simulated_rao
from fowtlib.components.aero import BladeAerodynamics, BladeElementRotor, RigidRotor, read_blade, read_coefficients
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import WorldForce
from fowtlib.components.mechanics.beam_division import divide
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.components.platform.solids import together
from fowtlib.components.servo import TorqueLaw
from fowtlib.components.turbine import SteadyTurbine
from fowtlib.modelfile import data_path
from fowtlib.solving.linear import Mode
from fowtlib.solving.model import Model
from fowtlib.solving.plant import Plant
from fowtlib.solving.results import Statistics

CALM = {"sea.spectrum": "still", "wind.kind": "none"}
WITHOUT_DRAG = {"platform.drag.drag_coefficient": 0.0}
HEAVY_LINES = {"platform.mooring.mass_per_length": 200.0}
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
THRUST = 808e3  # N, the largest of one rotor, for which the two-rotor spar was sized
HUB_HEIGHT = 90.0  # m


def calm_plant(name: str, parameters: dict[str, Any] | None = None) -> Plant:
    """A shipped model in still water without wind."""
    return fw.load(name).with_parameters({**CALM, **(parameters or {})}).compile()


def modes_by_motion(plant: Plant, rest: Any = None) -> dict[str, Mode]:
    """For each motion of the platform the mode in which its state takes part most, about rest (found if not given)."""
    modes = plant.linearize(plant.equilibrium() if rest is None else rest, outputs=[]).modes()
    moving = [mode for mode in modes if np.isfinite(mode.period)]

    def share(mode: Mode, motion: str) -> float:
        return mode.participation[f"platform.motion.{motion}"]

    return {motion: max(moving, key=lambda mode: share(mode, motion)) for motion in MOTIONS}


def free_decays(plant: Plant, offsets: dict[str, float], cycles: float = 5.0) -> dict[str, Decay]:
    """Decay of each motion from an offset [m or deg], for so many cycles of its mode."""
    modes = modes_by_motion(plant)
    return {
        motion: free_decay(plant, motion, offset, duration=cycles * modes[motion].period)
        for motion, offset in offsets.items()
    }


def oc3_line_at(plant: Plant, distance: float) -> dict[str, float]:
    """Tensions [kN] and seabed length [m] of the upwind line in the model, its fairlead so far from its anchor [m]."""
    state = plant.initial_state(start={"platform.motion.surge": distance - 848.67})
    names = {"H": "horizontal_tension", "V": "vertical_tension", "T": "tension"}
    values = {key: float(state[f"platform.mooring.line_2.{name}"]) / 1e3 for key, name in names.items()}
    return {**values, "seabed": float(state["platform.mooring.line_2.seabed_length"])}


def oc3_without_drag() -> Model:
    """The OC3 spar without quadratic drag, whose linear response is exact for small waves."""
    return fw.load("oc3_spar_rigid").with_parameters(WITHOUT_DRAG)


def oc3_rao(frequencies: np.ndarray) -> Rao:
    """Surge, heave and pitch per metre of wave from the linear model, without drag."""
    return linear_rao(oc3_without_drag(), frequencies, outputs=["surge", "heave", "pitch"])


def oc3_rao_of_runs(frequencies: np.ndarray) -> Rao:
    """The same from runs in regular waves of 1 m height."""
    return simulated_rao(
        oc3_without_drag(), frequencies, outputs=["surge", "heave", "pitch"], height=1.0, settle=1200.0, periods=5
    )


def heave_limit() -> float:
    """Heave of the OC3 spar per metre of a very long wave: C33/(C33 + K), with the heave stiffness K of the lines.

    A free spar follows with 1. K is the difference of the static load of the lines, 10 cm up and down.
    """
    root = fw.load("oc3_spar_rigid").root
    data = root.find("platform.water").database
    up, down = (root.find("platform.mooring").static_load((0, 0, z))[0][2] for z in (0.1, -0.1))
    return float(data.C[2, 2] / (data.C[2, 2] + (down - up) / 0.2))


def oc3_load_case_5_1() -> Statistics:
    """OC3 load case 5.1: steady wind of 8 m/s without shear, regular waves of 6 m and 10 s. The last 400 s of 800 s."""
    conditions = {
        "wind.kind": "steady", "wind.mean_speed": 8.0, "wind.shear_exponent": 0.0,
        "sea.spectrum": "regular", "sea.wave_height": 6.0, "sea.wave_period": 10.0,
    }  # fmt: skip
    plant = fw.load("oc3_spar_rigid").with_parameters(conditions).compile()
    return plant.simulate(800.0, 0.2).statistics(400.0)


def two_rotors_in(yaw_gain: float, wind: str = "kaimal", seed: int = 1, duration: float = 1000.0) -> fw.Result:
    """Two rotors at 11.4 m/s (intensity 0.17) in waves of Hs 3.1 m, Tp 10.1 s; yaw_gain 0 is PI control alone."""
    conditions = {"yaw_gain": yaw_gain, "wind.kind": wind, "sea.seed": seed}
    if wind == "kaimal":
        conditions["wind.seed"] = seed
    return fw.load("two_rotor_spar_rigid").with_parameters(conditions).compile().simulate(duration, 0.25)


def two_rotors_pushed(force: float = THRUST) -> Plant:
    """The two-rotor spar in calm weather with a steady force [N] downwind at each hub."""
    model = fw.load("two_rotor_spar_rigid").with_parameters(CALM)
    for side in ("left", "right"):
        push = model.root.add(f"push_{side}", WorldForce())
        thrust = model.root.add(f"force_{side}", Constant(value=(force, 0, 0)))
        model.root.connect(model.root.find(f"arm_{side}").frame_b, push.frame)
        model.root.connect(thrust.y, push.force)
    return model.compile()


def two_rotor_balance() -> list[tuple[str, float]]:
    """Vertical forces on the two-rotor spar at its published draft [MN, upward], and where it floats at rest [m]."""
    root = fw.load("two_rotor_spar_rigid").root
    data = root.find("platform.water").database
    buoyancy = data.rho * data.g * data.volume
    weight = -data.g * sum(mass for mass, _, _ in bodies(root))
    lines = root.find("platform.mooring").static_load()[0][2]
    rest = float(calm_plant("two_rotor_spar_rigid").equilibrium()["heave"])
    return [
        ("buoyancy [MN]", buoyancy / 1e6),
        ("weight [MN]", weight / 1e6),
        ("lines [MN]", lines / 1e6),
        ("sum [MN]", (buoyancy + weight + lines) / 1e6),
        ("sum over waterplane stiffness [m]", (buoyancy + weight + lines) / data.C[2, 2]),
        ("heave of the model at rest [m]", rest),
    ]


@dataclass(frozen=True)
class SurgePitch:
    """Mass and stiffness (2, 2) of surge and pitch about the axis at the still water level [SI], without damping."""

    mass: np.ndarray
    stiffness: np.ndarray
    surge_period: float
    pitch_period: float

    def static(self, force: float, height: float) -> np.ndarray:
        """Surge [m] and pitch [rad] under a horizontal force [N] at a height [m]."""
        return np.linalg.solve(self.stiffness, force * np.array([1.0, height]))


def surge_pitch(model: Model, heave: float = 0.0) -> SurgePitch:
    """Surge and pitch of an upright spar as two coupled oscillators, by textbook formulas; `heave` [m] at rest.

    Bodies by mass, height and inertia; added mass at the lowest frequency of the data; buoyancy and waterplane from the
    data, the weight of the bodies added; the lines by differences of their static load, acting at the fairleads: a
    horizontal spring, and a vertical load that hangs there like a weight. The ring of fairleads counts as a point.
    """
    root, g = model.root, 9.80665
    water = root.find("platform.water")
    data = water.database
    mooring = root.find("platform.mooring")
    depth, step = -float(mooring.fairlead_depth), 0.5
    force, _ = mooring.static_load((0, 0, heave))
    ahead, _ = mooring.static_load((step, 0, heave))
    behind, _ = mooring.static_load((-step, 0, heave))
    spring = (behind[0] - ahead[0]) / (2 * step)
    mass, moment, inertia, weight = np.sum(
        [(m, m * z, iyy + m * (x * x + z * z), m * g * z) for m, (x, _, z), iyy in bodies(root)], axis=0
    )
    added = data.A[0]
    M = np.array([[mass + added[0, 0], moment + added[0, 4]], [moment + added[4, 0], inertia + added[4, 4]]])
    hanging = data.C[4, 4] - weight + force[2] * depth
    K = np.array([[spring, spring * depth], [spring * depth, spring * depth**2 + hanging]])
    slow, fast = np.sqrt(eigh(K, M, eigvals_only=True))
    return SurgePitch(M, K, 2 * np.pi / slow, 2 * np.pi / fast)


def oo_star_hydrostatics(model: Model) -> dict[str, tuple[float, float]]:
    """Numbers of the OO-Star with two rotors, and those printed in table 7.5 of the thesis; C44 recomputed from these.

    Printed is a C44 of 2.16e9 N m, with a centre of mass 3.42 m above that of buoyancy, though 14.2 - 10.24 is 3.96 m.
    """
    hull = model.root.find("platform.hull").hull()
    extra = hull.fills["platform.hull.middle_column.extra"]
    floater = together([hull.structure, *(fill for fill in hull.fills.values() if fill is not extra)])
    tower, arm = model.root.find("tower"), model.root.find("arm_left")
    above = float(tower.mass), 2 * float(model.root.find("turbine_left").mass)
    mass = hull.mass.mass + sum(above)
    moment = above[0] * float(tower.r_cm[2]) + above[1] * float(arm.r[2])
    centre = (hull.mass.mass * hull.mass.centre[2] + moment) / mass
    water, rho_g = hull.buoyancy, 1025.0 * 9.80665
    righting = rho_g * (water.waterplane[3, 3] + water.volume * (water.centre[2] - centre))
    return {
        "displaced volume [m^3]": (water.volume, 2.35e4),
        "centre of buoyancy [m]": (water.centre[2], -14.2),
        "waterplane [m^2]": (water.waterplane[2, 2], 548.8),
        "its second moment [m^4]": (water.waterplane[3, 3], 2.95e5),
        "C33 [N/m]": (rho_g * water.waterplane[2, 2], 5.51e6),
        "C44 [N m]": (righting, rho_g * (2.95e5 + 2.35e4 * (10.24 - 14.2))),
        "floater: mass [kg]": (floater.mass, 2.17e7),
        "floater: centre of mass [m]": (floater.centre[2], -15.2),
        "floater: inertia in roll and pitch [kg m^2]": (floater.inertia[1, 1], 9.43e9),
        "floater: inertia in yaw [kg m^2]": (floater.inertia[2, 2], 1.63e10),
        "whole: mass [kg]": (mass, 2.36e7),
        "whole: centre of mass [m]": (centre, -10.24),
    }


# Periods [s] of the OO-Star with two rotors, table 7.7 of the thesis, and offsets [m, deg] of the decays here.
OO_STAR_PERIODS = {"surge": 147.5, "heave": 18.5, "pitch": 23.8, "yaw": 108.6}
OO_STAR_OFFSETS = {"surge": 5.0, "heave": 3.0, "pitch": 5.0, "yaw": 8.0}


def bodies(root: Any) -> list[tuple[float, np.ndarray, float]]:
    """(mass, place of the centre of mass, inertia about y) of the bodies of the two shipped models."""
    places = {"platform.hull": None, "platform.structure": None, "tower": None, "turbine": "tower_to_hub",
              "turbine_left": "arm_left", "turbine_right": "arm_right"}  # fmt: skip
    found = []
    for path, at in places.items():
        owner, _, name = path.rpartition(".")
        if name not in root.find(owner).parts:
            continue
        part = root.find(path)
        place = np.array(part.centre_of_mass if at else part.r_cm, dtype=float)
        place = place + np.array(root.find(at).r, dtype=float) if at else place
        found.append((float(part.mass), place, float(np.array(part.inertia, dtype=float)[1, 1])))
    return found


# NREL 5 MW, published. Wind speed [m/s]: electrical power [kW] and thrust [kN] of NREL/turbine-models,
# NREL_Reference_5MW_126.csv (OpenFAST, elastic); blade pitch [deg] of NREL/TP-500-38060 (2009), table 7-1.
NREL_5MW_CURVE = {
    4: (177.67, 121.90), 6: (737.59, 236.23), 8: (1771.17, 384.00), 10: (3448.38, 597.48), 12: (5000.0, 595.94),
    15: (5000.02, 426.43), 18: (5000.03, 354.36), 20: (5000.04, 324.77), 25: (5000.04, 275.29),
}  # fmt: skip
NREL_5MW_PITCH = {
    12: 3.83, 13: 6.60, 14: 8.70, 15: 10.45, 16: 12.06, 17: 13.54, 18: 14.92, 19: 16.23, 20: 17.47, 21: 18.70,
    22: 19.94, 23: 21.18, 24: 22.35, 25: 23.47,
}  # fmt: skip
NREL_5MW_EFFICIENCY = 0.944
PRECONE, TILT = np.radians(2.5), np.radians(5.0)


def nrel5mw_blade(**changes: Any) -> BladeAerodynamics:
    """The blade of the shipped data; changes as in dataclasses.replace, or moments=False: airfoils without moments."""
    moments = changes.pop("moments", True)
    files = (str(data_path(f"nrel5mw/{name}.csv")) for name in ("blade_aerodynamics", "airfoils"))
    blade = replace(read_blade(*files, hub_radius=1.5, tip_radius=63.0), **changes)
    if moments:
        return blade
    foils = blade.airfoils.items()
    plain = {name: replace(foil, coefficients=foil.coefficients * np.array([1, 1, 0])) for name, foil in foils}
    return replace(blade, airfoils=plain)


def nrel5mw_steady() -> SteadyTurbine:
    """The turbine with the table of its own blade elements that is shipped, and the controller of the definition."""
    table = read_coefficients(str(data_path("nrel5mw/rotor_coefficients_bem.csv")))
    return SteadyTurbine(table, 63.0, TorqueLaw(), 97.0, precone=PRECONE, tilt=TILT)


def land_turbine(wind: float) -> Statistics:
    """The flexible turbine on land in steady, uniform wind; without the first 80 s of 100 s.

    The published curves have no influence of the tower on the wind, so it is off.
    """
    bare = {"tower_drag.active": False, "tower_flow.active": False}
    model = fw.load("nrel5mw_land").with_parameters({"wind.kind": "steady", "wind.mean_speed": wind, **bare})
    return model.compile().simulate(100.0).statistics(discard=80.0)


def largest_power_coefficient(
    rotor: BladeElementRotor, *, precone: float = PRECONE, tilt: float = 0.0, shear: float = 0.0, straight: bool = False
) -> tuple[float, float]:
    """Largest C_p at zero pitch over tip speed ratios in steps of 0.1, with the area of the coned rotor; and where.

    shear: exponent of the wind over the height, with the wind at the hub in C_p and the mean over the azimuth.
    straight: line loads go in straight lines from node to node, and to zero at the ends, as CCBlade integrates them.
    """
    rigid, wind, hub, n = RigidRotor(rotor, precone, tilt), 8.0, 90.0, rotor.nodes
    area, found = np.pi * (63 * np.cos(precone)) ** 2, []
    weights = _to_zero_at_the_ends(rotor.blade) if straight else rotor.blade.length
    share = np.tile(weights / rotor.blade.length, rotor.blades)[:, None]
    for ratio in np.arange(6.5, 9.01, 0.1):
        speed, torques = ratio * wind / 63, []
        for azimuth in np.arange(0, 120, 20) if shear or tilt else [0]:
            inputs = rigid.inputs([wind, 0, 0], speed, azimuth=np.radians(azimuth), hub=(0, 0, hub))
            height = inputs[: 3 * n].reshape(n, 3)
            blown = np.outer(wind * (height[:, 2] / hub) ** shear, [1, 0, 0])
            loads = share * rigid.loads(rigid.inputs(blown, speed, azimuth=np.radians(azimuth), hub=(0, 0, hub)))
            moment = np.cross(height - [0, 0, hub], loads[:, :3]) + loads[:, 3:]
            torques.append(rigid.hub_axes()[:, 0] @ moment.sum(axis=0))
        found.append((float(np.mean(torques)) * speed / (0.5 * 1.225 * area * wind**3), float(ratio)))
    return max(found)


def _to_zero_at_the_ends(blade: BladeAerodynamics) -> np.ndarray:
    """Weights of the nodes in the trapezoidal rule from the hub to the tip, where the loads are zero."""
    r = np.concatenate([[blade.hub_radius], blade.radius, [blade.tip_radius]])
    return (r[2:] - r[:-2]) / 2


def finer(blade: BladeAerodynamics, times: int) -> BladeAerodynamics:
    """The same blade with each element cut in `times` equal ones; chord and twist linear between the old nodes."""
    ends = blade.hub_radius + np.concatenate([[0], np.cumsum(blade.length)])
    ends[-1] = blade.tip_radius
    parts = [np.linspace(a, b, times + 1)[:-1] for a, b in zip(ends[:-1], ends[1:], strict=True)]
    borders = np.concatenate([*parts, [blade.tip_radius]])
    r = (borders[1:] + borders[:-1]) / 2
    on = {name: np.interp(r, blade.radius, getattr(blade, name)) for name in ("chord", "twist", "curve", "sweep")}
    return replace(blade, radius=r, airfoil=[name for name in blade.airfoil for _ in range(times)],
                   length=np.diff(borders), **on)  # fmt: skip


def coarser(blade: BladeAerodynamics) -> BladeAerodynamics:
    """The same blade with each two elements from the tip on as one, in its middle; the airfoil is that of the outer."""
    borders = blade.hub_radius + np.concatenate([[0], np.cumsum(blade.length)])
    borders[-1] = blade.tip_radius
    kept = np.sort(np.concatenate([np.arange(len(blade.length), 0, -2), [0]]))
    r = (borders[kept][1:] + borders[kept][:-1]) / 2
    on = {name: np.interp(r, blade.radius, getattr(blade, name)) for name in ("chord", "twist", "curve", "sweep")}
    foils = [blade.airfoil[k - 1] for k in kept[1:]]
    return replace(blade, radius=r, airfoil=foils, length=np.diff(borders[kept]), **on)


def line_loads(times: float, kind: str, wind: float = 9.0, speed: float = 1.0789) -> tuple[float, float, float]:
    """Thrust [kN], torque [kN m] and flapwise moment at the root of one blade [kN m], of the rigid rotor without tilt.

    times: elements for one of the published blade, 0.5 or a whole number; kind: see BladeElementRotor.line_loads.
    """
    blade = nrel5mw_blade()
    made = coarser(blade) if times < 1 else finer(blade, int(times))
    rigid = RigidRotor(BladeElementRotor(made, line_loads=kind), PRECONE)
    inputs = rigid.inputs([wind, 0, 0], speed)
    loads, stations = rigid.loads(inputs), len(made.radius)
    thrust, torque = rigid.thrust_and_torque([wind, 0, 0], speed)
    moment = loads[:stations, :3] @ [np.cos(PRECONE), 0, np.sin(PRECONE)] @ (made.radius - made.hub_radius)
    return thrust / 1e3, torque / 1e3, float(moment) / 1e3


def rotor_masses(hinges: int) -> tuple[float, float, float, float]:
    """Mass [kg], first moment [kg m], inertia [kg m^2] of the NREL blade about its root, and inertia of the rotor.

    From the segments of a blade with so many hinges. About the root: the mean over the directions across the blade. The
    rotor: three coned blades and the hub, about the shaft.
    """
    segments = divide(read_beam(str(data_path("nrel5mw/blade_structure.csv"))), hinges, "free_tip").segments
    mass = np.array([s.mass for s in segments])
    z = np.array([s.centre[2] for s in segments])
    across = np.array([(s.inertia[0, 0] + s.inertia[1, 1]) / 2 for s in segments])
    shaft, rotor = np.array([np.cos(PRECONE), 0.0, np.sin(PRECONE)]), 115926.0
    for s in segments:
        arm = s.centre + [0, 0, 1.5]
        rotor += 3 * (shaft @ s.inertia @ shaft + s.mass * (arm @ arm - (arm @ shaft) ** 2))
    return float(mass.sum()), float(mass @ z), float((across + mass * z**2).sum()), float(rotor)
