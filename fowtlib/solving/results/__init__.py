"""Results: labelled time series, their statistics and their files."""

from fowtlib.solving.results.data import Continuation, Observer, RawTrajectory, parameter_hash
from fowtlib.solving.results.result import Result, signature
from fowtlib.solving.results.statistics import Statistics, Summary

__all__ = ["Continuation", "Observer", "RawTrajectory", "Result", "Statistics", "Summary", "parameter_hash",
           "signature"]
