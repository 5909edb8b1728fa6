"""Load cases as data: what is run, in batches, and what became of it."""

from fowtlib.cases.batch import Batch, Progress, run_batch
from fowtlib.cases.case import Case
from fowtlib.cases.case_set import CaseSet
from fowtlib.cases.check import check_cases
from fowtlib.cases.file import read_cases
from fowtlib.cases.registry import Row

__all__ = ["Batch", "Case", "CaseSet", "Progress", "Row", "check_cases", "read_cases", "run_batch"]
