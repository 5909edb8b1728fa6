"""A Bladed-style controller library, loaded and called: what runs in the process of the library.

This file is loaded by itself there: standard library only.
"""

import _ctypes
import ctypes
import os

MESSAGE_LENGTH = 1024
_STATUS, _LAST = 0, -1.0
_at_work: set[str] = set()


class ControllerFailure(Exception):
    """What the library says against a call; or the system, against loading it."""


class Native:
    """One run of a library. given: library, procedure, input_file, output_root, folder to run in.

    memory: the swap array, which the library reads and writes in place.
    """

    def __init__(self, given, memory):
        self.library = given["library"]
        if self.library in _at_work:
            raise ControllerFailure(
                f"the controller library '{self.library}' is at work in this process already, and has one memory only; "
                "let it run in processes of its own, in_process: false"
            )
        try:
            self.loaded = ctypes.CDLL(self.library)
            self.function = getattr(self.loaded, given["procedure"])
        except (OSError, AttributeError) as error:
            text = str(error)
            beside = "; a library that was unpacked from a wheel finds those it needs beside it: leave it in its folder"
            hint = beside if "cannot open shared object" in text or "Library not loaded" in text else ""
            raise ControllerFailure(f"the controller library cannot be loaded: {text}{hint}.") from None
        _at_work.add(self.library)
        self.function.restype = None
        self.folder, self.called = os.path.realpath(given["folder"]), False
        self.swap = (ctypes.c_float * (len(memory) // 4)).from_buffer(memory)
        self.flag, self.message = ctypes.c_int(0), ctypes.create_string_buffer(MESSAGE_LENGTH)
        names = [ctypes.create_string_buffer(given[name].encode()) for name in ("input_file", "output_root")]
        self.arguments = (self.swap, ctypes.byref(self.flag), *names, self.message)  # for all calls

    def step(self) -> str:
        """Call the library; what it warns of, mostly nothing."""
        self.called, before = True, os.getcwd()
        self.flag.value, self.message[0] = 0, b"\0"
        away = before != self.folder
        if away:
            os.chdir(self.folder)
        try:
            self.function(*self.arguments)
        finally:
            if away:
                os.chdir(before)
        text = self.message.value.strip().decode("utf-8", "replace")
        if self.flag.value < 0:
            raise ControllerFailure(f"the controller library reports an error: {text}")
        return (text or "no message") if self.flag.value > 0 else ""

    def close(self) -> None:
        """The last call, where there was a first one; and unload the library."""
        try:
            if self.called:
                self.swap[_STATUS] = _LAST
                self.step()
        finally:
            _at_work.discard(self.library)
            self.function = None
            unload = getattr(_ctypes, "dlclose", None) or _ctypes.FreeLibrary
            unload(self.loaded._handle)
