"""Rows of a flat model at random points: values and slopes with signals beside those of the run, and drag as a line.

A signal of wind or waves has its mean in the run of a mean state. Here each has a `shift` added, so that the equations
can be evaluated where a random process would take them. Quadratic laws |u| u are lines here, m |m| and the slope there
about their mean m: what drag does in the mean square has a law of its own (language.quadratic_laws).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.language import math as m
from fowtlib.solving.arrays import Arrays
from fowtlib.solving.functions import Functions


class DisturbedRows:
    """Rows (m,), expressions of a flat model, as functions of its symbols, of shifts of signals and of means of laws.

    symbols: of the signals, outputs of externals.
    """

    def __init__(self, dae: FlatDAE, rows: ca.SX, symbols: Sequence[ca.SX]):
        shift = ca.SX.sym("shift", len(symbols))
        means = ca.SX.sym("means", sum(law.added.numel() for law in dae.quadratics))
        expressions = [rows, *(item.inputs for item in dae.externals)]
        if dae.quadratics:
            added = ca.vertcat(*(law.added for law in dae.quadratics))
            ends = np.cumsum([0, *(law.added.numel() for law in dae.quadratics)]).tolist()
            lines = [_line(law.inputs, part, law.smoothing) - _law(law.inputs, law.smoothing)
                     for law, part in zip(dae.quadratics, ca.vertsplit(means, ends), strict=True)]  # fmt: skip
            expressions = ca.substitute(expressions, [added], [ca.vertcat(*lines)])
        if symbols:
            w = ca.vertcat(*symbols)
            expressions = ca.substitute(expressions, [w], [w + shift])
        pairs = zip(dae.externals, expressions[1:], strict=True)
        externals = tuple(replace(item, inputs=inputs) for item, inputs in pairs)
        self._rows, self._columns = expressions[0], [dae.x, dae.z, shift]
        self._functions = Functions(replace(dae, p=ca.vertcat(dae.p, shift, means), externals=externals))

    @cached_property
    def values(self) -> Arrays:
        """`(t, x, z, [u; d; p; shift; means]) -> rows`."""
        return Arrays(self._functions.function("disturbed", [ca.densify(self._rows)]))

    @cached_property
    def slopes(self) -> Arrays:
        """The same arguments -> rows by x, by z, by shift."""
        return Arrays(self._functions.torn_jacobian("disturbed_slopes", self._rows, self._columns))


def _law(u: ca.SX, smoothing: float) -> ca.SX:
    return m.smooth_norm(u, smoothing) * u


def _line(u: ca.SX, mean: ca.SX, smoothing: float) -> ca.SX:
    speed, off = m.smooth_norm(mean, smoothing), u - mean
    return speed * (mean + off) + mean * ca.dot(mean, off) / speed
