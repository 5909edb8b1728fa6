"""The wind of a field file in simulated models: what parts in it feel, and how a run ends that leaves it."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
import fowtlib.models
from fowtlib.components.aero import CoefficientRotor, TowerDrag
from fowtlib.components.blocks import Constant
from fowtlib.components.environment import FieldGrid, Wind, World, write_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_wind import field_function, field_handle
from fowtlib.components.mechanics import Fixed, SpeedSource
from fowtlib.language import Array, Component, ModelError, Scalar, der, eq, outer, param, var
from fowtlib.language import math as m

CSV = str(Path(fowtlib.models.__file__).parent / "data" / "nrel5mw" / "rotor_coefficients.csv")
GRID = FieldGrid(rows=5, columns=7, steps=80, dz=20.0, dy=25.0, dt=0.25, speed=10.0, hub_height=90.0, bottom=50.0)


@pytest.fixture(scope="module")
def fields(tmp_path_factory):
    """A periodic field and one that ends: waves of a few seconds, different from point to point."""
    folder = tmp_path_factory.mktemp("fields")
    time, z, y = np.meshgrid(np.arange(80) * 0.25, GRID.z, GRID.y, indexing="ij")
    phase = 2 * np.pi * time / 5 + 0.02 * y + 0.01 * z
    speeds = np.stack([10 + np.sin(phase) + 0.02 * (z - 90), 0.5 * np.cos(phase), 0.3 * np.sin(2 * phase)], axis=-1)
    periodic = write_field(folder / "periodic.bts", GRID, speeds)
    ending = write_field(folder / "ending.bts", replace(GRID, periodic=False), speeds)
    return FieldLookup(periodic), FieldLookup(ending)


class Drifting(Component):
    """Two points that move apart, and the wind at them."""

    drift: Scalar = param(default=1.0, unit="m/s", doc="speed of the second point along y")
    wind: Wind = outer(Wind)
    y: Scalar = var(unit="m", start=0, doc="position of the second point")
    velocities: Array = var(unit="m/s", shape=(6,), doc="wind at both")

    def equations(self):
        second = m.vertcat(4, self.y, 100)
        both = m.horzcat(m.vertcat(0, -10, 80), second)
        here = self.wind.velocity(both)
        return [eq(der(self.y), self.drift), eq(self.velocities, m.vertcat(here[:, 0], here[:, 1]))]


def drifting(path, drift=1.0, **wind):
    model = fw.Assembly("two points")
    model.world = World()
    model.wind = Wind(kind="field", file=path, **wind)
    model.points = Drifting(drift=drift)
    return model


def simulate(model, t_end=8.0, **options):
    return fw.load(model).compile().simulate(t_end, output_step=0.5, **options)


@pytest.mark.parametrize("direction", [0.0, 0.3])
def test_wind_at_moving_points(fields, direction):
    lookup = fields[0]
    result = simulate(drifting(lookup.field.path, direction=direction, stations=[[0, 90], [50, 100]]))
    time, zero = np.asarray(result["points.y"].time), 0 * np.asarray(result["points.y"].time)
    c, s = np.cos(direction), np.sin(direction)
    world = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    found = np.asarray(result["points.velocities"])
    for i, place in enumerate(((zero, zero - 10, zero + 80), (zero + 4, time, zero + 100))):
        expected = lookup.velocity(np.column_stack(place) @ world, time) @ world.T
        np.testing.assert_allclose(found[:, 3 * i : 3 * i + 3], expected, atol=1e-6)
    speed = np.asarray(result["wind.speed"])
    np.testing.assert_allclose(speed[:, 1], lookup.velocity(np.stack([zero, zero + 50, zero + 100], 1), time)[:, 0])


def test_jacobian_of_the_function(fields):
    function = field_function(fields[0], 2).function
    for handle in (field_handle(fields[0]), 0):  # in the field, and over a station
        shared = [handle, 3.17, 9.0, 0.7, 0.2, 0.3, 0.11, -0.08, 90.0, 5.0]
        column = np.array([*shared, 1.0, 7.0, 83.0, -4.0, -21.0, 101.0])
        jacobian = function.jacobian()(column, 0).full()
        assert jacobian.shape == (6, 16)
        for i in set(range(1, 16)) - {8, 9}:
            h = np.eye(16)[i] * 1e-5
            slope = (function(column + h) - function(column - h)).full().ravel() / 2e-5
            np.testing.assert_allclose(jacobian[:, i], slope, atol=2e-7)
        assert not jacobian[:, [0, 8, 9]].any()
        assert not jacobian[:3, 13:].any()
        assert not jacobian[3:, 10:13].any()
        assert jacobian[:, 6:8].any() == (handle == 0)
        assert jacobian[:, 5].any()


def test_the_function_without_a_compiler(fields, monkeypatch):
    function = field_function(fields[1], 3).function
    with monkeypatch.context() as changed:
        changed.setenv("FOWTLIB_CC", "no-such-compiler")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            twin = field_function(fields[1], 3).function
    random = np.random.default_rng(4)
    for handle in (field_handle(fields[1]), 0):
        for _ in range(20):
            column = np.concatenate([[handle], random.uniform(-1, 1, 7), [90.0, 20.0], random.uniform(-100, 100, 9)])
            np.testing.assert_allclose(function(column), twin(column), rtol=0, atol=1e-12)
            found, expected = (np.array(one.jacobian()(column, 0)) for one in (function, twin))
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_a_rotor_in_the_field(fields):
    lookup = fields[0]
    model = fw.Assembly("rotor")
    model.world = World()
    model.wind = Wind(kind="field", file=lookup.field.path, stations=[(30, 90)])
    model.rotor = CoefficientRotor(coefficients=CSV, radius=63.0, inertia=3.876e7)
    model.drive, model.speed, model.pitch = SpeedSource(), Constant(value=1.267), Constant(value=0.0)
    model.support = Fixed(r=(-2, 30, 90))
    model.connect(model.support.frame, model.rotor.frame)
    model.connect(model.speed.y, model.drive.w)
    model.connect(model.drive.flange, model.rotor.shaft)
    model.connect(model.pitch.y, model.rotor.blade_pitch)
    assert model.wind.mean_at(0) == pytest.approx(lookup.mean(30, 90))
    result = simulate(model)
    time = np.asarray(result["rotor.normal_wind"].time)
    expected = lookup.velocity(np.tile([-2.0, 30, 90], (len(time), 1)), time)[:, 0]
    np.testing.assert_allclose(np.asarray(result["rotor.normal_wind"]), expected, atol=1e-9)
    assert np.asarray(result["rotor.mean_wind"])[0] == pytest.approx(lookup.mean(30, 90))


def test_a_run_that_leaves_the_field_stops(fields):
    path = fields[0].field.path
    with pytest.raises(ModelError) as error:
        simulate(drifting(path, drift=20.0))
    assert str(error.value) == (
        f"points: point 2 of 2 is at y = 80 m, and the wind field {path} covers -75 to 75 m; use a field that is "
        "larger than all rotors with their motion (t = 4 s)."
    )
    np.testing.assert_allclose(error.value.result.time, np.arange(9) * 0.5)
    path = fields[1].field.path  # ends at 19.75 s, its first plane is 75 m downwind at the start
    with pytest.raises(ModelError) as error:
        simulate(drifting(path), 15.0)
    assert str(error.value) == (
        f"wind: the point needs the wind of time 20 s of the field {path}, which covers 0 to 19.75 s; use a "
        "longer field, a periodic one, or another field_shift (t = 12.5 s)."
    )
    assert simulate(drifting(path, field_shift=40.0), 15.0).time[-1] == 15


def test_many_points_cost_one_check_per_axis(fields):
    class Nodes(Component):
        """A blade of 51 nodes."""

        wind: Wind = outer(Wind)
        y: Scalar = var(unit="m", start=0, doc="position")

        def equations(self):
            nodes = m.horzcat(*[m.vertcat(0, self.y, 60 + i) for i in range(51)])
            return [eq(der(self.y), 0.01 * self.wind.velocity(nodes)[1, 50])]

    model = fw.Assembly("blade")
    model.wind = Wind(kind="field", file=fields[0].field.path, stations=[[0, 90], [0, 100]])
    model.blade = Nodes()
    plant = fw.load(model).compile()
    checks = [check for check in plant.dae.checks if check.level == "error"]
    ends, axes = 3, 3  # of the series, and of y, z and time of the field
    assert [check.path for check in checks] == ["wind"] * (ends + axes) + ["blade"] * axes


def test_what_a_rotor_requires(fields):
    wind = Wind(kind="field", file=fields[0].field.path)
    wind.require((-75, 75), (50, 130), "a rotor that fits")
    Wind(kind="steady", mean_speed=8).require((-1e3, 1e3), (0, 1e3), "a rotor in steady wind")
    start = f"{fields[0].field.path}: the wind field is too small: left needs "
    end = ", and more for the motion of a floating platform."
    for y_range, z_range, text in (
        (
            (6.3, 132.3),
            (27, 153),
            "y = 6.3 to 132.3 m and z = 27 to 153 m, and the field covers -75 to 75 m and 50 to 130 m; make one at "
            "least 266 m wide, and 27 to 153 m high",
        ),
        (
            (-63, 63),
            (60, 153.2),
            "z = 60 to 153.2 m, and the field covers 50 to 130 m; make one at least 126 m wide, and 60 to 154 m high",
        ),
    ):
        with pytest.raises(ModelError) as error:
            wind.require(y_range, z_range, "left")
        assert str(error.value) == start + text + end


def test_a_run_longer_than_the_field_is_warned_about(fields):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        simulate(drifting(fields[0].field.path), 21.0)
    assert sum("repeats itself after 20 s; use a longer one" in str(warning.message) for warning in caught) == 1


def test_dimensions_agree(fields):
    report = fw.load(drifting(fields[1].field.path, direction="10 deg")).check()
    assert not report.dimensions.findings


def test_mistakes(fields, tmp_path):
    path = fields[0].field.path
    with pytest.raises(
        ModelError, match="wind.file has no value; a wind of kind 'field' needs the path of a .bts file"
    ):
        simulate(drifting(""))
    with pytest.raises(ModelError, match=r"too small: point 1 is at y = 80 m, and the field covers -75 to 75 m"):
        simulate(drifting(path, stations=[[0, 90], [80, 90]]))
    with pytest.raises(ModelError, match=r"station 1 of FieldWind does not exist"):
        Wind(kind="field", file=path).mean_at(1)
    alone = write_field(tmp_path / "alone.bts", GRID, np.random.default_rng(1).normal(0, 1, (80, 5, 7, 3)))
    with pytest.raises(ModelError, match=r"alone.bts: the mean of u is .* m/s, and 10 m/s in the header .*; add the"):
        simulate(drifting(alone.path))
    (tmp_path / "broken.bts").write_bytes(Path(path).read_bytes()[:-10])
    with pytest.raises(ModelError, match="broken.bts: truncated"):
        simulate(drifting(str(tmp_path / "broken.bts")))


@pytest.mark.parametrize("tower_points", [1, 2, 0])
def test_a_tower_below_the_plane(tmp_path, tower_points):
    """Drag at 5, 20, 60 m: by the tower points at 15 and 0 m, else by what falls linearly to nothing at the ground."""
    z, heights = 30 + 15.0 * np.arange(9), [5.0, 20.0, 60.0]
    plane = np.zeros((20, 9, 9, 3))
    plane[..., 0] = 8 * (z[:, None] / 90) ** 0.2
    tower = np.zeros((20, tower_points, 3))
    tower[..., 0] = [5.59, 3.0][:tower_points]
    grid = FieldGrid(9, 9, 20, 15, 15, 0.1, 8, 90, 30, tower_points=tower_points)
    write_field(tmp_path / "a.bts", grid, plane, tower)
    model = fw.Assembly("tower")
    model.world, model.wind = World(), Wind(kind="field", file=str(tmp_path / "a.bts"))
    model.drag = TowerDrag(diameters=[6, 6, 5], lengths=[10, 20, 40])
    for k, height in enumerate(heights):
        point = model.add(f"point_{k}", Fixed(r=(3, 7, height)))
        model.connect(point.frame, model.drag.nodes[k])
    known = {1: ([0, 15, *z], [0, 5.59, *plane[0, :, 0, 0]]), 2: ([0, 15, *z], [3, 5.59, *plane[0, :, 0, 0]])}
    speed = np.interp(heights, *known.get(tower_points, ([0, *z], [0, *plane[0, :, 0, 0]])))
    state = fw.load(model).compile().initial_state()
    expected = 0.5 * 1.225 * np.array([60, 120, 200]) * speed**2
    found = [-float(np.ravel(state[f"drag.nodes[{k}].f"])[0]) for k in range(3)]
    assert found == pytest.approx(expected, rel=1e-3)
    assert np.ravel(state["drag.force"])[0] == pytest.approx(sum(expected), rel=1e-3)
