"""What the products of fluctuations in the loads of a rotor do: `python benchmarks/linear_rotor.py MODEL WIND`.

Hours of a model with a rotor of coefficients, as it is, and with its thrust, its torque, or both linear about the mean:
value and slopes of the table there, which leave the response as it is. Where runs with both agree with the response,
and runs as they are do not, the loads of the rotor are the cause. Two more responses have slopes that know of the
turbulence: the mean of the slopes over what the runs met, and those of the loads fitted to the runs by least squares.
Models: oc3_spar_rigid in the wind of its hub, dtu10mw_spar_1_operating (2, 3) in effective winds; 13, 15, 18 m/s.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pages import markdown

import fowtlib as fw
from fowtlib.components.aero.coefficient_rotor import CoefficientRotor
from fowtlib.language import der, eq
from fowtlib.language import math as m
from fowtlib.solving.starts import mean_parameters

DISCARD, HOUR, STEP = 600.0, 3600.0, 0.2
SEAS = {13.0: (3.3, 9.7), 15.0: (3.7, 9.9), 18.0: (4.4, 10.6)}  # the most probable: Hs [m], Tp [s]
ROTORS = {"oc3_spar_rigid": ("turbine.rotor", "kaimal")} | {
    f"dtu10mw_spar_{k}_operating": ("rna.turbine.rotor", "ntm") for k in (1, 2, 3)
}
RESULTS = ("surge", "pitch", "rotor_speed", "blade_pitch", "thrust", "tower_base_moment", "fairlead_tension_2",
           "upwind_tension")  # fmt: skip
STEPS = np.array([0.05, 0.05, 0.003, 0.002])  # of wind, wind of the tip speed ratio, rotor speed, pitch; SI
SEEN = ("relative_wind", "mean_wind", "normal_wind", "w", "blade_pitch", "thrust", "torque")
LOADS = ("thrust", "torque")


@dataclass(frozen=True)
class Line:
    """A load that is linear in relative wind, wind of the tip speed ratio, rotor speed and pitch."""

    value: float
    slopes: np.ndarray
    point: np.ndarray

    def at(self, *where: Any) -> Any:
        moved = (x - float(p) for x, p in zip(where, self.point, strict=True))
        return self.value + sum(float(k) * x for k, x in zip(self.slopes, moved, strict=True))


@contextmanager
def linear(lines: Mapping[str, Line]) -> Iterator[None]:
    """Rotors of coefficients that are compiled meanwhile have these loads as lines."""
    whole = CoefficientRotor.equations

    def equations(self: Any) -> list[Any]:
        R, hub = self.radius * m.cos(self.precone), m.dot(self.normal(), der(self.frame.r))

        def load(name: str, wind: Any, plain: Any) -> Any:
            if name not in lines:
                return plain
            return lines[name].at(wind, self.mean_wind - hub, self.w, self.blade_pitch)

        thrust = self.force_in(self.relative_wind) * self.thrust_coefficient
        torque = self.force_in(self.torque_wind()) * R * self.torque_coefficient
        return [
            super(CoefficientRotor, self).equations(),
            eq(self.thrust, load("thrust", self.relative_wind, thrust)),
            eq(self.torque, load("torque", self.torque_wind(), torque)),
            self.coefficients_in(hub),
        ]

    CoefficientRotor.equations = equations
    try:
        yield
    finally:
        CoefficientRotor.equations = whole


def loads_of(rotor: Any, air_density: float) -> Any:
    """Thrust and torque of the table, of the four numbers: (2, ...)."""
    radius, cone = rotor.parameter_value("radius"), rotor.parameter_value("precone")
    area = np.pi * (radius * np.cos(cone)) ** 2

    def loads(wind: Any, ratio_wind: Any, speed: Any, pitch: Any) -> np.ndarray:
        C_t, C_q = rotor.coefficients(speed * radius / ratio_wind, pitch)
        force = air_density / 2 * area * wind * np.abs(wind)
        return np.array([force * C_t, force * radius * np.cos(cone) * C_q])

    return loads


def slopes(loads: Any, points: np.ndarray) -> np.ndarray:
    """(2, 4, n): of both loads at points (n, 4)."""
    ahead, behind = (np.array([loads(*(points + s * e).T) for e in np.diag(STEPS)]) for s in (1, -1))
    return ((ahead - behind) / (2 * STEPS[:, None, None])).transpose(1, 0, 2)


def fitted(points: np.ndarray, loads: np.ndarray, filtered: bool) -> np.ndarray:
    """(2, 4): slopes of loads (2, n) by least squares; both winds are one where the ratio takes no filtered one."""
    columns = [0, 1, 2, 3] if filtered else [0, 2, 3]
    design = np.c_[np.ones(len(points)), (points - points.mean(axis=0))[:, columns]]
    found = np.zeros((2, 4))
    found[:, columns] = np.linalg.lstsq(design, loads.T, rcond=None)[0][1:].T
    return found


def compare(name: str, speed: float, seeds: int, folder: Path) -> str:
    """The table of one model in one wind."""
    where, kind = ROTORS[name]
    given = {"wind.kind": kind, "wind.turbulence_class": "B", "wind.mean_speed": speed, "sea.spectrum": "jonswap",
             "sea.significant_wave_height": SEAS[speed][0], "sea.peak_period": SEAS[speed][1]}  # fmt: skip
    plain = fw.load(name).compile()
    names = [n for n in RESULTS if n in plain.outputs]
    rotor = plain.root
    for step in where.split("."):
        rotor = getattr(rotor, step)
    loads = loads_of(rotor, float(plain.root.world.parameter_value("air_density")))
    mean = fw.mean_state(plain, mean_parameters(plain, given))
    point = np.array([[float(mean[f"{where}.{n}"]) for n in ("relative_wind", "mean_wind", "w", "blade_pitch")]])
    value, at = loads(*point.T)[:, 0], slopes(loads, point)[:, :, 0]
    lines = {n: Line(float(value[k]), at[k], point[0]) for k, n in enumerate(LOADS)}
    variants = {"as it is": {}, **{f"{n} linear": {n: lines[n]} for n in LOADS}, "both linear": lines}
    response, deviations, met = fw.response(plain, outputs=names, parameters=given), {}, []
    for label, chosen in variants.items():
        with linear(chosen):
            plant = fw.load(name).compile() if chosen else plain
        found = []
        for seed in range(1, seeds + 1):
            path = folder / f"{name}_{speed:g}_{seed}_{label.replace(' ', '_')}.npz"
            if not path.exists():
                period = {f"{part}.repetition_period": DISCARD + HOUR for part in ("wind", "sea")}
                more = period | {"wind.seed": seed, "sea.seed": seed + 50, "wind.sample_step": 0.1}
                seen = [f"{where}.{n}" for n in SEEN]
                run = plant.simulate(DISCARD + HOUR, STEP, parameters=given | more, solver="fixed", start="turning",
                                     outputs=[*names, *seen])  # fmt: skip
                kept = run.time >= DISCARD
                np.savez(path, deviations=[np.std(run[n].values[kept]) for n in names],
                         seen=[np.asarray(run[n].values)[kept][::5] for n in seen])  # fmt: skip
            with np.load(path) as data:
                found.append(data["deviations"])
                met += [data["seen"]] if label == "as it is" else []
        deviations[label] = np.mean(found, axis=0)
    wind, mean_wind, normal, w, pitch, *both = np.hstack(met)
    points = np.array([wind, mean_wind - (normal - wind), w, pitch]).T
    answers = {}
    for label, by in (
        ("slopes averaged", slopes(loads, points).mean(axis=2)),
        ("slopes fitted", fitted(points, np.array(both), rotor.filtered)),
    ):
        with linear({n: Line(float(np.mean(both[k])), by[k], points.mean(axis=0)) for k, n in enumerate(LOADS)}):
            answers[label] = fw.response(fw.load(name).compile(), outputs=names, parameters=given)
    rows = []
    for k, n in enumerate(names):
        cells = [response.std(n) / one[k] for one in deviations.values()]
        cells += [one.std(n) / deviations["as it is"][k] for one in answers.values()]
        rows.append((n, *(f"{cell:.2f}" for cell in cells)))
    return markdown((("result", *variants, *answers), rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", choices=list(ROTORS))
    parser.add_argument("speed", type=float, choices=list(SEAS))
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--folder", type=Path, default=Path("output/linear_rotor"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    print(f"{given.model}, {given.speed:g} m/s, {given.seeds} seeds: response over runs\n")
    print(compare(given.model, given.speed, given.seeds, given.folder))


if __name__ == "__main__":
    main()
