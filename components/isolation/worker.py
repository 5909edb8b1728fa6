"""The program that runs native code made elsewhere, in a process of its own: standard library only.

python worker.py MODULE MEMORY SIZE PARENT FOLDER

MODULE is a Python file with a class `Native(given, memory)`, which has `step() -> str`, `save() -> bytes`,
`restore(bytes)` and `close()`. MEMORY is a file of SIZE bytes that both processes map: numbers go through it. What is
given comes first on the standard input, in JSON. Then each byte there is a question: s(tep), g(et the state), p(ut the
state; its length and bytes follow), c(lose); or n(ear: the processor to run on follows), which has no answer. An answer
is a byte, '.' or '!' (refused), the length (uint32) of what follows, and a text or the state. What the library prints
goes to the standard error.

It ends when its standard input ends, or when the process PARENT does: then it deletes FOLDER too.
"""

import contextlib
import importlib.util
import json
import mmap
import os
import shutil
import signal
import struct
import sys
import threading
import time

HEAD = struct.Struct("<cI")
DONE = HEAD.pack(b".", 0)
SIZE = struct.Struct("<Q")
PROCESSOR = struct.Struct("<H")
ANYWHERE = 0xFFFF
OWN_THREADS = 2  # this one, and the one that watches the parent
TEXT = 1 << 20  # bytes of a text, at most


def _read(descriptor: int, size: int) -> bytes:
    """So many bytes; fewer at the end of the input."""
    found = bytearray()
    while len(found) < size and (piece := os.read(descriptor, size - len(found))):
        found += piece
    return bytes(found)


def _watch(parent: int, folder: str) -> None:
    """End with the process that has started this one, also while a library is at work or hangs."""
    while os.getppid() == parent:
        time.sleep(0.5)
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


class Place:
    """The processor to run on. A library with threads of its own has all of them, always."""

    def __init__(self) -> None:
        self.all = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
        self.calls, self.near, self.free = 0, False, False

    def move(self, processor: int) -> None:
        """To this processor, or to where the system wants."""
        if not self.free and not self._check():
            self.near = processor != ANYWHERE
            os.sched_setaffinity(0, {processor} if self.near else self.all)

    def look(self) -> None:
        """Once in a while see whether there are threads by now."""
        self.calls += 1
        if self.near and self.calls % 256 == 0:
            self._check()

    def _check(self) -> bool:
        threads = os.listdir("/proc/self/task")
        if len(threads) > OWN_THREADS:
            self.near, self.free = False, True
            for thread in threads:
                with contextlib.suppress(OSError):  # it may have ended
                    os.sched_setaffinity(int(thread), self.all)
        return self.free


def _load(path: str) -> type:
    spec = importlib.util.spec_from_file_location("native_unit", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Native


def main() -> None:
    """See above."""
    path, memory_file, size, parent, folder = sys.argv[1:6]
    questions, answers = os.dup(0), os.dup(1)
    os.dup2(2, 1)  # a library that prints must not get between the answers
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"):  # are for the simulation, which then ends this process
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    if os.name == "posix":
        threading.Thread(target=_watch, args=(int(parent), folder), daemon=True).start()

    def answer(kind: bytes, content: bytes = b"") -> None:
        left = memoryview(HEAD.pack(kind, len(content)) + content)
        while left:
            left = left[os.write(answers, left) :]

    def refuse(error: BaseException) -> None:
        text = str(error).strip() or type(error).__name__
        answer(b"!", text.encode("utf-8", "replace")[:TEXT])

    (length,) = SIZE.unpack(_read(questions, SIZE.size))
    given = json.loads(_read(questions, length))
    sys.path[:] = given["path"]
    with open(memory_file, "r+b") as file:
        memory = mmap.mmap(file.fileno(), int(size))
    try:
        native = _load(path)(given["given"], memory)
    except BaseException as error:
        refuse(error)
        return
    answer(b".")
    place = Place()
    while question := os.read(questions, 1):
        try:
            if question == b"s":
                place.look()
                if said := native.step():
                    answer(b".", said.encode("utf-8", "replace")[:TEXT])
                else:
                    os.write(answers, DONE)
            elif question == b"n":
                place.move(*PROCESSOR.unpack(_read(questions, PROCESSOR.size)))
            elif question == b"g":
                answer(b".", native.save())
            elif question == b"p":
                (length,) = SIZE.unpack(_read(questions, SIZE.size))
                native.restore(_read(questions, length))
                answer(b".")
            else:
                native.close()
                answer(b".")
                return
        except Exception as error:
            refuse(error)
            if question == b"c":
                return
    shutil.rmtree(folder, ignore_errors=True)  # nobody is there any more
    os._exit(1)


if __name__ == "__main__":
    main()
