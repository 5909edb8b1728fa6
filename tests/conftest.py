"""Settings of all tests: no property test depends on how fast the machine is, and every run sees the same examples.

Searching for new examples is a task of its own: `HYPOTHESIS_PROFILE=explore pytest`.
"""

import os

from hypothesis import settings

settings.register_profile("fowtlib", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fowtlib"))
