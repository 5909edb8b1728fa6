"""`fowt hydro`: from the hull of a model, or a mesh, to its hydrodynamic database; and what is in one."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.progress import part_bar
from fowtlib.cli.run import finite, numbers, positive
from fowtlib.language.errors import ModelError, NotFoundError, did_you_mean

if TYPE_CHECKING:
    from fowtlib.components.hydro import HydrodynamicDatabase
    from fowtlib.components.hydro.hull_mesh import HullMesh

OMEGA, HEADINGS, SIZE = "0.1:2.5:0.1", "-180:180:30", "2"
DEPTH, DENSITY, GRAVITY = math.inf, 1025.0, 9.80665  # where no model says it
SOLVING = ("omega", "headings", "size")  # what the panel method takes, with the defaults above
WAMIT = (".1", ".3", ".hst")
TARGETS = (".nc", *WAMIT, ".gdf")
MOST_PANELS = 50_000  # the matrix of so many takes 40 GB
COLUMNS = (
    "limit", "omega [rad/s]", "A11 [kg]", "A33 [kg]", "A55 [kg m^2]", "B11 [N s/m]", "B33 [N s/m]", "B55 [N m s]",
    "|X1| [N/m]", "|X3| [N/m]", "|X5| [N m/m]",
)  # fmt: skip
STUDY = (
    "panels [m]", "number", "time [s]", "A11 [%]", "A33 [%]", "A55 [%]", "B11 [%]", "B33 [%]", "B55 [%]", "X1 [%]",
    "X3 [%]", "X5 [%]",
)  # fmt: skip

EXAMPLES = r"""Added mass, radiation damping and wave loads of the hull by the panel method
(Capytaine, pip install "fowtlib[hydro]"); each frequency is kept and is not
computed again (`fowt cache`). MODEL is a model, or one of these files:
  HULL.gdf  a mesh of panels, as WAMIT and HAMS read it
  HULL.nc   a database: it is shown, or written as another kind of file
  HULL.1    output of WAMIT, with HULL.3 and HULL.hst beside it: the same

Several panel sizes are a study of the mesh: the largest difference of each
coefficient from that of the finest, over all frequencies, in percent of its
largest value. --output HULL.1 writes HULL.1, HULL.3 and HULL.hst.

--shapes 12 lets a floater of members bend in the 12 lowest shapes of its
structure; the .nc file is the database of an ElasticFloater. Beams are at most
--longest long (5 m, or as the ElasticFloater has it).

examples:
  fowt hydro oc3_spar --mesh-only
  fowt hydro oc3_spar --output spar.nc --plot spar.png
  fowt hydro oc3_spar --size 4,2,1 --omega 0.4,0.8
  fowt hydro oc3_spar --database --output spar.1
  fowt hydro oc4_semi_unmoored --shapes 6 --size 4 --omega 0.2:2:0.2 \
      --headings 0:180:30 --output oc4_shapes.nc
  fowt hydro hull.gdf --depth 200 --output hull.nc
  fowt hydro semi.1 --volume 13917 --centre 0,0,-13.15 --depth 200 \
      --output semi.nc
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "added mass, damping and wave loads of the hull, by the panel method"
    parser = commands.add_parser("hydro", help=text, epilog=EXAMPLES)
    loading.declare(parser, wind=False, waves=False, runs=False)
    form = "first:last:step"
    parser.add_argument("--omega", type=series, metavar=form, help=f"wave frequencies [rad/s]; {OMEGA}")
    parser.add_argument("--headings", type=series, metavar=form,
                        help=f"headings of the waves [deg]; default: {HEADINGS}")  # fmt: skip
    parser.add_argument("--size", type=sizes, metavar="M[,M...]",
                        help=f"width of the panels [m], several for a study; default: {SIZE}")  # fmt: skip
    parser.add_argument("--depth", type=depth, metavar="M", help="depth of the water [m], or inf; default: the model's")
    parser.add_argument("--density", type=positive, metavar="RHO", help="of the water [kg/m^3]; default: the model's")
    parser.add_argument("--gravity", type=positive, metavar="G", help="[m/s^2]; default: the model's")
    parser.add_argument("--part", metavar="PATH", help="which hull of the model; default: the only one")
    parser.add_argument("--database", action="store_true", help="show the database that the model reads")
    parser.add_argument("--mesh-only", action="store_true", help="check the mesh (leaks, volume), solve nothing")
    parser.add_argument("--leaky", action="store_true", help="take a mesh with small leaks, with a warning")
    parser.add_argument("--no-lid", action="store_true", help="leave the irregular frequencies in")
    parser.add_argument("--shapes", type=count, metavar="N", help="also of N shapes of a floater that bends")
    parser.add_argument("--longest", type=positive, metavar="M", help="with --shapes: longest beam [m]; default: 5")
    parser.add_argument("--volume", type=positive, metavar="M3", help="of WAMIT files: displaced volume [m^3]")
    parser.add_argument("--centre", type=point, metavar="X,Y,Z", help="of WAMIT files: centre of that volume [m]")
    parser.add_argument("--length", type=positive, default=1.0, metavar="M",
                        help="ULEN of WAMIT files, read or written [m]; default: 1")  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, action="append", default=[], metavar="FILE",
                        help="save: .nc, .1 (with .3 and .hst), or the mesh .gdf; may be repeated")  # fmt: skip
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the coefficients: .png, .svg or .pdf")
    tables.declare(parser, output=False)
    parser.set_defaults(action=show_hydro)


def series(text: str) -> list[float]:
    """`0.1:2:0.1`, both ends included, or single values; for argparse."""
    import numpy as np

    values = numbers(text)
    if not len(values) or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0):
        raise argparse.ArgumentTypeError(f"'{text}' is not first:last:step, for example {OMEGA}")
    return [round(value, 12) for value in values.tolist()]


def sizes(text: str) -> list[float]:
    """`2`, or `4,2,1`; for argparse."""
    values = numbers(text).tolist()
    if not values or not all(0 < value < math.inf for value in values):
        raise argparse.ArgumentTypeError(f"'{text}' is not a size of panels in m, or several: 4,2,1")
    return values


def count(text: str) -> int:
    """A number of shapes; for argparse."""
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of shapes, 1 or more")
    return int(text)


def depth(text: str) -> float:
    """A depth above zero, also inf; for argparse."""
    return math.inf if text.lower() in ("inf", "deep") else positive(text)


def point(text: str) -> tuple[float, ...]:
    """`0,0,-13.15`; for argparse."""
    values = tuple(finite(word) for word in text.split(","))
    if len(values) != 3:
        raise argparse.ArgumentTypeError(f"'{text}' is not a point X,Y,Z in m")
    return values


def show_hydro(arguments: argparse.Namespace) -> int:
    """Compute or read a database; print, save and draw it."""
    kind = Path(arguments.model).suffix
    if kind == ".nc" or kind in WAMIT or arguments.database:
        _refuse_solving(arguments, kind)
    for name, (read, text) in zip(SOLVING, ((series, OMEGA), (series, HEADINGS), (sizes, SIZE)), strict=True):
        if getattr(arguments, name) is None:
            setattr(arguments, name, read(text))
    if arguments.longest and not arguments.shapes:
        raise ModelError("--longest goes with --shapes: the beams of a floater that bends.")
    if arguments.shapes:
        if kind in (".nc", ".gdf", *WAMIT):
            raise ModelError(f"{arguments.model}: --shapes needs a model with a floater of members, not a file.")
        from fowtlib.cli.hydro_shapes import show_shapes

        return show_shapes(arguments)
    _check_targets(arguments)
    if kind == ".nc" or kind in WAMIT:
        return _show_database(_read(arguments, kind), arguments)
    if arguments.database and (kind == ".gdf" or arguments.mesh_only):
        raise ModelError("--database shows the database that a model reads, without a mesh; leave it away.")
    if arguments.database:
        return _show_database(_of_model(loading.load(arguments), arguments), arguments)
    mesher, water, volume = _mesh_file(arguments) if kind == ".gdf" else _hull_of_model(arguments)
    chosen = {name: value if getattr(arguments, name) is None else getattr(arguments, name)
              for name, value in water.items()}  # fmt: skip
    if kind != ".gdf":
        _refuse_too_many(arguments, volume)
    if len(arguments.size) > 1 and not arguments.mesh_only:
        return _study(mesher, chosen, arguments)
    hulls = [mesher(size) for size in arguments.size]
    if arguments.no_lid:
        hulls = [hull.without_lid() for hull in hulls]
    if arguments.mesh_only:
        return _show_mesh(hulls, chosen, volume, arguments)
    for name, value in _about(hulls[0], chosen, volume):
        tables.say(arguments, f"{name}: {value}")
    with part_bar("panel method") as report:
        from fowtlib.components.hydro.panel import solve_hull

        database = solve_hull(hulls[0], progress=report, **_options(chosen, arguments))
    _save_meshes(hulls, chosen, arguments)
    return _show_database(database, arguments)


def _refuse_solving(arguments: argparse.Namespace, kind: str) -> None:
    """Refuse options of the panel method where a database is only read."""
    given = [name for name in SOLVING if getattr(arguments, name) is not None]
    given += [name for name in ("no_lid", "leaky") if getattr(arguments, name)]
    if kind not in WAMIT:
        given += [name for name in ("depth", "density", "gravity") if getattr(arguments, name) is not None]
    if given:
        a_file = kind == ".nc" or kind in WAMIT
        what = arguments.model if a_file else "the database that the model reads"
        raise ModelError(
            f"--{given[0].replace('_', '-')}: {what} is shown as it is, and nothing is solved; leave it away, or solve "
            "anew with the model or a mesh (fowt hydro MODEL, without --database)."
        )


def _check_targets(arguments: argparse.Namespace) -> None:
    for path in arguments.output:
        for target in _written(path):
            check_target(target, TARGETS, arguments.force)
    check_target(arguments.plot, FIGURES, arguments.force)
    only = [path for path in arguments.output if path.suffix != ".gdf"]
    several = len(arguments.size) > 1
    if only and (arguments.mesh_only or several):
        why = "--mesh-only solves nothing" if arguments.mesh_only else "a study of the mesh has several results"
        raise ModelError(f"{only[0]}: {why}; leave --output away, or give one --size.")
    if arguments.plot and (arguments.mesh_only or several):
        raise ModelError(f"--plot {arguments.plot}: there is no single database to draw; give one --size.")


def _written(path: Path) -> list[Path]:
    """The files that one `--output` makes."""
    return [path.with_suffix(ending) for ending in WAMIT] if path.suffix in WAMIT else [path]


def _read(arguments: argparse.Namespace, kind: str) -> HydrodynamicDatabase:
    from fowtlib.components.hydro import HydrodynamicDatabase

    if kind == ".nc":
        return HydrodynamicDatabase.read(arguments.model)
    missing = [f"--{name}" for name in ("volume", "centre", "depth") if getattr(arguments, name) is None]
    if missing:
        raise ModelError(f"{arguments.model}: WAMIT files do not have all that a database needs: give "
                         f"{' and '.join(missing)} (of the .out file, or the PtfmVol0 of OpenFAST).")  # fmt: skip
    return HydrodynamicDatabase.from_wamit(
        Path(arguments.model).with_suffix(""), volume=arguments.volume, centre_of_buoyancy=arguments.centre,
        rho=arguments.density or DENSITY, g=arguments.gravity or GRAVITY, water_depth=arguments.depth,
        length=arguments.length,
    )  # fmt: skip


def _of_model(model: Any, arguments: argparse.Namespace) -> HydrodynamicDatabase:
    """The database that a part of the model reads."""
    from fowtlib.components.hydro import LinearPotentialFlow

    found = {part.path: part for part in model.root.walk() if isinstance(part, LinearPotentialFlow)}
    return _choose(found, arguments.part, model, "a part that reads a database (class LinearPotentialFlow)").database


def _hull_of_model(arguments: argparse.Namespace) -> tuple[Callable[[float], HullMesh], dict[str, float], float | None]:
    from fowtlib.components.environment import World
    from fowtlib.components.hydro.model_hulls import hulls

    model = loading.load(arguments)
    what = ("a hull that can be meshed: a Floater, upright columns of class MorisonDrag, or VisualTube of the "
            "material 'hull'")  # fmt: skip
    hull = _choose(hulls(model.root), arguments.part, model, what)
    world = next((part for part in model.root.walk() if isinstance(part, World)), None)
    names = {"depth": "water_depth", "density": "water_density", "gravity": "gravity"}
    water = {name: float(world.parameter_value(of_world)) for name, of_world in names.items()} if world else {}
    return hull.mesh, {"depth": DEPTH, "density": DENSITY, "gravity": GRAVITY} | water, hull.volume


def _refuse_too_many(arguments: argparse.Namespace, volume: float | None) -> None:
    """Refuse a size with which even a sphere of the volume, the body of least surface, would have too many panels."""
    if volume is None:
        return
    surface = (36 * math.pi * volume**2) ** (1 / 3)
    size = min(arguments.size)
    if surface / size**2 > MOST_PANELS:
        raise ModelError(
            f"--size: panels of {size:g} m would be more than {surface / size**2:.2g}, and {MOST_PANELS} is the most; "
            f"take {math.sqrt(surface / MOST_PANELS):.2g} m or more."
        )


def _choose(found: dict[str, Any], path: str | None, model: Any, what: str) -> Any:
    if not found:
        raise ModelError(f"{model.name or 'this model'} has no {what.removeprefix('a ')}.")
    if path is None:
        if len(found) > 1:
            raise ModelError(f"this model has several: choose one with --part, {', '.join(found)}.")
        return next(iter(found.values()))
    if path not in found:
        raise NotFoundError(f"--part: '{path}' is not {what}{did_you_mean(path, found, list_up_to=20)}")
    return found[path]


def _mesh_file(arguments: argparse.Namespace) -> tuple[Callable[[float], HullMesh], dict[str, float], float | None]:
    from fowtlib.components.hydro.gdf_files import read_gdf
    from fowtlib.components.hydro.mesh_mirror import with_mirrored_panels

    if len(arguments.size) > 1:
        raise ModelError(f"{arguments.model}: a mesh in a file has the panels that it has; leave --size away.")
    water = {"depth": DEPTH, "density": DENSITY, "gravity": GRAVITY}

    def mesh(_: float) -> HullMesh:
        return with_mirrored_panels(read_gdf(arguments.model, leaky=arguments.leaky))

    return mesh, water, arguments.volume


def _options(water: dict[str, float], arguments: argparse.Namespace) -> dict[str, Any]:
    return {
        "omega": arguments.omega, "headings": [math.radians(heading) for heading in arguments.headings],
        "water_depth": water["depth"], "rho": water["density"], "g": water["gravity"],
    }  # fmt: skip


def _about(hull: HullMesh, water: dict[str, float], volume: float | None) -> list[tuple[str, str]]:
    """What there is to say of a mesh."""
    from fowtlib.components.hydro.panel_limits import good_up_to, irregular_frequency

    off = f" ({hull.volume / volume - 1:+.2%} of the {volume:.6g} m^3 expected)" if volume else ""
    limit = good_up_to(hull, water["depth"], water["gravity"])
    lowest = irregular_frequency(hull, water["gravity"])
    lid = f"{len(hull.lid)} panels" if len(hull.lid) else "none"
    if math.isfinite(lowest):
        lid += f"; without one irregular frequencies could begin at {lowest:.3g} rad/s"
    tight = "watertight" if hull.watertight else "leaking"
    return [
        ("panels", f"{len(hull.panels)}, at most {hull.widths.max():.3g} m wide, {tight}"),
        ("symmetry", f"{hull.symmetry}; a part of {len(hull.part(hull.panels))} panels is solved"),
        ("lid", lid),
        ("volume", f"{hull.volume:.6g} m^3{off}, its centre at "
                   f"({', '.join(f'{value:.4g}' for value in hull.centre_of_buoyancy + 0.0)}) m"),
        ("waterplane", f"{hull.waterplane_area:.5g} m^2, draft {hull.draft:.4g} m"),
        ("good up to", f"{limit:.3g} rad/s (four panels on a wave)" if math.isfinite(limit) else "any frequency"),
    ]  # fmt: skip


def _show_mesh(hulls: list[HullMesh], water: dict[str, float], volume: float | None, arguments) -> int:
    _save_meshes(hulls, water, arguments)
    if len(hulls) == 1 and not arguments.form:
        tables.show(arguments, ("quantity", "value"), _about(hulls[0], water, volume), hulls[0].name)
        return 0
    from fowtlib.components.hydro.panel_limits import good_up_to

    columns = ("size [m]", "panels", "part", "lid", "symmetry", "volume [m^3]", "centre z [m]", "waterplane [m^2]",
               "draft [m]", "good up to [rad/s]")  # fmt: skip
    rows = [(size, len(hull.panels), len(hull.part(hull.panels)), len(hull.lid), str(hull.symmetry), hull.volume,
             float(hull.centre_of_buoyancy[2]), hull.waterplane_area, hull.draft,
             good_up_to(hull, water["depth"], water["gravity"]))
            for size, hull in zip(arguments.size, hulls, strict=True)]  # fmt: skip
    tables.show(arguments, columns, rows, hulls[0].name)
    return 0


def _save_meshes(hulls: list[HullMesh], water: dict[str, float], arguments: argparse.Namespace) -> None:
    from fowtlib.components.hydro.gdf_files import write_gdf

    for path in (path for path in arguments.output if path.suffix == ".gdf"):
        if len(hulls) > 1:
            raise ModelError(f"{path}: a mesh file takes one mesh; give one --size.")
        write_gdf(hulls[0], path, g=water["gravity"])
        say_saved(path)


def _study(mesher: Callable[[float], HullMesh], water: dict[str, float], arguments: argparse.Namespace) -> int:
    """Print how the coefficients change with the size of the panels."""
    import numpy as np

    from fowtlib.components.hydro.panel import mesh_study

    took: list[float] = []

    def timed(size: float) -> HullMesh:
        took.append(time.process_time())
        hull = mesher(size)
        return hull.without_lid() if arguments.no_lid else hull

    with part_bar("panel method") as report:
        studies = mesh_study(timed, arguments.size, progress=report, **_options(water, arguments))
    took.append(time.process_time())
    finest, rows = studies[-1].database, []
    for k, study in enumerate(studies):
        far = []
        for name, modes in (("A", (0, 2, 4)), ("B", (0, 2, 4)), ("X", (0, 2, 4))):
            own, best = (getattr(data, name) for data in (study.database, finest))
            for mode in modes:
                at = (..., mode, mode) if name != "X" else (..., mode)
                largest = np.abs(best[at]).max()
                far.append(100 * float(np.abs(own[at] - best[at]).max() / largest) if largest else 0.0)
        rows.append((study.size, len(study.hull.panels), round(took[k + 1] - took[k], 1), *far))
    tables.show(arguments, STUDY, rows, "differences from the finest mesh")
    return 0


def _show_database(database: HydrodynamicDatabase, arguments: argparse.Namespace) -> int:
    """Print a database for one heading, save and draw it."""
    import numpy as np

    _save(database, arguments)
    nearest = database.nearest_heading()
    at = math.degrees(database.heading[nearest])
    rows: list[tuple[Any, ...]] = []
    for name, matrix in (("zero", database.A_zero), ("infinite", database.A_inf)):
        if matrix is not None:
            rows.append((name, None, *(float(matrix[i, i]) for i in (0, 2, 4)), *[None] * 6))
    for k, omega in enumerate(database.omega):
        diagonals = [float(M[k, i, i]) for M in (database.A, database.B) for i in (0, 2, 4)]
        loads = [float(abs(database.X[k, nearest, i])) for i in (0, 2, 4)]
        rows.insert(len(rows) - 1, ("", float(omega), *diagonals, *loads))
    deep = f"depth {database.water_depth:g} m" if math.isfinite(database.water_depth) else "deep water"
    degrees = np.degrees(database.heading)
    tables.say(arguments, f"{database.source or 'database'}: volume {database.volume:.6g} m^3, {deep}, "
                          f"{database.heading.size} headings from {degrees[0]:g} to {degrees[-1]:g} deg")  # fmt: skip
    tables.show(arguments, COLUMNS, rows, f"loads for the heading {at:g} deg")
    return 0


def _save(database: HydrodynamicDatabase, arguments: argparse.Namespace) -> None:
    for path in arguments.output:
        if path.suffix in WAMIT:
            say_saved(*database.to_wamit(path.with_suffix(""), length=arguments.length))
            x, y, z = database.centre_of_buoyancy
            tables.say(arguments, f"WAMIT files lack volume {database.volume:.8g} m^3, its centre ({x:.6g}, {y:.6g}, "
                                  f"{z:.6g}) m, depth {database.water_depth:g} m, density {database.rho:g} kg/m^3, "
                                  f"gravity {database.g:g} m/s^2, length scale {arguments.length:g} m")  # fmt: skip
        elif path.suffix == ".nc":
            database.write(path)
            say_saved(path)
    if arguments.plot:
        from fowtlib.view.hydrodynamics import plot_database

        plot_database(database, arguments.plot, title=database.source)
        say_saved(arguments.plot)
