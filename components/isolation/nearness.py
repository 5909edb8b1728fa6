"""Two processes that take turns, on one processor: waking a processor that sleeps takes longer than a short call."""

from __future__ import annotations

import ctypes
import os
import struct
import time
from contextlib import suppress

MOVE = struct.Struct("<cH")  # the question that takes the other process to a processor
ANYWHERE = 0xFFFF
SHORT = 1e-3  # s; in a longer call the time to wake up does not matter, and other processors may be free
LONG = 5  # so many in a row; a single one says only that the machine is busy
FIRST = 20  # calls before, in which a library starts what threads it has


class Nearness:
    """Keeps the thread that calls on its processor for the time of a call, and has the other process follow it there.

    Where two processors would take turns each of them falls asleep in the turn of the other, and each turn begins with
    its waking up: 40 us in a virtual machine, for calls of 30 us. On one processor a turn is a mere change of process.
    """

    def __init__(self) -> None:
        self._calls, self._long, self._there, self._off = 0, 0, ANYWHERE, False
        try:
            self._where = ctypes.CDLL(None).sched_getcpu
            self._all = os.sched_getaffinity(0)
        except (OSError, AttributeError, TypeError):  # not on Linux
            self._off = True
        else:
            self._off = len(self._all) < 2

    def enter(self) -> bytes:
        """Before a call: what must go before the question, so that the other process is where this one is."""
        self._calls += 1
        self._begin = time.perf_counter()
        if self._off:
            return b""
        if self._calls <= FIRST:
            return self._follow(ANYWHERE)
        here = self._where()
        try:
            os.sched_setaffinity(0, {here})
        except OSError:
            self._off = True
            return self._follow(ANYWHERE)
        return self._follow(here)

    def _follow(self, processor: int) -> bytes:
        if processor == self._there:
            return b""
        self._there = processor
        return MOVE.pack(b"n", processor)

    def leave(self) -> None:
        """After a call: this thread is as free as before."""
        if self._off or self._calls <= FIRST:
            return
        with suppress(OSError):
            os.sched_setaffinity(0, self._all)
        self._long = self._long + 1 if time.perf_counter() - self._begin > SHORT else 0
        if self._long == LONG:
            self._calls = self._long = 0  # off for a while
