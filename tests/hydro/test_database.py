"""The hydrodynamic database: checks, files, interpolation, and the physics of the shipped OC3 data."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.errors import HydrodynamicDataError

OC3 = Path(__file__).parents[2] / "models" / "data" / "oc3_hywind" / "hydrodynamics.nc"


@pytest.fixture(scope="module")
def oc3():
    return HydrodynamicDatabase.read(OC3)


def small(**changes):
    """Three frequencies of a body whose load is 1 in surge, turning with the heading."""
    omega = np.array([0.5, 1.0, 1.5])
    heading = np.radians(np.arange(-180, 181, 30.0))
    X = np.zeros((3, heading.size, 6), dtype=complex)
    X[:, :, 0] = 1j * np.array([3.0, 2.0, 0.05])[:, None] * np.cos(heading)
    X[:, :, 2] = np.array([5.0, 2.0, 0.01])[:, None]
    C = np.zeros((6, 6))
    C[2, 2] = 8.0
    eye = np.eye(6)
    fields = {
        "omega": omega,
        "heading": heading,
        "A": np.tile(2 * eye, (3, 1, 1)),
        "B": np.tile(eye, (3, 1, 1)),
        "A_inf": 1.5 * eye,
        "A_zero": None,
        "X": X,
        "C": C,
        "volume": 1e-3,
        "centre_of_buoyancy": (0, 0, -1),
        "rho": 1000,
        "g": 9.8,
        "water_depth": np.inf,
        "source": "made up",
    }
    return HydrodynamicDatabase(**fields | changes)


@pytest.mark.parametrize("zero", [None, 3 * np.eye(6)])
def test_what_is_written_is_read_again(tmp_path, zero):
    path = tmp_path / "a.nc"
    written = small(A_zero=zero)
    written.write(path)
    again = HydrodynamicDatabase.read(path)
    for name in (
        "omega",
        "heading",
        "A",
        "B",
        "A_inf",
        "X",
        "C",
        "centre_of_buoyancy",
        "volume",
        "rho",
        "g",
        "water_depth",
    ):
        np.testing.assert_array_equal(getattr(again, name), getattr(written, name))
    assert (again.A_zero is None) == (zero is None)
    assert again.source == "made up"


def test_the_file_has_units(tmp_path):
    xarray = pytest.importorskip("xarray")
    path = tmp_path / "a.nc"
    small().write(path)
    with xarray.open_dataset(path, engine="scipy") as file:
        assert file["omega"].units == "rad/s"
        assert all("units" in variable.attrs for variable in file.variables.values())


def asymmetric(n=3):
    A = np.tile(2 * np.eye(6), (n, 1, 1))
    A[1, 0, 4] = 0.5
    return A


def without_sign():
    B = np.tile(np.eye(6), (3, 1, 1))
    B[2, 2, 2] = -0.1
    return B


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"A": np.zeros((2, 6, 6))}, r"A has the shape \(2, 6, 6\), expected \(3, 6, 6\)"),
        ({"A": asymmetric()}, r"A is not symmetric at 1 rad/s: \(1, 5\) is 0.5, \(5, 1\) is 0"),
        ({"A_inf": asymmetric()[1]}, r"A_inf is not symmetric: "),
        ({"B": without_sign()}, r"radiation damping of heave is negative at 1.5 rad/s"),
        ({"C": np.full((6, 6), np.nan)}, r"C\[0, 0\] is not finite"),
        ({"omega": [1.0, 0.5, 2.0]}, "omega must be positive and rising"),
        ({"omega": [0.0, 0.5, 2.0]}, "omega must be positive and rising"),
        ({"heading": np.arange(-180, 181, 30.0)}, "must be in rad"),
        ({"volume": -1.0}, "volume must be positive"),
        ({"rho": np.inf}, "rho must be positive"),
    ],
)
def test_contradictions_are_refused(changes, message):
    with pytest.raises(HydrodynamicDataError, match=message):
        small(**changes)


def test_the_two_ends_of_a_full_turn_must_agree():
    X = np.array(small().X)
    X[:, -1] *= 2
    with pytest.raises(HydrodynamicDataError, match="same direction"):
        small(X=X)


def test_a_database_is_frozen():
    with pytest.raises(ValueError, match="read-only"):
        small().A[0, 0, 0] = 1.0


def test_damaged_files(tmp_path):
    with pytest.raises(HydrodynamicDataError, match="cannot be read"):
        HydrodynamicDatabase.read(tmp_path / "none.nc")
    path = tmp_path / "a.nc"
    path.write_text("no netCDF at all")
    with pytest.raises(HydrodynamicDataError, match=r"a.nc: not a netCDF file"):
        HydrodynamicDatabase.read(path)
    small().write(path)
    path.write_bytes(path.read_bytes()[:900])
    with pytest.raises(HydrodynamicDataError, match=r"a.nc"):
        HydrodynamicDatabase.read(path)


def test_wamit_files_become_a_database(tmp_path):
    periods, headings = [12.0, 6.0], [0.0, 45.0, 90.0]
    radiation = [f"{p} {i} {i} {1.0 + p / 100} {0.1}" for p in periods for i in range(1, 7)]
    limit = [f"0.0 {i} {i} 1.0" for i in range(1, 7)]
    loads = [f"{p} {h} {i} 1.0 90.0 0.0 1.0" for p in periods for h in headings for i in range(1, 7)]
    stiffness = [f"{i} {j} {float(i == j == 3)}" for i in range(1, 7) for j in range(1, 7)]
    stem = tmp_path / "body"
    for extension, lines in ((".1", radiation + limit), (".3", loads), (".hst", stiffness)):
        stem.with_suffix(extension).write_text("\n".join(lines))
    fields = {"volume": 1.0, "centre_of_buoyancy": (0, 0, -1), "rho": 1000.0, "g": 10.0, "water_depth": 100.0}
    data = HydrodynamicDatabase.from_wamit(stem, **fields)
    assert data.C[2, 2] == 1e4
    assert data.X[0, 0, 0] == 1e4j
    assert data.A_inf[0, 0] == 1000
    stem.with_suffix(".3").write_text("\n".join(loads).replace("12.0", "12.5"))
    with pytest.raises(HydrodynamicDataError, match="its periods .* are not those"):
        HydrodynamicDatabase.from_wamit(stem, **fields)
    stem.with_suffix(".1").write_text("\n".join(radiation))
    with pytest.raises(HydrodynamicDataError, match="no lines for infinite frequency"):
        HydrodynamicDatabase.from_wamit(stem, **fields)


def test_excitation_between_headings_and_round_the_turn():
    data = small()
    for degrees in (0.0, 12.0, 175.0, -184.0, 360.0 + 12.0):
        expected = 2j * np.cos(np.radians(degrees))
        np.testing.assert_allclose(data.excitation_at([1.0], np.radians(degrees))[0, 0], expected, atol=2e-3)
    np.testing.assert_allclose(data.excitation_at([1.0], 0.3), data.excitation_at([1.0], 0.3 + 2 * np.pi))


def test_a_fan_of_headings_is_not_extended():
    data = small()
    part = replace(data, heading=np.radians([0.0, 30, 60, 90]), X=data.X[:, 6:10])
    np.testing.assert_allclose(part.excitation_at([1.0], np.radians(45))[0, 0], 2j * np.cos(np.pi / 4), atol=0.02)
    np.testing.assert_allclose(part.excitation_at([1.0], np.radians(90))[0, 0], 0, atol=1e-12)
    with pytest.raises(HydrodynamicDataError, match="heading -10 deg is outside of the data: there is none between 90"):
        part.excitation_at([1.0], np.radians(-10))
    one = replace(data, heading=[0.0], X=data.X[:, 6:7])
    assert one.excitation_at([1.0], 2 * np.pi)[0, 0] == pytest.approx(2j)
    with pytest.raises(HydrodynamicDataError, match="outside of the data"):
        one.excitation_at([1.0], 0.1)


def test_excitation_outside_of_the_frequencies():
    data = small()
    assert data.excitation_at(0.0, 0.0)[0, 2] == pytest.approx(8.0)  # a tide: C33
    assert data.excitation_at(0.0, 0.0)[0, 0] == 0
    assert 5.0 < data.excitation_at(0.2, 0.0)[0, 2].real < 8.0
    assert np.all(data.excitation_at([1.6, 9.0], 0.0) == 0)  # the data say that the load has decayed
    X = np.array(data.X)
    X[-1, :, 2] = 1.0
    above = r"9 rad/s is above the data.*heave has not decayed there \(20%.*--omega 0.1:9:0.1"
    with pytest.raises(HydrodynamicDataError, match=above):
        replace(data, X=X).excitation_at([0.5, 9.0], 0.0)
    with pytest.raises(HydrodynamicDataError, match="not negative"):
        data.excitation_at([-1.0], 0.0)


def test_oc3_numbers_of_the_report(oc3):
    """Jonkman (2010), NREL/TP-500-47535, section 4: C33 332,941 N/m, C44 -4,999,180,000 N m/rad, 8029.21 m^3."""
    assert oc3.C[2, 2] == pytest.approx(332_941, rel=1e-5)
    assert oc3.C[3, 3] == pytest.approx(-4_999_180_000, rel=1e-5)
    assert oc3.volume == pytest.approx(8029.21)
    assert oc3.A_inf[0, 0] == pytest.approx(7.759e6, rel=1e-3)
    assert oc3.water_depth == 320


def test_oc3_hydrostatics_from_the_geometry(oc3):
    """C33 and C44 = rho g (V z_B + I_wp); the panels of the WAMIT run are 0.2 % smaller than the round spar."""
    rho_g = oc3.rho * oc3.g
    assert oc3.C[2, 2] == pytest.approx(rho_g * np.pi / 4 * 6.5**2, rel=3e-3)
    moment = oc3.volume * oc3.centre_of_buoyancy[2] + np.pi / 64 * 6.5**4
    assert oc3.C[3, 3] == pytest.approx(rho_g * moment, rel=3e-3)


def test_oc3_long_waves_lift_like_a_tide(oc3):
    X = oc3.excitation_at([0.0, 0.01, 0.05], 0.0)
    np.testing.assert_allclose(np.abs(X[:, 2]), oc3.C[2, 2], rtol=0.06)
    assert abs(X[0, 0]) == 0


@pytest.mark.parametrize(("mode", "tolerance"), [(0, 0.01), (2, 0.01), (4, 0.01)])
def test_oc3_damping_follows_from_the_excitation(oc3, mode, tolerance):
    """Haskind: B_ii = k / (8 pi rho g c_g) * integral |X_i|^2 over the heading (Falnes 2002, eq. 5.146).

    The energy that an oscillating body radiates is tied to the load of the waves on it; this ties the scales of the .1
    and .3 files, which are independent.
    """
    omega = oc3.omega
    depth, g = oc3.water_depth, oc3.g
    k = omega**2 / g
    for _ in range(200):
        k = omega**2 / (g * np.tanh(k * depth))
    group = omega / k * 0.5 * (1 + 2 * k * depth / np.sinh(np.minimum(2 * k * depth, 600)))
    mean_square = np.mean(np.abs(oc3.X[:, :-1, mode]) ** 2, axis=1) * 2 * np.pi
    damping = k / (8 * np.pi * oc3.rho * g * group) * mean_square
    exact = oc3.B[:, mode, mode]
    strong = exact > 0.2 * exact.max()
    np.testing.assert_allclose(damping[strong], exact[strong], rtol=tolerance)


def test_two_rotor_spar():
    """Computed data: geometry of the spar, long waves, and damping tied to the loads."""
    spar = HydrodynamicDatabase.read(OC3.parents[1] / "two_rotor_spar" / "hydrodynamics.nc")
    assert spar.volume == pytest.approx(11_784.0, rel=1e-5)
    assert spar.centre_of_buoyancy[2] == pytest.approx(-71.88, abs=0.01)
    assert spar.C[2, 2] == pytest.approx(4.56e5, rel=1e-3)
    assert abs(spar.X[0, 0, 2]) == pytest.approx(spar.C[2, 2], rel=0.07)
    assert spar.A_inf[0, 0] == pytest.approx(spar.rho * spar.volume, rel=0.1)  # a long cylinder: as much as its water
    np.testing.assert_array_equal(spar.A, np.swapaxes(spar.A, 1, 2))
    omega = spar.omega
    wave = (omega > 0.5) & (omega < 1.5)  # deep water
    factor = omega[wave] ** 3 / (2 * spar.rho * spar.g**3)
    for mode in (0, 4):
        mean_square = np.mean(np.abs(spar.X[wave, :-1, mode]) ** 2, axis=1)
        np.testing.assert_allclose(factor * mean_square, spar.B[wave, mode, mode], rtol=0.03)


@pytest.mark.parametrize("name", ["added_mass", "water_density", "excitation_real"])
def test_a_changed_file_is_refused_by_name(tmp_path, name):
    from scipy.io import netcdf_file

    path = tmp_path / "a.nc"
    path.write_bytes(OC3.read_bytes())
    with netcdf_file(path, "r", mmap=False) as file:
        numbers = file.variables[name].data.tobytes()
    data = bytearray(path.read_bytes())
    data[data.index(numbers) + len(numbers) // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(HydrodynamicDataError, match=rf"a.nc: the file is damaged: .* of {name} are not those"):
        HydrodynamicDatabase.read(path)


def test_a_file_of_an_earlier_version_is_read(tmp_path):
    from scipy.io import netcdf_file

    with netcdf_file(OC3, "r", mmap=False) as old, netcdf_file(tmp_path / "b.nc", "w") as new:
        for dim, size in old.dimensions.items():
            new.createDimension(dim, size)
        for name, variable in old.variables.items():
            new.createVariable(name, "f8", variable.dimensions).data[...] = variable.data
    np.testing.assert_array_equal(HydrodynamicDatabase.read(tmp_path / "b.nc").A, HydrodynamicDatabase.read(OC3).A)


@pytest.mark.parametrize(("part", "mode"), [(1.2e-3, 5), (9e-3, 2), (2e-3, 0)])
def test_a_little_negative_damping_is_warned_of(part, mode):
    """As in the published files of the VolturnUS-S: 0.12 % of the maximum in yaw, at 4.35 rad/s."""
    B = np.tile(np.eye(6), (3, 1, 1))
    B[1, mode, mode] = -part
    name = ("surge", "sway", "heave", "roll", "pitch", "yaw")[mode]
    with pytest.warns(UserWarning, match=f"damping of {name} is negative at 1 rad/s .*{part:.2g} of its maximum"):
        small(B=B)
    B[1, mode, mode] = -0.011
    with pytest.raises(HydrodynamicDataError, match=f"damping of {name} is negative at 1 rad/s"):
        small(B=B)
