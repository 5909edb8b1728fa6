"""What individual pitch control and floating feedback do to the OC3 spar: the tables of docs/faults.md.

`python benchmarks/feedback.py FOLDER` runs oc3_spar in one turbulent wind and one sea, keeps the numbers in FOLDER and
fills the tables; what FOLDER has already is not run again.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from pages import fill, markdown

import fowtlib as fw
from fowtlib.components.servo import IndividualPitchController, NacelleVelocity

PAGE = Path(__file__).parent.parent / "docs" / "faults.md"
CONTROL, IPC = "turbine.control.", "individual.integral_gain"
KINDS = {
    "neither": {},
    "individual pitch, 1e-9": {IPC: 1e-9},
    "individual pitch, 3e-9": {IPC: 3e-9},
    "to pitch, 0.02": {CONTROL + "pitch_per_velocity": 0.02},
    "to pitch, 0.04": {CONTROL + "pitch_per_velocity": 0.04},
    "to torque, 1000": {CONTROL + "torque_per_velocity": 1000.0},
    "to pitch, 0.02, and individual, 1e-9": {CONTROL + "pitch_per_velocity": 0.02, IPC: 1e-9},
}
DURATION, DISCARD = 700.0, 100.0
CONDITIONS = {
    "wind.kind": "turbulence", "wind.mean_speed": 18.0, "wind.turbulence_class": "B", "wind.seed": 1,
    "wind.repetition_period": 720.0, "sea.spectrum": "jonswap", "sea.significant_wave_height": 4.4,
    "sea.peak_period": 10.6, "sea.seed": 101,
}  # fmt: skip
NAMES = ["blade_root_flapwise_moment_1", "pitch", "generator_speed", "generator_power", "tower_base_fore_aft_moment"]


def equipped(name: str) -> fw.Plant:
    """A spar with both, off at first."""
    model = fw.load(name)
    root, turbine = model.root, model.root.turbine
    root.nacelle_velocity = NacelleVelocity()
    top = root.tower.frame_b if name == "oc3_spar" else root.tower_to_hub.frame_b
    root.connect(top, root.nacelle_velocity.frame)
    root.connect(root.nacelle_velocity.velocity, turbine.control.velocity)
    if name == "oc3_spar":
        root.individual = IndividualPitchController(integral_gain=0.0)
        root.connect(turbine.azimuth, root.individual.azimuth)
        for k, blade in enumerate(turbine.assembly.rotor_blades):
            root.connect(blade.flapwise_moment, root.individual.moments[k])
            root.connect(root.individual.pitch[k], turbine.assembly.individual_pitch[k])
    return model.compile()


def measured(plant: fw.Plant, gains: dict[str, float]) -> list[float]:
    """Standard deviations of NAMES, in their units, and of the pitch rate of blade 1 its rms and mean size [deg/s]."""
    blade = "turbine.assembly.hub.pitch[0]"
    result = plant.simulate(DURATION, 0.05, parameters=CONDITIONS | gains, outputs=[*NAMES, blade])
    late = np.asarray(result.time) >= DISCARD
    rate = np.degrees(np.diff(np.asarray(result[blade])[late])) / 0.05
    deviations = [float(np.asarray(result[name])[late].std()) for name in NAMES]
    return [*deviations, float(np.sqrt(np.mean(rate**2))), float(np.abs(rate).mean())]


def damping(plant: fw.Plant, wind: float, gains: dict[str, float]) -> float:
    """Damping ratio [%] of the platform's pitch, by the linear model of oc3_spar_rigid."""
    calm = {"wind.kind": "steady", "wind.mean_speed": wind, "sea.spectrum": "still"}
    own = {path: value for path, value in gains.items() if path.startswith(CONTROL)}
    modes = fw.natural_modes(plant, fw.mean_state(plant, calm | own))
    return 100 * float(next(mode.damping_ratio for mode in modes if mode.name.split(",")[0] == "platform pitch"))


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "feedback.json"
    known: dict[str, list[float]] = json.loads(file.read_text()) if file.exists() else {}
    if any(name not in known for name in KINDS):
        plant = equipped("oc3_spar")
        for name, gains in KINDS.items():
            if name not in known:
                known[name] = measured(plant, gains)
                file.write_text(json.dumps(known, indent=1))
                print(name, known[name], flush=True)
    rigid = equipped("oc3_spar_rigid")
    dampings = {name: [damping(rigid, wind, gains) for wind in (13.0, 18.0)] for name, gains in KINDS.items()
                if IPC not in gains}  # fmt: skip
    print(dampings)
    heads = ("feedback", "flapwise root moment [MN m]", "platform pitch [deg]", "generator speed [rpm]", "power [kW]",
             "tower base [MN m]", "pitch rate, rms [deg/s]", "pitch rate, mean size [deg/s]")  # fmt: skip
    scale = (1e-6, 1, 1, 1, 1e-6, 1, 1)
    rows = [(name, *(s * v for s, v in zip(scale, values, strict=True))) for name, values in known.items()]
    text = fill(PAGE.read_text(), "feedback_deviations", markdown((heads, rows), 3))
    found = [(name, *values) for name, values in dampings.items()]
    text = fill(text, "feedback_damping", markdown((("feedback", "13 m/s", "18 m/s"), found), 3))
    PAGE.write_text(text)


if __name__ == "__main__":
    main()
