"""Ctrl-C and the request to end (SIGTERM) while compiled code runs: an exception raised inside of it would be lost.

So the signal sets a flag, and long work runs in a thread of its own while the main thread, the only one that gets
signals, waits for it and for them.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import copy_context
from typing import TypeVar

from fowtlib.language.stopping import STOP_ASKED

Result = TypeVar("Result")
LOOK, PATIENCE = 0.02, 0.2  # s between two looks at the flag, and for work to end after it


@contextmanager
def deferred_interrupt() -> Iterator[threading.Event]:
    """While the block runs, the first Ctrl-C or SIGTERM only sets the event; a second one acts at once."""
    interrupted = threading.Event()
    here = threading.current_thread() is threading.main_thread()  # only the main thread gets signals
    numbers = [signal.SIGINT, signal.SIGTERM] if here else []
    before = {number: signal.getsignal(number) for number in numbers}
    # in the background a shell takes Ctrl-C away; a handler that Python did not set cannot be put back
    before = {number: handler for number, handler in before.items() if handler not in (signal.SIG_IGN, None)}

    def note(number: int, frame: object) -> None:
        interrupted.set()
        put_back()

    def put_back() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    for number in before:
        signal.signal(number, note)
    known = STOP_ASKED.set(interrupted)
    try:
        yield interrupted
    finally:
        STOP_ASKED.reset(known)
        put_back()


def stoppable(work: Callable[[], Result], interrupted: threading.Event, stop: Callable[[], None]) -> Result:
    """What `work` gives, done in a thread; KeyboardInterrupt soon after an interrupt, with or without its end.

    stop: asks the work to end early. Work that does not within PATIENCE is left to itself.
    """
    stderr, context = sys.stderr, copy_context()
    results: list[Result] = []
    errors: list[BaseException] = []

    def carry_out() -> None:
        try:
            results.append(context.run(work))
        except BaseException as error:  # it belongs to the caller
            errors.append(error)

    thread = threading.Thread(target=copy_context().run, args=(carry_out,), daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(LOOK)
        if interrupted.is_set() and thread.is_alive():
            stop()
            thread.join(PATIENCE)
            if thread.is_alive():
                sys.stderr = stderr  # the work may have turned it away
                raise KeyboardInterrupt
    if errors:
        raise errors[0]
    return results[0]
