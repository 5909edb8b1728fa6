"""What is written as WAMIT files is read again as the same database, in any scale; and how the lines look."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.wamit import read_excitation, read_hydrostatics, read_radiation
from fowtlib.language.errors import ModelError

DATA = Path(__file__).parents[2] / "models" / "data"
ARRAYS = ("omega", "heading", "A", "B", "A_inf", "A_zero", "X", "C")


@pytest.mark.parametrize("hull", ["oc3_hywind", "two_rotor_spar"])
@pytest.mark.parametrize("length", [1.0, 9.4])
def test_a_shipped_database_goes_round(tmp_path, hull, length):
    data = HydrodynamicDatabase.read(DATA / hull / "hydrodynamics.nc")
    written = data.to_wamit(tmp_path / "hull", length=length)
    assert [path.name for path in written] == ["hull.1", "hull.3", "hull.hst"]
    again = HydrodynamicDatabase.from_wamit(
        tmp_path / "hull", volume=data.volume, centre_of_buoyancy=data.centre_of_buoyancy, rho=data.rho, g=data.g,
        water_depth=data.water_depth, length=length,
    )  # fmt: skip
    for name in ARRAYS:
        one, two = getattr(data, name), getattr(again, name)
        np.testing.assert_allclose(two, one, rtol=2e-9, atol=1e-9 * np.abs(one).max() * 1e-6, err_msg=name)


@st.composite
def databases(draw):
    """Any numbers that a database takes: symmetric matrices with a strong diagonal, loads of any phase."""
    n, nh = draw(st.integers(2, 4)), draw(st.integers(1, 3))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    volume = 10.0 ** draw(st.floats(0, 5))

    def matrices(*shape):
        M = random.normal(size=(*shape, 6, 6))
        M = M @ np.swapaxes(M, -1, -2) + 6 * np.eye(6)
        size = np.array([1.0] * 3 + [volume ** (1 / 3)] * 3)
        return volume * 1000 * M * np.outer(size, size)

    omega = np.cumsum(random.uniform(0.05, 1.0, n))
    return HydrodynamicDatabase(
        omega=omega, heading=np.sort(random.uniform(-3, 3, nh)), A=matrices(n), B=matrices(n), A_inf=matrices(),
        A_zero=matrices() if draw(st.booleans()) else None,
        X=volume * 1e4 * (random.normal(size=(n, nh, 6)) + 1j * random.normal(size=(n, nh, 6))), C=matrices(),
        volume=volume, centre_of_buoyancy=(0.0, 0.0, -(volume ** (1 / 3))), rho=draw(st.floats(900, 1100)),
        g=draw(st.floats(9.7, 9.9)), water_depth=draw(st.sampled_from([50.0, math.inf])),
    )  # fmt: skip


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=databases(), length=st.floats(0.1, 200))
def test_any_database_goes_round(tmp_path, data, length):
    """By the readers of single files: the checks of conventions know that these hulls are none."""
    stem = tmp_path / "any"
    data.to_wamit(stem, length=length)
    radiation = read_radiation(f"{stem}.1", rho=data.rho, length=length)
    excitation = read_excitation(f"{stem}.3", rho=data.rho, g=data.g, length=length)
    C = read_hydrostatics(f"{stem}.hst", rho=data.rho, g=data.g, length=length)
    assert (radiation.A_zero is None) == (data.A_zero is None)
    pairs = [(radiation.omega, data.omega), (radiation.A, data.A), (radiation.B, data.B), (C, data.C),
             (radiation.A_inf, data.A_inf), (excitation.omega, data.omega), (excitation.heading, data.heading)]
    pairs += [(radiation.A_zero, data.A_zero)] if data.A_zero is not None else []
    for one, two in pairs:
        np.testing.assert_allclose(one, two, rtol=2e-9)
    np.testing.assert_allclose(excitation.X, data.X, atol=2e-9 * np.abs(data.X).max())


def test_the_numbers_have_no_dimension(tmp_path):
    """By hand, for OC3 with ULEN = 10 m: A11 / (rho L^3), A55 / (rho L^5), B11 / (rho L^3 omega), X5 / (rho g L^3)."""
    data = HydrodynamicDatabase.read(DATA / "oc3_hywind" / "hydrodynamics.nc")
    data.to_wamit(tmp_path / "spar", length=10.0)
    lines = (tmp_path / "spar.1").read_text().splitlines()
    zero, infinite, first = (line.split() for line in (lines[0], lines[36], lines[72]))
    assert float(zero[0]) < 0 and float(infinite[0]) == 0  # PER < 0: zero frequency, PER = 0: infinite frequency
    assert len(zero) == len(infinite) == 4 and len(first) == 5
    assert float(zero[3]) == pytest.approx(data.A_zero[0, 0] / (1025 * 1e3))
    assert float(infinite[3]) == pytest.approx(data.A_inf[0, 0] / (1025 * 1e3))
    assert float(first[0]) == pytest.approx(2 * math.pi / data.omega[0])
    assert float(first[4]) == pytest.approx(data.B[0, 0, 0] / (1025 * 1e3 * data.omega[0]))
    pitch = lines[72 + 4 * 6 + 4].split()
    assert pitch[1:3] == ["5", "5"]
    assert float(pitch[3]) == pytest.approx(data.A[0, 4, 4] / (1025 * 1e5))
    load = (tmp_path / "spar.3").read_text().splitlines()[4].split()
    period, heading, mode, modulus, phase, real, imaginary = map(float, load)
    assert (mode, heading) == (5, pytest.approx(math.degrees(data.heading[0])))
    assert real + 1j * imaginary == pytest.approx(data.X[0, 0, 4] / (1025 * data.g * 1e3))
    assert modulus * np.exp(1j * math.radians(phase)) == pytest.approx(real + 1j * imaginary)
    assert period == pytest.approx(2 * math.pi / data.omega[0])
    stiffness = (tmp_path / "spar.hst").read_text().splitlines()[14].split()
    assert stiffness[:2] == ["3", "3"] and float(stiffness[2]) == pytest.approx(data.C[2, 2] / (1025 * data.g * 1e2))


def test_what_cannot_be_written_is_said(tmp_path):
    data = HydrodynamicDatabase.read(DATA / "oc3_hywind" / "hydrodynamics.nc")
    for length in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(HydrodynamicDataError, match="the length scale of WAMIT files must be positive"):
            data.to_wamit(tmp_path / "spar", length=length)
    with pytest.raises(ModelError, match=r"absent.*: cannot be written: No such file or directory"):
        data.to_wamit(tmp_path / "absent" / "spar")
    assert not list(tmp_path.iterdir())
