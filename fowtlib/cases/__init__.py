"""Load cases as data: what is run, in batches, and what became of it."""

from fowtlib.cases.case import Case
from fowtlib.cases.case_set import CaseSet
from fowtlib.cases.check import check_cases
from fowtlib.cases.file import read_cases

__all__ = ["Case", "CaseSet", "check_cases", "read_cases"]
