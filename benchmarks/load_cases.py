"""The numbers and pictures of docs/load_cases.md: complete turbines in load cases LC 2.1 to 2.7 and LC 1.1 to 1.8.

`python benchmarks/load_cases.py` runs every case by the command that the page prints, and writes tables and pictures;
`python benchmarks/load_cases.py NAME ...` does so for some; `--keep` reads results of an earlier run from output/.

Thesis: O. El Beshbichi, PhD thesis, University of Stavanger (2023), tables 3.3 and 4.9. FAST in steady wind: NREL's
table of power and force on the shaft of this turbine, NREL/turbine-models, Offshore/NREL_5MW_126_RWT.csv.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import gyroscopic as spinning
import load_case_pictures as pictures
import numpy as np
import two_rotor_load_cases as two
import verification_cases as cases
from pages import Table, fill, markdown

import fowtlib as fw
from fowtlib.analysis import Decay, analyse_decay, harmonic_fit, linear_rao, power_spectrum
from fowtlib.solving.results import Result

ROOT = Path(__file__).parent.parent
PAGE, FIGURES, RUNS = ROOT / "docs" / "load_cases.md", ROOT / "docs" / "figures", ROOT / "output" / "load_cases"
VACUUM = "--set world.air_density=0"
# the references have neither the drag of the tower nor its dam in the wind at the blades
BARE = "--set tower_drag.active=false --set tower_flow.active=false"
STIFF_BLADES = "--set turbine.assembly.blade_hinges=0"
FIELD = "output/load_cases/kaimal_11.4.bts"
FIELD_COMMAND = (
    f"fowt wind-field {FIELD} --speed 11.4 --class B --shear 0.14 --width 160 --height 160 --spacing 8 --time 1200"
)
IDAS, FIXED = "--solver idas --tolerance 1e-4", "--solver fixed"
SPAR = "fowt run oc3_spar --start file"
OFFSETS = {"surge": (10.0, 600.0), "heave": (5.0, 200.0), "pitch": (10.0, 200.0)}  # m or deg, s
COMMANDS = {
    "steady": f"fowt run nrel5mw_land --wind steady:SPEED,shear=0 {BARE} --time 90 {FIXED}",
    "turbulent": f"fowt run nrel5mw_land --wind field:{FIELD} {BARE} --time 600 {FIXED}",
    **{
        f"decay_{motion}": f"fowt decay oc3_spar --wind none --dof {motion} --offset {offset:g} --time {time:g}"
        f" {VACUUM}"
        for motion, (offset, time) in OFFSETS.items()
    },
    "regular": f"{SPAR} --wind none --waves regular:H=6,T=10 {VACUUM} {STIFF_BLADES} --time 600 {IDAS}",
    "regular_rigid": f"{SPAR} --wind none --waves regular:H=6,T=10 --set tower.hinges=0"
    f" {VACUUM} {STIFF_BLADES} --time 600 {IDAS}",
    "irregular": f"{SPAR} --wind none --waves jonswap:Hs=6,Tp=10,seed=1 {VACUUM} {STIFF_BLADES} --time 2000"
    f" {IDAS}",
    "steady_and_regular": f"{SPAR} --wind steady:8 --waves regular:H=6,T=10 {BARE} --time 600 {FIXED}",
    "turbulent_and_irregular": f"{SPAR} --wind field:{FIELD} --waves jonswap:Hs=6,Tp=10,seed=1 {BARE}"
    f" --time 1000 {FIXED}",
    **{case.key: case.command(f"output/load_cases/{case.key}.bts") for case in two.KAIMAL},
}
SPEEDS = (3, 5, 7, 8, 9, 10, 11, 11.4, 12, 13, 15, 18, 21, 25)

# FAST, steady wind: power [kW] and force on the shaft with the weight of the rotor [kN], NREL_5MW_126_RWT.csv.
FAST_STEADY = {
    3: (40.5, 171.7), 4: (177.7, 215.9), 5: (403.9, 268.9), 6: (737.6, 330.3), 7: (1187.2, 398.6), 8: (1771.1, 478.0),
    9: (2518.6, 579.2), 10: (3448.41, 691.496), 11: (4562.51, 790.615), 11.4: (5000.37, 805.112),
    12: (5000.0, 689.957), 13: (5000.0, 608.4), 15: (5000.0, 520.5), 17: (5000.0, 467.7), 18: (5000.0, 448.4),
    19: (5000.0, 432.3), 21: (5000.0, 406.7), 23: (5000.0, 385.1), 25: (5000.0, 369.3),
}  # fmt: skip
PITCH = {11.4: 0.0, **cases.NREL_5MW_PITCH}  # deg, NREL/TP-500-38060, table 7-1
ROTOR_WEIGHT = (56780 + 3 * 17740) * 9.80665 * np.sin(np.radians(5))  # N, along the tilted shaft
SECTIONS: dict[str, Callable[[], Table]] = {}
keep = False


def section(function: Callable[[], Table]) -> Callable[[], Table]:
    """Register a section of the page under the name of its function."""
    SECTIONS[function.__name__] = function
    return function


def result_of(name: str, **words: object) -> Result:
    """Run a command of the page, or read what it left."""
    command = COMMANDS[name]
    for word, value in words.items():
        command = command.replace(word.upper(), f"{value:g}")
    target = RUNS / "_".join([name, *(f"{value:g}" for value in words.values()), "fowt.nc"])
    if not (keep and target.exists()):
        RUNS.mkdir(parents=True, exist_ok=True)
        if FIELD in command and not (ROOT / FIELD).exists():
            execute(FIELD_COMMAND)
        execute(f"{command} --output {target}")
    return Result.open(target)


def execute(command: str) -> None:
    """Run a command line of the page in the project's folder."""
    print(f"$ {command}", file=sys.stderr, flush=True)
    words = shlex.split(command)
    subprocess.run([sys.executable, "-m", "fowtlib.cli", *words[1:]], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


@dataclass(frozen=True)
class SteadyPoint:
    """Means over the last 30 s of a run in steady wind; deflection over the three blades. SI but rpm, deg, kW, kN."""

    rotor_speed: float
    pitch: float
    power: float
    thrust: float
    deflection: float
    tower_top: float

    @classmethod
    def of(cls, result: Result, last: float = 30.0) -> SteadyPoint:
        """The point that a run ends in."""
        mean = {name: row.mean for name, row in result.statistics(discard=float(result.time[-1]) - last).items()}
        tip = np.mean([mean[f"blade_tip_out_of_plane_{k}"] for k in (1, 2, 3)])
        names = ("rotor_speed", "blade_pitch", "generator_power", "thrust")
        return cls(*(mean[name] for name in names), float(tip), mean["tower_top_fore_aft_displacement"])


@section
def commands() -> Table:
    """What the cases run."""
    lines = [("LC 2.1", "steady"), ("LC 2.2", "turbulent"), *(("LC 2.3", f"decay_{m}") for m in OFFSETS),
             ("LC 2.4", "regular"), ("LC 2.4, rigid tower", "regular_rigid"), ("LC 2.5", "irregular"),
             ("LC 2.6", "steady_and_regular"), ("LC 2.7", "turbulent_and_irregular")]  # fmt: skip
    wide = two.KAIMAL[3]
    lines += [(f"LC {case.name}", case.key) for case in two.KAIMAL]
    rows = [("wind of LC 2.2, 2.7", f"`{FIELD_COMMAND}`"), *((case, f"`{COMMANDS[name]}`") for case, name in lines)]
    rows.insert(-len(two.KAIMAL), (f"wind of LC {wide.name}", f"`{wide.field_command(_field_of(wide))}`"))
    return ("load case", "command"), rows


@section
def steady() -> Table:
    """LC 2.1: steady operation from 3 to 25 m/s."""
    points = {speed: SteadyPoint.of(result_of("steady", speed=speed)) for speed in SPEEDS}
    rows = []
    for speed, p in points.items():
        power, force = FAST_STEADY[speed]
        shaft = p.thrust + ROTOR_WEIGHT / 1e3
        rows.append((
            f"{speed:g}", p.rotor_speed, p.pitch, PITCH.get(speed, ""), p.power, power, _percent(p.power, power),
            p.thrust, shaft, force, _percent(shaft, force), p.deflection, p.tower_top,
        ))  # fmt: skip
    pictures.steady(points, FAST_STEADY, PITCH, ROTOR_WEIGHT / 1e3, FIGURES / "lc21_steady.png")
    return (
        "wind [m/s]", "rotor [rpm]", "pitch [deg]", "NREL", "power [kW]", "FAST", "difference", "thrust [kN]",
        "force on the shaft [kN]", "FAST", "difference", "tip out of plane [m]", "tower top [m]",
    ), rows  # fmt: skip


@section
def turbulent() -> Table:
    """LC 2.2: tower and blades in turbulent wind of 11.4 m/s."""
    names = ("wind_speed", "rotor_speed", "blade_pitch", "generator_power", "thrust", "blade_tip_out_of_plane_1",
             "tower_top_fore_aft_displacement", "tower_base_fore_aft_moment",
             "blade_root_flapwise_moment_1")  # fmt: skip
    return _statistics("turbulent", names, 100.0, FIGURES / "lc22_turbulent.png")


@section
def decay() -> Table:
    """LC 2.3: the platform let go from an offset."""
    published = {"surge": (0.097, 0.143), "heave": ("", ""), "pitch": (0.063, 0.088)}
    plant = fw.load("oc3_spar", set={**cases.CALM, "world.air_density": 0.0}).compile()
    rows, found = [], {}
    for motion, both in published.items():
        one = cases.free_decay(plant, motion, OFFSETS[motion][0], duration=OFFSETS[motion][1])
        found[motion] = one
        first = analyse_decay(_first_cycles(one, 2))
        rows.append((motion, one.frequency, one.damping_ratio, first.damping_ratio, one.damping_at_zero,
                     one.damping_slope, *both))  # fmt: skip
    pictures.decays(found, FIGURES / "lc23_decay.png")
    heads = ("motion", "frequency [Hz]", "damping ratio", "of the first two cycles", "at amplitude zero",
             "more per m or deg", "FAST", "thesis")  # fmt: skip
    return heads, rows


def _first_cycles(decay: Decay, cycles: int) -> tuple[np.ndarray, np.ndarray]:
    seen = decay.series.time <= (cycles + 0.75) * decay.period
    return decay.series.time[seen], decay.series.values[seen]


@section
def regular() -> Table:
    """LC 2.4: regular waves of 6 m and 10 s; platform and tower, no wind."""
    result, rigid = result_of("regular"), result_of("regular_rigid")
    rao = linear_rao(fw.load("oc3_spar_rigid").with_parameters(cases.WITHOUT_DRAG), [0.1],
                     outputs=["surge", "heave", "pitch"])  # fmt: skip
    rows = []
    for name in ("surge", "heave", "pitch"):
        flexible, stiff = _amplitude(result, name), _amplitude(rigid, name)
        linear = 3.0 * float(rao.amplitude(name)[0])
        rows.append((name, result.unit(name), flexible, stiff, linear, _percent(stiff, linear)))
    names = ("wave_elevation", "surge", "heave", "pitch", "tower_top_fore_aft_displacement",
             "tower_base_fore_aft_moment")  # fmt: skip
    pictures.series(result, names, FIGURES / "lc24_regular.png", (400, 460))
    heads = ("motion", "unit", "amplitude", "with a rigid tower", "linear, rigid, no drag", "difference of these two")
    return heads, rows


def _amplitude(result: Result, name: str) -> float:
    """Amplitude at the 10 s of the waves; values half a period before and after take slow surge out."""
    half = int(round(5.0 / (result.time[1] - result.time[0])))
    values = np.asarray(result[name])
    middle = (values[half:-half] - (values[2 * half :] + values[: -2 * half]) / 2) / 2
    return harmonic_fit((result.time[half:-half], middle), 0.1, discard=400.0).amplitude


@section
def irregular() -> Table:
    """LC 2.5: irregular waves; platform and tower, no wind. Peaks of the power spectra."""
    result = result_of("irregular")
    wanted = (("surge", "surge", 0.008, (0.004, 0.02)), ("surge", "waves", 0.1, (0.06, 0.2)),
              ("heave", "heave", 0.032, (0.02, 0.05)), ("pitch", "pitch", 0.035, (0.02, 0.05)),
              ("tower_base_fore_aft_moment", "waves", 0.1, (0.06, 0.2)),
              ("tower_base_fore_aft_moment", "tower fore-aft", 0.49, (0.3, 0.7)))  # fmt: skip
    spectra = {name: power_spectrum(result[name], discard=200.0, segment=600.0) for name, *_ in wanted}
    rows = []
    for name, motion, published, (low, high) in wanted:
        spectrum = spectra[name]
        inside = (spectrum.frequency >= low) & (spectrum.frequency <= high)
        peak = float(spectrum.frequency[inside][np.argmax(spectrum.density[inside])])
        factor, unit = _readable(spectrum.unit)
        std = factor * float(np.sqrt(spectrum.moment(0, low, high)))
        rows.append((name, motion, f"{low:g} to {high:g}", peak, published, std, unit))
    pictures.spectra(spectra, FIGURES / "lc25_spectra.png")
    heads = ("result", "peak of", "band [Hz]", "peak [Hz]", "thesis [Hz]", "standard deviation in the band", "unit")
    return heads, rows


@section
def steady_and_regular() -> Table:
    """LC 2.6: everything moves, steady wind of 8 m/s and regular waves."""
    names = ("surge", "heave", "pitch", "yaw", "rotor_speed", "generator_power", "thrust", "blade_tip_out_of_plane_1",
             "blade_root_flapwise_moment_1", "tower_top_fore_aft_displacement", "tower_base_fore_aft_moment",
             "fairlead_tension_2")  # fmt: skip
    return _statistics("steady_and_regular", names, 300.0, FIGURES / "lc26_steady_and_regular.png", (520, 600))


@section
def turbulent_and_irregular() -> Table:
    """LC 2.7: everything moves, turbulent wind of 11.4 m/s and irregular waves."""
    names = ("wind_speed", "surge", "heave", "pitch", "yaw", "rotor_speed", "blade_pitch", "generator_power", "thrust",
             "blade_tip_out_of_plane_1", "blade_root_flapwise_moment_1", "tower_base_fore_aft_moment",
             "fairlead_tension_2")  # fmt: skip
    return _statistics("turbulent_and_irregular", names, 300.0, FIGURES / "lc27_turbulent_and_irregular.png")


def _statistics(name: str, names: Sequence[str], settle: float, picture: Path, window: tuple = ()) -> Table:
    """Mean, standard deviation and extremes after `settle` [s], and a picture of the first eight results."""
    result = result_of(name)
    found = result.statistics(discard=settle)
    rows = []
    for item in names:
        row, factor, unit = found[item], *_readable(found[item].unit)
        values = np.array([row.mean, row.std, row.min, row.max])
        values[np.abs(values) < 1e-9 * np.abs(values).max()] = 0.0
        rows.append((item, unit, *(float(factor * value) for value in values)))
    pictures.series(result, names[:8], picture, window or (settle, float(result.time[-1])))
    return ("result", "unit", "mean", "standard deviation", "least", "largest"), rows


@section
def two_rotors() -> Table:
    """LC 1.1 to LC 1.8: two complete turbines on one spar in turbulent wind and irregular waves."""
    found = {}
    for case in two.KAIMAL:
        field = ROOT / _field_of(case)
        if not (keep and (RUNS / f"{case.key}_fowt.nc").exists()):
            RUNS.mkdir(parents=True, exist_ok=True)
            execute(case.field_command(_field_of(case)))
        found[case] = result_of(case.key).statistics(discard=two.SETTLE)
        field.unlink(missing_ok=True)  # 90 MB
    pictures.two_rotors(found, FIGURES / "lc1_two_rotors.png")
    return two.table(found)


def _field_of(case: two.LoadCase) -> str:
    return f"output/load_cases/{case.key}.bts"


@section
def gyroscopic() -> Table:
    """Pitch decay with turning rotors, and the yaw that follows."""
    runs = {
        "oc3_spar": ("oc3_spar", (1,)), "the same, counter-clockwise": ("oc3_spar", (-1,)),
        "two_rotor_spar, both clockwise": ("two_rotor_spar", (1, 1)),
        "the same, one of each": ("two_rotor_spar", (1, -1)),
    }  # fmt: skip
    rows, found = [], {}
    for name, (model, senses) in runs.items():
        found[name] = one = spinning.pitch_decay(model, senses)
        largest = [float(np.abs(values).max()) for values in (one.rate, one.moment, one.yaw, one.expected)]
        error = np.sqrt(np.mean((one.yaw - one.expected) ** 2)) / one.yaw.std()
        rows.append((
            name, one.spin / 1e6, np.degrees(largest[0]), largest[1] / 1e6, f"{largest[2]:.2g}" if not one.spin
            else largest[2], largest[3], f"{100 * error:.1f} %" if one.spin else "",
        ))  # fmt: skip
    pictures.gyroscopic(found, FIGURES / "gyroscopic_yaw.png")
    heads = ("model", "spin I Omega [MN m s]", "largest pitch rate of the nacelles [deg/s]",
             "largest gyroscopic moment [MN m]", "largest yaw [deg]", "of the oscillator [deg]",
             "difference over 120 s")  # fmt: skip
    return heads, rows


def _readable(unit: str) -> tuple[float, str]:
    return (1e-6, "MN m") if unit in ("N*m", "N m") else (1.0, unit)


def _percent(own: float, reference: float) -> str:
    return f"{100 * (own / reference - 1):+.1f} %"


def main(names: list[str]) -> int:
    """Run the chosen cases, or all, and write them into the page."""
    global keep
    keep = "--keep" in names
    names = [name for name in names if name != "--keep"]
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; there are {', '.join(SECTIONS)}", file=sys.stderr)
        return 2
    for name in names or SECTIONS:
        text = markdown(SECTIONS[name](), digits=4)
        print(f"{name}\n\n{text}\n", flush=True)
        PAGE.write_text(fill(PAGE.read_text(), name, text))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
