"""Run an FMU in fmpy with chosen outputs, and again with other parameters: no new export is needed for that.

python fmus/run_in_fmpy.py      after `make fmus`; the picture is fmus/built/run_in_fmpy.png
"""

from math import pi
from pathlib import Path

import fmpy
import matplotlib.pyplot as plt

BUILT = Path(__file__).parent / "built"
OUTPUTS = {  # values in an FMU are SI
    "surge": ("surge [m]", 1.0),
    "fairlead_tension_2": ("tension, upwind line [kN]", 1e-3),
    "blade_pitch": ("blade pitch [deg]", 180 / pi),
    "generator_power": ("power [MW]", 1e-6),
}
VARIANTS = {
    "as exported": {},
    "lines 5 m shorter": {"platform.mooring.length": 897.2},
    "gains for land": {
        "turbine.control.proportional_gain": 0.01882681,  # NREL/TP-500-38060, table 7-2
        "turbine.control.integral_gain": 0.008068634,
    },
}


def main(folder=BUILT, duration=400.0, picture="run_in_fmpy.png"):
    """The results of each variant: structured arrays with "time" and the outputs, in SI."""
    path = folder / "spar_in_waves.fmu"
    described = fmpy.read_model_description(path)
    units = {v.name: v.unit for v in described.modelVariables}
    results = {}
    figure, axes = plt.subplots(len(OUTPUTS), 1, figsize=(8, 8), sharex=True, layout="constrained")
    for variant, values in VARIANTS.items():
        rows = results[variant] = fmpy.simulate_fmu(
            path, fmi_type="CoSimulation", stop_time=duration, output_interval=0.1, output=list(OUTPUTS),
            start_values=values,
        )  # fmt: skip
        for axis, (name, (label, factor)) in zip(axes, OUTPUTS.items(), strict=True):
            axis.plot(rows["time"], rows[name] * factor, label=variant, linewidth=1)
            axis.set_ylabel(label)
        changes = ", ".join(f"{name} = {value:g} {units[name] or ''}" for name, value in values.items())
        print(f"{variant}: {changes}" if changes else f"{variant}:")
        for name, (label, factor) in OUTPUTS.items():
            late = rows[name][rows["time"] >= duration / 2] * factor
            print(f"  {label:28} mean {late.mean():8.3f}   standard deviation {late.std():7.3f}")
    axes[-1].set_xlabel("time [s]")
    axes[0].legend(ncols=len(VARIANTS), loc="lower right")
    figure.savefig(folder / picture, dpi=100)
    return results


if __name__ == "__main__":
    main() if BUILT.is_dir() else exit("There are no archives yet; make them: make fmus")
