"""The long attack: `make torture`, or `python tests/robustness/torture.py PART ... [--models N]`.

Writes the tables of docs/reliability.md, between their marks. Inputs that failed are kept in build/torture, each with
what was said; `--again` tries those once more.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import attempts
from pool import FAILURES, Attempt, Outcome, run

ROOT = Path(__file__).parents[2]
KEEP = ROOT / "build" / "torture"


def inputs(name: str, source: Iterable[Attempt], workers: int) -> list[Outcome]:
    """Try the inputs, tell how it goes, and give all outcomes."""
    outcomes, started = [], time.monotonic()
    for outcome in run(source, workers, KEEP):
        outcomes.append(outcome)
        if outcome.kind in FAILURES:
            last = [line for line in outcome.words.strip().splitlines() if line.strip()] or [""]
            print(f"{outcome.kind}: {outcome.name}: {last[-1][:200]}", flush=True)
        if len(outcomes) % 500 == 0:
            print(f"{name}: {len(outcomes)} after {time.monotonic() - started:.0f} s", flush=True)
    counts = Counter(outcome.kind for outcome in outcomes)
    print(f"{name}: {dict(counts)}; longest {max(o.seconds for o in outcomes):.2f} s, "
          f"most {max(o.memory for o in outcomes) / 1e6:.0f} MB", flush=True)  # fmt: skip
    return outcomes


def again(workers: int) -> list[Outcome]:
    """Make the inputs that failed anew from their names, and try them; those that pass are forgotten."""
    kept = {folder.name: folder for kind in FAILURES for folder in (KEEP / kind.replace(" ", "_")).glob("*")}
    outcomes = inputs("again", map(attempts.named, sorted(kept)), workers)
    for outcome in outcomes:
        if outcome.kind not in FAILURES:
            shutil.rmtree(kept[outcome.name])
    return outcomes


def main() -> int:
    """Attack, and say what was found; status 1 where something failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--again", action="store_true", help="only the inputs that failed before")
    given = parser.parse_args()
    warm()
    if given.again:
        return int(any(outcome.kind in FAILURES for outcome in again(given.workers)))
    outcomes = inputs("model files", attempts.model_attempts(given.models, given.seed), given.workers)
    return int(any(outcome.kind in FAILURES for outcome in outcomes))


def warm() -> None:
    """Import and do once what every attempt needs."""
    import contextlib
    import io

    from fowtlib.cli import main as fowt

    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
        warnings.catch_warnings(),
    ):
        fowt(["check", "oc3_spar_rigid"])
        fowt(["tree", "oc3_spar"])


if __name__ == "__main__":
    sys.exit(main())
