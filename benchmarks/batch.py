"""What a batch costs beside its runs, and how it scales.

Run: python benchmarks/batch.py [local|cluster] [cases] [seconds]. The same cases by 1, 2, 4 and 8 workers, more than
this computer may have cores: processor time, which does not depend on what else it does. That of the process which
runs the batch, for one case, is what limits the number of workers.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from pathlib import Path

from fowtlib.cases import Case, run_batch

MODEL = "oc3_spar_rigid"


def cases(count: int, duration: float) -> list[Case]:
    """Turbulent winds and irregular seas of several seeds."""
    sea = {"sea.spectrum": "jonswap", "sea.significant_wave_height": 3.0, "sea.peak_period": 10.0}
    return [
        Case(f"s{seed}", MODEL,
             {"wind.kind": "kaimal", "wind.mean_speed": 9.0, "wind.seed": seed, "sea.seed": seed, **sea},
             start="file", duration=duration)
        for seed in range(1, count + 1)
    ]  # fmt: skip


def used(who: int) -> float:
    """Processor time [s] of this process or of those that it has started and that have ended."""
    found = resource.getrusage(who)
    return found.ru_utime + found.ru_stime


def run(where: str, workers: int, count: int, duration: float) -> None:
    """Print one line."""
    before = time.perf_counter(), used(resource.RUSAGE_SELF), used(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as place:
        options = {"workers": workers}
        if where == "cluster":
            from distributed import LocalCluster

            cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None, memory_limit=None)
            options = {"cluster": cluster}
        batch = run_batch(cases(count, duration), Path(place) / "b", **options)
        computing = sum(row.processor or 0.0 for row in batch)
        if where == "cluster":
            cluster.close()
    wall = time.perf_counter() - before[0]
    here = used(resource.RUSAGE_SELF) - before[1]
    there = used(resource.RUSAGE_CHILDREN) - before[2]
    numbers = f"{wall:.1f} | {computing:.1f} | {there:.1f} | {1000 * here / count:.1f}"
    print(f"| {where} | {workers} | {numbers} |", flush=True)


def main() -> None:
    """Print a table."""
    where, count, duration = (sys.argv[1:] + ["local", "40", "300"][len(sys.argv) - 1 :])[:3]
    print("| where | workers | clock [s] | cases [s] | all workers [s] | batch, each case [ms] |")
    print("|---|---|---|---|---|---|")
    for workers in (1, 2, 4, 8):
        run(where, workers, int(count), float(duration))


if __name__ == "__main__":
    main()
