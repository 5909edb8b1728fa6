"""The triangle that bends: with masses for its turbines, against the rigid one, its database and its frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_radiation import bordered_radiation
from fowtlib.components.hydro.radiation_identification import kept_radiation
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.shape_numbers import shapes_of

FILE = Path(__file__).parents[2] / "models" / "data" / "wind_tracing" / "shapes.nc"
BARE = """
fowtlib: 1
title: the wind-tracing triangle with masses for turbines
world: {class: World, water_depth: 200 m, water_density: 1025 kg/m^3}
sea: {class: Sea, spectrum: still}
parts:
  platform: {use: platforms/PLATFORM, parts: {hull: {radiation_order: 2}}}
  on_front: {class: PointMass, mass: 599.718 t}
  on_left: {class: PointMass, mass: 599.718 t}
  on_right: {class: PointMass, mass: 599.718 t}
connect:
  - [world.frame, platform.world]
  - [platform.front, on_front.frame_a]
  - [platform.left, on_left.frame_a]
  - [platform.right, on_right.frame_a]
outputs:
  surge: platform.motion.surge
  sway: platform.motion.sway
  heave: platform.motion.heave
  roll: platform.motion.roll
  pitch: platform.motion.pitch
  yaw: platform.motion.yaw
"""
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@pytest.fixture(scope="module")
def plants(tmp_path_factory):
    """The platform with the rigid hull, and with the one that bends."""
    found = {}
    for name in ("wind_tracing", "wind_tracing_elastic"):
        path = tmp_path_factory.mktemp(name) / "bare.yaml"
        path.write_text(BARE.replace("PLATFORM", name))
        model = fw.load(path)
        if name == "wind_tracing":  # its own database is of another mesh, which differs by 0.1 % in the rigid motions
            model.root.find("platform.hull").database = ModalDatabase.read(FILE).rigid
        found[name] = model.compile()
    return found


def response(plant, **parameters):
    frequency = 1 / np.array([25.0, 18.0, 14.0, 11.0, 9.0, 7.0])
    state = fw.mean_state(plant, parameters=parameters)
    found = fw.linear_rao(plant, frequency, outputs=MOTIONS, heading=np.radians(40), state=state)
    return np.asarray(found.response)


def test_a_stiff_hull_moves_as_the_rigid_one(plants):
    """Response to waves from 40 deg aside, by the database: 0.1 % of the largest of each motion."""
    rigid = response(plants["wind_tracing"])
    stiff = response(plants["wind_tracing_elastic"], **{"platform.young_modulus": 35e14})
    size = np.abs(rigid).max(axis=0)
    np.testing.assert_allclose(stiff / size, rigid / size, rtol=0, atol=1e-3)
    soft = response(plants["wind_tracing_elastic"])
    assert np.abs(soft - rigid)[4, 4] > 0.2 * np.abs(rigid[4, 4])  # pitch at 9 s, near the bending in water


def test_shapes_are_the_lowest_of_the_dry_frame_and_of_no_momentum(plants):
    hull = plants["wind_tracing_elastic"].root.find("platform.hull")
    assert isinstance(hull.member_frame(), MemberFrame)
    own = shapes_of(hull.member_frame(), 12)
    shapes = hull.database.shapes.reshape(12, -1)
    kept = own.shapes.reshape(12, -1)
    shared = shapes @ (hull.member_frame().frame.mass @ kept.T)
    size = np.sqrt(np.diag(shapes @ (hull.member_frame().frame.mass @ shapes.T)))
    np.testing.assert_allclose(np.abs(shared) / np.outer(size, size), np.eye(12), atol=1e-2)
    assert own.frequencies[:2] == pytest.approx([1.193, 1.205], abs=2e-3)


def test_the_memory_of_rigid_motions_is_that_of_the_rigid_hull():
    """Four states a motion, the six shapes that go with heave: the rigid block of the model is the rigid hull's."""
    data = ModalDatabase.read(FILE)
    rigid = data.rigid
    alone = kept_radiation(rigid.omega, rigid.B, rigid.A, rigid.A_inf, order=4, passive=True)
    kept = [*range(6), 6, 8, 9, 11, 14, 16]
    pick = (slice(None), *np.ix_(kept, kept))
    bent = bordered_radiation(
        alone, data.omega, data.B[pick], data.A[pick], data.A_inf[np.ix_(kept, kept)], order=4, passive=True
    )
    omega = np.linspace(0.05, 3.0, 60)
    one, other = bent.transfer(omega)[:, :6, :6], alone.transfer(omega)
    np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(other).max())
    assert bent.passive and bent.stable
    assert next(entry.r2 for entry in bent.entries if (entry.i, entry.j) == (2, 6)) > 0.95  # heave with the first shape
