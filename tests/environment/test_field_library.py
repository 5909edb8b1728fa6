"""The look-up in C against the one in NumPy: values, Jacobian, many files, memory, and files that change."""

from __future__ import annotations

import ctypes
import os
import sys
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import FieldGrid, Wind, create_field, write_field
from fowtlib.components.environment.field_lookup import FieldLookup
from fowtlib.components.environment.field_wind import field_function, field_handle
from fowtlib.language import Component, ModelError, Scalar, der, eq, outer, var
from fowtlib.language.native import compiler

GRID = FieldGrid(rows=4, columns=5, steps=6000, dz=10.0, dy=12.0, dt=0.25, speed=8.0, hub_height=90.0, bottom=75.0)
POINTS = 3
CALM = (0, 0, 0, 0, 0, 0, 90, 0)  # base, fluctuation, shear, direction, gradients, station, which a field does not need

needs_compiler = pytest.mark.skipif(not compiler(), reason="needs a C compiler")


def random_field(path, seed=5, **changes):
    grid = replace(GRID, **changes)
    random = np.random.default_rng(seed)
    tower = random.normal(size=(grid.steps, grid.tower_points, 3)) if grid.tower_points else None
    return write_field(path, grid, random.normal((8, 0, 0), 1, (grid.steps, 4, 5, 3)), tower)


def in_numpy(lookup, points, monkeypatch):
    with monkeypatch.context() as changed:
        changed.setenv("FOWTLIB_CC", "no-such-compiler")
        return field_function(lookup, points)


@needs_compiler
@pytest.mark.filterwarnings("ignore:.*run as Python code")
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
@pytest.mark.parametrize(("periodic", "shift"), [(True, None), (False, None), (True, 17.0)])
def test_twins(tmp_path, monkeypatch, periodic, shift, interpolation):
    """The field has seven blocks of 256 kB; times and places lie within and beyond its edges, and beside its tower."""
    random = np.random.default_rng(6)
    field = random_field(tmp_path / "a.bts", periodic=periodic, tower_points=2, description="any")
    lookup = FieldLookup(field, shift, interpolation)
    function, twin = field_function(lookup, POINTS), in_numpy(lookup, POINTS, monkeypatch)
    assert function.library is not None
    assert twin.library is None
    slope, twin_slope = function.function.jacobian(), twin.function.jacobian()
    assert slope.sparsity_out(0) == twin_slope.sparsity_out(0)
    assert slope.sparsity_out(0).nnz() == 3 * POINTS * 10
    low, high = [-30, -30, 45] * POINTS, [30, 30, 110] * POINTS
    times = [*random.uniform(-20, 1520, 300), -0.1, 0.0, 0.1, 1499.6, 1499.8, 1499.9, 1500.0, 1e6]
    for time in times:
        shared = [field_handle(lookup), time, *random.uniform(-1, 1, 6), 90, 5]
        column = np.concatenate([shared, random.uniform(low, high)])
        accuracy = {"rtol": 0, "atol": 1e-12 if time < 1e5 else 1e-9}  # rounding of the time in cells
        np.testing.assert_allclose(function.function(column).full(), twin.function(column).full(), **accuracy)
        found, expected = (ca.densify(f(column, 0)).full() for f in (slope, twin_slope))
        np.testing.assert_allclose(found, expected, **accuracy)


@needs_compiler
def test_one_library_serves_many_files(tmp_path):
    """More files than the pool has blocks, in turns; the wind of each is its own number."""
    lookups = []
    for i in range(40):
        speeds = np.full((20, 4, 5, 3), float(i))
        lookups.append(FieldLookup(write_field(tmp_path / f"{i}.bts", replace(GRID, steps=20), speeds)))
    functions = [field_function(lookup, POINTS) for lookup in lookups]
    assert len({function.library for function in functions}) == 1
    for _ in range(2):
        for i, lookup in enumerate(lookups):
            column = [field_handle(lookup), 1.3, *CALM, *[0, 1, 90] * POINTS]
            np.testing.assert_allclose(functions[0].function(column).full(), i, atol=1e-3)


@needs_compiler
def test_called_by_pointer_from_c(tmp_path):
    """What an engine in C does: open under a number of its own, ask for the sizes, call; a null result is skipped."""
    field = random_field(tmp_path / "a.bts")
    library = ctypes.CDLL(str(field_function(FieldLookup(field), POINTS).library))
    name, pointers = f"wind_field_{POINTS}", ctypes.POINTER(ctypes.c_double)
    problem = getattr(library, f"{name}_problem")
    problem.restype = ctypes.c_char_p
    column, result = np.array([7.0, 3.0, *CALM, *[0, 1, 90] * POINTS]), np.empty(3 * POINTS * 10)
    arguments = (pointers * 2)(column.ctypes.data_as(pointers), pointers())
    results, nothing = (pointers * 1)(result.ctypes.data_as(pointers)), (pointers * 1)(pointers())
    problem()
    assert getattr(library, name)(arguments, results, None, None, 0) == 1
    assert problem() == b"a wind field is used that was not opened in this process; start the run again"
    assert problem() == b""
    opened = getattr(library, f"{name}_open")
    missing = os.fsencode(tmp_path / "none.bts")
    assert opened(ctypes.c_double(7.0), missing, ctypes.c_double(np.nan), 0) == 1
    assert problem() == missing + b": the wind field cannot be read: No such file or directory"
    assert opened(ctypes.c_double(7.0), os.fsencode(field.path), ctypes.c_double(np.nan), 0) == 0
    for prefix, count, inputs in (("", 3 * POINTS, 1), ("jac_", 30 * POINTS, 2)):
        sizes = [ctypes.c_longlong(-1) for _ in range(4)]
        assert getattr(library, f"{prefix}{name}_work")(*map(ctypes.byref, sizes)) == 0
        assert [size.value for size in sizes] == [inputs, 1, 0, 0]
        result[:] = np.nan
        assert getattr(library, prefix + name)(arguments, nothing, None, None, 0) == 0
        assert np.isnan(result).all()
        assert getattr(library, prefix + name)(arguments, results, None, None, 0) == 0
        assert np.isfinite(result).sum() == count
        if not prefix:
            expected = FieldLookup(field).velocity([(0, 1, 90)] * POINTS, 3.0)
            np.testing.assert_allclose(result[:count], expected.ravel(), atol=1e-12)


@needs_compiler
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="measures memory as Linux tells it")
def test_memory_of_a_long_field(tmp_path):
    """25 x 25 points over 4000 s at 20 Hz are 300 MB as int16 and 1.2 GB as numbers; a run takes the pool: 8 MB."""
    grid = replace(GRID, rows=25, columns=25, steps=80_000, dz=6.0, dy=6.0, dt=0.05, bottom=18.0)
    new = create_field(tmp_path / "long.bts", grid)  # zeros, of which the disk holds nothing
    last = new.stored[-3:]
    last[:] = 100
    new.stored.flush()
    path = new.path
    del new, last
    assert os.path.getsize(path) > 300e6
    lookup = FieldLookup(fw.components.environment.read_field(path))
    function = field_function(lookup, 51).function
    column = np.array([field_handle(lookup), 0.0, *CALM, *[0, 1, 90] * 51])

    def resident():
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    function(column)
    before = resident()
    for column[1] in np.arange(0, 4000, 3.0):  # every block, of 3.5 s each
        assert not function(column).full().any()
    column[1] = 3999.9
    assert np.all(function(column).full() == 100)
    assert resident() - before < 10e6


class Blown(Component):
    """A point that the wind carries across."""

    wind: Wind = outer(Wind)
    y: Scalar = var(unit="m", start=0, doc="position")

    def equations(self):
        return [eq(der(self.y), 0.01 * self.wind.velocity(np.array([0, 0, 90]))[1])]


def compiled(path):
    top = fw.Assembly("blown")
    top.wind = Wind(kind="field", file=str(path))
    top.point = Blown()
    return fw.load(top).compile()


@pytest.mark.filterwarnings("ignore:.*run as Python code")
@pytest.mark.parametrize("language", [pytest.param("c", marks=needs_compiler), "numpy"])
def test_a_file_that_is_gone_or_another_one(tmp_path, monkeypatch, language):
    if language == "numpy":
        monkeypatch.setenv("FOWTLIB_CC", "no-such-compiler")
    path = tmp_path / "a.bts"
    random_field(path)
    plant = compiled(path)
    first = plant.simulate(2.0)
    random_field(path, seed=6)
    os.utime(path, ns=(1, 1))
    second = plant.simulate(2.0)  # the next run takes in what is there now
    assert second.array("point.y")[-1] == compiled(path).simulate(2.0).array("point.y")[-1]
    assert second.array("point.y")[-1] != first.array("point.y")[-1]
    state = plant.initial_state()
    path.unlink()
    for calculation in (plant.simulate, lambda: plant.linearize(state)):
        with pytest.raises(ModelError) as error:
            calculation()
        assert f"{path}: cannot read the wind field: No such file or directory" in str(error.value)


@needs_compiler
def test_a_file_that_changes_during_a_run(tmp_path):
    """The next block, of 50 s, is refused, not read from another realisation."""
    path = tmp_path / "a.bts"
    random_field(path, steps=1000, tower_points=200)
    plant = compiled(path)

    def write_again(t, t_end):
        if t > 30:
            os.utime(path, ns=(1, 1))

    with pytest.raises(ModelError, match="a.bts: the wind field has changed since it was opened; start the run again"):
        plant.simulate(100.0, progress=write_again)


@needs_compiler
@pytest.mark.skipif(sys.platform == "win32", reason="a path of another code page")
def test_a_path_with_blanks_and_umlauts(tmp_path):
    lookup = FieldLookup(random_field(tmp_path / 'Böen "1".bts'))
    value = field_function(lookup, 1).function([field_handle(lookup), 2.0, *CALM, 0, 1, 90]).full().ravel()
    np.testing.assert_allclose(value, lookup.velocity([(0, 1, 90)], 2.0)[0], atol=1e-12)
