"""A floater that bends: its coordinates against matrices, the rigid limit, frames on it, and mistakes."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.mechanics import FreeMotion, World, WorldForce
from fowtlib.components.platform import Ballast, ElasticFloater, Floater, RectangularMember, modal_database
from fowtlib.components.platform.elastic_floater import shapes_of
from fowtlib.components.platform.frame_loads import stiffness_by_loads, weight_at_rest
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.language import Component, RealOutput, Vector, eq, param, port
from fowtlib.language.errors import ModelError

pytest.importorskip("capytaine")
G = 9.80665


class Source(Component):
    """Three constant numbers."""

    value: Vector = param(doc="the numbers")
    y: RealOutput = port(shape=(3,), doc="output")

    def equations(self):
        return [eq(self.y, self.value)]


def barge(cls=Floater, level=None, nodes=((-35.0, 0, 0), (0, 0, 0), (35.0, 0, 0)), **settings):
    drag = settings.pop("drag", {})
    floater = cls(node_points=nodes, **settings)
    floater.log = RectangularMember(start=(-40, 0, -1), end=(40, 0, -1), widths=[10, 10], heights=[8, 8],
                                    wall_thickness=0.04, **drag)  # fmt: skip
    floater.log.ballast = Ballast(level=-1.0)
    floater.log.ballast.level = floater.ballast_level("log.ballast") if level is None else level
    return floater


def afloat(floater, force=None):
    model = fw.Assembly("barge")
    model.world, model.motion, model.hull = World(water_depth=200.0), FreeMotion(), floater
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.hull.frame)
    if force is not None:
        model.load, model.given = WorldForce(), Source(value=force)
        model.connect(model.given.y, model.load.force)
        model.connect(model.hull.nodes[2], model.load.frame)
    return fw.load(model).compile()


@pytest.fixture(scope="module")
def database():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # coarse panels
        return modal_database(barge(), 3, omega=[0.5, 1.0], headings=[0.0], panel=4.0, water_depth=200.0)


QUIET = {"radiation_order": 0, "excitation": False}


def by_loads(database, structure):
    """Stiffness by weight and water at rest."""
    loads = database.at_rest + weight_at_rest(structure.frame, G)
    return stiffness_by_loads(structure.frame, loads, G)


def matrices(database, structure):
    """Mass and stiffness (9, 9) about the frame, from the parts that the floater is made of."""
    hull = barge().hull()
    x, y, z = hull.mass.centre
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    size = 6 + database.count
    mass, stiffness = database.A_inf.copy(), np.zeros((size, size))
    mass[:3, :3] += hull.mass.mass * np.eye(3)
    mass[:3, 3:6] -= hull.mass.mass * skew
    mass[3:6, :3] += hull.mass.mass * skew
    mass[3:6, 3:6] += hull.mass.about((0, 0, 0))
    stiffness[:6, :6] = hull.buoyancy.stiffness()
    stiffness[3, 3] -= hull.mass.mass * G * z
    stiffness[4, 4] -= hull.mass.mass * G * z
    shapes = database.shapes.reshape(database.count, -1)
    mass[6:, 6:] += shapes @ (structure.frame.mass @ shapes.T)
    stiffness[6:, 6:] += shapes @ ((structure.frame.stiffness + by_loads(database, structure)) @ shapes.T)
    stiffness[6:, 6:] += database.among
    stiffness[6:, :6] += database.with_rigid
    stiffness[:6, 6:] += database.with_rigid.T
    return mass, stiffness


def frequencies(plant, state):
    modes = plant.linearize(state, outputs=[]).modes()
    return np.array([mode.frequency_hz for mode in modes if mode.frequency_hz > 1e-3])


def test_the_coordinates_are_those_of_the_matrices(database):
    elastic = barge(ElasticFloater, database=database, **QUIET)
    plant = afloat(elastic)
    rest = plant.equilibrium()
    found = plant.linearize(rest, outputs=[]).modes()
    assert max(abs(mode.eigenvalue.real) for mode in found) < 1e-8  # nothing gains or loses energy
    mass, stiffness = matrices(database, elastic.member_frame())
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
    expected = np.sqrt(squares[squares > 1e-6]) / (2 * np.pi)
    np.testing.assert_allclose(sorted(frequencies(plant, rest)), expected, rtol=1e-5)
    assert len(expected) == 6


def test_a_stiff_hull_is_a_rigid_one(database):
    stiff = afloat(barge(ElasticFloater, database=database, young_modulus=210e13, shear_modulus=80e13, **QUIET))
    rigid = afloat(barge(Floater, database=database.rigid, **QUIET))
    found, expected = (frequencies(plant, plant.initial_state()) for plant in (stiff, rigid))
    np.testing.assert_allclose(found[:3], expected[:3], rtol=1e-3)
    assert found[3] > 100 * found[2]


def test_a_force_bends_it_as_the_matrices_say(database):
    force = 5e5
    elastic = barge(ElasticFloater, database=database, **QUIET)
    plant = afloat(elastic, (0, 0, -force))
    state = plant.equilibrium()
    structure = elastic.member_frame()
    _, stiffness = matrices(database, structure)
    on = structure.field([[35.0, 0, 0]], database.shapes).displacement[:, 0, 2]
    load = -force * np.array([1, -35.0, *on])
    kept = [2, 4, 6, 7, 8]
    moved = np.linalg.solve(stiffness[np.ix_(kept, kept)], load)
    rest = afloat(barge(ElasticFloater, database=database, **QUIET)).equilibrium()
    for k, x in ((0, -35.0), (1, 0.0), (2, 35.0)):
        there = structure.field([[x, 0, 0]], database.shapes).displacement[:, 0, 2]
        expected = moved[0] - moved[1] * x + moved[2:] @ there
        found = state[f"hull.nodes[{k}].r"][2] - rest[f"hull.nodes[{k}].r"][2]
        assert found == pytest.approx(expected, rel=5e-3, abs=1e-6)
    bent = moved[2:] @ on
    assert abs(bent) > 1e-4
    assert state["hull.structure.q"] - rest["hull.structure.q"] == pytest.approx(moved[2:], rel=0.01, abs=1e-7)


def test_section_loads_are_those_of_what_is_beyond(database):
    """Water on springs, rho g B w(x), and the force: shear and bending moment of the part beyond the section."""
    cuts, force = [12.5, -17.5], 5e5
    settings = {"section_points": [[x, 0, -1.0] for x in cuts], **QUIET}
    plant = afloat(barge(ElasticFloater, database=database, **settings), (0, 0, -force))
    loaded, rest = plant.equilibrium(), plant.equilibrium({"given.value": (0, 0, 0)})
    structure = barge(ElasticFloater, database=database).member_frame()
    x = np.linspace(-40, 40, 1601)
    there = structure.field(np.column_stack([x[::16], 0 * x[::16], 0 * x[::16] - 1]), database.shapes).displacement
    shapes = np.array([np.interp(x, x[::16], one) for one in there[:, :, 2]])

    def heights(state):
        z, R = state["hull.frame.r"][2], state["hull.frame.R"]
        return z + x * R[2, 0] + state["hull.structure.q"] @ shapes

    lift = -1025.0 * G * 10 * (heights(loaded) - heights(rest))
    for k, cut in enumerate(cuts):
        beyond, middle = x >= cut, x >= cut - 1e-9
        shear = np.trapezoid(lift[beyond], x[beyond]) - force
        moment = np.trapezoid((lift * (x - cut))[middle], x[middle]) - force * (35.0 - cut)
        axes = structure.frame.axes(structure.carrier(np.array([cut, 0, -1.0]))[0])
        found = [axes @ (loaded[f"hull.sections.{name}"][k] - rest[f"hull.sections.{name}"][k])
                 for name in ("force", "moment")]  # fmt: skip
        assert found[0][2] == pytest.approx(shear, abs=0.04 * force)
        assert found[1][1] == pytest.approx(-moment, rel=0.05)


def test_members_drag_where_they_bend(database):
    """1/2 rho C_d B int |phi v| phi v phi dx on the shape, by the speed of bending alone; and none on a rigid one."""
    drag = {"drag_coefficient": (0.0, 1.2), "sections": 24}
    plant = afloat(barge(ElasticFloater, database=database.first(1), drag=drag, **QUIET))
    state = plant.initial_state(start={"hull.structure.v[0]": 0.7})
    structure = barge(ElasticFloater, database=database).member_frame()
    x = np.linspace(-40, 40, 161)
    shape = structure.field(np.column_stack([x, 0 * x, 0 * x - 1]), database.shapes[:1]).displacement[0, :, 2]
    expected = -0.5 * 1025.0 * 1.2 * 10 * 0.7**2 * np.trapezoid(np.abs(shape) ** 3, x)
    assert float(np.squeeze(state["hull.log.on_shapes"])) == pytest.approx(expected, rel=0.01)
    force = -0.5 * 1025.0 * 1.2 * 10 * 0.7**2 * np.trapezoid(np.abs(shape) * shape, x)
    assert state["hull.log.force"][2] == pytest.approx(force, rel=0.02)


def test_mistakes_are_named(database):
    def refused(said, **settings):
        with pytest.raises(ModelError, match=said):
            afloat(barge(ElasticFloater, **{"database": database, **QUIET, **settings})).initial_state()

    refused("has 11 nodes that are not the 17 of its database", longest=8.0)
    refused("of its database moves the mass of the hull in surge", level=-4.9)
    refused(r"^hull.node_points\[1\]: the point \(0, 0, 30\) m meets no node of the frame: it is 6.2 radii from the "
            "axis of hull.log, the nearest member. Put it on a member", nodes=[[35.0, 0, 0], [0, 0, 30.0]])  # fmt: skip
    refused(r"hull.section_points: the point \(0, 0, 2\) m lies on no beam", section_points=[[0, 0, 2.0]])
    refused("node_forces has 1 rows, and there are 3 node_points", node_forces=[[0, 0, 1e5]])
    other = replace(database.first(1), shapes=database.shapes[1:2])
    refused("make up 0% of the lowest shape of its members", database=other)


def test_a_mesh_that_does_not_match_the_frame_is_refused():
    """Of another draft, and beside the hull."""
    hull = barge().hull()

    def refused(said, panels):
        mesh = HullMesh(panels, name="barge.gdf")
        with pytest.raises(ModelError, match=said):
            modal_database(barge(), 1, omega=[0.5, 1.0], headings=[0.0], panel=4.0, water_depth=200.0, mesh=mesh)

    refused(r"^the mesh barge.gdf holds 2\d\d\d m\^3, and the members of the frame 4000 m\^3: the mesh does not match "
            "the frame. Are draft", hull.panels(4.0) * [1, 1, 0.5])  # fmt: skip
    refused(r"^the mesh barge.gdf does not match the frame: its panel at \(.*\) m is [\d.]+ radii from the axis of log",
            hull.panels(4.0) + [0, 30.0, 0])  # fmt: skip


def test_shapes_are_of_one_metre():
    found = shapes_of(MemberFrame(barge().hull(), 5.0), 4)
    assert np.linalg.norm(found.shapes[:, :, :3], axis=2).max(axis=1) == pytest.approx(1.0)
    assert (np.diff(found.frequencies) > 0).all()
