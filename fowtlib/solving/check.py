"""The report of `Model.check()` and of `fowt check`: what the model is made of, and whether its dimensions agree."""

from __future__ import annotations

from dataclasses import dataclass

from fowtlib.flattening import FlatDAE
from fowtlib.flattening.dimensions import DimensionReport


@dataclass(frozen=True)
class ModelReport:
    """A model that flattens: its flat DAE, with the counts in `dae.stats`, and the findings of the dimension check."""

    title: str
    parts: int
    dae: FlatDAE
    dimensions: DimensionReport

    @property
    def ok(self) -> bool:
        """True where nothing was found."""
        return self.dimensions.ok

    def __str__(self) -> str:
        dae, stats = self.dae, self.dae.stats
        counts = [
            f"{self.parts} parts, {len(dae.parameters)} tunable parameters, {len(dae.inputs)} inputs",
            f"{stats['equations']} scalar equations for as many unknowns: {len(dae.states)} states, "
            f"{stats['aliases']} eliminated as equal to another, {len(dae.algebraics)} solved by iteration",
            f"{stats['differentiated']} equations differentiated; {stats['blocks']} blocks in order, "
            f"the largest of {stats['largest_block']}",
            f"{len(dae.externals)} external functions, {len(dae.events)} state events, "
            f"{len(dae.samples)} sampled parts, {len(dae.checks)} checks while it runs",
            str(self.dimensions),
        ]
        return "\n".join([f"{self.title}: nothing wrong." if self.ok else f"{self.title}:", *("  " + "\n  ".join(
            line.splitlines()) for line in counts)])  # fmt: skip
