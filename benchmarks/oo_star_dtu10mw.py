"""The OO-Star with one DTU 10-MW turbine in three winds: `python benchmarks/oo_star_dtu10mw.py` prints tables for docs.

J.M. Hegseth, E.E. Bachynski and B.J. Leira (J. Phys.: Conf. Ser. 1452, 2020, 012040) print how far deviations of a
linear model are from those of a nonlinear one, with the aerodynamic damping of a rotor at constant speed and pitch,
dT/dU, or with inertia and damping by frequency. Here the response of the model has the rotor and its controller in the
loop, which is the latter; for the former a turbine that stands fast in the same wind pushes the floater, with a
constant damping beside. Both over runs of the nonlinear model, hours with a wind and a sea of their own, kept in
`--folder`.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from pages import markdown
from scipy.stats import t as student

import fowtlib as fw
from fowtlib.components.mechanics import Frame
from fowtlib.language import RealInput, Scalar, der, eq, param, port
from fowtlib.language import math as m

MODEL = Path(__file__).with_suffix(".yaml")
DISCARD, HOUR, STEP = 600.0, 3600.0, 0.1
STATES = {"C1": (13.0, 2.7, 10.3), "C2": (19.0, 4.0, 11.1), "C3": (25.0, 5.8, 12.1)}  # wind, Hs, Tp
NAMES = ["surge", "heave", "pitch", "tower_base_moment", "thrust", "rotor_speed", "blade_pitch"]
# printed, in % of the deviation of the nonlinear model: constant damping, by frequency from the linear model
PRINTED = {
    ("C1", "pitch"): (-0.2, 23.7), ("C2", "pitch"): (-24.8, 38.0), ("C3", "pitch"): (-29.6, 55.0),
    ("C1", "tower_base_moment"): (-7.1, 13.0), ("C2", "tower_base_moment"): (-29.8, 15.1),
    ("C3", "tower_base_moment"): (-33.0, 19.2),
}  # fmt: skip


class PushedHub(fw.Component):
    """The thrust of a turbine that stands elsewhere on a hub, and a damping of the velocity of the hub along it."""

    damping: Scalar = param(default=0.0, unit="N*s/m", doc="dT/dU at constant speed and pitch")
    tilt: Scalar = param(default="5 deg", unit="rad", doc="of the shaft")

    frame: Frame = port(doc="hub")
    thrust: RealInput = port(unit="N", doc="of the other turbine")

    def equations(self):
        n = self.frame.R @ m.vertcat(m.cos(self.tilt), 0, -m.sin(self.tilt))
        force = (self.thrust - self.damping * m.dot(n, der(self.frame.r))) * n
        return [eq(self.frame.f, -force), eq(self.frame.t, m.zeros(3))]


def apart() -> Any:
    """The floater with rotor and nacelle as a body, pushed by the thrust of a turbine that stands fast."""
    text = MODEL.read_text().replace("rna: {use: turbines/dtu10mw_on_tower}", """rna: {use: turbines/dtu10mw_on_tower}
  ground: {class: Fixed, r: [0, 0, top]}
  body: {use: turbines/dtu10mw_body}
  to_hub: {class: FixedTranslation, r: [-7.07298, 0, 3.36881]}""")  # fmt: skip
    joined = [("ground.frame", "rna"), ("tower_to_top.frame_b", "body"), ("tower_to_top.frame_b", "to_hub.frame_a")]
    lines = "\n  - ".join(f"[{a}, {b if '.' in b else f'{b}.frame'}]" for a, b in joined)
    text = text.replace("[tower_to_top.frame_b, rna.frame]", lines)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "apart.yaml"
        path.write_text(text)
        model = fw.load(path)
    root = model.root
    root.push = PushedHub()
    root.connect(root.to_hub.frame_b, root.push.frame)
    root.connect(root.rna.turbine.thrust, root.push.thrust)
    return model.compile()


def weather(state: str) -> dict[str, Any]:
    speed, height, period = STATES[state]
    return {"wind.mean_speed": speed, "sea.significant_wave_height": height, "sea.peak_period": period}


def hours(folder: Path, plant: Any, state: str, seeds: int) -> np.ndarray:
    """Deviations (seeds, results) of hours of the nonlinear model."""
    found = []
    for seed in range(1, seeds + 1):
        path = folder / f"{state}_{seed}.json"
        if not path.exists():
            period = {f"{part}.repetition_period": DISCARD + HOUR for part in ("wind", "sea")}
            given = weather(state) | period | {"wind.seed": seed, "sea.seed": seed + 50, "wind.sample_step": STEP}
            run = plant.simulate(DISCARD + HOUR, STEP, parameters=given, outputs=NAMES)
            kept = run.time >= DISCARD
            path.write_text(json.dumps({n: float(np.std(run[n].values[kept])) for n in NAMES}))
        found.append([json.loads(path.read_text())[n] for n in NAMES])
    return np.array(found)


def constant_damping(plant: Any, state: str) -> float:
    """dT/dU [N s/m] at constant rotor speed and pitch: what a fast motion of the hub feels."""
    turbine = fw.aerodynamic_coefficients(plant, [20.0], parameters=weather(state))
    return float(turbine.damping[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--states", default="C1,C2,C3")
    parser.add_argument("--folder", type=Path, default=Path("output/oo_star_dtu10mw"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    whole, pushed, rows = fw.load(MODEL).compile(), apart(), []
    for state in given.states.split(","):
        runs = hours(given.folder, whole, state, given.seeds)
        mean = runs.mean(axis=0)
        half = student.ppf(0.975, given.seeds - 1) * runs.std(axis=0, ddof=1) / np.sqrt(given.seeds) / mean
        by_frequency = fw.response(whole, outputs=NAMES, parameters=weather(state))
        damping = constant_damping(whole, state)
        constant = fw.response(pushed, outputs=NAMES, parameters=weather(state) | {"push.damping": damping})
        print(f"{state}: damping {damping:.4g} N s/m", flush=True)
        for k, name in enumerate(NAMES):
            errors = [f"{100 * (one.std(name) / mean[k] - 1):+.1f}" for one in (constant, by_frequency)]
            printed = [f"{value:+.1f}" for value in PRINTED.get((state, name), ())] or ["", ""]
            rows.append((state, name, f"{mean[k]:.4g}", *errors, f"{100 * half[k]:.0f}", *printed))
    heads = ("state", "result", "runs", "constant [%]", "in the loop [%]", "bound [%]", "printed, constant", "printed")
    print(markdown((heads, rows), 3))


if __name__ == "__main__":
    main()
