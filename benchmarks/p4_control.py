"""Four control strategies on the optimised 10-MW spar: `python benchmarks/p4_control.py FOLDER [PART ...]`.

The strategies of J.M. Hegseth, E.E. Bachynski and J.R.R.A. Martins: no feedback (CS1), feedback of the platform's pitch
rate (CS2), of the nacelle's velocity (CS3), and of that velocity through a low-pass (CS4), which move the set point of
the rotor speed. Parts: `sweep` varies the feedback gain, `best` finds the gains of each with which fatigue asks for the
least steel in the tower, `front` does so at falling limits of the speed, `zeros` has the zeros from blade pitch to
rotor speed, `runs` steps through time, `plot` draws docs/figures/p4_control.png. Results are kept in FOLDER/*.json;
what is there already is not computed again. Prints the tables of docs/p4_control.md.
"""

from __future__ import annotations

import json
import sys
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pages import markdown
from scipy.linalg import eigvals
from scipy.optimize import minimize

import fowtlib as fw
from fowtlib.metocean import likely_states, site

CONTROL = "rna.turbine.control."
TOWER = ["tower_base_moment", *(f"tower_moment_node_{k}" for k in range(1, 11))]
RESULTS = [*TOWER, "rotor_speed", "blade_pitch", "pitch", "surge"]
MEASURED = ["pitch_rate", "nacelle_velocity"]  # rad/s, m/s
RATED_SPEED = 480 * np.pi / 30  # of the generator
LIFE, FACTOR, EXPONENT, INTERCEPT = 20 * 365.25 * 86400.0, 2.0, 5.0, 15.606  # of the tower; D curve in air
HOUR, CHARACTERISTIC = 3600.0, float(np.exp(-1))  # the most probable largest value of an hour
SPEED_LIMIT, DUTY_LIMIT = 6.33e-2, 7.65e-3  # rad/s and 1, weighted
PITCH_RATE = "10 deg/s"
RATED = 12.0  # m/s; below, the torque is K Omega^2 and the blades do not pitch
EXTREMES = {"EC1": (13.0, 8.1, 14.0, 0.17), "EC2": (21.0, 9.9, 15.0, 0.14), "EC3": (50.0, 15.1, 16.0, 0.12)}
FEEDBACK = {
    "CS1": (),
    "CS2": ("feedback.pitch_rate_gain",),
    "CS3": ("feedback.velocity_gain",),
    "CS4": ("feedback.filtered_gain", "feedback.filter_frequency"),
}
SPEED_GAINS = (CONTROL + "proportional_gain", CONTROL + "integral_gain")
START = {SPEED_GAINS[0]: 0.003588, SPEED_GAINS[1]: 0.00033, "feedback.filter_frequency": 0.2}
Gains = dict[str, float]


class Loop:
    """The response in one state with any gains, exactly: they act on three states, from four signals.

    H = H_d + H_u (1 - K H_su)^-1 K H_sd, with the transfer functions of the response without feedback from what drives
    it (d) and from the rates of blade pitch, integral and filter (u) to the results and the signals (s). The gains of
    the drag are those of the response without feedback.
    """

    def __init__(self, one: fw.Response):
        self.frequency, self.mean, self.units = one.frequency, one.mean, one.units
        self.outputs, self.driving = one.outputs, dict(one.driving)
        A, C = (np.asarray(one.linear.matrices[name]) for name in "AC")
        C = C[: len(one.outputs)]
        self.A, states = A, list(one.linear.states)
        pitch, integral, speed, filtered, self.angle = (
            states.index(n) for n in (CONTROL + "pitch.pitch", CONTROL + "pitch.integral", CONTROL + "speed_filter.x",
                                      "feedback.filtered", "motion.pitch"))  # fmt: skip
        unit = np.eye(len(A))
        self.into = unit[:, [pitch, integral, filtered]]
        measured = [one.outputs.index(n) for n in MEASURED]
        self.seen = np.vstack([unit[speed], C[measured], unit[filtered]])
        self.by_gain = A[pitch, speed] / START[SPEED_GAINS[0]], A[integral, speed] / START[SPEED_GAINS[1]]
        values, right = np.linalg.eig(A)
        left = np.linalg.inv(right)
        shares = 1 / (2j * np.pi * self.frequency[:, None] - values)
        among = lambda out, into: np.einsum("mk,qk,kn->qmn", out @ right, shares, left @ into, optimize=True)  # noqa: E731
        self.H_u, self.H_su = among(C, self.into), among(self.seen, self.into)
        self.H_d, self.H_sd = dict(one.transfer), {}
        s = (2j * np.pi * self.frequency)[:, None]
        for path, H in one.transfer.items():
            speed = H[:, one.outputs.index("rotor_speed")] * 50 * np.pi / 30
            rate, velocity = (H[:, k] for k in measured)
            w, f = 2 * np.pi * 1.25, START["feedback.filter_frequency"]  # corners of both filters
            self.H_sd[path] = np.stack([speed * w / (w + s), rate, velocity, velocity * f / (f + s)], axis=1)

    def gains(self, gains: Gains) -> np.ndarray:
        """K (3, 4): what is added to the rates of pitch, integral and filter, by the four signals."""
        p, i = (gains.get(path, START[path]) for path in SPEED_GAINS)
        change = [gains.get("feedback." + n, 0.0) for n in ("pitch_rate_gain", "velocity_gain", "filtered_gain")]
        share, corner = gains.get(CONTROL + "integrated_change", 0.0), gains.get("feedback.filter_frequency", 0.2)
        K = np.zeros((3, 4))
        K[0] = self.by_gain[0] * np.array([p - START[SPEED_GAINS[0]], *(-RATED_SPEED * p * np.array(change))])
        K[1] = self.by_gain[1] * np.array([i - START[SPEED_GAINS[1]], *(-RATED_SPEED * share * i * np.array(change))])
        K[2, 2:] = np.array([1.0, -1.0]) * (corner - 0.2)
        return K

    def closed(self, gains: Gains) -> tuple[fw.Response, np.ndarray]:
        """The response and A with these gains. Raises ModelError where it is unstable."""
        K = self.gains(gains)
        A = self.A + self.into @ K @ self.seen
        if np.linalg.eigvals(A).real.max() > 1e-9:
            raise fw.ModelError("the closed loop is unstable.")
        back = np.linalg.solve(np.eye(3) - K @ self.H_su, np.broadcast_to(K, (len(self.frequency), 3, 4)))
        transfer = {path: H + self.H_u @ (back @ self.H_sd[path]) for path, H in self.H_d.items()}
        shares = {path: ((H @ self.driving[path]) * H.conj()).sum(axis=2).real.T for path, H in transfer.items()}
        one = fw.Response(self.frequency, self.outputs, self.units, self.mean, shares, transfer, None, None, 0,
                          self.driving)  # fmt: skip
        return one, A


@dataclass
class Spar:
    """The spar in operation, below and above rated wind, and in a storm, with any gains.

    One response in each state is enough: gains act above rated wind alone, and there by `Loop`. exact: a response with
    the gains themselves instead, with their own drag.
    """

    sizes: dict[str, Any] = field(default_factory=dict)
    exact: bool = False

    def __post_init__(self) -> None:
        self.above = compiled("dtu10mw_p4")
        self.below = compiled("dtu10mw_p4", "constant_power")
        self.parked = compiled("dtu10mw_spar_3_parked")
        found = likely_states(site("northern_north_sea").at(119), range(1, 30, 2))
        self.states = [(u, h, t, 0.14 * (0.75 * u + 5.6) / u) for u, h, t in found]
        self.shares = found.weights
        values = self.above.parameter_values() | self.sizes
        self.z, self.D, self.t = (np.array(values[f"tower_{n}"], float) for n in ("heights", "diameters", "walls"))
        self._kept: dict[tuple[float, ...], Any] = {}

    def numbers(self, state: tuple[float, float, float, float], gains: Gains, brief: bool = False) -> dict[str, Any]:
        """Deviations, ranges of the tower, duty cycle in one state; not brief: means, extremes, pole of pitch too."""
        controlled = RATED < state[0] <= 25.0
        if controlled and self.exact:
            one = self._response(state, gains)
            return _numbers(one, np.asarray(one.linear.A), list(one.linear.states).index("motion.pitch"))
        if state not in self._kept:
            one = self._response(state, {})
            self._kept[state] = Loop(one) if controlled else _numbers(one)
        kept = self._kept[state]
        if not controlled:
            return kept
        one, A = kept.closed(gains)
        return _numbers(one, A, kept.angle, brief)

    def _response(self, state: tuple[float, float, float, float], gains: Gains) -> fw.Response:
        speed, height, period, intensity = state
        given = {"wind.mean_speed": speed, "wind.turbulence_intensity": intensity,
                 "sea.significant_wave_height": height, "sea.peak_period": period}  # fmt: skip
        if 4.0 <= speed <= 25.0:
            plant = self.above if speed > RATED else self.below
            return fw.response(plant, outputs=[*RESULTS, *MEASURED], parameters=given | self.sizes | gains)
        given |= self._in_a_storm() | {"thrust": 188.7e3 * (speed / 50.0) ** 2}
        names = [n for n in RESULTS if n in self.parked.outputs]
        return fw.response(self.parked, outputs=names, parameters=given)

    def _in_a_storm(self) -> dict[str, Any]:
        """Sizes of the hull in a storm; both models have a station at the water line."""
        own = {n: v for n, v in self.sizes.items() if n in self.parked.parameter_values()}
        given = self.above.parameter_values() | self.sizes
        return own | {name: given[name] for name in ("hull_heights", "hull_diameters", "hull_walls")}

    def balance(self) -> float:
        """Let the ballast fill to a heave of zero at rest [kg]."""
        calm = {"sea.spectrum": "still", "wind.kind": "steady", "wind.mean_speed": 0.0, "thrust": 0.0}
        rest = self.parked.equilibrium(parameters=self._in_a_storm() | calm, free=["ballast"], targets={"heave": 0.0})
        self.sizes["ballast"] = float(rest.parameters["ballast"])
        return self.sizes["ballast"]

    def judged(self, gains: Gains) -> dict[str, Any]:
        """What counts over the fifteen states."""
        each = [self.numbers(state, gains, brief=True) for state in self.states]
        weighted = lambda number: float(self.shares @ [number(one) for one in each])  # noqa: E731
        ranges = np.array([one["range"] for one in each])
        section = np.pi * ((self.D - self.t) / 2) ** 2 * self.t
        # of a stress that goes with 1/t; thickness counts beyond 25 mm
        thick = np.maximum(self.t, 0.025) / 0.025
        use = FACTOR * LIFE / 10**INTERCEPT * (self.shares @ (ranges / section * 1e-6 * thick**0.2) ** EXPONENT)
        return {
            "speed": weighted(lambda one: one["std"].get("rotor_speed", 0.0) * np.pi / 30),
            "duty": weighted(lambda one: one["duty"]),
            "pitch": weighted(lambda one: one["std"]["pitch"]),
            "moment": weighted(lambda one: one["std"]["tower_base_moment"]),
            "use": use.tolist(),
            "walls": needed_walls(use, self.t).tolist(),
        }  # fmt: skip

    def moments(self, state: tuple[float, float, float, float], gains: Gains) -> np.ndarray:
        """The largest bending moments at the joints of the tower in one state [N m] (11,)."""
        return 1e6 * np.array([self.numbers(state, gains)["largest"][n] for n in TOWER])

    def steel(self, walls: Any) -> float:
        """Mass of the tower [kg] with walls at its stations."""
        t = np.asarray(walls)
        fine = np.linspace(self.z[0], self.z[-1], 2001)
        D, t = np.interp(fine, self.z, self.D), np.interp(fine, self.z, t)
        return float(8500.0 * np.pi * np.trapezoid((D - t) * t, fine))

    def platform_pitch(self, speed: float, gains: Gains) -> tuple[float, float]:
        """Natural frequency [rad/s] and damping ratio of the platform's pitch, in one of the states above rated."""
        found = self.numbers(next(s for s in self.states if s[0] == speed), gains)["pole"]
        return float(abs(found)), float(-found.real / abs(found))


def compiled(name: str, region_3: str | None = None) -> Any:
    """A compiled model; the same one for the same question."""
    if (name, region_3) not in _PLANTS:
        given = {} if region_3 is None else {CONTROL + "region_3": region_3}
        _PLANTS[name, region_3] = fw.load(name, set=given).compile()
    return _PLANTS[name, region_3]


_PLANTS: dict[tuple[str, str | None], Any] = {}


def _numbers(one: fw.Response, A: np.ndarray | None = None, angle: int = 0, brief: bool = False) -> dict[str, Any]:
    names = [n for n in RESULTS if n in one.outputs]
    counted = {
        "std": {n: one.std(n) for n in names if n not in TOWER[1:]},
        "range": [1e6 * one.equivalent_load(n, EXPONENT) for n in TOWER],
        "duty": one.duty_cycle("blade_pitch", PITCH_RATE) if "blade_pitch" in names else 0.0,
    }
    if brief:
        return counted
    return counted | {
        "mean": {n: one.mean_of(n) for n in names},
        "largest": {n: max(one.extreme(n, HOUR, CHARACTERISTIC), -one.extreme(n, HOUR, CHARACTERISTIC, "min"))
                    for n in names},
        "pole": pitch_pole(A, angle) if A is not None else 0j,
    }  # fmt: skip


def pitch_pole(A: np.ndarray, angle: int) -> complex:
    """The pole that oscillates in which the platform's pitch, a state, takes part most."""
    values, right = np.linalg.eig(A)
    part = np.abs(right[angle] * np.linalg.inv(right)[:, angle]) * (values.imag > 0)
    return complex(values[np.argmax(part)])


def needed_walls(use: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Walls with which a use is one: stress goes with max(t, 25 mm)^0.2 / t."""
    allowed = np.maximum(walls, 0.025) ** 0.2 / walls * use ** (-1 / EXPONENT)
    return np.where(allowed < 0.025**-0.8, allowed**-1.25, 0.025**0.2 / allowed)


def words(gains: Gains) -> dict[str, float]:
    """Gains as in the tables: those of the rotor speed in s and 1."""
    return {path.rpartition(".")[2]: value * (50.0 if path in SPEED_GAINS else 1.0) for path, value in gains.items()}


def row(spar: Spar, gains: Gains) -> dict[str, Any]:
    """Everything that the tables have of one set of gains."""
    found = spar.judged(gains)
    frequency, damping = zip(*(spar.platform_pitch(speed, gains) for speed in (13.0, 17.0, 23.0)), strict=True)
    extremes = {name: spar.numbers(state, gains) for name, state in EXTREMES.items()}
    large = {name: {n: one["largest"][n] for n in ("pitch", "surge", "tower_base_moment")}
             for name, one in extremes.items()}  # fmt: skip
    return found | {"gains": gains, "steel": spar.steel(found["walls"]), "frequency": frequency, "damping": damping,
                    "largest": large}  # fmt: skip


SIZES = {"feedback.pitch_rate_gain": 5.0, "feedback.velocity_gain": 0.05, "feedback.filtered_gain": 0.2}


def best(spar: Spar, name: str, starts: list[Gains], limits: tuple[float, float]) -> Gains:
    """The gains of a strategy with which fatigue asks for the least steel, within limits of speed and duty cycle."""
    paths = [*SPEED_GAINS, *FEEDBACK[name]]
    known: dict[tuple[float, ...], np.ndarray] = {}

    def read(x: np.ndarray) -> Gains:
        """Gains from numbers near one: logarithms of what is positive, and feedback over its size."""
        return {p: float(x[k] * SIZES[p] if p in SIZES else START[p] * np.exp(x[k])) for k, p in enumerate(paths)}

    def numbers(x: np.ndarray) -> np.ndarray:
        """Steel over 1000 t, and what is left to the limits; where it is unstable, far beyond them."""
        key = tuple(np.round(x, 9))
        if key not in known:
            try:
                found = spar.judged(read(x))
                known[key] = np.array([spar.steel(found["walls"]) / 1e6, 1 - found["speed"] / limits[0],
                                       1 - found["duty"] / limits[1]])  # fmt: skip
            except fw.ModelError:
                known[key] = np.array([3.0, -1.0, -1.0])
        return known[key]

    def slopes(x: np.ndarray) -> np.ndarray:
        return np.array([(numbers(x + 1e-4 * e) - numbers(x)) / 1e-4 for e in np.eye(len(x))]).T

    bounds = [(-20.0, 5.0) if p in SIZES else (-2.5, 2.5) for p in paths]
    ends = []
    for start in starts:
        begin = [start.get(p, 0.0) / SIZES[p] if p in SIZES else np.log(start.get(p, START[p]) / START[p])
                 for p in paths]  # fmt: skip
        found = minimize(
            lambda x: 100 * numbers(x)[0], begin, jac=lambda x: 100 * slopes(x)[0], method="SLSQP", bounds=bounds,
            constraints={"type": "ineq", "fun": lambda x: numbers(x)[1:], "jac": lambda x: slopes(x)[1:]},
            options={"maxiter": 40, "ftol": 1e-4},
        )  # fmt: skip
        value = numbers(found.x)
        print(name, limits, found.message, found.nit, len(known), words(read(found.x)), value, flush=True)
        if value[1:].min() > -1e-4:
            ends.append((value[0], read(found.x)))
    if not ends:
        raise fw.ModelError(f"{name} has no gains within {limits}.")
    return min(ends, key=lambda end: end[0])[1]


def slow_zeros(loop: Loop, gains: Gains) -> np.ndarray:
    """Zeros below 1 rad/s, with positive imaginary part, from blade pitch to rotor speed, of the loop with gains."""
    A = loop.A + loop.into @ loop.gains(gains) @ loop.seen
    n = len(A)
    pencil = np.block([[A, loop.into[:, :1]], [loop.seen[:1], np.zeros((1, 1))]])
    mass = np.eye(n + 1)
    mass[n, n] = 0.0
    found = eigvals(pencil, mass)
    found = found[np.isfinite(found)]
    return np.sort_complex(found[(np.abs(found) < 1.0) & (found.imag > 0.02)])


def starts_of(name: str, more: list[Gains]) -> list[Gains]:
    """Weak and strong gains, and those given."""
    feedback = {path: -SIZES[path] / 2 for path in FEEDBACK[name][:1]}
    p, i = SPEED_GAINS
    made = [{p: START[p] * a, i: START[i] * b} | {k: v * c for k, v in feedback.items()}
            for a, b, c in ((1.5, 0.5, 1.0), (3.0, 2.0, 2.0))]  # fmt: skip
    return [*made, *more]


def front(spar: Spar, limits: list[float], duty: float) -> dict[str, list[dict[str, Any]]]:
    """Rows of each strategy at falling limits of the speed; where there are no gains, none."""
    rows: dict[str, list[dict[str, Any]]] = {}
    for name in FEEDBACK:
        rows[name], last = [], None
        for limit in limits:
            begin = starts_of(name, []) if last is None else [last]
            at = len(rows[name])
            begin += [rows["CS1"][at]["gains"]] if name != "CS1" and len(rows["CS1"]) > at else []
            try:
                last = best(spar, name, begin, (limit, duty))
            except fw.ModelError as error:
                print(error, flush=True)
                break
            rows[name].append(row(spar, last) | {"limit": limit})
    return rows


def sweep(spar: Spar) -> list[dict[str, Any]]:
    """Rows over the feedback gain with the speed gains as they are."""
    some: list[Gains] = [{}]
    some += [{"feedback.pitch_rate_gain": k} for k in (5.0, -5.0, -10.0, -20.0, -40.0)]
    some += [{"feedback.velocity_gain": k} for k in (-0.05, -0.1, -0.2, -0.4)]
    some += [{"feedback.filtered_gain": k, "feedback.filter_frequency": w}
             for w in (0.1, 0.2, 0.4) for k in (-0.05, -0.1, -0.2, -0.4)]  # fmt: skip
    found = []
    for gains in some:
        try:
            found.append(row(spar, gains))
        except fw.ModelError as error:
            print(gains, error, flush=True)
    return found


def curves(spar: Spar, speed_gains: Gains) -> dict[str, list[list[float]]]:
    """By a name: feedback gain, steel [t], duty cycle, deviation of the speed [rad/s], with the gains of the speed."""
    cases: dict[str, tuple[str, Gains, list[float]]] = {
        "CS2": ("feedback.pitch_rate_gain", {}, [4.0, 0.0, -2.0, -4.0, -8.0, -12.0, -16.0]),
        "CS3": ("feedback.velocity_gain", {}, [0.04, 0.0, -0.02, -0.04, -0.08, -0.12, -0.16]),
    }
    for corner in (0.05, 0.1, 0.2, 0.4):
        values = [0.1, 0.0, -0.1, -0.2, -0.4, -0.7, -1.0]
        cases[f"CS4, {corner:g} rad/s"] = "feedback.filtered_gain", {"feedback.filter_frequency": corner}, values
    found: dict[str, list[list[float]]] = {}
    for name, (path, more, values) in cases.items():
        found[name] = []
        for value in values:
            try:
                one = spar.judged({**speed_gains, **more, path: value})
            except fw.ModelError:
                continue
            found[name].append([value, spar.steel(one["walls"]) / 1e3, one["duty"], one["speed"]])
    return found


def plot(spar: Spar, folder: Path, path: Path) -> None:
    """Steel and duty cycle over the feedback gain, and spectra of the moment of the tower's base at 17 m/s."""
    import matplotlib.pyplot as plt

    each = {n: json.loads((folder / f"{n}.json").read_text()) for n in FEEDBACK}
    drawn = kept(folder, "curves", lambda: curves(spar, {p: each["CS1"]["gains"][p] for p in SPEED_GAINS}))
    figure, (steel, spectra) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for k, (name, rows) in enumerate(drawn.items()):
        _, mass, duty, _ = np.array(rows).T
        order = np.argsort([-r[0] for r in rows])
        steel.plot(1e3 * duty[order], mass[order], "o-", ms=3, color=f"C{k}", label=name)
    steel.axvline(1e3 * DUTY_LIMIT, color="0.5", lw=0.8, ls="--")
    steel.set(xlabel="duty cycle [1e-3]", ylabel="steel of the tower by fatigue [t]", xlim=(2, 16), ylim=(900, 1000))
    steel.legend(frameon=False, fontsize=8)
    state = next(s for s in spar.states if s[0] == 17.0)
    spar.numbers(state, {})
    for name, one in each.items():
        found, _ = spar._kept[state].closed(one["gains"])
        spectrum = found.spectrum("tower_base_moment")
        spectra.loglog(2 * np.pi * spectrum.frequency, spectrum.density / (2 * np.pi), label=name, lw=1)
    spectra.set(xlim=(0.02, 2), ylim=(1, 3e5), xlabel="frequency [rad/s]",
                ylabel="base moment, 17 m/s [(MN m)^2 s/rad]")  # fmt: skip
    spectra.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=130)
    for name, rows in drawn.items():
        print(name, [[round(v, 5) for v in r] for r in rows])


def table(rows: dict[str, dict[str, Any]], base: dict[str, Any]) -> str:
    heads = ("gains", "rotor speed [rad/s]", "duty cycle [1e-3]", "platform pitch [deg]", "tower base [MN m]",
             "use of the base", "largest use", "steel [t]", "pitch mode at 13, 17, 23 m/s [rad/s]", "damping ratio",
             "pitch in EC1, EC2, EC3 [deg]", "moment in EC1, EC2, EC3 [MN m]")  # fmt: skip
    lines = []
    for name, one in rows.items():
        many = lambda values, digits: ", ".join(f"{v:.{digits}f}" for v in values)  # noqa: E731
        lines.append((name, f"{one['speed']:.4f}", f"{1e3 * one['duty']:.2f}", f"{one['pitch']:.3f}",
                      f"{one['moment']:.2f}", f"{one['use'][0]:.2f}", f"{max(one['use']):.2f}",
                      f"{one['steel'] / 1e3:.0f} ({100 * (one['steel'] / base['steel'] - 1):+.1f} %)",
                      many(one["frequency"], 3), many(one["damping"], 2),
                      many([one["largest"][e]["pitch"] for e in EXTREMES], 1),
                      many([one["largest"][e]["tower_base_moment"] for e in EXTREMES], 0)))  # fmt: skip
    return markdown((heads, lines), 3)


def label(gains: Gains) -> str:
    return ", ".join(f"{name} {value:.4g}" for name, value in words(gains).items()) or "no feedback"


def kept(folder: Path, name: str, make: Any) -> Any:
    """What a file has, or what is made now and kept there."""
    file = folder / f"{name}.json"
    if not file.exists():
        made = make()
        file.write_text(json.dumps(made, indent=1))
    return json.loads(file.read_text())


def runs(folder: Path, seeds: int = 3, duration: float = 2100.0) -> str:
    """CS1 and CS4 at 17 m/s in the nonlinear model, and the response over it; 300 s left out of each run."""
    plant, lines = compiled("dtu10mw_p4"), []
    names = ["rotor_speed", "pitch", "blade_pitch_rate", "tower_base_moment", "tower_moment_node_5"]
    weather = {"wind.mean_speed": 17.0, "wind.turbulence_intensity": 0.1511,
               "sea.significant_wave_height": 4.09, "sea.peak_period": 10.14}  # fmt: skip
    for name in ("CS1", "CS4"):
        given = weather | json.loads((folder / f"{name}.json").read_text())["gains"]
        linear, found = fw.response(plant, outputs=names, parameters=given), []
        for seed in range(1, seeds + 1):
            run = plant.simulate(duration, 0.25, parameters=given | {"wind.seed": seed, "sea.seed": 100 + seed},
                                 outputs=names, solver="fixed", step=0.05)  # fmt: skip
            late = np.asarray(run.time) > 300.0
            loads = [float(fw.damage_equivalent_load(run[n], EXPONENT, discard=300.0)) for n in names[3:]]
            found.append([*(float(np.asarray(run[n])[late].std()) for n in names), *loads])
        mean, scatter = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(seeds)
        lines.append((name, *(f"{m:.4g} +- {s:.2g}" for m, s in zip(mean, scatter, strict=True))))
        also = [*(linear.std(n) for n in names), *(linear.equivalent_load(n, EXPONENT) for n in names[3:])]
        lines.append(("response over runs", *(f"{v / m:.2f}" for v, m in zip(also, mean, strict=True))))
    return markdown((("", *names, *(f"range of {n}" for n in names[3:])), lines), 4)


def main() -> None:
    folder, asked = Path(sys.argv[1]), sys.argv[2:] or ["sweep", "best", "front"]
    folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    spar = Spar()
    if "sweep" in asked:
        rows = kept(folder, "sweep", lambda: sweep(spar))
        print(table({label(one["gains"]): one for one in rows}, rows[0]), flush=True)
    if "best" in asked:
        found: dict[str, dict[str, Any]] = {}
        for name in FEEDBACK:
            more = [found["CS1"]["gains"]] if found else []
            found[name] = kept(folder, name, lambda n=name, m=more: row(
                spar, best(spar, n, starts_of(n, m), (SPEED_LIMIT, DUTY_LIMIT))))  # fmt: skip
        print(table({f"{n}: {label(one['gains'])}": one for n, one in found.items()}, found["CS1"]), flush=True)
    if "runs" in asked:
        print(runs(folder), flush=True)
    if "plot" in asked:
        plot(spar, folder, Path(__file__).parent.parent / "docs" / "figures" / "p4_control.png")
    if "zeros" in asked:
        rows = []
        for state in spar.states:
            if RATED < state[0] <= 25.0:
                spar.numbers(state, {})
                each = [slow_zeros(spar._kept[state], json.loads((folder / f"{n}.json").read_text())["gains"])
                        for n in FEEDBACK]  # fmt: skip
                rows.append((state[0], *(", ".join(f"{z:.4f}" for z in one) for one in each)))
        print(markdown((("wind [m/s]", *FEEDBACK), rows), 3), flush=True)
    if "front" in asked:
        limits = [SPEED_LIMIT, 0.055, 0.05, 0.0475, 0.045, 0.0425, 0.04]
        fronts = kept(folder, "front", lambda: front(spar, limits, DUTY_LIMIT))
        for limit in limits:
            print(limit, {n: [(round(one["steel"] / 1e3, 1), round(1e3 * one["duty"], 2)) for one in rows
                              if one["limit"] == limit] for n, rows in fronts.items()})  # fmt: skip


if __name__ == "__main__":
    main()
