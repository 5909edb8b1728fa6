"""Two FMUs run side by side: a spar with its turbine, and its mooring lines, cut apart at the fairleads.

Forces for the start of a step, held to the next exchange, come half a step late on average: the result is off in
proportion to the step. Forces for its middle, seen ahead with the velocity, are hardly off; what is left is of the
solver, which starts anew at every exchange. The whole spar as one FMU is the reference.

python fmus/connect_two.py      after `make fmus`; the picture is fmus/built/connect_two.png
"""

from pathlib import Path

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.simulation import instantiate_fmu

BUILT = Path(__file__).parent / "built"
SETTINGS = {"solver.step": 0.00625, "solver.tolerance": 1e-9}  # of all FMUs: the exchange is the only difference
START = {"platform.motion.surge_start": 10.0}  # [m]


def of_fairleads(pattern):
    """Names of a vector at the three fairleads."""
    return [pattern.format(i) + f"[{axis}]" for i in (1, 2, 3) for axis in (0, 1, 2)]


class Unit:
    """An FMU in co-simulation."""

    def __init__(self, path, start):
        described = fmpy.read_model_description(path)
        self.numbers = {v.name: v.valueReference for v in described.modelVariables}
        self.fmu = instantiate_fmu(fmpy.extract(path, path.with_suffix("")), described, "CoSimulation")
        self.fmu.enterInitializationMode()
        self.set(start, start.values())
        self.fmu.exitInitializationMode()

    def set(self, names, values):
        self.fmu.setFloat64([self.numbers[name] for name in names], list(values))

    def get(self, names):
        return np.array(self.fmu.getFloat64([self.numbers[name] for name in names]))


def coupled(folder, times, middle):
    """Surge [m] of the two FMUs; middle: the forces, which follow from the places at once, are those of mid-step."""
    spar, lines = Unit(folder / "spar_without_mooring.fmu", START | SETTINGS), Unit(folder / "mooring.fmu", SETTINGS)
    surge = [spar.get(["surge"])[0]]
    for t, step in zip(times, np.diff(times), strict=False):
        ahead = step / 2 * spar.get(of_fairleads("fairlead_velocity_{}")) if middle else 0.0
        lines.set(of_fairleads("fairlead_{}.position"), spar.get(of_fairleads("fairlead_position_{}")) + ahead)
        spar.set(of_fairleads("fairlead_{}.force"), lines.get(of_fairleads("fairlead_force_{}")))
        for unit in (spar, lines):
            unit.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=step)
        surge.append(spar.get(["surge"])[0])
    for unit in (spar, lines):
        unit.fmu.freeInstance()
    return np.array(surge)


def main(folder=BUILT, duration=60.0, steps=(0.1, 0.05, 0.025, 0.0125), picture="connect_two.png"):
    """Largest difference of surge [m] from the whole spar: {middle: [one for each step]}."""
    figure, (over_time, over_step) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    found = {False: [], True: []}
    for middle, label in ((False, "force for the start of the step"), (True, "force for its middle")):
        for step in steps:
            options = {"stop_time": duration, "output_interval": step, "fmi_type": "CoSimulation", "output": ["surge"]}
            whole = fmpy.simulate_fmu(folder / "spar_rigid.fmu", start_values=START | SETTINGS, **options)
            difference = coupled(folder, np.linspace(0, duration, len(whole)), middle) - whole["surge"]
            found[middle].append(np.max(np.abs(difference)))
            print(f"{label:32} {1000 * step:6.2f} ms   surge off by {found[middle][-1]:.2e} m at most")
        over_time.plot(whole["time"], 1000 * difference, label=label)
        over_step.loglog(1000 * np.array(steps), 1000 * np.array(found[middle]), "o-", label=label)
    over_time.set(xlabel="time [s]", ylabel="surge, coupled minus whole [mm]", title=f"step {1000 * steps[-1]:g} ms")
    over_step.set(xlabel="exchange step [ms]", ylabel="largest difference of surge [mm]")
    over_step.set_xticks(1000 * np.array(steps), [f"{1000 * step:g}" for step in steps])
    over_step.minorticks_off()
    over_step.legend()
    figure.savefig(folder / picture, dpi=100)
    return found


if __name__ == "__main__":
    main() if BUILT.is_dir() else exit("There are no archives yet; make them: make fmus")
