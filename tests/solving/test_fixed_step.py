"""The solver "fixed": order, damping, energy, samples, events, externals, failures, and agreement with IDAS.

The compiled engine is compared with its NumPy twin, which has exact Jacobians and CasADi's own externals.
"""

from __future__ import annotations

import re

import casadi as ca
import numpy as np
import pytest
import scipy

import fowtlib as fw
from fowtlib.cli import main
from fowtlib.language import (
    ExternalFunction,
    ModelError,
    RealInput,
    Scalar,
    assert_,
    assign,
    der,
    eq,
    param,
    port,
    reinit,
    sampled,
    table1d,
    table2d,
    time_series,
    var,
    when,
)
from fowtlib.language import math as m
from fowtlib.language.errors import SimulationError
from fowtlib.language.native import compiler
from fowtlib.solving.engines.fixed_step import FixedStep
from fowtlib.solving.engines.reduction import reduction
from fowtlib.solving.engines.twin import FixedStepTwin

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
RHO = 0.8


def plant_of(component, **parameters):
    return fw.load(component, **parameters).compile()


TIGHT = 1e-4  # the compiled iteration ends at 300 times its tolerance, the twin's at a hundredth


def engines(plant, step, tolerance=1e-8, rho_inf=RHO):
    """The compiled engine, its twin, and the point they start from: t, x, z, q."""
    state, at = plant.initial_state(), plant.at()
    both = [
        FixedStep(plant.fixed_step_code, at, step, TIGHT * tolerance, rho_inf),
        FixedStepTwin(at, step, tolerance, rho_inf),
    ]
    return *both, (state.x, state.z, np.concatenate([state.u, state.d]))


def compare_with_twin(plant, t_end, step, limit=1e-9, points=20):
    compiled, twin, start = engines(plant, step)
    x, z = compiled.advance(0.0, t_end, points, *start)
    x_twin, z_twin = twin.advance(0.0, t_end, points, *start)
    assert np.max(np.abs(x - x_twin) / (1 + np.abs(x_twin))) < limit
    assert np.max(np.abs(z - z_twin) / (1 + np.abs(z_twin)), initial=0.0) < 10 * limit
    return x, z


class Pendulum(fw.Component):
    """Length 1 m in a field of 1 m/s^2: phi'' = -sin(phi) - damping phi'."""

    damping: Scalar = param(default=0.0, unit="1/s", doc="damping")

    phi: Scalar = var(unit="rad", start=2.0, state="prefer", doc="angle")
    w: Scalar = var(unit="rad/s", state="prefer", doc="speed")

    def equations(self):
        return [eq(der(self.phi), self.w), eq(der(self.w), -m.sin(self.phi) * 1.0 - self.damping * self.w)]


class Mixed(fw.Component):
    """A pendulum whose tension is an algebraic unknown, with a filter and a load that follows a cubic equation."""

    gain: Scalar = param(default=0.3, doc="of the filter on the pendulum")

    phi: Scalar = var(start=1.0, state="prefer", doc="angle")
    w: Scalar = var(state="prefer", doc="speed")
    filtered: Scalar = var(start=0.2, state="prefer", doc="filtered speed")
    load: Scalar = var(doc="load + load^3 = w + sin(phi)")

    def equations(self):
        return [
            eq(der(self.phi), self.w),
            eq(der(self.w), -m.sin(self.phi) - self.gain * self.filtered - 0.1 * self.load),
            eq(der(self.filtered), 2.0 * (self.w - self.filtered) + 0.2 * m.cos(3 * self.time)),
            eq(self.load + self.load**3, self.w + m.sin(self.phi)),
        ]


# --- the scheme ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [Pendulum, Mixed])
def test_the_error_goes_with_the_square_of_the_step(model):
    """States and algebraic unknowns alike: half the step, a quarter of the error."""
    plant = plant_of(model())
    names = [q.path for q in (*plant.dae.states, *plant.dae.algebraics)]
    exact = plant.simulate(4.0, 0.2, tolerance=1e-11, outputs=names)
    errors = []
    for step in (0.02, 0.01, 0.005):
        run = plant.simulate(4.0, 0.2, solver="fixed", step=step, tolerance=1e-9, outputs=names)
        errors.append([np.max(np.abs(run.array(n) - exact.array(n))) for n in names])
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert np.all((ratios > 3.6) & (ratios < 4.4)), ratios
    assert np.max(errors[-1]) < 1e-4


def amplification(matrix, h, rho):
    """The scheme on x' = matrix x, one step of (x, rate), as Jansen et al. (2000), equations 12 to 16, write it."""
    n = len(matrix)
    am, af = 0.5 * (3 - rho) / (1 + rho), 1 / (1 + rho)
    gamma, one = 0.5 + am - af, np.eye(n)
    # unknowns x_new, rate_new: x_new - gamma h rate_new = x + (1 - gamma) h rate, and the balance between the two ends
    left = np.block([[one, -gamma * h * one], [-af * matrix, am * one]])
    right = np.block([[one, (1 - gamma) * h * one], [(1 - af) * matrix, -(1 - am) * one]])
    return np.linalg.solve(left, right)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 1.0])
def test_a_stiff_mode_is_damped_as_theory_says(rho):
    """A spring of 1e4 rad/s beside steps of 0.01 s follows the amplification matrix, whose radius is rho_inf."""

    class Spring(fw.Component):
        """q'' = -(1e4)^2 q."""

        q: Scalar = var(start=1e-3, state="prefer", doc="deflection")
        v: Scalar = var(state="prefer", doc="speed")

        def equations(self):
            return [eq(der(self.q), self.v), eq(der(self.v), -1e8 * self.q)]

    h, matrix = 0.01, np.array([[0.0, 1.0], [-1e8, 0.0]])
    step = amplification(matrix, h, rho)
    stiffer = amplification(1e6 * matrix, h, rho)
    assert np.max(np.abs(np.linalg.eigvals(stiffer))) == pytest.approx(rho, abs=2e-3)
    run = plant_of(Spring()).simulate(
        0.2, h, solver="fixed", step=h, rho_inf=rho, tolerance=1e-10, outputs=["q", "v"]
    )
    state = np.array([1e-3, 0.0, 0.0, -1e8 * 1e-3])
    for k in range(1, 21):
        state = step @ state
        size = max(abs(state[0]), 1e-3 * RHO**k if rho else 1e-3)
        assert run.array("q")[k] == pytest.approx(state[0], abs=1e-6 * size)
        assert run.array("v")[k] == pytest.approx(state[1], abs=1e-6 * max(abs(state[1]), 1e4 * size))


def test_a_pendulum_keeps_its_energy():
    """rho_inf = 1 is the trapezoidal rule: the energy swings with the square of the step and does not drift."""
    plant = plant_of(Pendulum())
    swings = []
    for step in (0.05, 0.025):
        run = plant.simulate(200.0, 0.05, solver="fixed", step=step, rho_inf=1.0, tolerance=1e-9, outputs=["phi", "w"])
        energy = run.array("w") ** 2 / 2 - np.cos(run.array("phi"))
        first, last = energy[:1000] - energy[0], energy[-1000:] - energy[0]
        assert np.max(np.abs(last)) < 1.05 * np.max(np.abs(first))
        swings.append(np.ptp(energy))
    assert swings[1] < 5e-4
    assert swings[0] / swings[1] == pytest.approx(4.0, rel=0.1)


def test_rates_that_are_states_or_unknowns_are_substituted():
    class Chain(fw.Component):
        """a' = b, b' = c, c' = f(a), and two states that are each other's rates."""

        a: Scalar = var(start=1.0, state="prefer", doc="state")
        b: Scalar = var(state="prefer", doc="state")
        c: Scalar = var(state="prefer", doc="state")
        left: Scalar = var(start=1.0, state="prefer", doc="cosh t")
        right: Scalar = var(state="prefer", doc="sinh t")

        def equations(self):
            return [
                eq(der(self.a), self.b), eq(der(self.b), self.c), eq(der(self.c), -self.a - self.b),
                eq(der(self.left), self.right), eq(der(self.right), self.left),
            ]  # fmt: skip

    plant = plant_of(Chain())
    reduced = reduction(plant.dae)
    free = sorted(plant.dae.states[i].path for i in reduced.free)
    assert free in (["c", "left"], ["c", "right"])
    assert sorted([*reduced.free, *reduced.order]) == list(range(5))
    run = plant.simulate(1.0, 0.1, solver="fixed", step=0.005, outputs=["left", "right"])
    assert run.array("left")[-1] == pytest.approx(np.cosh(1.0), abs=1e-4)
    assert run.array("right")[-1] == pytest.approx(np.sinh(1.0), abs=1e-4)
    compare_with_twin(plant, 2.0, 0.01)


# --- samples, events, resuming ------------------------------------------------------------------------------------


class Pushed(fw.Component):
    """A mass of 1 kg on a spring of 4 N/m with a damper of 0.2 N s/m."""

    force: RealInput = port(unit="N", default=0.0, doc="push")

    x: Scalar = var(unit="m", state="always", doc="place")
    v: Scalar = var(unit="m/s", state="always", doc="speed")

    def equations(self):
        return [eq(der(self.x), self.v), eq(der(self.v), self.force - 4 * self.x - 0.2 * self.v)]


class Loop(fw.Component):
    """x' = u - x under an integrator that samples; with a load that is an algebraic unknown."""

    period: float = param(default=0.05, unit="s", doc="sampling period")

    x: Scalar = var(start=1.0, state="prefer", doc="state")
    u: Scalar = var(discrete=True, doc="held command")
    load: Scalar = var(doc="load + load^3 = x + u")

    def equations(self):
        return [
            eq(der(self.x), self.u - self.x),
            eq(self.load + self.load**3, self.x + self.u),
            sampled(self.period, assign(self.u, self.u - 0.1 * self.x - 0.05 * self.load)),
        ]


def test_a_sampled_controller_acts_between_the_steps():
    """One step per sample, written out: where the command jumps, the rate of the scheme jumps as x' = u - x does."""
    options = {"step": 0.05, "tolerance": TIGHT * 1e-9, "outputs": ["x", "u", "load"]}
    run = plant_of(Loop()).simulate(2.0, 0.05, solver="fixed", **options)
    h, x, u, rate, rows = 0.05, 1.0, 0.0, None, []
    step = amplification(np.array([[-1.0]]), h, RHO)
    for _ in range(41):
        load = np.roots([1, 0, 1, -(x + u)])
        jump = -0.1 * x - 0.05 * load[np.abs(load.imag) < 1e-9].real[0]
        u += jump
        rows.append((x, u))
        rate = u - x if rate is None else rate + jump
        away, rate = step @ [x - u, rate]
        x = u + away
    assert np.max(np.abs(np.column_stack([run.array("x"), run.array("u")]) - rows)) < 1e-9
    assert run.array("load") + run.array("load") ** 3 == pytest.approx(run.array("x") + run.array("u"), abs=1e-8)


@pytest.mark.parametrize("engine", [0, 1])
def test_the_order_is_two_with_an_input_that_jumps_at_every_step(engine):
    """A swinging mass, pushed by a force that is held over each step: half the step leaves a quarter of the error.

    Against the exact motion under that force. With rho_inf = 0 the rate of the scheme differs most from the equations.
    """
    plant = plant_of(Pushed())
    errors = []
    for held in (0.02, 0.01, 0.005):
        exact = scipy.linalg.expm(held * np.array([[0, 1, 0], [-4, -0.2, 1], [0, 0, 0]]))
        *both, (x, z, q) = engines(plant, held, rho_inf=0.0)
        state, largest = x, 0.0
        for k in range(round(3.0 / held)):
            force = np.sin(3.0 * k * held)
            state = (exact @ [*state, force])[:2]
            rows, zs = both[engine].advance(k * held, held, 1, x, z, np.array([force]))
            x, z = rows[-1], zs[-1]
            largest = max(largest, np.abs(x - state).max())
        errors.append(largest)
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2.0, abs=0.1)


def test_samples_that_are_no_multiple_of_the_step_come_on_time():
    plant = plant_of(Loop(period=0.031))
    names = ["x", "u", "load"]
    exact = plant.simulate(1.0, 0.1, tolerance=1e-10, outputs=names)
    run = plant.simulate(1.0, 0.1, solver="fixed", step=0.0125, outputs=names)
    for name in names:
        assert np.max(np.abs(run.array(name) - exact.array(name))) < 2e-5


def test_an_event_is_found_and_the_run_goes_on_behind_it():
    class Ball(fw.Component):
        """It falls from 2 m and bounces with 0.8 of its speed."""

        height: Scalar = var(start=2.0, state="always", doc="height")
        v: Scalar = var(state="always", doc="upward velocity")
        last: Scalar = var(discrete=True, doc="time of the last impact")

        def equations(self):
            hit = when(self.height < 0, reinit(self.v, -0.8 * self.v), assign(self.last, self.time))
            return [eq(der(self.height), self.v), eq(der(self.v), -9.81), hit]

    run = plant_of(Ball()).simulate(3.0, 0.01, solver="fixed", step=0.0005, outputs=["last"])
    fall = np.sqrt(4 / 9.81)
    impacts = fall + np.concatenate([[0.0], np.cumsum(2 * fall * 0.8 ** np.arange(1, 4))])
    found = np.unique(run.array("last"))[1:]
    assert found == pytest.approx(impacts[: len(found)], abs=1e-5) and len(found) == 3


def test_a_resumed_run_is_the_whole_run(tmp_path):
    """Up to the rates that the scheme carries along, which start anew: an error of the order of the step's."""
    plant, options = plant_of(Mixed()), {"output_step": 0.05, "solver": "fixed", "step": 0.01}
    whole = plant.simulate(4.0, **options)
    first = plant.simulate(2.0, **options)
    first.save(tmp_path / "first.nc")
    second = plant.simulate(4.0, start=fw.Result.open(tmp_path / "first.nc"), **options)
    joined = first.followed_by(second)
    assert np.array_equal(joined.time, whole.time)
    for name in ("phi", "w", "filtered"):
        assert np.max(np.abs(joined.array(name) - whole.array(name))) < 5e-5


# --- externals ----------------------------------------------------------------------------------------------------


class Tables(fw.Component):
    """States driven by time series, one of them periodic, and tables of one and two arguments, also at their edges."""

    x: Scalar = var(start=0.3, state="prefer", doc="state")
    y: Scalar = var(start=0.1, state="prefer", doc="state")
    s: Scalar = var(state="prefer", doc="state")

    def equations(self):
        t = np.arange(0, 5.0, 0.1)
        gusts = time_series(self.time, 0.0, 0.1, np.column_stack([np.sin(t), np.cos(3 * t)]), name="gusts")
        waves = time_series(self.time, 0.0, 0.25, np.sin(2 * np.pi * np.arange(8) / 8), periodic=True, name="waves")
        grid = np.linspace(-1.0, 1.0, 9) ** 3 + np.linspace(-1, 1, 9)
        spring = table1d(self.x, grid, grid**3 + grid, name="spring")
        sharp = table1d(self.y, grid, np.abs(grid), smoothness="c1", name="sharp")
        surface = np.stack([np.outer(np.cos(grid), grid**2), np.outer(grid, np.sin(grid))], axis=-1)
        flat = table2d(self.x, self.y, grid, grid, surface, name="flat")
        return [
            eq(der(self.x), gusts[0] - spring + 0.3 * flat[0]),
            eq(der(self.y), gusts[1] - 3 * self.y - sharp + flat[1]),
            eq(der(self.s), waves - self.s),
        ]


def test_tables_and_time_series_are_evaluated_as_casadi_does():
    plant = plant_of(Tables())
    x, _ = compare_with_twin(plant, 4.0, 0.02)
    assert np.ptp(x, axis=0).min() > 0.2
    exact = plant.simulate(4.0, 0.2, tolerance=1e-9, outputs=["x", "y", "s"])
    run = plant.simulate(4.0, 0.2, solver="fixed", step=0.01, outputs=["x", "y", "s"])
    for name in ("x", "y", "s"):
        assert np.max(np.abs(run.array(name) - exact.array(name))) < 2e-4


DRAG_C = """
typedef long long casadi_int;
EXPORT int drag(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
  double v = arg[0][0], e = arg[0][1];
  w[2] = (v < 0 ? -v : v) * v; /* the last of the work that drag_work asks for */
  res[0][0] = -0.7 * w[2] + e;
  res[0][1] = v * e;
  return 0;
}
EXPORT casadi_int drag_n_in(void) { return 1; }
EXPORT casadi_int drag_n_out(void) { return 1; }
static const casadi_int two[] = {2, 1, 0, 2, 0, 1}, full[] = {2, 2, 0, 2, 4, 0, 1, 0, 1};
EXPORT const casadi_int *drag_sparsity_in(casadi_int i) { return two; }
EXPORT const casadi_int *drag_sparsity_out(casadi_int i) { return two; }
EXPORT int drag_work(casadi_int *arg, casadi_int *res, casadi_int *iw, casadi_int *w) {
  *arg = 1; *res = 1; *iw = 0; *w = 3;
  return 0;
}
"""
SLOPE_C = """
EXPORT int jac_drag(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
  double v = arg[0][0], e = arg[0][1];
  res[0][0] = -1.4 * (v < 0 ? -v : v);
  res[0][1] = e;
  res[0][2] = 1.0;
  res[0][3] = v;
  return 0;
}
EXPORT casadi_int jac_drag_n_in(void) { return 2; }
EXPORT casadi_int jac_drag_n_out(void) { return 1; }
EXPORT const casadi_int *jac_drag_sparsity_in(casadi_int i) { return two; }
EXPORT const casadi_int *jac_drag_sparsity_out(casadi_int i) { return full; }
"""
PYTHON = {
    "python": lambda a: [-0.7 * abs(a[0]) * a[0] + a[1], a[0] * a[1]],
    "jacobian": lambda a: [[-1.4 * abs(a[0]), 1.0], [a[1], a[0]]],
}


class Dragged(fw.Component):
    """A mass on a cubic spring with drag from an external, and a second call behind the first one."""

    drag: object = param(doc="external function")

    x: Scalar = var(start=1.0, state="prefer", doc="position")
    v: Scalar = var(state="prefer", doc="velocity")
    e: Scalar = var(doc="e^3 + e = the second output")

    def equations(self):
        first = self.drag(velocity=self.v, extra=self.e)["force"]
        second = self.drag(velocity=0.1 * first[0], extra=self.x)["force"]
        return [
            eq(der(self.x), self.v),
            eq(der(self.v), -self.x - self.x**3 + first[0] + second[0]),
            eq(self.e**3 + self.e, first[1] * 0.1 + m.sin(self.time)),
        ]


def drag(**given):
    return ExternalFunction("drag", {"velocity": 1, "extra": 1}, {"force": 2}, **given)


@pytest.fixture(scope="module")
def dragged():
    """The run with the Python function and its Jacobian, in the twin."""
    _, twin, start = engines(plant_of(Dragged(drag=drag(**PYTHON))), 0.01)
    return twin.advance(0.0, 3.0, 20, *start)[0]


@pytest.mark.parametrize("kind", ["source", "source without a Jacobian", "python", "python by differences"])
def test_externals_of_all_kinds_give_the_same(kind, dragged):
    given = {
        "source": {"source": DRAG_C + SLOPE_C, **PYTHON},
        "source without a Jacobian": {"source": DRAG_C, **PYTHON},
        "python": PYTHON,
        "python by differences": {"python": PYTHON["python"]},
    }[kind]
    plant = plant_of(Dragged(drag=drag(**given)))
    assert [len(level) for level in plant.dae.levels] == [1, 1]
    compiled = FixedStep(plant.fixed_step_code, plant.at(), 0.01, TIGHT * 1e-8, RHO)
    x, z = np.array([1.0, 0.0]), np.zeros(1)
    assert [q.path for q in plant.dae.states] == ["x", "v"]
    found, _ = compiled.advance(0.0, 3.0, 20, x, z, np.zeros(0))
    assert np.max(np.abs(found - dragged)) < 1e-8
    assert compiled.counts()["evaluations"] < 4 * compiled.counts()["steps"]


def test_an_error_in_python_code_comes_through():
    def broken(values):
        if values[0] < -0.2:
            raise ZeroDivisionError("no such speed")
        return PYTHON["python"](values)

    plant = plant_of(Dragged(drag=drag(python=broken, jacobian=PYTHON["jacobian"])))
    with pytest.raises(RuntimeError, match="no such speed"):
        plant.simulate(3.0, solver="fixed")


# --- parameters, failures, settings -------------------------------------------------------------------------------


def test_other_parameters_find_the_compiled_model_again():
    one, other = plant_of(Mixed()), plant_of(Mixed(gain=0.9))
    assert one.fixed_step_code.path == other.fixed_step_code.path
    assert one.fixed_step_code.path.stat().st_mtime == other.fixed_step_code.path.stat().st_mtime
    runs = [
        plant.simulate(2.0, solver="fixed", outputs=["w"], parameters=given).array("w")
        for plant, given in ((one, {"gain": 0.9}), (other, None), (one, None))
    ]
    assert np.array_equal(runs[0], runs[1])
    assert np.max(np.abs(runs[0] - runs[2])) > 0.01


def test_a_long_time_series_does_not_make_the_code_longer():
    class Long(fw.Component):
        """x' = series - x."""

        values: object = param(doc="samples")
        x: Scalar = var(state="prefer", doc="state")

        def equations(self):
            return [eq(der(self.x), ca.sum1(time_series(self.time, 0.0, 0.1, self.values)) - self.x)]

    rng = np.random.default_rng(1)
    short, long = (plant_of(Long(values=rng.normal(size=(n, 3)))) for n in (60, 20_000))
    assert short.fixed_step_code.path == long.fixed_step_code.path
    compare_with_twin(long, 1.0, 0.01)
    compare_with_twin(short, 1.0, 0.01)


class Ending(fw.Component):
    """y^2 = 1 - x has no solution once x has grown to one."""

    x: Scalar = var(state="prefer", doc="state")
    y: Scalar = var(start=1.0, doc="algebraic unknown")

    def equations(self):
        return [eq(der(self.x), 1.0 + 0 * self.y), eq(self.y**2, 1 - self.x)]


def test_a_step_that_is_not_solved_says_where():
    model = fw.Assembly("ending")
    model.load = Ending()
    with pytest.raises(ModelError) as failed:
        plant_of(model).simulate(2.0, 0.1, solver="fixed", step=0.05, tolerance=TIGHT * 1e-6, outputs=["load.x"])
    assert re.sub(r" \([a-z_/]*\.py:\d+\)", " (FILE)", str(failed.value)) == (
        "the integration fails after t = 0.9 s, because the equations of the step at t = 1 s are not solved, furthest "
        "of all that of load (FILE); the fastest change is der(load.x). Look there for a jump, a missing damping or a "
        "quantity that grows without bound, or take a shorter step (--step 25ms)."
    )
    result = failed.value.result
    assert 0.85 < result.time[-1] <= 1.0
    assert result.array("load.x") == pytest.approx(result.time, abs=1e-9)


class Logarithm(fw.Component):
    """x' = log(x) - 3 leaves the domain of the logarithm."""

    x: Scalar = var(start=1.0, state="prefer", doc="state")

    def equations(self):
        return [eq(der(self.x), m.log(self.x) - 3)]


def test_an_equation_that_is_not_finite_is_named():
    with pytest.raises(ModelError) as failed:
        plant_of(Logarithm()).simulate(2.0, 0.1, solver="fixed", step=0.05)
    assert str(failed.value) == (
        "the integration fails after t = 0.2 s: der(x) is not a finite number. "
        "Check the parameters, start values and limits there."
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": 0.0}, "the step of the solver 'fixed' is 0 s; it must be above zero, usually 0.01 s."),
        ({"step": float("nan")}, "the step of the solver 'fixed' is nan s; it must be above zero, usually 0.01 s."),
        (
            {"step": "0.2 s"},
            "the step of the solver 'fixed', 0.2 s, is longer than the output step, 0.1 s. "
            "Give a shorter step (--step) or a longer output step (--output-step).",
        ),
        ({"step": "2 m"}, "step: got '2 m', which is a length; a time in s is expected, e.g. '12.5 s'."),
        ({"rho_inf": 1.2}, "rho_inf is 1.2; it must lie between 0 and 1, usually 0.7 to 0.9."),
        (
            {"solver": "idas", "step": 0.01},
            "step is an option of the solver 'fixed'; the solver 'idas' has none like it.",
        ),
        ({"solver": "fxed"}, "there is no solver 'fxed'; did you mean 'fixed'?"),
    ],
)
def test_senseless_settings(options, message):
    with pytest.raises(ModelError) as error:
        plant_of(Pendulum()).simulate(1.0, 0.1, **{"solver": "fixed", **options})
    assert str(error.value) == message


def test_settings_travel_from_the_file_and_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    simulation = "{solver: fixed, step: 20 ms, rho_inf: 0.9, duration: 1 s, output_step: 0.1 s}"
    (tmp_path / "mass.yaml").write_text(
        "fowtlib: 1\nworld: {class: World, gravity: 9.81}\nparts:\n  slide: {class: Prismatic, n: [0, 0, 1]}\n"
        "  bob: {class: RigidBody, mass: 2 kg, inertia: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
        "connect:\n  - [world.frame, slide.frame_a]\n  - [slide.frame_b, bob.frame_a]\n"
        f"outputs: {{s: slide.s}}\nsimulation: {simulation}\n"
    )
    said = fw.load("mass.yaml").compile().simulate().attributes
    assert [said[key] for key in ("solver", "step", "rho_inf")] == ["fixed", 0.02, 0.9]
    assert main(["run", "mass.yaml", "--solver", "fixed", "--step", "12.5ms", "--output", "r.nc"]) == 0
    saved = fw.Result.open("r.nc").attributes
    assert (saved["solver"], saved["step"]) == ("fixed", 0.0125)
    assert main(["run", "mass.yaml", "--solver", "idas", "--output", "s.nc"]) == 0
    assert "step" not in fw.Result.open("s.nc").attributes
    capsys.readouterr()
    assert main(["run", "mass.yaml", "--step", "long"]) == 2
    assert capsys.readouterr().err.startswith("fowt run: step: ")


def test_without_a_compiler_the_twin_runs(monkeypatch):
    plant = plant_of(Mixed())
    compiled = plant.simulate(1.0, solver="fixed", tolerance=TIGHT * 1e-8, outputs=["w"])
    monkeypatch.setenv("FOWTLIB_CC", "no-such-compiler")
    run = plant.simulate(1.0, solver="fixed", tolerance=1e-8, outputs=["w"])
    assert run.attributes["solver"] == "fixed" and run.attributes["step"] == 0.0125
    assert np.max(np.abs(run.array("w") - compiled.array("w"))) < 1e-9


# --- a floating turbine -------------------------------------------------------------------------------------------


def test_the_twin_agrees_on_a_floating_turbine():
    plant = fw.load("oc3_spar_rigid").compile()
    compare_with_twin(plant, 2.0, 0.0125)
    options = {"t_end": 120.0, "output_step": 0.1, "outputs": ["surge", "pitch", "rotor_speed", "fairlead_tension_2"]}
    idas = plant.simulate(solver="idas", **options).statistics()
    for name, found in plant.simulate(solver="fixed", **options).statistics().items():
        for what in ("mean", "std", "min", "max"):
            assert getattr(found, what) == pytest.approx(getattr(idas[name], what), rel=0.01), (name, what)


def test_response_to_regular_waves():
    """Amplitudes at the frequency of the waves over the last 100 s, within 0.5 % of IDAS."""
    conditions = {"wind.kind": "none", "sea.spectrum": "regular", "sea.wave_height": 6.0, "sea.wave_period": 10.0}
    plant = fw.load("oc3_spar_rigid").with_parameters(conditions).compile()
    options = {"t_end": 200.0, "output_step": 0.1, "outputs": ["surge", "heave", "pitch"]}
    runs = [plant.simulate(solver=solver, **options) for solver in ("fixed", "idas")]
    wave = np.exp(-2j * np.pi * runs[0].time[-1000:] / 10.0)
    for name in options["outputs"]:
        one, other = (abs(np.mean(wave * run.array(name)[-1000:])) for run in runs)
        assert one == pytest.approx(other, rel=0.005)


class Watched(Mixed):
    """Mixed, whose filtered speed may not fall below -0.1."""

    def equations(self):
        return [*super().equations(), assert_(self.filtered > -0.1, "the filtered speed is below -0.1")]


def test_results_at_output_points_are_those_of_the_states_there():
    """What the engine hands over with a point is what states and algebraic unknowns give anew, to the last digit."""
    plant = plant_of(Mixed())
    result = plant.simulate(3.0, 0.1, solver="fixed", step=0.02)
    again = plant.observer(result.raw).values(["phi", "load"])
    assert np.array_equal(np.column_stack([result.array(name) for name in ("phi", "load")]), again)
    load, speed, angle = (result.array(name) for name in ("load", "w", "phi"))
    slope = 1 + 3 * np.max(load**2)  # of the equation; the unknown is solved to the tolerance, 1e-6
    assert np.max(np.abs(load + load**3 - speed - np.sin(angle))) < 1e-6 * slope


def test_a_broken_assertion_stops_at_the_same_point_as_with_idas():
    stops = []
    for solver in ("fixed", "idas"):
        with pytest.raises(SimulationError, match="the filtered speed is below") as caught:
            plant_of(Watched()).simulate(3.0, 0.1, solver=solver)
        stops.append(caught.value.result.time[-1])
    assert stops[0] == stops[1] > 0
