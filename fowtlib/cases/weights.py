"""The share of the lifetime of each case: by a distribution of the wind speed in bins, or by a scatter table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fowtlib.cases import csv_tables
from fowtlib.cases.folder import Folder
from fowtlib.cases.values import Item, Names, evaluate, scalar, word
from fowtlib.language.errors import one_of
from fowtlib.modelfile.nodes import Node
from fowtlib.modelfile.specs import check_keys, mapping

DEFAULT_VARIABLE = "wind_speed"
FORMS = {"weibull": ("scale", "shape"), "rayleigh": ("mean",)}
SCATTER, SHARE = "scatter", "weight"
KEYS = (*FORMS, SCATTER, "of", "width")


@dataclass(frozen=True)
class Weights:
    """Shares by the values of the variables `of`."""

    of: tuple[str, ...]
    share: Callable[[Sequence[float]], Mapping[float, float]] | None
    scatter: Mapping[tuple[str | int | float | bool, ...], float]
    node: Node

    def given(self, rows: Sequence[Mapping[str, Item]], factors: Sequence[float]) -> list[float]:
        """The weights of cases with these variables; those of the same state share its weight by their factors."""
        states = [tuple(row[name].label for name in self.of) for row in rows]
        shares = self.scatter if self.share is None else self._by_bins(rows)
        for state in states:
            if state not in shares:
                told = ", ".join(f"{name} = {value}" for name, value in zip(self.of, state, strict=True))
                raise self.node.place.error(f"weights: the scatter table has no row with {told}.")
        for state in shares:
            if state not in states:
                told = ", ".join(f"{name} = {value}" for name, value in zip(self.of, state, strict=True))
                raise self.node.place.error(
                    f"weights: no case has {told}, which the scatter table holds; a part of the lifetime would be lost."
                )
        totals = dict.fromkeys(states, 0.0)
        for state, factor in zip(states, factors, strict=True):
            totals[state] += factor
        return [shares[state] * factor / totals[state] if totals[state] else 0.0
                for state, factor in zip(states, factors, strict=True)]  # fmt: skip

    def _by_bins(self, rows: Sequence[Mapping[str, Item]]) -> dict[tuple[str | int | float | bool, ...], float]:
        values: dict[float, tuple[str | int | float | bool, ...]] = {}
        for row in rows:
            item = row[self.of[0]]
            if item.quantity is None:
                raise self.node.place.error(f"weights: '{item.written}' of '{self.of[0]}' is no number.")
            values[float(item.quantity.value)] = (item.label,)
        assert self.share is not None
        return {values[value]: share for value, share in self.share(sorted(values)).items()}


def read(node: Node, variables: Sequence[str], names: Names, folder: Folder, files: list[Path]) -> Weights:
    """What `weights` says; `variables` are those that vary."""
    items = mapping(node, f"'weights' is a mapping with {one_of([*FORMS, SCATTER])}")
    check_keys(items, KEYS, "'weights'")
    chosen = [key for key in (*FORMS, SCATTER) if key in items]
    if len(chosen) != 1:
        raise node.place.error(f"'weights' needs one of {one_of([*FORMS, SCATTER])}.")
    if chosen[0] == SCATTER:
        for key in ("of", "width"):
            if key in items:
                raise items[key].place.error(f"'{key}' does not belong to a scatter table.")
        return _scatter(items[SCATTER], variables, names, folder, files)
    of = word(items["of"], "of", names) if "of" in items else DEFAULT_VARIABLE
    if of not in variables:
        raise node.place.error(f"weights: '{of}' does not vary in this set; say what does: 'of: wind_speed'.")
    width = scalar(items["width"], "width", names, "m/s") if "width" in items else None
    return Weights((of,), _shares(chosen[0], items[chosen[0]], width, node, names), {}, node)


def law(form: str, node: Node, names: Names) -> dict[str, float]:
    """The parameters of a distribution of the wind speed by their names in FORMS; scale and mean [m/s]."""
    items = mapping(node, f"'{form}' is a mapping: {', '.join(FORMS[form])}")
    check_keys(items, FORMS[form], f"'{form}'")
    for key in FORMS[form]:
        if key not in items:
            raise node.place.error(f"'{form}' needs '{key}'.")
    units = {"scale": "m/s", "mean": "m/s", "shape": "1"}
    values = {key: scalar(items[key], key, names, units[key]) for key in FORMS[form]}
    for key, value in values.items():
        if not (value > 0 and math.isfinite(value)):
            raise items[key].place.error(f"{form}: {key} is {value:g}, and must be above zero.")
    return values


def _shares(form: str, node: Node, width: float | None, whole: Node, names: Names):
    values = law(form, node, names)
    if form == "rayleigh":
        values = {"shape": 2.0, "scale": values["mean"] * 2 / math.sqrt(math.pi)}

    def above(speed: float) -> float:
        return math.exp(-((max(speed, 0.0) / values["scale"]) ** values["shape"]))

    def shares(speeds: Sequence[float]) -> dict[float, float]:
        if width is None and len(speeds) < 2:
            raise whole.place.error("weights: one wind speed has no bin of its own; give its 'width'.")
        middles = [(a + b) / 2 for a, b in zip(speeds[:-1], speeds[1:], strict=True)]
        if width is not None:
            if width <= 0 or any(b - a < width * (1 - 1e-9) for a, b in zip(speeds[:-1], speeds[1:], strict=True)):
                raise whole.place.error(f"weights: bins of {width:g} m/s overlap, or have no width.")
            return {v: above(v - width / 2) - above(v + width / 2) for v in speeds}
        edges = [2 * speeds[0] - middles[0], *middles, 2 * speeds[-1] - middles[-1]]
        return {v: above(a) - above(b) for v, a, b in zip(speeds, edges[:-1], edges[1:], strict=True)}

    return shares


def _scatter(node: Node, variables: Sequence[str], names: Names, folder: Folder, files: list[Path]) -> Weights:
    """Rows of states with their weight."""
    if isinstance(node.value, str):
        columns = csv_tables.read(node, folder, files)
    else:
        entries = mapping(node, "'scatter' is a mapping of lists, one of them 'weight', or the name of a CSV file")
        columns = {key: [evaluate(one, names) for one in item.value] if isinstance(item.value, list) else []
                   for key, item in entries.items()}  # fmt: skip
    if SHARE not in columns or len({len(items) for items in columns.values()}) > 1 or not columns[SHARE]:
        raise node.place.error(f"the scatter table needs a column '{SHARE}' and others of the same length.")
    of = tuple(name for name in columns if name != SHARE)
    for name in of:
        if name not in variables:
            raise node.place.error(f"the scatter table has a column '{name}', and no such variable varies in this set.")
    table: dict[tuple[str | int | float | bool, ...], float] = {}
    for k, item in enumerate(columns[SHARE]):
        state = tuple(columns[name][k].label for name in of)
        if item.quantity is None or not (math.isfinite(item.quantity.value) and item.quantity.value >= 0):
            raise node.place.error(f"the scatter table: the weight '{item.written}' is not a number of zero or more.")
        if state in table:
            raise node.place.error(f"the scatter table has two rows for {', '.join(map(str, state))}.")
        table[state] = float(item.quantity.value)
    return Weights(of, None, table, node)
