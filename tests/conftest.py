"""Settings of all tests: no property test depends on how fast the machine is."""

from hypothesis import settings

settings.register_profile("fowtlib", deadline=None)
settings.load_profile("fowtlib")
