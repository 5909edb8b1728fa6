"""`fowt equilibrium`, `fowt eigen`, `fowt campbell`: the mean position, and the natural modes about it."""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Container, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.files import FIGURES, check_target, say_saved
from fowtlib.cli.run import numbers, positive
from fowtlib.language.errors import ModelError

if TYPE_CHECKING:
    from fowtlib.solving import Mode, Plant

WIND = "wind.mean_speed"
RUNS_AWAY = 1e-4  # 1/s; what grows slower is a double root at zero, or its rounding
GROWS = 1e-6  # of the size of a pole: its real part, above which a mode grows

EQUILIBRIUM = r"""In still water, and in the wind of --wind or of the model, at its mean speed.

With --free the parameters of the model take the values at which the conditions
of --target hold, as many as parameters are freed.

examples:
  fowt equilibrium oc3_spar_rigid --wind steady:8
  fowt equilibrium oc3_spar_rigid --wind none --free platform.mooring.length \
      --target "fairlead_tension_2=950 kN"
"""
EIGEN = r"""About the mean position: in still water, and in the wind of --wind or of the
model, at its mean speed. A mode is named after the motion that takes the
largest part in it. Of rotors that turn, the modes are those of the mean over a
revolution in multi-blade coordinates, as seen from the tower: blades that whirl
with the rotor are progressive, against it regressive.

examples:
  fowt eigen oc3_spar_rigid --wind none
  fowt eigen oc3_spar --wind none         the rotor stands
  fowt eigen oc3_spar --wind steady:12    it turns
  fowt view oc3_spar --wind none --mode 7
  fowt eigen nrel5mw_land --wind steady:12 --linear land.lin
  fowt eigen oc3_spar_rigid --wind steady:12 --linear spar.mat
"""
CAMPBELL = r"""In each of the winds the modes of the mean in steady operation, with the
controllers in the loop, in still water. A mode is followed from one wind to the
next by its shape. Frequencies are those seen from the tower, in which a blade
that swings with f has f - n and f + n, n the revolutions per second.

examples:
  fowt campbell nrel5mw_land --winds 4:24:2 --plot campbell.png
  fowt campbell oc3_spar --winds 8,12,16 --highest 1.5 --output modes.csv
"""


def declare(commands: Any) -> None:
    """Add the commands of this module."""
    equilibrium = commands.add_parser("equilibrium", help="the mean position in steady wind", epilog=EQUILIBRIUM)
    equilibrium.add_argument(
        "--free", metavar="PATH[=GUESS]", action="append", default=[],
        help="a tunable parameter that takes the value at which the conditions hold; may be repeated",
    )  # fmt: skip
    equilibrium.add_argument(
        "--target", metavar="RESULT=VALUE", action="append", default=[],
        help="a condition, for example --target 'fairlead_tension_1=950 kN'; one for each --free",
    )  # fmt: skip
    equilibrium.set_defaults(action=show_equilibrium)
    text = "natural modes by name: frequency, period, damping ratio"
    eigen = commands.add_parser("eigen", help=text, epilog=EIGEN)
    eigen.add_argument("--all", action="store_true", help="also the modes of filters, controllers and radiated waves, "
                       "and what does not oscillate")  # fmt: skip
    eigen.add_argument("--plot", type=Path, metavar="FILE", help="draw frequencies and damping: .png, .svg or .pdf")
    eigen.add_argument("--linear", type=Path, metavar="FILE",
                       help="save the linear model, with all results: .mat, .npz or .lin (OpenFAST)")  # fmt: skip
    text = "parameters or inputs that drive it, by path; else all inputs of the model, and the mean wind"
    eigen.add_argument("--inputs", metavar="A,B", default="", help=text)
    eigen.set_defaults(action=show_modes)
    text = "natural modes over the wind: table, and diagram with 1P, 3P, 6P"
    diagram = commands.add_parser("campbell", help=text, epilog=CAMPBELL)
    diagram.add_argument("--winds", metavar="A:B:STEP", required=True, help="speeds [m/s], or a list 8,12,16")
    diagram.add_argument("--highest", type=positive, default=3.0, metavar="HZ",
                         help="modes below this frequency are shown; default: 3")  # fmt: skip
    diagram.add_argument("--plot", type=Path, metavar="FILE", help="draw frequency and damping: .png, .svg or .pdf")
    diagram.set_defaults(action=show_campbell)
    loading.declare(diagram, wind=False, waves=False)
    tables.declare(diagram)
    for parser in (equilibrium, eigen):
        loading.declare(parser, waves=False)
        tables.declare(parser)


def show_equilibrium(arguments: argparse.Namespace) -> int:
    """Print the results of the model at its equilibrium."""
    from fowtlib.analysis.upright import warn_unless_upright
    from fowtlib.solving import mean_state

    tables.check(arguments)
    model, conditions = loading.load_at_rest(arguments)
    free, targets = _pairs(arguments.free), _pairs(arguments.target)
    plant = model.compile()
    state = plant.equilibrium(free=free, targets=targets) if free or targets else mean_state(plant)
    warn_unless_upright(plant, state)
    units, found = plant.dae.parameters, plant.parameter_values(state.parameters)
    stated = free or model.settings.get("equilibrium", {}).get("free", {})
    paths = dict.fromkeys(_parameter(path, units) for path in stated)
    rows = [(path, found[path].tolist(), units[path].unit) for path in paths]
    rows += [(name, tables.rounded(state[name], 1.0), unit) for name, (_, unit, _) in plant.outputs.items()]
    tables.say(arguments, conditions)
    tables.show(arguments, ("result", "value", "unit"), rows)
    return 0


def _pairs(texts: list[str]) -> dict[str, str | None]:
    """Names with what is given for them behind `=`; None without."""
    pairs: dict[str, str | None] = {}
    for text in texts:
        name, equals, value = (word.strip() for word in text.partition("="))
        if not name or (equals and not value):
            raise ModelError(f"'{text}': a name is expected, and a value behind '='.")
        if name in pairs:
            raise ModelError(f"{name} is given twice.")
        pairs[name] = value if equals else None
    return pairs


def _parameter(name: str, known: Container[str]) -> str:
    """The path of the parameter that a freed element belongs to."""
    return name if name in known else name.partition("[")[0]


def show_modes(arguments: argparse.Namespace) -> int:
    """Print the modes of the linear model at the equilibrium, slowest first."""
    from fowtlib.analysis.upright import warn_unless_upright
    from fowtlib.solving import mean_linear_model, mean_state, natural_modes

    tables.check(arguments)
    check_target(arguments.plot, FIGURES, arguments.force)
    check_target(arguments.linear, (".mat", ".npz", ".lin"), arguments.force)
    if arguments.inputs and not arguments.linear:
        raise ModelError("--inputs are those of the linear model of --linear; give both.")
    model, conditions = loading.load_at_rest(arguments)
    plant = model.compile()
    inputs = [path.strip() for path in arguments.inputs.split(",") if path.strip()]
    try:
        for path in inputs:
            plant.layout.symbols(path)
    except ModelError as error:
        raise error.at("--inputs") from None
    state = mean_state(plant)
    warn_unless_upright(plant, state)
    every = natural_modes(plant, state)
    modes = every if arguments.all else _chosen(every)
    rows = [(mode.number, mode.name, mode.frequency, mode.period, mode.damping_ratio) for mode in modes]
    tables.say(arguments, conditions)
    tables.show(arguments, ("mode", "motion", "frequency [Hz]", "period [s]", "damping ratio"), rows)
    if every and not modes:
        tables.say(arguments, f"Nothing oscillates; --all has {len(every)} that do not.")
    for mode in modes:
        pole = mode.eigenvalue
        if pole.real > GROWS * abs(pole):
            value = f"{pole.real:+.4g} {pole.imag:+.4g}i" if pole.imag else f"{pole.real:+.4g}"
            pace = f"grows by a factor e in {1 / pole.real:.4g} s (pole {value} 1/s)"
            warnings.warn(f"mode {mode.number}, {mode.name}, {pace}.", stacklevel=1)
    if arguments.plot:
        from fowtlib.solving.results.plots import plot_modes

        plot_modes(modes, path=arguments.plot, title="\n".join(filter(None, (model.title or model.name, conditions))))
    say_saved(arguments.plot)
    if arguments.linear:
        say_saved(mean_linear_model(plant, state, inputs or _drivers(plant)).save(arguments.linear))
    return 0


def _drivers(plant: Plant) -> list[str]:
    """What drives a linear model where nobody says it: the inputs of the model by their names, and the mean wind."""
    named = {path: name for name, path in plant.input_names.items()}
    return [named.get(path, path) for path in plant.layout.u] + [path for path in (WIND,) if path in plant.layout.p]


def _chosen(every: Sequence[Mode]) -> list[Mode]:
    """Oscillations of bodies, else of what there is, as water in pipes; and all that runs away."""
    bodies = any(mode.motion and mode.oscillates for mode in every)
    return [
        mode for mode in every
        if (mode.oscillates and (mode.motion or not bodies)) or mode.eigenvalue.real > RUNS_AWAY
    ]  # fmt: skip


def show_campbell(arguments: argparse.Namespace) -> int:
    """Print the modes over the wind, and draw them."""
    import numpy as np

    from fowtlib.analysis.campbell import campbell
    from fowtlib.cli.progress import part_bar

    tables.check(arguments)
    check_target(arguments.plot, FIGURES, arguments.force)
    winds = numbers(arguments.winds)
    if not len(winds) or winds.min() <= 0:
        raise ModelError(f"--winds: '{arguments.winds}' are no speeds above 0 m/s; give 4:24:2 or 8,12,16.")
    arguments.wind = f"steady:{winds[0]:g}"
    model, _ = loading.load_at_rest(arguments)
    with part_bar("winds") as progress:
        every = campbell(model, winds.tolist(), progress=progress)
    found = every.below(arguments.highest)
    if every.lines and not found.lines:
        least = min(float(np.nanmin(line.frequency)) for line in every.lines)
        raise ModelError(f"--highest: no mode lies below {arguments.highest:g} Hz; the slowest has {least:.4g} Hz.")
    tables.say(arguments, f"steady wind of {winds[0]:g} to {winds[-1]:g} m/s, still water")
    if arguments.form:
        tables.show(arguments, found.heads(), found.rows())
    else:
        tables.save(arguments, found.heads(), found.rows())
        heads = ("motion", *(f"{wind:g} m/s" for wind in winds))
        rows = [("rotor speed [rpm]", *(found.rotor_speed[:, k] * 30 / math.pi))
                for k in range(found.rotor_speed.shape[1])]  # fmt: skip
        rows += [(line.name, *_shown(line.frequency)) for line in found.lines]
        tables.show_rows(heads, rows, "frequency [Hz]")
        rows = [(line.name, *_shown(100 * line.damping_ratio)) for line in found.lines]
        print()
        tables.show_rows(heads, rows, "damping ratio [%]")
    for name, wind in found.unstable:
        warnings.warn(f"{name} grows at {wind:g} m/s.", stacklevel=1)
    if arguments.plot:
        found.plot(arguments.plot, model.title or model.name)
        say_saved(arguments.plot)
    return 0


def _shown(values: Any) -> list[Any]:
    """Numbers, and nothing where a mode is not there."""
    return [None if math.isnan(value) else value for value in values.tolist()]
