"""Pages for people: what a batch of runs has found, as one HTML file that needs nothing else."""

from fowtlib.report.batch_page import batch_page, write_batch_page

__all__ = ["batch_page", "write_batch_page"]
