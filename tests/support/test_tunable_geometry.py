"""Numbers of the structure as parameters of a run: a changed run is a fresh build, slopes are differences."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.mechanics import (
    BeamProperties,
    FixedFlange,
    FixedRotation,
    RigidBody,
    TorsionSpringDamper,
    World,
)
from fowtlib.components.support import Arm, FlexibleTower, RigidTower
from fowtlib.components.turbine import Hub, Nacelle, RigidBlade
from fowtlib.language.errors import ModelError


def join(model, *pairs):
    for a, b in pairs:
        model.connect(a, b)


def tower_and_arm():
    """A leaning tower of a tapered tube that carries an arm across the wind, with masses off the axes."""
    model = fw.Assembly("tower and arm")
    model.world = World()
    model.lean = FixedRotation(n=(1, 0.3, 0), angle=0.1)
    model.tower = FlexibleTower(
        heights=(0.0, 30.0, 80.0), diameters=(6.0, 5.0, 3.5), wall_thicknesses=(0.03, 0.025, 0.02), hinges=2,
        torsion=True, node_points=[20.0, 75.0, (0.5, 0.0, 40.0)], cuts=(0.0, 35.0),
    )  # fmt: skip
    model.arm = Arm(
        to=(5.0, 40.0, 2.0), root_radius=2.0, diameters=(3.0, 2.0), wall_thicknesses=(0.03, 0.02), hinges=2,
        torsion=True, cuts=(10.0,), node_distances=(12.0,),
    )  # fmt: skip
    model.head = RigidBody(mass=5e4, r_cm=(3.0, 1.0, 2.0), inertia=np.diag([4e5, 5e5, 6e5]))
    model.end = RigidBody(mass=2e4, r_cm=(-1.0, 0.5, 0.2), inertia=np.diag([1e5, 2e5, 3e5]))
    model.collar = RigidBody(mass=1e4, r_cm=(0.3, 0.0, 0.0), inertia=np.diag([1e4, 1e4, 2e4]))
    join(
        model, (model.world.frame, model.lean.frame_a), (model.lean.frame_b, model.tower.frame_a),
        (model.tower.frame_b, model.arm.frame_a), (model.tower.frame_b, model.head.frame_a),
        (model.arm.tip, model.end.frame_a), (model.tower.nodes[0], model.collar.frame_a),
    )  # fmt: skip
    return model


def rigid_tower_on_springs():
    """A rigid tower on a stub of a flexible one, so that its own numbers move the equilibrium."""
    model = fw.Assembly("rigid tower")
    model.world = World()
    model.lean = FixedRotation(n=(0, 1, 0), angle=0.05)
    model.stub = FlexibleTower(heights=(0, 10), diameters=(4, 4), wall_thicknesses=(0.03, 0.03), hinges=1)
    model.tower = RigidTower(height=60.0, mass=2e5, centre_of_mass=28.0, inertia=6e7, axial_inertia=8e5,
                             node_points=[30.0, (0.0, 1.0, 50.0)])  # fmt: skip
    model.head = RigidBody(mass=1e5, r_cm=(1.0, 0.5, 1.0), inertia=np.diag([4e5, 5e5, 6e5]))
    join(
        model, (model.world.frame, model.lean.frame_a), (model.lean.frame_b, model.stub.frame_a),
        (model.stub.frame_b, model.tower.frame_a), (model.tower.frame_b, model.head.frame_a),
    )  # fmt: skip
    return model


def nacelle_and_hub():
    """Nacelle, hub and two rigid blades on a short tower; a spring keeps the shaft from turning."""
    model = fw.Assembly("nacelle and hub")
    model.world = World()
    model.stub = FlexibleTower(heights=(0, 20), diameters=(4, 4), wall_thicknesses=(0.03, 0.03), hinges=1)
    model.nacelle = Nacelle(mass=2.4e5, centre_of_mass=(1.9, 0.1, 1.75), inertia=np.diag([1e6, 2e6, 2.6e6]),
                            shaft_height=2.0, tilt=0.09, overhang=5.0, azimuth_start=0.4)  # fmt: skip
    model.hub = Hub(blades=2, precone=0.04, radius=1.5, mass=5.7e4, inertia=1.2e5, centre_of_mass=0.3)
    model.spring, model.ground = TorsionSpringDamper(stiffness=1e8, damping=1e6), FixedFlange()
    join(
        model, (model.world.frame, model.stub.frame_a), (model.stub.frame_b, model.nacelle.frame_a),
        (model.nacelle.hub, model.hub.frame), (model.nacelle.shaft, model.spring.flange_b),
        (model.spring.flange_a, model.ground.flange),
    )  # fmt: skip
    for k, mass in enumerate((1.7e4, 1.6e4)):
        blade = RigidBlade(mass=mass, centre_of_mass=20.0, inertia=1.1e7)
        join(model, (model.hub.roots[k], model.add(f"blade_{k + 1}", blade).frame_a))
    return model


SIMULATED = ("tower.heights", "tower.diameters", "arm.wall_thicknesses", "nacelle.mass", "hub.radius", "tower.mass")
MODELS = {
    "tower and arm": tower_and_arm, "rigid tower": rigid_tower_on_springs, "nacelle and hub": nacelle_and_hub,
}  # fmt: skip


@cache
def compiled(name):
    plant = fw.load(MODELS[name]()).compile()
    return plant, plant.equilibrium()


def tunable():
    return [(name, path) for name in MODELS for path in compiled(name)[0].dae.parameters]


def changed(value, path, factor):
    """Another value of a parameter: what is zero gets something small. Cuts stay between the same hinges."""
    value = np.asarray(value, dtype=float)
    if path.endswith("cuts"):
        return value * (1 + (factor - 1) / 10)
    return np.where(value != 0, value * factor, 0.01 * (factor - 1))


def fresh(name, path, value):
    model = MODELS[name]()
    owner, _, parameter = path.rpartition(".")
    setattr(model.find(owner), parameter, value if np.ndim(value) else float(value))
    return fw.load(model).compile()


def test_what_is_tunable():
    plant, _ = compiled("tower and arm")
    for part in ("tower", "arm"):
        for name in ("diameters", "wall_thicknesses", "density", "young_modulus", "shear_modulus"):
            assert f"{part}.{name}" in plant.dae.parameters
    assert "tower.heights" in plant.dae.parameters
    assert set(plant.dae.bound) == {"tower.beam.chain", "arm.beam.chain"}


@pytest.mark.parametrize(("name", "path"), tunable())
def test_a_changed_run_is_a_fresh_build(name, path):
    plant, _ = compiled(name)
    value = changed(plant.dae.parameters[path].value, path, 1.05)
    other = fresh(name, path, value)
    state, same = plant.equilibrium({path: value}), other.equilibrium()
    assert state.x == pytest.approx(same.x, abs=1e-11)
    if path not in SIMULATED:
        return
    runs = [p.simulate(0.2, output_step=0.1, parameters=v) for p, v in ((plant, {path: value}), (other, None))]
    names = [n for n in plant.dae.names if n.endswith(("moment", "displacement", "torsion", ".t[0]")) and "[" not in n]
    for output in (names[0], names[-1]):
        a, b = (np.asarray(run[output]) for run in runs)
        assert a == pytest.approx(b, rel=1e-9, abs=1e-9 * max(1.0, np.max(np.abs(b))))


@pytest.mark.parametrize(("name", "path"), tunable())
def test_the_slope_of_the_equilibrium_is_a_difference(name, path):
    plant, state = compiled(name)
    if path == "tower.beam.cuts":  # one of them is at the root, and below it there is no tower
        with pytest.raises(ModelError, match="a hinge passes one of its nodes or cuts"):
            plant.linearize(state, inputs=[path], outputs=[])
        return
    linear = plant.linearize(state, inputs=[path], outputs=[])
    slope = -np.linalg.solve(linear.matrices["A"], linear.matrices["B"])
    value = np.asarray(plant.dae.parameters[path].value, dtype=float)
    scale = np.max(np.abs(state.x))
    for k in range(value.size):
        step = 1e-4 * (abs(value.reshape(-1, order="F")[k]) or 1.0)
        both = []
        for sign in (1, -1):
            moved = value.reshape(-1, order="F").copy()
            moved[k] += sign * step
            both.append(plant.equilibrium({path: moved.reshape(value.shape, order="F")}).x)
        difference = (both[0] - both[1]) / (2 * step)
        size = max(np.max(np.abs(difference)), 1e-6 * scale / step)
        assert np.max(np.abs(slope[:, k] - difference)) < 2e-5 * size


def test_the_slope_reaches_the_equilibrium():
    """A comparison of zeros proves nothing: the tube does move the equilibrium."""
    plant, state = compiled("tower and arm")
    for path in ("tower.diameters", "tower.wall_thicknesses", "tower.heights", "arm.young_modulus", "arm.density"):
        linear = plant.linearize(state, inputs=[path], outputs=[])
        slope = np.linalg.solve(linear.matrices["A"], linear.matrices["B"])
        value = np.ravel(plant.dae.parameters[path].value)
        assert np.max(np.abs(slope * value)) > 1e-4  # rad


def test_a_hinge_that_passes_a_node_needs_another_chain():
    plant, _ = compiled("tower and arm")
    with pytest.raises(fw.ModelError, match="a hinge passes one of its nodes or cuts, which makes another chain; set"):
        plant.equilibrium({"tower.diameters": (12.0, 4.0, 1.0)})


STEEL = {"mass_per_length": 3e3, "stiffness_x": 1e11}


@pytest.mark.parametrize(
    ("name", "value"),
    [("young_modulus", 2e11), ("density", 7850.0), ("shear_modulus", 8e10), ("diameters", (4.0, 4.0)),
     ("wall_thicknesses", (0.03, 0.03))],
)  # fmt: skip
def test_numbers_of_a_tube_beside_a_table_are_refused(name, value):
    table = BeamProperties.uniform(80.0, **STEEL)
    with pytest.raises(fw.ModelError) as error:
        FlexibleTower(table=table, **{name: value})
    assert str(error.value) == (
        f"FlexibleTower.{name} is given and would do nothing, because table is given (stiffness_factor scales what a "
        "table says); leave one of them out, or change it."
    )
    if name in ("diameters", "wall_thicknesses"):
        return
    with pytest.raises(fw.ModelError, match=f"Arm.{name} is given and would do nothing, because table is given"):
        Arm(to=(0, 80.0, 0), table=table, **{name: value})
    model = fw.Assembly("table")
    model.world, model.tower = World(), FlexibleTower(table=table, hinges=1)
    model.head = RigidBody(mass=1e5, inertia=np.eye(3) * 1e5)
    join(model, (model.world.frame, model.tower.frame_a), (model.tower.frame_b, model.head.frame_a))
    with pytest.raises(fw.ModelError, match=f"there is no tunable parameter 'tower.{name}'"):
        fw.load(model).compile().initial_state({f"tower.{name}": value})


def test_the_stiffness_of_a_table_is_scaled():
    def frequency(factor):
        model = fw.Assembly("table")
        model.world = World(gravity=0.0)
        model.tower = FlexibleTower(table=BeamProperties.uniform(80.0, **STEEL), hinges=2, stiffness_factor=factor)
        join(model, (model.world.frame, model.tower.frame_a))
        plant = fw.load(model).compile()
        return plant.linearize(plant.initial_state(), outputs=[]).modes()[0].frequency_hz

    assert frequency(4.0) == pytest.approx(2 * frequency(1.0), rel=1e-6)
