"""`view`: a model or a result as a picture in 3-D, animated, in one HTML file that needs nothing but a browser."""

from __future__ import annotations

import base64
import html
import json
import warnings
import webbrowser
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from fowtlib.language import shapes
from fowtlib.language.errors import ModelError
from fowtlib.language.whole_files import write_text
from fowtlib.solving import Model, Plant, Result, mean_state
from fowtlib.solving.results.plots import PANELS
from fowtlib.view import meshes
from fowtlib.view.modes import CYCLE, mode_of, mode_states, played
from fowtlib.view.recording import Cast, Observe, Reading, moments_of

READINGS = 24, 8  # results beside the picture, at most: the usual ones of a turbine, else any
ORDER = {name: rank for rank, name in enumerate(name for panel in PANELS for name in panel)}
CLEAR = 20.0  # degrees between the camera and a mooring line
SIZE_LIMIT = 15e6  # bytes; of a longer run fewer moments a second are shown


@dataclass(frozen=True)
class Animation:
    """A file that was written: its path, the number of moments in it, moments per simulated second, size in bytes."""

    path: Path
    moments: int
    rate: float
    size: int

    def __str__(self) -> str:
        size = f"{self.size / 1e6:.1f} MB"
        if self.moments == 1:
            return f"{self.path} ({size})"
        return f"{self.path} ({self.moments} moments, {self.rate:.3g} per simulated second, {size})"


@dataclass(frozen=True, eq=False)
class Recording:
    """Where the numbers come from: moments [s], `observe(paths)` -> (n_time, n) at them, and the results to read."""

    root: Any
    time: np.ndarray
    observe: Observe
    readings: list[Reading]
    title: str
    status: str
    loop: bool = False


def view(
    subject: Model | Plant | Result,
    path: str | Path | None = None,
    *,
    equilibrium: bool = False,
    mode: int | None = None,
    parameters: Mapping[str, Any] | None = None,
    rate: float | None = None,
    size_limit: float = SIZE_LIMIT,
    show: bool = False,
) -> Animation:
    """Draw a model at its start, or play a result, in one HTML file: `fw.view(model)`, `fw.view(result, path)`.

    path         the file, .html; None: the name of the model, in the current folder
    equilibrium  a model: at its mean position instead of its start; in constant wind and still water
    mode         a model: moving in the natural mode of this number, see fowtlib.analysis.natural_modes; one period is
                 shown again and again in 3 s, the largest displacement is 8 % of the size of the bodies
    parameters   a model: values of tunable parameters, as for `plant.initial_state`
    rate         a result: moments shown for each simulated second, at most as many as the result has; between them the
                 browser interpolates. None: 10, of a run shorter than 60 s more. To keep the file below size_limit
                 [bytes] they become fewer.
    show         open the file in the browser

    Raises ModelError: a result without a model or without moments, nothing to draw, a file that cannot be written.
    """
    if rate is not None and not rate > 0:
        raise ModelError(f"view: {rate:g} moments per second cannot be shown; give a positive rate.")
    if isinstance(subject, Result):
        root = _with_values(subject.root, subject.attributes["parameters"])
        cast = Cast(root.drawing())
        names = chosen([name for name in subject if subject.array(name).ndim == 1])
        most = max(2, int(size_limit / cast.bytes_per_moment(len(names))))
        recording = _of_result(subject, root, names, moments_of(subject.time, rate, most))
        name = subject.attributes["model"]
    elif isinstance(subject, Model | Plant):
        recording = _of_mode(subject, mode, parameters) if mode else _of_model(subject, equilibrium, parameters)
        cast, name = Cast(recording.root.drawing()), subject.name
    else:
        raise ModelError(f"view: a Model, a Plant or a Result can be drawn, not a {type(subject).__name__}.")
    target = _target(path if path is not None else f"{name or 'model'}.html")
    text = page(scene(cast, recording))
    write_text(target, text)
    time = recording.time
    span = float(time[-1] - time[0])
    animation = Animation(target, time.size, (time.size - 1) / span if span else 0.0, len(text.encode()))
    if show and not webbrowser.open(target.resolve().as_uri()):
        warnings.warn(f"no browser was found; open {target} in one yourself.", stacklevel=2)
    return animation


def scene(cast: Cast, recording: Recording) -> dict[str, Any]:
    """Everything the browser draws, ready for JSON: numbers as base64 of little-endian arrays."""
    moments = recording.time.size
    poses = cast.poses(recording.observe, moments)
    lines = cast.lines(recording.observe, moments)
    speeds, bearings = cast.speeds(recording.observe, moments), cast.bearings(recording.observe, moments)
    bodies = _bounds([_placed(poses[0], number, _points(shape)) for number, shape in cast.solids] or [lines[0][0]])
    solids = [(number, shape, meshes.mesh(shape, bodies["size"])) for number, shape in cast.solids]
    seen = poses[np.linspace(0, moments - 1, min(moments, 25)).astype(int)]
    placed = [_placed(rows, number, solid.points[::5]) for number, _, solid in solids for rows in seen]
    bodies = _bounds(placed) if placed else bodies
    whole = [*placed, *(line.reshape(-1, 3) for line in lines)]
    if cast.water is not None:
        whole.append(np.zeros((1, 3)))
    return {
        "title": recording.title,
        "status": recording.status,
        "loop": recording.loop,
        "azimuths": _azimuths(lines),
        "time": _packed(recording.time, "<f8"),
        "frames": cast.names,
        "poses": _packed(poses, "<f4"),
        "follow": next((number for number, _ in cast.solids if number >= 0), -1),
        "meshes": [
            {"frame": number, "material": shape.material, **_mesh(solid)} for number, shape, solid in solids
        ],
        "curves": [_curve(shape, line, bodies["size"]) for shape, line in zip(cast.curves, lines, strict=True)],
        "arrows": [
            {
                "tip": list(arrow.tip), "direction": list(arrow.direction),
                "lengths": _packed(arrow.scale * speed, "<f4"),
                "bearings": None if bearing is None else _packed(bearing, "<f4"),
            }
            for arrow, speed, bearing in zip(cast.arrows, speeds.T, bearings, strict=True)
        ],  # fmt: skip
        "arrow": _mesh(meshes.arrow()),
        "water": _water(cast.water),
        "readings": [
            {"name": item.name, "unit": item.unit, "about": item.long_name, "values": _packed(item.values, "<f4")}
            for item in recording.readings
        ],
        "bodies": bodies,
        "whole": _bounds(whole),
    }


def page(content: Mapping[str, Any]) -> str:
    """The HTML page of a scene, with its program and its data inside."""
    folder = resources.files("fowtlib.view")
    template, script = ((folder / name).read_text(encoding="utf-8") for name in ("scene.html", "scene.js"))
    data = json.dumps(content, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")
    for mark, text in (("<!--title-->", html.escape(content["title"])), ("/*program*/", script), ("/*scene*/", data)):
        template = template.replace(mark, text)
    return template


def _of_result(result: Result, root: Any, names: list[str], numbers: np.ndarray) -> Recording:
    if not result.time.size:
        raise ModelError("the result is empty: there is no moment to draw.")
    readings = [Reading(n, result.unit(n), result.long_name(n), result.array(n)[numbers]) for n in names]
    title = str(result.attributes["title"] or result.attributes["model"] or "result")
    status = str(result.attributes["status"])

    def observe(paths: Any) -> np.ndarray:
        return result.observe(paths)[numbers]

    return Recording(root, result.time[numbers], observe, readings, title, status)


def _of_model(model: Model | Plant, equilibrium: bool, parameters: Mapping[str, Any] | None) -> Recording:
    plant = model if isinstance(model, Plant) else model.compile()
    state = mean_state(plant, parameters) if equilibrium else plant.initial_state(parameters)
    result = played(plant, [state], np.array([state.t]))
    status = "at its mean position." if equilibrium else "at the start."
    root = _with_values(model.root, plant.parameter_values(parameters))
    return Recording(root, result.time, result.observe, _readings(plant, result), _title(model), status)


def _of_mode(model: Model | Plant, number: int, parameters: Mapping[str, Any] | None) -> Recording:
    plant = model if isinstance(model, Plant) else model.compile()
    state = mean_state(plant, parameters)
    mode = mode_of(plant, number, state)
    root = _with_values(model.root, plant.parameter_values(parameters))
    states = mode_states(plant, Cast(root.drawing()), mode, state)
    result = played(plant, states, np.linspace(0.0, CYCLE, len(states)))
    status = (
        f"mode {mode.number}, {mode.name}: {mode.frequency:.4g} Hz, period {mode.period:.4g} s, damping ratio "
        f"{100 * mode.damping_ratio:.3g} %. Exaggerated; one period in {CYCLE:g} s."
    )
    return Recording(root, result.time, result.observe, _readings(plant, result), _title(model), status, loop=True)


def _title(model: Model | Plant) -> str:
    return model.title or model.name or type(model.root).__name__


def _azimuths(lines: Iterable[np.ndarray]) -> dict[str, float]:
    """From where the camera looks in the first view and in that of everything [deg], not along a mooring line."""
    ends = [line[0, -1, :2] - line[0, 0, :2] for line in lines]
    longest = max((float(np.hypot(*end)) for end in ends), default=0.0)
    along = np.array([np.degrees(np.arctan2(end[1], end[0])) for end in ends if np.hypot(*end) > 0.5 * longest > 0])

    def apart(azimuth: float) -> float:
        return float(np.min(np.abs((along - azimuth + 90) % 180 - 90), initial=90.0))

    def free(wanted: float) -> float:
        near = sorted((wanted + turn for turn in range(-45, 46)), key=lambda azimuth: abs(azimuth - wanted))
        return next((azimuth for azimuth in near if apart(azimuth) >= CLEAR), max(near, key=apart))

    return {"start": free(-128.0), "all": free(-118.0)}


def _readings(plant: Plant, result: Result) -> list[Reading]:
    """The declared results of a model at one moment."""
    from fowtlib.language.units import from_si

    found = []
    for name in chosen(plant.outputs):
        path, unit, doc = plant.outputs[name]
        value = result.array(path)
        if value.ndim == 1:
            found.append(Reading(name, unit, doc, np.asarray(from_si(value, plant.describe(path)[0], unit))))
    return found


def chosen(names: Iterable[str]) -> list[str]:
    """The results to read: the usual ones of a floating turbine, or the first few of anything else."""

    def rank(name: str) -> int:
        return min((number for key, number in ORDER.items() if name.startswith(key)), default=len(ORDER))

    ranked = sorted(names, key=rank)
    usual = [name for name in ranked if rank(name) < len(ORDER)]
    return max(usual[: READINGS[0]], ranked[: READINGS[1]], key=len)


def _with_values(root: Any, parameters: Mapping[str, Any]) -> Any:
    """The component tree with the values of tunable parameters that a run had."""
    changed = {}
    for path, value in parameters.items():
        owner, _, name = path.rpartition(".")
        if not np.array_equal(np.asarray(root.find(owner).parameter_value(name), dtype=float), value):
            changed[path] = value
    return Model(root).with_parameters(changed).root if changed else root


def _target(path: str | Path) -> Path:
    target = Path(path)
    if target.suffix not in (".html", ".htm"):
        raise ModelError(f"{target}: a view is saved as .html, not as '{target.suffix or 'no ending'}'.")
    if not target.parent.is_dir():
        raise ModelError(f"{target}: the folder {target.parent} does not exist. Make it first, or choose another one.")
    return target


# -- numbers for the browser ------------------------------------------------------------------------------------------


def _packed(values: Any, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def _mesh(solid: meshes.Mesh) -> dict[str, str]:
    return {
        "points": _packed(solid.points, "<f4"),
        "normals": _packed(solid.normals, "<f4"),
        "triangles": _packed(solid.triangles, "<u4"),
    }


def _curve(shape: shapes.Curve, line: np.ndarray, size: float) -> dict[str, Any]:
    """Points as 16-bit steps between the lowest and the highest place of the whole curve (1 cm in 700 m)."""
    low, high = line.min(axis=(0, 1)), line.max(axis=(0, 1))
    step = np.maximum(high - low, 1e-9) / 65535
    diameter = meshes.ROD * size / 2 if shape.diameter is None else shape.diameter
    return {
        "material": shape.material,
        "diameter": float(diameter),
        "count": line.shape[1],
        "low": low.tolist(),
        "step": step.tolist(),
        "points": _packed(np.rint((line - low) / step), "<u2"),
    }


def _water(water: shapes.Water | None) -> dict[str, Any] | None:
    if water is None:
        return None
    waves = {name: _packed(getattr(water, name), "<f8") for name in ("omega", "amplitude", "phase", "wave_number")}
    return {"depth": water.depth, "heading": water.heading, "build_up": water.build_up, **waves}


def _points(shape: shapes.Shape) -> np.ndarray:
    """Points of a shape that tell how large a picture is, before sizes are chosen."""
    if isinstance(shape, shapes.Tube):
        return shape.points
    if isinstance(shape, shapes.Loft):
        return shape.sections.reshape(-1, 3)
    return np.atleast_2d(shape.centre)


def _placed(poses: np.ndarray, number: int, points: np.ndarray) -> np.ndarray:
    """Points of a frame in the world."""
    if number < 0:
        return points
    position, axis, w = poses[number, :3], poses[number, 3:6], poses[number, 6]
    return position + points + 2 * np.cross(axis, np.cross(axis, points) + w * points)


def _bounds(groups: list[np.ndarray]) -> dict[str, Any]:
    """Centre and diagonal of the box around points."""
    points = np.concatenate([group.reshape(-1, 3) for group in groups])
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    return {"centre": ((low + high) / 2).tolist(), "size": size or 1.0, "low": float(low[2])}
