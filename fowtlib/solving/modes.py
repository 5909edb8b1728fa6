"""Natural modes with the names that people use: platform pitch, 1st tower fore-aft, 1st blade flap collective.

A component says what its coordinates are called in a mode by the class attribute ``mode_names``: a pattern of the
path of a state below it (``beam.*.phi_x``; an index is written behind a dot) -> a name, in which ``{part}`` stands for
the name of the part and ``{parent}`` for that of the part around it. States that only remember, of a filter, a
controller or the radiated waves, have no such name; ``memory`` of their part says what they are. The part nearest to
the root decides.

A mode is called after the coordinates that take the largest part in it (participation: left times right eigenvector),
such that no name is given to more modes than it has coordinates: of two nearly equal modes one is surge, the other
sway. Parts that stand in a ring, such as blades, move together (collective), or as the cosine or the sine of their
azimuth (R. P. Coleman and A. M. Feingold, NACA Report 1351, 1958); the two with a quarter of a period between them run
round, with the rotor (progressive) or against it (regressive). Of rotors that turn, the modes are those of the mean in
multi-blade coordinates (solving.mean_linear): what is seen from the tower, where a blade that swings with the frequency
f shows f - n and f + n, n the revolutions per second.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from fowtlib.language.errors import NotFoundError, SimulationError
from fowtlib.solving.mean_linear import RotatingLinearModel, rotating_linear_model
from fowtlib.solving.multiblade import LEAST, multiblade_parts
from fowtlib.solving.rates import rate_states
from fowtlib.solving.turning import mean_state

STANDING = 1e-7  # of the fastest eigenvalue: a motion that nothing holds, zero twice and split by rounding
MOTIONS = ("m", "rad", "m/s", "rad/s")  # units of the states of a motion
ALONE = 0.3  # of two sides: one moves by less than this part of the other
WITH = 0.6  # a second name is worth saying when its share is this part of the first
HARMONICS = ("collective", "cosine", "sine")


@dataclass(frozen=True)
class NaturalMode:
    """A mode by its number and its name. The motions that oscillate have the numbers 1, 2, ...; then comes the rest.

    frequency [Hz] is the undamped one; `shares` of the names (their sum is 1); `shape`: complex amplitude of each
    state, 1 at the largest; motion: False for a mode of filters, controllers or radiated waves alone.
    """

    number: int
    name: str
    frequency: float
    damping_ratio: float
    eigenvalue: complex
    motion: bool
    shares: Mapping[str, float] = field(repr=False)
    shape: Mapping[str, complex] = field(repr=False)

    def __repr__(self) -> str:
        numbers = f"{self.frequency:.4g} Hz, {self.period:.4g} s, damping ratio {self.damping_ratio:.3g}"
        return f"<NaturalMode {self.number} {self.name}: {numbers}>"

    @property
    def period(self) -> float:
        """Undamped period [s]."""
        return 1.0 / self.frequency if self.frequency else float("inf")

    @property
    def oscillates(self) -> bool:
        """False for a motion that creeps back without passing its place of rest."""
        return self.eigenvalue.imag > 0.0


@dataclass(frozen=True)
class _Coordinate:
    """A state: the name of its motion, the part that gave the name or stands in a ring, its path below that part."""

    path: str
    name: str
    owner: str
    inner: str
    rate: bool
    motion: bool


@dataclass
class _Ring:
    """Parts in a ring, and the azimuth of the first [rad]; fixed: the parts are multi-blade coordinates."""

    parts: list[str]
    azimuth: float
    fixed: bool = False


@dataclass
class _Named:
    """What is known of a mode while it gets its name."""

    mode: Any
    shares: dict[str, float]
    motion: bool


def natural_modes(plant: Any, state: Any = None, *, parameters: Mapping[str, Any] | None = None) -> list[NaturalMode]:
    """The modes of a compiled model about a state, without one about its equilibrium; slowest first.

    Modes that do not oscillate, and those of memory (`motion` False), are in the list too.
    """
    return modes_of_mean(plant, state, parameters=parameters)[0]


def modes_of_mean(
    plant: Any, state: Any = None, *, parameters: Mapping[str, Any] | None = None
) -> tuple[list[NaturalMode], RotatingLinearModel]:
    """The same, and the linear model that they are of.

    Raises SimulationError for rotors of two blades that bend and turn.
    """
    if state is None:
        state = mean_state(plant, parameters)
    found = rotating_linear_model(plant, state, outputs=[])
    modes, multiblade = found.linear.modes(), found.average.multiblade if found.average else None
    if multiblade is not None and multiblade.two_bladed:
        raise SimulationError(
            f"{', '.join(multiblade.two_bladed)} turn and bend: a rotor of two blades is periodic to anyone, and has "
            "no modes of a mean. Take the modes at rest (--wind none), or rigid blades."
        )
    rings = _rings(plant, state, multiblade)
    units = [item.unit for item in plant.dae.states]
    paths = multiblade.paths() if multiblade is not None else [item.path for item in plant.dae.states]
    kept = set(found.linear.states)
    named_states = [(path, unit) for path, unit in zip(paths, units, strict=True) if path in kept]
    coordinates = plant.functions.once(("coordinates", tuple(named_states), tuple(ring.parts[0] for ring in rings)),
                                       lambda: _coordinates(plant, rings, named_states))  # fmt: skip
    fastest = max((abs(mode.eigenvalue) for mode in modes), default=0.0)
    modes = [mode for mode in modes if abs(mode.eigenvalue) > STANDING * fastest]
    memories = {c.name for c in coordinates if not c.motion}
    named = []
    for mode in modes:
        shares = _shares(mode, coordinates, rings)
        first = max(shares, key=shares.__getitem__)
        named.append(_Named(mode, shares, first not in memories))
    names = _names(named, coordinates, rings)
    asked = [k for k, item in enumerate(named) if item.motion and item.mode.eigenvalue.imag > 0]
    number = {k: i + 1 for i, k in enumerate([*asked, *(k for k in range(len(named)) if k not in asked)])}
    modes = [
        NaturalMode(number[k], name, item.mode.frequency_hz, item.mode.damping_ratio, item.mode.eigenvalue, item.motion,
                    item.shares, _of_states(plant, state, multiblade, paths, item.mode.shape))
        for k, (item, name) in enumerate(zip(named, names, strict=True))
    ]  # fmt: skip
    return modes, found


def _of_states(plant: Any, state: Any, multiblade: Any, paths: Sequence[str],
               shape: Mapping[str, complex]) -> dict[str, complex]:  # fmt: skip
    """Amplitudes of the states at the azimuths of the state; 0 of those that are no states of the linear model."""
    y = np.array([shape.get(path, 0.0) for path in paths], dtype=complex)
    x = y if multiblade is None else multiblade.states(state.x) @ y
    peak = x[np.argmax(np.abs(x))] if np.any(x) else 1.0
    return {item.path: complex(value) for item, value in zip(plant.dae.states, x / peak, strict=True)}


# -- what the states are called ---------------------------------------------------------------------------------------


def _rings(plant: Any, state: Any, multiblade: Any) -> list[_Ring]:
    """The parts that stand in rings; of rings that turn, their multi-blade coordinates."""
    turning = {ring.parts: multiblade_parts(ring.parts) for ring in (multiblade.rings if multiblade else ())}
    found = []
    for ring in plant.dae.symmetries:
        parts = tuple(ring.parts)
        if parts in turning:
            found.append(_Ring(turning[parts], _angle(plant, ring.angle, state), fixed=True))
        elif len(parts) > 1:
            found.append(_Ring(list(parts), _angle(plant, ring.angle, state)))
    return found


def _coordinates(plant: Any, rings: Sequence[_Ring], states: Sequence[tuple[str, str]]) -> list[_Coordinate]:
    """What the states (path, unit) of a linear model are called."""
    results = {path: name for name, (path, _, _) in plant.outputs.items()}
    standing = {name: parts[0] for parts in (ring.parts for ring in plant.dae.symmetries) if len(parts) >= LEAST
                for name in multiblade_parts(parts)}  # fmt: skip
    found = []
    for path, unit in states:
        part = next((name for name in standing if path.startswith(f"{name}.")), None)
        own = path if part is None else path.replace(part, standing[part], 1)
        found.append(replace(_coordinate(plant.root, own, unit, results), path=path))
    numbers = {c.path: k for k, c in enumerate(found)}
    own_paths = [item.path for item in plant.dae.states]
    for position, rate in rate_states(plant.dae).items():  # what has no name of its own is called after its position
        k, j = numbers.get(own_paths[position]), numbers.get(own_paths[rate])
        if k is not None and j is not None and found[j].name == found[j].path:
            found[j] = replace(found[j], name=found[k].name, rate=True, motion=found[k].motion)
    circled = [part for ring in rings for part in ring.parts]
    for k, c in enumerate(found):
        part = next((part for part in circled if c.path.startswith(f"{part}.")), None)
        if part is not None:
            found[k] = replace(c, owner=part, inner=c.path.removeprefix(f"{part}."))
    return found


def _coordinate(root: Any, path: str, unit: str, results: Mapping[str, str]) -> _Coordinate:
    words = path.split(".")
    rate = unit.endswith("/s")
    for depth in range(len(words)):
        owner, inner = ".".join(words[:depth]), ".".join(words[depth:])
        try:
            part = root.find(owner)
        except NotFoundError:
            break
        memory = getattr(type(part), "memory", "")
        if isinstance(memory, str) and memory:
            return _Coordinate(path, memory, owner, inner, rate, False)
        given = getattr(type(part), "mode_names", {})
        name = next((name for pattern, name in given.items() if fnmatchcase(_flat(inner), pattern)), "")
        if name:
            name = name.format(part=words[depth - 1] if depth else "", parent=words[depth - 2] if depth > 1 else "")
            return _Coordinate(path, " ".join(name.replace("_", " ").split()), owner, inner, rate, True)
    return _Coordinate(path, results.get(path, path), ".".join(words[:-1]), words[-1], rate, unit in MOTIONS)


def _flat(path: str) -> str:
    """An index behind a dot: `velocity[0]` is `velocity.0`."""
    return path.replace("[", ".").replace("]", "").replace(",", ".")


def _angle(plant: Any, expression: Any, state: Any) -> float:
    """The angle of a ring at a state; 0 where it is no state."""
    states = {plant.dae.x[i].element_hash(): i for i in range(plant.dae.x.shape[0])}
    number = states.get(expression.element_hash())
    return 0.0 if number is None else float(state.x[number])


# -- shares -----------------------------------------------------------------------------------------------------------


def _shares(mode: Any, coordinates: Sequence[_Coordinate], rings: Sequence[_Ring]) -> dict[str, float]:
    """Share of each name; that of parts in a ring is divided among their harmonics."""
    shares: dict[str, float] = defaultdict(float)
    circled: dict[tuple[str, int], float] = defaultdict(float)
    for c in coordinates:
        ring = _ring_of(c, rings) if rings else None
        if ring is None:
            shares[c.name] += mode.participation[c.path]
        else:
            circled[c.name, ring] += mode.participation[c.path]
    for (name, ring), share in circled.items():
        parts = _harmonics(mode, name, rings[ring], coordinates)
        squares = {word: float(np.vdot(vector, vector).real) for word, vector in parts.items()}
        whole = sum(squares.values())
        for word, square in squares.items():
            shares[f"{name} {word}"] += share * square / whole if whole > 0 else 0.0
    return dict(shares)


def _ring_of(coordinate: _Coordinate, rings: Sequence[_Ring]) -> int | None:
    return next((k for k, ring in enumerate(rings) if coordinate.owner in ring.parts), None)


def _harmonics(mode: Any, name: str, ring: _Ring, coordinates: Sequence[_Coordinate]) -> dict[str, np.ndarray]:
    """Complex amplitudes of the coordinates of this name over a ring: of the mean, of the cosine, of the sine.

    They are weighted such that the sum of their squares is that of the parts. Two parts have mean and difference.
    """
    table = np.array([_amplitudes(mode, name, part, coordinates) for part in ring.parts])
    count = len(ring.parts)
    if ring.fixed:
        weights = np.sqrt([count, count / 2, count / 2])
        return dict(zip(HARMONICS, weights[:, None] * table[:3], strict=True))
    if count < 3:
        return {"collective": table.sum(0) / np.sqrt(count), "teetering": (table[0] - table[-1]) / np.sqrt(count)}
    azimuth = ring.azimuth + 2 * np.pi * np.arange(count) / count
    weight = np.sqrt(2 / count)
    vectors = table.sum(0) / np.sqrt(count), weight * np.cos(azimuth) @ table, weight * np.sin(azimuth) @ table
    return dict(zip(HARMONICS, vectors, strict=True))


def _amplitudes(mode: Any, name: str, owner: str, coordinates: Iterable[_Coordinate]) -> np.ndarray:
    """Complex amplitudes of the positions of this name in one part; of its rates where it has no positions."""
    of = sorted((c for c in coordinates if c.name == name and c.owner == owner), key=lambda c: c.inner)
    positions = [c for c in of if not c.rate] or of
    return np.array([mode.shape[c.path] for c in positions])


# -- names ------------------------------------------------------------------------------------------------------------


def _names(named: Sequence[_Named], coordinates: Sequence[_Coordinate], rings: Sequence[_Ring]) -> list[str]:
    """The name of each mode, with its number among those of one name."""
    room = _room(coordinates, rings)
    chosen = _assigned([item for item in named if item.motion and item.mode.eigenvalue.imag > 0], room)
    names: list[str] = []
    count: dict[str, int] = defaultdict(int)
    for item in named:
        label = chosen.get(id(item)) or max(item.shares, key=item.shares.__getitem__)
        name = _whirl(item, label, coordinates, rings) + _side(item, label, coordinates, rings)
        if item.motion and room.get(label, 0) > 1:
            count[name] += 1
            name = f"{ordinal(count[name])} {name}"
        others = {key: share for key, share in item.shares.items() if key != label and key in room}
        other = max(others, key=others.__getitem__, default="")
        beside = other and item.motion and item.shares[other] > max(WITH * item.shares[label], 0.1)
        names.append(f"{name}, with {other}" if beside and not _related(label, other) else name)
    return names


def ordinal(number: int) -> str:
    """`1st`, `2nd`, `3rd`, `4th`, `11th`, `21st`."""
    last = 0 if number % 100 in (11, 12, 13) else number % 10
    return f"{number}{ {1: 'st', 2: 'nd', 3: 'rd'}.get(last, 'th') }"


def _room(coordinates: Sequence[_Coordinate], rings: Sequence[_Ring]) -> dict[str, int]:
    """How many modes each name has room for: the number of its coordinates."""
    room: dict[str, int] = defaultdict(int)
    for c in coordinates:
        ring = _ring_of(c, rings)
        if not c.motion or (c.rate and any(d.name == c.name and not d.rate for d in coordinates)):
            continue
        if ring is None:
            room[c.name] += 1
        elif c.owner == rings[ring].parts[0]:
            for word in HARMONICS if len(rings[ring].parts) > 2 else ("collective", "teetering"):
                room[f"{c.name} {word}"] += 1
    return dict(room)


def _assigned(named: Sequence[_Named], room: Mapping[str, int]) -> dict[int, str]:
    """The name of each mode such that the sum of the shares is largest and no name is given too often."""
    from scipy.optimize import linear_sum_assignment

    places = [name for name, count in room.items() for _ in range(count)]
    if not named or not places:
        return {}
    table = np.array([[item.shares.get(name, 0.0) for name in places] for item in named])
    rows, columns = linear_sum_assignment(table, maximize=True)
    return {id(named[i]): places[k] for i, k in zip(rows, columns, strict=True)}


def _whirl(item: _Named, label: str, coordinates: Sequence[_Coordinate], rings: Sequence[_Ring]) -> str:
    """The name; of cosine and sine with a quarter of a period between them the direction in which they run round."""
    base, _, word = label.rpartition(" ")
    if word not in ("cosine", "sine"):
        return label
    shares = [item.shares.get(f"{base} {harmonic}", 0.0) for harmonic in ("cosine", "sine")]
    if min(shares) < ALONE * max(shares):
        return label
    product = 0.0
    for ring in rings:
        parts = _harmonics(item.mode, base, ring, coordinates)
        if "cosine" in parts and parts["cosine"].size:
            product += np.vdot(parts["cosine"], parts["sine"])
    if abs(product.imag) < 2 * abs(product.real):
        return label
    return f"{base} {'progressive' if product.imag < 0 else 'regressive'}"


def _side(item: _Named, label: str, coordinates: Sequence[_Coordinate], rings: Sequence[_Ring]) -> str:
    """Where two equal parts or rings have this name: whether they move alike, against each other, or one alone."""
    base, _, word = label.rpartition(" ")
    vectors: dict[str, np.ndarray] = {}
    for ring in rings:
        parts = _harmonics(item.mode, base, ring, coordinates)
        if word in parts and parts[word].size:
            vectors[ring.parts[0]] = parts[word]
    if not vectors:
        owners = dict.fromkeys(c.owner for c in coordinates if c.name == label)
        vectors = {owner: _amplitudes(item.mode, label, owner, coordinates) for owner in owners}
    if len(vectors) != 2 or len({vector.shape for vector in vectors.values()}) > 1:
        return ""
    (one, a), (two, b) = vectors.items()
    sizes = np.linalg.norm(a), np.linalg.norm(b)
    if min(sizes) < ALONE * max(sizes):
        return f", {_difference(one, two) if sizes[0] > sizes[1] else _difference(two, one)}"
    return ", in phase" if np.vdot(a, b).real > 0 else ", in opposition"


def _difference(path: str, other: str) -> str:
    """The first word of a path that the other has not."""
    return next((a.replace("_", " ") for a, b in zip(path.split("."), other.split("."), strict=False) if a != b), path)


def _related(label: str, other: str) -> bool:
    """True for two harmonics of one ring."""
    return label.rpartition(" ")[0] == other.rpartition(" ")[0] and other.rpartition(" ")[2] in HARMONICS
