"""Two FMUs run side by side: a spar with its turbine, and its mooring lines, cut apart at the fairleads.

The spar gives position and velocity of its fairleads and takes the forces of the lines; the mooring does the opposite.
They meet only at the exchange times. The force is then held, so it is half an exchange step late on average, and the
result is off in proportion to the step. Taking the forces for where the fairleads will be in the middle of the step
removes that: the rest goes with the square of the step. The whole spar as one FMU is the reference.

python fmus/connect_two.py      after `make fmus`; the picture is fmus/built/connect_two.png
"""

from __future__ import annotations

from pathlib import Path

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.simulation import instantiate_fmu

BUILT = Path(__file__).parent / "built"
SOLVER = {"solver.step": 0.003125, "solver.tolerance": 1e-9}  # of all FMUs, so that the exchange is the only difference
START = {"platform.motion.surge_start": 10.0}  # [m] the spar is let go from here
EACH = [(i, k) for i in (1, 2, 3) for k in (0, 1, 2)]  # lines and axes


class Unit:
    """An FMU in co-simulation, its variables by name."""

    def __init__(self, path, **start):
        self.described = fmpy.read_model_description(path)
        self.numbers = {v.name: v.valueReference for v in self.described.modelVariables}
        self.fmu = instantiate_fmu(fmpy.extract(path), self.described, "CoSimulation")
        self.fmu.enterInitializationMode()
        self.set([*SOLVER, *start], [*SOLVER.values(), *start.values()])
        self.fmu.exitInitializationMode()

    def set(self, names, values):
        self.fmu.setFloat64([self.numbers[name] for name in names], [float(value) for value in values])

    def get(self, names):
        return np.array(self.fmu.getFloat64([self.numbers[name] for name in names]))

    def step(self, t, h):
        self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)


def coupled(folder, duration, step, look_ahead, outputs=("surge", "pitch")):
    """Times and outputs of the two FMUs, which exchange every `step` seconds."""
    spar, lines = Unit(folder / "spar_without_mooring.fmu", **START), Unit(folder / "mooring.fmu")
    place_there, speed, force_there = ([f"fairlead_{what}_{i}[{k}]" for i, k in EACH]
                                       for what in ("position", "velocity", "force"))  # fmt: skip
    place, force = ([f"fairlead_{i}.{what}[{k}]" for i, k in EACH] for what in ("position", "force"))
    times = np.linspace(0, duration, round(duration / step) + 1)
    rows = [spar.get(outputs)]
    for t in times[:-1]:
        ahead = spar.get(speed) * step / 2 if look_ahead else 0.0
        lines.set(place, spar.get(place_there) + ahead)
        spar.set(force, lines.get(force_there))  # the lines have no states: their forces follow at once
        spar.step(t, step)
        lines.step(t, step)
        rows.append(spar.get(outputs))
    return times, np.array(rows)


def main(folder=BUILT, duration=60.0, steps=(0.1, 0.05, 0.025, 0.0125), picture="connect_two.png"):
    """Largest difference of the surge [m] from that of the whole spar: {look_ahead: [one for each step]}."""
    found, curves = {}, {}
    for look_ahead in (False, True):
        for step in steps:
            times, rows = coupled(folder, duration, step, look_ahead)
            whole = fmpy.simulate_fmu(
                folder / "spar_rigid.fmu", stop_time=duration, output_interval=step, fmi_type="CoSimulation",
                start_values=START | SOLVER, output=["surge"],
            )  # fmt: skip
            curves[look_ahead, step] = times, rows[:, 0] - whole["surge"]
            found.setdefault(look_ahead, []).append(np.max(np.abs(curves[look_ahead, step][1])))
            how = "force at the middle" if look_ahead else "force at the start"
            print(f"{how:20} step {1000 * step:6.2f} ms   surge off by {found[look_ahead][-1]:.2e} m at most")
    figure, (over_time, over_step) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    over_time.plot(*curves[False, steps[-1]])
    over_time.set(xlabel="time [s]", ylabel="surge, coupled minus whole [m]", title=f"{1000 * steps[-1]:g} ms")
    for look_ahead, label in ((False, "force at the start of the step"), (True, "force at its middle")):
        over_step.loglog(1000 * np.array(steps), found[look_ahead], "o-", label=label)
    over_step.set(xlabel="exchange step [ms]", ylabel="largest difference of surge [m]")
    over_step.legend()
    figure.savefig(folder / picture, dpi=100)
    return found


if __name__ == "__main__":
    main()
