"""Wind across the flow in a response: towers and rotors in closed forms, turned as a whole, and by few channels."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.aero import TowerDrag
from fowtlib.components.environment import TurbulentWind, World
from fowtlib.components.environment.field_spectra import spectra
from fowtlib.components.mechanics import Fixed
from fowtlib.frequency import few_channels
from fowtlib.language.run_time import RestingPlaces
from fowtlib.solving.excited import excited_model
from fowtlib.solving.mean_linear import rotating_linear_model
from fowtlib.solving.rotation import steady_rotation

SPEED, INTENSITY, DIAMETER, LENGTH, C_D, AIR = 20.0, 1e-3, 4.0, 10.0, 0.7, 1.225
FREQUENCIES = np.geomspace(1e-3, 1.0, 300)
AT_POINTS = {"point_spacing": 10.0, "rotor_diameter": 100.0, "reference_height": 90.0}  # columns at 0, 10 m, ...


@pytest.fixture(scope="module")
def mast():
    """Response of two pieces of a mast that stands still at places (2, 3), in a wind of hardly any turbulence."""
    root = fw.Assembly("mast")
    given = {"mean_speed": SPEED, "turbulence_intensity": INTENSITY, "shear_exponent": 0.0} | AT_POINTS
    root.world, root.wind = World(air_density=AIR), TurbulentWind(**given)
    root.drag = TowerDrag(diameters=[DIAMETER] * 2, lengths=[LENGTH] * 2, drag_coefficient=C_D)
    root.piece_0, root.piece_1 = Fixed(r=(0, 0, 80)), Fixed(r=(0, 0, 100))
    root.connect(root.piece_0.frame, root.drag.nodes[0])
    root.connect(root.piece_1.frame, root.drag.nodes[1])
    plant = fw.Model(root, outputs={"along": "drag.force[0]", "across": "drag.force[1]"}).compile()

    def tower(places, **wind):
        given = {f"piece_{k}.r": tuple(map(float, place)) for k, place in enumerate(places)}
        given |= {f"wind.{name}": value for name, value in wind.items()}
        return fw.response(plant, parameters=given, frequencies=FREQUENCIES)

    return tower


ROTOR = """
fowtlib: 1
title: NREL 5-MW turbine of stiff blade elements on a stiff tower
world: {class: World}
wind: {class: Wind, kind: turbulence, mean_speed: 18 m/s, shear_exponent: 0}
parts:
  ground: {class: Fixed, r: [0, 0, 10]}
  tower: {class: FlexibleTower, properties: "data:oc3_hywind/tower.csv", hinges: 0}
  turbine: {use: turbines/nrel5mw, parts: {assembly: {blade_hinges: 0}}}
connect:
  - [ground.frame, tower.frame_a]
  - [tower.frame_b, turbine.frame]
outputs:
  thrust: {of: turbine.thrust, unit: kN}
  rotor_speed: {of: turbine.rotor_speed, unit: rpm}
  side_side: {of: tower.base_side_side_moment, unit: kN m}
  fore_aft: {of: tower.base_fore_aft_moment, unit: kN m}
  torsion: {of: tower.base_torsion, unit: kN m}
  flapwise: {of: turbine.assembly.blade_1.flapwise_moment, unit: kN m}
simulation: {start: turning, solver: fixed, duration: 10 s, output_step: 0.1 s, step: 12.5 ms}
"""
LOADS = ["thrust", "rotor_speed", "side_side", "fore_aft", "torsion"]


@pytest.fixture(scope="module")
def turbine(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "rotor.yaml"
    path.write_text(ROTOR)
    return fw.load(str(path)).compile()


def deviation(part, model="kaimal"):
    """Of a component at a point [m/s], of the frequencies of the response."""
    density = spectra(FREQUENCIES, SPEED, INTENSITY * SPEED, 90.0, model)[:, part]
    return np.sqrt(np.trapezoid(density, FREQUENCIES))


@pytest.mark.parametrize("model", ["kaimal", "von_karman"])
def test_a_tower_feels_half_as_much_of_the_wind_across(mast, model):
    """0.5 rho C_d D U v a metre beside rho C_d D U u: of two points with v of their own, and with u in common."""
    # 130 m of points 10 m apart: 14 columns and rows, at 5 m and 95 m
    places = [(0, 5, 95), (0, 5, 115)]
    found = mast(places, field_spectrum=model)
    slope = AIR * C_D * DIAMETER * LENGTH * SPEED
    assert found.std("across") == pytest.approx(slope / 2 * np.sqrt(2) * deviation(1, model), rel=1e-3)
    assert found.std("across") == pytest.approx(found.std("across", "lateral wind"), rel=1e-6)
    assert found.std("along", "wind") == pytest.approx(found.std("along"), rel=1e-6)
    # with a coherence: the same for both but for the slope and the spectra, line by line
    alike = mast(places, field_spectrum=model, lateral_coherence="iec")
    u, v = (spectra(FREQUENCIES, SPEED, 1.0, 90.0, model)[:, part] for part in (0, 1))
    assert alike["across"].density / v == pytest.approx(alike["along"].density / u / 4, rel=1e-4)


def test_a_tower_between_the_points_feels_less(mast):
    at, between = (mast([(0, y, 95), (0, y, 95)]) for y in (5, 0))
    assert between.std("across") == pytest.approx(at.std("across") / np.sqrt(2), rel=1e-3)  # half of two points
    assert between.std("along") == pytest.approx(at.std("along"), rel=1e-3)


@pytest.mark.parametrize("coherence", ["none", "iec"])
@pytest.mark.parametrize("angle", [np.pi / 2, 0.4, -2.5])
def test_a_wind_that_is_turned_with_the_model_does_the_same(mast, angle, coherence):
    c, s = np.cos(angle), np.sin(angle)
    places = np.array([[0.0, -12.0, 83.0], [0.0, 9.0, 98.0]])
    turned = places @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    one = mast(places.tolist(), lateral_coherence=coherence)
    other = mast(turned.tolist(), lateral_coherence=coherence, direction=angle)
    along, across = (other.combined({"along": x, "across": y}).std for x, y in ((c, s), (-s, c)))
    assert (along, across) == pytest.approx((one.std("along"), one.std("across")), rel=1e-5)


def test_a_wind_of_u_alone_is_the_share_of_the_wind(mast):
    places = [(0, 5, 95), (0, 5, 115)]
    whole, alone = (mast(places, components=c) for c in ("uvw", "u"))
    assert list(whole.shares) == ["wind", "lateral wind", "vertical wind"] and list(alone.shares) == ["wind"]
    assert alone.std("along") == pytest.approx(whole.std("along", "wind"), rel=1e-6)
    assert alone.std("across") < 1e-9 * whole.std("across")


def test_a_rotor_in_uniform_wind_across_is_that_in_a_turned_wind(turbine):
    """The static slopes by v that is the same everywhere, averaged over a turn."""
    steady = {"wind.kind": "steady", "wind.shear_exponent": 0.0, "wind.mean_speed": 18.0}
    angle = 0.005
    turned = []
    for direction in (angle, -angle):
        state = fw.mean_state(turbine, steady | {"wind.direction": direction})
        rotating = rotating_linear_model(turbine, state, (), LOADS, turning=True)
        turned.append(steady_rotation(turbine, state, LOADS, rotating).mean)  # over a revolution
    wanted = (turned[0] - turned[1]) / (2 * 18.0 * np.tan(angle))
    state = fw.mean_state(turbine, steady)
    excited = excited_model(turbine, state, LOADS)
    A, B, C, D = (excited.linear.matrices[name] for name in "ABCD")
    columns, (places,) = excited.fields[1]
    assert places.part == 1 and places.labels[0].startswith("lateral")
    uniform = np.zeros(B.shape[1])
    uniform[columns][: len(places.places.radii)] = 1.0
    found = (D @ uniform - C @ np.linalg.solve(A, B @ uniform))[: len(LOADS)]
    assert np.abs(found - wanted) == pytest.approx(0, abs=1e-3 * np.abs(wanted).max()), (found, wanted)


def test_feathered_blades_that_stand_feel_uniform_wind_across_as_a_turned_wind(turbine):
    """The loads of places at rest, at a moment at which nothing moves."""
    storm = {"wind.kind": "steady", "wind.shear_exponent": 0.0, "wind.mean_speed": 40.0, "*.safety.idling": 1}
    loads, paths = [*LOADS, "flapwise"], [item.path for item in turbine.dae.states]
    still = dict(zip(paths, turbine.initial_state(storm).x.tolist(), strict=True))
    still |= {path: 0.0 for path in paths if path.endswith((".w", "generator.speed", "speed_filter.x"))}

    def at(**wind):
        given = storm | {f"wind.{name}": value for name, value in wind.items()}
        state = turbine.initial_state(given, still)
        return state, np.ravel(state.values(loads))

    excited = excited_model(turbine, at()[0], loads)
    angle, faster = 5e-4, 0.02
    turned = (at(direction=angle)[1] - at(direction=-angle)[1]) / (2 * 40.0 * np.tan(angle))
    blown = (at(mean_speed=40 + faster)[1] - at(mean_speed=40 - faster)[1]) / (2 * faster)
    for (columns, (places,)), wanted in zip(excited.fields, (blown, turned), strict=False):
        assert isinstance(places.places, RestingPlaces)
        found = excited.linear.matrices["D"][: len(loads), columns].sum(axis=1)
        assert found == pytest.approx(wanted, rel=2e-3, abs=1e-5 * np.abs(wanted).max())
    side, along = loads.index("side_side"), loads.index("fore_aft")
    assert abs(turned[side]) > 5 * abs(blown[along])  # feathered blades have their lift across


@pytest.mark.long
def test_a_rotor_that_is_turned_with_its_wind_has_the_same_response(turbine):
    one = fw.response(turbine, outputs=[*LOADS, "flapwise"])
    given = {"ground.angles": (0.0, 0.0, 0.7), "wind.direction": 0.7}
    other = fw.response(turbine, outputs=[*LOADS, "flapwise"], parameters=given)
    for share in ("wind", "lateral wind", "vertical wind"):
        for name in one.outputs:
            assert other.std(name, share) == pytest.approx(one.std(name, share), rel=2e-3, abs=1e-3 * one.std(name))


@pytest.mark.long
def test_few_channels_stand_for_all(turbine, monkeypatch):
    loads, some = [*LOADS, "flapwise"], {"frequencies": np.geomspace(2e-3, 1.5, 90)}
    few = fw.response(turbine, outputs=loads, **some)
    monkeypatch.setattr(few_channels, "FEWEST", 1000)
    whole = fw.response(turbine, outputs=loads, **some)
    assert few.driving["lateral wind"].shape[1] < 20 < 80 < whole.driving["lateral wind"].shape[1]
    for name in loads:
        for share in few.shares:
            lost = whole.std(name, share) ** 2 - few.std(name, share) ** 2
            assert abs(lost) < 1.5 * few_channels.LEFT_OUT * whole.std(name) ** 2, (name, share)
    alone = fw.response(turbine, outputs=LOADS, parameters={"wind.components": "u"}, **some)
    assert alone.driving["wind"].shape[1] == whole.driving["wind"].shape[1]  # as they were without v and w
    for name in LOADS:
        assert alone.std(name, "wind") == pytest.approx(whole.std(name, "wind"), rel=1e-9)
