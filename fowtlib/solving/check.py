"""The report of `Model.check()` and of `fowt check`: what a model is made of, and what is wrong unsolved."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.dimensions import DimensionReport
from fowtlib.solving.binding import Binding
from fowtlib.solving.checks import broken
from fowtlib.solving.functions import Functions
from fowtlib.solving.initial import freed_states
from fowtlib.solving.layout import Layout
from fowtlib.solving.rates import rate_states


@dataclass(frozen=True)
class ModelReport:
    """A model that flattens: its flat DAE, with the counts in `dae.stats`, and the findings of the dimension check.

    remarks: what its parts say of themselves, and what a run would warn of at the start; that is nothing wrong.
    faults: with what a run of it would end before it begins.
    """

    title: str
    parts: int
    dae: FlatDAE
    dimensions: DimensionReport
    remarks: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """True where nothing was found."""
        return self.dimensions.ok and not self.faults

    def __str__(self) -> str:
        dae, stats = self.dae, self.dae.stats
        counts = [
            f"{_n(self.parts, 'part')}, {_n(len(dae.parameters), 'tunable parameter')}, {_n(len(dae.inputs), 'input')}",
            f"{_n(stats['equations'], 'scalar equation')} for as many unknowns: {_n(len(dae.states), 'state')}, "
            f"{stats['aliases']} eliminated as equal to another, {len(dae.algebraics)} solved by iteration",
            f"{_n(stats['differentiated'], 'equation')} differentiated; {_n(stats['blocks'], 'block')} in order, "
            f"the largest of {stats['largest_block']}",
            f"{_n(len(dae.externals), 'external function')}, {_n(len(dae.events), 'state event')}, "
            f"{_n(len(dae.samples), 'sampled part')}, {_n(len(dae.checks), 'check')} while it runs",
            *str(self.dimensions).splitlines(),
            *self.faults,
            *self.remarks,
        ]
        return "\n  ".join([f"{self.title}: {'nothing wrong.' if self.ok else ''}".rstrip(), *counts])


def broken_at_start(dae: FlatDAE, binding: Binding, model: str, start: str = "file") -> tuple[list[str], list[str]]:
    """The conditions of its parts that do not hold at the start values of a model: errors, and warnings.

    Of those that follow from what is known there without solving: from states with values of their own, discrete
    variables, inputs and parameters. So the places of the ends of a line are judged, and not its tension, where that is
    found by iteration. start: the word of the model file, see solving.starts. Where a run begins in the mean position
    the start values are no more than where that is sought from: a broken condition is a warning at most.
    """
    if not dae.checks:
        return [], []
    at = Functions(dae).at(binding)
    x, z, d = at.start_values()
    if start == "rest":
        x[list(rate_states(dae).values())] = 0.0
    q = np.concatenate([Layout(dae).inputs(), d])
    free = freed_states(dae, set())[1] if dae.initial_equations.shape[0] else []
    unknown = ca.vertcat(dae.x[free], dae.z, dae.w)
    conditions = ca.vertcat(*[check.condition for check in dae.checks])
    pattern = ca.Function("known", [unknown], [conditions], {"allow_free": True}).jac_sparsity(0, 0)
    open_ones = set(pattern.get_triplet()[0])
    known = [k for k in range(len(dae.checks)) if k not in open_ones]
    if not known:
        return [], []
    values = at.call(at.functions.function("known", [conditions[known]]), 0.0, x, z, q)
    found: dict[str, list[str]] = {"error": [], "warning": []}
    for k in np.array(known)[np.array(values).ravel() == 0].tolist():
        if dae.checks[k].level in found:
            found[dae.checks[k].level].append(f"at the start values, {broken(at, k, model, 0.0, x, z, q)}")
    return (found["error"], found["warning"]) if start in ("file", "rest") else ([], found["error"])


def _n(number: float, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"
