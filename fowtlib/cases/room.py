"""How many processes a computer has cores and memory for."""

from __future__ import annotations

import os
import sys
from pathlib import Path

MEMORY = 600 * 2**20  # bytes of a worker
_GROUP = Path("/sys/fs/cgroup")


def workers_that_fit() -> int:
    """As many as there are cores for this process, and memory that is free: 600 MB each. At least one."""
    memory = free_memory()
    by_memory = cores() if memory is None else int(memory // MEMORY)
    return max(1, min(cores(), by_memory))


def cores() -> int:
    """Cores that this process may use: by the system, and by the limit of a container."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    quota, _, period = _words(_GROUP / "cpu.max").partition(" ")
    if quota.isdigit() and period.isdigit() and int(period):
        count = min(count, -(-int(quota) // int(period)))
    return max(1, count)


def free_memory() -> int | None:
    """Bytes that could be used now: by the system, and by the limit of a container; None where nobody says."""
    if sys.platform != "linux":
        return None
    found = []
    for line in _words(Path("/proc/meminfo")).splitlines():
        if line.startswith("MemAvailable:"):
            found.append(int(line.split()[1]) * 1024)
    limit, used = _words(_GROUP / "memory.max"), _words(_GROUP / "memory.current")
    if limit.isdigit() and used.isdigit():
        found.append(max(0, int(limit) - int(used)))
    return min(found) if found else None


def _words(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""
