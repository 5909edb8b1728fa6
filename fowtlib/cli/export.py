"""`fowt export`: a model as a Functional Mock-up Unit."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from fowtlib.cli import loading
from fowtlib.cli.files import check_target, in_place_of
from fowtlib.cli.run import positive
from fowtlib.cli.weather import weather

EXAMPLES = """An FMU holds the model, its start values, the sources and a compiled library.
Its parameters can be set by whoever runs it: a new length or gain needs no new
export. The wind, the waves and --set are those of this command; --wind input,
--waves input and --input leave them, or a controller, to the importer.

examples:
  fowt export oc3_spar_rigid
  fowt export oc3_spar --fmi 2 --kind cs --wind steady:8 -o spar.fmu
  fowt export oc3_spar --platforms linux64,win64
  fowt export oc3_spar --wind input:8 --waves input \\
      --input turbine.blade_pitch --input turbine.generator_torque
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    parser = commands.add_parser("export", help="write a model as an FMU for other programs", epilog=EXAMPLES)
    loading.declare(parser)
    parser.add_argument(
        "--input", dest="inputs", metavar="PATH", action="append", default=[],
        help="a signal that the importer gives, such as turbine.blade_pitch; may be repeated",
    )  # fmt: skip
    parser.add_argument("--fmi", default="3", metavar="VERSION", help="2 (FMI 2.0) or 3 (FMI 3.0); default: 3")
    parser.add_argument(
        "--kind", default="both", metavar="KIND",
        help="me: the importer integrates; cs: the fixed-step solver inside; default: both",
    )  # fmt: skip
    parser.add_argument(
        "--platforms", metavar="NAMES", help="linux64,win64,darwin,linux-arm64; default: this machine's"
    )
    parser.add_argument("--step", metavar="T", help="cs: step of the solver [s], or 12.5ms")
    parser.add_argument("--tolerance", type=positive, metavar="RTOL", help="cs: of the solver, relative")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="the archive, .fmu; default: MODEL.fmu")
    parser.set_defaults(action=run)


def run(arguments: argparse.Namespace) -> int:
    """Compile the model, write the archive, and say how large it is."""
    from fowtlib.cli.tables import console
    from fowtlib.fmi import export_fmu
    from fowtlib.fmi.export import default_archive

    check_target(arguments.output, (".fmu",), arguments.force)
    platforms = arguments.platforms.split(",") if arguments.platforms is not None else None
    screen = console(stderr=True)
    with screen.status("model") as status:
        model = loading.load(arguments)
        plant = model.compile(arguments.inputs)
        before = "" if arguments.output else in_place_of(default_archive(plant))
        path = export_fmu(
            plant, arguments.output, fmi=arguments.fmi, kind=arguments.kind, platforms=platforms, step=arguments.step,
            tolerance=arguments.tolerance, progress=status.update,
        )  # fmt: skip
    if conditions := weather(model, arguments):
        print(conditions)
    print(f"saved {path}{before}", file=sys.stderr)
    return 0
