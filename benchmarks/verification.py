"""The numbers of docs/verification.md.

`make verification` computes all of them and writes them into the page, between the marks of each section;
`python benchmarks/verification.py NAME ...` does so for some. References:

- OC3: J. Jonkman, Definition of the Floating System for Phase IV of OC3, NREL/TP-500-47535 (2010); J. Jonkman and
  W. Musial, OC3 for IEA Wind Task 23, NREL/TP-5000-48191 (2010).
- Thesis: O. El Beshbichi, PhD thesis, University of Stavanger (2023), whose Modelica model has the same physics.

What tests/verification checks as well is computed in verification_cases.py. Pictures go to docs/figures.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import oc4_motions
import pitch_step
import verification_cases as cases
import verification_iea15 as iea15
import verification_modes as turbine_modes
from pages import Table, fill, markdown

PAGE = Path(__file__).parent.parent / "docs" / "verification.md"
FIGURES = PAGE.parent / "figures"
SECTIONS: dict[str, Callable[[], Table]] = {}


def section(function: Callable[[], Table]) -> Callable[[], Table]:
    """Register a section of the page under the name of its function."""
    SECTIONS[function.__name__] = function
    return function


@section
def mooring_line() -> Table:
    """The upwind line of the OC3 model: fairlead tension over the distance of the fairlead from the anchor."""
    plant = cases.calm_plant("oc3_spar_rigid")
    reference = {800: 353.5, 820: 474.8, 840: 721.1, 848.67: 911.1, 855: 1107.9, 865: 1688.1, 880: 5660.0}
    rows = []
    for distance, tension in reference.items():
        own = cases.oc3_line_at(plant, distance)["T"]
        rows.append((distance, own, tension, _percent(own, tension)))
    return ("distance [m]", "tension [kN]", "independent solution [kN]", "difference"), rows


@section
def steady_operation() -> Table:
    """The NREL 5 MW by blade elements and its controller, rigid blades, against its published steady curve."""
    turbine, rows = cases.nrel5mw_steady(), []
    for wind in sorted({*cases.NREL_5MW_CURVE, *cases.NREL_5MW_PITCH}):
        point = turbine.operating_point(wind)
        pitch, power = np.degrees(point.blade_pitch), cases.NREL_5MW_EFFICIENCY * point.aero_power / 1e3
        published = cases.NREL_5MW_PITCH.get(wind, 0.0 if wind < 12 else "")
        row = [wind, f"{pitch:.2f}", published, f"{pitch - published:+.2f}" if published != "" else ""]
        for own, other in zip((power, point.thrust / 1e3), cases.NREL_5MW_CURVE.get(wind, ("", "")), strict=True):
            row += [own, other, _percent(own, other) if other != "" else ""]
        rows.append(tuple(row))
    heads = ("wind [m/s]", "pitch [deg]", "published", "difference", "electrical power [kW]", "published", "difference",
             "thrust [kN]", "published", "difference")  # fmt: skip
    return heads, rows


@section
def bending_blades() -> Table:
    """The model nrel5mw_land in steady wind against the published steady curve."""
    rows = []
    for wind in (8, 12, 18, 25):
        result = cases.land_turbine(float(wind))
        pitch, published = result["blade_pitch"].mean, cases.NREL_5MW_PITCH.get(wind, 0.0)
        row = [wind, f"{pitch:.2f}", f"{published:.2f}", f"{pitch - published:+.2f}"]
        for name, other in zip(("generator_power", "thrust"), cases.NREL_5MW_CURVE[wind], strict=True):
            row += [result[name].mean, other, _percent(result[name].mean, other)]
        rows.append(tuple(row))
    heads = ("wind [m/s]", "pitch [deg]", "published", "difference", "electrical power [kW]", "published", "difference",
             "thrust [kN]", "published", "difference")  # fmt: skip
    return heads, rows


@section
def line_loads() -> Table:
    """Thrust, torque and root moment of the NREL 5 MW in 9 m/s by both integrals, over the number of elements."""
    rows = []
    for times in (0.5, 1, 2, 4, 8, 16):
        row: list[object] = []
        for kind in ("elements", "straight_lines"):
            loads = cases.line_loads(times, kind)
            row += [f"{value:.2f}" for value in loads]
        rows.append((int(17 * times) if times >= 1 else 9, *row))
    names = ("thrust [kN]", "torque [kN m]", "root moment [kN m]")
    return ("elements", *(f"{name}, {kind}" for kind in ("elements", "straight lines") for name in names)), rows


@section
def largest_power_coefficient() -> Table:
    """C_p of the NREL 5 MW by blade elements at zero pitch, and what each assumption does to it."""
    from fowtlib.components.aero import BladeElementRotor

    blade = cases.nrel5mw_blade()
    rotor = BladeElementRotor(blade)
    bare = BladeElementRotor(cases.nrel5mw_blade(moments=False, curve=None, sweep=None))
    tilted = {"tilt": cases.TILT}
    ccblade = {"straight": True}
    rows = []
    for name, made, options in (
        ("rigid, coned, wind along the shaft: the rotor of the shipped table", rotor, {}),
        ("no drag in the induction", replace(rotor, axial_drag=False, tangential_drag=False), {}),
        ("no tip loss", replace(rotor, tip_loss=False), {}),
        ("no hub loss", replace(rotor, hub_loss=False), {}),
        ("four times as many elements", BladeElementRotor(cases.finer(blade, 4)), {}),
        ("no sweep, no moments of the airfoils", bare, {}),
        ("the same, tilt 5 deg", bare, tilted),
        ("the same, line loads integrated as in CCBlade, no tilt, no cone", bare, {**ccblade, "precone": 0.0}),
        ("the same, coned", bare, ccblade),
        ("the same, tilt 5 deg, wind shear 0.2, no skewed wake", replace(bare, skew=0.0),
         {**ccblade, **tilted, "shear": 0.2}),
    ):  # fmt: skip
        power, ratio = cases.largest_power_coefficient(made, **options)
        rows.append((name, f"{power:.4f}", f"{ratio:.1f}"))
    return ("rotor", "largest C_p", "at tip speed ratio"), rows


@section
def wave_spectrum() -> Table:
    """Energy of JONSWAP seas (Hs 6 m, Tp 10 s) in bands of frequency: the mean of 50 seeds against the spectrum."""
    from fowtlib.components.environment.waves import irregular_waves, jonswap

    seas = [irregular_waves(6.0, 10.0, 320.0, seed=seed) for seed in range(1, 51)]
    omega = seas[0].omega
    energy = np.mean([sea.amplitude**2 / 2 for sea in seas], axis=0)
    rows = []
    for low, high in ((0.04, 0.08), (0.08, 0.095), (0.095, 0.105), (0.105, 0.12), (0.12, 0.2), (0.2, 0.5)):
        inside = (omega >= 2 * np.pi * low) & (omega < 2 * np.pi * high)
        target = float(np.sum(jonswap(omega[inside], 6.0, 10.0)) * (omega[1] - omega[0]))
        own = float(energy[inside].sum())
        rows.append((f"{low:g} to {high:g}", own, target, _percent(own, target)))
    return ("band [Hz]", "mean of 50 seeds [m^2]", "JONSWAP [m^2]", "difference"), rows


@section
def radiation_kernel() -> Table:
    """Share of the surge kernel K11 of the OC3 spar that two states hold, by the sum of Hankel singular values."""
    from fowtlib.components.hydro import HydrodynamicDatabase
    from fowtlib.components.hydro.radiation_identification import hankel_singular_values
    from fowtlib.components.hydro.retardation import retardation_kernel
    from fowtlib.modelfile import data_path

    spar = HydrodynamicDatabase.read(data_path("oc3_hywind/hydrodynamics.nc"))
    time = 0.2 * np.arange(301)
    rows = []
    for what, used, tail in (("whole damping", spar.omega > 0, True), ("cut at 3 rad/s", spar.omega < 3.001, False)):
        kernel = retardation_kernel(spar.omega[used], spar.B[used, 0, 0], time, tail=tail)
        values = hankel_singular_values(kernel)
        rows.append((what, f"{100 * values[:2].sum() / values.sum():.1f} %", "77.5 %"))
    return ("damping", "share of two states", "thesis"), rows


OC3_FREQUENCIES = {  # [Hz]: thesis, tables 2.7 and 3.2; FAST, ibid.
    "surge": (0.0081, 0.0080), "heave": (0.0314, 0.0320), "pitch": (0.035, 0.034), "yaw": (0.122, 0.121),
}  # fmt: skip


@section
def natural_frequencies() -> Table:
    """Linear model of the OC3 spar in still water and still air."""
    modes = cases.modes_by_motion(cases.calm_plant("oc3_spar_rigid"))
    rows = [
        (name, mode.frequency_hz, mode.damping_ratio, *both, _outside(mode.frequency_hz, both))
        for name, both in OC3_FREQUENCIES.items()
        for mode in [modes[name]]
    ]
    return ("motion", "frequency [Hz]", "damping ratio", "thesis [Hz]", "FAST [Hz]", "outside of both"), rows


@section
def free_decay() -> Table:
    """Runs of the OC3 spar that is let go 10 m or 10 deg from rest."""
    damping = {"surge": (0.143, 0.097), "pitch": (0.088, 0.063)}  # thesis, load case 2.3
    decays = cases.free_decays(cases.calm_plant("oc3_spar_rigid"), dict.fromkeys(OC3_FREQUENCIES, 10.0))
    rows = []
    for name, both in OC3_FREQUENCIES.items():
        decay, published = decays[name], damping.get(name, ("", ""))
        rows.append((name, decay.frequency, _outside(decay.frequency, both), decay.damping_ratio, *published))
    return ("motion", "frequency [Hz]", "outside of both", "damping ratio", "thesis", "FAST"), rows


@section
def mean_surge() -> Table:
    """OC3 load case 5.1: steady wind of 8 m/s, regular waves of 6 m and 10 s."""
    mean = cases.oc3_load_case_5_1()["surge"].mean
    return ("quantity", "mean of 400 s [m]", "codes in OC3 [m]"), [("surge", mean, "8.37 to 15.10")]


@section
def response_to_waves() -> Table:
    """Response per metre of wave of the OC3 spar without drag: the linear model against runs in waves of 1 m."""
    from fowtlib.solving.results.plots import plot_rao

    frequencies = [0.02, 0.03, 0.05, 0.07, 0.1, 0.15]
    linear, runs = cases.oc3_rao(frequencies), cases.oc3_rao_of_runs(frequencies)
    plot_rao([cases.oc3_rao(np.arange(0.003, 0.2, 0.0005)), runs], _figure("oc3_rao.png"))
    pairs = [(linear.amplitude(name), runs.amplitude(name)) for name in linear.outputs]
    rows = [(f, *(float(series[i]) for pair in pairs for series in pair)) for i, f in enumerate(frequencies)]
    heads = [f"{name}, {kind} [{linear.unit(name)}]" for name in linear.outputs for kind in ("linear", "runs")]
    return ("frequency [Hz]", *heads), rows


@section
def response_in_wind() -> Table:
    """Response of the OC3 spar with rigid blades in steady wind of 18 m/s: the mean over a revolution, and runs."""
    model = cases.fw.load("oc3_spar_rigid_bem", set={**cases.CALM, "wind.kind": "steady", "wind.mean_speed": 18.0})
    frequencies, names = [0.05, 0.1], ("surge", "heave", "pitch", "yaw")
    linear = cases.fw.linear_rao(model.compile(), frequencies, outputs=names)
    runs = cases.fw.simulated_rao(model, frequencies, outputs=names, height=0.5, settle=1200, in_wind=True)
    rows = [
        (f, name, *(value for rao in (linear, runs) for value in (rao.amplitude(name)[i], f"{rao.phase(name)[i]:.2f}")))
        for i, f in enumerate(frequencies) for name in names
    ]  # fmt: skip
    return ("frequency [Hz]", "motion", "linear [m/m, deg/m]", "phase [deg]", "runs", "phase [deg]"), rows


@section
def oc4_response() -> Table:
    """Motions of oc4_semi_rigid per metre of wave, and those of six equations in plain numpy."""
    frequencies = [0.03, 0.05, 0.07, 0.09, 0.1, 0.125, 0.15, 0.2]
    linear = cases.fw.linear_rao(cases.calm_plant("oc4_semi_rigid"), frequencies, outputs=["surge", "heave", "pitch"])
    printed, members = (np.abs(oc4_motions.motions(frequencies, bodies)[:, [0, 2, 4]]) * (1, 1, 180 / np.pi)
                        for bodies in (oc4_motions.BODIES, oc4_motions.BODIES_OF_MEMBERS))  # fmt: skip
    rows = []
    for i, f in enumerate(frequencies):
        own = np.abs(linear.response[i])
        pairs = zip(own, printed[i], strict=True)
        row = [value for pair in pairs for value in (pair[0], pair[1], _percent(*pair))]
        rows.append((f, *row, _percent(own[2], members[i, 2])))
    heads = [f"{name} [{unit}]{what}" for name, unit in (("surge", "m/m"), ("heave", "m/m"), ("pitch", "deg/m"))
             for what in ("", ", numpy")]  # fmt: skip
    heads = [*heads[:2], "difference", *heads[2:4], "difference", *heads[4:], "difference", "with the members' inertia"]
    return ("frequency [Hz]", *heads), rows


@section
def oc4_at_rest_and_in_wind() -> Table:
    """Natural frequencies, tension and offsets of oc4_semi_rigid beside published values."""
    plant = cases.calm_plant("oc4_semi_rigid")
    modes, found = cases.modes_by_motion(plant), oc4_motions.natural_frequencies()
    by_equations = dict(zip(("surge", "sway", "yaw", "roll", "pitch", "heave"), found, strict=True))
    raft = {"surge": 0.00884, "heave": 0.05733, "pitch": 0.04004, "yaw": 0.01253}
    rows = [(f"frequency of {name} [Hz]", modes[name].frequency_hz, f"{by_equations[name]:.5f}", value,
             _percent(modes[name].frequency_hz, value)) for name, value in raft.items()]  # fmt: skip
    rest = plant.equilibrium()
    tension = np.hypot(*oc4_motions.line_pull(837.6 - 40.868, 186.0)) / 1e3
    rows.append(("tension of a line at rest [kN]", rest["fairlead_tension_2"], tension, "", ""))
    turned = {"wind.kind": "steady", "wind.mean_speed": 8.0, "platform.mooring.headings": np.radians([30, 150, 270])}
    state = cases.fw.load("oc4_semi_rigid", set={**cases.CALM, **turned}).compile().equilibrium()
    cos, sin = np.cos(np.radians(30)), np.sin(np.radians(30))
    for name, own, value in (
        ("along", state["surge"], 4.40 * cos + 3.10 * sin),
        ("across", state["sway"], 3.10 * cos - 4.40 * sin),
    ):
        rows.append((f"8 m/s from 30 deg: offset {name} the wind [m]", own, "", value, _percent(own, value)))
    tilt, value = state["pitch"] - rest["pitch"], np.degrees(0.0277 * cos + 0.0146 * sin)
    rows.append(("8 m/s from 30 deg: tilt beyond that at rest [deg]", tilt, "", value, _percent(tilt, value)))
    return ("quantity", "oc4_semi_rigid", "plain numpy", "RAFT 2.0", "difference to RAFT"), rows


@section
def tlp_frequencies() -> Table:
    """Natural frequencies of the two tension leg platforms, rigid and flexible, beside published ones."""
    published = {
        "tlp_nrel5mw": {"surge": 0.0165, "heave": 0.4375, "pitch": 0.223, "yaw": 0.097},
        "tlp_two_rotor": {"surge": 1 / 44.3, "heave": 1 / 0.65, "pitch": 1 / 1.05, "yaw": 1 / 25.1},
    }
    rows = []
    for name, numbers in published.items():
        found = []
        for model in (f"{name}_rigid", name):
            plant = cases.calm_plant(model)
            modes = cases.fw.natural_modes(plant, plant.equilibrium())
            found.append({m.name.partition(",")[0]: m.frequency for m in modes if m.motion and m.oscillates})
        for motion, value in numbers.items():
            own = [one[f"platform {motion}"] for one in found]
            shown = (f"{frequency:.4g}" for frequency in (*own, value))
            rows.append((name, motion, *shown, *(_percent(frequency, value) for frequency in own)))
    return ("model", "motion", "rigid [Hz]", "flexible [Hz]", "published [Hz]", "rigid", "flexible"), rows


@section
def heave_in_long_waves() -> Table:
    """Heave of the OC3 spar per metre of a long wave, against the ratio of stiffnesses."""
    limit, own = cases.heave_limit(), float(cases.oc3_rao([0.004]).amplitude("heave")[0])
    heads = ("frequency [Hz]", "heave [m/m]", "C33/(C33 + lines)", "difference")
    return heads, [(0.004, own, limit, _percent(own, limit))]


# Natural frequencies [Hz] of the complete turbine on the OC3 spar, thesis table 3.2: FAST v8, and the thesis with two
# tower hinges and six blade hinges.
TABLE_3_2 = {
    "surge": (0.008, 0.008), "sway": (0.008, 0.008), "heave": (0.032, 0.0314), "roll": (0.034, 0.035),
    "pitch": (0.034, 0.035), "yaw": (0.121, 0.122), "tower fore-aft 1": (0.473, 0.490),
    "tower side-side 1": (0.457, 0.490), "drivetrain": (1.700, 1.667), "tower fore-aft 2": (3.751, 3.632),
    "tower side-side 2": (4.258, 4.312), "blade flap 1": (0.666, 0.634), "blade flap 2": (1.920, 1.951),
    "blade flap 3": (None, 4.204), "blade edge 1": (1.080, 1.126), "blade edge 2": (None, 4.144),
}  # fmt: skip
BENDING = ("tower fore-aft 1", "tower side-side 1", "blade flap 1", "blade edge 1", "blade flap 2", "tower fore-aft 2",
           "tower side-side 2")  # fmt: skip
FREE = ("drivetrain",)  # published free at both ends; the other modes with a locked generator


@section
def turbine_frequencies() -> Table:
    """The sixteen frequencies of table 3.2: two tower and six blade hinges, and six and twelve."""
    few, many = (_table_3_2(*hinges) for hinges in ((2, 6), (6, 12)))
    rows = []
    for name, (fast, thesis) in TABLE_3_2.items():
        off = "" if fast is None else _percent(many[name], fast)
        rows.append((name, few[name], many[name], fast or "", off, thesis, _percent(many[name], thesis)))
    own = ("2 and 6 hinges [Hz]", "6 and 12 hinges [Hz]")
    heads = ("mode", *own, "FAST [Hz]", "difference", "thesis [Hz]", "difference")
    return heads, rows


def _table_3_2(tower_hinges: int, blade_hinges: int) -> dict[str, float]:
    """The lowest frequency of each name, the generator locked but for the torsion of the drive train."""
    locked = turbine_modes.frequencies("oc3_spar", tower_hinges, blade_hinges, locked=True)
    free = turbine_modes.frequencies("oc3_spar", tower_hinges, blade_hinges, locked=False)
    return {name: (free if name in FREE else locked)[name][0] for name in TABLE_3_2}


@section
def beam_hinges() -> Table:
    """Frequencies of the turbine on the OC3 spar over the numbers of tower and blade hinges, generator locked."""
    rows = []
    for hinges in ((1, 2), (2, 3), (2, 4), (2, 6), (3, 8), (4, 10), (6, 12)):
        found = turbine_modes.frequencies("oc3_spar", *hinges, locked=True)
        rows.append((f"{hinges[0]} and {hinges[1]}", *(found[name][0] if name in found else "" for name in BENDING)))
    return ("tower and blade hinges", *(f"{name} [Hz]" for name in BENDING)), rows


@section
def locked_generator() -> Table:
    """The two modes that know whether the generator turns."""
    rows = []
    for name, kind, published in (
        ("oc3_spar", False, ("", "1.700 (FAST)")), ("oc3_spar", True, ("0.457 (FAST)", "")),
        ("nrel5mw_land", False, ("", "")), ("nrel5mw_land", True, ("0.3120 (FAST), 0.3164 (ADAMS)", "0.6205, 0.6094")),
    ):  # fmt: skip
        found = turbine_modes.frequencies(name, 4, 8, locked=kind)
        values = (found["tower side-side 1"][0], published[0], found["drivetrain"][0], published[1])
        rows.append((name, "locked" if kind else "free", *values))
    return ("model", "generator", "tower side-side 1 [Hz]", "published", "drivetrain [Hz]", "published"), rows


# NREL/TP-500-38060, table 9-1: FAST and ADAMS; each name in the order of the frequency here.
TABLE_9_1 = {
    "tower fore-aft 1": [(0.3240, 0.3195)], "tower side-side 1": [(0.3120, 0.3164)], "drivetrain": [(0.6205, 0.6094)],
    "blade flap 1": [(0.6664, 0.6296), (0.6675, 0.6686), (0.6993, 0.7019)],
    "blade edge 1": [(1.0793, 1.0740), (1.0898, 1.0877)],
    "blade flap 2": [(1.9223, 1.6507), (1.9337, 1.8558), (2.0205, 1.9601)],
    "tower fore-aft 2": [(2.9003, 2.8590)], "tower side-side 2": [(2.9361, 2.9408)],
}  # fmt: skip


@section
def land_frequencies() -> Table:
    """The turbine on land, generator locked: as shipped, like the model in ADAMS, and in the shapes of FAST."""
    shipped = turbine_modes.frequencies("nrel5mw_land", 6, 10, locked=True)
    shapes = turbine_modes.with_fast_shapes("nrel5mw_land", 6, 10)
    torsion = (("tower.torsion", True), ("world.gravity", 0.0))
    twisting = turbine_modes.frequencies("nrel5mw_land", 6, 10, locked=True, changes=torsion)
    rows = []
    for name, published in TABLE_9_1.items():
        for i, (fast, adams) in enumerate(published):
            own, other, same = shipped[name][i], twisting[name][i], shapes[name][i]
            rows.append((name, own, other, f"{adams:.4f}", _percent(other, adams), same, f"{fast:.4f}",
                         _percent(same, fast)))  # fmt: skip
    heads = ("mode", "as shipped [Hz]", "with torsion of the tower, without weight [Hz]", "ADAMS [Hz]", "difference",
             "in the shapes of FAST [Hz]", "FAST [Hz]", "difference")  # fmt: skip
    return heads, rows


@section
def fast_shapes() -> Table:
    """The turbine on the OC3 spar, its tower or blades kept to the shapes with which FAST lets them bend."""
    rows = [("every shape", turbine_modes.frequencies("oc3_spar", 6, 12, locked=True))]
    for what, tower, blades in (
        ("tower in two shapes each way", True, False),
        ("blades in two shapes flapwise, one edgewise", False, True),
        ("both", True, True),
    ):
        rows.append((what, turbine_modes.with_fast_shapes("oc3_spar", 6, 12, tower, blades)))
    table = [(what, *(found[name][0] for name in BENDING)) for what, found in rows]
    table.append(("FAST", *(f"{TABLE_3_2[name][0]:.3f}" for name in BENDING)))
    return ("bending", *(f"{name} [Hz]" for name in BENDING)), table


@section
def masses() -> Table:
    """Mass, first moment and inertia of the blade about its root, inertia of the rotor about the shaft."""
    reference = (17740.0, 363231.0, 11776047.0, 38759227.0)
    rows = []
    for hinges in (0, 2, 4, 6, 8, 10, 12):
        own = cases.rotor_masses(hinges)
        pairs = [(f"{a:.0f}", _percent(a, b)) for a, b in zip(own, reference, strict=True)]
        rows.append((hinges, *(text for pair in pairs for text in pair)))
    heads = ("blade mass [kg]", "first moment [kg m]", "blade inertia [kg m^2]", "rotor inertia [kg m^2]")
    return ("hinges", *(text for head in heads for text in (head, "to the definition"))), rows


@section
def two_rotor_rest() -> Table:
    """What holds the two-rotor spar at its published draft: upward forces [MN], and the heave that follows."""
    return ("force or place", "value"), cases.two_rotor_balance()


@section
def two_rotor_periods() -> Table:
    """Runs of the two-rotor spar that is let go from rest in still water and still air."""
    reference = {"surge": (132.3, 0.0873), "heave": (32.1, 0.0196), "pitch": (29.7, 0.0381), "yaw": (33.6, 0.0412)}
    offsets = {"surge": 5.0, "heave": 3.0, "pitch": 3.0, "yaw": 5.0}
    decays = cases.free_decays(cases.calm_plant("two_rotor_spar_rigid"), offsets)
    rows = []
    for name, (period, damping) in reference.items():
        decay = decays[name]
        rows.append((name, decay.period, period, _percent(decay.period, period), decay.damping_ratio, damping))
    return ("motion", "period [s]", "thesis [s]", "difference", "damping ratio", "thesis"), rows


@section
def surge_by_lines() -> Table:
    """Natural periods of both spars in surge and pitch: the linear model, two oscillators in numpy, the thesis."""
    import fowtlib as fw

    rows = []
    for what, name, parameters, surge, pitch in (
        ("OC3, 77.7 kg/m", "oc3_spar_rigid", {}, 123.45, 28.5),
        ("OC3, 200 kg/m", "oc3_spar_rigid", cases.HEAVY_LINES, 103.1, 28.2),
        ("two rotors, 200 kg/m", "two_rotor_spar_rigid", {}, 132.3, 29.7),
    ):
        plant = cases.calm_plant(name, parameters)
        modes = cases.modes_by_motion(plant)
        model = fw.load(name).with_parameters(parameters)
        own = cases.surge_pitch(model, float(plant.equilibrium()["heave"]))
        lines = own.stiffness[0, 0] / 1e3
        surges = (1 / modes["surge"].frequency_hz, own.surge_period, surge)
        rows.append((what, lines, *surges, 1 / modes["pitch"].frequency_hz, own.pitch_period, pitch))
    heads = ("surge, model [s]", "numpy [s]", "thesis [s]", "pitch, model [s]", "numpy [s]", "thesis [s]")
    return ("spar and lines", "surge stiffness [kN/m]", *heads), rows


@section
def two_rotor_static_pitch() -> Table:
    """Static pitch of the two-rotor spar under 808 kN at each hub."""
    import fowtlib as fw

    state = cases.two_rotors_pushed().equilibrium()
    heave = float(cases.calm_plant("two_rotor_spar_rigid").equilibrium()["heave"])
    linear = cases.surge_pitch(fw.load("two_rotor_spar_rigid"), heave).static(2 * cases.THRUST, cases.HUB_HEIGHT)
    stiffness = 3.42e9  # C55 of the thesis
    rows = [
        ("thesis: force times hub to centre of buoyancy (162 m) over C55", _pitch(162.0 / stiffness)),
        ("the same with the lever to the fairleads (176.5 m)", _pitch(176.5 / stiffness)),
        ("stiffness of water, weight and lines at rest, in plain numpy", float(np.degrees(linear[1]))),
        ("equilibrium of the model", float(state["pitch"])),
    ]
    return ("computation", "pitch [deg]"), rows


def _pitch(per_newton: float) -> float:
    return float(np.degrees(2 * cases.THRUST * per_newton))


@section
def two_rotor_mean_pitch() -> Table:
    """Equilibria of the two-rotor spar in steady wind."""
    import fowtlib as fw

    rows = []
    for speed in (8.0, 10.0, 11.0, 11.4, 12.0, 14.0):
        conditions = {"wind.kind": "steady", "wind.mean_speed": speed, "sea.spectrum": "still"}
        state = fw.load("two_rotor_spar_rigid", set=conditions).compile().equilibrium()
        rows.append((speed, 2 * state["thrust_left"], state["pitch"], state["surge"]))
    return ("wind speed [m/s]", "thrust of both rotors [kN]", "pitch [deg]", "surge [m]"), rows


@section
def two_rotor_yaw() -> Table:
    """Yaw of the two-rotor spar at 11.4 m/s: 3600 s, Hs 3.1 m, Tp 10.1 s, the first 400 s left out."""
    rows, shown = [], {}
    for wind, gain, published in (
        ("steady", 0.0, ("0", "")), ("kaimal", 0.0, ("6.5", "21.6")), ("kaimal", 1.5, ("2.5", "7.7")),
    ):  # fmt: skip
        result = cases.two_rotors_in(gain, wind, duration=3600.0)
        yaw = result.statistics(discard=400.0)["yaw"]
        largest = max(abs(yaw.min), abs(yaw.max))
        rows.append(("none" if wind == "steady" else "class B", gain, yaw.std, published[0], largest, published[1]))
        if wind == "kaimal":
            shown["PI" if gain == 0 else f"PI-P, yaw gain {gain:g}"] = result
    _draw_yaw(shown)
    heads = ("turbulence", "yaw gain", "standard deviation [deg]", "thesis [deg]", "largest [deg]", "thesis [deg]")
    return heads, rows


def _draw_yaw(results: dict) -> None:
    """Yaw with both controllers over 600 s."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 3.0), layout="constrained")
    axis = figure.subplots()
    looks = ({"color": "#d1651b", "linestyle": "--"}, {"color": "#0b5394"})
    for (label, result), look in zip(results.items(), looks, strict=True):
        seen = (result.time >= 1000) & (result.time <= 1600)
        axis.plot(result.time[seen], result["yaw"].values[seen], **look, linewidth=1.1, label=label)
    axis.set(xlabel="time [s]", ylabel="yaw [deg]", xlim=(1000, 1600))
    axis.grid(color="#d9d9d9", linewidth=0.6)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, ncols=2, loc="upper right")
    figure.savefig(_figure("two_rotor_yaw.png"), dpi=120)


@section
def oo_star_hydrostatics() -> Table:
    """Mass and hydrostatics of the OO-Star with two rotors, from its members."""
    import fowtlib as fw

    rows = [(name, f"{own:.5g}", f"{printed:.4g}", _percent(own, printed))
            for name, (own, printed) in cases.oo_star_hydrostatics(fw.load("oo_star_rigid")).items()]  # fmt: skip
    return ("quantity", "members", "thesis", "difference"), rows


@section
def oo_star_periods() -> Table:
    """Runs of the OO-Star with two rotors that is let go in still water and still air, and its linear model."""
    plant = cases.calm_plant("oo_star_rigid")
    modes = cases.modes_by_motion(plant)
    rows = []
    for name, decay in cases.free_decays(plant, cases.OO_STAR_OFFSETS, cycles=4.0).items():
        period = cases.OO_STAR_PERIODS[name]
        linear = 1 / modes[name].frequency_hz
        rows.append((name, decay.period, linear, period, _percent(decay.period, period), decay.damping_ratio))
    return ("motion", "decay [s]", "linear model [s]", "thesis [s]", "difference", "damping ratio"), rows


@section
def pitch_steps() -> Table:
    """Pitch steps of the Tjaereborg turbine with dynamic inflow."""
    _draw_pitch_steps(*pitch_step.steps())
    heads = ("step [deg]", "torque before [kN m]", "at once", "settled", "overshoot [kN m]",
             "half of it left after [s]", "a tenth after [s]", "the same in R/V")  # fmt: skip
    return heads, pitch_step.rows()


def _draw_pitch_steps(time: np.ndarray, torque: np.ndarray) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 2.8), layout="constrained")
    axis = figure.subplots()
    axis.plot(time, torque, color="#0b5394", linewidth=1.2)
    axis.set(xlabel="time [s]", ylabel="rotor torque [kN m]", xlim=(0, 62), ylim=(0, 400))
    axis.grid(color="#d9d9d9", linewidth=0.6)
    axis.spines[["top", "right"]].set_visible(False)
    figure.savefig(_figure("tjaereborg_pitch_steps.png"), dpi=120)


@section
def iea15_steady() -> Table:
    """The IEA 15 MW by blade elements and its controller, rigid blades, against tabulated curves and OpenFAST."""
    rows = []
    for wind in sorted({*iea15.TABULATED, *iea15.OPENFAST}):
        point = iea15.steady().operating_point(wind)
        power, thrust = iea15.EFFICIENCY * point.aero_power / 1e3, point.thrust / 1e3
        row: list[object] = [wind, f"{point.rotor_speed * 30 / np.pi:.2f}", f"{np.degrees(point.blade_pitch):.2f}"]
        other = iea15.OPENFAST.get(wind)
        row += [f"{other[0]:.2f}", f"{other[1]:.2f}"] if other else ["", ""]
        tabulated = iea15.TABULATED.get(wind)
        row += [power, *((tabulated[0], _percent(power, tabulated[0])) if tabulated else ("", "")), thrust]
        row += [tabulated[1], _percent(thrust, tabulated[1])] if tabulated else ["", ""]
        row += [other[2], _percent(thrust, other[2])] if other else ["", ""]
        rows.append(tuple(row))
    heads = ("wind [m/s]", "speed [rpm]", "pitch [deg]", "OpenFAST [rpm]", "OpenFAST [deg]", "electrical power [kW]",
             "tabulated", "difference", "thrust [kN]", "tabulated", "difference", "OpenFAST", "difference")  # fmt: skip
    return heads, rows


@section
def iea15_frequencies() -> Table:
    """Platform modes of the IEA 15 MW on the VolturnUS-S, and the bending of its tower with rigid blades."""
    rows: list[tuple[object, ...]] = []
    for motion, mode in cases.modes_by_motion(cases.calm_plant("volturnus_iea15_rigid")).items():
        printed, raft = iea15.FREQUENCIES[motion]
        rows.append((motion, mode.frequency_hz, printed, raft))
    found = iea15.tower_frequencies()
    rows += [("tower fore-aft 1", found["tower fore-aft 1"], "0.496", "0.5256 (pyBmodes)")]
    rows += [("tower side-side 1", found["tower side-side 1"], "", "")]
    return ("mode", "frequency [Hz]", "definition [Hz]", "other codes [Hz]"), rows


@section
def iea15_blade() -> Table:
    """First modes of the blade of the IEA 15 MW at rest and turning."""
    rows: list[tuple[object, ...]] = []
    for rpm in (0.0, 7.55):
        for hinges in (6, 10, 20):
            found = iea15.blade_frequencies(rpm, hinges)
            flap, edge, twist = (
                [hertz for name, hertz in found if name == kind] for kind in ("flap", "edge", "torsion")
            )
            rows.append((rpm, hinges, flap[0], edge[0], flap[1], edge[1], twist[0]))
    rows.append(("7.55, pyBmodes", "", 0.5585, 0.7281, 1.5916, "", ""))
    rows.append(("definition", "", 0.555, 0.642, "", "", ""))
    heads = ("speed [rpm]", "hinges", "flap 1 [Hz]", "edge 1 [Hz]", "flap 2 [Hz]", "edge 2 [Hz]", "torsion 1 [Hz]")
    return heads, rows


def _figure(name: str) -> Path:
    """Where a picture of the page goes."""
    FIGURES.mkdir(exist_ok=True)
    return FIGURES / name


def _outside(value: float, references: tuple[float, float]) -> str:
    """How far a value lies beyond the interval of two references."""
    if min(references) <= value <= max(references):
        return "0"
    nearest = min(references, key=lambda reference: abs(value - reference))
    return _percent(value, nearest)


def _percent(own: float, reference: float) -> str:
    return f"{100 * (own / reference - 1):+.2f} %"


def main(names: list[str]) -> int:
    """Print the chosen sections, or all, and write them into the page."""
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; there are {', '.join(SECTIONS)}", file=sys.stderr)
        return 2
    for name in names or SECTIONS:
        text = markdown(SECTIONS[name]())
        print(f"{name}\n\n{text}\n", flush=True)
        PAGE.write_text(fill(PAGE.read_text(), name, text))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
