"""A start in the stationary state: exact for what is linear, and nearer than the mean for a turbine."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import JonswapSea, Sea, World
from fowtlib.components.environment.field_file import FieldGrid, write_field
from fowtlib.language import Component, Scalar, Series, assign, der, eq, outer, param, sampled, var
from fowtlib.language.errors import SimulationError
from fowtlib.solving import starts
from fowtlib.solving.starts import start_values
from fowtlib.solving.stationary import harmonics, slow_modes
from fowtlib.solving.turning import turns_of


class Buoy(Component):
    """A damped oscillator, 20 s and 5 % of critical, that the elevation of the sea pushes."""

    stiffness: Scalar = param(default=0.09869604, unit="1/s^2", doc="stiffness over mass")
    damping: Scalar = param(default=0.0314159, unit="1/s", doc="damping over mass")
    sea: Sea = outer(Sea)
    x: Scalar = var(unit="m", start=3.0, fixed=True, state="prefer", doc="position")
    v: Scalar = var(unit="m/s", start=0, fixed=True, state="prefer", doc="speed")

    def equations(self):
        push = 0.05 * self.sea.elevation
        return [eq(der(self.x), self.v), eq(der(self.v), push - self.damping * self.v - self.stiffness * self.x)]


def floating(part=None, **sea):
    top = fw.Assembly("buoy")
    top.world, top.buoy = World(), part or Buoy()
    top.sea = JonswapSea(significant_wave_height=4, peak_period=12, repetition_period=600, **sea)
    return fw.load(top).compile()


@pytest.fixture(scope="module")
def buoy():
    return floating()


@pytest.fixture(scope="module")
def spar():
    return fw.load("oc3_spar_rigid").compile()


@pytest.mark.parametrize("seed", [1, 2])
def test_a_linear_model_has_no_transient_at_all(buoy, seed):
    """What the oscillator does at once is what it does one period of the sea later."""
    run = buoy.simulate(700.0, 0.5, start="stationary", parameters={"sea.seed": seed}, tolerance=1e-9)
    x, v = run["buoy.x"].values, run["buoy.v"].values
    np.testing.assert_allclose(x[:200], x[1200:1400], atol=2e-5 * np.abs(x).max())
    np.testing.assert_allclose(v[:200], v[1200:1400], atol=2e-5 * np.abs(v).max())
    rest = buoy.simulate(700.0, 0.5, start="turning", parameters={"sea.seed": seed})["buoy.x"].values
    assert np.abs(rest[:40] - rest[1200:1240]).max() > 0.1 * np.abs(rest).max()


def test_over_the_seeds_it_has_the_covariance_of_the_spectrum(buoy):
    """Integral of |H|^2 S over the frequencies, against 250 seeds: 1/sqrt(2 x 250) is 4.5 %."""
    found = [start_values(buoy, "stationary", {"sea.seed": seed})[0] for seed in range(250)]
    x, v = (np.array([values[path] for values in found]) for path in ("buoy.x", "buoy.v"))
    omega = np.linspace(0.05, 3, 20000)
    part = buoy.root.buoy
    H = 0.05 / (part.stiffness - omega**2 + 1j * omega * part.damping)
    S = buoy.root.sea.spectral_density(omega) * np.abs(H) ** 2
    assert x.std() == pytest.approx(np.sqrt(np.trapezoid(S, omega)), rel=0.15)
    assert v.std() == pytest.approx(np.sqrt(np.trapezoid(S * omega**2, omega)), rel=0.15)
    assert abs(np.corrcoef(x, v)[0, 1]) < 0.2 and abs(x.mean()) < 0.2 * x.std()


def test_waves_that_grow_from_nothing_have_no_past(buoy):
    values, whence = start_values(buoy, "stationary", {"sea.build_up": 30})
    assert abs(values["buoy.x"]) < 1e-9 and whence == "from the stationary state about the mean position"
    regular = {"sea.spectrum": "regular", "sea.wave_height": 2, "sea.wave_period": 9}
    moved = buoy.simulate(27.0, 0.25, start="stationary", parameters=regular, tolerance=1e-9)["buoy.x"].values
    np.testing.assert_allclose(moved[:37], moved[72:], atol=1e-5)
    np.testing.assert_allclose(moved[:37], moved[36:73], atol=1e-5)


def test_without_anything_that_drives_it_is_the_mean():
    class Hanging(Component):
        """A mass on a spring."""

        x: Scalar = var(unit="m", start=0.1, state="prefer", doc="position")
        v: Scalar = var(unit="m/s", start=0.3, state="prefer", doc="speed")

        def equations(self):
            return [eq(der(self.x), self.v), eq(der(self.v), 1.0 - 4 * self.x - self.v)]

    values, _ = start_values(fw.load(Hanging()).compile(), "stationary")
    assert values["x"] == pytest.approx(0.25) and values["v"] == pytest.approx(0, abs=1e-9)


class Rising(Buoy):
    """The same, thrown out by its damping."""

    damping: Scalar = param(default=-0.02, unit="1/s", doc="damping over mass")


class Held(Buoy):
    """The same, with a controller that samples."""

    push: Scalar = var(unit="m/s^2", start=0.0, discrete=True, doc="of the controller")

    def equations(self):
        return [*super().equations(), sampled(0.5, assign(self.push, -0.1 * self.v))]


def test_what_has_no_stationary_state(buoy):
    with pytest.warns(UserWarning, match=r"leaves a motion of buoy.x, with a period of 20 s, at its mean: .* grows"):
        values, _ = start_values(floating(Rising()), "stationary")
    assert abs(values["buoy.x"]) < 1e-9
    with pytest.raises(SimulationError, match="no stationary start: buoy.* is sampled"):
        start_values(floating(Held()), "stationary")


@pytest.mark.parametrize("interpolation", ["cubic", "linear", "monotone"])
def test_the_harmonics_of_a_series(interpolation):
    t = 0.5 * np.arange(40)
    values = 3 + np.outer(np.cos(2 * np.pi * t / 20 + 0.4), [1.0, 0.0]) + np.outer(np.sin(2 * np.pi * t / 5), [0, 2.0])
    omega, amplitude = harmonics(Series.samples(values, 0.5, periodic=True, interpolation=interpolation))
    large = np.abs(amplitude) > 1e-9
    assert np.argwhere(large).tolist() == [[0, 0], [3, 1]]
    assert omega[[0, 3]] == pytest.approx([2 * np.pi / 20, 2 * np.pi / 5])
    assert amplitude[0, 0] == pytest.approx(np.exp(0.4j)) and amplitude[3, 1] == pytest.approx(-2j)
    assert not len(harmonics(Series.samples(values, 0.5))[0]) and not len(harmonics(Series.constant([1.0]))[0])


@pytest.mark.filterwarnings("ignore:.*repeats itself")
@pytest.mark.parametrize(("intensity", "height", "left"), [(0.002, 0.02, 0.02), (0.15, 3.0, 0.55)])
def test_a_turbine_starts_where_it_would_be(spar, intensity, height, left):
    """Motions at once and three periods later: the same under little wind and waves, and else nearer than the mean."""
    parameters = {"wind.kind": "kaimal", "wind.mean_speed": 18.0, "wind.repetition_period": 600.0, "wind.seed": 2,
                  "wind.turbulence_intensity": intensity, "sea.spectrum": "jonswap", "sea.peak_period": 10.0,
                  "sea.significant_wave_height": height, "sea.repetition_period": 600.0, "sea.seed": 2}  # fmt: skip
    long = spar.simulate(1900, 0.5, solver="fixed", start="stationary", parameters=parameters)
    short = spar.simulate(100, 0.5, solver="fixed", start="turning", parameters=parameters)
    for name in ("surge", "roll", "pitch", "rotor_speed", "blade_pitch"):
        settled = long[name].values[3600:3801]
        gained = np.abs(long[name].values[:201] - settled).mean() / np.abs(short[name].values - settled).mean()
        assert gained < left, (name, gained)


def test_in_a_field_each_rotor_counts_its_own_disk(spar):
    """The same in a field, of which a rotor of coefficients feels the wind at the hub."""
    wind = {"kind": "turbulence", "mean_speed": 18.0, "repetition_period": 300.0, "seed": 3, "point_spacing": 10.0,
            "sample_step": 0.2, "turbulence_intensity": 0.03}  # fmt: skip
    parameters = {f"wind.{name}": value for name, value in wind.items()} | {"sea.spectrum": "still"}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*repeats itself")
        long = spar.simulate(1000, 0.5, solver="fixed", start="stationary", parameters=parameters)
        short = spar.simulate(100, 0.5, solver="fixed", start="turning", parameters=parameters)
    for name in ("surge", "pitch", "rotor_speed", "blade_pitch"):
        settled = long[name].values[1800:2001]
        gained = np.abs(long[name].values[:201] - settled).mean() / np.abs(short[name].values - settled).mean()
        assert gained < 0.35, (name, gained)
    made = spar.binding(parameters).root.find("wind")
    (series,) = made.before_the_run().values()
    hub = made.lookup().velocity([[0.0, 0.0, 90.0]] * 5, np.arange(5.0) * 0.2)[:, 0]
    np.testing.assert_allclose(np.diff(series(np.arange(5.0) * 0.2)[:, 1]), np.diff(hub), atol=1e-9)


def test_what_has_no_past_is_said(spar, tmp_path):
    """A record of wind and a field that ends; the start is that of steady wind."""
    np.savetxt(tmp_path / "wind.csv", np.c_[np.arange(0, 60.0), 17 + np.sin(np.arange(60.0))], "%.6f", ",")
    grid = FieldGrid(rows=6, columns=6, steps=300, dz=30.0, dy=30.0, dt=0.2, speed=17.0, hub_height=90.0, bottom=15.0,
                     periodic=False)  # fmt: skip
    speeds = np.random.default_rng(1).normal((17, 0, 0), 0.5, (300, 6, 6, 3))
    write_field(tmp_path / "wind.bts", grid, speeds)
    for kind, file in (("file", "wind.csv"), ("field", "wind.bts")):
        given = {"wind.kind": kind, "wind.file": str(tmp_path / file), "sea.spectrum": "still"}
        with pytest.warns(UserWarning, match="the start takes wind as steady before the run"):
            moved = start_values(spar, "stationary", given)[0]
        mean = start_values(spar, "turning", given)[0]
        assert moved["platform.motion.surge"] == pytest.approx(mean["platform.motion.surge"], abs=1e-9)


NEAR_RATED = {"wind.kind": "kaimal", "wind.mean_speed": 12.0, "sea.spectrum": "jonswap",
              "sea.significant_wave_height": 4, "sea.peak_period": 10}  # fmt: skip


def test_near_rated_wind_the_bodies_alone_are_moved(spar):
    with pytest.warns(UserWarning, match="leaves a motion of platform.motion.surge, .* So rotors and controllers"):
        moved, _ = start_values(spar, "stationary", NEAR_RATED)
    mean, _ = start_values(spar, "turning", NEAR_RATED)
    changed = {path for path in moved if moved[path] != mean[path]}
    assert {"platform.motion.pitch", "platform.motion.velocity[0]", "platform.water.radiation.x[0]"} <= changed
    assert not any(path.startswith("turbine.") for path in changed)


def test_a_start_outside_of_a_range_moves_the_bodies_alone(spar, monkeypatch):
    parameters = {**NEAR_RATED, "wind.mean_speed": 18.0}
    whole, _ = start_values(spar, "stationary", parameters)

    def outside(*_, **__):
        raise SimulationError("turbine.rotor: table left at its edge.")

    monkeypatch.setattr(starts, "check_state", outside)
    with pytest.warns(UserWarning, match="moves the bodies alone, not rotors and controllers: turbine.rotor: table"):
        bodies, _ = start_values(spar, "stationary", parameters)
    mean, _ = start_values(spar, "turning", parameters)
    assert bodies["platform.motion.surge"] == whole["platform.motion.surge"] != mean["platform.motion.surge"]
    assert bodies["turbine.rotor.w"] == mean["turbine.rotor.w"] != whole["turbine.rotor.w"]


def test_a_rotor_of_blade_elements_counts_by_its_mean_over_a_turn():
    """The start does not depend on the azimuth at which the mean stands; of one azimuth alone by 3 % in sway here."""
    plant = fw.load("oc3_spar_rigid_bem").compile()
    parameters = {**NEAR_RATED, "wind.mean_speed": 18.0}
    mean, binding = starts.mean_parameters(plant, parameters), plant.binding(parameters)
    values, _ = start_values(plant, "turning", parameters)
    (angle,) = [turn.azimuth for turn in turns_of(plant, plant.at(mean), plant.initial_state(mean, values))]
    assert plant.root.find("turbine.aerodynamics").felt_disk() == (0, 63.0)
    found = []
    for turned in (0.0, 0.3):
        values[plant.dae.states[angle].path] += turned
        found.append(slow_modes(plant.at(mean), plant, plant.initial_state(mean, values)).response(binding))
    for name in ("surge", "sway", "heave", "roll", "pitch", "yaw"):
        k = next(k for k, state in enumerate(plant.dae.states) if state.path == f"platform.motion.{name}")
        assert found[0][k] == pytest.approx(found[1][k], rel=0.02, abs=1e-4), name
