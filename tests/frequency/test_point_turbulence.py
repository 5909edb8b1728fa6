"""Wind across a turning rotor: the spectra of its parts beside blades that turn through generated fields."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.components.environment import generate_field
from fowtlib.components.environment.disc_turbulence import places_density
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_spectra import spectra
from fowtlib.components.environment.point_turbulence import PointGrid, point_density
from fowtlib.components.environment.turbulence import PlaneCoherence
from fowtlib.language.errors import ParameterError
from fowtlib.language.run_time import RestingPlaces, TurningRings

SPEED, SIGMA, HUB = 12.0, 2.0, 90.0
SIZES = {"width": 140.0, "height": 140.0, "columns": 15, "rows": 15, "duration": 400.0, "time_step": 0.1,
         "hub_height": HUB, "bottom": 20.0}  # fmt: skip
GRID = PointGrid(-70.0, 20.0, 10.0, 10.0, 15, 15)
ROTOR_SPEED = 2 * np.pi * 0.2  # so that 0.2 Hz and 0.6 Hz are once and three times a turn
RINGS = TurningRings(np.array([0.0, 3.0, 92.0]), np.array([25.0, 60.0]), ROTOR_SPEED, 3, orders=2)
SEEDS = 6


def at_a_point(part):
    return lambda omega: spectra(omega / (2 * np.pi), SPEED, SIGMA, HUB)[..., part] / (2 * np.pi)


def law(coherence, part, omega, places, basis=None):
    if coherence == "none":
        return point_density(omega, places, at_a_point(part), GRID, basis)
    return places_density(omega, places, at_a_point(part), PlaneCoherence(SPEED, HUB))


def channels(field, rings):
    """g_0, 2 Re g_1, -2 Im g_1, 2 Re g_2, -2 Im g_2 of each ring from blades in a field: v, w (2, steps, 10)."""
    time = 0.1 * np.arange(4000)
    psi = rings.speed * time[:, None] + 2 * np.pi * np.arange(3) / 3
    across = rings.centre[1:] + np.stack([np.cos(psi), np.sin(psi)], axis=-1)[:, :, None] * rings.radii[:, None]
    points = np.concatenate([np.zeros((*across.shape[:-1], 1)), across], axis=-1).reshape(-1, 3)
    speeds = FieldLookup(field).velocity(points, np.repeat(time, 6))[:, 1:].reshape(*across.shape[:-1], 2)
    waves = [np.ones_like(psi), *(2 * turn(p * psi) for p in (1, 2) for turn in (np.cos, np.sin))]
    return np.concatenate([np.einsum("tbrk,tb->ktr", speeds, wave) / 3 for wave in waves], axis=2)


@pytest.fixture(scope="module", params=["none", pytest.param("iec", marks=pytest.mark.long)])
def measured(request, tmp_path_factory):
    """Cross spectra per rad/s of v and w (2, q, 10, 10), mean of the seeds, and of which coherence."""
    folder, total = tmp_path_factory.mktemp("fields"), 0.0
    for seed in range(SEEDS):
        field = generate_field(folder / f"{seed}.bts", mean_speed=SPEED, turbulence_intensity=SIGMA / SPEED, seed=seed,
                               lateral_coherence=request.param, **SIZES)  # fmt: skip
        lines = np.fft.rfft(channels(field, RINGS), axis=1)[:, 1:] / 4000
        total = total + lines[..., :, None] * lines[..., None, :].conj() / SEEDS
    return request.param, total * 2 * 400.0 / (2 * np.pi)


def test_parts_of_the_wind_across_have_the_spectra_of_blades_in_a_field(measured):
    """Variances and what they have in common in bands about 0P, 1P, 3P and 6P, within what the seeds tell; v and w."""
    coherence, found = measured
    omega = 2 * np.pi * np.arange(1, 2001) / 400.0
    # between points 10 m apart a field with the coherence of u loses of the small eddies: of 5 m half as much
    bands = {"none": [(0.005, 0.05), (0.15, 0.25), (0.5, 0.7), (1.0, 1.4)], "iec": [(0.005, 0.05), (0.15, 0.25)]}
    for part in (1, 2):
        expected = law(coherence, part, omega, [RINGS])
        for low, high in bands[coherence]:
            band = (omega > 2 * np.pi * low) & (omega < 2 * np.pi * high)
            have, want = found[part - 1][band].mean(axis=0), expected[band].mean(axis=0)
            sizes, few = np.sqrt(np.diag(want).real), 1 / np.sqrt(SEEDS * band.sum())
            slow = 1 - (2 + np.cos(0.1 * np.pi * (low + high))) / 3  # what is lost between two steps of time
            assert np.diag(have).real == pytest.approx(np.diag(want).real, rel=4.5 * few + slow), (part, low)
            off = (have - want) / np.outer(sizes, sizes)
            assert np.abs(off - np.diag(np.diag(off))).max() < 5 * few, (part, low)


def test_what_goes_round_twice_is_the_other_way_round_once_three_turns_further_on():
    # three blades cannot tell them: g_2 = exp(-3 i Omega t) g_-1
    omega = np.linspace(0.2, 3.0, 15)
    twice, once = _one(omega, 2), _one(omega + 3 * ROTOR_SPEED, -1)
    assert twice == pytest.approx(once, rel=1e-2)  # but for orders beyond 11
    assert not np.allclose(twice, _one(omega + 3 * ROTOR_SPEED, 1), rtol=0.1)


def _one(omega, p):
    """Spectrum of g_p of the outer ring, from the channels a = g_p + g_-p and b = i (g_p - g_-p): of a - i b."""
    S = point_density(omega, [RINGS], at_a_point(1), GRID)
    even, odd = 4 * abs(p) - 1, 4 * abs(p) + 1
    return ((S[:, even, even] + S[:, odd, odd]).real - 2 * np.sign(p) * S[:, even, odd].imag) / 4


def test_a_place_between_the_points_has_the_weights_of_the_interpolation(tmp_path):
    at_point, in_the_middle = [0.0, 10.0, 100.0], [0.0, 15.0, 105.0]
    S = point_density([1.0], [RestingPlaces(np.array([at_point, in_the_middle]))], at_a_point(1), GRID)[0].real
    alone = at_a_point(1)(np.array([1.0]))[0]
    assert S / alone == pytest.approx(np.array([[1.0, 0.25], [0.25, 0.25]]))


@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_weights_are_those_of_the_look_up(tmp_path, interpolation):
    field = generate_field(tmp_path / "a.bts", mean_speed=SPEED, seed=3, **{**SIZES, "duration": 10.0})
    rng = np.random.default_rng(0)
    places = np.column_stack([np.zeros(30), rng.uniform(-75, 75, 30), rng.uniform(15, 165, 30)])  # some beyond the edge
    grid = PointGrid(-70.0, 20.0, 10.0, 10.0, 15, 15, interpolation)
    wanted = FieldLookup(field, interpolation=interpolation).evaluate(places, np.zeros(30))[0][:, 1]
    points = field.speeds(field.plane[0])[..., 1].ravel()
    assert grid.weights(places[:, 1:]) @ points == pytest.approx(wanted, abs=1e-9)


def test_sums_of_channels_have_the_spectra_of_these():
    rng, omega = np.random.default_rng(1), np.array([0.3, 4.0])
    places = [RINGS, RestingPlaces(np.array([[0.0, 0.0, 50.0], [0.0, 3.0, 117.0]]))]
    basis = rng.normal(size=(12, 3))
    whole = point_density(omega, places, at_a_point(2), GRID)
    assert point_density(omega, places, at_a_point(2), GRID, basis) == pytest.approx(basis.T @ whole @ basis)
    assert np.abs(whole - whole.conj().transpose(0, 2, 1)).max() < 1e-15 + 1e-12 * np.abs(whole).max()
    assert np.linalg.eigvalsh(whole).min() > -1e-9 * np.abs(whole).max()
    assert np.abs(whole[0, 0, 11]) > 0  # a place on the inner ring


def test_components_that_do_not_fluctuate(tmp_path):
    given = {**SIZES, "duration": 20.0, "mean_speed": SPEED, "seed": 4}
    whole = generate_field(tmp_path / "uvw.bts", **given)
    alone = generate_field(tmp_path / "u.bts", components="u", **given)
    one, other = (field.speeds(field.plane) for field in (whole, alone))
    assert np.array_equal(one[..., 0], other[..., 0])
    assert np.ptp(one[..., 1]) > 1 and np.abs(other[..., 1:]).max() < 1e-6
    with pytest.raises(ParameterError, match="components 'vw' is not one of uvw, uv, uw, u"):
        generate_field(tmp_path / "vw.bts", components="vw", **given)
