"""Sensitivities of runs in time: closed forms, differences of runs, samples, events, starts, and what is refused."""

import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis import damage_equivalent_load
from fowtlib.language import (
    Component,
    ModelError,
    OfferedEvent,
    RealInput,
    Scalar,
    assign,
    der,
    eq,
    event,
    initial,
    on,
    param,
    port,
    reinit,
    sampled,
    table1d,
    var,
    when,
)
from fowtlib.language import math as m
from fowtlib.language.errors import ParameterError, SimulationError
from fowtlib.solving.engines import choice
from fowtlib.solving.tangents import columns, propagation, sensitivities

TIGHT = 1e-13


def plant_of(component, **parameters):
    return fw.load(component, **parameters).compile()


def difference(plant, by, at, size, results, parameters=None, **run):
    """Richardson differences of runs by one scalar parameter (n, k)."""

    def values(value):
        found = plant.simulate(parameters={**(parameters or {}), by: value}, solver="fixed", **run)
        return np.column_stack([found.array(name) for name in results])

    coarse, fine = ((values(at + h) - values(at - h)) / (2 * h) for h in (size, size / 2))
    return (4 * fine - coarse) / 3


def worst(found, by, wanted):
    """Largest difference of each result over its largest value."""
    mine = found.derivatives[:, :, found.parameters.index(by)]
    scale = np.abs(wanted).max(axis=0)
    return np.abs(mine - wanted).max(axis=0) / np.where(scale > 0, scale, 1.0)


# --- closed forms -------------------------------------------------------------------------------------------------


class Oscillator(Component):
    """mass x'' + damping x' + stiffness x = 0, from rest at x = place."""

    mass: Scalar = param(default=2.0, unit="kg", doc="mass")
    damping: Scalar = param(default=0.4, unit="N s/m", doc="damping")
    stiffness: Scalar = param(default=5.0, unit="N/m", doc="stiffness")
    place: Scalar = param(default=1.5, unit="m", doc="where it starts")

    x: Scalar = var(unit="m", start=place, state="prefer", doc="place")
    v: Scalar = var(unit="m/s", state="prefer", doc="speed")

    def equations(self):
        return [eq(der(self.x), self.v), eq(self.mass * der(self.v), -self.damping * self.v - self.stiffness * self.x)]


def oscillation(t, mass, damping, stiffness, place):
    decay = damping / (2 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    return place * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))


def test_an_oscillator_is_its_closed_form_to_second_order_and_beyond_by_extrapolation():
    plant, values = plant_of(Oscillator()), {"mass": 2.0, "damping": 0.4, "stiffness": 5.0, "place": 1.5}
    runs = [sensitivities(plant, list(values), ["x"], t_end=10.0, output_step=0.1, step=step, rho_inf=1.0,
                          tolerance=TIGHT) for step in (0.005, 0.0025)]  # fmt: skip
    for name in values:
        by_complex_step = oscillation(runs[0].time, **{**values, name: values[name] + 1e-30j}).imag / 1e-30
        coarse, fine = (run.array("x", name) - by_complex_step for run in runs)
        size = np.abs(by_complex_step).max()
        if name != "place":
            assert np.abs(coarse).max() / np.abs(fine).max() == pytest.approx(4.0, rel=0.01)
        assert np.abs(coarse).max() < 1e-3 * size
        assert np.abs((4 * fine - coarse) / 3).max() < 1e-8 * size
    assert runs[0].growth == pytest.approx(-0.1, abs=0.02)  # half of damping / mass
    assert runs[0].unit("x", "stiffness") == "m/(N/m)"


class Pendulum(Component):
    """length phi'' = -gravity sin(phi), from 2 rad at rest: its motion is a function of sqrt(gravity / length) t."""

    gravity: Scalar = param(default=9.0, unit="m/s^2", doc="gravity")
    length: Scalar = param(default=2.0, unit="m", doc="length")

    phi: Scalar = var(unit="rad", start=2.0, state="prefer", doc="angle")
    w: Scalar = var(unit="rad/s", state="prefer", doc="speed")
    energy: Scalar = var(unit="m^2/s^2", doc="of the unit of mass")

    def equations(self):
        return [
            eq(der(self.phi), self.w), eq(self.length * der(self.w), -self.gravity * m.sin(self.phi)),
            eq(self.energy, 0.5 * self.length**2 * self.w**2 - self.gravity * self.length * m.cos(self.phi)),
        ]  # fmt: skip


def test_a_pendulum_is_a_function_of_scaled_time_and_keeps_its_energy():
    plant = plant_of(Pendulum())
    run = {"t_end": 8.0, "output_step": 0.1, "rho_inf": 1.0, "tolerance": TIGHT}
    found = [sensitivities(plant, ["gravity", "length"], ["phi", "w", "energy"], step=step, **run)
             for step in (0.005, 0.0025)]  # fmt: skip
    t = found[0].time

    def errors(one):
        phi, w = (one.run.array(name) for name in ("phi", "w"))
        scaled = {"gravity": t / 18.0, "length": -t / 4.0}  # d (sqrt(g / l) t) / sqrt(g / l)
        yield from (one.array("phi", name) - factor * w for name, factor in scaled.items())
        turning = -9.0 / 2.0 * np.sin(phi)
        yield one.array("w", "gravity") - w / 18.0 - t / 18.0 * turning
        yield one.array("energy", "gravity") + 2.0 * np.cos(2.0)  # that of the start

    for coarse, fine in zip(*(list(errors(one)) for one in found), strict=True):
        assert np.abs((4 * fine - coarse) / 3).max() < 1e-6
    assert -0.05 < found[0].growth < 0.3  # two of them part in proportion to time, not exponentially


# --- differences --------------------------------------------------------------------------------------------------


class Servo(Component):
    """All kinds of equations: an algebraic unknown, a table, a sampled controller, an initial equation, an event."""

    gain: Scalar = param(default=0.7, doc="of the controller")
    offset: Scalar = param(default=0.0, doc="zero, and not to be left out for that")
    heavy: Scalar = param(default=1.3, doc="inertia")
    kick: Scalar = param(default=0.5, doc="what a hit adds")
    period: Scalar = param(default=0.05, unit="s", doc="of the controller")

    hit: OfferedEvent = event(doc="the speed jumps", size=param(default=kick, doc="by so much"))

    x: Scalar = var(start=0.4, fixed=True, state="prefer", doc="place")
    v: Scalar = var(unit="1/s", start=0.1, fixed=True, state="prefer", doc="speed")
    f: Scalar = var(state="prefer", doc="filtered")
    root: Scalar = var(start=0.5, doc="algebraic")
    held: Scalar = var(discrete=True, start=gain, doc="of the controller")
    before: Scalar = var(discrete=True, start=0.0, doc="what it saw last")

    def equations(self):
        table = table1d(self.x, [-4.0, -1.0, 0.0, 1.5, 4.0], [1.0, 0.4, 0.0, 0.9, 2.0])
        return [
            eq(der(self.x), self.v),
            eq(self.heavy * der(self.v), -2.0 * table - 0.1 * self.v - self.held + self.root),
            eq(2.0 * der(self.f), self.root - self.f),
            eq(self.root**3 + self.heavy * self.root, m.cos(self.x) + self.offset * self.x + 0.1 * self.held),
            initial(self.f, 0.5 * self.root + self.gain),
            sampled(self.period, assign(self.held, self.gain * self.x + 0.3 * self.before * self.root),
                    assign(self.before, self.x)),
            on(self.hit, reinit(self.v, self.v + self.hit.size * self.root)),
        ]  # fmt: skip


SERVO = ["x", "v", "f", "root", "held"]


@pytest.mark.parametrize("events", [[], ["hit at 0.71 s", "hit at 1 s, size=0.2"]])
def test_samples_events_tables_and_initial_equations_are_the_differences_of_runs(events):
    plant = plant_of(Servo())
    run = {"t_end": 2.0, "output_step": 0.1, "step": 0.02, "tolerance": TIGHT, "events": events}
    by = {"gain": 0.7, "offset": 0.0, "heavy": 1.3, "kick": 0.5}
    found = sensitivities(plant, list(by), SERVO, **run)
    for name, value in by.items():
        wanted = difference(plant, name, value, 1e-3, SERVO, **run)
        assert np.all(worst(found, name, wanted) < 1e-8), name
    assert np.any(found.array("x", "offset") != 0) and np.any(found.array("x", "kick") != 0) == bool(events)


def test_without_a_compiler_it_is_the_same(monkeypatch):
    plant = plant_of(Servo())
    run = {"t_end": 1.0, "output_step": 0.1, "step": 0.02, "tolerance": TIGHT}
    compiled = sensitivities(plant, ["gain", "heavy"], SERVO, **run)
    for module in (choice, propagation, columns):
        monkeypatch.setattr(module, "compiler", lambda: None)
    twin = sensitivities(plant, ["gain", "heavy"], SERVO, **run)
    np.testing.assert_allclose(twin.derivatives, compiled.derivatives, rtol=1e-9, atol=1e-10)


def test_a_sampled_part_whose_period_is_the_parameter_is_refused():
    with pytest.raises(ParameterError, match="no sensitivity to period: it decides at which instants"):
        sensitivities(plant_of(Servo()), ["period"], SERVO, t_end=0.2, output_step=0.1)


# --- the spar -----------------------------------------------------------------------------------------------------

SPAR = {
    "platform.hull.mass": 3e-6, "platform.mooring.length": 3e-6, "platform.mooring.mass_per_length": 1e-4,
    "platform.mooring.fairlead_depth": 1e-3, "platform.drag.drag_coefficient": 1e-2, "world.air_density": 1e-3,
    "tower.mass": 1e-2, "turbine.rotor.inertia": 1e-2, "turbine.control.proportional_gain": 1e-2,
    "turbine.control.integral_gain": 1e-2, "platform.mooring.yaw_stiffness": 1e-2, "turbine.rotor.radius": 1e-3,
}  # fmt: skip
"""With the steps of the differences, relative: between the rounding of the mean and the curvature of the lines."""
SHOWN = ["surge", "heave", "pitch", "yaw", "rotor_speed", "blade_pitch", "thrust", "fairlead_tension_2"]


@pytest.fixture(scope="module")
def spar():
    return fw.load("oc3_spar_rigid").compile()


def compared(plant, by, conditions, limit, **run):
    found = sensitivities(plant, list(by), SHOWN, parameters=conditions, **run)
    for name, relative in by.items():
        value = float(found.at[found.parameters.index(name)])
        wanted = difference(plant, name, value, relative * value, SHOWN, conditions, **run)
        assert np.all(worst(found, name, wanted) < limit), (name, worst(found, name, wanted))
    return found


def test_the_decay_of_a_spar(spar):
    start = {"platform.motion.surge": 8.0, "platform.motion.pitch": 0.05, "platform.motion.heave": 1.0}
    still = {"wind.kind": "none", "sea.spectrum": "still"}
    by = {name: step for name, step in SPAR.items() if name.startswith(("platform", "tower"))}
    found = sensitivities(spar, list(by), ["surge", "heave", "pitch"], start=start, parameters=still, t_end=60.0,
                          output_step=0.5, tolerance=1e-12)  # fmt: skip
    for name, relative in by.items():
        value = float(found.at[found.parameters.index(name)])
        wanted = difference(spar, name, value, relative * value, found.results, still, start=start, t_end=60.0,
                            output_step=0.5, tolerance=1e-12)  # fmt: skip
        assert np.all(worst(found, name, wanted) < 1e-6), (name, worst(found, name, wanted))
    assert np.all(found.derivatives[0, 0] == 0)  # held


def test_a_spar_in_wind_and_regular_waves_from_a_mean_that_moves(spar):
    conditions = {"wind.kind": "steady", "wind.mean_speed": 14.0, "sea.spectrum": "regular", "sea.wave_height": 2.0,
                  "sea.wave_period": 10.0}  # fmt: skip
    found = compared(spar, SPAR, conditions, 1e-6, t_end=20.0, output_step=0.5, tolerance=1e-12, start="equilibrium")
    assert np.all(found.array("surge", "platform.mooring.length")[0] != 0)
    assert np.isfinite(found.growth)


def test_a_spar_by_the_sea_and_the_wind(spar):
    by = {"sea.significant_wave_height": 1e-3, "sea.peak_period": 3e-5, "wind.mean_speed": 3e-4,
          "world.water_density": 1e-4}  # fmt: skip
    conditions = {"wind.mean_speed": 16.0, "sea.significant_wave_height": 3.0, "sea.peak_period": 9.0,
                  "sea.repetition_period": 512.0, "wind.repetition_period": 512.0}  # fmt: skip
    compared(spar, by, conditions, 2e-6, t_end=10.0, output_step=0.5, tolerance=1e-12, start="equilibrium")


# --- numbers of a run ---------------------------------------------------------------------------------------------


def test_numbers_of_a_run_follow_by_the_chain_rule():
    plant, run = plant_of(Oscillator()), {"t_end": 20.0, "output_step": 0.05, "step": 0.02, "tolerance": TIGHT}
    found = sensitivities(plant, ["stiffness", "damping"], ["x"], **run)

    def load(time, values):
        return damage_equivalent_load((time, values), 4.0)

    numbers = [found.mean("x", 2.0), found.std("x", 2.0), found.maximum("x", 2.0), found.minimum("x", 2.0),
               found.slopes_of(load, "x", discard=2.0, name="range x")]  # fmt: skip

    def at(name, value):
        result = plant.simulate(parameters={name: value}, solver="fixed", **run)
        stats = result.statistics(discard=2.0)["x"]
        kept = result.time >= 2.0
        return np.array([stats.mean, stats.std, stats.max, stats.min,
                         load(result.time[kept], result.array("x")[kept])])  # fmt: skip

    for name, value in (("stiffness", 5.0), ("damping", 0.4)):
        h = 1e-4 * value
        slope = 8 * (at(name, value + h / 2) - at(name, value - h / 2)) - (at(name, value + h) - at(name, value - h))
        np.testing.assert_allclose([number[name] for number in numbers], slope / (6 * h), rtol=1e-6, atol=1e-10)
    np.testing.assert_allclose([number.value for number in numbers], at("damping", 0.4), rtol=1e-12)
    assert numbers[2].time == pytest.approx(4.0, abs=0.1) and "at 4" in repr(numbers[2])


def test_series_are_labelled_saved_and_drawn(tmp_path):
    import xarray

    found = sensitivities(plant_of(Oscillator()), ["stiffness"], ["x", "v"], t_end=1.0, output_step=0.1)
    series = found["x", "stiffness"]
    assert series.attrs["units"] == "m/(N/m)" and series.shape == (11,)
    found.save(tmp_path / "s.nc"), found.save(tmp_path / "s.csv"), found.plot(tmp_path / "s.png")
    again = xarray.open_dataarray(tmp_path / "s.nc", engine="scipy")
    np.testing.assert_array_equal(again.values, found.derivatives)
    head, *rows = (tmp_path / "s.csv").read_text().splitlines()
    assert head == "time [s],d x / d stiffness [m/(N/m)],d v / d stiffness [m/s/(N/m)]" and len(rows) == 11
    assert (tmp_path / "s.png").stat().st_size > 5000
    for wrong in (lambda: found["y", "stiffness"], lambda: found["x"], lambda: found.std("x")["k"],
                  lambda: found.save(tmp_path / "s.txt"), lambda: found.mean("x", 5.0)):  # fmt: skip
        with pytest.raises(ModelError):
            wrong()


# --- what is refused, and what is said ----------------------------------------------------------------------------


class Bouncing(Component):
    """A ball that jumps off the ground: an event at an instant that depends on the motion."""

    gravity: Scalar = param(default=9.81, unit="m/s^2", doc="gravity")
    height: Scalar = var(unit="m", start=1.0, state="prefer", doc="height")
    v: Scalar = var(unit="m/s", state="prefer", doc="speed")
    least: OfferedEvent = event(doc="it is stopped")

    def equations(self):
        return [eq(der(self.height), self.v), eq(der(self.v), -self.gravity),
                when(self.height < 0, reinit(self.v, -self.v)), on(self.least, reinit(self.v, 0.0))]  # fmt: skip


def test_events_at_instants_that_depend_on_the_motion_are_refused_where_they_happen():
    plant, run = plant_of(Bouncing()), {"output_step": 0.1, "step": 0.01}
    found = sensitivities(plant, ["gravity"], ["height"], t_end=0.4, tolerance=TIGHT, **run)
    fallen = found.run.array("height")[-1] - 1.0  # in proportion to gravity, step by step
    assert found.array("height", "gravity")[-1] == pytest.approx(fallen / 9.81, rel=1e-12)
    with pytest.raises(SimulationError, match=r"own happens at t = 0\.451.* depends on the motion"):
        sensitivities(plant, ["gravity"], ["height"], t_end=1.0, **run)
    with pytest.raises(SimulationError, match=r"least \(height < 0\.5 m\) happens at t = 0\.319"):
        sensitivities(plant, ["gravity"], ["height"], t_end=0.4, events=["least when height < 0.5 m"], **run)


def test_what_has_no_derivative_is_refused_with_the_reason(spar):
    run = {"t_end": 1.0, "output_step": 0.5}
    for by, text in ((["platform.hull.mas"], "did you mean"), (["wind.seed"], "no derivative by wind.seed"),
                     (["turbine.blades"], "turbine"), ([], "no parameter is given")):  # fmt: skip
        with pytest.raises(ParameterError, match=text):
            sensitivities(spar, by, ["surge"], **run)
    with pytest.raises(ModelError, match="no result or variable 'surg'; did you mean 'surge'"):
        sensitivities(spar, ["tower.mass"], ["surg"], **run)
    with pytest.raises(ParameterError, match="cannot go on from an earlier Result"):
        sensitivities(spar, ["tower.mass"], ["surge"], start=spar.simulate(0.5, 0.5, solver="fixed"), **run)
    with pytest.raises(ParameterError, match="stationary"):
        sensitivities(spar, ["tower.mass"], ["surge"], start="stationary", **run)
    with pytest.raises(ParameterError, match="no result is given"):
        sensitivities(spar, ["tower.mass"], [], **run)
    with pytest.raises(ParameterError, match="3 is no State, no Result"):
        sensitivities(spar, ["tower.mass"], ["surge"], start=3, **run)
    with pytest.raises(ParameterError, match=r"no element 'tower.mass\[0\]'; it is one number"):
        sensitivities(spar, ["tower.mass[0]"], ["surge"], **run)
    found = sensitivities(spar, ["tower.mass"], ["surge"], **run)
    for wrong in (lambda t, y: y, lambda t, y: "large", lambda t, y: None):
        with pytest.raises(ParameterError, match="one number of time and values"):
            found.slopes_of(wrong, "surge")


def test_a_number_of_the_wind_that_the_run_alone_gives(spar):
    weather = {"wind.mean_speed": 18.0, "wind.turbulence_intensity": 0.1, "wind.repetition_period": 512.0}
    run = {"t_end": 4.0, "output_step": 0.5, "tolerance": 1e-12, "start": "equilibrium"}
    compared(spar, {"wind.turbulence_intensity": 3e-3}, weather, 2e-6, **run)


class Still(Component):
    """Nothing moves."""

    given: Scalar = param(default=2.0, doc="a number")
    root: Scalar = var(start=1.0, doc="its root")

    def equations(self):
        return [eq(self.root**2, self.given + self.time)]


def test_a_model_without_states_is_refused():
    with pytest.raises(ParameterError, match="has no states"):
        sensitivities(plant_of(Still()), ["given"], ["root"], t_end=1.0, output_step=0.5)


class Lorenz(Component):
    """E. N. Lorenz (1963): chaos, with a largest exponent of 0.906 / s at 10, 28, 8/3."""

    rho: Scalar = param(default=28.0, doc="Rayleigh number")
    x: Scalar = var(start=1.0, state="prefer", doc="x")
    y: Scalar = var(start=1.0, state="prefer", doc="y")
    z: Scalar = var(start=20.0, state="prefer", doc="z")

    def equations(self):
        x, y, z = self.x, self.y, self.z
        return [eq(der(x), 10 * (y - x)), eq(der(y), x * (self.rho - z) - y), eq(der(z), x * y - 8 / 3 * z)]


def test_a_motion_that_is_chaotic_is_told_with_its_exponent():
    plant = plant_of(Lorenz())
    with pytest.warns(UserWarning, match="part exponentially, by a factor of e every 1"):
        found = sensitivities(plant, ["rho"], ["x"], t_end=120.0, output_step=0.1, step=0.01)
    assert found.growth == pytest.approx(0.906, abs=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sensitivities(plant_of(Oscillator()), ["damping"], ["x"], t_end=20.0, output_step=0.1)


class Root(Component):
    """der(x) = -sqrt(x - level): it comes to zero, where the derivative is infinite."""

    level: Scalar = param(default=0.0, doc="where it ends")
    u: RealInput = port(optional=True, doc="nothing")
    x: Scalar = var(start=1.0, state="prefer", doc="x")

    def equations(self):
        return [eq(der(self.x), -m.sqrt(m.fmax(self.x - self.level, 0.0)))]


def test_a_derivative_that_is_not_finite_is_named():
    plant = plant_of(Root())
    found = sensitivities(plant, ["level"], ["x"], t_end=1.0, output_step=0.1, step=0.01)
    assert np.all(np.isfinite(found.derivatives))
    with pytest.raises(SimulationError, match=r"der\(x\).* is not a finite number at t = 0 s"):
        sensitivities(plant, ["level"], ["x"], start={"x": 0.0}, t_end=1.0, output_step=0.1, step=0.01)
