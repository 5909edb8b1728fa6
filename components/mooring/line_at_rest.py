"""Where the nodes of a line with dynamics are when a run starts: its shape at rest between its ends."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fowtlib.components.mechanics.attitude import place_at_start
from fowtlib.components.mooring.lumped_mass import FEATHER, TOUCH
from fowtlib.components.mooring.lumped_statics import StaticLine, first_shape, rounded, settled
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.language.expressions import value_of

Floats = NDArray[np.float64]


def shape_at_rest(line: Any) -> Floats:
    """Nodes of a DynamicLine, one after the other (3 (n + 1),) [m], world; not inside equations()."""
    return value_of(line, "shape at rest", lambda: _shape(line)).ravel()


def ends_at_start(line: Any) -> tuple[Floats, Floats]:
    """Anchor and fairlead (3,) [m], world, where a run starts."""
    upper = line.parameter_value("fairlead_start")
    if upper is None:
        upper = place_at_start(line, "fairlead")
    if upper is None:
        raise ParameterError(
            f"{line.label}.fairlead_start has no value, and no way of parts leads from a fixed frame to its fairlead: "
            "give the place of the fairlead where a run starts."
        )
    lower = place_at_start(line, "anchor")
    if lower is None:
        lower = line.parameter_value("anchor_position")
    return np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)


def _shape(line: Any) -> Floats:
    numbers, (lower, upper) = static_line(line), ends_at_start(line)
    stations = np.concatenate([[0.0], np.cumsum(numbers.length)])
    guess = first_shape(lower, upper, stations / stations[-1], stations[-1], numbers.depth)
    try:
        return settled(guess, numbers)
    except ModelError as error:
        raise ModelError(f"{line.label}: {error}") from None


def static_line(line: Any) -> StaticLine:
    """The numbers of a line as its parameters are now."""

    def of(name: str) -> Floats:
        return np.array(line.of_elements(name, line.parameter_value), dtype=float)

    def of_points(name: str) -> Floats:
        return np.array(line.of_nodes(name, line.parameter_value), dtype=float)

    world, EA = line.world, of("axial_stiffness")
    length = np.array(line.element_lengths(line.parameter_value), dtype=float)
    rho, gravity, depth = (float(world.parameter_value(k)) for k in ("water_density", "gravity", "water_depth"))
    own = _halves((of("mass_per_length") - rho * np.pi / 4 * of("diameter") ** 2) * length) * gravity
    weight = own + (of_points("point_mass") - rho * of_points("point_volume")) * gravity
    lift = rho * gravity * (_halves(np.pi / 4 * of("diameter") ** 2 * length) + of_points("point_volume"))
    diameter = of("diameter")[[0, *range(len(length))]]
    heavy = np.maximum(own, FEATHER)
    ground = float(line.parameter_value("seabed_stiffness")) * _halves(of("diameter") * length)
    width, law = TOUCH * heavy / ground, _law(line, EA, of)
    ground = ground * np.maximum(weight, heavy) / heavy
    return StaticLine(length, law, weight, lift, diameter, ground, width, depth)


def _law(line: Any, EA: Floats, of: Any) -> Any:
    """Tension over strain, and its slope."""
    table = line.parameter_value("strain_table")
    chosen = np.zeros(len(EA), bool)
    if table is not None:
        given = line.parameter_value("fibre") is not None
        chosen = of("fibre") > 0.5 if given else np.ones(len(EA), bool)
        table = np.asarray(table, dtype=float)
        slopes = np.diff(table[:, 1]) / np.diff(table[:, 0])

    def tension(strain: Floats) -> tuple[Floats, Floats]:
        pull, slope = EA * strain, EA.copy()
        if table is not None:
            value, rate = table[0, 1] + slopes[0] * (strain - table[0, 0]), np.full(len(strain), slopes[0])
            for corner, change in zip(table[1:-1, 0], np.diff(slopes), strict=True):
                above = strain - corner
                size = np.sqrt(above**2 + 1e-10)
                value, rate = value + change * (above + size) / 2, rate + change * (1 + above / size) / 2
            pull, slope = np.where(chosen, value, pull), np.where(chosen, rate, slope)
        return rounded(pull, slope, EA)

    return tension


def _halves(of_elements: Floats) -> Floats:
    return np.concatenate([[0.0], of_elements / 2]) + np.concatenate([of_elements / 2, [0.0]])
