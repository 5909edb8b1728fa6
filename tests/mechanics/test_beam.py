"""Flexible beams: uniform beams with known solutions, shipped tower and blade against finite elements."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial
from scipy.linalg import eigh, eigvalsh

import fowtlib as fw
import fowtlib.models
from fowtlib.components.blocks import Constant
from fowtlib.components.mechanics import (
    Beam,
    BeamProperties,
    Fixed,
    FixedRotation,
    FreeMotion,
    PositionSensor,
    Revolute,
    RigidBody,
    SpeedSource,
    World,
    WorldForce,
    WorldTorque,
    read_beam,
)
from fowtlib.components.mechanics.beam_division import _bent, _straight, divide
from fowtlib.language import Component, RealOutput, Vector, eq, param, port
from fowtlib.language.errors import ModelError, ParameterError

DATA = Path(fowtlib.models.__file__).parent / "data"
UNIT = BeamProperties.uniform(1.0, 1.0, 1.0)
EXACT = np.array([3.5160, 22.034, 61.697])  # clamped-free, omega / sqrt(EI / (mu L^4))


class Source(Component):
    """Three constant numbers."""

    value: Vector = param(doc="the numbers")
    y: RealOutput = port(shape=(3,), doc="output")

    def equations(self):
        return [eq(self.y, self.value)]


def cantilever(properties=UNIT, *, gravity=0.0, angles=(0, 0, 0), **beam):
    model = fw.Assembly("cantilever")
    model.world, model.base = World(gravity=gravity), Fixed(angles=angles)
    model.beam = Beam(table=properties, **beam)
    model.connect(model.base.frame, model.beam.frame_a)
    return model


def modes(model, start=None):
    plant = fw.load(model).compile()
    return plant.linearize(plant.initial_state(start=start or {})).modes()


def frequencies(model, part="", start=None):
    """Circular frequencies [rad/s] of the oscillating modes whose main state has `part` in its name."""
    found = modes(model, start)
    return np.array([2 * np.pi * mode.frequency_hz for mode in found if abs(mode.eigenvalue.imag) > 1e-6
                     and part in mode.label])  # fmt: skip


def finite_elements(beam, elements=60, mass=0.0, inertia=0.0, offset=0.0):
    """Circular frequencies of the clamped beam by Hermite elements, both planes coupled by the structural twist.

    mass, inertia: body at the end, whose centre lies `offset` beyond it, inertia about its centre in both planes.
    """
    grid = np.linspace(0, beam.length, elements + 1)
    K, M = np.zeros((2, 4 * (elements + 1), 4 * (elements + 1)))
    points, weights = np.polynomial.legendre.leggauss(5)
    for e, (a, b) in enumerate(zip(grid, grid[1:], strict=False)):
        h, dofs = b - a, slice(4 * e, 4 * e + 8)
        for point, weight in zip((points + 1) / 2, weights * h / 2, strict=True):
            s, q = a + h * point, point
            N = [1 - 3 * q**2 + 2 * q**3, h * (q - 2 * q**2 + q**3), 3 * q**2 - 2 * q**3, h * (q**3 - q**2)]
            slope = [(6 * q**2 - 6 * q) / h, 1 - 4 * q + 3 * q**2, (6 * q - 6 * q**2) / h, 3 * q**2 - 2 * q]
            bend = [(12 * q - 6) / h**2, (6 * q - 4) / h, (6 - 12 * q) / h**2, (6 * q - 2) / h]
            N, slope, bend = (np.kron([row], np.eye(2)) for row in (N, slope, bend))  # u, v, u', v' at each end
            c, sn = np.cos(beam.at("twist", s)), np.sin(beam.at("twist", s))
            x, y = np.array([c, -sn]), np.array([sn, c])
            EI, rotary = (beam.at(f"{name}_x", s) * np.outer(x, x) + beam.at(f"{name}_y", s) * np.outer(y, y)
                          for name in ("stiffness", "rotary_inertia"))  # fmt: skip
            K[dofs, dofs] += weight * bend.T @ EI @ bend
            M[dofs, dofs] += weight * (beam.at("mass_per_length", s) * N.T @ N + slope.T @ rotary @ slope)
    end = np.kron([[1, offset], [offset, offset**2 + (inertia / mass if mass else 0)]], np.eye(2))
    M[-4:, -4:] += mass * end
    return np.sqrt(eigvalsh(K[4:, 4:], M[4:, 4:]))


def chain_frequencies(beam, hinges, quadrature):
    """Circular frequencies of an untwisted chain in its hinge angles, written without the library's parts."""
    parts, s = divide(beam, hinges, quadrature), np.linspace(0, beam.length, 20001)
    arms = np.maximum(s - parts.s[:, None], 0)
    M = np.trapezoid(arms[:, None] * arms * beam.at("mass_per_length", s), s)
    return np.sqrt(eigh(np.diag(parts.stiffness_x), M, eigvals_only=True))


# --- uniform beams --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("hinges", "expected"), [(2, [3.7299, 31.041]), (6, [3.5385, 22.531, 63.906])])
def test_the_plain_chain_has_the_frequencies_of_the_generalized_beam_element(hinges, expected):
    found = frequencies(cantilever(hinges=hinges, quadrature="plain"), "_x")
    assert found[: len(expected)] == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize(
    ("quadrature", "hinges", "errors"),
    [  # relative error of the first frequencies; the plain chain has 2.6 % with three hinges, 0.64 % with six
        ("loaded_tip", 3, [1e-3]), ("loaded_tip", 6, [2e-5, 1e-3, 0.02]),
        ("free_tip", 3, [2e-3]), ("free_tip", 6, [2e-5, 1e-3, 0.005]),
    ],
)  # fmt: skip
def test_few_units_converge(quadrature, hinges, errors):
    found = frequencies(cantilever(hinges=hinges, quadrature=quadrature), "_x")[: len(errors)]
    assert np.all(np.abs(found / EXACT[: len(errors)] - 1) < np.array(errors) + 2e-5)


@pytest.mark.parametrize(("quadrature", "order"), [("plain", 2), ("loaded_tip", 4), ("free_tip", 4)])
def test_order_of_convergence(quadrature, order):
    exact = 22.0344916
    errors = [abs(chain_frequencies(UNIT, n, quadrature)[1] / exact - 1) for n in (8, 16)]
    assert np.log2(errors[0] / errors[1]) > order - 0.3


@pytest.mark.parametrize(
    ("quadrature", "hinges", "error"), [("plain", 2, 0.0328), ("plain", 6, 0.0035), ("loaded_tip", 2, 0)]
)
def test_cantilever_with_a_tip_mass(quadrature, hinges, error):
    """A mass of 1000 times that of the beam: omega^2 = 3 EI / L^3 / (m + 33/140 mu L); plain: 1/(8 N^2)."""
    model = cantilever(hinges=hinges, quadrature=quadrature)
    model.mass = RigidBody(mass=1e3, inertia=1e-6 * np.eye(3))
    model.connect(model.beam.frame_b, model.mass.frame_a)
    expected = np.sqrt(3 / (1e3 + 33 / 140))
    assert frequencies(model)[0] / expected - 1 == pytest.approx(error, abs=2e-4)


@pytest.mark.parametrize("taper", [1.0, 0.3])
def test_static_tip_deflection_and_slope(taper):
    """Two Gauss hinges are exact under a force and a moment at the tip, for any taper; u'' = M / EI integrated here."""
    EI, s = np.array([1.0, taper]), np.linspace(0, 1, 4001)
    table = BeamProperties(np.array([0.0, 1.0]), 1.0, EI, EI)
    model = cantilever(table, hinges=2, quadrature="loaded_tip")
    model.force, model.torque = WorldForce(), WorldTorque()
    for load, name, value in ((model.force.force, "f", (1e-4, 0, 0)), (model.torque.torque, "t", (0, 2e-5, 0))):
        source = model.add(name, Source(value=value))
        model.connect(source.y, load)
    model.connect(model.beam.frame_b, model.force.frame)
    model.connect(model.beam.frame_b, model.torque.frame)
    state = fw.load(model).compile().equilibrium()
    curvature = (1e-4 * (1 - s) + 2e-5) / np.interp(s, [0, 1], EI)
    assert state["beam.deflection"][0] == pytest.approx(np.trapezoid(curvature * (1 - s), s), rel=1e-6)
    angle = sum(float(state[f"beam.hinge_{i}.bending.phi_x"]) for i in (1, 2))
    assert angle == pytest.approx(np.trapezoid(curvature, s), rel=1e-6)
    assert state["beam.root_moment"][1] == pytest.approx(-(1e-4 + 2e-5), rel=1e-6)
    assert state["beam.root_force"][0] == pytest.approx(-1e-4, rel=1e-9)


def test_torsion_and_stretch():
    """Clamped-free rod: omega_k = (k - 1/2) pi sqrt(GJ / (I L^2)), and with EA / mu along the axis."""
    table = BeamProperties.uniform(2.0, 3.0, 1e4, torsional_stiffness=5.0, axial_stiffness=40.0,
                                   rotary_inertia_x=0.3, rotary_inertia_y=0.4)  # fmt: skip
    model = cantilever(table, hinges=4, torsion=True, stretch=True)
    twist, stretch = frequencies(model, "twisting"), frequencies(model, "stretching")
    for found, speed in ((twist, np.sqrt(5 / 0.7)), (stretch, np.sqrt(40 / 3))):
        assert found[0] == pytest.approx(np.pi / 2 * speed / 2, rel=0.01)
        assert found[1] == pytest.approx(3 * np.pi / 2 * speed / 2, rel=0.08)


def test_damping_is_proportional_to_stiffness():
    model = cantilever(hinges=4, damping_x=0.003, damping_y=0.001)
    for mode in modes(model):
        coefficient = 0.003 if "x" in mode.label.split(".")[-1] else 0.001
        assert mode.damping_ratio == pytest.approx(coefficient * np.pi * mode.frequency_hz, rel=1e-6)


def test_stiffness_is_a_parameter_of_the_built_model():
    plant = fw.load(cantilever(hinges=3)).compile()
    first = [
        plant.linearize(plant.initial_state(parameters={"beam.stiffness_factor": k})).modes()[0].frequency_hz
        for k in (1, 4)
    ]
    assert first[1] == pytest.approx(2 * first[0], rel=1e-9)


# --- large motion ---------------------------------------------------------------------------------------------------

# Flapping frequencies of a uniform cantilever on a hub of no radius that turns at Omega = 6, over sqrt(EI / (mu L^4)):
# A. Wright, C. Smith, R. Thresher, J. Wang (1982), J. Appl. Mech. 49, 197-202, as tabulated by G. Bir (2009), BModes
# verification, NREL/CP-500-44749, table 3a.
WRIGHT = {6: (7.360, 26.809, 66.684)}


def ritz_frequencies(speed, terms=14):
    """The same by Rayleigh and Ritz, polynomials x^2 P_k(x): int w''^2 + speed^2 (1 - x^2) / 2 w'^2 over int w^2."""
    shape = [Polynomial([0, 0, 1]) * Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial, domain=[-1, 1])
             for k in range(terms)]  # fmt: skip
    x, weight = np.polynomial.legendre.leggauss(40)
    x, weight = (x + 1) / 2, weight / 2
    w, slope, bend = (np.array([p.deriv(k)(x) if k else p(x) for p in shape]) for k in range(3))
    K = (bend * weight) @ bend.T + speed**2 / 2 * (slope * weight * (1 - x**2)) @ slope.T
    return np.sqrt(eigh(K, (w * weight) @ w.T, eigvals_only=True))


def rotating_frequencies(hinges, speeds):
    """Circular frequencies of the flapping and the lagging modes at each speed."""
    plant = fw.load(rotating(hinges=hinges, quadrature="free_tip")).compile()
    for speed in speeds:
        found = plant.linearize(plant.initial_state(parameters={"speed.value": float(speed)})).modes()
        found = [(2 * np.pi * mode.frequency_hz, mode.label) for mode in found if abs(mode.eigenvalue.imag) > 1e-6]
        yield tuple(np.array([w for w, label in found if label.endswith(axis)]) for axis in ("_x", "_y"))


def rotating(**beam):
    model = fw.Assembly("rotating beam")
    model.world, model.shaft, model.drive = World(gravity=0.0), Revolute(), SpeedSource()
    model.speed, model.turn = Constant(value=0.0), FixedRotation(n=(0, 1, 0), angle=np.pi / 2)
    model.beam = Beam(table=UNIT, **beam)
    model.connect(model.world.frame, model.shaft.frame_a)
    model.connect(model.shaft.frame_b, model.turn.frame_a)
    model.connect(model.turn.frame_b, model.beam.frame_a)
    model.connect(model.drive.flange, model.shaft.flange)
    model.connect(model.speed.y, model.drive.w)
    return model


def test_the_reference_of_the_rotating_beam():
    """Polynomials against the closed solution at rest and against the published table."""
    assert ritz_frequencies(0)[:3] == pytest.approx(EXACT, rel=3e-5)
    for speed, published in WRIGHT.items():
        assert ritz_frequencies(speed)[:3] == pytest.approx(published, abs=6e-4)


def test_a_rotating_beam_stiffens():
    """Out of plane as by polynomials, in the plane with omega^2 smaller by Omega^2 (the load follows the radius).

    The rise of the first frequency alone, omega^2 = omega_0^2 + K Omega^2 (Southwell and Gough 1921), within 2 %.
    """
    rest, speeds = None, (0, 3, 6, 12)
    for (flap, lag), speed in zip(rotating_frequencies(6, speeds), speeds, strict=True):
        exact = ritz_frequencies(speed)
        for i, error in enumerate((0.005, 0.025)):
            assert flap[i] == pytest.approx(exact[i], rel=error)
            assert lag[i] ** 2 + speed**2 == pytest.approx(exact[i] ** 2, rel=2 * error)
        rest = flap[0] if rest is None else rest
        assert flap[0] ** 2 - rest**2 == pytest.approx(exact[0] ** 2 - EXACT[0] ** 2, rel=0.02, abs=1e-3)


def test_a_free_chain_keeps_energy_and_momentum():
    table = BeamProperties.uniform(2.0, 1.5, 3.0, 5.0, rotary_inertia_x=0.02, rotary_inertia_y=0.02)
    model = fw.Assembly("free chain")
    model.world, model.motion = World(gravity=0.0), FreeMotion(angle_rates_start=(0.7, -0.4, 0.3))
    model.beam = Beam(table=table, hinges=2)
    model.connect(model.world.frame, model.motion.frame_a)
    model.connect(model.motion.frame_b, model.beam.frame_a)
    start = {"beam.hinge_1.bending.phi_x": 0.3, "beam.hinge_2.bending.phi_y": -0.4, "beam.hinge_1.bending.w_y": 0.5}
    plant = fw.load(model).compile()
    result = plant.simulate(4.0, output_step=0.05, start=plant.initial_state(start=start), tolerance=1e-9)
    parts = divide(table, 2, "loaded_tip")
    energy, spin, impulse = 0.0, 0.0, 0.0
    for i, segment in enumerate(parts.segments):
        path = f"beam.segment_{i}"
        v, w, R, r = (np.asarray(result[f"{path}.{name}"]) for name in ("v", "frame_a.w", "frame_a.R", "frame_a.r"))
        origin = parts.points[i - 1] if i else np.zeros(3)
        inertia = R @ segment.inertia @ R.transpose(0, 2, 1)
        own = np.einsum("tij,tj->ti", inertia, w)
        centre = r + np.einsum("tij,j->ti", R, segment.centre - origin)
        energy = energy + 0.5 * segment.mass * (v**2).sum(1) + 0.5 * (own * w).sum(1)
        impulse = impulse + segment.mass * v
        spin = spin + own + segment.mass * np.cross(centre, v)
    for i in range(2):
        for name, k in (("phi_x", parts.stiffness_x[i]), ("phi_y", parts.stiffness_y[i])):
            energy = energy + 0.5 * k * np.asarray(result[f"beam.hinge_{i + 1}.bending.{name}"]) ** 2
    assert np.ptp(energy) < 1e-6 * energy[0]
    assert np.abs(impulse - impulse[0]).max() < 1e-6 * np.abs(impulse[0]).max()
    assert np.abs(spin - spin[0]).max() < 1e-6 * np.abs(spin[0]).max()


def test_a_beam_is_the_same_in_any_direction():
    table = BeamProperties.uniform(1.0, 1.0, 1.0, 2.0, twist=0.4)
    upright = frequencies(cantilever(table, hinges=3))
    turned = frequencies(cantilever(table, hinges=3, angles=(0.3, -0.7, 2.0)))
    assert turned == pytest.approx(upright, rel=1e-7)


def test_frames_along_the_beam():
    """Nodes lie where the undeflected axis is, also off it; a sensor there sees the motion of its segment."""
    bent = BeamProperties(np.linspace(0, 1, 11), 1.0, 1.0, 1.0, reference_x=0.1 * np.linspace(0, 1, 11) ** 2)
    model = cantilever(bent, hinges=3, node_points=[0.0, 0.5, (0.2, -0.1, 0.9), 1.0])
    model.sensors = fw.Assembly("sensors")
    for k in range(4):
        sensor = model.add(f"sensor_{k}", PositionSensor())
        model.connect(model.beam.nodes[k], sensor.frame)
    state = fw.load(model).compile().initial_state()
    expected = [(0, 0, 0), (0.025, 0, 0.5), (0.2, -0.1, 0.9), (0.1, 0, 1.0)]
    assert [tuple(state[f"sensor_{k}.r"]) for k in range(4)] == [pytest.approx(point, abs=1e-12) for point in expected]


# --- the shipped tower and blade ------------------------------------------------------------------------------------


def test_the_blade_has_the_mass_of_its_definition():
    """NREL/TP-500-38060, table 2-2: 17,740 kg, 363,231 kg m, 11,776,047 kg m^2; any number of hinges."""
    blade = read_beam(str(DATA / "nrel5mw" / "blade_structure.csv"))
    for hinges in (0, 1, 6):
        segments = divide(blade, hinges, "free_tip").segments
        mass = sum(s.mass for s in segments)
        first = sum(s.mass * s.centre[2] for s in segments)
        second = sum(s.mass * s.centre[2] ** 2 + s.inertia[0, 0] for s in segments)
        assert mass == pytest.approx(17740, rel=1e-5)
        assert first == pytest.approx(363231, rel=0.005)
        assert second == pytest.approx(11776047, rel=0.005)


def test_blade_frequencies():
    """Clamped, at rest, against finite elements of the same table, and those against another program.

    Without structural twist, as that program takes it: pyBmodes 1.19.1 (Apache-2.0) on the ElastoDyn blade file of the
    NREL 5 MW turbine, rotor speed 0, factor of the mass 1.053147 as in the shipped table.
    """
    blade = read_beam(str(DATA / "nrel5mw" / "blade_structure.csv"))
    other = [0.67384, 1.08532, 1.94156, 4.02807, 4.49749]
    assert finite_elements(replace(blade, twist=0.0))[:5] / (2 * np.pi) == pytest.approx(other, rel=0.003)
    reference = finite_elements(blade)[:4] / (2 * np.pi)
    found = frequencies(cantilever(blade, hinges=6, quadrature="free_tip"))[:4] / (2 * np.pi)
    assert found[:3] == pytest.approx(reference[:3], rel=0.003)
    assert found[3] == pytest.approx(reference[3], rel=0.04)


def test_tower_frequencies():
    """Clamped OC3 tower with mass and inertia of rotor and nacelle at its top, against finite elements."""
    tower = read_beam(str(DATA / "oc3_hywind" / "tower.csv"))
    head = {"mass": 350e3, "inertia": 2.35e7, "offset": 1.967}
    reference = finite_elements(tower, **head)[::2][:2]
    for hinges, errors in ((2, (0.003, 0.005)), (4, (5e-4, 0.005))):
        model = cantilever(tower, hinges=hinges, quadrature="loaded_tip")
        model.head = RigidBody(mass=head["mass"], inertia=head["inertia"] * np.eye(3), r_cm=(0, 0, head["offset"]))
        model.connect(model.beam.frame_b, model.head.frame_a)
        found = frequencies(model, "_x")[:2]
        assert np.all(np.abs(found / reference - 1) < errors)


def test_a_tube_from_diameters_is_the_tower_of_the_table():
    table = read_beam(str(DATA / "oc3_hywind" / "tower.csv"))
    tube = BeamProperties.tube([10.0, 87.6], [6.5, 3.87], [0.027, 0.019])
    s = table.z - 10.0
    for name in ("mass_per_length", "stiffness_x", "torsional_stiffness", "axial_stiffness", "rotary_inertia_x"):
        assert tube.at(name, s) == pytest.approx(table.at(name, s), rel=2e-3)


# --- mistakes -------------------------------------------------------------------------------------------------------


def test_mistakes(tmp_path):
    with pytest.raises(ParameterError, match="must increase"):
        BeamProperties(np.array([0.0, 2.0, 1.0]), 1.0, 1.0, 1.0)
    with pytest.raises(ParameterError, match="stiffness_x of a beam is 0 at z = 1 m"):
        BeamProperties(np.array([0.0, 1.0]), 1.0, np.array([1.0, 0.0]), 1.0)
    with pytest.raises(ParameterError, match="torsion needs the torsional_stiffness"):
        cantilever(torsion=True)
    with pytest.raises(ParameterError, match="Beam: give properties, the path"):
        cantilever(None)
    with pytest.raises(ModelError, match="cannot read the properties of a beam: No such file"):
        read_beam(str(tmp_path / "missing.csv"))
    path = tmp_path / "beam.csv"
    heads = "z_m,mass_per_length_kg_per_m,bending_stiffness_fore_aft_N_m2,bending_stiffness_side_side_N_m2"
    path.write_text(f"# a beam\n{heads}\n0,1,1,1\n\n2,1,1,1\n# between\n1,1,1,1\n")
    with pytest.raises(ModelError) as error:
        read_beam(str(path))
    assert str(error.value) == (
        f"{path}:7: the stations of a beam must increase from root to tip; 2 m is followed by 1 m."
    )
    with pytest.raises(ParameterError, match="node 1 at 1.5 m is off the beam"):
        cantilever(node_points=[1.5])
    with pytest.raises(ParameterError, match="wall of a tube"):
        BeamProperties.tube([0, 1], [1, 1], [0.6, 0.1])
    path = tmp_path / "beam.csv"
    path.write_text("z_m,mass\n0,1\n1,1\n")
    with pytest.raises(ModelError, match=r"beam.csv: unknown column 'mass'"):
        read_beam(str(path))
    path.write_text("z_m,mass_per_length_kg_per_m\n0,1\n2,1\n")
    with pytest.raises(ModelError, match=r"bending_stiffness_fore_aft_N_m2 or .* is missing"):
        read_beam(str(path))


def test_hinges_between_stations():
    # a uniform beam: one hinge in the middle of each piece; one piece alone: Gauss points of the whole
    even = BeamProperties(np.linspace(0, 1, 5), 1.0, 1.0, 1.0)
    wanted, found = divide(even, 4, "plain"), divide(even, 4, "stations")
    assert found.s == pytest.approx(wanted.s, rel=1e-12)
    assert found.stiffness_x == pytest.approx(wanted.stiffness_x, rel=1e-12)
    assert divide(UNIT, 3, "stations").s == pytest.approx(divide(UNIT, 3, "loaded_tip").s, rel=1e-12)
    marks = (0.0, 0.1, 0.4, 1.0)
    assert [np.searchsorted(marks, s) for s in divide(even, 6, "stations", marks).s] == [1, 1, 2, 2, 3, 3]
    with pytest.raises(ParameterError, match="5 hinges are no multiple of 4"):
        divide(even, 5, "stations")


def test_a_straight_segment_is_a_bent_one_without_bends():
    rng = np.random.default_rng(3)
    columns = {name: 1 + rng.random(7) for name in ("mass_per_length", "rotary_inertia_x", "rotary_inertia_y")}
    beam = BeamProperties(np.sort(10 * rng.random(7)), stiffness_x=1.0, stiffness_y=2.0, **columns)
    for a, b in [(0.0, beam.length), (0.31 * beam.length, 0.33 * beam.length)]:
        one, other = _straight(beam, np.array([a, b]))[0], _bent(beam, a, b)
        assert one.mass == pytest.approx(other.mass, rel=1e-14)
        np.testing.assert_allclose(one.centre, other.centre, atol=1e-13)
        np.testing.assert_allclose(one.inertia, other.inertia, rtol=1e-12, atol=1e-12)


def test_pieces_that_are_known_are_those_of_the_same_tube_alone():
    heights, diameters = np.linspace(0.0, 60.0, 7), np.linspace(8.0, 5.0, 7)
    tubes = []
    for place in (None, 0, 3, 6):
        walls = np.full(7, 0.04)
        if place is not None:
            walls[place] = 0.05
        tubes.append(BeamProperties.tube(heights, diameters, walls))
    plain = [divide(tube, 6, "stations", tuple(heights.tolist())) for tube in tubes]
    masses = np.array([[segment.mass for segment in found.segments] for found in plain])
    for tube, mass in zip(tubes, masses, strict=True):
        assert mass.sum() == pytest.approx(np.trapezoid(tube.mass_per_length, tube.z), rel=1e-12)
    # the wall at 30 m changes what lies between 20 m and 40 m, and the hinges there; nothing else
    moved = masses[2] != masses[0]
    assert moved.tolist() == [False, False, True, True, True, False, False]
    assert (plain[2].stiffness_x != plain[0].stiffness_x).tolist() == [False, False, True, True, False, False]
