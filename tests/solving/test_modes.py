"""Natural modes get the names that people use, each one once."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.mechanics import Fixed, PointMass, Prismatic, SpringDamper
from fowtlib.solving.modes import _Coordinate, _harmonics, _Named, _Ring, _whirl, natural_modes, ordinal

CALM = {"sea.spectrum": "still", "wind.kind": "none"}


@pytest.fixture(scope="module")
def spar():
    return natural_modes(fw.load("oc3_spar").with_parameters(CALM).compile())


def test_the_modes_of_a_floating_turbine(spar):
    """Frequencies of the whole turbine: J. Jonkman and W. Musial, NREL/TP-5000-48191 (2010), figure 4 and section 3.2.

    The platform to 10 % (their mean of the participants), the tower and the blades near 0.47 Hz, 0.70 Hz and 1.1 Hz.
    """
    shown = {mode.name: mode for mode in spar if mode.motion and mode.oscillates}
    expected = {"platform surge": 0.008, "platform sway": 0.008, "platform heave": 0.0324, "platform pitch": 0.0342,
                "platform roll": 0.0342, "platform yaw": 0.121, "1st tower fore-aft": 0.473,
                "1st tower side-side": 0.49, "1st blade flap collective": 0.70, "1st blade edge sine": 1.08,
                "1st blade edge cosine": 1.10}  # fmt: skip
    for name, frequency in expected.items():
        assert shown[name].frequency == pytest.approx(frequency, rel=0.05), name
        assert shown[name].shares[name.removeprefix("1st ")] > 0.5
    assert [mode.number for mode in shown.values()] == list(range(1, len(shown) + 1))


def test_no_mode_is_listed_twice(spar):
    names = [mode.name for mode in spar if mode.motion and mode.oscillates]
    assert len(names) == len(set(names))
    memory = {mode.name for mode in spar if not mode.motion}
    assert "radiated waves" in memory and not any("blade" in name or "platform" in name for name in memory)
    assert all(sum(mode.shares.values()) == pytest.approx(1.0) for mode in spar)


def test_two_rotors_move_together_or_against_each_other():
    modes = natural_modes(fw.load("two_rotor_support").compile())
    by_name = {mode.name: mode for mode in modes if mode.oscillates}
    alike, against = by_name["1st arm vertical, in phase"], by_name["1st arm vertical, in opposition"]
    left, right = (f"support.arm_{side}.beam.hinge_1.bending.phi_y" for side in ("left", "right"))
    assert (alike.shape[left] / alike.shape[right]).real > 0 > (against.shape[left] / against.shape[right]).real


def square(angle: float) -> fw.Model:
    """A mass on equal springs along two axes: its two modes have one frequency, and any direction."""
    root = fw.Assembly("square")
    root.world = World(gravity=0.0)
    c, s = math.cos(angle), math.sin(angle)
    root.east, root.north, root.mass = Prismatic(n=(c, s, 0)), Prismatic(n=(-s, c, 0)), PointMass(mass=2.0)
    root.connect(root.world.frame, root.east.frame_a)
    root.connect(root.east.frame_b, root.north.frame_a)
    root.connect(root.north.frame_b, root.mass.frame_a)
    for k, place in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        wall = root.add(f"wall_{k}", Fixed(r=(100 * place[0], 100 * place[1], 0)))
        spring = root.add(f"spring_{k}", SpringDamper(stiffness=50.0, natural_length=99.0))
        root.connect(wall.frame, spring.frame_a)
        root.connect(spring.frame_b, root.mass.frame_a)
    outputs = {"east": fw.Output("east.s"), "north": fw.Output("north.s")}
    return fw.Model(root, outputs=outputs)


@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 4])
def test_of_two_equal_modes_each_name_is_given_once(angle):
    modes = natural_modes(square(angle).compile())
    assert {mode.name.partition(",")[0] for mode in modes} == {"east", "north"}
    # along: two springs of 50 N/m; across them their tension of 50 N over 100 m: k = 2 (50 + 0.5) N/m
    assert [mode.frequency for mode in modes] == pytest.approx([math.sqrt(101 / 2) / (2 * math.pi)] * 2, rel=1e-6)


def ring_mode(amplitudes, azimuth=0.3):
    """A mode in which three blades have these amplitudes, as a function of the azimuth of each."""
    ring = _Ring(["a", "b", "c"], azimuth)
    places = azimuth + 2 * np.pi * np.arange(3) / 3
    coordinates = [_Coordinate(f"{p}.phi", "blade flap", p, "phi", False, True) for p in ring.parts]
    mode = SimpleNamespace(shape={c.path: complex(amplitudes(a)) for c, a in zip(coordinates, places, strict=True)})
    return mode, ring, coordinates


@pytest.mark.parametrize(
    ("amplitudes", "squares"),
    [
        (lambda a: 1.0, {"collective": 3.0, "cosine": 0.0, "sine": 0.0}),
        (lambda a: math.cos(a), {"collective": 0.0, "cosine": 1.5, "sine": 0.0}),
        (lambda a: 2 * math.sin(a), {"collective": 0.0, "cosine": 0.0, "sine": 6.0}),
        (lambda a: 1 + 1j * math.cos(a), {"collective": 3.0, "cosine": 1.5, "sine": 0.0}),
    ],
)
def test_harmonics_of_a_ring(amplitudes, squares):
    mode, ring, coordinates = ring_mode(amplitudes)
    found = {k: np.vdot(v, v).real for k, v in _harmonics(mode, "blade flap", ring, coordinates).items()}
    assert found == pytest.approx(squares, abs=1e-12)


@pytest.mark.parametrize(
    ("amplitudes", "name"),
    [
        # the displacement cos(omega t - a) has its crest at a = omega t: it runs with the rotor
        (lambda a: np.exp(-1j * a), "blade flap progressive"),
        (lambda a: np.exp(1j * a), "blade flap regressive"),
        (lambda a: np.cos(a - 0.7), "blade flap cosine"),  # a standing wave between the two
    ],
)
def test_the_direction_of_a_whirl(amplitudes, name):
    mode, ring, coordinates = ring_mode(amplitudes)
    shares = {"blade flap cosine": 0.5, "blade flap sine": 0.5}
    assert _whirl(_Named(mode, shares, True), "blade flap cosine", coordinates, [ring]) == name


def test_ordinals():
    assert [ordinal(n) for n in (1, 2, 3, 4, 11, 12, 13, 21, 102, 111)] == [
        "1st", "2nd", "3rd", "4th", "11th", "12th", "13th", "21st", "102nd", "111th",
    ]  # fmt: skip
