"""Tables and pictures of docs/sizing.md: `python benchmarks/sizing.py`."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from pages import fill

import fowtlib as fw
from fowtlib.components.hydro.panel import solve_hull
from fowtlib.components.hydro.panel_mesh import Column, members_mesh
from fowtlib.components.platform import layers
from fowtlib.design.construction import BuildStage, ballast_for, build_stages, hull_sizes
from fowtlib.solving.results.drawing import COLORS, drawing_style, save_figure

DOCS = Path(__file__).parents[1] / "docs"
PAGE = DOCS / "sizing.md"
G = 9.81
NEEDED = 1.0  # m of metacentric height while it is built


def heave_table() -> str:
    """Heave at model scale: closed form with three columns, panels of three sizes, and what was measured."""
    heads = "| added mass from | A33 [kg], mass 180.5 kg, draft 1.320 m | T3 [s] | A33 [kg], 186 kg, 1.383 m | T3 [s] |"
    rows = [heads, "| --- | ---: | ---: | ---: | ---: |"]
    stiffness = 1000 * G * math.pi / 4 * 0.333**2
    states = ((1.320, 180.5), (1.383, 186.0))

    def row(name, added):
        cells = [f"{a:.1f} | {2 * math.pi * math.sqrt((m + a) / stiffness):.3f}"
                 for a, (_, m) in zip(added, states, strict=True)]  # fmt: skip
        rows.append(f"| {name} | " + " | ".join(cells) + " |")

    for name, column in (("closed form, column at the water level", 0.333), ("closed form, free disc", 0.0),
                         ("closed form, column as wide as the base", 0.667)):  # fmt: skip
        row(name, [layers.plate_added_mass(0.889, column, 1000.0)] * 2)
    for size in (0.08, 0.055, 0.04):
        added, panels = [], 0
        for draft, _ in states:
            hull = Column(((-draft, 0.889), (0.044 - draft, 0.889), (0.044 - draft, 0.667), (0.155 - draft, 0.667),
                           (0.266 - draft, 0.333), (0.5, 0.333)))  # fmt: skip
            mesh = members_mesh([hull], [], size)
            panels = max(panels, len(mesh.panels))
            found = solve_hull(mesh, omega=[1.474, 2.0], headings=[0.0], water_depth=2.0, rho=1000.0, g=G)
            added.append(float(found.A[0, 2, 2]))
        row(f"Capytaine, {panels} panels", added)
    rows.append("| measured, six decays | | 4.254 to 4.268 | | |")
    return "\n".join(rows)


def stages(hull) -> list[BuildStage]:
    """The sequence of the thesis: base, rings, tower lowered in the shaft, ballast, nacelle and blades, raising."""
    tower, whole, ballast = 550e3, 970e3, 5325e3
    found = [BuildStage("plate, base and cone", 12.0)]
    for top in (22, 32, 47, 62, 82):
        stage = BuildStage(f"rings to {top} m", float(top))
        found.append(BuildStage(stage.name, stage.top, ballast_for(hull, stage, NEEDED)))
    lowered = BuildStage("flotation cylinder and tower, lowered", 82.0, 0.0, 0.0, tower, 52.0)
    found.append(BuildStage(lowered.name, 82.0, ballast_for(hull, lowered, NEEDED), 0.0, tower, 52.0))
    found.append(BuildStage("all solid ballast", 82.0, ballast, 0.0, tower, 52.0))
    found.append(BuildStage("nacelle and blades, lowered", 82.0, ballast, 0.0, whole, 77.0))
    found.append(BuildStage("raised", 82.0, ballast, 0.0, whole, 127.0))
    return found


def stage_table() -> str:
    """Drafts while it is built; of the rings with the least ballast for NEEDED."""
    hull = hull_sizes(fw.load("raisable_spar_sizes"))
    heads = ("stage", "concrete [m^3]", "ballast [t]", "mass [t]", "draft [m]", "water depth [m]", "KB [m]", "BM [m]",
             "KG [m]", "GM [m]", "GM without ballast [m]")  # fmt: skip
    rows = ["| " + " | ".join(heads) + " |", "| --- |" + " ---: |" * (len(heads) - 1)]
    for stage in stages(hull):
        (row,) = build_stages(hull, [stage])
        bare = BuildStage(stage.name, stage.top, 0.0, 0.0, stage.set_mass, stage.set_centre)
        (without,) = build_stages(hull, [bare])
        cells = [f"{row.concrete_volume:.0f}", f"{stage.solid_ballast / 1e3:.0f}", f"{row.mass / 1e3:.0f}"]
        values = (row.draft, row.water_depth, row.centre_of_buoyancy, row.metacentric_radius, row.centre_of_mass,
                  row.metacentric_height, without.metacentric_height)  # fmt: skip
        cells += [f"{value:.2f}" for value in values]
        rows.append(f"| {row.name} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def pictures() -> None:
    """Draft, metacentric height, mass and heel over the column's diameter; draft over the wall."""
    from matplotlib.figure import Figure

    plant = fw.load("raisable_spar_sizes").compile()
    names = {"draft": "draft [m]", "metacentric_height": "GM [m]", "mass": "mass [t]", "heel": "heel at 1 MN [deg]"}
    diameters, walls = np.linspace(14.0, 18.0, 81), np.linspace(0.25, 0.45, 21)
    as_built = fw.parameter_map(plant, {"column_diameter": diameters}, list(names))
    kept = fw.parameter_map(plant, {"column_diameter": diameters}, list(names), free=["solid_ballast"],
                            targets={"draft": 62.0})  # fmt: skip
    with drawing_style():
        figure = Figure(figsize=(8.0, 5.4), layout="constrained")
        for axis, (name, title) in zip(np.ravel(figure.subplots(2, 2)), names.items(), strict=True):
            for table, label, color in ((as_built, "ballast 5325 t", COLORS[0]), (kept, "ballast for 62 m", COLORS[1])):
                upright = table["metacentric_height"] > 0.3  # m; below, a heel is not small
                values = np.where(upright, table[name], np.nan) if name == "heel" else table[name]
                axis.plot(diameters, values, color=color, label=label)
            axis.set_title(title, loc="left")
            axis.set_xlabel("diameter of the column [m]")
            if name == "metacentric_height":
                axis.axhline(1.0, color="#888888", linestyle="--", linewidth=0.9)
                axis.annotate("1 m", (18.0, 1.0), ha="right", va="bottom", fontsize=8)
            if name == "heel":
                axis.axhline(4.5, color="#888888", linestyle="--", linewidth=0.9)
                axis.annotate("4.5 deg", (14.0, 4.5), ha="left", va="bottom", fontsize=8)
                axis.set_ylim(0, 25)
            if name == "draft":
                axis.legend()
        save_figure(figure, DOCS / "figures" / "sizing_diameter.png")
        figure = Figure(figsize=(5.0, 3.2), layout="constrained")
        axis = figure.subplots()
        over = fw.parameter_map(plant, {"wall": walls}, ["draft"])
        axis.plot(1e3 * walls, over["draft"], color=COLORS[0])
        axis.axhline(82.0, color="#888888", linestyle="--", linewidth=0.9)
        axis.annotate("top of the column", (350.0, 82.0), ha="left", va="top", fontsize=8)
        axis.set_xlabel("thickness of the walls [mm]")
        axis.set_title("draft [m], ballast 5325 t", loc="left")
        save_figure(figure, DOCS / "figures" / "sizing_wall.png")


if __name__ == "__main__":
    for name, text in (("stages", stage_table()), ("heave", heave_table())):
        print(text)
        if PAGE.exists():
            PAGE.write_text(fill(PAGE.read_text(), name, text))
    pictures()
