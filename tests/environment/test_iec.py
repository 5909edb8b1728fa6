"""Conditions of IEC 61400-1 and 61400-3-1: formulas by hand, and the kinds of wind and sea that are made of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import ExtremeWave, NormalSea, Sea, SevereSea, Wind, World, iec
from fowtlib.components.environment.wind.transient import rotor_diameter
from fowtlib.language import Array, Component, ModelError, eq, outer, var
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

SIZES = ("B", 126.0, 90.0)  # turbulence class, rotor diameter, hub height: Lambda_1 = 42 m, D/Lambda_1 = 3
PLACES = np.array([[0, 30, 90], [0, -30, 150], [0, 90, 30], [40, 30, 61]], dtype=float)


# --- formulas -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wind_class", "reference", "average", "gust", "yearly"),
    [("I", 50, 10, 70, 56), ("II", 42.5, 8.5, 59.5, 47.6), ("III", 37.5, 7.5, 52.5, 42)],
)
def test_wind_classes(wind_class, reference, average, gust, yearly):
    """Table 1, and the speeds that the standard's models make of it."""
    assert iec.REFERENCE_SPEED[wind_class] == reference
    assert iec.average_speed(reference) == pytest.approx(average)
    assert iec.extreme_speed(reference) == pytest.approx(gust)
    assert iec.extreme_speed(reference, 1) == pytest.approx(yearly)
    assert iec.extreme_speed(reference, 50, turbulent=True) == pytest.approx(reference)
    assert iec.extreme_speed(reference, 1, turbulent=True) == pytest.approx(0.8 * reference)


@pytest.mark.parametrize(("name", "intensity"), [("A+", 0.18), ("A", 0.16), ("B", 0.14), ("C", 0.12)])
def test_turbulence_classes(name, intensity):
    assert iec.normal_turbulence(15.0, name) == pytest.approx(intensity * 16.85)  # 0.75 * 15 + 5.6
    assert iec.normal_turbulence(4.0, name) == pytest.approx(intensity * 8.6)


@pytest.mark.parametrize(
    ("wind", "printed", "exact"),
    [(11, 0.18, 0.176), (13, 0.17, 0.165), (21, 0.14, 0.142), (25, 0.14, 0.136), (36, 0.13, 0.127), (50, 0.12, 0.121)],
)
def test_turbulence_of_published_states(wind, printed, exact):
    """Intensities of class B in the tables of Hegseth et al. (2019 to 2021), to the two digits printed."""
    found = iec.normal_turbulence(float(wind), "B") / wind
    assert round(found, 2) == printed and found == pytest.approx(exact, abs=6e-4)


def test_the_distribution_of_the_turbulence():
    """C = 0.14 * 14.55, k = 5.45 at 15 m/s, where I_ref is the 70 % quantile; the 90 % one is about sigma_1."""
    assert iec.turbulence_distribution(15.0, "B") == pytest.approx((2.037, 5.45))
    assert iec.turbulence_quantile(15.0, "B", 1 - math.exp(-1)) == pytest.approx(2.037)
    assert iec.turbulence_quantile(15.0, "B", 0.7) / 15 == pytest.approx(0.14, rel=4e-3)
    assert iec.turbulence_quantile(5.0, "A+", 0.9) == pytest.approx(1.7186, rel=1e-4)  # 1.269 * 1.354299; 1.683
    for speed in (10.0, 15.0, 25.0):
        exact = iec.turbulence_quantile(speed, "A+", 0.9)
        assert exact == pytest.approx(iec.normal_turbulence(speed, "A+"), rel=0.011)
    median = Wind(kind="ntm", mean_speed=15.0, quantile=0.5)
    assert median.standard_deviation() == pytest.approx(2.037 * math.log(2) ** (1 / 5.45))


@pytest.mark.parametrize(
    ("value", "by_hand"),
    [
        # c I_ref (0.072 (V_ave/c + 3) (V/c - 4) + 10): 0.28 (0.072 * 8 * 1.7 + 10), 0.36 (0.072 * 6.75 * 6 + 10)
        (iec.extreme_turbulence(11.4, "B", 50.0), 3.074176),
        (iec.extreme_turbulence(20.0, "A+", 37.5), 4.649760),
        # sigma_1 = 0.14 * 14.6 = 2.044 m/s at 12 m/s
        (iec.operating_gust(12.0, *SIZES), 3.3 * 2.044 / 1.3),
        (iec.operating_gust(50.0, *SIZES), 1.35 * 6.0),
        (iec.operating_gust(12.0, "A", 80.0, 50.0), 3.3 * 0.16 * 14.6 / (1 + 8 / 35)),
        (math.degrees(iec.direction_change(12.0, *SIZES)), 29.858771),  # 4 atan(2.044 / 15.6)
        (math.degrees(iec.direction_change(25.0, "A+", 80.0, 50.0)), 32.485637),  # 4 atan(4.383 / (25 * 1.228571))
        (math.degrees(iec.direction_change(1.0, "A+", 0.0)), 180.0),  # 4 atan(1.143) is more than a half turn
        (math.degrees(iec.coherent_direction(3.9)), 180.0),
        (math.degrees(iec.coherent_direction(4.0)), 180.0),
        (math.degrees(iec.coherent_direction(25.0)), 28.8),
        # (2.5 + 0.2 * 6.4 * 2.044 * 3^(1/4)) / 126, 3^(1/4) = 1.316074
        (126 * iec.extreme_shear(12.0, *SIZES), 5.943264),
        # (2.5 + 1.28 * 0.18 * 24.35 * (80/35)^(1/4)) / 80, the root 1.229574
        (80 * iec.extreme_shear(25.0, "A+", 80.0, 50.0), 9.398202),
        (iec.ONE_HOUR, round(math.sqrt(math.log(1000) / math.log(1000 / 3)), 2)),
        (iec.HIGHEST_WAVE, round(math.sqrt(math.log(1000) / 2), 2)),
        (iec.design_wave_period(10.0, 0.0), 11.208891),  # 11.1 * 1.00980999
        (iec.design_wave_period(10.0, 1.0), 14.440283),
    ],
)  # fmt: skip
def test_formulas_by_hand(value, by_hand):
    assert value == pytest.approx(by_hand, rel=2e-6)


def test_what_the_formulas_do_not_know():
    with pytest.raises(ModelError, match="turbulence class 'D' is not one of A\\+, A, B, C"):
        iec.normal_turbulence(10, "D")
    with pytest.raises(ModelError, match="extreme wind of 100 years; take 50 or 1"):
        iec.extreme_speed(50.0, 100)
    with pytest.raises(ModelError, match="lies between 0 and 1, and 1 does not"):
        iec.turbulence_quantile(10.0, "B", 1.0)
    with pytest.raises(ModelError, match="mean speed above zero"):
        iec.direction_change(0.0)
    with pytest.raises(ModelError, match="rotor diameter above zero"):
        iec.extreme_shear(10.0, "B", 0.0)


# --- kinds of wind ------------------------------------------------------------------------------------------------


class Vane(Component):
    """What the wind is at some places, over its second station."""

    wind: Wind = outer(Wind)
    felt: Array = var(unit="m/s", shape=(12,), doc="wind at the places")

    def equations(self):
        return [eq(self.felt, m.vec(self.wind.velocity(PLACES.T, 1)))]


@pytest.fixture(scope="module")
def plant():
    top = fw.Assembly("vane")
    top.world, top.wind, top.vane = World(), Wind(stations=[[-30, 80], [30, 90]]), Vane()
    top.sea = Sea()
    return fw.load(top).compile()


def events():
    """Parameters; turn, gust and gradients [up, across] over the time since the start, by the text of the standard."""
    g, theta = 5.943264 / 126, math.radians(29.858771)

    def rise(t, T):
        return 0.5 * (1 - np.cos(np.pi * np.clip(t, 0, T) / T))

    def bulge(t, T):
        return 1 - np.cos(2 * np.pi * np.clip(t, 0, T) / T)

    def gust(t):
        s = np.clip(t, 0, 10.5)
        return -0.37 * 3.3 * 2.044 / 1.3 * np.sin(3 * np.pi * s / 10.5) * (1 - np.cos(2 * np.pi * s / 10.5))

    nothing = {"turn": 0, "gust": 0, "up": 0, "across": 0}
    return {
        "nwp": lambda t: nothing,
        "eog": lambda t: {**nothing, "gust": gust(t)},
        "edc": lambda t: {**nothing, "turn": theta * rise(t, 6)},
        "edc,sign=-1": lambda t: {**nothing, "turn": -theta * rise(t, 6)},
        "ecd": lambda t: {**nothing, "turn": math.radians(60) * rise(t, 10), "gust": 15 * rise(t, 10)},
        "ews": lambda t: {**nothing, "up": g * bulge(t, 12)},
        "ews,sign=-1": lambda t: {**nothing, "up": -g * bulge(t, 12)},
        "ews,plane=horizontal": lambda t: {**nothing, "across": g * bulge(t, 12)},
    }


@pytest.mark.parametrize("direction", [0.0, 0.4])
@pytest.mark.parametrize("name", list(events()))
def test_transient_conditions_at_points(plant, name, direction):
    """Also with a wind that blows askew, beside the rotor, and before and behind the event."""
    kind, *words = name.split(",")
    values = {"wind.kind": kind, "wind.mean_speed": 12.0, "wind.direction": direction}
    values |= {f"wind.{word.partition('=')[0]}": word.partition("=")[2] for word in words}
    if "wind.sign" in values:
        values["wind.sign"] = int(values["wind.sign"])
    if kind != "nwp":
        values["wind.start_time"] = 1.0
    if kind in ("eog", "edc", "ews"):
        values["wind.rotor_diameter"] = 126.0
    result = plant.simulate(15.0, 0.25, solver="fixed", step=0.125, parameters=values)
    time, felt = np.asarray(result["vane.felt"].time), np.asarray(result["vane.felt"]).reshape(-1, 4, 3)
    now = {key: value + 0 * time for key, value in events()[name](time - 1).items()}
    bearing = direction + now["turn"]
    across = np.cos(bearing)[:, None] * PLACES[:, 1] - np.sin(bearing)[:, None] * PLACES[:, 0]
    speed = 12 * (PLACES[:, 2] / 90) ** 0.14 + now["gust"][:, None]
    speed = speed + now["up"][:, None] * (PLACES[:, 2] - 90) + now["across"][:, None] * (across - 30)
    np.testing.assert_allclose(felt[..., 0], speed * np.cos(bearing)[:, None], atol=2e-5)
    np.testing.assert_allclose(felt[..., 1], speed * np.sin(bearing)[:, None], atol=2e-5)
    assert not felt[..., 2].any()
    np.testing.assert_allclose(np.asarray(result["wind.bearing"]), bearing, atol=2e-6)


# Numbers of the files EOGR, EDC+R, ECD+R and EWSV+12.0 that pyIECWind 0.2 (github.com/SMI-Lab-Inha/pyIECWind, after
# NREL's IECWind) makes, three decimals; rotor and hub 80 m. Times since the start; gust [m/s], turn [deg], and of EWS
# the difference of the speeds over a diameter by that at the hub.
OTHER_PROGRAM = {
    "eog": ("I", "A", 10.0, {0.4: -0.022, 1.0: -0.292, 2.5: -1.555, 3.5: 0.0, 4.5: 3.195, 5.2: 4.294, 8.0: -1.555}),
    "edc": ("III", "C", 10.0, {0.5: 0.513, 1.5: 4.406, 3.0: 15.045, 4.5: 25.683, 5.5: 29.576, 6.0: 30.089}),
    "ecd": ("III", "C", 10.0, {0.5: 0.092, 2.0: 1.432, 3.3: 3.682, 5.0: 7.5, 7.0: 11.908, 10.0: 15.0}),
    "ews": ("III", "C", 12.0, {0.5: 0.015, 2.0: 0.214, 4.0: 0.642, 6.0: 0.856, 9.0: 0.428, 11.5: 0.015}),
}


@pytest.mark.parametrize("kind", list(OTHER_PROGRAM))
def test_transient_conditions_are_those_of_another_program(plant, kind):
    """To the last digit of its files."""
    wind_class, turbulence_class, speed, expected = OTHER_PROGRAM[kind]
    values = {"wind.kind": kind, "wind.mean_speed": speed, "wind.reference_height": 80.0, "wind.start_time": 0.0}
    values |= {"wind.wind_class": wind_class} if kind == "eog" else {}
    values |= {} if kind == "ecd" else {"wind.turbulence_class": turbulence_class, "wind.rotor_diameter": 80.0}
    result = plant.simulate(12.0, 0.1, solver="fixed", step=0.1, parameters=values)
    felt = np.asarray(result["vane.felt"]).reshape(-1, 4, 3)
    change = np.linalg.norm(felt, axis=2) - np.linalg.norm(felt[0], axis=1)
    turn = np.degrees(np.asarray(result["wind.bearing"]))
    told = {"edc": turn, "ews": (change[:, 1] - change[:, 2]) / 120 * 80 / speed}.get(kind, change[:, 0])
    rows = [round(10 * time) for time in expected]
    np.testing.assert_allclose(told[rows], list(expected.values()), atol=6e-4)
    if kind == "ecd":
        assert turn[[5, 50, 100]] == pytest.approx([0.443, 36.0, 72.0], abs=6e-4)


@pytest.mark.parametrize(
    ("values", "mean", "sigma"),
    [
        ({"kind": "ntm", "mean_speed": 12.0, "turbulence_class": "A+"}, 12.0, 0.18 * 14.6),
        ({"kind": "etm", "mean_speed": 11.4}, 11.4, 3.074176),
        ({"kind": "etm", "mean_speed": 20.0, "turbulence_class": "A+", "wind_class": "III"}, 20.0, 4.64976),
        ({"kind": "ewm"}, 50.0, 5.5),
        ({"kind": "ewm", "wind_class": "II", "return_period": 1}, 34.0, 3.74),
        ({"kind": "ewm", "reference_speed": 57.0}, 57.0, 6.27),
    ],
)
def test_turbulent_conditions(values, mean, sigma):
    """The series has the variance of the model but for what its sampling leaves out, and the profile the mean."""
    wind = Wind(stations=[[0, 90], [0, 120]], repetition_period=1024.0, **values)
    assert wind.mean_at(0) == pytest.approx(mean)
    exponent = 0.11 if values["kind"] == "ewm" else 0.14
    assert wind.mean_at(1) == pytest.approx(mean * (120 / 90) ** exponent)
    assert wind.standard_deviation() == pytest.approx(sigma, rel=1e-6)
    lost = sum(fw.components.environment.turbulence.lost_variance(mean, 90.0, 0.25, 1024.0))
    assert np.var(wind.turbulence().values[:, 0]) == pytest.approx(sigma**2 * (1 - lost), rel=1e-6)


@pytest.mark.parametrize(
    ("values", "speed"),
    [({}, 70.0), ({"wind.return_period": 1}, 56.0), ({"wind.wind_class": "III", "wind.return_period": 1}, 42.0)],
)
def test_steady_extreme_wind(plant, values, speed):
    felt = plant.simulate(1.0, 1.0, solver="fixed", parameters={"wind.kind": "ewm_steady", **values})["vane.felt"]
    expected = speed * (PLACES[:, 2] / 90) ** 0.11
    np.testing.assert_allclose(np.asarray(felt).reshape(-1, 4, 3)[..., 0], [expected, expected], rtol=1e-12)


def test_the_mean_of_the_extreme_wind_is_that_of_its_class(plant):
    """Over a whole period of the turbulence, at a point; a speed that the model has had before has no part in it."""
    values = {"wind.kind": "ewm", "wind.repetition_period": 128.0, "wind.wind_class": "III"}
    result = plant.simulate(128.0, 0.25, solver="fixed", step=0.25, parameters=values)
    assert np.mean(np.asarray(result["wind.speed"])[:-1, 1]) == pytest.approx(37.5, abs=1e-6)


@pytest.mark.parametrize(
    ("wind", "words"),
    [
        ({"kind": "ewm", "mean_speed": 12.0}, "mean_speed is given .* the kind 'ewm' takes no notice"),
        ({"kind": "ewm_steady", "shear_exponent": 0.2}, "shear_exponent is given .* 'ewm_steady'"),
        ({"kind": "ecd", "mean_speed": 12.0, "turbulence_class": "A"}, "turbulence_class is given .* 'ecd'"),
        ({"kind": "ntm", "mean_speed": 12.0, "turbulence_intensity": 0.1}, "turbulence_intensity is given .* 'ntm'"),
        ({"kind": "etm", "mean_speed": 9.0, "wind_class": "I", "reference_speed": 40.0}, "reference_speed is given"),
        ({"kind": "ewm", "return_period": 10}, "there is no extreme wind of 10 years; take 50 or 1"),
    ],
)
def test_what_a_kind_does_not_take(wind, words):
    with pytest.raises(ModelError, match=words):
        Wind(**wind).mean_at(0)


def test_a_rotor_diameter_is_asked_for_where_there_is_no_rotor(plant):
    with pytest.raises(ModelError, match="wind.rotor_diameter has no value and the model has no rotor"):
        plant.simulate(1.0, parameters={"wind.kind": "edc", "wind.mean_speed": 12.0})
    turbine = fw.load("oc3_spar_rigid", set={"wind.kind": "edc"})
    assert rotor_diameter(turbine.root.wind) == pytest.approx(2 * 63.0 * math.cos(math.radians(2.5)))


# --- kinds of sea -------------------------------------------------------------------------------------------------

STATES = [[4, 1.0, 8.0], [12, 2.0, 9.0], [24, 5.0, 12.0]]


def standing(sea, plant, **more):
    """The sea as it stands in a run."""
    return plant.binding({**{f"sea.{key}": value for key, value in sea.items()}, **more}).root.sea


def test_the_normal_sea_follows_the_wind(plant):
    blows = {"wind.kind": "steady", "wind.mean_speed": 15.0}
    assert standing({"spectrum": "nss", "states": STATES}, plant, **blows).state() == pytest.approx((2.75, 9.75))
    # the wind of station 0, which is at 80 m, is the one of the table
    sheared = {"wind.kind": "nwp", "wind.mean_speed": 12.0 * (80 / 90) ** -0.14}
    assert standing({"spectrum": "nss", "states": STATES}, plant, **sheared).state() == pytest.approx((2.0, 9.0))
    given = NormalSea(states=STATES, wind_speed=8.0)
    assert given.state() == pytest.approx((1.5, 8.5))
    severe = SevereSea(states=STATES, wind_speed=12.0)
    assert severe.state() == pytest.approx((2.0, 9.0))


@pytest.mark.parametrize(
    ("sea", "height", "period"),
    [
        ({"spectrum": "sss", "significant_wave_height": 10.0}, 10.0, 12.7 * 1.00980999),
        ({"spectrum": "sss", "significant_wave_height": 10.0, "peak_period": 15.0}, 10.0, 15.0),
        ({"spectrum": "ess", "height_50": 10.0}, 10.0, 12.7 * 1.00980999),
        ({"spectrum": "ess", "height_50": 10.0, "hours": 1}, 10.9, 12.7 * 1.00980999),
        ({"spectrum": "ess", "height_50": 10.0, "height_1": 7.0, "return_period": 1, "peak_period": 11.0}, 7.0, 11.0),
        ({"spectrum": "ess", "height_50": 10.0, "period_choice": "short"}, 10.0, 11.208891),
    ],
)
def test_severe_and_extreme_seas(plant, sea, height, period):
    waves = standing(sea, plant)
    assert waves.state() == pytest.approx((height, period), rel=1e-6)
    omega = np.linspace(0.01, 12, 20001)
    variance = np.trapezoid(waves.spectral_density(omega), omega)
    assert variance == pytest.approx(height**2 / 16, rel=2e-3)
    peak = omega[np.argmax(waves.spectral_density(omega))]
    assert peak == pytest.approx(2 * math.pi / period, rel=2e-3)


def test_the_extreme_wave(plant):
    wave = standing({"spectrum": "ewh", "height_50": 10.0, "period_choice": "long"}, plant)
    assert wave.components().amplitude == pytest.approx([9.3])
    assert wave.components().omega == pytest.approx([2 * math.pi / 14.440283])
    yearly = ExtremeWave(height_1=7.0, return_period=1, factor=1.3, wave_period=12.0)
    assert yearly.wave() == pytest.approx((9.1, 12.0))


def test_waves_that_are_not_aligned_with_the_wind(plant):
    sea = {"spectrum": "regular", "wave_height": 2.0, "wave_period": 8.0, "misalignment": "-30 deg"}
    waves = standing(sea, plant, **{"wind.kind": "nwp", "wind.mean_speed": 8.0, "wind.direction": "50 deg"})
    assert math.degrees(waves.components().heading) == pytest.approx(20)
    result = plant.simulate(4.0, 0.5, solver="fixed", step=0.25, parameters={
        **{f"sea.{key}": value for key, value in sea.items()}, "wind.direction": "50 deg"})  # fmt: skip
    assert np.asarray(result["sea.elevation"])[-1] == pytest.approx(-1.0, abs=1e-6)  # half a period: a trough
    with pytest.raises(ModelError, match="heading is given and would do nothing, because misalignment is given"):
        Sea(heading=0.1, misalignment=0.2)
    alone = fw.Assembly("sea")
    alone.world, alone.sea = World(), Sea(spectrum="regular", wave_height=1, wave_period=8, misalignment=0.1)
    with pytest.raises(ModelError, match="sea.misalignment goes by the wind, and the model has no parts of class Wind"):
        fw.load(alone).compile().simulate(1.0)


@pytest.mark.parametrize(
    ("sea", "words"),
    [
        ({"spectrum": "nss"}, "sea.states has no value; a sea of kind 'nss' needs it"),
        ({"spectrum": "nss", "states": STATES, "wind_speed": 25.0}, "wind of 4 to 24 m/s, and there is one of 25"),
        ({"spectrum": "nss", "states": [[4, 1], [8, 2]], "wind_speed": 5.0}, "give rows of wind speed, Hs and Tp"),
        ({"spectrum": "nss", "states": STATES[::-1], "wind_speed": 5.0}, "by rising speed"),
        ({"spectrum": "ess", "height_50": 10.0, "return_period": 1}, "sea.height_1 has no value"),
        ({"spectrum": "sss"}, "sea.states has no value"),
        ({"spectrum": "ess", "height_50": 9.0, "peak_period": 12.0, "period_choice": "long"}, "period_choice is given"),
        ({"spectrum": "ewh"}, "sea.height_50 has no value"),
    ],
)
def test_a_sea_that_lacks_something(sea, words):
    top = fw.Assembly("sea")
    with pytest.raises(ModelError, match=words):
        top.world, top.sea = World(), Sea(**sea)
        fw.load(top).compile().simulate(1.0)


# --- what turbines feel -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def felt():
    """Force [N] and moment [N m] of the air on a rotor of blade elements that floats, at the height of each event."""
    plant = fw.load("oc3_spar_rigid_bem", set={"sea.spectrum": "still", "wind.mean_speed": 12.0}).compile()
    loads = {}
    for kind, more in (
        ("nwp", {}),
        *[("edc", {"wind.sign": sign}) for sign in (1, -1)],
        *[("ews", {"wind.plane": plane, "wind.sign": s}) for plane in ("vertical", "horizontal") for s in (1, -1)],
    ):
        result = plant.simulate(6.0, 6.0, solver="fixed", parameters={"wind.kind": kind, **more})
        names = ("aerodynamics.force", "aerodynamics.moment", "aerodynamics.disk_wind")
        key = kind, more.get("wind.plane", ""), more.get("wind.sign", 1)
        loads[key] = [np.asarray(result[f"turbine.{name}"])[-1] for name in names]
    return loads


def test_shear_tilts_and_yaws_the_rotor(felt):
    """More wind above pushes the upper half: a moment about +y. More on the side of +y: a moment about -z."""
    calm = felt["nwp", "", 1]
    for plane, axis, sign in (("vertical", 1, 1), ("horizontal", 2, -1)):
        changes = [felt["ews", plane, s][1] - calm[1] for s in (1, -1)]
        assert changes[0][axis] * sign > 4e6  # a sixth of the thrust of 0.5 MN times the diameter is about 10 MN m
        assert changes[1][axis] == pytest.approx(-changes[0][axis], rel=0.1)
        assert abs(changes[0][3 - axis]) < 0.25 * abs(changes[0][axis])
        for s in (1, -1):
            assert felt["ews", plane, s][0][0] == pytest.approx(calm[0][0], rel=0.05)
            assert felt["ews", plane, s][2] == pytest.approx(calm[2], abs=0.1)


def test_the_turned_wind_pushes_from_the_side(felt):
    """It blows askew through the disk, thrusts less, and turns the rotor into itself: about z with its own sign."""
    calm, angle = felt["nwp", "", 1], math.radians(29.858771)
    for sign in (1, -1):
        force, moment, disk = felt["edc", "", sign]
        speed = np.hypot(*calm[2][:2])
        assert disk == pytest.approx([speed * math.cos(angle), sign * speed * math.sin(angle), 0], abs=0.05)
        assert 0.7 * calm[0][0] < force[0] < 0.95 * calm[0][0]
        assert sign * (moment[2] - calm[1][2]) > 5e5


@pytest.mark.parametrize("solver", ["fixed", "idas"])
def test_the_rotor_by_coefficients_feels_the_turn(solver):
    """The wind along the normal of a rotor that turns and leans with its platform."""
    plant = fw.load("oc3_spar_rigid", set={"sea.spectrum": "still", "wind.mean_speed": 12.0}).compile()
    result = plant.simulate(7.0, 1.0, solver=solver, parameters={"wind.kind": "edc", "wind.start_time": 0.5})
    bearing, yaw = (np.asarray(result[name]) for name in ("wind.bearing", "platform.motion.yaw"))
    pitch = np.asarray(result["platform.motion.pitch"])
    hub = np.asarray(result["wind.speed"]).ravel()
    expected = hub * np.cos(bearing - yaw) * np.cos(math.radians(5) + pitch)
    np.testing.assert_allclose(np.asarray(result["turbine.rotor.normal_wind"]), expected, rtol=1e-3)
    assert bearing[-1] == pytest.approx(math.radians(29.878), abs=1e-3)  # of a rotor of 125.88 m


@pytest.mark.parametrize(("years", "beta", "T"), [(50, 6.4, 14.0), (1, 4.8, 10.5)])
def test_the_gust_of_the_second_edition(plant, years, beta, T):
    """IEC 61400-1 (1999), 6.3.2.2, category A: sigma_1 = 0.18 (15 m/s + 2 V)/3, Lambda_1 = 21 m; by hand at 12 m/s."""
    size = beta * 0.18 * (15 + 2 * 12.0) / 3 / (1 + 0.1 * 171.2 / 21.0)
    assert iec.second_edition_gust(12.0, "A", 171.2, 90.0, years) == pytest.approx(size)
    values = {"wind.kind": "eog", "wind.edition": 2, "wind.gust_years": years, "wind.turbulence_class": "A",
              "wind.mean_speed": 12.0, "wind.rotor_diameter": 171.2, "wind.start_time": 1.0}  # fmt: skip
    result = plant.simulate(17.0, 0.125, solver="fixed", step=0.125, parameters=values)
    felt = np.asarray(result["vane.felt"]).reshape(-1, 4, 3)[..., 0]
    s = np.clip(np.asarray(result["vane.felt"].time) - 1.0, 0, T) / T
    expected = -0.37 * size * np.sin(3 * np.pi * s) * (1 - np.cos(2 * np.pi * s))
    np.testing.assert_allclose(felt[:, 0] - felt[0, 0], expected, atol=2e-5)
    assert expected.max() == pytest.approx(0.74 * size, rel=1e-3)  # half a period after it begins, between two dips


@pytest.mark.parametrize(("turbulence_class", "years"), [("C", 50), ("A", 100)])
def test_the_second_edition_knows_two_categories_and_two_periods(turbulence_class, years):
    with pytest.raises(ParameterError, match="edition 2"):
        iec.second_edition_gust(12.0, turbulence_class, years=years)
