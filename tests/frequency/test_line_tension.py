"""Lines that move, in the response of a spar: against runs of it, and the largest tensions."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.frequency import line_extreme, with_line_results
from fowtlib.language.errors import ModelError

LINE = "platform.mooring.line_2"
STILL_AIR = {"wind.kind": "steady", "wind.mean_speed": 18.0}
WAVES = {**STILL_AIR, "sea.significant_wave_height": 6.0, "sea.peak_period": 10.0}
NAMES = [f"{LINE}.tension", f"{LINE}.shape_velocity"]


@pytest.fixture(scope="module")
def plant():
    """The spar whose lines move, and which feels them."""
    return with_line_results(fw.load("oc3_spar_rigid", set={"platform.mooring.dynamics": "coupled"})).compile()


def test_the_response_of_a_moving_line_is_that_of_runs(plant):
    """Three seeds of 40 minutes; the drag of the shape is linearised by the response itself.

    The sea of these seeds has 2 to 3 % more than its spectrum; surge says how much of it gets there.
    """
    found = fw.response(plant, outputs=["surge", *NAMES], parameters=WAVES)
    runs = []
    for seed in (1, 2, 3):
        result = plant.simulate(3000.0, output_step=0.2, parameters={**WAVES, "sea.seed": seed})
        runs.append([np.std(result[name].values[result.time > 600]) for name in ("surge", *NAMES)])
    ratios = np.mean(runs, axis=0) / [found.std(name) for name in ("surge", *NAMES)]
    assert ratios == pytest.approx(1, abs=0.1)
    quiet = fw.response(fw.load("oc3_spar_rigid").compile(), outputs=["fairlead_tension_2"], parameters=WAVES)
    assert found.std(NAMES[0]) > 2 * 1e3 * quiet.std("fairlead_tension_2")  # a line in balance is far below


def test_drag_and_added_mass_are_tunable(plant):
    """More drag, more tension: the shape takes up less; more added mass lowers its own frequency."""
    first = fw.response(plant, outputs=NAMES, parameters=WAVES)
    more = fw.response(plant, outputs=NAMES, parameters={**WAVES, "platform.mooring.drag_coefficient": 4.0})
    assert more.std(NAMES[0]) > 1.1 * first.std(NAMES[0])
    assert more.std(NAMES[1]) < 0.9 * first.std(NAMES[1])
    heavy = fw.response(plant, outputs=NAMES, parameters={**WAVES, "platform.mooring.added_mass_coefficient": 3.0})
    assert heavy.state[f"{LINE}.generalised_mass"] > 1.1 * first.state[f"{LINE}.generalised_mass"]
    assert heavy.std(NAMES[0]) != pytest.approx(first.std(NAMES[0]), rel=1e-3)


def test_largest_tensions(plant):
    found = fw.response(plant, outputs=NAMES, parameters=WAVES)
    extreme = line_extreme(found, LINE, law="rayleigh_exponential")
    u, drag = found.std(NAMES[1]), float(found.state[f"{LINE}.generalised_drag"])
    linear = found.std(NAMES[0]) ** 2 - 8 / np.pi * (drag * u**2) ** 2
    assert extreme.drag_share == pytest.approx(drag * u**2 / np.sqrt(linear), rel=1e-9)
    assert extreme.std == pytest.approx(np.sqrt(linear + 3 * (drag * u**2) ** 2), rel=1e-9)
    assert extreme.maxima == pytest.approx(3600 * found.spectrum(NAMES[0]).up_crossing_rate)
    assert extreme.largest > found.extreme(NAMES[0])
    assert extreme.dynamic == pytest.approx(extreme.largest - extreme.mean)
    harmonic = line_extreme(found, LINE)
    assert found.extreme(NAMES[0]) < harmonic.largest < extreme.largest  # drag grows, and has a limit
    assert harmonic.std == found.std(NAMES[0])
    for law, one in (("harmonic", harmonic), ("rayleigh_exponential", extreme)):
        assert line_extreme(found, LINE, 3 * 3600.0, law=law).largest > one.largest
        assert line_extreme(found, LINE, quantile=0.9, law=law).largest > one.largest
        assert line_extreme(found, LINE, quantile=None, law=law).largest == pytest.approx(one.largest, rel=0.02)
    # in a sea so small that there is no drag, not where the line answers most (1 mm is felt there), the largest is that
    # of a Gaussian tension
    calm = fw.response(plant, outputs=NAMES, parameters={**WAVES, "sea.significant_wave_height": 1e-4})
    for law in ("harmonic", "rayleigh_exponential"):
        small = line_extreme(calm, LINE, law=law)
        assert small.drag_share < 0.01
        assert small.dynamic == pytest.approx(calm.extreme(NAMES[0]) - small.mean, rel=5e-3)


def test_largest_tensions_are_those_of_runs(plant):
    """The median of the largest of eight runs of 1000 s, in a sea in which drag prevails; Gaussian is far below."""
    sea = {**STILL_AIR, "sea.significant_wave_height": 9.0, "sea.peak_period": 13.0}
    found = fw.response(plant, outputs=NAMES, parameters=sea)
    ours = line_extreme(found, LINE, 1000.0)
    largest = []
    for seed in range(1, 9):
        result = plant.simulate(1400.0, output_step=0.2, parameters={**sea, "sea.seed": seed})
        largest.append(result[NAMES[0]].values[result.time > 400].max())
    run = np.median(largest) - ours.mean
    assert ours.drag_share > 2
    assert ours.dynamic == pytest.approx(run, rel=0.15)
    assert found.extreme(NAMES[0], 1000.0) - ours.mean < 0.85 * run
    assert line_extreme(found, LINE, 1000.0, law="rayleigh_exponential").dynamic > 1.2 * run


def test_results_that_are_missing(plant):
    found = fw.response(plant, outputs=["surge"], parameters=WAVES)
    with pytest.raises(ModelError, match="with_line_results"):
        line_extreme(found, LINE)
    with pytest.raises(ModelError, match="'weibull' is not"):
        line_extreme(fw.response(plant, outputs=NAMES, parameters=WAVES), LINE, law="weibull")
    whole = fw.response(plant, outputs=NAMES, parameters=WAVES)
    with pytest.raises(ModelError, match="did you mean 'platform.mooring.line_2'"):
        line_extreme(whole, "platform.mooring.line_22")
    with pytest.raises(ModelError, match="no line of this model has dynamics"):
        with_line_results(fw.load("oc3_spar_rigid"))
    changed = with_line_results(fw.load("oc3_spar_rigid", set={"platform.mooring.dynamics": "uncoupled"}))
    assert f"{LINE}.tension" in changed.with_parameters({"sea.seed": 2, "platform.mooring.length": 900.0}).outputs
