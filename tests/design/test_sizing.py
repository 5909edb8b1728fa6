"""Sizes from targets: by the equations, by an optimisation, and by formulas of their own; targets that fight; files."""

import json
import math
from pathlib import Path

import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.design.problem import Problem
from fowtlib.design.sizing import SizingStopped, TargetsError, size
from fowtlib.design.sizing_file import read_sizing
from fowtlib.design.standards import check_model
from fowtlib.language.errors import ModelError

FREE = {
    "solid_ballast": ("0 t", "20000 t"), "column_diameter": ("10 m", "25 m"), "plate_diameter": ("20 m", "60 m"),
    "base_diameter": ("20 m", "50 m"),
}  # fmt: skip
TWO = {name: FREE[name] for name in ("solid_ballast", "column_diameter")}
TARGETS = {"draft": "62 m", "heave_period": 28.5, "metacentric_height": 2.4, "heel": "17 deg"}
FILE = """fowtlib_sizing: 1
title: A spar of 62 m
model: raisable_spar_sizes
free:
  solid_ballast: [0 t, 20000 t]
  column_diameter: [10 m, 25 m]
targets:
  draft: 62 m
  heave_period: 27 s
"""


@pytest.fixture(scope="module")
def spar():
    return fw.load("raisable_spar_sizes").compile()


def formulas(values):
    """What the spar does, worked out anew from its shape by formulas of cylinders and cones (SI)."""
    D, Dp, Db, ballast = (values[name] for name in ("column_diameter", "plate_diameter", "base_diameter",
                                                    "solid_ballast"))  # fmt: skip
    t, s, pi, draft, rho, g = 0.35, 7.0, math.pi, 62.0, 1025.0, 9.81

    def cylinder(size, low, high):
        V = pi / 4 * size**2 * (high - low)
        return V, V * (low + high) / 2

    def cone(size, end, low, high):
        V = pi * (high - low) / 12 * (size**2 + size * end + end**2)
        centre = (high - low) / 4 * (size**2 + 2 * size * end + 3 * end**2) / (size**2 + size * end + end**2)
        return V, V * (low + centre)

    def add(*parts):
        return sum(factor * V for factor, (V, _) in parts), sum(factor * S for factor, (_, S) in parts)

    hull = [cylinder(Db, 2, 7), cone(Db, D, 7, 12), cylinder(D, 12, 82)]
    holes = [cylinder(Db - 2 * t, 2, 7), cone(Db - 2 * t, D - 2 * t, 7, 12), cylinder(D - 2 * t, 12, 82)]
    walls = add(*((1, part) for part in hull), *((-1, part) for part in holes), (1, cylinder(s + 2 * t, 2, 82)),
                (-1, cylinder(s, 2, 82)))  # fmt: skip
    plate = cylinder(Dp, 0, 2)
    ring = pi / 4 * ((Db - 2 * t) ** 2 - (s + 2 * t) ** 2)
    level = 2 + ballast / 2600 / ring  # within the base
    parts = [(2400, plate), (2400 * 1.0203, walls), (2600, (ring * (level - 2), ring * (level**2 - 4) / 2)),
             (1, (970e3, 970e3 * 127))]  # fmt: skip
    mass, moment = add(*parts)
    V, S = add((1, plate), *((1, part) for part in hull[:2]), (1, cylinder(D, 12, draft)))
    GM = S / V + pi / 64 * D**4 / V - moment / mass
    zeta = (Dp**2 - D**2) ** 0.5 / pi
    A33 = rho / 12 * (2 * Dp**3 + 3 * pi * Dp**2 * zeta - pi**3 * zeta**3 - 3 * pi * D**2 * zeta)
    return {"float": mass / (rho * V), "GM": GM,
            "heave": 2 * pi * ((mass + A33) / (rho * g * pi / 4 * D**2)) ** 0.5,
            "heel": 1e6 * (97.8 + draft - 37) / (rho * g * V * GM)}  # fmt: skip


def test_equations_and_an_optimisation_of_other_formulas_find_the_same_sizes(spar):
    """The component, solved for its sizes; and slsqp on formulas that know nothing of it, targets as equalities."""
    found = size(spar, FREE, {**TARGETS, "heel": "17 deg", "metacentric_height": 2.0})
    assert found.way == "equations"
    assert found["ballast_level"] < 7.0  # the formulas know the base alone
    bounds = {"solid_ballast": (0.0, 2e7, 5e6), "column_diameter": (10.0, 25.0, 15.0),
              "plate_diameter": (20.0, 60.0, 40.0), "base_diameter": (20.0, 50.0, 30.0)}  # fmt: skip
    variables = [fw.Variable(name, *given) for name, given in bounds.items()]
    functions = [fw.Function(key, lambda values, key=key: formulas(values)[key], list(bounds), si=True)
                 for key in ("float", "GM", "heave", "heel")]  # fmt: skip
    functions.append(fw.Function("nothing", lambda values: 0 * values["column_diameter"], ["column_diameter"], si=True))
    design = fw.Design(None, variables, fw.Objective({"nothing": 1.0}, scale=1.0),
                       ["float = 1", "GM = 2.0", "heave = 28.5", f"heel = {math.radians(17)}"],
                       functions=functions)  # fmt: skip
    other = design.optimise("slsqp", tolerance=1e-10)
    assert other.feasible
    for name in bounds:
        assert float(other[name]) == pytest.approx(found[name], rel=1e-5), name


def test_an_optimisation_with_the_targets_as_equalities_finds_what_the_equations_find(spar):
    by_equations = size(spar, FREE, TARGETS)
    by_search = size(spar, FREE, TARGETS, objective="concrete_volume")
    assert (by_equations.way, by_search.way) == ("equations", "optimisation")
    for name in FREE:
        assert by_search[name] == pytest.approx(by_equations[name], rel=1e-5), name
    assert by_equations.result_rows()[1][0] == ("draft [m]", pytest.approx(62.0, abs=1e-3), pytest.approx(62.0), "62 m")


def test_bounds_leave_freedom_for_an_objective(spar):
    """4.5 degrees of heel under 1 MN: a metacentric height of 5 m or more, and a period in pitch of some 30 s."""
    targets = {"draft": 62.0, "heave_period": ["> 25 s", "< 35 s"], "metacentric_height": "> 1 m", "heel": "< 4.5 deg"}
    found = size(spar, FREE, targets, objective="concrete_volume")
    assert found["heel"] <= 4.5 * (1 + 1e-5) and found["heave_period"] >= 25 * (1 - 1e-5)
    assert found["metacentric_height"] > 5 and 26 < found["pitch_period"] < 33
    nearer = size(spar, FREE, targets)
    assert nearer["concrete_volume"] > found["concrete_volume"]


def test_two_targets_that_fight_are_named(spar):
    """A soft spar heels: with 1 MN no period of 50 s in pitch and no 4.5 degrees at once. Alone, each is met."""
    with pytest.raises(TargetsError) as caught:
        size(spar, TWO, {"draft": 62.0, "pitch_period": "> 50 s", "heel": "< 4.5 deg"})
    assert set(caught.value.against) == {"pitch_period", "heel"}
    assert str(caught.value).startswith("two targets fight each other: pitch_period > 50 s and heel < 4.5 deg.")
    assert size(spar, TWO, {"draft": 62.0, "pitch_period": "> 50 s"})["pitch_period"] >= 50 * (1 - 1e-5)


def test_one_target_out_of_reach_is_named(spar):
    with pytest.raises(TargetsError, match=r"no sizes within their bounds are found that give draft = 70 m: the near"):
        size(spar, {"solid_ballast": ("4000 t", "5500 t")}, {"draft": "70 m"})


@pytest.mark.parametrize(
    ("free", "targets", "words"),
    [
        ({}, {"draft": 62}, "need parameters that are free"),
        ({"solid_ballast": 5e6}, {"draft": 62}, "has bounds"),
        ({"solid_balast": (0, 1e7)}, {"draft": 62}, "solid_ballast"),
        ({"solid_ballast": (0, 1e7)}, {"draugt": 62}, "draft"),
        ({"solid_ballast": (0, 1e7)}, {"draft": ["62 m", "< 70 m"]}, "one value, or bounds"),
        ({"solid_ballast": (0, 1e7)}, {"draft": "62 kg"}, "kg"),
    ],
)
def test_mistakes(spar, free, targets, words):
    with pytest.raises(ModelError, match=words):
        size(spar, free, targets)


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("spar.yaml").write_text(FILE)
    assert main(["size", "spar.yaml", "--output", "sizes.json"]) == 0
    assert "column_diameter [m]" in capsys.readouterr().out
    kept = json.loads(Path("sizes.json").read_text())
    assert kept["way"] == "equations" and kept["results"]["heave_period"] == pytest.approx(27.0)
    assert read_sizing("spar.yaml").found()["draft"] == pytest.approx(62.0)
    Path("spar.yaml").write_text(FILE.replace("[0 t, 20000 t]", "[0 t, 100 t]"))
    assert main(["size", "spar.yaml"]) == 2
    assert "spar.yaml:" in capsys.readouterr().err
    Path("spar.yaml").write_text(FILE.replace("draft:", "draugt:"))
    assert main(["size", "spar.yaml"]) == 2
    assert "spar.yaml:8:" in capsys.readouterr().err


def test_stopped_it_tells_the_nearest_sizes_so_far(spar, tmp_path, monkeypatch, capsys):
    """Interrupted while the fourth sizes are tried, in Python and by the command."""
    targets = {"draft": "62 m", "heave_period": ["> 27 s", "< 27.5 s"]}
    g, tried = Problem.g, []

    def counted(self, y):
        tried.append(y)
        if len(tried) == stop_at:
            raise KeyboardInterrupt
        return g(self, y)

    monkeypatch.setattr(Problem, "g", counted)
    stop_at = 4
    with pytest.raises(SizingStopped) as stopped:
        size(spar, TWO, targets)
    found = stopped.value
    assert set(found.values) == set(TWO) and 0 < found.tried < 4 and math.isfinite(found.left)
    assert found.units["column_diameter"] == "m" and 10 <= found.values["column_diameter"] <= 25

    tried.clear()
    monkeypatch.chdir(tmp_path)
    text = FILE.replace("heave_period: 27 s", "heave_period: ['> 27 s', '< 27.5 s']")
    Path("spar.yaml").write_text(text)
    assert main(["size", "spar.yaml"]) == 130
    said = capsys.readouterr().err
    assert "fowt size: stopped after" in said and f"column_diameter = {found.values['column_diameter']:.6g} m" in said
    assert "Traceback" not in said


def test_the_checker_takes_a_model():
    """The OC3 spar is stiffer in pitch than spars of F205 are, and its lines hold its yaw: 29 s and 8 s."""
    verdicts = {verdict.limit.quantity: verdict for verdict in check_model(fw.load("oc3_spar_rigid"))}
    assert verdicts["period of surge"].kept and verdicts["period of heave"].kept
    assert not verdicts["period of pitch"].kept and not verdicts["period of yaw"].kept
