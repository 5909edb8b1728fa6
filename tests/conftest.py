"""Settings of all tests: no property test depends on how fast the machine is, and every run sees the same examples.

Searching for new examples is a task of its own: `HYPOTHESIS_PROFILE=explore pytest`.
"""

import os
import signal

import pytest
from hypothesis import settings

settings.register_profile("fowtlib", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fowtlib"))


@pytest.fixture
def python_handler():
    """The handler of Ctrl-C of an interactive start; a shell may have taken it away."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def counted(monkeypatch):
    """How often, from now on, models are flattened, and C code of models is written and compiled."""
    from fowtlib.flattening import assembler
    from fowtlib.solving.engines import fixed_step_code

    monkeypatch.setenv("FOWTLIB_KEEP_FLAT", "no")  # what another test or process has flattened does not count
    counts = dict.fromkeys(("flattened", "written", "compiled"), 0)

    def count(owner, name, key, counts_too=lambda *_: True):
        original = getattr(owner, name)

        def counting(*arguments, **options):
            counts[key] += counts_too(*arguments)
            return original(*arguments, **options)

        monkeypatch.setattr(owner, name, counting)

    count(assembler._Flattening, "run", "flattened")
    count(fixed_step_code, "kept_text", "written")
    count(fixed_step_code, "load_library", "compiled", lambda text, name: name == "model")
    return counts
