"""The flow about a deforming barge, against published results of WAMIT."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial import legendre

from fowtlib.components.hydro.deformation import Field, shape_stiffness
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.members import MemberShape
from fowtlib.language.netcdf_files import add_variable, read_netcdf, write_netcdf
from tests.hydro.test_deformation import box, vertical

pytest.importorskip("capytaine")
from fowtlib.components.hydro.panel import solve_shapes

# WEC-Sim_Applications, Generalized_Body_Modes (Apache-2.0), WAMIT 7.2: barge of 80 x 10 x 5 m, g 9.81, rho 1000, deep
# water; two bending modes of Ansys as series of Legendre (within 1 % of the points between the ends)
SERIES = (
    [-0.00092, 0, 1.18699, 0, -0.15185, 0, 0.00042, 0, -0.01531],
    [0, -0.02265, 0, 1.47229, 0, -0.43839, 0, 0.03264],
)
RHO, G = 1000.0, 9.81


def bending():
    shapes = [lambda x, c=c: legendre.legval(x / 40, c) for c in SERIES]
    slopes = [lambda x, c=c: legendre.legval(x / 40, legendre.legder(c)) / 40 for c in SERIES]
    return vertical(shapes, slopes)


def test_stiffness_is_that_of_wamit():
    found = shape_stiffness(box(pieces=(60, 6, 4)), bending())
    assert np.diag(found.among) == pytest.approx([227.747, 262.456], rel=0.01)
    # what is left of integrals of 20,000 and 400: good to 1 % of what the series leaves out (the points give 220.34)
    assert found.with_rigid[0, 2] == pytest.approx(-0.479, abs=0.3)
    assert found.with_rigid[1, 4] == pytest.approx(220.49, abs=25)
    assert found.with_rigid[0, 4] == pytest.approx(0, abs=1e-6)


@pytest.fixture(scope="module")
def barge():
    x = np.linspace(-40, 40, 41)
    nodes = np.column_stack([x, 0 * x, 0 * x])
    shapes = np.zeros((2, 41, 6))
    shapes[:, :, 2] = [legendre.legval(x / 40, c) for c in SERIES]
    hull = HullMesh(box(pieces=(36, 8, 5)))
    return solve_shapes(hull, bending(), nodes, shapes, omega=2 * math.pi / np.array([12.0, 6.0]), headings=[0.0],
                        rho=RHO, g=G)  # fmt: skip


def test_added_mass_damping_and_loads_are_those_of_wamit(barge):
    """2 % of A and X; damping 3 %."""
    assert barge.A[:, 2, 2] / RHO == pytest.approx([5707.0, 3177.6], rel=0.02)
    assert barge.A[:, 6, 6] / RHO == pytest.approx([1125.5, 884.96], rel=0.02)
    assert barge.B[:, 6, 6] / RHO / barge.omega == pytest.approx([11.23, 308.2], rel=0.03)
    loads = np.abs(barge.X[:, 0]) / (RHO * G)
    assert loads[:, 2] == pytest.approx([447.9, 57.20], rel=0.02)
    assert loads[:, 6] == pytest.approx([48.10, 72.97], rel=0.02)
    assert loads[1, 7] == pytest.approx(96.99, rel=0.02)
    assert barge.A_inf[6, 6] / RHO == pytest.approx(933.73, rel=0.02)


def test_motions_are_those_of_wamit(barge):
    """Modal mass and stiffness of the same source; heave, pitch and bending in waves of 12 s and 6 s."""
    mass = np.diag([4e6, 4e6, 4e6, 1e8, 4e6 * 80**2 / 12, 1e9, 1.079216e6, 1.209976e6])
    stiffness = np.diag([0.0, 0, 0, 0, 0, 0, 6.077064e6, 4.382532e7])
    stiffness[:6, :6] += barge.C
    stiffness[6:, 6:] += barge.among
    stiffness[6:, :6] += barge.with_rigid
    stiffness[:6, 6:] += barge.with_rigid.T
    kept = [2, 4, 6, 7]
    for k, expected in enumerate([(0.83481, 0.02563, 0.07550, 0.01423), (0.40828, 0.00755, 0.12338, 0.02482)]):
        w = barge.omega[k]
        dynamic = -(w**2) * (mass + barge.A[k]) + 1j * w * barge.B[k] + stiffness
        found = np.abs(np.linalg.solve(dynamic[np.ix_(kept, kept)], barge.X[k, 0, kept]))
        assert found[0] == pytest.approx(expected[0], rel=0.02)
        assert found[2] == pytest.approx(expected[2], rel=0.03)


def test_wet_frequencies_are_those_of_wamit(barge):
    """Coupled, with the added mass at infinite frequency: 2.032 rad/s of the first bending by the same source."""
    mass = np.diag([4e6, 4e6, 4e6, 6.666667e7, 2.166667e9, 2.166667e9, 1.079216e6, 1.209976e6])
    stiffness = np.diag([0.0, 0, 0, 0, 0, 0, 6.077064e6, 4.382532e7])
    stiffness[:6, :6] += barge.C
    stiffness[6:, 6:] += barge.among
    stiffness[6:, :6] += barge.with_rigid
    stiffness[:6, 6:] += barge.with_rigid.T
    kept = [2, 4, 6, 7]
    squares = np.linalg.eigvals(
        np.linalg.solve((mass + barge.A_inf)[np.ix_(kept, kept)], stiffness[np.ix_(kept, kept)])
    )
    found = np.sqrt(np.sort(squares.real))
    assert found[2] == pytest.approx(2.032, rel=0.01)
    assert found[3] == pytest.approx(4.595, rel=0.02)


def test_a_slender_column_in_water_slows_down_as_its_strips_say():
    """A cantilever from the sea bed to the water level: omega / sqrt(1 + rho C_a A / m) with C_a = 1, towards rest.

    There the water level is a wall, and the strips at it are like the others; 3 m on 60 m.
    """
    sizes = ((3.0, 3.0),) * 2
    column = MemberShape("column", (0, 0, -60.0), (0, 0, 5.0), (0.0, 65.0), sizes, True, (0.05, 0.05), 7850.0)
    hull = Hull((column,))
    root = 1.8751041
    share = (math.cosh(root) + math.cos(root)) / (math.sinh(root) + math.sin(root))

    def shape(z):
        s = root * (z + 60) / 60
        return (np.cosh(s) - np.cos(s) - share * (np.sinh(s) - np.sin(s))) / 2

    def deform(points):
        moved, gradient = np.zeros((1, len(points), 3)), np.zeros((1, len(points), 3, 3))
        z = points[:, 2]
        moved[0, :, 0] = shape(z)
        gradient[0, :, 0, 2] = (shape(z + 1e-4) - shape(z - 1e-4)) / 2e-4
        return Field(moved, gradient)

    nodes = np.column_stack([0 * np.arange(7), 0 * np.arange(7), np.linspace(-60, 0, 7)])
    shapes = np.zeros((1, 7, 6))
    shapes[0, :, 0] = shape(nodes[:, 2])
    mesh = HullMesh(hull.panels(1.5), hull.lids(1.5), join=1e-3)
    found = solve_shapes(mesh, deform, nodes, shapes, omega=[0.3, 0.6], headings=[0.0], rho=RHO, g=G)
    z = np.linspace(-60, 0, 2001)
    steel, section = 3000.0, mesh.volume / 60  # kg/m of the column; area of the meshed section
    dry, wet = (np.trapezoid(per_length * shape(z) ** 2, z) for per_length in (steel, RHO * section))
    assert math.sqrt((dry + wet) / (dry + found.A_zero[6, 6])) == pytest.approx(1, abs=0.02)
    assert found.A_zero[6, 6] == pytest.approx(wet, rel=0.05)


def test_a_file_comes_back_and_mistakes_are_told(barge, tmp_path):
    barge.write(tmp_path / "barge.nc")
    again = ModalDatabase.read(tmp_path / "barge.nc")
    for name in ("A", "B", "X", "among", "shapes", "nodes"):
        assert np.array_equal(getattr(again, name), getattr(barge, name))
    barge.rigid.write(tmp_path / "rigid.nc")
    with pytest.raises(HydrodynamicDataError, match="coefficients of a rigid hull"):
        ModalDatabase.read(tmp_path / "rigid.nc")


@pytest.mark.parametrize(("law", "told"), [(None, "too stiff in deep water. Make it anew"), (1.0, "too stiff"),
                                           (3.0, "this version of fowtlib knows 2 at most")])  # fmt: skip
def test_a_file_of_another_law_of_stiffness_is_refused(barge, tmp_path, law, told):
    """One without a number is of the first law, which let points of a section go straight on."""
    barge.write(tmp_path / "now.nc")
    known = read_netcdf(tmp_path / "now.nc")
    assert known.variables["stiffness_law"].values == 2

    def fill(file):
        for name, variable in known.variables.items():
            if name != "stiffness_law":
                add_variable(
                    file, name, "d", tuple(f"{name}_{k}" for k in range(variable.values.ndim)), variable.values
                )
        if law is not None:
            add_variable(file, "stiffness_law", "d", (), law)

    write_netcdf(tmp_path / "other.nc", fill)
    with pytest.raises(HydrodynamicDataError, match=f"other.nc: .*{told}"):
        ModalDatabase.read(tmp_path / "other.nc")
