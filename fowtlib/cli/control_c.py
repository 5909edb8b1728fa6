"""Ctrl-C where the exception that it raises would be lost.

Python raises KeyboardInterrupt in whatever it runs at that moment. CasADi, before an operation, asks in Python what its
arguments are, and drops what is raised there; so does Python while it throws an object away. There the exception waits
for the next line of the code that passes it on.
"""

from __future__ import annotations

import copyreg
import os
import signal
import sys
import threading
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_DROPPING = (os.path.join("casadi", "casadi.py"), weakref.__file__)
_PLACES = {
    ("<frozen importlib._bootstrap>", "cb"),  # takes the lock of a module away
    (copyreg.__file__, "_slotnames"),  # of whatever is copied; what it cannot keep in a class it does not mind
}


@contextmanager
def heard() -> Iterator[None]:
    """While the block runs, KeyboardInterrupt of Ctrl-C gets to it from everywhere."""
    here = threading.current_thread() is threading.main_thread()
    if not here or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:  # it means something else
        yield
        return
    signal.signal(signal.SIGINT, _pressed)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _pressed(number: int, frame: FrameType | None) -> None:
    passing = _passing(frame)
    if passing is frame or passing is None or sys.gettrace() not in (None, _waiting):  # a debugger is at work
        raise KeyboardInterrupt

    def at_next_line(*_: Any) -> None:
        sys.settrace(None)
        passing.f_trace = None
        raise KeyboardInterrupt

    passing.f_trace = at_next_line
    sys.settrace(_waiting)


def _waiting(*_: Any) -> None:
    """Traces no other frame."""


def _passing(frame: FrameType | None) -> FrameType | None:
    """The innermost frame from which an exception gets to the outermost one."""
    passing = frame
    while frame is not None:
        if _drops(frame):
            passing = frame.f_back
        frame = frame.f_back
    return passing


def _drops(frame: FrameType) -> bool:
    code = frame.f_code
    place = code.co_filename, code.co_name
    return code.co_name == "__del__" or place in _PLACES or code.co_filename.endswith(_DROPPING)
