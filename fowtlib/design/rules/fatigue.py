"""Fatigue against its design factor."""

from __future__ import annotations

from typing import Any

from fowtlib.design.rules.either import demand, demand_not_negative, of_arrays


@of_arrays
def fatigue_utilisation(damage: Any, design_fatigue_factor: Any) -> Any:
    """Damage of the whole life times the design fatigue factor: DFF D <= 1 (DNVGL-ST-0126, DNV-RP-C203, 2.1).

    The factor is 1 to 3, by the consequence of a crack and how well it can be looked for; 2 for a tower and 3 for the
    hull below it are usual. Of a series of welds of which none may fail more is needed.
    """
    demand("fatigue", 0.0, design_fatigue_factor=design_fatigue_factor)
    demand_not_negative("fatigue", damage=damage)
    return design_fatigue_factor * damage
