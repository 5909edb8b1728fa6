"""Events that parts offer: carried out at a time or at a crossing, by both engines, without making the model anew."""

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import (
    Component,
    OfferedEvent,
    Scalar,
    assign,
    der,
    eq,
    event,
    on,
    param,
    reinit,
    var,
    when,
)
from fowtlib.language.errors import ModelError, NotFoundError, ParameterError, StructureError, UnitError
from fowtlib.solving import Conditions, Event, Result


class Cart(Component):
    """x'' = push - pull x."""

    usual: Scalar = param(default=2.0, unit="m/s^2", doc="push when an event does not say it")
    pull: Scalar = param(default=0.0, unit="1/s^2", doc="pull back")

    shove: OfferedEvent = event(
        doc="the push changes", size=param(default=usual, unit="m/s^2", min=0, max=100, doc="new push"),
        share=param(default=1.0, doc="of it"),
    )  # fmt: skip
    stop: OfferedEvent = event(doc="it stands still at once, and stays where it is")

    x: Scalar = var(unit="m", start=0.0, fixed=True, state="always", doc="place")
    v: Scalar = var(unit="m/s", start=1.0, fixed=True, state="always", doc="speed")
    push: Scalar = var(unit="m/s^2", discrete=True, start=0.0, doc="push")
    free: Scalar = var(discrete=True, start=1.0, doc="0 where it has stopped")
    since: Scalar = var(unit="s", discrete=True, start=0.0, doc="time of the last event")

    def equations(self):
        return [
            eq(der(self.x), self.free * self.v),
            eq(der(self.v), self.free * (self.push - self.pull * self.x)),
            on(self.shove, assign(self.push, self.shove.share * self.shove.size), assign(self.since, self.time)),
            on(self.stop, assign(self.free, 0.0), assign(self.since, self.time), reinit(self.v, 0.0)),
        ]


@pytest.fixture(scope="module")
def plant():
    model = fw.Assembly("two carts")
    model.left, model.right = Cart(), Cart(pull=4.0)
    return fw.load(model).compile()


SOLVERS = [("idas", {"tolerance": 1e-9}), ("fixed", {"step": 0.01, "rho_inf": 1.0})]


def simulated(plant, solver, events, end=3.0, step=0.1, **more):
    name, settings = solver
    return plant.simulate(end, step, solver=name, events=events, **settings, **more)


@pytest.mark.parametrize("solver", SOLVERS)
def test_an_event_at_a_time_between_output_points(plant, solver):
    result = simulated(plant, solver, [Event("left.shove", at="1.234 s", values={"size": 3})])
    t = result.time
    late = np.maximum(t - 1.234, 0)
    np.testing.assert_allclose(result["left.x"], t + 1.5 * late**2, atol=1e-6)
    np.testing.assert_allclose(result["left.v"], 1 + 3 * late, atol=1e-6)
    assert result.attributes["events"] == "t = 1.234 s: left.shove"


@pytest.mark.parametrize("solver", SOLVERS)
def test_an_event_at_a_crossing(plant, solver):
    """X = sin(2 t) / 2 of the right cart rises above 0.3 at asin(0.6) / 2, and it stops there."""
    result = simulated(plant, solver, ["right.stop when right.x > 30 cm"])
    instant = math.asin(0.6) / 2
    assert result["right.since"][-1] == pytest.approx(instant, abs=1e-5)
    assert result["right.x"][-1] == pytest.approx(0.3, abs=1e-9)
    assert result["right.v"][-1] == 0.0 == result["left.since"][-1]


def test_a_condition_that_holds_at_the_start_is_waited_for_again(plant):
    """X = sin(2 t) / 2 is below 0.1 at the start; it falls below it anew at (pi - asin(0.2)) / 2."""
    result = simulated(plant, SOLVERS[0], ["right.stop when right.x < 0.1"])
    assert result["right.since"][-1] == pytest.approx((math.pi - math.asin(0.2)) / 2, abs=1e-7)


def test_events_of_one_instant_come_in_their_order_and_one_at_the_start_before_the_first_point(plant):
    events = ["left.shove at 0, size=1", "left.shove at 2 s", "left.shove at 2 s, size=5, share=0.5"]
    result = simulated(plant, SOLVERS[1], [*events, "left.stop at 3 s"])
    assert result["left.push"][0] == 1 and result["left.push"][-1] == 2.5
    assert result["left.v"][20] == pytest.approx(3.0) and result["left.v"][-1] == 0.0
    lines = result.attributes["events"].splitlines()
    assert lines == [f"t = {t} s: left.{name}" for t, name in ((0, "shove"), (2, "shove"), (2, "shove"), (3, "stop"))]


def test_a_default_follows_the_parameters_of_the_run(plant):
    result = simulated(plant, SOLVERS[1], ["left.shove at 1 s"], parameters={"left.usual": 7})
    assert result["left.push"][-1] == 7.0


def test_an_event_may_set_off_a_when_and_another_event(plant):
    class Alarm(Component):
        rung: Scalar = var(discrete=True, start=0.0, doc="1 once the push has been large")

        def equations(self):
            return [when(self.cart.push > 1.5, assign(self.rung, 1.0))]

    model = fw.Assembly("watched")
    model.cart = Cart()
    Alarm.cart = property(lambda self: model.cart)
    model.alarm = Alarm()
    result = fw.load(model).compile().simulate(
        2, 0.1, solver="idas", events=["cart.shove at 0.55 s", "cart.stop when alarm.rung > 0.5"]
    )  # fmt: skip
    assert result["alarm.rung"][6] == 1.0 and result["cart.since"][-1] == pytest.approx(0.55)
    assert result["cart.x"][-1] == pytest.approx(0.55, abs=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("end", [1.0, 1.3, 1.62, 2.0])
def test_a_run_goes_on_across_events_bit_for_bit(plant, solver, end, tmp_path):
    events = ["left.shove at 1.3 s", "right.stop when right.x < -0.05", "left.stop when left.v > 2.5 m/s"]
    whole = simulated(plant, solver, events)
    assert len(whole.attributes["events"].splitlines()) == 3
    with pytest.warns(UserWarning, match="did not happen"):
        first = simulated(plant, solver, events, end=end)
    first.save(tmp_path / "first.nc")
    first = Result.open(tmp_path / "first.nc", plant)
    joined = first.followed_by(simulated(plant, solver, events, start=first))
    for name in ("left.x", "left.v", "right.x", "right.v", "left.since", "right.since"):
        np.testing.assert_array_equal(joined[name], whole[name])
    assert joined.attributes["events"] == whole.attributes["events"]


def test_a_run_goes_on_with_other_events_and_what_has_happened_stays_so(plant):
    events = ["left.shove at 1 s", "right.stop when right.x > 0.3"]
    first = simulated(plant, SOLVERS[1], events, end=2)
    with pytest.warns(UserWarning, match="events was"):
        later = simulated(plant, SOLVERS[1], [*events, "left.stop at 2.5 s"], start=first)
    assert later["left.push"][0] == 2.0 and later["right.v"][-1] == 0.0
    assert later.attributes["events"].splitlines()[:2] == first.attributes["events"].splitlines()
    assert later.attributes["events"].splitlines()[2:] == ["t = 2.5 s: left.stop"]


def test_nothing_is_flattened_or_compiled_for_an_event(plant, monkeypatch):
    simulated(plant, SOLVERS[1], ())
    dae, code = plant.dae, plant.code
    monkeypatch.setattr("fowtlib.solving.engines.fixed_step_code.FixedStepCode.__init__", None)
    without = simulated(plant, SOLVERS[1], ())
    simulated(plant, SOLVERS[1], ["left.shove at 1 s", "right.stop when right.x > 0.3"])
    again = simulated(plant, SOLVERS[1], ())
    assert plant.dae is dae and plant.code is code
    np.testing.assert_array_equal(again["left.x"], without["left.x"])


def test_conditions_carry_events_and_what_is_given_beside_them_counts_more(plant):
    conditions = Conditions(events=["left.stop at 1 s"], duration=2, output_step=0.1)
    assert conditions.events == (Event("left.stop", at=1),)
    assert plant.simulate(conditions=conditions)["left.x"][-1] == pytest.approx(1.0)
    assert plant.simulate(conditions=conditions, events=())["left.x"][-1] == pytest.approx(2.0)


def test_an_event_in_plain_data_and_in_one_line_is_the_same():
    written = Event("left.shove", at=100, values={"size": "3 m/s^2"})
    assert Event.from_plain(written.plain()) == written == Event.parse("left.shove at 100 s, size=3 m/s^2")
    waiting = Event("left.stop", when="left.x > 3 m")
    assert Event.from_plain(waiting.plain()) == waiting == Event.parse("left.stop when left.x > 3 m")


WRONG = [
    ("left.jump at 1 s", NotFoundError, "no event 'left.jump'.* left.shove, left.stop, right.shove, right.stop"),
    ("left.shoove at 1 s", NotFoundError, "did you mean 'left.shove'"),
    ("shove at 1 s", ParameterError, "at 2 places; say at which: left.shove, right.shove"),
    ("left.shove at 1 s, sise=3", ParameterError, "no value 'sise'; did you mean 'size'"),
    ("left.stop at 1 s, size=3", ParameterError, "it takes no values"),
    ("left.shove at 1 s, size=3 kg", ParameterError, "size"),
    ("left.shove at 1 s, size=-1", ParameterError, "size = -1, and it must be 0 to 100"),
    ("left.shove at 1 s, size=", ParameterError, "'size' has no value"),
    ("left.shove at noon", ParameterError, "at"),
    ("left.shove at -1 s", ParameterError, "before the start of the run"),
    ("left.shove", ParameterError, "no event; write"),
    ("left.stop when left.y > 3", NotFoundError, "no result or variable 'left.y'; did you mean 'left.x'"),
    ("left.stop when left.x > 3 kg", ParameterError, "when"),
    ("left.stop when left.x = 3", ParameterError, "no condition"),
]


@pytest.mark.parametrize(("text", "kind", "message"), WRONG)
def test_what_cannot_be_is_refused_before_the_run(plant, text, kind, message):
    with pytest.raises(ModelError, match=message) as caught:
        simulated(plant, SOLVERS[1], [text])
    assert isinstance(caught.value, (kind, UnitError))


@pytest.mark.parametrize("entries", [{"at": 1}, {"event": "a.b"}, {"event": "a.b", "at": 1, "when": "x > 1"}, 3])
def test_plain_data_that_is_no_event(entries):
    with pytest.raises(ParameterError):
        Event.from_plain(entries, "spar.yaml:7")


def test_a_result_with_a_unit_of_its_own_is_compared_with_one():
    root = fw.Assembly("cart")
    root.cart = Cart()
    plant = fw.Model(root, outputs={"place": fw.Output("cart.x", "cm")}).compile()
    with pytest.raises(ParameterError, match="given in cm; say the unit: 3 cm"):
        plant.simulate(1, 0.1, events=["cart.stop when place > 3"])
    result = plant.simulate(1, 0.1, events=["cart.stop when place > 3 cm"])
    assert result.attributes["events"] == "t = 0.03 s: cart.stop (place > 3 cm)"


def test_what_an_author_gets_wrong():
    class Silent(Cart):
        burst: OfferedEvent = event(doc="nobody answers")

    model = fw.Assembly("m")
    model.part = Silent()
    with pytest.raises(StructureError, match="part.burst is offered, and its equations do not say"):
        fw.load(model).compile()
    with pytest.raises(TypeError, match="declared by param"):
        event(doc="a value without default", size=param(unit="m"))
    with pytest.raises(StructureError, match="on\\(\\) takes an event"):
        on("burst")


def test_what_is_offered_is_listed(plant):
    first, second, *_ = plant.offered_events()
    assert (first.path, first.values[0][:3]) == ("left.shove", ("size", 2.0, "m/s^2"))
    assert (second.path, second.values) == ("left.stop", ())
    assert fw.load(plant.root).check().dimensions.ok


def test_a_state_holds_what_has_happened(plant):
    result = simulated(plant, SOLVERS[1], ["left.shove at 1 s"])
    going_on = plant.simulate(1, 0.1, start={"left.push": result["left.push"][-1]}, solver="fixed")
    assert going_on["left.v"][-1] == pytest.approx(3.0)


def test_a_star_in_a_name_means_every_place(plant):
    result = simulated(plant, SOLVERS[1], ["*.shove at 1 s, size=3", "*t.stop when left.x > 2"])
    lines = result.attributes["events"].splitlines()
    assert [line.partition(": ")[2].split()[0] for line in lines] == [
        "left.shove", "right.shove", "left.stop", "right.stop"
    ]  # fmt: skip
    with pytest.raises(NotFoundError, match="there is no event 'middle"):
        plant.timeline(["middle*.shove at 1 s"])
    with pytest.raises(ParameterError, match="at all of them"):
        plant.timeline(["shove at 1 s"])
