"""What surrounds a turbine: the world, the sea, the wind."""

# World has a Frame and the bodies of the mechanics need World: the mechanics load first and fetch World themselves.
from fowtlib.components import mechanics as _mechanics  # noqa: F401  isort: skip
from fowtlib.components.environment.world import World

__all__ = ["World"]
