"""What takes long: kills at random times, full disks, two processes on one cold cache, many plants, long runs, threads.

Each check works from outside, on `fowt` or on Python of its own process, and gives a row for docs/reliability.md: what
was done, how often, what was found, and whether that is good.
"""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

MODEL = "oc3_spar_rigid"
FOWT = [sys.executable, "-m", "fowtlib.cli"]
OFTEN = """
import sys
import fowtlib.solving.run
from fowtlib.cli.app import main
fowtlib.solving.run.PIECE = 0.2  # s: pieces small enough for a run of a few seconds
sys.exit(main(sys.argv[1:]))
"""


@dataclass(frozen=True)
class Row:
    """A line of the table."""

    what: str
    times: int
    found: str
    good: bool


def kills(count: int, seed: int = 1, duration: float = 3000.0) -> Row:
    """`fowt run` from a cold or warm cache, ended with SIGKILL at a random time, resumed, killed again, resumed.

    Good: what stands can be read, nothing that stood is lost by the next kill, the resumed run equals the uninterrupted
    one bit for bit and leaves nothing beside its result, and no run after a kill fails, whatever was in the cache.
    """
    chance, faults, early, killed = random.Random(seed), [], 0, 0
    reached: list[float] = []  # the simulated times from which runs went on
    with tempfile.TemporaryDirectory(prefix="kills_") as name:
        folder, cache = Path(name), Path(name) / "cache"
        environment = os.environ | {"FOWTLIB_CACHE": str(cache)}
        takes = []  # s of the clock, from a cold cache and from a warm one
        for name in ("whole.nc", "again.nc"):
            started = time.monotonic()
            _fowt(folder, environment, duration, name)
            takes.append(time.monotonic() - started)
        whole = _rows(folder / "whole.nc")
        number = 0
        while killed < count:
            number += 1
            target, at, long = folder / f"run_{number}.nc", [0.0], takes[1]
            if number % 5 == 1:
                shutil.rmtree(cache, ignore_errors=True)  # so that compilations are hit too
                long = takes[0]
            for _ in range(chance.choice((1, 1, 2, 3))):
                resume = ("--resume", target.name) if _left(target) else ()
                late = chance.random() < 0.6 and long == takes[1]  # so that runs are hit, and not only their beginnings
                seconds = chance.uniform(0.0, 1.0 if late else long)
                killed += _killed(folder, environment, duration, target, resume, seconds, late)
                try:
                    at.append(_reached(target))
                except Exception as error:
                    faults.append(f"run {number}, after its kill: {type(error).__name__} {error}"[:300])
                if at[-1] < at[-2]:
                    faults.append(f"run {number}: it stood at {at[-2]:g} s, and after the next kill at {at[-1]:g} s")
            early += not at[-1]
            reached += [at[-1]] if at[-1] else []
            resume = ("--resume", target.name) if _left(target) else ()
            again = _fowt(folder, environment, duration, target.name, *resume)
            if again.returncode:
                faults.append(f"run {number}: status {again.returncode}, {again.stderr.strip()[:300]}")
            elif not _equal(_rows(target), whole):
                faults.append(f"run {number}: the resumed run differs")
            elif _left(target) != [target]:
                faults.append(f"run {number}: {', '.join(file.name for file in _left(target))} are left")
            for file in folder.glob(f"*run_{number}*"):
                file.unlink() if file.is_file() else shutil.rmtree(file)
    places = f" at {min(reached):g} to {max(reached):g} s of {duration:g} s" if reached else ""
    found = (f"{number} runs: {len(reached)} went on{places}, {early} began anew; "
             f"{len(faults)} faults{_first(faults)}")  # fmt: skip
    return Row("kills (SIGKILL) of runs and compilations, resumed and compared bit for bit", killed, found, not faults)


def _killed(folder: Path, environment: dict[str, str], duration: float, target: Path, more: tuple[str, ...],
            seconds: float, late: bool) -> bool:  # fmt: skip
    """Begin a run and kill it after some seconds of the clock; whether it had not ended by itself.

    late: the seconds count from the first piece that it writes.
    """
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    words = [sys.executable, "-c", OFTEN, *_words(duration, target.name, *more)[len(FOWT) :]]
    before = _written(target)
    process = subprocess.Popen(words, cwd=folder, env=environment, start_new_session=True, **silent)
    while late and process.poll() is None and _written(target) == before:
        time.sleep(0.02)
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
    return process.wait() == -signal.SIGKILL


def _written(target: Path) -> int:
    """When the last checkpoint of a run was written [ns]; 0 without one."""
    state = target.with_name(f"{target.name}.part.state")
    return state.stat().st_mtime_ns if state.exists() else 0


def _left(target: Path) -> list[Path]:
    """What stands of a run: its result, its journal, its checkpoint."""
    return sorted(target.parent.glob(f"{target.name}*"))


def _reached(target: Path) -> float:
    """The time up to which a run that was killed can be read [s]."""
    from fowtlib.solving.results import Result
    from fowtlib.solving.results.journal import NothingKept, journal_of

    found = [file for file in (target, journal_of(target)) if file.exists()]
    try:
        return max((Result.open(file).final.time for file in found), default=0.0)
    except NothingKept:
        return 0.0


def disk_full(count: int, seed: int = 1) -> Row:
    """Runs whose files may not grow beyond a random size: a tmpfs where one can be mounted, else RLIMIT_FSIZE.

    Good: a sentence and no traceback, and what stands is readable or refused with a sentence.
    """
    chance, faults, stopped = random.Random(seed), [], 0
    with tempfile.TemporaryDirectory(prefix="full_") as name:
        folder = Path(name)
        disk = folder / "disk"
        disk.mkdir()
        mounted = False
        for number in range(count):
            size = chance.choice((4, 64, 256, 1024, 4096)) * 1024
            mounted = not subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(disk)],
                                         capture_output=True).returncode  # fmt: skip
            try:
                limit = None if mounted else (lambda most=size: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)))
                run = subprocess.run(_words(60.0, str(disk / f"run_{number}.nc")), cwd=folder, capture_output=True,
                                     text=True, preexec_fn=limit, timeout=300)  # fmt: skip
                stopped += run.returncode != 0
                if run.returncode not in (0, 2) or "Traceback" in run.stderr:
                    faults.append(f"size {size}: status {run.returncode}, {run.stderr.strip()[-160:]}")
                for file in disk.glob("*.nc"):
                    try:
                        _rows(file)
                    except Exception as error:
                        if type(error).__name__ == "ModelError" and run.returncode:
                            continue
                        faults.append(f"size {size}: {type(error).__name__} {error}"[:200])
            finally:
                if mounted:
                    subprocess.run(["umount", str(disk)], check=True)
                for file in disk.glob("*"):
                    file.unlink()
    how = "tmpfs" if mounted else "limit of the size of files"
    return Row(f"runs on a full disk ({how})", count, f"{stopped} stopped by it; {len(faults)} faults{_first(faults)}",
               not faults)  # fmt: skip


def cold_cache(count: int) -> Row:
    """Two processes compile the same model into one empty cache at once. Good: both run, with the same numbers."""
    faults = []
    for number in range(count):
        with tempfile.TemporaryDirectory(prefix="cold_") as name:
            folder = Path(name)
            environment = os.environ | {"FOWTLIB_CACHE": str(folder / "cache")}
            both = [subprocess.Popen(_words(0.5, f"{i}.nc"), cwd=folder, env=environment, text=True,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) for i in (0, 1)]  # fmt: skip
            said = [process.communicate(timeout=300)[1] for process in both]
            if any(process.returncode for process in both):
                faults.append(f"pair {number}: {' '.join(said).strip()[-160:]}")
            elif not _equal(_rows(folder / "0.nc"), _rows(folder / "1.nc")):
                faults.append(f"pair {number}: the results differ")
    return Row("two processes on one cold cache", count, f"{len(faults)} faults{_first(faults)}", not faults)


@contextmanager
def _own_folder() -> Iterator[None]:
    """Temporary files of this process in a folder of its own, so that those of others do not count."""
    with tempfile.TemporaryDirectory(prefix="growth_") as name:
        before, tempfile.tempdir = tempfile.tempdir, name
        try:
            yield
        finally:
            tempfile.tempdir = before


@_own_folder()
def plants(count: int) -> Row:
    """Plants made, run and dropped in one process. Good: memory, descriptors, maps and temporary files do not grow."""
    import gc

    import fowtlib as fw

    def once(number: int) -> None:
        plant = fw.load(MODEL).compile()
        plant.simulate(0.2, 0.1, solver="fixed", step=0.05, parameters={"sea.seed": number % 7 + 1})

    uses = []  # resident memory goes up and down by what the allocator keeps: the first third against the last
    for number in range(count):
        once(number)
        if number >= count // 30 and number % max(1, count // 60) == 0:
            gc.collect()
            uses.append(_use())
    third = max(1, len(uses) // 3)
    before, after = ({key: float(np.median([use[key] for use in part])) for key in uses[0]}
                     for part in (uses[:third], uses[-third:]))  # fmt: skip
    return _growth("plants compiled, run and dropped in one process", count, before, after, 60e6)


@_own_folder()
def long_run(seconds: float) -> Row:
    """One run of `seconds`, with few output points. Good: nothing but its rows grows."""
    import fowtlib as fw

    plant = fw.load(MODEL).compile()
    seen: list[dict[str, float]] = []

    def look(t: float, end: float) -> None:
        if not seen and t > 0.1 * end:
            seen.append(_use())

    result = plant.simulate(seconds, 10.0, solver="fixed", step=0.05, progress=look,
                            parameters={"sea.repetition_period": 4096.0})  # fmt: skip
    rows = 2 * 8 * len(result.time) * (plant.dae.stats.get("states", 60) + 100)
    row = _growth(f"a run of {seconds:g} s ({MODEL}, fixed steps)", 1, seen[0] if seen else _use(), _use(), 60e6 + rows)
    return Row(row.what, 1, f"{result.attributes['wall_time']:.0f} s of wall time; {row.found}", row.good)


def threads(count: int) -> Row:
    """Two plants in two threads, and one plant in two threads, in a process of their own.

    Good: the numbers are those of a run alone, or the run is refused by name.
    """
    faults, refused = [], 0
    for number in range(count):
        run = subprocess.run(
            [sys.executable, "-c", THREADS, str(number % 2)], capture_output=True, text=True, timeout=600
        )
        words = run.stdout.split()
        if run.returncode or not words:
            faults.append(f"status {run.returncode}: {run.stderr.strip()[-200:]}")
        elif "refused" in words:
            refused += 1
        elif words.count("same") != 2:
            faults.append(f"other numbers: {run.stdout.strip()}")
    return Row("two plants, and one plant, in two threads", count,
               f"{refused} refused by name; {len(faults)} faults{_first(faults)}", not faults)  # fmt: skip


THREADS = """
import sys, threading
import numpy as np
import fowtlib as fw
from fowtlib.language.errors import ModelError
one = fw.load("oc3_spar_rigid").compile()
two = one if sys.argv[1] == "1" else fw.load("oc3_spar_rigid").compile()
def run(plant, solver):
    options = {"solver": "fixed", "step": 0.05} if solver else {}
    return plant.simulate(20.0, 0.1, parameters={"wind.mean_speed": 9.0}, **options).raw.x
alone = [run(one, True), run(one, False)]
found = {}
def work(name, plant):
    try:
        same = all(np.array_equal(run(plant, solver), known) for solver, known in ((True, alone[0]), (False, alone[1])))
        found[name] = "same" if same else "differs"
    except ModelError as error:
        found[name] = "refused"
        print(error, file=sys.stderr)
    except BaseException as error:
        found[name] = repr(error).replace(" ", "_")
both = [threading.Thread(target=work, args=item) for item in (("a", one), ("b", two))]
for thread in both: thread.start()
for thread in both: thread.join()
print(*found.values())
"""


def cycles(count: int) -> Row:
    """The FMU of the tests unpacked, loaded, stepped and freed, in processes of its own and as often in this one.

    Good: nothing has grown, see fmu_cycles.py.
    """
    import fmu_cycles

    sys.path.insert(0, str(Path(__file__).parents[1] / "fmu"))
    import controller_fmu

    with tempfile.TemporaryDirectory(prefix="cycles_") as name:
        found = fmu_cycles.both(controller_fmu.make(Path(name) / "controller.fmu"), count)
    words = [f"{where}: {'; '.join(lines) or 'nothing has grown'}" for where, lines in found.items()]
    return Row("an FMU made and freed, each way", count, "; ".join(words), not any(found.values()))


def _words(duration: float, target: str, *more: str) -> list[str]:
    return [
        *FOWT,
        "run",
        MODEL,
        "--time",
        str(duration),
        "--solver",
        "fixed",
        "--step",
        "0.05",
        "--output",
        target,
        *more,
    ]


def _fowt(folder: Path, environment: dict[str, str], duration: float, target: str,
          *more: str) -> subprocess.CompletedProcess[str]:  # fmt: skip
    return subprocess.run(_words(duration, target, *more), cwd=folder, env=environment, capture_output=True, text=True,
                          timeout=600)  # fmt: skip


def _rows(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times and states of a result."""
    from fowtlib.solving.results import Result

    stored = Result.open(path).stored
    return stored.time, np.column_stack([np.ravel(values) if np.ndim(values) == 1 else values[:, 0]
                                         for values in stored.values.values()])  # fmt: skip


def _equal(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def _use() -> dict[str, float]:
    """Resident memory [bytes], open descriptors, mapped files, files in the temporary folder."""
    status = Path("/proc/self/statm").read_text().split()
    maps = {line.split()[-1] for line in Path("/proc/self/maps").read_text().splitlines() if "/" in line}
    return {
        "memory": int(status[1]) * resource.getpagesize(),
        "descriptors": len(os.listdir("/proc/self/fd")),
        "maps": len(maps),
        "temporary files": len(os.listdir(tempfile.gettempdir())),
    }


def _growth(what: str, times: int, before: dict[str, float], after: dict[str, float], memory: float) -> Row:
    more = {key: after[key] - before[key] for key in before}
    good = more["memory"] <= memory and all(more[key] <= 2 for key in ("descriptors", "maps", "temporary files"))
    words = [f"{more['memory'] / 1e6:+.0f} MB", *(f"{more[key]:+.0f} {key}" for key in list(more)[1:])]
    return Row(what, times, ", ".join(words), good)


def _first(faults: list[str]) -> str:
    return f" (the first: {faults[0]})" if faults else ""
