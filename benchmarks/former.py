"""The code of a checkout against a former one: `python benchmarks/run.py --former COMMIT`, or a folder with a checkout.

Each row is run with the former and with the present code in turn, in two processes that wait for each other, by the
time of the processor. The ratio holds on any machine; the times do not. With `--write` the table goes into
docs/performance.md.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

HERE = Path(__file__).parent.parent
TURNS = 3
SEA = {"sea.spectrum": "jonswap", "sea.significant_wave_height": 6.0, "sea.peak_period": 10.0, "sea.seed": 1}
KAIMAL = {"wind.kind": "kaimal", "wind.mean_speed": 11.4, "wind.turbulence_class": "B", "wind.seed": 1}
FIELDS = {"oc3_spar": (11.4, 160.0), "two_rotor_spar": (12.0, 300.0)}  # mean speed [m/s] and width [m]
FIXED, IDAS = {"solver": "fixed", "step": 0.0125}, {"solver": "idas", "tolerance": 1e-4}
Work = Callable[[], None]

# what: its name in the table, simulated seconds, and how much faster than 1 it shall be
ROWS: dict[str, tuple[str, float, float]] = {
    "run": ("oc3_spar, field and JONSWAP, 12.5 ms, without start-up", 600.0, 200 / 98),
    "command": ("oc3_spar, field and JONSWAP, the whole command, warm", 600.0, 130 / 57),
    "two": ("two_rotor_spar, field and JONSWAP, 12.5 ms", 300.0, 60 / 22),
    "idas": ("oc3_spar with IDAS 1e-4, field and JONSWAP", 100.0, 25 / 12.5),
    "rigid": ("oc3_spar_rigid with IDAS 1e-6, Kaimal and JONSWAP", 4000.0, 700 / 520),
    "fmu": ("FMU of oc3_spar in fmpy, 12.5 ms exchange", 60.0, 80 / 33),
}


class _Checkout:
    """Finds fowtlib and all its parts in the folder of a checkout, before any installed one."""

    def __init__(self, folder: Path):
        places = tomllib.loads((folder / "pyproject.toml").read_text())["tool"]["setuptools"]["package-dir"]
        self.places = {name: folder / place for name, place in places.items()} | {"fowtlib": folder / "fowtlib"}

    def find_spec(self, name, path=None, target=None):
        """The spec of a module or package of the checkout."""
        known = [package for package in self.places if name == package or name.startswith(f"{package}.")]
        if not known:
            return None
        package = max(known, key=len)
        place = self.places[package].joinpath(*name[len(package) + 1 :].split("."))
        file, inside = place.with_suffix(".py"), None
        if (place / "__init__.py").is_file():
            file, inside = place / "__init__.py", [str(place)]
        if not file.is_file():
            return None
        return importlib.util.spec_from_file_location(name, file, submodule_search_locations=inside)


def _field(folder: Path, name: str) -> Path:
    """The wind field of a model; both codes run in the same one."""
    path = folder / f"{name}.bts"
    if not path.exists():
        from fowtlib.components.environment import generate_field

        speed, width = FIELDS[name]
        grid = {"columns": round(width / 10) + 1, "rows": 16, "width": width, "height": 150.0}
        generate_field(path, mean_speed=speed, duration=660.0, **grid)
    return path


def _simulation(name: str, conditions: dict, duration: float, options: dict) -> Work:
    import fowtlib as fw

    plant = fw.load(name, set=conditions).compile()
    start = plant.initial_state()
    plant.simulate(1.0, 0.1, start=start, **options)  # compiles
    return lambda: plant.simulate(duration, 0.1, start=start, **options)


def _command(field: Path, duration: float, checkout: Path, folder: Path) -> Work:
    """The command, with the packages of the checkout."""
    words = ["run", "oc3_spar", "--wind", f"field:{field}", "--waves", "jonswap:Hs=6,Tp=10,seed=1", "--solver", "fixed"]
    words += ["--time", str(duration), "--force", "--output", str(folder / f"{os.getpid()}.nc")]
    command = [sys.executable, "-W", "ignore", __file__, "fowt", str(checkout), *words]
    return lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) and None


def _fmu(duration: float, folder: Path) -> Work:
    import fmpy

    import fowtlib as fw

    path = folder / f"{os.getpid()}.fmu"
    fw.export_fmu(fw.load("oc3_spar").compile(), path, kind="cs")
    unpacked = fmpy.extract(path, unzipdir=str(path.with_suffix("")))
    description = fmpy.read_model_description(unpacked)
    return lambda: fmpy.simulate_fmu(
        unpacked, stop_time=duration, output_interval=0.0125, output=["surge", "pitch", "generator_power"],
        fmi_type="CoSimulation", model_description=description,
    )  # fmt: skip


def _work(row: str, checkout: Path, folder: Path) -> Work:
    duration = ROWS[row][1]
    if row == "rigid":
        return _simulation("oc3_spar_rigid", KAIMAL | SEA, duration, IDAS | {"tolerance": 1e-6})
    if row == "fmu":
        return _fmu(duration, folder)
    name = "two_rotor_spar" if row == "two" else "oc3_spar"
    field = _field(folder, name)
    if row == "command":
        return _command(field, duration, checkout, folder)
    conditions = SEA | {"wind.kind": "field", "wind.file": str(field)}
    return _simulation(name, conditions, duration, IDAS if row == "idas" else FIXED)


def _spent() -> float:
    """Processor time of this process and of those that it has waited for [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def serve(row: str, checkout: Path, folder: Path) -> None:
    """Warm up, then do the work of a row whenever a line comes; say the seconds that each took."""
    out, sys.stdout = sys.stdout, sys.stderr
    work = _work(row, checkout, folder)
    work()
    print(_spent(), file=out, flush=True)
    for _ in sys.stdin:
        began = _spent()
        work()
        print(_spent() - began, file=out, flush=True)


class RowFailure(Exception):
    """The work of a row ended before it was done; what it said stands above."""


class _Server:
    """A process that does the work of a row with the code of a checkout."""

    def __init__(self, row: str, checkout: Path, folder: Path):
        command = [sys.executable, "-W", "ignore", __file__, "serve", str(checkout), row, str(folder)]
        threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        env=os.environ | threads)  # fmt: skip

    def warm(self) -> None:
        """Wait until it has done the work for the first time."""
        self._answer()

    def measure(self) -> float:
        """Processor time of the work once more [s]."""
        assert self.process.stdin
        with contextlib.suppress(BrokenPipeError):  # it has ended, and gives no answer
            self.process.stdin.write("\n")
            self.process.stdin.flush()
        return self._answer()

    def _answer(self) -> float:
        assert self.process.stdout
        line = self.process.stdout.readline()
        if not line:
            raise RowFailure
        return float(line)

    def close(self) -> None:
        """Let it end."""
        assert self.process.stdin
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        self.process.wait()


@contextlib.contextmanager
def checkout(former: str) -> Iterator[Path]:
    """The folder of a checkout: as given, or of a commit, in a worktree that is removed again."""
    if (Path(former) / "pyproject.toml").is_file():
        yield Path(former).resolve()
        return
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "former"
        git = ["git", "-C", str(HERE), "worktree"]
        added = subprocess.run([*git, "add", "--detach", str(made), former], capture_output=True, text=True)
        if added.returncode:
            why = added.stderr.strip()
            raise SystemExit(f"--former {former}: neither the folder of a checkout nor a commit: {why}")
        try:
            yield made
        finally:
            subprocess.run([*git, "remove", "--force", str(made)], check=True)


def compare(former: str, rows: list[str]) -> tuple[str, bool]:
    """The table of these rows, printed while it grows; and whether all of them ended well."""
    well = True
    lines = ["| work, one core, processor time | former | now | ratio | asked |", "| --- | --- | --- | --- | --- |"]
    print("\n".join(lines), flush=True)
    with checkout(former) as before, tempfile.TemporaryDirectory() as name:
        for row in rows:
            what, duration, asked = ROWS[row]
            try:
                times = _times(row, before, Path(name))
                ratio = statistics.median(a / b for a, b in zip(*times, strict=True))
                cells = [*(f"{duration / statistics.median(taken):.0f} x" for taken in times), f"{ratio:.2f}"]
            except RowFailure:
                cells, well = ["failed", "", ""], False
            lines.append(f"| {what}, {duration:g} s | {' | '.join(cells)} | {asked:.2f} |")
            print(lines[-1], flush=True)
    return "\n".join(lines), well


def _times(row: str, before: Path, folder: Path) -> list[list[float]]:
    """Seconds of the work of a row with the former and with the present code, TURNS times in turn."""
    with contextlib.ExitStack() as ending:
        servers = []
        for place in (before, HERE):  # one after the other: the first one makes the wind field
            servers.append(_Server(row, place, folder))
            ending.callback(servers[-1].close)
            servers[-1].warm()
        turns = [[server.measure() for server in servers] for _ in range(TURNS)]
    return [list(taken) for taken in zip(*turns, strict=True)]


if __name__ == "__main__":
    task, place = sys.argv[1], Path(sys.argv[2])
    sys.meta_path.insert(0, _Checkout(place))
    if task == "fowt":
        from fowtlib.cli import main

        sys.exit(main(sys.argv[3:]))
    serve(sys.argv[3], place, Path(sys.argv[4]))
