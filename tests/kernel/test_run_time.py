"""Data bound when a run starts: one flattening and one compilation, as many data as there are runs."""

import hashlib
import os

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import (
    Assembly,
    Component,
    ModelError,
    Scalar,
    Series,
    at_start,
    der,
    eq,
    open_input,
    outer,
    param,
    run_time_series,
    var,
)
from fowtlib.language.native import compiler


class Push(Component, selector="kind", shared=("force",)):
    """A push and its mean, which is where a cart starts."""

    kind: str = param(default="none", bound=True, doc="kind of push")
    strength: Scalar = param(default=1.0, min=0, doc="factor of the push")
    columns: int = param(default=1, doc="number of pushes")

    def series(self) -> Series | None:
        return None

    def mean(self) -> float:
        return 0.0

    def force(self, owner: Component):
        series = run_time_series(self.time, self.columns, "push", lambda push: push.series(), of=self)
        return self.strength * sum(series[i] for i in range(self.columns))


class NoPush(Push, kind="none"):
    """Nothing pushes."""


class RandomPush(Push, kind="random"):
    """Random samples."""

    seed: int = param(default=1, bound=True, doc="number of the realisation")
    scale: float = param(default=1.0, bound=True, min=0, doc="size")

    def series(self):
        values = self.scale * np.random.default_rng(self.seed).normal(size=(64, self.columns))
        return Series.samples(values, 0.25, periodic=True)

    def mean(self):
        return float(self.seed)


class FilePush(Push, kind="file"):
    """Samples of a file."""

    file: str = param(default="", bound=True, doc="file of numbers")

    def series(self):
        return Series.samples(np.loadtxt(self.file), 0.5, interpolation="linear")


class HumpPush(Push, kind="hump"):
    """A short hump."""

    begin: float = param(default=2.0, bound=True, doc="when it begins")

    def series(self):
        hump = [(0.0, 0.5 * self.parameter_value("strength")), (2 * np.pi, -0.5 * self.parameter_value("strength"))]
        return Series.transition(self.begin, 0.2, np.zeros(self.columns), np.zeros(self.columns), harmonics=hump)


class OpenPush(Push, kind="open"):
    """A push from outside."""

    def force(self, owner):
        return open_input("push", 1, "N", "push from outside")


class Cart(Component):
    """A cart that is pushed against a damper."""

    damping: Scalar = param(default=0.5, min=0, doc="damper")
    push: Push = outer(Push)
    v: Scalar = var(doc="speed")
    start: Scalar = var(state="prefer", doc="where it started")

    def equations(self):
        first = at_start("first", 1, "1", "start", lambda cart: cart.push.mean() * cart.parameter_value("damping"))
        return [
            eq(der(self.v), self.push.force(self) - self.damping * self.v + 0.01 * first),
            eq(self.start, first),
        ]


def model(**push):
    top = Assembly()
    top.push = Push(**push)
    top.cart = Cart()
    return top


def fresh(root, **changes):
    return fw.load(root).with_parameters(changes).compile().simulate(4, 0.1, solver="fixed")


def test_one_plant_for_all_data(tmp_path, counted):
    path = tmp_path / "push.txt"
    np.savetxt(path, np.sin(np.arange(12)))
    plant = fw.load(model()).compile()
    cases = [
        {},
        {"push.kind": "random"},
        {"push.kind": "random", "push.seed": 5, "push.scale": 2.0, "push.strength": 3.0},
        {"push.kind": "hump", "push.begin": 1.0, "cart.damping": 0.1},
        {"push.kind": "file", "push.file": str(path)},
    ]
    results = [plant.simulate(4, 0.1, solver="fixed", parameters=case) for case in cases]
    assert counted == {"flattened": 1, **dict.fromkeys(("written", "compiled"), int(bool(compiler())))}
    speeds = [result["cart.v"] for result in results]
    for case, speed, result in zip(cases, speeds, results, strict=True):
        expected = fresh(model(), **case)
        np.testing.assert_allclose(speed, expected["cart.v"], rtol=0, atol=1e-13)
        assert (
            result["cart.start"][0]
            == expected["cart.start"][0]
            == (case.get("push.seed", 1) * case.get("cart.damping", 0.5) if case.get("push.kind") == "random" else 0)
        )
    assert len({float(speed[-1]) for speed in speeds}) == len(cases)


@pytest.mark.parametrize("when", ["same time and size", "same time, another size", "later"])
def test_data_that_change_between_two_runs(tmp_path, when):
    """A copy with the old time of the file is read, too, and a result names what it was computed from."""
    path, told = tmp_path / "push.txt", []
    np.savetxt(path, np.ones(12), fmt="%.3f")
    os.utime(path, (1e9, 1e9))
    plant = fw.load(model()).compile()
    for strength in (1.0, 3.0):
        np.savetxt(path, np.full(12, strength), fmt="%.5f" if strength == 3 and "another" in when else "%.3f")
        if when != "later":
            os.utime(path, (1e9, 1e9))
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        parameters = {"push.kind": "file", "push.file": str(path)}
        result = plant.simulate(
            1, 0.1, solver="fixed", parameters=parameters, progress=lambda *_: path.write_text("5.0\n" * 12)
        )
        assert result.attributes["data"] == {"push.file": f"push.txt sha256:{digest}"}
        assert result.attributes["structure"]["push.file"] == f"push.txt sha256:{digest}"
        told.append(float(result["cart.v"][-1]))
    assert told[1] == pytest.approx(3 * told[0], rel=1e-6)


def test_a_part_takes_the_place_of_another(counted):
    plant = fw.load(model(strength=2.0, columns=3)).compile()
    result = plant.simulate(4, 0.1, solver="fixed", parts={"push": RandomPush(seed=7)})
    assert counted == {"flattened": 1, **dict.fromkeys(("written", "compiled"), int(bool(compiler())))}
    expected = fresh(
        model(kind="random", seed=7, strength=2.0, columns=3)
    )  # what was not given: from the old
    np.testing.assert_allclose(result["cart.v"], expected["cart.v"], rtol=0, atol=1e-13)
    state = plant.initial_state({"push": RandomPush(seed=7)})
    assert state["cart.start"] == 3.5
    assert plant.initial_state()["cart.start"] == 0


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"push.kind": "open"}, "OpenPush has force.. of its own"),
        ({"push": OpenPush()}, "OpenPush has force.. of its own"),
        (
            {"push": Cart()},
            "push: a Cart cannot take the place of a NoPush in a compiled model, where only a Push fits",
        ),
        ({"cart": Cart()}, "only the part it was compiled with fits"),
        ({"pull": RandomPush()}, "no part 'pull' to be replaced"),
        (
            {"push": RandomPush(columns=2)},
            "push.columns decides about the equations: .* with 1, and the RandomPush has 2",
        ),
        ({"push.kind": "rondom"}, "push.kind = 'rondom' is not one of none, random, file, hump, open"),
        ({"push.kind": "random", "push.begin": 1.0}, "no parameter 'begin'; it belongs to the kind hump"),
        ({"push.kind": "random", "push.scale": -1.0}, "push.scale = -1 is below its minimum"),
        ({"push.kind": "random", "push.seed": 0.5}, "push.seed: got 0.5, and a whole number is expected"),
        ({"push.columns": 2}, "tunable parameter 'push.columns'"),
        ({"push.strength": -1}, "below its minimum"),
    ],
)
def test_what_cannot_be_bound(parameters, words):
    plant = fw.load(model()).compile()
    with pytest.raises(ModelError, match=words):
        plant.simulate(1, 0.1, parameters=parameters)


def test_kinds_are_classes():
    assert type(Push()) is NoPush
    push = Push(kind="random", seed=3)
    assert type(push) is RandomPush
    assert push.kind == "random"
    push.kind = "hump"
    assert type(push) is HumpPush
    with pytest.raises(ModelError, match="NoPush.* has no parameter 'seed'; it belongs to the kind random"):
        Push(seed=3)
    with pytest.raises(ModelError, match="RandomPush is of the kind 'random'"):
        RandomPush(kind="hump")


def test_a_part_keeps_its_own_kind():
    plant = fw.load(model(kind="random", seed=4)).compile()
    bound = plant.binding({"push": NoPush()})
    assert (type(bound.root.push), bound.root.push.kind) == (NoPush, "none")
    assert plant.initial_state({"push": NoPush()})["cart.start"] == 0


def test_a_compiled_plant_does_not_follow_its_model():
    top = model(kind="random", seed=4)
    plant = fw.load(top).compile()
    before = plant.simulate(2, 0.1)["cart.v"]
    top.push.seed = 5
    np.testing.assert_array_equal(plant.simulate(2, 0.1)["cart.v"], before)
    assert plant.initial_state()["cart.start"] == 2.0


def test_a_run_past_the_end_of_its_data_stops(tmp_path):
    path = tmp_path / "push.txt"
    np.savetxt(path, np.ones(5))
    plant = fw.load(model()).compile()
    long = {"push.kind": "file", "push.file": str(path)}
    with pytest.raises(ModelError, match="push at time = 2.1, and the table covers 0 to 2"):
        plant.simulate(4, 0.1, parameters=long)
    np.savetxt(path, np.ones(9))  # the file has changed: it is read again
    assert plant.simulate(4, 0.1, parameters=long)["cart.v"][-1] == pytest.approx((1 - np.exp(-2)) / 0.5, rel=1e-4)


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_nothing_steps_over_what_is_short(solver):
    plant = fw.load(model()).compile()
    options = {"step": 0.01} if solver == "fixed" else {}
    hump = {"push.kind": "hump", "push.begin": 50.03, "cart.damping": 0.0}
    result = plant.simulate(100, 10, solver=solver, parameters=hump, tolerance=1e-8, **options)
    assert result["cart.v"][-1] == pytest.approx(0.5 * 0.2, rel=2e-5)
    assert result["cart.v"][5] == pytest.approx(0, abs=1e-12)
    assert result["cart.v"][6] == pytest.approx(0.5 * 0.2, rel=2e-5)


def test_equations_do_not_see_what_is_bound():
    class Curious(Component):
        """Looks at a seed."""

        push: Push = outer(Push)
        v: Scalar = var()

        def equations(self):
            return [eq(self.v, self.push.seed)]

    class Asking(Curious):
        """Asks for a seed."""

        def equations(self):
            return [eq(self.v, self.push.parameter_value("seed"))]

    class Holding(Curious):
        """Holds a part of the model that is flattened."""

        def equations(self):
            push = self.push
            return [eq(self.v, at_start("mean", compute=lambda it: push.mean()))]

    for cls, words in ((Curious, "push.seed is bound when a run starts"), (Asking, "push.seed is bound"),
                       (Holding, "uses push of the model")):  # fmt: skip
        top = model(kind="random")
        top.curious = cls()
        with pytest.raises(ModelError, match=words):
            fw.load(top).compile()


def test_what_is_built_does_not_depend_on_what_is_bound():
    top = Assembly()
    top.source = Cart2(number=2)
    top.push = Push(columns=top.source.number)
    top.cart = Cart()
    with pytest.raises(ModelError, match="push.columns decides how the model is built, and cannot depend on source"):
        fw.load(top).compile()


class Cart2(Component):
    """Has a number that is bound."""

    number: Scalar = param(default=1, bound=True, doc="number")


def test_linear_models_and_states_of_bound_runs():
    plant = fw.load(model()).compile()
    data = {"push.kind": "random", "push.seed": 6}
    with pytest.raises(ModelError, match="the equations depend on time through cart"):
        plant.equilibrium(data)
    assert plant.equilibrium()["cart.v"] == pytest.approx(0)
    state = plant.initial_state(data)
    linear = plant.linearize(state, ["push.strength"], ["cart.v"])
    push = RandomPush(seed=6).series()(0.0)[0]
    assert linear.B[0, 0] == pytest.approx(push)


def test_a_run_goes_on_with_its_data():
    plant = fw.load(model()).compile()
    data = {"push.kind": "random", "push.seed": 9}
    whole = plant.simulate(4, 0.1, solver="fixed", parameters=data)
    first = plant.simulate(2, 0.1, solver="fixed", parameters=data)
    rest = plant.simulate(4, 0.1, solver="fixed", parameters=data, start=first)
    assert rest["cart.v"][-1] == pytest.approx(float(whole["cart.v"][-1]), abs=1e-6)
    with pytest.raises(ModelError, match="push.seed was 9, is 8"):
        plant.simulate(4, 0.1, solver="fixed", parameters={**data, "push.seed": 8}, start=first)


def test_a_series_by_its_fourier_transform():
    """The spline through the samples whose transform is given, two signals, whatever is built up."""
    random = np.random.default_rng(4)
    samples = random.normal(size=(64, 2))
    given = Series.fourier(np.fft.rfft(samples, axis=0).T, 64, 0.25, build_up=3.0)
    same = Series.samples(samples, 0.25, periodic=True, build_up=3.0)
    t = np.linspace(-20, 40, 301)
    np.testing.assert_allclose(given(t), same(t), atol=1e-11)
    np.testing.assert_allclose(given(np.arange(16, 48) * 0.25), samples[16:48], atol=1e-11)
    with pytest.raises(ModelError, match="four or more are needed"):
        Series.fourier(np.zeros((1, 2)), 2, 0.25)
