"""Kinds of wind: one compiled model for all of them, classes and the words of a model file, starts that follow."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import (
    GustWind,
    InputWind,
    KaimalWind,
    NoWind,
    SeriesWind,
    SteadyWind,
    StepWind,
    Wind,
    World,
    generate_field,
)
from fowtlib.language import Array, Component, ModelError, Scalar, Series, der, eq, outer, param, var
from fowtlib.language import math as m
from fowtlib.language.errors import ModelFileError, ParameterError
from fowtlib.modelfile.writing import dump
from fowtlib.solving.engines.c_lanes import ANY_PROCESSOR
from fowtlib.solving.engines.fixed_step_code import kept_text
from fowtlib.solving.engines.reduction import reduction
from fowtlib.solving.engines.turning_frames import turning_frames

STATIONS = [[-30, 80], [30, 90]]


class Kite(Component):
    """Three points in the wind, two of which it carries away."""

    wind: Wind = outer(Wind)
    x: Scalar = var(unit="m", start=0, doc="way across")
    felt: Array = var(unit="m/s", shape=(9,), doc="wind at the points")

    def equations(self):
        places = m.horzcat(m.vertcat(2, self.x, 100), m.vertcat(self.x, -5, 85), m.vertcat(0, 0, 60))
        here = self.wind.velocity(places, 1)
        return [eq(der(self.x), 0.05 * here[1, 0] + 0.01 * here[0, 2]), eq(self.felt, m.vec(here))]


def model(**wind):
    top = fw.Assembly("kite")
    top.world, top.wind, top.kite = World(), Wind(stations=STATIONS, **wind), Kite()
    return fw.load(top)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wind")
    time = np.arange(0, 40.1, 0.5)
    table = np.column_stack([time, 8 + np.sin(time), 9 + np.cos(0.5 * time)])
    np.savetxt(folder / "speeds.csv", table, delimiter=",")
    for seed in (1, 2):
        generate_field(folder / f"{seed}.bts", mean_speed=9.0 + seed, width=160, height=160, columns=9, rows=9,
                       duration=40, time_step=0.25, seed=seed)  # fmt: skip
    return folder


def cases(files):
    return {
        "none": {},
        "steady": {"wind.kind": "steady", "wind.mean_speed": 8.0, "wind.shear_exponent": 0.2},
        "turned": {"wind.kind": "steady", "wind.mean_speed": 8.0, "wind.direction": "20 deg"},
        "step": {"wind.kind": "step", "wind.mean_speed": 8.0, "wind.step_speed": 11.0, "wind.start_time": 2.03,
                 "wind.step_duration": 3.0},
        "gust": {"wind.kind": "gust", "wind.mean_speed": 12.0, "wind.start_time": 1.0, "wind.reference_height": 80.0},
        "hump": {"wind.kind": "gust", "wind.mean_speed": 12.0, "wind.gust_shape": "1-cos", "wind.gust_speed": 4.0},
        "kaimal": {"wind.kind": "kaimal", "wind.mean_speed": 10.0, "wind.seed": 3, "wind.turbulence_class": "A"},
        "seed": {"wind.kind": "kaimal", "wind.mean_speed": 10.0, "wind.seed": 4, "wind.repetition_period": 600.0},
        "ewm": {"wind.kind": "ewm", "wind.return_period": 1, "wind.seed": 2},
        "ecd": {"wind.kind": "ecd", "wind.mean_speed": 9.0, "wind.start_time": 1.0, "wind.sign": -1},
        "ews": {"wind.kind": "ews", "wind.mean_speed": 9.0, "wind.plane": "horizontal", "wind.direction": 0.3,
                "wind.rotor_diameter": 100.0},
        "file": {"wind.kind": "file", "wind.file": str(files / "speeds.csv"), "wind.shear_exponent": 0.1},
        "straight": {"wind.kind": "file", "wind.file": str(files / "speeds.csv"), "wind.interpolation": "linear"},
        "field": {"wind.kind": "field", "wind.file": str(files / "1.bts")},
        "cubic": {"wind.kind": "field", "wind.file": str(files / "2.bts"), "wind.interpolation": "cubic",
                  "wind.direction": 0.2, "wind.field_shift": 10.0},
    }  # fmt: skip


def test_one_compiled_model_for_every_kind(files):
    plant, felt = model().compile(), {}
    for name, case in cases(files).items():
        results = [plant.simulate(8.0, 0.1, solver="fixed", parameters=case),
                   model().with_parameters(case).compile().simulate(8.0, 0.1, solver="fixed")]  # fmt: skip
        names = ("speed", "base", "fluctuation", "bearing", "gradient")
        for path in ("kite.x", "kite.felt", *(f"wind.{name}" for name in names)):
            found, expected = (np.asarray(result[path]) for result in results)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * max(1, np.abs(expected).max()))
        felt[name] = np.asarray(results[0]["kite.felt"]).tobytes()
    assert len(set(felt.values())) == len(felt)


def test_the_code_does_not_know_the_wind(files):
    texts = set()
    for case in cases(files).values():
        dae = model().with_parameters(case).compile().dae
        texts.add(kept_text(dae, reduction(dae), [], turning_frames(dae), ANY_PROCESSOR)[0])
    assert len(texts) == 1


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_parts_take_the_place_of_the_wind(solver, files):
    plant = model(kind="steady", mean_speed=10.0, shear_exponent=0.2).compile()
    for wind, changes in (
        (SteadyWind(mean_speed=8), {"wind.mean_speed": 8}),
        (NoWind(), {"wind.kind": "none"}),
        (KaimalWind(seed=5), {"wind.kind": "kaimal", "wind.seed": 5}),
        (StepWind(step_speed=14), {"wind.kind": "step", "wind.step_speed": 14}),
        (SeriesWind(file=str(files / "speeds.csv")), {"wind.kind": "file", "wind.file": str(files / "speeds.csv")}),
    ):
        found = plant.simulate(3.0, 0.5, solver=solver, parts={"wind": wind})
        base = model(kind="steady", mean_speed=10.0, shear_exponent=0.2)
        expected = base.with_parameters(changes).compile().simulate(3.0, 0.5, solver=solver)
        np.testing.assert_allclose(found["kite.felt"], expected["kite.felt"], rtol=0, atol=1e-9)
        np.testing.assert_array_equal(found["wind.speed"], expected["wind.speed"])


@pytest.mark.parametrize(
    ("wind", "made_for_it"),
    [
        ({"kind": "steady"}, False),
        ({"kind": "step", "step_speed": 11.0}, False),
        ({"kind": "gust"}, True),
        ({"kind": "gust", "gust_speed": 3.0}, False),
        ({"kind": "kaimal"}, True),
    ],
)
def test_what_is_made_for_a_mean_speed(wind, made_for_it):
    """What an FMU has to guard: data computed from the speed; the speed itself stays a symbol."""
    reads = model(**wind, mean_speed=9.0).compile().binding().reads
    assert any("wind.mean_speed" in paths for paths in reads.values()) == made_for_it


def test_a_kind_that_is_derived_from_another_one():
    wind = Wind(kind="kaimal", mean_speed=9, seed=3)
    wind.kind = "steady"
    assert type(wind) is SteadyWind
    wind.kind = "gust"
    assert (type(wind), wind.parameter_value("mean_speed")) == (GustWind, 9)


def test_wind_from_outside_is_another_model():
    plant = model().compile()
    with pytest.raises(ModelError, match=r"wind: .* InputWind has speeds\(\) of its own, other equations"):
        plant.simulate(1.0, parts={"wind": InputWind()})
    driven = model(kind="input", mean_speed=7.0).compile()
    assert np.asarray(driven.simulate(1.0)["wind.speed"])[-1] == pytest.approx([7.0, 7.0])
    with pytest.raises(ModelError, match="choose it in the model, before compile"):
        driven.simulate(1.0, parameters={"wind.kind": "steady"})
    for name in ("mean_speed", "shear_exponent", "reference_height"):  # they are in the values of the inputs
        with pytest.raises(ModelError, match=f"there is no tunable parameter 'wind.{name}'"):
            driven.simulate(1.0, parameters={f"wind.{name}": 8.0})


@pytest.mark.parametrize(
    ("wind", "parameters", "words"),
    [
        ({"kind": "none"}, {"wind.mean_speed": 8.0}, "the kind 'none' takes no notice of it"),
        ({"kind": "steady", "mean_speed": 8.0}, {"wind.kind": "none", "wind.mean_speed": 8.0}, "the kind 'none'"),
        ({"kind": "steady", "mean_speed": 8.0}, {"wind": NoWind(), "wind.mean_speed": 8.0}, "the kind 'none'"),
    ],
)
def test_a_value_that_would_do_nothing_in_a_run(wind, parameters, words):
    plant = model(**wind).compile()
    with pytest.raises(ModelError, match=f"wind.mean_speed is given and would do nothing, because {words}"):
        plant.simulate(1.0, parameters=parameters)
    assert np.all(np.asarray(plant.simulate(1.0, parameters={"wind.kind": "none"})["wind.speed"]) == 0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"kind": "none", "mean_speed": 8.0}, "mean_speed is given .* 'none'"),
        ({"kind": "file", "file": "a.csv", "mean_speed": 8.0}, "mean_speed is given .* 'file'"),
        ({"kind": "field", "file": "a.bts", "shear_exponent": 0.1}, "shear_exponent is given .* 'field'"),
        ({"kind": "kaimal", "mean_speed": 8.0, "turbulence_class": "A", "turbulence_intensity": 0.1},
         "turbulence_class is given and would do nothing, because turbulence_intensity is given"),
        ({"kind": "gust", "mean_speed": 8.0, "gust_speed": 5.0, "extreme_speed": 37.5},
         "extreme_speed is given and would do nothing, because gust_speed is given"),
    ],
)  # fmt: skip
def test_values_that_would_do_nothing_beside_each_other(tmp_path, given, words):
    with pytest.raises(ModelError, match=words):
        Wind(**given)
    path = tmp_path / "wind.yaml"
    if "file" in given:
        (tmp_path / given["file"]).touch()
    values = ", ".join(f"{name}: {value}" for name, value in given.items())
    path.write_text(f"fowtlib: 1\nparts: {{wind: {{class: Wind, {values}}}}}\n")
    with pytest.raises(ModelError, match=f"wind.yaml:2: .*{words}"):
        fw.load(path)


def test_the_later_of_two_values_counts(tmp_path):
    """A model file has the one, a run or an option the other; a kind leaves what it takes no notice of."""
    path = tmp_path / "wind.yaml"
    path.write_text("fowtlib: 1\nparts: {wind: {class: Wind, kind: kaimal, mean_speed: 8, turbulence_class: A}}\n")
    by_class = fw.load(path)
    by_intensity = fw.load(path, set={"wind.turbulence_intensity": 0.3})
    assert by_intensity.root.wind.standard_deviation() == pytest.approx(2.4)
    assert not by_intensity.root.wind.is_set("turbulence_class")
    again = by_class.compile().binding({"wind.turbulence_intensity": 0.3}).root.wind
    assert again.standard_deviation() == pytest.approx(2.4)
    back = by_intensity.compile().binding({"wind.turbulence_class": "A"}).root.wind
    assert back.standard_deviation() == by_class.root.wind.standard_deviation()
    calm = fw.load(path, set={"wind.kind": "none"}).root.wind
    assert not calm.is_set("mean_speed")


def test_a_kind_of_ones_own():
    class Sawtooth(Wind, kind="sawtooth"):
        """Rises and falls, again and again."""

        rise: float = param(default=2.0, unit="m/s", bound=True, doc="height of the teeth")

        def station_series(self):
            teeth = np.outer([0.0, self.rise, 0.0, self.rise], np.repeat([0.0, 1.0], len(self.hubs)))
            return Series.samples(teeth, 1.0, periodic=True, interpolation="linear")

    try:
        speed = model().compile().simulate(3.0, 0.5, parts={"wind": Sawtooth(rise=4.0)})["wind.speed"]
        np.testing.assert_allclose(speed[:, 0], [0, 2, 4, 2, 0, 2, 4], atol=1e-12)
    finally:
        del Wind.family.kinds["sawtooth"]
        Wind.family.field.choices = tuple(Wind.family.kinds)


@pytest.mark.parametrize("kind", ["cubic", "monotone", "linear"])
def test_series_that_do_not_overshoot(tmp_path, kind):
    path = tmp_path / "jump.csv"
    path.write_text("\n".join(f"{t},{8 if t < 5 else 12}" for t in range(11)))
    speed = model(kind="file", file=str(path), interpolation=kind).compile().simulate(10, 0.05)["wind.speed"][:, 0]
    over = max(float(speed.max()) - 12, 8 - float(speed.min()))
    assert over > 0.2 if kind == "cubic" else abs(over) < 1e-12


def test_words_of_a_model_file(tmp_path):
    def load(text, **options):
        path = tmp_path / "wind.yaml"
        path.write_text(f"fowtlib: 1\nparts:\n  world: {{class: World}}\n{text}", encoding="utf-8")
        return fw.load(path, **options)

    short = load("  wind: {class: Wind, kind: kaimal, mean_speed: 9 m/s, seed: 7}\n")
    assert type(short.root.wind) is KaimalWind
    assert short.root.wind.seed == 7
    named = load("  wind:\n    class: GustWind\n    mean_speed: 9\n")
    assert type(named.root.wind) is GustWind
    other = load("  wind: {class: Wind, kind: kaimal, mean_speed: 9, seed: 7}\n", set={"wind.kind": "steady"})
    assert type(other.root.wind) is SteadyWind  # the seed belonged to the other kind
    assert other.root.wind.parameter_value("mean_speed") == 9
    same = load("  wind: {class: Wind, kind: kaimal, mean_speed: 9, seed: 7}\n", set={"wind.kind": "kaimal"})
    assert same.root.wind.seed == 7
    for text, words in (
        ("  wind:\n    class: Wind\n    kind: kaimall\n",
         r"wind.yaml:6: wind.kind: 'kaimall' is not possible; did you mean 'kaimal'"),
        ("  wind:\n    class: Wind\n    kind: steady\n    seed: 3\n",
         r"wind.yaml:7: wind: SteadyWind has no parameter 'seed'; it belongs to the kind kaimal"),
        ("  wind:\n    class: Wind\n    kind: steady\n    mean_sped: 3\n", r"wind.yaml:7: .*did you mean 'mean_speed'"),
    ):  # fmt: skip
        with pytest.raises(ModelFileError, match=words):
            load(text)


def test_a_model_is_written_with_its_kind(tmp_path):
    top = fw.Assembly("windy")
    top.wind = Wind(kind="kaimal", mean_speed=9.0, seed=7)
    path = tmp_path / "written.yaml"
    path.write_text(dump(top), encoding="utf-8")
    assert "class: Wind" in path.read_text()
    again = fw.load(path).root.wind
    assert (type(again), again.seed) == (KaimalWind, 7)


def test_a_turbine_starts_in_the_wind_of_the_run():
    plant = fw.load("oc3_spar_rigid", set={"wind.kind": "steady", "wind.mean_speed": 8.0}).compile()
    for changes in ({"wind.mean_speed": 16.0}, {"wind.kind": "kaimal", "wind.mean_speed": 16.0, "wind.seed": 2}):
        state = plant.initial_state(changes)
        fresh = fw.load("oc3_spar_rigid", set={"wind.kind": "steady", "wind.mean_speed": 8.0})
        expected = fresh.with_parameters(changes).compile().initial_state()
        np.testing.assert_allclose(state.x, expected.x, rtol=1e-12, atol=1e-12)
        assert state["turbine.blade_pitch"] > 0.1
    assert plant.initial_state()["turbine.blade_pitch"] < 0.01


def test_the_spectrum_of_kaimal_wind_is_that_of_its_series():
    """Integral and coherence by closed forms; bands of the cross spectra of 60 realisations within their scatter."""
    wind = KaimalWind(stations=[[0, 90], [12, 90], [0, 75]], mean_speed=11.4, sample_step=0.5, repetition_period=1024.0)
    omega = 2 * np.pi * np.arange(1, 513) / 1024.0
    density = wind.spectral_density(omega)
    assert density.shape == (512, 3, 3)
    fine = np.geomspace(1e-7, 1e5, 20001)
    total = np.trapezoid(wind.spectral_density(fine)[:, 0, 0], fine)
    assert total == pytest.approx((0.14 * (0.75 * 11.4 + 5.6)) ** 2, rel=2e-3)  # IEC 61400-1 (11), class B
    assert density[40, 0, 1] / density[40, 0, 0] == pytest.approx(
        np.exp(-12 * np.hypot(omega[40] / (2 * np.pi) * 12 / 11.4, 0.12 * 12 / (8.1 * 42))), rel=1e-12
    )
    found = np.zeros((512, 3, 3))
    for seed in range(60):
        wind.seed = seed
        amplitudes = np.fft.rfft(wind.turbulence().values, axis=0)[1:513] / 2048 * 2
        found += np.real(amplitudes[:, :, None] * amplitudes[:, None, :].conj()) / 2 / omega[0] / 60
    for band in (slice(3, 20), slice(20, 100), slice(100, 400)):
        mean, count = density[band].mean(axis=0), 60 * (band.stop - band.start)
        np.testing.assert_allclose(found[band].mean(axis=0), mean, rtol=0, atol=4 * mean[0, 0] / np.sqrt(count))
    np.testing.assert_array_equal(SteadyWind(mean_speed=8).spectral_density(omega), np.zeros((512, 1, 1)))


@pytest.mark.parametrize("kind", ["kaimal", "turbulence"])
def test_an_intensity_is_no_percentage(kind):
    """20 for 20 % would blow with a deviation of twenty times the mean speed."""
    with pytest.raises(ParameterError, match="turbulence_intensity = 20 is above its maximum 2"):
        fw.load("oc3_spar_rigid", set={"wind.kind": kind, "wind.turbulence_intensity": 20}).compile()
