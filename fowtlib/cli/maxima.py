"""`fowt maxima`: the extreme value of a series in a given time, by several fits with confidence bounds."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import Any

from fowtlib.cli import results, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import finite, positive
from fowtlib.language.errors import ModelError

EXAMPLES = """Several results are realisations (seeds) of the same conditions. The value is
what the extreme in --duration stays within with the probability --fractile;
without that it is the most probable extreme.

methods:
  gumbel      maxima of blocks, Gumbel's distribution by moments
  likelihood  the same, by likelihood
  pareto      peaks over a threshold, generalized Pareto distribution
  exponential the same, exponential distribution
  crossings   up-crossing rates, q exp(-a (y - b)^c)
  gaussian    as of a Gaussian process, from mean, deviation and crossing rate

examples:
  fowt maxima run.nc --of surge --discard 400 --block 200
  fowt maxima seed_*.nc --of pitch --duration 10800 --plot gumbel.png
  fowt maxima run.nc --of surge --method crossings --plot rates.png
"""
METHODS = ("gumbel", "likelihood", "pareto", "exponential", "crossings", "gaussian")


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "extreme of a series in a given time, by fits with bounds"
    parser = commands.add_parser("maxima", help=text, epilog=EXAMPLES)
    results.declare(parser)
    add = parser.add_argument
    add("--of", required=True, metavar="NAME", help="the series, for example surge")
    add("--side", choices=("max", "min"), default="max", metavar="SIDE", help="max or min; default: max")
    add("--method", choices=METHODS, metavar="METHOD", help="one of the methods below; default: all")
    add("--duration", type=positive, metavar="S", default=3600.0, help="of the extreme [s]; default: 3600")
    add("--fractile", type=probability, metavar="P", help="probability to stay within; default: most probable extreme")
    add("--block", type=positive, metavar="S", help="length of blocks [s]; default: each result is one")
    add("--threshold", type=finite, metavar="X", help="of peaks and crossings; default: mean + 1.4 standard deviations")
    add("--separation", type=positive, metavar="S", default=0.0, help="least time between peaks [s]; default: 0")
    add("--confidence", type=probability, metavar="P", default=0.95, help="of the bounds; default: 0.95")
    add("--parametric", action="store_true", help="bootstrap from the fit, not from the data, where a fit can")
    add("--samples", type=samples, metavar="N", default=500, help="of the bootstrap, 20 or more; default: 500")
    add("--seed", type=int, metavar="N", default=0, help="of the bootstrap; default: 0")
    add("--plot", type=Path, metavar="FILE", help="draw Gumbel paper, or with --method crossings the rates")
    tables.declare(parser)
    parser.set_defaults(action=show_maxima)


def probability(text: str) -> float:
    """A number between 0 and 1, for argparse."""
    value = finite(text)
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a probability between 0 and 1")
    return value


def samples(text: str) -> int:
    """A whole number from 20 upward, for argparse."""
    if not text.isdecimal() or int(text) < 20:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of samples, 20 or more")
    return int(text)


def show_maxima(arguments: argparse.Namespace) -> int:
    """Print one row per method, and draw one of them."""
    from fowtlib.analysis.maximum import MOST_PROBABLE

    check_target(arguments.plot, FIGURES, arguments.force)
    tables.check(arguments)
    if arguments.plot and arguments.method in ("pareto", "exponential", "gaussian"):
        raise ModelError(f"--plot: there is no picture of the method {arguments.method}; take gumbel or crossings.")
    records = results.series(arguments.results, arguments.of)
    p = MOST_PROBABLE if arguments.fractile is None else arguments.fractile
    rows, fits = [], {}
    for method in [arguments.method] if arguments.method else METHODS:
        try:
            fit, about = _fit(method, records, arguments)
            parametric = arguments.parametric and not fit.plain_only
            bounds = fit.bounds(arguments.duration, p, confidence=arguments.confidence, count=arguments.samples,
                                seed=arguments.seed, parametric=parametric)  # fmt: skip
        except ModelError as error:
            if arguments.method:
                raise
            warnings.warn(f"{method}: {error}", stacklevel=1)
            continue
        fits[method] = fit
        rows.append((method, bounds.value, bounds.low, bounds.high, fit.unit, about))
    if not rows:
        raise ModelError(f"{arguments.of}: there is no fit; the warnings say why.")
    if arguments.plot:
        _draw(arguments, fits, records)
    what = "most probable" if arguments.fractile is None else f"{arguments.fractile:g} fractile of the"
    title = f"{what} {arguments.side}imum of {arguments.of} in {arguments.duration:g} s"
    percent = f"{100 * arguments.confidence:g} %"
    tables.show(arguments, ("method", "value", f"low {percent}", f"high {percent}", "unit", "fit"), rows, title)
    say_saved(arguments.plot)
    return 0


def _fit(method: str, records: list[Any], arguments: argparse.Namespace) -> tuple[Any, str]:
    """A fit, and its numbers in words."""
    from fowtlib.analysis.extremes import block_maxima, fit_gumbel, gaussian_maximum
    from fowtlib.analysis.peaks import fit_peaks, peaks
    from fowtlib.analysis.tails import fit_crossings

    common = {"side": arguments.side, "discard": arguments.discard}
    if method in ("gumbel", "likelihood"):
        block = arguments.block or min(_span(record) for record in records) - arguments.discard
        maxima = block_maxima(records, block, **common)
        fit = fit_gumbel(maxima, block, method="moments" if method == "gumbel" else method, side=arguments.side,
                         name=arguments.of, unit=records[0].attrs.get("units", "1"))  # fmt: skip
        blocks = f"{maxima.size} blocks of {block:g} s"
        return fit, f"{blocks}: location {fit.location:.5g}, scale {fit.scale:.4g}"
    if method in ("pareto", "exponential"):
        found = peaks(records, arguments.threshold, separation=arguments.separation, **common)
        fit = fit_peaks(found, shape=None if method == "pareto" else 0.0)
        return (
            fit,
            f"{found.values.size} peaks beyond {fit.threshold:.5g}: scale {fit.scale:.4g}, shape {fit.shape:.3g}",
        )
    if method == "crossings":
        fit = fit_crossings(records, arguments.threshold, **common)
        return fit, f"beyond {fit.threshold:.5g}: q {fit.q:.3g} 1/s, a {fit.a:.3g}, b {fit.b:.4g}, c {fit.c:.3g}"
    fit = gaussian_maximum(records, **common)
    return fit, f"mean {fit.mean:.5g}, deviation {fit.std:.4g}, {fit.mean_rate:.4g} 1/s"


def _span(record: Any) -> float:
    """Length of a record with the step behind its last point: 3600 points of 1 s are 3600 s."""
    time = record["time"].values
    return float(time[-1] - time[0]) * (1.0 + 1.0 / max(time.size - 1, 1))


def _draw(arguments: argparse.Namespace, fits: dict[str, Any], records: list[Any]) -> None:
    method = arguments.method or "gumbel"
    if method not in fits:
        raise ModelError("--plot: there are no blocks for Gumbel paper; give --block, or --method crossings.")
    if method == "crossings":
        gaussian, _ = _fit("gaussian", records, arguments)
        fits[method].plot(arguments.plot, duration=arguments.duration, gaussian=gaussian)
        return
    fits[method].plot(arguments.plot, duration=arguments.duration, confidence=arguments.confidence,
                      count=arguments.samples, seed=arguments.seed, parametric=arguments.parametric)  # fmt: skip
