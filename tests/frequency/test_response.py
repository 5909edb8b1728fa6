"""Stationary response: textbook oscillators, drag in a closed form, RAOs times spectra, and the words of mistakes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import erf

import fowtlib as fw
from fowtlib.frequency import best_gain, response
from fowtlib.frequency.drag import best_gains
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.language.quadratic_laws import slope_at
from fowtlib.solving.excited import ExcitedModel
from tests.frequency.conftest import LINEAR, MASS, STIFFNESS, oscillator

FINE = np.unique(np.concatenate([np.geomspace(1e-4, 9.0, 4000), 0.3183 + np.linspace(-0.1, 0.1, 4000)]))


def test_an_oscillator_in_white_noise_has_the_deviation_of_the_textbook():
    # variance pi S / (2 b k) for a one-sided S per rad/s (Newland, Random Vibrations, ch. 7)
    found = response(oscillator(), frequencies=FINE)
    assert found.std("x") == pytest.approx(np.sqrt(np.pi * 2.0 / (2 * LINEAR * STIFFNESS)), rel=2e-3)
    assert found.std("v") == pytest.approx(np.sqrt(np.pi * 2.0 / (2 * LINEAR * MASS)), rel=2e-2)  # force ends at 60
    assert found["x"].up_crossing_rate == pytest.approx(np.sqrt(STIFFNESS / MASS) / (2 * np.pi), rel=2e-2)


def test_the_frequencies_of_a_response_are_close_where_it_changes_fast():
    coarse, fine = response(oscillator()), response(oscillator(), frequencies=FINE)
    assert coarse.std("x") == pytest.approx(fine.std("x"), rel=5e-3)
    assert coarse.frequency.size < FINE.size / 5


def test_drag_is_the_best_linear_law_of_the_response_itself():
    # b = c sqrt(8 / pi) s and s^2 = pi S / (2 b m), so s^3 = pi S / (2 c m sqrt(8 / pi))
    drag = 1.5
    wanted = (np.pi * 2.0 / (2 * drag * MASS * np.sqrt(8 / np.pi))) ** (1 / 3)
    found = response(oscillator(damping=0.0, drag=drag, highest=60.0), frequencies=np.linspace(1e-3, 9.5, 40000))
    assert found.std("v") == pytest.approx(wanted, rel=2e-2)  # the part above 60 rad/s: 2 b / (pi m 60) = 1.3 %
    assert 3 < found.iterations < 40


@pytest.mark.parametrize("flow", [0.2, 1.0, 5.0])
def test_drag_in_a_flow_is_that_about_the_mean_of_the_flow(flow):
    # E[2 |v + U|] = 2 s sqrt(2 / pi) exp(-U^2 / (2 s^2)) + 2 U erf(U / (s sqrt 2)), and s^2 = pi S / (2 b m)
    drag, s = 1.5, 0.5
    for _ in range(200):
        b = drag * 2 * (s * np.sqrt(2 / np.pi) * np.exp(-((flow / s) ** 2) / 2) + flow * erf(flow / s / np.sqrt(2)))
        s = 0.5 * s + 0.5 * np.sqrt(np.pi * 2.0 / (2 * b * MASS))
    found = response(oscillator(damping=0.0, drag=drag, flow=flow), frequencies=np.linspace(1e-3, 9.5, 40000))
    beyond = 1 - 2 / np.pi * np.arctan(60 * MASS / b)  # energy of the velocity above 60 rad/s, about
    assert found.std("v") == pytest.approx(s * np.sqrt(1 - beyond), rel=5e-3)


def test_gains_of_drag_about_a_mean():
    s, m = 0.8, 0.6
    alone = 2 * (s * np.sqrt(2 / np.pi) * np.exp(-((m / s) ** 2) / 2) + m * erf(m / s / np.sqrt(2)))
    assert best_gain(np.array([[s**2]]), np.array([m])) == pytest.approx(alone, rel=1e-9)
    mean = np.array([3.0, -4.0, 0.0])
    assert best_gain(1e-6 * np.eye(3), mean) == pytest.approx(slope_at(mean), rel=1e-5)
    covariance, mean = np.array([[1.3, 0.5], [0.5, 0.4]]), np.array([0.7, -0.4])
    grid = np.linspace(-9, 9, 1801)
    z = np.stack(np.meshgrid(grid, grid)).reshape(2, -1)
    weight = np.exp(-(z**2).sum(axis=0) / 2)
    u = np.linalg.cholesky(covariance) @ z + mean[:, None]
    moment = (weight * np.linalg.norm(u, axis=0) * u) @ (u - mean[:, None]).T / weight.sum()
    assert best_gain(covariance, mean) == pytest.approx(moment @ np.linalg.inv(covariance), rel=1e-5)


def test_gains_of_many_laws_are_those_of_each():
    rng = np.random.default_rng(3)
    velocities, means = [rng.normal(size=(n, 50)) for n in (1, 3, 3, 2)], [rng.normal(size=n) for n in (1, 3, 3, 2)]
    for gain, u, mean in zip(best_gains(velocities, means), velocities, means, strict=True):
        assert gain == pytest.approx(best_gain(u @ u.T, mean), rel=1e-12)


def test_gains_of_drag_in_one_two_and_three_directions():
    assert best_gain(np.array([[4.0]])) == pytest.approx(np.sqrt(8 / np.pi) * 2, rel=1e-9)
    assert best_gain(9 * np.eye(2)) == pytest.approx(1.5 * np.sqrt(np.pi / 2) * 3 * np.eye(2), rel=1e-9)
    assert best_gain(4 * np.eye(3)) == pytest.approx(32 / (3 * np.sqrt(2 * np.pi)) * np.eye(3), rel=1e-9)
    assert not best_gain(np.zeros((2, 2))).any()


def test_gains_of_drag_for_an_ellipse_against_its_angle():
    # E[|u| u u^T] over the angle of a Gaussian in two directions: the radius has E[r^3] = 3 sqrt(pi / 2)
    covariance = np.array([[1.3, 0.5], [0.5, 0.4]])
    angle = 2 * np.pi * (np.arange(4000) + 0.5) / 4000
    u = np.linalg.cholesky(covariance) @ np.array([np.cos(angle), np.sin(angle)])
    mean = 3 * np.sqrt(np.pi / 2) * (np.linalg.norm(u, axis=0) * u) @ u.T / angle.size
    assert best_gain(covariance) == pytest.approx(mean @ np.linalg.inv(covariance), rel=1e-6)


def test_gains_turn_with_the_axes():
    c, s = np.cos(0.7), np.sin(0.7)
    turn, covariance = np.array([[c, -s], [s, c]]), np.diag([2.0, 0.1])
    turned = best_gain(turn @ covariance @ turn.T)
    assert turned == pytest.approx(turn @ best_gain(covariance) @ turn.T, rel=1e-9)


@pytest.fixture(scope="module")
def spar():
    return fw.load("oc3_spar_rigid").compile()


def test_small_waves_give_the_response_operator_times_the_spectrum(spar):
    # the operator takes another way to the load: tunable parameters of the part, in place of its series
    frequency = np.linspace(0.04, 0.3, 200)
    names = ["surge", "heave", "pitch", "fairlead_tension_2"]
    calm = {"wind.kind": "none", "sea.significant_wave_height": 1e-3, "sea.peak_period": 10.0}
    found = response(spar, outputs=names, parameters=calm, frequencies=frequency)
    rao = fw.linear_rao(spar, frequency, outputs=names, parameters={"wind.kind": "none"})
    sea = found.spectrum("surge", "sea").density / np.abs(rao["surge"]) ** 2
    for name in names:
        expected = np.abs(rao[name]) ** 2 * sea
        assert found[name].density == pytest.approx(expected, rel=2e-3, abs=1e-4 * expected.max())
    assert found.transfer["sea"][:, 1, 0] == pytest.approx(rao["heave"], rel=2e-3)


def test_processes_add_up_and_are_what_they_were_given(spar):
    given = {"sea.significant_wave_height": 4.0, "sea.peak_period": 9.0, "wind.mean_speed": 18.0}
    found = response(spar, parameters=given)
    assert set(found.shares) == {"sea", "wind"}
    assert found.std("wave_elevation") == pytest.approx(1.0, rel=5e-3)
    both = [found.std("pitch", process) ** 2 for process in ("sea", "wind")]
    assert found.std("pitch") ** 2 == pytest.approx(sum(both), rel=1e-9)


@pytest.mark.parametrize("side", ["max", "min"])
def test_extremes_are_those_of_rice(spar, side):
    found = response(oscillator(), frequencies=FINE)
    level = found.extreme("x", 600.0, 0.9, side)
    rate = found["x"].up_crossing_rate * np.exp(-0.5 * (level / found.std("x")) ** 2)
    assert np.exp(-600.0 * rate) == pytest.approx(0.9, rel=1e-9)
    assert (level > 0) == (side == "max")


@pytest.mark.parametrize(
    ("given", "who"),
    [
        ({"sea.spectrum": "regular", "sea.wave_height": 2.0, "sea.wave_period": 10.0}, "sea of kind 'regular'"),
        ({"wind.kind": "step", "wind.step_speed": 20.0}, "wind of kind 'step'"),
        ({"wind.kind": "eog", "wind.mean_speed": 18.0}, "wind of kind 'eog'"),
    ],
)
def test_what_has_no_spectrum_is_not_left_out_without_a_word(spar, given, who):
    with pytest.raises(ModelError, match=f"{who}: its signals have no spectrum"):
        response(spar, outputs=["surge"], parameters={"wind.mean_speed": 18.0, **given})


@pytest.mark.parametrize("kind", ["steady", "nwp"])
def test_a_steady_wind_beside_random_waves_is_no_mistake(spar, kind):
    found = response(spar, outputs=["surge"], parameters={"wind.kind": kind, "wind.mean_speed": 18.0})
    assert set(found.shares) == {"sea"}


def test_mistakes_are_named(spar):
    still = {"wind.kind": "none", "sea.spectrum": "still"}
    with pytest.raises(ModelError, match="takes anything from random waves or wind"):
        response(spar, parameters=still)
    found = response(oscillator())
    with pytest.raises(ModelError, match="no output 'y'"):
        found.std("y")
    with pytest.raises(ModelError, match="no process 'sea'"):
        found.std("x", "sea")
    with pytest.raises(ModelError, match="'top' is not 'max' or 'min'"):
        found.extreme("x", side="top")
    with pytest.raises(SimulationError, match="unstable"):
        response(oscillator(damping=-0.2))
    with pytest.raises(ModelError, match="hold 0.01.* up-crossings"):
        found.extreme("x", 0.05)


# --- what is refused or told ------------------------------------------------------------------------------------------


def test_an_integrator_at_rest_below_rated_is_no_instability(spar):
    # below rated the pitch controller waits: its integral is a pole at zero, and nothing that is asked for knows of it
    asked = {"outputs": ["surge", "pitch", "rotor_speed"], "parameters": {"wind.mean_speed": 8.0}}
    found = response(spar, **asked)
    roots = np.linalg.eigvals(found.linear.matrices["A"])
    assert np.abs(roots).min() < 1e-9
    grids = [np.concatenate([[lowest, 1e-6, 1e-5], found.frequency]) for lowest in (1e-10, 1e-7)]
    lower, low = (response(spar, frequencies=grid, **asked).std("pitch") for grid in grids)
    assert lower == pytest.approx(low, rel=1e-3)  # what drifts has a density of f^-2


def test_an_unstable_loop_is_refused_with_its_pole_and_its_state():
    pole = r"in which one\.[xv] takes part most, grows by a factor e in 30 s \(pole \+0.03333 \+2i 1/s\)"
    with pytest.raises(SimulationError, match=pole):
        response(oscillator(damping=-0.2))
    # x' = v, M v' = -b v - k x with b < 0 and b^2 > 4 k M
    with pytest.raises(SimulationError, match="a motion that does not oscillate, in which one"):
        response(oscillator(damping=-20.0))


def test_a_model_without_equilibrium_has_no_response():
    with pytest.raises(SimulationError, match="no equilibrium"):
        response(oscillator(push=5.0, stiffness=0.0, damping=0.0))


@pytest.mark.parametrize(
    ("frequencies", "words"),
    [
        (np.linspace(0.005, 0.33, 400), r"the frequencies end at 0.33 Hz, .* of v, x; take higher ones"),
        (np.linspace(0.3, 9.0, 4000), r"the frequencies begin at 0.3 Hz, .* of x.*; take lower ones"),
    ],
)
def test_frequencies_that_end_in_the_midst_of_the_response_are_told(frequencies, words):
    with pytest.warns(UserWarning, match=words):
        response(oscillator(), frequencies=frequencies)


def test_a_spectrum_that_ends_in_the_midst_of_the_response_is_told():
    with pytest.warns(UserWarning, match=r"the spectrum of one ends at 0.3\d+ Hz.*; let it reach further"):
        response(oscillator(highest=2.05))


def test_frequencies_are_rising_numbers(spar):
    for wrong in ([0.1, 0.05], [0.1], [0.0, 0.1]):
        with pytest.raises(ModelError, match="numbers"):
            response(spar, frequencies=wrong)


def test_what_is_no_model_no_list_and_no_number_is_told():
    plant = oscillator()
    wrong = [
        (lambda: response("oc3_spar_rigid"), r"load one first: fw.load\('oc3_spar_rigid'\)"),
        (lambda: response(plant, outputs="x"), r"as in \['x'\]"),
        (lambda: response(plant, frequencies="abc"), "positive numbers in Hz, not 'abc'"),
        (lambda: response(plant, shifted=["1 s"]), "modes with their new periods are expected"),
    ]
    for ask, why in wrong:
        with pytest.raises(ModelError, match=why):
            ask()
    found = response(plant)
    assert found.extreme("x", "3 h") == found.extreme("x", 3 * 3600.0)
    with pytest.raises(ModelError, match="a time in s is expected|which is a mass"):
        found.extreme("x", "3 kg")


@pytest.fixture(scope="module")
def elastic_spar():
    return fw.load("dtu10mw_spar_3_operating").compile()


def test_drag_that_settles_on_the_slow_modes_is_that_of_the_whole_model(elastic_spar, monkeypatch):
    names = ["pitch", "heave", "rotor_speed", "tower_base_moment", "upwind_tension"]
    slow = fw.response(elastic_spar, outputs=names, tolerance=1e-5)
    frequencies = slow.frequency
    of_slow = fw.response(elastic_spar, outputs=names, tolerance=1e-5, frequencies=frequencies)
    monkeypatch.setattr(ExcitedModel, "slow", lambda model, fastest: model)
    whole = fw.response(elastic_spar, outputs=names, tolerance=1e-8, frequencies=frequencies)
    for name in names:
        assert of_slow.std(name) == pytest.approx(whole.std(name), rel=1e-6)


def test_a_state_does_not_tell_which_one_came_before_it(elastic_spar):
    def found(height):
        return fw.response(elastic_spar, outputs=["pitch", "heave"], parameters={"sea.significant_wave_height": height})

    first, _, again = found(3.0), found(9.0), found(3.0)
    assert again.frequency == pytest.approx(first.frequency, rel=0.01)
    for name in ("pitch", "heave"):
        assert again.std(name) == pytest.approx(first.std(name), rel=2e-5)


def test_drag_settles_where_hardly_anything_else_damps():
    """In small weather a spar in operation is nearly unstable, and the gains of drag answer steeply to themselves."""
    plant = fw.load("oc3_spar_rigid").compile()
    weather = {"wind.mean_speed": 12.0, "wind.turbulence_intensity": 0.03, "sea.significant_wave_height": 3.0}
    found = fw.response(plant, outputs=["surge", "pitch"], parameters=weather)
    assert found.iterations < 40
    assert max(mode.eigenvalue.real for mode in found.linear.modes()) < 1e-9
