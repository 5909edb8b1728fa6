"""One flattening and one compilation for twenty conditions, each with the result of a model built for it alone."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import Wind, generate_field
from fowtlib.language import Component, Scalar, der, eq, outer, param, var
from fowtlib.language import math as m
from fowtlib.language.native import compiler

needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
QUICK = {"solver": "fixed"}


class Mast(Component):
    """A mast that the wind bends both ways, felt at two heights."""

    mass: Scalar = param(default=2e4, unit="kg", min=1, doc="mass of its head")
    damping: Scalar = param(default=4e3, unit="N*s/m", min=0, doc="damping")
    stiffness: Scalar = param(default=2e4, unit="N/m", min=1, doc="stiffness")
    drag: Scalar = param(default=20.0, unit="kg/m", min=0, doc="force by the square of the speed")
    wind: Wind = outer(Wind)
    x: Scalar = var(unit="m", start=0, fixed=True, state="prefer", doc="bending downwind")
    y: Scalar = var(unit="m", start=0, fixed=True, state="prefer", doc="bending across")
    v: Scalar = var(unit="m/s", start=0, fixed=True, state="prefer", doc="speed downwind")
    w: Scalar = var(unit="m/s", start=0, fixed=True, state="prefer", doc="speed across")

    def equations(self):
        blown = self.wind.velocity(m.horzcat(m.vertcat(self.x, self.y, 90), m.vertcat(0, 0, 60)))
        u, across = blown[0, 0] - self.v, blown[1, 0] - self.w
        speed = m.sqrt(u**2 + across**2 + 1e-6)
        return [
            eq(der(self.x), self.v),
            eq(der(self.y), self.w),
            eq(self.mass * der(self.v), self.drag * speed * u - self.damping * self.v - self.stiffness * self.x),
            eq(self.mass * der(self.w), self.drag * speed * across - self.damping * self.w - self.stiffness * self.y),
        ]


def mast():
    top = fw.Assembly("mast")
    top.wind, top.mast = Wind(), Mast()
    return fw.load(top)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    for seed, speed in ((1, 9.0), (2, 14.0)):
        generate_field(folder / f"{seed}.bts", mean_speed=speed, width=160, height=160, columns=9, rows=9, duration=80,
                       time_step=0.25, seed=seed)  # fmt: skip
    time = np.arange(0, 200.1, 0.5)
    np.savetxt(folder / "a.csv", np.column_stack([time, 9 + np.sin(0.3 * time)]), delimiter=",")
    np.savetxt(folder / "b.csv", np.column_stack([time, 12 + 3 * (time > 50)]), delimiter=",")
    return folder


def twenty(files):
    """Wind and parameters, duration [s], step [s]: they differ in kind, file, seed, heading, length and parameters."""
    mean = {"wind.mean_speed": 9.0}
    hump = {"wind.gust_shape": "1-cos", "wind.gust_speed": 5.0}
    csv, field = ({"wind.kind": "file"}, {"wind.kind": "field"})
    wind = [
        ({}, 60, 0.05),
        ({"wind.kind": "steady", **mean}, 60, 0.05),
        ({"wind.kind": "steady", "wind.mean_speed": 15.0, "wind.shear_exponent": 0.2}, 4000, 0.1),
        ({"wind.kind": "steady", **mean, "wind.direction": 0.6, "mast.mass": 3e4}, 100, 0.02),
        ({"wind.kind": "step", **mean, "wind.step_speed": 13.0, "wind.start_time": 20.03}, 80, 0.05),
        ({"wind.kind": "gust", **mean, "wind.start_time": 30.0}, 90, 0.05),
        ({"wind.kind": "gust", **mean, "wind.start_time": 10.0, **hump}, 60, 0.04),
        ({"wind.kind": "kaimal", **mean}, 600, 0.1),
        ({"wind.kind": "kaimal", **mean, "wind.seed": 2}, 600, 0.1),
        ({"wind.kind": "kaimal", **mean, "wind.seed": 3, "wind.turbulence_class": "A"}, 4000, 0.1),
        ({"wind.kind": "kaimal", "wind.mean_speed": 18.0, "wind.turbulence_intensity": 0.1}, 300, 0.05),
        ({"wind.kind": "kaimal", **mean, "wind.direction": -0.3, "mast.damping": 8e3}, 200, 0.05),
        ({**csv, "wind.file": str(files / "a.csv")}, 150, 0.05),
        ({**csv, "wind.file": str(files / "b.csv"), "wind.interpolation": "monotone"}, 150, 0.05),
        ({**csv, "wind.file": str(files / "b.csv"), "wind.interpolation": "linear", "mast.drag": 30.0}, 150, 0.05),
        ({**field, "wind.file": str(files / "1.bts")}, 60, 0.05),
        ({**field, "wind.file": str(files / "2.bts")}, 60, 0.05),
        ({**field, "wind.file": str(files / "2.bts"), "wind.interpolation": "cubic"}, 70, 0.05),
        ({**field, "wind.file": str(files / "1.bts"), "wind.direction": 0.2, "mast.stiffness": 3e4}, 65, 0.025),
        ({**field, "wind.file": str(files / "1.bts"), "wind.field_shift": 12.0}, 75, 0.05),
    ]  # fmt: skip
    return [(fw.Conditions(parameters=p, duration=t, output_step=max(0.5, h)), h) for p, t, h in wind]


def compare(found, expected, paths):
    for path in paths:
        one, other = (np.asarray(result[path]) for result in (found, expected))
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-10 * max(1.0, np.abs(other).max()), err_msg=path)


@needs_compiler
@pytest.mark.filterwarnings("ignore:.*repeats itself")
def test_twenty_conditions(files, counted):
    plant, cases = mast().compile(), twenty(files)
    assert len(cases) == 20
    results = [plant.simulate(conditions=case, step=step, **QUICK) for case, step in cases]
    assert counted == {"flattened": 1, "written": 1, "compiled": 1}
    for (case, step), found in zip(cases, results, strict=True):
        alone = mast().with_parameters(case.parameters).compile()
        expected = alone.simulate(conditions=case.but(parameters={}), step=step, **QUICK)
        compare(found, expected, ("mast.x", "mast.y", "mast.v", "wind.speed"))
    ends = {np.asarray(result["mast.x"]).tobytes() for result in results}
    assert len(ends) == 20
    assert counted["flattened"] == 21


@needs_compiler
def test_a_turbine_in_six_winds(files, counted):
    """A whole turbine on a spar: controller and rotor start in the wind of each run."""
    plant = fw.load("oc3_spar_rigid", set={"sea.spectrum": "still"}).compile()
    cases = [
        {"wind.kind": "steady", "wind.mean_speed": 8.0},
        {"wind.kind": "steady", "wind.mean_speed": 16.0, "wind.shear_exponent": 0.14},
        {"wind.kind": "gust", "wind.mean_speed": 11.4, "wind.start_time": 5.0},
        {"wind.kind": "kaimal", "wind.mean_speed": 13.0, "wind.seed": 5},
        {"wind.kind": "file", "wind.file": str(files / "a.csv")},
        {"wind.kind": "field", "wind.file": str(files / "2.bts")},
    ]
    results = [plant.simulate(30, 0.5, parameters=case, **QUICK) for case in cases]
    assert counted == {"flattened": 1, "written": 1, "compiled": 1}
    for case, found in zip(cases, results, strict=True):
        alone = fw.load("oc3_spar_rigid", set={"sea.spectrum": "still", **case}).compile()
        compare(found, alone.simulate(30, 0.5, **QUICK), ("surge", "rotor_speed", "blade_pitch", "wind_speed"))
    assert len({float(result["rotor_speed"][0]) for result in results}) > 3
