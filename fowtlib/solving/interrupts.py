"""Ctrl-C while compiled code runs: an exception raised inside of it would be lost, so it waits for a safe place."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from fowtlib.language.stopping import STOP_ASKED


@contextmanager
def deferred_interrupt() -> Iterator[threading.Event]:
    """While the block runs, the first Ctrl-C only sets the event; a second one acts at once."""
    interrupted = threading.Event()
    here = threading.current_thread() is threading.main_thread()  # only the main thread gets signals
    if not here or signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in the background a shell takes Ctrl-C away
        yield interrupted
        return

    def note(number: int, frame: object) -> None:
        interrupted.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, note)
    known = STOP_ASKED.set(interrupted)
    try:
        yield interrupted
    finally:
        STOP_ASKED.reset(known)
        signal.signal(signal.SIGINT, before)
