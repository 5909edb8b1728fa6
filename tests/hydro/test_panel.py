"""Panel meshes (always) and the panel method against WAMIT (only with the extra `fowtlib[hydro]`)."""

import importlib.util
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fowtlib.components.hydro.database import HydrodynamicDatabase
from fowtlib.components.hydro.errors import HydrodynamicDataError, MissingExtraError
from fowtlib.components.hydro.panel import Column, Pontoon, compute
from fowtlib.components.hydro.panel_mesh import floater_mesh, hydrostatics, round_factor
from fowtlib.language.errors import ModelError, ParameterError

DATA = Path(__file__).parents[2] / "models" / "data"
OC3 = Column(((-120.0, 9.4), (-12.0, 9.4), (-4.0, 6.5), (10.0, 6.5)))
needs_capytaine = pytest.mark.skipif(importlib.util.find_spec("capytaine") is None, reason="needs fowtlib[hydro]")


def test_the_oc3_spar_has_its_volume_with_few_panels():
    volume, centre, C = hydrostatics(floater_mesh([OC3], [], 4.0))
    assert volume == pytest.approx(8029.21, rel=1e-6)
    np.testing.assert_allclose(centre, [0, 0, -62.0657], atol=1e-4)
    assert C[2, 2] == pytest.approx(np.pi / 4 * 6.5**2)
    assert C[3, 3] == pytest.approx(volume * centre[2] + np.pi / 64 * 6.5**4, rel=1e-5)


def triangle(**section):
    """Three columns of 12 m diameter with pontoons between them."""
    angles = np.radians([0, 120, 240])
    columns = [Column(((-20.0, 12.0), (12.0, 12.0)), x=30 * np.cos(a), y=30 * np.sin(a)) for a in angles]
    z = -18.0 if "width" in section else -15.0
    ends = [(c.x, c.y, z) for c in columns]
    return columns, [Pontoon(ends[i], ends[(i + 1) % 3], **section) for i in range(3)]


@pytest.mark.parametrize("section", [{"width": 4.0, "height": 4.0}, {"diameter": 4.0}])
def test_pontoons_close_with_the_columns(section):
    columns, pontoons = triangle(**section)
    volume, centre, C = hydrostatics(floater_mesh(columns, pontoons, 2.0))  # refuses an open hull
    across = np.linspace(-2, 2, 4001)
    height = 4.0 if "width" in section else 2 * np.sqrt(4 - across**2)
    outside = np.trapezoid((30 * np.sqrt(3) - 2 * np.sqrt(36 - across**2)) * height, across)
    assert volume == pytest.approx(3 * np.pi * 36 * 20 + 3 * outside, rel=1e-3)
    np.testing.assert_allclose(centre[:2], 0, atol=1e-3)
    waterplane = 3 * np.pi * (36 * 30**2 / 2 + 6**4 / 4)
    assert C[3, 3] == pytest.approx(waterplane + volume * centre[2], rel=5e-3)
    assert C[4, 4] == pytest.approx(C[3, 3], rel=1e-3)


def test_pontoons_of_a_central_column_with_free_ends():
    """A tension leg hull: column 16 m, draft 43 m, three pontoons 6 m square to 32.5 m, flush with the bottom."""
    reach = [(32.5 * np.cos(a), 32.5 * np.sin(a), -40.0) for a in np.radians([180, 60, -60])]
    pontoons = [Pontoon((0, 0, -40), end, width=6.0, height=6.0) for end in reach]
    volume, *_ = hydrostatics(floater_mesh([Column(((-43.0, 16.0), (10.0, 16.0)))], pontoons, 2.5))
    across = np.linspace(-3, 3, 4001)
    outside = 3 * 6 * np.trapezoid(32.5 - np.sqrt(64 - across**2), across)
    assert volume == pytest.approx(np.pi * 64 * 43 + outside, rel=1e-3)


@settings(max_examples=25, deadline=None)
@given(
    draft=st.floats(2, 150),
    bottom=st.floats(1, 30),
    top=st.floats(1, 30),
    part=st.floats(0.1, 0.9),
    size=st.floats(0.7, 5),
    x=st.floats(-50, 50),
)
def test_a_tapered_column_has_its_volume(draft, bottom, top, part, size, x):
    column = Column(((-draft, bottom), (-part * draft, top), (5.0, top)), x=x)
    volume, centre, C = hydrostatics(floater_mesh([column], [], size * max(1.0, draft / 30)))
    cone = np.pi / 12 * (1 - part) * draft * (bottom**2 + bottom * top + top**2)
    assert volume == pytest.approx(cone + np.pi / 4 * top**2 * part * draft, rel=1e-6)
    assert centre[0] == pytest.approx(x, abs=1e-6)
    assert C[2, 2] == pytest.approx(np.pi / 4 * top**2)
    assert C[2, 4] == pytest.approx(-x * C[2, 2], abs=1e-6 * C[2, 2])  # the same micrometre as the centre


def test_a_submerged_column_with_a_step():
    volume, centre, C = hydrostatics(floater_mesh([Column(((-20, 9.0), (-15, 9.0), (-15, 5.0), (-5, 5.0)))], [], 1.5))
    parts = np.pi / 4 * np.array([9.0**2 * 5, 5.0**2 * 10])
    assert volume == pytest.approx(parts.sum(), rel=1e-6)
    assert centre[2] == pytest.approx(parts @ [-17.5, -10] / parts.sum(), rel=1e-6)
    assert C[2, 2] == pytest.approx(0, abs=1e-6)


def test_normals_point_into_the_water():
    panels = floater_mesh([OC3], [], 4.0)
    normal = np.cross(panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 1])
    outwards = panels.mean(axis=1) * [1, 1, 0]
    assert ((normal * outwards).sum(axis=1) > -1e-9).all()
    assert normal[:, 2].sum() < 0


def test_a_polygon_gets_the_area_of_its_circle():
    assert round_factor(24) ** 2 * 12 * np.sin(2 * np.pi / 24) == pytest.approx(np.pi)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Column(((1.0, 5.0), (3.0, 5.0))), "column: sections must be"),
        (lambda: Column(((-9.0, 5.0), (-10.0, 5.0))), "column: sections must be"),
        (lambda: Pontoon((0, 0, -5), (9, 0, -5), width=3.0), "either width and height, or diameter"),
        (lambda: Pontoon((0, 0, -5), (9, 0, -6), diameter=2.0), "must be horizontal"),
        (lambda: Pontoon((0, 0, -1), (9, 0, -1), diameter=2.0), "must lie below the water"),
        (lambda: floater_mesh([OC3], [Pontoon((0, 0, -9), (20, 0, -9), width=3, height=3)], 2.0), "constant diameter"),
        (lambda: floater_mesh([OC3], [Pontoon((0, 0, -50), (20, 0, -50), width=9.6, height=3)], 2.0), "wider than 9.6"),
        (
            lambda: floater_mesh([OC3], [Pontoon((0, 0, -50), (20, y, -50), width=5, height=3) for y in (0, 8)], 2.0),
            "overlap",
        ),
    ],
)
def test_what_cannot_be_meshed_is_said(make, message):
    with pytest.raises(ParameterError, match=message):
        make()


def test_without_capytaine_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "capytaine", None)
    with pytest.raises(MissingExtraError, match=r'pip install "fowtlib\[hydro\]"'):
        compute([OC3], omega=[1.0, 2.0], headings=[0.0])


@needs_capytaine
def test_the_oc3_spar_against_wamit(tmp_path):
    """Coarse (512 panels): added mass 3 to 6 % high (0.6 to 1.2 % with 2750 panels), loads of long waves within 2 %."""
    wamit = HydrodynamicDatabase.read(DATA / "oc3_hywind" / "hydrodynamics.nc")
    pick = [1, 9, 19]  # 0.1, 0.5, 1 rad/s
    panel = compute([OC3], omega=wamit.omega[pick], headings=np.radians([0, 30, 90]), water_depth=320.0, panel_size=3.0)
    panel.write(tmp_path / "spar.nc")
    panel = HydrodynamicDatabase.read(tmp_path / "spar.nc")
    assert panel.volume == pytest.approx(wamit.volume, rel=1e-6)
    np.testing.assert_allclose(np.diag(panel.C), np.diag(wamit.C), rtol=3e-3)
    for i, j in ((0, 0), (1, 1), (2, 2), (3, 3), (4, 4), (0, 4), (1, 3)):
        np.testing.assert_allclose(panel.A[:, i, j], wamit.A[pick, i, j], rtol=0.06)
        assert panel.A_inf[i, j] == pytest.approx(wamit.A_inf[i, j], rel=0.06)
        assert panel.A_zero[i, j] == pytest.approx(wamit.A_zero[i, j], rel=0.06)
    for i in (0, 2, 4):
        np.testing.assert_allclose(panel.B[:, i, i], wamit.B[pick, i, i], rtol=0.06)
    for k, degrees in enumerate((0, 30, 90)):
        h = int(np.argmin(np.abs(wamit.heading - np.radians(degrees))))
        size = np.abs(wamit.X[pick]).max(axis=1)
        assert (np.abs(panel.X[:, k, :5] - wamit.X[pick, h, :5]) < 0.04 * size[:, :5]).all()


@needs_capytaine
def test_a_symmetric_floater_of_several_columns():
    """Three columns: surge and sway alike, no coupling of heave with the rest, damping tied to the loads (Haskind)."""
    columns, pontoons = triangle(width=4.0, height=4.0)
    headings = np.radians(np.arange(0, 360, 40.0))
    omega = 0.6
    data = compute(columns, pontoons, omega=[0.5, omega], headings=headings, panel_size=5.0)
    A = data.A[1]
    assert A[1, 1] == pytest.approx(A[0, 0], rel=0.02)
    assert A[4, 4] == pytest.approx(A[3, 3], rel=0.02)
    assert A[0, 4] == pytest.approx(-A[1, 3], rel=0.02)
    np.testing.assert_array_equal(A, A.T)
    assert abs(A[0, 2]) < 0.01 * A[0, 0]
    k = omega**2 / data.g
    for mode in (0, 4):  # heave all but cancels at this frequency
        damping = k / (8 * np.pi * data.rho * data.g * data.g / (2 * omega))
        damping *= 2 * np.pi * np.mean(np.abs(data.X[1, :, mode]) ** 2)
        assert damping == pytest.approx(data.B[1, mode, mode], rel=0.05)


@needs_capytaine
def test_frequencies_out_of_range_are_refused():
    with pytest.raises(HydrodynamicDataError, match="at least 0.04"):
        compute([OC3], omega=[0.01, 1.0], headings=[0.0], water_depth=320.0)


BUOY = Column(((-10.0, 8.0), (4.0, 8.0)))
COARSE = {"omega": [0.4, 0.6, 0.8], "headings": [0.0, 0.5], "water_depth": 100.0, "panel_size": 2.5}


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    """An empty folder for what is kept."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("FOWTLIB_CACHE", str(folder))
    return folder


@pytest.fixture
def solved(monkeypatch):
    """Frequencies [rad/s] that Capytaine is asked to solve, in this order; stops at those in the list's `stop_at`."""
    capytaine = pytest.importorskip("capytaine")

    class Frequencies(list):
        stop_at = ()

    frequencies = Frequencies()
    original = capytaine.BEMSolver.solve_all

    def solve_all(self, problems, **options):
        if problems[0].omega in frequencies.stop_at:
            raise KeyboardInterrupt
        frequencies.append(float(problems[0].omega))
        return original(self, problems, **options)

    monkeypatch.setattr(capytaine.BEMSolver, "solve_all", solve_all)
    return frequencies


def test_nothing_is_lost_when_the_computation_stops(tmp_path, own_cache, solved):
    """Stopped in the middle it goes on where it was; done once, it is not done again, whatever file it goes to."""
    target = tmp_path / "buoy.nc"
    solved.stop_at = (0.6,)
    with pytest.raises(KeyboardInterrupt):
        compute([BUOY], **COARSE, path=target)
    assert not target.exists()
    assert solved == [math.inf, pytest.approx(0.0774, abs=1e-4), 0.4]
    solved.stop_at = ()
    done = []
    database = compute([BUOY], **COARSE, path=target, progress=lambda k, n: done.append((k, n)))
    assert solved[3:] == [0.6, 0.8]
    assert done == [(1, 5), (2, 5), (3, 5), (4, 5), (5, 5)]
    again = compute([BUOY], **COARSE)
    assert len(solved) == 5
    for name in ("A", "B", "X", "A_inf", "A_zero"):
        np.testing.assert_array_equal(getattr(again, name), getattr(database, name))
    np.testing.assert_array_equal(HydrodynamicDatabase.read(target).A, database.A)


def test_what_was_solved_for_another_floater_is_not_taken(own_cache, solved):
    """Other frequencies and another density take what there is; depth, headings, hull, mesh and gravity do not."""
    compute([BUOY], **COARSE)
    solved.clear()
    heavy = compute([BUOY], **COARSE | {"omega": [0.4, 0.8]}, rho=2000.0)
    assert heavy.A[0, 0, 0] == pytest.approx(2000 / 1025 * compute([BUOY], **COARSE).A[0, 0, 0])
    assert not solved
    compute([BUOY], **COARSE | {"omega": [0.4, 0.5, 0.8]})
    assert solved == [0.5]
    wide = Column(((-10.0, 8.1), (4.0, 8.1)))
    for hull, other in ((BUOY, {"water_depth": 110.0}), (BUOY, {"panel_size": 2.0}), (BUOY, {"g": 9.7}), (wide, {})):
        solved.clear()
        compute([hull], **COARSE | {"omega": [0.4, 0.8]} | other)
        assert len(solved) == 4
    solved.clear()
    compute([BUOY], **COARSE | {"omega": [0.4, 0.8], "headings": [0.0, 0.6]})
    assert solved == [0.4, 0.8]  # the limits have no waves


def test_a_damaged_result_is_made_again(own_cache, solved):
    compute([BUOY], **COARSE)
    kept = sorted(own_cache.glob("panels_*.json"))
    assert len(kept) == 5
    kept[0].write_bytes(kept[0].read_bytes()[:-40])
    solved.clear()
    with pytest.warns(UserWarning, match="this file is damaged; it is made again"):
        compute([BUOY], **COARSE)
    assert len(solved) == 1


@needs_capytaine
def test_a_result_that_is_refused_is_kept(own_cache, monkeypatch):
    """The checks at the end come after hours of work."""
    from fowtlib.components.hydro import panel

    def refuse(database):
        raise HydrodynamicDataError("the load of long waves is not that of the buoyancy.")

    monkeypatch.setattr(panel, "check_conventions", refuse)
    with pytest.raises(HydrodynamicDataError, match="of the buoyancy. .* What was solved is kept") as caught:
        compute([BUOY], **COARSE | {"omega": [0.4, 0.6]})
    assert str(caught.value).startswith("the load of long waves")
    assert len(list(own_cache.glob("panels_*.json"))) == 4


@needs_capytaine
def test_a_file_that_cannot_be_written_is_refused_before_the_work(tmp_path, monkeypatch):
    import capytaine

    monkeypatch.setattr(capytaine.BEMSolver, "solve_all", lambda *_, **__: pytest.fail("it was solved"))
    with pytest.raises(ModelError, match=r"the folder .*absent does not exist"):
        compute([BUOY], **COARSE, path=tmp_path / "absent" / "buoy.nc")
