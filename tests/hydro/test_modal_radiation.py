"""The memory of the waves of bodies that deform: few combinations of their shapes radiate; a shipped platform."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_radiation import bordered_radiation, kept_modal_radiation
from fowtlib.components.hydro.radiation_identification import identify_radiation
from tests.hydro.test_radiation_identification import resonators

DATA = Path(__file__).parents[2] / "models" / "data"
# as of the shipped databases: wide steps where little is left of the damping
OMEGA = np.array([*np.arange(1, 17) / 10, 1.8, 2.0, 2.4, 2.8, 3.4, 4.0, 5.0])


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def test_wide_steps_where_little_is_left_do_not_cut_the_kernel():
    """A resonator of 0.8 rad/s, whose kernel is a fifth of its start after 8 s: damping within 3 %."""
    damping = resonators(OMEGA, [(1.0, 0.8, 0.25)]).real
    model = identify_radiation(OMEGA, damping, order=2)
    assert model.passive
    np.testing.assert_allclose(model.transfer(OMEGA).real, damping, atol=0.03 * damping.max())


@pytest.mark.parametrize(("second", "groups"), [
    ([[0.2, -0.3], [-0.3, 0.6]], [{0}, {1}]), ([[0.0, 0.0], [0.0, 0.5]], [set(), set(), {0}, {1}]),
])  # fmt: skip
def test_shapes_radiate_by_few_combinations_and_planes_stay_apart(second, groups):
    """Four states for each motion that makes waves, and the damping within 2 %.

    Two pairs of shapes, each turned in itself as those of a hull with three legs, make waves as surge and sway do, and
    by one more motion in each plane, which goes with them or is alone.
    """
    among = np.zeros((8, 10))
    among[:6, :6] = np.eye(6)
    for plane, (pair, other) in enumerate(((6, 8), (7, 9))):
        among[plane, [pair, other]] = 0.5, -0.2
        among[6 + plane, [pair, other]] = 0.8, 0.4
    for first, angle in ((6, 0.4), (8, -1.1)):
        among[:, first : first + 2] = among[:, first : first + 2] @ turned(angle)
    base = np.zeros((len(OMEGA), 8, 8))
    for plane in (0, 1):
        kept = np.ix_(range(len(OMEGA)), [plane, 6 + plane], [plane, 6 + plane])
        modes = [([[1.0, 0.3], [0.3, 0.2]], 0.7, 0.3), (second, 1.1, 0.3)]
        base[kept] = resonators(OMEGA, modes).real
    damping = among.T @ base @ among
    zero, none = np.zeros_like(damping), np.zeros((10, 10))
    rigid = identify_radiation(OMEGA, damping[:, :6, :6], order=4)
    model = bordered_radiation(rigid, OMEGA, damping, zero, none, order=4, passive=True)
    assert model.passive and model.stable
    assert model.states == rigid.states + 2 * 4
    assert sorted(({0, 1} & set(group.motions) for group in model.groups), key=sorted) == groups
    size = np.sqrt(np.einsum("nii->ni", damping).max(axis=0)[[0, 1, 6, 7, 8, 9]])
    kept = np.ix_(range(len(OMEGA)), [0, 1, 6, 7, 8, 9], [0, 1, 6, 7, 8, 9])
    apart = np.abs(model.transfer(OMEGA).real - damping)[kept] / np.outer(size, size)
    assert apart.max() < 0.02
    np.testing.assert_allclose(model.transfer(OMEGA)[:, :6, :6], rigid.transfer(OMEGA)[:, :6, :6], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "order", "states", "bound"), [("tlp_elastic", 6, 84, 0.14)]
)
def test_shipped_memory_is_near_to_its_damping(name, order, states, bound):
    """Every entry B_ij of the model within a share of sqrt(max B_ii max B_jj) at all frequencies, and passive."""
    data = ModalDatabase.read(DATA / name / "shapes.nc")
    model = kept_modal_radiation(data, order, True)
    assert model.passive and model.stable and model.states == states
    damping = (data.B + data.B.transpose(0, 2, 1)) / 2
    size = np.sqrt(np.einsum("nii->ni", damping).max(axis=0))
    assert (np.abs(model.transfer(data.omega).real - damping) / np.outer(size, size)).max() < bound
