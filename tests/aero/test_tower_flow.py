"""The tower in the wind: potential flow around a cylinder at the blades, drag of a tower in sheared wind."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import BladeElementAerodynamics, TowerDrag, TowerPotentialFlow
from fowtlib.components.aero.tower_flow import deflected_wind, shadowed_wind
from fowtlib.components.environment import Wind, World
from fowtlib.components.mechanics import Fixed, FixedTranslation, Prismatic, RigidBody, SpringDamper
from fowtlib.components.support import RigidTower
from fowtlib.language.errors import ParameterError, SimulationError

DATA = Path(fowtlib.models.__file__).parent / "data" / "nrel5mw"
STRAIGHT = [(0, 0, 0), (0, 0, 50), (0, 0, 100)]
D = 6.0


def deflected(wind, place, points=STRAIGHT, diameters=(D, D, D)):
    points = [ca.SX(np.array(p, dtype=float)) for p in points]
    result = deflected_wind(ca.SX(np.array(wind, dtype=float)), ca.SX(np.array(place, dtype=float)), points, diameters)
    return ca.Function("wind", [], [result])()["o0"].full().ravel()


def test_on_the_surface_of_the_cylinder():
    """Stagnation points in front and behind, twice the speed at the sides (any text on potential flow)."""
    assert deflected([10, 0, 0], [-D / 2, 0, 60]) == pytest.approx([0, 0, 0], abs=1e-12)
    assert deflected([10, 0, 0], [D / 2, 0, 60]) == pytest.approx([0, 0, 0], abs=1e-12)
    assert deflected([10, 0, 0], [0, D / 2, 60]) == pytest.approx([20, 0, 0])


@pytest.mark.parametrize("x", [-4.0, -6.0, -30.0])
def test_upstream_the_wind_lacks_the_square_of_d_over_2x(x):
    assert deflected([10, 0, 0], [x, 0, 60])[0] == pytest.approx(10 * (1 - (D / (2 * x)) ** 2))


def test_speed_by_the_stream_function():
    """Psi = W y (1 - R^2 / d^2): u = d psi / dy, v = -d psi / dx, by differences; the wind blows obliquely, w stays."""
    turn, speed, h = 0.6, 12.0, 1e-5
    c, s = np.cos(turn), np.sin(turn)

    def psi(along, across):
        return speed * across * (1 - (D / 2) ** 2 / (along**2 + across**2))

    for along, across in ((-5.0, 2.0), (1.0, -4.0), (7.0, 3.0)):
        u = (psi(along, across + h) - psi(along, across - h)) / (2 * h)
        v = -(psi(along + h, across) - psi(along - h, across)) / (2 * h)
        place = [along * c - across * s, along * s + across * c, 30.0]
        found = deflected([speed * c, speed * s, 1.5], place)
        assert found == pytest.approx([u * c - v * s, u * s + v * c, 1.5], abs=1e-7)


def test_symmetry():
    left, right = (deflected([9, 0, 0], [-5, y, 40]) for y in (2.5, -2.5))
    assert left == pytest.approx(right * [1, -1, 1])
    assert abs(left[1]) > 0.1


def test_the_local_diameter_and_the_nearest_point_of_a_bent_tower():
    points, diameters = [(0, 0, 0), (1.0, 0, 50), (4.0, 0, 100)], (8.0, 6.0, 4.0)
    axis = np.array([4.0, 0, 100]) / np.hypot(4, 100)
    nearest, diameter = np.array([0.5, 0, 25.0]), 7.0  # half way up the lower half
    normal = np.array([axis[2], 0, -axis[0]])
    chord_height = axis @ nearest
    wind = deflected(10 * normal, nearest - 9.0 * normal, points, diameters)
    assert chord_height == pytest.approx(axis @ (nearest - 9.0 * normal))
    assert wind == pytest.approx(10 * normal * (1 - (diameter / 18) ** 2), rel=1e-6)


def test_above_the_tower_the_dam_fades_within_a_diameter():
    lack = [10 - deflected([10, 0, 0], [-6, 0, z])[0] for z in (99.999, 100.0, 103.0, 106.0, 110.0)]
    assert lack == pytest.approx([2.5, 2.5, 1.25, 0, 0], abs=1e-5)
    assert [10 - deflected([10, 0, 0], [-6, 0, z])[0] for z in (0.0, -3.0, -6.0)] == pytest.approx([2.5, 1.25, 0])


def test_inside_of_the_tower_the_wind_is_bounded():
    found = [deflected([10, 0, 0], [x, 0.3, 50]) for x in np.linspace(-3, 3, 13)]
    assert np.all(np.linalg.norm(found, axis=1) <= 20 + 1e-9)


def test_slopes_are_finite_everywhere():
    place = ca.SX.sym("place", 3)
    points = [ca.SX(np.array(p, dtype=float)) for p in STRAIGHT]
    wind = deflected_wind(ca.SX([10.0, 0, 0]), place, points, (D, D, D))
    slope = ca.Function("slope", [place], [ca.jacobian(wind, place)])
    for at in ([0, 0, 50], [-3, 0, 50], [-5, 1, 100], [-5, 1, 120], [-5, 0, 0]):
        assert np.all(np.isfinite(slope(at).full()))



def shadowed(wind, place, drag=1.0, greatest=1.0, points=STRAIGHT, diameters=(D, D, D)):
    points = [ca.SX(np.array(p, dtype=float)) for p in points]
    wind, place = (ca.SX(np.array(v, dtype=float)) for v in (wind, place))
    result = shadowed_wind(wind, place, points, diameters, drag, greatest)
    return ca.Function("wind", [], [result])()["o0"].full().ravel()


@pytest.mark.parametrize("x", [30.0, 90.0, 300.0])
def test_far_behind_the_tower_the_momentum_that_is_missing_is_its_drag(x):
    """Sum of W (W - u) over y against C_d D W^2 / 2, where the deficit is small; the text says nothing of that."""
    y = np.linspace(-40, 40, 801)
    missing = np.array([10 - shadowed([10, 0, 0], [x, at, 60], drag=0.7)[0] for at in y])
    assert np.sum(10 * missing) * (y[1] - y[0]) == pytest.approx(0.7 * D * 10**2 / 2, rel=1e-2)


def test_the_shadow_lies_behind_the_tower_whatever_the_wind():
    for turn in (0.0, 0.7, -2.0):
        along, across = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
        wind, high = 8 * along, np.array([0, 0, 40.0])
        assert shadowed(wind, high - 6 * along) == pytest.approx(wind)
        assert shadowed(wind, high + 6 * along + 6 * across) == pytest.approx(wind)
        assert shadowed(wind, high + 12 * along) == pytest.approx(wind * (1 - 4**-0.5))
        left, right = (shadowed(wind, high + 12 * along + y * across) for y in (2.0, -2.0))
        assert left == pytest.approx(right)
        root = (148**0.5 / 3) ** 0.5
        assert left @ along == pytest.approx(8 * (1 - np.cos(np.pi / 2 * (2 / 3) / root) ** 2 / root))


def test_the_deficit_is_bounded_and_its_slopes_are_finite():
    assert shadowed([10, 0, 0], [3.01, 0, 50], greatest=0.5)[0] == pytest.approx(5.0)
    place = ca.SX.sym("place", 3)
    points = [ca.SX(np.array(p, dtype=float)) for p in STRAIGHT]
    wind = shadowed_wind(ca.SX([10.0, 0, 0]), place, points, (D, D, D))
    slope = ca.Function("slope", [place], [ca.jacobian(wind, place)])
    for at in ([0, 0, 50], [5, 0, 50], [9, 1, 50], [9, 1, 102], [0, 4, 50], [-5, 0, 0]):
        assert np.all(np.isfinite(slope(at).full()))


def add_tower(model, name, x):
    """A tower with a vertical axis at x."""
    tower = model.add(name, TowerPotentialFlow(diameters=[D, D]))
    for k, z in enumerate((0.0, 84.0)):
        point = model.add(f"{name}_point_{k}", FixedTranslation(r=(x, 0, z)))
        model.connect(model.world.frame, point.frame_a)
        model.connect(point.frame_b, tower.nodes[k])


def rotor_beside_a_tower(with_tower, distance=6.0, second=None):
    """Two blades at rest, one hangs down in front of the tower; the second tower stands at `second`."""
    model = fw.Assembly("rotor")
    model.world = World()
    model.wind = Wind(kind="steady", mean_speed=12.0)
    air = BladeElementAerodynamics(
        blade=str(DATA / "blade_aerodynamics.csv"), airfoils=str(DATA / "airfoils.csv"), hub_radius=1.5, tip_radius=63,
        blades=2,
    )  # fmt: skip
    if with_tower:
        add_tower(model, "tower_flow", 0.0)
    if second is not None:
        add_tower(model, "other", second)
    model.air = air
    hub = model.add("hub", FixedTranslation(r=(-distance, 0, 90)))
    model.connect(model.world.frame, hub.frame_a)
    model.connect(hub.frame_b, model.air.hub)
    for i, side in enumerate((1, -1)):
        for k, r in enumerate(air.rotor.blade.radius):
            place = model.add(f"place_{i}_{k}", FixedTranslation(r=(0, 0, side * float(r))))
            model.connect(hub.frame_b, place.frame_a)
            model.connect(place.frame_b, model.air.nodes[17 * i + k])
    return fw.load(model).compile()


def test_a_rotor_meets_the_deflected_wind():
    """At rest there is no induction: the drag of the lower blade is that of the wind lessened by (D/2x)^2."""
    free, dammed = (rotor_beside_a_tower(flag).initial_state() for flag in (False, True))
    share = (1 - (D / 12) ** 2) ** 2
    forces = [np.array([-state[f"air.nodes[{k}].f"] for k in range(34)]).reshape(34, 3) for state in (free, dammed)]
    assert forces[1][:17] == pytest.approx(forces[0][:17], abs=1e-9)  # the upper blade is above the tower
    assert forces[1][19:, 0] == pytest.approx(share * forces[0][19:, 0], rel=1e-9)  # from 8.3 m on, below its top


def test_the_flow_of_all_towers_adds_up():
    """Two towers in line, 6 m and 12 m behind the blade: u/U = 1 - (D/12)^2 - (D/24)^2."""
    free, dammed = (rotor_beside_a_tower(flag, second=6.0 if flag else None).initial_state() for flag in (False, True))
    share = (1 - (D / 12) ** 2 - (D / 24) ** 2) ** 2
    forces = [np.array([-state[f"air.nodes[{k}].f"] for k in range(34)]).reshape(34, 3) for state in (free, dammed)]
    assert forces[1][19:, 0] == pytest.approx(share * forces[0][19:, 0], rel=1e-9)


def test_a_blade_in_the_tower_is_told():
    with pytest.raises(SimulationError, match="a blade strikes the tower"):
        rotor_beside_a_tower(True, distance=2.9).simulate(1.0, output_step=1.0)


def tower_in_shear(sections, exponent=0.2, **options):
    model = fw.Assembly("tower")
    height, part = 87.6, 87.6 / sections
    model.world = World()
    model.wind = Wind(kind="steady", mean_speed=12.0, shear_exponent=exponent, direction=np.radians(30))
    heights = [(k + 0.5) * part for k in range(sections)]
    model.tower = RigidTower(height=height, mass=1.0, centre_of_mass=1.0, node_points=heights)
    model.drag = TowerDrag(diameters=[5.0] * sections, lengths=[part] * sections, drag_coefficient=0.8, **options)
    model.connect(model.world.frame, model.tower.frame_a)
    for k in range(sections):
        model.connect(model.tower.nodes[k], model.drag.nodes[k])
    return fw.load(model).compile().initial_state()


@pytest.mark.parametrize("exponent", [0.0, 0.2, 0.5])
def test_drag_of_a_tower_in_power_law_shear(exponent):
    """Integral of 0.5 rho C_d D V^2 (z/90)^2a dz, and its moment about the base."""
    state, h = tower_in_shear(24, exponent), 87.6
    pressure = 0.5 * 1.225 * 0.8 * 5.0 * 12**2 * (h / 90) ** (2 * exponent)
    force, moment = pressure * h / (2 * exponent + 1), pressure * h**2 / (2 * exponent + 2)
    direction = np.array([np.cos(np.radians(30)), np.sin(np.radians(30)), 0])
    assert np.ravel(state["drag.force"]) == pytest.approx(force * direction, rel=3e-3, abs=1e-6)
    assert state["tower.base_fore_aft_moment"] == pytest.approx(moment * direction[0], rel=1e-3)
    assert state["tower.base_side_side_moment"] == pytest.approx(-moment * direction[1], rel=1e-3)


def test_drag_of_a_tower_in_turbulence_is_the_same_in_time_and_frequency():
    """A mast on a spring and a dashpot, its drag by the relative wind."""
    model = fw.Assembly("mast on a spring")
    model.world, model.wind = World(), Wind(kind="kaimal", mean_speed=20.0, turbulence_intensity=0.15, seed=3,
                                            repetition_period=1500.0)  # fmt: skip
    model.slide, model.body = Prismatic(n=(1, 0, 0)), RigidBody(mass=2000.0, r_cm=(0, 0, 0), inertia=np.eye(3))
    model.wall = Fixed(r=(-50, 0, 0))
    model.spring = SpringDamper(stiffness=800.0, damping=100.0, natural_length=50.0)
    model.drag = TowerDrag(diameters=[2.0], lengths=[20.0], drag_coefficient=0.7)
    model.connect(model.world.frame, model.slide.frame_a)
    model.connect(model.wall.frame, model.spring.frame_a)
    for frame in (model.body.frame_a, model.drag.nodes[0], model.spring.frame_b):
        model.connect(model.slide.frame_b, frame)
    plant = fw.Model(model, outputs={"x": "slide.s", "drag": "drag.force[0]"}).compile()
    response = fw.response(plant)
    result = plant.simulate(1500.0, output_step=0.25, solver="fixed", step=0.05)
    late = np.asarray(result.time) > 100
    for name in ("x", "drag"):
        series = np.asarray(result[name])[late]
        assert series.std() == pytest.approx(response.std(name), rel=0.06)
        # the mean of |u| u is (1 + 0.15^2) times that of the mean wind, and the response has that alone
        assert series.mean() == pytest.approx(1.0225 * response.mean[response.outputs.index(name)], rel=0.02)


def test_drag_of_a_moving_tower_is_by_the_relative_wind():
    """A light mast on a slide in uniform wind runs towards the speed of the wind: m dv/dt = c (V - v)^2."""
    model = fw.Assembly("mast on a slide")
    model.world, model.wind = World(), Wind(kind="steady", mean_speed=8.0)
    model.slide, model.body = Prismatic(n=(1, 0, 0)), RigidBody(mass=500.0, r_cm=(0, 0, 0), inertia=np.eye(3))
    model.drag = TowerDrag(diameters=[2.0], lengths=[20.0], drag_coefficient=0.7)
    model.connect(model.world.frame, model.slide.frame_a)
    for frame in (model.body.frame_a, model.drag.nodes[0]):
        model.connect(model.slide.frame_b, frame)
    result = fw.load(model).compile().simulate(30.0, output_step=10.0, tolerance=1e-9)
    c = 0.5 * 1.225 * 0.7 * 40.0 / 500.0
    exact = 8.0 - 8.0 / (1 + c * 8.0 * np.array([0, 10, 20, 30.0]))
    assert result.array("slide.v") == pytest.approx(exact, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize(
    ("component", "message"),
    [
        (TowerPotentialFlow(diameters=[6.0]), "tower.diameters: 2 or more are needed, one for each frame."),
        (TowerPotentialFlow(diameters=[6.0, -1]), "tower.diameters: -1 is not a positive length in m."),
        (TowerDrag(diameters=[6.0, 5.0], lengths=[10.0]), "tower: 2 diameters and 1 lengths; give one for each frame."),
        (TowerDrag(diameters=[6.0], lengths=[0.0]), "tower.lengths: 0.0 is not a positive length in m."),
    ],
)
def test_a_tower_that_cannot_be(component, message):
    model = fw.Assembly("tower")
    model.world, model.wind = World(), Wind(kind="steady", mean_speed=8.0)
    model.tower = component
    for k in range(np.size(component.parameter_value("diameters"))):
        model.connect(model.world.frame, model.tower.nodes[k])
    with pytest.raises(ParameterError) as caught:
        fw.load(model).compile()
    assert str(caught.value) == message


SHIPPED = {  # diameters (base, top, length) of what stands in the wind
    "oc3_spar": [(6.5, 3.87, 77.6)], "nrel5mw_land": [(6.0, 3.87, 87.6)],
    "two_rotor_spar": [(6.28, 4.79, 77.6), (3.29, 3.29, 40.01), (4.79, 1.79, 66.905), (4.79, 1.79, 66.905)],
}  # fmt: skip


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_models_have_their_towers_in_the_wind(name):
    """At rest in 18 m/s: C_d 1 on the whole tower; each influence is off by one setting."""
    turbines = ("turbine_left", "turbine_right") if name == "two_rotor_spar" else ("turbine",)
    still = {"wind.kind": "steady", "wind.mean_speed": 18.0, **{f"{t}.assembly.blade_hinges": 0 for t in turbines}}
    if name == "two_rotor_spar":
        bare = {"tower_drag_coefficient": 0.0, "tower_flow.active": False}
    else:
        bare = {"tower_drag.active": False, "tower_flow.active": False}
    if name != "nrel5mw_land":
        still["sea.spectrum"] = "still"
    drags = ["tower_drag", *(["arm_drag_left", "arm_drag_right"] if name == "two_rotor_spar" else [])]
    state = fw.load(name, set=still).compile().initial_state()
    without = fw.load(name, set={**still, **bare}).compile().initial_state()
    drag = sum(float(np.ravel(state[f"{part}.force"])[0]) for part in drags)
    area = sum((base + top) / 2 * length for base, top, length in SHIPPED[name])
    assert drag == pytest.approx(0.5 * 1.225 * area * 18**2, rel=1e-3)
    assert all(np.ravel(without[f"{part}.force"]) == pytest.approx([0, 0, 0], abs=1e-9) for part in drags)
    least = 1e-3 if name != "two_rotor_spar" else 1e-5  # blade 1 is up; the others pass the tower at its sides
    for turbine in turbines:
        dam = abs(float(state[f"{turbine}.thrust"]) / float(without[f"{turbine}.thrust"]) - 1)
        assert least < dam < 0.02
