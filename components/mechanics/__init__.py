"""Mechanical parts: 3-D multibody with `Frame` ports and 1-D rotational with `Flange` ports."""

from fowtlib.components.mechanics.connectors import Flange, Frame

__all__ = ["Flange", "Frame"]
