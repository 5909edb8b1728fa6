"""The long attack: `make torture`, or `python tests/robustness/torture.py [--only PART ...] [--models N] ...`.

Writes the tables of docs/reliability.md, between their marks. Inputs that failed are kept in build/torture, each with
what was said; `--again` tries those once more. Status 1 where something failed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import shutil
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import attempts
import long_checks
from pool import CHANGED, CRASH, FAILURES, HANG, MEMORY, OK, OTHER, RAW, REFUSED, Attempt, Outcome, run

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "reliability.md"
KEEP = ROOT / "build" / "torture"
NUMBERS = {
    "models": 10_000,
    "data": 5_000,
    "kills": 50,
    "full": 20,
    "cold": 50,
    "plants": 500,
    "seconds": 1e5,
    "threads": 10,
    "cycles": 1000,
}
CHECKS = {
    "kills": lambda given: long_checks.kills(given.kills, given.seed),
    "full": lambda given: long_checks.disk_full(given.full, given.seed),
    "cold": lambda given: long_checks.cold_cache(given.cold),
    "plants": lambda given: long_checks.plants(given.plants),
    "seconds": lambda given: long_checks.long_run(given.seconds),
    "threads": lambda given: long_checks.threads(given.threads),
    "cycles": lambda given: long_checks.cycles(given.cycles),
}


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
    print(f"{name}: {dict(Counter(outcome.kind for outcome in outcomes))}", flush=True)
    return outcomes


def again(workers: int) -> list[Outcome]:
    """Make the inputs that failed anew from their names, and try them; those that pass are forgotten."""
    kept = {folder.name: folder for kind in FAILURES for folder in (KEEP / kind.replace(" ", "_")).glob("*")}
    outcomes = inputs("again", map(attempts.named, sorted(kept)), workers)
    for outcome in outcomes:
        if outcome.kind not in FAILURES:
            shutil.rmtree(kept[outcome.name])
    return outcomes


def inputs_row(name: str, outcomes: list[Outcome]) -> tuple[object, ...]:
    """A row of the table of inputs."""
    counts = Counter(outcome.kind for outcome in outcomes)
    longest, most = (max((getattr(o, key) for o in outcomes), default=0) for key in ("seconds", "memory"))
    kinds = (OK, OTHER, REFUSED, RAW, HANG, MEMORY, CRASH, CHANGED)
    return (name, len(outcomes), *(counts[kind] for kind in kinds), f"{longest:.1f} s", f"{most / 1e6:.0f} MB")


def main() -> int:
    """Attack, and write down what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, number in NUMBERS.items():
        parser.add_argument(f"--{name}", type=type(number), default=number, help=f"0: none; default {number:g}")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", nargs="+", choices=NUMBERS, help="only these parts")
    parser.add_argument("--again", action="store_true", help="only the inputs that failed before")
    parser.add_argument("--no-page", action="store_true", help="do not write docs/reliability.md")
    given = parser.parse_args()
    wanted = [name for name in given.only or NUMBERS if getattr(given, name)]
    checks = [] if given.again else [_told(CHECKS[name](given)) for name in CHECKS if name in wanted]
    if given.again or {"models", "data"} & set(wanted):
        warm()  # after the checks that measure how this process grows
    if given.again:
        return int(any(outcome.kind in FAILURES for outcome in again(given.workers)))
    tried: dict[str, list[Outcome]] = {}
    if "models" in wanted:
        tried["mutated model files"] = inputs(
            "models", attempts.model_attempts(given.models, given.seed), given.workers
        )
    if "data" in wanted:
        tried["damaged data files"] = inputs("data", attempts.data_attempts(given.data, given.seed), given.workers)
    if not given.no_page:
        write_page(tried, checks)
    failed = any(outcome.kind in FAILURES for outcomes in tried.values() for outcome in outcomes)
    return int(failed or not all(check.good for check in checks))


def _told(row: long_checks.Row) -> long_checks.Row:
    print(f"{row.what}: {row.found}{'' if row.good else '  <- not good'}", flush=True)
    return row


def write_page(tried: dict[str, list[Outcome]], checks: list[long_checks.Row]) -> None:
    """Put the tables into the page, those that were made."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    from pages import fill, markdown

    page = PAGE.read_text(encoding="utf-8")
    if tried:
        heads = ("", "inputs", "read", "other numbers", "refused", "raw error", "hang", "over 1 GB", "crash",
                 "changed in silence", "longest", "most memory")  # fmt: skip
        page = fill(page, "inputs", markdown((heads, [inputs_row(*item) for item in tried.items()])))
    if checks:
        rows = []
        for check in checks:
            found = check.found.replace("|", "/").replace("\n", " ")
            rows.append((check.what, check.times, found, "yes" if check.good else "no"))
        page = fill(page, "long checks", markdown((("", "times", "found", "good"), rows)))
    PAGE.write_text(page, encoding="utf-8")


def warm() -> None:
    """Import and do once what every attempt needs."""
    from fowtlib.cli import main as fowt

    silent = io.StringIO()
    with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent), warnings.catch_warnings():
        fowt(["check", "oc3_spar_rigid"])
        fowt(["tree", "oc3_spar"])


if __name__ == "__main__":
    sys.exit(main())
