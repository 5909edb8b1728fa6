"""Damping of a parked blade of the NREL 5 MW over its angle of attack: table and picture of docs/unsteady_airfoils.md.

python benchmarks/stall_vibration.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pages import fill, markdown
from scipy.optimize import curve_fit

import fowtlib as fw
from fowtlib.components.aero import BladeElementAerodynamics
from fowtlib.components.aero.blade_element_aerodynamics import node_points
from fowtlib.components.environment import Wind, World
from fowtlib.components.mechanics import Fixed
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.components.turbine import FlexibleBlade
from fowtlib.modelfile import data_path

DOCS = Path(__file__).parents[1] / "docs"
SPEED, EDGE = 50.0, (0.95, 1.25)  # [m/s]; [Hz], where the first edgewise mode is
ANGLES = np.arange(-24.0, 61.0, 4.0)
TIMED = {"steady": (-8.0, 4.0, 16.0, 44.0), "beddoes_leishman": (-8.0, 4.0, 16.0, 44.0)}


def parked_blade(word: str, speed: float = SPEED, **more) -> fw.Plant:
    """One blade upright, its root held, in wind from any side: `at` gives the parameters; without gravity."""
    model = fw.Assembly("parked blade")
    model.world = World(gravity=0)
    model.wind = Wind(kind="steady", mean_speed=speed, stations=[(0, 100)])
    model.air = BladeElementAerodynamics(
        blade=str(data_path("nrel5mw/blade_aerodynamics.csv")), airfoils=str(data_path("nrel5mw/airfoils.csv")),
        hub_radius=1.5, tip_radius=63, blades=1, airfoil_model=word, **more,
    )  # fmt: skip
    model.hub, model.root = Fixed(r=(0, 0, 100)), Fixed(r=(0, 0, 101.5))
    model.blade = FlexibleBlade(
        properties=str(data_path("nrel5mw/blade_structure.csv")), node_points=node_points(model.air.rotor.blade),
        damping_flapwise="0.00225 s", damping_edgewise="0.00141 s",
    )  # fmt: skip
    model.connect(model.hub.frame, model.air.hub)
    model.connect(model.root.frame, model.blade.frame_a)
    for i in range(model.air.rotor.nodes):
        model.connect(model.blade.nodes[i], model.air.nodes[i])
    return fw.load(model).compile()


def at(angle: float) -> dict[str, float]:
    """Parameters with which a section without twist meets the wind at an angle of attack [deg]."""
    return {"wind.direction": np.radians(90 - angle)}


def edge_mode(plant: fw.Plant, angle: float) -> tuple[complex, np.ndarray]:
    """Eigenvalue of the first edgewise mode, and the motion of the aerodynamic nodes (n, 2): flap- and edgewise."""
    nodes = range(17)
    linear = plant.linearize(plant.equilibrium(parameters=at(angle)), outputs=[f"air.nodes[{i}].r" for i in nodes])
    values, vectors = np.linalg.eig(np.asarray(linear.A))
    motion = (np.asarray(linear.C) @ vectors).reshape(len(nodes), 3, -1)[:, :2]
    size = np.abs(motion[-1, 1]) / np.linalg.norm(vectors, axis=0)
    inside = (values.imag > 2 * np.pi * EDGE[0]) & (values.imag < 2 * np.pi * EDGE[1])
    k = int(np.argmax(np.where(inside, size, -1)))
    shape = motion[:, :, k] / motion[-1, 1, k]
    return complex(values[k]), shape


def damping(eigenvalue: complex) -> float:
    """As a part of the critical, in %."""
    return -100 * eigenvalue.real / abs(eigenvalue)


def quasi_steady_damping(angle: float, shape: np.ndarray, still: complex, speed: float = SPEED) -> float:
    """Damping ratio [%] by the formula of Petersen et al. (1998, Riso-R-1046) and Hansen (2003, Wind Energy 6:179).

    A section with the relative wind W whose motion has the parts u_d along the drag and u_l along the lift has
    forces -c u, c = rho chord W / 2 [[2 c_d, c_d' - c_l], [2 c_l, c_l' + c_d]]; the mode (`shape`) sums them up. The
    angles of attack are those of the blade at rest. still: the mode's eigenvalue without air.
    """
    elements = BladeElementAerodynamics(
        blade=str(data_path("nrel5mw/blade_aerodynamics.csv")), airfoils=str(data_path("nrel5mw/airfoils.csv")),
        hub_radius=1.5, tip_radius=63, blades=1,
    ).rotor.blade  # fmt: skip
    beam = read_beam(str(data_path("nrel5mw/blade_structure.csv")))
    mass = beam.at("mass_per_length", elements.radius - elements.hub_radius) * elements.length
    inflow, step, power = np.radians(angle), 1e-4, 0.0
    drag, lift = np.array([np.sin(inflow), np.cos(inflow)]), np.array([np.cos(inflow), -np.sin(inflow)])  # flap, edge
    for i, name in enumerate(elements.airfoil):
        alpha, foil = inflow - elements.twist[i], elements.airfoils[name]
        slope = (foil.at(alpha + step) - foil.at(alpha - step)) / (2 * step)
        cl, cd = foil.at(alpha)[:2]
        c = 0.5 * 1.225 * elements.chord[i] * elements.length[i] * speed * np.array(
            [[2 * cd, slope[1] - cl], [2 * cl, slope[0] + cd]]
        )  # fmt: skip
        u = np.array([shape[i] @ drag, shape[i] @ lift])
        power += float(np.real(u.conj() @ c @ u))
    modal = float(mass @ (np.abs(shape) ** 2).sum(axis=1))
    return damping(still) + 100 * power / (2 * abs(still) * modal)


def decrement(plant: fw.Plant, angle: float, duration: float = 36.0, discarded: float = 12.0) -> float:
    """Damping ratio [%] of the edgewise motion after a turn of the wind by 0.1 deg, from the vibration that fits."""
    start = plant.equilibrium(parameters=at(angle + 0.1))
    result = plant.simulate(
        duration, 0.02, start=start, parameters=at(angle), outputs=["blade.tip_deflection"], solver="idas",
        tolerance=1e-9,
    )  # fmt: skip
    t, y = np.asarray(result.time), np.asarray(result.array("blade.tip_deflection"))[:, 1]
    t, y = t[t >= discarded] - discarded, y[t >= discarded]

    def vibration(t, a, b, rate, omega, rest):
        return rest + np.exp(rate * t) * (a * np.cos(omega * t) + b * np.sin(omega * t))

    size, rest = float(y.std()), float(y.mean())
    (_, _, rate, omega, _), _ = curve_fit(vibration, t, y, p0=[size, size, -0.03, 2 * np.pi * 1.08, rest])
    return -100 * rate / float(np.hypot(rate, omega))


def main() -> None:
    """Fill the page and draw the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    words = ("steady", "attached", "oye", "beddoes_leishman")
    plants = {word: parked_blade(word) for word in words}
    calm = parked_blade("steady", 0.01)
    still, _ = edge_mode(calm, 0.0)
    table: dict[str, list[float]] = {name: [] for name in ("formula", *words)}
    for angle in ANGLES:
        for word in words:
            value, shape = edge_mode(plants[word], float(angle))
            table[word].append(damping(value))
            if word == "steady":
                table["formula"].append(quasi_steady_damping(float(angle), shape, still))
    timed = {word: {angle: decrement(plants[word], angle) for angle in angles} for word, angles in TIMED.items()}
    in_time = ("steady, in time", "beddoes_leishman, in time")
    heads = ("angle of attack [deg]", "formula", *(f"{w}, linear" for w in words), *in_time)
    rows = []
    for k, angle in enumerate(ANGLES):
        own = [f"{timed[w][angle]:.2f}" if angle in timed[w] else "" for w in ("steady", "beddoes_leishman")]
        rows.append((f"{angle:g}", *(f"{table[n][k]:.2f}" for n in ("formula", *words)), *own))
    text = markdown((heads, rows))
    print(f"without air {damping(still):.3f} %\n{text}")
    page = DOCS / "unsteady_airfoils.md"
    page.write_text(fill(page.read_text(encoding="utf-8"), "stall_vibration", text), encoding="utf-8")
    figure, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
    axes.axhline(0, color="0.7", linewidth=0.8)
    axes.plot(ANGLES, table["formula"], "k--", label="steady, formula")
    for word, colour in zip(words, ("k", "C2", "C1", "C0"), strict=True):
        axes.plot(ANGLES, table[word], color=colour, label=f"{word}, linear model")
    for word, colour in (("steady", "k"), ("beddoes_leishman", "C0")):
        axes.plot(list(timed[word]), list(timed[word].values()), "o", color=colour, label=f"{word}, in time")
    axes.set(xlabel="angle of attack of a section without twist [deg]", ylabel="damping of the first edgewise mode [%]",
             xlim=(ANGLES[0], ANGLES[-1]), ylim=(-5, 3))  # fmt: skip
    axes.legend(fontsize=8, ncols=2)
    figure.savefig(DOCS / "figures" / "stall_vibration.png", dpi=110)


if __name__ == "__main__":
    main()
