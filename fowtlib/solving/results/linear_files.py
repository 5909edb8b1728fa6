"""Linear models as text in the form of OpenFAST (`.lin`), which its tools for modes and controllers read.

Operating points, descriptions with units, then A, B, C and D, in SI but for outputs, with all their digits. States of a
model in multi-blade coordinates stand in the frame that does not turn: nothing is left for a reader to transform.
Source of the form: NREL, OpenFAST documentation, "Linearization files" and the files of its module FAST_Lin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language.whole_files import write_text


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """Where a linear model is of: values, units and orders of its rows and columns.

    time [s]; rotor_speed [rad/s], azimuth [rad] of the first rotor that turns; wind_speed [m/s]; states, rates, inputs,
    outputs: values as the matrices have them; state_units, input_units; orders: 2 of the states of a motion, 1 of the
    others; turning: True where a state belongs to a part that turns with a rotor.
    """

    time: float
    states: np.ndarray
    rates: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray
    state_units: tuple[str, ...]
    input_units: tuple[str, ...]
    orders: tuple[int, ...]
    turning: tuple[bool, ...]
    rotor_speed: float = 0.0
    azimuth: float = 0.0
    wind_speed: float = 0.0
    title: str = field(default="")


def write_lin(linear: Any, point: OperatingPoint, path: Path) -> Path:
    """Write a linear model (fowtlib.solving.LinearModel)."""
    counts = (len(linear.states), len(linear.inputs), len(linear.outputs))
    now = f"{datetime.now():%d-%b-%Y at %H:%M:%S}"
    lines = [
        "",
        f"Linearized model: Predictions were generated on {now} using fowtlib",
        "",
        "",
        f"Description: {point.title}",
        "",
        "Simulation information:",
        *(f"   {name + ':':<25}{value:18.9E} {unit}" for name, value, unit in (
            ("Simulation time", point.time, "s"), ("Rotor Speed", point.rotor_speed, "rad/s"),
            ("Azimuth", point.azimuth, "rad"), ("Wind Speed", point.wind_speed, "m/s"))),
        *(f"   {name + ':':<35}{count:5d}" for name, count in (
            ("Number of continuous states", counts[0]), ("Number of discrete states", 0),
            ("Number of constraint states", 0), ("Number of inputs", counts[1]), ("Number of outputs", counts[2]))),
        "   Jacobians included in this file?    No",
        "",
    ]  # fmt: skip
    described = [f"{name}, {unit}" for name, unit in zip(linear.states, point.state_units, strict=True)]
    rates = [f"First time derivative of {name}, {unit}/s"
             for name, unit in zip(linear.states, point.state_units, strict=True)]  # fmt: skip
    inputs = [f"{name}, {unit}" for name, unit in zip(linear.inputs, point.input_units, strict=True)]
    outputs = [f"{name}, ({linear.units.get(name, '1')})" for name in linear.outputs]
    still = [False] * max(counts)
    lines += _table("Order of continuous states", "Row/Column", point.states, point.turning, point.orders, described)
    of_rates = (point.rates, point.turning, point.orders, rates)
    lines += _table("Order of continuous state derivatives", "Row/Column", *of_rates)
    if counts[1]:
        lines += _table("Order of inputs", "Column", point.inputs, still, [0] * counts[1], inputs)
    if counts[2]:
        lines += _table("Order of outputs", "Row", point.outputs, still, [0] * counts[2], outputs)
    lines += ["", "Linearized state matrices:", ""]
    for name in "ABCD":
        matrix = linear.matrices[name]
        if matrix.size:
            lines.append(f"{name}: {matrix.shape[0]} x {matrix.shape[1]}")
            lines += [" ".join(f"{value:23.16E}" for value in row) for row in matrix.tolist()]
            lines.append("")
    return write_text(path, "\n".join(lines) + "\n")


def _table(title: str, column: str, values: np.ndarray, turning: Sequence[bool], orders: Sequence[int],
           texts: Sequence[str]) -> list[str]:  # fmt: skip
    lines = [
        f"{title}:",
        f"   {column:<10} {'Operating Point':<23} Rotating Frame? Derivative Order Description",
        f"   {'-' * 10} {'-' * 23} {'-' * 15} {'-' * 16} {'-' * 11}",
    ]
    for k, (value, text) in enumerate(zip(values.tolist(), texts, strict=True)):
        lines.append(f"{k + 1:11d} {value:23.16E} {'T' if turning[k] else 'F':^15} {orders[k]:^16d} {text}")
    return [*lines, ""]
