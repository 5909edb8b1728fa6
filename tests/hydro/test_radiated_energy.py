"""What a body that deforms loses goes away as waves: damping against the waves that it makes, and thin plates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial import legendre

from fowtlib.components.environment.waves import wave_number
from fowtlib.components.hydro.hull_mesh import HullMesh
from tests.hydro.test_deformation import box, vertical

pytest.importorskip("capytaine")
from fowtlib.components.hydro.panel_solver import PanelSolver

G = 9.81


def shapes(length):
    """Bending upwards in halves and thirds: Legendre's polynomials 2 and 3."""
    series = [[0, 0, 1], [0, 0, 0, 1]]
    return vertical(
        [lambda x, c=c: legendre.legval(2 * x / length, c) for c in series],
        [lambda x, c=c: legendre.legval(2 * x / length, legendre.legder(c)) * 2 / length for c in series],
    )


@pytest.mark.parametrize(("sizes", "pieces", "depth", "omega"), [
    ((80.0, 10.0, 5.0), (28, 6, 4), math.inf, 0.9), ((80.0, 10.0, 5.0), (28, 6, 4), 20.0, 0.7),
    ((60.0, 20.0, 0.5), (30, 10, 1), 20.0, 0.9),
])  # fmt: skip
def test_damping_is_the_energy_that_the_waves_carry_away(sizes, pieces, depth, omega):
    """B_ij = k / (8 pi rho g c_g) times the integral of X_i X_j* over all headings, for shapes and rigid motions.

    By M.D. Haskind's relation X is the wave that a motion makes far away, and c_g the speed of its energy (J.N. Newman,
    Marine Hydrodynamics (1977), 6.18). 2 % of sqrt(B_ii B_jj); 3 % of the plate, whose panels are four times wider than
    deep (9 % with one point a panel).
    """
    hull = HullMesh(box(*sizes, pieces=pieces))
    headings = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    flow = PanelSolver(hull, depth, G, shapes(sizes[0])).solve(omega, headings)
    k = float(wave_number(omega, depth, G))
    kh = k * depth
    group = omega / k / 2 * (1 if math.isinf(depth) else 1 + 2 * kh / math.sinh(2 * kh))
    pairs = np.mean(flow.X[:, :, None] * flow.X[:, None].conj(), axis=0).real
    carried = k / (8 * np.pi * G * group) * 2 * np.pi * pairs
    kept = [2, 4, 6, 7]
    damping, carried = (matrix[np.ix_(kept, kept)] for matrix in (flow.B, carried))
    size = np.sqrt(np.diag(carried))
    wrong = np.abs(damping - carried) / np.outer(size, size)
    assert wrong.max() < (0.03 if sizes[2] < 1 else 0.02)
