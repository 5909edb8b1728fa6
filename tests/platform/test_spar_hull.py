"""An elastic spar: hull and tower as one beam against Hermitian finite elements, rigid hulls, ballast, mistakes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

import fowtlib as fw
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro import diffraction_coefficient
from fowtlib.components.mechanics import Frame, FreeMotion, RigidBody
from fowtlib.components.platform import SparHull
from fowtlib.components.support import FlexibleTower
from fowtlib.language import Component, Scalar, eq, param, port
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError, ParameterError

RHO, G, DEPTH = 1025.0, 9.80665, 320.0
HULL = {"heights": [-80.0, -55.0, -30.0, -8.0, 10.0], "diameters": [20.0, 13.0, 20.0, 12.6, 12.6],
        "wall_thicknesses": [0.08, 0.05, 0.07, 0.08, 0.06]}  # fmt: skip
TOWER = {"heights": [10.0, 60.0, 115.0], "diameters": [12.6, 11.5, 6.8], "wall_thicknesses": [0.05, 0.03, 0.015]}
HEAD, DISK, ARM = 676.7e3, 7.8e7, 2.8  # mass [kg], inertia [kg m^2], height over the top of the tower [m]
SPRING, FAIRLEAD = 70e3, -12.0
DAMPING = 0.004  # s, over stiffness


class Spring(Component):
    """A linear horizontal spring to the world, in place of a mooring."""

    stiffness: Scalar = param(default=SPRING, unit="N/m", doc="stiffness")
    lift: Scalar = param(default=0.0, unit="N", doc="constant pull downwards")
    frame: Frame = port(doc="fairlead")

    def equations(self):
        force = m.vertcat(self.stiffness * self.frame.r[0], self.stiffness * self.frame.r[1], self.lift)
        return [eq(self.frame.f, force), eq(self.frame.t, m.zeros(3))]


def spar(hinges=8, tower_hinges=6, cuts=(-40.0, -15.0), ballast=None, sea=None, **hull):
    root = fw.Assembly("spar")
    root.world = World(water_depth=DEPTH, water_density=RHO, gravity=G)
    if sea is not None:
        root.sea = Sea(**sea)
    root.motion = FreeMotion()
    settings = {"damping_fore_aft": DAMPING, "drag_coefficient": 0.0, "node_heights": [FAIRLEAD], "cuts": cuts}
    root.hull = SparHull(**{**HULL, **settings, "hinges": hinges, "ballast_mass": ballast or BALLAST, **hull})
    root.tower = FlexibleTower(**TOWER, hinges=tower_hinges, damping_fore_aft=DAMPING)
    root.head = RigidBody(mass=HEAD, r_cm=(0, 0, ARM), inertia=np.diag([DISK, DISK, DISK]))
    root.spring = Spring()
    for a, b in (
        (root.world.frame, root.motion.frame_a), (root.motion.frame_b, root.hull.frame),
        (root.hull.frame_b, root.tower.frame_a), (root.tower.frame_b, root.head.frame_a),
        (root.hull.nodes[0], root.spring.frame),
    ):  # fmt: skip
        root.connect(a, b)
    outputs = {"surge": "motion.surge", "pitch": "motion.pitch", "base": "tower.base_fore_aft_moment"}
    outputs |= {f"cut_{k}": f"hull.cut_fore_aft_moment[{k}]" for k in range(len(cuts))}
    return fw.Model(root, outputs=outputs)


def tubes(z):
    """Mass, bending stiffness and added mass per length, and volume per length, of the shell alone at heights z."""
    out = []
    for tube, rho in ((HULL, 7850.0), (TOWER, 8500.0)):
        D, t = (np.interp(z, tube["heights"], tube[name]) for name in ("diameters", "wall_thicknesses"))
        area, second = np.pi / 4 * (D**2 - (D - 2 * t) ** 2), np.pi / 64 * (D**4 - (D - 2 * t) ** 4)
        out.append((rho * area, 210e9 * second, np.pi / 4 * D**2, np.pi / 4 * (D - 2 * t) ** 2, rho * second))
    hull = z < HULL["heights"][-1]
    shell, EI, section, inside, rotary = (np.where(hull, *pair) for pair in zip(*out, strict=True))
    return shell, EI, np.where(z < 0, section, 0.0), inside, rotary


def gauss(a, b, n=4):
    x, w = np.polynomial.legendre.leggauss(n)
    return (a + b) / 2 + (b - a) / 2 * x, (b - a) / 2 * w


def integral(f, marks):
    return sum(w @ f(z) for a, b in zip(marks, marks[1:], strict=False) for z, w in [gauss(a, b, 6)])


MARKS = sorted({*HULL["heights"], *TOWER["heights"], 0.0})
VOLUME = integral(lambda z: tubes(z)[2], MARKS)
BALLAST = RHO * VOLUME - integral(lambda z: tubes(z)[0], MARKS) - HEAD  # floats at its draft without a mooring's weight


class Elements:
    """Hermitian beam elements from the keel to the top of the tower: K with geometric stiffness, M with added mass."""

    def __init__(self, size=2.0):
        level = self._level()
        marks = sorted({*MARKS, level, FAIRLEAD, -40.0, -15.0})
        self.z = np.concatenate(
            [np.linspace(a, b, max(2, round((b - a) / size)), endpoint=False)
             for a, b in zip(marks, marks[1:], strict=False)] + [[marks[-1]]])  # fmt: skip
        self.level, n = level, len(self.z)
        self.parts, self.K, self.M, self.bend = [], *(np.zeros((2 * n, 2 * n)) for _ in range(3))
        for e in range(n - 1):
            part = self._element(e)
            self.parts.append(part)
            place = slice(2 * e, 2 * e + 4)
            self.K[place, place] += part[0] + part[1]
            self.bend[place, place] += part[0]
            self.M[place, place] += part[2]
        self.head = np.array([[HEAD, HEAD * ARM], [HEAD * ARM, HEAD * ARM**2 + DISK]])
        self.M[-2:, -2:] += self.head
        self.head_weight = np.array([[0.0, 0.0], [0.0, -HEAD * G * ARM]])  # it stands above its support
        self.K[-2:, -2:] += self.head_weight
        fairlead, water = (2 * int(np.argmin(np.abs(self.z - z))) for z in (FAIRLEAD, 0.0))
        self.K[fairlead, fairlead] += SPRING
        self.K[water + 1, water + 1] += RHO * G * np.pi / 64 * 12.6**4

    def _level(self):
        """Surface of the ballast, by bisection."""
        low, high = HULL["heights"][0], 0.0
        for _ in range(80):
            middle = (low + high) / 2
            marks = [z for z in HULL["heights"] if z < middle] + [middle]
            held = 2600.0 * integral(lambda z: tubes(z)[3], marks)
            low, high = (middle, high) if held < BALLAST else (low, middle)
        return low

    def mass(self, z):
        shell, _, _, inside, _ = tubes(z)
        return shell + 2600.0 * np.where(z < self.level, inside, 0.0)

    def tension(self, z):
        """Axial force without the pressure in the section: weight less buoyancy of what is above."""
        marks = [z, *(mark for mark in (*MARKS, self.level) if mark > z)]
        marks = sorted(marks)
        above = integral(lambda s: self.mass(s) - RHO * tubes(s)[2], marks)
        return -G * (HEAD + above)

    def _element(self, e):
        a, L = self.z[e], self.z[e + 1] - self.z[e]
        bend, geometric, mass = (np.zeros((4, 4)) for _ in range(3))
        for z, w in zip(*gauss(a, a + L), strict=True):
            N, slope, curve = shape((z - a) / L, L)
            shell, EI, section, inside, rotary = tubes(np.array(z))
            turned = rotary + 2600.0 * inside**2 / (4 * np.pi) * (z < self.level)
            bend += w * EI * np.outer(curve, curve)
            geometric += w * self.tension(z) * np.outer(slope, slope)
            mass += w * ((self.mass(z) + RHO * section) * np.outer(N, N) + turned * np.outer(slope, slope))
        return bend, geometric, mass

    def frequencies(self):
        """Natural frequencies [Hz], lowest first."""
        values = eigh(self.K, self.M, eigvals_only=True)
        return np.sqrt(values[values > 0]) / (2 * np.pi)

    def waves(self, omega):
        """Loads of a wave of unit amplitude on the nodes, after MacCamy and Fuchs in deep water."""
        k = omega**2 / G
        loads = []
        for e in range(len(self.parts)):
            load, (a, b) = np.zeros(4, complex), self.z[e : e + 2]
            if b <= 1e-9:
                for z, w in zip(*gauss(a, b), strict=True):
                    D = np.interp(z, HULL["heights"], HULL["diameters"])
                    force = RHO * np.pi * D**2 / 4 * diffraction_coefficient(k * D / 2) * 1j * omega**2 * np.exp(k * z)
                    load += w * force * shape((z - a) / (b - a), b - a)[0]
            loads.append(load)
        return loads

    def moments(self, omega, heights):
        """Moments of what is above on what is below in a wave of unit amplitude, complex."""
        loads, F = self.waves(omega), np.zeros(2 * len(self.z), complex)
        for e, load in enumerate(loads):
            F[2 * e : 2 * e + 4] += load
        x = np.linalg.solve(self.K + 1j * omega * DAMPING * self.bend - omega**2 * self.M, F)
        found = []
        for height in heights:
            e = int(np.argmin(np.abs(self.z - height)))
            bend, geometric, mass = self.parts[e]
            dynamic = bend * (1 + 1j * omega * DAMPING) + geometric - omega**2 * mass
            found.append(-(dynamic @ x[2 * e : 2 * e + 4] - loads[e])[1])  # of below on above, turned round
        return np.array(found)


def shape(s, L):
    """Hermite's functions of an element of the length L at s in [0, 1], their first and second derivatives."""
    N = np.array([1 - 3 * s**2 + 2 * s**3, L * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, L * (s**3 - s**2)])
    slope = np.array([(6 * s**2 - 6 * s) / L, 1 - 4 * s + 3 * s**2, (6 * s - 6 * s**2) / L, 3 * s**2 - 2 * s])
    curve = np.array([(12 * s - 6) / L**2, (6 * s - 4) / L, (6 - 12 * s) / L**2, (6 * s - 2) / L])
    return N, slope, curve


@pytest.fixture(scope="module")
def elements():
    return Elements()


HINGES = (3, 6)


@pytest.fixture(scope="module")
def spars():
    """Plants with so many hinges in the hull and in the tower, and their equilibria."""
    sea = {"spectrum": "jonswap", "significant_wave_height": 1.0, "peak_period": 10.0}
    plants = [spar(hinges, hinges, sea=sea, strips=80).compile() for hinges in HINGES]
    return [(plant, plant.equilibrium(parameters=CALM)) for plant in plants]


CALM = {"sea.spectrum": "still"}


def test_hull_and_tower_are_the_beam_of_finite_elements(elements, spars):
    # modes in the plane; their twins across, heave and yaw are no modes of the elements
    exact, errors = elements.frequencies()[:4], []
    for plant, state in spars:
        found = np.array([mode.frequency_hz for mode in plant.linearize(state).modes()])
        errors.append([np.abs(found - value).min() / value for value in exact])
    few, many = np.array(errors)
    assert (many[:2] < 1e-4).all()  # surge and pitch are rigid
    assert (many[2:] < [1e-4, 1e-3]).all()
    assert (many[2:] < few[2:] / 2).all()


def test_moments_along_hull_and_tower_in_waves_are_those_of_finite_elements(elements, spars):
    omega, errors = np.array([0.45, 0.7, 1.1]), []
    wanted = np.array([elements.moments(w, (-40.0, -15.0, 10.0)) for w in omega])
    for plant, _ in spars:
        found = fw.response(plant, outputs=["cut_0", "cut_1", "base"], frequencies=omega / (2 * np.pi))
        transfer = found.transfer["sea"][:, :, 0]
        errors.append((np.abs(transfer - wanted).max(axis=0) / np.abs(wanted).max(axis=0)).max())
    assert errors[1] < 1.5e-4
    assert errors[1] < errors[0] / 3


def test_a_stiff_hull_is_a_rigid_one_and_cuts_change_nothing():
    omega = np.array([0.45, 1.1])
    sea = {"spectrum": "jonswap", "significant_wave_height": 1.0, "peak_period": 10.0}
    found = []
    for settings in ({"hinges": 0}, {"hinges": 1, "stiffness_factor": 1e4, "cuts": (-40.0, -30.0, -15.0)}):
        plant = spar(tower_hinges=1, sea=sea, strips=40, **settings).compile()
        found.append(fw.response(plant, outputs=["surge", "pitch", "base", "cut_0"], frequencies=omega / (2 * np.pi)))
    rigid, stiff = (item.transfer["sea"][:, :, 0] for item in found)
    assert np.abs(stiff / rigid - 1).max() < 1e-3


def test_sizes_change_from_run_to_run_and_no_hinge_passes_a_cut():
    settings = {"hinges": 4, "tower_hinges": 1, "quadrature": "stations", "cuts": (-55.0, -30.0, -8.0),
                "strips": 100}  # fmt: skip
    other = {"heights": [-86.0, -57.0, -33.0, -6.0, 10.0], "diameters": [23.0, 11.0, 17.0, 12.6, 12.6],
             "wall_thicknesses": [0.05, 0.09, 0.05, 0.06, 0.05]}  # fmt: skip
    changed, built = spar(**settings).compile(), spar(**settings, **other).compile()
    found = []
    for plant, parameters in ((changed, {f"hull.{name}": value for name, value in other.items()}), (built, {})):
        guess = {"hull.ballast_mass": BALLAST}
        state = plant.equilibrium(free=guess, targets={"motion.heave": 0.0}, parameters=parameters)
        frequencies = [mode.frequency_hz for mode in plant.linearize(state).modes()]
        found.append([float(state.parameters["hull.ballast_mass"]), *sorted(frequencies)])
    assert found[0] == pytest.approx(found[1], rel=1e-7, abs=1e-7)  # how many strips a piece has is that of the model
    assert abs(found[0][0] / BALLAST - 1) > 0.02


def test_ballast_fills_the_hull_from_the_keel():
    hull = SparHull(heights=[-50, 10], diameters=[12, 12], wall_thicknesses=[1, 1], ballast_mass=2600 * np.pi * 25 * 7)
    found = {fact.name: fact.value for fact in hull.facts()}
    assert found["ballast level"] == pytest.approx(-43.0, abs=1e-9)
    assert found["displaced volume"] == pytest.approx(np.pi * 36 * 50, rel=1e-12)
    assert found["centre of buoyancy"][2] == pytest.approx(-25.0, rel=1e-12)
    assert found["steel mass"] == pytest.approx(7850 * np.pi * 11 * 60, rel=1e-12)
    numbers = hull.chain()
    mass = sum(value for (kind, _), value in numbers.items() if kind == "mass")
    assert mass == pytest.approx(found["steel mass"] + 2600 * np.pi * 25 * 7, rel=1e-6)


def test_ballast_in_a_cone_has_the_level_of_its_volume():
    # a cone from 10 m to 4 m over 30 m, thin wall: V(h) = pi / 3 s (r^3 - (r - h / s)^3) with s = h / (r - r')
    hull = SparHull(heights=[-30, 0.001, 5], diameters=[20, 8, 8], wall_thicknesses=[1e-6, 1e-6, 1e-6], hinges=0,
                    ballast_mass=1e6, ballast_density=1000.0)  # fmt: skip
    slope = 6 / 30.001
    top = (1000 - 1000.0 * 3 * slope / np.pi) ** (1 / 3)
    level = next(fact.value for fact in hull.facts() if fact.name == "ballast level")
    assert level == pytest.approx(-30 + (10 - top) / slope, abs=2e-3)


def test_a_steep_cone_is_told_of():
    settings = {"wall_thicknesses": [0.05] * 4, "heights": [-90, -12, -4, 10]}
    (said,) = SparHull(diameters=[15, 15, 8.3, 8.3], **settings).remarks()
    assert "its cone from -12 m upwards has 23 deg" in said
    assert not SparHull(diameters=[9.4, 9.4, 6.5, 6.5], **settings).remarks()


@pytest.mark.parametrize(
    "wrong, words",
    [
        ({"ballast": 5e7}, "the ballast has 19230.8 m^3 and the hull holds"),
        ({"heights": [-80.0, -55.0, -30.0, -8.0, -1.0]}, "end above it"),
        ({"wall_thicknesses": [0.08, 0.05, 0.07, 0.08, 0.0]}, "wall of a tube must be thicker than zero"),
        ({"cuts": (-40.0, -90.0)}, "cut 2 at -90 m is off the hull, which goes from -80 m to 10 m"),
        ({"node_heights": [12.0]}, "node 1 at 12 m is off the hull"),
    ],
)
def test_what_cannot_be_is_said(wrong, words):
    with pytest.raises((ModelError, ParameterError)) as error:
        spar(**wrong).compile()
    assert words in str(error.value)
    assert "hull" in str(error.value).lower()


def test_without_drag_and_damping_nothing_is_lost_or_gained():
    plant = spar(hinges=1, tower_hinges=0, damping_fore_aft=0.0).compile()
    modes = plant.linearize(plant.equilibrium()).modes()
    moving = [mode for mode in modes if mode.frequency_hz > 1e-3]
    assert len(moving) == 2 + 2 + 1 + 2  # surge, pitch and their twins, heave, bending of the hull
    assert max(abs(mode.damping_ratio) for mode in moving) < 1e-7
