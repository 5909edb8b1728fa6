"""The dimension check: what it finds, in which words, and what it leaves alone."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.blocks import Constant, Gain, Integrator, TransferFunction
from fowtlib.components.mechanics import FixedTranslation, Revolute, RigidBody, World
from fowtlib.flattening.dimensions import check_dimensions
from fowtlib.language import (
    Component,
    RealInput,
    Scalar,
    Vector,
    assign,
    der,
    eq,
    external,
    initial,
    param,
    part,
    port,
    sampled,
    var,
)
from fowtlib.language import math as m


class Lump(Component):
    """Quantities of several kinds; the tests write the equations."""

    mass: Scalar = param(default=2.0, unit="kg", doc="mass")
    length: Scalar = param(default=1.5, unit="m", doc="length")
    gravity: float = param(default=9.81, unit="m/s^2", doc="acceleration of gravity")

    x: Scalar = var(unit="m", doc="position")
    v: Scalar = var(unit="m/s", doc="velocity")
    force: Scalar = var(unit="N", doc="force")
    angle: Scalar = var(unit="rad", doc="angle")
    r: Vector = var(unit="m", doc="place")
    d: Scalar = var(unit="m", discrete=True, doc="held position")


def findings(*equations):
    """What the check says about equations of a Lump, without the place."""
    model = fw.Assembly("m")
    model.lump = type("Case", (Lump,), {"equations": lambda self: [equation(self) for equation in equations]})()
    return [finding.text for finding in check_dimensions(model).findings]


def test_agreeing_equations_are_left_alone():
    square = ca.Function("square", [u := ca.MX.sym("u")], [u**2])
    assert not findings(
        lambda s: eq(der(s.x), s.v),
        lambda s: eq(s.force, s.mass * der(s.v) + 0.5 * s.mass * s.v**2 / s.length),
        lambda s: eq(s.force, s.mass * s.gravity * m.sin(s.angle)),
        lambda s: eq(s.v, m.sqrt(2 * s.gravity * s.x)),
        lambda s: eq(s.x, m.fmax(s.x, 0.3) + m.if_else(s.x > s.length, s.length, 0)),
        lambda s: eq(s.x, m.norm(s.r) + m.smooth_abs(s.x, 0.01) + s.length * (1 + s.angle)),
        lambda s: eq(s.v, s.length * der(s.angle)),
        lambda s: eq(s.r, m.vertcat(s.x, 0, 3.0)),
        lambda s: eq(s.force, external(square, s.x)),
        lambda s: eq(s.angle, m.atan2(s.x, s.length) + s.v * s.time / s.length),
        lambda s: eq(s.x, (s.length**3) ** (1 / 3)),
    )


@pytest.mark.parametrize(
    ("equation", "text"),
    [
        (
            lambda s: eq(der(s.x), s.force / s.mass),
            "the left side is a speed [m/s], the right side an acceleration [m/s^2]: "
            "der(lump.x) = (lump.force/lump.mass).",
        ),
        (
            lambda s: eq(s.x, s.length + s.v),
            "a length [m] and a speed [m/s] are added: (lump.length+lump.v).",
        ),
        (
            lambda s: eq(s.angle, m.sin(s.x)),
            "the argument of sin() is a length [m]: sin(lump.x).",
        ),
        (
            lambda s: eq(s.x, m.if_else(s.v < s.length, s.x, s.length)),
            "a speed [m/s] and a length [m] are compared: (lump.v<lump.length).",
        ),
        (
            lambda s: eq(s.force, s.mass * s.v * s.x),
            "the left side is a force [N], the right side a quantity in m^2*kg/s: "
            "lump.force = ((lump.mass*lump.v)*lump.x).",
        ),
        (
            lambda s: eq(s.v, m.sqrt(2 * s.x)),
            "the left side is a speed [m/s], the right side a quantity in m^0.5: lump.v = sqrt((2.*lump.x)).",
        ),
        (
            lambda s: eq(s.angle, 2**s.x),
            "an exponent is a length [m]: pow(2,lump.x).",
        ),
        (
            lambda s: initial(s.x, s.v * s.v),
            "the left side is a length [m], the right side a quantity in m^2/s^2: lump.x = sq(lump.v).",
        ),
        (
            lambda s: sampled(0.1, assign(s.d, s.v)),
            "the variable is a length [m], its new value a speed [m/s]: lump.d = lump.v.",
        ),
    ],
)  # fmt: skip
def test_what_disagrees_is_said_in_words(equation, text):
    assert findings(equation) == [text]


def test_a_vector_equation_is_reported_once():
    assert len(findings(lambda s: eq(der(s.r), s.r))) == 1


class Half(Component):
    """Hands a length on where a mass belongs."""

    length: Scalar = param(default=3.0, unit="m", doc="length")
    body = part(Lump, mass=length / 2)


def test_a_modifier_of_the_wrong_dimension():
    model = fw.Assembly("m")
    model.half = Half()
    assert [str(f) for f in check_dimensions(model).findings] == [
        "half.body: the value of 'mass' is a length [m], its declaration a mass [kg]."
    ]


class Brake(Component):
    """A block with units of its own."""

    speed: RealInput = port(unit="m/s", doc="speed")
    force: Scalar = var(unit="N", doc="braking force")

    def equations(self):
        return [eq(self.force, -3.0 * self.speed)]


def test_general_blocks_take_any_quantity():
    model = fw.Assembly("m")
    model.source, model.gain, model.integrator = Constant(value=2.0), Gain(gain=3.0), Integrator()
    model.filter, model.brake = TransferFunction(numerator=[1.0], denominator=[1.0, 0.5, 1.0]), Brake()
    model.connect(model.source.y, model.gain.u)
    model.connect(model.gain.y, model.integrator.u)
    model.connect(model.integrator.y, model.filter.u)
    model.connect(model.filter.y, model.brake.speed)
    (finding,) = check_dimensions(model).findings
    assert (finding.path, finding.text) == (
        "brake", "the left side is a force [N], the right side a speed [m/s]: brake.force = (-3*filter.y)."
    )  # fmt: skip


def pendulum(**changes):
    model = fw.Assembly("pendulum")
    model.world, model.hinge, model.rod = World(), Revolute(n=(0, 1, 0), phi_start=0.3), FixedTranslation(r=(1, 0, 0))
    model.bob = RigidBody(mass=2.0, inertia=np.diag([0.1, 0.1, 0.1]))
    model.connect(model.world.frame, model.hinge.frame_a)
    model.connect(model.hinge.frame_b, model.rod.frame_a)
    model.connect(model.rod.frame_b, model.bob.frame_a)
    for name, component in changes.items():
        model.add(name, component)
    return model


def test_model_check_reports_counts_and_findings():
    report = fw.load(pendulum()).check()
    assert report.ok
    text = str(report)
    assert "nothing wrong" in text and "2 states" in text and "scalar equations agree" in text

    bad = type("Bad", (Lump,), {"equations": lambda self: [eq(self.x, self.mass), *_rest(self)]})()
    report = fw.load(pendulum(bad=bad)).check()
    assert not report.ok
    assert "dimensions: 1 equation does not agree:" in str(report)
    assert "bad (kernel/test_dimensions.py:" in str(report)


def _rest(lump):
    return [eq(lump.v, 0), eq(lump.force, 0), eq(lump.angle, 0), eq(lump.r, m.zeros(3))]


@pytest.mark.parametrize("name", ["tlp_elastic", "oo_star_dtu10mw"])
def test_elements_with_units_of_their_own_agree_with_any(name):
    """Matrices over translations, rotations and shapes, and the states of a fitted memory."""
    report = fw.load(name).check()
    assert report.ok and not report.dimensions.findings
