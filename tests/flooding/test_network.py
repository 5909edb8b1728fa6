"""Tanks, pumps, valves, vents and openings in networks, against sums by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.components.blocks import Constant, Ramp
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, Doorway, Pipe, Pump, RoundTank, SeaOpening, Valve, Vent
from fowtlib.components.flooding.pipe import friction_factor
from fowtlib.components.mechanics import Fixed
from fowtlib.language.errors import ModelError

GRAVITY, RHO, ATMOSPHERE = 9.80665, 1025.0, 101325.0


def ashore(**parts: object) -> fw.Assembly:
    """A model whose parts with a frame stand on the ground, 2 m above the still water level."""
    model = fw.Assembly("tanks ashore")
    model.world = World()
    model.ground = Fixed(r=(0, 0, 2))
    for name, part in parts.items():
        model.add(name, part)
        if "frame" in part.ports:
            model.connect(model.ground.frame, getattr(model, name).frame)
    return model


def pool(area: float, volume: float, floor: float = 0.0, **more: object) -> BoxTank:
    return BoxTank(length=area, width=1, height=6, volume_start=volume, place=(0, 0, floor), **more)


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_a_network_of_four_tanks_keeps_its_volume_to_rounding(solver):
    """A ring of four tanks with a pump, a valve that is shut on the way, a pipe with inertia and a doorway."""
    model = ashore(
        one=pool(6, 20), two=pool(4, 8, 0.5), three=RoundTank(diameter=3, height=6, volume_start=12),
        four=pool(5, 10, -0.3), pump=Pump(rated_flow=0.2, rated_head=2, shutoff_head=5), valve=Valve(area=0.05),
        pipe=Pipe(length=15, diameter=0.3, inertia=True), door=Doorway(area=0.2, height=0.5, place=(0, 0, 1.5)),
        ramp=Ramp(duration=20),
    )  # fmt: skip
    model.connect(model.ramp.y, model.pump.command)
    ring = ("one", "pump", "two", "valve", "three", "pipe", "four", "door", "one")
    for tank, link, following in zip(ring[::2], ring[1::2], ring[2::2], strict=False):
        model.connect(getattr(model, tank).water[0], getattr(model, link).water_a)
        model.connect(getattr(model, link).water_b, getattr(model, following).water[0])
    more = {"step": 0.02} if solver == "fixed" else {}
    events = ["valve.turn at 10 s, to=0.4", "valve.shut at 40 s", "pump.failure at 60 s"]
    result = fw.load(model).compile().simulate(80, 0.5, solver=solver, events=events, **more)
    volumes = np.array([result[f"{name}.volume"].values for name in ring[:-1:2]])
    assert np.max(np.ptp(volumes, axis=1)) > 2
    assert np.max(np.abs(volumes.sum(axis=0) - 50)) < 2e-12
    late = result.time > 41
    assert np.all(result["valve.volume_flow"].values[late] == 0)
    assert np.max(np.abs(result["pump.volume_flow"].values[result.time > 61])) < 1e-4  # of its check valve


def test_a_pump_between_two_tanks_finds_the_flow_of_its_curve_and_of_the_pipe():
    """By hand: H_0 - (H_0 - H_r) (Q / Q_r)^2 = dz + (f L / D + K) Q^2 / (2 g A^2), f by Colebrook and White."""
    L, D, K, rough, nu = 40.0, 0.2, 3.0, 1e-4, 1.19e-6
    model = ashore(
        low=pool(1e6, 2e6), high=pool(1e6, 3e6, 2.5),
        pump=Pump(rated_flow=0.1, rated_head=8, shutoff_head=12, efficiency=0.6),
        pipe=Pipe(length=L, diameter=D, loss_factor=K, roughness=rough, viscosity=nu),
    )  # fmt: skip
    for a, b in ((model.low.water[0], model.pump.water_a), (model.pump.water_b, model.pipe.water_a),
                 (model.pipe.water_b, model.high.water[0])):  # fmt: skip
        model.connect(a, b)
    state = fw.load(model).compile().initial_state()
    area, Q = math.pi / 4 * D**2, 0.1
    for _ in range(50):
        reynolds, f = Q / area * D / nu, 0.02
        for _ in range(50):
            f = (-2 * math.log10(rough / D / 3.7 + 2.51 / reynolds / math.sqrt(f))) ** -2
        resistance = (f * L / D + K) / (2 * GRAVITY * area**2)
        Q = math.sqrt((12 - 3.5) / (4 / 0.1**2 + resistance))
    assert float(state["pump.volume_flow"]) == pytest.approx(Q, rel=2e-3)  # Churchill is good for 1 % in f
    lift = 12 - 4 * (float(state["pump.volume_flow"]) / 0.1) ** 2
    power = RHO * GRAVITY * float(state["pump.volume_flow"]) * lift
    assert float(state["pump.lift"]) == pytest.approx(lift, rel=1e-9)
    assert float(state["pump.hydraulic_power"]) == pytest.approx(power, rel=1e-9)
    assert float(state["pump.shaft_power"]) == pytest.approx(power / 0.6, rel=1e-9)


CURVE = ((0.0, 12.0), (0.05, 11.2), (0.1, 8.0), (0.14, 3.0))  # m^3/s and m


def pumped(head: float, command: float = 1.0, in_line: bool = False, **pump: object) -> fw.Plant:
    """A pump between two lakes, `head` metres apart, told by a constant command; in_line: with a pipe of inertia."""
    model = ashore(
        low=pool(1e6, 3e6), high=pool(1e6, 3e6, head), pump=Pump(in_line=in_line, **pump), told=Constant(value=command)
    )
    ways = [(model.low.water[0], model.pump.water_a), (model.pump.water_b, model.high.water[0])]
    if in_line:
        model.pipe = Pipe(length=30, diameter=0.5, loss_factor=0.0, roughness=0.0, viscosity=1e-9, inertia=True)
        ways[1:] = [(model.pump.water_b, model.pipe.water_a), (model.pipe.water_b, model.high.water[0])]
    for a, b in (*ways, (model.told.y, model.pump.command)):
        model.connect(a, b)
    return fw.load(model).compile()


@pytest.mark.parametrize("command", [1.0, 0.7])
def test_a_pump_by_points_obeys_the_laws_of_affinity(command):
    """At its points Q = s Q_i under s^2 H_i, between them linear in the square of the flow; by hand."""
    plant = pumped(0.0, command, curve=CURVE)
    (low, high), between = (CURVE[1], CURVE[2]), 9.0
    squared = low[0] ** 2 + (low[1] - between) / (low[1] - high[1]) * (high[0] ** 2 - low[0] ** 2)
    for flow, lift in (*CURVE[1:], (math.sqrt(squared), between)):
        state = plant.initial_state({"high.place": (0, 0, lift * command**2)})
        assert float(state["pump.volume_flow"]) == pytest.approx(flow * command, rel=1e-6)
        power = RHO * GRAVITY * flow * lift * command**3
        assert float(state["pump.hydraulic_power"]) == pytest.approx(power, rel=1e-6)


def test_a_pump_of_two_points_is_the_parabola_and_one_in_line_finds_the_same_flow():
    parabola = pumped(5.0, rated_flow=0.14, rated_head=3.0, shutoff_head=12.0).initial_state()
    points = pumped(5.0, curve=(CURVE[0], CURVE[-1])).initial_state()
    assert float(points["pump.volume_flow"]) == pytest.approx(float(parabola["pump.volume_flow"]), rel=1e-12)
    result = pumped(5.0, 0.8, True, curve=CURVE).simulate(200, 1)
    lift = float(result["pump.lift"].values[-1])  # 5 m, and what the pipe loses
    same = pumped(lift, 0.8, curve=CURVE).initial_state()["pump.volume_flow"]
    assert 5.0 < lift < 5.1
    assert result["pump.volume_flow"].values[-1] == pytest.approx(float(same), rel=1e-4)


def test_a_pump_beyond_its_points_says_so_and_a_curve_that_rises_is_refused():
    with pytest.warns(UserWarning, match=r"its curve goes from 0 to 0.14 m3/s at its speed; beyond that it is cont"):
        flow = pumped(1.0, curve=CURVE).simulate(1, 1)["pump.volume_flow"].values[0]
    (a, b), (c, d) = CURVE[2:]
    assert flow == pytest.approx(math.sqrt(a**2 + (b - 1.0) / (b - d) * (c**2 - a**2)), rel=1e-6)
    for curve, said in (
        (((0, 5), (0.1, 6)), "its lifts must fall from row to row"),
        (((0.1, 5), (0.2, 4)), "its flows must begin with 0 and rise"),
        (((0, 5, 1), (0.1, 4, 1)), "two rows or more of flow"),
    ):
        with pytest.raises(ModelError, match=said):
            Pump(curve=curve)
    with pytest.raises(ModelError, match="rated_flow is given and would do nothing, because its curve is given"):
        Pump(curve=CURVE, rated_flow=0.1)
    with pytest.raises(ModelError, match="rated_flow needs a value, or its curve"):
        Pump(shutoff_head=3)


def test_friction_is_that_of_poiseuille_and_of_colebrook():
    for reynolds in (1.0, 100.0, 1500.0):
        assert float(friction_factor(reynolds, 1e-4)) == pytest.approx(64 / reynolds, rel=2e-3)
    for reynolds in (1e4, 1e5, 1e7):
        for rough in (1e-6, 1e-3, 1e-2):
            f = 0.02
            for _ in range(60):
                f = (-2 * math.log10(rough / 3.7 + 2.51 / reynolds / math.sqrt(f))) ** -2
            assert float(friction_factor(reynolds, rough)) == pytest.approx(f, rel=0.035)


def test_a_check_valve_holds_the_water_and_its_absence_does_not():
    def after(**more: object) -> float:
        pump = Pump(rated_flow=0.1, rated_head=2, shutoff_head=4, **more)
        model = ashore(low=pool(10, 10), high=pool(10, 40), pump=pump, off=Constant(value=0.0))
        model.connect(model.low.water[0], model.pump.water_a)
        model.connect(model.pump.water_b, model.high.water[0])
        model.connect(model.off.y, model.pump.command)
        return float(fw.load(model).compile().simulate(60, 1)["low.volume"].values[-1])

    leak = 0.1 * 3 / 2 * 1e-4 * 60
    assert after() == pytest.approx(10 + leak, rel=1e-5)
    assert after(check_valve=False) > 15


def test_an_orifice_drains_a_tank_in_the_time_of_torricelli():
    """sqrt(h) falls by C_d A_o / A sqrt(g / 2) t."""
    model = ashore(tank=pool(4, 16), sink=pool(1e4, 1e4, -2.0), valve=Valve(area=0.02))
    model.connect(model.tank.water[0], model.valve.water_a)
    model.connect(model.valve.water_b, model.sink.water[0])
    result = fw.load(model).compile().simulate(120, 1, tolerance=1e-8)
    drop = result["tank.surface"].values - result["sink.surface"].values
    rate = 0.61 * 0.02 * math.sqrt(GRAVITY / 2) * (1 / 4 + 1e-4)
    assert np.sqrt(drop) == pytest.approx(math.sqrt(drop[0]) - rate * result.time, abs=2e-6)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_trapped_air_is_compressed_until_it_holds_the_water(exponent):
    """p_atm ((V_0 / V)^n - 1) = rho g times the difference of the surfaces."""
    model = ashore(
        open=pool(1e6, 5e6), bell=pool(4, 2, sealed=True, polytropic_exponent=exponent), valve=Valve(area=0.05)
    )
    model.connect(model.open.water[0], model.valve.water_a)
    model.connect(model.valve.water_b, model.bell.water[0])
    state = fw.load(model).compile().equilibrium()
    low, high, outside = 0.5, 5.0, float(state["open.level"])
    for _ in range(200):
        h = (low + high) / 2
        pressure = ATMOSPHERE * ((5.5 / (6 - h)) ** exponent - 1)
        low, high = (low, h) if pressure > RHO * GRAVITY * (outside - h) else (h, high)
    assert float(state["bell.level"]) == pytest.approx(h, abs=1e-6)
    assert float(state["bell.air_pressure"]) == pytest.approx(RHO * GRAVITY * (outside - h), rel=1e-6)


def test_a_vent_lets_the_air_out_and_shut_it_holds_it():
    model = ashore(open=pool(1e6, 3e6), bell=pool(4, 2, sealed=True), valve=Valve(area=0.02), vent=Vent(area=1e-3))
    model.connect(model.open.water[0], model.valve.water_a)
    model.connect(model.valve.water_b, model.bell.water[0])
    model.connect(model.bell.air, model.vent.air)
    plant = fw.load(model).compile()
    vented = plant.simulate(400, 2)
    assert vented["bell.level"].values[-1] == pytest.approx(3.0, abs=1e-3)
    shut = plant.simulate(400, 2, events=["vent.shut at 20 s"])
    mass = shut["bell.air_mass"].values
    assert np.ptp(mass[shut.time >= 20]) == 0 and mass[0] > mass[-1]
    volume, p = shut["bell.volume"].values[-1], shut["bell.air_pressure"].values[-1]
    assert p == pytest.approx(RHO * GRAVITY * (3 - volume / 4), rel=1e-3)
    assert mass[-1] == pytest.approx(1.225 * (1 + p / ATMOSPHERE) * (24 - volume), rel=1e-9)


def flow_of(opening: SeaOpening | Doorway, level: float, floor: float = -6.0) -> float:
    """Flow through an opening to a compartment with its floor 4 m below the still water level."""
    model = ashore(tank=pool(100, 100 * (level - floor - 2), floor), hole=opening)
    model.connect(model.hole.water, model.tank.water[0])
    return float(fw.load(model).compile().initial_state()["hole.volume_flow"])


def test_openings_to_the_sea_under_it_across_its_surface_and_above():
    """Orifice with water on both sides, fall into a compartment, weir of Poleni at the surface, dry."""
    hole = {"area": 0.02, "discharge_coefficient": 0.6, "opening_start": 1.0}
    assert flow_of(SeaOpening(place=(0, 0, -4), **hole), -1.0) == pytest.approx(
        0.012 * math.sqrt(2 * GRAVITY * 1.0), rel=1e-6
    )
    assert flow_of(SeaOpening(place=(0, 0, -4), **hole), 1.0) == pytest.approx(
        -0.012 * math.sqrt(2 * GRAVITY * 1.0), rel=1e-6
    )
    assert flow_of(SeaOpening(place=(0, 0, -3), **hole), -3.0) == pytest.approx(
        0.012 * math.sqrt(2 * GRAVITY * 1.0), rel=1e-6
    )
    notch = SeaOpening(area=1.6, height=0.8, place=(0, 0, -2), discharge_coefficient=0.6)  # half of it under water
    poleni = 2 / 3 * 0.6 * 2.0 * math.sqrt(2 * GRAVITY) * 0.4**1.5
    assert flow_of(notch, -3.0) == pytest.approx(poleni, rel=0.02)
    assert abs(flow_of(SeaOpening(place=(0, 0, -1), **hole), -3.0)) < 1e-9


def test_what_is_overfilled_drained_or_dry_is_said_in_a_sentence():
    def run(**start: float) -> None:
        model = ashore(low=pool(2, 4, places=((0, 0, 0.2),)), high=pool(2, 4), pump=Pump(mode="flow", rated_flow=0.1))
        model.connect(model.low.water[0], model.pump.water_a)
        model.connect(model.pump.water_b, model.high.water[0])
        fw.load(model).compile().simulate(100, 1, parameters=start)

    with pytest.raises(ModelError, match=r"^low: air comes into its port 0: it lies .* m above the water, of which .* "
                       r"m3 are left, and 0.1 m3/s leave through it; stop the pump .* \(t = 37 s\)"):  # fmt: skip
        run()
    with pytest.raises(ModelError, match=r"^high: the tank is overfilled: 12\.\d* m3 of water, and it holds 12 m3; .* "
                       r"\(t = \d+ s\)"):  # fmt: skip
        run(**{"high.volume_start": 10.55})
    with pytest.raises(ModelError, match="its command is 1.5, and must be 0 to 1"):
        model = ashore(low=pool(2, 4), high=pool(2, 4), pump=Pump(mode="flow", rated_flow=0.1), on=Constant(value=1.5))
        model.connect(model.on.y, model.pump.command)
        model.connect(model.low.water[0], model.pump.water_a)
        model.connect(model.pump.water_b, model.high.water[0])
        fw.load(model).compile().simulate(1, 1)
    with pytest.raises(ModelError, match="air_volume is given and would do nothing, because the tank is open"):
        pool(2, 4, air_volume=1.0)
    with pytest.raises(ModelError, match="shutoff_head must be above its rated_head"):
        Pump(rated_flow=1.0, rated_head=3.0)
    with pytest.raises(ModelError, match="rated_head is given and would do nothing, because its mode is flow"):
        Pump(rated_flow=1.0, rated_head=3.0, mode="flow")


def test_modes_of_water_in_a_pipe_are_shown_where_no_body_moves(capsys, tmp_path):
    """Two tanks and a pipe: omega^2 = g A / L (1 / A_1 + 1 / A_2), less the square of the decay by laminar friction."""
    tanks = "class: BoxTank, width: 1 m, height: 5 m, walls_wet: true"
    path = tmp_path / "pipe.yaml"
    path.write_text(f"""fowtlib: 1
world: {{class: World, gravity: 9.81}}
parts:
  left: {{{tanks}, length: 2 m, volume_start: 6}}
  right: {{{tanks}, length: 1 m, volume_start: 3}}
  pipe: {{class: Pipe, length: 10 m, diameter: 0.2 m, inertia: true}}
connect:
  - [world.frame, left.frame]
  - [world.frame, right.frame]
  - ["left.water[0]", pipe.water_a]
  - [pipe.water_b, "right.water[0]"]
""")
    assert main(["eigen", str(path), "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    omega = np.sqrt(9.81 * np.pi / 4 * 0.2**2 / 10 * (1 / 2 + 1 / 1))
    assert row["frequency [Hz]"] == pytest.approx(omega / (2 * np.pi), rel=1e-4)
