"""Ducts and tanks whose water the motion of their body drives: U-tubes against Lloyd's linear theory, and balances.

A. R. J. M. Lloyd, Seakeeping: Ship Behaviour in Rough Weather (1989), ch. 20, with the coefficients of C. Moaleji and
A. R. Greig, Ocean Engineering 34 (2007) 2103-2121: with r_d the depth of the duct below the axis of roll, h the water
over it, w the distance of the columns, A_r and A the sections of columns and duct, and the water q that went over,

    I phi'' + rho w (r_d + h) q'' + C phi + rho g w q = moment,
    rho w (r_d + h) phi'' + rho (w / A + 2 h / A_r) q'' + rho g w phi + 2 rho g q / A_r = - losses.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

import fowtlib as fw
from fowtlib.components.blocks import Sine
from fowtlib.components.environment import World
from fowtlib.components.flooding import BoxTank, Duct, TabulatedTank
from fowtlib.components.flooding.pipe import friction_factor
from fowtlib.components.mechanics import Prismatic, Revolute, RigidBody
from fowtlib.components.mechanics.rotational import FixedFlange, TorqueSource, TorsionSpringDamper
from fowtlib.language.errors import ParameterError

GRAVITY, RHO = 9.80665, 1025.0
W, LONG, WIDE, H, DEEP, AREA = 10.0, 4.0, 1.2, 2.5, 2.0, 2.4  # m, m^2: w, reservoirs along x and y, h, r_d, A
RESERVOIR = LONG * WIDE
MASS, INERTIA, BELOW = 9e5, 1.2e7, 0.55  # of the body: kg, kg m^2 about its centre, m below the axis of roll
SMOOTH = {"loss_factor": 0.0, "roughness": 0.0, "viscosity": 1e-9}


def rolling(loss=None, slide=None, moved=(0.0, 0.0), inertia=INERTIA, **hinge):
    """A body on a hinge along x, or on another joint, with two columns and the duct between them."""
    model = fw.Assembly("anti-roll tank")
    model.world = World(gravity=GRAVITY, water_density=RHO)
    model.hinge = slide or Revolute(n=(1, 0, 0), **hinge)
    model.body = RigidBody(mass=MASS, inertia=np.diag([inertia] * 3).tolist(), r_cm=(0, 0, -BELOW))
    column = {"length": LONG, "width": WIDE, "height": 5, "flow_inertia": True, "walls_wet": True}
    for name, side, more in (("right", -1, moved[0]), ("left", 1, moved[1])):
        tank = BoxTank(place=(0, side * W / 2, -DEEP), volume_start=RESERVOIR * H + more, **column)
        model.add(name, tank)
    losses = SMOOTH if loss is None else SMOOTH | {"loss_factor": loss}
    model.duct = Duct(points=((0, -W / 2, -DEEP), (0, W / 2, -DEEP)), area=AREA, **losses)
    model.connect(model.world.frame, model.hinge.frame_a)
    for frame in (model.body.frame_a, model.right.frame, model.left.frame, model.duct.frame):
        model.connect(model.hinge.frame_b, frame)
    model.connect(model.right.water[0], model.duct.water_a)
    model.connect(model.duct.water_b, model.left.water[0])
    return model


def matrices(inertia=INERTIA):
    """Mass and stiffness (2, 2) of roll and of the water that went over, by hand."""
    column, duct, z = RHO * RESERVOIR * H, RHO * AREA * W, -DEEP + H / 2
    inertia += MASS * BELOW**2 + duct * (DEEP**2 + W**2 / 12)
    inertia += 2 * column * ((W / 2) ** 2 + z**2 + (WIDE**2 + H**2) / 12)
    stiffness = GRAVITY * (MASS * BELOW + duct * DEEP - 2 * column * z - 2 * RHO * LONG * WIDE**3 / 12)
    together = RHO * W * (DEEP + H)
    M = np.array([[inertia, together], [together, RHO * (W / AREA + 2 * H / RESERVOIR)]])
    K = np.array([[stiffness, RHO * GRAVITY * W], [RHO * GRAVITY * W, 2 * RHO * GRAVITY / RESERVOIR]])
    return M, K


def frequencies(plant):
    found = np.linalg.eigvals(plant.linearize(plant.initial_state()).A.values)
    return np.sort(np.abs(found[found.imag > 1e-6]))


def test_natural_frequencies_are_those_of_lloyd():
    """Of the tank on a body that does not move, sqrt(2 g / (w A_r / A + 2 h)), and of both together."""
    M, K = matrices()
    together = np.sqrt(eigh(K, M, eigvals_only=True))
    assert frequencies(fw.load(rolling()).compile()) == pytest.approx(together, rel=1e-6)
    alone = np.sqrt(2 * GRAVITY / (W * RESERVOIR / AREA + 2 * H))
    assert np.sqrt(K[1, 1] / M[1, 1]) == pytest.approx(alone, rel=1e-12)
    held = frequencies(fw.load(rolling(slide=Prismatic(n=(1, 0, 0)))).compile())
    assert held == pytest.approx([alone], rel=1e-6)
    assert abs(together[0] / alone - 1) > 0.1


def test_what_drives_the_water_of_a_body_that_sways():
    """Along y: (M + m) y'' + rho w q'' = 0 and rho w y'' + rho (w / A + 2 h / A_r) q'' + 2 rho g q / A_r = 0."""
    total = MASS + RHO * (AREA * W + 2 * RESERVOIR * H)
    M = np.array([[total, RHO * W], [RHO * W, RHO * (W / AREA + 2 * H / RESERVOIR)]])
    free = np.sqrt(2 * RHO * GRAVITY / RESERVOIR / (M[1, 1] - M[0, 1] ** 2 / M[0, 0]))
    assert frequencies(fw.load(rolling(slide=Prismatic(n=(0, 1, 0)))).compile()) == pytest.approx([free], rel=1e-6)


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_momentum_of_a_body_on_which_water_swings(solver):
    """Free along y: (M + m) v + rho w Q does not change, as 6 m^3 more stand on one side at the start."""
    more = {"step": 0.01} if solver == "fixed" else {"tolerance": 1e-9}
    plant = fw.load(rolling(slide=Prismatic(n=(0, 1, 0)), moved=(3.0, -3.0), loss=2.0)).compile()
    result = plant.simulate(20, 0.1, solver=solver, **more)
    flow, v = result["duct.volume_flow"].values, result["hinge.v"].values
    total = MASS + RHO * (AREA * W + 2 * RESERVOIR * H)
    exchanged = RHO * W * np.max(np.abs(flow))
    assert np.max(np.abs(total * v + RHO * W * flow)) < 1e-6 * exchanged
    assert np.max(np.abs(flow)) > 1.0


def energy(result):
    """Kinetic and potential energy of body and water [J], by hand; and the power that the duct loses [W]."""
    phi, w = result["hinge.phi"].values, result["hinge.w"].values
    flow, left, right = (result[name].values for name in ("duct.volume_flow", "left.volume", "right.volume"))
    duct = RHO * AREA * W
    inertia = INERTIA + MASS * BELOW**2 + duct * (DEEP**2 + W**2 / 12)
    potential = -GRAVITY * np.cos(phi) * (MASS * BELOW + duct * DEEP)
    own, spread = LONG * WIDE**3 / 12, RHO * (W / AREA) * flow**2
    for side, volume in ((1, left), (-1, right)):
        h = volume / RESERVOIR
        z = -DEEP + h / 2
        slope = np.tan(phi)
        # the level surface: moments of the wedge about the middle of the column
        y1 = -own * slope / (RESERVOIR * h)
        z1 = own * slope**2 / (2 * RESERVOIR * h)
        inertia = inertia + RHO * volume * ((W / 2) ** 2 + z**2 + (WIDE**2 + h**2) / 12)
        potential = potential + RHO * volume * GRAVITY * ((side * W / 2 + y1) * np.sin(phi) + (z + z1) * np.cos(phi))
        spread = spread + RHO * h / RESERVOIR * flow**2
    path = W * DEEP + W / 2 * (left + right) / RESERVOIR
    kinetic = inertia * w**2 / 2 + RHO * path * flow * w + spread / 2
    return kinetic + potential, kinetic


def test_the_energy_of_body_and_water_goes_into_the_losses_of_the_duct():
    """A roll of 0.12 rad let go: what is missing is the work of (f w / D + K) rho |Q|^3 / (2 A^2)."""
    loss = 2.0
    plant = fw.load(rolling(loss=loss, phi_start=0.12)).compile()
    result = plant.simulate(40, 0.01, tolerance=1e-9)
    total, kinetic = energy(result)
    speed, D = np.abs(result["duct.volume_flow"].values) / AREA, np.sqrt(4 * AREA / np.pi)
    friction = np.array([float(friction_factor(max(v, 1e-12) * D / SMOOTH["viscosity"], 0.0)) for v in speed]) * W / D
    lost = RHO * AREA * speed**3 * (loss + friction) / 2
    work = np.concatenate([[0], np.cumsum((lost[1:] + lost[:-1]) / 2 * 0.01)])
    assert np.max(np.abs(total + work - total[0])) < 1e-5 * np.ptp(kinetic)
    assert work[-1] > 0.2 * np.ptp(kinetic)


def test_a_tuned_tank_takes_the_roll_at_resonance():
    """Against both equations with the losses of equal work, 8 / (3 pi) |Q| Q: roll 2 %, a quarter of that without.

    What is left is the third harmonic of the losses, and that the level moves by 0.2 of the height of the columns.
    """
    loss, moment, damping = 12.0, 1.5e5, 4e5
    M, K = matrices()
    inertia = INERTIA + K[0, 0] * M[1, 1] / K[1, 1] - M[0, 0]  # tuned: both have the frequency of the tank
    M, K = matrices(inertia)
    omega = np.sqrt(K[0, 0] / M[0, 0])
    assert omega == pytest.approx(np.sqrt(K[1, 1] / M[1, 1]), rel=1e-12)
    B, given = np.diag([damping, 0.0]), np.array([moment, 0.0])
    for _ in range(200):
        roll, water = np.abs(np.linalg.solve(K - omega**2 * M + 1j * omega * B, given))
        B[1, 1] = (B[1, 1] + RHO * loss / (2 * AREA**2) * 8 / (3 * np.pi) * omega * water) / 2
    without = moment / (omega * damping)
    model = rolling(loss=loss, inertia=inertia)
    model.ground, model.damper = FixedFlange(), TorsionSpringDamper(stiffness=0, damping=damping)
    model.push, model.wave = TorqueSource(), Sine(amplitude=moment, frequency=omega / (2 * np.pi))
    model.connect(model.wave.y, model.push.torque)
    for flange in (model.damper.flange_b, model.push.flange):
        model.connect(model.hinge.flange, flange)
    model.connect(model.ground.flange, model.damper.flange_a)
    period = 2 * np.pi / omega
    result = fw.load(model).compile().simulate(50 * period, period / 100, solver="fixed", step=0.02)
    late = result.time > 40 * period
    found = [np.ptp(result[name].values[late]) / 2 for name in ("hinge.phi", "left.volume")]
    print("ROLL", found, roll, water, without)
    assert found[0] == pytest.approx(roll, rel=0.02)
    assert found[1] == pytest.approx(water, rel=0.02)
    assert found[0] < 0.25 * without


def test_what_cannot_be_is_said():
    floor = {"levels": [0, 2], "areas": [4, 6], "second_moments": [[1, 1, 0], [2, 2, 0]]}
    with pytest.raises(ParameterError, match="needs a tank of one section from floor to roof, and a TabulatedTank is"):
        TabulatedTank(volume_start=3, flow_inertia=True, **floor)
    with pytest.raises(ParameterError, match="flow_inertia and sloshing are of the same water"):
        BoxTank(length=2, width=2, height=2, volume_start=3, flow_inertia=True, sloshing=True)
    with pytest.raises(
        ParameterError, match=r"points needs two points or more, rows of x, y, z, not the shape \(1, 3\)"
    ):
        Duct(points=((0, 0, 0),), area=1.0)
