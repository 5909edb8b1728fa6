"""Runs of the wind-tracing triangle that bends: turns of the wind, both hulls, a storm (docs/wind_tracing.md).

    python benchmarks/wind_tracing_turns.py [turns|hulls|storm] [FIGURE.png]

Three NREL 5-MW turbines with flexible blades; `hulls` has them rigid. A turn of two hours takes 40 s of processor time.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.modelfile import shipped_models

NAMES = ("front", "left", "right")
WINDS = (8.0, 10.0, 11.4, 12.0, 14.0, 18.0)  # m/s
HULLS = {"bends": (35e9, 0.03), "stiff": (35e14, 0.0)}  # Young's modulus [Pa], damping over stiffness [s]
STORM = {
    "wind.kind": "turbulence", "wind.mean_speed": 50.0, "wind.turbulence_class": "B", "wind.point_spacing": 20.0,
    "wind.repetition_period": 900.0, "sea.significant_wave_height": 12.7, "sea.peak_period": 14.1,
    "sea.heading": np.radians(30), **{f"turbine_{name}.safety.idling": 1 for name in NAMES},
}  # fmt: skip
SHARES = (0.04, 0.15, 0.5, 0.85, 0.96)  # of each pontoon, where there are sections


def with_sections() -> str:
    """The model file of the triangle, with sections in its pontoons."""
    feet = np.array([[-160.0415, 0, -13.5], [80.0207, 138.6, -13.5], [80.0207, -138.6, -13.5]])
    points = [((1 - s) * feet[k] + s * feet[(k + 1) % 3]).tolist() for k in range(3) for s in SHARES]
    use = f"{{use: platforms/wind_tracing_elastic, parts: {{hull: {{section_points: {points}}}}}}}"
    return shipped_models()["wind_tracing"].read_text().replace("{use: platforms/wind_tracing_elastic}", use)


def compiled(text: str):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.yaml"
        path.write_text(text)
        return fw.load(path).compile()


def hull(kind: str) -> dict[str, float]:
    modulus, damping = HULLS[kind]
    return {"platform.young_modulus": modulus, "platform.structural_damping": damping}


def turns(figure: str | None) -> None:
    """The wind turns by 90 deg in 10 minutes: yaw [deg], its turning points and what is left in the last hour."""
    plant = fw.load("wind_tracing").compile()
    slow = {f"turbine_{name}.control.proportional_gain": 0.05 * 0.006275604 for name in NAMES}
    slow |= {f"turbine_{name}.control.integral_gain": 0.05**2 * 0.0008965149 for name in NAMES}
    cases = {f"{wind:g} m/s": {"wind.mean_speed": wind} for wind in WINDS}
    cases["11.4 m/s, pitch loop 20 times slower"] = {"wind.mean_speed": 11.4, **slow}
    found = {}
    for name, case in cases.items():
        turn = {"wind.kind": "veer", "wind.turn": np.radians(90), "wind.turn_duration": 600, "sea.spectrum": "still"}
        result = plant.simulate(7200.0, output_step=1.0, parameters={**turn, **case})
        found[name] = np.asarray(result["yaw"])
        smooth = np.convolve(found[name], np.ones(119) / 119, "valid")
        at = np.flatnonzero(np.diff(smooth[:-1]) * np.diff(smooth[1:]) < 0) + 1
        last = found[name][-3600:]
        print(name, "turns at", [(int(k) + 59, round(float(smooth[k]), 1)) for k in at][:9],
              f"last hour {last.mean():.2f} deg, swing {np.ptp(last) / 2:.2f} deg", flush=True)  # fmt: skip
    if figure:
        draw(found, figure)


def draw(found: dict[str, np.ndarray], path: str) -> None:
    import matplotlib.pyplot as plt

    picture, axis = plt.subplots(figsize=(9, 4.2), layout="constrained")
    for name, yaw in found.items():
        axis.plot(np.arange(len(yaw)) / 60, yaw, "k--" if "loop" in name else "-", label=name, linewidth=1.4)
    axis.set(xlabel="time [min]", ylabel="yaw [deg]", title="the wind turns by 90 deg in 10 minutes", xlim=(0, 120))
    axis.grid(alpha=0.3)
    axis.legend()
    picture.savefig(path, dpi=110)


def hulls() -> None:
    """Rigid turbines in turbulence and waves, three seeds: deviations of both hulls."""
    text = shipped_models()["wind_tracing_rigid"].read_text()
    plant = compiled(text.replace("wind_tracing}", "wind_tracing_elastic}"))
    for seed in (1, 2, 3):
        given = {"sea.heading": np.radians(40), "wind.seed": seed, "sea.seed": seed}
        deviations = {}
        for kind in HULLS:
            result = plant.simulate(900.0, output_step=0.2, parameters={**given, **hull(kind)})
            for name in ("surge", "sway", "heave", "roll", "pitch", "yaw", "mooring_tension_1"):
                deviations.setdefault(name, []).append(float(np.asarray(result[name])[1500:].std()))
        print(f"seed {seed}:", {name: f"{100 * (a / b - 1):+.1f} %" for name, (a, b) in deviations.items()}, flush=True)


def storm() -> None:
    """Deviations of both hulls, and bending of the pontoons about the horizontal [MN m]."""
    plant = compiled(with_sections())
    for kind in HULLS:
        result = plant.simulate(900.0, output_step=0.2, parameters={**STORM, **hull(kind)}, start="rest", step=0.0125)
        for name in ("surge", "heave", "roll", "pitch", "yaw", "mooring_tension_1", "tower_base_fore_aft_moment_front",
                     "tower_base_side_side_moment_front", "tower_base_fore_aft_moment_left"):  # fmt: skip
            print(kind, name, f"{np.asarray(result[name])[1500:].std():.4g}", flush=True)
        sections = np.asarray(result["platform.hull.sections.moment"]).reshape(-1, 3, len(SHARES), 3)
        moment = sections[1500:, :, 2, 1] / 1e6
        rest = moment.mean(axis=0)
        for k in range(3):
            print(kind, f"pontoon {k + 1}: {rest[k]:.0f} at rest, deviation {moment[:, k].std():.0f},",
                  f"furthest {np.abs(moment[:, k] - rest[k]).max():.0f} MN m", flush=True)  # fmt: skip


if __name__ == "__main__":
    asked = sys.argv[1:] or ["turns"]
    if asked[0] == "turns":
        turns(asked[1] if len(asked) > 1 else None)
    else:
        {"hulls": hulls, "storm": storm}[asked[0]]()
