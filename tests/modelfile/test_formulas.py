"""Formulas: the arithmetic of Python, units followed, and nothing run."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.language import Component, Scalar, Vector, param
from fowtlib.language.errors import ModelFileError
from fowtlib.language.expressions import evaluate
from fowtlib.language.unit_grammar import parse_unit
from fowtlib.language.units import unit_text
from fowtlib.modelfile.formulas import FUNCTIONS, Quantity, parse


class Sample(Component):
    span: Scalar = param(default=2.0, unit="m")
    mass: Scalar = param(default=3.0, unit="kg")
    slope: Scalar = param(default=0.5, unit="rad")
    ratio: Scalar = param(default=4.0)
    cutoff: Scalar = param(default=0.25, unit="Hz")
    headings: Vector = param(default=(1.0, 2.0, 3.0), unit="rad")


SAMPLE = Sample()
VALUES = {name: float(getattr(SAMPLE, name)) for name in ("span", "mass", "slope", "ratio", "cutoff")}


def lookup(name: str) -> Quantity:
    if name not in SAMPLE.parameters:
        raise ModelFileError(f"no {name}")
    unit = SAMPLE.parameters[name].unit
    return Quantity(getattr(SAMPLE, name), None if unit == "1" else parse_unit(unit))


def value_of(text: str) -> float:
    return float(evaluate(parse(text).evaluate(lookup).value))


@pytest.mark.parametrize(
    "text",
    ["2 + 3 * 4", "(2 + 3) * 4", "-2 ** 2", "2 ** -1", "2 ** 3 ** 2", "10 / 4 / 5", "1 - 2 - 3", "--3", "2 * -3",
     "1e3 + .5", "sin(1) + cos(pi / 3) * atan2(1, 2)", "sqrt(2) * exp(0.5) - log(3)", "max(1, 2) + min(3, abs(-4))",
     "+7", "2 - -3"],
)  # fmt: skip
def test_numbers_as_in_python(text):
    names = {name: getattr(math, name, None) for name in FUNCTIONS}
    names |= {"pi": math.pi, "min": min, "max": max, "abs": abs}
    assert value_of(text) == eval(text, {"__builtins__": {}}, names)


def formulas() -> st.SearchStrategy[str]:
    numbers = st.floats(0.1, 100.0).map(lambda value: repr(round(value, 3)))
    leaves = numbers | st.sampled_from(["ratio", "ratio", "pi"])

    def more(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        return st.one_of(
            st.tuples(inner, st.sampled_from(["+", "-", "*", "/", " + ", " * "]), inner).map("".join),
            inner.map(lambda text: f"({text})"),
            inner.map(lambda text: f"-{text}"),
            inner.map(lambda text: f"cos({text})"),
            st.tuples(inner, st.sampled_from(["2", "-1", "(0.5)"])).map(lambda pair: f"({pair[0]})**{pair[1]}"),
        )

    return st.recursive(leaves, more, max_leaves=6)


@given(formulas())
def test_agrees_with_python(text):
    names = {"ratio": 4.0, "pi": math.pi, "cos": math.cos}
    try:
        expected = eval(text, {"__builtins__": {}}, names)
    except (ZeroDivisionError, OverflowError, TypeError):  # TypeError: the cosine of a complex number
        expected = math.nan
    try:
        found = value_of(text)
    except (ModelFileError, ZeroDivisionError, OverflowError, TypeError):  # the latter while a parameter is put in
        found = math.nan
    if isinstance(expected, complex) or not math.isfinite(expected):
        return
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("2*span + 3 m", 7.0, "m"),
        ("2*span + 3", 7.0, "m"),
        ("span*span", 4.0, "m^2"),
        ("sqrt(span*span*4)", 4.0, "m"),
        ("span**3 / span", 4.0, "m^2"),
        ("span^2", 4.0, "m^2"),
        ("mass/span", 1.5, "kg/m"),
        ("headings[1] - slope", 1.5, "rad"),
        ("max(span, 5 m)", 5.0, "m"),
        ("3 km / 2", 1500.0, "m"),
        ("2 * 90°", math.pi, "rad"),
        ("1 m^2 * span", 2.0, "m^3"),
        ("atan2(span, span)", math.pi / 4, None),
        ("ratio * 2", 8.0, None),
        ("5 % * span", 0.1, "m"),
    ],
)
def test_units_are_followed(text, value, unit):
    result = parse(text).evaluate(lookup)
    assert float(evaluate(result.value)) == pytest.approx(value)
    assert (unit_text(result.unit) if result.unit else None) == unit


def test_a_formula_stays_an_expression_of_the_parameters():
    sample = Sample()
    result = parse("2*span").evaluate(lambda name: Quantity(getattr(sample, name), parse_unit("m")))
    sample.span = 10.0
    assert float(result.value) == 20.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("span + mass", "a length cannot be added to a mass."),
        ("span - mass", "a mass cannot be subtracted from a length."),
        ("sin(span)", "sin() of a length has no meaning."),
        ("2**span", "an exponent cannot be a length."),
        ("span**ratio", "a length can only be raised to a power that is a number."),
        ("1/0", "'1/0' divides by zero."),
        ("sqrt(-1)", "'sqrt(-1)' has no real value."),
        ("(-8)**(1/3)", "'(-8)**(1/3)' has no real value."),
        ("1e400", "'1e400' has no real value."),
        ("2*(span", "cannot read '2*(span' as a quantity or a formula: ')' is missing at the end."),
        ("2*", "cannot read '2*' as a quantity or a formula: something is missing at the end."),
        ("span mass", "cannot read 'span mass' as a quantity or a formula: 'mass' is not expected."),
        ("span ; 2", "cannot read 'span ; 2' as a quantity or a formula: ';' has no meaning here."),
        ("sinn(1)", "cannot read 'sinn(1)' as a quantity or a formula: "
         "there is no function 'sinn'; did you mean 'sin', 'asin' or 'sinh'?"),
        ("min(1)", "cannot read 'min(1)' as a quantity or a formula: min() takes 2 values, not 1."),
        ("headings[1.5]", "cannot read 'headings[1.5]' as a quantity or a formula: "
         "an index is a whole number, counted from 0."),
        ("(1 + 2)[0]", "'(1 + 2)[0]' takes an element of a single number."),
        ("1 +" * 200,
         "'1 +1 +1 +1 +1 +1 +1 +1 +1 +1 +1 +1 +1 +1...' is too long; a formula has 500 characters at most."),
        ("__import__('os')", "cannot read '__import__('os')' as a quantity or a formula: "
         "there is no function '__import__'."),
        ("().__class__", "cannot read '().__class__' as a quantity or a formula: "
         "a number or a name is missing before ')'."),
    ],
)  # fmt: skip
def test_messages(text, message):
    with pytest.raises(ModelFileError) as error:
        parse(text).evaluate(lookup)
    assert str(error.value) == message


@settings(deadline=None)  # the first unknown word imports pint
@given(st.text(max_size=40))
def test_any_text_is_a_formula_or_a_model_error(text):
    from fowtlib.language.errors import ModelError

    try:
        parse(text).evaluate(lookup)
    except ModelError as error:
        assert str(error)


@given(st.sampled_from(["exec", "open", "eval", "print", "__builtins__", "os.system", "getattr"]), st.text(max_size=10))
def test_no_name_is_ever_run(name, rest):
    with pytest.raises(ModelFileError):
        parse(f"{name}({rest!r})").evaluate(lookup)
