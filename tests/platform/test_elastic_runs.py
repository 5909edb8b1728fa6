"""A floater that bends in the place of a rigid one: in model files, in waves with both engines, and its radiation."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cli import main
from fowtlib.components.environment.sea import RegularWaves
from fowtlib.components.hydro.linear_loads import RadiationTransfer
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_radiation import kept_modal_radiation
from fowtlib.components.hydro.radiation_identification import kept_radiation
from fowtlib.components.mechanics import FreeMotion, World
from fowtlib.components.platform import ElasticFloater, Floater
from fowtlib.language import StateSpace, shapes
from fowtlib.solving.modes import natural_modes
from fowtlib.view.modes import played
from fowtlib.view.recording import Cast
from tests.platform.test_elastic_floater import barge, matrices

pytest.importorskip("capytaine")

RIGID = """
fowtlib: 1
title: a barge of 80 m
parts:
  world: {class: World, water_depth: 200 m}
  motion: {class: FreeMotion}
  hull:
    class: Floater
    node_points: [[-35 m, 0, 0], [35 m, 0, 0]]
    parts:
      log:
        class: RectangularMember
        start: [-40 m, 0, -1 m]
        end: [40 m, 0, -1 m]
        widths: 10 m
        heights: 8 m
        wall_thickness: 40 mm
        parts:
          ballast: {class: Ballast, level: -4.1 m}
connect:
  - [world.frame, motion.frame_a]
  - [motion.frame_b, hull.frame]
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The model file, what the command says, and the file of the database."""
    folder = tmp_path_factory.mktemp("barge")
    level = next(barge().parts["log"].parts["ballast"].parameter_value("level") for _ in "x")
    (folder / "rigid.yaml").write_text(RIGID.replace("-4.1 m", f"{level:.6f} m"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # coarse panels
        status = main(["hydro", str(folder / "rigid.yaml"), "--shapes", "3", "--size", "4", "--omega",
                       "0.3:2.1:0.3", "--headings", "0", "-o", str(folder / "barge.nc")])  # fmt: skip
    assert status == 0
    return folder


def test_the_command_makes_the_database_of_a_model_file(made, capsys):
    database = ModalDatabase.read(made / "barge.nc")
    assert database.count == 3 and database.water_depth == 200.0
    text = (made / "rigid.yaml").read_text()
    (made / "elastic.yaml").write_text(
        text.replace("class: Floater", "class: ElasticFloater\n    database: barge.nc\n    excitation: false")
    )
    plant = fw.load(str(made / "elastic.yaml")).compile()
    names = [mode.name for mode in natural_modes(plant, plant.equilibrium())]
    assert [name for name in names if "bending" in name] == [f"{k} hull bending" for k in ("1st", "2nd", "3rd")]


@pytest.mark.parametrize(("words", "said"), [
    (["--size", "5,4"], "--shapes makes one database; give one --size"),
    (["--mesh-only"], "--mesh-only does not go with --shapes"),
    (["-o", "barge.1"], "shapes are kept in one .nc file"),
    (["--part", "hul"], "--part: 'hul' is no floater of members; did you mean 'hull'?"),
])  # fmt: skip
def test_mistakes_of_the_command(made, capsys, words, said):
    assert main(["hydro", str(made / "rigid.yaml"), "--shapes", "2", *words]) != 0
    assert said in capsys.readouterr().err


def test_other_models_have_no_shapes(capsys):
    assert main(["hydro", "oc3_spar_rigid", "--shapes", "2"]) != 0
    assert "has no floater of members (Floater), which --shapes needs" in capsys.readouterr().err
    assert main(["hydro", "oc3_spar_rigid", "--longest", "2"]) != 0
    assert "--longest goes with --shapes" in capsys.readouterr().err


def in_waves(floater):
    model = fw.Assembly("barge")
    model.world, model.motion, model.hull = World(water_depth=200.0), FreeMotion(), floater
    model.sea = RegularWaves(wave_height=1.0, wave_period=8.0)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.hull.frame)
    return fw.load(model).compile()


@pytest.mark.parametrize(("solver", "order"), [("idas", 0), ("fixed", 0), ("fixed", 4)])
def test_a_stiff_hull_moves_as_a_rigid_one_in_waves(made, solver, order):
    """Heave and pitch of the same hull in the same waves, to 0.1 % of the motion; bending upwards makes waves too."""
    database = ModalDatabase.read(made / "barge.nc").first(2)
    stiff = barge(ElasticFloater, database=database, young_modulus=210e12, shear_modulus=80.8e12, damping_time=1e-3,
                  radiation_order=order)  # fmt: skip
    settings = {"step": 0.02} if solver == "fixed" else {"tolerance": 1e-7}
    found, expected = (
        in_waves(floater).simulate(16.0, 0.5, solver=solver, outputs=[], **settings)
        for floater in (stiff, barge(Floater, database=database.rigid, radiation_order=order))
    )
    for name in ("hull.frame.r[2]", "hull.frame.R[2,0]"):
        one, other = found.array(name), expected.array(name)
        assert np.ptp(other) > 0.02
        assert np.abs(one - other).max() < 1e-3 * np.ptp(other)


def test_the_memory_of_the_water_takes_energy(made):
    """Re(v* Z v) >= 0 of the radiation of all motions at all frequencies: passive; and near to the damping."""
    database = ModalDatabase.read(made / "barge.nc")
    floater = barge(ElasticFloater, database=database, excitation=False)
    fw.load(floating(floater))
    model = floater.parts["potential_flow"].parts["radiation"].model()
    realized = StateSpace(model.A, model.B, model.C)
    omega = np.concatenate([np.linspace(0.01, 4, 120), [10.0, 50.0]])
    transfer = np.array(realized.transfer(omega))
    hermitian = (transfer + transfer.conj().transpose(0, 2, 1)) / 2
    size = np.sqrt(np.maximum(np.einsum("nii->ni", hermitian.real).max(axis=0), 1e-9))
    lowest = np.linalg.eigvalsh(hermitian / np.outer(size, size)).min()
    assert lowest > -1e-6
    assert isinstance(RadiationTransfer(database, realized), RadiationTransfer)


def test_the_memory_of_rigid_motions_is_that_of_the_rigid_hull(made):
    """The same model of heave, surge and pitch, and the shapes near to the data (0.2 of the largest)."""
    database = ModalDatabase.read(made / "barge.nc")
    bent = kept_modal_radiation(database, 4, True)
    rigid = database.rigid
    stiff = kept_radiation(rigid.omega, rigid.B, rigid.A, rigid.A_inf, order=4, passive=True)
    omega = np.linspace(0.05, 6.0, 200)
    one, other = bent.transfer(omega), stiff.transfer(omega)
    kept = np.ix_(range(len(omega)), [0, 2, 4], [0, 2, 4])
    np.testing.assert_allclose(one[kept], other[kept], atol=1e-9 * np.abs(other).max())
    assert bent.passive and bent.stable
    damping = bent.transfer(database.omega)[:, [0, 2, 4, 6], [6, 6, 6, 6]].real
    expected, size = database.B[:, [0, 2, 4, 6], 6], np.sqrt(np.einsum("nii->ni", database.B).max(axis=0))
    assert (np.abs(damping - expected) / (size[[0, 2, 4, 6]] * size[6])).max() < 0.2


def floating(floater):
    model = fw.Assembly("barge")
    model.world, model.motion, model.hull = World(water_depth=200.0), FreeMotion(), floater
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.hull.frame)
    return model


def test_what_a_bent_barge_loses_the_water_takes(made):
    """Let go bent: kinetic and potential energy fall by the work of the radiation load, which never gives any."""
    database, soft = ModalDatabase.read(made / "barge.nc"), {"young_modulus": 4e9, "shear_modulus": 1.54e9}
    elastic = barge(ElasticFloater, database=database, excitation=False, **soft)
    plant = fw.load(floating(elastic)).compile()
    rest = plant.equilibrium()
    start = plant.initial_state(start={"hull.structure.q[0]": float(rest["hull.structure.q"][0]) + 0.3}, base=rest)
    result = plant.simulate(8.0, 0.02, start=start, outputs=[], tolerance=1e-8)
    structure = elastic.member_frame()
    mass, stiffness = matrices(database, structure)
    q, v = (np.column_stack([result.array(f"hull.structure.{name}[{k}]") for k in range(3)]) for name in "qv")
    heave = result.array("hull.frame.r[2]")
    pitch = -np.arcsin(result.array("hull.frame.R[2,0]"))
    moved = np.column_stack([heave - heave_of(rest), pitch, q - rest["hull.structure.q"]])
    kept = [2, 4, 6, 7, 8]
    speed = np.column_stack([np.gradient(heave, result.time), np.gradient(pitch, result.time), v])
    held = stiffness[np.ix_(kept, kept)]
    energy = np.einsum("ti,ij,tj->t", speed, mass[np.ix_(kept, kept)], speed) / 2
    energy += np.einsum("ti,ij,tj->t", moved, held, moved) / 2
    load = np.column_stack([result.array(f"hull.potential_flow.radiation.{name}")
                            for name in ("force[2]", "moment[1]", *(f"on_shapes[{k}]" for k in range(3)))])  # fmt: skip
    power = np.einsum("ti,ti->t", load, speed)
    work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(result.time))])
    assert work.max() < 1e-4 * energy[0]
    assert work[-1] < -0.02 * energy[0]
    np.testing.assert_allclose(energy[5:-5], (energy[0] + work)[5:-5], atol=0.01 * energy[0])


def heave_of(state):
    return float(state["hull.frame.r"][2])


def test_pictures_show_it_bent(made, tmp_path):
    """Sections lie where the field of its shapes moves them, as often as is said; a mode of bending is an animation."""
    database = ModalDatabase.read(made / "barge.nc")
    elastic = barge(ElasticFloater, database=database, excitation=False, radiation_order=0, drawn_bending=20.0)
    plant = fw.load(floating(elastic)).compile()
    state = plant.initial_state(start={"hull.structure.q[0]": 0.05})
    cast = Cast(elastic.drawing())
    poses = cast.poses(played(plant, [state], np.array([0.0])).observe, 1)[0]
    carried = [(cast._numbers[frame], frame) for frame in cast.frames if isinstance(frame, shapes.Carried)]
    assert len(carried) == len(elastic.member_frame().pieces)
    points = np.array([frame.point for _, frame in carried])
    moved = elastic.member_frame().field(points, database.shapes[:1]).displacement[0]
    turned = elastic.member_frame().turn(points, database.shapes[:1])[0]
    found = poses[[number for number, _ in carried]]
    np.testing.assert_allclose(found[:, :3], points + 20 * 0.05 * moved, atol=1e-9)
    np.testing.assert_allclose(2 * found[:, 3:6], 20 * 0.05 * turned, rtol=1e-3, atol=1e-9)
    number = next(mode.number for mode in natural_modes(plant, plant.equilibrium()) if "1st hull bending" in mode.name)
    shown = fw.view(plant, tmp_path / "bending.html", mode=number)
    assert shown.moments > 10 and "1st hull bending" in (tmp_path / "bending.html").read_text()
