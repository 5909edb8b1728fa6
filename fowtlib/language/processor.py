"""Which vectors this compiler and processor have: C text that tells, and the answer for this machine."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from fowtlib.language.native import load_library


def processor_text() -> str:
    """C text: VECTORS where there are any, words for text in them, and `widest()`, the lanes of double numbers."""
    return Path(__file__).with_suffix(".c").read_text(encoding="utf-8")


@cache
def lanes_here() -> int:
    """Lanes of the widest vectors that the processor has and the compiler knows; 1 where there are none.

    Raises CompilerError without a compiler.
    """
    text = processor_text() + "#ifndef VECTORS\nstatic int widest(void) { return 1; }\n#endif\n"
    return load_library(text + "EXPORT int lanes(void) { return widest(); }\n", "processor")[1].lanes()
