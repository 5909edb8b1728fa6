"""Sea and Wind in simulated models: results are the numbers of waves.py and turbulence.py, and mistakes are named."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import Sea, Wind, World, jonswap, operating_gust
from fowtlib.language import Array, Component, ModelError, Scalar, Vector, der, eq, outer, var
from fowtlib.language import math as m

POINTS = np.array([[0, 0, 0], [10, 20, -15], [0, 0, -300], [0, 0, 2.0]])
HEADING = 0.4


class Probe(Component):
    """Looks at the sea and the wind, and moves with the water so that there is something to integrate."""

    sea: Sea = outer(Sea)
    wind: Wind = outer(Wind)
    x: Scalar = var(unit="m", start=0, doc="drift in the water")
    blown: Scalar = var(unit="m", start=0, doc="drift in the wind")
    velocity: Array = var(unit="m/s", shape=(12,), doc="of the water")
    acceleration: Array = var(unit="m/s^2", shape=(12,), doc="of the water")
    load: Array = var(unit="N", shape=(3,), doc="a made-up load")
    wind_velocity: Vector = var(unit="m/s", doc="at 120 m over the last station")

    def equations(self):
        last = len(self.wind.hubs) - 1
        return [
            eq(der(self.x), self.velocity[0]),
            eq(der(self.blown), self.wind.speed[last]),
            eq(self.velocity, by_point(self.sea.velocity(POINTS))),
            eq(self.acceleration, by_point(self.sea.acceleration(POINTS))),
            eq(self.load, self.sea.signal(load_transfer, 3, "load")),
            eq(self.wind_velocity, self.wind.velocity(m.vertcat(5, 6, 120), last)),
        ]


def by_point(matrix):
    return m.vertcat(*[matrix[i, j] for i in range(len(POINTS)) for j in range(3)])


def load_transfer(waves):
    return np.column_stack([1e6 * np.exp(-waves.omega), 0 * waves.omega, 1e5j * waves.omega**2]).reshape(len(waves), 3)


def model(sea=None, wind=None):
    top = fw.Assembly("sea and wind")
    top.world = World(water_depth="300 m")
    top.sea = Sea(**(sea or {}))
    top.wind = Wind(**(wind or {}))
    top.probe = Probe()
    return top


def simulate(top, t_end=30.0, output_step=0.5, **options):
    return fw.load(top).compile().simulate(t_end, output_step=output_step, **options)


def values(result, path):
    return np.asarray(result[path])


def compare(top, result, relative):
    waves = top.sea.components()
    time = np.asarray(result["sea.elevation"].time)
    n, p = len(waves), len(POINTS)
    wanted = {
        "sea.elevation": (np.ones((n, 1)), (len(time),)),
        "probe.velocity": (waves.velocity_transfer(POINTS).reshape(n, 3 * p), (len(time), 3 * p)),
        "probe.acceleration": (waves.acceleration_transfer(POINTS).reshape(n, 3 * p), (len(time), 3 * p)),
        "probe.load": (load_transfer(waves), (len(time), 3)),
    }
    for path, (transfer, shape) in wanted.items():
        expected = waves.evaluate(transfer, time).reshape(shape)
        scale = np.abs(expected).max() or 1
        np.testing.assert_allclose(values(result, path), expected, atol=relative * scale, err_msg=path)


def test_still_water_and_no_wind():
    result = simulate(model())
    names = ("velocity", "acceleration", "load", "wind_velocity")
    for path in ("sea.elevation", "wind.speed", *(f"probe.{name}" for name in names)):
        assert not values(result, path).any(), path


def test_regular_waves():
    top = model(sea={"spectrum": "regular", "wave_height": "6 m", "wave_period": 10, "heading": "0.4 rad"})
    result = simulate(top)
    compare(top, result, 1e-12)
    time = np.asarray(result["sea.elevation"].time)
    np.testing.assert_allclose(values(result, "sea.elevation"), 3 * np.cos(0.2 * math.pi * time), atol=1e-12)
    w, k = 0.2 * math.pi, top.sea.components().wave_number[0]
    drift = 3 / math.tanh(k * 300) * np.sin(w * time) * math.cos(HEADING)
    np.testing.assert_allclose(values(result, "probe.x"), drift, atol=1e-4)


def test_jonswap_sea():
    sea = {"spectrum": "jonswap", "significant_wave_height": 6, "peak_period": 10, "seed": 4, "heading": HEADING}
    top = model(sea=sea)
    compare(top, simulate(top, 40, output_step=0.37), 1e-3)
    # the series of the whole period: variance and a harmonic of the spectrum
    assert top.sea.components().significant_wave_height == pytest.approx(6, rel=0.1)
    omega = top.sea.components().omega
    assert omega[np.argmax(jonswap(omega, 6, 10))] == pytest.approx(0.2 * math.pi, rel=2e-3)


@pytest.mark.parametrize(
    ("sea", "message"),
    [
        ({"spectrum": "regular", "wave_height": 40, "wave_period": 3}, "sea: a wave 14 m long breaks at 2 m, and has"),
        (
            {"spectrum": "jonswap", "significant_wave_height": 6, "peak_period": 2},
            "sea: Hs 6 m is too steep a sea for Tp 2 s, where 0.4162 m is the limit",
        ),
    ],
)
def test_waves_that_would_break_are_warned_about(sea, message):
    with pytest.warns(UserWarning, match=message):
        fw.load(model(sea=sea)).compile().initial_state()


def test_waves_build_up():
    sea = {"spectrum": "regular", "wave_height": 2, "wave_period": 8, "build_up": 10}
    result = simulate(model(sea=sea), 20, output_step=1.0)
    time = np.asarray(result["sea.elevation"].time)
    s = np.minimum(time / 10, 1)
    expected = np.cos(2 * math.pi * time / 8) * (10 * s**3 - 15 * s**4 + 6 * s**5)
    np.testing.assert_allclose(values(result, "sea.elevation"), expected, atol=1e-12)


def test_steady_wind_with_shear_and_direction():
    wind = {"kind": "steady", "mean_speed": 10, "shear_exponent": 0.14, "direction": "30 deg", "stations": [[0, 60]]}
    result = simulate(model(wind=wind), 1.0)
    assert values(result, "wind.speed")[-1] == pytest.approx(10 * (60 / 90) ** 0.14)
    speed = 10 * (120 / 90) ** 0.14
    assert values(result, "probe.wind_velocity")[-1] == pytest.approx([speed * math.sqrt(0.75), speed / 2, 0])


def test_mean_speed_at_a_station(tmp_path):
    wind = Wind(kind="kaimal", mean_speed=10, shear_exponent=0.2, stations=[[0, 90], [0, 45]])
    assert float(wind.mean_at(1)) == pytest.approx(10 * 0.5**0.2)
    assert Wind().mean_at() == 0
    path = tmp_path / "wind.csv"
    path.write_text("0,8\n1,9\n2,10\n3,11\n")
    assert Wind(kind="file", file=str(path)).mean_at() == 9.5


def test_mean_speed_of_a_steady_wind_is_tunable():
    plant = fw.load(model(wind={"kind": "steady", "mean_speed": 10})).compile()
    result = plant.simulate(1.0, output_step=0.5, parameters={"wind.mean_speed": 14})
    assert values(result, "wind.speed")[-1] == pytest.approx(14)


def test_step():
    wind = {"kind": "step", "mean_speed": 8, "step_speed": 12, "start_time": 5, "step_duration": 2}
    result = simulate(model(wind=wind), 10, output_step=1.0)
    np.testing.assert_allclose(values(result, "wind.speed").ravel(), [8] * 6 + [10] + [12] * 4, atol=1e-12)


def test_gusts():
    wind = {"kind": "gust", "mean_speed": 11.4, "start_time": 100, "shear_exponent": 0.2}
    result = simulate(model(wind=wind), 120, output_step=0.25)
    time, speed = np.asarray(result["wind.speed"].time), values(result, "wind.speed").ravel()
    size = operating_gust(11.4)
    s = np.clip((time - 100) / 10.5, 0, 1)
    expected = 11.4 - 0.37 * size * np.sin(3 * math.pi * s) * (1 - np.cos(2 * math.pi * s))
    np.testing.assert_allclose(speed, expected, atol=1e-12)
    assert speed.max() == pytest.approx(11.4 + 0.74 * size, abs=0.01)
    # the gust itself is the same at every height
    assert values(result, "probe.wind_velocity")[:, 0] == pytest.approx(expected + 11.4 * ((120 / 90) ** 0.2 - 1))
    wind |= {"gust_shape": "1-cos", "gust_speed": 5, "gust_duration": 20, "start_time": 0}
    speed = values(simulate(model(wind=wind), 20, output_step=5), "wind.speed").ravel()
    np.testing.assert_allclose(speed, 11.4 + np.array([0, 2.5, 5, 2.5, 0]), atol=1e-12)


def test_the_integrator_does_not_step_over_a_gust():
    wind = {"kind": "gust", "mean_speed": 11.4, "start_time": 400}
    result = simulate(model(wind=wind), 1000, output_step=500)
    gust = 0.37 * operating_gust(11.4) * 10.5 * (1.2 - 2 / 3) / math.pi  # integral of the shape, by hand
    assert values(result, "probe.blown")[-1] - 11400 == pytest.approx(gust, abs=0.05)


def test_turbulent_wind():
    stations = [[-69.3, 90], [69.3, 90]]
    wind = {"kind": "kaimal", "mean_speed": 11.4, "stations": stations, "seed": 3, "shear_exponent": 0.1}
    top = model(wind=wind)
    result = simulate(top, 30, output_step=0.25)
    series = top.wind.turbulence().values[:121]
    np.testing.assert_allclose(values(result, "wind.speed"), 11.4 + series, atol=1e-9)
    expected = 11.4 * (120 / 90) ** 0.1 + series[:, 1]
    np.testing.assert_allclose(values(result, "probe.wind_velocity")[:, 0], expected, atol=1e-9)
    assert top.wind.turbulence().values.std(axis=0) == pytest.approx([1.981, 1.981], rel=0.05)


def test_intensity_replaces_the_class():
    wind = {"kind": "kaimal", "mean_speed": 18, "turbulence_intensity": 0.18}
    assert model(wind=wind).wind.turbulence().values.std() == pytest.approx(0.18 * 18, rel=0.03)


def test_wind_from_a_file(tmp_path):
    path = tmp_path / "wind.csv"
    time = np.arange(0, 20.01, 0.5)
    np.savetxt(path, np.column_stack([time, 8 + np.sin(time)]), delimiter=",", header="time,speed")
    wind = {"kind": "file", "file": str(path), "shear_exponent": 0.14}
    result = simulate(model(wind=wind), 20, output_step=0.5)
    np.testing.assert_allclose(values(result, "wind.speed").ravel(), 8 + np.sin(time), atol=1e-6)
    sheared = (8 + np.sin(time)) * (120 / 90) ** 0.14
    np.testing.assert_allclose(values(result, "probe.wind_velocity")[:, 0], sheared, atol=1e-6)
    with pytest.raises(ModelError, match="table left at its edge: wind file .*wind.csv at time = .* covers 0 to 20"):
        simulate(model(wind=wind), 25, output_step=0.5)


# --- mistakes


@pytest.mark.parametrize(
    ("sea", "wind", "message"),
    [
        (
            {"spectrum": "jonswap", "peak_period": 10},
            {},
            "sea.significant_wave_height has no value; a sea of kind 'jonswap' needs it (JONSWAP: Hs).",
        ),
        (
            {"spectrum": "regular", "wave_height": 2},
            {},
            "sea.wave_period has no value; a sea of kind 'regular' needs it (regular waves: period).",
        ),
        ({}, {"kind": "steady"}, "wind.mean_speed has no value; a wind of kind 'steady' needs it."),
        ({}, {"kind": "kaimal"}, "wind.mean_speed has no value; a wind of kind 'kaimal' needs it."),
        ({}, {"kind": "file"}, "wind.file has no value; a wind of kind 'file' needs the path of a CSV file."),
        (
            {"spectrum": "pierson"},
            {},
            "Sea.spectrum = 'pierson' is not one of still, regular, jonswap, nss, sss, ess, ewh, record, input (kind "
            "of sea state); there are 'still', 'regular', 'jonswap', 'nss', 'sss', 'ess', 'ewh', 'record' and 'input'.",
        ),
        (
            {},
            {"kind": "kaimal", "mean_speed": 8, "turbulence_class": "D"},
            "wind.turbulence_class = 'D' is not one of A+, A, B, C (IEC turbulence class).",
        ),
    ],
)
def test_mistakes(sea, wind, message):
    with pytest.raises(ModelError) as error:
        simulate(model(sea=sea, wind=wind))
    assert str(error.value) == message


def test_a_station_that_does_not_exist():
    with pytest.raises(ModelError) as error:
        Wind(kind="steady", mean_speed=8).mean_at(1)
    assert str(error.value) == (
        "station 1 of SteadyWind does not exist (it has 1, counted from 0); "
        "set its parameter stations to the (y, z) of every hub."
    )


@pytest.mark.parametrize("wind", [{"kind": "kaimal"}, {"kind": "gust", "start_time": 0.2}])
def test_what_is_made_for_a_mean_speed_follows_it(wind):
    plant = fw.load(model(wind={**wind, "mean_speed": 11.4})).compile()
    changed = plant.simulate(4.0, output_step=0.5, parameters={"wind.mean_speed": 12})
    expected = simulate(model(wind={**wind, "mean_speed": 12}), 4.0)
    np.testing.assert_array_equal(values(changed, "wind.speed"), values(expected, "wind.speed"))
    first = plant.simulate(4.0, output_step=0.5)
    assert np.std(values(changed, "wind.speed") - values(first, "wind.speed")) > 1e-3


def test_a_run_longer_than_the_waves_is_warned_about():
    sea = {"spectrum": "jonswap", "significant_wave_height": 1, "peak_period": 2, "repetition_period": 40}
    wind = {"kind": "kaimal", "mean_speed": 8, "repetition_period": 60}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = simulate(model(sea=sea, wind=wind), 50, output_step=1.0)
    text = [str(warning.message) for warning in caught]
    assert sum("the sea repeats itself after 40 s" in line for line in text) == 1
    assert not any("the wind repeats" in line for line in text)
    eta = values(result, "sea.elevation")
    np.testing.assert_allclose(eta[40:], eta[:11], atol=1e-9)


class Nodes(Component):
    """The wind at three nodes in one call, and at each of them by itself."""

    wind: Wind = outer(Wind)
    x: Scalar = var(unit="m", start=0, doc="drift of the nodes")
    together: Array = var(unit="m/s", shape=(9,), doc="one call")
    apart: Array = var(unit="m/s", shape=(9,), doc="three calls")

    def equations(self):
        nodes = m.horzcat(m.vertcat(self.x, 6, 120), m.vertcat(-5, 70, 30 + self.x), m.vertcat(0, 1, -3))
        station = len(self.wind.hubs) - 1
        here = self.wind.velocity(nodes, station)
        single = [self.wind.velocity(nodes[:, i], station) for i in range(3)]
        return [
            eq(der(self.x), 0.5),
            eq(self.together, m.vertcat(*[here[:, i] for i in range(3)])),
            eq(self.apart, m.vertcat(*single)),
        ]


@pytest.mark.parametrize(
    "wind",
    [
        {"kind": "none"},
        {"kind": "steady", "mean_speed": 10},
        {"kind": "step", "mean_speed": 10, "step_speed": 12, "start_time": 1},
        {"kind": "gust", "mean_speed": 10, "start_time": 1},
        {"kind": "kaimal", "mean_speed": 10, "repetition_period": 60},
        {"kind": "file"},
    ],
)
def test_many_positions_in_one_call(tmp_path, wind):
    """Each column is the wind at its position: the power law above the station of 90 m, and the series of that one."""
    if wind["kind"] == "file":
        wind["file"] = str(tmp_path / "wind.csv")
        (tmp_path / "wind.csv").write_text("\n".join(f"{t},8,{9 + 0.1 * t}" for t in range(6)))
    top = fw.Assembly("nodes")
    top.world = World()
    top.wind = Wind(**wind, shear_exponent=0.2, direction=0.3, stations=[[0, 45], [0, 90]])
    top.nodes = Nodes()
    result = simulate(top, 4.0)
    found = values(result, "nodes.together")
    np.testing.assert_array_equal(found, values(result, "nodes.apart"))
    base, extra = values(result, "wind.base")[:, 1], values(result, "wind.fluctuation")[:, 1]
    height = np.column_stack([0 * base + 120, 30 + values(result, "nodes.x"), 0 * base + 0.09])
    speed = base[:, None] * (height / 90) ** 0.2 + extra[:, None]
    expected = np.stack([speed * np.cos(0.3), speed * np.sin(0.3), 0 * speed], axis=-1)
    np.testing.assert_allclose(found.reshape(-1, 3, 3), expected, atol=1e-9)
    assert found.any() == (wind["kind"] != "none")


def test_positions_of_another_shape():
    class Turned(Component):
        """Positions as rows."""

        wind: Wind = outer(Wind)
        u: Array = var(unit="m/s", shape=(3,), doc="wind")

        def equations(self):
            return [eq(self.u, self.wind.velocity(np.zeros((5, 3))))]

    top = fw.Assembly("turned")
    top.wind = Wind()
    top.turned = Turned()
    with pytest.raises(ModelError, match="the wind is wanted at positions 5 x 3; give them as 3 x n"):
        fw.load(top).compile()
