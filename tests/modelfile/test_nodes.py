"""Reading YAML: what plain scalars mean, placeholders, lines, and messages for text that is no YAML."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.language.errors import ModelFileError
from fowtlib.modelfile.nodes import parse
from fowtlib.modelfile.yaml_text import to_text


@pytest.mark.parametrize(
    ("text", "value"),
    [("1", 1), ("-2.5", -2.5), ("1e6", 1e6), ("1.5e-3", 1.5e-3), (".inf", float("inf")), ("~", None), ("", None),
     ("true", True), ("on", "on"), ("no", "no"), ("12:30", "12:30"), ("0x10", "0x10"), ("2020-01-01", "2020-01-01"),
     ('"12"', "12"), ("12.1 rpm", "12.1 rpm"), ("[1, a, 2 m]", [1, "a", "2 m"]), ("{a: 1}", {"a": 1}),
     ("rotor_{name}", "rotor_{name}"), ("[tower.arm_{name}.tip, x]", ["tower.arm_{name}.tip", "x"]),
     ("[r_{a}{b}, '{a}']", ["r_{a}{b}", "{a}"]), ("'{side}*half_span'", "{side}*half_span")],
)  # fmt: skip
def test_values(text, value):
    found = parse(f"key: {text}\n", "a.yaml").plain()["key"]
    assert found == value
    assert type(found) is type(value)


def test_every_value_knows_its_line():
    top = parse("a: 1\nb:\n  c: [1,\n      2]\n  d: x\n", "a.yaml")
    assert [str(node.place) for node in top.walk()] == [f"a.yaml:{line}" for line in (1, 1, 2, 3, 3, 4, 5)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a.yaml: the file is empty; a model file begins with 'fowtlib: 1'."),
        ("a: 1\nb: 2\na: 3\n", "a.yaml:3: 'a' is given twice; the first is in line 1."),
        ("a: 1\n\tb: 2\n", "a.yaml:2: this is not YAML: there is a tab; indent with spaces."),
        ("a: b: c", "a.yaml:1: this is not YAML: there is a colon too many, or the line is indented wrongly; "
         "quote text that holds ': '."),
        ("a: 1\nb: [1, 2\n", "a.yaml:3: this is not YAML: expected ',' or ']', but got '<stream end>' "
         "while parsing a flow sequence."),
        ("a: !!python/object/apply:os.system [ls]", "a.yaml:1: the tag !!python/object/apply:os.system "
         "has no meaning here."),
        ("a: &x [*x]", "a.yaml:1: an alias (*name) stands within the value it names."),
        ("? [1]\n: 2", "a.yaml:1: a key must be a name; quote text that begins with a bracket or a brace."),
        ("[" * 1000, "a.yaml:1: lists and mappings are nested too deeply; the limit is 50."),
    ],
)  # fmt: skip
def test_messages(text, message):
    with pytest.raises(ModelFileError) as error:
        parse(text, "a.yaml")
    assert str(error.value) == message


def test_aliases_that_multiply_are_stopped():
    rows = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    rows += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 8)]
    with pytest.raises(ModelFileError, match="becomes too large when its aliases"):
        parse("\n".join(rows), "a.yaml")


@settings(deadline=None)
@given(st.text(max_size=200))
def test_any_text_is_yaml_or_a_model_file_error(text):
    try:
        parse(text, "a.yaml")
    except ModelFileError as error:
        assert str(error).startswith("a.yaml")


letters = st.characters(codec="utf-8", exclude_categories=("Cs", "Cc"), exclude_characters="\ufeff")
plain_text = st.text(letters, max_size=20)
data = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**15), 10**15) | st.floats(allow_nan=False) | plain_text,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(plain_text, inner, max_size=4),
    max_leaves=12,
)


@settings(deadline=None)
@given(st.dictionaries(plain_text, data, min_size=1, max_size=4))
def test_what_is_written_is_read_again(document):
    text = to_text(document)
    if "\ue000" not in text and "\ue001" not in text:
        assert parse(text, "a.yaml").plain() == document
