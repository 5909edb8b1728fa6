"""The equations of an FMU for processors with wider vectors: the same numbers as those for any processor."""

from __future__ import annotations

import ctypes
import subprocess

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.fmi.binaries import host
from fowtlib.fmi.c_text import c_sources
from fowtlib.fmi.variables import Settings, Variables
from fowtlib.language.native import compiler
from fowtlib.language.processor import lanes_here

linux = pytest.mark.skipif(host() != "linux64" or not compiler(), reason="compiles with gcc or clang for Linux")

LOOK = """typedef void (*equation)(const double *, const double *, const double *, const double *, const double *,
                         double *, double *, double *);
void wide_equations(const equation **inputs, equation *residual, const equation **pieces);
EXPORTED int look(int wide, int level, const double *t, const double *x, const double *z, const double *q,
                  const double *w, double *first, double *second, double *scratch) {
  const equation *inputs = any_inputs, *pieces = 0;
  equation residual = model;
  if (wide) wide_equations(&inputs, &residual, &pieces);
  (level < LEVELS ? inputs[level] : residual)(t, x, z, q, w, first, second, scratch);
  return residual != model && inputs != any_inputs && pieces;
}
"""


@linux
def test_the_equations_in_wider_vectors_give_the_same_numbers(tmp_path):
    """On a processor that has them; bit for bit, of the turbine with rigid blades near its start."""
    plant = fw.load("oc3_spar_rigid").compile()
    dae, state, random = plant.dae, plant.initial_state(), np.random.default_rng(4)
    sources = c_sources(Variables(plant, state, Settings(0.01, 0.8, 1e-6, 10.0, 0.1)), state, 3, ("rigid", "@"))
    levels = [f"level_{k}" for k in range(len(dae.levels))]
    arguments = ", ".join([*5 * ["const double *"], *3 * ["double *"]])
    look = "".join(f"void {name}({arguments});\n" for name in [*levels, "model"])
    head, rest = LOOK.split("EXPORTED", 1)
    look += f"{head}static const equation any_inputs[] = {{{', '.join(levels)}}};\n#define LEVELS {len(levels)}\n{rest}"
    for name, text in {**sources.files, "look.c": look}.items():
        (tmp_path / name).write_text(text)
    units = [str(tmp_path / name) for name in ("equations.c", "equations_wide.c", "look.c")]
    flags = ["-std=c11", "-O1", "-fPIC", "-shared", "-ffp-contract=off"]
    subprocess.run([*compiler(), *flags, *units, "-o", str(tmp_path / "look.so"), "-lm"], check=True)
    library = ctypes.CDLL(str(tmp_path / "look.so"))
    point = [np.array([state.t]), state.x, state.z, plant.at().whole(np.concatenate([state.u, state.d]))]
    point.append(random.normal(size=dae.w.shape[0]))
    sizes = [*((y.shape[0], 1) for y in dae.level_inputs), (dae.x.shape[0], dae.z.shape[0])]
    found = []
    for wide in (0, 1):
        scratch = np.full(20_000, np.nan)
        found.append([[np.full(size, np.nan) for size in pair] for pair in sizes])
        for level, pair in enumerate(found[-1]):
            given = [ctypes.c_void_p(array.ctypes.data) for array in (*point, *pair, scratch)]
            other = library.look(wide, level, *given)
            assert bool(other) == (wide == 1 and lanes_here() >= 4)
    for one, other in zip(*found, strict=True):
        for mine, theirs in zip(one, other, strict=True):
            np.testing.assert_array_equal(mine, theirs)
    assert np.isfinite(found[0][-1][0]).all() and np.abs(found[0][-1][1]).max() > 0
