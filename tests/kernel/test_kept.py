"""Flat models kept on disk: with the same numbers to the last bit, never stale, never from somebody else.

The models are small ones of springs and masses, with as many parts as it takes to be kept, and a shipped one.
"""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
import textwrap
import time
import warnings
from contextlib import suppress
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
import fowtlib.modelfile
from fowtlib.flattening import flat, flatten, kept, own_code
from fowtlib.flattening.fingerprint import fingerprint
from fowtlib.flattening.own_code import Unknown
from fowtlib.flattening.scalar_graph import NotArithmetic, ScalarGraph
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError

MODEL, SMALL = "oc3_spar_rigid", "raisable_spar_sizes"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache folder, in which flat models of any size are kept."""
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv(kept.SWITCH, raising=False)
    monkeypatch.setattr(kept, "FEW", 1)
    return tmp_path / "cache"


def flattened(root, monkeypatch, opened=()):
    """The flat model, and whether it was flattened now."""
    calls = []
    original = kept.flatten_with
    monkeypatch.setattr(kept, "flatten_with", lambda *a: calls.append(a) or original(*a))
    try:
        return flat(root, opened), bool(calls)
    finally:
        monkeypatch.setattr(kept, "flatten_with", original)


def text_of(dae) -> list[str]:
    """All expressions as the text of functions, operation by operation, and everything else as words."""
    symbols = [dae.t, dae.x, dae.z, dae.u, dae.d, dae.p, dae.w]
    columns = [dae.ode, dae.alg, dae.initial_equations, *(e.inputs for e in dae.externals), *dae.observed.values(),
               *(c.condition for c in dae.checks), *(v for c in dae.checks for v in c.values.values()),
               *(e.indicator for e in dae.events), *(s.values for s in dae.samples), *(o.inputs for o in dae.operators),
               *(o.correction for o in dae.operators), *(q.inputs for q in dae.quadratics),
               *(q.start for q in (*dae.states, *dae.algebraics, *dae.discretes)),
               *(i.symbol for i in (*dae.parameters.values(), *dae.dependents.values(), *dae.bound.values()))]
    words = [[(q.path, q.unit, q.doc, q.hint, q.start_given, q.fixed, q.nominal)
              for q in (*dae.states, *dae.algebraics, *dae.discretes)],
             [(i.path, i.unit, i.doc, i.default.tolist(), i.driver) for i in dae.inputs.values()],
             [(i.path, i.value.tolist(), i.value.shape, i.unit, i.min, i.max) for i in dae.parameters.values()],
             [(b.path, b.owner, b.unit, [f.name for f in b.functions], type(b.compute)) for b in dae.bound.values()],
             [(e.path, e.function.name(), e.outputs) for e in dae.externals], list(dae.observed), dict(dae.units),
             dict(dae.docs), dae.residual_paths, dae.initial_paths, dae.initial_sources,
             [(c.message, c.level, c.path, list(c.values)) for c in dae.checks],
             [(o.path, o.owner, o.declared, o.state_targets, o.discrete_targets) for o in dae.offers],
             [(o.path, o.realization.A.tolist()) for o in dae.operators], [ring.parts for ring in dae.symmetries],
             [(s.targets, s.path, type(s.process)) for s in dae.samples], [s.path for s in dae.stages],
             [(q.path, q.smoothing) for q in dae.quadratics],
             {key: value for key, value in dae.stats.items() if key != "flattening_time"},
             list(dae.bound_parameters.values())]  # fmt: skip
    offers = [ca.Function("o", [*symbols, offer.given], [offer.state_values, offer.discrete_values]).serialize()
              for offer in dae.offers]  # fmt: skip
    return [ca.Function("all", symbols, columns).serialize(), *offers, *map(repr, words)]


@pytest.mark.parametrize("name", [MODEL, "oo_star_rigid_bem", "dtif_raising"])
def test_what_is_read_is_what_was_flattened(folder, monkeypatch, name):
    root = fw.load(name).root
    first, made = flattened(root, monkeypatch)
    again, made_again = flattened(fw.load(name).root, monkeypatch)
    assert made and not made_again and first.key == again.key != ""
    assert text_of(again) == text_of(first) == text_of(flatten(root))
    assert again.equation_table == first.equation_table
    omega = np.array([0.3, 0.8])
    for one, other in zip(first.operators, again.operators, strict=True):
        np.testing.assert_array_equal(one.transfer(omega), other.transfer(omega))


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(fw.modelfile.shipped_models()))
def test_all_models_are_read_as_they_were_flattened(folder, monkeypatch, name):
    first = flattened(fw.load(name).root, monkeypatch)[0]
    again, made_again = flattened(fw.load(name).root, monkeypatch)
    assert not made_again and text_of(again) == text_of(first)


def test_every_number_of_a_model_file_is_content():
    """Those that the file names for itself, for which its component has a class of its own, and those of its parts."""
    model = fw.load("two_rotor_spar_rigid")
    known, tried = fingerprint(model.root), 0
    assert fingerprint(model.with_parameters({}).root) == known
    parameters = flatten(model.root).parameters
    assert "yaw_gain" in parameters
    for path in [path for k, path in enumerate(parameters) if "." not in path or k % 5 == 0]:
        value = parameters[path].value
        with suppress(ModelError):  # a number that would do nothing is refused
            assert fingerprint(model.with_parameters({path: 1.001 * value + 1e-6 * (value == 0)}).root) != known, path
            tried += 1
    assert tried > 20


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_runs_are_equal_to_the_last_bit(folder, monkeypatch, solver):
    outcome = []
    for switch in ("no", "yes", "yes"):
        monkeypatch.setenv(kept.SWITCH, switch)
        result = fw.load(MODEL).compile().simulate(2.0, 0.5, solver=solver, start="turning")
        outcome.append(np.array([result[name].values for name in ("surge", "pitch", "fairlead_tension_1")]).tobytes())
    assert outcome[0] == outcome[1] == outcome[2]
    assert len(list(folder.glob("flat_*.json"))) == 1


SPRING = """
import fowtlib as fw
from fowtlib.language import Scalar, der, eq, param, var
from {helper} import FACTOR, pull

NUMBERS = {{"k": 2.0}}

class Spring(fw.Component):
    stiffness: Scalar = param(default=3.0, unit="N/m", doc="stiffness")
    order: int = param(default=1, doc="how often the pull counts")
    x: Scalar = var(start=1.0, unit="m", doc="place", state="always")
    v: Scalar = var(unit="m/s", doc="speed", state="always")

    def equations(self):
        force = -pull(self.order * self.stiffness * self.x) * FACTOR
        return [eq(der(self.x), self.v), eq(der(self.v), force * NUMBERS["k"])]
"""
HELPER = "FACTOR = 1.0\ndef pull(force):\n    return {pull}\n"


def module(path: Path, name: str, text: str):
    """A module of that text, older than this process as far as its file says."""
    file = path / f"{name}.py"
    file.write_text(textwrap.dedent(text))
    sys.modules.pop(name, None)
    return __import__(name)


@pytest.fixture
def spring(folder, tmp_path, monkeypatch):
    """Writes the modules of a user and gives the root of his model."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(own_code, "_BEGAN", time.time() + 3600)  # files of this test are as old as those of a user
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # two texts of one second and size would have one
    count = iter(range(100))

    def write(pull="force", of=SPRING, **values):
        helper, name = f"helper_of_{os.getpid()}_{next(count)}", "springs_of_a_user"
        module(tmp_path, helper, HELPER.format(pull=pull))
        root = fw.Assembly("springs")
        root.first = module(tmp_path, name, of.format(helper=helper)).Spring(**values)
        return root

    return write


def rate(dae) -> float:
    """The rate of the speed at the start."""
    x, z, p = dae.x, dae.z, dae.p
    values = np.concatenate([np.ravel(item.value) for item in dae.parameters.values()])
    return float(ca.Function("f", [x, z, p], [dae.ode[1]])([1.0, 0.0], [], values))


def test_another_equation_value_helper_or_number_is_another_model(spring, monkeypatch):
    keys, rates = set(), []
    for change in (
        {}, {"pull": "2 * force"}, {"stiffness": 4.0}, {"order": 2},
        {"of": SPRING.replace('"k": 2.0', '"k": 5.0')}, {"of": SPRING.replace("-pull(", "-3 * pull(")},
    ):  # fmt: skip
        dae, made = flattened(spring(**change), monkeypatch)
        assert made
        keys.add(dae.key)
        rates.append(rate(dae))
    assert rates == [-6.0, -12.0, -8.0, -12.0, -15.0, -18.0]
    assert len(keys) == 6
    root = spring()
    key = fingerprint(root)[0]
    sys.modules["springs_of_a_user"].NUMBERS["k"] = 7.0  # a program changes what its equations take
    assert fingerprint(root)[0] != key


TOP, FORCE = "from {helper} import FACTOR, pull\n", "        force ="
WITHOUT = SPRING.replace(TOP, "FACTOR, pull = 1.0, abs\n")


@pytest.mark.parametrize("text", [
    SPRING.replace(TOP, "").replace(FORCE, f"        from late_helper import FACTOR, pull\n{FORCE}"),
    SPRING.replace(TOP, "def pull(x):\n    import late_helper as late\n    return late.pull(x)\nFACTOR = 1.0\n"),
    WITHOUT.replace(FORCE, f"        pull = of_late().pull\n{FORCE}")
    + "\ndef of_late():\n    import late_helper\n    return late_helper\n",
])  # fmt: skip
def test_what_a_function_imports_when_it_is_called_is_content(spring, tmp_path, text):
    keys, rates = [], []
    for pull in ("force", "2 * force", "force"):
        module(tmp_path, "late_helper", HELPER.format(pull=pull))
        root = spring(of=text)
        keys.append(fingerprint(root))
        rates.append(rate(flatten(root)))
    assert rates == [-6.0, -12.0, -6.0]
    assert keys[0] == keys[2] != keys[1] and keys[0][1]


@pytest.mark.parametrize("line", [
    "import never_imported_before", "from never_imported_before import pull", "from . import pull",
    "import os; os.environ.get('FACTOR')", "from os import getenv; getenv('FACTOR')",
    "from importlib import import_module; import_module('late_helper')",
])  # fmt: skip
def test_a_function_that_asks_for_more_than_code_and_values_is_not_known_again(spring, line):
    for text in (
        WITHOUT.replace(FORCE, f"        {line}\n{FORCE}"),
        WITHOUT.replace(FORCE, f"        pull = asking\n{FORCE}") + f"\ndef asking(x):\n    {line}\n    return x\n",
    ):
        with pytest.raises(Unknown):
            fingerprint(spring(of=text))


def test_an_opened_signal_is_another_model(folder, monkeypatch):
    root = fw.load(MODEL).root
    assert flattened(root, monkeypatch)[1]
    dae, made = flattened(root, monkeypatch, ["turbine.blade_pitch"])
    assert made and "turbine.blade_pitch" in dae.inputs


@pytest.mark.parametrize("package", ["casadi", "numpy", "fowtlib"])
def test_another_version_is_another_model(spring, monkeypatch, package):
    root = spring()
    key = fingerprint(root)[0]
    own_code.digest_of_own_code.cache_clear()
    version = own_code.version
    monkeypatch.setattr(own_code, "version", lambda name: "99.0" if name == package else version(name))
    other = fingerprint(root)[0]
    own_code.digest_of_own_code.cache_clear()
    assert other != key


TABLE = SPRING.replace("from fowtlib.language import", "from fowtlib.language import Data, data, ").replace(
    "    x: Scalar",
    "    table: Data[list] = data(lambda path: [float(line) for line in open(path)], doc='factors')\n    x: Scalar",
).replace("self.stiffness *", "self.table[0] *")


def test_another_content_of_a_data_file_is_another_model(spring, tmp_path, monkeypatch):
    file = tmp_path / "factors.csv"
    found = []
    for number in ("3.0", "8.0", "3.0"):
        file.write_text(number)
        dae, made = flattened(spring(of=TABLE, table=str(file)), monkeypatch)
        found.append((rate(dae), made))
    assert [value for value, _ in found] == [-6.0, -16.0, -6.0]
    assert found[0][1] and found[1][1]


def kept_files(folder) -> list[Path]:
    return sorted(folder.glob("flat_*.json"))


@pytest.mark.parametrize("harm", ["short", "bit", "empty", "others", "owner", "link"])
def test_a_file_that_is_harmed_or_not_ours_is_made_again(folder, monkeypatch, harm):
    model = fw.load(SMALL)
    first = flat(model.root)
    (path,) = kept_files(folder)
    content = bytearray(path.read_bytes())
    if harm == "short":
        path.write_bytes(content[: len(content) // 2])
    elif harm == "bit":
        content[len(content) // 3] ^= 4
        path.write_bytes(content)
    elif harm == "empty":
        path.write_bytes(b"")
    elif harm == "others":
        path.chmod(0o666)
    elif harm == "owner":
        if os.getuid():
            pytest.skip("only root can give a file to somebody else")
        os.chown(path, 12345, -1)
    else:
        moved = path.rename(folder.parent / "elsewhere.json")
        path.symlink_to(moved)
    words = {"short": "is damaged", "bit": "is damaged", "empty": "is empty", "others": "can be written by others",
             "owner": "belongs to another user", "link": "is not a regular file"}[harm]  # fmt: skip
    with pytest.warns(UserWarning, match=words):
        again, made = flattened(model.root, monkeypatch)
    assert made and text_of(again) == text_of(first)
    (path,) = kept_files(folder)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600 and not path.is_symlink()


def test_a_folder_of_somebody_else_is_not_read(folder, monkeypatch):
    model = fw.load(SMALL)
    flat(model.root)
    monkeypatch.setattr(os, "getuid", lambda: 4242)
    assert flattened(model.root, monkeypatch)[1]


@pytest.mark.parametrize("change", [
    lambda record: record.pop("states"), lambda record: record["graph"].update(first=record["graph"]["second"]),
    lambda record: record["externals"].pop(), lambda record: record["graph"].update(results="AAAA"),
    lambda record: record.update(bound=[]), lambda record: record["symbols"][1].pop(),
])  # fmt: skip
def test_a_record_that_is_none_is_flattened_anew(folder, monkeypatch, change):
    """What another program has written under a name with the right digests."""
    model = fw.load(MODEL)
    first = flat(model.root)
    (path,) = kept_files(folder)
    record = json.loads(path.read_text())
    path.unlink()
    change(record)
    kept._keep(f"flat_{first.key}", record)
    again, made = flattened(model.root, monkeypatch)
    assert made and text_of(again) == text_of(first)


def test_a_folder_that_cannot_be_written(folder, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    model = fw.load(SMALL)
    monkeypatch.setattr(kept.store, "workshop", refuse)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert flattened(model.root, monkeypatch)[1] and flattened(model.root, monkeypatch)[1]
    assert kept_files(folder) == []


def test_two_processes_at_once(folder):
    code = (
        "import fowtlib as fw; from fowtlib.flattening import kept; kept.FEW = 1; "
        f"print(fw.load('{MODEL}').compile().dae.key)"
    )
    runs = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    keys = {run.communicate(timeout=300)[0] for run in runs}
    assert len(keys) == 1 and [run.returncode for run in runs] == [0, 0]
    assert {path.name.split("_")[1] for path in kept_files(folder)} == {keys.pop().strip()}


def test_it_is_switched_off_and_a_wrong_word_is_refused(folder, monkeypatch):
    model = fw.load(MODEL)
    monkeypatch.setenv(kept.SWITCH, "no")
    assert flat(model.root).key == "" and not folder.exists()
    monkeypatch.setenv(kept.SWITCH, "perhaps")
    with pytest.raises(fw.ModelError, match="FOWTLIB_KEEP_FLAT is 'perhaps'; yes or no is expected"):
        flat(model.root)


def test_code_that_nobody_can_know_again_is_flattened_every_time(spring, folder, monkeypatch):
    def equations(self):
        return [fw.language.eq(self.x, 0), fw.language.eq(self.v, 0)]

    root = spring()
    space = {"__name__": "nowhere"}
    exec(compile("import fowtlib as fw\nclass Loose(fw.Component):\n    pass", "<nowhere>", "exec"), space)
    root.loose = space["Loose"]()
    with pytest.raises(Unknown):
        fingerprint(root)
    root = fw.load(MODEL).root
    kind = type(root.find("platform.motion"))
    monkeypatch.setattr(kind, "equations", equations)
    with pytest.raises(Unknown, match="is not as its file says"):
        fingerprint(root)


def test_code_written_after_the_process_has_begun_is_not_trusted(spring, monkeypatch):
    root = spring()
    fingerprint(root)
    monkeypatch.setattr(own_code, "_BEGAN", time.time() - 3600)
    with pytest.raises(Unknown, match="was written after this process had begun"):
        fingerprint(root)


def test_equations_that_read_a_file_of_their_own_or_that_warn_are_not_kept(spring, folder, tmp_path, monkeypatch):
    (tmp_path / "numbers.txt").write_text("2.0")
    reading = SPRING.replace('NUMBERS["k"]', f"float(open(r'{tmp_path}/numbers.txt').read())")
    dae, made = flattened(spring(of=reading), monkeypatch)
    assert made and rate(dae) == -6.0 and kept_files(folder) == []
    (tmp_path / "numbers.txt").write_text("3.0")
    assert rate(flat(spring(of=reading))) == -9.0
    warning = SPRING.replace("        return [", "        __import__('warnings').warn('stiff')\n        return [")
    for _ in range(2):
        with pytest.warns(UserWarning, match="stiff"):
            flat(spring(of=warning))
    assert kept_files(folder) == []


def test_bound_parameters_are_checked_and_are_not_in_the_key(folder, monkeypatch):
    model = fw.load(MODEL)
    first = flat(model.root)
    other = model.with_parameters({"sea.seed": 77, "wind.seed": 9})
    dae, made = flattened(other.root, monkeypatch)
    assert not made and dae.key == first.key
    other.root.sea._values["seed"] = -1
    with pytest.raises(fw.ModelError, match="sea.seed = -1 is below its minimum"):
        flat(other.root)


FOLLOWING = SPRING.replace('    order: int = param(default=1, doc="how often the pull counts")', """
    length: float = param(default=2.0, unit="m", bound=True, doc="length")
    order: int = param(default=lambda own: round(own.parameter_value("length")), doc="how often the pull counts")
    place: Scalar = param(default=lambda own: own.parameter_value("length") / 4, unit="m", doc="where it starts")
    """).replace("var(start=1.0", "var(start=place")  # fmt: skip


def test_defaults_that_follow_from_bound_parameters_are_those_of_now(spring, monkeypatch):
    """A tunable one is found anew, a structural one, of which the equations are made, makes another model."""
    kind = type(spring(of=FOLLOWING).first)

    def of(length):
        root = fw.Assembly("springs")
        root.first = kind(length=length)
        return flattened(root, monkeypatch)

    of(1.0)  # the first model of a process, whose units come from files
    first, made = of(2.0)
    assert made and float(first.parameters["first.place"].value) == 0.5 and rate(first) == -12.0
    for _ in range(2):
        dae, made = of(2.2)
        assert not made and float(dae.parameters["first.place"].value) == 0.55 and dae.key == first.key
    dae, made = of(3.0)
    assert made and float(dae.parameters["first.place"].value) == 0.75 and rate(dae) == -18.0


def test_a_turbine_starts_in_the_wind_of_its_file(folder, tmp_path, monkeypatch):
    """A file of another wind is the same model and another start: 5 and 9 m/s, below rated wind."""
    speeds = []
    for number, speed in enumerate((5.0, 9.0, 5.0)):
        file = tmp_path / f"wind_{number % 2}.csv"
        file.write_text("time,speed\n" + "".join(f"{time},{speed}\n" for time in range(5)))
        model = fw.load(MODEL, set={"wind.kind": "file", "wind.file": str(file)})
        dae, made = flattened(model.root, monkeypatch)
        assert made == (number == 0)
        speeds.append(float(dae.parameters["turbine.rotor_speed_start"].value))
        assert speeds[-1] == float(flatten(model.root).parameters["turbine.rotor_speed_start"].value)
    assert speeds[0] == speeds[2] < 0.9 * speeds[1]


def test_the_report_of_a_check_is_the_same_again(folder, monkeypatch):
    first, again = fw.load(MODEL).check(), fw.load(MODEL).check()
    monkeypatch.setenv(kept.SWITCH, "no")
    assert str(first) == str(again) == str(fw.load(MODEL).check())
    assert len(list(folder.glob("dimensions_*.json"))) == 1


def test_equations_of_a_model_that_was_changed_are_refused(folder, monkeypatch):
    model = fw.load(MODEL)
    flat(model.root)
    dae = flat(model.root)
    model.root.platform.hull.mass = 1.0
    with pytest.raises(fw.ModelError, match="changed after it was compiled"):
        dae.equation_table  # noqa: B018


def test_a_graph_of_scalars():
    x, y, other = ca.SX.sym("x", 3), ca.SX.sym("y"), ca.SX.sym("other")
    symbols = ca.vertcat(x, y)
    results = ca.vertcat(m.sin(x[0]) * y, x[1], 2.5, ca.if_else(y < x[2], x[0] / y, ca.atan2(y, x[1])), 0.0)
    graph = ScalarGraph.of(symbols, results)
    new = ca.SX.sym("s", 4)
    functions = [ca.Function("f", [s], [e]) for s, e in ((symbols, results), (new, graph.expressions(new)))]
    assert functions[0].serialize() == functions[1].serialize().replace("s_", "x_") or [
        f.instruction_id(k) for f in functions for k in range(f.n_instructions())
    ] == 2 * [functions[0].instruction_id(k) for k in range(functions[0].n_instructions())]
    point = [0.3, -1.2, 2.0, 0.7]
    np.testing.assert_array_equal(*(np.array(f(point)) for f in functions))
    with pytest.raises(NotArithmetic):
        ScalarGraph.of(symbols, ca.vertcat(other))
    black = ca.Function("black", [ca.MX.sym("a")], [ca.MX.sym("a")], {"allow_free": True})
    assert black.n_in() == 1
    with pytest.raises(ValueError, match="no graph"):
        graph.expressions(ca.SX.sym("s", 3))
