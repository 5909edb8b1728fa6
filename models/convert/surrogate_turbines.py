"""Writes turbines/surrogate_7mw.yaml and surrogate_15mw.yaml by the rule of fowtlib.design.rules.turbine."""

from __future__ import annotations

from pathlib import Path

from fowtlib.design.rules.turbine import DTU_10MW, NREL_5MW, TurbineSizes, between, pitch_gains

RADIUS, POWER = 85.6, 7.0e6
# of the rated speed, DTU 10-MW
SPEEDS = {"cut_in_speed": 280 / 480, "region_2_speed": 320 / 480, "region_3_speed": 475 / 480}
LARGE_RADIUS, LARGE_POWER = 120.97, 15.0e6
TURBINES = Path(__file__).parents[1] / "turbines"


def surrogate(radius: float, power: float) -> TurbineSizes:
    """By the powers through the two known turbines, also beyond them."""
    return between(NREL_5MW, DTU_10MW, radius, power, f"surrogate {power / 1e6:g}-MW")


def text(turbine: TurbineSizes, about: str) -> str:
    """The definition file; about: what it stands for."""
    megawatts = f"{turbine.rated_power / 1e6:g}"
    n, rpm = turbine.gear_ratio, 9.549296585513721
    x, z = turbine.centre
    xx, yy, zz, xz = turbine.inertia
    rated = turbine.rated_torque / n
    proportional, integral = pitch_gains(turbine, DTU_10MW, 0.1794, 0.0165)
    speed = turbine.rated_speed * n * rpm
    speeds = "\n".join(f"        {key}: {share * speed:.6g} rpm" for key, share in SPEEDS.items())
    return f"""# {about}
# Made by models/convert/surrogate_turbines.py by the rule of fowtlib.design.rules.turbine: what belongs to the
# rotor by its radius, to nacelle and drive train by the rated torque; coefficients and controller of the DTU 10-MW.
# The frame is the hub.
fowtlib: 1
title: Surrogate {megawatts}-MW rotor, nacelle, drive train and controller
class: RotorNacelle
mass: {turbine.mass:.0f} kg
centre_of_mass: [{x:.5f}, 0, {z:.5f}]
inertia: [[{xx:.0f}, 0, {xz:.0f}], [0, {yy:.0f}, 0], [{xz:.0f}, 0, {zz:.0f}]]
gear_ratio: {n:.6g}
generator_inertia: {turbine.generator_inertia / n**2:.6g} kg*m^2
parts:
  rotor:
    class: CoefficientRotor
    coefficients: data:dtu10mw/rotor_coefficients.csv
    radius: {turbine.radius:g} m
    precone: 2.5 deg
    tilt: 5 deg
    inertia: {turbine.rotor_inertia:.0f} kg*m^2
  control:
    class: BaselineController
    rated_speed: {speed:.6g} rpm
    filter_frequency: 1.25 Hz
    # {proportional:.4f} s and {integral:.5f} of the rotor's speed
    proportional_gain: {proportional / n:.6g} s
    integral_gain: {integral / n:.6g}
    region_3: constant_torque
    parts:
      pitch:
        scheduled: gains
        doubling_pitch: 2.0597 rad
        schedule_curvature: 16.8919 rad^-2
        greatest_rate: 10 deg/s
      torque:
{speeds}
        rated_torque: {rated:.6g} N*m
        region_2_constant: {turbine.optimal_constant / n**3:.6g} N*m*s^2/rad^2
        greatest_torque: {1.5683 * rated:.6g} N*m
        greatest_rate: {0.7842 * rated:.6g} N*m/s
        response_time: 0.008 s
  safety: {{greatest_rate: 4 deg/s, brake_torque: {0.941 * rated:.6g} N*m, brake_time: 0.6 s}}
"""


ABOUT = {
    (
        RADIUS,
        POWER,
    ): "A 7-MW turbine between the NREL 5-MW and the DTU 10-MW, rigid, above its tower, for one of closed data.",
    (
        LARGE_RADIUS,
        LARGE_POWER,
    ): "A 15-MW turbine by the powers through the NREL 5-MW and the DTU 10-MW, rigid, above its tower.",
}

if __name__ == "__main__":
    for (radius, power), about in ABOUT.items():
        path = TURBINES / f"surrogate_{power / 1e6:g}mw.yaml"
        path.write_text(text(surrogate(radius, power), about))
