"""Independent solutions in plain numpy and scipy for docs/verification.md: they share no equation with the components.

Only data come from the models: masses, the tables of the hydrodynamic database, diameters, line properties.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from verification_cases import SurgePitch, bodies, surge_pitch

from fowtlib.analysis import Decay, analyse_decay
from fowtlib.solving.model import Model

Floats = NDArray[np.float64]


class SurgeAndPitch:
    """An upright spar with surge x [m] and pitch p [rad] about its axis at the still water level.

    M q'' + B q' + drag + lines + C q = load, with q = (x, p). Added mass and potential damping are those of the
    database at one frequency [rad/s]; drag is integrated over 480 slices of the hull; the lines pull at the fairleads
    with their static force at the place where these are, a plane case without heave.
    """

    def __init__(self, model: Model, frequency: float):
        self.root = root = model.root
        data = root.find("platform.water").database
        self.linear: SurgePitch = surge_pitch(model)
        self.mooring = root.find("platform.mooring")
        self.depth = float(self.mooring.fairlead_depth)
        at = [np.ix_([0, 4], [0, 4])]
        added, low = (self._interpolated(data.omega, data.A, frequency)[at[0]], data.A[0][at[0]])
        self.mass = self.linear.mass + added - low
        self.damping = self._interpolated(data.omega, data.B, frequency)[at[0]]
        self.damping[0, 0] += float(np.asarray(root.find("platform.damping").translation, dtype=float)[0])
        self.righting = self.linear.stiffness[1, 1] - self.linear.stiffness[0, 0] * self.depth**2
        drag = root.find("platform.drag")
        heights, diameters = np.asarray(drag.points, dtype=float)[:, 2], np.asarray(drag.diameters, dtype=float)
        edges = np.linspace(heights[0], 0.0, 481)
        self.z = (edges[1:] + edges[:-1]) / 2
        across = np.interp(self.z, heights, diameters) * (edges[1] - edges[0])
        self.drag = 0.5 * data.rho * float(drag.drag_coefficient) * across
        reach = np.linspace(-30.0, 30.0, 241)
        self.line_force = reach, np.array([self.mooring.static_load((x, 0.0, 0.0))[0][0] for x in reach])

    @staticmethod
    def _interpolated(omega: Floats, table: Floats, frequency: float) -> Floats:
        return np.array([[np.interp(frequency, omega, table[:, i, j]) for j in range(6)] for i in range(6)])

    def restoring(self, q: Floats) -> Floats:
        """Force [N] and moment [N m] of lines, buoyancy and weight."""
        pull = np.interp(q[0] - self.depth * q[1], *self.line_force)
        return np.array([pull, -self.depth * pull - self.righting * q[1]])

    def resisting(self, v: Floats) -> Floats:
        """Force [N] and moment [N m] of drag and linear damping."""
        speed = v[0] + self.z * v[1]
        load = self.drag * np.abs(speed) * speed
        return -np.array([load.sum(), load @ self.z]) - self.damping @ v

    def decay(self, surge: float, pitch: float, duration: float) -> tuple[Decay, Decay]:
        """Decays of surge [m] and pitch [deg] from rest at an offset."""
        inverse = np.linalg.inv(self.mass)

        def rate(_: float, y: Floats) -> Floats:
            return np.concatenate([y[2:], inverse @ (self.restoring(y[:2]) + self.resisting(y[2:]))])

        time = np.linspace(0.0, duration, int(duration / 0.1) + 1)
        start = [surge, np.radians(pitch), 0.0, 0.0]
        run = solve_ivp(rate, (0.0, duration), start, t_eval=time, rtol=1e-8, atol=1e-9)
        rest = self.at_rest(0.0, 0.0)
        return (
            analyse_decay((time, run.y[0]), rest=float(rest[0])),
            analyse_decay((time, np.degrees(run.y[1])), rest=float(np.degrees(rest[1]))),
        )

    def at_rest(self, force: float, moment: float) -> Floats:
        """Surge [m] and pitch [rad] under a horizontal force [N] and a moment [N m] about the axis of pitch."""

        def tilt(x: float) -> float:
            return float(brentq(lambda p: moment + self.restoring(np.array([x, p]))[1], -0.5, 0.5))

        x = float(brentq(lambda x: force + self.restoring(np.array([x, tilt(x)]))[0], -25.0, 25.0))
        return np.array([x, tilt(x)])

    def pushed(self, thrust: float, tilt: float, hub: tuple[float, float]) -> Floats:
        """Surge and pitch under a thrust [N] at the hub (x, z) [m], along a shaft tilted by `tilt` [rad]."""
        eccentric = sum(mass * 9.80665 * place[0] for mass, place, _ in bodies(self.root))
        pitch = 0.0
        for _ in range(20):
            along = thrust * np.array([np.cos(tilt + pitch), -np.sin(tilt + pitch)])
            x, z = hub[0] + hub[1] * pitch, hub[1] - hub[0] * pitch
            surge, pitch = self.at_rest(along[0], z * along[0] - x * along[1] + eccentric)
        return np.array([surge, pitch])


class Yaw:
    """Yaw of a spar with two rotors as one oscillator that the difference of their thrusts turns.

    I yaw'' + B yaw' + K yaw = half_span (T_right - T_left): bodies about the axis, the linear damping of the model, the
    lines turned as a whole about the axis where the spar is on average, and the yaw spring.
    """

    def __init__(self, model: Model, surge: float, pitch: float):
        root = model.root
        self.half_span = float(np.asarray(root.find("arm_left").r, dtype=float)[1])
        structure = np.asarray(root.find("platform.structure").inertia, dtype=float)[2, 2]
        rotors = [float(root.find(f"turbine_{side}").mass) for side in ("left", "right")]
        self.inertia = structure + sum(rotors) * self.half_span**2
        self.damping = float(np.asarray(root.find("platform.damping").rotation, dtype=float)[2])
        self.mooring = root.find("platform.mooring")
        at = surge - float(self.mooring.fairlead_depth) * pitch
        step = 1e-3
        self.stiffness = float(self.mooring.yaw_stiffness)
        self.stiffness += (self._moment(at, -step) - self._moment(at, step)) / (2 * step)

    def _moment(self, surge: float, yaw: float) -> float:
        """Moment of the lines about the axis of a spar at a surge [m], turned by yaw [rad]."""
        total = 0.0
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        for k, (fairlead, _) in enumerate(self.mooring.layout()):
            place = turn @ np.array([float(fairlead[0]), float(fairlead[1])])
            moved = np.array([surge, 0.0]) + place - np.array([float(fairlead[0]), float(fairlead[1])])
            force = self.mooring.static_load((*moved, 0.0))[1][k]["horizontal"]
            anchor = np.array([float(value) for value in self.mooring.layout()[k][1]][:2])
            way = anchor - np.array([surge, 0.0]) - place
            pull = force * way / np.hypot(*way)
            total += place[0] * pull[1] - place[1] * pull[0]
        return total

    def under(self, time: Floats, left: Floats, right: Floats, yaw: float) -> Floats:
        """Yaw [rad] over time [s] under the thrusts [N] of the rotors, from rest at a yaw."""

        def rate(t: float, y: Floats) -> list[float]:
            moment = self.half_span * np.interp(t, time, right - left)
            return [y[1], (moment - self.damping * y[1] - self.stiffness * y[0]) / self.inertia]

        run = solve_ivp(rate, (time[0], time[-1]), [yaw, 0.0], t_eval=time, max_step=1.0, rtol=1e-6, atol=1e-8)
        return np.asarray(run.y[0])
