"""Starts kept on disk: the same numbers to the last bit, found anew where anything that they follow from is another."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.flattening import kept
from fowtlib.language.externals import ExternalFunction
from fowtlib.language.native import compile_library, compiler
from fowtlib.solving import initial
from fowtlib.solving.known_again import kept_or_found

MODEL = "oc3_spar_rigid"  # two initial equations, 12 algebraic unknowns, 9 compiled external functions
CHOICES = {
    "nothing": {},
    "a start value": {"start": {"platform.motion.surge": 3.0}},
    "the time": {"t": 2.0},
    "a parameter": {"parameters": {"platform.hull.mass": 7.5e6}},
    "the wind": {"parameters": {"wind.mean_speed": 9.25}},
}

pytestmark = pytest.mark.skipif(not compiler(), reason="Python code is not known again by its content")


@pytest.fixture
def searched(tmp_path, monkeypatch):
    """An empty folder for what is kept, and a list that grows when a start is sought."""
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv(kept.SWITCH, raising=False)
    found, original = [], initial._solved
    monkeypatch.setattr(initial, "_solved", lambda *a: found.append(a) or original(*a))
    return found


def start_of(plant, **choice) -> bytes:
    state = plant.initial_state(**choice)
    return np.concatenate([state.x, state.z]).tobytes()


def test_a_start_is_found_once_and_is_the_same_to_the_last_bit(searched, tmp_path, monkeypatch):
    plants = [fw.load(MODEL).compile() for _ in range(2)]
    assert all(plant.dae.key for plant in plants)
    seen = {}
    for k, (what, choice) in enumerate(CHOICES.items()):
        for plant in plants:  # each makes its functions once, if at all
            plant.functions._last = plant.functions._lean = None
        seen[what] = start_of(plants[0], **choice)
        assert len(searched) == k + 1, what
        assert start_of(plants[1], **choice) == seen[what]
        assert len(searched) == k + 1, f"sought again: {what}"
    assert len(set(seen.values())) == len(CHOICES)  # each of the choices matters

    monkeypatch.setenv(kept.SWITCH, "no")
    assert start_of(fw.load(MODEL).compile()) == seen["nothing"]
    assert len(searched) == len(CHOICES) + 1
    monkeypatch.delenv(kept.SWITCH)

    for file in (tmp_path / "cache").glob("initial_*.json"):
        file.write_bytes(file.read_bytes().replace(b"1", b"2"))
    with pytest.warns(UserWarning, match="this file is damaged; it is made again"):
        assert start_of(fw.load(MODEL).compile()) == seen["nothing"]
    assert len(searched) == len(CHOICES) + 2


def test_many_starts_of_a_process_leave_one_file(searched, tmp_path):
    """A batch of cases has the functions, and writes nothing more."""
    plant = fw.load(MODEL).compile()
    for surge in (1.0, 2.0, 3.0):
        plant.initial_state(start={"platform.motion.surge": surge})
    assert len(searched) == 3 and len(list((tmp_path / "cache").glob("initial_*.json"))) == 1


def test_a_library_of_somebody_else_is_called_every_time(searched, tmp_path):
    """What it computes may change under the same path."""
    text = """
    #define casadi_int long long int
    EXPORT int twice(const double **arg, double **res, casadi_int *iw, double *w, int mem) {
        if (res[0]) res[0][0] = 2 * arg[0][0]; return 0; }
    """
    path = compile_library(text, "twice")
    assert ctypes.CDLL(str(path)).twice
    dae = fw.load(MODEL).compile().dae
    for function, times in ((dae.externals[0].function, 1), (ExternalFunction(
            "twice", {"x": 1}, {"y": 1}, library=path).function, 2)):  # fmt: skip
        calls = []
        changed = type("Changed", (), {"key": dae.key, "externals": [type("E", (), {"function": function})]})
        for _ in range(2):
            assert kept_or_found(changed, "tried", [str(times)], lambda calls=calls: calls.append(1) or 7.5) == 7.5
        assert len(calls) == times


def test_what_a_start_imports_and_reads_needs_no_scipy(tmp_path):
    """It takes longer to import than a kept model to read; see docs/performance.md."""
    command = """
import sys, fowtlib.solving.plant, fowtlib.solving.model, fowtlib.components.hydro, fowtlib.components.platform
from fowtlib.components.hydro import HydrodynamicDatabase
from fowtlib.language.netcdf_files import read_netcdf, write_netcdf, set_attributes
HydrodynamicDatabase.read(sys.argv[1])
write_netcdf(sys.argv[2], lambda file: set_attributes(file, {"title": "starts"}))
assert read_netcdf(sys.argv[2]).attributes["title"] == "starts"
print([name for name in sys.modules if name.startswith("scipy")])
"""
    data = Path(fw.__file__).parents[1] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc"
    done = subprocess.run([sys.executable, "-c", command, str(data), str(tmp_path / "made.nc")],
                          text=True, capture_output=True, check=True)  # fmt: skip
    assert done.stdout.strip() == "[]"
