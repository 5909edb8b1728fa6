"""Space frames against closed forms: bending, shear, torsion, buckling, free beams, arms, rigid motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import eigvals

from fowtlib.components.platform.space_frame import Beam, NodeMass, Section, SpaceFrame
from fowtlib.language.errors import ParameterError

STEEL = {"density": 7850.0, "young_modulus": 210e9, "shear_modulus": 80.8e9}
RNG = np.random.default_rng(3)


def beam_along(direction, length=40.0, pieces=8, section=None, first=(0, 0, 0), **others):
    """A straight beam from the origin."""
    unit = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    section = section or Section.tube(2.0, 0.03, **STEEL)
    nodes = np.linspace(0, length, pieces + 1)[:, None] * unit
    return SpaceFrame(nodes, [Beam(k, k + 1, section, first) for k in range(pieces)], **others)


def clamped(frame):
    held = np.zeros((len(frame.nodes), 6), dtype=bool)
    held[0] = True
    return held


def random_turn():
    turn = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 0, 1), (0, -1, 0), (1, 2, -0.7)])
def test_a_cantilever_of_timoshenko(direction):
    """A force across: w = F L^3 / 3EI + F L / G A_s, theta = F L^2 / 2EI; torsion T L / GJ; stretch N L / EA."""
    frame, length = beam_along(direction), 40.0
    section = frame.beams[0].section
    unit = np.asarray(direction) / np.linalg.norm(direction)
    across = np.cross(unit, [0.3, 0.5, -0.8])
    across /= np.linalg.norm(across)
    loads = np.zeros((9, 6))
    loads[-1] = [*(1e5 * across + 3e5 * unit), *(2e5 * unit)]
    moved = frame.static(loads, clamped(frame))[-1]
    e, g = section.young_modulus, section.shear_modulus
    bent = 1e5 * (length**3 / (3 * e * section.about_first) + length / (g * section.shear_first))
    assert moved[:3] @ across == pytest.approx(bent, rel=1e-9)
    assert moved[:3] @ unit == pytest.approx(3e5 * length / (e * section.area), rel=1e-9)
    assert moved[3:] @ unit == pytest.approx(2e5 * length / (g * section.torsion), rel=1e-9)
    turn = 1e5 * length**2 / (2 * e * section.about_first) * np.cross(unit, across)
    np.testing.assert_allclose(moved[3:] - moved[3:] @ unit * unit, turn, rtol=1e-9, atol=1e-12)
    assert frame.tensions(frame.static(loads, clamped(frame))) == pytest.approx(3e5, rel=1e-9)


def test_a_box_bends_about_its_axes():
    section = Section.box((4.0, 2.0), 0.05, **STEEL)
    length = 60.0
    for along_first in (True, False):
        frame = beam_along((1, 0, 0), length, section=section, first=(0, 1, 0))
        loads = np.zeros((9, 6))
        loads[-1, 1 if along_first else 2] = 1e5
        moved = frame.static(loads, clamped(frame))[-1, 1 if along_first else 2]
        second = section.about_second if along_first else section.about_first
        shear = section.shear_first if along_first else section.shear_second
        bent = length**3 / (3 * section.young_modulus * second) + length / (section.shear_modulus * shear)
        assert moved == pytest.approx(1e5 * bent, rel=1e-9)
    assert section.about_second > section.about_first
    thin = Section.box((2.0, 2.0), 0.01, **STEEL)
    assert thin.torsion == pytest.approx((2.0 - 0.01) ** 3 * 0.01, rel=1e-9)  # a^3 t of a thin square


def test_free_beam_has_six_rigid_motions_and_the_roots_of_bending():
    """Roots beta L = 4.7300, 7.8532, 10.9956: R.D. Blevins, Formulas for Natural Frequency and Mode Shape (1979)."""
    section = Section(0.2, 0.1, 0.1, 0.2, 210e9, 80e9, 1500.0, 1500.0)
    modes = beam_along((1, 1, 0), 100.0, 20, section).modes(12)
    assert modes.frequencies[:6] == pytest.approx(0, abs=1e-3 * modes.frequencies[6])
    scale = math.sqrt(section.young_modulus * section.about_first / 1500.0) / 100.0**2
    bending = sorted(w for w in modes.frequencies[6:] if w < 11.5**2 * scale)
    expected = np.repeat(np.array([4.73004, 7.85320, 10.99561]) ** 2 * scale, 2)
    np.testing.assert_allclose(bending[:6], expected[: len(bending[:6])], rtol=2e-4)


def test_shear_and_rotary_inertia_lower_a_short_beam():
    """Pinned beam: (EI k^4 / m) / (1 + k^2 I/A (1 + E/(kappa G))) to second order, Timoshenko (1921)."""
    section = Section.tube(4.0, 0.1, **STEEL)
    length = 40.0
    frame = beam_along((1, 0, 0), length, 32, section)
    held = np.zeros((33, 6), dtype=bool)
    held[[0, -1], 1:3] = True
    held[0, [0, 3]] = True
    held[:, [2, 4]] = True  # one plane
    lowest = frame.modes(1, held).frequencies[0]
    k, ratio = math.pi / length, section.about_first / section.area
    c2 = section.young_modulus * section.about_first / section.mass
    b = 1 + k**2 * ratio * (1 + section.young_modulus * section.area / (section.shear_modulus * section.shear_first))
    a = ratio**2 * STEEL["density"] * section.area / (section.shear_modulus * section.shear_first) / 1.0
    a *= section.mass / (section.young_modulus * section.about_first) * section.young_modulus / STEEL["density"]
    squared = (b - math.sqrt(b**2 - 4 * a * c2 * k**4)) / (2 * a)
    assert lowest == pytest.approx(math.sqrt(squared), rel=1e-3)
    assert lowest < 0.985 * k**2 * math.sqrt(c2)


@pytest.mark.parametrize("direction", [(0, 0, 1), (2, -1, 0.3)])
def test_a_column_buckles_at_eulers_load(direction):
    section = Section(0.2, 0.1, 0.1, 0.2, 210e9, 80e9, 1500.0, 1500.0)
    frame = beam_along(direction, 60.0, 10, section)
    euler = math.pi**2 * section.young_modulus * section.about_first / (4 * 60.0**2)
    held = clamped(frame)
    free, before, beyond = (frame.modes(1, held, -share * euler).frequencies[0] for share in (0, 0.9995, 1.0005))
    assert 0.0 < before < 0.03 * free and beyond == 0.0


def test_rigid_motion_makes_no_force_and_keeps_the_mass():
    """Also with arms: an L with a mass off its nodes, anywhere."""
    section = Section.box((4.0, 2.0), 0.05, **STEEL)
    turn = random_turn()
    nodes = np.array([[0, 0, 0], [30, 0, 0], [30, 25, 5]]) @ turn.T
    arms = [tuple(turn @ (0, 0, 3)), tuple(turn @ (-2, 0, 0))]
    beams = [Beam(0, 1, section, end_arm=arms[0]), Beam(1, 2, section, start_arm=arms[1])]
    inertia = np.diag([3e6, 2e6, 1e6])
    frame = SpaceFrame(nodes, beams, [NodeMass(2, 4e5, (1, 2, 3), inertia)])
    rigid = np.zeros((6, 3, 6))
    for k in range(3):
        rigid[k, :, k] = 1
        axis = np.eye(3)[k]
        rigid[3 + k, :, :3], rigid[3 + k, :, 3:] = np.cross(axis, nodes), axis
    moved = rigid.reshape(6, -1)
    assert np.abs(frame.stiffness @ moved.T).max() < 1e-6 * frame.stiffness.max()
    total = moved @ (frame.mass @ moved.T)
    lengths = [np.linalg.norm(nodes[1] + arms[0] - nodes[0]), np.linalg.norm(nodes[2] - nodes[1] - arms[1])]
    mass = 4e5 + section.mass * sum(lengths)
    np.testing.assert_allclose(total[:3, :3], mass * np.eye(3), rtol=1e-12, atol=1e-6 * mass)
    centre = 4e5 * (nodes[2] + (1, 2, 3)) + section.mass * (
        lengths[0] * (nodes[0] + nodes[1] + arms[0]) / 2 + lengths[1] * (nodes[1] + arms[1] + nodes[2]) / 2
    )
    np.testing.assert_allclose([total[2, 4], total[0, 5], total[1, 3]], [-centre[0], -centre[1], -centre[2]], rtol=1e-9)


def test_an_arm_is_a_stiff_beam():
    section, stiff = Section.tube(2.0, 0.03, **STEEL), Section.tube(20.0, 5.0, 1e-3, 210e13, 80e13)
    loads = np.zeros((3, 6))
    loads[2] = [1e5, 2e5, 3e5, 1e5, 0, 0]
    nodes = np.array([[0, 0, 0], [20, 0, 4], [40, 10, 4]], dtype=float)
    with_arm = SpaceFrame(nodes, [Beam(0, 1, section, end_arm=(0, 0, -4)), Beam(1, 2, section)])
    more = np.vstack([nodes, [[20, 0, 0]]])
    with_beam = SpaceFrame(more, [Beam(0, 3, section), Beam(3, 1, stiff), Beam(1, 2, section)])
    one = with_arm.static(loads, clamped(with_arm))
    two = with_beam.static(np.vstack([loads, np.zeros((1, 6))]), clamped(with_beam))
    np.testing.assert_allclose(one, two[:3], rtol=1e-3, atol=1e-6)


def test_section_loads_balance_and_displacements_between_nodes_are_those_of_finer_pieces():
    coarse, fine = beam_along((1, 0, 0), 40.0, 1), beam_along((1, 0, 0), 40.0, 8)
    loads = np.zeros((2, 6))
    loads[-1] = [2e5, 1e5, -5e4, 1e4, 0, 3e5]
    more = np.zeros((9, 6))
    more[-1] = loads[-1]
    moved = coarse.static(loads, clamped(coarse))
    expected = fine.static(more, clamped(fine))
    for k, share in enumerate(np.linspace(0, 1, 9)):
        place, (between,), (rate,) = coarse.section_motion(0, share, moved[None])
        np.testing.assert_allclose(place, fine.nodes[k], atol=1e-9)
        np.testing.assert_allclose(between, expected[k], rtol=1e-6, atol=1e-9)
        ahead, behind = (coarse.section_motion(0, share + step, moved[None])[1][0] for step in (1e-4, -1e-4))
        np.testing.assert_allclose(rate, (ahead - behind) / (2e-4 * 40.0), rtol=1e-5, atol=1e-9)
    ends = coarse.section_loads(moved)[0]
    np.testing.assert_allclose(ends[1, :3], loads[-1, :3], rtol=1e-9)
    np.testing.assert_allclose(ends[0, :3], loads[-1, :3], rtol=1e-9)
    assert ends[0, 5] == pytest.approx(3e5 + 1e5 * 40.0, rel=1e-9)
    assert ends[0, 4] == pytest.approx(5e4 * 40.0, rel=1e-9)


def test_mistakes_are_named():
    section = Section.tube(2.0, 0.03, **STEEL)
    with pytest.raises(ParameterError, match=r"falls into 2 pieces: nothing joins the node at \(40, 0, 0\) m"):
        SpaceFrame([[0, 0, 0], [20, 0, 0], [40, 0, 0], [60, 0, 0]], [Beam(0, 1, section), Beam(2, 3, section)])
    with pytest.raises(ParameterError, match="beam 1 has no length"):
        SpaceFrame([[0, 0, 0], [0, 0, 0]], [Beam(0, 1, section)])
    frame = beam_along((1, 0, 0))
    held = np.zeros((9, 6), dtype=bool)
    held[0, :3] = True
    with pytest.raises(ParameterError, match="free to move"):
        frame.static(np.ones((9, 6)), held)


def loaded(torque=0.0, moment=0.0):
    """A thin beam of 10 m along x in 32 pieces under a torque, or a moment about its strong axis; stiffness by it."""
    section = Section(1.0, 8e-6, 1e-3, 1.2e-5, 210e9, 80e9, 1.0, 1.0)  # weak about the first direction, y
    nodes = np.column_stack([np.linspace(0, 10, 33), np.zeros(33), np.zeros(33)])
    frame = SpaceFrame(nodes, [Beam(k, k + 1, section, (0.0, 1.0, 0.0)) for k in range(32)])
    loads, held = np.zeros((33, 6)), np.zeros((33, 6), dtype=bool)
    held[0] = True
    loads[-1, 3], loads[-1, 5] = torque, moment
    return frame, frame.stress_stiffness(frame.static(loads, held)), section


def critical(frame, stress, free):
    """The smallest factor of the load at which the frame buckles."""
    kept = free.reshape(-1)
    K, S = (matrix.toarray()[np.ix_(kept, kept)] for matrix in (frame.stiffness, stress))
    assert pytest.approx(S.T, abs=1e-9 * np.abs(S).max()) == S
    values = eigvals(K, -S)
    real = values.real[np.isfinite(values) & (np.abs(values.imag) < 1e-6 * np.abs(values))]
    return real[real > 0].min()


def test_a_beam_between_forks_buckles_sideways_as_prandtl_said():
    """Uniform moment pi / L sqrt(E I_weak G J) (S.P. Timoshenko and J.M. Gere, Theory of Elastic Stability, 6.3)."""
    frame, stress, section = loaded(moment=1e3)
    free = np.ones((33, 6), dtype=bool)
    free[:, [0, 1, 5]] = False  # out of the plane of bending alone
    free[[0, -1], 2] = free[[0, -1], 3] = False
    expected = np.pi / 10 * np.sqrt(210e9 * section.about_first * 80e9 * section.torsion)
    assert 1e3 * critical(frame, stress, free) == pytest.approx(expected, rel=1e-3)


def test_a_shaft_that_is_held_at_both_ends_buckles_by_torsion():
    """8.987 E I / L (A.G. Greenhill, 1883, for clamped ends; Timoshenko and Gere, 2.21)."""
    section = Section(1.0, 8e-6, 8e-6, 1.2e-5, 210e9, 80e9, 1.0, 1.0)
    frame, _, _ = loaded()
    frame = SpaceFrame(frame.nodes, [Beam(k, k + 1, section, (0.0, 1.0, 0.0)) for k in range(32)])
    loads, held = np.zeros((33, 6)), np.zeros((33, 6), dtype=bool)
    held[0], loads[-1, 3] = True, 1e3
    stress, free = frame.stress_stiffness(frame.static(loads, held)), np.ones((33, 6), dtype=bool)
    free[[0, -1]] = False
    assert 1e3 * critical(frame, stress, free) == pytest.approx(8.98682 * 210e9 * 8e-6 / 10, rel=1e-3)


def test_loads_turn_with_a_frame_that_turns_as_one():
    """An angle with rigid arms under a load at its end: forces turn with it, of semitangential moments half does."""
    section = Section.tube(1.0, 0.05, 7850.0, 210e9, 80e9)
    nodes = [[0, 0, 0], [4.0, 0, 0], [4.0, 3.0, 0], [4.0, 3.0, 5.0]]
    arms = {"end_arm": (-0.5, 0.2, 0.1)}, {}, {"start_arm": (0, 0, 0.6)}
    beams = [Beam(k, k + 1, section, **arm) for k, arm in enumerate(arms)]
    frame = SpaceFrame(nodes, beams)
    held, loads = np.zeros((4, 6), dtype=bool), np.zeros((4, 6))
    held[0], loads[3] = True, [1e5, -2e5, 3e5, 2e4, 5e4, -4e4]
    moved = frame.static(loads, held)
    stress = frame.stress_stiffness(moved)
    inner = (frame.stiffness @ moved.reshape(-1)).reshape(4, 6)  # by the nodes on the beams, in balance
    for k in range(3):
        axis = np.eye(3)[k]
        turn = np.zeros((4, 6))
        turn[:, :3], turn[:, 3:] = np.cross(axis, frame.nodes), axis
        found = (stress @ turn.reshape(-1)).reshape(4, 6)
        turned = np.cross(axis, inner[:, :3])  # forces that turn with the frame
        moments = np.cross(axis, inner[:, 3:]) / 2  # of semitangential moments half
        assert found[:, :3] == pytest.approx(turned, abs=1e-6 * np.abs(inner).max())
        assert found[:, 3:] == pytest.approx(moments, abs=1e-6 * np.abs(inner).max())
