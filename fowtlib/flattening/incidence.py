"""Which unknowns an equation depends on, through orientations and external functions too."""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca
import numpy as np

from fowtlib.flattening.system import System


class Incidence:
    """Dependence of expressions on the unknowns of a system."""

    def __init__(self, system: System):
        self.system = system
        self._closures: list[np.ndarray] = []
        self._symbols: list[ca.SX] = []
        self._seen = 0
        self._unknowns = ca.SX(0, 1)

    def rows(self, column: ca.SX) -> list[np.ndarray]:
        """Numbers of the unknowns each element of a column depends on, sorted."""
        direct, through = self.split(column)
        if not self._symbols:
            return direct
        return [union([own, *self.closures(via)]) for own, via in zip(direct, through, strict=True)]

    def split(self, column: ca.SX) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Unknowns in the elements of a column themselves, and symbols of intermediates in them."""
        self._update()
        return self._pattern(column)

    def closures(self, symbols: Iterable[int]) -> list[np.ndarray]:
        """Unknowns that intermediate symbols depend on, each list once: the outputs of a call have the same."""
        return list({id(self._closures[k]): self._closures[k] for k in symbols}.values())

    @property
    def symbols(self) -> list[ca.SX]:
        """Symbols of the intermediates, in the order of the numbers that `split` gives."""
        self._update()
        return self._symbols

    def _pattern(self, column: ca.SX) -> tuple[list[np.ndarray], list[np.ndarray]]:
        if column.shape[0] == 0:
            return [], []
        intermediates = ca.vertcat(*self._symbols) if self._symbols else ca.SX(0, 1)
        function = ca.Function("incidence", [self._unknowns, intermediates], [column], {"allow_free": True})
        return _rows(function.jac_sparsity(0, 0)), _rows(function.jac_sparsity(0, 1))

    def _update(self) -> None:
        """Take up unknowns and intermediates that came since the last call."""
        system = self.system
        if self._unknowns.shape[0] != len(system.unknowns):
            self._unknowns = ca.vertcat(*[unknown.symbol for unknown in system.unknowns])
        fresh = system.intermediates[self._seen :]
        if not fresh:
            return
        self._seen = len(system.intermediates)
        self._symbols = self._symbols + [symbol for item in fresh for symbol in item.symbols]
        direct, through = self._pattern(ca.vertcat(*[item.inputs for item in fresh]))
        own: list[np.ndarray] = []
        via: list[np.ndarray] = []
        group: list[int] = []  # of each symbol; the symbols of a group depend on the same
        position = 0
        for item in fresh:
            block = slice(position, position + item.inputs.shape[0])
            position = block.stop
            if item.function is None:  # each symbol stands for the input of the same number
                group += range(len(own), len(own) + len(item.symbols))
                own += direct[block]
                via += through[block]
            else:
                group += [len(own)] * len(item.symbols)
                own.append(union(direct[block]))
                via.append(union(through[block]))
        self._closures += _transitive(self._closures, own, via, group)


def _transitive(
    known: list[np.ndarray], own: list[np.ndarray], via: list[np.ndarray], group: list[int]
) -> list[np.ndarray]:
    """Closures of symbols by their groups: what these depend on themselves, and via symbols with numbers from 0 on."""
    first, groups = len(known), np.array(group, int)
    closures: list[np.ndarray | None] = [None] * len(own)
    for start in range(len(own)):
        stack = [start]
        while stack:
            k = stack[-1]
            if closures[k] is not None:
                stack.pop()
                continue
            inside = np.unique(groups[via[k][via[k] >= first] - first])
            missing = [int(g) for g in inside if closures[g] is None]
            if missing:
                stack.extend(missing)
                continue
            parts = {id(known[j]): known[j] for j in via[k][via[k] < first]}  # symbols of a call share their closure
            closures[k] = union([own[k], *parts.values(), *(closures[g] for g in inside)])
            stack.pop()
    return [closures[g] for g in group]


def union(parts: Iterable[np.ndarray]) -> np.ndarray:
    """Sorted numbers of lists, sorted each and without repetitions, each number once."""
    parts = [part for part in parts if part.size]
    if len(parts) < 2:
        return parts[0] if parts else np.zeros(0, int)
    merged = np.concatenate(parts)
    merged.sort()
    first = np.empty(merged.size, bool)
    first[0] = True
    np.not_equal(merged[1:], merged[:-1], out=first[1:])
    return merged[first]


def _rows(sparsity: ca.Sparsity) -> list[np.ndarray]:
    transposed = sparsity.T  # column-compressed of the transpose: row-compressed
    pointers, indices = np.array(transposed.colind()), np.array(transposed.row(), dtype=int)
    return [indices[pointers[i] : pointers[i + 1]] for i in range(sparsity.shape[0])]
