"""Start values of unknowns that follow from others: what is left to be found, or to be a state, begins with them."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Component, Scalar, Vector, der, eq, initial, param, var
from fowtlib.language import math as m


class Twice(Component):
    """x^3 = x has the solutions -1, 0 and 1; y = 2 x begins."""

    begin: Scalar = param(default=-2.0, doc="start of y")
    x: Scalar = var(doc="solution")
    y: Scalar = var(start=begin, doc="twice of it")

    def equations(self):
        return [eq(self.y, 2 * self.x), eq(self.x**3, self.x)]


class Behind(Component):
    """The start of the last of a row: z = 3 - y, y = 2 x."""

    x: Scalar = var(doc="solution")
    y: Scalar = var(doc="twice of it")
    z: Scalar = var(start=5.0, doc="what is left of 3")

    def equations(self):
        return [eq(self.z, 3 - self.y), eq(self.y, 2 * self.x), eq(self.x**3, self.x)]


class Place(Component):
    """A point where both distances hold, on the side where it begins, from a point that moves."""

    guess: Vector = param(default=(0, -1, 0), unit="m", doc="first guess of the offset")
    base: Vector = var(unit="m", state="prefer", start=(5.0, 0.0, 0.0), doc="moves")
    place: Vector = var(unit="m", doc="where it is")
    offset: Vector = var(unit="m", start=guess, doc="from the base")

    def equations(self):
        a, b = self.offset - m.vertcat(1, 0, 0), self.offset + m.vertcat(1, 0, 0)
        return [
            eq(der(self.base), -self.base),
            eq(self.place, self.base + self.offset),
            eq(m.dot(a, a), 2), eq(m.dot(b, b), 2), eq(self.place[2], 0),
        ]  # fmt: skip


class State(Component):
    """x' = -x, with the start of what is 4 x + rest."""

    rest: Scalar = param(default=1.0, doc="beside it")
    x: Scalar = var(state="prefer", doc="state")
    y: Scalar = var(start=9.0, doc="four times and a rest")

    def equations(self):
        return [eq(der(self.x), -self.x), eq(self.y, 4 * self.x + self.rest)]


class OfItsOwn(Component):
    """Both have a start: that of the state counts, but where the other one was given for the model."""

    begin: Scalar = param(default=3.0, doc="start of y")
    x: Scalar = var(state="prefer", start=1.0, doc="state")
    y: Scalar = var(start=begin, doc="twice of it")

    def equations(self):
        return [eq(der(self.x), -self.x), eq(self.y, 2 * self.x)]


class Curved(Component):
    """What is not in proportion says nothing: y = x^2."""

    x: Scalar = var(state="prefer", doc="state")
    y: Scalar = var(start=9.0, doc="square")

    def equations(self):
        return [eq(der(self.x), -self.x), eq(self.y, self.x**2)]


class Still(Component):
    """An initial equation goes before."""

    x: Scalar = var(state="prefer", doc="state")
    y: Scalar = var(start=8.0, doc="four times")

    def equations(self):
        return [eq(der(self.x), 1 - self.x), eq(self.y, 4 * self.x), initial(self.x, 1)]


def begun(part, **parameters):
    model = fw.Assembly("a part")
    model.part = part
    return fw.load(model).compile().initial_state(parameters)


@pytest.mark.parametrize("begin", [-2.0, 2.0, 0.1])
def test_the_solution_is_the_one_beside_the_start(begin):
    expected = float(np.sign(np.round(begin)))
    assert begun(Twice(begin=begin))["part.x"] == pytest.approx(expected, abs=1e-8)
    assert begun(Twice(), **{"part.begin": begin})["part.x"] == pytest.approx(expected, abs=1e-8)  # of a run


def test_through_what_is_between():
    assert begun(Behind())["part.x"] == pytest.approx(-1.0, abs=1e-8)  # 3 - 5 = 2 x


@pytest.mark.parametrize("side", [1, -1])
def test_a_place_from_what_moves(side):
    model = Place(guess=(0, side, 0))
    found = begun(model)
    np.testing.assert_allclose(np.ravel(found["part.offset"]), (0, side, 0), atol=1e-8)
    np.testing.assert_allclose(np.ravel(found["part.place"]), (5, side, 0), atol=1e-8)


def test_a_state_begins_where_what_follows_from_it_does():
    assert begun(State())["part.x"] == 2.0
    assert begun(State(), **{"part.rest": 5.0})["part.x"] == 1.0
    assert begun(Still())["part.x"] == pytest.approx(1.0, abs=1e-9)


def test_starts_of_its_own_come_first_and_given_ones_before_defaults():
    assert begun(OfItsOwn())["part.x"] == 1.0
    assert begun(OfItsOwn(begin=3.0))["part.x"] == 1.5
    assert begun(Curved())["part.x"] == 0.0
