"""A run that goes on from a result computes the same numbers, bit for bit; a journal keeps what a killed run had."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cli import main as fowt
from fowtlib.language import ModelError, Scalar, assign, der, eq, math, param, reinit, sampled, var, when
from fowtlib.solving.checkpoint import last_time
from fowtlib.solving.conditions import Conditions
from fowtlib.solving.results.journal import Journal, NothingKept, journal_of, read_journal, state_of
from fowtlib.solving.results.packing import packed, unpacked

SOLVERS = ({"solver": "idas"}, {"solver": "fixed", "step": 0.01})


class Bouncing(fw.Component):
    """A ball that bounces, a counter that is sampled, and a pendulum of large angle."""

    period: float = param(default=0.25, unit="s", doc="sampling period")

    height: Scalar = var(start=2.0, unit="m", doc="height")
    speed: Scalar = var(start=0.0, unit="m/s", doc="speed")
    angle: Scalar = var(start=2.0, unit="rad", doc="angle")
    rate: Scalar = var(start=0.0, unit="rad/s", doc="rate")
    count: Scalar = var(discrete=True, doc="samples so far")

    def equations(self):
        return [
            eq(der(self.height), self.speed),
            eq(der(self.speed), -9.81 + 0.01 * self.count),
            eq(der(self.angle), self.rate),
            eq(der(self.rate), -9.81 * math.sin(self.angle) - 0.02 * self.rate),
            when(self.height < 0, reinit(self.speed, -0.9 * self.speed)),
            sampled(self.period, assign(self.count, self.count + 1)),
        ]


@pytest.fixture(scope="module")
def plant():
    return fw.load(Bouncing()).compile()


def _same(one: fw.Result, other: fw.Result) -> bool:
    pairs = ((getattr(one.raw, key), getattr(other.raw, key)) for key in ("time", "x", "z", "d"))
    return all(a.shape == b.shape and a.tobytes() == b.tobytes() for a, b in pairs)


@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
@pytest.mark.parametrize("middle", [1.1, 2.5, 2.517])
def test_a_resumed_run_is_the_whole_run_bit_for_bit(plant, tmp_path, options, middle):
    whole = plant.simulate(5.0, output_step=0.05, **options)
    first = plant.simulate(middle, output_step=0.05, **options)
    first.save(tmp_path / "first.nc")
    second = plant.simulate(5.0, output_step=0.05, start=fw.Result.open(tmp_path / "first.nc"), **options)
    joined = first.followed_by(second)
    assert _same(joined, whole)
    assert all(joined.array(name).tobytes() == whole.array(name).tobytes() for name in whole)


@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
def test_an_oscillator_without_events_and_a_run_in_three_parts(tmp_path, options):
    class Pendulum(fw.Component):
        """A pendulum."""

        angle: Scalar = var(start=2.0, unit="rad", doc="angle")
        rate: Scalar = var(start=0.0, unit="rad/s", doc="rate")

        def equations(self):
            return [eq(der(self.angle), self.rate), eq(der(self.rate), -9.81 * math.sin(self.angle))]

    plant = fw.load(Pendulum()).compile()
    whole = plant.simulate(90.0, output_step=0.1, **options)
    result = plant.simulate(13.0, output_step=0.1, **options)
    for end in (47.3, 90.0):
        result = result.followed_by(plant.simulate(end, output_step=0.1, start=result, **options))
    assert _same(result, whole)


@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
def test_a_journal_holds_the_run_up_to_its_last_piece_and_goes_on_exactly(plant, tmp_path, options, monkeypatch):
    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)
    whole = plant.simulate(5.0, output_step=0.05, **options)
    stored = []

    def killed(t: float, t_end: float) -> None:
        if t > 3.0 and not stored:
            path = tmp_path / "run.nc.part"
            stored.append((path.read_bytes(), state_of(path).read_bytes()))

    plant.simulate(5.0, output_step=0.05, journal=Journal(tmp_path / "run.nc"), progress=killed, **options)
    left = tmp_path / "killed.nc.part"
    left.write_bytes(stored[0][0])
    state_of(left).write_bytes(stored[0][1])
    first = fw.Result.open(left)
    assert first.time[-1] >= 2.5
    second = plant.simulate(5.0, output_step=0.05, start=first, **options)
    assert _same(first.followed_by(second), whole)


def test_a_damaged_journal_is_read_up_to_the_damage(plant, tmp_path, monkeypatch):
    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)
    result = plant.simulate(5.0, output_step=0.05, journal=Journal(tmp_path / "run.nc"))
    path, random = tmp_path / "run.nc.part", np.random.default_rng(1)
    data = path.read_bytes()
    for place in random.integers(0, len(data), 300):
        path.write_bytes(data[:place] + bytes([data[place] ^ 0x10]) + data[place + 1 :])
        try:
            read = read_journal(path)
        except ModelError:
            continue
        assert read.raw.x.tobytes() == result.raw.x[: len(read.time)].tobytes()
        assert "damaged" in read.attributes["status"]


def test_a_changed_checkpoint_does_not_resume(plant):
    result = plant.simulate(2.5, output_step=0.05)
    data = result.raw.checkpoint
    object.__setattr__(result.raw, "checkpoint", data[:100] + bytes([data[100] ^ 1]) + data[101:])
    with pytest.raises(ModelError, match="the result to resume from is damaged: of its checkpoint, its checksum"):
        plant.simulate(5.0, output_step=0.05, start=result)


def test_another_solver_goes_on_with_a_new_start_and_says_so(plant):
    result = plant.simulate(2.5, output_step=0.05)
    with pytest.warns(UserWarning, match="a new start of its solver.*tolerance was 1e-06, is 1e-07"):
        later = plant.simulate(3.0, output_step=0.05, start=result, tolerance=1e-7)
    assert later.time[0] == result.time[-1]


def test_a_full_disk_does_not_stop_the_run(plant, tmp_path, monkeypatch):
    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)

    def full(path, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("fowtlib.solving.results.journal.replace_file", full)
    with pytest.warns(UserWarning, match="run.nc.part: cannot be written .No space left on device."):
        result = plant.simulate(1.0, output_step=0.05, journal=Journal(tmp_path / "run.nc"))
    assert result.time[-1] == 1.0


def test_packed_bytes_are_refused_where_one_has_changed():
    data, random = packed({"a": 1}, {"x": np.arange(20.0)}), np.random.default_rng(2)
    text, arrays = unpacked(data)
    assert text == {"a": 1} and np.array_equal(arrays["x"], np.arange(20.0))
    for place in random.integers(0, len(data), 200):
        with pytest.raises(ValueError):
            unpacked(data[:place] + bytes([data[place] ^ 4]) + data[place + 1 :])


def test_a_damaged_result_is_refused_or_unchanged(plant, tmp_path):
    result = plant.simulate(2.0, output_step=0.05)
    path, random = result.save(tmp_path / "run.nc"), np.random.default_rng(3)
    data, refused = path.read_bytes(), 0
    for place in random.integers(0, len(data), 300):
        path.write_bytes(data[:place] + bytes([data[place] ^ 0x08]) + data[place + 1 :])
        try:
            read = fw.Result.open(path)
        except ModelError as error:
            assert "run.nc" in str(error)
            refused += 1
            continue
        assert all(read.array(name).tobytes() == result.array(name).tobytes() for name in result)
        assert _same(read, result)
    assert refused > 150


# --- what a kill leaves ----------------------------------------------------------------------------------------------


LATE = Conditions(discard=4.0)


class Killed(BaseException):
    """Ends a run without anything that follows, as a kill does."""


def _kill(plant, output, at, options, **more):
    """Let a run to `output` end at a time as by a kill, with pieces as short as can be."""

    def stop(t: float, t_end: float) -> None:
        if t >= at:
            raise Killed

    with pytest.raises(Killed):
        plant.simulate(5.0, output_step=0.05, journal=Journal(output), progress=stop, **options, **more)
    return journal_of(output)


@pytest.fixture
def short_pieces(monkeypatch):
    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)


@pytest.mark.usefixtures("short_pieces")
@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
def test_a_run_that_is_killed_again_and_again_loses_nothing_and_stays_exact(plant, tmp_path, options):
    whole = plant.simulate(5.0, output_step=0.05, **options)
    left, reached = _kill(plant, tmp_path / "run.nc", 1.0, options), 0.0
    for at in (0.9, 2.0, 3.2, 3.2, 3.3, 4.9):
        earlier = fw.Result.open(left)
        assert earlier.final.time >= reached
        reached = earlier.final.time
        _kill(plant, tmp_path / "run.nc", at, options, start=earlier)
    earlier = fw.Result.open(left)
    assert reached >= 3.0 and "damaged" not in earlier.attributes["status"]
    assert _same(earlier.followed_by(plant.simulate(5.0, output_step=0.05, start=earlier, **options)), whole)


@pytest.mark.usefixtures("short_pieces")
@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
@pytest.mark.parametrize("end", [0.04, 0.1, 0.7])
def test_a_run_whose_checkpoint_lies_at_its_start_goes_on(tmp_path, options, end):
    plant = fw.load(Bouncing(period=1.5)).compile()
    whole = plant.simulate(2.0, output_step=0.05, **options)
    first = plant.simulate(end, output_step=0.05, **options)
    later = plant.simulate(2.0, output_step=0.05, start=first, journal=Journal(tmp_path / "run.nc"), **options)
    assert _same(first.followed_by(later), whole)


@pytest.mark.usefixtures("short_pieces")
@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
@pytest.mark.parametrize("at", [0.3, 2.6])
def test_a_journal_without_output_points_goes_on_from_its_checkpoint(plant, tmp_path, options, at):
    whole = plant.simulate(5.0, output_step=0.05, conditions=LATE, **options)
    first = fw.Result.open(_kill(plant, tmp_path / "run.nc", at, options, conditions=LATE))
    assert first.time.size == 0 and first.raw.x.shape == (0, 4) and first.final.time >= at - 0.3
    again = fw.Result.open(_kill(plant, tmp_path / "run.nc", 3.5, options, conditions=LATE, start=first))
    assert again.time.size == 0 and again.final.time > 3.0
    later = plant.simulate(5.0, output_step=0.05, conditions=LATE, start=again, **options)
    assert _same(again.followed_by(later), whole)


def test_a_journal_without_anything_says_so(plant, tmp_path):
    left = _kill(plant, tmp_path / "run.nc", 0.0, {})
    with pytest.raises(NothingKept, match=r"run.nc.part: the run stopped before its first results were written"):
        fw.Result.open(left)


@pytest.mark.usefixtures("short_pieces")
@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
@pytest.mark.parametrize("what", ["missing", "damaged", "empty", "of another run"])
def test_without_a_sound_checkpoint_a_run_goes_on_from_its_last_point_and_says_so(plant, tmp_path, options, what):
    whole, left = plant.simulate(5.0, output_step=0.05, **options), _kill(plant, tmp_path / "run.nc", 3.0, options)
    state = state_of(left)
    data = state.read_bytes()
    if what == "missing":
        state.unlink()
    elif what == "of another run":
        state.write_bytes(state_of(_kill(plant, tmp_path / "other.nc", 3.0, options)).read_bytes())
    else:
        state.write_bytes(data[:-40] + bytes([data[-40] ^ 1]) + data[-39:] if what == "damaged" else b"")
    said = {"missing": "cannot be read: No such file", "damaged": "is damaged", "empty": "is damaged"}.get(what, what)
    first = fw.Result.open(left)
    with pytest.warns(UserWarning, match=f"not exactly as it would have: .*holds no checkpoint.*its .*{said}"):
        later = plant.simulate(5.0, output_step=0.05, start=first, **options)
    joined = first.followed_by(later)
    np.testing.assert_allclose(joined.time, whole.time, rtol=1e-12)
    np.testing.assert_allclose(joined.raw.x, whole.raw.x, atol=2e-3)


@pytest.mark.usefixtures("short_pieces")
@pytest.mark.parametrize("options", SOLVERS, ids=("idas", "fixed"))
def test_a_checkpoint_behind_damage_leaves_no_gap(plant, tmp_path, options):
    left = _kill(plant, tmp_path / "run.nc", 1.0, options)
    first = fw.Result.open(left)
    _kill(plant, tmp_path / "run.nc", 4.0, options, start=first)
    data, whole = bytearray(left.read_bytes()), plant.simulate(5.0, output_step=0.05, **options)
    assert fw.Result.open(left).time[-1] > 3.0
    data[-600] ^= 1
    left.write_bytes(data)
    read = fw.Result.open(left)
    assert "damaged" in read.attributes["status"] and read.time[-1] < fw.Result.open(left).final.time + 0.1
    later = plant.simulate(5.0, output_step=0.05, start=read, **options)
    assert later.time[0] == last_time(first.raw.checkpoint)  # it went on there, and the journal holds it
    assert _same(read.followed_by(later), whole)


@pytest.mark.skipif(sys.platform == "win32", reason="no locks that go with a process")
def test_two_runs_do_not_write_one_journal(tmp_path):
    """While a run goes on, another one to its file is refused; a run that has ended or was killed leaves it free."""
    first, path = Journal(tmp_path / "run.nc"), tmp_path / "run.nc"
    first.begin({"units": {}, "long_names": {}, "attributes": {}, "raw": {}})
    for refused in (Journal(path).require_free, lambda: Journal(path).begin({})):
        with pytest.raises(ModelError, match=r"run\.nc\.part: a run to this file is going on in another process"):
            refused()
    assert fowt(["run", "oc3_spar_rigid", "--time", "1", "--output", str(path), "--force"]) == 2
    first.close()
    Journal(path).require_free()
    script = (
        "import sys, os; from pathlib import Path; from fowtlib.solving.results.journal import Journal\n"
        "Journal(Path(sys.argv[1])).begin({}) or os.kill(os.getpid(), 9)"
    )
    assert subprocess.run([sys.executable, "-c", script, str(path)]).returncode == -9
    Journal(path).require_free()
