"""The look-up in C against the one in NumPy, its sparse Jacobian, and a model that uses it."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import fowtlib.components.environment as environment
from fowtlib.components.environment import FieldGrid, write_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_wind import field_function
from fowtlib.language import ExternalFunction

SOURCE = Path(environment.__file__).parent / "full_field.c"
GRID = FieldGrid(rows=4, columns=5, steps=40, dz=10.0, dy=12.0, dt=0.25, speed=8.0, hub_height=90.0, bottom=75.0)
POINTS = 3

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs a C compiler")


def compiled(field, folder, *options):
    library = folder / f"{Path(field).stem}.so"
    flags = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", f"-DFIELD_POINTS={POINTS}"]
    command = ["gcc", *flags, f'-DFIELD_FILE="{field}"', *options, str(SOURCE), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    sizes = {"time": 1, "positions": 3 * POINTS}, {"velocities": 3 * POINTS}
    return ExternalFunction("wind_field", *sizes, library=library)


@pytest.mark.parametrize(("periodic", "shift"), [(True, None), (False, None), (True, 17.0)])
def test_twins(tmp_path, periodic, shift):
    random = np.random.default_rng(5)
    grid = replace(GRID, periodic=periodic, tower_points=2, description="any")
    speeds, tower = random.normal(size=(40, 4, 5, 3)), random.normal(size=(40, 2, 3))
    field = write_field(tmp_path / "a.bts", grid, speeds, tower)
    twin = field_function(FieldLookup(field, shift), POINTS).function
    function = compiled(field.path, tmp_path, *([] if shift is None else [f"-DFIELD_SHIFT={shift}"])).function
    slope, twin_slope = function.jacobian(), twin.jacobian()
    assert slope.sparsity_out(0).nnz() == 3 * POINTS * 4
    low, high = [-30, -30, 70] * POINTS, [30, 30, 110] * POINTS  # some of them beyond the edge
    for _ in range(300):
        column = np.concatenate([[random.uniform(-20, 40)], random.uniform(low, high)])
        np.testing.assert_allclose(function(column).full(), twin(column).full(), atol=1e-12)
        np.testing.assert_allclose(ca.densify(slope(column, 0)).full(), twin_slope(column, 0).full(), atol=1e-10)


def test_a_file_that_cannot_be_used(tmp_path):
    field = write_field(tmp_path / "a.bts", GRID, np.zeros((40, 4, 5, 3)))
    for name, data in (("short", Path(field.path).read_bytes()[:-2]), ("other", b"\x05" + bytes(200))):
        path = tmp_path / f"{name}.bts"
        path.write_bytes(data)
        with pytest.raises(RuntimeError, match="wind_field"):
            compiled(path, tmp_path).function(np.zeros(1 + 3 * POINTS))
