"""`fowt tune`: PI gains of the blade pitch from the model, and what they do to pitch and yaw of the platform."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from fowtlib.cli import loading, tables
from fowtlib.cli.run import finite, numbers
from fowtlib.language.errors import ParameterError

if TYPE_CHECKING:
    from fowtlib.control import PitchLoop, Poles, Tuned

EXAMPLES = r"""Without --frequency: the damping of pitch and yaw of the platform over the wind,
in the linear model of the whole, with the gains that the model has. With it
also gains with which the rotor alone has this frequency and damping, and the
damping with these. A damping ratio below zero is a motion that grows.

examples:
  fowt tune oc3_spar_rigid
  fowt tune oc3_spar_rigid --frequency 0.2 --damping 0.7
  fowt tune oc3_spar_rigid --winds 6:16:0.5 --peak-shaving 0.8 \
      --save shaving.csv
"""


def declare(commands: Any) -> None:
    """Add the command of this module."""
    text = "PI gains of the blade pitch; damping of the platform over the wind"
    parser = commands.add_parser("tune", help=text, epilog=EXAMPLES)
    loading.declare(parser, wind=False, waves=False)
    parser.add_argument("--winds", type=winds, metavar="first:last:step", default="12:24:2",
                        help="mean wind speeds [m/s], or single ones; default: 12:24:2")  # fmt: skip
    parser.add_argument("--frequency", type=finite, metavar="RAD/S", help="wanted natural frequency of the rotor alone")
    parser.add_argument("--damping", type=finite, metavar="RATIO", help="its damping ratio; default: 0.7")
    parser.add_argument("--controller", metavar="PATH", help="the PitchController; default: the first")
    text = "least pitch over the wind that keeps the thrust below this share of its largest"
    parser.add_argument("--peak-shaving", type=finite, metavar="SHARE", help=text)
    text = "write the least pitch as the table of a controller, BaselineController.peak_shaving"
    parser.add_argument("--save", metavar="FILE.csv", help=text)
    tables.declare(parser)
    parser.set_defaults(action=tune)


def winds(text: str) -> list[float]:
    """`12:24:2`, both ends included, or single winds `13,18`; for argparse."""
    values = numbers(text)
    if not len(values) or values.min() <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not first:last:step in m/s, for example 12:24:2")
    return values.tolist()


def tune(arguments: argparse.Namespace) -> int:
    """Print gains, damping over the wind, and what grows; or the least pitch of peak shaving."""
    import numpy as np

    from fowtlib.control import PitchLoop, least_pitch, shave_peak, tune_pi

    tables.check(arguments)
    if arguments.damping is not None and arguments.frequency is None:
        raise ParameterError("--damping goes with --frequency, of the rotor alone; give both.")
    if arguments.save is not None and arguments.peak_shaving is None:
        raise ParameterError("--save writes the table of --peak-shaving; give both.")
    loop = PitchLoop(loading.load(arguments), arguments.controller)
    if arguments.peak_shaving is not None:
        if arguments.frequency is not None:
            raise ParameterError("--peak-shaving and --frequency are two questions; ask them one after the other.")
        shaved = shave_peak(loop, arguments.winds, arguments.peak_shaving)
        rows = [
            (item.wind, float(np.degrees(item.least_pitch)), *(value / 1e3 for value in (*item.thrust, *item.power)))
            for item in shaved
        ]
        columns = ("wind [m/s]", "least pitch [deg]", "thrust [kN]", "shaved [kN]", "power [kW]", "shaved [kW]")
        tables.show(arguments, columns, rows)
        if arguments.save is not None:
            own = float(np.ravel(loop.plant.parameter_values()[loop.parameter("least_pitch")])[0])
            about = (f"fowt tune {arguments.model} --peak-shaving {arguments.peak_shaving:g}",
                     "What the least pitch is raised by, over the mechanical power of the generator.")  # fmt: skip
            least_pitch(shaved, own).write(arguments.save, about)
            owner = loop.path.rpartition(".")[0]
            tables.say(arguments, f"saved {arguments.save}; use it by --set {owner}.peak_shaving={arguments.save}")
        return 0
    tuned = None
    if arguments.frequency is not None:
        damping = 0.7 if arguments.damping is None else arguments.damping
        tuned = tune_pi(loop, arguments.winds, arguments.frequency, damping)
        _say_gains(arguments, loop, tuned)
    own, then = loop.poles(arguments.winds), loop.poles(arguments.winds, tuned) if tuned else []
    columns, rows = _table(own, then, tuned)
    tables.show(arguments, columns, rows)
    grows = ""
    for words, poles in (("the gains of the model", own), ("the new gains", then)):
        for item in poles:
            for mode in item.growing():
                grows = f"{item.wind:g}"
                tables.say(arguments, f"{item.wind:g} m/s: with {words} {mode.name} grows, damping ratio "
                           f"{mode.damping_ratio:.3f}, period {mode.period:.1f} s.")  # fmt: skip
    if grows:
        tables.say(arguments, "Drag that grows with the square of the speed is not in these ratios; "
                   f"`fowt decay {arguments.model} --wind steady:{grows} --dof ... --offset ...` shows where it holds "
                   "the motion.")  # fmt: skip
    return 0


def _say_gains(arguments: argparse.Namespace, loop: PitchLoop, tuned: Tuned) -> None:
    for path, value in loop.parameters(tuned).items():
        tables.say(arguments, f"--set {path}={value:.6g}")
    tables.say(arguments, f"the effect of pitch is a straight line over the pitch to {tuned.error:.0%}\n")


def _table(own: list[Poles], then: list[Poles], tuned: Tuned | None) -> tuple[list[str], list[list[Any]]]:
    import numpy as np

    from fowtlib.control.pi_tuning import WATCHED

    watched = [name for name in WATCHED if any(item.mode(name) for item in own)]
    columns = ["wind [m/s]", "blades [deg]"]
    alone = {item.wind: item.closed(*tuned.at(item.pitch)) for item in tuned.responses} if tuned else {}
    if tuned:
        columns += ["rotor [rad/s]", "its damping"]
    for name in watched:
        short = name.removeprefix("platform ")
        columns += [f"{short} [Hz]", f"{short} damping", *([f"{short} damping, new"] if tuned else [])]
    rows = []
    for k, item in enumerate(own):
        row: list[Any] = [item.wind, float(np.degrees(item.pitch))]
        if tuned:
            row += [float(value) for value in alone.get(item.wind, (np.nan, np.nan))]
        for name in watched:
            modes = [poles.mode(name) for poles in (item, *([then[k]] if tuned else []))]
            row += [float(modes[0].frequency) if modes[0] else np.nan]
            row += [float(mode.damping_ratio) if mode else np.nan for mode in modes]
        rows.append(row)
    return columns, rows
