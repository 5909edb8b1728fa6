"""The spar whose tower is raised by water: draft, volume, lift-off, stability, periods, failures, waves, lowering."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.lifting import stroke
from fowtlib.cli.app import main
from fowtlib.language.errors import ModelError, SimulationError

MODELS = Path(__file__).parents[2] / "models"
G, RHO = 9.80665, 1025.0
SHAFT, CYLINDER = math.pi / 4 * 7.0**2, math.pi / 4 * 6.6**2
LIFTED = 163e3 + 340e3 + 480e3  # cylinder, tower, rotor and nacelle
DEPTH = LIFTED / (RHO * CYLINDER)
FRICTIONLESS = {
    "platform.rubbing.coefficient": 0.0, "platform.shaft.gap_loss": 0.0, "platform.shaft.gap_friction": 0.0
}  # fmt: skip


@pytest.fixture(scope="module")
def plant():
    return fw.load("dtif_raising").compile()


@pytest.fixture(scope="module")
def raised(plant):
    """The whole operation in still water: raised, latched."""
    return plant.simulate(4500, 1.0)


def array(result, name):
    return np.asarray(result[name])


def floating(plant, s, **motion):
    """The state with the tower afloat at s, without friction and losses in the gap."""
    volume = SHAFT * s + (SHAFT - CYLINDER) * DEPTH
    start = {"guide.s": s, "shaft.volume": volume, "tanks.volume": 2140 - volume, **motion}
    return plant.initial_state(FRICTIONLESS, {f"platform.{name}": value for name, value in start.items()})


# --- the operation in still water -----------------------------------------------------------------------------------


def test_the_draft_does_not_change_while_the_tower_is_raised(raised):
    """All water stays inside, and what moves slowly weighs the same wherever it is: to 2 mm of 62 m."""
    assert np.abs(array(raised, "heave")).max() < 2e-3
    total = array(raised, "shaft_water") + array(raised, "tank_water")
    assert np.abs(total - 2140.0).max() < 1e-7


def test_each_metre_takes_the_section_of_the_shaft(raised):
    s, volume = array(raised, "position"), array(raised, "shaft_water")
    way = (s > 2) & (s < 48)
    assert np.polyfit(s[way], volume[way], 1)[0] == pytest.approx(SHAFT, rel=1e-3)
    level = (volume - CYLINDER * s) / (SHAFT - CYLINDER)
    assert np.allclose(array(raised, "shaft_level")[way], level[way], rtol=1e-9)


def test_the_floor_is_left_when_its_force_is_zero(raised):
    """N = m g - rho g A_c h until then; afterwards the floor is not touched again, and the latch closes at the top."""
    t, s, immersion = raised.time, array(raised, "position"), array(raised, "immersion")
    N = 1e3 * array(raised, "floor_force")  # the output is in kN
    before = (t > 30) & (immersion < 0.95 * DEPTH) & (s < 0.2)
    assert before.sum() > 50
    expected = LIFTED * G - RHO * G * CYLINDER * immersion
    assert np.abs(N - expected)[before].max() < 0.02 * LIFTED * G
    assert N[s > 0.25].max() == 0
    assert array(raised, "platform.latch.closed")[-1] == 1
    assert s[-1] == pytest.approx(49.95, abs=2e-3)


def test_pump_work_is_what_tower_and_water_gain(raised):
    """Work of the pump between 1000 s and 3500 s against potential energies; losses in gap and guide are below 1 %."""
    t, power = raised.time, 1e3 * array(raised, "pump_power")
    a, b = 1000, 3500
    work = np.trapezoid(power[a : b + 1], t[a : b + 1])
    s, tank = array(raised, "position"), array(raised, "platform.tanks.surface")
    water = array(raised, "platform.shaft.energy")
    column = RHO * G * array(raised, "tank_water") * ((tank - 58.2077) / 2 + 60.0)
    gained = LIFTED * G * (s[b] - s[a]) + (water[b] - water[a]) + (column[b] - column[a])
    assert gained <= work
    assert gained == pytest.approx(work, rel=1e-2)


def test_both_engines_agree_on_the_lift_off(plant):
    options = {"t_end": 220.0, "output_step": 1.0}
    fixed = plant.simulate(**options, solver="fixed", step=0.02)
    exact = plant.simulate(**options, solver="idas", tolerance=1e-8)
    assert np.abs(array(fixed, "position") - array(exact, "position")).max() < 2e-3
    assert np.abs(array(fixed, "shaft_level") - array(exact, "shaft_level")).max() < 5e-3


def test_a_pump_that_fails_leaves_the_tower_where_it_floats(plant):
    events = ["platform.lifting.lift at 10 s", "platform.filling.failure at 300 s", "platform.filling.repair at 500 s"]
    result = plant.simulate(600, 1.0, events=events)
    s, t = array(result, "position"), result.time
    stopped = s[(t > 330) & (t < 500)]
    assert np.ptp(stopped) < 0.05 and stopped[0] > 1.0
    assert s[-1] > stopped[-1] + 0.8
    assert array(result, "floor_force")[t > 200].max() == 0


# --- stability over the stroke ----------------------------------------------------------------------------------------


def by_hand(s):
    """GM [m] at the place s, from masses and levels written down anew; see docs/dtif.md for the rules."""

    def cone(a, b, height):
        both = a * a + a * b + b * b
        return math.pi * height / 3 * both, height / 4 * (a * a + 2 * a * b + 3 * b * b) / both

    masses = [(math.pi * 20**2 * 2 * 2500, 1.0)]
    for a, b, low, high, density in ((15, 15, 2, 7, 2500), (15, 7.5, 7, 12, 2000), (7.5, 7.5, 12, 82, 2000)):
        outer, inner = cone(a, b, high - low), cone(a - 0.35, b - 0.35, high - low)
        volume = outer[0] - inner[0]
        masses.append((volume * density, low + (outer[0] * outer[1] - inner[0] * inner[1]) / volume))
    masses.append((416.1e3, 42.0))
    ring, ballast = math.pi * (14.65**2 - 3.53**2), 62 - 58.2077
    masses.append((ring * (ballast - 2) * 3900, (2 + ballast) / 2))
    foot, shaft = 2 + s, SHAFT * s + (SHAFT - CYLINDER) * DEPTH
    masses += [(163e3, foot + 15), (340e3, foot + 30 + 0.45 * 73.3), (480e3, foot + 30 + 77.8)]
    column = (SHAFT * (s + DEPTH) ** 2 / 2 - CYLINDER * ((s + DEPTH) ** 2 - s**2) / 2) / shaft
    masses += [(RHO * shaft, 2 + column), (RHO * (2140 - shaft), ballast + (2140 - shaft) / ring / 2)]
    plate, base, frustum, above = math.pi * 400 * 2, math.pi * 225 * 5, cone(15, 7.5, 5), math.pi * 7.5**2 * 50
    volume = plate + base + frustum[0] + above
    buoyancy = (plate * 1 + base * 4.5 + frustum[0] * (7 + frustum[1]) + above * 37) / volume
    middle = 2 / 3 * (14.65**3 - 3.53**3) / (14.65**2 - 3.53**2) * math.sin(math.pi / 8) / (math.pi / 8)
    tanks = math.pi / 4 * (14.65**4 - 3.53**4) - ring * middle**2 / 2
    surfaces = tanks + math.pi / 64 * (7**4 - 6.6**4)
    moment = sum(mass * (z - 62) for mass, z in masses)
    height = buoyancy - 62 + (math.pi / 4 * 7.5**4 - surfaces) / volume - moment / (RHO * volume)
    return height, sum(mass for mass, _ in masses) - RHO * volume


def test_the_metacentric_height_over_the_stroke_is_that_of_a_sum_by_hand(plant):
    """Both leave out the pull of the lines, 147 t, for which the ballast makes room."""
    found = stroke(plant, 50.0, 0.2, count=6)
    hand = [by_hand(s) for s in found.position]
    assert found.metacentric_height == pytest.approx([gm for gm, _ in hand], abs=0.01)
    assert found.excess == pytest.approx(hand[0][1], rel=1e-3)
    assert found.lifted_mass == pytest.approx(LIFTED) and found.immersion == pytest.approx(DEPTH)
    assert (np.diff(found.shaft_volume) / np.diff(found.position)) == pytest.approx(SHAFT)
    found.check(1.0)
    assert found.metacentric_height[-1] < 2.5 < found.metacentric_height[0]


def test_it_says_where_the_floater_would_turn_over(plant):
    """Of normal concrete, with a shaft of concrete as thick as the hull, GM runs out on the way."""
    heavy = {"platform.light_concrete": 2500, "platform.shaft_wall_mass": 1617e3, "platform.ballast_level": -58.97}
    found = stroke(plant, 50.0, 0.2, count=11, parameters=heavy)
    assert abs(found.excess) < 250e3
    with pytest.raises(
        ModelError, match=r"GM is below 1 m from s = \d+\.?\d* m on.*From s = \d+\.?\d* m on the floater turns"
    ):
        found.check(1.0)


@pytest.mark.parametrize(
    "changes, says",
    [
        (
            {"platform.cylinder_diameter": "6 m"},
            "the flotation cylinder is too small: 983000 kg float on it at 33.92 m",
        ),
        ({"platform.tank_water": "1500 m^3"}, "the tanks run dry when the tower is at s = 36.9"),
    ],
)
def test_what_cannot_be_raised_is_refused_with_the_reason(plant, changes, says):
    with pytest.raises(ModelError, match=says):
        stroke(plant, 50.0, 0.2, count=11, parameters=changes).check()


def test_the_stroke_on_the_command_line(capsys):
    """The table that `stroke` has; then where GM is too small, and what the command does not take."""
    assert main(["stability", "dtif_raising", "--stroke", "0.2:50:25", "--csv"]) == 0
    head, *rows = [line.split(",") for line in capsys.readouterr().out.splitlines()]
    assert head[:2] == ["place [m]", "GM [m]"] and [float(row[0]) for row in rows] == pytest.approx([0.2, 25.1, 50.0])
    for row in rows:
        assert float(row[1]) == pytest.approx(by_hand(float(row[0]))[0], abs=0.01)
    for more, says in (
        (["--stroke", "0:50:5", "--least", "3"], "GM is below 3 m from s = 40.8"),
        (["--stroke", "0:50:25", "--towards", "90"], "are not of a stroke"),
        (["--stroke", "0,25,50"], "are no two places [m] from 0 upwards"),
        (["--stroke", "5"], "are no two places [m] from 0 upwards"),
        (["--stroke", "0:50:25", "--plot", "a.png"], "are not of a stroke"),
        (["--least", "1"], "--least is of --stroke"),
    ):
        assert main(["stability", "dtif_raising", *more]) == 2
        error = capsys.readouterr().err
        assert says in error and "Traceback" not in error


def test_a_run_stops_where_the_cylinder_is_too_small(plant):
    changes = {"platform.cylinder_diameter": 6.0, "platform.shaft_water": 230.0}
    with pytest.raises(SimulationError, match="the water stands over the top of the piston"):
        plant.simulate(400, 1.0, parameters=changes)


def test_a_run_stops_where_the_tanks_are_drained_below_their_pump(plant):
    with pytest.raises(SimulationError, match="platform.tanks"):
        plant.simulate(400, 1.0, parameters={"platform.tank_water": 100.0})


# --- modes and waves --------------------------------------------------------------------------------------------------


def test_modes_afloat_are_those_of_closed_forms(plant):
    """Heave 2 pi sqrt((m + A33)/C33) with A33 in closed form; the tower in the shaft 2 pi sqrt(d/g)."""
    modes = plant.linearize(floating(plant, 25.0)).modes()

    def period(state):
        return (
            1 / max(modes, key=lambda mode: mode.participation.get(state, 0) * (mode.damping_ratio < 0.5)).frequency_hz
        )

    assert period("platform.guide.s") == pytest.approx(2 * math.pi * math.sqrt(DEPTH / G), rel=1e-4)
    added = RHO / 12 * (2 * 40**3 + 3 * math.pi * 40**2 * (z := math.sqrt(40**2 - 15**2) / math.pi)
                        - math.pi**3 * z**3 - 3 * math.pi * 15**2 * z)  # fmt: skip
    mass = RHO * 16944.97 - 147.2e3
    alone = 2 * math.pi * math.sqrt((mass + added) / (RHO * G * math.pi / 4 * 15**2))
    assert alone == pytest.approx(28.6, abs=0.15)
    assert period("platform.motion.heave") == pytest.approx(alone, rel=0.01)
    assert period("platform.motion.heave") < alone  # the lines add 1 % of stiffness


def test_a_floating_tower_goes_with_the_heave_of_its_hull(plant):
    """Its weight and its lift grow alike in a hull that heaves: nothing moves it in the shaft, at any period."""
    result = plant.simulate(
        60, 0.5, parameters=FRICTIONLESS, start=floating(plant, 25.0, **{"motion.heave": 2.0}), events=()
    )
    assert np.ptp(array(result, "heave")) > 3.5
    assert np.ptp(array(result, "position")) < 2e-3


def test_regular_waves_of_its_own_period_do_not_move_it(plant):
    """4 m at 2 pi sqrt(d/g), without friction and losses: 2 mm in the shaft, while the hull pitches by a degree."""
    sea = {
        "spectrum": "regular",
        "wave_height": 4.0,
        "wave_period": 2 * math.pi * math.sqrt(DEPTH / G),
        "build_up": 60.0,
    }
    parameters = FRICTIONLESS | {f"sea.{name}": value for name, value in sea.items()}
    result = plant.simulate(300, 0.25, parameters=parameters, start=floating(plant, 25.0), events=())
    late = result.time > 150
    assert np.ptp(array(result, "position")[late]) < 4e-3
    assert np.ptp(array(result, "pitch")[late]) > 1.5 and np.ptp(array(result, "heave")[late]) > 0.1


def test_it_is_raised_in_waves_within_its_limits(plant):
    """A part of the way in 2 m of 9 s: the floor is not touched again, and the cylinder stays above the water."""
    sea = {"sea.spectrum": "jonswap", "sea.significant_wave_height": 2.0, "sea.peak_period": 9.0, "sea.build_up": 100.0}
    result = plant.simulate(700, 0.5, parameters=sea)
    s, N, immersion = array(result, "position"), array(result, "floor_force"), array(result, "immersion")
    assert s[-1] > 6.0
    assert N[s > 0.5].max() == 0 and immersion.max() < 29.5
    assert np.ptp(array(result, "heave")) > 0.02


def test_with_play_its_rings_knock_and_it_rises_all_the_same(raised):
    """2 m of 9 s, 20 mm: the place of the tower to 2 cm, rings no deeper in the wall than 15 mm, more acceleration."""
    sea = {"sea.spectrum": "regular", "sea.wave_height": 2.0, "sea.wave_period": 9.0, "sea.build_up": 60.0}
    loose = fw.load("dtif_raising_play").compile().simulate(300, 0.1, parameters=sea)
    fitted = fw.load("dtif_raising").compile().simulate(300, 0.1, parameters=sea)
    assert array(loose, "position")[-1] == pytest.approx(array(fitted, "position")[-1], abs=0.02)
    for name in ("first_gap", "second_gap"):
        gap = array(loose, name)[loose.time > 100]
        assert -15 < gap.min() < 0 < gap.max() < 20
    felt = [np.std(array(found, "nacelle_acceleration")[found.time > 100]) for found in (loose, fitted)]
    assert felt[0] > 1.2 * felt[1]


# --- lowering ---------------------------------------------------------------------------------------------------------


def test_the_tower_is_let_go_afloat_and_set_down_gently():
    result = fw.load("dtif_lowering").compile().simulate(2300, 1.0, parameters={"platform.pump_flow": 2.0})
    s, latch = array(result, "position"), array(result, "latch_force")
    assert 1e3 * latch[20] == pytest.approx(LIFTED * G, rel=1e-3)
    assert latch[-1] == 0 and array(result, "platform.latch.closed")[-1] == 0
    assert s[-1] < 0.2 and array(result, "platform.floor_stop.impact_speed").max() < 0.1
    assert np.abs(array(result, "heave")).max() < 2e-3
    assert [line.split(": ")[1].split(" ")[0] for line in result.attributes["events"].splitlines()] == [
        "platform.lifting.lower", "platform.latch.open"
    ]  # fmt: skip


def test_pictures_show_the_water_where_it_is(plant, raised):
    """Shaft and tanks are blue columns from their floors to their levels, inside of a hull that is seen through."""
    from fowtlib.view.recording import Cast

    cast = Cast(plant.root.drawing())
    lines = cast.lines(lambda paths: raised.observe(paths)[::500], len(raised.time[::500]))
    water = [line for shape, line in zip(cast.curves, lines, strict=True) if shape.material == "water"]
    assert any(shape.material == "glass" for _, shape in cast.solids)
    levels = [array(raised, "shaft_level")[::500] - 60, array(raised, "platform.tanks.surface")[::500]]
    tops = sorted((line[:, -1, 2] for line in water), key=lambda z: z[-1], reverse=True)
    assert len(water) == 2
    for top, level in zip(tops, levels, strict=True):
        assert top == pytest.approx(level, abs=2e-3)


# --- operation --------------------------------------------------------------------------------------------------------


def test_the_speed_loop_does_not_drive_the_hull():
    """At 12 m/s surge and pitch die out; with the gains of land surge grows. Yaw: see docs/dtif.md."""
    plant = fw.load("dtif_operating").compile()
    wind = {"wind.kind": "steady", "wind.mean_speed": 12.0, "sea.spectrum": "still"}
    land = {"turbine.control.proportional_gain": 0.00348359, "turbine.control.integral_gain": 0.000333743}
    surge = []
    for gains in ({}, land):
        modes = plant.linearize(plant.equilibrium(parameters=wind | gains), outputs=[]).modes()
        damping = {mode.label: mode.damping_ratio for mode in modes if mode.frequency_hz < 0.03}
        surge.append(next(ratio for label, ratio in damping.items() if "surge" in label))
        assert next(ratio for label, ratio in damping.items() if "pitch" in label and "turbine" not in label) > 0.2
    assert surge[0] > 0.01 and surge[1] < -0.01


def test_it_leans_in_the_wind_as_its_stiffness_says():
    """Thrust times its lever over the fairleads, over rho g V GM with the pull of the lines, to 8 %."""
    plant = fw.load("dtif_operating").compile()
    wind = {"wind.kind": "steady", "wind.mean_speed": 18.0, "sea.spectrum": "still"}
    state = plant.equilibrium(parameters=wind)
    pitch, thrust = state["platform.motion.pitch"], state["turbine.thrust"]
    fairlead, hub = -25.0, 97.8
    metacentre = 4.17 + 147.2e3 * 25 / (RHO * 16944.97)  # m; with the pull of the lines at rest at their fairleads
    expected = thrust * (hub - fairlead) / (RHO * G * 16944.97 * metacentre)
    assert pitch == pytest.approx(expected, rel=0.08)
    assert state["platform.latch.force"] == pytest.approx(LIFTED * G * math.cos(pitch), rel=0.01)
    assert state["platform.shaft.lift"] == pytest.approx(0, abs=1.0)


def test_fifteen_megawatts_by_scaling_stand_as_seven_do():
    """Froude: power by the scale to 3.5, thrust to the third power, lengths by the scale; angles stay."""
    by = (15 / 7) ** (1 / 3.5)
    model = fw.load("dtif_operating", set={"wind.kind": "steady", "wind.mean_speed": 11.0, "sea.spectrum": "still"})
    one, other = (found.compile().equilibrium() for found in (model, fw.scaled(model, by)))
    for name, power in (("turbine.generator_power", 3.5), ("turbine.thrust", 3), ("platform.motion.surge", 1),
                        ("platform.motion.pitch", 0), ("platform.motion.yaw", 0)):  # fmt: skip
        assert other[name] == pytest.approx(one[name] * by**power, rel=1e-4), name
    assert other["turbine.generator_power"] == pytest.approx(15e6, rel=1e-3)


def test_in_rotor_effective_winds_all_else_is_the_same_and_yaw_dies_out(tmp_path):
    """The moments of the blades by the turning of the hull: a rotor by coefficients lets yaw grow at 12 m/s."""
    names = ("dtif_operating", "dtif_operating_effective")
    texts = [(MODELS / f"{name}.yaml").read_text(encoding="utf-8") for name in names]
    lines = [
        [line for line in text.splitlines() if not line.lstrip().startswith("#") and not line.startswith("title:")]
        for text in texts
    ]
    differing = [pair for pair in zip(*lines, strict=True) if pair[0] != pair[1]]
    assert differing == [("    use: turbines/surrogate_7mw", "    use: turbines/surrogate_7mw_effective")]
    again = tmp_path / "again.yaml"
    again.write_text(fw.dump(fw.load(names[1])), encoding="utf-8")
    wind = {"wind.kind": "steady", "wind.mean_speed": 12.0, "sea.spectrum": "still"}
    damping = []
    for model in (names[0], again):
        plant = fw.load(model).compile()
        modes = plant.linearize(plant.equilibrium(parameters=wind), outputs=[]).modes()
        damping.append(next(mode.damping_ratio for mode in modes if mode.frequency_hz < 0.03 and "yaw" in mode.label))
    assert damping[0] < 0 and damping[1] > 0.3
