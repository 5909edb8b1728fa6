"""The DeepCwind semisubmersible from its members, against the numbers that are printed of it.

[report] A. Robertson et al., NREL/TP-5000-60601 (2014); [deck] OpenFAST input files of the same platform, in
fowt-force-gen 0.1.0 and OpenFAST/r-test (5MW_OC4Semi_WSt_WavesWN); [wamit] its .hst file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import Sea, World
from fowtlib.components.hydro import HydrodynamicDatabase
from fowtlib.components.hydro.panel_mesh import hydrostatics
from fowtlib.components.mechanics import RigidBody

PLATFORMS = Path(__file__).parents[2] / "models" / "platforms"
DATA = HydrodynamicDatabase.read(PLATFORMS.parent / "data" / "oc4_semi" / "hydrodynamics.nc")
RHO, G = 1025.0, 9.80665


@pytest.fixture(scope="module")
def floater():
    return fw.load(PLATFORMS / "oc4_semi_unmoored.yaml").root.hull


@pytest.fixture(scope="module")
def hull(floater):
    return floater.hull()


def test_displaced_volume(hull):
    """13,917 m^3 in [deck]; without the overlaps of pontoons and columns, which count once here."""
    assert hull.buoyancy.volume == pytest.approx(13917, rel=1e-3)
    twice = sum(member.solid(a, b).mass for number, member in enumerate(hull.members)
                for a, b in [_wet(member)] if b > a)  # fmt: skip
    within = 2.0106 * (3 * 2 * 12 + 3 * (12 + 3.25))  # of the lower pontoons, whose ends lie on the axes of columns
    assert twice - hull.buoyancy.volume == pytest.approx(within, abs=2.0)  # braces and pontoons share a bit too
    assert hull.buoyancy.centre == pytest.approx([0, 0, -13.15], abs=0.03)  # [report], table 4-1


def _wet(member):
    z = member.start[2], member.end[2]
    if max(z) <= 0:
        return 0.0, member.length
    if min(z) >= 0:
        return 0.0, 0.0
    return 0.0, member.length * z[0] / (z[0] - z[1])


def test_hydrostatic_stiffness(hull):
    """Heave 3.836e6 N/m and roll -3.776e8 N m of [report] (0.4 % and 0.9 % from its own panels in [wamit])."""
    C = hull.buoyancy.stiffness(RHO, G)
    assert C[2, 2] == pytest.approx(380.0615 * RHO * G, rel=3e-4)  # [wamit]
    assert C[3, 3] == pytest.approx(-37875.5 * RHO * G, rel=1e-3)  # [wamit]
    assert C[2, 2] == pytest.approx(3.836e6, rel=5e-3) and C[3, 3] == pytest.approx(-3.776e8, rel=1e-2)  # [report]
    assert C[4, 4] == pytest.approx(C[3, 3], rel=1e-6) and abs(C[2, 4]) < 1e-6 * C[2, 2] * 50


def test_steel_and_ballast(hull):
    """3.85218e6 kg at z = -8.6588 m of steel in [deck]; with the water 1.3473e7 kg at -13.46 m in [report]."""
    assert hull.structure.mass == pytest.approx(3.85218e6, rel=3e-3)
    assert hull.structure.centre == pytest.approx([0, 0, -8.6588], abs=0.1)
    assert hull.mass.mass == pytest.approx(1.3473e7, rel=1e-3)
    assert hull.mass.centre == pytest.approx([0, 0, -13.46], abs=0.03)
    upper, base = (RHO * 3 * np.pi / 4 * d**2 * h for d, h in ((11.88, 7.83), (23.88, 5.05)))
    assert sum(fill.mass for fill in hull.fills.values()) == pytest.approx(upper + base, rel=1e-6)


def test_inertia(hull):
    """6.827e9 and 1.226e10 kg m^2 in [report]; the members have 3.9 % and 4.3 % less.

    The difference is in the steel: 1.226e10 less the water, exactly 8.56e9, leaves 3.70e9, and 3.85e6 kg of steel on
    the walls of the members have 3.16e9; all of it at the distance of the offset columns would have 3.21e9.
    """
    roll, pitch, yaw = np.diag(hull.mass.inertia)
    assert roll == pytest.approx(pitch, rel=1e-6)
    assert roll / 6.827e9 - 1 == pytest.approx(-0.039, abs=0.002)
    assert yaw / 1.226e10 - 1 == pytest.approx(-0.043, abs=0.002)
    assert hull.structure.inertia[2, 2] < hull.structure.mass * 28.86751**2
    assert hull.metacentric_height() == pytest.approx(10.7, abs=0.05)


def test_the_panels_have_the_volume_of_the_members(hull):
    """Below 0.5 % at a usual size of panels; the hull is closed (`hydrostatics` refuses leaks)."""
    volume, _, C = hydrostatics(hull.panels(2.5))
    assert volume == pytest.approx(hull.buoyancy.volume, rel=1e-3)
    lids = hull.lids(2.5)
    area = np.linalg.norm(np.cross(lids[:, 2] - lids[:, 0], lids[:, 3] - lids[:, 1]), axis=1).sum() / 2
    assert area == pytest.approx(C[2, 2], rel=1e-9)


def test_ballast_for_the_draft_is_that_of_the_report(floater):
    """Turbine and tower of 599,718 kg and lines that pull with 3 x 631.3 kN leave 5.05 m of water in each."""
    load = 599718 + 3 * 631.3e3 / G
    names = [f"base_column_{k}.water" for k in (1, 2, 3)]
    level = floater.ballast_level(*names, load=load, density=RHO)
    assert level - (-19.94) == pytest.approx(5.05, abs=0.02)


def test_the_moored_platform_has_the_periods_that_are_known():
    """With a rigid body for tower and turbine. Hz: RAFT 2.0 (its test files) .00884 .05733 .04002 .01253."""
    whole = fw.Assembly("moored")
    whole.world, whole.sea = World(water_depth=200.0), Sea()
    whole.platform = fw.load(PLATFORMS / "oc4_semi.yaml").root
    # tower 249,718 kg and rotor with nacelle 350,000 kg of the NREL 5-MW, about their common centre
    whole.top = RigidBody(mass=599718.0, r_cm=(-0.2, 0, 60.1), inertia=np.diag([4.4e8, 4.4e8, 2.0e7]))
    whole.connect(whole.world.frame, whole.platform.motion.frame_a)
    whole.connect(whole.platform.hull.nodes[0], whole.top.frame_a)
    plant = fw.load(whole).compile()
    state = plant.equilibrium()
    assert state["platform.motion.heave"] == pytest.approx(0.0, abs=0.05)
    modes = {mode.label.rpartition(".")[2]: mode.frequency_hz for mode in plant.linearize(state).modes()[:6]}
    known = {"surge": 0.00884, "sway": 0.00884, "heave": 0.05733, "roll": 0.04002, "pitch": 0.04002, "yaw": 0.01253}
    for name, frequency in known.items():
        assert modes[name] == pytest.approx(frequency, rel=0.04), name
