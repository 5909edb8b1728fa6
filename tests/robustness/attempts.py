"""What is done with a damaged input, and how its outcome is told from what the program says."""

from __future__ import annotations

import random
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import model_files
from pool import OK, RAW, REFUSED, Attempt

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
        (folder / "model.yaml").write_bytes(model_files.mutated(text, chance))
        if len(text) > SMALL or ELASTIC.search(text) or chance.random() < 0.4:
            return command("tree", "model.yaml")
        if chance.random() < 0.6:
            return command("check", "model.yaml")
        return command("run", "model.yaml", "--time", "0.2", "--output-step", "0.1")

    return act


KINDS = {"model": _model}
