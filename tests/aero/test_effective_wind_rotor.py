"""A rotor in effective winds: its series beside their spectra and beside a field, time beside frequency, mistakes."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import CoefficientRotor, EffectiveWindRotor, TowerDrag, read_load_slopes
from fowtlib.components.blocks import Constant
from fowtlib.components.environment.wind import SteadyWind, Wind
from fowtlib.components.environment.wind.discs import DiscSignals, Turbulence
from fowtlib.components.mechanics import Fixed, Revolute, RigidBody, SpeedSource, World
from fowtlib.components.servo import BaselineController
from fowtlib.components.turbine import RotorNacelle
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError
from fowtlib.solving.binding import tree_with

DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"
WHOLE, SLOPES = str(DATA / "rotor_coefficients_whole.csv"), str(DATA / "load_slopes.csv")
ROTOR = {"coefficients": WHOLE, "radius": 63.0, "precone": "2.5 deg", "inertia": 38759227.0}


def turbine(wind, rotor=None, **settings):
    """An NREL 5 MW turbine whose hub stands still."""
    model = Assembly("turbine in turbulence")
    model.world, model.tower, model.wind = World(), Fixed(r=(0, 0, 90)), wind
    model.turbine = RotorNacelle(
        mass=350e3, gear_ratio=97.0, generator_inertia=534.116, generator_efficiency=0.944, **settings,
        rotor=rotor or EffectiveWindRotor(**ROTOR, slopes=SLOPES),
        control=BaselineController(proportional_gain=0.006275604, integral_gain=0.0008965149,
                                   region_3="constant_torque"),
    )  # fmt: skip
    model.connect(model.tower.frame, model.turbine.frame)
    names = {"thrust": "rotor.thrust", "torque": "rotor.torque", "speed": "rotor_speed"}
    if rotor is None:
        names |= {"tilt": "rotor.tilt_moment", "yaw": "rotor.yaw_moment"}
    return fw.Model(model, outputs={name: f"turbine.{path}" for name, path in names.items()})


@functools.cache
def plant():
    """For winds of all kinds."""
    return turbine(Wind(kind="kaimal", mean_speed=14.0)).compile()


def rotor_in(**wind):
    """The rotor as it stands when a run in this wind starts."""
    return tree_with(plant().dae, plant().root, {f"wind.{name}": value for name, value in wind.items()}).find(
        "turbine.rotor"
    )


def spectra(rotor, frequency):
    """Of the four winds, per Hz, (q, 4, 4)."""
    density = Turbulence(rotor.wind).spectral_density(2 * np.pi * frequency) * 2 * np.pi
    response = DiscSignals().response(rotor, np.ones(1))[0]
    return response @ density @ response.conj().T


def bands(series, period, step, edges):
    """Variances (bands, 4) of the samples of a series."""
    values = series(np.arange(0, period, step))
    line = 2 * np.abs(np.fft.rfft(values, axis=0) / len(values)) ** 2
    frequency = np.arange(len(line)) / period
    return np.array([line[(frequency > low) & (frequency <= high)].sum(axis=0) for low, high in edges])


def expected(rotor, period, edges):
    """The same from the spectra."""
    found = []
    for low, high in edges:
        frequency = np.arange(1, round(high * period) + 1) / period
        frequency = frequency[frequency > low]
        found.append(np.einsum("qii->i", spectra(rotor, frequency)).real / period)
    return np.array(found)


EDGES = ((0.01, 0.1), (0.45, 0.75))  # of what all blades feel at once, and of their passing at 0.605 Hz


@pytest.mark.parametrize(("kind", "more"), [("kaimal", {}), ("ntm", {"turbulence_class": "A"}), ("etm", {})])
def test_series_of_a_run_have_the_spectra_of_the_frequency_domain(kind, more):
    rotor = rotor_in(kind=kind, mean_speed=14.0, **more)
    found = bands(DiscSignals()(rotor), 4096.0, 0.25, EDGES)
    assert found == pytest.approx(expected(rotor, 4096.0, EDGES), rel=0.12)  # some hundred harmonics of random size


def test_thrust_and_torque_are_nearly_coherent_and_moments_independent_of_them():
    rotor = rotor_in(mean_speed=14.0)
    density = spectra(rotor, np.array([0.01, 0.1, 0.605]))
    alone = np.sqrt(np.einsum("qii->qi", density).real)
    coherence = np.abs(density) / (alone[:, :, None] * alone[:, None])
    assert coherence[0, 0, 1] > 0.999  # of large eddies, the whole disk at once
    assert coherence[1, 0, 1] > 0.99
    assert coherence[2, 0, 1] > 0.95
    assert not density[:, :2, 2:].any()


def test_the_stations_have_the_same_turbulence_with_and_without_discs():
    rotor = rotor_in(mean_speed=14.0, seed=5)
    alone, beside = rotor.wind.turbulence(), rotor.wind.disc_series(Turbulence(rotor.wind).places, 0)
    assert beside.values == pytest.approx(alone.values, abs=1e-9)
    thrust = DiscSignals()(rotor)(alone.time)[:, 0]
    omega = 2 * np.pi * np.arange(1, 4097) / 4096
    of_hub, both, _, of_disk = Turbulence(rotor.wind).spectral_density(omega)[:, :2, :2].real.sum(axis=0).ravel()
    assert np.corrcoef(thrust, alone.values[:, 0])[0, 1] == pytest.approx(both / np.sqrt(of_hub * of_disk), abs=0.05)


@pytest.mark.parametrize("spectrum", ["kaimal", pytest.param("von_karman", marks=pytest.mark.long)])
def test_the_blades_meet_the_same_in_a_field(spectrum):
    found, fields = 0, {"kaimal": 1, "von_karman": 2}[spectrum]
    for seed in range(1, fields + 1):
        rotor = rotor_in(kind="turbulence", mean_speed=14.0, field_spectrum=spectrum, point_spacing=10.0,
                         sample_step=0.1, repetition_period=600.0, seed=seed)  # fmt: skip
        found += bands(DiscSignals()(rotor), 600.0, 0.1, EDGES) / fields
    ratio = found / expected(rotor, 600.0, EDGES)
    assert ratio[0] == pytest.approx(np.ones(4), abs=0.3)  # 54 or 108 harmonics: 14 or 10 % to one deviation
    assert ratio[1] == pytest.approx(np.ones(4), abs=0.25)  # straight lines over 10 m take some of the small eddies
    assert ratio.mean() == pytest.approx(1.0, abs=0.12)


def test_in_steady_wind_and_in_a_gust_it_is_the_rotor_of_coefficients():
    plants = plant(), turbine(SteadyWind(mean_speed=14.0), CoefficientRotor(**ROTOR, filtered=False)).compile()
    for wind in ({"wind.kind": "steady"}, {"wind.kind": "eog", "wind.start_time": 1.0}):
        options = {"output_step": 0.25, "outputs": ["thrust", "torque", "speed"], "solver": "fixed", "step": 0.025}
        one, other = (p.simulate(8.0, parameters={**wind, "wind.mean_speed": 14.0}, **options) for p in plants)
        for name in ("thrust", "torque", "speed"):
            assert np.asarray(one[name]) == pytest.approx(np.asarray(other[name]), rel=1e-6)
    assert np.ptp(np.asarray(one["thrust"])) > 5e4  # the gust is felt


def test_a_run_has_the_deviations_of_the_response():
    small = {"wind.turbulence_intensity": 0.02, "wind.mean_speed": 15.0, "wind.repetition_period": 2150.0}
    result = plant().simulate(2150.0, output_step=0.25, parameters=small, solver="fixed", step=0.05, events=None)
    response = fw.response(plant(), parameters=small, frequencies=np.linspace(0.5 / 2150, 1.0, 4000))
    late = np.asarray(result.time) >= 100.0
    for name in ("thrust", "torque", "speed", "tilt", "yaw"):
        assert np.std(np.asarray(result[name])[late]) == pytest.approx(response.std(name), rel=0.06)


def test_a_hub_that_tilts_is_damped_by_the_slopes_of_the_moment():
    model, inertia = Assembly("tilting"), 2.4e7
    model.world, model.wind, model.base = World(), SteadyWind(mean_speed=14.0), Fixed(r=(0, 0, 90))
    model.hinge = Revolute(n=(0, 1, 0))
    model.body = RigidBody(mass=3e5, inertia=((inertia, 0, 0), (0, inertia, 0), (0, 0, inertia)))
    model.rotor = EffectiveWindRotor(**ROTOR, slopes=SLOPES)
    model.drive, model.speed, model.pitch = SpeedSource(), Constant(value=1.267), Constant(value=np.radians(8.6))
    for pair in ((model.base.frame, model.hinge.frame_a), (model.hinge.frame_b, model.body.frame_a),
                 (model.hinge.frame_b, model.rotor.frame), (model.speed.y, model.drive.w),
                 (model.drive.flange, model.rotor.shaft), (model.pitch.y, model.rotor.blade_pitch)):  # fmt: skip
        model.connect(*pair)
    plant = fw.Model(model).compile()
    linear = plant.linearize(plant.initial_state())
    k = linear.states.index("hinge.w")
    slopes = read_load_slopes(SLOPES).at(14.0)
    damping = 1.225 * 1.5 * (slopes.moment[0] @ slopes.radius)
    assert linear.A[k, k] == pytest.approx(-damping / inertia, rel=1e-6)


def test_a_kaimal_field_and_kaimal_turbulence_give_one_response():
    frequency = np.geomspace(1e-3, 1.0, 150)
    winds = ({"kind": "ntm"}, {"kind": "turbulence"})
    one, other = (
        fw.response(plant(), frequencies=frequency,
                    parameters={f"wind.{name}": value for name, value in {**wind, "mean_speed": 14.0}.items()})
        for wind in winds
    )  # fmt: skip
    assert one.density == pytest.approx(other.density, rel=1e-6)


def test_two_rotors_are_in_one_turbulence():
    model = Assembly("two rotors")
    model.world, model.wind = World(), Wind(kind="kaimal", mean_speed=14.0, stations=((70, 90), (-70, 90)), seed=4)
    model.left = EffectiveWindRotor(**ROTOR, slopes=SLOPES, station=0)
    model.right = EffectiveWindRotor(**ROTOR, slopes=SLOPES, station=1, rotation=-1)
    turbulence = Turbulence(model.wind)
    assert [turbulence.columns(rotor) for rotor in (model.left, model.right)] == [slice(2, 6), slice(6, 10)]
    S = turbulence.spectral_density(2 * np.pi * np.array([0.005, 0.02]))
    assert np.linalg.eigvalsh(S).min() > 0
    disks = np.abs(S[:, 2, 6]) / np.sqrt(S[:, 2, 2] * S[:, 6, 6]).real
    points = np.abs(S[:, 0, 1]) / S[:, 0, 0].real
    assert np.all((disks > points) & (disks < 1))  # small eddies are out of the means, large ones are of both
    left, right = (DiscSignals()(rotor)(np.arange(0, 4096, 0.25)) for rotor in (model.left, model.right))
    total = turbulence.spectral_density(2 * np.pi * np.arange(1, 4097) / 4096).real.sum(axis=0)
    expected = total[2, 6] / np.sqrt(total[2, 2] * total[6, 6])
    assert np.corrcoef(left[:, 0], right[:, 0])[0, 1] == pytest.approx(expected, abs=0.12)


def test_the_tower_beside_the_rotor_is_in_the_same_field():
    model = turbine(Wind(kind="turbulence", mean_speed=14.0, shear_exponent=0.0)).root
    model.column = Fixed(r=(0, 0, 60))
    model.drag = TowerDrag(diameters=[5.0], lengths=[20.0], drag_coefficient=0.7)
    model.connect(model.column.frame, model.drag.nodes[0])
    plant = fw.Model(model, outputs={"thrust": "turbine.rotor.thrust", "drag": "drag.force[0]"}).compile()
    found = fw.response(plant, frequencies=np.geomspace(1e-4, 2.0, 400))
    slope, wind = 1.225 * 0.7 * 100.0 * 14.0, found.transfer["wind"]
    density = Turbulence(plant.root.wind).spectral_density(2 * np.pi * found.frequency)[:, 0, 0].real * 2 * np.pi
    assert found.std("drag") == pytest.approx(slope * np.sqrt(np.trapezoid(density, found.frequency)), rel=2e-3)
    assert found.std("thrust") > 3e4
    # stations and disc, then the column
    assert wind.shape[2] == 6
    assert np.abs(wind[0, 1]) == pytest.approx([0, 0, 0, 0, 0, slope], rel=2e-3, abs=1e-6 * slope)


def test_a_wind_beyond_the_slopes_and_one_of_stations_alone_are_refused():
    with pytest.raises(ParameterError, match=r"load_slopes.csv: .* cover winds of 2 to 30 m/s, and not 33"):
        plant().simulate(1.0, parameters={"wind.mean_speed": 33.0})

    class Hum(SteadyWind, kind="hum"):
        """White noise at the stations, of which nobody knows more."""

        def spectral_density(self, omega):
            return np.ones((len(np.atleast_1d(omega)), 1, 1))

    with pytest.raises(ParameterError, match="kind 'hum' has turbulence at its stations alone"):
        fw.response(turbine(Hum(mean_speed=14.0)))
