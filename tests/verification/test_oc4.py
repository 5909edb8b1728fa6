"""The OC4 semisubmersible with the NREL 5-MW turbine (models oc4_semi_rigid and oc4_semi) against published numbers.

docs/floaters.md has the table, tests/platform/test_oc4_semi.py the platform alone. [R] RAFT 2.0, values of its tests
(OC4semi-WAMIT_Coefs). [F] a run of OpenFAST, github.com/OpenFAST/openfast/issues/1634.
"""

import numpy as np
import oc4_motions
import pytest
import verification_cases as cases

import fowtlib as fw

G = 9.80665
RNA, TOWER, PLATFORM = 350e3, 249718.0, 1.3473e7  # kg; the last from NREL/TP-5000-60601
STIFFNESS = 3.836e6, -3.776e8  # N/m and N m, heave and pitch of the water, NREL/TP-5000-60601


@pytest.fixture(scope="module")
def calm():
    return cases.calm_plant("oc4_semi_rigid")


@pytest.fixture(scope="module")
def rest(calm):
    return calm.equilibrium()


@pytest.fixture(scope="module")
def modes(calm):
    return cases.modes_by_motion(calm)


@pytest.mark.parametrize(("motion", "hertz"), [
    ("surge", 0.00884), ("sway", 0.00884), ("heave", 0.05733), ("roll", 0.04002), ("pitch", 0.04004), ("yaw", 0.01253),
])  # fmt: skip
def test_natural_frequencies(modes, motion, hertz):
    """[R], which has the same database; within 2 %: surge -1.3, heave +0.8, pitch -1.1, yaw +0.5 %."""
    assert modes[motion].frequency_hz == pytest.approx(hertz, rel=0.02)


def test_draft_and_trim_at_rest(rest):
    """It is 12.7 t heavier than printed: 33 mm. Rotor and nacelle, 0.414 m beside the axis, tilt it: a hand sum."""
    assert rest["platform.motion.heave"] == pytest.approx(-12.7e3 * G / STIFFNESS[0], abs=2e-3)
    lines = 8.770e7  # N m about y, MoorDyn's lines linearised at rest, as in pyBmodes 1.19.1
    upright = STIFFNESS[1] + G * (PLATFORM * 13.46 - TOWER * 43.348 - RNA * 89.567) + lines
    assert rest["platform.motion.pitch"] == pytest.approx(-0.413771 * RNA * G / upright, rel=0.02)
    for motion in ("surge", "sway", "roll", "yaw"):
        assert rest[f"platform.motion.{motion}"] == pytest.approx(0.0, abs=5e-3)


def test_tension_at_rest(rest):
    """1105.7 kN: elastic catenary, 835.35 m, 113.35 kg/m, 0.0766 m, EA 753.6 MN over 796.73 m and 186 m."""
    for line in (1, 2, 3):
        assert rest[f"fairlead_tension_{line}"] == pytest.approx(1105.7, rel=2e-3)


def test_offset_in_wind(rest):
    """[R] at 8 m/s from 30 deg: 4.40 m, 3.10 m, -0.0146 rad, 0.0277 rad, turned into the wind; the lines turn here.

    Its rotor and nacelle have no overhang: the tilt at rest is subtracted. Within 3 %: -1.9 % and +1.2 %.
    """
    plant = fw.load("oc4_semi_rigid", set={
        "wind.kind": "steady", "wind.mean_speed": 8.0, "sea.spectrum": "still",
        "platform.mooring.headings": np.radians([30.0, 150.0, 270.0]),
    }).compile()  # fmt: skip
    state = plant.equilibrium()
    cos, sin = np.cos(np.radians(30)), np.sin(np.radians(30))
    assert state["platform.motion.surge"] == pytest.approx(4.40 * cos + 3.10 * sin, rel=0.03)
    assert 0.3 < state["platform.motion.sway"] < 0.55  # 0.485 m in [R]
    tilt = state["platform.motion.pitch"] - rest["platform.motion.pitch"]
    assert tilt == pytest.approx(0.0277 * cos + 0.0146 * sin, rel=0.03)


def test_rated_wind():
    """[F] at 11.4 m/s: 11.93 rpm and 4.6 MW, where the torque is steep: 0.1 % of the speed is 1 % of the power."""
    wind = {"wind.kind": "steady", "wind.mean_speed": 11.4, "sea.spectrum": "still"}
    plant = fw.load("oc4_semi_rigid", set=wind).compile()
    state = plant.equilibrium()
    assert state["rotor_speed"] == pytest.approx(11.93, rel=0.003)
    assert state["generator_power"] == pytest.approx(4600, rel=0.05)
    assert state["heave"] == pytest.approx(0.0, abs=0.1)


def test_the_flexible_model():
    """The tower bends with 0.4284 Hz on rigid blades in pyBmodes 1.19.1, from the same input files: +0.9 % here.

    Every result of oc3_spar has the same name.
    """
    plant = fw.load("oc4_semi", set={**cases.CALM, "turbine.assembly.blade_hinges": 0}).compile()
    modes = plant.linearize(plant.equilibrium(), outputs=[]).modes()
    assert min(m.frequency_hz for m in modes if m.label.startswith("tower.")) == pytest.approx(0.4284, rel=0.015)
    pitch = next(mode for mode in modes if mode.label == "platform.motion.pitch")
    assert pitch.frequency_hz == pytest.approx(0.04004, rel=0.03)  # [R], rigid
    assert set(plant.outputs) == set(fw.load("oc3_spar").outputs)


def test_motions_in_waves(calm):
    """The printed masses, WAMIT's output and catenaries in six equations of plain numpy (benchmarks/oc4_motions.py).

    Surge and heave within 0.3 %. Pitch is up to 3.3 % off, for the members have 4 % less inertia than is printed: with
    their mass and inertia the six equations agree with the model in all three. Phases within 1 deg.
    """
    frequencies = [0.02, 0.03, 0.07, 0.09, 0.1, 0.125, 0.15, 0.2]
    own = fw.linear_rao(calm, frequencies, outputs=["surge", "heave", "pitch"]).response
    own[:, 2] = np.radians(own[:, 2].real) + 1j * np.radians(own[:, 2].imag)
    printed = oc4_motions.motions(frequencies)[:, [0, 2, 4]]
    np.testing.assert_allclose(np.abs(own[:, :2]), np.abs(printed[:, :2]), rtol=3e-3)
    np.testing.assert_allclose(np.abs(own[:, 2]), np.abs(printed[:, 2]), rtol=0.03)
    assert np.abs(np.angle(own / printed)).max() < np.radians(1.0)
    of_members = oc4_motions.motions(frequencies, oc4_motions.BODIES_OF_MEMBERS)[:, [0, 2, 4]]
    np.testing.assert_allclose(np.abs(own), np.abs(of_members), rtol=3e-3)


def test_the_six_equations_themselves():
    """[R] for their natural frequencies, and the tension of test_tension_at_rest."""
    found = oc4_motions.natural_frequencies()
    assert found == pytest.approx([0.00884, 0.00884, 0.01253, 0.04002, 0.04004, 0.05733], rel=0.02)
    assert np.hypot(*oc4_motions.line_pull(837.6 - 40.868, 186.0)) == pytest.approx(1105.7e3, rel=5e-4)


@pytest.mark.long
def test_the_response_of_the_flexible_model_in_its_own_wind():
    """In the 11.4 m/s of the model: its rotor of blade elements turns. Motions beside those of the rigid model.

    Two hinges in each blade, for time; with none the rotor is above rated there, on the side where surge grows.
    """
    found = {}
    for name in ("oc4_semi", "oc4_semi_rigid"):
        model = fw.load(name).in_the_mean()
        if name == "oc4_semi":
            model = model.with_parameters({"turbine.assembly.blade_hinges": 2})
        found[name] = fw.linear_rao(model.compile(), [0.07, 0.1, 0.15], outputs=["surge", "heave", "pitch"])
    flexible, rigid = (found[name].response for name in found)
    np.testing.assert_allclose(np.abs(flexible[:, :2]), np.abs(rigid[:, :2]), rtol=0.02)
    np.testing.assert_allclose(np.abs(flexible[:, 2]), np.abs(rigid[:, 2]), rtol=0.08)  # the tower bends
