"""Regulators and estimators at several operating points as one table, which a part reads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from fowtlib.components.servo import EstimatorTable, GainTable
from fowtlib.control.estimators import Estimator
from fowtlib.control.points import OVER, OperatingPoint
from fowtlib.control.reduction import SampledModel
from fowtlib.control.regulators import Regulator
from fowtlib.language.errors import ParameterError

Design = TypeVar("Design", Regulator, Estimator)


def _in_order(
    points: Sequence[OperatingPoint], designs: Sequence[Design], what: str
) -> tuple[list[OperatingPoint], list[Design]]:
    """Both in the order of the schedule."""
    if len(points) != len(designs) or not points:
        raise ParameterError(f"there are {len(points)} operating points and {len(designs)} {what}; give one each.")
    order = np.argsort([point.value for point in points])
    return [points[i] for i in order], [designs[i] for i in order]


def gain_table(points: Sequence[OperatingPoint], regulators: Sequence[Regulator], over: str = OVER) -> GainTable:
    """The gains of regulators over the values of their points, with the set points and the trim there.

    All states of the regulators are measured signals, and what is integrated must be one of them, in SI. Raises
    ParameterError where the regulators do not fit together.
    """
    points, regulators = _in_order(points, regulators, "regulators")
    first = regulators[0]
    states, demands = first.model.states[: first.state_gain.shape[1]], first.model.inputs
    gains, integral_gains = [], []
    for point, regulator in zip(points, regulators, strict=True):
        own = regulator.model.states[: regulator.state_gain.shape[1]]
        if own != states or regulator.model.inputs != demands:
            raise ParameterError(
                f"{over} = {point.value:g}: the regulator has other states or inputs than the first one; design all of "
                "them for models with the same states."
            )
        strange = [name for name in regulator.integrals if name not in states]
        if strange:
            raise ParameterError(
                f"'{strange[0]}' is integrated and is no state; give the linear model the path of a state as output."
            )
        gains.append(regulator.state_gain)
        integral = np.zeros_like(regulator.state_gain)
        # the error is -y, so that u = -K_e e grows with the integral of y
        integral[:, [states.index(name) for name in regulator.integrals]] = -regulator.integral_gain
        integral_gains.append(integral)
    return GainTable(
        over, np.array([point.value for point in points]), tuple(states), tuple(demands), np.array(gains),
        np.array(integral_gains), np.array([[point[name] for name in states] for point in points]),
        np.array([[point[name] for name in demands] for point in points]),
    )  # fmt: skip


def estimator_table(
    points: Sequence[OperatingPoint], estimators: Sequence[Estimator], over: str = OVER
) -> EstimatorTable:
    """Estimators over the values of their points, with states, inputs and outputs at rest there.

    Outputs must count in SI: name them by their paths. Raises ParameterError where the estimators do not fit together,
    or are of sampled models.
    """
    points, estimators = _in_order(points, estimators, "estimators")
    first = estimators[0].model
    for point, estimator in zip(points, estimators, strict=True):
        own = estimator.model
        if isinstance(own, SampledModel):
            raise ParameterError(f"{over} = {point.value:g}: the estimator is of a sampled model; a part needs the "
                                 "continuous one.")  # fmt: skip
        if (own.states, own.inputs, own.outputs) != (first.states, first.inputs, first.outputs):
            raise ParameterError(
                f"{over} = {point.value:g}: the estimator has other states, inputs or outputs than the first one; "
                "design all of them for models with the same."
            )
    matrices = {name: np.array([estimator.model.matrices[name] for estimator in estimators]) for name in "ABCD"}
    rest = {
        key: np.array([[point[name] for name in names] for point in points]).reshape(len(points), len(names))
        for key, names in (("x0", first.states), ("u0", first.inputs), ("y0", first.outputs))
    }
    return EstimatorTable(
        over, np.array([point.value for point in points]), tuple(first.states), tuple(first.inputs),
        tuple(first.outputs), **matrices, L=np.array([estimator.gain for estimator in estimators]), **rest,
    )  # fmt: skip
