"""The reader of WAMIT files: dimensions, limits of frequency, and a named error with file and line for each fault."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fowtlib.components.hydro.errors import HydrodynamicDataError
from fowtlib.components.hydro.wamit import read_excitation, read_hydrostatics, read_radiation
from fowtlib.language.errors import ModelError

RHO, G, LENGTH = 1000.0, 10.0, 2.0

RADIATION = """\
-1.0  1 1 8.0
-1.0  1 5 -2.0
-1.0  5 1 -2.0
-1.0  5 5 30.0
 0.0  1 1 7.0
 0.0  1 5 -1.0
 0.0  5 1 -1.0
 0.0  5 5 29.0
10.0  1 1 8.5  0.1
10.0  1 5 -2.1 -0.02
10.0  5 1 -2.1 -0.02
10.0  5 5 31.0 0.3
 5.0  1 1 8.6  0.5
 5.0  1 5 -2.2 -0.05
 5.0  5 1 -2.2 -0.05
 5.0  5 5 32.0 0.7
"""
EXCITATION = """\
10.0 0.0 1 2.0 90.0 0.0 2.0
10.0 0.0 5 3.0 180.0 -3.0 0.0
10.0 30.0 1 1.0 0.0 1.0 0.0
10.0 30.0 5 1.0 -90.0 0.0 -1.0
5.0 0.0 1 4.0 90.0 0.0 4.0
5.0 0.0 5 5.0 180.0 -5.0 0.0
5.0 30.0 1 1.0 0.0 1.0 0.0
5.0 30.0 5 1.0 -90.0 0.0 -1.0
"""
HYDROSTATICS = "\n".join(f"{i} {j} {10 * i + j}" for i in range(1, 7) for j in range(1, 7))


def write(folder, name, text):
    path = folder / name
    path.write_text(text)
    return path


def test_radiation_gets_the_dimensions_of_its_modes(tmp_path):
    data = read_radiation(write(tmp_path, "a.1", RADIATION), rho=RHO, length=LENGTH)
    np.testing.assert_allclose(data.omega, [2 * np.pi / 10, 2 * np.pi / 5])
    assert data.A[0, 0, 0] == pytest.approx(8.5 * RHO * LENGTH**3)
    assert data.A[0, 0, 4] == pytest.approx(-2.1 * RHO * LENGTH**4)
    assert data.A[1, 4, 4] == pytest.approx(32 * RHO * LENGTH**5)
    assert data.B[1, 4, 0] == pytest.approx(-0.05 * RHO * LENGTH**4 * 2 * np.pi / 5)
    assert data.A[:, 2, 2] == pytest.approx(0)


def test_zero_and_infinite_frequency_are_not_mixed_up(tmp_path):
    data = read_radiation(write(tmp_path, "a.1", RADIATION), rho=RHO)
    assert data.A_zero[0, 0] == pytest.approx(8 * RHO)
    assert data.A_inf[0, 0] == pytest.approx(7 * RHO)
    without = "\n".join(RADIATION.splitlines()[8:])
    data = read_radiation(write(tmp_path, "b.1", without), rho=RHO)
    assert data.A_zero is None
    assert data.A_inf is None


def test_fortran_exponents_and_windows_line_ends(tmp_path):
    path = tmp_path / "a.1"
    path.write_bytes(RADIATION.replace("8.5", "0.85D+01").replace("\n", "\r\n").encode())
    assert read_radiation(path, rho=1.0).A[0, 0, 0] == pytest.approx(8.5)


def test_excitation_is_complex_with_headings_in_radians(tmp_path):
    data = read_excitation(write(tmp_path, "a.3", EXCITATION), rho=RHO, g=G, length=LENGTH)
    np.testing.assert_allclose(data.heading, np.radians([0, 30]))
    assert data.X.shape == (2, 2, 6)
    assert data.X[0, 0, 0] == pytest.approx(2j * RHO * G * LENGTH**2)
    assert data.X[1, 0, 4] == pytest.approx(-5 * RHO * G * LENGTH**3)


def test_hydrostatics_have_the_dimensions_of_the_pair(tmp_path):
    C = read_hydrostatics(write(tmp_path, "a.hst", HYDROSTATICS), rho=RHO, g=G, length=LENGTH)
    assert C[2, 2] == pytest.approx(33 * RHO * G * LENGTH**2)
    assert C[2, 3] == pytest.approx(34 * RHO * G * LENGTH**3)
    assert C[4, 3] == pytest.approx(54 * RHO * G * LENGTH**4)


def radiation(path):
    return read_radiation(path, rho=RHO)


def excitation(path):
    return read_excitation(path, rho=RHO, g=G)


def hydrostatics(path):
    return read_hydrostatics(path, rho=RHO, g=G)


@pytest.mark.parametrize(
    ("reader", "text", "old", "new", "message"),
    [
        (radiation, RADIATION, "8.5", "8.5x", "bad.txt:9: '8.5x' is not a number"),
        (radiation, RADIATION, "8.5", "*****", "bad.txt:9: '*****' is not a number"),
        (radiation, RADIATION, "8.5", "nan", "bad.txt:9: 'nan' is not a finite number"),
        (radiation, RADIATION, "8.5  0.1", "8.5", "bad.txt:9: expected 'PER I J A B', found 4 columns"),
        (radiation, RADIATION, "10.0  1 1", "10.0  7 1", "bad.txt:9: '7' is not a mode"),
        (radiation, RADIATION, "10.0  1 5", "10.0  1 1", "bad.txt:10: the pair (1, 1) is given twice"),
        (radiation, RADIATION, "10.0  5 1 -2.1 -0.02\n", "", "the pair (5, 1) is missing for the period 10 s"),
        (radiation, RADIATION, " 0.0  5 5 29.0\n", "", "the pair (5, 5) is missing for infinite frequency"),
        (radiation, "-1 1 1 3.0\n", "3.0", "3.0", "no line with a positive period"),
        (excitation, EXCITATION, "10.0 0.0 1 2.0 90.0", "10.0 0.0 1 2.0 80.0", "bad.txt:1: modulus and phase"),
        (excitation, EXCITATION, "5.0 30.0 1 1.0 0.0 1.0 0.0\n", "", "mode 1 is missing for the period 5 s"),
        (excitation, EXCITATION, "10.0 0.0 5", "-1.0 0.0 5", "bad.txt:2: the period must be positive"),
        (excitation, EXCITATION, "10.0 0.0 5", "10.0 0.0 1", "bad.txt:2: mode 1 is given twice"),
        (excitation, EXCITATION, EXCITATION, "\n \n", "the file is empty"),
        (hydrostatics, HYDROSTATICS, "3 3 33\n", "", "1 of the 36 pairs are missing, the first is (3, 3)"),
        (hydrostatics, HYDROSTATICS, "3 3 33", "3 2 33", "bad.txt:15: the pair (3, 2) is given twice"),
        (hydrostatics, HYDROSTATICS, "3 3 33", "3 3", "bad.txt:15: expected 'I J C', found 2 columns"),
    ],
)
def test_a_fault_is_named_with_its_line(tmp_path, reader, text, old, new, message):
    assert old in text
    with pytest.raises(HydrodynamicDataError) as caught:
        reader(write(tmp_path, "bad.txt", text.replace(old, new, 1)))
    assert message in str(caught.value)


def test_a_file_that_is_not_there_or_not_text(tmp_path):
    with pytest.raises(HydrodynamicDataError, match="cannot read the WAMIT file: No such file"):
        radiation(tmp_path / "none.1")
    (tmp_path / "binary.1").write_bytes(b"\x00\x81\xff\xfe")  # in the other order it is UTF-16
    with pytest.raises(HydrodynamicDataError, match="not a text file"):
        radiation(tmp_path / "binary.1")


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_what_is_written_is_read_again(tmp_path, data):
    numbers = st.floats(-1e3, 1e3).map(lambda x: float(f"{x:.6e}"))
    periods = data.draw(st.lists(st.integers(1, 999).map(lambda n: n / 7), min_size=1, max_size=4, unique=True))
    pairs = data.draw(st.lists(st.tuples(st.integers(1, 6), st.integers(1, 6)), min_size=1, max_size=5, unique=True))
    table = {(p, pair): (data.draw(numbers), data.draw(numbers)) for p in periods for pair in pairs}
    lines = [f"{p!r} {i} {j} {a:.6E} {b:.6E}" for (p, (i, j)), (a, b) in table.items()]
    shuffled = data.draw(st.permutations(lines))
    result = read_radiation(write(tmp_path, "r.1", "\n".join(shuffled)), rho=1.0)
    for (p, (i, j)), (a, b) in table.items():
        k = int(np.argmin(np.abs(result.omega - 2 * math.pi / p)))
        assert result.A[k, i - 1, j - 1] == pytest.approx(a)
        assert result.B[k, i - 1, j - 1] / result.omega[k] == pytest.approx(b)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(which=st.sampled_from(range(3)), at=st.integers(0, 10_000), length=st.integers(0, 12), put=st.text(max_size=8))
def test_a_damaged_file_is_read_or_refused_with_a_sentence(tmp_path, which, at, length, put):
    text, reader = [(RADIATION, radiation), (EXCITATION, excitation), (HYDROSTATICS, hydrostatics)][which]
    at %= len(text)
    path = tmp_path / "damaged.txt"
    path.write_text(text[:at] + put + text[at + length :], encoding="utf-8", errors="replace", newline="")
    try:
        reader(path)
    except ModelError as error:
        assert str(error).startswith(str(path))
