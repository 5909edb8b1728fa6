"""Connectors whose members each port sizes: joined, summed, refused where sizes differ."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Array, Component, Connector, Scalar, der, eq, flow, param, port, potential, var
from fowtlib.language.errors import ModelError


class Coordinates(Connector):
    """Several coordinates, and the loads on them."""

    q = potential(shape="port", unit="m", doc="coordinates")
    f = flow(shape="port", unit="N", doc="loads into the component")


class Masses(Component):
    """Masses on their own coordinates: f = M q''."""

    n: int = param(default=2, min=1, doc="number of coordinates")
    masses: Array = param(default=lambda self: [1.0] * self.n, shape="n", unit="kg", doc="masses")

    at: Coordinates = port(shape="n", optional=True, doc="coordinates")
    q: Array = var(shape="n", unit="m", start=1.0, state="prefer", doc="places")
    v: Array = var(shape="n", unit="m/s", state="prefer", doc="velocities")

    def equations(self):
        return [eq(self.at.q, self.q), eq(der(self.q), self.v), eq(self.at.f, self.masses * der(self.v))]


class Springs(Component):
    """Springs to the ground: f = k q."""

    n: int = param(default=2, min=1, doc="number of coordinates")
    stiffness: Scalar = param(default=1.0, unit="N/m", doc="stiffness of each")

    at: Coordinates = port(shape=lambda self: (self.n,), doc="coordinates")

    def equations(self):
        return [eq(self.at.f, self.stiffness * self.at.q)]


def joined(n=3, other=None, **parts):
    model = fw.Assembly("coordinates")
    model.masses, model.springs = Masses(n=n, masses=list(range(1, n + 1))), Springs(n=other or n, stiffness=4.0)
    model.connect(model.masses.at, model.springs.at)
    for name, part in parts.items():
        setattr(model, name, part)
        model.connect(model.masses.at, part.at)
    return model


def test_sizes_follow_from_parameters_and_loads_sum_to_zero():
    for n in (1, 3):
        plant = fw.load(joined(n, more=Springs(n=n, stiffness=5.0))).compile()
        assert len(plant.dae.states) == 2 * n
        found = sorted(mode.frequency_hz for mode in plant.linearize(plant.initial_state(), outputs=[]).modes())
        assert found == pytest.approx(sorted(3 / np.sqrt(np.arange(1, n + 1)) / (2 * np.pi)))
        state = plant.initial_state()
        assert np.allclose(state["masses.at.q"], 1.0) and np.allclose(state["more.at.f"], 5.0)
        assert np.allclose(state["masses.at.f"] + state["springs.at.f"] + state["more.at.f"], 0.0)


def test_what_nobody_meets_is_zero():
    model = fw.Assembly("alone")
    model.masses = Masses(n=4)
    state = fw.load(model).compile().initial_state()
    assert np.allclose(state["masses.at.f"], np.zeros(4))


def test_other_sizes_cannot_be_joined():
    with pytest.raises(ModelError, match=r"masses.at has shape \(3,\) and springs.at has shape \(2,\)"):
        fw.load(joined(3, 2)).compile()


class Unsized(Component):
    """A port that says no size."""

    at: Coordinates = port(optional=True, doc="coordinates")

    def equations(self):
        return [eq(self.at.f, self.at.q)]


def test_a_port_without_a_size_is_told():
    model = fw.Assembly("unsized")
    model.part = Unsized()
    with pytest.raises(ModelError, match=r"part.at: a Coordinates as a port needs a shape"):
        fw.load(model).compile()
