"""Expressions of scalars as arrays of numbers, and back: the same operations, and nothing else.

CasADi's own files can name libraries that are loaded when they are read. These arrays can hold sums and sines only.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

_NO_ARITHMETIC = {ca.OP_CALL, ca.OP_PARAMETER}


class NotArithmetic(Exception):
    """An expression holds something else than operations of one or two scalars on the given symbols."""


@dataclass(frozen=True, eq=False)
class ScalarGraph:
    """Nodes: the symbols, the numbers, then groups of nodes of one operation, each of nodes before its group.

    groups (k, 2): CasADi's number of the operation, and how many nodes. first, second: the nodes that each is of,
    second -1 where it is of one. results: nodes.
    """

    symbols: int
    numbers: np.ndarray
    groups: np.ndarray
    first: np.ndarray
    second: np.ndarray
    results: np.ndarray

    @classmethod
    def of(cls, symbols: ca.SX, results: ca.SX) -> ScalarGraph:
        """The graph of a dense column in terms of a column of symbols. Raises NotArithmetic."""
        try:
            function = ca.Function("graph", [symbols], [results])
        except RuntimeError as error:  # free symbols
            raise NotArithmetic(str(error)) from None
        place: dict[int, int] = {}  # node in each place of the function's work vector
        level = [0] * symbols.shape[0]
        operations, one, two = [-1] * len(level), [-1] * len(level), [-1] * len(level)
        numbers, nodes = [], np.zeros(results.shape[0], np.int64)
        for k in range(function.n_instructions()):
            operation, read = function.instruction_id(k), function.instruction_input(k)
            if operation == ca.OP_OUTPUT:
                nodes[function.instruction_output(k)[1]] = place[read[0]]
                continue
            if operation == ca.OP_INPUT:
                place[function.instruction_output(k)[0]] = read[1]
                continue
            if operation in _NO_ARITHMETIC or len(read) > 2:
                raise NotArithmetic(f"operation {operation}")
            of = [place[i] for i in read] if operation != ca.OP_CONST else []
            if not of:
                numbers.append(function.instruction_constant(k))
            place[function.instruction_output(k)[0]] = len(level)
            level.append(1 + max((level[i] for i in of), default=0))
            operations.append(operation if of else -1)
            one.append(of[0] if of else -1)
            two.append(of[1] if len(of) == 2 else -1)
        return cls._sorted(symbols.shape[0], numbers, *map(np.array, (level, operations, one, two)), nodes)

    @classmethod
    def _sorted(cls, symbols: int, numbers: list[float], level: np.ndarray, operations: np.ndarray, one: np.ndarray,
                two: np.ndarray, results: np.ndarray) -> ScalarGraph:  # fmt: skip
        """The nodes in groups: numbers first, in their order, then by how much lies before them."""
        plain = operations < 0
        plain[:symbols] = True
        order = np.lexsort((operations, np.where(plain, 0, level)))
        now = np.empty(len(order) + 1, np.int64)  # where each node is now; -1 stays
        now[order], now[-1] = np.arange(len(order)), -1
        rest = order[symbols + len(numbers) :]
        starts = np.flatnonzero(np.diff(operations[rest] + 1000 * level[rest], prepend=-1))
        groups = np.column_stack([operations[rest][starts], np.diff(starts, append=len(rest))])
        return cls(symbols, np.array(numbers, float), groups, now[one[rest]], now[two[rest]], now[results])

    def expressions(self, symbols: ca.SX) -> ca.SX:
        """The results in terms of a column of symbols. Raises ValueError for arrays that are no graph."""
        nodes, last = ca.vertcat(symbols, ca.SX(ca.DM(self.numbers))), 0
        count = nodes.shape[0] + len(self.first)
        if symbols.shape[0] != self.symbols or len(self.first) != len(self.second) or np.any(self.groups < 0):
            raise ValueError("no graph of scalars")
        nodes = ca.vertcat(nodes, ca.SX.zeros(len(self.first), 1))
        for operation, size in self.groups.tolist():
            begin, upto = count - len(self.first) + last, last + size
            one, two = self.first[last:upto], self.second[last:upto]
            if one.min() < 0 or max(one.max(), two.max()) >= begin or len(one) != size:
                raise ValueError("no graph of scalars")
            first = nodes[one.tolist()]
            both = two[0] >= 0
            made = ca.SX.binary(operation, first, nodes[two.tolist()]) if both else ca.SX.unary(operation, first)
            nodes[begin : begin + size] = ca.densify(made)
            last = upto
        if last != len(self.first) or np.any((self.results < 0) | (self.results >= count)):
            raise ValueError("no graph of scalars")
        return nodes[self.results.tolist()] if len(self.results) else ca.SX(0, 1)
