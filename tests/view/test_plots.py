"""Figures: they are written, their axes carry names and units, and mistakes are told."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fowtlib.analysis.decay import analyse_decay
from fowtlib.analysis.rao import Rao
from fowtlib.analysis.series import Series
from fowtlib.analysis.spectra import power_spectrum
from fowtlib.language.errors import ModelError, NotFoundError
from fowtlib.solving.results import Result
from fowtlib.view import plot_decay, plot_modes, plot_rao, plot_result, plot_spectra

TIME = np.arange(0.0, 200.05, 0.1)
UNITS = {
    "surge": "m",
    "sway": "m",
    "pitch": "deg",
    "rotor_speed_left": "rpm",
    "rotor_speed_right": "rpm",
    "extra": "N*m",
}


def result(**values: np.ndarray) -> Result:
    values = values or {name: np.sin(0.1 * TIME + i) for i, name in enumerate(UNITS)}
    return Result(TIME, values, UNITS, {}, {"title": "two rotors"})


def titles(figure) -> list[str]:
    return [axis.get_title(loc="left") for axis in figure.axes]


def legends(axis) -> list[str]:
    return [text.get_text() for text in axis.get_legend().get_texts()] if axis.get_legend() else []


def test_the_usual_panels(tmp_path):
    figure = plot_result(result(), path=tmp_path / "r.png")
    assert titles(figure) == ["surge, sway [m]", "pitch [deg]", "rotor speed [rpm]"]
    assert legends(figure.axes[2]) == ["left", "right"]
    assert figure.axes[-1].get_xlabel() == "time [s]"
    assert (tmp_path / "r.png").stat().st_size > 10_000


def test_a_lateral_motion_that_does_not_matter_is_left_out():
    assert titles(plot_result(result(surge=np.sin(TIME), sway=0.01 * np.sin(TIME)))) == ["surge [m]"]


def test_chosen_panels():
    assert titles(plot_result(result(), ["extra", "sway"])) == ["extra [N m]", "sway [m]"]
    with pytest.raises(NotFoundError, match=r"^there is no result 'srge'; did you mean 'surge'\?"):
        plot_result(result(), ["srge"])


def test_a_result_of_something_else_shows_everything():
    assert titles(plot_result(Result(TIME, {"x": TIME, "v": TIME}, {"x": "m", "v": "m/s"}))) == ["x [m]", "v [m/s]"]


def test_decay(tmp_path):
    values = 10 * np.exp(-0.01 * TIME) * np.cos(0.3 * TIME)
    decay = analyse_decay(Series(TIME, values, "m", "surge"))
    figure = plot_decay(decay, tmp_path / "d.svg")
    assert figure.axes[1].get_ylim()[1] > 110 * decay.damping.max()
    top, bottom = figure.axes
    assert top.get_ylabel() == "surge [m]" and bottom.get_xlabel() == "amplitude [m]"
    assert top.get_title(loc="left").startswith("Free decay in surge: period 20.9")
    assert "<svg" in (tmp_path / "d.svg").read_text()[:1000]


def test_rao_and_spectra_and_modes():
    frequency = np.linspace(0.01, 0.2, 100)
    rao = Rao(frequency, ("heave", "pitch"), np.ones((100, 2)) * 1j, ("m/m", "deg/m"))
    figure = plot_rao([rao, rao])
    assert [axis.get_ylabel() for axis in figure.axes] == [
        "amplitude [m/m]",
        "phase [deg]",
        "amplitude [deg/m]",
        "phase [deg]",
    ]
    phase = np.where(frequency < 0.1, 170.0, -170.0)
    rao = Rao(frequency, ("heave",), np.exp(1j * np.radians(phase))[:, None], ("m/m",), heading=np.pi / 4)
    figure = plot_rao(rao)
    drawn = figure.axes[1].lines[0].get_ydata()
    np.testing.assert_allclose(drawn[np.isfinite(drawn)], phase)  # every point, and one gap at the jump
    assert np.isnan(drawn).sum() == 1
    assert figure.get_suptitle() == "Response to waves of heading 45 deg"
    spectra = [power_spectrum(result()[name]) for name in ("surge", "sway", "pitch")]
    figure = plot_spectra(spectra, targets={"target": lambda f: 1 + 0 * f})
    assert [axis.get_ylabel() for axis in figure.axes] == ["density [m²/Hz]", "density [deg²/Hz]"]
    assert legends(figure.axes[0]) == ["surge", "sway", "target"]
    modes = [
        SimpleNamespace(frequency_hz=f, damping_ratio=0.02, label=n)
        for f, n in ((0.03, "spar.heave"), (0.008, "spar.surge"))
    ]
    figure = plot_modes([*modes, SimpleNamespace(frequency_hz=0.1, damping_ratio=1.0, label="filter")])
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["surge", "heave"]
    many = [SimpleNamespace(frequency_hz=0.1 + i, damping_ratio=0.02, label=f"m{i}") for i in range(50)]
    figure = plot_modes(many, title="a spar\nwind none")
    bottom, top = figure.axes[0].get_ylim()
    assert -1 < top < 0 and 49 < bottom < 50  # the first and the last bar, and no empty space beyond
    assert figure.get_suptitle() == "a spar\nwind none"


def test_mistakes(tmp_path):
    with pytest.raises(ModelError) as caught:
        plot_result(result(), path=tmp_path / "r.xls")
    assert str(caught.value) == f"{tmp_path}/r.xls: a figure is saved as .png, .pdf, .svg, not as '.xls'."
    with pytest.raises(ModelError) as caught:
        plot_result(result(), path=tmp_path / "no" / "r.png")
    assert str(caught.value) == (
        f"{tmp_path}/no/r.png: the folder {tmp_path}/no does not exist. Make it first, or choose another one."
    )
    with pytest.raises(ModelError, match=r"^there is nothing to plot: the linear model has no oscillating mode\.$"):
        plot_modes([])
