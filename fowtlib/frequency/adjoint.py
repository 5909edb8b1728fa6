"""Adjoint of a stationary response: slopes of functions of its spectra by the linear model and by what drives it.

With amplitudes d of the inputs, H = C x + D d, (i omega - A) x = B d, and slopes h of a scalar by H,

    (i omega - A)^H lambda = C' h,  slopes by A: Re sum lambda x^H, by B: Re sum lambda d^H, by C: Re sum h x^H,

one solve a frequency with the factors of the response itself. Drag is in the loop by gains G that follow from the
response, G = gain(covariance(G)): its slopes, made once, give the gains to rounding by Newton's iteration, and the
adjoint of the fixed point, (1 - Phi)' g = slope by G, once for all scalars.

Arrays over frequencies have these in the middle, (rows, q, channels), so that what is constant multiplies all at once.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from fowtlib.analysis.spectra import widths
from fowtlib.frequency.answers_to_laws import AnswersToLaws
from fowtlib.frequency.common_sums import CommonSums, Rows
from fowtlib.frequency.drag import best_gain
from fowtlib.frequency.driven import Driving, Grid, frequency_widths
from fowtlib.frequency.gain_slopes import slope_at_mean, stacked_slopes
from fowtlib.frequency.mixing import Mixing
from fowtlib.frequency.quantities import ORDERS
from fowtlib.language.eigenvectors import eigenvectors
from fowtlib.language.errors import SimulationError
from fowtlib.solving.excited import ExcitedModel
from fowtlib.solving.linear import LinearModel, Resolvent, times
from fowtlib.solving.stationary_gradients import Bars

SETTLED, ROUNDING = 1e-12, 1e-10  # change of the gains, relative, at which Newton ends; and where it may stay
FAR = 0.3  # change from which on it goes by the gains found, mixed, and where Newton's step led away
NEWTON = 40
SLOW = 4.0  # a step that divides the change by less than this asks for new slopes, which cost some ten steps
# Where shapes of modes are nearly alike rounding is more than any bound by the roots: a change below NOISE that so many
# iterations have not halved is rounding
NOISE, STALLED = 1e-6, 4
AT_ONCE = 32  # frequencies, of what all laws do to all laws
EXACT = 1e-15  # of the largest share of functions of frequency, below which one is rounding
MANY = 3  # scalars from which on sums that they have in common are made
GUESS = 1.0  # m/s; deviation of the velocities of drag before the first iteration


@dataclass(frozen=True, eq=False)
class Forcing:
    """What drives a response at frequencies (q,) [Hz].

    drive (q, inputs, k): of all channels; density (q, k, k) per Hz, with processes in blocks; columns: of a process;
    driven: numbers of the inputs that it drives.
    """

    frequency: np.ndarray
    drive: np.ndarray
    density: np.ndarray
    columns: Mapping[str, slice]
    driven: Mapping[str, np.ndarray]

    @property
    def widths(self) -> np.ndarray:
        """What each frequency stands for in a covariance [Hz]."""
        return frequency_widths(self.frequency)

    def of(self, process: str | None) -> np.ndarray:
        """The densities of one process alone; None: of all."""
        if process is None:
            return self.density
        part, columns = np.zeros_like(self.density), self.columns[process]
        part[:, columns, columns] = self.density[:, columns, columns]
        return part


@dataclass(frozen=True, eq=False)
class Slopes:
    """Slopes of a scalar by the matrices, by the drive, by the densities, by means of laws.

    drive: of processes, (n, q, k) of the inputs that it drives and of its channels. d scalar = Re sum(conj(drive)
    d drive), and by the densities Re sum(direct d density), direct (q, k, k), with sum(laws d covariance) / 2 of the
    inputs of the laws; see RandomResponse.by_density.
    """

    bars: Bars
    drive: Mapping[str, np.ndarray]
    direct: np.ndarray
    laws: np.ndarray
    means: np.ndarray


@dataclass(frozen=True, eq=False)
class Asked:
    """A scalar: its slopes by the moments of a result, of all processes or of one."""

    result: int
    by_moments: np.ndarray
    process: str | None = None


class RandomResponse:
    """The response of a linear model with the drag of its own response, and its adjoint.

    gains: of the laws of drag, where they are nearly known, and newton: slopes of the fixed point there. Raises
    SimulationError where they do not settle.
    """

    def __init__(self, excited: ExcitedModel, forcing: Forcing, gains: Sequence[np.ndarray] | None = None,
                 newton: np.ndarray | None = None):  # fmt: skip
        self.excited, self.forcing, self.omega = excited, forcing, 2 * np.pi * forcing.frequency
        self.weighted = forcing.density * forcing.widths[:, None, None]
        operators = excited.linear.operators
        self.errors = operators.errors(self.omega) if operators is not None else None
        self.powers = (1j * self.omega)[:, None] ** np.arange(3)
        places = [place for _, place in excited.laws]
        self.means = excited.means
        self.gains = list(gains) if gains is not None else [
            best_gain(GUESS**2 * np.eye(place.stop - place.start), self.means[place]) for place in places
        ]  # fmt: skip
        self.answers: AnswersToLaws | None = None  # by which slopes of the fixed point were made
        self.common: CommonSums | None = None
        self.iterations = 0
        self._settle(newton)
        self._answer()

    # --- forward ---------------------------------------------------------------------------------------------------

    def _settle(self, phi: np.ndarray | None) -> None:
        """Newton's iteration for the gains, with slopes that are kept while it comes nearer fast."""
        last, self.newton, mixing = np.inf, phi, Mixing()
        best, stalled = np.inf, 0
        if not self.excited.laws:
            return
        driving = {path: Driving(self.forcing.driven[path], self.drives[path], self.weighted[:, channels, channels])
                   for path, channels in self.forcing.columns.items()}  # fmt: skip
        grid = Grid(self.excited, self.forcing.frequency, {}, driving)
        for self.iterations in range(NEWTON):
            found = grid.gains(self.gains)
            off = [new - old for new, old in zip(found, self.gains, strict=True)]
            change = max(float(np.linalg.norm(d) / max(np.linalg.norm(g), 1e-12))
                         for d, g in zip(off, found, strict=True))  # fmt: skip
            if change < SETTLED or (change > last / 2 and change < self._rounding):
                return
            best, stalled = (change, 0) if change < best / 2 else (best, stalled + 1)
            if stalled >= STALLED and best < NOISE:
                return
            if change > FAR or change > last:
                self.gains, self.newton = mixing(self.gains, found), None
            else:
                if self.newton is None or change > max(last / SLOW, self._rounding):
                    self._answer()
                    self.newton = self._map()
                step = np.linalg.solve(np.eye(len(self.newton)) - self.newton, self._packed(off))
                self.gains = [g + s for g, s in zip(self.gains, self._unpacked(step), strict=True)]
            last = change
        raise SimulationError(f"the linearised drag does not settle; the last change is {change:.2g}.")

    @property
    def _rounding(self) -> float:
        """Change of the gains that rounding makes: that of roots as large as the fastest, in the least damping."""
        A = self.excited.states_with(self.gains)
        basis = eigenvectors(A) if len(A) else None
        roots = np.zeros(0) if basis is None else basis[0]
        least = -np.max(roots.real[roots.imag > 0], initial=-np.inf)
        return max(ROUNDING, 4 * np.finfo(float).eps * np.abs(roots).max() / least) if 0 < least < np.inf else ROUNDING

    @cached_property
    def phi(self) -> np.ndarray:
        """Slopes of the gains of all laws by those that are put in, at the fixed point."""
        return self._map() if self.excited.laws else np.zeros((0, 0))

    def _answer(self) -> None:
        """Amplitudes of the modes, and outputs, to what each process drives."""
        self.closed = self.excited.with_gains(self.gains)
        A, B, C, D = (self.closed.matrices[name] for name in "ABCD")
        self.resolvent, operators = Resolvent(self.omega, A), self.closed.operators
        size = self.omega.size, self.weighted.shape[1]
        self.three = np.zeros((0, *size), dtype=complex)
        self.amplitudes, self.out = (np.empty((rows, *size), dtype=complex) for rows in (len(A), len(C)))
        for path, channels in self.forcing.columns.items():
            driven, drive = self.forcing.driven[path], self.drives[path]
            self.amplitudes[:, :, channels] = self.resolvent.driven(B[:, driven], drive)
            self.out[:, :, channels] = times(D[:, driven], drive)
        if operators is not None:
            by_w = self.resolvent.between(operators.C, operators.B) + operators.D
            q, n = by_w.shape[:2]
            by_w = np.einsum("qndm,qd->qnm", by_w.reshape(q, n, 3, -1), self.powers)
            self.loop = np.eye(self.errors.shape[1]) - self.errors @ by_w  # (1 - E G), to the outputs w
            u = times(operators.C @ self.resolvent.shapes, self.amplitudes)
            for path, channels in self.forcing.columns.items():
                u[:, :, channels] += times(operators.D_input[:, self.forcing.driven[path]], self.drives[path])
            u = u.transpose(1, 0, 2)
            self.three = self._with_rates(np.linalg.solve(self.loop, self.errors @ u)).transpose(1, 0, 2)
            self.amplitudes += self.resolvent.amplitudes(times(operators.B, self.three))
            self.out += times(operators.D_output, self.three)
        self.out += times(C @ self.resolvent.shapes, self.amplitudes)

    @cached_property
    def x(self) -> np.ndarray:
        """The states (n, q, k), with the gains that were found."""
        return times(self.resolvent.shapes, self.amplitudes)

    def _with_rates(self, w: np.ndarray, part: slice = slice(None)) -> np.ndarray:
        """Outputs of operators (q, m, k), and their rates and those of the rates: (q, 3 m, k)."""
        return (self.powers[part, :, None, None] * w[:, None]).reshape(len(w), -1, w.shape[2])

    def _covariances(self) -> list[np.ndarray]:
        """Of the inputs of each law."""
        u = self.out[self.excited.results :]
        return self._of_each_law(_with_density(u, self.weighted), u)

    def _of_each_law(self, a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
        """Re sum over frequencies, and channels, of a b^H, of the inputs of each law (n, q, ...)."""
        found: list[np.ndarray] = [np.zeros((0, 0))] * len(self.excited.laws)
        for numbers, rows in self.excited.law_rows:
            one, other = (_grouped(of, rows) for of in (a, b))
            for number, block in zip(numbers, one @ other.transpose(0, 2, 1), strict=True):
                found[number] = block
        return found

    def moments(self, result: int, process: str | None = None) -> np.ndarray:
        """Spectral moments of a result, of orders 0, 1, 2 and 4 [unit^2 Hz^n]."""
        H, frequency = self.out[result], self.forcing.frequency
        density = np.einsum("qk,qkl,ql->q", H, self.forcing.of(process), H.conj()).real
        return np.array([np.sum(frequency**n * density * widths(frequency)) for n in ORDERS])

    # --- the fixed point -------------------------------------------------------------------------------------------

    @property
    def _width(self) -> int:
        return max((place.stop - place.start for _, place in self.excited.laws), default=0)

    def _packed(self, blocks: Sequence[np.ndarray]) -> np.ndarray:
        whole = np.zeros((len(blocks), self._width, self._width))
        for k, block in enumerate(blocks):
            whole[k, : len(block), : len(block)] = block
        return whole.ravel()

    def _unpacked(self, values: np.ndarray) -> list[np.ndarray]:
        whole = values.reshape(len(self.excited.laws), self._width, self._width)
        sizes = [place.stop - place.start for _, place in self.excited.laws]
        return [block[:n, :n] for block, n in zip(whole, sizes, strict=True)]

    def _added(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What is added to the laws as they answer it at once, and B and D of it in closed loop."""
        n, m = self.excited.driven, self.excited.results
        B, D = (self.excited.linear.matrices[name] for name in "BD")
        G = self._gain_matrix()
        through = np.linalg.inv(np.eye(len(G)) - G @ D[m:, n:])
        return through, B[:, n:] @ through, D[:, n:] + D[:, n:] @ (through @ G) @ D[m:, n:]

    def _injected(self) -> Iterator[tuple[slice, np.ndarray]]:
        """Answers (outputs, laws, q), some frequencies after the other, to what is added to the laws in closed loop."""
        through, B_in, D_closed = self._added()
        C, operators = self.closed.matrices["C"], self.closed.operators
        if operators is not None:
            D_input = self.excited.linear.operators.D_input[:, self.excited.driven :] @ through
        if self.resolvent.basis is not None:
            roots, right, left = self.resolvent.basis
            of, shares = _alike(1 / (1j * self.omega - roots[:, None]))
            by_share = ((C @ right)[:, None, :] * (left @ B_in).T).reshape(-1, len(right)) @ of
        for first in range(0, self.omega.size, AT_ONCE):
            part = slice(first, min(first + AT_ONCE, self.omega.size))
            if self.resolvent.basis is None:
                found = self.resolvent.between(C, B_in, part).transpose(1, 2, 0)
            else:
                found = (by_share @ shares[:, part]).reshape(*D_closed.shape, -1)
            found = found + D_closed[:, :, None]
            if operators is not None:
                u = self.resolvent.between(operators.C, B_in, part) + D_input
                three = self._with_rates(np.linalg.solve(self.loop[part], self.errors[part] @ u), part)
                more = (self.resolvent.between(C, operators.B, part) + operators.D_output) @ three
                found = found + more.transpose(1, 2, 0)
            yield part, found

    def _gain_matrix(self) -> np.ndarray:
        size = sum(place.stop - place.start for _, place in self.excited.laws)
        G = np.zeros((size, size))
        for (_, place), gain, slope in zip(self.excited.laws, self.gains, self.excited.slopes, strict=True):
            G[place, place] = gain - slope
        return G

    def _map(self) -> np.ndarray:
        """Phi: slopes of the gains of all laws by those that are put in.

        Beside it, what of the results answers to the laws, and the slopes of each gain.
        """
        width, laws = self._width, self.excited.laws
        count = len(laws)
        self.by_covariance, self.by_mean = np.zeros((count, *[width] * 4)), np.zeros((count, *[width] * 3))
        spread = np.zeros((count, width), dtype=int)  # rows of laws, of those that are narrower -1
        covariances = self._covariances()
        for k, (_, place) in enumerate(laws):
            n = place.stop - place.start
            spread[k] = [*range(place.start, place.stop), *[-1] * (width - n)]
        for numbers, rows in self.excited.law_rows:
            part, covariance = slice(rows.shape[1]), np.array([covariances[k] for k in numbers])
            slopes = stacked_slopes(covariance, self.means[rows])
            self.by_covariance[numbers, part, part, part, part], self.by_mean[numbers, part, part, part] = slopes
        product = self._laws_with_laws(spread)
        # covariance_i[r, s] by G_j[c, e]: T[r, c] Z[e, s], and the same with r and s exchanged
        product = product.reshape(count, count, width, width, width, width)  # i j r c e s
        by_gain = np.einsum("ijrces->irsjce", product)
        by_gain = by_gain + by_gain.transpose(0, 2, 1, 3, 4, 5)
        by_gain = by_gain.reshape(count, width**2, -1)
        phi = self.by_covariance.reshape(count, width**2, width**2) @ by_gain
        return phi.reshape(count * width**2, count * width**2)

    def _laws_with_laws(self, spread: np.ndarray) -> np.ndarray:
        """Re sum of answers T to the laws times spectra Z of their inputs; see AnswersToLaws.with_spectra."""
        (count, width), m = spread.shape, self.excited.results
        if self.closed.operators is None and self.resolvent.modes is not None:
            _, B, D = self._added()
            self.answers = AnswersToLaws.of(self.resolvent, B, self.closed.matrices["C"], D)
            if self.common is None:
                sums = self.answers.spectra(self.out[m:], self.weighted)
            else:
                by = np.hstack([self.closed.matrices[name][m:] for name in "CD"])
                sums = self.common.laws_with_laws(self.out[m:], by)
            return self.answers.with_spectra(sums, m, spread)
        self.by_laws = np.zeros((self.omega.size, m, len(self.out) - m), dtype=complex)
        rows = spread.ravel()
        there = (rows >= 0)[:, None, None]
        product = np.zeros((count, count, width**2, width**2))
        for part, injected in self._injected():
            self.by_laws[part] = injected[:m].transpose(2, 0, 1)
            u = np.where(there, self.out[m:][rows][:, part], 0.0).transpose(1, 0, 2)
            T = np.where(there & there.transpose(1, 0, 2), injected[m:][rows][:, rows], 0.0)
            Z = (u @ self.weighted[part]) @ u.conj().transpose(0, 2, 1)  # of law j in direction e, with law i in s
            # as real numbers, the frequencies last: Re sum T Z
            T = np.conj(T, out=T).reshape(count, width, count, width, -1).swapaxes(1, 2)
            Z = Z.reshape(-1, count, width, count, width).transpose(3, 1, 2, 4, 0)
            T, Z = (np.ascontiguousarray(block).reshape(count, count, width**2, -1).view(float) for block in (T, Z))
            product += T @ Z.swapaxes(2, 3)
        return product

    @cached_property
    def _of_fixed_point(self) -> tuple[np.ndarray, np.ndarray]:
        """The factors of (1 - Phi)'."""
        return lu_factor((np.eye(len(self.phi)) - self.phi).T)

    # --- adjoint ---------------------------------------------------------------------------------------------------

    def slopes(self, asked: Sequence[Asked], by_drive: Collection[str] | None = None) -> list[Slopes]:
        """Slopes of scalars; by_drive: of these processes, None: all. With few of them each by itself."""
        if not asked:
            return []
        if len(asked) >= MANY and self.closed.operators is None and self.resolvent.modes is not None:
            return self._slopes_together(asked, by_drive)
        return [self._slopes_of(one, by_drive) for one in asked]

    def _bars(self, asked: Sequence[Asked]) -> tuple[np.ndarray, list[np.ndarray]]:
        """Slopes of scalars by the outputs that they are of (scalars, q, k), and by the densities (q, k, k)."""
        orders = self.forcing.frequency ** np.array(ORDERS)[:, None] * widths(self.forcing.frequency)
        bars, direct = np.empty((len(asked), *self.out.shape[1:]), dtype=complex), []
        for bar, one in zip(bars, asked, strict=True):
            weight, H, S = one.by_moments @ orders, self.out[one.result], self.forcing.of(one.process)
            bar[:] = 2 * weight[:, None] * _with_density(H[None], S)[0]
            direct.append(np.where(S != 0, weight[:, None, None] * (H[:, :, None] * H.conj()[:, None, :]), 0.0))
        return bars, direct

    def _slopes_of(self, asked: Asked, by_drive: Collection[str] | None) -> Slopes:
        """Those of one scalar.

        Those by the outputs are `bar` for the result, and the inputs of laws times their density times a constant
        matrix Q, so that their products with what is put in are Q times products that are the same for all scalars.
        """
        (bar,), (direct,) = self._bars([asked])
        (Q,), (means,) = self._through_laws([asked.result], bar[None])
        operators, every = self.closed.operators, slice(None)
        rows = np.r_[asked.result, self.excited.results : len(self.out)]  # of the outputs that it depends on

        def of_outputs(matrix: np.ndarray, channels: slice = every) -> np.ndarray:
            """A matrix times the slopes by these outputs."""
            return times(matrix[:, 1:] @ Q, self.swept[:, :, channels]) + matrix[:, :1, None] * bar[:, channels]

        # slopes by the rates, and by the inputs of operators, are `lift` times both
        of_states = self.resolvent.shapes.conj().T @ self.closed.matrices["C"][rows].T
        both, lift = self.resolvent.backwards(of_outputs(of_states))
        if operators is not None:
            costate = times(lift, both)
            three = of_outputs(operators.D_output[rows].T) + times(operators.B.T, costate)
            three = three.reshape(3, -1, *three.shape[1:])
            of_w = np.einsum("qd,dmqk->qmk", self.powers.conj(), three)
            of_w = np.linalg.solve(self.loop.conj().transpose(0, 2, 1), of_w)
            of_u = (self.errors.conj().transpose(0, 2, 1) @ of_w).transpose(1, 0, 2)
            both = np.concatenate([costate + self.resolvent.adjoint(times(operators.C.T, of_u)), of_u])
            lift = np.eye(len(both))
        drive = {}
        for path, channels in self.forcing.columns.items():
            if by_drive is None or path in by_drive:
                of_both, of_rows = self._by_driven(path, asked.result)
                drive[path] = times(of_both @ lift, both[:, :, channels]) + of_outputs(of_rows, channels)
        sums = lift @ self._with_laws(*self._with_inputs(both))
        return Slopes(self._by_matrices(asked.result, sums, self._with_laws(*self._with_inputs(bar[None])), Q), drive,
                      direct, Q, means)  # fmt: skip

    def _slopes_together(self, asked: Sequence[Asked], by_drive: Collection[str] | None) -> list[Slopes]:
        """Those of many scalars: the same by sums that all have in common."""
        modes = self.resolvent.modes
        common = self.common = CommonSums(self.resolvent, modes, self._rows) if self.common is None else self.common
        bars, direct = self._bars(asked)
        results, m = [one.result for one in asked], self.excited.results
        Q, means = self._through_laws(results, bars)
        C, lift = self.closed.matrices["C"] @ modes.shapes, modes.of.T
        own, by_laws = C[results], C[m:].T @ Q
        sums = lift @ self._with_laws(common.with_modes(own, by_laws, bars))
        rows, found = self._with_laws(common.rows(bars)), []
        drives = [path for path in self.forcing.columns if by_drive is None or path in by_drive]
        for k, result in enumerate(results):
            drive = {}
            for path in drives:
                of_both, of_rows = self._by_driven(path, result)
                drive[path] = common.driven(path, of_both @ lift, np.hstack([of_rows[:, :1], of_rows[:, 1:] @ Q[k]]),
                                            np.hstack([own[k][:, None], by_laws[k]]), bars[k])  # fmt: skip
            matrices = self._by_matrices(result, sums[k], rows[k : k + 1], Q[k])
            found.append(Slopes(matrices, drive, direct[k], Q[k], means[k]))
        return found

    @cached_property
    def _rows(self) -> Rows:
        return Rows(self.forcing.columns, self.forcing.driven, self.excited.driven, self.drives, self.weighted, self.x,
                    self.swept)  # fmt: skip

    @cached_property
    def _acting(self) -> np.ndarray:
        """Rates, and inputs of operators, by all inputs of the model without the laws."""
        base = self.excited.linear
        own = [] if base.operators is None else [base.operators.D_input]
        return np.vstack([base.matrices["B"], *own])

    @cached_property
    def _back(self) -> np.ndarray:
        """Slopes by the inputs of the laws, from those by what these put in."""
        n, m, G = self.excited.driven, self.excited.results, self._gain_matrix()
        return G.T @ np.linalg.inv(np.eye(len(G)) - self.excited.linear.matrices["D"][m:, n:].T @ G.T)

    @cached_property
    def _back_to_rates(self) -> np.ndarray:
        return self._back @ self._acting[:, self.excited.driven :].T

    def _direct(self, result: int) -> np.ndarray:
        """Of a result, and of the laws, by all that is put in, at once."""
        D = self.excited.linear.matrices["D"]
        return np.vstack([D[result], D[self.excited.results :]])

    def _by_driven(self, path: str, result: int) -> tuple[np.ndarray, np.ndarray]:
        """Slopes by what a process drives, from those by rates, and by the result and the laws with these in loop."""
        D, driven = self._direct(result), self.forcing.driven[path]
        of_laws = D[1:, driven].T
        return (self._acting[:, driven].T + of_laws @ self._back_to_rates,
                D[:, driven].T + of_laws @ (self._back @ D[:, self.excited.driven :].T))  # fmt: skip

    def _by_matrices(self, result: int, sums: np.ndarray, row: np.ndarray, Q: np.ndarray) -> Bars:
        """Slopes by the matrices, from those by the rates with all that is put in, and from the row of the result."""
        m, nx = self.excited.results, len(self.amplitudes)
        of_bars = np.vstack([row, Q @ self._swept_sums])
        # by the outputs of the model without the laws: those of laws have what their gains put in, too
        of_rows = self._back @ self._direct(result)[:, self.excited.driven :].T
        of_bars[1:] += self._back_to_rates @ sums + of_rows @ of_bars
        whole = np.zeros((len(self.out) + len(sums) - nx, sums.shape[1]))
        whole[result], whole[m : len(self.out)], whole[len(self.out) :] = of_bars[0], of_bars[1:], sums[nx:]
        return Bars(sums[:nx, :nx], sums[:nx, nx:], whole[:, :nx], whole[:, nx:])

    def by_density(self, slopes: Sequence[Slopes], columns: slice, change: np.ndarray) -> np.ndarray:
        """Changes of scalars with that of the densities of these channels, (q, k, k).

        What it does to the covariances of the laws is the same for all.
        """
        u = np.ascontiguousarray(self.out[self.excited.results :, :, columns])
        of_covariance = np.zeros((len(u), len(u)))
        blocks = self._of_each_law(_with_density(u, change * self.forcing.widths[:, None, None]), u)
        for (_, place), block in zip(self.excited.laws, blocks, strict=True):
            of_covariance[place, place] = block
        return np.array([np.sum((of.direct[:, columns, columns] * change).real)
                         + np.sum(of.laws * of_covariance) / 2 for of in slopes])  # fmt: skip

    def density_slopes(self, of: Slopes) -> np.ndarray:
        """Slopes of a scalar by all densities (q, k, k)."""
        u = self.out[self.excited.results :]
        turned = np.empty_like(u)
        for _, rows in self.excited.law_rows:
            blocks = of.laws[rows[:, :, None], rows[:, None, :]] @ _grouped(u, rows)
            turned[rows] = blocks.view(complex).reshape(*rows.shape, *u.shape[1:])
        through_laws = turned.transpose(1, 2, 0) @ u.conj().transpose(1, 0, 2)
        return of.direct + self.forcing.widths[:, None, None] / 2 * through_laws

    def _with_inputs(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """Re sum of rows (n, q, k) times the conjugates of [states; what drives the model], and of those of w, w', w''.

        None: without operators.
        """
        by_drive = np.zeros((len(rows), self.excited.driven))
        for path, channels in self.forcing.columns.items():
            by_drive[:, self.forcing.driven[path]] += _outer(rows[:, :, channels], self.drives[path])
        by_three = _outer(rows, self.three) if self.closed.operators is not None else None
        return np.hstack([_outer(rows, self.x), by_drive]), by_three

    def _with_laws(self, by: np.ndarray, by_three: np.ndarray | None = None) -> np.ndarray:
        """The same (..., n) with all that is put in: what the laws put in are gains times sums of the others."""
        C, D = (self.closed.matrices[name][self.excited.results :] for name in "CD")
        by_laws, more = by @ np.hstack([C, D]).T, []
        if by_three is not None:
            by_laws += by_three @ self.closed.operators.D_output[self.excited.results :].T
            more = [by_three]
        return np.concatenate([by, by_laws @ self._gain_matrix().T, *more], axis=-1)

    @cached_property
    def drives(self) -> dict[str, np.ndarray]:
        """The drive of each process, of its inputs and channels alone (n, q, k)."""
        drive = self.forcing.drive
        return {path: np.ascontiguousarray(drive[:, self.forcing.driven[path], channels].transpose(1, 0, 2))
                for path, channels in self.forcing.columns.items()}  # fmt: skip

    @cached_property
    def swept(self) -> np.ndarray:
        """The inputs of the laws times the density (n, q, k)."""
        return np.ascontiguousarray(_with_density(self.out[self.excited.results :], self.weighted))

    @cached_property
    def _swept_sums(self) -> np.ndarray:
        return self._with_laws(*self._with_inputs(self.swept))

    def _through_laws(self, results: Sequence[int], bars: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The matrix Q of scalars, and their slopes by the means, by the covariances of the laws; see `slopes`."""
        m, laws, count, width = self.excited.results, self.excited.laws, len(bars), self._width
        means, Q = np.zeros((count, self.means.size)), np.zeros((count, *(len(self.out) - m,) * 2))
        if not laws:
            return Q, means
        factors = self._of_fixed_point  # and with it what answers to the laws
        u = self.out[m:]
        of_bars = np.ascontiguousarray((u.transpose(1, 0, 2) @ bars.conj().transpose(1, 2, 0)).transpose(2, 1, 0))
        direct = []
        for result, of_bar in zip(results, of_bars, strict=True):
            if self.answers is not None:
                whole = self.answers.with_row(result, of_bar)
                blocks = [whole[place, place] for _, place in laws]
            else:
                blocks = self._of_each_law(np.ascontiguousarray(self.by_laws[:, result].conj().T), of_bar)
            direct.append(self._packed(blocks))
        by_gains = lu_solve(factors, np.array(direct).T).T.reshape(count, len(laws), width, width)
        by_covariance = np.einsum("labcd,klab->klcd", self.by_covariance, by_gains, optimize=True)
        by_covariance = by_covariance + by_covariance.transpose(0, 1, 3, 2)
        by_mean = np.einsum("labm,klab->klm", self.by_mean - self._by_mean_itself, by_gains, optimize=True)
        for number, (_, place) in enumerate(laws):
            n = place.stop - place.start
            means[:, place], Q[:, place, place] = by_mean[:, number, :n], by_covariance[:, number, :n, :n]
        return Q, means

    @cached_property
    def _by_mean_itself(self) -> np.ndarray:
        """Slopes by the means of what the linear model has of the laws by itself (laws, n, n, n)."""
        found = np.zeros((len(self.excited.laws), *[self._width] * 3))
        for one, (_, place), smoothing in zip(found, self.excited.laws, self.excited.smoothing, strict=True):
            one[(slice(place.stop - place.start),) * 3] = slope_at_mean(self.means[place], smoothing)[1]
        return found

    @property
    def linear(self) -> LinearModel:
        """With the gains of drag."""
        return self.closed


def _grouped(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows (laws, n) of complex values (m, q, ...), as real numbers (laws, n, l)."""
    in_order = bool((np.diff(rows.ravel()) == 1).all())
    chosen = values[rows[0, 0] : rows[-1, -1] + 1] if in_order else values[rows]
    return np.ascontiguousarray(chosen).reshape(*rows.shape, -1).view(float)


def _alike(shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Functions of frequency (n, q) as sums of fewer: factors (n, r), (r, q), to rounding.

    The shares of roots far above all frequencies are nearly straight lines.
    """
    size = np.maximum(np.abs(shares).max(axis=1, initial=0.0), 1e-300)[:, None]
    of, values, functions = np.linalg.svd(shares / size, full_matrices=False)
    count = int(np.sum(values > EXACT * values.max(initial=0.0)))
    return size * of[:, :count] * values[:count], functions[:count]


def _with_density(rows: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Rows (n, q, k) times densities (q, k, k)."""
    return (rows.transpose(1, 0, 2) @ density).transpose(1, 0, 2)


def _outer(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Re sum over frequencies and channels of a b^H, of (n, q, k) and (m, q, k)."""
    size = a.shape[1] * a.shape[2]
    a, b = (np.ascontiguousarray(block, dtype=complex).reshape(len(block), size).view(float) for block in (a, b))
    return a @ b.T
