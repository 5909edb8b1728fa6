"""Code of the equations with lanes and shared texts: the numbers are those of CasADi's own evaluation, bit for bit."""

from __future__ import annotations

import ctypes as c
import re

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.native import compiler, load_library
from fowtlib.solving.engines import c_pieces
from fowtlib.solving.engines.c_lanes import OPERATIONS, WIDE, in_wide_vectors, prologue, word_here
from fowtlib.solving.engines.c_text import c_program
from fowtlib.solving.engines.fixed_step_code import _function, _known_from, dependences
from fowtlib.solving.engines.lanes import Packs, operations_of
from fowtlib.solving.engines.reduction import reduction

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")

WORDS = sorted({2, word_here()}) if compiler() else []
NAN = float("nan")


def library_of(text, word):
    """The library of a text with words of so many lanes, in vectors that hold them."""
    return load_library(in_wide_vectors(text) if word == WIDE else text, "lanes", optimization="-O1")[1]


def values(function, arguments, word, plain=""):
    """Results of a function of x and p by its C text, and the text. plain: what stands in front of it."""
    program = c_program(function, [("all", ["out"])], ["x", "p"], ["out"], word=word)
    library = library_of(plain + prologue(word) + program.text, word if not plain else 0)
    columns = [np.array(value, dtype=float) for value in arguments]
    out, scratch = np.full(function.numel_out(0), 7.0), np.full(program.scratch + 1, NAN)
    library["all"](*(c.c_void_p(array.ctypes.data) for array in (*columns, out, scratch)))
    return out, program.text


def vectors(text):
    """Statements that make vectors, and those that make numbers."""
    return len(re.findall(r"const W v\d+a?\b", text)), text.count("const double a")


def arms(count, joints=6):
    """`count` arms of joints, each with angles and lengths of its own, on a common root; sums over all arms."""
    x, p = ca.SX.sym("x", count * joints), ca.SX.sym("p", count * joints + 1)
    ends, forces = [], ca.SX(2, 1)
    for arm in range(count):
        place, angle, force = ca.SX(2, 1), p[-1] * (arm + 0.5), ca.SX(2, 1)
        for joint in range(joints):
            number = arm * joints + joint
            angle = angle + x[number]
            place = place + p[number] * ca.vertcat(ca.cos(angle), ca.sin(angle))
            force = force + ca.fmax(p[number], 0.3) * place / (1 + ca.sumsqr(place))
            ends.append(ca.vertcat(place, force))
        forces = forces + force
    return ca.Function("arms", [x, p], [ca.vertcat(*ends, forces)])


@pytest.mark.parametrize("plain", ["", "#include <math.h>\n#undef __GNUC__\n"])
def test_four_lanes_without_vectors_that_hold_them(plain):
    """In an FMU they are pairs where the processor has no wider ones, numbers for a compiler without vectors."""
    function, random = arms(4), np.random.default_rng(6)
    x, p = random.uniform(-2, 2, 24), random.uniform(0.1, 1, 25)
    text = plain + prologue(WIDE)
    program = c_program(function, [("all", ["out"])], ["x", "p"], ["out"], word=WIDE)
    assert vectors(program.text)[0] > 10
    _, library = load_library(text + program.text, "lanes", optimization="-O1")
    out, scratch = np.full(function.numel_out(0), 7.0), np.full(program.scratch + 1, NAN)
    library["all"](*(c.c_void_p(array.ctypes.data) for array in (x, p, out, scratch)))
    np.testing.assert_array_equal(out, np.array(function(x, p)).ravel())


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6, 7])
def test_arms_give_the_numbers_of_casadi(word, count):
    function, random = arms(count), np.random.default_rng(count)
    arguments = [random.normal(size=function.numel_in(i)) for i in range(2)]
    found, text = values(function, arguments, word)
    # the same operations in the same order: not a bit differs
    np.testing.assert_array_equal(found, np.array(function(*arguments)).ravel())
    wide, single = vectors(text)
    if count >= 3:
        alone = 100 if count == 5 else 0  # one of five arms, as vectors have four lanes
        assert wide >= 100 and single < 120 + alone  # the rest are the sums over all arms


@pytest.mark.parametrize("word", WORDS)
def test_every_operation_with_lanes(word):
    """Three parts with each operation, at numbers where it is odd too: NaN, infinity, both zeros, equal ones."""
    x, p = ca.SX.sym("x", 6), ca.SX.sym("p", 1)
    of_two = [
        ca.fmin, ca.fmax, ca.atan2, ca.fmod, ca.copysign, ca.lt, ca.le, ca.eq, ca.ne, ca.logic_and, ca.logic_or,
        ca.plus, ca.minus, ca.times, ca.rdivide, ca.power, ca.hypot, ca.remainder, lambda a, b: ca.if_else(a, b, 1.5),
    ]  # fmt: skip
    of_one = [
        ca.sin, ca.cos, ca.tan, ca.asin, ca.acos, ca.atan, ca.sinh, ca.cosh, ca.tanh, ca.asinh, ca.acosh, ca.atanh,
        ca.exp, ca.log, ca.sqrt, ca.fabs, ca.sign, ca.floor, ca.ceil, ca.erf, ca.log1p, ca.expm1, ca.logic_not,
        lambda a: a * a, lambda a: 2 * a, lambda a: 1 / a, lambda a: ca.exp(-a), lambda a: a**3, lambda a: a**2.5,
    ]  # fmt: skip
    rows = [f(x[k], x[k + 3]) + p for f in of_two for k in range(3)] + [f(x[k]) + p for f in of_one for k in range(3)]
    function = ca.Function("odd", [x, p], [ca.vertcat(*rows)])
    used = {function.instruction_id(k) for k in range(function.n_instructions())}
    assert set(OPERATIONS) - used == {ca.OP_ASSIGN, ca.OP_LIFT}
    for point in ([0.3, -0.7, 2.5, 1.5, -0.2, 2.5], [0.0, -0.0, 1.0, -0.0, 0.0, -1.0],
                  [NAN, 1.0, np.inf, 2.0, NAN, -np.inf], [1e-310, 1e300, -3.0, 0.0, 1e300, -3.0]):  # fmt: skip
        found, text = values(function, [point, [0.25]], word)
        assert vectors(text)[0] > 40
        with np.errstate(all="ignore"):
            np.testing.assert_allclose(found, np.array(function(point, 0.25)).ravel(), rtol=1e-15, atol=0)


def test_without_vectors_of_the_compiler():
    """What stands in the place of vectors where the compiler is neither gcc nor clang."""
    function, random = arms(3), np.random.default_rng(0)
    arguments = [random.normal(size=function.numel_in(i)) for i in range(2)]
    found, _ = values(function, arguments, 2, "#include <math.h>\n#undef __GNUC__\n")
    np.testing.assert_array_equal(found, np.array(function(*arguments)).ravel())


def test_what_is_not_alike_is_left_as_it_is():
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 1)
    rows = [ca.sin(x[0]) * p, ca.exp(x[1]) + p, ca.sqrt(x[2]) - p]
    _, text = values(ca.Function("different", [x, p], [ca.vertcat(*rows)]), [[1, 2, 3], [4]], 2)
    assert vectors(text) == (0, 6)


def test_lanes_of_an_expression_follow_those_of_what_it_is_of():
    """Results in another order than the parts they are of: no numbers have to change their lanes."""
    x, p = ca.SX.sym("x", 9), ca.SX.sym("p", 1)
    parts = [ca.sin(x[k] * x[k + 3]) + x[k + 6] for k in range(3)]
    rows = [parts[2] * p + 1, parts[0] * p + 1, parts[1] * p + 1, *(ca.exp(part) for part in parts)]
    function = ca.Function("turned", [x, p], [ca.vertcat(*rows)])
    program = operations_of(function, lambda argument, element: 0)
    packs = Packs(program, range(len(program.code)))
    assert len(packs.columns) == 6  # product, sine, sum, product with p, sum with 1, exponential
    for column in packs.columns:
        for inside in packs.operands(column):
            assert len(set(inside)) == 1 or inside in packs.columns or program.code[inside[0]] < 0


def test_values_known_from_different_sections_on_stay_apart():
    """Three alike expressions, one of an input that is known later: it cannot go with the others."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 1)
    function = ca.Function("later", [x, p], [ca.sin(x[:2]) * p, ca.sin(x[2]) * p])
    sections = [("soon", ["first"]), ("later", ["second"])]
    program = c_program(function, sections, ["x", "p"], ["first", "second"],
                        known_from=lambda argument, element: int(argument == 0 and element == 2))  # fmt: skip
    soon, later = program.text.split("soon_piece_1", 1)
    assert "x[2]" not in soon and "x[2]" in later
    together = c_program(function, sections, ["x", "p"], ["first", "second"])
    assert "x[2]" in together.text.split("soon_piece_1", 1)[0]


@pytest.fixture(scope="module")
def turbine():
    """The equations of the turbine with three blades, where they stand when it has started."""
    plant = fw.load("oc3_spar").compile()
    dae, at = plant.dae, plant.at()
    state = plant.initial_state()
    return plant, [state.t, state.x, state.z, at.whole(np.concatenate([state.u, state.d])), np.zeros(dae.w.shape[0])]


def section_names(dae):
    levels = [(f"level_{level}", ["first"]) for level in range(len(dae.levels))]
    return [*levels, ("model", ["first", "second"]), ("observed", ["first"])]


@pytest.mark.parametrize(("word", "repeated"), [(2, 40), (WORDS[-1] if WORDS else 2, 10)])
def test_the_turbine_gives_the_numbers_of_casadi(turbine, word, repeated, monkeypatch):
    """Inputs of externals, rates, residuals and results at points about the start, bit for bit."""
    (plant, point), random = turbine, np.random.default_rng(3)
    dae = plant.dae
    function, sections = _function(dae, plant.outputs.paths, {"cse": True}), section_names(plant.dae)
    known = dependences(dae, reduction(dae))
    texts = []
    for least in (10**6, repeated):
        monkeypatch.setattr(c_pieces, "REPEATED", least)
        program = c_program(function, sections, list("txzqw"), ["first", "second"], known, _known_from(dae), word)
        texts.append(vectors(program.text))
    wide, single = texts[0]
    assert wide > 2 * single and 3 * (wide + single) < 2 * function.n_instructions()
    assert sum(texts[1]) < 0.85 * sum(texts[0])  # what repeats itself is written once
    assert program.text.count("level_0_part_") > program.text.count("void level_0_part_") > 0  # hinge after hinge
    library = library_of(prologue(word) + program.text, word)
    scratch = np.full(program.scratch + 1, NAN)
    for _ in range(3):
        moved = [np.asarray(v, dtype=float) + random.normal(0, 0.1, np.shape(v)) for v in point]
        moved[3] = np.asarray(point[3], dtype=float)
        expected = [np.array(value).ravel() for value in function(*moved)]
        results = iter(expected)
        for name, outputs in sections:
            wanted = [next(results) for _ in outputs]
            found = [np.full(value.size, 7.0) for value in wanted]
            given = [np.atleast_1d(value) for value in moved]
            pointers = [c.c_void_p(array.ctypes.data) for array in (*given, *found)]
            pointers += [None] * (2 - len(found))
            library[name](*pointers, c.c_void_p(scratch.ctypes.data))
            for got, value in zip(found, wanted, strict=True):
                np.testing.assert_array_equal(got, value)


def test_the_same_text_each_time(turbine):
    plant, _ = turbine
    function, sections = _function(plant.dae, [], {"cse": True}), section_names(plant.dae)
    first, second = (c_program(function, sections, list("txzqw"), ["first", "second"]).text for _ in range(2))
    assert first == second


def test_pieces_of_one_unknown_are_enough(turbine):
    """Where one unknown moves, the pieces that depend on it give all that changes, as the Newton matrix needs it."""
    plant, point = turbine
    dae = plant.dae
    function, sections = _function(dae, [], {"cse": True}), section_names(dae)[:-1]
    known = dependences(dae, reduction(dae))
    program = c_program(function, [*sections, ("observed", ["first"])], list("txzqw"), ["first", "second"], known,
                        _known_from(dae), WORDS[-1])  # fmt: skip
    library = library_of(prologue(WORDS[-1]) + program.text, WORDS[-1])
    pieces = (c.c_void_p * len(program.masks[0])).in_dll(library, "pieces")
    call = c.CFUNCTYPE(None, *[c.c_void_p] * 8)
    given = [np.atleast_1d(np.asarray(value, dtype=float)).copy() for value in point]
    scratch = np.full(program.scratch + 1, NAN)
    sizes = [function.numel_out(k) for k in range(function.n_out())]
    out = [np.full(size + 1, NAN) for size in sizes]

    def run(some):
        for piece in some:
            section = next(s for s, end in enumerate(program.starts[1:]) if piece < end)
            first = out[min(section, len(dae.levels))]
            call(pieces[piece])(*(array.ctypes.data for array in (*given, first, out[len(dae.levels) + 1], scratch)))

    every = range(program.starts[len(dae.levels) + 1])
    run(every)
    for unknown in range(0, dae.z.shape[0], 7):
        given[2][unknown] += 0.1
        run(piece for piece in every if program.masks[0][piece] >> unknown & 1)
        expected = [np.array(value).ravel() for value in function(*given)]
        for got, value in list(zip(out, expected, strict=True))[: len(dae.levels) + 2]:
            np.testing.assert_array_equal(got[: value.size], value)
