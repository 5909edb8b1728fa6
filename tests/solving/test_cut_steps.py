"""Steps of the solver "fixed" that are not solved at once: taken in parts, and told of at the end of the run."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import World
from fowtlib.components.mechanics.forced_motion import ForcedOscillation
from fowtlib.components.mooring import DynamicLine
from fowtlib.language import Component, Scalar, assign, der, eq, param, sampled, var
from fowtlib.language import math as m
from fowtlib.language.errors import SimulationError
from fowtlib.solving.engines.twin import FixedStepTwin

STEP, RHO_INF, TIGHT = 0.05, 0.0, 1e-12
CUT = r"the step at t = 0\.5 s was not solved at once and taken in up to 2 parts"


class Block(Component):
    """A block that friction of 4 N/kg brings to rest; from 0.5 s on it sticks, and Newton's method runs to and fro."""

    roughness: Scalar = param(default=3e-3, unit="m/s", doc="speed up to which it creeps")
    begun: Scalar = param(default=2.0, unit="m/s", doc="speed at the start")

    x: Scalar = var(unit="m", state="prefer", doc="way")
    v: Scalar = var(unit="m/s", start=begun, state="prefer", doc="speed")
    f: Scalar = var(unit="m/s^2", doc="friction over mass")
    seen: Scalar = var(unit="1", discrete=True, doc="how many samples there were")

    def equations(self):
        return [
            eq(der(self.x), self.v), eq(der(self.v), self.f), eq(self.f, -4 * m.tanh(self.v / self.roughness)),
            sampled(0.1, assign(self.seen, self.seen + 1)),
        ]  # fmt: skip


def block(**parameters):
    return fw.load(Block(**parameters)).compile()


def run(plant, t_end=1.0, step=STEP, **more):
    return plant.simulate(t_end, 0.05, solver="fixed", step=step, rho_inf=RHO_INF, **more)


def test_friction_that_sticks_within_a_step():
    """Closed form: v0^2 / (2 mu g) = 0.5 m, to the way mu g h^2 that friction decides within a step."""
    with pytest.warns(UserWarning, match=CUT + r"\. .* \(--step 25ms\)\.$"):
        found = run(block())
    assert CUT.replace("\\", "") in found.attributes["warnings"]
    assert found.array("x")[-1] == pytest.approx(0.5, abs=4 * STEP**2)
    assert abs(found.array("v")[-1]) < 3e-3
    assert found.time == pytest.approx(np.linspace(0, 1, 21), abs=1e-12)
    assert found.array("seen") == pytest.approx(1 + np.floor(found.time / 0.1 + 1e-9))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fine = run(block(), step=0.5 * STEP)
    assert fine.array("x")[-1] == pytest.approx(0.5, abs=4 * (0.5 * STEP) ** 2)


@pytest.mark.parametrize("roughness", [1e-3, 3e-4, 1e-4])
def test_what_parts_do_not_solve_damped_newton_does(roughness):
    """A floor so rough that parts are too long for it as well; a run that comes to its end, and the way to 10 %."""
    with pytest.warns(UserWarning, match="not solved at once and taken in up to 8 parts"):
        found = run(block(roughness=roughness))
    assert found.array("x")[-1] == pytest.approx(0.5, rel=0.1)


def test_a_step_that_nothing_solves_still_ends_the_run():
    class Broken(Component):
        x: Scalar = var(unit="1", start=1.0, state="prefer", doc="state")

        def equations(self):
            return [eq(der(self.x), -m.sqrt(self.x - self.time))]

    with pytest.raises(SimulationError, match=r"fails after t = 0\.6 s: der\(x\) is not a finite number"):
        run(fw.load(Broken()).compile())


def test_a_run_from_its_checkpoint_goes_on_through_a_cut_and_still_tells_of_one():
    plant = block()
    with pytest.warns(UserWarning, match=CUT):
        whole = run(plant)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for until in (0.4, 0.7):
            part = run(plant, until)
            rest = run(plant, start=part)
            assert rest.array("x")[-1] == whole.array("x")[-1]
            assert CUT.replace("\\", "") in rest.attributes["warnings"]


def test_the_engine_without_a_compiler_cuts_too():
    """Its iteration is another one, and cuts where the compiled one does not; the way is that of the closed form."""
    plant = block(roughness=2e-2)
    order = [state.path for state in plant.dae.states]
    x, z, q = np.array([2.0 * (name == "v") for name in order]), np.zeros(len(plant.dae.algebraics)), np.zeros(1)
    engine = FixedStepTwin(plant.at(), STEP, 1e-8, RHO_INF)
    taken: list[np.ndarray] = []
    engine.watch = taken.append
    ends = engine.advance(0.0, 0.8, 16, x, z, q)[0]
    assert ends[-1, order.index("x")] == pytest.approx(0.5, abs=4 * STEP**2)
    assert engine.remarks()[0].startswith("the step at t = 0.5 s was not solved at once and taken in up to 4 parts")
    assert taken[0][:, 1].sum() == pytest.approx(0.8, rel=1e-12) and len(taken[0]) > 16
    again = FixedStepTwin(plant.at(), STEP, 1e-8, RHO_INF)
    again.remember(*engine.memory())
    assert again.remarks() == engine.remarks()


def test_sensitivities_go_through_the_parts():
    """Against differences of runs that are cut in the same way."""
    plant = block()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        settings = {"step": STEP, "rho_inf": RHO_INF, "tolerance": TIGHT}
        found = fw.sensitivities(plant, ["begun"], ["x"], t_end=0.8, output_step=0.05, **settings)
        h = 1e-5
        above, below = (run(plant, 0.8, parameters={"begun": 2.0 + s * h}, tolerance=TIGHT).array("x") for s in (1, -1))
    assert found.derivatives[:, 0, 0] == pytest.approx((above - below) / (2 * h), rel=1e-3, abs=1e-6)


def test_a_line_that_comes_taut_within_a_step():
    """Its greatest tension is that of `idas` to 0.02 %."""
    angle = np.radians(120)
    model = fw.Assembly("a line that comes taut")
    model.world = World(water_depth=90)
    top = (40 + 7.5 * np.cos(angle), 7.5 * np.sin(angle), -25)
    model.drive = ForcedOscillation(r=top, n=(1, 0, 0), speed_amplitude=2 * np.pi * 4 / 12, period=12)
    model.line = DynamicLine(
        anchor_position=(232.5 * np.cos(angle), 232.5 * np.sin(angle), -90), lengths=(166.1, 73.4, 17.1), elements=12,
        mass_per_length=(165, 550, 750), diameter=(0.1636, 0.2987, 0.3488), axial_stiffness=1.4e10,
    )  # fmt: skip
    model.connect(model.drive.frame, model.line.fairlead)
    plant = fw.load(model).compile()
    with pytest.warns(UserWarning, match="steps from t = .* were not solved at once and taken in up to"):
        found = plant.simulate(48.0, 0.025, solver="fixed", step=0.025, rho_inf=0.0)
    wanted = plant.simulate(48.0, 0.025, solver="idas")
    assert found.array("line.tension").max() == pytest.approx(wanted.array("line.tension").max(), rel=2e-4)
