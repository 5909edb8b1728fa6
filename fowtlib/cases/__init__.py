"""Load cases as data: what is run, in batches, and what became of it."""

from fowtlib.cases.case import Case

__all__ = ["Case"]
