"""Airfoils in unsteady flow: the wake that they shed and the separation of their flow follow with a delay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from fowtlib.components.aero.airfoil_models import STEADY, AirfoilModel, Look, SectionFlow
from fowtlib.components.aero.blade_aerodynamics import Airfoil
from fowtlib.components.aero.separation import Separation, separation

LEAST_SPEED = 1.0
"""[m/s]: below this speed of the relative wind the delays do not become longer."""

WHOLE_BELOW, NONE_ABOVE = np.radians(40.0), np.radians(50.0)
"""Angles of attack between which the unsteady part fades out: a flat plate across the wind has no attached flow."""


@dataclass(frozen=True)
class UnsteadyAirfoil(AirfoilModel):
    """Partial: incompressible unsteady flow at a section, after Hansen, Gaunaa and Madsen (2004, Riso-R-1354).

    With the speed W of the relative wind, T = c / (2 W), the angle of attack a at three quarters of the chord and the
    turning w of the section (nose up), the states follow, each where the model has it:
        y_i' = b_i / T (A_i W a - y_i)                  downwash of the shed wake, i = 1, 2
        a_E = a (1 - A_1 - A_2) + (y_1 + y_2) / W       effective angle
        x' = (C_p - x) / (T_p T)                        C_p = k (a_E - a_0) + pi T w, lift of attached flow
        f' = (f_st(x / k + a_0) - f) / (T_f T)          place of separation, 1: attached
        c_l = c_l,st(a_E) + (f - f_st(a_E)) (k (a_E - a_0) - c_l,fs(a_E)) + pi T w
        c_d = c_d,st(a_E) + (a - a_E) (c_l - pi T w) + (c_d,st(a_E) - c_d,st(a_0)) D
        c_m = c_m,st(a_E) - pi / 2 T w,         D = (sqrt(f_st) - sqrt(f)) / 2 - (f_st - f) / 4
    That is Hansen's C_l = f k (a_E - a_0) + (1 - f) c_l,fs, written so that its balance is the polar to the last digit,
    and his lags with y_i = W x_i, so that the term with dW/dt needs no acceleration. k, a_0, f_st, c_l,fs: of the
    polar, see Separation. Beyond WHOLE_BELOW all fades to the polar, which alone counts from NONE_ABOVE on, both sides;
    W in the delays is not below LEAST_SPEED. Without the accelerations of a section, and with no moment of the moving
    centre of pressure.
    """

    wake_lags: ClassVar[bool] = True
    pressure_lag: ClassVar[bool] = False
    separation: ClassVar[bool] = False
    source: ClassVar[str] = "unsteady_airfoil.c"

    wake_share: tuple[float, float] = (0.165, 0.335)
    wake_decay: tuple[float, float] = (0.0455, 0.3)
    pressure_time: float = 1.5
    separation_time: float = 6.0

    def cubics(self, foil: Airfoil) -> np.ndarray:
        """The polar, the place of separation and the lift of fully separated flow."""
        return _of(foil).cubics

    def data(self, foils: Sequence[Airfoil]) -> tuple[dict[str, Any], dict[str, Any]]:
        """See AirfoilModel."""
        known = [_of(foil) for foil in foils]
        macros = {
            "WAKE_LAGS": int(self.wake_lags), "PRESSURE_LAG": int(self.pressure_lag),
            "SEPARATION": int(self.separation), "PRESSURE_TIME": self.pressure_time,
            "SEPARATION_TIME": self.separation_time, "LEAST_SPEED": LEAST_SPEED,
            "WHOLE_BELOW": float(WHOLE_BELOW), "NONE_ABOVE": float(NONE_ABOVE),
            "WAKE_SHARE": _list(self.wake_share), "WAKE_DECAY": _list(self.wake_decay),
        }  # fmt: skip
        names = {"unsteady": "lifts", "flow_slope": "lift_slope", "flow_zero": "zero_lift",
                 "flow_drag": "zero_lift_drag"}  # fmt: skip
        return macros, {name: [float(getattr(s, of)) for s in known] for name, of in names.items()}

    def flow(self, look: Look, told: SectionFlow, foils: Sequence[Airfoil]) -> tuple[np.ndarray, np.ndarray]:
        """See AirfoilModel."""
        known = [_of(foil) for foil in foils]
        lifts, k, zero, drag_0 = (
            np.array([float(getattr(s, name)) for s in known])[told.airfoil]
            for name in ("lifts", "lift_slope", "zero_lift", "zero_lift_drag")
        )
        V = np.maximum(told.speed, LEAST_SPEED)
        T, edge = told.chord / (2 * V), told.turn * told.chord / 2
        across, along = told.speed * np.sin(told.angle) + edge, told.speed * np.cos(told.angle)
        at_rest = (across == 0) & (along == 0)
        angle = np.where(at_rest, told.angle, np.arctan2(across, along))
        bent = np.where(np.abs(angle) <= np.pi / 3, angle, np.sign(angle) * (np.pi - np.abs(angle)) / 2)
        states, rates = iter(told.states), []

        def lag(target: np.ndarray, time: np.ndarray) -> np.ndarray:
            """The state at the end of the step, where its rate is that of its equation."""
            end = (next(states) * time + told.step * target) / (time + told.step)
            rates.append((target - end) / time)
            return end

        effective, apparent = bent, np.zeros_like(T)
        if self.wake_lags:
            apparent = np.pi * T * told.turn
            terms = zip(self.wake_share, self.wake_decay, strict=True)
            wake = sum(lag(share * V * bent, T / decay) for share, decay in terms)
            effective = bent * (1 - sum(self.wake_share)) + wake / V
        lift, drag, moment, f_st, separated = look(effective)
        attached, moved = k * (effective - zero), effective
        if self.pressure_lag:
            moved = lag(attached + apparent, self.pressure_time * T) / np.where(lifts, k, np.inf) + zero
        if self.separation:
            f = lag(look(moved)[3], self.separation_time * T)
            lift = lift + (f - f_st) * (attached - separated)
            if self.wake_lags:
                drag = drag + (drag - drag_0) * ((_root(f_st) - _root(f)) / 2 - (f_st - f) / 4)
        if self.wake_lags:
            drag = drag + (bent - effective) * lift
        share = np.clip((NONE_ABOVE - np.abs(angle)) / (NONE_ABOVE - WHOLE_BELOW), 0, 1)
        share = lifts * share**2 * (3 - 2 * share)
        steady, _ = STEADY.flow(look, told, foils)
        dynamic = np.array([lift + apparent, drag, moment - apparent / 2])
        return steady + share * (dynamic - steady), np.array(rates)


@dataclass(frozen=True)
class AttachedFlow(UnsteadyAirfoil):
    """The wake alone: two states. The flow separates as it does at rest at the effective angle."""

    state_units: ClassVar[tuple[str, ...]] = ("m/s", "m/s")


@dataclass(frozen=True)
class BeddoesLeishman(UnsteadyAirfoil):
    """All of it, four states: Beddoes and Leishman's model as Hansen, Gaunaa and Madsen have it."""

    pressure_lag: ClassVar[bool] = True
    separation: ClassVar[bool] = True
    state_units: ClassVar[tuple[str, ...]] = ("m/s", "m/s", "1", "1")


@dataclass(frozen=True)
class OyeStall(UnsteadyAirfoil):
    """The separation alone, one state, delayed by 4 c / W: Oye (1991), in Hansen (2008), section 9.3.

    Lift follows f; drag and moment are those of the polar. The angle of attack is that at three quarters of the chord.
    """

    wake_lags: ClassVar[bool] = False
    separation: ClassVar[bool] = True
    state_units: ClassVar[tuple[str, ...]] = ("1",)
    separation_time: float = 8.0


AIRFOIL_MODELS: dict[str, AirfoilModel] = {
    "steady": STEADY, "attached": AttachedFlow(), "beddoes_leishman": BeddoesLeishman(), "oye": OyeStall(),
}  # fmt: skip
"""The airfoil models by the words of a model file."""


@lru_cache(maxsize=64)
def _of(foil: Airfoil) -> Separation:
    return separation(foil)


def _list(numbers: Sequence[float]) -> str:
    return "{" + ", ".join(repr(float(x)) for x in numbers) + "}"


def _root(f: np.ndarray) -> np.ndarray:
    """Square root; a parabola below 0.01, and its slope below 0, so that a slope exists everywhere."""
    low = 0.1 * (1.5 * f / 0.01 - 0.5 * (np.maximum(f, 0) / 0.01) ** 2)
    return np.where(f >= 0.01, np.sqrt(np.maximum(f, 0)), low)
