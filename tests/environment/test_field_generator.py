"""Generated wind fields against the spectra, the coherence and the shear that were asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch

from fowtlib.components.environment import field_generator
from fowtlib.components.environment.field_generator import generate_field
from fowtlib.components.environment.field_spectra import PlaneCoherence, band_variance, spectra
from fowtlib.components.environment.iec import normal_turbulence
from fowtlib.components.environment.turbulence import coherence, kaimal
from fowtlib.language import ModelError

V = 12.0
SIGMA = normal_turbulence(V)
SMALL = {"mean_speed": V, "width": 60, "height": 45, "columns": 5, "rows": 4, "duration": 128, "time_step": 0.125}
SEEDS = 12


@pytest.fixture(scope="module")
def fields(tmp_path_factory):
    """Speeds (seeds, steps, rows, columns, 3), once for each spectrum and with coherence of v and w for von Karman."""
    folder = tmp_path_factory.mktemp("fields")

    def speeds(seed, **options):
        field = generate_field(folder / "field.bts", seed=seed, **SMALL, **options)
        return field.speeds(field.plane)

    return {
        "kaimal": np.stack([speeds(seed) for seed in range(SEEDS)]),
        "von_karman": np.stack([speeds(s, spectrum="von_karman", lateral_coherence="iec") for s in range(SEEDS)]),
    }


def density(values, step):
    """Periodogram of the whole period along the steps, and its frequencies."""
    steps = values.shape[1]
    amplitude = np.fft.rfft(values, axis=1)[:, 1 : (steps - 1) // 2 + 1]
    return np.arange(1, (steps - 1) // 2 + 1) / (steps * step), 2 * step / steps * np.abs(amplitude) ** 2


# --- the targets


@pytest.mark.parametrize("model", ["kaimal", "von_karman"])
def test_each_spectrum_holds_its_variance(model):
    wanted = SIGMA**2 * np.array([1, 0.64, 0.25] if model == "kaimal" else [1, 1, 1])
    for i in range(3):
        parts = [(1e-9, 1e-3), (1e-3, 0.1), (0.1, 10), (10, 1e3), (1e3, 1e6)]
        total = sum(quad(lambda f, i=i: spectra(f, V, SIGMA, model=model)[i], *part, limit=400)[0] for part in parts)
        assert total == pytest.approx(wanted[i], rel=5e-3)


def test_values_by_hand():
    assert spectra(0.1, 11.4, 2.0)[0] == pytest.approx(float(kaimal(0.1, 11.4, 2.0)), rel=1e-14)
    # w of Kaimal: sigma 1, L = 27.72 m; L/V = 2.43158 s: 9.72632 / 2.458947^(5/3)
    assert spectra(0.1, 11.4, 2.0)[2] == pytest.approx(9.72632 / 2.458947 ** (5 / 3), rel=1e-5)
    # von Karman at x = fL/V = 1 (L = 147 m): the constants usually printed are 70.8 and 188.8
    S = spectra(V / 147, V, 1.0, model="von_karman")
    assert S[0] == pytest.approx(4 * 147 / V / 71.8 ** (5 / 6), rel=1e-3)
    assert S[1] == S[2] == pytest.approx(2 * 147 / V * 189.8 / 71.8 ** (11 / 6), rel=1e-3)


def test_isotropy_of_von_karman():
    """S_v = (S_u - f dS_u/df) / 2 in isotropic turbulence."""
    f, h = np.geomspace(0.005, 5, 20), 1e-5
    along = [spectra(f * (1 + s * h), V, SIGMA, model="von_karman")[:, 0] for s in (-1, 0, 1)]
    slope = (along[2] - along[0]) / (2 * h)
    np.testing.assert_allclose(spectra(f, V, SIGMA, model="von_karman")[:, 1], (along[1] - slope) / 2, rtol=1e-7)


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (4, 1), (4, 5), (5, 4), (7, 9)])
def test_factors_of_the_coherence_matrix(shape):
    rows, columns = shape
    n = rows * columns
    frequency = np.array([1e-3, 0.02, 0.2])
    plane = PlaneCoherence(rows, columns, 15, 12, V, 90)
    factor = plane.apply(frequency, np.broadcast_to(np.eye(n), (3, n, n)).astype(complex))
    z, y = (side.ravel() for side in np.meshgrid(15 * np.arange(rows), 12 * np.arange(columns), indexing="ij"))
    distance = np.hypot(z[:, None] - z, y[:, None] - y)
    wanted = coherence(frequency[:, None, None], distance, V)
    np.testing.assert_allclose(factor @ factor.swapaxes(1, 2), wanted, atol=1e-13)


# --- the fields


@pytest.mark.parametrize("model", ["kaimal", "von_karman"])
def test_spectra(fields, model):
    """Mean over points, seeds and a band of harmonics.

    A harmonic of one point and seed scatters by its mean at most (amplitudes between fixed and Gaussian), and points
    that move together do not average it: the mean over a band scatters by at most 1/sqrt(seeds x harmonics).
    """
    frequency, found = density(fields[model], 0.125)
    found = found.mean(axis=(0, 2, 3))
    edges = [0, 4, 16, 64, 256, len(frequency)]
    wanted = band_variance(len(frequency), 128.0, V, SIGMA, 90.0, model=model) * 128.0
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        ratio = found[low:high].sum(axis=0) / wanted[low:high].sum(axis=0)
        np.testing.assert_allclose(ratio, 1, atol=4 / math.sqrt(SEEDS * (high - low)), err_msg=f"{low}-{high}")


def test_welch_spectrum_of_points_that_are_independent(fields):
    """Of v and w every harmonic has its exact energy, so Welch differs by leakage and little scatter."""
    values = fields["kaimal"][..., 1:]
    frequency, found = welch(values, fs=8, nperseg=256, axis=1)
    found = found.mean(axis=(0, 2, 3))[8:100]
    np.testing.assert_allclose(found / spectra(frequency[8:100], V, SIGMA)[:, 1:], 1, atol=0.1)


def test_harmonics_of_independent_points_are_exact(fields):
    frequency, found = density(fields["kaimal"][:2], 0.125)
    wanted = band_variance(len(frequency), 128.0, V, SIGMA, 90.0) * 128.0
    quantum = np.ptp(fields["kaimal"], axis=(0, 1, 2, 3)) / 65535
    noise = 20 * np.sqrt(wanted * quantum**2 * 0.125 / 6)  # cross term with the white noise of the quantisation
    for i in (1, 2):
        error = np.abs(found[..., i] - wanted[None, :, None, None, i])
        assert np.all(error <= 1e-4 * wanted[None, :, None, None, i] + noise[None, :, None, None, i])


def test_variance_is_that_of_the_spectrum_that_a_field_holds(fields):
    for model in ("kaimal", "von_karman"):
        wanted = band_variance(511, 128.0, V, SIGMA, 90.0, model=model).sum(axis=0)
        found = fields[model].var(axis=1).mean(axis=(0, 1, 2))
        np.testing.assert_allclose(found, wanted, rtol=4 / math.sqrt(SEEDS * 10))
        assert np.all(wanted < 1.01 * SIGMA**2)


@pytest.mark.parametrize(("dy", "dz"), [(1, 0), (3, 2)])
def test_coherence(fields, dy, dz):
    """That of IEC for u; for v and w if asked for. Scatter of the mean: at most 1/sqrt(seeds x harmonics)."""
    distance = math.hypot(15 * dy, 15 * dz)
    for model, lateral in (("kaimal", False), ("von_karman", True)):
        amplitude = np.fft.rfft(fields[model], axis=1)[:, 1:512]
        cross = amplitude[:, :, dz:, dy:] * amplitude[:, :, : 4 - dz, : 5 - dy].conj()
        power = np.mean(np.abs(amplitude) ** 2, axis=(0, 2, 3))
        found = cross.real.mean(axis=(0, 2, 3)) / power
        target = coherence(np.arange(1, 512) / 128, distance, V)
        for low, high in ((0, 4), (4, 16), (16, 64), (200, 500)):
            tolerance = 4 / math.sqrt(SEEDS * (high - low))
            wanted = np.array([1, lateral, lateral]) * target[low:high].mean()
            np.testing.assert_allclose(found[low:high].mean(axis=0), wanted, atol=tolerance)


def test_shear_is_the_mean_over_the_period(fields):
    mean = fields["kaimal"].mean(axis=1)
    z = 90 + np.array([-22.5, -7.5, 7.5, 22.5])
    np.testing.assert_allclose(mean[..., 0], np.broadcast_to((V * (z / 90) ** 0.2)[:, None], (SEEDS, 4, 5)), atol=1e-4)
    np.testing.assert_allclose(mean[..., 1:], 0, atol=1e-4)


def test_seeds(tmp_path, monkeypatch):
    paths = [tmp_path / f"{i}.bts" for i in range(3)]
    generate_field(paths[0], seed=5, **SMALL)
    generate_field(paths[1], seed=6, **SMALL)
    monkeypatch.setattr(field_generator, "BLOCK", 20_000)  # blocks of one point and one harmonic give the same field
    monkeypatch.setattr(field_generator, "KEPT", 0)  # and series that are made twice
    generate_field(paths[2], seed=5, **SMALL)
    stored = [field_generator.read_field(path).stored.astype(int) for path in paths]
    assert np.abs(stored[0] - stored[2]).max() <= 1  # rounding of the sums
    assert np.abs(stored[0] - stored[1]).max() > 1000


def test_a_seed_is_one_field_for_ever(tmp_path):
    """Speeds of the first version that had seeds; a field that is made again is the one of the results that exist."""
    field = generate_field(tmp_path / "a.bts", seed=5, lateral_coherence="iec", **SMALL)
    found = field.speeds(field.plane)[[0, 100, 700], [0, 2, 3], [0, 4, 2]]
    wanted = [[11.6754, -1.3470, 0.2329], [11.4305, -2.8142, 0.0357], [15.1626, -2.5099, -0.0708]]
    np.testing.assert_allclose(found, wanted, atol=5e-4)


def test_class_or_intensity(tmp_path):
    for options, sigma in (
        ({"turbulence_class": "A"}, normal_turbulence(V, "A")),
        ({"turbulence_intensity": 0.1}, 1.2),
    ):
        field = generate_field(tmp_path / "a.bts", **SMALL, **options)
        wanted = band_variance(511, 128.0, V, sigma, 90.0).sum(axis=0)
        np.testing.assert_allclose(field.speeds(field.plane)[..., 2].var(axis=0), wanted[2], rtol=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mean_speed": 0}, "mean_speed = 0 m/s, turbulence needs a positive one."),
        ({"height": 200}, "the lowest row is at -10 m, where the power law has no wind; give a smaller height, or the"),
        ({"columns": 0}, "0 x 4 points, expected 1 to 20000."),
        ({"columns": 400, "rows": 400}, "400 x 400 points, expected 1 to 20000."),
        ({"width": 0}, "width and height of the grid must be positive."),
        ({"duration": 1}, "8 time steps of 0.125 s, expected 16 or more."),
        ({"turbulence_class": "D"}, "turbulence_class 'D' is not one of A+, A, B, C."),
        ({"seed": -1}, "seed and turbulence_intensity begin at 0."),
        ({"lateral_coherence": "all"}, "lateral_coherence 'all' is not one of none, iec."),
    ],
)
def test_mistakes(tmp_path, change, message):
    with pytest.raises(ModelError) as error:
        generate_field(tmp_path / "a.bts", **{**SMALL, **change})
    assert str(error.value).startswith(f"{tmp_path}/a.bts: cannot generate the wind field: {message}")


def test_a_spectrum_that_does_not_exist(tmp_path):
    with pytest.raises(ModelError, match="there is no spectrum 'mann'; the spectra are kaimal, von_karman"):
        generate_field(tmp_path / "a.bts", **SMALL, spectrum="mann")


def test_a_field_appears_when_it_is_complete(tmp_path):
    """Progress from 0 towards 1, and a generation that is stopped leaves what was there."""
    path, told = tmp_path / "a.bts", []
    generate_field(path, **SMALL, progress=lambda done, total: told.append(done / total))
    assert told == sorted(told)
    assert told[0] == 0
    assert told[-1] < 1
    before = path.read_bytes()

    def stop(done, total):
        if done > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        generate_field(path, **SMALL, seed=2, progress=stop)
    assert path.read_bytes() == before
    assert [item.name for item in tmp_path.iterdir()] == ["a.bts"]
    with pytest.raises(ModelError, match=r"none.a.bts: cannot be written: No such file or directory"):
        generate_field(tmp_path / "none" / "a.bts", **SMALL)
