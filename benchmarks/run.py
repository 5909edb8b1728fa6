"""Measure fowtlib: `make bench`, or `python benchmarks/run.py NAME ...` for some of it.

`python benchmarks/run.py --write` puts the table into docs/performance.md. `--former COMMIT`, or a folder with a
checkout, compares this code with a former one instead, in turn; see former.py.

Each measurement runs in a process of its own, so that its peak memory is its own. The table has the goal beside the
measured value; wall-clock times depend on the machine and on what else it does. Beside them stands the time of the
processor: on a machine that does nothing else the two are equal.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from former import ROWS, compare
from pages import fill

PAGE = Path(__file__).parent.parent / "docs" / "performance.md"
Measured = list[tuple[str, str, str]]  # (what, measured, goal)
MEASUREMENTS: dict[str, Callable[[], Measured]] = {}
OC3_CONDITIONS = {
    "wind.kind": "kaimal", "wind.mean_speed": 11.4, "wind.turbulence_class": "B", "wind.seed": 1,
    "sea.spectrum": "jonswap", "sea.significant_wave_height": 6.0, "sea.peak_period": 10.0, "sea.seed": 1,
}  # fmt: skip


def measurement(function: Callable[[], Measured]) -> Callable[[], Measured]:
    """Register a measurement under the name of its function."""
    MEASUREMENTS[function.__name__] = function
    return function


class Stopwatch:
    """Wall-clock time and processor time since it was made, in seconds."""

    def __init__(self):
        self.wall_start, self.cpu_start = time.perf_counter(), time.process_time()

    def read(self) -> tuple[float, float]:
        """Seconds by the clock and of the processor."""
        return time.perf_counter() - self.wall_start, time.process_time() - self.cpu_start

    def text(self, digits: int = 2) -> str:
        """Both, for the table."""
        wall, cpu = self.read()
        return f"{wall:.{digits}f} s ({cpu:.{digits}f} s)"


def peak_memory() -> float:
    """Peak resident memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024 if sys.platform == "linux" else 1024**2)


@measurement
def start() -> Measured:
    """Import of the package, and the shortest command; the best of five."""

    def best(*command: str) -> tuple[float, float]:
        times = []
        for _ in range(5):
            began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            times.append((time.perf_counter() - began, cpu))
        return tuple(min(column) for column in zip(*times, strict=True))

    bare, package = best(sys.executable, "-c", ""), best(sys.executable, "-c", "import fowtlib")
    command = best(str(Path(sys.executable).with_name("fowt")), "--help")
    return [
        ("import fowtlib", f"{package[0] - bare[0]:.2f} s ({package[1] - bare[1]:.2f} s)", "under 0.5 s"),
        ("fowt --help", f"{command[0]:.2f} s ({command[1]:.2f} s)", ""),
    ]


def _flatten(name: str) -> Measured:
    import fowtlib as fw

    watch = Stopwatch()
    model = fw.load(name)
    loaded, watch = watch.text(), Stopwatch()
    plant = model.compile()
    flattened = watch.text()
    return [
        (f"load {name}, with the imports", loaded, ""),
        (f"flatten it: {_size(plant)}", flattened, "under 3 s"),
    ]


def _size(plant) -> str:
    return f"{len(plant.dae.states)} states, {len(plant.dae.algebraics)} algebraic unknowns"


@measurement
def flatten_oc3() -> Measured:
    """From the model file of one turbine to its flat equations."""
    return _flatten("oc3_spar_rigid")


@measurement
def flatten_two_rotors() -> Measured:
    """From the model file of two rotors on one spar to its flat equations."""
    return _flatten("two_rotor_spar_rigid")


def _flatten_network(name: str) -> Measured:
    import networks

    import fowtlib as fw

    model = fw.load(getattr(networks, name)(50_000))
    watch = Stopwatch()
    plant = model.compile()
    took = watch.text(1)
    what = f"flatten a {name.replace('_', ' ')} of {plant.stats['equations']} scalar equations"
    return [(what, took, "under 20 s"), ("its peak memory", f"{peak_memory():.0f} MB", "under 2000 MB")]


@measurement
def flatten_ladder() -> Measured:
    """A generated ladder of resistors and capacitors."""
    return _flatten_network("ladder")


@measurement
def flatten_sheet() -> Measured:
    """A generated sheet of resistors and capacitors, whose nodes have four neighbours."""
    return _flatten_network("sheet")


@measurement
def flatten_drive_train() -> Measured:
    """A generated drive train, with index reduction at every gear."""
    return _flatten_network("drive_train")


@measurement
def simulate_oc3() -> Measured:
    """4000 s of one turbine in turbulent wind and irregular waves: the median of three runs."""
    import fowtlib as fw

    plant = fw.load("oc3_spar_rigid").with_parameters(OC3_CONDITIONS).compile()
    times = []
    for _ in range(3):
        watch = Stopwatch()
        plant.simulate(4000.0, output_step=0.1, solver="idas", tolerance=1e-6)
        times.append(watch.read())
    wall, cpu = (sorted(4000 / took for took in took_both) for took_both in zip(*times, strict=True))
    what = "oc3_spar_rigid, 4000 s, Kaimal and JONSWAP, IDAS 1e-6, median of three"
    return [
        (what, f"{wall[1]:.0f} x real time ({cpu[1]:.0f} x)", "300 x or more"),
        ("slowest and fastest of the three", f"{wall[0]:.0f} and {wall[2]:.0f} ({cpu[0]:.0f} and {cpu[2]:.0f})", ""),
        ("its peak memory", f"{peak_memory():.0f} MB", "under 500 MB"),
    ]


def _turbine(name: str, speed: float, width: float, goals: dict[str, str], runs: dict[str, dict]) -> Measured:
    """Median of three runs of 600 s of complete turbines in full-field turbulence and waves, with each solver."""
    import fowtlib as fw
    from fowtlib.components.environment import generate_field

    measured: Measured = []
    with tempfile.TemporaryDirectory() as folder:
        field = Path(folder) / "field.bts"
        grid = {"columns": round(width / 10) + 1, "rows": 16, "width": width, "height": 150.0}
        generate_field(field, mean_speed=speed, duration=660.0, **grid)
        sea = {"sea.spectrum": "jonswap", "sea.significant_wave_height": 6.0, "sea.peak_period": 10.0, "sea.seed": 1}
        conditions = sea | {"wind.kind": "field", "wind.file": str(field)}
        plant = fw.load(name, set=conditions).compile()
        start = plant.initial_state()
        for label, options in runs.items():
            plant.simulate(1.0, 0.1, start=start, **options)  # compiles
            times = []
            for _ in range(3):
                watch = Stopwatch()
                plant.simulate(600.0, 0.1, start=start, **options)
                times.append(watch.read())
            wall, cpu = (sorted(600 / took for took in both) for both in zip(*times, strict=True))
            what = f"{name}, 600 s, wind field and JONSWAP, {label}, median of three"
            measured.append((what, f"{wall[1]:.0f} x real time ({cpu[1]:.0f} x)", goals[label]))
    measured.append(("its peak memory", f"{peak_memory():.0f} MB", ""))
    return measured


FIXED = {"solver": "fixed", "step": 0.0125}


@measurement
def simulate_flexible() -> Measured:
    """The complete turbine: two tower hinges, six hinges a blade, 17 aerodynamic nodes a blade, one core."""
    runs = {"fixed 12.5 ms": FIXED, "IDAS 1e-4": {"solver": "idas", "tolerance": 1e-4}}
    goals = {"fixed 12.5 ms": "75 x or more", "IDAS 1e-4": "15 x or more"}
    return _turbine("oc3_spar", 11.4, 160.0, goals, runs)


@measurement
def simulate_two_flexible() -> Measured:
    """Two complete turbines on a tower with arms and wires."""
    return _turbine("two_rotor_spar", 12.0, 300.0, {"fixed 12.5 ms": "30 x or more"}, {"fixed 12.5 ms": FIXED})


@measurement
def design_map() -> Measured:
    """1000 points of a map at rest in steady wind, and points of a hull of members with ballast for its draft."""
    import numpy as np

    import fowtlib as fw

    wind = {"wind.kind": "steady", "wind.mean_speed": 11.4, "sea.spectrum": "still"}
    spar, sizes = fw.load("oc3_spar_rigid", set=wind).compile(), fw.load("two_rotor_spar_design").compile()
    yaw = np.linspace(5e7, 2e8, 25)
    over = {"platform.hull.mass": np.linspace(7.3e6, 7.6e6, 40), "platform.mooring.yaw_stiffness": yaw}
    hull = {"diameter": np.linspace(10.0, 12.0, 10), "draft": np.linspace(120.0, 160.0, 10)}
    balanced = {"free": ["ballast"], "targets": {"heave": 0}}
    motions, modes = ["pitch", "heave"], ["pitch", "heave", "period of platform yaw", "mass"]
    rows: Measured = []
    for what, plant, axes, of, options in (
        ("oc3_spar_rigid: pitch and heave", spar, over, motions, {}),
        ("oc3_spar_rigid: with mass and a period", spar, over, modes, {}),
        ("two_rotor_spar_design: pitch, ballast and a period", sizes, hull, ["pitch", "period of heave"], balanced),
    ):
        fw.parameter_map(plant, {path: values[:2] for path, values in axes.items()}, of, **options)
        watch = Stopwatch()
        found = fw.parameter_map(plant, axes, of, **options)
        points = found.feasible.size
        goal = "under 10 s" if points == 1000 else ""
        rows.append((f"map of {points} points, {what}", f"({watch.read()[1]:.1f} s)", goal))
    return rows


@measurement
def response() -> Measured:
    """The response in the frequency domain, all results, on one core: one state, and the 546 of a study of spars."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy is imported
    import numpy as np

    import fowtlib as fw
    from fowtlib.metocean import centre_bins, site

    rows: Measured = []
    for name, winds in (
        ("oc3_spar_rigid", (16.0, 18.0, 20.0, 19.0)),
        ("two_rotor_spar_rigid", (16.0, 18.0, 20.0, 19.0)),
    ):
        plant = fw.load(name).compile()
        texts = []
        for wind, height in ((14.0, 4.0), *((wind, 4.0) for wind in winds), *((19.0, 2.0 + k / 4) for k in range(8))):
            watch = Stopwatch()
            fw.response(plant, parameters={"wind.mean_speed": wind, "sea.significant_wave_height": height})
            texts.append(watch.read())
        groups = texts[:1], texts[1 : 1 + len(winds)], texts[1 + len(winds) :]
        told = [f"{wall:.3f} s ({cpu:.3f} s)" for wall, cpu in (sorted(group)[len(group) // 2] for group in groups)]
        rows += [
            (f"response of {name}, all results, the first state", told[0], ""),
            ("another state in another wind, the median", told[1], ""),
            ("another sea in the same wind, the median", told[2], "0.05 s"),
        ]
    grid = (np.arange(5, 26, 2.0), np.arange(0.5, 25), np.arange(0.5, 30))
    states = centre_bins(site("northern_north_sea").at(119), *grid, jacobian=False)
    plant, watch = fw.load("oc3_spar_rigid").compile(), Stopwatch()
    found = fw.responses(plant, states)
    rows.append((f"responses of oc3_spar_rigid in {len(found)} states, all results", watch.text(1), "under 60 s"))
    rows.append(("its peak memory", f"{peak_memory():.0f} MB", ""))
    return rows


P3_VARIABLES = (
    "hull_diameters", "hull_walls", "tower_diameters", "tower_walls", "chain_diameter", "line_length", "line_distance",
    "ballast", "chain_mass", "stiffener_fraction",
)  # fmt: skip
P3_RESULTS = ("std pitch", "max pitch", "std rotor_speed", "std tower_base_moment", "max upwind_tension",
              "range hull_moment_0")  # fmt: skip


@measurement
def elastic_spar_states() -> Measured:
    """An elastic spar of the DTU 10-MW turbine in operation: one state with all results on one core, also resized."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy is imported
    import fowtlib as fw

    rows: Measured = []
    plant = fw.load("dtu10mw_spar_3_design").compile()
    groups: dict[str, list[tuple[float, float]]] = {}
    sizes = {name: plant.parameter_values()[name] for name in P3_VARIABLES[:6]}
    states = [("first", 13.0, 3.0, 1.0), *(("wind", wind, 3.0, 1.0) for wind in (15.0, 17.0, 19.0, 14.0)),
              *(("sea", 14.0, 3.0 + k / 4, 1.0) for k in range(1, 9)),
              *(("design", 14.0, 3.0, 1 + 1e-3 * k) for k in range(1, 6)),
              *(("its wind", wind, 3.0, 1.005) for wind in (15.0, 17.0, 19.0))]  # fmt: skip
    for what, wind, height, factor in states:
        resized = {name: factor * value for name, value in sizes.items()} if factor != 1 else {}
        watch = Stopwatch()
        fw.response(plant, parameters={"wind.mean_speed": wind, "sea.significant_wave_height": height, **resized})
        groups.setdefault(what, []).append(watch.read())
    for what, text, goal in (
        ("first", "response of dtu10mw_spar_3_design, all results, the first state", ""),
        ("wind", "another state in another wind, the median", "0.05 s"),
        ("sea", "another sea in the same wind, the median", "0.05 s"),
        ("design", "other sizes of hull, tower and lines in the same weather, the median", ""),
        ("its wind", "another wind after that, the median", ""),
    ):
        wall, cpu = sorted(groups[what])[len(groups[what]) // 2]
        rows.append((text, f"{wall:.3f} s ({cpu:.3f} s)", goal))
    return rows


@measurement
def elastic_spar_life() -> Measured:
    """Responses of an elastic spar in 546 states, all results, on one core."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy is imported
    import numpy as np

    import fowtlib as fw

    rows: Measured = []
    plant = fw.load("dtu10mw_spar_1_operating").compile()
    heights, periods = np.linspace(1.0, 9.0, 7), np.linspace(6.0, 14.0, 6)
    grid = [{"wind.mean_speed": 4.0 + 1.6 * w, "sea.significant_wave_height": h, "sea.peak_period": period}
            for w in range(13) for h in heights for period in periods]  # fmt: skip
    watch = Stopwatch()
    found = fw.responses(plant, grid)
    rows.append((f"responses of dtu10mw_spar_1_operating in {len(found)} states", watch.text(1), "under 60 s"))
    return rows


@measurement
def elastic_spar_gradient() -> Measured:
    """Values of some results of the elastic spar, and their gradients by the numbers of its hull, tower and lines."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    import fowtlib as fw
    from fowtlib.frequency import PreparedGradient

    prepared = PreparedGradient(fw.load("dtu10mw_spar_3_operating").compile(), P3_RESULTS, P3_VARIABLES)
    prepared.evaluate()
    times = []
    for function in (prepared.values, prepared.evaluate):
        readings = []
        for k in range(1, 4):
            watch = Stopwatch()
            function(prepared.start * (1 + 1e-4 * k))
            readings.append(watch.read()[1])
        times.append(sorted(readings)[1])
    size = f"{len(P3_RESULTS)} results of dtu10mw_spar_3_operating by {len(prepared.parameters)} variables"
    return [
        (size, f"values ({times[0]:.2f} s), with gradients ({times[1]:.2f} s)", ""),
        ("the ratio", f"{times[1] / times[0]:.1f}", "4 or less"),
    ]


@measurement
def elastic_spar_80_variables() -> Measured:
    """Values of 16 results of the spar for design, and their gradients by 80 variables."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    import spar_gradients

    import fowtlib as fw

    plant = fw.load("dtu10mw_spar_3_design").compile()
    values, both = spar_gradients.measured(plant, 80, spar_gradients.RESULTS)
    what = f"{len(spar_gradients.RESULTS)} results of dtu10mw_spar_3_design by 80 variables"
    return [
        (what, f"values ({values:.2f} s), with gradients ({both:.2f} s)", ""),
        ("the ratio", f"{both / values:.1f}", "4 or less"),
    ]


@measurement
def first_step() -> Measured:
    """From the command line to the first step of the complete turbine: with nothing compiled, and again."""
    rows: Measured = []
    surroundings = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    with tempfile.TemporaryDirectory() as folder:
        command = [str(Path(sys.executable).with_name("fowt")), "run", "oc3_spar", "--start", "file", "--time", "0.1"]
        for what, goal in (("from a cold cache", "under 60 s"), ("from a warm cache", "under 5 s")):
            began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                [*command, "--solver", "fixed", "--output", f"{folder}/{goal[-4:-2].strip()}.nc"],
                check=True, stdout=subprocess.DEVNULL, env=surroundings | {"FOWTLIB_CACHE": folder},
            )  # fmt: skip
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            took = f"{time.perf_counter() - began:.1f} s ({cpu:.1f} s)"
            rows.append((f"fowt run oc3_spar to the first step, {what}", took, goal))
    return rows


@measurement
def fmu() -> Measured:
    """The complete turbine as a co-simulation FMU in fmpy, against the same engine in Python with the same outputs."""
    import fmpy

    import fowtlib as fw

    plant, step, duration, chosen = fw.load("oc3_spar").compile(), 0.0125, 60.0, ["surge", "pitch", "generator_power"]
    own: list[float] = []
    theirs: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "oc3_spar.fmu"
        watch = Stopwatch()
        fw.export_fmu(plant, path, kind="cs")
        rows: Measured = [
            ("export oc3_spar as an FMU", watch.text(1), ""),
            ("the archive", f"{path.stat().st_size / 1e6:.2f} MB", "under 5 MB"),
        ]
        unpacked = fmpy.extract(path, unzipdir=f"{folder}/unpacked")
        description = fmpy.read_model_description(unpacked)
        watch = Stopwatch()
        instance = fmpy.instantiate_fmu(unpacked, description, fmi_type="CoSimulation")
        rows.append(("instantiate it", watch.text(3), "under 2 s"))
        instance.freeInstance()
        for _ in range(4):  # the first ones compile
            watch = Stopwatch()
            plant.simulate(duration, step, solver="fixed", step=step, outputs=chosen)
            own.append(watch.read()[1])
            watch = Stopwatch()
            fmpy.simulate_fmu(unpacked, stop_time=duration, output_interval=step, output=chosen,
                              fmi_type="CoSimulation", model_description=description)  # fmt: skip
            theirs.append(watch.read()[1])
    native, outside = statistics.median(own[1:]), statistics.median(theirs[1:])
    what = "oc3_spar in fmpy, communication every 12.5 ms, processor time, median of three"
    text = f"{duration / outside:.0f} x real time, {100 * native / outside:.0f} % of the speed in Python"
    rows.append((what, text, "80 % or more"))
    return rows


def processor() -> str:
    """Name of the processor, where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def measure(names: list[str]) -> tuple[str, bool]:
    """The table of these measurements, printed while it grows; and whether all of them ended well."""
    well = True
    machine = f"Python {platform.python_version()}, {processor()}"
    lines = [machine, "", "| what | measured (processor time) | goal |", "| --- | --- | --- |"]
    print("\n".join(lines), flush=True)
    for name in names:
        command = [sys.executable, "-W", "ignore", __file__, "--one", name]
        child = subprocess.run(command, stdout=subprocess.PIPE, text=True)
        well &= child.returncode == 0
        rows = json.loads(child.stdout.splitlines()[-1]) if child.returncode == 0 else [(name, "failed", "")]
        lines += [f"| {' | '.join(row)} |" for row in rows]
        print("\n".join(lines[-len(rows) :]), flush=True)
    return "\n".join(lines), well


def main(words: list[str]) -> int:
    """Measure what is named, or everything; with `--write` also put the table into the documentation."""
    if words[:1] == ["--one"]:
        print(json.dumps(MEASUREMENTS[words[1]]()))
        return 0
    write, against = "--write" in words, None
    names = [word for word in words if word != "--write"]
    if "--former" in names:
        place = names.index("--former")
        against = (names[place + 1 : place + 2] or [""])[0]
        del names[place : place + 2]
        if not against:
            print("--former COMMIT or --former FOLDER: which code shall it be compared with?", file=sys.stderr)
            return 2
    known = ROWS if against else MEASUREMENTS
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    if against:
        table, well = compare(against, names or list(known))
    else:
        table, well = measure(names or list(known))
    if write and well:
        PAGE.write_text(fill(PAGE.read_text(), "former" if against else "bench", table))
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
