"""Tests of a tank model in the dry and at rest: centre of gravity, inertia, stiffness of chains and of moorings.

Source: C. Serret (2019), Development of the Deepwater Turbine Installation-Floating concept, section 5.8 (inclination,
swing, chain) and 5.9 (pull); the formulas are those of a rigid body on a pivot and of a bar.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fowtlib.analysis.estimates import Estimate, covariance_of, of_formula
from fowtlib.analysis.plants import chosen_outputs, plant_of, shown_unit
from fowtlib.language.errors import ModelError

GRAVITY = 9.81


def inclination_test(moved: float, distance: ArrayLike, angle: ArrayLike, mass: float) -> Estimate:
    """Arm [m] of a body: what its centre of gravity hangs below a pivot, or afloat its metacentric height GM.

    moved [kg] is shifted across by each distance [m], which inclines the body of ``mass`` [kg], the moved one included,
    to the angle [rad]: tan(angle) = moved distance / (mass arm) + what it leans by itself. Least squares, with the
    error of the arm.
    """
    d, tangent = _pairs("an inclination test", distance, np.tan(np.asarray(angle, dtype=float)), 3)
    slope, _ = _line(d, tangent)
    if slope.value == 0.0:
        raise ModelError("an inclination test: the body does not incline; is the moved mass free to act?")
    arm = moved / (mass * slope.value)
    return Estimate(arm, abs(arm / slope.value) * slope.error, slope.freedom)


def swing_inertia(period: float, mass: float, arm: float, gravity: float = GRAVITY) -> float:
    """Moment of inertia [kg m^2] about the pivot of a compound pendulum: T^2/(4 pi^2) M g l."""
    return period**2 / (4 * math.pi**2) * mass * gravity * arm


@dataclass(frozen=True)
class SwingTest:
    """A body on a pivot: its first moment M l [kg m] and its moment of inertia about the pivot [kg m^2]."""

    moment: Estimate
    inertia: Estimate

    def arm(self, mass: float) -> Estimate:
        """Distance [m] of the centre of gravity below the pivot."""
        return Estimate(self.moment.value / mass, self.moment.error / mass, self.moment.freedom)

    def central(self, mass: float) -> float:
        """Moment of inertia [kg m^2] about the centre of gravity: I - M l^2."""
        return self.inertia.value - self.moment.value**2 / mass

    def less(self, frame: SwingTest) -> SwingTest:
        """The same without the frame that it hangs in, which has been swung alone."""

        def without(whole: Estimate, part: Estimate) -> Estimate:
            error = math.hypot(whole.error, part.error)
            return Estimate(whole.value - part.value, error, min(whole.freedom, part.freedom))

        return SwingTest(without(self.moment, frame.moment), without(self.inertia, frame.inertia))


def swing_test(period: ArrayLike, weight: float, height: ArrayLike, gravity: float = GRAVITY) -> SwingTest:
    """First moment and inertia of a body from the periods [s] of small swings with a known weight at some heights.

    weight [kg], a small one, is fixed at each height [m] below the pivot (negative: above). Each period gives one
    equation T^2/(4 pi^2) g (S + weight h) = I + weight h^2 that is linear in S and I. At least two heights; the errors
    are those of three or more.
    """
    T, h = _pairs("a swing test", period, height, 2)
    squared = T**2 / (4 * math.pi**2) * gravity
    basis = np.column_stack([squared, -np.ones(T.size)])
    target = weight * h**2 - squared * weight * h
    if np.linalg.matrix_rank(basis * [1.0, squared.mean()]) < 2:
        raise ModelError("a swing test: all periods are the same, so they do not tell the arm from the inertia; hang "
                         "the weight at heights further apart.")  # fmt: skip
    (moment, inertia), *_ = np.linalg.lstsq(basis, target, rcond=None)
    errors = np.zeros((2, 2))
    if T.size > 2:
        errors = covariance_of(basis, target - basis @ np.array([moment, inertia]))
    unit = np.eye(2)
    freedom = max(T.size - 2, 1)
    return SwingTest(Estimate(float(moment), of_formula(unit[0], errors), freedom),
                     Estimate(float(inertia), of_formula(unit[1], errors), freedom))  # fmt: skip


@dataclass(frozen=True)
class TensileTest:
    """Of a chain or rope: stiffness of the piece [N/m], EA [N], and E [Pa] of the circle of its equivalent diameter."""

    stiffness: Estimate
    axial_stiffness: Estimate
    modulus: Estimate


def tensile_test(extension: ArrayLike, force: ArrayLike, length: float, diameter: float) -> TensileTest:
    """Slope of the force [N] over the extension [m] of a piece of this length [m], and what follows from it."""
    x, y = _pairs("a tensile test", extension, force, 2)
    slope, _ = _line(x, y)
    area = math.pi / 4 * diameter**2
    return TensileTest(slope, _times(slope, length), _times(slope, length / area))


@dataclass(frozen=True)
class PullTest:
    """Equilibria of a model under a force that rises: displacements (n, k) of the results over forces (n,) [N].

    stiffness: force over displacement at no load, of each result, in N per unit of it.
    """

    force: np.ndarray
    results: tuple[str, ...]
    units: tuple[str, ...]
    displacement: np.ndarray
    stiffness: dict[str, float]

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.results:
            raise ModelError(f"the pull test has no result '{name}'; it has {', '.join(self.results)}.")
        return self.displacement[:, self.results.index(name)]

    def tangent(self, name: str) -> np.ndarray:
        """Stiffness d force / d displacement at every force (n,), N per unit of the result."""
        return np.gradient(self.force, self[name])


def pull_test(
    model: Any, load: str, forces: Sequence[float] | np.ndarray, *, results: Sequence[str] | None = None,
    axis: int = 0, parameters: Mapping[str, Any] | None = None,
) -> PullTest:  # fmt: skip
    """Pull a model step by step, as by weights on a string, and take its equilibria.

    load    path of a force or moment that is a vector parameter in the axes of the world, such as "pull.force" of a
            ConstantForce, or a single number; axis: which of its components is the pull
    forces  rising, with 0 among them or between them; results: names, None takes the six motions
    """
    plant = plant_of(model)
    names, values = chosen_outputs(plant, results), np.asarray(forces, dtype=float)
    if values.ndim != 1 or values.size < 3 or np.any(np.diff(values) <= 0) or not values[0] <= 0.0 <= values[-1]:
        raise ModelError("a pull test takes three forces or more that rise, with 0 N within them.")
    if load not in plant.dae.parameters:
        raise ModelError(f"there is no tunable load '{load}'; add a ConstantForce where the string is fixed.")
    size = plant.dae.parameters[load].symbol.numel()
    if not 0 <= axis < size:
        raise ModelError(f"{load} has {size} components; axis {axis} is none of them.")
    rows = []
    for value in values.tolist():
        vector = [value if k == axis else 0.0 for k in range(size)]
        state = plant.equilibrium(parameters={**(parameters or {}), load: vector if size > 1 else value})
        rows.append([float(np.asarray(state[name])) for name in names])
    table = np.array(rows)
    stiffness = {}
    for column, name in enumerate(names):
        slope = np.interp(0.0, values, np.gradient(table[:, column], values))
        stiffness[name] = 1 / float(slope) if abs(slope) * np.ptp(values) > 1e-9 else math.inf
    return PullTest(values, tuple(names), tuple(shown_unit(plant, name) for name in names), table, stiffness)


def _pairs(what: str, x: ArrayLike, y: ArrayLike, least: int) -> tuple[np.ndarray, np.ndarray]:
    one, other = np.atleast_1d(np.asarray(x, dtype=float)), np.atleast_1d(np.asarray(y, dtype=float))
    if one.shape != other.shape or one.ndim != 1 or one.size < least or not np.isfinite(one + other).all():
        raise ModelError(f"{what} takes {least} pairs of numbers or more, as many of one as of the other.")
    return one, other


def _line(x: np.ndarray, y: np.ndarray) -> tuple[Estimate, Estimate]:
    """Slope and intercept of the straight line, with errors where there are three points or more."""
    basis = np.column_stack([x, np.ones(x.size)])
    if np.ptp(x) == 0.0:
        raise ModelError("all abscissae are the same, so there is no slope.")
    weights, *_ = np.linalg.lstsq(basis, y, rcond=None)
    errors = covariance_of(basis, y - basis @ weights) if x.size > 2 else np.zeros((2, 2))
    slope, intercept = (Estimate(float(w), math.sqrt(errors[k, k]), max(x.size - 2, 1)) for k, w in enumerate(weights))
    return slope, intercept


def _times(one: Estimate, factor: float) -> Estimate:
    return Estimate(one.value * factor, one.error * abs(factor), one.freedom)
