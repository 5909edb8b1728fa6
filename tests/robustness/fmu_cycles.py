"""Make and free an FMU again and again: memory, descriptors, maps, threads, processes and files must not grow.

python tests/robustness/fmu_cycles.py FMU [COUNT]      by default 1000 times in processes of their own, and 1000 inside

Linux only. Exit status 1, and a line for each thing that grows.
"""

from __future__ import annotations

import gc
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from fowtlib.components.fmu import FMU
from fowtlib.components.fmu.running import FmuProcess

WARM = 10  # cycles before anything is counted: imports, first use of libraries
MEMORY = 2_000_000  # bytes that the memory may move by; a leak of 20 kB in each of 1000 cycles is ten times that
STEPS = 3


def standing() -> dict[str, int]:
    """What this process has now."""
    gc.collect()
    own = Path("/proc/self")
    memory = int((own / "statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    pid = str(os.getpid())
    return {
        "bytes of memory": memory,
        "descriptors": len(os.listdir(own / "fd")),
        "maps of libraries and files": sum("/" in line for line in (own / "maps").read_text().splitlines()),
        "threads": len(os.listdir(own / "task")),
        "processes": sum(_parent(item) == pid for item in Path("/proc").iterdir() if item.name.isdigit()),
        "temporary files": len(os.listdir(tempfile.gettempdir())),
    }


def _parent(process: Path) -> str:
    try:
        return (process / "stat").read_text().rpartition(")")[2].split()[1]
    except OSError:  # it has ended
        return ""


def cycle(process: FmuProcess) -> None:
    """Unpack, load, step and free one."""
    session = process.start()
    inputs = np.zeros(sum(signal.variable.size for signal in process.inputs))
    for k in range(STEPS):
        session.step(k * process.period, inputs)
    session.close()


def growth(process: FmuProcess, count: int) -> list[str]:
    """A sentence for each thing of which there is more after `count` cycles."""
    usual = tempfile.tempdir
    with tempfile.TemporaryDirectory() as folder:
        tempfile.tempdir = folder  # other programs may be at work in the usual one
        try:
            for _ in range(WARM):
                cycle(process)
            before = standing()
            for _ in range(count):
                cycle(process)
            after = standing()
        finally:
            tempfile.tempdir = usual
    allowed = {"bytes of memory": MEMORY}
    return [
        f"{name}: {before[name]} before {count} cycles, {after[name]} after them"
        for name in before
        if after[name] - before[name] > allowed.get(name, 0)
    ]


def both(path: Path, count: int) -> dict[str, list[str]]:
    """What has grown after `count` cycles in processes of their own, and after `count` in this process."""
    found = {}
    for where, in_process in (("in processes of their own", False), ("in this process", True)):
        unit = FMU(file=str(path))
        process = FmuProcess(
            unit._archive, unit._description, unit._content, unit._inputs, unit._outputs, unit._start, unit._step,
            in_process=in_process,
        )  # fmt: skip
        found[where] = growth(process, count)
    return found


def main(arguments: list[str] | None = None) -> int:
    """See above."""
    given = sys.argv[1:] if arguments is None else arguments
    if not 1 <= len(given) <= 2:
        sys.exit(__doc__)
    count = int(given[1]) if len(given) == 2 else 1000
    found = both(Path(given[0]), count)
    for where, lines in found.items():
        print(f"{count} cycles {where}: {'; '.join(lines) or 'nothing has grown'}")
    return int(any(found.values()))


if __name__ == "__main__":
    sys.exit(main())
