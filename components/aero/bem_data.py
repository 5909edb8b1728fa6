"""The data of a blade-element rotor as C text, which stands in front of polar.c, its airfoil model and bem.c.

The numbers of a station are there for every node, so that a vector of nodes reads them at once.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from fowtlib.components.aero.blade_aerodynamics import Airfoil

if TYPE_CHECKING:
    from fowtlib.components.aero.bem import BladeElementRotor


def c_text(rotor: BladeElementRotor) -> str:
    """The rotor as C text."""
    b = rotor.blade
    used = list(dict.fromkeys(b.airfoil))
    foils = [b.airfoils[name] for name in used]
    polar = np.array([used.index(name) for name in b.airfoil])
    sizes = [len(foil.angle) for foil in foils]
    starts = np.cumsum([0, *sizes[:-1]])
    # one cubic per knot; the last knot of an airfoil has none of its own and is never looked up
    model = rotor.airfoil_model
    cubics = [np.pad(model.cubics(foil), ((0, 1), (0, 0), (0, 0))) for foil in foils]
    more_macros, more_numbers = model.data(foils)
    first_in, most_in_bin = _bins([foil.angle for foil in foils])
    most = np.array([np.abs(foil.coefficients).max(axis=0) for foil in foils])[polar]
    lift_lines = np.array([_lift_line(foil) for foil in foils])[polar]
    tip, hub = rotor.losses
    upright = np.prod([2 / np.pi * np.arccos(np.exp(-x)) for x in (tip, hub)], axis=0)
    stations = {"length": rotor.lengths, "tip_loss": tip, "hub_loss": hub,
                "least_loss": np.minimum(tip, hub), "upright_loss": upright,
                "most_lift": most[:, 0], "most_drag": most[:, 1],
                "lift_slope": lift_lines[:, 0], "zero_lift": lift_lines[:, 1]}  # fmt: skip
    numbers = {**{name: np.tile(values, rotor.blades) for name, values in stations.items()},
               "knot": np.concatenate([[*foil.angle[:-1], 10.0] for foil in foils]),
               "cubic": np.concatenate([c.ravel() for c in cubics]), **more_numbers}  # fmt: skip
    integers = {"polar": np.tile(polar, rotor.blades), "first_in": np.concatenate(first_in + starts[:, None])}
    macros = {"BLADES": rotor.blades, "STATIONS": len(b.radius), "SENSE": rotor.rotation,
              "TIP_RADIUS": _number(b.tip_radius), "SKEW": _number(rotor.skew), "SKEWED_WAKE": int(rotor.skew != 0),
              "DYNAMIC_INFLOW": int(rotor.dynamic_inflow), "AXIAL_DRAG": int(rotor.axial_drag),
              "TANGENTIAL_DRAG": int(rotor.tangential_drag),
              "AIRFOIL_STATES": model.states, "COLUMNS": cubics[0].shape[1], "BINS": first_in.shape[1],
              "MOST_IN_BIN": most_in_bin, **more_macros}  # fmt: skip
    lines = [f"#define {key} {value if str(value).startswith('{') else f'({value})'}" for key, value in macros.items()]
    lines += [_array("int", key, value) for key, value in integers.items()]
    lines += [_array("double", key, value) for key, value in numbers.items()]
    return "\n".join(lines) + "\n"


def _bins(angles: list[np.ndarray]) -> tuple[np.ndarray, int]:
    """For each airfoil the number of the knot below each part of the turn from -pi, and the most knots within a part.

    As fine as it takes to have two knots at most in a part, if that is within a sixteenth of a degree.
    """
    for count in (360, 720, 1440, 2880, 5760):
        edges = np.linspace(-np.pi, np.pi, count + 1)
        below, above = (np.array([np.searchsorted(angle, place, side="right") for angle in angles])
                        for place in (edges[:-1] - 1e-9, edges[1:] + 1e-9))  # fmt: skip
        most = int((above - np.maximum(below, 1)).max())
        if most <= 2:
            break
    return np.maximum(below - 1, 0), most


def _lift_line(foil: Airfoil) -> tuple[float, float]:
    """Slope and zero of a straight line through the lift from -4 to 6 deg: where the search for the inflow begins."""
    angle = np.radians(np.linspace(-4, 6, 101))
    slope, lift = np.polyfit(angle, np.interp(angle, foil.angle, foil.coefficients[:, 0]), 1)
    return (slope, -lift / slope) if slope > 0.1 else (0.0, 0.0)


@cache
def _number(value: float) -> str:
    """A C constant with every digit; infinity is a number that exp(-x) takes to zero."""
    return repr(float(value)) if np.isfinite(value) else "1e300"


def _array(kind: str, name: str, values: Any) -> str:
    items = [_number(float(v)) if kind == "double" else str(int(v)) for v in values]
    body = "\n".join(", ".join(items[i : i + 12]) + "," for i in range(0, len(items), 12))
    return f"static const {kind} {name}[] = {{\n{body}\n}};"
