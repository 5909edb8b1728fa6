"""Design files, and `fowt optimise`."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.design.file import read_design, shipped_designs
from fowtlib.language.errors import ModelError

COLUMN = """fowtlib_design: 1
title: The tubular column
variables:
  d: {lower: 2, upper: 14, start: 10}
  t: {lower: 0.2, upper: 0.8, start: 0.5}
functions:
  cost: 9.82 * d * t + 2 * d
  stress: 2500 / (pi * d * t)
  euler: {formula: pi^2 * 0.85e6 * (d^2 + w^2) / (8 * 250^2), of: {w: t}}
  buckling: stress - euler
objective: cost
constraints:
  - stress < 500
  - {result: buckling, upper: 0, scale: 500}
optimiser: {method: slsqp, tolerance: 1e-8}
"""
HULL = """fowtlib_design: 1
model: two_rotor_spar_design
free: [ballast]
targets: {heave: 0}
variables:
  diameter: {lower: 9 m, upper: 12 m}
objective: "hull: mass"
cases:
  thrust: {weight: 1}
  rest: {parameters: {thrust: 0}, weight: 0}
constraints:
  - pitch @ thrust < 5 deg
  - {result: period of heave, lower: 25 s, cases: rest}
"""


@pytest.fixture
def written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(text, name="column.yaml"):
        Path(name).write_text(text)
        return name

    return write


def test_a_file_is_a_design(written):
    file = read_design(written(COLUMN))
    assert file.design.title == "The tubular column" and file.optimiser == {"method": "slsqp", "tolerance": 1e-8}
    found = file.design.optimise(**file.optimiser)
    assert found.value == pytest.approx(26.531, abs=2e-3)


def test_the_command_shows_saves_and_draws(written, capsys):
    name = written(COLUMN)
    assert main(["optimise", name, "-o", "column.json", "--plot", "column.png"]) == 0
    shown = capsys.readouterr()
    assert "The tubular column: an optimum; all constraints are kept." in shown.out
    assert ["d", "[1]", "10", "5.4512", "2", "14"] in [line.split() for line in shown.out.splitlines()]
    assert shown.err.splitlines()[0].split() == [
        "iterate",
        "evaluations",
        "objective",
        "violation",
        "step",
        "worst",
        "constraint",
    ]
    told = json.loads(Path("column.json").read_text())
    assert told["optimum"] == pytest.approx(26.531, abs=2e-3) and Path("column.png").stat().st_size > 5000
    # the journal is not written over unasked; going on from it has nothing left to do
    assert main(["optimise", name]) == 2
    assert "column.jsonl is there already: go on from it with --resume" in capsys.readouterr().err
    before = Path("column.jsonl").read_text()
    assert main(["optimise", name, "--resume", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["optimum"] == pytest.approx(26.531, abs=2e-3)
    assert Path("column.jsonl").read_text() == before
    assert main(["optimise", name, "--force", "--csv", "--method", "ipopt", "--starts", "2", "--seed", "1"]) == 0
    assert capsys.readouterr().out.startswith("variable,start,optimum,lower,upper,active,price\n")


def test_the_command_evaluates_the_start(written, capsys):
    assert main(["optimise", written(COLUMN), "--evaluate", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["optimum"] == pytest.approx(9.82 * 5 + 20) and not Path("column.jsonl").exists()


def test_no_design_is_an_answer(written, capsys):
    name = written(COLUMN.replace("stress < 500", "stress < 50"))
    assert main(["optimise", name]) == 1
    out = capsys.readouterr().out
    assert (
        "no design that keeps all constraints was found" in out and "stress" in out and "at most 50 is allowed" in out
    )


def test_a_front_by_the_command(written, capsys):
    assert main(["optimise", written(COLUMN), "--front", "stress=4", "-o", "front.csv", "--plot", "front.png"]) == 0
    rows = np.genfromtxt("front.csv", delimiter=",", skip_header=1, dtype=str)
    assert rows.shape[0] == 4 and np.all(np.diff(rows[:, 0].astype(float)) > 0)
    assert np.all(np.diff(rows[:, 1].astype(float)) < 0) and Path("front.png").exists()


def test_the_shipped_designs_are_read():
    assert "two_rotor_spar_hull" in shipped_designs()
    for name in shipped_designs():
        assert fw.read_design(name).design.keys


RING = """fowtlib_design: 1
variables:
  wall: {drives: [], unit: m, lower: 5 mm, upper: 60 mm, start: [20 mm, 30 mm, 40 mm]}
functions:
  forces: {formula: 1000 * k * wall, of: {k: wall}, unit: kN}
  volume: {formula: "wall[0] + wall[1] + wall[2]", unit: m}
  tower:
    rule: tower_cost
    take: mass
    of: {heights: [0, 10, 20], diameters: [4, "volume", 4], walls: wall}
  strength:
    rule: at_most
    of: {value: forces, limit: 800}
objective: tower
constraints: [{result: volume, lower: 80 mm}, strength < 1.0]
optimiser: {method: successive}
"""


def test_variables_that_drive_nothing_and_rules_of_lists_in_si(written):
    design = read_design(written(RING)).design
    assert design.space.units == ["m"] * 3 and np.allclose(design.space.start, [0.02, 0.03, 0.04])
    at = {row.name: row.value for row in design.evaluate().constraints}
    # 1000 x^2 kN, as N, over 800; the formula has the numbers in their units
    assert at["strength[2]"] == pytest.approx(1e6 * 0.04**2 / 800)
    t, D = np.array([0.02, 0.03, 0.04]), np.array([4, 0.09, 4])
    of = [(D[k : k + 2].mean(), t[k : k + 2].mean()) for k in (0, 1)]
    assert design.evaluate().value == pytest.approx(sum(8500 * np.pi * (d - w) * w * 10 for d, w in of), rel=1e-9)
    walls = [[0.0213, 0.0333, 0.0417], [0.0251, 0.0301, 0.0399], [0.0207, 0.0309, 0.0411]]
    assert {design.evaluate({"wall": wall}).reason for wall in walls} == {"as given"}


def test_a_variable_drives_part_of_an_array_and_a_case_has_its_own_model(written):
    model = """fowtlib: 1
title: sticks
parameters: {lengths: {value: [1 m, 2 m, 3 m, 4 m], unit: m}}
world: {class: World}
parts:
  ball: {class: RigidBody, mass: MASS, r_cm: [0, 0, 0], inertia: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
  stick: {class: FixedTranslation, r: ["lengths[1] + lengths[2]", 0, "lengths[3]"]}
  motion: {class: Prismatic, n: [0, 0, 1]}
  spring: {class: SpringDamper, stiffness: 100, damping: 1, natural_length: 5 m}
  foot: {class: Fixed, r: [0, 0, -5 m]}
connect:
  - [world.frame, motion.frame_a]
  - [foot.frame, spring.frame_a]
  - [motion.frame_b, spring.frame_b]
  - [motion.frame_b, stick.frame_a]
  - [stick.frame_b, ball.frame_a]
outputs: {reach: "ball.frame_a.r[0]", height: "ball.frame_a.r[2]"}
"""
    written(model.replace("MASS", "1 kg"), "light.yaml")
    written(model.replace("MASS", "3 kg"), "heavy.yaml")
    text = """fowtlib_design: 1
model: light.yaml
variables:
  some: {drives: "lengths[1:3]", lower: 1 m, upper: 5 m}
objective: reach @ light
cases: {light: {weight: 1}, heavy: {weight: 1, model: heavy.yaml}}
constraints: [reach @ heavy > 3 m, height @ heavy < 9 m, height @ light < 9 m]
"""
    design = read_design(written(text, "sticks.yaml")).design
    assert design.space.elements == ["some[0]", "some[1]"] and np.allclose(design.space.start, [2, 3])
    found = design.evaluate({"some": [4, 4.5]})
    rows = {row.name: row.value for row in found.constraints}
    assert found.value == pytest.approx(8.5) and rows["reach @ heavy"] == pytest.approx(8.5)
    assert rows["height @ light"] - rows["height @ heavy"] == pytest.approx(2 * 9.80665 / 100, rel=1e-3)
    with pytest.raises(ModelError, match="lengths has 4 elements"):
        read_design(written(text.replace("[1:3]", "[2:5]"), "wrong.yaml"))
    # the model of a case may have values of its own: half as stiff it sinks in twice as far
    soft = text.replace("model: heavy.yaml}", "model: heavy.yaml, set: {spring.stiffness: 50}}")
    other = {row.name: row.value for row in read_design(written(soft, "soft.yaml")).design.evaluate().constraints}
    stiff = {row.name: row.value for row in design.evaluate().constraints}
    assert stiff["height @ heavy"] - other["height @ heavy"] == pytest.approx(3 * 9.80665 / 100, rel=1e-3)
    with pytest.raises(ModelError, match=r"none.yaml:6: 'set' is of a model, and the case names none"):
        read_design(written(text.replace("weight: 1, model: heavy.yaml", "set: {spring.stiffness: 50}"), "none.yaml"))
    with pytest.raises(ModelError, match=r"wrong.yaml:6: .*'stifness'"):
        read_design(written(soft.replace("spring.stiffness", "spring.stifness"), "wrong.yaml"))


def test_a_shipped_design_is_found(written, capsys):
    """A model with two cases: the optimum is where the pitch is 5 deg, as one equilibrium more finds it."""
    assert main(["optimise", written(HULL, "hull.yaml"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    state = fw.load("two_rotor_spar_design").compile().equilibrium(
        free=["ballast", "diameter"], targets={"heave": 0, "pitch": "5 deg"}
    )  # fmt: skip
    assert told["variables"][0]["optimum"] == pytest.approx(float(state.parameters["diameter"]), rel=1e-5)
    assert told["parameters"]["ballast"] == pytest.approx(float(state.parameters["ballast"]), rel=1e-5)
    assert told["constraints"][1]["constraint"] == "period of heave [s]"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("fowtlib_design: 1", "fowtlib_design: 2", ":1: got 'fowtlib_design: 2'"),
        ("fowtlib_design: 1", "fowtlib: 1", ":1: this is a model file"),
        ("  diameter: {lower: 9 m,", "  diametre: {lower: 9 m,", ":6: the variable 'diametre' cannot"),
        ("  diameter: {lower: 9 m,", "  hull.column.sections: {lower: 9,", ":6: the variable 'hull.column.sections"),
        ("lower: 9 m, upper: 12 m", "lower: 12 m, upper: 9 m", ":6: the bounds of 'diameter', 12 and 9 m, are the"),
        ("lower: 9 m, upper: 12 m", "lower: 9 m", ":6: the variable 'diameter' has no 'upper' bound"),
        ("lower: 9 m, upper: 12 m", "lower: 9 m, upper: 12 m, uper: 3", ":6: 'uper' is not a key of a variable"),
        ("lower: 9 m, upper: 12 m", "lower: 9 kg, upper: 12 m", ":6: diameter: got '9 kg'"),
        ('objective: "hull: mass"', "objective: {mass: heavy}", ":7: the factor of 'mass' in the objective is a n"),
        ('objective: "hull: mass"', "objectiv: mass", ":7: 'objectiv' is not a key of a design file"),
        ("pitch @ thrust < 5 deg", "pich @ thrust < 5 deg", ":12: case thrust: the model has no quantity 'pich'; did"),
        ("pitch @ thrust < 5 deg", "pitch @ storm < 5 deg", ":12: 'pitch @ storm': there is no case 'storm'"),
        ("pitch @ thrust < 5 deg", "pitch", ":12: 'pitch' is no constraint, such as"),
        ("pitch @ thrust < 5 deg", "std of rol < 3", ":12: 'std of rol' is of no result of the model"),
        ("cases: rest", "cases: [calm]", "the constraint on 'period of heave' is never evaluated: there is no"),
        ("lower: 25 s, cases", "lowr: 25 s, cases", ":13: 'lowr' is not a key of a constraint"),
        ("lower: 25 s, cases", "cases", ":13: the constraint on 'period of heave' has no limit"),
        ("{thrust: 0}, weight: 0", "{thrst: 0}, weight: 0", ":10: case rest: there is no tunable parameter 'thrst'"),
        ("{thrust: 0}, weight: 0", "{thrust: 0}, weight: -1", ":10: the weight of a case is zero or more"),
        ("{thrust: 0}, weight: 0", "{thrust: 0}, wind: steady:8", ":10: 'wind': the model has no part 'wind'"),
        ("model: two_rotor_spar_design", "model: two_rotor_spr_design", ":2: there is no model 'two_rotor_spr_design'"),
        ("free: [ballast]", "free: [balast]", "balast"),
        ("period of heave", "period of heve", ":13: case rest: there is no 'period of heve' at this point; did you me"),
        ("period of heave", "periods of heave", "no quantity 'periods of heave'; did you mean 'period of heave'?"),
        ("period of heave", "balast", "the model has no quantity 'balast'; did you mean 'ballast'?"),
        ("free: [ballast]", "statistics: {duration: -3}", ":3: duration: a number above 0 is expected, not -3"),
        ("free: [ballast]", "statistics: {quantile: 2}", ":3: quantile: a number between 0 and 1 is expected"),
    ],
)  # fmt: skip
def test_mistakes_have_their_line(written, capsys, old, new, message):
    assert old in HULL
    assert main(["optimise", written(HULL.replace(old, new, 1), "hull.yaml")]) == 2
    said = capsys.readouterr().err
    assert "hull.yaml" + message in said or (message in said and not message.startswith(":")), said
    assert "Traceback" not in said


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cost: 9.82 * d * t + 2 * d", "cost: 9.82 * d * t + 2 m * d", ":7: the formula of 'cost' has a unit in it"),
        ("cost: 9.82 * d * t + 2 * d", "cost: 9.82 * d * t + 2 * (d", ":7: cannot read"),
        ("cost: 9.82 * d * t + 2 * d", "cost: 9.82 * d * t + 2 * depth", ":7: there is no result 'depth'"),
        ("of: {w: t}", "of: {w: t, v: d}", ":9: nothing in the formula of 'euler' uses 'v'"),
        ("buckling: stress - euler", "buckling: stress - euler\n  more: d + t", ":11: nothing uses the function 'mor"),
        ("buckling: stress - euler", "buckling: stress - euler + buckling", ":10: the function 'buckling' depends on"),
        ("of: {w: t}", "of: {w: [t]}", ":9: 'w' stands for a result, by its name, not for a list"),
        ("method: slsqp", "method: slsqb", ":15: there is no optimiser 'slsqb'; did you mean 'slsqp'"),
        ("tolerance: 1e-8", "starts: 0.5", ":15: 'starts' is a whole number"),
        ("title: The tubular column", "free: [d]", ":2: 'free' is of a model, and the file names none"),
    ],
)  # fmt: skip
def test_mistakes_in_functions_have_their_line(written, old, new, message):
    assert old in COLUMN
    with pytest.raises(ModelError) as error:
        read_design(written(COLUMN.replace(old, new, 1))).design.evaluate()
    assert "column.yaml" + message in str(error.value)


def test_arguments_that_do_not_fit_are_refused(written, capsys):
    name = written(COLUMN)
    assert main(["optimise", name, "--evaluate", "--resume"]) == 2
    assert "--journal and --resume are of a search" in capsys.readouterr().err
    assert main(["optimise", name, "--resume"]) == 2
    assert "there is no journal column.jsonl" in capsys.readouterr().err
    assert main(["optimise", "colum"]) == 2
    assert "there is no design 'colum', nor a file of that name" in capsys.readouterr().err
    assert main(["optimise", "nowhere.yaml"]) == 2
    assert "there is no file 'nowhere.yaml'" in capsys.readouterr().err
    assert main(["optimise", "colum.yaml"]) == 2
    assert "there is no file 'colum.yaml'; did you mean 'column.yaml'?" in capsys.readouterr().err
    assert main(["optimise", name, "--front", "stress=3", "--evaluate"]) == 2
    assert "--evaluate shows the start alone, and --front searches" in capsys.readouterr().err
    hull = written(HULL, "hull.yaml")
    assert main(["optimise", hull, "--front", "pich @ thrust=3"]) == 2
    assert "fowt optimise: --front: the model has no quantity 'pich'; did you mean" in capsys.readouterr().err
    assert main(["optimise", hull, "--front", "pitch @ storm=3"]) == 2
    assert "fowt optimise: --front: 'pitch @ storm': there is no case 'storm'" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["optimise", name, "--front", "stress"])
    assert "'stress' is not RESULT=POINTS, such as mass=6" in capsys.readouterr().err


def test_ctrl_c_says_how_to_go_on(written):
    """In the middle of a search of a model."""
    name = written(HULL, "hull.yaml")
    script = (  # a shell may have taken away the handler of Ctrl-C
        "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from fowtlib.cli.app import main; sys.exit(main(['optimise', sys.argv[1]]))"
    )
    process = subprocess.Popen([sys.executable, "-c", script, name], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               text=True)  # fmt: skip
    deadline = time.time() + 120
    while time.time() < deadline and not (
        Path("hull.jsonl").exists() and Path("hull.jsonl").read_text().count("\n") > 2
    ):
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert errors.endswith("fowt optimise: stopped; hull.jsonl keeps what was found; go on with --resume.\n")
