"""Chord and twist as parameters of a run: the same as a fresh build, with exact derivatives."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import BladeElementAerodynamics
from fowtlib.components.environment import Wind, World
from fowtlib.components.mechanics import FixedRotation, FixedTranslation, Prismatic, Revolute, RigidBody, SpringDamper
from fowtlib.language.errors import ParameterError

DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"
FILES = {"blade": str(DATA / "blade_aerodynamics.csv"), "airfoils": str(DATA / "airfoils.csv")}


def rotor_on_a_spring(speed, **parameters):
    """Two rigid blades that turn with `speed` on a carriage along the wind, held by a spring of 50 kN/m."""
    model = fw.Assembly("rotor on a spring")
    model.world, model.wind = World(), Wind(kind="steady", mean_speed=11.0)
    model.carriage = Prismatic(n=(1, 0, 0))
    model.mass = RigidBody(mass=1e5, inertia=np.eye(3) * 1e6)
    model.spring = SpringDamper(stiffness=5e4, natural_length=100.0)
    model.ground = FixedTranslation(r=(100, 0, 0))
    model.shaft = Revolute(n=(1, 0, 0), w_start=speed)
    model.inertia = RigidBody(mass=1.0, inertia=np.eye(3) * 1e7)
    model.up = FixedTranslation(r=(0, 0, 90))
    model.air = BladeElementAerodynamics(**FILES, hub_radius=1.5, tip_radius=63, blades=2, **parameters)
    for a, b in (
        (model.world.frame, model.ground.frame_a), (model.world.frame, model.carriage.frame_a),
        (model.carriage.frame_b, model.mass.frame_a), (model.carriage.frame_b, model.up.frame_a),
        (model.spring.frame_a, model.carriage.frame_b), (model.spring.frame_b, model.ground.frame_b),
        (model.up.frame_b, model.shaft.frame_a), (model.shaft.frame_b, model.inertia.frame_a),
        (model.shaft.frame_b, model.air.hub),
    ):  # fmt: skip
        model.connect(a, b)
    for i in range(2):
        turn = model.add(f"blade_{i}", FixedRotation(n=(1, 0, 0), angle=np.pi * i))
        model.connect(model.shaft.frame_b, turn.frame_a)
        for k, r in enumerate(model.air.rotor.blade.radius):
            place = model.add(f"place_{i}_{k}", FixedTranslation(r=(0, 0, float(r))))
            model.connect(turn.frame_b, place.frame_a)
            model.connect(place.frame_b, model.air.nodes[17 * i + k])
    return model


def slopes(plant, rows, columns, parameters, state):
    """Exact derivatives of rows by each of the columns, at a state."""
    function = plant.functions.torn_jacobian("slopes", rows, columns)
    q = plant.at(parameters).whole(np.concatenate([state.u, state.d]))
    return [np.array(ca.densify(block)) for block in function.call([state.t, state.x, state.z, q])]


def numbers_of(plant, name):
    """Places of a parameter among all."""
    symbols = [s.element_hash() for s in plant.dae.p.elements()]
    return [symbols.index(s.element_hash()) for s in plant.dae.parameters[name].symbol.elements()]


SHAPED = {"air.chord": lambda blade: blade.chord, "air.twist": lambda blade: blade.twist}


@pytest.mark.parametrize("name", SHAPED)
def test_the_derivative_of_steady_loads_is_that_of_a_difference(name):
    """Thrust of the turning rotor, with induction, by the chord and the twist of three elements."""
    model = rotor_on_a_spring(1.1)
    plant, values = fw.load(model).compile(), SHAPED[name](model.air.rotor.blade)
    state = plant.initial_state()
    thrust = ca.SX(plant.dae.observed["air.thrust"])
    exact = slopes(plant, thrust, [plant.dae.p], {}, state)[0].ravel()[numbers_of(plant, name)]
    for k in (3, 10, 16):
        step = np.zeros(17)
        step[k] = 1e-5
        ends = [float(plant.initial_state({name: values + sign * step})["air.thrust"]) for sign in (1, -1)]
        assert exact[k] == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-5)
        assert abs(exact[k]) > 1


@pytest.mark.parametrize("name", SHAPED)
def test_the_derivative_of_the_equilibrium_is_that_of_a_difference(name):
    """Where the standing rotor pushes the spring to; its shaft is held."""
    model = rotor_on_a_spring(0.0)
    plant, values = fw.load(model).compile(), SHAPED[name](model.air.rotor.blade)
    hold = {"shaft.phi": 0.4, "shaft.w": 0.0}

    def place(parameters=None):
        return float(plant.equilibrium(parameters, hold)["carriage.s"])

    state, dae = plant.equilibrium(hold=hold), plant.dae
    by_x, by_z, by_p = slopes(plant, ca.vertcat(dae.ode, dae.alg), [dae.x, dae.z, dae.p], {}, state)
    kept = [i for i, quantity in enumerate(dae.states) if not quantity.path.startswith("shaft.")]
    rows = [*kept, *range(len(dae.states), by_x.shape[0])]
    whole = np.hstack([by_x[:, kept], by_z])[rows]
    moved = -np.linalg.solve(whole, by_p[np.ix_(rows, numbers_of(plant, name))])
    own = [quantity.path for quantity in dae.states].index("carriage.s")
    assert place() > 0.5
    for k in (4, 12):
        step = np.zeros(17)
        step[k] = 1e-4
        difference = (place({name: values + step}) - place({name: values - step})) / 2e-4
        assert moved[kept.index(own), k] == pytest.approx(difference, rel=1e-4)


@pytest.mark.parametrize("dynamic", [False, True])
def test_a_changed_run_is_that_of_a_fresh_build(dynamic):
    model = rotor_on_a_spring(1.1, dynamic_inflow=dynamic)
    blade, outputs = model.air.rotor.blade, ["carriage.s", "air.thrust", "shaft.w"]
    changes = {"air.chord": (1.1 * blade.chord).tolist(), "air.twist": (blade.twist + 0.02).tolist()}
    run = fw.load(model).compile()
    changed, unchanged = (run.simulate(2.0, 0.5, parameters=p, outputs=outputs) for p in (changes, {}))
    shape = {name.removeprefix("air."): value for name, value in changes.items()}
    built = fw.load(rotor_on_a_spring(1.1, dynamic_inflow=dynamic, **shape)).compile()
    fresh = built.simulate(2.0, 0.5, outputs=outputs)
    for name in outputs:
        assert np.asarray(changed[name]) == pytest.approx(np.asarray(fresh[name]), rel=1e-10, abs=1e-12)
        assert np.abs(np.asarray(changed[name]) - np.asarray(unchanged[name])).max() > 1e-4


def test_a_shape_of_another_blade_is_refused():
    with pytest.raises(ParameterError, match=r"air\.chord"):
        fw.load(rotor_on_a_spring(1.0, chord=[1.0, 2.0])).compile()
    with pytest.raises(ParameterError, match=r"air\.chord.*below"):
        fw.load(rotor_on_a_spring(1.0, chord=[0.0] * 17)).compile()


def test_the_start_knows_the_shape():
    """The steady operation that a turbine starts in is that of the changed blade, of a fresh build and of a run."""
    base = {"wind.kind": "steady", "wind.mean_speed": 8.0, "turbine.assembly.blade_hinges": 0, "tower.hinges": 0}
    model = fw.load("nrel5mw_land", set=base)
    twist = model.root.turbine.aerodynamics.rotor.blade.twist + 0.05
    change = {"turbine.aerodynamics.twist": twist.tolist()}
    other = fw.load("nrel5mw_land", set={**base, **change})
    plant = model.compile()
    first, changed = (float(plant.initial_state(p)["turbine.rotor_speed"]) for p in ({}, change))
    assert changed < 0.99 * first
    assert changed == pytest.approx(float(other.compile().initial_state()["turbine.rotor_speed"]), rel=1e-12)
    assert other.root.turbine.aerodynamics.rotor.external is model.root.turbine.aerodynamics.rotor.external
