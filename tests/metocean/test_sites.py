"""Files of sites and scatter tables, and what is said of those that cannot be read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fowtlib.language.errors import ModelError
from fowtlib.metocean import ScatterTable, bins, environment, read_scatter, shipped, site

TABLE = """# a bay
wind_speed [m/s],Hs [m],Tp [s],count
5,0.5,4,30
5,1.5,6,10
10,1.5,6,20
10,2.5,8,20
15,2.5,8,10
15,3.5,9,0
"""


def own(tmp_path: Path, change: str = "", drop: str = "") -> Path:
    """The file of a shipped site, changed."""
    import fowtlib.metocean

    text = (Path(fowtlib.metocean.__file__).parent / "sites" / "norway_5.yaml").read_text()
    lines = [line for line in text.splitlines() if not drop or not line.startswith(drop)]
    path = tmp_path / "own.yaml"
    path.write_text("\n".join([*lines, change]))
    return path


def test_shipped_sites_say_where_their_numbers_are_from():
    for name in shipped():
        joint = site(name)
        assert joint.source and joint.title and joint.name == name
        assert joint.reference_height == 10 and joint.averaging == 3600


def test_a_file_of_ones_own_is_read_alike(tmp_path):
    path = own(tmp_path)
    assert replace(site(path), name="norway_5") == site("norway_5")
    path = own(tmp_path, "wind_scale: 18.29 kn", drop="wind_scale")
    assert site(path).wind_scale == pytest.approx(9.409, abs=1e-3)


@pytest.mark.parametrize(
    ("change", "drop", "says"),
    [
        ("", "wind_shape", "own.yaml: the site lacks 'wind_shape'."),
        ("wind_shap: 2", "", "own.yaml: a site has no 'wind_shap'; did you mean 'wind_shape'?"),
        ("wind_shape: two", "wind_shape", "'wind_shape' is to be a number, not two."),
        ("wind_scale: 9 kg", "wind_scale", "own.yaml"),
        ("period_mean: [1, 2]", "period_mean", "'period_mean' is a list of three numbers, not [1, 2]."),
        ("wind_shape: [1, 2, 3]", "wind_shape", "'wind_shape' is one number, not [1, 2, 3]."),
        ("wind_shape: -2", "wind_shape", "own.yaml: wind_shape must be a positive number, not -2.0."),
        ("period_exponent: 1.5", "period_exponent", "must be a whole number, not 1.5"),
        ("wind_shape: [", "wind_shape", "this is not YAML"),
    ],
)
def test_what_a_site_cannot_be(tmp_path, change, drop, says):
    with pytest.raises(ModelError) as refused:
        site(own(tmp_path, change, drop))
    assert says in str(refused.value)
    assert "own.yaml" in str(refused.value)


def test_unknown_names_and_files(tmp_path):
    with pytest.raises(ModelError, match="there is no site 'norway_6'; did you mean 'norway_5'"):
        site("norway_6")
    with pytest.raises(ModelError, match="cannot read the site"):
        site(tmp_path / "none.yaml")
    (tmp_path / "list.yaml").write_text("- 1\n")
    with pytest.raises(ModelError, match="a site is a mapping"):
        site(tmp_path / "list.yaml")


def test_a_scatter_table_gives_states_conditional_values_and_samples(tmp_path):
    path = tmp_path / "bay.csv"
    path.write_text(TABLE)
    table = environment(path)
    assert isinstance(table, ScatterTable)
    assert len(table.states) == 5  # of the last class nothing was seen
    assert table.states.weights == pytest.approx(np.array([30, 10, 20, 20, 10]) / 90)
    assert table.conditional(5, "mean") == (pytest.approx(0.75), pytest.approx(4.5))
    assert table.conditional(7.5, "mean") == (pytest.approx(1.375), pytest.approx(5.75))
    assert table.conditional(5) == (0.5, 4.0)
    drawn = table.sample(9000, seed=2)
    assert (drawn.wind_speed == 15).mean() == pytest.approx(1 / 9, abs=0.015)
    assert np.array_equal(drawn.wave_height, table.sample(9000, seed=2).wave_height)
    with pytest.raises(ModelError, match=r"4 m/s is outside of the scatter table, .* 5 to 15 m/s"):
        table.conditional(4)
    with pytest.raises(ModelError, match="a scatter table has classes and no contours"):
        site(path)


def test_a_scatter_table_of_a_joint_distribution_gives_its_means(tmp_path):
    """Through a file and back: bins of the distribution, written as a table."""
    joint = site("norway_5").at(90)
    states = bins(joint, np.arange(1, 40, 2.0), np.arange(0.25, 20, 0.5), np.arange(1, 40, 1.0), keep=None)
    weights = states.weights / states.weights.sum()
    rows = [f"{u},{h},{t},{p}" for (u, h, t), p in zip(states, weights, strict=True)]
    path = tmp_path / "fine.csv"
    path.write_text("\n".join(["wind_speed,Hs,Tp,probability", *rows]))
    height, period = read_scatter(path).conditional(13, "mean")
    assert height == pytest.approx(joint.conditional(13, "mean")[0], abs=0.03)
    q = (np.arange(2000) + 0.5) / 2000
    of_all_seas = joint.peak_period(13, joint.wave_height(13).ppf(q)).mean().mean()
    assert period == pytest.approx(of_all_seas, abs=0.03)
    assert of_all_seas == pytest.approx(0.98 * joint.conditional(13, "mean")[1], rel=3e-3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            TABLE.replace("count", "counts"),
            "bay.csv:2: the scatter table has no column 'counts'; did you mean 'count'?",
        ),
        (TABLE.replace("count", "probability"), "the probabilities have the sum 90 and not 1"),
        (TABLE.replace("10,1.5,6,20", "10,1.5,6,x"), "bay.csv:5: count: 'x' is not a finite number."),
        (TABLE.replace("10,1.5,6,20", "10,1.5,6"), "bay.csv:5: the row has 3 cells, and there are 4 columns."),
        (TABLE.replace("10,1.5,6,20", "10,1.5,6,-2"), "bay.csv:5: a count is not negative."),
        (TABLE.replace("10,1.5,6,20", "5,0.5,4,20"), "a class stands in the table twice."),
        ("wind_speed,Hs,count\n1,1,1\n", "the scatter table needs the columns Tp too."),
        ("wind_speed,Hs,Tp\n1,1,1\n", "needs one column 'probability' or 'count'."),
        (TABLE.replace("5,0.5,4", "5,-0.5,4"), "bay.csv:3: Hs must be positive."),
        (TABLE.replace("Hs [m]", "Hs [cm]"), "Hs is to be given in m, not in cm."),
        ("wind_speed\n", "the scatter table has a header and one line or more."),
    ],
)
def test_what_a_scatter_table_cannot_be(tmp_path, text, says):
    path = tmp_path / "bay.csv"
    path.write_text(text)
    with pytest.raises(ModelError) as refused:
        read_scatter(path)
    assert says in str(refused.value)
