"""How a frame is turned where a run starts: from the world along joints and links, before anything is solved."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import casadi as ca
import numpy as np

from fowtlib.components.mechanics.interfaces import TwoFrames
from fowtlib.language import Component
from fowtlib.language.expressions import value_of

Place = tuple[int, str]  # id of a component, which is found faster than its path; label of its port


def heading_at_start(component: Component, port: str) -> float:
    """Angle [rad] about the vertical by which x of a frame starts turned; 0 where nothing leads to a fixed frame.

    The way from the world to the frame counts by `start_rotation` of the parts on it. Beams start straight; the command
    of a drive counts where a Constant gives it.
    """
    R = value_of(component, f"attitude of {port}", lambda: _attitude(component, port))
    return float(np.arctan2(R[1, 0], R[0, 0]))


def place_at_start(component: Component, port: str) -> np.ndarray | None:
    """Where a frame (3,) [m], world, is where a run starts; None where nothing leads to a frame whose place is known.

    The way counts by `start_rotation` and `start_translation` of the parts on it, from a part that knows the place of
    its frames (`start_place`): World, Fixed, what is moved, or a point with states of its own.
    """
    parts, links = _network([component, *component.enclosing()][-1])
    start = (id(component), port)
    found = {start: (np.eye(3), np.zeros(3))}  # rotation and place of what was sought, seen from this place
    for number, label in (waiting := [start]):
        R, r = found[number, label]
        part = parts.get(number)
        known = getattr(type(part), "start_place", None)
        if known is not None and number != id(component):
            fixed = getattr(type(part), "fixed_rotation", None)
            turn = np.eye(3) if fixed is None else _numbers(fixed(part))
            return np.asarray(known(part), dtype=float) + turn @ r
        for place, turn in _next(part, number, label, links, parts):
            if place in found:
                continue
            found[place] = (R, r) if turn is None else _moved(part, label, turn, R, r)
            waiting.append(place)
    return None


def _moved(part: Any, label: str, turn: np.ndarray, R: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation and place seen from the other frame of a part."""
    arm = np.asarray(part.start_translation(), dtype=float)
    return (turn @ R, turn @ (r - arm)) if label == "frame_a" else (turn @ R, arm + turn @ r)


def _attitude(component: Component, port: str) -> np.ndarray:
    """World from frame (3, 3), by the way through the fewest parts."""
    parts, links = _network([component, *component.enclosing()][-1])
    found: dict[Place, np.ndarray] = {(id(component), port): np.eye(3)}  # frame at hand, from the frame at this place
    for number, label in (waiting := list(found)):
        R = found[number, label]
        part = parts.get(number)
        fixed = getattr(type(part), "fixed_rotation", None)
        if fixed is not None and label == "frame":
            return _numbers(fixed(part)) @ R
        for place, turn in _next(part, number, label, links, parts):
            if place not in found:
                found[place] = R if turn is None else turn @ R
                waiting.append(place)
    return np.eye(3)


def _network(root: Component) -> tuple[dict[int, Any], dict[Place, list[Place]]]:
    """All parts by their ids, and the places that each place is connected with; the same within an evaluation."""
    return value_of(root, "network", lambda: _linked(root))


def _linked(root: Component) -> tuple[dict[int, Any], dict[Place, list[Place]]]:
    links: dict[Place, list[Place]] = defaultdict(list)
    parts = {id(part): part for part in root.walk()}
    for owner in parts.values():
        for a, b, _ in owner.connections:
            one, other = (id(a.component.current), a.label), (id(b.component.current), b.label)
            links[one].append(other)
            links[other].append(one)
    return parts, links


def _next(part: Any, number: int, label: str, links: Any, parts: Any) -> Iterator[tuple[Place, np.ndarray | None]]:
    """The places beside one, each with the turn from here to there; None: there is none."""
    for place in links[number, label]:
        yield place, None
    if isinstance(part, TwoFrames) and label in ("frame_a", "frame_b") and not part.parts:
        rotation = part.start_rotation(_command(number, links, parts))
        if rotation is not None:
            R = _numbers(rotation)
            yield ((number, "frame_b"), R.T) if label == "frame_a" else ((number, "frame_a"), R)


def _command(number: int, links: Any, parts: Any) -> float:
    """What a Constant gives to the port `command` of a part; else 0."""
    seen = [(number, "command")]
    for place in seen:
        for other, port in links[place]:
            if port == "y" and "value" in getattr(parts.get(other), "parameters", ()):
                return float(np.ravel(parts[other].parameter_value("value"))[0])
            if (other, port) not in seen:
                seen.append((other, port))
    return 0.0


def _numbers(R: Any) -> np.ndarray:
    return np.asarray(R, dtype=float) if isinstance(R, np.ndarray) else ca.evalf(ca.SX(R)).full()
