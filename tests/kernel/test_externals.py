"""External functions: torn calls with their own Jacobian give what the same formula in the equations gives."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import ExternalFunction, ModelError, Scalar, der, eq, param, var
from fowtlib.language.equations import active
from fowtlib.language.externals import with_interface
from fowtlib.language.native import compiler

MASS, DRAG = 2.0, 0.7


def drag_force(v: np.ndarray) -> list[float]:
    return [-DRAG * abs(v[0]) * v[0]]


def drag_slope(v: np.ndarray) -> list[list[float]]:
    return [[-2 * DRAG * abs(v[0])]]


class Falling(fw.Component):
    """A mass with quadratic drag from an external function, `level` calls deep; terminal velocity tanh law."""

    drag: object = param(doc="external function")

    x: Scalar = var(unit="m", doc="distance")
    v: Scalar = var(unit="m/s", state="prefer", doc="velocity")
    f: Scalar = var(unit="N", doc="drag")

    def equations(self):
        return [
            eq(der(self.x), self.v),
            eq(self.f, self.drag(velocity=self.v)["force"]),
            eq(MASS * der(self.v), MASS * 9.81 + self.f),
        ]


def exact(time: np.ndarray) -> np.ndarray:
    terminal = np.sqrt(MASS * 9.81 / DRAG)
    return terminal * np.tanh(9.81 * time / terminal)


def check(function: ExternalFunction) -> None:
    result = fw.load(Falling(drag=function)).compile().simulate(3.0, output_step=0.1, tolerance=1e-10)
    assert np.max(np.abs(result.array("v") - exact(result.time))) < 1e-7
    plant = fw.load(Falling(drag=function)).compile()
    rest = plant.equilibrium(start={"v": 4.0})
    linear = plant.linearize(rest)
    assert rest["v"] == pytest.approx(np.sqrt(MASS * 9.81 / DRAG), rel=1e-8)
    assert float(linear.A.sel(rate="v", state="v")) == pytest.approx(-2 * DRAG * rest["v"] / MASS, rel=1e-6)


def test_python_function_with_its_jacobian():
    check(ExternalFunction("drag", {"velocity": 1}, {"force": 1}, python=drag_force, jacobian=drag_slope))


def test_python_function_by_finite_differences():
    check(ExternalFunction("drag", {"velocity": 1}, {"force": 1}, python=drag_force))


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs a C compiler")
def test_shared_library_with_its_jacobian(tmp_path):
    v = ca.SX.sym("v")
    function = ca.Function("drag", [v], [-DRAG * ca.fabs(v) * v])
    generator = ca.CodeGenerator("drag.c")
    generator.add(function)
    generator.add(function.jacobian())
    source, library = tmp_path / generator.generate(f"{tmp_path}/"), tmp_path / "drag.so"
    subprocess.run(["gcc", "-O1", "-fPIC", "-shared", source, "-o", library, "-lm"], check=True)
    check(ExternalFunction("drag", {"velocity": 1}, {"force": 1}, library=library))


def test_a_rate_of_an_external_output_uses_its_jacobian():
    class Differentiated(fw.Component):
        """y = g(x) of the external is differentiated: dy/dt = g'(x) dx/dt."""

        x: Scalar = var(start=0.3, doc="state")
        y: Scalar = var(doc="external output")
        rate: Scalar = var(doc="its rate")

        def equations(self):
            y = square(x=self.x)["y"]
            return [eq(der(self.x), 1 - self.x), eq(self.y, y), eq(self.rate, der(self.y))]

    square = ExternalFunction("square", {"x": 1}, {"y": 1}, python=lambda x: x**2, jacobian=lambda x: 2 * x)
    result = fw.load(Differentiated()).compile().simulate(2.0, output_step=0.1, tolerance=1e-10)
    x = result.array("x")
    assert np.allclose(result.array("rate"), 2 * x * (1 - x), atol=1e-8)


def test_declared_inputs_are_checked():
    drag = ExternalFunction("drag", {"velocity": 1}, {"force": 1}, python=drag_force)

    class Wrong(Falling):
        """Calls the external with a name it does not have."""

        def equations(self):
            return [eq(self.f, self.drag(velocty=self.v)["force"])]

    with pytest.raises(ModelError, match="external function drag has no input 'velocty'; did you mean 'velocity'?"):
        fw.load(Wrong(drag=drag)).compile()
    with pytest.raises(ModelError, match="give either library or python"):
        ExternalFunction("drag", {"velocity": 1}, {"force": 1})
    with pytest.raises(ModelError, match="there is no library"):
        ExternalFunction("drag", {"velocity": 1}, {"force": 1}, library="missing.so")


def test_the_reason_of_a_refusal_reaches_the_user():
    said = {"last": "said of an earlier call"}

    def refuse(v: np.ndarray) -> list[float]:
        if v[0] > 5:
            said["last"] = "The brochure of the drag ends at 5 m/s."
            raise ValueError
        return drag_force(v)

    sizes = {"velocity": 1}, {"force": 1}
    explained = {"explain": lambda: said.pop("last", "")}
    for options, kind, words in ((explained, ModelError, "^The brochure"), ({}, RuntimeError, "Error in Function")):
        function = ExternalFunction("drag", *sizes, python=refuse, jacobian=drag_slope, **options)
        plant = fw.load(Falling(drag=function)).compile()
        with pytest.raises(kind, match=words):
            plant.simulate(3.0, output_step=0.1)


def test_one_check_for_many_arguments():
    """The extremes of a column are checked; the message has the one that is the farthest outside, and its number."""

    class Spread(fw.Component):
        """Three places that move apart."""

        x: Scalar = var(start=0.0, doc="place")

        def equations(self):
            text = "place {number} of 3 is at {value}, and 4 is the limit."
            places = fw.language.math.vertcat(self.x, -3 * self.x, 2 * self.x)
            active().check_range(places, -4.0, 4.0, "places", "x", text)
            return [eq(der(self.x), 1.0)]

    plant = fw.load(Spread()).compile()
    assert len(plant.dae.checks) == 1
    with pytest.raises(ModelError) as error:
        plant.simulate(3.0, output_step=0.5)
    assert str(error.value) == "spread: place 2 of 3 is at -4.5, and 4 is the limit (t = 1.5 s)."


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
@pytest.mark.parametrize("name", ["first", "second"])
def test_the_interface_in_front_of_a_c_text(name):
    """y0 = u0 u2, y1 = u1, with a sparse Jacobian; the names of what is exported follow that of the function."""
    text = """
    EXPORT double FUNCTION(_half)(double value) { return value / OUTPUTS; }
    EXPORT int FUNCTION()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
        (void)iw, (void)w, (void)mem;
        if (res[0]) res[0][0] = arg[0][0] * arg[0][INPUTS - 1], res[0][1] = arg[0][1];
        return 0;
    }
    EXPORT int JACOBIAN()(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
        (void)iw, (void)w, (void)mem;
        if (res[0]) res[0][0] = arg[0][2], res[0][1] = 1, res[0][2] = arg[0][0];
        return 0;
    }
    """
    pattern = ca.Sparsity(2, 3, [0, 1, 2, 3], [0, 1, 0])
    function = ExternalFunction(name, {"u": 3}, {"y": 2}, source=with_interface(name, pattern, text))
    point = ca.DM([2.0, 3.0, 5.0])
    assert np.ravel(function.function(point)).tolist() == [10.0, 3.0]
    jacobian = function.function.jacobian()(point, 0)
    assert jacobian.sparsity() == pattern and jacobian.nonzeros() == [5.0, 1.0, 2.0]
    half = getattr(ctypes.CDLL(str(function.library)), f"{name}_half")
    half.restype, half.argtypes = ctypes.c_double, [ctypes.c_double]
    assert half(3.0) == 1.5
