"""The command line, `fowt`: one module per group of commands; `app` puts them together."""

from fowtlib.cli.app import main

__all__ = ["main"]
