"""Matrices of parameters: symmetric, without negative moments of inertia, positive definite."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.hydro import AddedMass, Hydrostatics
from fowtlib.components.mechanics import FreeMotion, RigidBody
from fowtlib.components.support import CoupledSpring
from fowtlib.language.errors import ParameterError
from fowtlib.language.matrix_forms import wrong_form

SPHERE = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
ONE_SIDED = ((1.0, 0.2, 0), (0, 1.0, 0), (0, 0, 1.0))
MODEL = """fowtlib: 1
world: {class: World}
parts:
  motion: {class: FreeMotion}
  body: {class: RigidBody, mass: 1, inertia: INERTIA}
connect:
  - [world.frame, motion.frame_a]
  - [motion.frame_b, body.frame_a]
"""


@pytest.mark.parametrize(("form", "matrix", "said"), [
    ("inertia", SPHERE, ""),
    ("inertia", np.zeros((3, 3)), ""),
    ("inertia", ((1.0, 0.9, 0), (0.9, 1.0, 0), (0, 0, 0)), ""),  # a rod, whose moment about itself is zero
    ("inertia", ((1.0, 0.5, 0), (0.5, 1.0004, 0), (0, 0, 1)), ""),
    ("inertia", ONE_SIDED, "entry (1, 2) is 0.2 and (2, 1) is 0; an inertia tensor is symmetric"),
    ("inertia", ((1.0, 0, 0), (0, -1.0, 0), (0, 0, 1.0)), "its least principal moment is -1 kg m^2, "),
    ("inertia", ((1.0, 2.0, 0), (2.0, 1.0, 0), (0, 0, 1.0)), "its least principal moment is -1 kg m^2, "),
    ("inertia", ((0, 2.0, 0), (0, 1.0, 0), (0, 0, 1.0)), "entry (1, 2) is 2 and (2, 1) is 0; "),
    ("symmetric", np.diag([-1.0, 2.0]), ""),
    ("symmetric", ((4.0, 1.0), (0.9, 1.0)), ""),  # 5 % of sqrt(M11 M22), as of a database
    ("symmetric", ((4.0, 1.0), (0.8, 1.0)), "entry (1, 2) is 1 and (2, 1) is 0.8; this matrix is symmetric"),
    ("symmetric", ((4.0, 1.0), (0.0, 0.0)), ""),  # nothing says what is small
    ("stiffness", np.eye(6), ""),
    ("stiffness", np.zeros((6, 6)), "it must be positive definite"),
])  # fmt: skip
def test_what_is_wrong_with_a_matrix(form, matrix, said):
    found = wrong_form(form, np.array(matrix, dtype=float))
    assert found.startswith(said)
    assert bool(found) == bool(said)


def test_an_inertia_tensor_that_none_is_in_a_model_file(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL.replace("INERTIA", "[[1, 0.2, 0], [0, 1, 0], [0, 0, 1]]"))
    with pytest.raises(ParameterError, match=r"model.yaml:5: body.inertia: entry \(1, 2\) is 0.2 and \(2, 1\) is 0"):
        fw.load(path).compile()
    path.write_text(MODEL.replace("INERTIA", "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"))
    plant = fw.load(path).compile()
    for wrong, said in ((ONE_SIDED, "is symmetric"), (-np.eye(3), "no body has a negative one")):
        with pytest.raises(ParameterError, match=f"body.inertia: .*{said}"):
            plant.simulate(0.1, parameters={"body.inertia": wrong})
    plant.simulate(0.1, parameters={"body.inertia": np.diag([1.0, 2.0, 3.0])})


def of_a_hull(**parts):
    root = fw.Assembly("a hull")
    root.world, root.motion, root.body = World(), FreeMotion(), RigidBody(mass=1e6, inertia=1e6 * np.eye(3))
    root.connect(root.world.frame, root.motion.frame_a)
    root.connect(root.motion.frame_b, root.body.frame_a)
    for name, one in parts.items():
        root.add(name, one)
        root.connect(root.motion.frame_b, one.frame)
    return fw.Model(root)


def test_stiffness_of_a_waterplane_and_added_mass_that_were_typed_on_one_side_only():
    C, A = np.diag([0, 0, 1e6, 1e8, 1e8, 0]), np.diag([1e6, 1e6, 1e6, 1e8, 1e8, 1e8])
    whole = np.zeros((6, 6))
    whole[2, 4] = whole[4, 2] = 3e6
    half = np.triu(whole)
    hydrostatics = {"volume": 975.6, "centre_of_buoyancy": (0, 0, -1)}
    of_a_hull(water=Hydrostatics(stiffness=C + whole, **hydrostatics), added=AddedMass(matrix=A + whole)).compile()
    with pytest.raises(ParameterError, match=r"water.stiffness: entry \(3, 5\) is 3e\+06 and \(5, 3\) is 0"):
        of_a_hull(water=Hydrostatics(stiffness=C + half, **hydrostatics)).compile()
    with pytest.raises(ParameterError, match=r"added.matrix: entry \(3, 5\) is 3e\+06 and \(5, 3\) is 0"):
        of_a_hull(added=AddedMass(matrix=A + half)).compile()


def test_a_spring_of_a_foundation_by_itself_is_checked_too():
    root = fw.Assembly("a spring")
    root.world, root.motion, root.body = World(), FreeMotion(), RigidBody(mass=1.0, inertia=np.eye(3))
    root.spring = CoupledSpring(stiffness=np.eye(6) + np.eye(6, k=1))
    for a, b in ((root.world.frame, "frame_a"), (root.motion.frame_b, "frame_b")):
        root.connect(a, getattr(root.spring, b))
    root.connect(root.world.frame, root.motion.frame_a)
    root.connect(root.motion.frame_b, root.body.frame_a)
    with pytest.raises(ParameterError, match="spring.stiffness: .*a stiffness is symmetric"):
        fw.Model(root).compile()
