"""DynamicLine: statics against the elastic catenary, modes, driven tension against MoorDyn, balances, both engines."""

import warnings

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import Sea
from fowtlib.components.mechanics import Fixed, World
from fowtlib.components.mechanics.forced_motion import ForcedOscillation
from fowtlib.components.mooring import CatenaryLine, DynamicLine, catenary
from fowtlib.language import Assembly
from fowtlib.language.errors import ParameterError

OC3 = {"axial_stiffness": 384.243e6, "mass_per_length": 77.7066, "diameter": 0.09}
WEIGHT = catenary.weight_in_water(77.7066, 0.09)


def between(line, left, right, depth, **world):
    """The plant of a line between two fixed points."""
    model = Assembly("line between two points")
    model.world = World(water_depth=depth, **world)
    model.left, model.right = Fixed(r=left), Fixed(r=right)
    model.line = line
    model.connect(model.left.frame, model.line.anchor)
    model.connect(model.right.frame, model.line.fairlead)
    return fw.load(model).compile()


def driven(line, fairlead, depth, amplitude, frequency, n=(1, 0, 0), drive_place=None):
    """The plant of a line whose fairlead goes to and fro."""
    model = Assembly("line with a driven fairlead")
    model.world = World(water_depth=depth)
    model.drive = ForcedOscillation(r=fairlead, n=n, speed_amplitude=amplitude * 2 * np.pi * frequency,
                                    period=1 / frequency)  # fmt: skip
    model.line = line
    model.connect(model.drive.frame, model.line.fairlead)
    return fw.load(model).compile()


def test_statics_converge_to_the_elastic_catenary_with_the_square_of_the_elements():
    """A line in mid-water, pulls at both ends."""
    H, V = catenary.fairlead_tension(700, 200, catenary.Line(760, WEIGHT, 384.243e6, clearance=500))
    expected = np.array([H, V])
    errors = []
    for elements in (10, 20, 40):
        line = DynamicLine(lengths=760, elements=elements, **OC3)
        state = between(line, (0, 0, -270), (700, 0, -70), 770).initial_state()
        pull = np.ravel(state["line.fairlead.f"])
        assert pull[1] == pytest.approx(0, abs=1e-6)
        errors.append(np.max(np.abs(pull[[0, 2]] / expected - 1)))
        assert np.ravel(state["line.anchor.f"])[0] == pytest.approx(-pull[0], rel=1e-9)
    assert errors[2] < 3e-4
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize(("properties", "length", "anchor", "fairlead", "depth"), [
    (OC3, 902.2, (0, 0, -320), (848.67, 0, -70), 320),
    # chain of the OC4 semi-submersible, NREL/TP-5000-60601 (2014), table 5-1
    ({"axial_stiffness": 753.6e6, "mass_per_length": 113.35, "diameter": 0.0766}, 835.35, (837.6, 0, -200),
     (40.868, 0, -14), 200),
])  # fmt: skip
def test_statics_on_the_seabed_are_those_of_the_catenary(properties, length, anchor, fairlead, depth):
    """On a hard seabed, 40 elements."""
    one = between(CatenaryLine(length=length, **properties), anchor, fairlead, depth).initial_state()
    line = DynamicLine(lengths=length, elements=40, seabed_stiffness=1e8, **properties)
    many = between(line, anchor, fairlead, depth).initial_state()
    for name in ("tension", "anchor_tension"):
        assert many[f"line.{name}"] == pytest.approx(one[f"line.{name}"], rel=2e-3), name


def test_a_run_begins_settled_in_both_engines():
    plant = between(DynamicLine(lengths=902.2, **OC3), (0, 0, -320), (848.67, 0, -70), 320)
    at_rest = plant.equilibrium()["line.tension"]
    for solver in ("idas", "fixed"):
        series = np.asarray(plant.simulate(20.0, output_step=0.5, solver=solver)["line.tension"])
        assert np.max(np.abs(series / at_rest - 1)) < 1e-8, solver


def test_modes_of_a_taut_string():
    """Without weight and water: the lumped string has 2 c n / L sin(k pi / 2 n), c^2 = T / m and EA / m."""
    n, EA, m, L, stretch = 16, 5e8, 80.0, 100.0, 2e-3
    line = DynamicLine(lengths=L, elements=n, axial_stiffness=EA, mass_per_length=m, diameter=0.1, damping_ratio=0.0)
    plant = between(line, (0, 0, -50), (L * (1 + stretch), 0, -50), 100, gravity=0.0, water_density=0.0)
    found = np.array([mode.frequency_hz for mode in plant.linearize(plant.equilibrium(), outputs=[]).modes()])
    k = np.arange(1, n)
    shape = 2 * n / L * np.sin(k * np.pi / (2 * n)) / (2 * np.pi)
    across = shape * np.sqrt(EA * stretch / (m * (1 + stretch)))
    along = shape * np.sqrt(EA / m)
    assert found == pytest.approx(np.sort(np.concatenate([across, across, along])), rel=1e-6)
    closed_form = np.sqrt(EA * stretch / m) / (2 * L)
    assert found[0] == pytest.approx(closed_form, rel=3e-3)


DRIVEN = {"lengths": 902.2, "anchor_position": (0, 0, -320), **OC3}


def last_cycles(time, values, period, duration, cycles=2):
    kept = time >= duration - cycles * period - 1e-9
    return values[kept]


def test_both_engines_agree_on_a_driven_line_and_the_fixed_step_converges():
    plant = driven(DynamicLine(**DRIVEN), (858.67, 0, -70), 320, 2.0, 0.2)
    def run(**options):
        return np.asarray(plant.simulate(30.0, output_step=0.1, **options)["line.tension"])
    exact = run(solver="idas", tolerance=1e-8)
    size = np.ptp(exact)
    errors = [np.max(np.abs(run(solver="fixed", step=step) - exact)) / size for step in (0.025, 0.0125, 0.00625)]
    assert errors[0] < 5e-3
    assert errors[2] < errors[1] / 2 < errors[0] / 4


def lumped_by_moordyn(folder, n, frequency, amplitude, duration, step=0.0125):
    """Tension of the last element of the same line in MoorDyn, at times (k,)."""
    moordyn = pytest.importorskip("moordyn", reason="MoorDyn is not installed (pip install moordyn), to compare with")
    path = folder / "line.txt"
    path.write_text(f"""one line
---------------------- LINE TYPES ----------------------
TypeName Diam Mass/m EA BA/-zeta EI Cd Ca CdAx CaAx
(name) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
main 0.09 77.7066 384.243e6 -0.8 0 1.33 1.0 0.1 0.0
---------------------- POINTS ----------------------
ID Type X Y Z Mass Volume CdA Ca
(#) (-) (m) (m) (m) (kg) (m^3) (m^2) (-)
1 Fixed 0 0 -320 0 0 0 0
2 Coupled 858.67 0 -70 0 0 0 0
---------------------- LINES ----------------------
ID LineType AttachA AttachB UnstrLen NumSegs LineOutputs
(#) (name) (#) (#) (m) (-) (-)
1 main 1 2 902.2 {n} -
---------------------- OPTIONS ----------------------
0 writeLog
0.001 dtM
1e5 kBot
1e4 cBot
320 WtrDpth
1025 WtrDnsty
9.80665 g
rk2 tScheme
1e-8 threshIC
300 TmaxIC
--------------------- end ----------------------
""")
    system = moordyn.Create(str(path))
    try:
        omega = 2 * np.pi * frequency

        def motion(t):
            s = min(t * frequency / 2, 1.0)
            grown, rate = s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2 * frequency / 2
            x = amplitude * grown * np.sin(omega * t)
            return x, amplitude * (grown * omega * np.cos(omega * t) + rate * np.sin(omega * t))

        moordyn.SetVerbosity(system, moordyn.LEVEL_NONE)
        moordyn.Init(system, [858.67, 0, -70], [0, 0, 0])
        line = moordyn.GetLine(system, 1)
        times, pulls = [0.0], [np.linalg.norm(moordyn.GetLineNodeTen(line, n))]
        for k in range(round(duration / step)):
            x, v = motion(k * step + step / 2)  # MoorDyn holds the velocity over a step
            x -= v * step / 2
            moordyn.Step(system, [858.67 + x, 0, -70], [v, 0, 0], k * step, step)
            times.append((k + 1) * step)
            pulls.append(np.linalg.norm(moordyn.GetLineNodeTen(line, n)))
    finally:
        moordyn.Close(system)
    return np.array(times), np.array(pulls)


@pytest.mark.parametrize(("frequency", "amplitude"), [(0.05, 6.0), (0.1, 2.0), (0.2, 2.0)])
def test_tension_of_a_driven_fairlead_against_moordyn(frequency, amplitude, tmp_path, capfd):
    """20 equal elements, the line stays taut: the statics within 0.2 %, the amplitude of the tension within 2 %."""
    period, n = 1 / frequency, 20
    duration = 5 * period
    time, theirs = lumped_by_moordyn(tmp_path, n, frequency, amplitude, duration)
    plant = driven(DynamicLine(**DRIVEN), (858.67, 0, -70), 320, amplitude, frequency)
    result = plant.simulate(duration, output_step=0.05, solver="fixed", step=0.0125)
    ours = np.asarray(result["line.tensions"])[:, -1]
    assert ours[0] == pytest.approx(theirs[0], rel=2e-3)
    ours, theirs = (last_cycles(*series, period, duration) for series in ((result.time, ours), (time, theirs)))
    assert ours.min() > 0
    assert np.ptp(ours) == pytest.approx(np.ptp(theirs), rel=0.02)
    assert ours.max() == pytest.approx(theirs.max(), rel=0.01)


def test_snap_loads_of_a_line_that_goes_slack_against_moordyn(tmp_path, capfd):
    """0.2 Hz and 4 m: slack in each period, and a peak as it comes taut; within 15 %, and measured within 1 %."""
    frequency, amplitude, n = 0.2, 4.0, 20
    time, theirs = lumped_by_moordyn(tmp_path, n, frequency, amplitude, 25.0)
    plant = driven(DynamicLine(**DRIVEN), (858.67, 0, -70), 320, amplitude, frequency)
    result = plant.simulate(25.0, output_step=0.05, solver="fixed", step=0.0125)
    ours = np.asarray(result["line.tensions"])[:, -1]
    assert ours.max() == pytest.approx(theirs.max(), rel=0.05)
    assert np.min(np.asarray(result["line.tensions"])) < 1e2


def test_messages_say_what_to_do():
    with pytest.raises(ParameterError, match="water and seabed act on the diameter"):
        between(DynamicLine(lengths=100, axial_stiffness=1e8, mass_per_length=80), (0, 0, -50), (90, 0, 0), 50)
    with pytest.raises(ParameterError, match="not weight_per_length"):
        between(DynamicLine(lengths=100, axial_stiffness=1e8, weight_per_length=80), (0, 0, -50), (90, 0, 0), 50)
    with pytest.raises(ParameterError, match="3 sections and 2 elements"):
        between(DynamicLine(lengths=[1, 2, 3], elements=2, **OC3), (0, 0, -50), (5, 0, 0), 50)


# --- published series -------------------------------------------------------------------------------------------------


def harmonics(time, values, period, count=3):
    """Amplitudes of the harmonics over the last two periods, range and mean."""
    kept = time >= time[-1] - 2 * period - 1e-9
    t, s = time[kept][:-1], values[kept][:-1]
    found = [2 * abs(np.mean(s * np.exp(-2j * np.pi * k * t / period))) for k in range(1, count + 1)]
    return found, np.ptp(values[kept]), s.mean()


@pytest.mark.parametrize(("depth", "anchor", "length", "elements", "static", "span", "first"), [
    (200, 700, 760, 38, 2065.4e3, 2042e3, 1004e3),
    pytest.param(50, 400, 410, 82, 991.6e3, 1196e3, 519e3, marks=pytest.mark.long),
])  # fmt: skip
def test_chain_whose_fairlead_heaves(depth, anchor, length, elements, static, span, first):
    """5 m in 10 s, against OrcaFlex (tests of MoorDyn, BSD-3): range and first harmonic within 5 %.

    Axial drag is 1.15 on the bar (DNV-OS-E301), which is 0.64 d there, and 0.64 / pi on pi d here.
    """
    line = DynamicLine(
        lengths=length, elements=elements, anchor_position=(anchor, 0, -depth), axial_stiffness=1.674e9,
        mass_per_length=390, diameter=0.252, damping_ratio=1.0, drag_coefficient=1.37, friction=0.5,
        axial_drag_coefficient=0.64 / np.pi,
    )  # fmt: skip
    plant = driven(line, (0, 0, 0), depth, 5.0, 0.1, n=(0, 0, 1))
    result = plant.simulate(50.0, output_step=0.05, solver="fixed", step=0.0125)
    tension = np.asarray(result["line.tension"])
    (found, *_), size, _ = harmonics(result.time, tension, 10.0)
    assert tension[0] == pytest.approx(static, rel=0.014)  # 1.3 % at 50 m, where the catenary is 1.0 % above OrcaFlex
    assert size == pytest.approx(span, rel=0.05)
    assert found == pytest.approx(first, rel=0.05)


@pytest.mark.parametrize(("n", "span", "expected"), [
    ((1, 0, 0), 10.76, (3.88, 2.42)),
    ((0, 1, 0), 4.83, (0.05, 2.34)),
    ((0, 0, 1), 21.00, (9.53, 1.17)),
])  # fmt: skip
def test_jumper_whose_top_moves(n, span, expected):
    """Lowe and Langley (2006), 10 m in 27 s, kN: range, and harmonics above a tenth of it, within 5 %.

    The top comes 5 m out of the water when it heaves: nearly half of the mean comes from what weighs more there.
    """
    model = Assembly("jumper")
    model.world = World(water_depth=100, water_density=1000, gravity=9.807)
    model.drive = ForcedOscillation(r=(0, 0, -5), n=n, speed_amplitude=10 * 2 * np.pi / 27, period=27)
    model.line = DynamicLine(lengths=170, elements=34, anchor_position=(-100, 0, -55), **JUMPER)
    model.connect(model.drive.frame, model.line.fairlead)
    result = fw.load(model).compile().simulate(108.0, output_step=0.1, solver="fixed", step=0.0125)
    found, size, _ = harmonics(result.time, np.asarray(result["line.tension"]) / 1e3, 27.0)
    assert size == pytest.approx(span, rel=0.05)
    for amplitude, published in zip(found, expected, strict=False):
        if published > 0.1 * span:
            assert amplitude == pytest.approx(published, rel=0.05)


JUMPER = {"axial_stiffness": 5e8, "bending_stiffness": 1.208e5, "mass_per_length": 165.0, "diameter": 0.396,
          "damping_ratio": 0.5, "drag_coefficient": 1.0, "axial_drag_coefficient": 0.0}  # fmt: skip


def test_jumper_at_rest():
    """The same: force at its top, with bending; and how near to that a run begins."""
    line = DynamicLine(lengths=170, elements=34, **JUMPER)
    plant = between(line, (-100, 0, -55), (0, 0, -5), 100, water_density=1000.0, gravity=9.807)
    state = plant.equilibrium()
    assert np.ravel(state["line.fairlead.f"])[[0, 2]] == pytest.approx([11.40e3, 45.71e3], rel=5e-4)
    assert plant.initial_state()["line.tension"] == pytest.approx(state["line.tension"], rel=1e-3)


@pytest.mark.parametrize(("heading", "span", "expected"), [
    (0, 11.2, (5.19, 1.63)),
    (45, 12.2, (5.50, 1.89)),
    (90, 12.65, (5.72, 1.50)),
])  # fmt: skip
def test_jumper_in_waves(heading, span, expected):
    """The same, its top held, in waves of 5 m amplitude and 10 s: range and both harmonics within 5 %.

    The series begin as waves that grew over one period are there: at heading 0 their second harmonic falls from period
    to period, 1.83, 1.44, 1.36. Their range is that of 30 s, the published harmonics are those of the first 20 s.
    """
    model = Assembly("jumper in waves")
    model.world = World(water_depth=100, water_density=1000, gravity=9.807)
    model.sea = Sea(spectrum="regular", wave_height=10, wave_period=10, heading=np.radians(heading), build_up=10)
    model.top = Fixed(r=(0, 0, -5))
    model.line = DynamicLine(lengths=170, elements=34, anchor_position=(-100, 0, -55), **JUMPER)
    model.connect(model.top.frame, model.line.fairlead)
    plant = fw.load(model).compile()
    assert np.ravel(plant.initial_state()["line.fairlead.f"])[[0, 2]] == pytest.approx([11.40e3, 45.71e3], rel=2e-3)
    result = plant.simulate(40.0, output_step=0.1, solver="fixed", step=0.0125)
    time, tension = result.time, np.asarray(result["line.tension"]) / 1e3
    assert np.ptp(tension[time >= 10 - 1e-9]) == pytest.approx(span, rel=0.05)
    begun = time < 30 + 1e-9
    found, *_ = harmonics(time[begun], tension[begun], 10.0)
    assert found[:2] == pytest.approx(expected, rel=0.05)
    if heading == 0:
        falling = [harmonics(time[k : k + 101], tension[k : k + 101], 10.0)[0][1] for k in (100, 200, 300)]
        assert falling == pytest.approx((1.83, 1.44, 1.36), rel=0.05)


# --- steps that are short enough --------------------------------------------------------------------------------------


def whipping(friction=0.5):
    """A heavy line of three sections that lies slack on 190 m of seabed, its fairlead moved 4 m to and fro in 12 s."""
    line = DynamicLine(
        lengths=(166.1, 73.4, 17.1), mass_per_length=(165, 550, 750), diameter=(0.1636, 0.2987, 0.3488), elements=12,
        axial_stiffness=1.4e10, anchor_position=(232.5, 0, -90), friction=friction,
    )  # fmt: skip
    return driven(line, (47.5, 0, -25), 90, 4.0, 1 / 12)


def told_of_steps(plant, step, output_step, **more):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        result = plant.simulate(18.0, output_step=output_step, step=step, **more)
    said = [str(one.message) for one in found if "its ends part at" in str(one.message)]
    assert "\n".join(said) in result.attributes["warnings"]
    return np.asarray(result["line.tensions"]).max(), said


def test_a_snap_needs_steps_of_the_time_that_a_wave_takes_through_an_element():
    """With such steps peaks on the seabed stay within 5 % of half of them; longer steps, and output points, are told.

    The least l sqrt(m / EA) is 23.73 m of the lower section, of which there are seven elements, at 9211 m/s.
    """
    plant, wave = whipping(), 166.1 / 7 * np.sqrt(165 / 1.4e10)
    peak, said = told_of_steps(plant, 0.0025, 0.0025, solver="fixed")
    finer, also = told_of_steps(plant, 0.00125, 0.00125, solver="fixed")
    assert not said and not also
    assert peak == pytest.approx(finer, rel=0.05)
    _, (said,) = told_of_steps(plant, 0.0125, 0.1, solver="fixed")
    assert f"not further apart than {wave:.6g} s; this run has steps of 0.0125 s and output points every 0.1 s" in said
    _, (said,) = told_of_steps(plant, 0.0025, 0.1, solver="fixed")
    assert "; this run has output points every 0.1 s (t = " in said
    _, (said,) = told_of_steps(plant, None, 0.1, solver="idas")
    assert "; this run has output points every 0.1 s (t = " in said


def test_a_line_that_stays_taut_or_is_gone_needs_no_short_steps():
    plant = driven(DynamicLine(**DRIVEN | {"elements": 6}), (858.67, 0, -70), 320, 2.0, 0.1)
    assert not told_of_steps(plant, 0.05, 0.1, solver="fixed")[1]
    assert not told_of_steps(plant, 0.05, 0.1, solver="fixed", events=["line.loss at 1 s"])[1]
