"""Still water."""

from __future__ import annotations

from fowtlib.components.environment.sea.base import Sea


class StillSea(Sea, kind="still"):
    """No waves."""
