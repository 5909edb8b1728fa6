"""Pitch steps of the Tjaereborg 2 MW turbine at constant speed in uniform wind, with dynamic inflow by components.

Known: three blades, R = 30.56 m, 22.36 rpm, chord 3.3 m at r = 6.46 m to 0.9 m at the tip and twist 1 deg per 3 m, both
linear, airfoils NACA 44xx (H. Snel and J. G. Schepers, Joint investigation of dynamic inflow effects, ECN-C--94-107,
1995). Assumed: the polar of the attached 15 to 18 % thick airfoils, lift 0.45 + 0.105 per deg and drag 0.010; no tilt.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

import fowtlib as fw
from fowtlib.components.aero import Airfoil, BladeAerodynamics, BladeElementRotor, DynamicInflow, RigidRotor
from fowtlib.language import Scalar, eq, param, var, when
from fowtlib.language import math as m

WIND, SPEED, RADIUS = 8.7, 22.36 * np.pi / 30, 30.56
PITCH = np.radians([0.070, 3.716])  # deg of the measured steps
STEPS = (2.0, 32.0)  # s, up and back


def rotor() -> BladeElementRotor:
    """The rotor from r = 6.46 m, in 17 elements."""
    degrees = np.array([-180.0, -90, -40, -14, 10, 14, 40, 90, 180])
    lift = np.array([0.0, 0, -0.8, -1.02, 1.5, 1.5, 0.9, 0, 0])
    drag = np.array([0.01, 1.8, 0.7, 0.010, 0.010, 0.02, 0.7, 1.8, 0.01])
    foil = Airfoil("NACA 44xx", np.radians(degrees), np.column_stack([lift, drag, 0 * lift]), smooth=False)
    borders = np.linspace(6.46, RADIUS, 18)
    r = (borders[1:] + borders[:-1]) / 2
    blade = BladeAerodynamics(
        hub_radius=6.46, tip_radius=RADIUS, radius=r, chord=0.9 + 0.1 * (30.46 - r), twist=np.radians((RADIUS - r) / 3),
        airfoil=["NACA 44xx"] * len(r), airfoils={"NACA 44xx": foil},
    )  # fmt: skip
    return BladeElementRotor(blade, dynamic_inflow=True)


class PitchSteps(fw.Component):
    """The rotor at its speed in uniform wind along the shaft; its blades pitch at once at STEPS."""

    rotor: object = param()
    torque: Scalar = var(unit="N*m", doc="of the rotor on its shaft")

    def build(self):
        b = self.rotor.blade
        self.inflow = DynamicInflow(radius=b.radius.tolist(), length=b.length.tolist(), tip_radius=b.tip_radius)

    def equations(self):
        bem = self.rotor
        given = RigidRotor(bem).inputs([WIND, 0, 0], SPEED)
        cuts = np.cumsum(list(bem.inputs.values()))[:-1]
        values = dict(zip(bem.inputs, np.split(given, cuts), strict=True))
        arm = values["position"].reshape(-1, 3) - values["hub_position"]
        up, back = STEPS
        pitch = m.if_else(self.time > up, m.if_else(self.time > back, PITCH[0], PITCH[1]), PITCH[0])
        axes = [ca.DM(a.reshape(3, 3).T) @ m.rotation_z(-pitch) for a in values["orientation"].reshape(-1, 9)]
        values |= {"orientation": m.vertcat(*[m.vec(R) for R in axes]), "induced": self.inflow.induced}
        outputs, stations = bem.external(**values), len(bem.blade.radius)
        loads = outputs["loads"]
        moments = [m.cross(ca.DM(arm[i]), loads[6 * i : 6 * i + 3])[0] + loads[6 * i + 3] for i in range(bem.nodes)]
        mean = sum(outputs["quasi_steady"][k * stations : (k + 1) * stations] for k in range(bem.blades)) / bem.blades
        return [
            eq(self.inflow.quasi_steady, mean), eq(self.inflow.wind_speed, WIND), eq(self.torque, sum(moments)),
            when(self.time > up), when(self.time > back),
        ]  # fmt: skip


def steps() -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and torque [kN m] over 62 s."""
    result = fw.load(PitchSteps(rotor=rotor())).compile().simulate(62.0, 0.05, tolerance=1e-8)
    return result.time, result.array("torque") / 1e3


def rows() -> list[tuple[object, ...]]:
    """For each step: torque before, at once behind it, settled [kN m]; the overshoot, and how it decays."""
    time, torque = steps()
    table = []
    for name, start, end in (("0.070 to 3.716", STEPS[0], STEPS[1]), ("3.716 to 0.070", STEPS[1], 62.0)):
        inside = (time > start + 1e-6) & (time < end)
        t, q, before = time[inside] - start, torque[inside], float(torque[time < start - 1e-6][-1])
        settled = float(q[-1])
        left = np.abs(q - settled) / abs(q[0] - settled)
        table.append((name, before, float(q[0]), settled, float(q[0] - settled),
                      float(t[left < 0.5][0]), float(t[left < 0.1][0]), float(t[left < 0.1][0] * WIND / RADIUS)))
    return table
