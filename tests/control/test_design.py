"""Regulators and estimators against what is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import linalg

from fowtlib.control import DesignError, compensator, discretized, kalman, lqi, lqr, reduced
from fowtlib.language.errors import NotFoundError, ParameterError
from fowtlib.solving import LinearModel


def model(A, B, C=None, D=None, states=None, inputs=None, outputs=None):
    A, B = np.array(A, float), np.array(B, float)
    C = np.eye(len(A)) if C is None else np.array(C, float)
    D = np.zeros((len(C), B.shape[1])) if D is None else np.array(D, float)
    names = [states or [f"x{i}" for i in range(len(A))], inputs or [f"u{i}" for i in range(B.shape[1])],
             outputs or [f"y{i}" for i in range(len(C))]]  # fmt: skip
    return LinearModel(A, B, C, D, *names, {})


def cart():
    """X'' = u: position and speed."""
    return model([[0, 1], [0, 0]], [[0], [1]], states=["position", "speed"], inputs=["force"])


def random_model(seed, n=6, m=2, p=3):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) - 2.5 * np.eye(n)
    return model(A, rng.normal(size=(n, m)), rng.normal(size=(p, n)), rng.normal(size=(p, m)))


@pytest.mark.parametrize(("q", "r"), [(1.0, 1.0), (9.0, 0.25), (2e-3, 40.0)])
def test_double_integrator(q, r):
    """K = (sqrt(q/r), sqrt(2 sqrt(q/r))): a damping ratio of 0.7071 at the frequency (q/r)^(1/4)."""
    regulator = lqr(cart(), {"position": q}, {"force": r})
    root = np.sqrt(q / r)
    assert_allclose(regulator.gain, [[root, np.sqrt(2 * root)]], rtol=1e-9)
    assert_allclose(np.abs(regulator.poles), root**0.5, rtol=1e-9)
    assert_allclose(-regulator.poles.real / np.abs(regulator.poles), np.sqrt(0.5), rtol=1e-9)
    assert_allclose(regulator.K.sel(input="force", state="speed"), np.sqrt(2 * root), rtol=1e-9)


def test_scalar_plant():
    """X' = a x + b u: P from the quadratic equation; the closed loop is -sqrt(a^2 + b^2 q / r)."""
    for a, b, q, r in ((2.0, 3.0, 5.0, 7.0), (-1.0, 0.5, 1.0, 0.1)):
        regulator = lqr(model([[a]], [[b]]), [q], r)
        assert_allclose(regulator.poles, [-np.sqrt(a**2 + b**2 * q / r)], rtol=1e-12)
        assert_allclose(regulator.cost, [[r * (a + np.sqrt(a**2 + b**2 * q / r)) / b**2]], rtol=1e-12)


def test_the_cost_is_that_of_the_motion():
    """X' P x is the integral of the cost along the closed loop, by the Lyapunov equation."""
    plant = random_model(3)
    Q, R = np.diag([1.0, 2, 0, 3, 0, 1]), np.array([[2.0, 0.3], [0.3, 1.0]])
    regulator = lqr(plant, Q, R)
    A = plant.matrices["A"] - plant.matrices["B"] @ regulator.gain
    spent = linalg.solve_continuous_lyapunov(A.T, -(Q + regulator.gain.T @ R @ regulator.gain))
    assert_allclose(regulator.cost, spent, rtol=1e-8, atol=1e-10)


def test_estimator_is_dual_to_the_regulator():
    plant = random_model(5)
    A, C = plant.matrices["A"], plant.matrices["C"]
    noise, rough = {name: 0.5 + k for k, name in enumerate(plant.states)}, {"y0": 0.1, "y1": 2.0, "y2": 0.7}
    estimator = kalman(plant, noise, rough)
    regulator = lqr(model(A.T, C.T), list(noise.values()), list(rough.values()))
    assert_allclose(estimator.gain, regulator.gain.T, rtol=1e-9, atol=1e-12)
    assert_allclose(np.sort_complex(estimator.poles), np.sort_complex(regulator.poles), rtol=1e-7)
    sampled = discretized(plant, 0.1)
    A, C = sampled.matrices["A"], sampled.matrices["C"]
    dual = discretized(model(A.T, C.T), 1.0)
    dual.matrices["A"], dual.matrices["B"] = A.T, C.T
    gain = lqr(dual, list(noise.values()), list(rough.values())).gain
    assert_allclose(kalman(sampled, noise, rough).gain, gain.T, rtol=1e-8, atol=1e-12)


def test_scalar_estimator():
    """X' = a x + w, y = x + v: the error decays as the closed loop of the dual regulator, sqrt(a^2 + w / v)."""
    estimator = kalman(model([[0.4]], [[1.0]], inputs=["wind"]), {"wind": 3.0}, {"y0": 0.5})
    assert_allclose(estimator.poles, [-np.sqrt(0.4**2 + 3.0 / 0.5)], rtol=1e-12)
    assert estimator.model.inputs == []


def settled(closed, B):
    """Steady states of x' = A x + B d."""
    return -np.linalg.solve(closed, B)


def test_integral_action_leaves_no_steady_error():
    """Under constant disturbances of unknown size, also with a plant that differs from the model."""
    plant = random_model(7)
    outputs = {"y0": 0.3, "y2": 1.0}
    regulator = lqi(plant, 1.0, 1.0, outputs)
    A, B, C, D = (plant.matrices[name] for name in "ABCD")
    n, K, Ke = len(A), regulator.state_gain, regulator.integral_gain
    for change in (1.0, 1.05):
        a, rows = change * A, [0, 2]
        closed = np.block([[a - B @ K, -B @ Ke], [-(C[rows] - D[rows] @ K), D[rows] @ Ke]])
        assert np.linalg.eigvals(closed).real.max() < 0
        disturbance = np.concatenate([np.random.default_rng(1).normal(size=n), np.zeros(2)])
        rest = settled(closed, disturbance)
        u = -np.hstack([K, Ke]) @ rest
        assert_allclose(C[rows] @ rest[:n] + D[rows] @ u, 0.0, atol=1e-12)
        without = settled(a - B @ lqr(plant, 1.0, 1.0).gain, disturbance[:n])
        assert np.abs(C[rows] @ without).max() > 1e-2


@pytest.mark.parametrize("seed", [0, 4, 9])
def test_the_block_of_the_integrals_is_exact(seed):
    """K_e' R K_e = Q_e, whatever the plant: |K_e| = sqrt(Q_e / R) of one error and one input."""
    plant = random_model(seed)
    R = np.diag([2.0, 5.0])
    regulator = lqi(plant, {"x0": 3.0}, R, {"y0": 0.01, "y1": 0.25})
    Ke = regulator.integral_gain
    assert_allclose(Ke.T @ R @ Ke, np.diag([0.01, 0.25]), rtol=1e-7, atol=1e-10)
    single = lqi(random_model(seed, m=1), {"x1": 1.0}, 200.0, {"y0": 0.01})
    assert_allclose(abs(single.integral_gain[0, 0]), np.sqrt(0.01 / 200), rtol=1e-8)


def test_sampled_regulators_tend_to_the_continuous_one():
    """With the weights of a sample, Q T and R T, the gain differs by a share of the period, halving with it."""
    plant, errors = random_model(11), []
    exact = lqr(plant, 1.0, 1.0).gain
    for period in (0.02, 0.01, 0.005):
        gain = lqr(discretized(plant, period), period, period).gain
        errors.append(np.abs(gain - exact).max())
    assert_allclose(np.array(errors[:-1]) / errors[1:], 2.0, rtol=0.1)
    assert errors[-1] < 0.02 * np.abs(exact).max()


def test_sampled_models():
    plant = random_model(2)
    A, B, C, D = (plant.matrices[name] for name in "ABCD")
    sampled = discretized(plant, 0.3)
    assert_allclose(sampled.matrices["A"], linalg.expm(0.3 * A), rtol=1e-10, atol=1e-12)
    steady = C @ np.linalg.solve(-A, B) + D
    assert_allclose(sampled.frequency_response([0.0])[0], steady, rtol=1e-9)
    tustin = discretized(plant, 0.3, "tustin")
    omega = np.array([0.1, 1.0, 4.0])
    warped = 2 / 0.3 * np.tan(omega * 0.15)
    assert_allclose(tustin.frequency_response(omega), plant.frequency_response(warped), rtol=1e-9)
    ours, theirs = ([mode.eigenvalue for mode in item.modes()] for item in (sampled, plant))
    assert_allclose(np.sort_complex(ours), np.sort_complex(theirs), rtol=1e-6)


@pytest.mark.parametrize("states", [["x0"], ["x3", "x1"], ["x5", "x0", "x2"]])
def test_residualised_states_keep_the_steady_gain(states):
    plant = random_model(13)
    small = reduced(plant, states)
    assert small.states == states
    assert_allclose(small.frequency_response([0.0]), plant.frequency_response([0.0]), rtol=1e-9)
    assert np.abs(small.frequency_response([3.0]) - plant.frequency_response([3.0])).max() > 1e-3


def test_fast_states_are_residualised_and_held_ones_do_not_move():
    """A fast lag in front of a cart: gone but for its steady gain. A second cart that is held leaves the first."""
    names = ["position", "speed", "lag"]
    plant = model([[0, 1, 0], [0, 0, 1], [0, 0, -100]], [[0], [0], [100]], states=names)
    small = reduced(plant, ["position", "speed"])
    assert_allclose(small.matrices["A"], [[0, 1], [0, 0]])
    assert_allclose(small.matrices["B"], [[0], [1]], rtol=1e-12)
    A = [[0, 1, 0, 0], [-2, 0, 1, 0], [0, 0, 0, 1], [1, 0, -1, 0]]
    coupled = model(A, np.eye(4)[:, [1]], C=[[1, 0, 0, 0]], states=["a", "da", "b", "db"])
    assert_allclose(reduced(coupled, ["a", "da"], ["b", "db"]).matrices["A"], [[0, 1], [-2, 0]])
    assert_allclose(reduced(coupled, ["a", "da"]).matrices["A"], [[0, 1], [-1, 0]], atol=1e-12)


def test_a_state_without_rest_is_named():
    """The angle of a shaft drifts: it can be kept or held, not residualised; unheard ones do no harm."""
    plant = model([[-1, 0.5], [1, 0]], [[1], [0]], C=[[1, 0]], states=["shaft.w", "shaft.phi"])
    assert reduced(model([[-1, 0], [1, 0]], [[1], [0]], C=[[1, 0]], states=["w", "phi"]), ["w"]).states == ["w"]
    with pytest.raises(ParameterError, match="'shaft.phi' has no rest of its own"):
        reduced(plant, ["shaft.w"])
    assert reduced(plant, ["shaft.w"], ["shaft.phi"]).states == ["shaft.w"]


def test_compensator_separates():
    """Poles of the loop closed by regulator and estimator are those of both (separation)."""
    plant = random_model(17)
    regulator = lqi(plant, 1.0, 1.0, {"y0": 0.5})
    estimator = kalman(plant, dict.fromkeys(plant.states, 1.0), {"y0": 0.1, "y1": 0.1})
    controller = compensator(regulator, estimator)
    A, B, C, D = (estimator.model.matrices[name] for name in "ABCD")
    a, b, c, _ = (controller.matrices[name] for name in "ABCD")
    closed = np.block([[A, B @ c], [b @ C, a + b @ D @ c]])
    wanted = np.concatenate([regulator.poles, estimator.poles])
    assert_allclose(np.sort_complex(np.linalg.eigvals(closed)), np.sort_complex(wanted), rtol=1e-6)
    assert controller.inputs == ["y0", "y1"] and controller.outputs == plant.inputs


@pytest.mark.parametrize(("A", "B", "name"), [
    ([[0.1, 0], [0, -1]], [[0], [1]], "sway"),
    ([[-1, 0, 0], [0, 0, 1], [0, 0, 0]], [[1], [0], [0]], "heave"),
    ([[1, 0], [0, 1]], [[1], [1]], "sway|heave"),
])  # fmt: skip
def test_what_cannot_be_stabilised_is_named(A, B, name):
    states = ["sway", "heave"] if len(A) == 2 else ["roll", "heave", "speed of heave"]
    with pytest.raises(DesignError, match=f"'(speed of )?({name})' .* cannot be stabilised"):
        lqr(model(A, B, states=states), 1.0, 1.0)


def test_mistakes_are_sentences():
    with pytest.raises(NotFoundError, match="no state 'posiion'; did you mean 'position'"):
        lqr(cart(), {"posiion": 1.0}, 1.0)
    with pytest.raises(NotFoundError, match="no input 'forces'; did you mean 'force'"):
        lqr(cart(), {"position": 1.0}, {"forces": 1.0})
    with pytest.raises(NotFoundError, match="no output 'z'"):
        lqi(cart(), {"position": 1.0}, 1.0, {"z": 1.0})
    with pytest.raises(NotFoundError, match="no state 'spead'; did you mean 'speed'"):
        reduced(cart(), ["spead"])
    with pytest.raises(ParameterError, match="weight of the input 'force' must be positive"):
        lqr(cart(), {"position": 1.0}, 0.0)
    with pytest.raises(ParameterError, match="weight of the state 'speed' must not be negative"):
        lqr(cart(), {"position": 1.0, "speed": -1.0}, 1.0)
    with pytest.raises(ParameterError, match=r"there are 2 states, so give"):
        lqr(cart(), [1.0, 2.0, 3.0], 1.0)
    with pytest.raises(ParameterError, match="not symmetric"):
        lqr(cart(), [[1.0, 0.5], [0.0, 1.0]], 1.0)
    with pytest.raises(DesignError, match="'position' .*no weight sees it"):
        lqr(cart(), {"speed": 1.0}, 1.0)
    with pytest.raises(DesignError, match="shows in no measured output"):
        kalman(cart(), {"force": 1.0}, {"y1": 1.0})
    with pytest.raises(ParameterError, match="nothing is measured"):
        kalman(cart(), {"force": 1.0}, {})
    for period in (-1.0, float("inf"), float("nan")):
        with pytest.raises(ParameterError, match=f"period of sampling is {period:g}"):
            discretized(cart(), period)
    for weights in ("heavy", {"position": "heavy"}, {"position": [1.0, 2.0]}, [[1.0], [2.0, 3.0]], None):
        with pytest.raises(ParameterError, match="weights of the states are not"):
            lqr(cart(), weights, 1.0)
    with pytest.raises(ParameterError, match="weight of the process noise 'force' must not be negative"):
        kalman(cart(), {"speed": 1.0, "force": -1.0}, {"y1": 1.0})
    with pytest.raises(ParameterError, match="weights of the process noises are not numbers"):
        kalman(cart(), {"force": "loud"}, {"y1": 1.0})
