"""What a check of a model says of its lines unsolved: what a run from the same start would end with."""

from __future__ import annotations

import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Fixed, World
from fowtlib.components.mooring import CatenaryLine, DynamicLine, SectionedLine, Tendon
from fowtlib.language.errors import SimulationError

LINE = {"axial_stiffness": 5e8, "weight_per_length": 700.0}
HEAVY = {"axial_stiffness": 5e8, "mass_per_length": 80.0, "diameter": 0.1}
PARTS = {  # by kind: a line of a length, its other end
    "catenary": (lambda length, **more: CatenaryLine(length=length, **LINE, **more), (400.0, 0.0, -20.0)),
    "sectioned": (lambda length, **more: SectionedLine(lengths=[length / 2] * 2, **LINE, **more), (400.0, 0.0, -20.0)),
    "lumped": (lambda length, **more: DynamicLine(lengths=length, elements=4, **HEAVY, **more), (400.0, 0.0, -20.0)),
    "tendon": (lambda length, **more: Tendon(length=length, **LINE, **more), (0.0, 0.0, -20.0)),
}
TOO_SHORT = "the line is too short: its ends are 412.311 m apart and it is 300 m long, so that it is stretched by 0.37"
SAID = {
    "catenary": TOO_SHORT,
    "sectioned": TOO_SHORT,
    "lumped": "an element is stretched by 0.37",
    "tendon": "the tendon is stretched by 0.25 of its length",
}
SHORT = {"catenary": 300.0, "sectioned": 300.0, "lumped": 300.0, "tendon": 80.0}
LONG = {"catenary": 430.0, "sectioned": 430.0, "lumped": 430.0, "tendon": 99.8}


def between(kind, length, **changes):
    make, end = PARTS[kind]
    model = fw.Assembly("a line")
    model.world, model.end = World(water_depth=120.0), Fixed(r=end)
    model.line = make(length, anchor_position=(0, 0, -120), **changes)
    model.connect(model.end.frame, model.line.fairlead)
    return fw.load(model)


@pytest.mark.parametrize("kind", PARTS)
def test_a_line_that_is_too_short_is_told_before_a_run(kind):
    model = between(kind, SHORT[kind])
    report = model.check()
    assert not report.ok and len(report.faults) == 1
    assert report.faults[0].startswith(f"at the start values, line: {SAID[kind]}")
    with pytest.raises(SimulationError, match="line: .* stretched by"):
        model.compile().simulate(0.1, 0.1)
    assert between(kind, LONG[kind]).check().faults == ()


@pytest.mark.parametrize("kind", ["catenary", "tendon"])
def test_its_greatest_strain_decides(kind):
    assert between(kind, SHORT[kind], greatest_strain=0.5).check().ok


def test_an_end_below_the_seabed_is_told_before_a_run():
    model = between("catenary", 500.0)
    model.root.end.r = (400, 0, -150)
    assert model.check().faults == ("at the start values, line: the fairlead is at -150 m, below the seabed at -120 m",)


def test_a_run_from_the_mean_position_is_not_judged_by_its_start_values():
    """They are where the mean is sought from alone, and it may lie where the line reaches."""
    model = between("catenary", SHORT["catenary"])
    model.settings["start"] = "equilibrium"
    report = model.check()
    assert report.ok and [remark for remark in report.remarks if f"line: {TOO_SHORT}" in remark]
    model.settings["start"] = "rest"
    assert not model.check().ok


def test_what_a_run_would_warn_of_is_a_remark():
    report = between("tendon", 101.0).check()
    assert report.ok and any("slack from the start on" in remark for remark in report.remarks)
