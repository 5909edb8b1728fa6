"""The DTU 10-MW turbine against other codes and printed numbers: what docs/dtu10mw.md and the tests share.

`python benchmarks/verification_dtu10mw.py [NAME ...]` computes the tables and writes them into the page.

[H] HAWC2, steady wind without shear, controller in the loop: means of `dtu_10mw_steady_stats.hdf5` in lacbox 0.4.0
(MIT); without tilt and with rigid bodies (`notiltrigid`), and as the turbine is (`tilt`). [S] HAWCStab2, rigid, without
tilt, at 8 m/s and seven rotor speeds: `DTU_10MW_RWT.pwr` there. [C] HAWCStab2, natural frequencies of the turbine that
turns, without weight and air: `dtu_10mw_structural.cmb` there. [B] An independent blade-element calculation with the
data of J. M. Hegseth's public code (thesis NTNU 2020:356): straight blades, one airfoil from 9.8 m to 27.4 m, air of
1.25 kg/m^3.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import verification_iea15 as iea15
from pages import Table, fill, markdown

import fowtlib as fw
from fowtlib.components.aero import BladeAerodynamics, BladeElementRotor, read_blade
from fowtlib.components.aero.bem_steady import RigidRotor
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.modelfile import data_path

PAGE = Path(__file__).parent.parent / "docs" / "dtu10mw.md"
CONE, RPM = np.radians(2.5), np.pi / 30
# wind [m/s]: rotor speed [rpm], pitch [deg], power of the air [kW], thrust [kN]
HAWC2_RIGID = {
    5.0: (5.9969, 1.8964, 825.9, 347.8), 6.0: (5.9968, 0.8627, 1574.3, 493.4), 7.0: (5.9968, 0.0001, 2549.5, 635.8),
    8.0: (6.7481, 0.0, 3798.1, 819.9), 9.0: (7.5896, 0.0, 5404.7, 1037.3), 10.0: (8.4313, 0.0, 7410.8, 1280.2),
    11.0: (9.5969, 0.0, 9869.0, 1591.2), 12.0: (9.5971, 4.4857, 10670.2, 1253.4),
    13.0: (9.5971, 7.1758, 10671.3, 1072.2), 15.0: (9.597, 10.8281, 10673.3, 883.9),
    17.0: (9.597, 13.7142, 10675.4, 773.5), 20.0: (9.597, 17.4205, 10678.6, 669.7),
    22.0: (9.597, 19.6538, 10680.9, 622.9), 24.0: (9.597, 21.7528, 10683.3, 587.3),
}  # fmt: skip
# the same of the flexible turbine with tilt; flapwise root moment [MN m], pitched axes; way of the tip downwind [m]
HAWC2_FLEXIBLE = {
    8.0: (6.7479, 0.0, 3800.4, 811.5, 17.18, 5.33), 12.0: (9.5971, 3.8422, 10681.5, 1270.4, 25.74, 7.53),
    18.0: (9.5970, 14.2903, 10678.3, 740.4, 14.21, 2.88), 24.0: (9.5970, 20.9506, 10682.1, 593.0, 9.73, 0.71),
}  # fmt: skip
# wind [m/s], rotor speed [rpm], power [kW], thrust [kN] at zero pitch
HAWCSTAB2 = [
    (8.000, 5.153988595, 3482.3, 649.44), (8.001, 5.584185581, 3616.0, 699.64), (8.002, 6.014489941, 3705.1, 746.20),
    (8.003, 6.444901676, 3756.3, 790.16), (8.004, 6.875420786, 3772.3, 831.91), (8.005, 7.306047271, 3756.6, 872.35),
    (8.006, 7.736781130, 3711.0, 911.62),
]  # fmt: skip
# wind [m/s]: rpm, pitch [deg]; thrust [MN], power [MW]; T_v [kN s/m], T_speed [MN s], T_pitch [MN/rad], Q_v [MN s],
# Q_speed [MN m s], Q_pitch [MN m/rad], M_v [MN s], of the tilt moment
REFERENCE = {
    8.0: (6.43, 0.0, 0.818, 3.83, 121.5, 0.986, -2.46, 2.110, -8.19, 1.8, 3.47),
    10.0: (8.03, 0.0, 1.277, 7.47, 151.7, 1.233, -3.84, 2.637, -10.22, 2.7, 4.34),
    11.0: (8.84, 0.0, 1.546, 9.95, 167.0, 1.356, -4.65, 2.901, -11.26, 3.4, 4.77),
    12.0: (9.6, 6.09, 1.133, 10.01, 159.2, 0.355, -7.39, 2.425, -9.14, -52.9, 4.41),
    13.0: (9.6, 8.33, 0.993, 9.99, 157.7, -0.064, -7.88, 2.497, -12.52, -73.9, 4.34),
    15.0: (9.6, 11.67, 0.832, 10.00, 158.7, -0.713, -8.46, 2.740, -21.08, -105.3, 4.30),
    19.0: (9.6, 16.85, 0.665, 10.01, 147.4, -1.463, -8.77, 3.072, -38.25, -152.7, 4.19),
    25.0: (9.6, 23.17, 0.551, 10.05, 149.0, -2.609, -9.50, 3.830, -75.35, -225.2, 4.14),
}
QUANTITIES = ("T", "P", "T_v", "T_speed", "T_pitch", "Q_v", "Q_speed", "Q_pitch", "M_v")
# Hz at 6 rpm: tower, and the means of the backward and the forward mode, which lie one turn below and above
CAMPBELL = {"tower fore-aft": 0.2509, "tower side-side": 0.2564, "blade flap": 0.5832, "blade edge": 0.9298}
SECTIONS: dict[str, Callable[[], Table]] = {}


def section(function: Callable[[], Table]) -> Callable[[], Table]:
    """Register a section of the page under the name of its function."""
    SECTIONS[function.__name__] = function
    return function


# --- the rotor ---


@lru_cache(maxsize=1)
def blade() -> BladeAerodynamics:
    """The elements of the blade."""
    paths = [str(data_path(f"dtu10mw/{name}.csv")) for name in ("blade_aerodynamics", "airfoils")]
    return read_blade(*paths, 2.8, 89.1655)


@lru_cache(maxsize=1)
def straight_rotor() -> RigidRotor:
    """Without cone and prebend, as in [B]."""
    return RigidRotor(BladeElementRotor(replace(blade(), curve=None, sweep=None)))


@lru_cache(maxsize=1)
def coned_rotor() -> RigidRotor:
    """With both."""
    return RigidRotor(BladeElementRotor(blade()), CONE)


def coned(wind: float, speed: float, pitch: float) -> tuple[float, float]:
    """Thrust [N] and torque [N m] of this, as a turbine of fowtlib has it, in wind along the shaft."""
    return coned_rotor().thrust_and_torque([wind, 0, 0], speed, pitch)


def prebend_angle(of: BladeAerodynamics) -> np.ndarray:
    """Angle [rad] of the half chords of the prebent blade upwind of the pitch axis, (elements,)."""
    return -np.arctan(np.gradient(of.curve + of.chord / 4 * np.sin(of.twist), of.radius))


def laid_along_the_blade(wind: float, speed: float, pitch: float) -> tuple[float, float]:
    """Thrust [N] and torque [N m] with two things that HAWC2 has and BladeElementAerodynamics has not.

    Sections lie across the prebent blade, not across the pitch axis; and the angle of attack is that at 3/4 of the
    chord, which the turning of the coned section about its span changes by speed sin(cone) chord / 2.
    """
    given, own = blade(), coned_rotor()
    angle = prebend_angle(given)
    across = np.hypot(0.75 * wind, speed * given.radius)
    turned = replace(
        given, length=given.length / np.cos(angle),
        twist=given.twist + speed * np.sin(CONE + angle) * given.chord / 2 / across,
    )  # fmt: skip
    rotor = RigidRotor(BladeElementRotor(turned), own.precone)
    inputs, n = rotor.inputs([wind, 0, 0], speed, pitch), rotor.rotor.nodes
    axes = inputs[3 * n : 12 * n].reshape(n, 3, 3)  # rows: x, y, z of each node
    c, s = np.cos(np.tile(angle, 3))[:, None], np.sin(np.tile(angle, 3))[:, None]
    x, z = axes[:, 0].copy(), axes[:, 2].copy()
    axes[:, 0], axes[:, 2] = c * x + s * z, c * z - s * x
    inputs[3 * n : 12 * n] = axes.ravel()
    loads = rotor.loads(inputs)
    arm = inputs[: 3 * n].reshape(n, 3) - inputs[18 * n : 18 * n + 3]
    return float(loads[:, 0].sum()), float((np.cross(arm, loads[:, :3]) + loads[:, 3:])[:, 0].sum())


def derivatives(wind: float) -> dict[str, float]:
    """Thrust, power and slopes of the straight rotor at a point of REFERENCE, in its units; wake in equilibrium."""
    rpm, degrees = REFERENCE[wind][:2]
    speed, pitch, rotor = rpm * RPM, np.radians(degrees), straight_rotor()
    r = np.tile(rotor.rotor.blade.radius, 3)

    def loads(v: float, w: float, beta: float) -> np.ndarray:
        inputs = rotor.inputs([v, 0, 0], w, beta, air_density=1.25)
        found = rotor.loads(inputs)
        thrust, torque = rotor.thrust_and_torque([v, 0, 0], w, beta, air_density=1.25)
        return np.array([thrust, torque, (found[:, 0] * r).sum() / 2])  # tilt: 3/2 of one blade

    v, w, beta = (
        (loads(wind + a, speed + b, pitch + c) - loads(wind - a, speed - b, pitch - c)) / (2 * (a + b + c))
        for a, b, c in ((0.05, 0, 0), (0, 0.005, 0), (0, 0, 0.002))
    )
    thrust, torque, _ = loads(wind, speed, pitch)
    values = (thrust / 1e6, torque * speed / 1e6, v[0] / 1e3, w[0] / 1e6, beta[0] / 1e6, v[1] / 1e6, w[1] / 1e6,
              beta[1] / 1e6, v[2] / 1e6)  # fmt: skip
    return dict(zip(QUANTITIES, values, strict=True))


def buhl(load: np.ndarray, loss: np.ndarray) -> np.ndarray:
    """Axial induction factor of a thrust coefficient: momentum theory, Buhl's parabola above 0.96 F."""
    light = (1 - np.sqrt(np.clip(1 - load / loss, 0, 1))) / 2
    square, slope = 50 / 9 - 4 * loss, 4 * loss - 40 / 9
    heavy = (np.sqrt(np.maximum(slope**2 - 4 * square * (8 / 9 - load), 0)) - slope) / (2 * square)
    return np.where(load > 0.96 * loss, heavy, light)


def of_hawc2(load: np.ndarray, loss: np.ndarray) -> np.ndarray:
    """The same in HAWC2: a polynomial (H. A. Madsen et al., Wind Energ. Sci. 5 (2020) 1, eq. 2)."""
    x = load / loss
    return 0.2460 * x + 0.0586 * x**2 + 0.0883 * x**3


def annuli(
    wind: float, speed: float, pitch: float, law: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> tuple[float, float]:
    """Thrust [N] and torque [N m] of the straight rotor, written apart from fowtlib: induction factors, bisection."""
    of = straight_rotor().rotor.blade
    r, foils, solidity = of.radius, [of.airfoils[name] for name in of.airfoil], 3 * of.chord / (2 * np.pi * of.radius)
    low, high, swirl = np.full(r.size, -0.5), np.full(r.size, 0.95), np.zeros(r.size)
    for _ in range(50):
        a = (low + high) / 2
        for _ in range(12):
            across, along = wind * (1 - a), speed * r * (1 + swirl)
            phi, square = np.arctan2(across, along), across**2 + along**2
            lift, drag, _ = np.array([foil.at(x) for foil, x in zip(foils, phi - of.twist - pitch, strict=True)]).T
            normal, tangential = (lift * np.cos(phi) + drag * np.sin(phi), lift * np.sin(phi) - drag * np.cos(phi))
            loss = 2 / np.pi * np.arccos(np.exp(-1.5 * (of.tip_radius - r) / (r * np.abs(np.sin(phi)))))
            follows = np.clip(solidity * tangential * square / (4 * loss * across * speed * r), -0.5, 0.5)
            swirl = (swirl + follows) / 2
        small = a < law(solidity * normal * square / wind**2, loss)
        low, high = np.where(small, a, low), np.where(small, high, a)
    pressure = 1.5 * 1.225 * square * of.chord * of.length
    return float((pressure * normal).sum()), float((pressure * tangential * r).sum())


def as_hawc2(wind: float, speed: float, pitch: float) -> tuple[float, float]:
    """Thrust [N] and torque [N m] along the blade, times what HAWC2's induction makes of them in `annuli`."""
    own = laid_along_the_blade(wind, speed, pitch)
    before, after = annuli(wind, speed, pitch, buhl), annuli(wind, speed, pitch, of_hawc2)
    return own[0] * after[0] / before[0], own[1] * after[1] / before[1]


def _beside(reference: float, *own: float) -> list[object]:
    """The reference in full, and how far own values are off."""
    return [f"{reference:.0f}", *(_percent(value, reference) for value in own)]


@section
def dtu10mw_hawc2() -> Table:
    """Rigid rotor at the speed and pitch of HAWC2."""
    rows: list[tuple[object, ...]] = []
    for wind, (rpm, degrees, power, thrust) in HAWC2_RIGID.items():
        given = wind, rpm * RPM, np.radians(degrees)
        found = [rotor(*given) for rotor in (coned, laid_along_the_blade, as_hawc2)]
        powers, thrusts = ([loads[k] * scale for loads in found] for k, scale in ((1, rpm * RPM / 1e3), (0, 1e-3)))
        rows.append((wind, f"{degrees:.2f}", *_beside(power, *powers), *_beside(thrust, *thrusts)))
    heads = ("wind [m/s]", "pitch [deg]", "power of HAWC2 [kW]", "here", "along the blade", "and HAWC2's induction",
             "thrust of HAWC2 [kN]", "here", "along the blade", "and HAWC2's induction")  # fmt: skip
    return heads, rows


@section
def dtu10mw_hawcstab2() -> Table:
    """Rigid rotor at 8 m/s and zero pitch over the rotor speed."""
    rows: list[tuple[object, ...]] = []
    for wind, rpm, power, thrust in HAWCSTAB2:
        given = wind, rpm * RPM, 0.0
        found = [rotor(*given) for rotor in (coned, as_hawc2)]
        powers, thrusts = ([loads[k] * scale for loads in found] for k, scale in ((1, rpm * RPM / 1e3), (0, 1e-3)))
        ratio = f"{rpm * RPM * 89.1655 / wind:.2f}"
        rows.append((f"{rpm:.2f}", ratio, *_beside(power, *powers), *_beside(thrust, *thrusts)))
    heads = ("speed [rpm]", "tip speed ratio", "power of HAWCStab2 [kW]", "here", "as HAWC2",
             "thrust of HAWCStab2 [kN]", "here", "as HAWC2")  # fmt: skip
    return heads, rows


@section
def dtu10mw_derivatives() -> Table:
    """Thrust, power and their slopes: here, and in the reference."""
    rows: list[tuple[object, ...]] = []
    for wind, (_, _, *printed) in REFERENCE.items():
        own = derivatives(wind)
        rows.append((wind, *(f"{own[name]:.4g} ({value:g})" for name, value in zip(QUANTITIES, printed, strict=True))))
    heads = ("wind [m/s]", "T [MN]", "P [MW]", "T_v [kN s/m]", "T_Omega [MN s]", "T_theta [MN/rad]", "Q_v [MN s]",
             "Q_Omega [MN m s]", "Q_theta [MN m/rad]", "M_T,v [MN s]")  # fmt: skip
    return heads, rows


# --- structure ---


def blade_frequencies(hinges: int) -> dict[str, list[float]]:
    """Frequencies [Hz] of one blade at rest without weight and air, by `flap`, `edge` and `torsion`."""
    found = iea15.blade_frequencies(0.0, hinges, table=read_beam(str(data_path("dtu10mw/blade_structure.csv"))))
    return {kind: [hertz for name, hertz in found if name == kind] for kind in ("flap", "edge", "torsion")}


# by finite elements of Timoshenko in the principal axes of the sections, 120 of them, with and without shear
WITHOUT_SHEAR = {"flap": (0.6203, 1.7953, 3.7508), "edge": (0.9510, 2.8947)}
WITH_SHEAR = {"flap": (0.6154, 1.7563, 3.6037), "edge": (0.9372, 2.7915)}


def tower_frequencies(gravity: float, model: str = "dtu10mw_land_rigid", **more: Any) -> dict[str, float]:
    """First bending of the tower, rotor free to turn [Hz]; with rigid blades unless another model is given."""
    calm = {"wind.kind": "none", "world.gravity": gravity, **more}
    plant = fw.load(model, set=calm).compile()
    found: dict[str, float] = {}
    for mode in fw.natural_modes(plant, plant.equilibrium()):
        for name in ("tower fore-aft", "tower side-side"):
            if mode.name.startswith(f"1st {name}"):
                found[name] = mode.frequency
    return found


@section
def dtu10mw_blade() -> Table:
    """First modes of the blade alone, at rest."""
    rows: list[tuple[object, ...]] = []
    for hinges in (6, 10, 20):
        found = blade_frequencies(hinges)
        rows.append((f"{hinges} hinges", *found["flap"][:3], *found["edge"][:2]))
    for name, values in (("finite elements, no shear", WITHOUT_SHEAR), ("finite elements, shear", WITH_SHEAR)):
        rows.append((name, *values["flap"], *values["edge"]))
    return ("blade", "flap 1 [Hz]", "flap 2 [Hz]", "flap 3 [Hz]", "edge 1 [Hz]", "edge 2 [Hz]"), rows


# --- operation ---

LOSSES = {"turbine.control.torque.rated_torque": 211642.2}  # behind 94 % as in the definition
QUIET = {"tower_drag.active": False, "tower_flow.active": False, "wind.shear_exponent": 0.0, "wind.kind": "steady"}


@lru_cache(maxsize=4)
def flexible_operation(wind: float, time: float = 60.0) -> dict[str, float]:
    """Means of the last 20 s of the flexible turbine on land in steady wind, at the rating of HAWC2."""
    set_values = {**QUIET, **LOSSES, "wind.mean_speed": wind}
    result = fw.load("dtu10mw_land", set=set_values).compile().simulate(time, 0.1, solver="fixed")
    return {name: row.mean for name, row in result.statistics(discard=time - 20.0).items()}


@section
def dtu10mw_flexible() -> Table:
    """The flexible turbine on land in steady wind."""
    rows: list[tuple[object, ...]] = []
    for wind in (12.0, 18.0, 24.0):
        _, degrees, power, thrust, moment, tip = HAWC2_FLEXIBLE[wind]
        mean = flexible_operation(wind)
        flap = np.mean([mean[f"blade_root_flapwise_moment_{k}"] for k in (1, 2, 3)]) / 1e6
        out = np.mean([mean[f"blade_tip_out_of_plane_{k}"] for k in (1, 2, 3)])
        rows.append((wind, mean["blade_pitch"], degrees, f"{mean['aero_power']:.0f}", f"{power:.0f}", mean["thrust"],
                     thrust, flap, moment, out, tip))  # fmt: skip
    heads = ("wind [m/s]", "pitch [deg]", "HAWC2", "power [kW]", "HAWC2", "thrust [kN]", "HAWC2",
             "flapwise moment [MN m]", "HAWC2", "tip downwind [m]", "HAWC2")  # fmt: skip
    return heads, rows


def _percent(own: float, reference: float) -> str:
    return f"{100 * (own / reference - 1):+.1f} %"


def main(names: list[str]) -> int:
    """Print the chosen sections, or all, and write them into the page."""
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; there are {', '.join(SECTIONS)}", file=sys.stderr)
        return 2
    for name in names or SECTIONS:
        text = markdown(SECTIONS[name](), 4)
        print(f"{name}\n{text}\n", flush=True)
        PAGE.write_text(fill(PAGE.read_text(encoding="utf-8"), name, text), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
