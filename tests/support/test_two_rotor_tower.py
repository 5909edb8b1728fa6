"""The tower with two arms: statics by hand, frequencies against finite elements written here, symmetry, hub places."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import eigh
from scipy.optimize import brentq

from fowtlib.modelfile import load

G = 9.80665
E, SHEAR, DENSITY, WIRE, MASS = 210e9, 80.8e9, 8500.0, 1.151e9, 60.88
SPAN, ROOT, TOP = 69.3, 2.395, 69.3 * np.tan(np.pi / 6)


def tube(outer, wall):
    """Area and second moment of a ring."""
    inner = outer - 2 * wall
    return np.pi / 4 * (outer**2 - inner**2), np.pi / 64 * (outer**4 - inner**4)


class Frame:
    """Euler-Bernoulli frame: six degrees of freedom a node, geometric stiffness, consistent mass, rotary inertia."""

    def __init__(self, axial_factor):
        self.points, self.terms, self.axial_factor = [], [], axial_factor

    def node(self, point):
        self.points.append(np.array(point, dtype=float))
        return len(self.points) - 1

    def member(self, first, end, outer, wall, elements, axial):
        """A straight tapered tube from node `first` to the point `end`, axial(x) its tension; returns its last node."""
        a, last = self.points[first], first
        for k in range(elements):
            x = (k + 0.5) / elements
            node = self.node(a + (np.array(end) - a) * (k + 1) / elements)
            D, t = (np.interp(x, [0, 1], values) for values in (outer, wall))
            self.beam(last, node, *tube(D, t), axial(x))
            last = node
        return last

    def beam(self, i, j, A, inertia, N=0.0, density=DENSITY, factor=1.0):
        """One element; factor > 1 makes a rigid one."""
        d = self.points[j] - self.points[i]
        h = np.linalg.norm(d)
        z = d / h
        x = np.cross(z, (0, 0, 1)) if abs(z[2]) < 0.9 else np.array([1.0, 0, 0])
        x /= np.linalg.norm(x)
        T = np.kron(np.eye(4), np.array([x, np.cross(z, x), z]))
        K, M = np.zeros((2, 12, 12))
        bending = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                            [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) / h**3  # fmt: skip
        tension = np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h**2, -3 * h, -(h**2)],
                            [-36, -3 * h, 36, -3 * h], [3 * h, -(h**2), -3 * h, 4 * h**2]]) / (30 * h)  # fmt: skip
        mass = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                         [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]) / 420  # fmt: skip
        for dofs, sign in (([0, 4, 6, 10], 1), ([1, 3, 7, 9], -1)):
            S = np.diag([1, sign, 1, sign])
            block = np.ix_(dofs, dofs)
            K[block] += S @ (factor * E * inertia * bending + N * tension) @ S
            M[block] += S @ (density * A * h * mass + density * inertia * tension) @ S
        two, polar = np.array([[1, -1], [-1, 1]]), 2 * inertia
        stretch = self.axial_factor * E * A / h
        for dofs, k, m in (([2, 8], stretch, density * A * h), ([5, 11], SHEAR * polar / h, density * polar * h)):
            block = np.ix_(dofs, dofs)
            K[block] += factor * k * two
            M[block] += m / 6 * np.array([[2, 1], [1, 2]])
        self.terms.append(([*range(6 * i, 6 * i + 6), *range(6 * j, 6 * j + 6)], T.T @ K @ T, T.T @ M @ T))

    def wire(self, i, j, tension):
        d = self.points[j] - self.points[i]
        h = np.linalg.norm(d)
        unstretched = h / (1 + tension / WIRE)
        n = np.outer(d, d) / h**2
        k = WIRE / unstretched * n + tension / h * (np.eye(3) - n)
        dofs = [*range(6 * i, 6 * i + 3), *range(6 * j, 6 * j + 3)]
        self.terms.append((dofs, np.block([[k, -k], [-k, k]]), MASS * unstretched / 2 * np.eye(6)))

    def frequencies(self, masses):
        n = 6 * len(self.points)
        K, M = np.zeros((2, n, n))
        for dofs, k, m in self.terms:
            K[np.ix_(dofs, dofs)] += k
            M[np.ix_(dofs, dofs)] += m
        for node, mass in masses:
            for k in range(3):
                M[6 * node + k, 6 * node + k] += mass
        return np.sqrt(eigh(K[6:, 6:], M[6:, 6:], eigvals_only=True, subset_by_index=[0, 11])) / (2 * np.pi)


def finite_elements(tension, gravity, head=350e3, elements=16, axial_factor=1.0):
    """Frequencies [Hz] and masses [kg]; axial forces from the weights and from the tension of the wires."""
    area = {name: np.mean([tube(D, t)[0] for D, t in zip(*np.linspace(*ends, 2001).T, strict=True)])
            for name, ends in {"tower": ((6.28, 0.03), (4.79, 0.0215)), "arm": ((4.79, 0.028), (1.79, 0.010)),
                               "top": ((3.29, 0.014), (3.29, 0.014))}.items()}  # fmt: skip
    lengths = {"tower": 80.0, "arm": SPAN - ROOT, "top": TOP}
    mass = {name: DENSITY * area[name] * length for name, length in lengths.items()}
    wire = MASS * (SPAN / np.cos(np.pi / 6)) / (1 + tension / WIRE)
    above = 2 * head + 2 * mass["arm"] + mass["top"] + 2 * wire
    frame = Frame(axial_factor)
    crown = frame.member(frame.node((0, 0, 10)), (0, 0, 90), (6.28, 4.79), (0.03, 0.0215), elements,
                         lambda x: -gravity * (above + (1 - x) * mass["tower"]))  # fmt: skip
    top = frame.member(crown, (0, 0, 90 + TOP), (3.29, 3.29), (0.014, 0.014), elements,
                       lambda x: -tension - gravity * (wire + (1 - x) * mass["top"]))  # fmt: skip
    masses = []
    for side in (1, -1):
        root = frame.node((0, side * ROOT, 90))
        frame.beam(crown, root, 0.4, 1.0, density=0.0, factor=1e3)
        tip = frame.member(root, (0, side * SPAN, 90), (4.79, 1.79), (0.028, 0.010), elements,
                           lambda x: -tension * np.cos(np.pi / 6))  # fmt: skip
        frame.wire(tip, top, tension)
        masses.append((tip, head))
    return frame.frequencies(masses), mass


def support(**changes):
    return load("two_rotor_support", set={f"support.{name}": value for name, value in changes.items()})


@pytest.fixture(scope="module")
def loaded():
    plant = support().compile()
    return plant, plant.equilibrium()


def test_masses():
    """Tower 305 t, arms 119 t each, cylinder 49 t: with both wires 602 t; the source has 536.9 t (see SOURCES.md)."""
    _, mass = finite_elements(0.0, 0.0, elements=2)
    root = support().root
    found = {name: sum(part.mass for key, part in root.support.parts[place].beam.parts.items()
                       if key.startswith("segment")) for name, place in
             (("tower", "tower"), ("arm", "arm_left"), ("top", "top"))}  # fmt: skip
    for name, value in mass.items():
        assert found[name] == pytest.approx(value, rel=1e-3)
    assert [mass[name] / 1e3 for name in ("tower", "arm", "top")] == pytest.approx([305.3, 119.0, 49.0], abs=0.1)


def sagging_arm(pretension):
    """Sag of the tip [m], tension [N] and root moment [N m] by integrals along the arm, the wire at its angle.

    The bending moment is that of the weights, of the wire and of its pressure times the deflection; the curvature
    shortens the arm.
    """
    L, s = SPAN - ROOT, np.linspace(0, SPAN - ROOT, 2001)
    A, inertia = np.array([tube(4.79 - 3.0 * x / L, 0.028 - 0.018 * x / L) for x in s]).T
    weight = np.array([np.trapezoid(A[i:] * (s[i:] - s[i]), s[i:]) for i in range(len(s))]) * DENSITY * G
    length = SPAN / np.cos(np.pi / 6)
    unstretched = length / (1 + pretension / WIRE)

    def bent(tension):
        w, short = np.zeros_like(s), 0.0
        for _ in range(20):
            angle = np.arctan2(TOP + w[-1], SPAN - short)
            tip = (350e3 + MASS * unstretched / 2) * G - tension * np.sin(angle)
            moment = weight + tip * (L - s) + tension * np.cos(angle) * (w[-1] - w)
            slope = cumulative_trapezoid(moment / (E * inertia), s, initial=0)
            w, short = cumulative_trapezoid(slope, s, initial=0), np.trapezoid(slope**2, s) / 2
        return w[-1], moment[0], np.hypot(TOP + w[-1], SPAN - short)

    tension = brentq(lambda T: T - pretension - WIRE / unstretched * (bent(T)[2] - length), 1e6, 2e7)
    return bent(tension)[0], tension, bent(tension)[1]


def test_the_wires_carry_the_tips(loaded):
    """With the wires fitted without tension, and as shipped; both sides alike, nothing left over at the base."""
    plant, shipped = loaded
    for state, pretension in ((plant.equilibrium(parameters={"support.wire_pretension": 0.0}), 0.0), (shipped, 7.24e6)):
        sag, tension, moment = sagging_arm(pretension)
        assert state["tip_sag_left"] == pytest.approx(-sag, rel=0.002, abs=2e-4)
        assert state["wire_tension_left"] == pytest.approx(tension / 1e3, rel=0.002)
        assert state["arm_vertical_moment_left"] == pytest.approx(moment / 1e3, rel=0.005)
        for name in ("tip_sag", "wire_tension", "arm_vertical_moment"):
            assert state[f"{name}_left"] == pytest.approx(float(state[f"{name}_right"]), rel=1e-9)
        for name in ("fore_aft_moment", "side_side_moment", "torsion"):
            assert state[f"tower_{name}"] == pytest.approx(0.0, abs=1e-3)


def test_frequencies_without_load():
    """Weightless, wires without tension, against finite elements with the same sections (which may stretch)."""
    model = load("two_rotor_support", set={"world.gravity": 0, "support.wire_pretension": 0})
    plant = model.compile()
    found = [mode.frequency_hz for mode in plant.linearize(plant.initial_state()).modes()]
    exact, _ = finite_elements(0.0, 0.0)
    assert found[:6] == pytest.approx(exact[:6], rel=0.02)


def test_frequencies_under_load(loaded):
    """At rest under the weights, with the wires tight: geometric stiffness in the finite elements.

    The beams of the model do not stretch; beside finite elements that do not either, the error is that of few hinges.
    """
    plant, state = loaded
    found = [mode.frequency_hz for mode in plant.linearize(state).modes()]
    tension = float(state["wire_tension_left"]) * 1e3
    assert found[:6] == pytest.approx(finite_elements(tension, G)[0][:6], rel=0.02)
    assert found[:6] == pytest.approx(finite_elements(tension, G, axial_factor=1e3)[0][:6], rel=0.01)


TURBINES = """
fowtlib: 1
title: two turbines on their tower
world: {class: World}
parts:
  ground: {class: Fixed, r: [0, 0, 10]}
  support: {use: towers/two_rotor, tower_hinges: 0, top_hinges: 0, arm_hinges: 0, wire_pretension: 0}
each:
  - for: [{name: left, way: 1}, {name: right, way: -1}]
    parts:
      turbine_{name}:
        class: RotorNacelleAssembly
        rotation: way
        blade_properties: data:nrel5mw/blade_structure.csv
        blade_hinges: 0
        parts:
          nacelle: {mass: 240 t, centre_of_mass: [1.9, 0, 1.75], shaft_height: 1.96256, tilt: 5 deg, overhang: 5.0191}
          hub: {radius: 1.5 m, precone: 2.5 deg, mass: 56780 kg}
          drivetrain: {gear_ratio: 97, stiffness: 8.67637e8 N*m/rad, generator_inertia: 534.116 kg*m^2}
    connect:
      - ["support.arm_{name}.tip", "turbine_{name}.frame"]
connect:
  - [ground.frame, support.base]
"""


def test_the_hubs_end_where_they_belong(tmp_path):
    """Rigid: hubs 90 m above the water, 69.3 m off the axis, 5 m upwind of it; weights bend and turn the arms."""
    path = tmp_path / "turbines.yaml"
    path.write_text(TURBINES)
    state = load(str(path)).compile().initial_state()
    weight, span = 350e3 * G, SPAN - ROOT
    for name, side in (("left", 1), ("right", -1)):
        assert np.ravel(state[f"turbine_{name}.hub.frame.r"]) == pytest.approx([-5.0, side * SPAN, 90.0], abs=1e-3)
        s = np.linspace(0, span, 4001)
        A = np.array([tube(4.79 - 3.0 * x / span, 0.028 - 0.018 * x / span)[0] for x in s])
        own = np.trapezoid(A * s, s) * DENSITY * G
        wire = MASS * SPAN / np.cos(np.pi / 6) / 2 * G  # half a wire hangs at the tip
        arm = f"support.arm_{name}"
        assert state[f"{arm}.root_vertical_moment"] == pytest.approx((weight + wire) * span + own, rel=1e-3)
        assert state[f"{arm}.root_torsion"] == pytest.approx(-0.413771 * weight, rel=0.01)
        assert state[f"{arm}.root_horizontal_moment"] == pytest.approx(0.0, abs=1e-3 * weight)
    assert state["support.tower.base_fore_aft_moment"] == pytest.approx(-0.413771 * 2 * weight, rel=0.01)
