"""The report of `Model.check()` and of `fowt check`: what the model is made of, and whether its dimensions agree."""

from __future__ import annotations

from dataclasses import dataclass

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.dimensions import DimensionReport


@dataclass(frozen=True)
class ModelReport:
    """A model that flattens: its flat DAE, with the counts in `dae.stats`, and the findings of the dimension check.

    remarks: what its parts say of themselves, which is nothing wrong.
    """

    title: str
    parts: int
    dae: FlatDAE
    dimensions: DimensionReport
    remarks: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """True where nothing was found."""
        return self.dimensions.ok

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
            *self.remarks,
        ]
        return "\n  ".join([f"{self.title}: {'nothing wrong.' if self.ok else ''}".rstrip(), *counts])


def _n(number: float, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"
