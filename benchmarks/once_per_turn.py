"""The once-per-turn flapwise moment of the NREL 5 MW by a second model of its blades: tables of docs/skewed_wake.md.

Elastic blades on a hub that turns at a constant speed and is held at the tilt and mean pitch of oc3_spar, in steady
uniform wind: periodic deflections from modes of a beam (two flapwise and one edgewise of OpenFAST's ElastoDyn, or
more), by virtual work, with forces of the blade-element rotor and d'Alembert's of the exact motion. No line is shared
with the blades of hinges. python benchmarks/once_per_turn.py
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.polynomial import legendre
from pages import fill, markdown
from scipy.integrate import cumulative_trapezoid

from fowtlib.components.aero import BladeElementRotor, bem_numpy, read_blade
from fowtlib.components.aero.bem_steady import _about
from fowtlib.components.mechanics.beam_properties import read_beam
from fowtlib.modelfile import data_path

PAGE = Path(__file__).parents[1] / "docs" / "skewed_wake.md"
CASES = {8.0: (9.086, 7.65), 11.4: (11.94, 10.02)}  # wind [m/s]: speed [rpm], tilt and pitch [deg] of oc3_spar
HUB, CONE, GRAVITY, DAMPING = 1.5, np.radians(2.5), 9.80665, 0.00225
MODES = ({2: 0.0622, 3: 1.7254, 4: -3.2452, 5: 4.7131, 6: -2.2555},
         {2: -0.5809, 3: 1.2067, 4: -15.5349, 5: 29.7347, 6: -13.8255},
         {2: 0.3627, 3: 2.5337, 4: -3.5772, 5: 2.376, 6: -0.6952})  # fmt: skip
"""Mode shapes of ElastoDyn, two flapwise, one edgewise: NRELOffshrBsline5MW_Blade.dat of rosco 2.10.6 (Apache-2.0)."""


def blade():
    """The elements of the blade."""
    files = (str(data_path(f"nrel5mw/{name}.csv")) for name in ("blade_aerodynamics", "airfoils"))
    return read_blade(*files, HUB, 63.0)


class Beam:
    """Shapes of a bent blade in the axes of its root: curvatures, slopes and deflections (modes, stations)."""

    def __init__(self, functions: int | None):
        table = read_beam(str(data_path("nrel5mw/blade_structure.csv")))
        self.s = s = np.linspace(0, 61.5, 247)
        self.mass = table.at("mass_per_length", s) * np.gradient(s)
        self.mass[[0, -1]] /= 2
        stiff, twist = (table.at("stiffness_x", s), table.at("stiffness_y", s)), table.at("twist", s)
        if functions is None:
            bent = [sum(c * k * (k - 1) * (s / 61.5) ** (k - 2) for k, c in m.items()) / 61.5**2 for m in MODES]
            flap, edge = bent[:2], bent[2:]
        else:
            loads = [legendre.legval(2 * s / 61.5 - 1, np.eye(functions)[i]) * (1 - s / 61.5) ** 2
                     for i in range(functions)]  # fmt: skip
            flap, edge = ([1e6 * load / EI for load in loads] for EI in stiff)
        flap, edge = np.array(flap), np.array(edge)
        n, m = len(flap), len(edge)
        weight = np.gradient(s)
        self.K = np.zeros((n + m, n + m))
        self.K[:n, :n] = np.einsum("is,js,s->ij", flap, flap, stiff[0] * weight)
        self.K[n:, n:] = np.einsum("is,js,s->ij", edge, edge, stiff[1] * weight)
        c, d = np.cos(twist), np.sin(twist)
        curved = np.array([np.vstack([c * flap, d * edge]), np.vstack([-d * flap, c * edge])])
        self.slope = cumulative_trapezoid(curved, s, axis=-1, initial=0)  # (2, modes, stations)
        self.shape = cumulative_trapezoid(self.slope, s, axis=-1, initial=0)

    def place(self, q):
        """Points (turns, stations, 3) and slopes (2, turns, stations), with the shortening of the bent axis."""
        x, y = (q @ shape for shape in self.shape)
        slopes = np.array([q @ slope for slope in self.slope])
        z = self.s - cumulative_trapezoid((slopes**2).sum(0), self.s, initial=0) / 2
        return np.stack([x, y, z + HUB], -1), slopes


@dataclass
class Periodic:
    """One blade of three at `turns` azimuths; `moment` [kN m] about its root, flapwise, and what it is made of."""

    wind: float
    rotor: BladeElementRotor
    beam: Beam
    bent: bool = True
    turns: int = 12
    loads: Callable | None = None
    parts: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self):
        rpm, tilt = CASES[self.wind]
        self.speed, self.hub = rpm * np.pi / 30, _about("y", np.radians(tilt))
        self.psi = 2 * np.pi * np.arange(self.turns) / self.turns
        self.roots = np.array([self.hub @ _about("x", p) @ _about("y", -CONE) for p in self.psi])
        self.order = np.fft.fftfreq(self.turns, 1 / self.turns)
        self._solve()

    def _rate(self, x, times=1):
        order = np.where(np.abs(self.order) * 2 == self.turns, 0, self.order) if times == 1 else self.order
        factor = (1j * order * self.speed) ** times
        return np.real(np.fft.ifft(factor.reshape(-1, *[1] * (x.ndim - 1)) * np.fft.fft(x, axis=0), axis=0))

    def _solve(self):
        b, n = self.beam, len(self.beam.K)
        radius = b.s + HUB
        M = np.einsum("kis,kjs,s->ij", b.shape, b.shape, b.mass)
        tension = np.cumsum((b.mass * radius)[::-1])[::-1] * np.gradient(b.s)
        G = np.einsum("kis,kjs,s->ij", b.slope, b.slope, tension)
        own = self.rotor.blade
        chord = np.interp(b.s, own.radius - HUB, own.chord)
        air = 3.85 * chord * self.speed * radius * np.gradient(b.s) * (b.s > 8)
        C = np.einsum("is,js,s->ij", b.shape[0], b.shape[0], air)
        q = np.zeros((self.turns, n))
        for _ in range(60):
            Q = self._forces(q)
            if not self.bent:
                break
            rest = np.fft.fft(Q - DAMPING * self._rate(q) @ b.K - q @ b.K, axis=0)
            for k, order in enumerate(self.order):
                w = order * self.speed
                A = b.K * (1 + 1j * w * DAMPING) - w**2 * M + 1j * w * C + self.speed**2 * G
                rest[k] = np.linalg.solve(A, rest[k]) if abs(order) <= 4 else 0
            step = np.real(np.fft.ifft(rest, axis=0))
            q += 0.9 * step
            if np.abs(step @ b.shape[0][:, -1]).max() < 1e-5:
                break
        else:
            raise RuntimeError("the deflections do not settle")
        self.tip = float((q @ b.shape[0][:, -1]).mean())
        self.moment = sum(self.parts.values())

    def _forces(self, q):
        b, own = self.beam, self.rotor.blade
        points, slopes = b.place(q)
        world = np.einsum("nij,nsj->nsi", self.roots, points)
        inertia = -b.mass[:, None] * self._rate(world, 2)
        weight = np.broadcast_to(b.mass[:, None] * np.array([0, 0, -GRAVITY]), world.shape)
        at = own.radius - HUB
        nodes, axes = self._nodes(at, points, slopes)
        air = self._air(nodes, axes)
        root = self.roots @ [0, 0, HUB]
        of_all = (("air", nodes, air[..., :3]), ("gravity", world, weight), ("inertia", world, inertia))
        for name, places, force in of_all:
            moment = np.cross(places - root[:, None], force).sum(1) + (air[..., 3:].sum(1) if name == "air" else 0)
            self.parts[name] = np.einsum("nji,nj->ni", self.roots, moment)[:, 1] / 1e3
        Q = np.zeros_like(q)
        body, blown = (np.einsum("nji,nsj->nsi", self.roots, f) for f in (inertia + weight, air[..., :3]))
        for i in range(len(b.K)):
            down = -cumulative_trapezoid(np.einsum("kns,ks->ns", slopes, b.slope[:, i]), b.s, initial=0)
            Q[:, i] = np.einsum("nsk,ks->n", body[..., :2], b.shape[:, i]) + (body[..., 2] * down).sum(1)
            shape = np.array([np.interp(at, b.s, f) for f in b.shape[:, i]])
            Q[:, i] += np.einsum("nsk,ks->n", blown[..., :2], shape)
            Q[:, i] += np.array([f @ np.interp(at, b.s, d) for f, d in zip(blown[..., 2], down, strict=True)])
        return Q

    def _nodes(self, at, points, slopes):
        own, b = self.rotor.blade, self.beam
        nodes, axes = np.empty((self.turns, len(at), 3)), np.empty((self.turns, len(at), 3, 3))
        for k, R in enumerate(self.roots):
            for i, s in enumerate(at):
                z = np.array([*(np.interp(s, b.s, slope[k]) for slope in slopes), 1.0])
                z /= np.linalg.norm(z)
                x = np.array([1.0, 0, 0]) - z[0] * z
                x /= np.linalg.norm(x)
                section = np.column_stack([x, np.cross(z, x), z])
                place = [np.interp(s, b.s, points[k, :, j]) for j in range(3)]
                nodes[k, i] = R @ (place + section @ [own.curve[i], own.sweep[i], 0])
                axes[k, i] = R @ section @ _about("z", -own.twist[i])
        return nodes, axes

    def _air(self, nodes, axes):
        velocity, third = self._rate(nodes), self.turns // 3
        result = np.empty((*nodes.shape[:2], 6))
        for k, psi in enumerate(self.psi):
            of = [(k + j * third) % self.turns for j in range(3)]
            wind = [self.wind, 0, 0]
            flat = [nodes[of].ravel(), np.swapaxes(axes[of], -1, -2).ravel(), velocity[of].ravel(),
                    np.tile(wind, 3 * nodes.shape[1]), np.zeros(3), (self.hub @ _about("x", psi)).T.ravel(),
                    np.zeros(3), wind, [1.225], self.rotor.blade.chord]  # fmt: skip
            u = np.concatenate(flat)
            found = self.loads(u) if self.loads else self.rotor.external.function(ca.DM(u)).full().ravel()
            result[k] = found[: 6 * 3 * nodes.shape[1]].reshape(3, -1, 6)[0]
        return result


def harmonic(moment: np.ndarray) -> complex:
    """Of once per turn: the part with the cosine of the azimuth (0: up), and with the sine."""
    once = 2 * np.mean(moment * np.exp(1j * 2 * np.pi * np.arange(len(moment)) / len(moment)))
    return complex(once)


def row(name: str, periodic: Periodic) -> tuple:
    """Of a table: the parts and the deviation."""
    once = harmonic(periodic.moment)
    return (f"{periodic.wind:g}", name, f"{once.real:.0f}", f"{once.imag:.0f}", f"{periodic.moment.std():.0f}")


def alternative(rotor: BladeElementRotor, factor=None, growth=0.6, loss=False, swirl=False, sign=1.0, inside=False):
    """Loads of the NumPy twin with the skew in another way.

    With a factor, chi = (1 + growth a) chi_0, times the tip loss, the swirl too, the other sign, or within the balance
    of momentum.
    """
    factor = rotor.skew if factor is None else factor

    class Sections(bem_numpy._Sections):
        def loads(self, skew, flow, given=None):
            Vx, Vt, phi = self.Vx, self.Vt, self.angle()
            h, k = self.induction(phi)
            a, F = 1 - 1 / h, 1.0
            if loss:
                F = np.ones_like(phi)
                for distance in (self.tip, self.hub):
                    F *= np.maximum(2 / np.pi * np.arccos(np.exp(-distance / np.abs(np.sin(phi)))), 1e-4)

            def yaw(a):
                return 1 + sign * factor * F * np.tan((1 + growth * np.clip(a, 0, 1)) * skew[0] / 2) * skew[1]

            ends = yaw(a)
            for _ in range(60 if inside else 0):
                phi = phi + 0.5 * (np.arctan2(Vx * (1 - a * ends), Vt / k) - phi)
                h, k = self.induction(phi)
                a = 1 - 1 / h
                ends = yaw(a)
            U, T = Vx * (1 - a * ends), Vt + Vt * (1 / k - 1) * (ends if swirl else 1)
            lift, drag, moment = flow(np.arctan2(U, T) - self.twist, np.hypot(U, T))
            pressure, W = self.chord / 2 * (U**2 + T**2), np.hypot(U, T)
            s, c = U / W, T / W
            force = pressure * (lift * c + drag * s), pressure * (drag * c - lift * s)
            return *force, pressure * self.chord * moment, a * Vx

    def loads(u):
        kept, bem_numpy._Sections = bem_numpy._Sections, Sections
        try:
            return bem_numpy.loads(rotor, u)
        finally:
            bem_numpy._Sections = kept

    return loads


def main() -> None:
    """Fill the page."""
    rotor = BladeElementRotor(blade(), line_loads="straight_lines")
    few, many = Beam(None), Beam(6)
    heads = ("wind [m/s]", "blades", "cosine [kN m]", "sine [kN m]", "deviation [kN m]")
    structure, skews = [], []
    for wind in CASES:
        base = Periodic(wind, rotor, many)
        structure += [row("6 flapwise and 6 edgewise functions", base),
                      row("ElastoDyn's 2 and 1 modes", Periodic(wind, rotor, few)),
                      row("rigid", Periodic(wind, rotor, many, bent=False)),
                      row("no skewed wake", Periodic(wind, replace(rotor, skew=0.0), many))]  # fmt: skip
        for name, part in base.parts.items():
            once = harmonic(part)
            cells = (f"{once.real:.0f}", f"{once.imag:.0f}", f"{part.std():.0f}")
            structure.append((f"{wind:g}", f"of the first: {name}", *cells))
        for name, how in (("as it is, and as in AeroDyn", {}), ("correction times the tip loss", {"loss": True}),
                          ("chi = chi_0", {"growth": 0.0}), ("15 pi / 64", {"factor": 15 * np.pi / 64}),
                          ("the swirl too", {"swirl": True}), ("within the balance of momentum", {"inside": True}),
                          ("the other sign", {"sign": -1.0})):  # fmt: skip
            skews.append(row(name, Periodic(wind, rotor, few, loads=alternative(rotor, **how))))
    page = PAGE.read_text(encoding="utf-8")
    for name, rows, second in (("structure", structure, "blades"), ("skew", skews, "skewed wake")):
        text = markdown(((heads[0], second, *heads[2:]), rows))
        print(text)
        page = fill(page, name, text)
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
