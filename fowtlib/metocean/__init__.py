"""Wind and sea as random variables: joint distributions, contours, bins, extremes of the long term."""

from fowtlib.metocean.batch_fits import fits_of_batch
from fowtlib.metocean.binning import bins
from fowtlib.metocean.comparison import Answers, compare_methods, worst_states
from fowtlib.metocean.contours import contour, cut_off, distance, inflated, radius, return_period, surface
from fowtlib.metocean.fits import Fits, read_fits, read_maxima, write_fits
from fowtlib.metocean.joint import ConditionalModel
from fowtlib.metocean.laws import LogNormal, Weibull
from fowtlib.metocean.long_term import (
    LongTerm,
    Modified,
    OnContour,
    environmental_contour,
    excess_of_fits,
    full_long_term,
    modified_contours,
    on_contour,
)
from fowtlib.metocean.representative import centre_bins, likely_states
from fowtlib.metocean.run_lists import cases_file, states_to_cases
from fowtlib.metocean.scatter import ScatterTable, read_scatter
from fowtlib.metocean.short_term import Each, Either, Extreme, Gumbel, ShortTerm, UpCrossings, known, one_by_one
from fowtlib.metocean.sites import environment, open_distribution, shipped, site
from fowtlib.metocean.states import State, States
from fowtlib.metocean.turbulence import Turbulence

__all__ = [
    "Answers",
    "ConditionalModel",
    "Each",
    "Either",
    "Extreme",
    "Fits",
    "Gumbel",
    "LogNormal",
    "LongTerm",
    "Modified",
    "OnContour",
    "ScatterTable",
    "ShortTerm",
    "State",
    "States",
    "Turbulence",
    "UpCrossings",
    "Weibull",
    "bins",
    "cases_file",
    "centre_bins",
    "compare_methods",
    "contour",
    "cut_off",
    "distance",
    "environment",
    "environmental_contour",
    "excess_of_fits",
    "fits_of_batch",
    "full_long_term",
    "inflated",
    "known",
    "likely_states",
    "modified_contours",
    "on_contour",
    "one_by_one",
    "open_distribution",
    "radius",
    "read_fits",
    "read_maxima",
    "read_scatter",
    "return_period",
    "shipped",
    "site",
    "states_to_cases",
    "surface",
    "worst_states",
    "write_fits",
]
