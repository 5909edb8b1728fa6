"""Lines that move: against two static profiles, quasi-static limits, a lumped-mass line, and their own response."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Frame, World
from fowtlib.components.mooring import CatenaryLine, catenary, line_motion
from fowtlib.language import Assembly, Component, Scalar, Vector, eq, fix_orientation, param, port
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError

# the chain of J.M. Hegseth et al., Marine Structures 72 (2020) 102771: of 81 mm, its fairlead 309.3 m above the seabed
WEIGHT, EA, LENGTH, DISTANCE, HEIGHT = 1230.2, 590.5e6, 1497.2, 1433.0, 309.3
DIAMETER, RHO = 0.1487, 1025.0  # of a bar that displaces the same water
MASS = WEIGHT / 9.80665 + RHO * np.pi / 4 * DIAMETER**2
HELD = 1e4  # friction that holds all of the line on the seabed


def line(friction=0.0):
    return catenary.Line(LENGTH, WEIGHT, EA, friction)


def coefficients(H, V, friction=0.0, mass=1.0, drag=1.0):
    found = line_motion.coefficients(H, V, line(friction), mass, drag)
    return type(found)(*(np.array(value, dtype=float).ravel().squeeze() for value in found))


# --- coefficients -----------------------------------------------------------------------------------------------------


def test_the_line_of_the_printed_optimum():
    """Values of an independent catenary whose line on the seabed does not stretch: H, top, hanging, stiffness of 3."""
    H, V = catenary.fairlead_tension(DISTANCE, HEIGHT, line(HELD))
    assert (H, np.hypot(H, V)) == (pytest.approx(1.675e6, rel=1e-3), pytest.approx(2.055e6, rel=1e-3))
    assert LENGTH - catenary.state(H, V, line(HELD)).grounded == pytest.approx(967, abs=0.5)
    of_one = catenary.stiffness(H, V, line(HELD))[0, 0]
    assert 1.5 * of_one == pytest.approx(70.5e3, rel=1e-3)  # one line ahead, two at 60 degrees behind
    H, V = catenary.fairlead_tension(DISTANCE + 18, HEIGHT, line(HELD))
    assert (H, np.hypot(H, V)) == (pytest.approx(2.83e6, rel=3e-3), pytest.approx(3.20e6, rel=3e-3))


@pytest.mark.parametrize("friction", [0.0, 1.0, HELD])
@pytest.mark.parametrize("offset", [0.0, 18.0, 28.0])
def test_series_stiffness_is_the_slope_of_the_tension_in_balance(friction, offset):
    H, V = catenary.fairlead_tension(DISTANCE + offset, HEIGHT, line(friction))
    along = np.array([H, V]) / np.hypot(H, V)
    found = coefficients(H, V, friction)
    step = 0.05
    ends = [catenary.fairlead_tension(DISTANCE + offset + s * along[0], HEIGHT + s * along[1], line(friction))
            for s in (step, -step)]  # fmt: skip
    tensions = [along @ np.array(pair) for pair in ends]
    slope = (tensions[0] - tensions[1]) / (2 * step)
    assert found.elastic * found.geometric / (found.elastic + found.geometric) == pytest.approx(slope, rel=2e-3)
    assert found.slope @ along == pytest.approx(slope, rel=2e-3)
    hanging = LENGTH - catenary.state(H, V, line(friction)).grounded
    if friction == 0:
        assert found.elastic == pytest.approx(EA / LENGTH, rel=1e-6)
    elif friction == HELD:
        assert found.elastic == pytest.approx(EA / hanging, rel=1e-6)
    else:
        assert EA / LENGTH < found.elastic < EA / hanging


@pytest.mark.parametrize("offset", [0.0, 18.0])
def test_shape_from_two_profiles_in_balance(offset):
    """Textbook catenaries before and after a motion of the fairlead along the line, point by point, integrated."""
    friction, step = HELD, 0.02
    H, V = catenary.fairlead_tension(DISTANCE + offset, HEIGHT, line(friction))
    along = np.array([H, V]) / np.hypot(H, V)
    q = np.linspace(0, LENGTH - catenary.state(H, V, line(friction)).grounded, 4001)  # below the fairlead

    def points(s):
        x, z = DISTANCE + offset + s * along[0], HEIGHT + s * along[1]
        H, V = catenary.fairlead_tension(x, z, line(friction))
        low, high = (V - WEIGHT * q) / H, V / H
        run = H / WEIGHT * (np.arcsinh(high) - np.arcsinh(low)) + H * q / EA
        rise = H / WEIGHT * (np.hypot(1, high) - np.hypot(1, low)) + (V * q - WEIGHT * q**2 / 2) / EA
        return np.array([x - run, z - rise])

    moved = (points(step) - points(-step)) / (2 * step)
    slope = (V - WEIGHT * q) / H
    across = (moved[1] - slope * moved[0]) / np.hypot(1, slope)
    found = coefficients(H, V, friction)
    r = across * (found.elastic + found.geometric) / found.elastic
    assert r[0] == pytest.approx(0, abs=1e-3) and abs(r[-1]) < 2e-3
    assert found.mass == pytest.approx(np.trapezoid(r**2, q), rel=2e-3)
    assert found.drag == pytest.approx(np.trapezoid(np.abs(r) ** 3, q), rel=2e-3)


def test_the_quadrature_is_fine_enough(monkeypatch):
    for friction in (0.0, HELD):
        for offset in (-100.0, 0.0, 30.0, 60.0):  # from much on the seabed to taut
            H, V = catenary.fairlead_tension(DISTANCE + offset, HEIGHT, line(friction))
            few = coefficients(H, V, friction)
            monkeypatch.setattr(line_motion, "POINTS", 60)
            many = coefficients(H, V, friction)
            monkeypatch.undo()
            assert (few.mass, few.drag) == (pytest.approx(many.mass, rel=1e-3), pytest.approx(many.drag, rel=2e-3))


# --- a line whose fairlead is moved -----------------------------------------------------------------------------------


class Shaken(Component):
    """A frame that goes to and fro about a place, centre + amplitude sin(2 pi f t) direction, rising over 2 periods."""

    centre: Vector = param(unit="m", doc="place")
    direction: Vector = param(doc="unit vector")
    amplitude: Scalar = param(unit="m", doc="amplitude")
    frequency: Scalar = param(unit="Hz", doc="frequency")

    frame: Frame = port(doc="what moves")

    def equations(self):
        turns = self.frequency * self.time
        rising = m.if_else(turns < 2, (1 - m.cos(m.pi * turns / 2)) / 2, 1)
        way = self.amplitude * rising * m.sin(2 * m.pi * turns)
        return [eq(self.frame.r, self.centre + way * self.direction), fix_orientation(self.frame, m.eye(3), m.zeros(3))]


CHAIN = {"length": LENGTH, "axial_stiffness": EA, "mass_per_length": WEIGHT / 9.80665 + RHO * np.pi / 4 * DIAMETER**2,
         "diameter": DIAMETER, "anchor_position": (0, 0, -320.0)}  # fmt: skip


def shaken(offset=18.0, friction=1.0, **values):
    H, V = catenary.fairlead_tension(DISTANCE + offset, HEIGHT, line(friction))
    along = np.array([H, 0, V]) / np.hypot(H, V)
    model = Assembly("a line that is shaken")
    model.world = World(water_depth=320.0)
    model.hand = Shaken(centre=(DISTANCE + offset, 0, HEIGHT - 320), direction=along, amplitude=1.0, frequency=0.1)
    model.line = CatenaryLine(friction=friction, **{**CHAIN, "dynamics": "coupled", **values})
    model.connect(model.hand.frame, model.line.fairlead)
    return fw.load(model).compile(), coefficients(H, V, friction)


def amplitude_of(time, values, period, periods=2):
    """Complex amplitude of the last periods, of sin: 1 is in phase with the motion."""
    last = time > time[-1] - periods * period + 1e-9
    return 2j * np.mean((values - np.mean(values[last]))[last] * np.exp(-2j * np.pi * time[last] / period))


def simulated(plant, period, amplitude=1.0, periods=8, **parameters):
    given = {"hand.frequency": 1 / period, "hand.amplitude": amplitude, **parameters}
    result = plant.simulate(periods * period, output_step=period / 400, solver="fixed", parameters=given)
    return result.time, {name: result[f"line.{name}"].values for name in ("tension", "static_tension")}


def test_slow_motions_have_the_tension_of_the_catenary_and_fast_ones_that_of_stretch():
    plant, found = shaken()
    time, tensions = simulated(plant, 5000.0, periods=4)
    slow = amplitude_of(time, tensions["tension"], 5000.0)
    static = amplitude_of(time, tensions["static_tension"], 5000.0)
    series = found.elastic * found.geometric / (found.elastic + found.geometric)
    assert abs(slow - static) < 0.01 * abs(static)
    assert abs(static) == pytest.approx(series, rel=5e-3)
    held = {"line.drag_coefficient": 5000.0}
    time, tensions = simulated(plant, 10.0, 0.05, **held)
    fast = amplitude_of(time, tensions["tension"], 10.0)
    axial = CHAIN["mass_per_length"] * EA / found.elastic / 3 * (2 * np.pi / 10) ** 2  # 7 % here
    assert abs(fast) / 0.05 == pytest.approx(found.elastic - axial, rel=0.02)
    assert abs(np.angle(fast, deg=True)) < 6


def lumped(motion, velocity, end, offset, friction, step=0.005, n=48):
    """Tension at the fairlead of a chain of point masses over the seabed; explicit, in two dimensions.

    Links stretch, with 2 % of damping; water adds mass and drag across the line; the seabed is a spring with Coulomb
    friction. motion, velocity: of the fairlead (t, 2).
    """
    H, V = catenary.fairlead_tension(DISTANCE + offset, HEIGHT, line(friction))
    form = catenary.profile(H, V, line(friction), points=n + 1)
    r, ds = np.stack([form["x"], form["z"]], axis=1), LENGTH / n
    v, place = np.zeros_like(r), r[-1].copy()
    mass = CHAIN["mass_per_length"] * ds
    both, drag = mass + RHO * np.pi / 4 * DIAMETER**2 * ds, 0.5 * RHO * 1.33 * DIAMETER * ds
    weight = WEIGHT * ds
    ground, damping, inner = weight / 0.02, np.sqrt(weight / 0.02 * mass), 0.04 * np.sqrt(EA / ds * mass)
    tensions = np.zeros(round(end / step))
    for i in range(tensions.size):
        r[-1], v[-1] = place + motion(i * step), velocity(i * step)
        link, rate = np.diff(r, axis=0), np.diff(v, axis=0)
        size = np.hypot(link[:, 0], link[:, 1])
        link /= size[:, None]
        T = np.maximum(EA * (size / ds - 1), 0) + inner * np.sum(rate * link, axis=1)
        tensions[i] = T[-1]
        force = np.diff(T[:, None] * link, axis=0)
        depth = -r[1:-1, 1]
        push = np.where(depth > 0, np.maximum(ground * depth - damping * v[1:-1, 1], 0), 0)
        force[:, 1] += push - weight
        axis = link[1:] + link[:-1]
        axis /= np.hypot(axis[:, 0], axis[:, 1])[:, None]
        along = np.sum(force * axis, axis=1)[:, None] * axis
        u = v[1:-1] + step * (along / mass + (force - along) / both)
        along = np.sum(u * axis, axis=1)[:, None] * axis
        across = u - along
        u = along + across / (1 + step * drag * np.hypot(across[:, 0], across[:, 1]) / both)[:, None]
        stop = friction * push * step / mass
        u[:, 0] -= np.clip(u[:, 0], -stop, stop)
        v[1:-1] = u
        r[1:-1] += step * u
    return np.arange(tensions.size) * step, tensions


@pytest.mark.parametrize(("period", "amplitude", "share"), [(20.0, 1.0, 0.13), (10.0, 3.0, 0.11)])
def test_against_a_lumped_mass_line(period, amplitude, share):
    """A chain of 81 mm at an offset of 18 m, on a seabed with friction 1; the line in balance is far off.

    Amplitudes of 0.3, 1 and 3 m, periods of 20, 10 and 6 s: the model has 0.89 to 1.10 of the tension, and phases
    agree to 8 degrees; at 6 s to 17 degrees.
    """
    plant, found = shaken()
    time, tensions = simulated(plant, period, amplitude)
    ours = amplitude_of(time, tensions["tension"], period) / amplitude
    static = amplitude_of(time, tensions["static_tension"], period) / amplitude
    H, V = catenary.fairlead_tension(DISTANCE + 18, HEIGHT, line(1.0))
    along = np.array([H, V]) / np.hypot(H, V)

    def way(t):
        rising = (1 - np.cos(np.pi * t / period / 2)) / 2 if t < 2 * period else 1.0
        return amplitude * rising * np.sin(2 * np.pi * t / period) * along

    def speed(t):
        return (way(t + 1e-4) - way(t - 1e-4)) / 2e-4

    other = amplitude_of(*lumped(way, speed, 6 * period, 18.0, 1.0), period) / amplitude
    assert abs(ours) == pytest.approx(abs(other), rel=share)
    assert np.angle(ours / other, deg=True) == pytest.approx(0, abs=8)
    assert abs(static - other) > 3 * abs(ours - other)


def test_a_body_feels_the_line_or_does_not():
    """Coupled, the fairlead takes the tension of the moving line; uncoupled that of the line in balance."""
    for kind in ("coupled", "uncoupled", "none"):
        plant, _ = shaken(dynamics=kind)
        result = plant.simulate(30.0, output_step=0.1)
        f = np.hypot(result["line.fairlead.f[0]"].values, result["line.fairlead.f[2]"].values)
        tension = result["line.tension" if kind != "uncoupled" else "line.static_tension"].values
        assert f == pytest.approx(tension, rel=1e-6)
        if kind != "none":
            assert np.abs(result["line.tension"].values - result["line.static_tension"].values).max() > 1e5
    assert not plant.dae.states  # a line without dynamics has none


def test_a_line_that_is_lost_pulls_no_more():
    plant, _ = shaken()
    result = plant.simulate(40.0, output_step=0.1, events=[{"at": 15.0, "event": "line.loss"}])
    after = result.time > 15.2
    for name in ("tension", "dynamic_tension", "static_tension", "fairlead.f[0]"):
        assert np.abs(result[f"line.{name}"].values[after]).max() < 1e-6
    assert np.abs(result["line.tension"].values[result.time < 14.8]).min() > 1e6


def test_what_a_moving_line_needs():
    with pytest.raises(ParameterError, match="need mass_per_length and diameter"):
        shaken(mass_per_length=None, diameter=0.0, weight_per_length=WEIGHT)
    model = Assembly("between two bodies")
    model.world = World(water_depth=320.0)
    model.hand = Shaken(centre=(DISTANCE, 0, -10.7), direction=(1, 0, 0), amplitude=1.0, frequency=0.1)
    model.foot = Shaken(centre=(0, 0, -320), direction=(1, 0, 0), amplitude=0.0, frequency=0.1)
    model.line = CatenaryLine(**{**CHAIN, "dynamics": "coupled"})
    model.connect(model.hand.frame, model.line.fairlead)
    model.connect(model.foot.frame, model.line.anchor)
    with pytest.raises(ParameterError, match="its anchor is a body"):
        fw.load(model).compile()
