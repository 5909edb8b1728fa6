"""Names of cases, which are names of files on every system."""

from __future__ import annotations

import re

from fowtlib.modelfile.nodes import Place

LONGEST = 100
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]*")
_DEVICES = {"con", "prn", "aux", "nul", *(f"{what}{k}" for what in ("com", "lpt") for k in range(1, 10))}


class Register:
    """The names that are taken; capitals make no difference, as some systems make none."""

    def __init__(self) -> None:
        self.places: dict[str, tuple[str, Place]] = {}
        self.counts: dict[str, int] = {}

    def numbered(self, group: str) -> str:
        """A name for a case whose set has no pattern: of its group, with a number."""
        stem = re.sub(r"[^A-Za-z0-9.+-]+", "_", group).strip("_.+-").lower()[:60] or "case"
        self.counts[stem] = self.counts.get(stem, 0) + 1
        return f"{stem}_{self.counts[stem]:04d}"

    def add(self, name: str, place: Place) -> str:
        """Take a name; an error where it cannot be one, or is taken."""
        if not _NAME.fullmatch(name):
            raise place.error(
                f"'{name[:60]}' cannot be the name of a case, which names its files: take letters of the English "
                "alphabet, digits, '_', '-', '+' and '.', the first a letter or a digit."
            )
        if len(name) > LONGEST:
            raise place.error(f"the name '{name[:40]}...' has {len(name)} letters; the limit is {LONGEST}.")
        if name.endswith(".") or name.lower().partition(".")[0] in _DEVICES:
            raise place.error(f"'{name}' cannot be the name of a file on every system; take another pattern.")
        key = name.lower()
        if key in self.places:
            other, first = self.places[key]
            like = "" if other == name else f", and '{other}' differs from it in capitals only"
            raise place.error(
                f"two cases are called '{name}'{like}; the first is of {first}. Put what differs into the pattern "
                "'name', as in u{wind_speed:02.0f}_s{seed_number}."
            )
        self.places[key] = name, place
        return name
