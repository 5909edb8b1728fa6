"""What rules need to know of a steel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Steel:
    """Young's modulus [Pa], Poisson's ratio [-], yield stress [Pa], density [kg/m^3].

    The yield stress of a plate falls with its thickness (EN 10025); that of the plate at hand is to be given.
    """

    youngs_modulus: Any = 2.1e11
    poissons_ratio: Any = 0.3
    yield_stress: Any = 355e6
    density: Any = 7850.0


STEEL = Steel()
