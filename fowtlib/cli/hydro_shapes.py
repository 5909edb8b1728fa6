"""`fowt hydro --shapes`: the flow about a floater of members that bends in the lowest shapes of its structure."""

from __future__ import annotations

import argparse
import math
from typing import Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import check_target, say_saved
from fowtlib.cli.progress import part_bar
from fowtlib.language.errors import ModelError, NotFoundError, did_you_mean

LONGEST = 5.0  # m: of the beams, as an ElasticFloater has it
COLUMNS = ("shape", "dry [Hz]", "in water [Hz]", "modal mass [kg]", "added mass [kg]", "stiffness by water [N/m]")


def show_shapes(arguments: argparse.Namespace) -> int:
    """Compute the database of an ElasticFloater, print its shapes, save it."""
    _refuse(arguments)
    from fowtlib.components.environment import World
    from fowtlib.components.platform import Floater
    from fowtlib.components.platform.elastic_floater import ElasticFloater, modal_database

    model = loading.load(arguments)
    found = {part.path: part for part in model.root.walk() if isinstance(part, Floater)}
    floater = _choose(found, arguments.part, model)
    world = next((part for part in model.root.walk() if isinstance(part, World)), None)
    water = {"depth": math.inf, "density": 1025.0, "gravity": 9.80665}
    if world is not None:
        names = {"depth": "water_depth", "density": "water_density", "gravity": "gravity"}
        water = {name: float(world.parameter_value(of_world)) for name, of_world in names.items()}
    water |= {name: getattr(arguments, name) for name in water if getattr(arguments, name) is not None}
    own = {"longest": arguments.longest or LONGEST}
    if isinstance(floater, ElasticFloater):
        own = {name: float(floater.parameter_value(name)) for name in ("longest", "young_modulus", "shear_modulus")}
        if arguments.longest:
            own["longest"] = arguments.longest
    target = arguments.output[0] if arguments.output else None
    with part_bar("panel method") as report:
        database = modal_database(
            floater, arguments.shapes, omega=arguments.omega, headings=[math.radians(h) for h in arguments.headings],
            panel=arguments.size[0], water_depth=water["depth"], rho=water["density"], g=water["gravity"], path=target,
            progress=report, **own,
        )  # fmt: skip
    if target:
        say_saved(target)
    tables.show(arguments, COLUMNS, _rows(floater, database, own), f"shapes of {floater.path or model.name}")
    return 0


def _refuse(arguments: argparse.Namespace) -> None:
    """What goes with --shapes: a model, one size of panels, one .nc file."""
    given = [name for name in ("database", "mesh_only", "leaky", "no_lid", "plot", "volume", "centre")
             if getattr(arguments, name)]  # fmt: skip
    if given:
        raise ModelError(f"--{given[0].replace('_', '-')} does not go with --shapes; leave one of them away.")
    if len(arguments.size) > 1:
        raise ModelError("--shapes makes one database; give one --size.")
    if len(arguments.output) > 1 or any(path.suffix != ".nc" for path in arguments.output):
        raise ModelError(f"--output {arguments.output[-1]}: shapes are kept in one .nc file.")
    for path in arguments.output:
        check_target(path, (".nc",), arguments.force)


def _choose(found: dict[str, Any], path: str | None, model: Any) -> Any:
    if not found:
        raise ModelError(f"{model.name or 'this model'} has no floater of members (Floater), which --shapes needs.")
    if path is None and len(found) > 1:
        raise ModelError(f"this model has several: choose one with --part, {', '.join(found)}.")
    if path is None:
        return next(iter(found.values()))
    if path not in found:
        raise NotFoundError(f"--part: '{path}' is no floater of members{did_you_mean(path, found, list_up_to=20)}")
    return found[path]


def _rows(floater: Any, database: Any, own: dict[str, float]) -> list[tuple[Any, ...]]:
    """Of each shape: frequencies in air, and in water alone with the added mass at infinite frequency."""
    import numpy as np

    from fowtlib.components.platform.member_frame import MemberFrame

    structure = MemberFrame(floater.hull(), **own).frame
    shapes = database.shapes.reshape(database.count, -1)
    mass, stiffness = (np.einsum("ki,ki->k", shapes, (matrix @ shapes.T).T)
                       for matrix in (structure.mass, structure.stiffness))  # fmt: skip
    added, lifted = np.diag(database.A_inf)[6:], np.diag(database.among)
    dry = np.sqrt(stiffness / mass) / (2 * np.pi)
    wet = np.sqrt(np.maximum(stiffness + lifted, 0.0) / (mass + added)) / (2 * np.pi)
    return [(k + 1, *map(float, row)) for k, row in enumerate(zip(dry, wet, mass, added, lifted, strict=True))]
