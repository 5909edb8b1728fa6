"""Messages of errors: where, what is wrong, what to do."""

from __future__ import annotations

import pytest

from fowtlib.language import errors
from fowtlib.language.errors import ModelError, ModelFileError, ParameterError, did_you_mean, one_of


def test_every_error_of_a_user_is_a_model_error():
    names = ["ParameterError", "ConnectionFault", "UnitError", "StructureError", "SimulationError", "ModelFileError",
             "CompilerError", "NotFoundError"]  # fmt: skip
    assert all(issubclass(getattr(errors, name), ModelError) for name in names)


def test_places_are_put_in_front_from_the_inside_out():
    error = ParameterError("'lenght' is not a parameter of Tower.", where="tower").at("spar.yaml:12")
    assert str(error) == "spar.yaml:12: tower: 'lenght' is not a parameter of Tower."
    assert error.message == "'lenght' is not a parameter of Tower."
    assert str(ModelFileError("The file is empty.").at("")) == "The file is empty."


@pytest.mark.parametrize(
    ("word", "candidates", "text"),
    [
        ("lenght", ["length", "mass"], "; did you mean 'length'?"),
        ("Mass", ["length", "mass"], "; did you mean 'mass'?"),
        ("draft", ["draft_of_the_column", "mass"], "; did you mean 'draft_of_the_column'?"),
        ("gain_1", ["gain_a", "gain_b", "mass"], "; did you mean 'gain_a' or 'gain_b'?"),
        ("xyz", ["length", "mass"], "; there are 'length' and 'mass'."),
        ("xyz", ["length"], "; there is 'length'."),
        ("xyz", [f"long_name_{i}" for i in range(20)], "."),
        ("xyz", [], "."),
    ],
)
def test_did_you_mean(word, candidates, text):
    assert did_you_mean(word, candidates) == text


def test_one_of():
    assert one_of(["a"]) == "'a'"
    assert one_of(["a", "b", "c"]) == "'a', 'b' or 'c'"
    assert one_of([]) == ""
