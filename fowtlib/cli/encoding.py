"""Text on an output whose encoding cannot write it all: plain characters in place of the others, never an error.

Windows gives a program whose output goes to a file or a pipe an encoding of its own (cp1252), and a minimal Linux none
but ASCII. Box lines become `|`, `+` and `-`, a degree sign `deg`, letters lose their accents, and the rest is `?`.
"""

from __future__ import annotations

import codecs
import io
import sys
import unicodedata

HANDLER = "fowtlib.plain"
_PLAIN = {
    "°": "deg", "·": "*", "×": "x", "−": "-", "–": "-", "—": "-", "‐": "-", "‑": "-", "…": "...", "’": "'", "‘": "'",
    "“": '"', "”": '"', "•": "*", "→": "->", "←": "<-", "±": "+-", "≤": "<=", "≥": ">=", "≈": "~", "√": "sqrt",
    "∞": "inf", "µ": "u", "μ": "u", "├": "|", "└": "`", "│": "|", "┃": "|", "─": "-", "━": "-", "╸": "-", "╺": "-",
    "ß": "ss", "æ": "ae", "ø": "o", "Æ": "AE", "Ø": "O", "ł": "l", "Ł": "L", "đ": "d",
}  # fmt: skip


def plain(text: str) -> str:
    """The text in ASCII."""
    return "".join(map(_plain, text))


def _plain(letter: str) -> str:
    if letter.isascii():
        return letter
    if letter in _PLAIN:
        return _PLAIN[letter]
    if "BOX DRAWINGS" in unicodedata.name(letter, ""):
        return "+"
    return unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode() or "?"


def _replaced(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return plain(error.object[error.start : error.end]), error.end


def write_what_can_be_written() -> None:
    """From now on stdout and stderr replace what their encoding lacks."""
    codecs.register_error(HANDLER, _replaced)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=HANDLER)


def is_unicode(stream: object) -> bool:
    """True where a stream can write every character."""
    return (getattr(stream, "encoding", None) or "utf-8").lower().replace("_", "-").startswith("utf")
