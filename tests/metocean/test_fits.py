"""Tables of what runs have given, and the methods beside each other."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fowtlib.language.errors import ParameterError
from fowtlib.metocean import (
    Fits,
    Gumbel,
    UpCrossings,
    bins,
    compare_methods,
    cut_off,
    full_long_term,
    modified_contours,
    radius,
    read_fits,
    read_maxima,
    site,
    surface,
    write_fits,
)
from fowtlib.metocean.pictures import plot_contours, plot_exceedance
from fowtlib.metocean.short_term import Either, known

JOINT = site("norway_5").at(90)
BINS = bins(JOINT, np.arange(4, 51, 4.0), np.arange(1, 21, 2.0), np.arange(2, 35, 4.0))
RINGS = {"wind_speeds": [8, 16, 24], "points": 5, "upper": True}
POINTS = (surface(JOINT, radius(50), **RINGS), surface(JOINT, cut_off(JOINT, 25)[0], **RINGS))


def surge(states) -> Gumbel:
    return Gumbel(states.wind_speed + 2 * states.wave_height, 0.2 + 0.1 * states.wave_height)


def write(path: Path, head: list[str], rows) -> Path:
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([head, *rows])
    return path


def fits_file(folder: Path, **change) -> Path:
    """Fits of one response in the bins and on both contours, with six digits."""
    rows = []
    for states in (BINS, *POINTS):
        law = surge(states)
        for index, state in enumerate(states):
            p = "" if states.probability is None else f"{states.probability[index]:.6g}"
            numbers = [*state, law.location[index], law.scale[index]]
            rows.append(["surge", "m", *(f"{value:.6g}" for value in numbers), p])
    head = ["response", "unit", "wind_speed [m/s]", "Hs [m]", "Tp [s]", "location", "scale", "probability"]
    return write(folder / "fits.csv", head, rows)


def test_fits_from_a_file_give_what_the_laws_give(tmp_path):
    fits = read_fits(fits_file(tmp_path))
    assert list(fits) == ["surge"]
    assert len(fits["surge"].bins[0]) == len(BINS)
    assert len(fits["surge"].points[0]) == 30
    (answers,) = compare_methods(JOINT, fits, cut_offs=[25])
    assert answers.flta.value(50) == pytest.approx(full_long_term(BINS, surge).value(50), rel=1e-4)
    expected = modified_contours(JOINT, surge, [25], **RINGS)
    assert answers.ecm.value == pytest.approx(expected.contours[0].value, rel=1e-4)
    assert answers.mecm.value == pytest.approx(expected.value, rel=1e-4)
    assert len(answers.contours[0].states) == len(answers.contours[1].states) == 15


def test_rates_from_a_file(tmp_path):
    head = ["response", "wind_speed", "Hs", "Tp", "probability", "q", "a", "b", "c", "threshold"]
    rows = [["yaw", 10, 3, 9, 0.4, 0.1, 0.5, 2, 2, 3], ["yaw", 20, 5, 11, 0.1, 0.1, 0.5, 4, 2, 6]]
    fits = read_fits(write(tmp_path / "rates.csv", head, rows), duration=600)
    found = compare_methods(JOINT, fits, duration=600)[0]
    law = UpCrossings(0.1, 0.5, np.array([2, 4]), 2, 600, np.array([3, 6]))
    assert found.flta.exceedance(7.5) == pytest.approx(np.array([0.4, 0.1]) @ law.sf(7.5))
    assert found.ecm is None and found.mecm is None


def test_fits_are_written_and_read(tmp_path):
    """Both forms; the rates from fits with attributes, as those of fowtlib.analysis have them."""
    tails = [SimpleNamespace(q=0.1, a=0.3, b=1.0, c=1.5 + 0.1 * i, threshold=2.0, sign=1.0) for i in range(len(BINS))]
    rates = Fits("yaw", "deg", (BINS, UpCrossings.of(tails, 600.0)), None)
    write_fits(tmp_path / "rates.csv", [rates])
    found = read_fits(tmp_path / "rates.csv", 600.0)["yaw"]
    assert found.unit == "deg" and found.points is None
    assert np.array_equal(found.bins[0].weights, BINS.weights)
    assert np.array_equal(found.bins[1].sf(6.0), rates.bins[1].sf(6.0))
    both = Fits("surge", "m", (BINS, surge(BINS)), (POINTS[0], surge(POINTS[0])))
    write_fits(tmp_path / "both.csv", [both])
    assert np.array_equal(read_fits(tmp_path / "both.csv")["surge"].points[1].isf(0.1), both.points[1].isf(0.1))
    with pytest.raises(ParameterError, match="laws of one form"):
        write_fits(tmp_path / "mixed.csv", [rates, both])
    with pytest.raises(ParameterError, match="only Gumbel laws, and rates with a threshold"):
        write_fits(tmp_path / "no.csv", [Fits("x", "", (BINS, UpCrossings(1, 1, 0, 2)), None)])
    assert not (tmp_path / "mixed.csv").exists()


def test_maxima_of_runs_are_fitted_state_by_state(tmp_path):
    rng = np.random.default_rng(2)
    rows = []
    for states in (BINS[:3], POINTS[0][:2]):
        law = surge(states)
        for seed in range(4):
            for index, (state, value) in enumerate(zip(states, law.isf(rng.uniform(size=len(states))), strict=True)):
                p = "" if states.probability is None else states.probability[index]
                rows.append([*state, p, seed, value, -value])
    head = ["wind_speed", "Hs", "Tp", "probability", "seed", "surge [m]", "tension [kN]"]
    fits = read_maxima(write(tmp_path / "maxima.csv", head, rows))
    assert list(fits) == ["surge", "tension"] and fits["tension"].unit == "kN"
    states, law = fits["surge"].bins
    first = [row[5] for row in rows if tuple(row[:3]) == tuple(states)[1]]
    assert len(first) == 4
    assert law.scale[1] == pytest.approx(np.sqrt(6) / np.pi * np.std(first, ddof=1))
    assert fits["surge"].runs.tolist() == [4, 4, 4]
    assert len(fits["surge"].points[0]) == 2


def test_sides_of_maxima(tmp_path):
    rows = [[10, 3, 9, 1.0, 4.0 + seed, -5.0 - seed, 6.0 + seed**2] for seed in range(3)]
    head = ["wind_speed", "Hs", "Tp", "probability", "surge [m]", "heave [m]", "yaw [deg]"]
    path = write(tmp_path / "maxima.csv", head, rows)
    surge, heave, yaw = read_maxima(path, {"heave": "min", "yaw": "abs"}).values()
    assert [each.label for each in (surge, heave, yaw)] == ["surge", "heave (min)", "|yaw|"]
    assert heave.bins[1].location - 5.0 == pytest.approx(surge.bins[1].location - 4.0)  # as deep as surge is high
    (least,) = compare_methods(JOINT, {"heave": heave}, years=1.0)
    assert least.fits.sign * least.flta.value(1.0) < -7.0
    with pytest.raises(ParameterError, match=r"maxima.csv:2: 'heave': an absolute value is not negative."):
        read_maxima(path, "abs")
    with pytest.raises(ParameterError, match=r"maxima.csv: a side is given for 'yav'; did you mean 'yaw'"):
        read_maxima(path, {"yav": "abs"})


def test_sides_are_written_as_they_lie_on_the_axis_of_the_response(tmp_path):
    above, below = UpCrossings(0.1, 0.3, 2.0, 2.0, 3600.0, 3.0), UpCrossings(0.1, 0.2, -2.0, 2.0, 3600.0, -1.0)
    low = Fits("heave", "m", (BINS, below), None, side="min")
    both = Fits("heave", "m", (BINS, Either(above, below)), (POINTS[0], Either(above, below)), side="abs")
    write_fits(tmp_path / "sides.csv", [low, both])
    first, *_ = csv.DictReader((tmp_path / "sides.csv").read_text().splitlines())
    assert (first["side"], float(first["b"]), float(first["threshold"])) == ("min", 2.0, 1.0)
    found = read_fits(tmp_path / "sides.csv")
    assert list(found) == ["heave (min)", "|heave|"]
    assert found["heave (min)"].bins[1].sf(2.0) == pytest.approx(np.full(len(BINS), below.sf(2.0)), rel=1e-12)
    for part in ("bins", "points"):
        values = getattr(found["|heave|"], part)[1].isf(1e-3)
        np.testing.assert_allclose(values, both.bins[1].isf(1e-3), rtol=1e-12)


def test_the_absolute_value_of_two_rates():
    """F = exp(-(nu_+ + nu_-) T), so that with equal rates it is the law of twice the time, exactly."""
    one = UpCrossings(0.1, np.array([0.5, 0.02]), 0.0, 2.0, 3600.0, 0.0)
    twice = UpCrossings(0.1, one.a, 0.0, 2.0, 7200.0, 0.0)
    both = Either(one, one)
    for q in (0.9, 0.5, 1e-2, 1e-9):
        assert both.isf(q) == pytest.approx(twice.isf(q), rel=1e-12)
        assert both.sf(both.isf(q)) == pytest.approx(q, rel=1e-9)
    assert both.cdf(9.0) == pytest.approx(twice.cdf(9.0), rel=1e-12)
    lopsided = Either(one, UpCrossings(0.1, one.a, -3.0, 2.0, 3600.0, 0.0))
    assert np.all(one.isf(1e-3) < lopsided.isf(1e-3)) and np.all(lopsided.isf(1e-3) < both.isf(1e-3))
    where = known(BINS[:2], lopsided)
    assert where(BINS[[1]]).isf(1e-3) == pytest.approx(lopsided.isf(1e-3)[1:])


HEAD = ["response", "wind_speed", "Hs", "Tp", "probability", "location", "scale"]
ROW = ["surge", 10, 3, 9, 0.4, 5, 1]


@pytest.mark.parametrize(
    ("head", "rows", "says"),
    [
        ([*HEAD, "side"], [[*ROW, "up"]], "fits.csv:2: a side is max, min, abs, abs above, abs below."),
        ([*HEAD, "side"], [[*ROW, "abs above"]], "'surge' has the sides abs above and abs below together, or abs."),
        (
            [*HEAD, "side"],
            [[*ROW, "abs above"], ["surge", 11, *ROW[2:], "abs below"]],
            "'surge': abs above and abs below are of the same states in the same order.",
        ),
        (HEAD[1:], [ROW[1:]], "needs the column 'response'"),
        (HEAD[:-1], [ROW[:-1]], "needs the columns location, scale, or q, a, b, c, threshold."),
        ([*HEAD[:-1], "scales"], [ROW], "has no column 'scales'; did you mean 'scale'?"),
        (HEAD, [[*ROW[:-1], 0]], "fits.csv:2: scale must be positive."),
        (HEAD, [ROW, ROW], "fits.csv:3: the response has a fit in this state already."),
        (HEAD, [[*ROW[:-1], "nan"]], "fits.csv:2: scale: 'nan' is not a finite number."),
        (HEAD, [[*ROW[:4], -1, 5, 1]], "fits.csv:2: a probability is not negative."),
        (HEAD, [[*ROW[:3], 0, *ROW[4:]]], "fits.csv:2: Tp must be positive."),
        (HEAD, [[*ROW[:4], 0.7, 5, 1], ["surge", 11, 3, 9, 0.7, 5, 1]], "of sum 1 at most"),
    ],
)
def test_what_a_table_of_fits_cannot_be(tmp_path, head, rows, says):
    with pytest.raises(ParameterError) as refused:
        read_fits(write(tmp_path / "fits.csv", head, rows))
    assert says in str(refused.value)


def test_what_a_table_of_maxima_cannot_be(tmp_path):
    head = ["wind_speed", "Hs", "Tp", "surge"]
    one = write(tmp_path / "one.csv", head, [[10, 3, 9, 5], [11, 3, 9, 5], [11, 3, 9, 6]])
    with pytest.raises(ParameterError, match=r"one.csv:2: there is one run alone at 10 m/s, Hs 3 m, Tp 9 s"):
        read_maxima(one)
    same = write(tmp_path / "same.csv", head, [[10, 3, 9, 5], [10, 3, 9, 5]])
    with pytest.raises(ParameterError, match=r"same.csv:2: 'surge' has one maximum in all runs"):
        read_maxima(same)
    with pytest.raises(ParameterError, match="no column of a response"):
        read_maxima(write(tmp_path / "none.csv", head[:3], [[10, 3, 9]]))


def test_a_point_beside_all_contours_is_refused(tmp_path):
    """Above all: wind at another height, or a cut-out speed that was not named."""
    with pytest.raises(
        ParameterError, match=r"lies on no contour: its distance is 2\.3.*contours have 4\.584 \(50 years\)"
    ):
        compare_methods(JOINT, read_fits(fits_file(tmp_path)))
    with pytest.raises(ParameterError, match="height and shear exponent of the wind"):
        compare_methods(site("norway_5"), read_fits(fits_file(tmp_path)), cut_offs=[25])


def test_pictures(tmp_path):
    answers = compare_methods(JOINT, read_fits(fits_file(tmp_path)), cut_offs=[25])
    figure = plot_exceedance(answers, tmp_path / "extremes.svg", title="a site")
    (axis,) = figure.axes
    assert axis.get_xlabel() == "surge [m]" and axis.get_ylabel() == "return period [years]"
    line = axis.get_lines()[0]
    at_50 = np.interp(np.log(50), np.log(line.get_ydata()), line.get_xdata())
    assert at_50 == pytest.approx(answers[0].flta.value(50), rel=1e-3)
    assert figure.get_suptitle() == "a site"
    assert (tmp_path / "extremes.svg").read_text().startswith("<?xml")
    low = replace(answers[0], fits=replace(answers[0].fits, side="min"))  # the same laws, of the negative
    (axis,) = plot_exceedance([low]).axes
    assert axis.get_xlabel() == "surge (min) [m]" and np.array_equal(axis.get_lines()[0].get_xdata(), -line.get_xdata())
    figure = plot_contours([("50 years", POINTS[0])], rings=[("8 m/s", POINTS[0][:5])], height=90)
    labels = [axis.get_xlabel() for axis in figure.axes]
    assert labels == ["mean wind speed at 90 m [m/s]", "peak period [s]"]
    assert figure.axes[0].get_ylabel() == "significant wave height [m]"
