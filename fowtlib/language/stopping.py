"""The wish of the user to stop a run, for parts that wait for something outside of this process."""

from __future__ import annotations

import threading
from contextvars import ContextVar

STOP_ASKED: ContextVar[threading.Event | None] = ContextVar("stop_asked", default=None)
"""Set while a run is at work: the event that its first Ctrl-C sets. Who waits long looks at it, gives up the
waiting and raises KeyboardInterrupt."""
