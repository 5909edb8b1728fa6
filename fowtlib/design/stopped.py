"""A search that the user has stopped: what it has found so far is kept."""

from __future__ import annotations

from collections.abc import Mapping


class SearchStopped(KeyboardInterrupt):
    """Ctrl-C during a search: the values so far that come nearest to what is asked for, from which another may begin.

    values [SI], units: by name; left: by how much they miss it, as the search measures that; tried: number of points.
    """

    def __init__(self, values: Mapping[str, float], units: Mapping[str, str], left: float, tried: int):
        super().__init__("search stopped")
        self.values, self.units, self.left, self.tried = values, units, left, tried

    @property
    def shown(self) -> str:
        """The values with their units, as one line."""
        return ", ".join(f"{name} = {value:.6g} {self.units[name]}".rstrip() for name, value in self.values.items())
