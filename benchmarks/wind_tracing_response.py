"""Response of the wind-tracing triangle to waves, rigid and elastic, calm and in steady wind (docs/wind_tracing.md).

    python benchmarks/wind_tracing_response.py [FIGURE.png]
    python benchmarks/wind_tracing_response.py blades
    python benchmarks/wind_tracing_response.py poles

The turbines of `wind_tracing_rigid`, without tilt, so that it points into the wind; the hull bends with E = 35 GPa, is
as good as rigid with 1e5 times that, and soft with 0.35 times. `blades`: rotors of blade elements beside those of
coefficients in steady wind of 10 m/s, on the hull that bends and on the rigid one, blades and towers rigid. `poles`:
the slow ones of that model, with the friction of the turret, over the wind.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import fowtlib as fw
from fowtlib.modelfile import shipped_models

PERIODS = np.arange(5, 30.01, 0.25)[::-1]
HEADINGS = (0, 45, 90, 135)
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
HULLS = {"rigid": 35e14, "elastic": 35e9, "soft": 0.35 * 35e9}
WINDS = {
    "calm": {"wind.kind": "none", "sea.spectrum": "still"},
    "11.4 m/s": {"wind.kind": "steady", "wind.mean_speed": 11.4, "sea.spectrum": "still"},
}


def plant():
    """The model with rigid turbines on the hull that bends."""
    text = shipped_models()["wind_tracing_rigid"].read_text().replace("wind_tracing}", "wind_tracing_elastic}")
    return compiled(text, {f"turbine_{name}.rotor.tilt": 0.0 for name in ("front", "left", "right")})


def with_blade_elements():
    """The model with loads on its blades, which do not bend, and neither do the towers."""
    text = shipped_models()["wind_tracing"].read_text()
    for bends, stiff in (("hinges: 2\n", "hinges: 0\n"), ("hinges: {value: 6", "hinges: {value: 0"),
                         ("        damping_fore_aft: 0.00256 s\n", "")):  # fmt: skip
        assert bends in text
        text = text.replace(bends, stiff)
    return compiled(text, {})


def compiled(text, values):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.yaml"
        path.write_text(text)
        return fw.load(path, set=values).compile()


def compare_blades(speed=10.0):
    """Differences of all motions over the largest of each heading."""
    wind = {"wind.kind": "steady", "wind.mean_speed": speed, "sea.spectrum": "still"}
    within = PERIODS[PERIODS <= 25]
    plants = (plant(), with_blade_elements())
    for hull in ("rigid", "elastic"):
        modulus = HULLS[hull]
        given = {**wind, "platform.young_modulus": modulus, "platform.structural_damping": 0.03 * 35e9 / modulus}
        states = [fw.mean_state(built, parameters=given) for built in plants]
        for heading in HEADINGS:
            coefficients, blades = (
                np.abs(np.asarray(fw.linear_rao(
                    built, 1 / within, outputs=MOTIONS, heading=np.radians(heading), state=state
                ).response)) for built, state in zip(plants, states, strict=True)
            )  # fmt: skip
            for k, motion in enumerate(MOTIONS):
                off = np.abs(blades - coefficients)[:, k]
                sizes = f"{coefficients[:, k].max():.4f}, {blades[:, k].max():.4f}"
                print(f"{hull:8} {heading:4} {motion:6} largest {sizes}, difference at most "
                      f"{off.max():.5f} at {within[off.argmax()]:g} s")  # fmt: skip


def show_poles():
    """Poles of less than 0.09 rad/s: the platform about the turret and on its lines."""
    built = with_blade_elements()
    for speed in (8.0, 10.0, 11.4, 12.0, 14.0, 18.0):
        state = fw.mean_state(built, parameters={**WINDS["11.4 m/s"], "wind.mean_speed": speed})
        for mode in fw.natural_modes(built, state):
            pole = mode.eigenvalue
            if mode.motion and abs(pole) < 0.09:
                print(f"{speed:4} m/s: {pole.real:+.5f} +- {abs(pole.imag):.5f}i 1/s, {mode.name}")


def responses(built):
    """Amplitudes (periods, motions) per metre of wave, by wind, hull and heading; angles in deg."""
    found = {}
    for wind, given in WINDS.items():
        for hull, modulus in HULLS.items():
            damping = {"platform.structural_damping": 0.03 * 35e9 / modulus}
            parameters = {**given, "platform.young_modulus": modulus, **damping}
            state = fw.mean_state(built, parameters=parameters)
            for mode in fw.natural_modes(built, parameters=parameters) if wind == "calm" else []:
                if "hull bending" in str(mode) or "platform" in str(mode):
                    print(hull, mode)
            for heading in HEADINGS:
                angle = np.radians(heading)
                rao = fw.linear_rao(built, 1 / PERIODS, outputs=MOTIONS, heading=angle, state=state)
                found[wind, hull, heading] = np.abs(np.asarray(rao.response))
    return found


def show(found):
    """What the statements of the source are about."""
    within = (PERIODS >= 5) & (PERIODS <= 25)
    for (wind, hull, heading), table in found.items():
        for k, motion in enumerate(MOTIONS):
            y = table[:, k]
            peaks = [i for i in range(1, len(y) - 1) if y[i] > y[i - 1] and y[i] > y[i + 1] and y[i] > 0.05 * y.max()]
            print(f"{wind:9} {hull:8} {heading:4} {motion:6} largest {y[within].max():7.3f}, peaks at "
                  + ", ".join(f"{PERIODS[i]:g} s ({y[i]:.3f})" for i in peaks))  # fmt: skip
    for wind, hull in ((wind, hull) for wind in WINDS for hull in HULLS):
        for k, motion in enumerate(MOTIONS):
            at = np.array([found[wind, hull, heading][:, k] for heading in HEADINGS])
            for word, which in (("largest", at.argmax(0)), ("smallest", at.argmin(0))):
                rows = (f"{h} deg: {_stretches(PERIODS[within & (which == i)])}" for i, h in enumerate(HEADINGS))
                print(f"{wind} {hull} {motion} {word} at", "; ".join(rows))


def _stretches(periods):
    ordered = np.sort(periods)
    parts = np.split(ordered, np.where(np.diff(ordered) > 0.26)[0] + 1) if len(ordered) else []
    return " ".join(f"{part[0]:g}..{part[-1]:g}" for part in parts) or "-"


def draw(found, path):
    """Amplitudes in calm air over the period, rigid dashed."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 3, figsize=(12, 6.4), sharex=True, layout="constrained")
    for k, (motion, axis) in enumerate(zip(MOTIONS, axes.ravel(), strict=True)):
        for colour, heading in zip(("C0", "C1", "C2", "C3"), HEADINGS, strict=True):
            axis.plot(PERIODS, found["calm", "elastic", heading][:, k], colour, label=f"{heading} deg")
            axis.plot(PERIODS, found["calm", "rigid", heading][:, k], colour, linestyle="--", linewidth=1)
        within = [found["calm", hull, b][PERIODS <= 25, k] for hull in ("rigid", "elastic") for b in HEADINGS]
        title = f"{motion} [{'m/m' if k < 3 else 'deg/m'}]"
        axis.set(title=title, ylim=(0, 1.1 * np.max(within)), xlim=(5, 25))
        axis.grid(alpha=0.3)
    axes[0, 0].legend()
    for axis in axes[1]:
        axis.set_xlabel("period [s]")
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    if sys.argv[1:] == ["blades"]:
        compare_blades()
        sys.exit()
    if sys.argv[1:] == ["poles"]:
        show_poles()
        sys.exit()
    table = responses(plant())
    show(table)
    if len(sys.argv) > 1:
        draw(table, sys.argv[1])
