"""What a free surface takes from the stability of a floating box, from its linear model and from tilted tanks."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, PrismaticTank, RoundTank, TabulatedTank
from fowtlib.components.mechanics import Fixed, Frame
from fowtlib.language import Component, eq, open_input, port
from tests.flooding.floating import DRAFT, GRAVITY, KG, LENGTH, RHO, VOLUME, WIDTH, floating_box

WATER = 120.0
RING = math.pi / 64 * (10**4 - 5**4)
TANKS = {
    "box": (lambda **s: BoxTank(length=10, width=8, height=4, **s), 80.0, (10 * 8**3 / 12, 8 * 10**3 / 12)),
    "round": (lambda **s: RoundTank(diameter=9, height=4, **s), math.pi / 4 * 81, (math.pi / 64 * 9**4,) * 2),
    "ring": (
        lambda **s: RoundTank(diameter=10, inner_diameter=5, height=4, **s), math.pi / 4 * 75, (RING, RING),
    ),
    "prism": (
        lambda **s: PrismaticTank(
            area=80, second_moments=(8e3 / 12, 5120 / 12, 0), half_length=5, half_width=4, height=4, **s
        ),
        80.0, (5120 / 12, 8e3 / 12),
    ),
    "table": (
        lambda **s: TabulatedTank(
            levels=(0, 2, 4), areas=(80, 80, 80), second_moments=[(8e3 / 12, 5120 / 12, 0)] * 3, **s
        ),
        80.0, (5120 / 12, 8e3 / 12),
    ),
}  # fmt: skip


class Push(Component):
    """Six loads on a frame, from outside of the model."""

    frame: Frame = port(doc="where they act")

    def equations(self):
        load = open_input("load", 6, "", "force [N] and moment [N m], world")
        return [eq(self.frame.f, -load[:3]), eq(self.frame.t, -load[3:])]


def static_stiffness(model: fw.Assembly) -> np.ndarray:
    """Loads (6, 6) that hold the box at displacements, from its linear model; all that is free in it follows."""
    model.push = Push()
    model.connect(model.motion.frame_b, model.push.frame)
    plant = fw.load(model).compile()
    linear = plant.linearize(plant.equilibrium(), inputs=["push.load"])
    A, B, names = linear.A.values, linear.B.values, list(linear.states)
    held = [names.index(f"motion.{name}") for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")]
    speeds = [names.index(f"motion.{name}[{i}]") for name in ("velocity", "angle_rates") for i in range(3)]
    sloshing = [i for i, name in enumerate(names) if "slosh[" in name]
    rows = speeds + [i for i, name in enumerate(names) if "slosh_velocity[" in name]
    matrix = np.hstack([A[np.ix_(rows, sloshing)], B[rows]])
    return np.linalg.solve(matrix, -A[np.ix_(rows, held)])[len(sloshing) :]


@pytest.mark.parametrize(("shape", "sloshing"), [*((shape, False) for shape in TANKS), ("box", True), ("round", True)])
def test_a_free_surface_takes_rho_i_over_the_displaced_mass_from_gm(shape, sloshing):
    """GM = KB + BM - KG - rho i / (rho_w V), exactly, also when its first mode sloshes; the water counts in KG."""
    tank, area, moments = TANKS[shape]
    floor = -2.5
    more = {"sloshing": True} if sloshing else {}
    K = static_stiffness(floating_box(("tank", tank(volume_start=WATER, place=(0, 0, floor), **more)), water=WATER))
    centre = (WATER * (floor + WATER / area / 2) + (VOLUME - WATER) * KG) / VOLUME
    for i, (breadth, length, moment) in enumerate(((WIDTH, LENGTH, moments[0]), (LENGTH, WIDTH, moments[1]))):
        gm = -DRAFT / 2 + length * breadth**3 / 12 / VOLUME - centre - moment / VOLUME
        assert K[3 + i, 3 + i] == pytest.approx(RHO * GRAVITY * VOLUME * gm, rel=1e-7)
    assert K[2, 2] == pytest.approx(RHO * GRAVITY * LENGTH * WIDTH, rel=1e-9)


@pytest.mark.parametrize("share", [0.0, 1.0])
@pytest.mark.parametrize("shape", ["box", "round", "ring"])
def test_a_tank_that_is_empty_or_full_has_no_free_surface(shape, share):
    tank, area, _ = TANKS[shape]
    held = share * 4 * area
    K = static_stiffness(floating_box(("tank", tank(volume_start=held, place=(0, 0, -2.5))), water=held))
    centre = (held * -0.5 + (VOLUME - held) * KG) / VOLUME
    for i, (breadth, length) in enumerate(((WIDTH, LENGTH), (LENGTH, WIDTH))):
        gm = -DRAFT / 2 + length * breadth**3 / 12 / VOLUME - centre
        assert K[3 + i, 3 + i] == pytest.approx(RHO * GRAVITY * VOLUME * gm, rel=1e-6)


def tilted(tank: object, roll: float, pitch: float) -> dict[str, np.ndarray]:
    """Volume, centre, inertia of a tank that is held at an attitude, in axes of its frame."""
    model = fw.Assembly("tilted tank")
    model.world = World()
    model.fixed = Fixed(angles=(roll, pitch, 0.3))
    model.tank = tank
    model.connect(model.fixed.frame, model.tank.frame)
    state = fw.load(model).compile().initial_state()
    return {name: np.asarray(state[f"tank.{name}"]) for name in ("volume", "centre", "inertia", "surface", "mass")}


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.98])
@pytest.mark.parametrize("shape", ["box", "round"])
def test_water_in_a_tilted_tank_against_a_million_columns(shape, share):
    """From a puddle in a corner to a bubble under the roof: centre, level and inertia by brute force."""
    tank, area, _ = TANKS[shape]
    roll, pitch, height = math.radians(12), math.radians(-20), 4.0
    found = tilted(tank(volume_start=share * area * height), roll, pitch)
    n, length, width = 1000, *((10, 8) if shape == "box" else (9, 9))
    x, y = np.meshgrid(((np.arange(n) + 0.5) / n - 0.5) * length, ((np.arange(n) + 0.5) / n - 0.5) * width)
    inside = np.ones_like(x) if shape == "box" else (x**2 + y**2 < 4.5**2) * 1.0
    cell = inside * area / inside.sum()
    up = np.array([-math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)])  # R.T e_z
    level = float(found["surface"]) / up[2]
    column = np.clip(level - (up[0] * x + up[1] * y) / up[2], 0, height)
    volume = float((cell * column).sum())
    exact = 3e-5 if shape == "box" else 2e-3  # strips of a round tank; columns themselves are good for 2e-5
    small = min(share, 1 - share) * area * height
    assert abs(volume - share * area * height) < exact * small
    first = np.array([(cell * x * column).sum(), (cell * y * column).sum(), (cell * column**2 / 2).sum()])
    assert np.max(np.abs(found["centre"].ravel() - first / volume)) < exact * 9 * small / volume
    xx, yy, zz = ((cell * w).sum() for w in (x**2 * column, y**2 * column, column**3 / 3))
    xy, xz, yz = ((cell * w).sum() for w in (x * y * column, x * column**2 / 2, y * column**2 / 2))
    inertia = 1025 * np.array([[yy + zz, -xy, -xz], [-xy, xx + zz, -yz], [-xz, -yz, xx + yy]])
    assert np.max(np.abs(found["inertia"].reshape(3, 3) - inertia)) < exact * 81 * 1025 * small


def test_a_table_of_a_frustum_gives_its_level_and_centre():
    """V = pi h / 3 S, S = R_1^2 + R_1 R_2 + R_2^2; centre h / 4 (R_1^2 + 2 R_1 R_2 + 3 R_2^2) / S."""
    h = np.linspace(0, 4, 81)
    r = 1 + h / 2
    moments = np.stack([math.pi / 4 * r**4, math.pi / 4 * r**4, 0 * r], axis=1)
    squares = 1 + 2.5 + 2.5**2  # up to h = 3
    vessel = TabulatedTank(levels=h, areas=math.pi * r**2, second_moments=moments, volume_start=math.pi * squares)
    found = tilted(vessel, 0.0, 0.0)
    assert float(found["surface"]) == pytest.approx(3.0, abs=2e-4)  # areas are linear between levels
    centre = 3 / 4 * (1 + 5 + 3 * 2.5**2) / squares
    assert found["centre"].ravel() == pytest.approx([0, 0, centre], abs=2e-4)


def test_a_tilted_table_agrees_with_the_box_to_first_order():
    box, _, _ = TANKS["box"]
    table, _, _ = TANKS["table"]
    a, b = (tilted(tank(volume_start=150), 0.02, -0.03) for tank in (box, table))
    for name in ("volume", "centre", "inertia", "surface"):
        assert np.max(np.abs(a[name] - b[name])) < 1e-6 * max(1.0, np.max(np.abs(a[name])))
