"""Numbers of the water loads that may change in a compiled model: runs as of a model built with them; derivatives."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw

CALM = {"wind.kind": "none", "sea.spectrum": "still", "platform.drag.end_drag": (3.0, 2.0)}
CALM |= {"platform.damping.matrix": np.zeros((6, 6))}
WATER = "platform.water"
MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def changed_matrix(path, row, column, factor, extra):
    def change(root):
        owner, _, name = path.rpartition(".")
        matrix = np.array(root.find(owner).parameter_value(name))
        matrix[row, column] = matrix[column, row] = matrix[row, column] * factor + extra
        return matrix

    return path, change


def given(path, value):
    return path, lambda root: value


CHANGES = [
    given(f"{WATER}.hydrostatics.volume", 8060.0),
    given(f"{WATER}.hydrostatics.centre_of_buoyancy", (0.4, -0.3, -60.0)),
    given(f"{WATER}.position", (0.0, 0.0, 0.3)),
    changed_matrix(f"{WATER}.hydrostatics.stiffness", 2, 2, 1.2, 0.0),
    changed_matrix(f"{WATER}.hydrostatics.stiffness", 2, 4, 1.0, 4e5),  # was zero
    changed_matrix(f"{WATER}.added_mass.matrix", 0, 0, 1.1, 0.0),
    changed_matrix(f"{WATER}.added_mass.matrix", 2, 4, 1.0, 2e6),  # was zero
    changed_matrix("platform.damping.matrix", 1, 3, 1.0, 3e6),
    given("platform.damping.translation", (2e5, 1e5, 4e5)),
    given("platform.drag.diameters", (11.0, 9.0, 6.0, 6.0)),
    given("platform.drag.drag_coefficient", 1.1),
    given("platform.drag.end_drag", (0.0, 0.0)),
]
MOVING = {f"platform.motion.{name}": value for name, value in zip(MOTIONS, (3, -1, 1, 0.05, 0.1, 0.02), strict=True)}
MOVING |= {f"platform.motion.velocity[{i}]": v for i, v in enumerate((0.7, -0.2, 0.5))}
MOVING |= {f"platform.motion.angle_rates[{i}]": v for i, v in enumerate((0.004, -0.006, 0.003))}


@pytest.fixture(scope="module")
def model():
    return fw.load("oc3_spar_rigid").with_parameters(CALM)


@pytest.fixture(scope="module")
def plant(model):
    return model.compile()


@pytest.mark.parametrize(("path", "change"), CHANGES, ids=[path.partition(".")[2] for path, _ in CHANGES])
def test_a_changed_run_is_that_of_a_model_built_so(model, plant, path, change):
    value = change(model.root)
    parameters = {path: value}
    run = plant.simulate(20.0, 0.5, solver="fixed", step=0.05, start=MOVING, parameters=parameters)
    fresh = model.with_parameters(parameters).compile().simulate(20.0, 0.5, solver="fixed", step=0.05, start=MOVING)
    usual = plant.simulate(20.0, 0.5, solver="fixed", step=0.05, start=MOVING)
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    np.testing.assert_allclose([run[n] for n in names], [fresh[n] for n in names], rtol=1e-9, atol=1e-10)
    assert max(np.abs(np.asarray(run[n]) - np.asarray(usual[n])).max() for n in names) > 1e-6


@pytest.fixture(scope="module")
def windy(model):
    return model.with_parameters({"wind.kind": "steady", "wind.mean_speed": 8.0}).compile()


STATIC = [
    (f"{WATER}.hydrostatics.volume", 0, 1.0),
    (f"{WATER}.hydrostatics.centre_of_buoyancy", 0, 0.05),
    (f"{WATER}.position", 2, 0.02),
    (f"{WATER}.hydrostatics.stiffness", 6 * 4 + 2, 1e4),  # (2, 4), by columns
]


@pytest.mark.parametrize(("path", "entry", "step"), STATIC, ids=[path.rpartition(".")[2] for path, *_ in STATIC])
def test_the_derivative_of_the_equilibrium_is_a_difference(windy, path, entry, step):
    base = np.array(windy.dae.parameters[path].value, dtype=float)
    names = ("surge", "heave", "pitch")

    def at(change):
        value = np.ravel(base, order="F").copy()
        value[entry] += change
        state = windy.equilibrium({path: value.reshape(base.shape, order="F")})
        return np.array([float(state[f"platform.motion.{name}"]) for name in names])

    state = windy.equilibrium()
    linear = windy.linearize(state, inputs=[path], outputs=[f"platform.motion.{name}" for name in names])
    A, B, C, D = (np.asarray(matrix) for matrix in (linear.A, linear.B, linear.C, linear.D))
    moving = np.abs(A).max(axis=0) > 0  # all but the angle of the rotor, on which nothing depends
    assert moving.sum() == len(moving) - 1
    shift = np.linalg.solve(A[np.ix_(moving, moving)], B[moving, entry])
    derivative = D[:, entry] - C[:, moving] @ shift
    difference = (at(step) - at(-step)) / (2 * step)
    np.testing.assert_allclose(derivative, difference, rtol=2e-3, atol=1e-3 * np.abs(difference).max())


DYNAMIC = [
    (f"{WATER}.added_mass.matrix", 0, 1e4),
    (f"{WATER}.added_mass.matrix", 6 * 4 + 2, 1e4),
    ("platform.damping.matrix", 6 * 4 + 0, 1e5),
    ("platform.drag.diameters", 1, 1e-3),
    ("platform.drag.end_drag", 0, 1e-2),
    ("platform.drag.drag_coefficient", 0, 1e-3),
]


@pytest.mark.parametrize(("path", "entry", "step"), DYNAMIC)
def test_the_derivative_of_the_acceleration_is_a_difference(plant, path, entry, step):
    base = np.array(plant.dae.parameters[path].value, dtype=float)
    names = [f"platform.motion.acceleration[{i}]" for i in range(3)]
    names += [f"platform.motion.angle_accelerations[{i}]" for i in range(3)]

    def at(change):
        value = np.ravel(base, order="F").copy()
        value[entry] += change
        state = plant.initial_state({path: value.reshape(base.shape, order="F")}, start=MOVING)
        return np.array([float(state[name]) for name in names])

    linear = plant.linearize(plant.initial_state(start=MOVING), inputs=[path], outputs=names)
    difference = (at(step) - at(-step)) / (2 * step)
    assert np.abs(difference).max() > 0
    np.testing.assert_allclose(linear.D[:, entry], difference, rtol=1e-3, atol=1e-4 * np.abs(difference).max())


@pytest.mark.parametrize("name", ["damping.matrix", "drag.end_drag"])
def test_what_a_hull_was_built_without_cannot_be_changed(name):
    plant = fw.load("oc3_spar_rigid").with_parameters({"wind.kind": "none"}).compile()
    with pytest.raises(fw.ModelError, match=f"no tunable parameter 'platform.{name}'"):
        plant.initial_state({f"platform.{name}": np.ones((6, 6)) if "matrix" in name else (1.0, 1.0)})
