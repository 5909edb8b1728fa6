"""Regulators at several operating points as one table of gains, which a ScheduledFeedback reads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fowtlib.components.servo import GainTable
from fowtlib.control.points import OVER, OperatingPoint
from fowtlib.control.regulators import Regulator
from fowtlib.language.errors import ParameterError


def gain_table(points: Sequence[OperatingPoint], regulators: Sequence[Regulator], over: str = OVER) -> GainTable:
    """The gains of regulators over the values of their points, with the set points and the trim there.

    All states of the regulators are measured signals, and what is integrated must be one of them, in SI. Raises
    ParameterError where the regulators do not fit together.
    """
    if len(points) != len(regulators) or not points:
        counts = f"{len(points)} operating points and {len(regulators)} regulators"
        raise ParameterError(f"there are {counts}; give one each.")
    order = np.argsort([point.value for point in points])
    points, regulators = [points[i] for i in order], [regulators[i] for i in order]
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
