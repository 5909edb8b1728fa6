"""Names that every component has, which a class of the author cannot use for something else."""

from __future__ import annotations

from collections.abc import Sequence
from types import FrameType

from fowtlib.language.composition import OWN_NAMES
from fowtlib.language.equations import place
from fowtlib.language.errors import StructureError

FOR_AUTHORS = frozenset((
    "build", "equations", "drawing", "facts", "remarks", "in_the_mean", "before_the_run", "void", "units_within",
    "in_own_units", "of_the_air",
))  # fmt: skip
"""Those that a class says itself, as what they are."""


def refuse_names_of_all(every: type, cls: type, declared: Sequence[str], frame: FrameType) -> None:
    """StructureError where a class declares, or defines in its body, what each component has already.

    every: the class of all components. declared: parameters, ports, variables and parts of `cls`, with those of its
    bases; frame: of its class statement.
    """
    known = {name for name in dir(every) if not name.startswith("__")} | OWN_NAMES
    ours = cls.__module__.startswith("fowtlib.")  # a kind of component of the library itself may work otherwise
    defined = [] if ours else [name for name in vars(cls) if name in known - FOR_AUTHORS]
    for name in (*(name for name in declared if name in known), *defined):
        where = place(f"{frame.f_code.co_filename}:{frame.f_lineno}")
        raise StructureError(
            f"{cls.__name__} ({where}): '{name}' is a name that every component has already, for another use; call "
            f"it otherwise, such as 'own_{name.strip('_')}'."
        )
