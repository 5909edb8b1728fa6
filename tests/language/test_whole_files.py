"""Files that are whole or not there."""

from __future__ import annotations

import os

import pytest

from fowtlib.language.whole_files import WriteError, write_text, write_whole


def test_a_failure_leaves_what_was_there(tmp_path):
    path = write_text(tmp_path / "a.txt", "old\n")

    def full(temporary):
        temporary.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(WriteError, match=r"a\.txt: cannot be written: No space left on device\."):
        write_whole(path, full)
    with pytest.raises(ZeroDivisionError):
        write_whole(path, lambda temporary: 1 / 0)
    assert path.read_bytes() == b"old\n" and os.listdir(tmp_path) == ["a.txt"]


def test_a_missing_folder_is_a_sentence(tmp_path):
    with pytest.raises(WriteError, match=r"none/a\.txt: cannot be written: No such file"):
        write_text(tmp_path / "none" / "a.txt", "")


@pytest.mark.skipif(os.name != "posix", reason="links and modes of Unix")
def test_a_link_stays_and_the_mode_is_that_of_any_file(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link.txt").symlink_to(tmp_path / "there" / "file.txt")
    umask = os.umask(0o027)
    try:
        write_text(tmp_path / "link.txt", "ä\n")
    finally:
        os.umask(umask)
    target = tmp_path / "there" / "file.txt"
    assert (tmp_path / "link.txt").is_symlink() and target.read_text(encoding="utf-8") == "ä\n"
    assert target.stat().st_mode & 0o777 == 0o640


def test_the_disk_is_asked_before_the_name_changes(tmp_path, monkeypatch):
    done = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda handle: (done.append("fsync"), fsync(handle)))
    monkeypatch.setattr(os, "replace", lambda *names: (done.append("replace"), replace(*names)))
    write_text(tmp_path / "a.txt", "x")
    assert [step for step in done if step == "fsync"] == ["fsync"] * (2 if os.name == "posix" else 1)
    assert done[0] == "fsync"
