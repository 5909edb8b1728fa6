"""The command line, `fowt`: one module per group of commands; `app` puts them together."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from fowtlib.cli.control_c import heard

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """The program `fowt`; see app.main. Ctrl-C is answered in one line while the commands are being imported, too."""
    try:
        with heard():
            from fowtlib.cli import app

            return app.main(argv)
    except KeyboardInterrupt:
        print("fowt: stopped; nothing was saved.", file=sys.stderr)
        return 130
