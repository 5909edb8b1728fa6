"""C text of the pieces of a program. What repeats itself, as the hinges of a beam do, is written once, with a table."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from fowtlib.solving.engines.c_lanes import OPERATIONS, VECTORS
from fowtlib.solving.engines.lanes import Lanes
from fowtlib.solving.engines.statements import Statement, Statements

REPEATED = 40  # statements from which on a text is shared

Segment = list[Statement]
Source = tuple[str, int, Lanes]
"""What a number in a table stands for: argument or result, and its element; or a column in the scratch memory."""


class Pieces:
    """C text of the pieces, of the functions and tables they share, and the first place in the scratch memory of each.

    segments: of each piece, lists of statements, which may be the same as others but for what they are of. word: lanes
    of a vector of C.
    """

    def __init__(self, name: str, statements: Statements, segments: list[list[Segment]], word: int):
        self.shared: list[str] = []
        self.bodies: list[str] = []
        self.places = [0]
        slot: dict[Lanes, int] = {}
        alike = _alike(statements, segments, word)
        kept = _kept(segments, alike)
        functions: dict[str, str] = {}
        for piece in segments:
            here, body = _Here(statements, word, kept, slot, self.places[-1]), ""
            for segment in piece:
                sources, text = alike.get(id(segment), ([], ""))
                if not text:
                    body += here.text(segment)
                    continue
                part = _Part(statements, word, kept)
                inside = part.text(segment)
                if text not in functions:
                    functions[text] = f"{name}_part_{len(functions)}"
                    self.shared.append(part.function(functions[text], inside))
                slot |= {column: here.size + offset for column, offset in part.slot.items()}
                numbers = [slot[column] if column else element for _, element, column in sources]
                table = f"{name}_table_{len(self.shared)}"
                values = ", ".join(map(str, [here.size, *numbers]))
                self.shared.append(f"static const int {table}[] = {{{values}}};\n")
                body += f"  {functions[text]}({', '.join([*part.used, 'scratch', table])});\n"
                here.size += part.size
            vectors = any(len(line.column) > 1 for segment in piece for line in segment)
            self.bodies.append(body + "  LEAVE\n" * vectors)
            self.places.append(here.size)


def _alike(statements: Statements, segments: list[list[Segment]], word: int) -> dict[int, tuple[list[Source], str]]:
    """By identity of a segment that has the same text as others: what its table holds, and the text."""
    found: dict[str, dict[int, tuple[list[Source], str]]] = defaultdict(dict)
    for piece in segments:
        for segment in piece:
            if len(segment) >= REPEATED:
                part = _Part(statements, word, frozenset())
                text = part.text(segment)
                found[text][id(segment)] = (list(part.sources), text)
    return {key: entry for same in found.values() if len(same) > 1 for key, entry in same.items()}


def _kept(segments: list[list[Segment]], alike: dict[int, tuple[list[Source], str]]) -> frozenset[Lanes]:
    """Columns that others need than the piece, or the shared text, that makes them; in all places of a shared text."""
    born: dict[Lanes, object] = {}
    parts = [(id(segment) if id(segment) in alike else -number, segment)
             for number, piece in enumerate(segments) for segment in piece]  # fmt: skip
    for part, segment in parts:
        born |= {line.column: part for line in segment if line.result is None}
    kept = {need for part, segment in parts for line in segment for need in line.needs if born[need] != part}
    same: dict[str, list[Segment]] = defaultdict(list)
    for _, segment in parts:
        if id(segment) in alike:
            same[alike[id(segment)][1]].append(segment)
    for some in same.values():
        for lines in zip(*some, strict=True):
            if any(line.result is None and line.column in kept for line in lines):
                kept |= {line.column for line in lines}
    return frozenset(kept)


class _Here:
    """How statements are written inside of a piece. slot: where what is kept lies; size: where the next does."""

    def __init__(self, statements: Statements, word: int, kept: frozenset[Lanes], slot: dict[Lanes, int], size: int):
        self.statements, self.word, self.kept, self.slot, self.size = statements, word, kept, slot, size
        self.names: dict[Lanes, list[str]] = {}

    def element(self, name: str, number: int) -> str:
        """An element of an argument or result."""
        return f"{name}[{number}]"

    def place(self, column: Lanes, lane: int) -> str:
        """Where in the scratch memory a lane of a column lies."""
        return str(self.slot[column] + lane)

    def next_place(self, offset: int) -> str:
        """Where in the scratch memory a column is kept that lies there from then on."""
        return str(offset)

    def number(self, column: Lanes) -> int:
        """The number in the name of a column."""
        return self.statements.number[column]

    def text(self, segment: Segment) -> str:
        """The text of statements."""
        lines = []
        for line in segment:
            if line.result is not None:
                lines.append(f"{self.element(*line.result)} = {self.value(line.column[0])}")
                continue
            texts = self.right(line.column)
            number, vector = self.number(line.column), len(line.column) > 1
            names = [f"v{number}{'ab'[k]}" for k in range(len(texts))] if vector else [f"a{number}"]
            self.names[line.column] = names
            lines += [
                f"const {'W' if vector else 'double'} {name} = {text}" for name, text in zip(names, texts, strict=True)
            ]
            if line.column in self.kept:
                self.slot[line.column] = self.size
                for name in names:
                    place = self.next_place(self.size)
                    lines.append(f"KEEP(scratch + {place}, {name})" if vector else f"scratch[{place}] = {name}")
                    self.size += self.word if vector else 1
        return "".join(f"  {line};\n" for line in lines)

    def value(self, value: int) -> str:
        """A number."""
        if value in self.statements.constants:
            return self.statements.constants[value]
        if value in self.statements.inputs:
            return self.element(*self.statements.inputs[value])
        column = self.statements.column.get(value, (value,))
        lane = column.index(value)
        if column not in self.names:
            return f"scratch[{self.place(column, lane)}]"
        names = self.names[column]
        return f"LANE({names[lane // self.word]}, {lane % self.word})" if len(column) > 1 else names[0]

    def vector(self, column: Lanes) -> list[str]:
        """The words of values side by side."""
        if column in self.names:
            return self.names[column]
        starts = range(0, len(column), self.word)
        if len(set(column)) == 1 or column[0] in self.statements.constants:
            return self.words([self.value(value) for value in column])
        if self.statements.direct(column):
            first = self.element(*self.statements.inputs[column[0]])
            return [f"LOAD(&{first} + {k})" for k in starts]
        return [f"LOAD(scratch + {self.place(column, k)})" for k in starts]

    def words(self, lanes: Sequence[str]) -> list[str]:
        """Words of lanes; what is left of the last one is filled with its last lane."""
        filled = [*lanes, *[lanes[-1]] * (-len(lanes) % self.word)]
        return [f"WORD({', '.join(filled[k : k + self.word])})" for k in range(0, len(filled), self.word)]

    def right(self, column: Lanes) -> list[str]:
        """What makes a number, or the words of a vector."""
        if self.statements.gathered(column):
            return self.words([self.value(value) for value in column])
        code, operands = self.statements.operations.code[column[0]], self.statements.operands(column)
        if len(column) == 1:
            return [OPERATIONS[code].format(*(self.value(operand[0]) for operand in operands))]
        if code in VECTORS:
            return [VECTORS[code].format(*words) for words in zip(*map(self.vector, operands), strict=True)]
        return self.words([OPERATIONS[code].format(*map(self.value, lane)) for lane in zip(*operands, strict=True)])


class _Part(_Here):
    """The same for a text that several places share: k[0] is where it begins to write, the rest is what it is of.

    sources: what the table holds behind k[0]. used: arguments and results of the function, by what they are in C.
    """

    def __init__(self, statements: Statements, word: int, kept: frozenset[Lanes]):
        super().__init__(statements, word, kept, {}, 0)
        self.sources: dict[Source, int] = {}
        self.used: dict[str, str] = {}
        self._arguments = {name for name, _ in statements.inputs.values()}

    def element(self, name: str, number: int) -> str:
        self.used[name] = f"{'const ' if name in self._arguments else ''}double *restrict {name}"
        return f"{name}[{self._number_of((name, number, ()))}]"

    def place(self, column: Lanes, lane: int) -> str:
        return f"{self._number_of(('', 0, column))} + {lane}"

    def next_place(self, offset: int) -> str:
        return f"k[0] + {offset}"

    def number(self, column: Lanes) -> int:
        return len(self.names)

    def _number_of(self, source: Source) -> str:
        return f"k[{1 + self.sources.setdefault(source, len(self.sources))}]"

    def function(self, name: str, body: str) -> str:
        """The text of a function."""
        parameters = ", ".join([*self.used.values(), "double *restrict scratch", "const int *restrict k"])
        return f"static FS_PIECE void {name}({parameters}) {{\n{body}}}\n"
