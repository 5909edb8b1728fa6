"""What is kept on disk: the same parts find it, any other part does not, and a damaged file is made again."""

import numpy as np
import pytest

from fowtlib.language.cache import cached, sources


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path))
    return tmp_path


class Maker:
    """Counts how often it is asked; its numbers have all their digits."""

    def __init__(self):
        self.calls = 0

    def __call__(self):
        self.calls += 1
        return {"numbers": np.array([0.1, 1 / 3, 1e-300, -0.0]), "text": "§", "many": [1, None]}


def test_the_same_parts_are_made_once_with_all_digits(folder):
    make = Maker()
    first, second = (cached("thing", ["a", np.arange(3.0)], make) for _ in range(2))
    assert make.calls == 1
    assert first == second == {"numbers": [0.1, 1 / 3, 1e-300, -0.0], "text": "§", "many": [1, None]}
    assert [file.name[:6] for file in folder.iterdir()] == ["thing_"]


@pytest.mark.parametrize(
    "parts",
    [
        ["a", "bd", np.arange(6.0)],
        ["ab", "c", np.arange(6.0)],  # the same letters, parted elsewhere
        ["a", "bc", np.arange(6.0) + 1e-15],
        ["a", "bc", np.arange(6.0).reshape(2, 3)],
        ["a", "bc", np.arange(6)],
        ["a", "bc"],
    ],
)
def test_any_other_part_is_made_anew(folder, parts):
    make = Maker()
    cached("thing", ["a", "bc", np.arange(6.0)], make)
    cached("thing", parts, make)
    cached("other", ["a", "bc", np.arange(6.0)], make)
    assert make.calls == 3


@pytest.mark.parametrize(
    "damage", [lambda t: t[: len(t) // 2], lambda t: t.replace("0.1", "0.2"), lambda t: "", lambda t: "\n"]
)
def test_a_damaged_file_is_made_again(folder, damage):
    make = Maker()
    whole = cached("thing", ["a"], make)
    (file,) = folder.iterdir()
    file.write_text(damage(file.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.warns(UserWarning, match="this file is (damaged|empty); it is made again"):
        assert cached("thing", ["a"], make) == whole
    assert cached("thing", ["a"], make) == whole
    assert make.calls == 2


def test_bytes_that_are_no_text_are_damage(folder):
    make = Maker()
    cached("thing", ["a"], make)
    (file,) = folder.iterdir()
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.warns(UserWarning, match="this file is damaged; it is made again"):
        cached("thing", ["a"], make)
    assert make.calls == 2


def test_where_nothing_can_be_written_nothing_is_kept(tmp_path, monkeypatch):
    file = tmp_path / "file"
    file.write_text("no folder")
    monkeypatch.setenv("FOWTLIB_CACHE", str(file))
    make = Maker()
    assert cached("thing", ["a"], make) == cached("thing", ["a"], make)
    assert make.calls == 2


def test_only_arrays_of_numbers_are_parts(folder):
    with pytest.raises(TypeError, match="an array of numbers is expected"):
        cached("thing", [np.array([None])], Maker())


def test_sources_are_the_texts_of_modules_and_the_versions_of_packages():
    text, *versions = sources("fowtlib.language.cache")
    assert "def sources(" in text
    assert np.__version__ in versions
