"""The numbers of docs/verification.md.

`make verification` computes all of them and writes them into the page, between the marks of each section;
`python benchmarks/verification.py NAME ...` prints some. References:

- OC3: J. Jonkman, Definition of the Floating System for Phase IV of OC3, NREL/TP-500-47535 (2010); J. Jonkman and
  W. Musial, OC3 for IEA Wind Task 23, NREL/TP-5000-48191 (2010).
- Thesis: O. El Beshbichi, PhD thesis, University of Stavanger (2023), whose Modelica model has the same physics.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pages import fill

PAGE = Path(__file__).parent.parent / "docs" / "verification.md"
Table = tuple[tuple[str, ...], list[tuple[object, ...]]]  # heads, rows
SECTIONS: dict[str, Callable[[], Table]] = {}


def section(function: Callable[[], Table]) -> Callable[[], Table]:
    """Register a section of the page under the name of its function."""
    SECTIONS[function.__name__] = function
    return function


@section
def mooring_line() -> Table:
    """One OC3 line: fairlead tension over the distance from the anchor, fairlead 250 m above the seabed."""
    from fowtlib.components.mooring import catenary

    line = catenary.Line(902.2, catenary.weight_in_water(77.7066, 0.09), 384.243e6)
    reference = {800: 353.5, 820: 474.8, 840: 721.1, 848.67: 911.1, 855: 1107.9, 865: 1688.1, 880: 5660.0}
    rows = []
    for distance, tension in reference.items():
        own = float(np.hypot(*catenary.fairlead_tension(distance, 250.0, line))) / 1e3
        rows.append((distance, own, tension, _percent(own, tension)))
    return ("distance [m]", "tension [kN]", "independent solution [kN]", "difference"), rows


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


@section
def natural_frequencies() -> Table:
    """Linear model of the OC3 spar in still water and still air."""
    reference = {
        "surge": ("0.0081", "0.008"), "heave": ("0.0314", "0.032"), "pitch": ("0.035", "0.034"),
        "yaw": ("0.122", "0.121"),
    }  # fmt: skip
    modes = _modes("oc3_spar_rigid")
    rows = [(name, *modes[name], *values) for name, values in reference.items()]
    return ("motion", "frequency [Hz]", "damping ratio", "thesis [Hz]", "FAST in the thesis [Hz]"), rows


@section
def free_decay() -> Table:
    """Runs of the OC3 spar that is let go 10 m or 10 deg from rest."""
    import fowtlib as fw
    from fowtlib.analysis import free_decay as decay_of

    model = fw.load("oc3_spar_rigid")
    rows = []
    for name, thesis in (("surge", 0.0081), ("heave", 0.0314), ("pitch", 0.035), ("yaw", 0.122)):
        decay = decay_of(model, name, 10.0)
        rows.append((name, decay.frequency, decay.damping_ratio, thesis, _percent(decay.frequency, thesis)))
    return ("motion", "frequency [Hz]", "damping ratio", "thesis [Hz]", "difference"), rows


@section
def mean_surge() -> Table:
    """OC3 load case 5.1: steady wind of 8 m/s, regular waves of 6 m and 10 s."""
    import fowtlib as fw

    conditions = {
        "wind.kind": "steady", "wind.mean_speed": 8.0,
        "sea.spectrum": "regular", "sea.wave_height": 6.0, "sea.wave_period": 10.0,
    }  # fmt: skip
    result = fw.load("oc3_spar_rigid", set=conditions).compile().simulate(1600.0)
    mean = result.statistics(discard=600.0)["surge"].mean
    return ("quantity", "mean of 1000 s [m]", "codes in OC3 [m]"), [("surge", mean, "8.37 to 15.10")]


@section
def response_to_waves() -> Table:
    """Response per metre of wave of the OC3 spar: the linear model against runs in regular waves of 0.2 m."""
    import fowtlib as fw
    from fowtlib.analysis import linear_rao, simulated_rao

    model = fw.load("oc3_spar_rigid")
    frequencies, names = [0.01, 0.05, 0.08, 0.1, 0.15], ["surge", "heave", "pitch"]
    linear = linear_rao(model, frequencies, outputs=names)
    runs = simulated_rao(model, frequencies, outputs=names, height=0.2, settle=1500.0)
    pairs = [(linear.amplitude(name), runs.amplitude(name)) for name in names]
    rows = [(f, *(float(series[i]) for pair in pairs for series in pair)) for i, f in enumerate(frequencies)]
    heads = [f"{name}, {kind} [{linear.unit(name)}]" for name in names for kind in ("linear", "runs")]
    return ("frequency [Hz]", *heads), rows


@section
def two_rotor_periods() -> Table:
    """Runs of the two-rotor spar that is let go from rest in still water and still air."""
    import fowtlib as fw
    from fowtlib.analysis import free_decay as decay_of

    model = fw.load("two_rotor_spar_rigid")
    reference = {"surge": (132.3, 0.0873), "heave": (32.1, 0.0196), "pitch": (29.7, 0.0381), "yaw": (33.6, 0.0412)}
    rows = []
    for name, (period, damping) in reference.items():
        decay = decay_of(model, name, 10.0, duration=900.0)
        rows.append((name, decay.period, period, _percent(decay.period, period), decay.damping_ratio, damping))
    return ("motion", "period [s]", "thesis [s]", "difference", "damping ratio", "thesis"), rows


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
    import fowtlib as fw

    rows = []
    for wind, yaw_gain in (("steady", 0.0), ("kaimal", 0.0), ("kaimal", 1.5)):
        model = fw.load("two_rotor_spar_rigid", set={"wind.kind": wind, "yaw_gain": yaw_gain})
        yaw = model.compile().simulate(3600.0).statistics(discard=400.0)["yaw"]
        largest = max(abs(yaw.min), abs(yaw.max))
        rows.append(("none" if wind == "steady" else "class B", yaw_gain, yaw.std, largest))
    return ("turbulence", "yaw gain", "standard deviation [deg]", "largest [deg]"), rows


def _modes(name: str) -> dict[str, tuple[float, float]]:
    """Frequency [Hz] and damping ratio by motion, in still water and still air."""
    import fowtlib as fw
    from fowtlib.cli.stability import motion_of

    plant = fw.load(name, set={"wind.kind": "none", "sea.spectrum": "still"}).compile()
    names = {path: name for name, (path, _, _) in plant.outputs.items()}
    modes = plant.linearize(plant.equilibrium()).modes()
    oscillating = [mode for mode in modes if mode.eigenvalue.imag > 0]
    return {motion_of(mode, names): (mode.frequency_hz, mode.damping_ratio) for mode in oscillating}


def _percent(own: float, reference: float) -> str:
    return f"{100 * (own / reference - 1):+.2f} %"


def markdown(table: Table) -> str:
    """A table as text of the page."""
    heads, rows = table
    lines = [heads, tuple("---" for _ in heads), *rows]
    cells = [[f"{cell:.5g}" if isinstance(cell, float) else str(cell) for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)


def main(names: list[str]) -> int:
    """Print the chosen sections, or write all of them into the page."""
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; there are {', '.join(SECTIONS)}", file=sys.stderr)
        return 2
    page = PAGE.read_text()
    for name in names or SECTIONS:
        text = markdown(SECTIONS[name]())
        print(f"{name}\n\n{text}\n", flush=True)
        page = fill(page, name, text)
    if not names:
        PAGE.write_text(page)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
