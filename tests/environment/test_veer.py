"""Wind that turns slowly."""

import numpy as np

import fowtlib as fw
from fowtlib.components.environment import Wind, World
from fowtlib.modelfile.short_forms import WIND


def test_direction_turns_smoothly_and_stays():
    model = fw.Assembly("wind alone")
    model.world, model.wind = World(), Wind(kind="veer", mean_speed=10, direction=0.2, turn=1.5, start_time=10,
                                            turn_duration=100)  # fmt: skip
    result = fw.load(model).compile().simulate(200.0, output_step=5.0)
    t, s = np.asarray(result.time), np.clip((np.asarray(result.time) - 10) / 100, 0, 1)
    expected = 0.2 + 1.5 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    np.testing.assert_allclose(np.asarray(result["wind.bearing"]).ravel(), expected, atol=1e-6)
    np.testing.assert_allclose(np.asarray(result["wind.speed"]).ravel(), 10 + 0 * t, atol=1e-9)


def test_short_form_of_the_command_line():
    wind = WIND.parse("veer:12,by=30,at=60,within=600")
    assert wind["wind.kind"] == "veer"
    assert np.isclose(np.degrees(wind["wind.turn"]), 30)
    assert (wind["wind.start_time"], wind["wind.turn_duration"]) == (60, 600)
