"""A worker of a batch on this computer: `python -m fowtlib.cases.worker`, started by fowtlib.cases.pool.

It reads jobs, one line of JSON each, and writes what becomes of them, one line each: {"ready": process}, {"at": [t,
end]} and {"outcome": ...}. It ends when its input does, at once: so it never outlives the process that started it,
however that ends. What models print goes to the log, which is its standard error.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import sys
import threading
import time
from typing import Any

TOLD = 0.5  # s between two reports of the simulated time


def main() -> None:
    """Carry out jobs until there are no more."""
    source, sink = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)  # what is printed must not get between the lines
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that runs the batch, which tells us
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def read() -> None:
        for line in source:
            jobs.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()

    def say(**message: Any) -> None:
        try:
            sink.write(json.dumps(message) + "\n")
            sink.flush()
        except OSError:  # nobody is there any more
            os._exit(1)

    from fowtlib.cases.job import Job, carry_out

    say(ready=os.getpid())
    while True:
        told = [0.0]

        def report(t: float, end: float, told: list[float] = told) -> None:
            now = time.monotonic()
            if now - told[0] >= TOLD:
                told[0] = now
                say(at=[t, end])

        job = json.loads(jobs.get())
        outcome = carry_out(Job(**job), report)
        say(outcome=outcome.plain())
        sys.stderr.flush()


if __name__ == "__main__":
    main()
