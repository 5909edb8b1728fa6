"""C text of the pieces of a program. What repeats itself, as the hinges of a beam do, is written once, with a table."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence

from fowtlib.solving.engines.c_lanes import OPERATIONS, VECTORS
from fowtlib.solving.engines.lanes import Lanes
from fowtlib.solving.engines.statements import Statement, Statements

REPEATED = 40  # statements from which on a text is shared
SHORT = 1 << 16  # above the largest number of half a word
IN_TEXT = {"0.0", "0.5", "1.0", "2.0", "(-1.0)"}  # constants that stand in a text that is shared

Segment = list[Statement]
Source = tuple[str, int, Lanes]
"""What a number in a table stands for: argument or result, and its element; or a lane of a column in the memory."""

Table = tuple[list[Source], list[str]]
"""Of a place of a shared text: sources, and texts of its constants."""


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
        segments = _joined(statements, segments, word)
        alike = _alike(statements, segments, word)
        kept = _kept(segments, alike)
        functions: dict[str, str] = {}
        largest = 0
        for piece in segments:
            here, body = _Here(statements, word, kept, slot, self.places[-1]), ""
            for segment in piece:
                if id(segment) not in alike:
                    body += here.text(segment)
                    continue
                (sources, constants), text = alike[id(segment)]
                here.size = here.whole(here.size)
                part = _Part(statements, word, kept)
                inside = part.text(segment)
                if text not in functions:
                    functions[text] = f"{name}_part_{len(functions)}"
                    self.shared.append(part.function(functions[text], f"{name}_place", inside))
                slot |= {column: here.size + offset for column, offset in part.slot.items()}
                places = (slot[column] + element if column else element for _, element, column in sources)
                numbers = [here.size, *places]
                table = f"{name}_table_{len(self.shared)}"
                largest = max(largest, *numbers)
                self.shared.append(f"static const {name}_place {table}[] = {{{', '.join(map(str, numbers))}}};\n")
                handed = [*part.used, "scratch", table]
                if constants:
                    handed.append(f"{table}_c")
                    self.shared.append(f"static const double {table}_c[] = {{{', '.join(constants)}}};\n")
                body += f"  {functions[text]}({', '.join(handed)});\n"
                here.size += part.size
            vectors = any(len(line.column) > 1 for segment in piece for line in segment)
            self.bodies.append(body + "  LEAVE\n" * vectors)
            self.places.append(here.whole(here.size))
        if self.shared:
            short = largest < SHORT
            self.shared.insert(0, f"typedef {'unsigned short' if short else 'int'} {name}_place;\n")


def _alike(statements: Statements, segments: list[list[Segment]], word: int) -> dict[int, tuple[Table, str]]:
    """By identity of a segment that has the same text as others: what its tables hold, and the text."""
    found: dict[str, dict[int, tuple[Table, str]]] = defaultdict(dict)
    for piece in segments:
        for segment in piece:
            if len(segment) >= REPEATED:
                part = _Part(statements, word, frozenset())
                text = part.text(segment)
                found[text][id(segment)] = (part.table, text)
    return {key: entry for same in found.values() if len(same) > 1 for key, entry in same.items()}


def _joined(statements: Statements, segments: list[list[Segment]], word: int) -> list[list[Segment]]:
    """The same, with the segments of a piece as one where the whole piece has the same text as another."""
    whole = [[line for segment in piece for line in segment] for piece in segments]
    texts = [_Part(statements, word, frozenset()).text(piece) if len(piece) >= REPEATED else "" for piece in whole]
    often = Counter(texts)
    return [[one] if text and often[text] > 1 else piece
            for one, text, piece in zip(whole, texts, segments, strict=True)]  # fmt: skip


def _kept(segments: list[list[Segment]], alike: dict[int, tuple[Table, str]]) -> frozenset[Lanes]:
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

    def whole(self, size: int) -> int:
        """The next place at which a word may lie, if the memory begins at one."""
        return -(-size // self.word) * self.word

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
                if vector:
                    self.size = self.whole(self.size)
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

    Constants that are no small whole numbers are in a table, too, c. table: what behind k[0] and in c has to stand.
    used: arguments and results of the function, by what they are in C.
    """

    def __init__(self, statements: Statements, word: int, kept: frozenset[Lanes]):
        super().__init__(statements, word, kept, {}, 0)
        self.used: dict[str, str] = {}
        self._sources: dict[Source, int] = {}
        self._constants: list[str] = []
        self._first: dict[Lanes, int] = {}  # of constants in a row
        self._arguments = {name for name, _ in statements.inputs.values()}

    @property
    def table(self) -> Table:
        return list(self._sources), self._constants

    def value(self, value: int) -> str:
        if value in self.statements.constants and self.statements.constants[value] not in IN_TEXT:
            return f"c[{self._place_of_constants((value,))}]"
        return super().value(value)

    def vector(self, column: Lanes) -> list[str]:
        if len(set(column)) > 1 and all(value in self.statements.constants for value in column):
            first = self._place_of_constants(column)
            return [f"LOAD(c + {first + k})" for k in range(0, len(column), self.word)]
        return super().vector(column)

    def _place_of_constants(self, column: Lanes) -> int:
        if column not in self._first:
            self._first[column] = len(self._constants)
            texts = [self.statements.constants[value] for value in column]
            self._constants += texts + [texts[-1]] * (-len(texts) % self.word if len(texts) > 1 else 0)
        return self._first[column]

    def element(self, name: str, number: int) -> str:
        self.used[name] = f"{'const ' if name in self._arguments else ''}double *restrict {name}"
        return f"{name}[{self._number_of((name, number, ()))}]"

    def place(self, column: Lanes, lane: int) -> str:
        return self._number_of(("", lane, column))

    def next_place(self, offset: int) -> str:
        return f"k[0] + {offset}"

    def number(self, column: Lanes) -> int:
        return len(self.names)

    def _number_of(self, source: Source) -> str:
        return f"k[{1 + self._sources.setdefault(source, len(self._sources))}]"

    def function(self, name: str, place: str, body: str) -> str:
        """The text of a function. place: the type of the numbers in k."""
        tables = [f"const {place} *restrict k", *["const double *restrict c"] * bool(self._constants)]
        parameters = ", ".join([*self.used.values(), "double *restrict scratch", *tables])
        return f"static FS_PIECE void {name}({parameters}) {{\n{body}}}\n"
