"""What stands on pictures of designs and of spectra: units, and nothing cut off or covered."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.analysis.spectra import Spectrum
from fowtlib.design.pareto import Front
from fowtlib.solving.results.plots import plot_spectra


def test_a_front_has_units_and_its_ends_lie_inside(tmp_path):
    names, units = ("cost", "pitch @ thrust"), ("MEUR", "deg")
    front = Front("hull", names, (5.0, 6.0, 8.0), (5.0, 3.0, 2.0), (True,) * 3, (), units)
    axis = front.plot(tmp_path / "front.png").axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("cost [MEUR]", "pitch @ thrust [deg]")
    low, high = axis.get_xlim()
    assert low < 5.0 and high > 8.0
    alone = Front("hull", ("a + b", "c"), (5.0, 6.0), (5.0, 3.0), (True,) * 2, ())
    assert alone.plot(tmp_path / "alone.png").axes[0].get_xlabel() == "a + b"


@pytest.mark.parametrize(("count", "beside"), [(4, False), (25, True)])
def test_the_legend_of_many_spectra_stands_beside_them(tmp_path, count, beside):
    f = np.linspace(0.01, 1.0, 50)
    spectra = [Spectrum(f, 1 / (1 + (f - k / count) ** 2), "m", f"moment_{k}") for k in range(count)]
    figure = plot_spectra(spectra, tmp_path / "spectra.png", highest=1.0)
    figure.canvas.draw()
    axis, legend = figure.axes[0], figure.axes[0].get_legend().get_window_extent()
    room = axis.get_window_extent()
    assert (legend.x0 >= room.x1) == beside
    assert legend.y0 >= 0 and legend.y1 <= figure.bbox.height and legend.x1 <= figure.bbox.width
    drawn = {(line.get_color(), line.get_linestyle()) for line in axis.get_lines()}
    assert len(drawn) == count
