"""How fast beams converge with the number of hinges; prints the tables, `--write` puts them into docs/beams.md.

Frequencies of the straight, resting chain from its mass matrix in the hinge angles; the tests compare the same chains,
as parts of a model, with finite elements.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from pages import fill
from scipy.linalg import eigh

import fowtlib as fw
from fowtlib.components.mechanics import BeamProperties, read_beam
from fowtlib.components.mechanics.beam_division import QUADRATURES, divide
from fowtlib.modelfile import data_path

PAGE = Path(__file__).parents[1] / "docs" / "beams.md"
UNITS = (1, 2, 3, 4, 6, 8, 10)


def frequencies(beam, hinges, quadrature, mass=0.0, inertia=0.0, offset=0.0):
    """Circular frequencies of the chain, with a body at its tip: (mass, inertia, distance of its centre)."""
    chain, s = divide(beam, hinges, quadrature), np.linspace(0, beam.length, 20001)
    weight = np.full(len(s), s[1]) * beam.at("mass_per_length", s)
    weight[[0, -1]] /= 2
    arms = np.maximum(s - chain.s[:, None], 0)
    tip = beam.length + offset - chain.s
    M = (arms * weight) @ arms.T + mass * np.outer(tip, tip) + inertia
    axes = np.concatenate([chain.axes[:, :2, 0], chain.axes[:, :2, 1]])
    M = np.tile(M, (2, 2)) * (axes @ axes.T)
    K = np.concatenate([chain.stiffness_x, chain.stiffness_y])
    return np.sqrt(eigh(np.diag(K), M, eigvals_only=True))


def table(title, beam, picked, names, reference_quadrature, **head):
    """Errors of the frequencies numbered `picked`, in percent, against 60 hinges at Gauss points."""
    exact = frequencies(beam, 60, reference_quadrature, **head)[picked]
    unit = 2 * np.pi if title.endswith("Hz") else 1.0
    values = ", ".join(f"{name} {w / unit:.4g}" for name, w in zip(names, exact, strict=True))
    rule = "| --- " * (2 + len(names)) + "|"
    lines = [f"{title}: {values}.", "", f"| quadrature | hinges | {' | '.join(names)} |", rule]
    for quadrature in QUADRATURES:
        if quadrature == "loaded_tip" and "blade" in title:
            continue
        for n in UNITS:
            found = frequencies(beam, n, quadrature, **head)
            pairs = [(found[k] if k < len(found) else None, w) for k, w in zip(picked, exact, strict=True)]
            cells = ["" if f is None else f"{100 * (f / w - 1):+.2f} %" for f, w in pairs]
            lines.append(f"| {quadrature} | {n} | {' | '.join(cells)} |")
    return "\n".join(lines)


SUPPORT = ("yaw", "side-side 1", "fore-aft 1", "side-side 2", "arms vertical", "fore-aft 2")


def support_frequencies(tower, arm, top=1):
    """First frequencies [Hz] of the two-rotor tower with 350 t at its tips, at rest under the weights."""
    hinges = {"tower_hinges": tower, "arm_hinges": arm, "top_hinges": top}
    plant = fw.load("two_rotor_support", set={f"support.{name}": n for name, n in hinges.items()}).compile()
    modes = plant.linearize(plant.equilibrium()).modes()
    return np.array([mode.frequency_hz for mode in modes if mode.damping_ratio < 1][: len(SUPPORT)])


def support_table(finest=8):
    """Errors of the two-rotor tower, in percent, against `finest` hinges everywhere."""
    exact = support_frequencies(finest, finest, finest)
    values = ", ".join(f"{name} {f:.4g}" for name, f in zip(SUPPORT, exact, strict=True))
    lines = [f"Hz, with {finest} hinges in every member: {values}.", "",
             f"| tower hinges | arm hinges | {' | '.join(SUPPORT)} |", "| --- " * (2 + len(SUPPORT)) + "|"]  # fmt: skip
    for tower, arm in ((1, 1), (1, 2), (2, 2), (2, 3), (3, 3), (3, 4), (4, 6)):
        cells = [f"{100 * error:+.2f} %" for error in support_frequencies(tower, arm) / exact - 1]
        lines.append(f"| {tower} | {arm} | {' | '.join(cells)} |")
        print(lines[-1], flush=True)
    return "\n".join(lines)


def main():
    """Print the tables, and write them."""
    uniform = BeamProperties.uniform(1.0, 1.0, 1.0)
    tower = read_beam(str(data_path("oc3_hywind/tower.csv")))
    blade = read_beam(str(data_path("nrel5mw/blade_structure.csv")))
    bending = ("first", "second", "third")
    text = "\n\n".join([
        table("Uniform clamped beam, omega / sqrt(EI / (mu L^4))", uniform, [0, 2, 4], bending, "free_tip"),
        table("The same with a mass of 1000 times its own at the tip", uniform, [0], bending[:1],
              "loaded_tip", mass=1e3),
        table("OC3 tower with rotor and nacelle, clamped, Hz", tower, [0, 2, 4], bending, "loaded_tip",
              mass=350e3, inertia=2.35e7, offset=1.967),
        table("NREL 5 MW blade, clamped, at rest, Hz", blade, [0, 1, 2, 3, 4],
              ("flap 1", "edge 1", "flap 2", "edge 2", "flap 3"), "free_tip"),
    ])  # fmt: skip
    support = support_table()
    print(text, support, sep="\n\n")
    if "--write" in sys.argv:
        PAGE.write_text(fill(fill(PAGE.read_text(), "convergence", text), "two-rotor tower", support))


if __name__ == "__main__":
    main()
