"""An FMU that crashes, hangs, leaves or floods: a sentence, the results so far, and nothing that stays behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.fmu import FMU
from fowtlib.components.fmu.running import FmuProcess, FmuSession
from fowtlib.components.isolation import folders
from fowtlib.language.errors import SimulationError
from fowtlib.solving.run import Interrupted

CRASH, EXIT, HANG, FLOOD, ENDS_BADLY, FREED_BADLY, HANGS_AT_THE_END, ABORT, EXITS_AT_START = (
    5,
    6,
    7,
    8,
    9,
    10,
    11,
    12,
    13,
)
START = {"mode": 2, "enabled": True, "generator.speed": 1150.0, "pitch[1]": 0.0, "torque": 0.0}
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals")


def plant(path: str, trouble: int = 0, at: float = 0.5, **values) -> fw.Plant:
    model = fw.Assembly("guarded")
    model.unit = FMU(file=path, start={**START, "trouble": trouble, "trouble_time": at}, **values)
    return fw.load(model).compile()


def left() -> set[str]:
    """Folders of sessions, and processes of this one that are or were."""
    prefixes = (folders.PREFIX, folders.NEW)
    return {name for name in os.listdir(tempfile.gettempdir()) if name.startswith(prefixes)} | set(children())


def children(parent: int | None = None) -> list[str]:
    of = str(parent or os.getpid())
    text = subprocess.run(["ps", "-ww", "-eo", "ppid=,pid=,args="], capture_output=True, text=True, check=True).stdout
    return [line.split()[1] for line in text.splitlines() if line.split()[0] == of and "worker.py" in line]


@pytest.fixture(autouse=True)
def nothing_stays(temporary_files_of_its_own):
    before = left()
    yield
    assert left() == before


PATIENCE = 5.0  # s; to load the library takes a busy machine more than one
FAILURES = [
    (CRASH, "it crashed (SIGSEGV); it printed: nothing"),
    (EXIT, "it ended its process with the code 0; it printed: nothing"),
    (ABORT, "it crashed (SIGABRT); it printed: the table has 0 rows"),
    (HANG, "it took longer than 5 s, its 'patience'; it printed: nothing"),
]


@pytest.mark.parametrize("solver", ["fixed", "idas"])
@pytest.mark.parametrize(("trouble", "text"), FAILURES)
def test_what_ends_in_a_step(fmu, trouble, text, solver):
    with pytest.raises(SimulationError) as caught:
        plant(fmu(), trouble, patience=PATIENCE).simulate(1.0, 0.1, solver=solver, outputs=["unit.torque"])
    name = Path(fmu()).name
    assert str(caught.value) == f"unit: the FMU '{name}' cannot be called: {text} (t = 0.5 s)."
    assert caught.value.result.dataset.sizes["time"] >= 5
    assert np.isfinite(caught.value.result["unit.torque"]).all()


def test_what_ends_before_the_first_step(fmu, monkeypatch):
    with pytest.raises(SimulationError, match=r"cannot be called: it ended its process with the code 0.*\(t = 0 s\)"):
        plant(fmu(), EXITS_AT_START).simulate(1.0, 0.1)
    one = plant(fmu())
    monkeypatch.setenv("TEST_FMU_CRASHES", "1")
    with pytest.raises(SimulationError, match=r"unit: .*cannot be loaded: it crashed \(SIGSEGV\); it printed: nothing"):
        one.simulate(1.0, 0.1)


@pytest.mark.parametrize(
    ("trouble", "text"),
    [(ENDS_BADLY, r"it crashed \(SIGSEGV\)"), (FREED_BADLY, r"it crashed \(SIGSEGV\)"),
     (HANGS_AT_THE_END, r"it took longer than 5 s")],
)  # fmt: skip
def test_what_ends_at_the_end_does_not_cost_the_result(fmu, trouble, text):
    with pytest.warns(UserWarning, match=f"unit: closing it fails: the FMU .* cannot be ended: {text}"):
        result = plant(fmu(), trouble, patience=PATIENCE).simulate(1.0, 0.1, outputs=["unit.samples"])
    assert result["unit.samples"][-1] == 81


def test_a_flood_of_words_neither_stops_it_nor_comes_out(fmu, capfd):
    """10 MB in each of 41 steps; only the last words are kept."""
    begin = time.monotonic()
    result = plant(fmu(), FLOOD).simulate(0.52, 0.01, outputs=["unit.samples"])
    assert result["unit.samples"][-1] == 42
    assert time.monotonic() - begin < 30
    assert capfd.readouterr() == ("", "")


def test_both_ways_give_the_same(fmu):
    names = ["unit.torque", "unit.pitch_1", "unit.samples", "unit.instances", "unit.active", "unit.mode_out"]
    inside, outside = (plant(fmu(), in_process=where).simulate(1.0, 0.1, outputs=names) for where in (True, False))
    for name in names:
        np.testing.assert_array_equal(inside[name], outside[name])


@pytest.mark.parametrize("version", [2, 3])
def test_both_ways_give_the_same_for_numbers_of_all_types(fmu, version):
    """Bit for bit, sample by sample: reals with units, a matrix, whole numbers, booleans, from inputs that change."""
    chance, columns = np.random.default_rng(version), []
    ways = [process(fmu(version), where) for where in (True, False)]
    names = [signal.variable.name for signal in ways[0].inputs for _ in range(signal.variable.size)]
    low, high = np.array([{"mode": (0, 9), "enabled": (0, 1)}.get(name, (200, 230)) for name in names]).T
    inputs = low + (high - low) * chance.random((80, len(names)))
    for one in ways:
        session = one.start()
        columns.append([session.step(k * one.period, row) for k, row in enumerate(inputs)])
        session.close()
    np.testing.assert_array_equal(*columns)
    outputs, first = {}, 0
    for output in ways[0].outputs:
        outputs[output.variable.name] = np.array(columns[0])[:, first : (first := first + output.variable.size)]
    np.testing.assert_array_equal(outputs["mode_out"][:, 0], np.rint(inputs[:, names.index("mode")]))
    np.testing.assert_array_equal(outputs["active"][:, 0], inputs[:, names.index("enabled")] >= 0.5)
    assert len(np.unique(outputs["torque"])) > 20


@pytest.mark.parametrize("value", [np.nan, np.inf, 2.0**31])
def test_a_whole_number_that_the_type_does_not_have(fmu, value):
    session = process(fmu(), True).start()
    column = np.array([120.0 if signal.variable.name != "mode" else value for signal in session.process.inputs])
    with pytest.raises(SimulationError, match=r"the input 'mode' is (nan|inf|2147483648), and -2147483648 to"):
        session.step(0.0, column)
    session.close()


def test_ctrl_c_during_a_call_that_hangs(fmu, python_handler):
    """Both the simulation and the process of the FMU get it; it is answered at once, with the results so far."""
    one = plant(fmu(), HANG)
    threading.Timer(1.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(Interrupted) as caught:
        one.simulate(1.0, 0.1, solver="fixed")
    assert 1.4 < time.monotonic() - begin < 50  # not the 60 s that a call may take
    times = caught.value.result.time
    assert times[:5] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert len(times) == 6 and 0.4 < times[5] <= 0.5  # where it stood


PROGRAM = """
import signal, sys, os
signal.signal(signal.SIGINT, signal.default_int_handler)  # as in a terminal; a shell may have taken it away
import fowtlib as fw
from fowtlib.components.fmu import FMU
from fowtlib.language.errors import SimulationError
model = fw.Assembly("guarded")
model.unit = FMU(file=sys.argv[1], start={**%r, "trouble": %d, "trouble_time": 0.5})
plant = fw.load(model).compile()
def say(t, t_end):
    print("at work", t, flush=True)
try:
    plant.simulate(1e6, 0.5, solver="fixed", step=0.0125, progress=say)
except SimulationError as error:
    print("said:", error, flush=True)
"""


def running(path: str, folder: Path, trouble: int) -> subprocess.Popen:
    """A program at work on a long run, with temporary files in `folder`."""
    program = subprocess.Popen(
        [sys.executable, "-c", PROGRAM % (START, trouble), path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env={**os.environ, "TMPDIR": str(folder)}, text=True, start_new_session=True,
    )  # fmt: skip
    assert program.stdout.readline().startswith("at work")
    return program


def gone(process: str, seconds: float = 5.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not Path(f"/proc/{process}").exists() or " Z " in Path(f"/proc/{process}/stat").read_text():
            return True
        time.sleep(0.05)
    return False


@pytest.mark.skipif(sys.platform != "linux", reason="/proc")
@pytest.mark.parametrize("trouble", [0, HANG])
def test_a_simulation_that_is_killed_takes_the_process_and_its_files_along(fmu, tmp_path, trouble):
    program = running(fmu(), tmp_path, trouble)
    (worker,) = children(program.pid)
    time.sleep(0.5)
    program.kill()
    program.wait()
    assert gone(worker)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform != "linux", reason="/proc")
def test_ctrl_c_for_all_processes_of_the_terminal(fmu, tmp_path):
    program = running(fmu(), tmp_path, 0)
    (worker,) = children(program.pid)
    os.kill(int(worker), signal.SIGINT)  # as if it were in the group of the terminal
    os.kill(int(worker), signal.SIGTERM)
    assert program.stdout.readline().startswith("at work")
    os.killpg(program.pid, signal.SIGINT)
    assert "said: interrupted at t = " in program.stdout.read()
    program.wait()
    assert gone(worker)
    assert list(tmp_path.iterdir()) == []


def test_leftovers_of_those_killed_all_at_once_go_at_the_next_start(tmp_path, monkeypatch):
    """What is locked is in use; what is not a folder of ours stays."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    used, left_over, other = folders.private_folder(), tmp_path / f"{folders.PREFIX}x", tmp_path / "other"
    link = tmp_path / f"{folders.PREFIX}link"
    for folder in (left_over / "unit", other):
        folder.mkdir(parents=True)
        (folder / "file").write_text("x")
    link.symlink_to(other)
    program = "from fowtlib.components.isolation import folders; folders.remove(folders.private_folder())"
    subprocess.run([sys.executable, "-c", program], check=True, env={**os.environ, "TMPDIR": str(tmp_path)})
    assert sorted(tmp_path.iterdir()) == sorted([used, other, link])
    assert (other / "file").exists() and used.stat().st_mode & 0o777 == 0o700
    folders.remove(used)
    link.unlink()


# --- what it remembers -----------------------------------------------------------------------------------------------

KEEPS = {
    2: 'canGetAndSetFMUstate="true" canSerializeFMUstate="true" ',
    3: 'canGetAndSetFMUState="true" canSerializeFMUState="true" ',
}


def process(path: str, in_process: bool = False) -> FmuProcess:
    unit = FMU(file=path, start=START | ({"array_in": 0} if "array_in" in FMU(file=path).ports else {}))
    signals = unit._inputs, unit._outputs, unit._start, unit._step
    return FmuProcess(unit._archive, unit._description, unit._content, *signals, in_process=in_process)


def go_on(session: FmuSession, first: int, last: int) -> np.ndarray:
    size = sum(signal.variable.size for signal in session.process.inputs)
    speeds = [np.full(size, 120 + np.sin(k)) for k in range(first, last)]
    return np.array([session.step(0.0125 * (first + k), inputs) for k, inputs in enumerate(speeds)])


@pytest.mark.parametrize("in_process", [False, True])
@pytest.mark.parametrize("version", [2, 3])
def test_a_saved_state_goes_on_in_another_process(fmu, version, in_process):
    one = process(fmu(version, ("<CoSimulation ", "<CoSimulation " + KEEPS[version])), in_process)
    assert one.keeps_state
    session = one.start()
    go_on(session, 0, 20)
    state = session.saved_state()
    expected = go_on(session, 20, 40)
    session.restore_state(state)
    np.testing.assert_array_equal(go_on(session, 20, 40), expected)
    session.close()
    fresh = one.start()
    fresh.restore_state(state)
    np.testing.assert_array_equal(go_on(fresh, 20, 40), expected)
    with pytest.raises(SimulationError, match="the FMU fails: .*erialize.* failed with status 3"):
        fresh.restore_state(state[:-1])
    fresh.close()


def test_a_state_that_cannot_be_saved(fmu):
    session = process(fmu()).start()
    with pytest.raises(SimulationError, match="does not say that it can save its state"):
        session.saved_state()
    session.close()


# --- again and again -------------------------------------------------------------------------------------------------


def cycles():
    """The script beside, as a module."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "robustness"))
    try:
        import fmu_cycles
    finally:
        sys.path.pop(0)
    return fmu_cycles


@pytest.mark.skipif(sys.platform != "linux", reason="/proc")
@pytest.mark.parametrize(("in_process", "count"), [(False, 15), (True, 50)])
def test_cycles_leave_nothing(fmu, in_process, count):
    assert cycles().growth(process(fmu(), in_process), count) == []
