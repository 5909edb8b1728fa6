"""The vector mathematics of the blade elements, against NumPy's extended precision, at every width this machine has.

Bounds: those that vector_math.c states, measured with gcc 12 with and without fused operations.
"""

import ctypes
from pathlib import Path

import numpy as np
import pytest

import fowtlib.components.aero as aero
from fowtlib.components.aero.vectors import WIDTHS, in_vectors
from fowtlib.language.native import compiler, load_library

pytestmark = [
    pytest.mark.skipif(not compiler(), reason="needs a C compiler"),
    pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="needs extended precision"),
]
FOLDER = Path(aero.__file__).parent
COUNT = 4096  # a multiple of every width
LAST_PLACE = 2.0**-53

# each on its range, with a name of its own for each width; two inputs and two outputs for all
WRAPPERS = """
#define WRAP(name, statements) EXPORT void LANE(try_##name)(const double *x, const double *y, double *a, double *b) { \\
    for (int i = 0; i < COUNT; i += LANES) { \\
        LANE(numbers) p = LANE(load)(x + i), q = LANE(load)(y + i), r = {0}, s = {0}; \\
        (void)q; statements; LANE(store)(a + i, r), LANE(store)(b + i, s); } }
WRAP(sine_cosine, LANE(sine_cosine)(p, &r, &s))
WRAP(decay, r = LANE(decay)(p))
WRAP(arc_sine, r = p + p * (p * p) * LANE(arc_sine_rest)(p * p))
WRAP(angle, r = LANE(angle)(q, p))
WRAP(root, r = LANE(root)(p))
WRAP(choose, r = LANE(choose)(p < q, p, q); s = LANE(size)(p))
#undef WRAP
"""


@pytest.fixture(scope="module")
def library():
    """The functions of all widths, and which of them the processor has."""
    mathematics = (FOLDER / "vector_math.c").read_text() + "\n#undef V\n#undef M\n#undef STRIDED\n"
    text = "#include <math.h>\nstatic const double pi = 3.14159265358979323846;\n" + f"#define COUNT {COUNT}\n"
    asked = "#ifdef VECTORS\nEXPORT int lanes_here(void) { return widest(); }\n"
    asked += "#else\nEXPORT int lanes_here(void) { return 1; }\n#endif\n"
    return load_library(text + in_vectors(mathematics + WRAPPERS) + asked, "vector_math")[1]


@pytest.fixture(scope="module", params=list(WIDTHS))
def evaluate(request, library):
    if library.lanes_here() < request.param:
        pytest.skip("this processor has no such vectors")

    def call(name, x, y=None):
        x = np.ascontiguousarray(x, dtype=float)
        y = np.zeros(COUNT) if y is None else np.ascontiguousarray(y, dtype=float)
        out = np.zeros(COUNT), np.zeros(COUNT)
        pointers = [ctypes.c_void_p(column.ctypes.data) for column in (x, y, *out)]
        getattr(library, f"try_{name}_{request.param}")(*pointers)
        return out

    return call


def units(value, exact):
    """The largest error in units of 2^-53 of the value."""
    return float(np.abs((value - exact) / exact).max()) / LAST_PLACE


def test_sine_and_cosine(evaluate):
    x = np.concatenate([np.logspace(-7, np.log10(np.pi / 2), COUNT // 2), np.linspace(1e-3, np.pi / 2, COUNT // 2)])
    sine, cosine = evaluate("sine_cosine", x)
    assert units(sine, np.sin(x.astype(np.longdouble))) < 2.5
    assert np.abs(cosine - np.cos(x.astype(np.longdouble))).max() < 2.5 * LAST_PLACE


def test_decay(evaluate):
    x = np.concatenate([[0.0, 700.0], np.logspace(-12, 2.845, COUNT - 2)])
    assert units(evaluate("decay", x)[0], np.exp(-x.astype(np.longdouble))) < 1.5
    far = np.full(COUNT, 1e300)
    assert np.all(evaluate("decay", far)[0] == evaluate("decay", np.full(COUNT, 700.0))[0])


def test_arc_sine(evaluate):
    x = np.linspace(1e-6, 0.5, COUNT)
    assert units(evaluate("arc_sine", x)[0], np.arcsin(x.astype(np.longdouble))) < 1.5


def test_angle(evaluate):
    g = np.random.default_rng(1)
    x, y = g.normal(size=COUNT), g.normal(size=COUNT) * 10.0 ** g.integers(-6, 6, COUNT)
    exact = np.arctan2(y.astype(np.longdouble), x.astype(np.longdouble))
    assert units(evaluate("angle", x, y)[0], exact) < 2
    x[:6], y[:6] = [0, 0, 0, 1, -1, 2], [0, 1, -2, 0, 0, 2]
    assert evaluate("angle", x, y)[0][:6] == pytest.approx(np.arctan2(y[:6], x[:6]), abs=1e-15)


def test_roots_choices_and_sizes(evaluate):
    g = np.random.default_rng(2)
    x, y = g.normal(size=COUNT), g.normal(size=COUNT)
    assert np.array_equal(evaluate("root", np.abs(x))[0], np.sqrt(np.abs(x)))
    chosen, size = evaluate("choose", x, y)
    assert np.array_equal(chosen, np.minimum(x, y)) and np.array_equal(size, np.abs(x))


def test_a_lane_without_a_number_is_alone(evaluate):
    for name, values in (("decay", np.ones(COUNT)), ("sine_cosine", np.ones(COUNT)), ("angle", np.ones(COUNT))):
        good = evaluate(name, values, values)[0]
        bad = values.copy()
        bad[5] = np.nan
        out = evaluate(name, bad, values)[0]
        assert np.array_equal(np.delete(out, 5), np.delete(good, 5))
