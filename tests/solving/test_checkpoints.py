"""A run that goes on from a result computes the same numbers, bit for bit; a journal keeps what a killed run had."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import ModelError, Scalar, assign, der, eq, math, param, reinit, sampled, var, when
from fowtlib.solving.results.journal import Journal, read_journal, state_of
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


def test_a_damaged_checkpoint_beside_a_journal_is_named(plant, tmp_path, monkeypatch):
    monkeypatch.setattr("fowtlib.solving.run.PIECE", 0.0)
    plant.simulate(5.0, output_step=0.05, journal=Journal(tmp_path / "run.nc"))
    path = tmp_path / "run.nc.part"
    good, data = read_journal(path), state_of(path).read_bytes()
    assert good.raw.checkpoint == data
    for damaged in (data[:-1], data[:50] + bytes([data[50] ^ 8]) + data[51:], b""):
        state_of(path).write_bytes(damaged)
        with pytest.warns(UserWarning, match="run.nc.part.state: the checkpoint is damaged; a run that goes on starts"):
            read = read_journal(path)
        assert read.raw.checkpoint == b"" and read.raw.x.tobytes() == good.raw.x.tobytes()
