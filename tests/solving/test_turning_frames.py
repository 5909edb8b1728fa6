"""Vectors in world axes that turn with their frames, in the Newton matrix that the fixed-step engine keeps."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.native import compiler
from fowtlib.solving.engines.turning_frames import turning_frames

CALM = {"wind.kind": "steady", "wind.mean_speed": 12.0}


@pytest.fixture(scope="module")
def plant():
    blades = {f"turbine_{side}.assembly.blade_hinges": 1 for side in ("left", "right")}
    return fw.load("two_rotor_spar", set={**CALM, **blades}).compile()


def test_vectors_are_found_with_the_axes_of_their_frame(plant):
    """Three components of one vector each; R is a rotation, and that of a hub does not turn with its ring."""
    dae, frames = plant.dae, turning_frames(plant.dae)
    vectors = [[dae.algebraics[i].path for i in numbers] for frame in frames for numbers in frame.unknowns]
    assert [f"der(support.arm_left.nodes[2].w[{i}])" for i in range(3)] in vectors
    assert [f"der(der(platform.motion.{name}))" for name in ("surge", "sway", "heave")] in vectors
    rows = [{dae.residual_paths[i] for i in numbers} for frame in frames for numbers in frame.rows]
    assert rows and all(len(of_one) == 1 for of_one in rows)
    q = ca.vertcat(dae.u, dae.d, dae.p)
    given = ca.Function("R", [dae.x, q], [frame.R for frame in frames])
    start = plant.initial_state()
    at, turned = plant.at().whole(np.concatenate([start.u, start.d])), start.x.copy()
    for ring in dae.symmetries:
        turned[next(i for i in range(dae.x.numel()) if dae.x[i].element_hash() == ring.angle.element_hash())] += 1.0
    for R, other in zip(given(start.x, at), given(turned, at), strict=True):
        assert np.abs(np.array(R @ R.T) - np.eye(3)).max() < 1e-12
        assert np.abs(np.array(R - other)).max() == 0.0


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_a_matrix_that_turns_with_the_frames_saves_evaluations(plant, leads_to_the_same_motion_with_less_work):
    """The arms are light about their own axis; the motions agree as far as Newton's method is exact."""
    leads_to_the_same_motion_with_less_work(plant, "frames")
