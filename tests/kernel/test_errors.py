"""The exact words of the errors that a user of Python models meets.

In the texts below a place in this file, `kernel/test_errors.py:57`, is written as the source line found there.
"""

from __future__ import annotations

import re
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant, Gain, Sine, Sum
from fowtlib.components.mechanics import (
    AngleSource,
    FixedRotation,
    FixedTranslation,
    FreeMotion,
    Inertia,
    Prismatic,
    Revolute,
    RigidBody,
    TorqueSource,
    World,
)
from fowtlib.language import (
    Component,
    ModelError,
    RealInput,
    RealOutput,
    Scalar,
    Vector,
    assert_,
    assign,
    der,
    eq,
    external,
    fix_orientation,
    initial,
    param,
    port,
    reinit,
    sampled,
    var,
    when,
)
from fowtlib.language import math as m
from fowtlib.language.tables import table1d

LINES = Path(__file__).read_text().splitlines()


def assembly(*connections, **parts):
    model = fw.Assembly("m")
    for name, component in parts.items():
        model.add(name, component)
    for a, b in connections:
        ends = []
        for path in (a, b):
            owner, _, name = path.rpartition(".")
            ends.append(getattr(model.find(owner), name))
        model.connect(*ends)
    return model


def said(action, *arguments, **keywords):
    """What the user reads; places in this file as the line found there."""
    with pytest.raises(ModelError) as caught:
        action(*arguments, **keywords)
    return re.sub(r"kernel/test_errors\.py:(\d+)", lambda place: LINES[int(place[1]) - 1].strip(), str(caught.value))


def check(model):
    return fw.load(model).compile()


def simulate(model, t_end=3.0, **keywords):
    return check(model).simulate(t_end, output_step=0.1, **keywords)


class Case(Component):
    """A position that moves; the tests add equations."""

    stiffness: Scalar = param(default=1.0, unit="1/s^2", doc="stiffness over mass")
    period: Scalar = param(default=0.1, unit="s", doc="period of the sampled part")

    x: Scalar = var(unit="m", start=1.0, state="always", doc="position")
    v: Scalar = var(unit="m/s", state="always", doc="speed")
    held: Scalar = var(unit="m", discrete=True, doc="held position")

    def equations(self):
        return [eq(der(self.x), self.v), eq(der(self.v), -self.stiffness * self.x), *self.more()]


def case(*more):
    """A model with one Case, `c`, with more statements."""
    return assembly(c=type("Case", (Case,), {"more": lambda self: [statement(self) for statement in more]})())


def one(name="c", **members):
    """A model with one component made of declarations and `equations`; every declaration is a Scalar."""
    annotations = {key: Scalar for key, value in members.items() if key != "equations"}
    return assembly(**{name: type("One", (Component,), {"__annotations__": annotations, **members})()})


# --- parameters ---------------------------------------------------------------------------------------------------


def test_unknown_parameter():
    assert said(Inertia, inertai=2.0) == "Inertia has no parameter 'inertai'; did you mean 'inertia'?"
    model = assembly(wheel=Inertia(inertia=2.0))
    assert said(setattr, model.wheel, "w_strat", 1) == "wheel has no parameter 'w_strat'; did you mean 'w_start'?"
    assert said(fw.load(model).with_parameters, {"wheel.inertai": 1}) == (
        "set: wheel: Inertia has no parameter 'inertai'; did you mean 'inertia'?"
    )
    assert said(fw.load(model).with_parameters, {"whel.inertia": 1}) == (
        "set: the model has no part 'whel'; did you mean 'wheel'?"
    )
    assert said(simulate, case(), parameters={"c.stifness": 1}) == (
        "there is no tunable parameter 'c.stifness'; did you mean 'c.stiffness'? "
        "A structural or dependent parameter is changed in the model, before compile()."
    )


def test_unknown_attribute():
    model = assembly(wheel=Inertia(inertia=2.0))
    assert said(getattr, model.wheel, "flang_a") == (
        "wheel has no part, port, parameter or variable 'flang_a'; did you mean 'flange_a' or 'flange_b'?"
    )
    assert not hasattr(model, "wheels")


def test_missing_parameter():
    assert said(check, assembly(wheel=Inertia())) == (
        "wheel.inertia has no value: moment of inertia about the shaft [kg*m^2]. "
        "Give Inertia the parameter 'inertia'."
    )  # fmt: skip


def test_parameter_out_of_bounds():
    text = "wheel.inertia = -2 kg*m^2 is below its minimum 0 kg*m^2 (moment of inertia about the shaft)."
    assert said(check, assembly(wheel=Inertia(inertia=-2))) == text
    assert said(simulate, assembly(wheel=Inertia(inertia=2)), parameters={"wheel.inertia": "-2 kg*m^2"}) == text


class Row(Component):
    """Wheels in a row, made by build()."""

    units: int = param(default=2, min=1, doc="number of wheels")

    def build(self):
        for k, mass in enumerate(np.full(self.units, 2.0)):
            self.add(f"wheel_{k}", Inertia(inertia=mass))


def test_count_out_of_bounds_is_found_before_parts_are_made():
    assert said(Row, units=-1) == "Row.units = -1 is below its minimum 1 (number of wheels)."


def test_wrong_unit():
    assert said(Inertia, inertia="2 kg") == (
        "Inertia.inertia: got '2 kg', which is a mass; "
        "a moment of inertia in kg*m^2 is expected, e.g. '534.1 kg*m^2'."
    )  # fmt: skip
    assert said(simulate, case(), start={"c.x": "3 s"}) == (
        "c.x: got '3 s', which is a time; a length in m is expected, e.g. '853.87 m'."
    )


class Choosy(Component):
    kind: str = param(default="round", choices=("round", "square"), doc="shape of the section")
    count: int = param(default=2, min=1, doc="number of sections")


def test_wrong_choice_and_wrong_type():
    assert said(check, assembly(c=Choosy(kind="sqare"))) == (
        "c.kind = 'sqare' is not one of round, square (shape of the section)."
    )
    assert said(Choosy, count=2.5) == "Choosy.count: got 2.5, and a whole number is expected (number of sections)."


# --- connections --------------------------------------------------------------------------------------------------


def test_two_outputs_on_one_signal():
    model = assembly(
        ("one.y", "gain.u"), ("two.y", "gain.u"), one=Constant(value=1), two=Constant(value=2), gain=Gain(gain=1)
    )
    assert said(check, model) == (
        "two outputs drive one signal: one.y (model.connect(*ends)) and two.y (model.connect(*ends)). "
        "Connect one of them, or add a Sum between."
    )


def test_unconnected_ports():
    assert said(check, assembly(motor=TorqueSource(), torque=Constant(value=1))) == (
        "motor.flange is not connected: where the torque acts. Connect a Flange to it."
    )
    model = assembly(("motor.flange", "wheel.flange_a"), motor=TorqueSource(), wheel=Inertia(inertia=1))
    assert said(check, model) == (
        "motor.torque is not connected: torque on the part joined to the flange [N*m]. Connect an output to it."
    )


def test_ports_of_different_kinds():
    assert said(check, assembly(("world.frame", "wheel.flange_a"), world=World(), wheel=Inertia(inertia=1))) == (
        "model.connect(*ends): world.frame is a Frame and wheel.flange_a a Flange; "
        "only ports of one kind can be connected."
    )
    assert said(check, assembly(("world.frame", "one.y"), world=World(), one=Constant(value=1))) == (
        "model.connect(*ends): world.frame is a Frame and one.y a RealOutput; only ports of one kind can be connected."
    )


def test_what_is_not_a_port():
    model = assembly(world=World(), group=assembly(one=Constant(value=1)), gain=Gain(gain=1), sum=Sum(gains=(1, 1)))
    assert said(model.connect, model.world, model.gain.u) == (
        "Assembly: connect() joins two ports, and <World world> is not a port."
    )
    assert said(model.group.connect, model.group.one.y, model.gain.u) == (
        "group: gain.u is not a port of this component or of a part below it; "
        "connect it where it belongs, after the part was added."
    )
    assert said(lambda: model.sum.u[2]) == "sum.u[2]: the array has 2 ports, counted from 0."
    assert said(lambda: model.gain.u[0]) == "gain.u is one port, not an array of ports; connect it without an index."
    assert said(check, assembly(("one.y", "sum.u"), one=Constant(value=1), sum=Sum(gains=(1, 1)))) == (
        "model.connect(*ends): sum.u is an array of 2 ports; connect one of them: sum.u[0]."
    )
    assert said(check, assembly(("gain.u", "gain.u"), gain=Gain(gain=1))) == (
        "model.connect(*ends): gain.u is connected to itself."
    )


class Root(Component):
    """A second world."""

    frame: World.frame.annotation = port(doc="a fixed frame")

    def equations(self):
        return [eq(self.frame.r, m.zeros(3)), fix_orientation(self.frame, m.eye(3), m.zeros(3))]


def test_orientations():
    body = {"mass": 1, "inertia": np.eye(3)}
    model = assembly(("a.frame_a", "b.frame_a"), world=World(), a=RigidBody(**body), b=RigidBody(**body))
    assert said(check, model) == (
        "the orientation of a.frame_a is not tied to the world; "
        "join it by a joint, a fixed part or a FreeMotion to the World."
    )
    assert said(check, assembly(("world.frame", "root.frame"), world=World(), root=Root())) == (
        "the orientation of root.frame is fixed twice, by world and by root; one of them must leave it free."
    )
    model = assembly(
        ("world.frame", "hinge.frame_a"), ("hinge.frame_b", "root.frame"), world=World(), hinge=Revolute(), root=Root()
    )
    assert said(check, model) == (
        "the orientation of root.frame is fixed by root, and so is that of a frame that it is joined to; "
        "one of them must leave it free."
    )


# --- equations as written -----------------------------------------------------------------------------------------


class Sketch(Component):
    """A place; the tests write its equations."""

    r: Vector = var(unit="m", doc="place")


def sketch(equations):
    return assembly(c=type("Sketch", (Sketch,), {"equations": equations})())


def test_equations_that_are_not_well_formed():
    assert said(check, sketch(lambda self: [eq(self.r, m.zeros(2))])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.r, m.zeros(2))])) == (): "
        "the sides of an equation have different shapes: 3 x 1 on the left, 2 x 1 on the right."
    )
    assert said(check, sketch(lambda self: [eq(self.r + m.zeros(2), 0)])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.r + m.zeros(2), 0)])) == (): "
        "the equations of Sketch fail: Dimension mismatch for (x+y), x is 3x1, while y is 2x1."
    )
    assert said(check, sketch(lambda self: [eq(self.q, 0)])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.q, 0)])) == () "
        "has no part, port, parameter or variable 'q'; there is 'r'."
    )
    assert said(check, sketch(lambda self: None)) == "c: equations() returned nothing; end it with return [...]."
    assert said(check, sketch(lambda self: [self.r == 0])) == (
        "c: equations() returned an expression, which is not an equation; write eq(left, right), not left == right."
    )
    assert said(check, sketch(lambda self: [eq(self.r, 1 if self.r[0] > 0 else 2)])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.r, 1 if self.r[0] > 0 else 2)])) == (): "
        "the equations of Sketch fail: a comparison of unknowns is neither true nor false while the model is made; "
        "write if_else(condition, a, b) of fowtlib.language.math."
    )
    assert said(check, sketch(lambda self: [eq(self.r, None)])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.r, None)])) == (): "
        "None (NoneType) cannot stand in an equation."
    )  # fmt: skip
    assert said(check, sketch(lambda self: [eq(self.r, [1, 2][5])])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.r, [1, 2][5])])) == (): "
        "the equations of Sketch fail: IndexError, list index out of range."
    )


def test_external_functions_called_wrongly():
    u = ca.MX.sym("u", 2)
    function = ca.Function("lift", [u], [ca.bspline(u[0], [1.0, 2, 3, 4], [[0.0] * 4 + [1.0] * 4], [3], 1)])
    assert said(check, sketch(lambda self: [eq(self.r, external(function, self.r))])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.r, external(function, self.r))])) == (): "
        "external function lift takes 2 inputs, and 3 are given."
    )
    assert said(check, sketch(lambda self: [eq(self.r, function(self.r[:2]))])) == (
        "c (assert said(check, sketch(lambda self: [eq(self.r, function(self.r[:2]))])) == (): "
        "the equations of Sketch fail: a CasADi function of MX is called on unknowns; "
        "call it by external(function, inputs)."
    )


# --- singular models ----------------------------------------------------------------------------------------------


def test_an_equation_is_missing():
    model = one(
        x=var(unit="m", doc="position", hint="does a spring hold it?"), v=var(unit="m/s", doc="speed"),
        f=var(unit="N", doc="force"), equations=lambda self: [eq(der(self.x), self.v), eq(self.f, 2 * self.x)],
    )  # fmt: skip
    assert said(check, model) == (
        "the model is singular: 1 equation for 2 unknowns, after the simple ones are eliminated.\n"
        "Under-determined: 1 equation is missing for these unknowns:\n"
        "  c.x (position). Hint: does a spring hold it?\n"
        "  c.f (force)\n"
        "Likely cause: c lacks an equation or a connection; a body that nothing holds needs a joint, "
        "an output needs an equation."
    )


def test_an_equation_is_too_many():
    model = one(
        x=var(unit="m", doc="position"), v=var(unit="m/s", doc="speed"),
        equations=lambda self: [
            eq(der(self.x), self.v),
            eq(self.v, 3 * self.x),
            eq(self.v, 4),
        ],
    )  # fmt: skip
    assert said(check, model) == (
        "the model is singular: 2 equations for 1 unknown, after the simple ones are eliminated.\n"
        "Over-determined: 1 equation is too many among these:\n"
        "  c: c.v = (3*c.x) (eq(self.v, 3 * self.x),)\n"
        "  c: der(c.x) = c.v (eq(der(self.x), self.v),)\n"
        "  c: c.v = 4 (eq(self.v, 4),)\n"
        "Likely cause: c prescribes a quantity twice; remove one of the equations or connections."
    )


def test_motion_prescribed_twice():
    model = assembly(
        ("one.y", "crank.phi"), ("two.y", "motor.phi"), ("crank.flange", "wheel.flange_a"),
        ("motor.flange", "wheel.flange_b"), one=Sine(frequency=1), two=Sine(frequency=2),
        crank=AngleSource(), motor=AngleSource(), wheel=Inertia(inertia=1),
    )  # fmt: skip
    text = re.sub(r"\((mechanics|blocks)/\w+\.py:\d+\)", "(...)", said(check, model))
    assert text == (
        "the model is singular: 4 equations for 4 unknowns, after the simple ones are eliminated.\n"
        "Under-determined: 1 equation is missing for these unknowns:\n"
        "  crank.flange.tau (torque into the component)\n"
        "  motor.flange.tau (torque into the component)\n"
        "Over-determined: 1 equation is too many among these:\n"
        "  one: one.y = (one.offset+(one.amplitude*sin((((6.28319*one.frequency)*time)+one.phase)))) (...)\n"
        "  two: two.y = (two.offset+(two.amplitude*sin((((6.28319*two.frequency)*time)+two.phase)))) (...)\n"
        "  crank: crank.flange.phi = one.y (...)\n"
        "  motor: motor.flange.phi = two.y (...)\n"
        "  wheel: crank.flange.phi = wheel.phi (...) and 1 more element\n"
        "Likely cause: something is prescribed twice in one place and left open in another, "
        "as by a connection to the wrong port."
    )


def test_redundant_planar_loop():
    """Four parallel hinges in a loop: out of its plane the loop is held twice."""
    hinges = {f"hinge_{i}": Revolute(n=(0, 1, 0)) for i in range(4)}
    rods = {f"rod_{i}": FixedTranslation(r=r) for i, r in enumerate([(1, 0, 0), (0, 0, 1), (-1, 0, 0)])}
    model = assembly(
        ("world.frame", "hinge_0.frame_a"), ("hinge_0.frame_b", "rod_0.frame_a"), ("rod_0.frame_b", "hinge_1.frame_a"),
        ("hinge_1.frame_b", "rod_1.frame_a"), ("rod_1.frame_b", "hinge_2.frame_a"),
        ("hinge_2.frame_b", "rod_2.frame_a"), ("rod_2.frame_b", "hinge_3.frame_a"),
        ("world.frame", "base.frame_a"), ("base.frame_b", "hinge_3.frame_b"),
        ("rod_0.frame_b", "body.frame_a"), world=World(), base=FixedTranslation(r=(0, 0, 1)), **hinges, **rods,
        body=RigidBody(mass=1, inertia=np.eye(3)),
    )  # fmt: skip
    first, *_, last = said(check, model).splitlines()
    assert first.startswith("the model is singular: ")
    assert last == (
        "Likely cause: the loop that rod_1 closes constrains the same motion twice, as the hinges of a planar loop do "
        "out of its plane; make one of its hinges a PlanarLoopRevolute, or a ball joint (Spherical) where they are "
        "not parallel."
    )


def held(*links):
    """A body that several rigid links hold to the world."""
    body = RigidBody(mass=5, inertia=np.eye(3))
    parts = {f"l{k}": link for k, link in enumerate(links, 1)}
    pairs = [(f"{name}.frame_{side}", port) for name in parts for side, port in (("a", "world.frame"), ("b", "end"))]
    end = "l1.frame_b"
    pairs = [(a, end if b == "end" else b) for a, b in pairs if (a, b) != (end, "end")]
    return assembly(*pairs, (end, "b.frame_a"), world=World(), b=body, **parts)


@pytest.mark.parametrize(
    ("model", "cause"),
    [
        (
            lambda: held(FixedTranslation(r=(1, 0, 0)), FixedTranslation(r=(1, 0, 0))),
            "l2 and l1 are rigid and join the same frames, so that what they carry is held twice; drop one of them, "
            "or give it a joint or a spring.",
        ),
        (
            lambda: held(FixedTranslation(r=(1, 0, 0)), FixedRotation(angle=0.0, r=(1, 0, 0))),
            "l2 and l1 are rigid and join the same frames, so that what they carry is held twice; drop one of them, "
            "or give it a joint or a spring.",
        ),
        (
            lambda: held(Prismatic(), FixedTranslation(r=(1, 0, 0))),
            "no part of the loop that l2 closes turns, so that its orientation is held twice; put a joint that turns "
            "(a Spherical, or a Revolute) into it.",
        ),
        (
            lambda: assembly(
                ("world.frame", "m.frame_a"), ("m.frame_b", "a.frame_a"), ("m.frame_b", "b.frame_a"),
                ("m.frame_b", "c.frame_a"), ("a.frame_b", "d.frame_a"), ("d.frame_b", "b.frame_b"),
                world=World(), m=FreeMotion(), c=RigidBody(mass=1, inertia=np.eye(3)),
                a=FixedTranslation(r=(1, 0, 0)), b=FixedTranslation(r=(1, 1, 0)), d=FixedTranslation(r=(0, 1, 0)),
            ),
            "d, a and b are rigid and join the same frames, so that what they carry is held twice; drop one of them, "
            "or give it a joint or a spring.",
        ),
    ],
    ids=["two links", "link and rotation", "slide and link", "triangle afloat"],
)  # fmt: skip
def test_a_body_that_is_held_twice(model, cause):
    assert said(check, model()).splitlines()[-1] == f"Likely cause: {cause}"


# --- initial values -----------------------------------------------------------------------------------------------


def test_no_consistent_start():
    model = one(
        level=var(start=-1.0, state="always", doc="level"), outflow=var(start=0.1, doc="outflow"),
        equations=lambda self: [
            eq(der(self.level), -self.outflow),
            eq(self.outflow**2, self.level),
        ],
    )  # fmt: skip
    assert said(check(model).initial_state) == (
        "no consistent start values at t = 0 s: the equations furthest from being satisfied are "
        "c (eq(self.outflow**2, self.level),). Give start values nearer to a solution."
    )


def test_start_value_of_what_is_not_a_state():
    assert said(simulate, case(), start={"c.y": 1}) == (
        "'c.y' is not a state and cannot be given a start value; did you mean 'c.x' or 'c.v'?"
    )


def test_too_many_initial_equations():
    model = case(
        lambda s: initial(s.x, 1),
        lambda s: initial(s.v, 0),
        lambda s: initial(s.x + s.v, 3),
    )
    assert said(simulate, model) == (
        "3 initial equations, and only 2 states whose start values can give way to them: "
        "c (lambda s: initial(s.x, 1),), c (lambda s: initial(s.v, 0),), c (lambda s: initial(s.x + s.v, 3),). "
        "Remove an initial equation, or the fixed=True of a state."
    )


# --- while it runs ------------------------------------------------------------------------------------------------


def test_an_equation_that_ceases_to_be_a_number(capfd):
    """The root of a level that becomes negative between two output points, after t = 0.61 s."""
    model = one(
        level=var(start=1.0, state="always", doc="level"), outflow=var(doc="outflow of the tank"),
        equations=lambda self: [eq(der(self.level), -1.0 - self.outflow), eq(self.outflow, m.sqrt(self.level))],
    )  # fmt: skip
    assert said(simulate, model) == (
        "the integration fails after t = 0.6 s: c.outflow (outflow of the tank) is not a finite number. "
        "Check the parameters, start values and limits there."
    )
    assert said(simulate, model, start={"c.level": -1}) == (
        "the integration fails after t = 0 s: c.outflow (outflow of the tank) is not a finite number. "
        "Check the parameters, start values and limits there."
    )
    assert capfd.readouterr() == ("", "")  # no word of CasADi or SUNDIALS


def test_an_implicit_equation_that_ceases_to_be_a_number():
    model = one(
        level=var(start=1.0, state="always", doc="level"), y=var(doc="implicit"),
        equations=lambda self: [
            eq(der(self.level), -1.0),
            eq(self.y + m.exp(self.y), m.log(self.level)),
        ],
    )  # fmt: skip
    assert said(simulate, model) == (
        "the integration fails after t = 1 s: an equation of c (eq(self.y + m.exp(self.y), m.log(self.level)),) "
        "is not a finite number. Check the parameters, start values and limits there."
    )


def test_a_result_that_is_not_a_number():
    """Nothing else needs the logarithm, so the run goes on and says so."""
    model = one(
        level=var(start=1.05, state="always", doc="level"), y=var(doc="its logarithm"),
        equations=lambda self: [eq(der(self.level), -1.0), eq(self.y, m.log(self.level))],
    )  # fmt: skip
    text = "c.y is not a finite number at 15 of 26 output points, first at t = 1.1 s."
    with pytest.warns(UserWarning, match=re.escape(text)):
        result = simulate(model, 2.5, outputs=["c.y"])
    assert result.attributes["warnings"] == text


def test_growth_without_bound(capfd):
    model = one(x=var(start=1.0, state="always"), equations=lambda self: [eq(der(self.x), self.x**2)])
    assert said(simulate, model) == (
        "the integration fails after t = 0.9 s, because 100,000 steps do not reach the next point; "
        "the fastest change is der(c.x). Look there for a jump, a missing damping or a quantity "
        "that grows without bound, or try another tolerance (--tolerance 1e-8)."
    )
    assert capfd.readouterr() == ("", "")


def test_what_was_computed_survives_a_failure():
    model = one(x=var(start=1.0, state="always"), equations=lambda self: [eq(der(self.x), self.x**2)])
    with pytest.raises(ModelError) as caught:
        simulate(model)
    result = caught.value.result
    assert np.asarray(result["c.x"].time)[-1] == pytest.approx(0.9)
    assert np.asarray(result["c.x"])[-1] == pytest.approx(10.0, rel=1e-3)


def test_ctrl_c_keeps_what_was_computed():
    from fowtlib.solving.run import Interrupted

    def stop(t, t_end):
        if t >= 50:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        check(case()).simulate(1000.0, output_step=0.1, progress=stop)
    assert re.fullmatch(r"interrupted at t = \d+ s\.", str(caught.value))
    assert 50 <= np.asarray(caught.value.result["c.x"].time)[-1] < 1000


def test_table_left_at_its_edge():
    def equations(self):
        return [
            eq(der(self.x), 1.0),
            eq(self.y, table1d(self.x, [0, 1, 2, 3], [0, 1, 4, 9], name="lift", argument="x")),
        ]

    model = one(x=var(start=1.0, state="always", doc="position"), y=var(doc="lift"), equations=equations)
    assert said(simulate, model) == (
        "c: table left at its edge: lift at x = 3.1, and the table covers 0 to 3 (t = 2.1 s)."
    )


def test_broken_assertion():
    assert said(simulate, case(lambda s: assert_(s.x > 0, "the mass hits the wall"))) == (
        "c: the mass hits the wall (t = 1.6 s)."
    )


# --- events and samples -------------------------------------------------------------------------------------------


def test_what_stands_in_sampled_and_when():
    for name, statement in (
        ("sampled", lambda s: sampled(0.1, eq(s.held, s.x))),
        ("sampled", lambda s: sampled(0.1, assign(s.held, s.x), [eq(s.held, 2 * s.x)])),
        ("when", lambda s: when(s.x < 0, eq(s.held, s.x))),
    ):
        text = said(check, case(statement))
        assert text.startswith("c (") and text.endswith(
            f": {name}() takes no equations: at such an instant a variable is given a value, and keeps it; "
            "write assign(target, value) in place of eq(target, value)."
        )
    assert said(check, case(lambda s: sampled(0.1))).endswith(
        "sampled() has nothing to do: give it an assign(target, value), or several."
    )
    assert said(check, case(lambda s: sampled(0.1, s.held + 1))).endswith(
        "sampled() takes assignments, assign(target, value), and SX((c.held+1)) is none."
    )
    assert said(check, case(lambda s: sampled(0.1, reinit(s.x, 1)))).endswith(
        "sampled() cannot make a state jump; write reinit() in a when()."
    )
    assert said(check, case(lambda s: assign(s.held, s.x))) == (
        "c: assign() stands alone in equations(), which does not say when to carry it out; "
        "put it into a when() or sampled()."
    )
    model = case(lambda s: sampled(0.1, [assign(s.held, s.x)]))  # a list of them will do
    assert simulate(model, 0.5)["c.held"].values[-1] < 1


def test_equations_that_set_what_is_given():
    """A signal that comes from outside, set inside; a discrete variable; parameters only; an output nobody sets."""
    for model in (assembly(c=SetsItsInput()), assembly(c=SetsTheInputOfItsPart())):
        assert (
            said(check, model)
            .splitlines()[-1]
            .endswith(
                ".u is an input that nothing is connected to, so that its value comes from outside of the model and no "
                "equation can set it; connect an output to it, such as a Constant, or let its component declare it as "
                "an output (RealOutput) or a variable."
            )
        )
    assert said(check, case(lambda s: eq(s.held, 2.0))).splitlines()[-1] == (
        "Likely cause: c.held is discrete and changes by assign() in a sampled() or when() only, not by an equation; "
        "declare it without discrete=True, or assign it."
    )
    assert said(check, case(lambda s: eq(s.stiffness, 2.0))).splitlines()[-1] == (
        "Likely cause: the equation of c contains no unknown; remove it, or make it an assert_()."
    )
    model = assembly(c=SetsItsInput(), g=Constant(value=1.0))
    model.connect(model.g.y, model.c.u)  # now it is heard twice
    assert said(check, model).splitlines()[-1].startswith("Likely cause: c, g prescribe the same quantity")
    assert said(check, assembly(c=Silent())).splitlines()[1:3] == [
        "Under-determined: 1 equation is missing for this unknown:", "  c.y (what nobody sets)",
    ]  # fmt: skip
    assert said(check, assembly(c=DrivesItsInput())) == (
        "c.u (self.connect(self.constant.y, self.u)) is an input, and c.constant.y inside of it drives it; "
        "make it an output (RealOutput), or connect it the other way."
    )


class SetsItsInput(Component):
    u: RealInput = port(default=0.0, doc="signal")

    def equations(self):
        return [eq(self.u, 3.0)]


class WithDefault(Component):
    u: RealInput = port(default=0.0, doc="signal")
    y: RealOutput = port(doc="twice the signal")

    def equations(self):
        return [eq(self.y, 2 * self.u)]


class SetsTheInputOfItsPart(Component):
    def build(self):
        self.add("part", WithDefault())

    def equations(self):
        return [eq(self.part.u, 3.0)]


class Silent(Component):
    y: RealOutput = port(doc="what nobody sets")

    def build(self):
        self.add("constant", Constant(value=1.0))


class DrivesItsInput(Component):
    u: RealInput = port(default=0.0, doc="signal")

    def build(self):
        self.add("constant", Constant(value=1.0))
        self.connect(self.constant.y, self.u)


def test_targets_of_events():
    assert said(check, case(lambda s: when(s.x < 0, reinit(s.held, 1)))) == (
        "c: reinit() cannot set c.held, which is not a state; declare it with state='always'."
    )
    assert said(check, case(lambda s: when(s.x < 0, assign(s.x, 1)))) == (
        "c: assign() cannot set c.x, which is a state; write reinit()."
    )
    assert said(check, case(lambda s: sampled(0.1, assign(s.x, 1)))) == (
        "c: assign() cannot set c.x; declare it with var(discrete=True)."
    )
    assert said(check, case(lambda s: when(s.x, assign(s.held, 1)))) == (
        "c: a when() takes one comparison, a < b or a > b; "
        "join several by fmax (and) or fmin (or)."
    )  # fmt: skip


@pytest.mark.parametrize("t_end", [0.7, 1.0, 2.0, 3.3])
def test_chattering(t_end):
    """A relay without hysteresis switches for ever at one instant."""
    model = one(
        x=var(start=1.0, state="always", doc="position"), up=var(discrete=True),
        equations=lambda self: [
            eq(der(self.x), 2 * self.up - 1),
            when(self.x < 0.5, assign(self.up, 1)),
            when(self.x > 0.5, assign(self.up, 0)),
        ],
    )  # fmt: skip
    assert said(simulate, model, t_end) == (
        "c: the event of a when() returns at once, again and again, at t = 0.5 s. "
        "Give the condition a hysteresis, or let the motion come to rest there."
    )


def test_bounces_that_accumulate():
    """A ball bounces ever faster, until t = 3 sqrt(2 h / g); it must not fall through the floor."""
    model = one(
        h=var(unit="m", start=1.0, state="always", doc="height"), v=var(unit="m/s", state="always", doc="speed"),
        equations=lambda self: [
            eq(der(self.h), self.v), eq(der(self.v), -9.81), when(self.h < 0, reinit(self.v, -0.5 * self.v))
        ],
    )  # fmt: skip
    assert said(simulate, model, tolerance=1e-9) == (
        f"c: the event of a when() returns at once, again and again, at t = {3 * np.sqrt(2 / 9.81):.6g} s. "
        "Give the condition a hysteresis, or let the motion come to rest there."
    )


class Delay(Component):
    """Takes over its input at each sample."""

    u: RealInput = port(doc="input")
    y: RealOutput = port(doc="output")
    held: Scalar = var(discrete=True, doc="held value")

    def equations(self):
        return [eq(self.y, self.held), sampled(0.1, assign(self.held, self.u))]


def test_sampled_parts_in_a_ring():
    model = assembly(("one.y", "two.u"), ("two.y", "one.u"), one=Delay(), two=Delay())
    assert said(check, model) == (
        "the sampled parts one, two need each other's values of the same instant; delay one by a sample."
    )


def test_period_of_a_sampled_part():
    assert said(simulate, case(lambda s: sampled(s.period, assign(s.held, s.x))), parameters={"c.period": 0}) == (
        "c: the period of a sampled part is 0 s; it must be above zero."
    )


def test_arguments_of_a_simulation():
    assert said(simulate, case(), solver="cvode") == "there is no solver 'cvode'; there are 'idas' and 'fixed'."
    assert said(simulate, case(), -1.0) == "duration is -1 s; it must be above zero."
    assert said(check(case()).simulate, 1.0, output_step=0.0) == "output_step is 0 s; it must be above zero."
    assert said(simulate, case(), outputs=["c.y"]) == "there is no variable 'c.y'; did you mean 'c.x' or 'c.v'?"


class Tube(Component):
    """A rod whose wall is what is left between two diameters."""

    outer: Scalar = param(default=2.0, unit="m", min=0, doc="outer diameter")
    inner: Scalar = param(default=1.0, unit="m", min=0, doc="inner diameter")

    def build(self):
        self.wall = Wall(thickness=(self.outer - self.inner) / 2, share=self.inner / self.outer)


class Wall(Component):
    thickness: Scalar = param(unit="m", min=0, doc="thickness of the wall")
    share: Scalar = param(max=1.0, doc="inner diameter over outer")
    x: Scalar = var(start=1.0, state="prefer", doc="state")

    def equations(self):
        return [eq(der(self.x), self.thickness - self.x), assert_(self.x < 3, "x is {x}, beyond 3", x=self.x),
                assert_(self.x < 2, "x is beyond 2", "warning")]  # fmt: skip


@pytest.mark.parametrize(
    ("inner", "outer", "text", "built"),
    [
        (3.0, 2.0, "tube.wall.thickness = -0.5 m is below its minimum 0 m (thickness of the wall)", ""),
        (1.0, 0.5, "tube.wall.thickness = -0.25 m is below its minimum 0 m (thickness of the wall)", ""),
        (0.0, 0.0, "tube.wall.share = nan is no finite number (inner diameter over outer)",
         "tube.wall.share is not a finite number: (tube.inner / tube.outer) (inner diameter over outer)"),
    ],
)  # fmt: skip
def test_a_parameter_that_follows_from_others_keeps_its_bounds(inner, outer, text, built):
    """In the model as it is built, in a run, and in an equilibrium with other values."""
    plant = fw.load(assembly(tube=Tube())).compile()
    values = {"tube.inner": inner, "tube.outer": outer}
    for use in (plant.initial_state, plant.equilibrium, lambda parameters: plant.simulate(1, 1, parameters=parameters)):
        assert said(use, parameters=values) == f"{text}; it follows from the values that were given."
    assert said(check, assembly(tube=Tube(inner=inner, outer=outer))) == f"{built or text}."
    assert plant.parameter_values({"tube.inner": 1.5})["tube.inner"] == 1.5


def test_an_equilibrium_is_checked_against_what_the_parts_state():
    plant = fw.load(assembly(tube=Tube())).compile()
    assert said(plant.equilibrium, parameters={"tube.outer": 8.0}) == (
        "tube.wall: x is 3.5, beyond 3. So there is no equilibrium: where nothing would change any more the model "
        "breaks this condition."
    )
    with pytest.warns(UserWarning, match=r"^tube\.wall: x is beyond 2\.$"):
        state = plant.equilibrium(parameters={"tube.outer": 6.0})
    assert float(state["tube.wall.x"]) == pytest.approx(2.5)
    beyond = plant.initial_state(start={"tube.wall.x": 4.0})
    assert said(plant.linearize, beyond) == "tube.wall: x is 4, beyond 3."


def test_a_list_for_one_number_is_told_where_formulas_give_it():
    """Also where the numbers come from formulas, which are known late: of a plate, of a mass, of a length."""
    from fowtlib.components.platform import Bulkhead

    length = fw.components.mechanics.FixedTranslation(r=[0, 0, 2.0])
    for name in ("place", "thickness"):
        plate = Bulkhead(**{"place": 1.0, "thickness": 0.02, name: [length.r[2] / 4, length.r[2] / 2]})
        with pytest.raises(ModelError, match=f"{name} takes one number, and a list of 2 is given"):
            plate.numbers()
