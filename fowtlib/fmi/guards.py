"""Checks that an archive has on top of those of its model: what was computed for it must still be true in a run."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import replace

import casadi as ca
import numpy as np

from fowtlib.flattening.flat_dae import Check, FlatDAE
from fowtlib.flattening.system import element_names, scalars
from fowtlib.language.bounds import lower, upper
from fowtlib.solving.binding import Binding
from fowtlib.solving.plant import Plant


def guarded(plant: Plant, binding: Binding, step: float) -> Plant:
    """The plant with checks of the parameters that follow from others, and of those for whose values it holds data.

    What an importer sets is checked against its own bounds as it is set; what follows from it may leave its bounds too.
    Numbers that a model takes in when a run starts, a series of turbulence, are constants of the archive. A parameter
    that they were computed from can be changed by an importer, and they would not follow.
    Conditions of an equilibrium are left out: an FMU runs. Those on the length of steps are about `step` [s], that of
    the engine inside.
    """
    dae, checks = plant.dae, list(_bounds(plant.dae))
    made: dict[str, str] = {}
    for record in dae.bound.values():
        if binding.reads.get(record.path) and _in_equations(dae, record.symbol):
            made |= dict.fromkeys(sorted(binding.reads[record.path]), record.path)
    for path, user in made.items():
        item, value = dae.parameters[path], np.ravel(binding.values[path], order="F")
        names = element_names(path, item.symbol.shape)
        for name, symbol, number in zip(names, scalars(item.symbol), value, strict=True):
            unit = "" if item.unit == "1" else f" {item.unit}"
            message = (
                f"{name} is {{value}}{unit}, and this FMU holds data that were computed for {number:g}{unit} ({user}); "
                "export it with the new value."
            )
            near = ca.fabs(symbol - number) <= 1e-9 * (1 + abs(number))
            checks.append(Check(near, message, "error", {"value": symbol}, ""))
    of_runs = [by_step(check, step) for check in dae.checks if check.level != "rest"]
    if not checks and [id(check) for check in of_runs] == [id(check) for check in dae.checks]:
        return plant
    changed = copy.copy(plant)
    changed.dae = replace(dae, checks=(*of_runs, *checks), key="")  # another model than the one that is kept
    return changed


def by_step(check: Check, step: float) -> Check:
    """A condition on the length of steps as a warning of an engine that takes these [s]."""
    if check.level != "step":
        return check
    holds = ca.logic_or(check.condition, check.values["seconds"] >= step * (1 - 1e-9))
    message = f"{check.message}; the engine inside has steps of {step:g} s"
    return Check(holds, message, "warning", check.values, check.path)


def _bounds(dae: FlatDAE) -> Iterator[Check]:
    """What FlatDAE.check_dependents refuses, once for each expression and bound, and not what a given value ensures."""
    given = {
        element.element_hash(): (item.min, item.max)
        for item in dae.parameters.values()
        for element in scalars(item.symbol)
    }
    seen: set[tuple[str, float | None, float | None]] = set()
    for item in dae.dependents.values():
        unit = "" if item.unit == "1" else f" {item.unit}"
        for name, value in zip(element_names(item.path, item.symbol.shape), scalars(item.symbol), strict=True):
            ensured = given.get(value.element_hash(), (None, None)) if value.is_symbolic() else (None, None)
            key = (str(value), item.min, item.max)
            if value.is_constant() or key in seen:
                continue
            seen.add(key)
            ends = f"({item.doc}); it follows from the values that were given."
            if not value.is_symbolic():
                finite = ca.fabs(value) <= np.finfo(float).max
                message = f"{name} = {{value}}{unit} is no finite number {ends}"
                yield Check(finite, message, "error", {"value": value}, "")
            if item.min is not None and (ensured[0] is None or ensured[0] < item.min):
                message = f"{name} = {{value}}{unit} is {lower(item.min, item.unit)} {ends}"
                yield Check(value >= item.min, message, "error", {"value": value}, "")
            if item.max is not None and (ensured[1] is None or ensured[1] > item.max):
                message = f"{name} = {{value}}{unit} is {upper(item.max, item.unit)} {ends}"
                yield Check(value <= item.max, message, "error", {"value": value}, "")


def _in_equations(dae: FlatDAE, symbol: ca.SX) -> bool:
    """Whether equations, events or samples depend on symbols, and not start values alone."""
    used = [dae.ode, dae.alg, *(ca.vec(external.inputs) for external in dae.externals)]
    used += [e for event in dae.events for e in (event.indicator, event.state_values, event.discrete_values)]
    used += [e for sample in dae.samples for e in (sample.values, sample.period, sample.offset)]
    return ca.depends_on(ca.vertcat(*map(ca.vec, used)), symbol)
