"""Checkpoints: a run between two stretches, with all that its way on depends on, as bytes.

A run goes from stretch to stretch, whose ends lie at times that its model and its output step give, never the clock;
IDAS starts anew with each of them, and the fixed-step engine gives its whole memory. So a run that goes on from a
checkpoint computes what it would have computed without the interruption, bit for bit. A stretch that the end of the run
has cut short is not one of them: a longer run would have had another, so the checkpoint lies before it, and it is
computed again.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from fowtlib.solving.engines import Engine
from fowtlib.solving.events import StateEvents
from fowtlib.solving.results.packing import packed, unpacked
from fowtlib.solving.sessions import Sessions
from fowtlib.solving.timeline import Timeline


class Run(Protocol):
    """What a checkpoint is made from and put into; see fowtlib.solving.run."""

    engine: Engine
    events: StateEvents
    timeline: Timeline
    t: float
    t_start: float
    step: float
    most: int
    parts: int
    x: np.ndarray
    z: np.ndarray
    d: np.ndarray
    u: np.ndarray
    clocks: list[tuple[float, float, int]]
    warned: dict[int, str]
    sessions: Sessions
    rows: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]


def settings(run: Run) -> dict[str, Any]:
    """What must be the same for a run to go on exactly: the solver with its settings, and the output step."""
    same = {**run.engine.attributes, "output_step": run.step, "inputs": run.u.tolist()}
    return {**same, "events": run.timeline.settings()} if run.timeline.planned else same


def checkpoint(run: Run) -> bytes:
    """The run as it stands; empty where a process of the model cannot save what it remembers."""
    states = run.sessions.saved()
    if states is None:
        return b""
    events, (times, *last) = run.events, run.rows[-1]
    text = {
        "t": run.t, "t_start": run.t_start, "settings": settings(run), "most": run.most, "parts": run.parts,
        "clocks": [n for _, _, n in run.clocks], "warned": list(run.warned.items()),
        "last_event": list(events.last_event.items()), "returns": list(events.returns.items()),
        "just_fired": sorted(events.just_fired), "last_act": None if np.isinf(events.last_act) else events.last_act,
        "last_time": float(times[-1]), "happened": run.timeline.happened,
        "done": [item.done for item in run.timeline.planned],
    }  # fmt: skip
    arrays = {"x": run.x, "z": run.z, "d": run.d, "u": run.u, "armed": events.armed.astype(np.uint8)}
    arrays |= {f"last_{key}": rows[-1] for key, rows in zip("xzd", last, strict=True)}
    arrays |= {f"session {k}": np.frombuffer(state, np.uint8) for k, state in states.items()}
    text["engine"], memory = run.engine.memory()
    return packed(text, {**arrays, **{f"engine {name}": values for name, values in memory.items()}})


def last_time(data: bytes) -> float:
    """The time of the last output point before a checkpoint [s]: from there on a run that goes on computes anew."""
    return float(unpacked(data)[0]["last_time"])


def differences(data: bytes, run: Run) -> list[str]:
    """What differs between the settings of a checkpoint and those of a run."""
    old, new = unpacked(data)[0]["settings"], settings(run)
    return [f"{key} was {old.get(key)}, is {new.get(key)}" for key in {**old, **new} if old.get(key) != new.get(key)]


def restore(data: bytes, run: Run) -> None:
    """Put a run of the same model, parameters and settings where it stood; ValueError where it does not fit."""
    text, arrays = unpacked(data)
    for key in "xzdu":
        if arrays[key].shape != getattr(run, key).shape:
            raise ValueError("it is of another model")
    memory = {name.removeprefix("engine "): values for name, values in arrays.items() if name.startswith("engine ")}
    run.engine.remember(text["engine"], memory)
    run.t, run.t_start, run.most, run.parts = text["t"], text["t_start"], text["most"], text["parts"]
    run.x, run.z, run.d, run.u = (arrays[key] for key in "xzdu")
    run.clocks = [(offset, period, n) for (offset, period, _), n in zip(run.clocks, text["clocks"], strict=True)]
    run.warned = dict(map(tuple, text["warned"]))
    events = run.events
    events.last_event, events.returns = (dict(map(tuple, text[key])) for key in ("last_event", "returns"))
    events.just_fired = set(text["just_fired"])
    events.last_act = -np.inf if text["last_act"] is None else text["last_act"]
    events.armed = arrays["armed"].astype(bool)
    run.timeline.happened = list(text.get("happened", ()))
    for item, done in zip(run.timeline.planned, text.get("done", ()), strict=True):
        item.done = done
    sessions = {int(name.removeprefix("session ")): name for name in arrays if name.startswith("session ")}
    run.sessions.restore({k: bytes(arrays[name]) for k, name in sessions.items()})
    run.rows = [(np.array([text["last_time"]]), *(arrays[f"last_{key}"][None] for key in "xzd"))]
