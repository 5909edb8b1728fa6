"""A body that is moved as a record says: the motion of a free body needs no load, whatever its attitude."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.mechanics import FreeMotion, ImposedMotion, RigidBody, read_motion
from fowtlib.language.errors import ModelError, ParameterError

MOTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
RATES = {"velocity_start": (0.3, -0.2, 0.1), "angle_rates_start": (0.4, -0.3, 0.5)}


def body(mount: fw.Component) -> fw.Assembly:
    root = fw.Assembly("a body")
    root.world, root.mount = World(gravity=1e-3), mount
    root.body = RigidBody(mass=3.0, inertia=np.diag([1.0, 2.0, 2.5]), r_cm=(0.1, 0.0, 0.2))
    return root


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """All six motions of a body that tumbles freely, as a run saves them: m and deg."""
    free = body(FreeMotion(roll_start=0.2, pitch_start=0.3, yaw_start=0.5, **RATES))
    free.connect(free.world.frame, free.mount.frame_a)
    free.connect(free.mount.frame_b, free.body.frame_a)
    outputs = {name: fw.Output(f"mount.{name}", "deg" if i > 2 else None) for i, name in enumerate(MOTIONS)}
    run = fw.Model(free, "tumbling", outputs, {}).compile().simulate(4.0, output_step=0.02, tolerance=1e-10)
    path = tmp_path_factory.mktemp("motions") / "motion.csv"
    run.save(path)
    return path, run


def imposed(path: str, **given: float) -> fw.Plant:
    moved = body(ImposedMotion(file=str(path), **given))
    moved.connect(moved.mount.frame, moved.body.frame_a)
    return fw.load(moved).compile()


def test_a_free_motion_needs_no_load(record):
    """Position and attitude are those of the record, and the convention of its angles is that of FreeMotion.

    Loads of 3 kg and 0.5 m/s^2 would be 1 N; a wrong order of the turns shows at once.
    """
    path, run = record
    plant = imposed(path)
    moved = plant.simulate(4.0, output_step=0.02)
    position = np.column_stack([np.asarray(run[name]) for name in MOTIONS[:3]])
    np.testing.assert_allclose(np.asarray(moved["mount.frame.r"]), position, atol=1e-8)
    for load in ("mount.frame.f", "mount.frame.t"):
        sizes = np.abs(np.asarray(moved[load])).max(axis=1)
        assert sizes[5:-5].max() < 1e-4 and sizes.max() < 0.05, load  # the last samples have no neighbours


def test_a_record_begins_later_and_grows(record):
    path, run = record
    moved = imposed(path, start=1.0, build_up=0.5, r=(0.0, 0.0, 2.0)).simulate(2.0, output_step=0.5)
    heave = np.interp(1.0 + moved.time, run.time, np.asarray(run["heave"]))
    heights = np.asarray(moved["mount.frame.r"])[:, 2]
    assert heights[0] == pytest.approx(2.0, abs=1e-9)
    np.testing.assert_allclose(heights[1:], 2.0 + heave[1:], atol=1e-4)


def test_the_run_stops_at_the_end_of_the_record(record):
    with pytest.raises(ModelError, match=r"the record of motions .*motion.csv ends at 4 s"):
        imposed(record[0]).simulate(5.0)
    with pytest.raises(ModelError, match=r"mount.start: 9 s lies outside of the record, 0 to 4 s"):
        imposed(record[0], start=9.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time [s],surge [m]\n0,0\n1,x\n2,0\n3,0\n", ":3: '1,x' is not a row of numbers under"),
        ("time [s],surgee [m]\n0,0\n", ":1: there is no motion 'surgee'; did you mean 'surge'"),
        ("time [s],surge\n0,0\n", ":1: 'surge' has no unit; write surge \\[m\\]"),
        ("time [s],surge [kg]\n0,0\n", ":1: surge: "),
        ("surge [m]\n0\n", ":1: one column is time"),
        ("time [s],surge [m]\n0,0\n1,0\n3,0\n4,0\n", "which rise by equal steps"),
        ("", "no motions; the first line names the columns"),
    ],
)
def test_files_that_are_no_motions(tmp_path, text, message):
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(ParameterError, match=message):
        read_motion(str(tmp_path / "m.csv"))


def test_a_part_of_the_motions_in_other_units(tmp_path):
    rows = "".join(f"{0.5 * i},{10 * i},{i}\n" for i in range(6))
    (tmp_path / "m.csv").write_text("# towed\ntime [s],surge [mm],pitch [deg]\n" + rows)
    found = read_motion(str(tmp_path / "m.csv"))
    assert found.values[3] == pytest.approx([0.03, 0, 0, 0, np.radians(3), 0])
    assert (found.step, found.end) == (0.5, 2.5)
