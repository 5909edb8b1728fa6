"""The progress of long work on the terminal."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Report = Callable[[float, float], None]


@contextmanager
def progress_bar(begin: float = 0.0) -> Iterator[Report]:
    """A bar on stderr while the block runs; gives `report(t, t_end)`, to be called with the simulated time [s].

    Without a terminal nothing is shown. `begin` is the simulated time at the start of a resumed run.
    """
    from fowtlib.cli.tables import console

    screen = console(stderr=True)
    if not screen.is_terminal:
        yield lambda t, t_end: None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("simulating"),
        BarColumn(),
        TextColumn("{task.completed:.0f} of {task.total:.0f} s"),
        TextColumn("{task.fields[factor]}"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=screen, transient=True)
    with bar:
        task = bar.add_task("", total=None, completed=0.0, factor="", visible=False)
        started = time.perf_counter()

        def report(t: float, t_end: float) -> None:
            elapsed = max(time.perf_counter() - started, 1e-9)
            factor = f"{(t - begin) / elapsed:.0f} x real time" if t > begin else ""
            bar.update(task, completed=t - begin, total=t_end - begin, factor=factor, visible=True)

        yield report


@contextmanager
def part_bar(title: str) -> Iterator[Report]:
    """A bar on stderr while the block runs; gives `report(done, total)`. Without a terminal nothing is shown."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    from fowtlib.cli.tables import console

    screen = console(stderr=True)
    columns = (TextColumn(title), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=screen, disable=not screen.is_terminal, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda done, total: bar.update(task, completed=done, total=total)
