"""A controller in Python drives the turbine of an FMU: every 12.5 ms it reads the speed and sets pitch and torque.

It is that of the NREL 5-MW turbine (NREL/TP-500-38060, chapter 7, with a plain torque law) with the gains for the OC3
spar (NREL/TP-500-47535, section 6). Put your own in its place.

python fmus/external_controller.py      after `make fmus`; the picture is fmus/built/external_controller.png
"""

from math import exp, pi
from pathlib import Path

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.simulation import instantiate_fmu

BUILT = Path(__file__).parent / "built"
PERIOD = 0.0125  # [s]
COMMANDS = ["blade_pitch", "generator_torque"]
OUTPUTS = {  # values in an FMU are SI
    "generator_speed": ("generator [rpm]", 30 / pi),
    "blade_pitch": ("blade pitch [deg]", 180 / pi),
    "generator_power": ("power [MW]", 1e-6),
    "pitch": ("platform pitch [deg]", 180 / pi),
}


class Controller:
    """PI control of the speed by the pitch, torque by the speed; SI units."""

    rated_speed, rated_torque = 1173.7 * pi / 30, 43093.55
    proportional_gain, integral_gain, doubling_pitch = 0.006275604, 0.0008965149, 0.1099965
    pitch_rate, torque_rate = 8 * pi / 180, 15000.0
    region_2_constant = 0.0255764 * (30 / pi) ** 2
    forget = exp(-2 * pi * 0.25 * PERIOD)  # low-pass filter of the speed, 0.25 Hz

    def __init__(self, speed, pitch, torque):
        self.filtered, self.pitch, self.torque = speed, pitch, torque
        self.integral = pitch * (1 + pitch / self.doubling_pitch)

    def step(self, speed):
        """Pitch [rad] and torque [N m] after one more measured generator speed [rad/s]."""
        self.filtered = self.forget * self.filtered + (1 - self.forget) * speed
        error, gain = self.filtered - self.rated_speed, 1 / (1 + self.pitch / self.doubling_pitch)
        self.integral = np.clip(self.integral + self.integral_gain * error * PERIOD, 0, pi / 2 / gain)
        wanted = np.clip(gain * (self.proportional_gain * error + self.integral), 0, pi / 2)
        self.pitch += np.clip(wanted - self.pitch, -self.pitch_rate * PERIOD, self.pitch_rate * PERIOD)
        below_rated = min(self.region_2_constant * self.filtered**2, self.rated_torque)
        asked = self.rated_torque if self.pitch > pi / 180 else below_rated
        self.torque += np.clip(asked - self.torque, -self.torque_rate * PERIOD, self.torque_rate * PERIOD)
        return self.pitch, self.torque


def main(folder=BUILT, duration=120.0, picture="external_controller.png"):
    """Times and outputs in SI, one column each in the order of OUTPUTS."""
    path = folder / "spar_open_control.fmu"
    described = fmpy.read_model_description(path)
    number = {v.name: v.valueReference for v in described.modelVariables}
    commands, outputs = [number[f"turbine.{n}"] for n in COMMANDS], [number[n] for n in OUTPUTS]
    fmu = instantiate_fmu(fmpy.extract(path, path.with_suffix("")), described, "CoSimulation")
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    controller = Controller(*fmu.getFloat64([number["generator_speed"], *commands]))  # where the FMU starts
    times, rows = np.arange(round(duration / PERIOD) + 1) * PERIOD, []
    for t in times:
        fmu.setFloat64(commands, controller.step(fmu.getFloat64([number["generator_speed"]])[0]))
        rows.append(fmu.getFloat64(outputs))
        if t < times[-1]:
            fmu.doStep(currentCommunicationPoint=t, communicationStepSize=PERIOD)
    fmu.freeInstance()
    figure, axes = plt.subplots(len(OUTPUTS), 1, figsize=(8, 7), sharex=True, layout="constrained")
    for axis, values, (label, factor) in zip(axes, np.transpose(rows), OUTPUTS.values(), strict=True):
        axis.plot(times, values * factor)
        axis.set_ylabel(label)
    axes[-1].set_xlabel("time [s]")
    figure.savefig(folder / picture, dpi=100)
    return times, np.array(rows)


if __name__ == "__main__":
    main() if BUILT.is_dir() else exit("There are no archives yet; make them: make fmus")
