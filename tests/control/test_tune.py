"""PI gains from the model, and the damping of the platform with them: closed forms, textbook cases, runs in time."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.components.environment import Wind, World
from fowtlib.components.mechanics import FixedTranslation
from fowtlib.components.servo import FLOATING_GAINS, ONSHORE_GAINS, LeastPitch, read_least_pitch
from fowtlib.control import PitchLoop, RotorResponse, Tuned, least_pitch, opened, shave_peak, tune_pi
from fowtlib.language.errors import ModelError, ParameterError

MODELS = Path(__file__).parents[2] / "models"


@pytest.fixture(scope="module")
def loop():
    return PitchLoop(fw.load("oc3_spar_rigid"))


@pytest.fixture(scope="module")
def tuned(loop):
    return tune_pi(loop, (9, 13, 17, 21), 0.2, 0.7)


def test_gains_that_are_scheduled_themselves():
    """`scheduled: gains` of the DTU turbine: the gains of the linear model are those that `Tuned.at` says."""
    loop = PitchLoop(fw.load("dtu10mw_land_rigid"))
    found = tune_pi(loop, (13, 18, 23), 0.2, 0.7)
    given = loop.parameters(found)
    assert given["turbine.control.pitch.schedule_curvature"] == 0.0  # the tuned schedule has none
    for item in found.responses:
        assert_allclose(item.closed(*found.at(item.pitch))[0], 0.2, rtol=0.06)
        linear = loop.plant.linearize(loop.state(item.wind, given), outputs=[])
        row, names = linear.A[linear.states.index("turbine.control.pitch.pitch")], linear.states
        k_p, k_i = found.at(item.pitch)
        assert_allclose(row[names.index("turbine.control.speed_filter.x")] * 0.05, k_p, rtol=1e-6)
        assert_allclose(row[names.index("turbine.control.pitch.integral")] * 0.05, 1.0, rtol=1e-6)
        grows = linear.A[names.index("turbine.control.pitch.integral")]
        assert_allclose(grows[names.index("turbine.control.speed_filter.x")], k_i, rtol=1e-6)


def test_gains_give_frequency_and_damping():
    """The roots of s^2 - (a + b k_P) s - b k_I."""
    response = RotorResponse(15.0, 0.2, -0.1, -80.0)
    k_p, k_i = response.gains(0.3, 0.6)
    roots = np.roots([1, -(response.a + response.b * k_p), -response.b * k_i])
    assert_allclose(np.abs(roots), 0.3, rtol=1e-12)
    assert_allclose(-roots.real / np.abs(roots), 0.6, rtol=1e-12)
    assert_allclose(response.closed(k_p, k_i), (0.3, 0.6), rtol=1e-12)


def test_the_response_is_the_slope_of_the_torque(loop):
    """By differences of the torque Q of the rotor: b = n dQ/dpitch / (I + n^2 I_g), and a over its speed."""
    wind, step = 15.0, 1e-4
    state = loop.state(wind)
    paths = dict(zip(loop.plant.layout.x, state.x, strict=True))
    inertia, ratio = 38759227 + 97**2 * 534.116, 97

    def torque(name, by):
        moved = loop.plant.initial_state({"wind.mean_speed": wind}, {**paths, name: paths[name] + by})
        return moved["turbine.rotor.torque"]

    def slope(name):
        return (torque(name, step) - torque(name, -step)) / (2 * step)

    response = loop.response(wind)
    assert_allclose(response.b, ratio * slope("turbine.control.pitch.pitch") / inertia, rtol=1e-5)
    assert_allclose(response.a, slope("turbine.rotor.w") / inertia, rtol=1e-4)  # that of the generator is constant
    assert_allclose(response.pitch, state["turbine.blade_pitch"], rtol=1e-9)


def standing(within: str) -> fw.Model:
    """The turbine on a rigid tower, in the parts that `within` names."""
    root = fw.Assembly("turbine on the ground")
    root.world, root.wind = World(), Wind(kind="steady", mean_speed=15)
    root.tower = FixedTranslation(r=(0, 0, 87.6))
    unit = root
    for name in within.split():
        unit = unit.add(name, fw.Assembly(name))
    unit.turbine = fw.load(MODELS / "turbines/nrel5mw_rigid.yaml").root
    root.connect(root.world.frame, root.tower.frame_a)
    root.connect(root.tower.frame_b, unit.turbine.frame)
    return fw.Model(root)


def test_a_turbine_within_other_parts_is_found():
    found = []
    for within in ("", "farm row"):
        loop = PitchLoop(standing(within))
        assert loop.turbine == ".".join([*within.split(), "turbine"])
        found.append((loop.response(15.0), shave_peak(loop, (12,), 0.9)))
    assert found[0] == found[1]


def test_a_rotor_of_blade_elements_behind_a_soft_drive_train(loop):
    """Its speed has several states, of rotor, gear and generator; the answer is nearly that of the table."""
    blades = PitchLoop(fw.load("oc3_spar_rigid_bem")).response(14.0)
    table = loop.response(14.0)
    assert_allclose(blades.b, table.b, rtol=0.2)
    assert_allclose(blades.pitch, table.pitch, atol=np.radians(0.5))


def test_the_schedule_meets_the_frequency_and_no_wind_has_less_damping(tuned):
    assert [item.wind for item in tuned.responses] == [13.0, 17.0, 21.0]  # at 9 m/s the blades are not pitched
    for item in tuned.responses:
        omega, damping = item.closed(*tuned.at(item.pitch))
        assert_allclose(omega, 0.2, rtol=0.06)
        assert damping > 0.7 - 1e-9
    assert min(item.closed(*tuned.at(item.pitch))[1] for item in tuned.responses) < 0.7 + 1e-6
    double = Tuned(0.01, 0.002, 0.1, (), 0.0)
    assert double.at(0.05) == (0.005, 0.001)


def test_the_gains_of_a_turbine_on_land_take_the_damping_of_a_floating_one(loop):
    """At 13 m/s platform pitch grows with the onshore gains and decays with the floating ones: poles, and a run."""
    wind, grown = 13.0, {}
    for name, gains in (("land", ONSHORE_GAINS), ("floating", FLOATING_GAINS)):
        values = Tuned(gains["proportional_gain"], gains["integral_gain"], 0.1099965, (), 0.0)
        poles = loop.poles([wind], values)[0]
        mode = poles.mode("platform pitch")
        assert (mode.damping_ratio < 0) == (name == "land")
        assert (mode in poles.growing()) is (name == "land")
        parameters = {**loop.parameters(values), "wind.mean_speed": wind}
        rest = loop.state(wind, parameters)
        start = dict(zip(loop.plant.layout.x, rest.x, strict=True))
        start["platform.motion.pitch"] += np.radians(0.1)
        result = loop.plant.simulate(400.0, 1.0, start=start, parameters=parameters, solver="fixed", step=0.05)
        away = np.abs(np.asarray(result["platform.motion.pitch"]) - rest["platform.motion.pitch"])
        grown[name] = away[300:].max() / away[:60].max()
    assert grown["land"] > 1.5 and grown["floating"] < 0.5


def test_a_loop_opened_at_a_state_is_the_cut_plant(loop):
    """What the pitch does to the others, without what drives it."""
    state = loop.state(15.0)
    closed = loop.plant.linearize(state, outputs=["turbine.rotor.w"])
    name = "turbine.control.pitch.pitch"
    cut = opened(closed, [name])
    k = closed.states.index(name)
    rest = [i for i in range(len(closed.states)) if i != k]
    assert cut.inputs == [name] and name not in cut.states
    assert_allclose(cut.matrices["B"][:, 0], closed.matrices["A"][rest, k])
    assert_allclose(cut.matrices["A"], closed.matrices["A"][np.ix_(rest, rest)])


def test_peak_shaving_holds_the_thrust_at_its_share(loop):
    rows = shave_peak(loop, (9.0, 11.0, 15.0), 0.85)
    largest = max(row.thrust[0] for row in rows)
    by_wind = {row.wind: row for row in rows}
    assert_allclose(by_wind[11.0].thrust[1], 0.85 * largest, rtol=1e-3)
    assert by_wind[11.0].least_pitch > np.radians(1) and by_wind[11.0].power[1] < by_wind[11.0].power[0]
    assert by_wind[9.0].least_pitch == 0.0 and by_wind[15.0].thrust[0] == by_wind[15.0].thrust[1]


def test_a_controller_with_the_table_holds_the_thrust_in_every_wind(loop, tmp_path):
    """Steady thrust at most 0.8 of the largest, between the winds of the table too; other winds are as before."""
    rows = shave_peak(loop, (8.0, 9.0, 10.0, 10.5, 11.0, 11.5, 12.0, 12.5, 13.0), 0.8)
    limit = 0.8 * max(row.thrust[0] for row in rows)
    path = tmp_path / "shaving.csv"
    least_pitch(rows).write(path, ["of a test"])
    model = fw.load("oc3_spar_rigid", set={"turbine.control.peak_shaving": str(path)}).in_the_mean()
    shaved = model.compile()
    found = {wind: shaved.equilibrium({"wind.mean_speed": wind}) for wind in (9.0, 10.75, 11.5, 12.25, 15.0)}
    plain = {wind: loop.plant.equilibrium({"wind.mean_speed": wind}) for wind in (9.0, 11.5, 15.0)}
    assert max(float(state["thrust"]) for state in found.values()) * 1e3 == pytest.approx(limit, rel=0.01)
    assert float(found[11.5]["thrust"]) < 0.81 * float(plain[11.5]["thrust"])
    share = float(found[11.5]["generator_power"]) / float(plain[11.5]["generator_power"])
    assert share == pytest.approx(0.917, abs=0.01)
    for wind in (9.0, 15.0):
        for name in ("thrust", "generator_power", "blade_pitch"):
            assert float(found[wind][name]) == pytest.approx(float(plain[wind][name]), rel=1e-3, abs=1e-3)


def test_a_table_of_least_pitch_is_written_and_read(tmp_path):
    table = LeastPitch([1e6, 2e6, 3e6], np.radians([0, 1.25, 3.5]))
    table.write(tmp_path / "a.csv")
    back = read_least_pitch(str(tmp_path / "a.csv"))
    assert_allclose(back.power, table.power)
    assert_allclose(back.pitch, table.pitch, rtol=1e-5)
    with pytest.raises(ParameterError, match="two or more rising powers"):
        LeastPitch([2e6, 1e6], [0, 0.1])
    (tmp_path / "b.csv").write_text("generator_power_kW,least_pitch_deg\n1,x\n")
    with pytest.raises(ParameterError, match="'1,x' is not a row of numbers"):
        read_least_pitch(str(tmp_path / "b.csv"))
    changes = {"turbine.control.sample_period": 0.1, "turbine.control.peak_shaving": str(tmp_path / "a.csv")}
    with pytest.raises(ModelError, match="peak_shaving is continuous in time; leave sample_period out"):
        fw.load("oc3_spar_rigid", set=changes).compile()


def test_mistakes_are_sentences(loop):
    with pytest.raises(ParameterError, match="the blades are pitched in 1; give at least two above rated"):
        tune_pi(loop, (8, 15), 0.2)
    with pytest.raises(ParameterError, match="both must be positive"):
        tune_pi(loop, (13, 15), -0.2)
    with pytest.raises(ModelError, match="'turbine.pitch' is no PitchController; there are turbine.control.pitch"):
        PitchLoop(loop.model, "turbine.pitch")
    with pytest.raises(ModelError, match="has no PitchController"):
        PitchLoop(fw.load("two_rotor_spar_rigid_feedback"))
    with pytest.raises(ModelError, match="sampled controller has no linear model"):
        PitchLoop(fw.load("oc3_spar_rigid").with_parameters({"turbine.control.sample_period": 0.1}))
    with pytest.raises(ParameterError, match="give 0.5 to 1"):
        shave_peak(loop, (9.0, 11.0), 85.0)


def test_the_command_prints_gains_and_damping(capsys):
    assert main(["tune", "oc3_spar_rigid", "--winds", "13,18", "--frequency", "0.2", "--json"]) == 0
    printed = capsys.readouterr()
    rows = json.loads(printed.out)
    assert [row["wind [m/s]"] for row in rows] == [13.0, 18.0]
    assert rows[0]["pitch damping"] > 0.1 > rows[0]["pitch damping, new"]
    assert min(row["its damping"] for row in rows) == pytest.approx(0.7, abs=1e-6)
    assert "--set turbine.control.proportional_gain=" in printed.err
    assert "13 m/s: with the new gains platform pitch grows" in printed.err
    assert "`fowt decay oc3_spar_rigid --wind steady:" in printed.err


@pytest.mark.parametrize(("options", "message"), [
    (["--winds", "12:24"], "'12:24' is not first:last:step in m/s"),
    (["--damping", "0.7"], "--damping goes with --frequency"),
    (["--peak-shaving", "0.9", "--frequency", "0.2"], "two questions"),
    (["--save", "a.csv"], "--save writes the table of --peak-shaving; give both"),
    (["--frequency", "fast"], "'fast' is not a number"),
    (["--controller", "turbine.control"], "is no PitchController"),
])  # fmt: skip
def test_mistakes_on_the_command_line(capsys, options, message):
    try:
        status = main(["tune", "oc3_spar_rigid", *options])
    except SystemExit as end:
        status = end.code
    assert status == 2 and message in capsys.readouterr().err
