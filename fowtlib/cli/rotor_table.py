"""`fowt rotor-table`: coefficients and steady operation of a blade-element rotor."""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.progress import part_bar
from fowtlib.cli.run import numbers
from fowtlib.language.errors import ModelError, NotFoundError, did_you_mean
from fowtlib.language.whole_files import write_text

if TYPE_CHECKING:
    from fowtlib.components.aero import CoefficientTable
    from fowtlib.components.turbine import OperatingPoint, Turbine

RATIOS, PITCHES, WINDS = "1.5:18:0.5", "-5:30:1", "3:25:1"
LEAST_POINTS = 4  # of a grid, for the cubic splines of the rotor that reads the table
COLUMNS = (
    "wind [m/s]", "rotor speed [rpm]", "blade pitch [deg]", "tip speed ratio", "aero power [kW]", "thrust [kN]", "C_p",
    "C_t", "generator torque [N m]",
)  # fmt: skip

EXAMPLES = r"""C_p, C_t and C_q over tip speed ratio and blade pitch, of rigid blades in
uniform wind along the shaft, and the steady operation of the turbine with its
controller. The coefficients are for a CoefficientRotor:
  --set turbine.rotor.coefficients=rotor.csv

examples:
  fowt rotor-table nrel5mw_land --output rotor.csv --plot rotor.png
  fowt rotor-table oc3_spar --winds 8:14:0.5 --curve curve.csv
  fowt rotor-table oc3_spar --winds 3:25:0.5 --slopes slopes.csv
  fowt rotor-table nrel5mw_land --ratios -1:20:0.25 --pitch -5:100:1 \
      --output parked.csv
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "coefficients and steady operation of a blade-element rotor"
    parser = commands.add_parser("rotor-table", help=text, epilog=EXAMPLES)
    loading.declare(parser, wind=False, waves=False, runs=False)
    form = "first:last:step"
    for option, default, what in (
        ("--ratios", RATIOS, "tip speed ratios"),
        ("--pitch", PITCHES, "blade pitch [deg]"),
        ("--winds", WINDS, "wind speeds of the steady operation [m/s]"),
    ):
        parser.add_argument(option, type=grid, default=default, metavar=form, help=f"{what}; default: {default}")
    parser.add_argument("--turbine", metavar="PATH", help="which turbine; default: the first of the model")
    tables.add_output(parser, "output", "save the coefficients: .csv")
    parser.add_argument("--curve", type=Path, metavar="FILE", help="save the steady operation: .csv")
    text = "save the slopes of the loads for an EffectiveWindRotor: .csv"
    parser.add_argument("--slopes", type=Path, metavar="FILE", help=text)
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw both: .png, .svg or .pdf")
    tables.declare(parser, output=False)
    parser.set_defaults(action=show_rotor_table)


def grid(text: str) -> list[float]:
    """`-5:30:1`, both ends included, or single values `3,5,8`; for argparse."""
    import numpy as np

    values = numbers(text)
    if not len(values) or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0):
        raise argparse.ArgumentTypeError(f"'{text}' is not first:last:step, for example {PITCHES}")
    return values.tolist()


def show_rotor_table(arguments: argparse.Namespace) -> int:
    """Compute, save and draw the coefficients; print the steady operation."""
    from fowtlib.components.aero import write_coefficients

    tables_of = (arguments.output, arguments.curve, arguments.slopes)
    for path, endings in (*((path, (".csv",)) for path in tables_of), (arguments.plot, FIGURES)):
        check_target(path, endings, arguments.force)
    _check_grids(arguments)
    turbine = _turbine(loading.load(arguments), arguments.turbine)
    precone = turbine.assembly.hub.parameter_value("precone")
    table = _coefficients(turbine, arguments)
    points = _operation(turbine, table, arguments.winds)
    if arguments.output:
        write_coefficients(arguments.output, table, precone, _about(turbine, arguments.model, precone))
    rows = [_row(point, turbine, table) for point in points]
    if arguments.curve:
        write_text(arguments.curve, tables.csv_text(COLUMNS, ([f"{value:.10g}" for value in row] for row in rows)))
    if arguments.slopes:
        _save_slopes(turbine, arguments, points)
    power = _power(table, precone)
    if arguments.plot:
        from fowtlib.view.rotor import plot_rotor

        plot_rotor(table, power, points, path=arguments.plot, title=arguments.model)
    i, j = divmod(int(power.argmax()), power.shape[1])
    best = f"largest C_p of the table {power[i, j]:.4f}, at tip speed ratio {table.tip_speed_ratio[i]:g} "
    best += f"and {math.degrees(table.blade_pitch[j]):.4g} deg"
    tables.show(arguments, COLUMNS, rows, best)
    say_saved(arguments.output, arguments.curve, arguments.slopes, arguments.plot)
    return 0


def _check_grids(arguments: argparse.Namespace) -> None:
    for option, values in (("--ratios", arguments.ratios), ("--pitch", arguments.pitch)):
        if len(values) < LEAST_POINTS:
            raise ModelError(f"{option}: a table needs {LEAST_POINTS} values or more, and these are {len(values)}.")
    if arguments.winds[0] <= 0:
        raise ModelError(f"--winds: {arguments.winds[0]:g} is not above zero.")
    if arguments.pitch[0] < -180 or arguments.pitch[-1] > 180:
        raise ModelError("--pitch: the angles are in degrees, from -180 to 180.")


def _turbine(model: Any, path: str | None) -> Turbine:
    """The turbine of a model whose rotor has blade elements."""
    from fowtlib.components.turbine import Turbine

    found = {part.path: part for part in model.root.walk() if isinstance(part, Turbine)}
    if not found:
        raise ModelError(
            f"{model.name or 'this model'} has no turbine with a blade-element rotor (class Turbine), whose "
            "coefficients could be computed."
        )
    if path is None:
        if len(found) > 1:
            warnings.warn(f"this is {next(iter(found))}; another one: --turbine, {', '.join(found)}.", stacklevel=1)
        return next(iter(found.values()))
    if path not in found:
        raise NotFoundError(f"--turbine: there is no turbine '{path}'{did_you_mean(path, found, list_up_to=20)}")
    return found[path]


def _coefficients(turbine: Turbine, arguments: argparse.Namespace) -> CoefficientTable:
    from fowtlib.components.aero import coefficient_table

    pitches = [math.radians(angle) for angle in arguments.pitch]
    precone = turbine.assembly.hub.parameter_value("precone")
    with part_bar("rotor coefficients") as report:
        rotor = turbine.aerodynamics.steady_rotor
        return coefficient_table(rotor, arguments.ratios, pitches, precone=precone, progress=report)


def _operation(turbine: Turbine, table: CoefficientTable, winds: Sequence[float]) -> list[OperatingPoint]:
    steady, points = turbine.steady_turbine(table), []
    for wind in winds:
        try:
            points.append(steady.operating_point(wind))
        except ModelError:
            ratios, pitches = table.tip_speed_ratio, [math.degrees(angle) for angle in table.blade_pitch]
            raise ModelError(
                f"--winds: at {wind:g} m/s there is no steady operation at tip speed ratios {ratios[0]:g} to "
                f"{ratios[-1]:g} and pitch {pitches[0]:.4g} to {pitches[-1]:.4g} deg. Give other wind speeds, or wider "
                "--ratios and --pitch."
            ) from None
    return points


def _power(table: CoefficientTable, precone: float) -> Any:
    return table.torque * table.tip_speed_ratio[:, None] * math.cos(precone)


def _row(point: OperatingPoint, turbine: Turbine, table: CoefficientTable) -> list[float]:
    thrust, torque = table(point.tip_speed_ratio, point.blade_pitch)
    power = float(torque) * point.tip_speed_ratio * math.cos(turbine.assembly.hub.parameter_value("precone"))
    return [
        point.wind_speed, point.rotor_speed * 30 / math.pi, math.degrees(point.blade_pitch), point.tip_speed_ratio,
        point.aero_power / 1e3, point.thrust / 1e3, power, float(thrust), point.generator_torque,
    ]  # fmt: skip


def _save_slopes(turbine: Turbine, arguments: argparse.Namespace, points: Sequence[OperatingPoint]) -> None:
    from fowtlib.components.aero import load_slopes, write_load_slopes

    hub = turbine.assembly.hub
    speeds, pitches = [point.rotor_speed for point in points], [point.blade_pitch for point in points]
    cone = hub.side * hub.parameter_value("precone")
    slopes = load_slopes(turbine.aerodynamics.steady_rotor, arguments.winds, speeds, pitches, precone=cone)
    about = (
        f"Slopes of the loads of one blade of {turbine.path} in {arguments.model}, by the wind along the shaft at each",
        f"element, over the air density; {_theory()}, in steady operation.",
    )
    write_load_slopes(arguments.slopes, slopes, about)


def _theory() -> str:
    from importlib.metadata import version

    return f"blade element momentum theory, fowtlib {version('fowtlib')} (fowt rotor-table)"


def _about(turbine: Turbine, model: str, precone: float) -> list[str]:
    """What stands at the head of the file."""
    radius, cone = turbine.aerodynamics.tip_radius, math.degrees(precone)
    return [
        f"Steady rotor coefficients of {turbine.path} in {model}: rigid blades, uniform wind along the shaft.",
        f"B{_theory()[1:]}.",
        f"Tip speed ratio with the radius along the blade, {radius:g} m; coefficients with that radius times "
        f"cos({cone:g} deg).",
    ]
