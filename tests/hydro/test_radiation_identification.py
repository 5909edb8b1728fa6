"""Radiation kernels and their state-space models: kernels known in closed form, and the OC3-Hywind spar."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import linalg

from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.radiation_identification import (
    hankel_singular_values,
    identify_radiation,
    kept_radiation,
)
from fowtlib.components.hydro.retardation import added_mass_from_kernel, retardation_kernel

OC3 = Path(__file__).parents[2] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc"
OMEGA = np.concatenate([np.linspace(0.02, 2.0, 100), np.linspace(2.05, 8.0, 80)])  # not uniform


@pytest.fixture(scope="module")
def spar():
    return HydrodynamicDatabase.read(OC3)


def resonators(omega, modes):
    """K(s) = sum r s / (s^2 + 2 z w s + w^2) and K(t): zero at s = 0, passive; modes: (r, w, z)."""
    s = 1j * np.asarray(omega, dtype=float)[:, None, None]
    return sum(np.atleast_2d(r) * s / (s**2 + 2 * z * w * s + w**2) for r, w, z in modes)


def resonator_kernel(time, modes):
    total = 0.0
    for r, w, z in modes:
        wd = w * np.sqrt(1 - z**2)
        shape = np.exp(-z * w * time) * (np.cos(wd * time) - z * w / wd * np.sin(wd * time))
        total = total + np.multiply.outer(shape, np.atleast_2d(r))
    return total


MODES = [(2.0e5, 0.9, 0.35), (0.8e5, 1.6, 0.25)]


def test_kernel_of_a_damping_known_in_closed_form():
    # B = exp(-omega^2) omega^2: K = 2/pi int = (1 - t^2/2) exp(-t^2/4) / (2 sqrt(pi))
    time = np.linspace(0.0, 12.0, 121)
    exact = (1 - time**2 / 2) * np.exp(-(time**2) / 4) / (2 * np.sqrt(np.pi))
    kernel = retardation_kernel(OMEGA, OMEGA**2 * np.exp(-(OMEGA**2)), time)
    np.testing.assert_allclose(kernel, exact, atol=2e-6 * exact[0])


def test_tail_above_the_data_follows_the_cube_of_the_frequency():
    # all of the damping above 5 rad/s is tail: B = 125 / omega^3 there, compared with brute force
    omega = np.linspace(0.01, 5.0, 500)
    time = np.array([0.0, 0.3, 1.0, 4.0])
    difference = retardation_kernel(omega, omega**0, time) - retardation_kernel(omega, omega**0, time, tail=False)
    u = np.linspace(5.0, 4000.0, 2_000_001)
    brute = [2 / np.pi * np.trapezoid(125 / u**3 * np.cos(u * t), u) for t in time]
    np.testing.assert_allclose(difference, brute, atol=1e-5)


def test_kernel_gives_back_the_added_mass():
    time = np.arange(0.0, 60.0, 0.05)
    excess = added_mass_from_kernel(time, resonator_kernel(time, MODES), OMEGA)
    exact = resonators(OMEGA, MODES).imag / OMEGA[:, None, None]
    np.testing.assert_allclose(excess, exact, atol=1e-5 * np.abs(exact).max())


def test_known_state_space_is_recovered():
    damping = resonators(OMEGA, MODES)
    model = identify_radiation(OMEGA, damping.real, damping.imag / OMEGA[:, None, None], np.zeros((1, 1)), order=4)
    time = np.linspace(0.0, 30.0, 301)
    exact = resonator_kernel(time, MODES)
    assert model.states == 4
    assert model.passive and model.stable
    np.testing.assert_allclose(model.kernel(time), exact, atol=0.01 * exact.max())
    wanted = np.sort([complex(-z * w, w * np.sqrt(1 - z**2)) for _, w, z in MODES][::-1])
    found = np.sort([pole for pole in linalg.eigvals(model.A) if pole.imag > 0])
    np.testing.assert_allclose(found, wanted, rtol=0.03)


@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-8, 1e-6])
def test_coupled_motions_share_states(noise):
    # one wave pattern moves both motions: rank-one residues, so that four states do for two motions
    direction = np.array([1.0, -0.6])
    modes = [(np.outer(direction, direction) * r, w, z) for r, w, z in MODES]
    damping = resonators(OMEGA, modes)
    uneven = 1 + noise * np.random.default_rng(0).standard_normal((OMEGA.size, 1, 1))
    model = identify_radiation(OMEGA, damping.real * uneven, order=2)
    assert model.states == 4
    assert min(entry.r2 for entry in model.entries) > 0.999
    time = np.linspace(0.0, 20.0, 50)
    kernel = model.kernel(time)
    np.testing.assert_allclose(kernel, kernel.transpose(0, 2, 1), atol=1e-3 * kernel.max())


def test_uncoupled_and_negligible_entries_are_left_out_and_named():
    damping = np.zeros((OMEGA.size, 6, 6))
    damping[:, [0, 4, 2], [0, 4, 2]] = resonators(OMEGA, MODES).real[:, 0]
    damping[:, 0, 4] = damping[:, 4, 0] = 0.5 * damping[:, 0, 0]
    damping[:, 0, 2] = damping[:, 2, 0] = 0.005 * damping[:, 0, 0]
    damping[:, 1, 1] = 1e-6 * damping[:, 0, 0]
    model = identify_radiation(OMEGA, damping, order=3)
    assert [group.motions for group in model.groups] == [(0, 4), (2,)]
    assert {(entry.i, entry.j) for entry in model.entries} == {(0, 0), (0, 4), (2, 2), (4, 4)}
    assert {(0, 2), (1, 1), (5, 5)} <= set(model.skipped)
    assert "left out: K12, K13" in str(model)
    assert not model.B[:, 1].any() and not model.C[5].any()


def test_no_radiation_at_all_gives_a_model_without_states():
    model = identify_radiation(OMEGA, np.zeros((OMEGA.size, 6, 6)))
    assert model.states == 0 and model.B.shape == (0, 6) and model.C.shape == (6, 0)
    assert not model.kernel([0.0, 1.0]).any()


def test_mistakes_are_explained():
    with pytest.raises(HydrodynamicDataError, match="order is 1; a motion needs two states at least"):
        identify_radiation(OMEGA, np.ones((OMEGA.size, 6, 6)), order=1)
    with pytest.raises(HydrodynamicDataError, match=r"damping has the shape \(5, 6\)"):
        identify_radiation(OMEGA, np.ones((5, 6)))
    with pytest.raises(HydrodynamicDataError, match="the frequencies are too few"):
        identify_radiation([0.5, 1.0, 1.5], np.ones((3, 1, 1)))


# --- OC3-Hywind -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order, r2, damping", [(2, 0.96, 0.20), (4, 0.994, 0.08), (6, 0.9998, 0.012)])
def test_oc3_fit(spar, order, r2, damping):
    model = identify_radiation(spar.omega, spar.B, spar.A, spar.A_inf, order=order)
    assert model.states == 5 * order  # surge-pitch, sway-roll, heave; yaw makes no waves
    assert model.stable
    assert model.passive
    assert min(entry.r2 for entry in model.entries) > r2
    assert max(entry.damping_error for entry in model.entries) < damping
    assert max(entry.consistency for entry in model.entries) < 0.01  # B, A and A_inf of the data agree
    no_load = model.C @ np.linalg.solve(model.A, model.B)
    assert np.abs(no_load).max() < 1e-9 * spar.B.max()
    assert (5, 5) in model.skipped


def test_oc3_model_in_frequency_domain(spar):
    model = identify_radiation(spar.omega, spar.B, spar.A, spar.A_inf, order=6)
    response = model.transfer(spar.omega)
    added_mass = spar.A_inf + response.imag / spar.omega[:, None, None]
    for i, j in ((0, 0), (2, 2), (4, 4), (0, 4)):
        np.testing.assert_allclose(response.real[:, i, j], spar.B[:, i, j], atol=0.02 * np.abs(spar.B[:, i, j]).max())
        np.testing.assert_allclose(added_mass[:, i, j], spar.A[:, i, j], rtol=0.005)
    low = np.abs(spar.omega - 0.05).argmin()
    np.testing.assert_allclose(added_mass[low, 0, 0], spar.A_zero[0, 0], rtol=0.002)


def test_without_the_condition_of_passivity_the_fit_is_closer_but_not_passive(spar):
    free = identify_radiation(spar.omega, spar.B, spar.A, spar.A_inf, order=4, passive=False)
    bound = identify_radiation(spar.omega, spar.B, spar.A, spar.A_inf, order=4)
    assert not free.passive and bound.passive
    assert all(f.r2 >= b.r2 - 1e-4 for f, b in zip(free.entries, bound.entries, strict=True))


def test_oc3_share_of_the_kernel_in_two_states(spar):
    """El Beshbichi (2023) finds that two states hold 77.5 % of K11; so we do if B ends at 3 rad/s without a tail."""
    time = 0.2 * np.arange(301)
    values = hankel_singular_values(retardation_kernel(spar.omega, spar.B[:, 0, 0], time))
    assert values[:2].sum() / values.sum() == pytest.approx(0.947, abs=0.005)
    assert (values[:2] ** 2).sum() / (values**2).sum() > 0.997
    below = spar.omega < 3.001
    values = hankel_singular_values(retardation_kernel(spar.omega[below], spar.B[below, 0, 0], time, tail=False))
    assert values[:2].sum() / values.sum() == pytest.approx(0.775, abs=0.01)


def test_oc3_kernel_at_time_zero_is_the_integral_of_the_damping(spar):
    kernel = retardation_kernel(spar.omega, spar.B[:, 0, 0], [0.0])
    integral = np.trapezoid(spar.B[:, 0, 0], spar.omega) + spar.B[-1, 0, 0] * spar.omega[-1] / 2
    assert kernel[0] == pytest.approx(2 / np.pi * integral, rel=2e-3)


def test_a_kept_model_is_the_identified_one_to_the_last_digit(spar, tmp_path, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path))
    arrays = spar.omega, spar.B, spar.A, spar.A_inf
    fresh = identify_radiation(*arrays, order=3)
    models = [kept_radiation(*arrays, order=3, passive=True) for _ in range(2)]
    assert len(list(tmp_path.iterdir())) == 1
    for model in models:
        for name in "ABC":
            assert np.array_equal(getattr(model, name), getattr(fresh, name))
        assert str(model) == str(fresh) and model.entries == fresh.entries and model.skipped == fresh.skipped
        assert all(np.array_equal(a.hankel, b.hankel) for a, b in zip(model.groups, fresh.groups, strict=True))
    kept_radiation(*arrays, order=2, passive=True)
    kept_radiation(spar.omega, spar.B * (1 + 1e-15), *arrays[2:], order=3, passive=True)
    assert len(list(tmp_path.iterdir())) == 3
    none = kept_radiation(spar.omega, 0 * spar.B, *arrays[2:], order=3, passive=True)
    assert (none.A.shape, none.B.shape, none.C.shape) == ((0, 0), (0, 6), (6, 0))
