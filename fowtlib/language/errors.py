"""The errors a user of a model meets: one plain sentence that says where, what is wrong and what to do.

A mistake of the user raises a subclass of `ModelError`; the command line prints its message and ends with status 2,
without a traceback. Anything else that is raised is a bug of the library or of a component.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Self


class ModelError(Exception):
    """A mistake in a model or in its use.

    `message` is the sentence; `where` is put in front of it: a place in a model file ("spar.yaml:12") or a path
    ("platform.motion").
    """

    def __init__(self, message: str, *, where: str = ""):
        self.message = message
        self.where = where
        super().__init__(message)

    def __str__(self) -> str:
        return f"{self.where}: {self.message}" if self.where else self.message

    def at(self, where: str) -> Self:
        """The same error with a place in front of the one it has: `raise error.at("spar.yaml:12")`."""
        self.where = ": ".join(filter(None, (where, self.where)))
        return self


class ParameterError(ModelError):
    """A parameter is unknown, missing, out of bounds, of the wrong shape or of the wrong type."""


class UnusedParameterError(ParameterError):
    """A parameter is given, and another one takes precedence, so that it would do nothing."""


class ConnectionFault(ModelError):
    """Ports are joined that cannot be, or a port that must be joined is not."""


class UnitError(ModelError):
    """A quantity has an unknown unit or the wrong dimension."""


class StructureError(ModelError):
    """The equations and the unknowns of a model do not fit each other, or an equation is not well formed."""


class SimulationError(ModelError):
    """The numbers fail: inconsistent start values, a residual that is not finite, a table left at its edge."""


class ModelFileError(ModelError):
    """A model file cannot be read or does not describe a model."""


class CompilerError(ModelError):
    """C code of a model cannot be compiled: there is no compiler, the text is wrong, or its cache cannot be written."""


class NotFoundError(ModelError):
    """A path or a name (of a variable, a parameter, an output, a model) does not exist."""


def one_of(names: Iterable[str], word: str = "or") -> str:
    """`'a', 'b' or 'c'`."""
    quoted = [f"'{name}'" for name in names]
    if len(quoted) < 2:
        return "".join(quoted)
    return f"{', '.join(quoted[:-1])} {word} {quoted[-1]}"


def did_you_mean(word: str, candidates: Iterable[str], *, list_up_to: int = 12) -> str:
    """The end of a message about an unknown name, to be put directly behind it.

    `; did you mean 'length'?` with the closest candidates; without a close one `; there are 'a', 'b' and 'c'.` for a
    short list of candidates, and `.` for a long or empty one.
    """
    names = list(dict.fromkeys(str(candidate) for candidate in candidates))
    close = closest(word, names)
    if close:
        return f"; did you mean {one_of(close)}?"
    if names and len(names) <= list_up_to:
        return f"; there {'is' if len(names) == 1 else 'are'} {one_of(names, 'and')}."
    return "."


def closest(word: str, candidates: Iterable[str]) -> list[str]:
    """The one to three candidates most like `word`, the best first; case does not count."""
    by_lower: dict[str, str] = {}
    for name in candidates:
        by_lower.setdefault(name.lower(), name)
    swapped = [name for lower, name in by_lower.items() if sorted(lower) == sorted(word.lower())]
    if swapped:
        return swapped[:3]
    best = difflib.get_close_matches(word.lower(), by_lower, n=3, cutoff=0.6)
    if not best:  # a part of a longer name, such as `draft` for `draft_of_column`
        best = [lower for lower in by_lower if len(word) > 2 and word.lower() in lower][:3]
    if not best:
        return []
    ratio = {lower: difflib.SequenceMatcher(None, word.lower(), lower).ratio() for lower in best}
    good = [lower for lower in by_lower if ratio.get(lower, 0.0) > max(ratio.values()) - 0.15]
    return [by_lower[lower] for lower in sorted(good, key=lambda lower: -ratio[lower])]
