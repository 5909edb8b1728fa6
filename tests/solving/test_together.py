"""Slopes of numbers by elements that move at once: those of one element after the other, or none where they mix."""

import numpy as np

from fowtlib.solving.together import slopes_together

VALUES = {"a": 2.0, "b": 3.0, "c": 0.5, "d": 1.5}
STEPS = {name: 3e-5 * value for name, value in VALUES.items()}
ALL = np.array([True])


def numbers(a, b, c, d):
    return {"one": np.array([a**2, np.sin(b), 7.0]), "two": np.array([c * a, d**3])}


SLOPES = {  # by hand
    "a": {"one": [4.0, 0, 0], "two": [0.5, 0]},
    "b": {"one": [0, np.cos(3.0), 0]},
    "c": {"two": [2.0, 0]},
    "d": {"two": [0, 6.75]},
}
MATTERED = {name: {key: np.array(slope) != 0 for key, slope in found.items()} for name, found in SLOPES.items()}


def together(compute, mattered=MATTERED, calls=None):
    def computed(shifts, keys):
        if calls is not None:
            calls.append(sorted(shifts))
        found = compute(**{name: value + shifts.get(name, 0.0) for name, value in VALUES.items()})
        return [found[key] for key in keys]

    return slopes_together(STEPS, mattered, compute(**VALUES), computed)


def test_elements_that_matter_to_different_numbers_move_at_once():
    calls = []
    found = together(numbers, calls=calls)
    for name, slopes in SLOPES.items():
        assert found[name].keys() == slopes.keys()
        for key, slope in slopes.items():
            np.testing.assert_allclose(found[name][key], slope, rtol=1e-8, atol=1e-12)
    # two groups, a with b and d, and c, each to both sides; then all at once
    assert calls == [["a", "b", "d"]] * 2 + [["c"]] * 2 + [["a", "b", "c", "d"]] * 2


def test_a_number_that_belonged_to_none_is_seen():
    assert together(lambda a, b, c, d: numbers(a, b, c, d) | {"one": np.array([a**2, np.sin(b), 7 + 1e-6 * a])}) is None


def test_a_number_that_now_follows_from_two_that_moved_at_once_is_seen():
    def mixed(a, b, c, d):
        return numbers(a, b, c, d) | {"one": np.array([a**2 + 1e-4 * b, np.sin(b), 7.0])}

    assert together(mixed) is None
    apart = MATTERED | {"b": {"one": np.array([True, True, False])}}
    np.testing.assert_allclose(together(mixed, apart)["b"]["one"], [1e-4, np.cos(3.0), 0], rtol=1e-6)


def test_a_number_that_no_longer_follows_has_no_slope():
    found = together(lambda a, b, c, d: numbers(a, b, c, d) | {"two": np.array([c * a, 1.0])})
    assert not found["d"]["two"].any()


def test_a_kink_is_left_to_those_who_move_one_by_one():
    assert together(lambda a, b, c, d: numbers(a, b, c, d) | {"two": np.array([c * a, abs(d - 1.5)])}) is None


def test_all_of_a_key_may_belong_to_an_element():
    found = together(numbers, {"a": {"one": ALL, "two": ALL}, "b": {"one": ALL}, "c": {"two": ALL}, "d": {"two": ALL}})
    np.testing.assert_allclose(found["a"]["two"], [0.5, 0.0], rtol=1e-8)
