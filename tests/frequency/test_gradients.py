"""Gradients by adjoints: closed forms, and central differences with Richardson's extrapolation, to 1e-6."""

from __future__ import annotations

import itertools

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.fatigue.spectral import narrow_band
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro import SlenderHullLoads
from fowtlib.components.mechanics import Fixed, PointMass, TubeBeam
from fowtlib.frequency import (
    EquivalentLoad,
    ModeDamping,
    ModeFrequency,
    OfSpectrum,
    PreparedGradient,
    Std,
    best_gain,
    response,
)
from fowtlib.frequency.adjoint import _alike
from fowtlib.frequency.common_sums import _alone, _by_products
from fowtlib.frequency.gain_slopes import gain_slopes, slope_at_mean
from fowtlib.frequency.quantities import with_slopes
from fowtlib.language import (
    Component,
    ExternalFunction,
    Number,
    Scalar,
    Vector,
    at_start,
    der,
    eq,
    param,
    quadratic,
    run_time_series,
    table1d,
    var,
)
from fowtlib.language.errors import ModelError, ParameterError, SimulationError
from fowtlib.solving.closed_slopes import Tangents
from fowtlib.solving.differences import derivative
from fowtlib.solving.stationary_gradients import pole
from fowtlib.solving.together import slopes_together

GRAVITY = 9.81


def check(prepared, relative=1e-6, step=1e-3, point=None):
    """The gradients against differences with steps h, h/2, h/4; a zero counts beside the value of the result."""
    point = prepared.start if point is None else np.asarray(point, dtype=float)
    values, jacobian = prepared.evaluate(point)
    assert prepared.values(point) == pytest.approx(values, rel=1e-9, abs=1e-12)
    for j, value in enumerate(point):
        size = abs(value) or 1.0

        def difference(h, j=j):
            both = [point + sign * h * np.eye(len(point))[j] for sign in (1, -1)]
            return (prepared.values(both[0]) - prepared.values(both[1])) / (2 * h)

        a, b, c = (difference(step * size / part) for part in (1, 2, 4))
        one, two = (4 * b - a) / 3, (4 * c - b) / 3
        wanted = (16 * two - one) / 15
        for k, name in enumerate(prepared.results):
            limit = max(relative * abs(wanted[k]), 1e-8 * abs(values[k]) / size)
            assert abs(jacobian[k, j] - wanted[k]) <= limit, (name, prepared.parameters[j], jacobian[k, j], wanted[k])
    return values, jacobian


# --- parts that have nothing to do with wind ------------------------------------------------------------------------


class Push:
    """A random force with a share that the part says, through a filter of the first order that the part has too."""

    def __call__(self, part):
        return None

    def process(self, part):
        return part

    def response(self, part, omega):
        delay = part.parameter_value("delay")
        return (1 / (1 + 1j * omega * delay))[:, None, None].astype(complex)


class Chain(Component):
    """Two masses on springs and dampers with drag, pushed at random and by a constant force; hardening springs."""

    mass: Scalar = param(default=3.0, unit="kg", doc="of each")
    stiffness: Scalar = param(default=12.0, unit="N/m", doc="of each spring")
    hardening: Scalar = param(default=0.8, unit="N/m^3", doc="of the cube of the stretch")
    damping: Scalar = param(default=0.4, unit="N*s/m", doc="of each damper")
    drag: Scalar = param(default=1.1, unit="kg/m", doc="of the square of the speed")
    force: Scalar = param(default=5.0, unit="N", doc="constant force on the second")
    delay: Scalar = param(default=0.05, unit="s", doc="of what pushes")
    flow: Scalar = param(default=0.0, unit="m/s", doc="of what drags")
    unused: Scalar = param(default=2.0, doc="nothing depends on it")
    level: Number = param(default=2.0, bound=True, min=0, doc="one-sided spectrum of the force [N^2 s/rad]")
    kind: str = param(default="white", bound=True, doc="a word")
    count: int = param(default=2, doc="of masses")

    x1: Scalar = var(unit="m", start=0.0, doc="displacement")
    x2: Scalar = var(unit="m", start=0.0, doc="displacement")
    v1: Scalar = var(unit="m/s", start=0.0, doc="velocity")
    v2: Scalar = var(unit="m/s", start=0.0, doc="velocity")
    pull: Scalar = var(unit="N", doc="force of the first spring")

    def equations(self):
        push = run_time_series(self.time, 1, "push", Push(), of=self)
        stretch = self.x2 - self.x1
        between = self.stiffness * stretch + self.hardening * stretch**3 + self.damping * (self.v2 - self.v1)
        resistance = self.drag * quadratic(self.v2 - self.flow, 1e-6)
        return [
            eq(der(self.x1), self.v1),
            eq(der(self.x2), self.v2),
            eq(self.pull, self.stiffness * self.x1 + self.hardening * self.x1**3),
            eq(self.mass * der(self.v1), between - self.pull - self.damping * self.v1),
            eq(self.mass * der(self.v2), push + self.force - between - resistance),
        ]

    def spectral_density(self, omega):
        return np.full(np.shape(omega), float(self.level))


def model(outputs, **parts):
    root = fw.Assembly("a model")
    for name, part in parts.items():
        setattr(root, name, part)
    return fw.Model(root, outputs=outputs)


def chain(**parameters):
    outputs = {"x": "one.x2", "v": "one.v2", "pull": fw.Output("one.pull", "kN"), "first": "one.x1"}
    return model(outputs, one=Chain(**parameters))


GRID = np.linspace(0.01, 2.0, 300)
TUNED = [f"one.{name}" for name in ("mass", "stiffness", "hardening", "damping", "drag", "force", "delay", "level")]


def test_a_chain_with_drag_in_noise():
    wanted = ["mean x", "std x", "std v", "max pull", "min x", "range pull", "frequency first", "damping x",
              OfSpectrum("pull", lambda s, mean: narrow_band(s).equivalent_load(3.0) + mean**2)]  # fmt: skip
    prepared = PreparedGradient(chain(), wanted, [*TUNED, "one.unused"], frequencies=GRID)
    values, jacobian = check(prepared)
    assert np.all(jacobian[:, -1] == 0)
    assert np.all(jacobian[1:6, TUNED.index("one.level")] != 0)
    found = response(chain(), frequencies=GRID, tolerance=1e-12)
    assert values[1] == pytest.approx(found.std("x"), rel=1e-9)
    assert values[3] == pytest.approx(found.extreme("pull"), rel=1e-9)
    assert values[5] == pytest.approx(found.equivalent_load("pull"), rel=1e-9)


@pytest.mark.parametrize(("noise", "settles"), [(2e-7, True), (1e-4, False)])
def test_drag_that_rounding_keeps_from_settling(monkeypatch, noise, settles):
    from fowtlib.frequency import adjoint

    quiet = PreparedGradient(chain(), ["std x"], ["one.drag"], frequencies=GRID).values()
    sides = itertools.cycle((1, -1))

    class Noisy(adjoint.Grid):
        def gains(self, gains):
            side = next(sides)
            return [gain * (1 + noise * side) for gain in super().gains(gains)]

    monkeypatch.setattr(adjoint, "Grid", Noisy)
    prepared = PreparedGradient(chain(), ["std x"], ["one.drag"], frequencies=GRID)
    if settles:
        assert prepared.values() == pytest.approx(quiet, rel=noise)
    else:
        with pytest.raises(SimulationError, match="does not settle"):
            prepared.values()


def test_far_from_the_start_and_from_point_to_point():
    prepared = PreparedGradient(chain(), ["std pull", "mean first"], TUNED[:4], frequencies=GRID)
    for point in ([2.0, 20.0, 1.5, 0.8], [5.0, 8.0, 0.0, 0.3]):
        check(prepared, point=point)


def test_drag_in_a_flow():
    flowing = chain(flow=0.9, force=1.0)
    check(PreparedGradient(flowing, ["std x", "std pull", "mean x"], ["one.flow", "one.drag", "one.stiffness"],
                           frequencies=GRID))  # fmt: skip


def test_the_deviation_of_an_oscillator_in_white_noise_by_the_textbook():
    # variance pi S / (2 b k) for a one-sided S per rad/s, here of one mass; its slopes by b, k and S
    single = chain(drag=0.0, hardening=0.0, delay=0.0, damping=0.3, force=0.0)
    fine = np.unique(np.concatenate([np.geomspace(1e-3, 9.0, 4000), 0.2 + np.linspace(-0.15, 0.5, 6000)]))
    found = fw.gradient(single, "std first", ["one.damping", "one.stiffness", "one.level"], frequencies=fine)
    std = found.values[0]
    # in units of b and k a chain of equal parts scales as one oscillator does
    assert found["std first", "one.damping"] * 0.3 == pytest.approx(-std / 2, rel=2e-2)
    assert found["std first", "one.level"] * 2.0 == pytest.approx(std / 2, rel=1e-9)


class Pendulum(Component):
    """A mass on a rod, pushed aside by a constant force: tan(angle) = F / (m g), and it swings about there."""

    length: Scalar = param(default=1.5, unit="m", doc="of the rod")
    mass: Scalar = param(default=2.0, unit="kg", doc="of the bob")
    force: Scalar = param(default=9.0, unit="N", doc="sideways")
    damping: Scalar = param(default=0.0, unit="1/s", doc="of the rate")

    angle: Scalar = var(unit="rad", start=0.0, doc="from the vertical")
    rate: Scalar = var(unit="rad/s", start=0.0, doc="of the angle")

    def equations(self):
        push = self.force / self.mass * ca.cos(self.angle) - GRAVITY * ca.sin(self.angle)
        return [eq(der(self.angle), self.rate), eq(self.length * der(self.rate), push - self.damping * self.rate)]


def test_the_frequency_of_a_pendulum_about_its_inclined_mean_in_closed_form():
    swinging = model({"angle": fw.Output("one.angle", "deg")}, one=Pendulum())
    found = fw.gradient(swinging, ["mean angle", "frequency angle"], ["one.length", "one.mass", "one.force"])
    length, mass, force = 1.5, 2.0, 9.0
    pull = np.hypot(GRAVITY, force / mass)
    frequency = np.sqrt(pull / length) / (2 * np.pi)
    assert found.values == pytest.approx([np.degrees(np.arctan2(force, mass * GRAVITY)), frequency], rel=1e-10)
    by_pull = frequency / (2 * pull)
    assert found["frequency angle", "one.length"] == pytest.approx(-frequency / (2 * length), rel=1e-10)
    assert found["frequency angle", "one.force"] == pytest.approx(by_pull * force / mass**2 / pull, rel=1e-10)
    assert found["frequency angle", "one.mass"] == pytest.approx(-by_pull * force**2 / mass**3 / pull, rel=1e-10)
    of_force = np.degrees(mass * GRAVITY / (force**2 + (mass * GRAVITY) ** 2))
    assert found["mean angle", "one.force"] == pytest.approx(of_force, rel=1e-10)
    assert found.unit("mean angle", "one.force") == "deg/N"
    assert found.relative[1, 0] == pytest.approx(-0.5)


# --- tables, functions outside of the equations, numbers computed at the start --------------------------------------


def soft(y):
    return np.array([4 * y[0] + 0.3 * y[0] ** 3 * y[1]])


def slope_of_soft(y):
    return np.array([[4 + 0.9 * y[0] ** 2 * y[1], 0.3 * y[0] ** 3]])


class Spring(Component):
    """A mass on a spring whose law is a table or a function outside, and whose mass is computed when a run starts."""

    side: Scalar = param(default=0.7, unit="m", min=0, doc="of a cube of water, which is the mass")
    force: Scalar = param(default=9.0, unit="N", doc="constant")
    share: Scalar = param(default=1.2, doc="of the second part of the law")
    table: bool = param(default=True, doc="else a function outside")

    x: Scalar = var(unit="m", start=0.3, doc="stretch")
    v: Scalar = var(unit="m/s", start=0.0, doc="rate")

    def equations(self):
        mass = at_start("mass", 1, "kg", "of the cube", lambda part: 1000 * part.parameter_value("side") ** 3, of=self)
        if self.table:
            grid = np.linspace(-4, 4, 30)
            law = table1d(self.x, grid, 4 * grid + 0.3 * grid**3) * self.share
        else:
            outside = ExternalFunction("soft", {"y": 2}, {"law": 1}, python=soft, jacobian=slope_of_soft)
            law = outside(y=ca.vertcat(self.x, self.share))["law"]
        return [eq(der(self.x), self.v), eq(mass * der(self.v), self.force - law - 0.01 * self.v)]


@pytest.mark.parametrize("table", [True, False])
def test_through_tables_and_external_functions_and_numbers_of_the_start(table):
    prepared = PreparedGradient(model({"x": "one.x"}, one=Spring(table=table)), ["mean x", "frequency x", "damping x"],
                                ["one.side", "one.force", "one.share"])  # fmt: skip
    values, jacobian = check(prepared)
    assert jacobian[1, 0] == pytest.approx(-1.5 * values[1] / 0.7, rel=1e-9)  # as (side^3)^-1/2
    x, share = values[0], 1.2
    stiffness = (4 + 0.9 * x**2) * share if table else 4 + 0.9 * x**2 * share
    by_x = 1.8 * x * share
    assert jacobian[0, 1] == pytest.approx(1 / stiffness, rel=1e-8)
    assert jacobian[1, 1] == pytest.approx(values[1] / (2 * stiffness) * by_x / stiffness, rel=1e-7)


class Stepped(Component):
    """A mass on a spring; the mass counts the first size, and of the second what is beyond 2."""

    sizes: Vector = param(default=(1.5, 1.0, 4.0), doc="of which the third counts for nothing")

    x: Scalar = var(unit="m", start=0.0, doc="stretch")
    v: Scalar = var(unit="m/s", start=0.0, doc="rate")

    def equations(self):
        def counted(part):
            first, second, _ = part.parameter_value("sizes")
            return first + max(second - 2.0, 0.0) ** 2

        mass = at_start("mass", 1, "kg", "what counts of the sizes", counted, of=self)
        return [eq(der(self.x), self.v), eq(mass * der(self.v), 0.1 * self.sizes[1] - 4.0 * self.x - 0.01 * self.v)]


def test_sizes_that_did_not_matter_to_a_part_count_as_soon_as_they_do():
    made = lambda: PreparedGradient(model({"x": "one.x"}, one=Stepped()), ["frequency x"], ["one.sizes"])  # noqa: E731
    prepared = made()
    _, first = prepared.evaluate()
    assert first[0, 1:].tolist() == [0.0, 0.0]
    work = prepared.plant.functions.once("tuned runs", lambda: None)
    assert sorted(next(iter(work.apart.values()))) == ["one.sizes[1]", "one.sizes[2]"]
    values, again = prepared.evaluate([1.6, 1.2, 4.5])
    assert again[0] == pytest.approx([-values[0] / 3.2, 0.0, 0.0], rel=1e-7)
    values, later = prepared.evaluate([1.6, 3.0, 4.5])
    mass = 1.6 + 1.0
    assert later[0] == pytest.approx([-values[0] / (2 * mass), -values[0] / mass, 0.0], rel=1e-4)
    np.testing.assert_allclose(later, made().evaluate([1.6, 3.0, 4.5])[1], rtol=1e-12)


@pytest.mark.parametrize("level", [0.9, 2.0])
def test_two_runs_of_one_model_have_slopes_of_their_own(level):
    """What one has computed is used by the other where it holds for it, and is that of a model of its own."""
    results, by, other = ["std x", "std pull", "mean x"], [*TUNED, "one.flow"], {"one.level": level, "one.delay": 0.7}
    plant = fw.load(chain(flow=0.4)).compile()
    first, second = (PreparedGradient(plant, results, by, parameters=given, frequencies=grid)
                     for given, grid in (({}, GRID), (other, GRID[::2])))  # fmt: skip
    alone = PreparedGradient(chain(flow=0.4), results, by, parameters=other, frequencies=GRID[::2])
    kept = first.evaluate()
    for mine, own in zip(second.evaluate(), alone.evaluate(), strict=True):
        np.testing.assert_allclose(mine, own, rtol=1e-9, atol=1e-12)
    for one, again in zip(kept, first.evaluate(), strict=True):
        np.testing.assert_allclose(one, again, rtol=1e-9, atol=1e-12)


def test_values_to_a_tolerance_are_those_to_rounding():
    results = ["std x", "max pull", "mean x"]
    exact, rough = (PreparedGradient(chain(), results, ["one.drag"], frequencies=GRID, tolerance=tolerance)
                    for tolerance in (None, 1e-7))  # fmt: skip
    for drag in (1.0, 3.0):
        assert rough.values([drag]) == pytest.approx(exact.values([drag]), rel=1e-6)
    np.testing.assert_allclose(rough.evaluate([3.0])[1], exact.evaluate([3.0])[1], rtol=1e-9)


def cantilever():
    """A tube with a mass at its end."""
    root = fw.Assembly("a cantilever")
    root.world = World()
    root.ground = Fixed(r=(0, 0, 0))
    root.tube = TubeBeam(heights=(0, 15.0, 30.0), diameters=(2.0, 1.8, 1.5), wall_thicknesses=(0.02, 0.018, 0.016),
                         hinges=3, density=7850.0, young_modulus=2.1e11, shear_modulus=8e10)  # fmt: skip
    root.top = PointMass(mass=4000.0)
    root.connect(root.ground.frame, root.tube.frame_a)
    root.connect(root.tube.frame_b, root.top.frame_a)
    return fw.Model(root, outputs={"sway": "tube.deflection[0]"})


def test_the_frequency_of_a_cantilever_by_the_sizes_of_its_tube():
    by = ["tube.diameters", "tube.wall_thicknesses[0]", "tube.young_modulus", "tube.density", "top.mass"]
    prepared = PreparedGradient(cantilever(), [ModeFrequency(1.0, together=True)], by)
    assert prepared.parameters[:3] == ("tube.diameters[0]", "tube.diameters[1]", "tube.diameters[2]")
    values, jacobian = check(prepared)
    assert np.all(jacobian[0, [0, 1, 3, 4]] > 0)
    assert np.all(jacobian[0, [2, 5, 6]] < 0)  # near the tip it is mass more than stiffness
    # with gravity at rest the column is not only stiff, so that the frequency does not grow quite as sqrt(E)
    assert jacobian[0, 4] * 2.1e11 == pytest.approx(values[0] / 2, rel=2e-2)


@pytest.mark.parametrize("wrong", [9, 30.0, 0.01])
def test_a_mode_that_is_named_by_a_frequency_far_from_all_modes_is_refused(wrong):
    with pytest.raises(ModelError, match=f"frequency {wrong:g} Hz: no mode is near {wrong:g} Hz, the nearest has"):
        fw.gradient(model({"a": "one.angle"}, one=Pendulum()), ModeFrequency(wrong), ["one.length"])


# --- poles that are one ---------------------------------------------------------------------------------------------


def test_poles_that_are_one_are_refused_and_their_mean_has_a_derivative():
    both = model({"a": "one.angle", "b": "two.angle"}, one=Pendulum(), two=Pendulum())
    with pytest.raises(SimulationError, match=r"frequency a: 2 poles are one here, .*together=True"):
        fw.gradient(both, "frequency a", ["one.length"])
    prepared = PreparedGradient(both, [ModeFrequency("a", together=True)], ["one.length", "two.length", "one.force"])
    values, jacobian = prepared.evaluate()
    assert jacobian[0, :2] == pytest.approx(-values[0] / (4 * 1.5) * np.ones(2), rel=1e-9)
    apart = fw.gradient(both, [ModeFrequency("a")], ["one.length", "two.length"], parameters={"two.length": 1.6})
    assert apart["frequency a", "one.length"] == pytest.approx(-values[0] / (2 * 1.5), rel=1e-9)
    assert apart["frequency a", "two.length"] == pytest.approx(0.0, abs=1e-12)


def test_the_mean_of_a_defective_pair():
    A = np.array([[-1.0, 1.0, 0.2], [0.0, -1.0, 0.3], [0.0, 0.0, -4.0]])
    found = pole(A, -1.0, together=True)
    assert (found.value, found.count) == (pytest.approx(-1.0), 2)
    change = np.array([[0.3, 0.1, 0.0], [0.2, 0.5, 0.4], [0.1, -0.3, 0.2]])

    def mean(h):
        roots = np.linalg.eigvals(A + h * change)
        return np.array([np.sort(roots.real)[1:].mean()])

    assert np.sum(found.by_A.real * change) == pytest.approx(derivative(mean, 0.0, size=1e-2)[0], rel=1e-6)


# --- smaller things -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("covariance", [[[1.7]], [[2.0, 0.6], [0.6, 0.9]], np.diag([2.0, 2.0, 0.4]), 1.3 * np.eye(2)])
def test_slopes_of_the_gain_of_drag(covariance):
    covariance = np.array(covariance)
    n = len(covariance)
    change = np.random.default_rng(2).standard_normal((n, n))
    change = change + change.T
    wanted = derivative(lambda h: best_gain(covariance + h * change), 0.0, size=0.1)
    by_covariance, by_mean = gain_slopes(covariance)
    assert np.einsum("abcd,cd", by_covariance, change) == pytest.approx(wanted, rel=2e-7, abs=1e-7)
    assert by_mean == pytest.approx(np.zeros((n, n, n)), abs=1e-12)


def test_slopes_of_the_gain_of_drag_about_a_mean():
    covariance, mean = np.array([[2.0, 0.6], [0.6, 0.9]]), np.array([0.8, -1.1])
    by_covariance, by_mean = gain_slopes(covariance, mean)
    change, shift = np.array([[0.4, 0.3], [0.3, -0.2]]), np.array([0.5, 0.7])
    wanted = derivative(lambda h: best_gain(covariance + h * change, mean + h * shift), 0.0, size=0.1)
    assert np.einsum("abcd,cd", by_covariance, change) + by_mean @ shift == pytest.approx(wanted, rel=1e-6)


def test_slopes_of_the_gain_of_drag_in_a_strong_flow():
    mean = np.array([30.0, 40.0])  # where the law is that of its mean: |m| 1 + m m' / |m|
    at_mean, its_slopes = slope_at_mean(mean)
    assert at_mean == pytest.approx(np.array([[50 + 18, 24], [24, 50 + 32]]))
    assert gain_slopes(1e-4 * np.eye(2), mean)[1] == pytest.approx(its_slopes, abs=1e-5)
    for k in range(2):
        wanted = derivative(lambda h, k=k: slope_at_mean(mean + h * np.eye(2)[k])[0], 0.0, size=1.0)
        assert its_slopes[:, :, k] == pytest.approx(wanted, abs=1e-9)


def test_derivatives_of_functions_in_python():
    assert derivative(np.exp, 1.3) == pytest.approx(np.exp(1.3), rel=1e-11)
    assert derivative(np.sqrt, 0.0004, low=0.0004) == pytest.approx(25.0, rel=1e-7)
    assert derivative(np.exp, 1.3, high=1.3) == pytest.approx(np.exp(1.3), rel=1e-8)
    assert derivative(np.exp, 1.3, quick=True) == pytest.approx(np.exp(1.3), rel=1e-9)
    assert derivative(np.exp, 1.3, quick=True, low=1.3) == pytest.approx(np.exp(1.3), rel=1e-8)
    with pytest.raises(SimulationError, match="kink or a jump"):
        derivative(lambda x: np.array([max(x, 2.0)]), 2.0, quick=True)
    with pytest.raises(SimulationError, match=r"the wall has a kink or a jump at 2, and no derivative there"):
        derivative(lambda x: np.array([max(x, 2.0)]), 2.0, what="the wall")
    with pytest.raises(SimulationError, match="kink or a jump"):
        derivative(lambda x: np.floor([x]), 2.0)


@pytest.mark.parametrize("deviation", [0.0, 4e-16])
def test_a_result_that_is_at_rest_but_for_rounding_has_no_deviation_to_differentiate(deviation):
    """Sway of a spar in waves along x: 4e-16 m."""
    moments = deviation**2 * np.array([1.0, 0.1, 0.01, 1e-4])
    with pytest.raises(SimulationError, match="std sway: the result is at rest"):
        with_slopes(Std("sway"), moments, -1e-13, "m")


def test_what_has_no_derivative_says_why():
    plant = chain().compile()
    for by, told in [
        ("one.stifness", "there is no tunable parameter 'one.stifness'; did you mean 'one.stiffness'"),
        ("one.count", "one.count: it is structural, it counts parts or states"),
        ("one.kind", "one.kind: it is no number in this run that could"),
        ("one.mass[1]", r"one.mass has no element 'one.mass\[1\]'"),
    ]:
        with pytest.raises(ParameterError, match=told):
            fw.gradient(plant, "std x", [by])
    with pytest.raises(ParameterError, match="given twice"):
        fw.gradient(plant, "std x", ["one.mass", "one.mass"])
    with pytest.raises(ParameterError, match="given as a list"):
        fw.gradient(plant, "std x", "one.mass")
    for wanted, told in [
        ("std y", "the model has no result 'y'"),
        ("sdt x", "first word says what of a result is wanted; did you mean 'std'"),
        ("std", "of which result"),
        ("frequency pull", "'pull' is no state"),
        (Std("x", "sea"), "the response has no process 'sea'; there is 'one'"),
    ]:
        with pytest.raises(ModelError, match=told):
            fw.gradient(plant, wanted, ["one.mass"], frequencies=GRID)
    with pytest.raises(ModelError, match=r"at rest, and its deviation has no derivative"):
        fw.gradient(plant, "std first", ["one.mass"], parameters={"one.stiffness": 0.0, "one.hardening": 0.0,
                    "one.damping": 0.0, "one.force": 0.0}, frequencies=GRID)  # fmt: skip


class Sliding(Component):
    """A mass that nothing holds."""

    mass: Scalar = param(default=3.0, unit="kg", doc="mass")
    height: Scalar = param(default=1.0, unit="m", doc="of something beside it")
    x: Scalar = var(unit="m", start=0.2, doc="displacement")
    v: Scalar = var(unit="m/s", start=0.0, doc="velocity")
    y: Scalar = var(unit="m", start=0.0, doc="what follows it")

    def equations(self):
        return [eq(der(self.x), self.v), eq(self.mass * der(self.v), -self.v),
                eq(der(self.y), ca.sin(self.x) + self.height - self.y)]  # fmt: skip


def test_a_position_that_nothing_holds():
    sliding = model({"x": "one.x", "v": "one.v", "y": "one.y"}, one=Sliding())
    found = fw.gradient(sliding, ["mean v"], ["one.mass", "one.height"])
    assert found.jacobian == pytest.approx(np.zeros((1, 2)))
    with pytest.raises(SimulationError, match="depends on a position that nothing holds"):
        fw.gradient(sliding, "mean y", ["one.mass"])
    with pytest.raises(ModelError, match="no mode of the model oscillates"):
        fw.gradient(sliding, ModeDamping("x"), ["one.mass"])


# --- turbines and hulls ---------------------------------------------------------------------------------------------


def test_the_sizes_of_a_spar_whose_hull_is_computed_when_a_run_starts():
    prepared = PreparedGradient(fw.load("two_rotor_spar_design"), ["mean pitch", "frequency heave"],
                                ["diameter", "draft", "mooring.length"])  # fmt: skip
    check(prepared, step=3e-4)


def test_the_load_on_a_fixed_hull_by_its_sizes_and_by_the_direction_of_the_waves():
    """Its sizes move the strips, of which the waves have slopes; the direction moves the waves themselves."""
    root = fw.Assembly("hull")
    root.world, root.joint = World(water_depth=150.0), Fixed()
    root.sea = Sea(spectrum="jonswap", significant_wave_height=4.0, peak_period=10.0, heading=0.3)
    root.hull = SlenderHullLoads(heights=[-120.0, -12.0, -4.0, 10.0], diameters=[9.4, 9.4, 6.5, 6.5])
    root.connect(root.joint.frame, root.hull.frame)
    outputs = {"force": fw.Output("hull.force[0]", "kN"), "moment": fw.Output("hull.moment[0]", "kN*m")}
    prepared = PreparedGradient(fw.Model(root, outputs=outputs), ["std force", "std moment"],
                                ["hull.diameters", "hull.position[2]", "sea.heading"],
                                frequencies=np.linspace(0.02, 0.4, 60))  # fmt: skip
    values, jacobian = check(prepared)
    assert jacobian[0, -1] == pytest.approx(-values[0] * np.tan(0.3), rel=1e-6)  # the force goes by its cosine
    check(prepared, point=[9.0, 9.6, 6.8, 6.4, 1.0, -0.5])  # once it is known what matters to what


@pytest.fixture(scope="module")
def elastic_spar():
    """The spar for design in its rated wind, by the sizes of hull and tower, at two designs; its slopes at the second.

    There sizes that matter to different numbers move at once.
    """
    plant = fw.load("dtu10mw_spar_3_design").compile()
    by = ["hull_diameters", "hull_walls", "tower_diameters", "tower_walls", "rna.turbine.rotor.radius"]
    results = ["std pitch", "max upwind_tension", EquivalentLoad("tower_base_moment", 5.0)]
    prepared = PreparedGradient(plant, results, by, parameters={"wind.mean_speed": 11.0})
    prepared.evaluate()
    point = prepared.start * (1 + 1e-3 * np.random.default_rng(2).standard_normal(prepared.start.size))
    return prepared, point, *prepared.evaluate(point)


def test_the_sizes_of_an_elastic_spar(elastic_spar):
    """Along one direction in which all sizes change, against extrapolated differences of whole results."""
    prepared, point, values, jacobian = elastic_spar
    direction = point * np.random.default_rng(3).uniform(0.5, 1.0, point.size)

    def difference(step):
        above, below = (prepared.values(point + sign * step * direction) for sign in (1, -1))
        return (above - below) / (2 * step)

    a, b, c = (difference(step) for step in (2e-3, 1e-3, 5e-4))
    one, two = (4 * b - a) / 3, (4 * c - b) / 3
    # the gains of drag are known to 1e-9: 1e-6 of the last of these differences
    np.testing.assert_allclose(jacobian @ direction, (16 * two - one) / 15, rtol=3e-6)


def test_results_together_have_the_slopes_of_one_after_the_other(elastic_spar, monkeypatch):
    """Of all processes, and of one alone: by sums that all have in common, and each by itself."""
    spar, found = elastic_spar[0], []
    results = [Std("pitch", "sea"), "max upwind_tension", Std("tower_base_moment", "wind")]
    by = ["hull_diameters", "tower_walls", "rna.turbine.rotor.radius"]
    prepared = PreparedGradient(spar.plant, results, by, parameters=spar.given, frequencies=spar.frequencies)
    for many in (np.inf, 1):
        monkeypatch.setattr("fowtlib.frequency.adjoint.MANY", many)
        found.append(prepared.evaluate()[1] * prepared.start)
    alone, together = found
    assert np.abs((together - alone) / np.abs(alone).max(axis=1, keepdims=True)).max() < 1e-8  # see below


def test_sums_of_functions_times_products():
    """One function after the other, and from the products at each frequency, against the sums as they are written."""
    random = np.random.default_rng(4)
    values, rows, columns = (random.standard_normal(size) + 1j * random.standard_normal(size)
                             for size in ((3, 40), (4, 40, 2), (40, 2, 5)))  # fmt: skip
    wanted = np.einsum("fq,iqk,qkc->fic", values.conj(), rows, columns).real
    for sums in (_alone, _by_products):
        np.testing.assert_allclose(sums(values, rows, columns), wanted, rtol=1e-12, atol=1e-12)


def test_sizes_that_move_at_once_have_the_slopes_of_one_after_the_other(elastic_spar, monkeypatch):
    prepared, point, _, jacobian = elastic_spar
    found = []

    def counted(*arguments):
        found.append(slopes_together(*arguments))
        return found[-1]

    for module in ("fowtlib.solving.tuned", "fowtlib.frequency.signal_slopes"):
        monkeypatch.setattr(f"{module}.slopes_together", counted)
    prepared.evaluate(1.0001 * point)
    # the chain of the hull, from which signals follow; signals without closed forms; and other numbers of the parts
    assert [len(item) > 20 for item in found] == [True, True, True]
    for module in ("fowtlib.solving.tuned", "fowtlib.frequency.signal_slopes"):
        monkeypatch.setattr(f"{module}.slopes_together", lambda *arguments: None)
    closed = Tangents.__call__  # and no closed forms
    monkeypatch.setattr(Tangents, "__call__", lambda *arguments: np.full_like(closed(*arguments), np.nan))
    _, alone = prepared.evaluate(point)
    size = np.abs(alone * point).max(axis=1, keepdims=True)
    assert np.abs((jacobian - alone) * point / size).max() < 1e-8  # the gains of drag are known to 1e-9


def test_ballast_that_fills_until_the_draft_is_right():
    prepared = PreparedGradient(fw.load("two_rotor_spar_design"), ["mean pitch", "frequency heave", "mean heave"],
                                ["diameter", "draft"], free=["ballast"], targets={"heave": 0.0})  # fmt: skip
    values, jacobian = check(prepared, step=3e-4)
    assert values[2] == pytest.approx(0.0, abs=1e-9)
    assert jacobian[2] == pytest.approx([0.0, 0.0], abs=1e-9)
    floating = fw.gradient(fw.load("two_rotor_spar_design"), "mean pitch", ["diameter"])
    assert abs(jacobian[0, 0] / floating.jacobian[0, 0] - 1) > 0.1  # not what it is with the ballast as it was
    with pytest.raises(ModelError, match="ballast is free, and follows from the others"):
        fw.gradient(prepared.plant, "mean pitch", ["ballast"], free=["ballast"], targets={"heave": 0.0})


def test_a_floating_turbine_in_wind_and_waves():
    by = ["platform.mooring.length", "turbine.control.proportional_gain", "platform.drag.diameters[1]",
          "wind.mean_speed", "sea.peak_period", "world.water_density"]  # fmt: skip
    prepared = PreparedGradient(
        fw.load("oc3_spar_rigid"), ["std pitch", "max fairlead_tension_2", "range thrust", "frequency heave"], by,
        parameters={"wind.mean_speed": 18.0}, frequencies=np.geomspace(2e-3, 0.5, 120),
    )  # fmt: skip
    _, jacobian = check(prepared, relative=2e-6, step=1e-3)
    assert jacobian[3, by.index("sea.peak_period")] == 0
    assert prepared.units == ("deg", "kN", "kN", "Hz")


@pytest.mark.parametrize(
    ("weather", "by"),
    [
        ({"wind.kind": "turbulence", "wind.mean_speed": 18.003}, ["wind.mean_speed", "platform.mooring.length"]),
        ({"wind.kind": "turbulence", "wind.mean_speed": 15.5, "wind.turbulence_intensity": 0.12},
         ["wind.turbulence_intensity", "wind.mean_speed"]),
        ({"wind.kind": "ewm"}, ["wind.reference_speed"]),
    ],
)  # fmt: skip
def test_a_mean_speed_that_a_kind_of_wind_computes_is_not_rounded(weather, by):
    storm = {"wind.kind": "ewm", "wind.reference_speed": 17.7777}  # 10 minutes; 50 years
    model = fw.load("oc3_spar_rigid", set=storm if weather["wind.kind"] == "ewm" else {})
    prepared = PreparedGradient(model, ["std pitch", "mean pitch"], by,
                                parameters=weather, frequencies=np.geomspace(2e-3, 0.5, 40))  # fmt: skip
    check(prepared, relative=3e-6)


@pytest.mark.long
def test_two_rotors_in_a_field_whose_places_move_with_an_arm():
    weather = {"wind.kind": "turbulence", "wind.mean_speed": 18.0}
    prepared = PreparedGradient(fw.load("two_rotor_spar_rigid"), ["std yaw", "std roll"], ["arm_left.r[1]"],
                                parameters=weather, frequencies=np.geomspace(2e-3, 0.5, 60))  # fmt: skip
    check(prepared)
    with pytest.raises(ParameterError, match="by wind.direction, which turns a wind that is a field"):
        fw.gradient(prepared.plant, "std yaw", ["wind.direction"], parameters=weather)


def test_rotors_of_blade_elements_that_turn_are_refused_before_their_mean_is_sought():
    with pytest.raises(SimulationError, match="no gradients of the mean over a revolution"):
        fw.gradient(fw.load("oc3_spar_rigid_bem"), "mean pitch", ["platform.mooring.length"])


def test_shares_of_roots_as_sums_of_fewer_functions():
    omega = 2 * np.pi * np.linspace(0.003, 2.0, 300)
    slow = -0.05 * np.arange(1, 9) + 1j * np.arange(1, 9)
    roots = np.concatenate([slow, slow.conj(), -1.0 - 1j * np.geomspace(50, 5e4, 30)])
    shares = 1 / (1j * omega - roots[:, None])
    of, functions = _alike(shares)
    assert functions.shape[0] < 30
    assert np.abs(of @ functions / shares - 1).max() < 1e-12
