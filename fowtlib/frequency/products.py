"""What products of fluctuations add to a response, as a random load of its own at their sums and differences.

Rows r = 1/2 (u' h u - trace h) of Gaussian u with the correlations R(tau) = E[u(t + tau) u(t)'] have no covariance with
what is linear in u, and among each other

    E[r_i(t + tau) r_j(t)] = 1/2 trace(h_i R(tau) h_j R(tau)')

(the formula of Isserlis; in frequency the convolution of the spectra, the second order of a Volterra series:
M. Schetzen, 1980; M. G. Donley and P. D. Spanos, 1990, chapter 4). So a linear model takes them as one more process,
with channels that are sums of them: as few as its states and results can tell from each other.

What these loads make of y is again a factor of products with y, and that goes with what is linear: with answers g of u
to the rows k, rows have the mean of u_a(t) g_bk(t - s) h_k,cd u_c(s) u_d(s) over all that is not u_d, which is a kernel
h_i,ab g_bk R_ac h_k,cd in time, by u_d. A random decay 1 + b x is slower by it, and it is of the size of the noise of
the same products: of order b^2 both (the direct interaction of R. H. Kraichnan, 1961; M. Schetzen, 1980). With both the
variance is right to the second order in what is quadratic. The process counts as Gaussian in deviations and extremes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fowtlib.analysis.spectra import mean_square_below
from fowtlib.frequency.driven import Process
from fowtlib.frequency.quadratic_rows import QuadraticRows
from fowtlib.language.errors import SimulationError
from fowtlib.solving.excited import ExcitedModel
from fowtlib.solving.linear import LinearModel

PRODUCTS = "products"
STRONG = (
    "the products of fluctuations cannot be told from each other, or are as strong as what is linear. Take "
    "linearisation='equivalent', or runs."
)
LEFT_OUT = 1e-7  # of the squares of all forms, in channels and directions not taken: slow swings are small there
DIRECTIONS = 24  # at most
BEYOND = 1e-4  # of the variance of a direction: what may lie above the highest frequency
LINES = 1 << 13  # at most, of the axis of the spectra
GONE = 1e-6  # of the largest answer times correlation: lags beyond which there is less count as none


@dataclass(frozen=True, eq=False)
class Channels:
    """Random loads 1/2 (y' f y - trace f), forms f (channels, m, m), of y = directions @ deviations (m, variables).

    B, D, D_operators: what they do in the linear model, by their columns.
    """

    forms: np.ndarray
    directions: np.ndarray
    B: np.ndarray
    D: np.ndarray
    D_operators: np.ndarray | None

    @property
    def count(self) -> int:
        """Number of channels."""
        return len(self.forms)


def channels_of(excited: ExcitedModel, quadratic: QuadraticRows, rates: np.ndarray,
                results: np.ndarray) -> Channels | None:  # fmt: skip
    """The few channels; rates, results: their deviations. None: nothing is quadratic."""
    beside, n = excited.beside, quadratic.forms.shape[1]
    if beside is None or not len(quadratic.rows):
        return None
    flat = quadratic.forms.reshape(-1, n * n)
    felt = np.vstack([beside.B / _sizes(rates)[:, None], beside.D[: results.size] / _sizes(results)[:, None]]) @ flat
    strengths, shapes = np.linalg.svd(felt, full_matrices=False)[1:]
    left = np.cumsum((strengths**2)[::-1])[::-1]
    if not left[0] > 0:
        return None
    kept = int(np.count_nonzero(left > LEFT_OUT * left[0]))
    shapes, to = shapes[:kept], flat @ shapes[:kept].T  # rows by channels
    forms = shapes.reshape(kept, n, n)
    squares, axes = np.linalg.eigh(np.einsum("k,kij,klj->il", strengths[:kept] ** 2, forms, forms))
    beyond = np.cumsum(squares)
    few = axes[:, beyond > LEFT_OUT * beyond[-1]][:, -DIRECTIONS:]
    operators = None if beside.D_operators is None else beside.D_operators @ to
    return Channels(few.T @ forms @ few, few.T @ quadratic.whitening, beside.B @ to, beside.D @ to, operators)


def with_channels(excited: ExcitedModel, channels: Channels) -> ExcitedModel:
    """The model with these loads as further inputs, behind those that random processes drive."""
    linear, n = excited.linear, excited.driven
    A, B, C, D = (linear.matrices[name] for name in "ABCD")
    operators = linear.operators
    if operators is not None and channels.D_operators is not None:
        operators = replace(operators, D_input=_between(operators.D_input, n, channels.D_operators))
    inputs = [*linear.inputs[:n], *(f"{PRODUCTS} [{k}]" for k in range(channels.count)), *linear.inputs[n:]]
    made = LinearModel(A, _between(B, n, channels.B), C, _between(D, n, channels.D), linear.states, inputs,
                       linear.outputs, linear.units, operators)  # fmt: skip
    return replace(excited, linear=made)


class Products:
    """The process of loads, from cross spectra (q, m, m) per Hz of their directions at frequencies [Hz].

    fed_back: with what they make of products themselves.
    """

    def __init__(self, channels: Channels, frequency: np.ndarray, cross: np.ndarray, fed_back: bool = True):
        self.channels, self.fed_back = channels, fed_back
        self.step, self.correlations = correlations(frequency, cross)

    def process(self, first: int, inputs: int) -> Process:
        """By its spectra; first: of the inputs of the model."""
        count = self.channels.count
        lines, density = spectra_of_products(self.channels.forms, self.step, self.correlations)

        def at(omega: np.ndarray) -> np.ndarray:
            return _at(omega / (2 * np.pi), lines, density) / (2 * np.pi)

        def ones(omega: np.ndarray) -> np.ndarray:
            return np.broadcast_to(np.eye(count, dtype=complex), (omega.size, count, count))

        return Process(at, np.arange(first, first + count), ones, inputs)

    def through(self, transfer: Mapping[str, np.ndarray], frequency: np.ndarray) -> dict[str, np.ndarray]:
        """What the loads have of each process by the products of what is linear in it and what they do themselves.

        transfer: of [states; inputs] by process (q, n, channels), also by these loads. Nothing where that is left out.
        """
        if not self.fed_back:
            return {}
        y = {path: self.channels.directions @ H for path, H in transfer.items()}
        G = y[PRODUCTS]
        lines, kernel = feedback(self.channels.forms, self.step, self.correlations, frequency, G)
        K = _at(frequency, lines, kernel)
        try:
            return {path: np.linalg.solve(np.eye(K.shape[1]) - K @ G, K @ of) for path, of in y.items()}
        except np.linalg.LinAlgError:
            raise SimulationError(STRONG) from None


def fed_back(transfer: Mapping[str, np.ndarray], through: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Transfer functions (q, n, channels) by process, with what goes through the loads."""
    if not through:
        return dict(transfer)
    return {path: H + transfer[PRODUCTS] @ through[path] for path, H in transfer.items()}


def correlations(frequency: np.ndarray, cross: np.ndarray) -> tuple[float, np.ndarray]:
    """Step of frequencies [Hz], and R (n, m, m) of Gaussian y at n lags in a period of one over it.

    cross: one-sided cross spectra (q, m, m) per Hz at rising frequencies, exp(+i omega t). They count as those of y
    with a covariance of one, which their shape is then that of. SimulationError where they depend on each other.
    """
    below = mean_square_below(frequency, np.moveaxis(cross, 0, -1))
    try:
        one = np.linalg.inv(np.linalg.cholesky(below[..., -1].real))
    except np.linalg.LinAlgError:
        raise SimulationError(STRONG) from None
    below = np.moveaxis(one @ np.moveaxis(below, -1, 0) @ one.T, 0, -1)
    own = np.diagonal(below.real, axis1=0, axis2=1)  # (q, m)
    top = float(frequency[np.flatnonzero((own >= 1 - BEYOND).all(axis=1))[0]])
    step = max(float(frequency[0]), top / LINES)
    count = int(np.ceil(top / step)) + 1
    edges = step * (np.arange(count + 1) - 0.5)
    power = np.array([[np.diff(np.interp(edges, frequency, part)) for part in row] for row in below])
    length = 1 << int(np.ceil(np.log2(4 * count)))
    return step, np.fft.irfft(np.moveaxis(power, -1, 0) * (length / 2), length, axis=0)


def spectra_of_products(forms: np.ndarray, step: float, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (n,) [Hz] from 0 up, and cross spectra (n, k, k) per Hz of 1/2 (y' f y - trace f), forms (k, m, m).

    step, R: of the correlations of y.
    """
    length, (k, m) = len(R), forms.shape[:2]
    products = np.empty((length, k, k))
    by_row, by_column = forms.reshape(k * m, m), forms.transpose(1, 0, 2).reshape(m, k * m)
    for part in np.array_split(np.arange(length // 2 + 1), max(length // 2048, 1)):
        left = (by_row @ R[part].transpose(1, 0, 2).reshape(m, -1)).reshape(k, m, part.size, m)
        right = (R[part].reshape(-1, m) @ by_column).reshape(part.size, m, k, m)
        left = left.transpose(2, 0, 1, 3).reshape(part.size, k, m * m)
        right = right.transpose(0, 1, 3, 2).reshape(part.size, m * m, k)
        products[part] = left @ right / 2
    products[length // 2 + 1 :] = products[length - length // 2 - 1 : 0 : -1].transpose(0, 2, 1)  # R(-t) = R(t)'
    density = np.fft.rfft(products, axis=0) * (2 / (length * step))
    return step * np.arange(len(density)), density


def feedback(forms: np.ndarray, step: float, R: np.ndarray, frequency: np.ndarray,
             G: np.ndarray) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Frequencies (n,), and loads by y (n, k, m), by the products of y with what loads make of products of y.

    With answers g_bk(t) of y to the loads the mean of f_i,ab y_a(t) g_bk(t - s) 1/2 f_k,cd y_c(s) y_d(s), twice, has
    the part f_i,ab g_bk(t - s) R_ac(t - s) f_k,cd y_d(s) that is linear in y. G: transfer functions (q, m, k) at
    frequencies [Hz].
    """
    length, (k, m) = len(R), forms.shape[:2]
    lines = step * np.arange(length // 2 + 1)
    g = np.fft.irfft(_at(lines, frequency, G), length, axis=0) * (length * step)
    g[length // 2 :] = 0.0  # of what comes before
    found = np.zeros((length, k, m))
    size = np.abs(g).max(axis=(1, 2)) * np.abs(R).max(axis=(1, 2))
    lags = int(np.flatnonzero(size > GONE * size.max())[-1]) + 1 if size.any() else 0
    for part in np.array_split(np.arange(lags), max(lags // 512, 1)):
        left = (forms[None] @ g[part, None]).transpose(0, 1, 3, 2)  # f_i,ab g_bk as (t, i, k, a)
        right = R[part, None] @ forms[None]  # R_ac f_k,cd as (t, k, a, d)
        found[part] = left.reshape(part.size, k, -1) @ right.reshape(part.size, -1, m)
    found[0] /= 2
    return lines, np.fft.rfft(found, axis=0) / (length * step)


def _at(frequency: np.ndarray, lines: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, ...) at lines, at other frequencies."""
    flat = values.reshape(len(values), -1)
    found = np.stack([np.interp(frequency, lines, column, right=0.0) for column in flat.T], axis=1)
    return found.reshape(-1, *values.shape[1:])


def cross_spectra(transfer: Mapping[str, np.ndarray], spectra: Mapping[str, np.ndarray]) -> np.ndarray:
    """Of what transfer functions (q, n, channels) are of: (q, n, n) per Hz."""
    return np.asarray(sum((H @ spectra[path]) @ H.conj().transpose(0, 2, 1) for path, H in transfer.items()))


def _between(matrix: np.ndarray, at: int, columns: np.ndarray) -> np.ndarray:
    return np.hstack([matrix[:, :at], columns, matrix[:, at:]])


def _sizes(deviations: np.ndarray) -> np.ndarray:
    """What tells a small load from a large one; what does not move at all counts as infinitely large."""
    return np.where(deviations > 1e-9 * deviations.max(initial=0.0), deviations, np.inf)
