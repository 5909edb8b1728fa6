"""What an exception in `equations()` means for the author of the component: the line, and the reason in words."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

from fowtlib.language.equations import place

_PACKAGE = Path(__file__).parents[1]
_OURS = tuple(str(_PACKAGE / floor) for floor in ("language", "flattening"))
_REASONS = {
    "truth value": "a comparison of unknowns is neither true nor false while the model is made; "
    "write if_else(condition, a, b) of fowtlib.language.math.",
    "'eval_sx' not defined": "a CasADi function of MX is called on unknowns; call it by external(function, inputs).",
}


def author_line(error: BaseException) -> str:
    """`file:line` of the author's code in which an error arose: the last line outside of the kernel and of packages."""
    frames = traceback.extract_tb(error.__traceback__)
    outside = [f for f in frames if not f.filename.startswith(_OURS) and "site-packages" not in f.filename]
    frame = (outside or list(frames))[-1]
    return place(f"{frame.filename}:{frame.lineno}")


def reason(error: BaseException) -> str:
    """The reason in one sentence, without the file names of CasADi's sources."""
    text = str(error)
    for words, sentence in _REASONS.items():
        if words in text:
            return sentence
    lines = [line.strip() for line in text.splitlines() if line.strip()] or [type(error).__name__]
    line = re.sub(r"^\S*casadi/\S+:\d+: ", "", lines[-1])
    if isinstance(error, (RuntimeError, NotImplementedError, AttributeError, TypeError)):
        return line if line.endswith((".", "?")) else f"{line}."
    return f"{type(error).__name__}, {line}."
