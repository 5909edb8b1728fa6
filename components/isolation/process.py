"""Native code made elsewhere as something to call: in this process, or in one of its own."""

from __future__ import annotations

import importlib.util
import json
import mmap
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Protocol

from fowtlib.components.isolation import worker
from fowtlib.components.isolation.nearness import Nearness
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.language.stopping import STOP_ASKED

LOOK = 0.2  # s between two looks at a call that does not return
KEPT = 4000  # bytes of what the library has printed last
SHOWN = 400  # letters of it in a message


class Unit(Protocol):
    """Native code at work. Its numbers go through `memory`, whose layout is an affair of the code and its user.

    All methods raise SimulationError with what the code says where it refuses.
    """

    memory: mmap.mmap | bytearray

    def step(self) -> str:
        """Call the code once; what it has to say, mostly nothing."""

    def save(self) -> bytes:
        """All that the code remembers."""

    def restore(self, state: bytes) -> None:
        """Go back to what `save` gave, also to that of another process."""

    def close(self, orderly: bool = True) -> None:
        """End the code; orderly: with its own last call."""


@cache
def _loaded(module: Path) -> Any:
    spec = importlib.util.spec_from_file_location(module.stem, module)
    code = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
    spec.loader.exec_module(code)  # type: ignore[union-attr]
    return code


class Inside:
    """Native code in this process: what it does to the process, it does to the session of the user."""

    def __init__(self, module: Path, given: dict[str, Any], size: int):
        self.memory = bytearray(size)
        self._native = self._guarded(_loaded(module).Native, given, self.memory)

    def _guarded(self, action: Any, *arguments: Any) -> Any:
        try:
            return action(*arguments)
        except ModelError:
            raise
        except Exception as error:
            raise SimulationError(str(error).strip() or type(error).__name__) from error

    def step(self) -> str:
        """See Unit."""
        return self._guarded(self._native.step)

    def save(self) -> bytes:
        """See Unit."""
        return self._guarded(self._native.save)

    def restore(self, state: bytes) -> None:
        """See Unit."""
        self._guarded(self._native.restore, state)

    def close(self, orderly: bool = True) -> None:
        """See Unit."""
        native, self._native = self._native, None
        if native is not None:
            self._guarded(native.close)


class Outside:
    """Native code in a process of its own; what kills or stops the code ends with an error here.

    module: the Python file with the class `Native` that the process loads, see worker.py. given: what its constructor
    gets, as in JSON. size: bytes of the memory that both share. what: what messages call the code. folder: one of
    `private_folder`; the process deletes it when this one has died. patience: wall time a call may take [s].
    Both processes sleep while the other one works.
    """

    def __init__(
        self, module: Path, given: dict[str, Any], size: int, *, what: str, folder: Path, patience: float,
        cwd: Path | None = None,
    ):  # fmt: skip
        self.what, self.patience = what, patience
        self._asked: float | None = None  # since when an answer is waited for
        self._stop: threading.Event | None = None
        self._cause = ""  # why this side has killed it
        self._ended = threading.Event()
        self._nearness = Nearness()
        self.memory = _shared_memory(folder / "memory", size)
        arguments = [str(module), str(folder / "memory"), str(size), str(os.getpid()), str(folder)]
        self._process = subprocess.Popen(
            [sys.executable, "-I", worker.__file__, *arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0, cwd=cwd or folder,
            start_new_session=True,  # Ctrl-C is for the simulation, which then ends the process
        )  # fmt: skip
        self._printed = _Printed(self._process.stderr)
        self._questions, self._answers = self._process.stdin.fileno(), self._process.stdout.fileno()
        threading.Thread(target=self._watch, daemon=True).start()
        content = json.dumps({"path": sys.path, "given": given}).encode()
        try:
            self._ask(worker.SIZE.pack(len(content)) + content, "loaded")
        except BaseException:
            self.close(orderly=False)
            raise

    def step(self) -> str:
        """See Unit."""
        before = self._nearness.enter()
        try:
            return self._ask(before + b"s", "called").decode("utf-8", "replace")
        finally:
            self._nearness.leave()

    def save(self) -> bytes:
        """See Unit."""
        return self._ask(b"g", "asked for its state")

    def restore(self, state: bytes) -> None:
        """See Unit."""
        self._ask(b"p" + worker.SIZE.pack(len(state)) + state, "given its state")

    def close(self, orderly: bool = True) -> None:
        """See Unit. What is at work or does not end is killed."""
        if self._ended.is_set():
            return
        try:
            if orderly and self._asked is None and self._process.poll() is None:
                self._ask(b"c", "ended")
                self._wait_for_the_end()
        finally:
            self._end()

    def last_words(self) -> str:
        """The end of what the code has printed."""
        return self._printed.tail()

    # --- questions and answers -----------------------------------------------------------------------------------

    def _ask(self, question: bytes, done: str) -> bytes:
        self._stop, self._asked = STOP_ASKED.get(), time.monotonic()
        try:
            sent = os.write(self._questions, question)
            while sent < len(question):
                sent += os.write(self._questions, question[sent : sent + (1 << 20)])
        except OSError:
            raise self._death(done) from None
        head = self._read(worker.HEAD.size)
        if head == worker.DONE:
            self._asked = None
            return b""
        if len(head) < worker.HEAD.size:
            raise self._death(done)
        kind, length = worker.HEAD.unpack(head)
        content = b""
        if length:
            content = self._read(length)
            if len(content) < length:
                raise self._death(done)
        self._asked = None
        if kind != b".":
            raise SimulationError(content.decode("utf-8", "replace"))
        return content

    def _read(self, size: int) -> bytes:
        found = os.read(self._answers, size)
        while 0 < len(found) < size and (piece := os.read(self._answers, size - len(found))):
            found += piece
        return found

    # --- what goes wrong -----------------------------------------------------------------------------------------

    def _watch(self) -> None:
        """Kill the process when a call lasts too long, or when the user wants to stop during a call."""
        while not self._ended.wait(min(LOOK, self.patience)):
            asked, stop = self._asked, self._stop
            if asked is None:
                continue
            waited = time.monotonic() - asked
            if waited > self.patience:
                self._cause = "patience"
            elif waited > LOOK and stop is not None and stop.is_set():
                self._cause = "stop"
            if self._cause:
                self._kill()
                return

    def _kill(self) -> None:
        with suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(self._process.pid, signal.SIGKILL)  # and what the library has started
            else:
                self._process.kill()

    def _death(self, done: str) -> SimulationError:
        try:
            code = self._process.wait(2)
        except subprocess.TimeoutExpired:
            code = None
        self._end()
        if self._cause == "stop":
            raise KeyboardInterrupt
        if self._cause == "patience":
            why = f"it took longer than {self.patience:g} s, its 'patience'"
        elif code is None:
            why = "it has cut the connection to the simulation"
        else:
            why = _end_of_a_process(code)
        return SimulationError(f"{self.what} cannot be {done}: {why}; it printed: {self.last_words() or 'nothing'}")

    def _wait_for_the_end(self) -> None:
        """The code is unloaded now, and may fail in that too."""
        try:
            code = self._process.wait(self.patience)
        except subprocess.TimeoutExpired:
            self._cause = "patience"
            raise self._death("unloaded") from None
        if code:
            raise self._death("unloaded")

    def _end(self) -> None:
        """Whatever was: no process, thread or descriptor remains."""
        self._ended.set()
        self._kill()
        self._process.wait()
        with suppress(OSError):
            self._process.stdin.close()
        self._process.stdout.close()
        self._printed.finish()


class _Printed:
    """The end of what comes out of a pipe, which is read as it comes, so that no disk fills and no writer waits."""

    def __init__(self, stream: Any):
        self._stream, self._tail = stream, b""
        self._thread = threading.Thread(target=self._drain, daemon=True)
        self._thread.start()

    def _drain(self) -> None:
        with self._stream, suppress(OSError, ValueError):
            while piece := self._stream.read(1 << 16):
                self._tail = (self._tail + piece)[-KEPT:]

    def finish(self) -> None:
        """Wait until the writer has gone."""
        self._thread.join(1.0)

    def tail(self) -> str:
        """The last lines in one."""
        self._thread.join(0.05)  # what was written before an answer is read by now
        lines = self._tail.decode("utf-8", "replace").split("\n")
        return " ".join(line.strip() for line in lines if line.strip())[-SHOWN:]


def _shared_memory(path: Path, size: int) -> mmap.mmap:
    """Zeros in a file that is mapped; all is written, so that a full disk shows here and not as a crash later."""
    try:
        with path.open("w+b") as file:
            file.write(bytes(size))
            file.flush()
            return mmap.mmap(file.fileno(), size)
    except OSError as error:
        raise SimulationError(f"there is no place for {size} bytes in '{path.parent}' ({error.strerror})") from None


def _end_of_a_process(code: int) -> str:
    if code >= 0:
        return f"it ended its process with the code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return f"it was killed ({name})" if name == "SIGKILL" else f"it crashed ({name})"
