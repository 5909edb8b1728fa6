"""A frame of columns and braces that bends by strips: OC4's semi-submersible, beside its whole frame in water."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

import fowtlib as fw

# A. Robertson et al., NREL/TP-5000-60601 (2014), table 4-1: C_a of all members; walls of table 3-2 are in the model
C_A, RHO, STANDING = 0.63, 1025.0, 600e3  # C_a, kg/m^3, kg: tower and turbine of 600 t
COLUMNS = [f"{name}_column_{k}" for k in (1, 2, 3) for name in ("base", "upper")]
BRACES = [f"{name}_{k}" for k in (1, 2, 3) for name in ("lower_delta_pontoon", "lower_y_pontoon", "brace")]
MODEL = """
fowtlib: 1
title: the OC4 semi-submersible by strips
world: {class: World, water_depth: 200 m, water_density: 1025 kg/m^3}
parts:
  platform: {use: platforms/oc4_semi, parts: {hull: {database: null, SETTINGS parts: {MEMBERS}}}}
  standing: {class: PointMass, mass: 600 t}
connect:
  - [world.frame, platform.world]
  - [platform.tower_base, standing.frame_a]
"""
ELASTIC = "class: ElasticFloater, shapes: 6, longest: 8 m,"


@pytest.fixture(scope="module")
def plants(tmp_path_factory):
    """The platform by strips: the rigid hull, and the one that bends."""
    wet = ["main_column", *COLUMNS, *BRACES]
    found, members = {}, ", ".join(f"{name}: {{added_mass_coefficient: {C_A}}}" for name in wet)
    for name, settings in (("rigid", ""), ("elastic", ELASTIC)):
        path = tmp_path_factory.mktemp(name) / "semi.yaml"
        path.write_text(MODEL.replace("SETTINGS", settings).replace("MEMBERS", members))
        found[name] = fw.load(path).compile()
    return found


def frequencies(plant, **parameters):
    """Of all modes at rest [Hz], rising."""
    rest = plant.equilibrium(parameters=parameters)
    return np.sort([mode.frequency_hz for mode in plant.linearize(rest, outputs=[]).modes()])


def whole_frame(structure):
    """Bending frequencies [Hz] of all nodes of the frame with the water as masses across each beam, dry stiffness."""
    frame = structure.frame
    mass = frame.mass.toarray()

    def moved(place, ends, share):
        row = np.zeros((3, 6 * len(frame.nodes)))
        for node, part in zip(ends, (1 - share, share), strict=True):
            turned = np.cross(np.eye(3), place - frame.nodes[node]).T  # by a small turn about each axis
            row[:, 6 * node : 6 * node + 6] += part * np.hstack([np.eye(3), turned])
        return row

    for piece, beam in zip(structure.pieces, structure._beams, strict=True):
        member = structure.hull.members[piece.member]
        a, b, ends = member.at(piece.low), member.at(piece.high), (beam.start, beam.end)
        along, diameter = member.axes[:, 2], float(member.size_at((piece.low + piece.high) / 2)[0])
        for share in (np.arange(20) + 0.5) / 20:
            place = a + share * (b - a)
            if place[2] < 0:
                row, across = moved(place, ends, share), np.eye(3) - np.outer(along, along)
                mass += C_A * RHO * np.pi / 4 * diameter**2 * (piece.high - piece.low) / 20 * row.T @ across @ row
    top = 6 * structure.node_at((0, 0, 10))
    assert frame.nodes[top // 6][2] == pytest.approx(10.0)
    mass[range(top, top + 3), range(top, top + 3)] += STANDING
    value = eigh(frame.stiffness.toarray(), mass, eigvals_only=True, subset_by_index=(6, 9))
    return np.sqrt(value) / (2 * np.pi)


def stiffer(plant, times):
    """Frequencies with moduli so many times those of steel."""
    moduli = {"young_modulus": 210e9, "shear_modulus": 80.8e9}
    return frequencies(plant, **{f"platform.hull.{name}": times * value for name, value in moduli.items()})


def test_a_stiff_frame_moves_as_the_rigid_hull(plants):
    """Six rigid motions with 1e5 times the modulus of steel: 0.1 %."""
    rigid = frequencies(plants["rigid"])
    assert len(rigid) == 6 and rigid[0] > 0.005
    np.testing.assert_allclose(stiffer(plants["elastic"], 1e5)[:6], rigid, rtol=1e-3)


def test_bending_is_that_of_the_whole_frame(plants):
    """Six shapes by strips, beside all nodes of the frame with closed-form water: 0.5 %.

    Of steel a hundred times as stiff, over ten, so that weight and still water, which are not in the other, count for
    little.
    """
    bent = stiffer(plants["elastic"], 100)[6:10] / 10
    whole = whole_frame(plants["elastic"].root.find("platform.hull").member_frame())
    np.testing.assert_allclose(bent, whole, rtol=0.005)
