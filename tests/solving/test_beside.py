"""Values of a component tree with one parameter elsewhere: what follows from it is computed again, and nothing else."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language import Component, Scalar, param
from fowtlib.language.errors import ModelError
from fowtlib.language.expressions import one_evaluation, value_of
from fowtlib.solving.beside import Beside
from fowtlib.solving.binding import start_numbers
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


def _started(dae, tree, paths):
    """What parts compute when a run starts, and what parameters follow from others; what is refused as such."""
    found = {}
    for path in paths:
        try:
            found[path] = start_numbers(dae.bound[path], tree.find(dae.bound[path].owner))
        except ModelError:
            found[path] = None
    return found


@pytest.mark.parametrize(
    "name",
    ["dtu10mw_spar_3_design", "two_rotor_spar_design",
     pytest.param("oc4_semi_rigid", marks=pytest.mark.long)],
)  # fmt: skip
def test_all_that_parts_compute_follows_from_the_parameters_that_were_noted(name):
    """For each tunable parameter of a model, moved by itself: as on a tree of which nothing is known."""
    plant = fw.load(name).compile()
    dae, binding = plant.dae, plant.binding({})
    paths = [path for path in dae.bound if path not in binding.sources]
    common = Common(dae, plant.root, frozenset())
    beside, changed = Beside(common), 0
    with beside.here() as (tree, _):
        here = _started(dae, tree, paths)
    for path, value in binding.values.items():
        if not common.is_plain(path):
            continue
        moved = {path: np.asarray(value) * (1 + 1e-5) + (np.asarray(value) == 0) * 1e-5}
        with beside.at(moved) as tree:
            found = _started(dae, tree, paths)
        with common.put(moved) as tree, one_evaluation():
            wanted = _started(dae, tree, paths)
        for number in paths:
            np.testing.assert_array_equal(found[number], wanted[number], err_msg=f"{number} by {path}")
            changed += not np.array_equal(wanted[number], here[number])
    assert changed > 10
