"""Data in another convention than the library's are refused, with the convention that they probably follow."""

from __future__ import annotations

import contextlib
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fowtlib.components.environment.waves import wave_number
from fowtlib.components.hydro import HydrodynamicDatabase, HydrodynamicDataError
from fowtlib.components.hydro.conventions import check_conventions
from fowtlib.language.errors import ModelError

DATA = Path(__file__).parents[2] / "models" / "data"
OC3 = HydrodynamicDatabase.read(DATA / "oc3_hywind" / "hydrodynamics.nc")
TURN = np.array([0, 0, 0, 1, 1, 1])


def write(stem, data=OC3, *, first=lambda w: 2 * np.pi / w, length=1.0, head="", degrees=np.degrees, limits=(-1.0, 0.0),
          encoding="utf-8"):  # fmt: skip
    """The files .1, .3 and .hst of WAMIT, with faults on demand; `first` makes the first column."""
    scale = data.rho * length ** (3 + TURN[:, None] + TURN)
    pairs = [(i, j) for i in range(6) for j in range(6) if abs(data.A_inf[i, j]) > 1]
    radiation = [f"{tag} {i + 1} {j + 1} {(M / scale)[i, j]:.6e}"
                 for tag, M in zip(limits, (data.A_zero, data.A_inf), strict=True) if tag is not None
                 for i, j in pairs]  # fmt: skip
    waves = []
    for n, w in enumerate(data.omega):
        A, B = data.A[n] / scale, data.B[n] / scale / w
        radiation += [f"{first(w):.6e} {i + 1} {j + 1} {A[i, j]:.6e} {B[i, j]:.6e}" for i, j in pairs]
        loads = data.X[n] / (data.rho * data.g * length ** (2 + TURN))
        waves += [f"{first(w):.6e} {degrees(beta):.6e} {m + 1} {abs(x):.6e} {np.degrees(np.angle(x)):.6e} "
                  f"{x.real:.6e} {x.imag:.6e}"
                  for beta, load in zip(data.heading, loads, strict=True) for m, x in enumerate(load)]  # fmt: skip
    C = data.C / (data.rho * data.g * length ** (2 + TURN[:, None] + TURN))
    stiffness = [f"{i + 1} {j + 1} {C[i, j]:.6e}" for i in range(6) for j in range(6)]
    for ending, lines in ((".1", radiation), (".3", waves), (".hst", stiffness)):
        Path(f"{stem}{ending}").write_text(head + "\n".join(lines) + "\n", encoding=encoding)


def read(stem, **changes):
    given = {"volume": OC3.volume, "centre_of_buoyancy": OC3.centre_of_buoyancy, "rho": OC3.rho, "g": OC3.g,
             "water_depth": OC3.water_depth}  # fmt: skip
    return HydrodynamicDatabase.from_wamit(stem, **{**given, **changes})


def from_files(folder, **faults):
    write(folder / "spar", **faults)
    return read(folder / "spar")


# --- the limit -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["oc3_hywind", "two_rotor_spar"])
def test_shipped_data_have_the_limit_of_long_waves(name):
    data = HydrodynamicDatabase.read(DATA / name / "hydrodynamics.nc")
    k = float(wave_number(data.omega[0], data.water_depth, data.g))
    ahead = int(np.abs(data.heading).argmin())
    limit = 1j * data.g * k * (data.rho * data.volume + data.A_zero[0, 0])
    assert data.X[0, ahead, 0] / limit == pytest.approx(1.0, abs=0.02)
    assert data.X[0, ahead, 2] / data.C[2, 2] == pytest.approx(1.0, abs=0.06)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_conventions(data)


def test_true_files_are_read_without_a_word(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = from_files(tmp_path)
    np.testing.assert_allclose(data.X, OC3.X, atol=1e-5 * np.abs(OC3.X).max())


def test_the_length_scale_of_the_run_is_the_remedy(tmp_path):
    write(tmp_path / "spar", length=3.2)
    np.testing.assert_allclose(read(tmp_path / "spar", length=3.2).A, OC3.A, rtol=1e-5, atol=1e3)


# --- other conventions in WAMIT files --------------------------------------------------------------------------------

FILES = {
    "conjugated": ({"data": replace(OC3, X=OC3.X.conj())}, r"exp\(-i omega t\)"),
    "waves from the heading": ({"degrees": lambda b: np.degrees(b) + 180}, "from which the waves come"),
    "rad/s": ({"first": lambda w: w}, "must be the period .IPEROUT = 1."),
    "Hz": ({"first": lambda w: w / (2 * np.pi)}, "frequencies in Hz: write the periods"),
    "ULEN 3.2": ({"length": 3.2}, "another length scale: they fit with a ULEN of about 3"),
    "ULEN 10": ({"length": 10.0}, "another length scale: they fit with a ULEN of about 1[01]"),
    "ULEN 0.5": ({"length": 0.5}, "another length scale: they fit with a ULEN of about 0.5"),
    "heading in rad": ({"degrees": lambda b: b}, "headings are in rad where degrees"),
    "heading clockwise": ({"degrees": lambda b: -np.degrees(b)}, "headings turn the wrong way"),
    "heading from y": ({"degrees": lambda b: 90 - np.degrees(b)}, "headings count from the y axis"),
    "limits": ({"limits": (0.0, -1.0)}, "zero and at infinite frequency are mixed up"),
}


@pytest.mark.parametrize("name", FILES)
def test_files_in_another_convention_are_refused_with_its_name(tmp_path, name):
    faults, message = FILES[name]
    with pytest.raises(HydrodynamicDataError, match=message) as caught:
        from_files(tmp_path, **faults)
    assert str(tmp_path / "spar") in str(caught.value)


def test_files_without_the_infinite_frequency_are_refused(tmp_path):
    with pytest.raises(HydrodynamicDataError, match=r"no lines for infinite frequency \(PER = 0\)"):
        from_files(tmp_path, limits=(-1.0, None))


def test_an_added_mass_that_is_not_symmetric_is_refused(tmp_path):
    A = OC3.A.copy()
    A[:, 0, 4] *= -1
    for name in ("A", "A_inf", "A_zero"):
        M = np.array(getattr(OC3, name))
        M[..., 0, 4] *= -1
        with pytest.raises(HydrodynamicDataError, match=rf"{name} is not symmetric.*\(1, 5\) is .*\(5, 1\) is"):
            replace(OC3, **{name: M})


@pytest.mark.parametrize("head", [" header of a run\n", "OC3 Hywind 2009, ULEN 1\n", "PER I J A B\r\n"])
def test_a_header_line_is_skipped(tmp_path, head):
    np.testing.assert_allclose(from_files(tmp_path, head=head).omega, OC3.omega, rtol=1e-5)


@pytest.mark.parametrize("head", ["", "header of a run\n"])
def test_a_byte_order_mark_is_skipped(tmp_path, head):
    np.testing.assert_allclose(from_files(tmp_path, head=head, encoding="utf-8-sig").omega, OC3.omega, rtol=1e-5)


def test_a_second_header_line_and_a_broken_first_line_are_named(tmp_path):
    with pytest.raises(HydrodynamicDataError, match="spar.1:2: 'and' is not a number"):
        from_files(tmp_path, head="header of a run\nand another line\n")
    with pytest.raises(HydrodynamicDataError, match="spar.1:1: 'x' is not a number"):
        from_files(tmp_path, head="1.0 1 x 3.0 4.0\n")


# --- other conventions in any source ---------------------------------------------------------------------------------


def swapped(*order):
    return {"X": OC3.X[:, :, list(order)]}


def about(height):
    """Moments of the waves about z = height."""
    X = OC3.X.copy()
    X[:, :, 4] -= height * X[:, :, 0]
    X[:, :, 3] += height * X[:, :, 1]
    return {"X": X}


def whole_about(height):
    """Loads, matrices and stiffness alike about z = height."""
    T = np.eye(6)
    T[0, 4], T[1, 3] = height, -height  # velocity of the origin from that of the point
    fields = {name: T.T @ getattr(OC3, name) @ T for name in ("A", "B", "A_inf", "A_zero")}
    return {**fields, **about(height), **stiffness_about(height)}


def stiffness_about(height):
    C = OC3.C.copy()
    C[[3, 4], [3, 4]] -= OC3.rho * OC3.volume * OC3.g * height
    return {"C": C}


CHANGES = {
    "omega in Hz": ({"omega": OC3.omega / (2 * np.pi)}, "omega is in Hz"),
    "surge and heave": (swapped(2, 1, 0, 3, 4, 5), "stand in the order heave, sway, surge, roll, pitch, yaw"),
    "y up": (swapped(0, 2, 1, 3, 5, 4), "stand in the order surge, heave, sway, roll, yaw, pitch"),
    "roll and pitch": (swapped(0, 1, 2, 4, 3, 5), "stand in the order surge, sway, heave, pitch, roll, yaw"),
    "about the centre of mass": (about(-78.0), "moments of the waves are about a point at z = -7"),
    "about the hub": (about(90.0), "moments of the waves are about a point at z = (8|9)"),
    "per wave height": ({"X": 2 * OC3.X}, "per wave height"),
    "kN": ({"X": OC3.X / 1000}, "in kN"),
    "stiffness about the hub": (stiffness_about(90.0), "stiffness of roll.*less than the moment of buoyancy alone"),
    "all about the hub": (whole_about(90.0), "stiffness of roll.*less than the moment of buoyancy alone"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_netcdf_file_in_another_convention_is_refused(tmp_path, name):
    changes, message = CHANGES[name]
    path = tmp_path / "spar.nc"
    replace(OC3, **changes).write(path)
    with pytest.raises(HydrodynamicDataError, match=message) as caught:
        HydrodynamicDatabase.read(path)
    assert str(caught.value).startswith(str(path))


def test_periods_in_a_netcdf_file_are_refused(tmp_path):
    back = slice(None, None, -1)
    data = replace(OC3, omega=2 * np.pi / OC3.omega[back], A=OC3.A[back], B=OC3.B[back], X=OC3.X[back])
    data.write(tmp_path / "spar.nc")
    with pytest.raises(HydrodynamicDataError, match="omega of a netCDF file must be in rad/s"):
        HydrodynamicDatabase.read(tmp_path / "spar.nc")


def test_data_that_fit_no_convention_are_warned_of_with_the_numbers():
    X = OC3.X.copy()
    X[:, :, 0] *= 3
    with pytest.warns(UserWarning, match=r"not have its limit for long waves.*X1 is .*; the limit for long waves is"):
        check_conventions(replace(OC3, X=X))


@pytest.mark.parametrize("make", [whole_about, stiffness_about])
def test_data_about_a_point_in_the_deep_are_warned_of_or_refused(make):
    """Nothing but the breadth of the waterplane tells that all is about the centre of mass, or has the weight in it."""
    with pytest.warns(UserWarning, match="waterplane has a gyration radius of 1.. m"), contextlib.suppress(ModelError):
        check_conventions(replace(OC3, **make(-78.0)))


def test_data_without_long_waves_are_not_judged():
    short = slice(20, None)
    data = replace(OC3, omega=OC3.omega[short], A=OC3.A[short], B=OC3.B[short], X=OC3.X[short])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_conventions(data)


def test_panel_results_are_checked_too(monkeypatch):
    pytest.importorskip("capytaine")
    from fowtlib.components.hydro import panel

    column = panel.Column(((-20.0, 10.0), (5.0, 10.0)))
    options = {"omega": [0.15, 0.3, 0.6], "headings": [0.0, 0.5], "panel_size": 2.5}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        panel.compute([column], **options)
    solve = panel.PanelSolver.solve

    def other_sign_in_time(self, *arguments):
        flow = solve(self, *arguments)
        return replace(flow, X=flow.X.conj())

    monkeypatch.setattr(panel.PanelSolver, "solve", other_sign_in_time)
    with pytest.raises(HydrodynamicDataError, match=r"exp\(-i omega t\)"):
        panel.compute([column], **options)
