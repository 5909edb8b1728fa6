"""Which states of a model are the rates of others."""

from __future__ import annotations

from typing import Any


def rate_states(dae: Any) -> dict[int, int]:
    """Numbers of the states that are the rates of states."""
    numbers = {dae.x[i].element_hash(): i for i in range(dae.x.shape[0])}
    rows = {k: numbers.get(dae.ode[k].element_hash()) for k in range(dae.ode.shape[0]) if dae.ode[k].is_symbolic()}
    return {k: number for k, number in rows.items() if number is not None}
