"""What is done with a damaged input, and how its outcome is told from what the program says."""

from __future__ import annotations

import random
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import data_files
import model_files
from pool import CHANGED, MEMORY, OK, OTHER, RAW, REFUSED, Attempt

from fowtlib.language.errors import ModelError

SMALL = 6000  # letters of a model that is checked or run, not only loaded
ELASTIC = re.compile(r"Flexible|nrel5mw\b|Arm\b|towers/")  # parts with so many equations that a check takes its time


def command(*words: str) -> tuple[str, str]:
    """Kind and words of one command of `fowt`, by its exit status."""
    from fowtlib.cli import main

    try:
        status = main([*words, "--traceback"])
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 1
    sys.stdout.flush()
    sys.stderr.flush()
    sys.stderr.seek(0)
    said = sys.stderr.read()
    if "more memory than there is" in said:
        return MEMORY, said
    if status == 3:
        return RAW, said
    if status == 2 and len(said.strip()) < 12:
        return RAW, f"refused without a sentence: {said!r}"
    return (OK if status in (0, 1) else REFUSED), said


def model_attempts(count: int, seed: int = 1) -> Iterator[Attempt]:
    """Mutated model files: all are loaded; small ones are checked, or run for a moment, besides."""
    return (named(f"model_{seed}_{number}") for number in range(count))


def named(name: str) -> Attempt:
    """The attempt of this name, kind_seed_number, which decides all about it."""
    kind, seed, number = name.split("_")
    return Attempt(name, KINDS[kind](random.Random(f"{kind} {seed} {number}")))


@cache
def _models() -> list[str]:
    return [text for _, text in sorted(model_files.seeds().items())]


def _model(chance: random.Random) -> Callable[[Path], tuple[str, str]]:
    def act(folder: Path) -> tuple[str, str]:
        text = chance.choice(_models())
        try:
            content = model_files.mutated(text, chance)
        except MemoryError:  # of the mutator itself
            content = text.encode()[: chance.randrange(len(text))]
        (folder / "model.yaml").write_bytes(content)
        if len(text) > SMALL or ELASTIC.search(text) or chance.random() < 0.4:
            return command("tree", "model.yaml")
        if chance.random() < 0.6:
            return command("check", "model.yaml")
        return command("run", "model.yaml", "--time", "0.2", "--output-step", "0.1")

    return act


def _data(chance: random.Random) -> Callable[[Path], tuple[str, str]]:
    def act(folder: Path) -> tuple[str, str]:
        kind = chance.choice(data_files.KINDS)
        content, known = data_files.good(kind)
        damaged = damage(content, chance)
        path = folder / kind.name
        path.write_bytes(damaged)
        try:
            value = kind.read(path)
        except ModelError as error:
            return (REFUSED if len(str(error)) > 12 else RAW), str(error)
        if data_files.digest(value) == known:
            return OK, "the same numbers"
        return (CHANGED if kind.checked else OTHER), kind.name

    return act


def damage(content: bytes, chance: random.Random) -> bytes:
    """Bytes turned, cut off, or replaced; in a text also cells, lines and columns."""
    if b"\0" in content[:2000] or chance.random() < 0.5:
        if chance.random() < 0.1:
            return content[: chance.randrange(len(content))]
        damaged = model_files.by_bytes(content, chance)
        return damaged if damaged != content else content[:-1]
    lines = content.decode().split("\n")
    at = chance.randrange(len(lines))
    cells = lines[at].replace(",", " , ").split(" ")
    word = chance.choice([*model_files.NUMBERS, *model_files.WORDS])
    kind = chance.randrange(5)
    if kind == 0:
        cells[chance.randrange(len(cells))] = word
        lines[at] = " ".join(cells)
    elif kind == 1:
        lines[at] = word
    elif kind == 2:
        del lines[at : at + chance.choice((1, 1, 5, 1000))]
    elif kind == 3:
        lines[at:at] = [lines[at]] * chance.choice((1, 1, 2000))
    else:
        lines[at], lines[-at] = lines[-at], lines[at]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def data_attempts(count: int, seed: int = 1) -> Iterator[Attempt]:
    """Damaged data, result and FMU files, each read as a model reads it."""
    for kind in data_files.KINDS:
        data_files.good(kind)  # in the parent
    return (named(f"data_{seed}_{number}") for number in range(count))


KINDS = {"model": _model, "data": _data}
