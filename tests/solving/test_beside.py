"""Values of a component tree with one parameter elsewhere: what follows from it is computed again, and nothing else."""

import numpy as np

from fowtlib.language import Component, Scalar, param
from fowtlib.language.expressions import value_of
from fowtlib.solving.beside import Beside
from fowtlib.solving.bindings import Common


class Plate(Component):
    length: Scalar = param(default=2.0, unit="m", doc="along")
    width: Scalar = param(default=3.0, unit="m", doc="across")
    border: Scalar = param(default=lambda self: self.parameter_value("width") / 10, unit="m", doc="around it")


def test_only_what_reads_the_moved_parameter_is_computed_again():
    plate, computed = Plate(), []

    def squared(name):
        def compute():
            computed.append(name)
            return plate.parameter_value(name) ** 2

        return value_of(plate, name, compute)

    def all_squared():
        return [squared(name) for name in ("length", "width", "border")]

    beside = Beside(Common(None, plate, frozenset()))
    with beside.here() as (_, read):
        here = all_squared()
    assert {name for _, name in read} == {"length", "width", "border"}
    for given, wanted, again in (
        ({"length": 4.0}, [16.0, 9.0, 0.3**2], ["length"]),
        ({"width": 5.0}, [4.0, 25.0, 0.5**2], ["width", "border"]),
    ):
        computed.clear()
        with beside.at({name: np.array(value) for name, value in given.items()}):
            np.testing.assert_allclose(all_squared(), wanted, rtol=1e-15)
        assert computed == again
    computed.clear()
    with beside.here():  # as it was, and known
        assert all_squared() == here
    assert not computed
