"""The program `fowt`: its commands, and what becomes of errors.

Exit status: 0 done, 1 done and the answer is no (`fowt check`) or a case has failed (`fowt batch`), 2 a mistake of the
user (message on stderr), 3 an error inside fowtlib or a component, 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import argparse
import atexit
import contextlib
import gc
import os
import re
import sys
import textwrap
import threading
import traceback
import warnings
from collections.abc import Iterator, Sequence
from typing import NoReturn

from fowtlib.cli import (
    batch,
    cache,
    calibrate,
    cases,
    compare,
    contours,
    decay,
    events,
    export,
    extremes,
    fatigue,
    hydro,
    inspection,
    library,
    loading,
    loads,
    maps,
    maxima,
    optimise,
    rao,
    response,
    righting,
    rotor_table,
    run,
    scale,
    sensitivity,
    sheet,
    size,
    stability,
    statistics,
    tune,
    view,
    wind_field,
)
from fowtlib.cli.encoding import write_what_can_be_written
from fowtlib.cli.files import declare_force
from fowtlib.cli.report import write_report
from fowtlib.language.errors import ModelError, did_you_mean

GROUPS = (
    run, cases, batch, export, view, inspection, events, stability, righting, tune, sheet, maps, size, optimise, scale,
    decay, calibrate, rao, response, sensitivity, statistics, maxima, loads, fatigue, compare, rotor_table, hydro,
    wind_field, contours, extremes, library, cache,
)  # fmt: skip


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Help whose texts keep their line breaks; a form such as kaimal:SPEED[,class=..] breaks between its keys."""

    def _split_lines(self, text: str, width: int) -> list[str]:
        indent = "  " if "\n" in text else ""
        lines = [
            piece
            for line in text.split("\n")
            for piece in textwrap.wrap(line.replace("[,", " [,"), width, subsequent_indent=indent)
        ]
        return [line.replace(" [,", "[,") for line in lines]


class Parser(argparse.ArgumentParser):
    """argparse with whole option names only, and the names the user may have meant."""

    def __init__(self, *args, **kwargs):
        kwargs.setdefault("allow_abbrev", False)
        kwargs.setdefault("formatter_class", Formatter)
        super().__init__(*args, **kwargs)
        self._negative_number_matcher = re.compile(r"-[\d.]")  # -180:180:30 and -1,0,0 are values, no options

    def _check_value(self, action: argparse.Action, value: object) -> None:
        if action.choices is not None and value not in action.choices:
            what = action.metavar or action.dest
            if isinstance(action, argparse._SubParsersAction):
                what = what.lower()
            of = f" of {action.option_strings[-1]}" if action.option_strings else ""
            meant = did_you_mean(str(value), map(str, action.choices), list_up_to=20)
            self.error(f"unknown {what} '{value}'{of}{meant}")

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and where help is, and exit with status 2."""
        self.exit(2, f"{self.prog}: {message}\nSee {self.prog} --help\n")

    def unknown(self, words: Sequence[str]) -> NoReturn:
        """Refuse arguments nobody declared; each with the option that was probably meant."""
        word = words[0].partition("=")[0]
        if word in self._option_string_actions:
            self.error(f"the option '{word}' belongs behind the command: {self.prog} ... {word}")
        if word.startswith("-"):
            self.error(f"unknown option '{word}'{did_you_mean(word, self._option_string_actions, list_up_to=0)}")
        self.error(f"one argument too many: '{word}'.")


def parser() -> tuple[Parser, dict[str, Parser]]:
    """The parser of the whole program, and those of its commands by name."""
    top = Parser("fowt", description="Floating wind turbines: simulate, inspect and linearise models.")
    top.add_argument("--version", action="store_true", help="print the version and exit")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", parser_class=Parser)
    for group in GROUPS:
        group.declare(commands)
    known = dict(_named(commands))
    for command in known.values():
        if {action.dest for action in command._actions} & {"output", "plot", "table", "curve"}:
            declare_force(command)
        command.add_argument("--traceback", action="store_true", help="on an error, show where in the program it arose")
    return top, known


def _named(commands: argparse._SubParsersAction) -> Iterator[tuple[str, Parser]]:
    """Commands by name; those that have actions of their own (`fowt batch run`) by both words."""
    for line in commands._choices_actions:  # what the help says of a command
        command = commands.choices[line.dest]
        command.description = f"{line.help[0].upper()}{line.help[1:]}."
        below = [action for action in command._actions if isinstance(action, argparse._SubParsersAction)]
        for actions in below:
            yield from ((f"{line.dest} {name}", inner) for name, inner in _named(actions))
        yield line.dest, command


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status."""
    write_what_can_be_written()
    top, commands = parser()
    arguments, rest = top.parse_known_args(argv)
    if arguments.version:
        from importlib.metadata import version

        print(f"fowt {version('fowtlib')}")
        return 0
    if arguments.command is None:
        top.print_help()
        return 2
    if rest:
        commands[_words(arguments)].unknown(rest)
    gc.set_threshold(200_000)  # a model is a million objects that stay: looking through them again and again costs 6 %
    with warnings.catch_warnings():
        warnings.showwarning = _warn
        status = _carry_out(arguments)
    if argv is None:
        _leave(status)
    return status


def _words(arguments: argparse.Namespace) -> str:
    """The command, and its action where it has one."""
    return " ".join(filter(None, (arguments.command, getattr(arguments, "verb", ""))))


def _leave(status: int) -> None:
    """End the process at once, when all is saved: to take down the million objects of a model takes 0.1 s.

    What is compiled beside comes to its end first, unless Ctrl-C was pressed. Other work that Ctrl-C has left to itself
    may go on in compiled code, under which the interpreter cannot be taken down.
    """
    for thread in threading.enumerate() if status != 130 else ():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join()
    atexit._run_exitfuncs()  # temporary folders and processes
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(status)


def _carry_out(arguments: argparse.Namespace) -> int:
    """Do what the command says; every error becomes a sentence and a status."""
    try:
        return arguments.action(arguments)
    except ModelError as error:
        return _stopped(arguments, _status(error), loading.message(error, arguments))
    except KeyboardInterrupt:
        return _stopped(arguments, 130, "stopped; nothing was saved.")
    except MemoryError:
        return _stopped(arguments, 2, "this needs more memory than there is; make the model or the run smaller.")
    except BrokenPipeError:  # the reader of our output has enough: `fowt parts | head`
        sys.stderr.close()
        return 0
    except Exception as error:
        reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        report = write_report(arguments, error)
        hint = f"\nA report for the makers of fowtlib, with how to send it: {report}" if report else ""
        hint += "" if arguments.traceback else "\nTo see where it arose, add --traceback."
        return _stopped(arguments, 3, f"an error inside the program: {reason}{hint}")


def _status(error: ModelError) -> int:
    """130 for a simulation that Ctrl-C stopped, 2 for a mistake."""
    simulation = sys.modules.get("fowtlib.solving.run")  # imported only by a command that needs it
    return 130 if simulation and isinstance(error, simulation.Interrupted) else 2


def _stopped(arguments: argparse.Namespace, status: int, message: str) -> int:
    if arguments.traceback:
        traceback.print_exc()
    sys.stdout.flush()
    print(f"fowt {_words(arguments)}: {message}", file=sys.stderr)
    return status


def _warn(message: Warning | str, category: type[Warning], *_: object) -> None:
    """Pass on what a model has to say; what packages tell their programmers is not for the user of a command."""
    if category is UserWarning or category.__module__.startswith("fowtlib."):
        print(f"fowt: warning: {message}", file=sys.stderr)
