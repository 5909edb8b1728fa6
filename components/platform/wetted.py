"""What of a closed surface lies under a plane: volume, first moments, integral of the depth, waterplane; exactly.

Everything follows from E, the integral of the depth over what is wet. A place x of the hull is h = z + n x over the
plane, u = (z, n). Over the region h < 0

    E(u) = integral of -h dV,   dE/du = -(V, S),   d(V, S)/du = -W,

V the volume and S its first moments in the axes of the hull, W the moments of the waterplane, integral of
(1, x) (1, x)^T dA over |n|. rho g E is the potential of the buoyancy: its force is rho g V n and its moment S x n, so
that no closed path gains or loses energy.

The flat top of a float that passes the surface would make a jump of W. So the surface of the water is `transition`
thick: V, S and E are means over planes from half of it below to half of it above, which is the buoyancy of water whose
density fades out over it, still exactly conservative. With the moments M of the wet region, (1, x) (1, x)^T, at the
upper and the lower plane, the mean is (M+ u+ - M- u-) / (2 e) and its Jacobian (M+ - M-) / (2 e), which is continuous;
e is half of the transition. It changes V of a hull with upright walls by nothing, and S_z by A e^2 / 6.

Each triangle, cut by the plane, makes a tetrahedron with the origin, and its cut one on the plane with the foot of the
origin: sums of them are the moments, whatever the shape and the attitude are.
Source: J.N. Newman, Marine Hydrodynamics (1977), 6.16; moments of tetrahedra: F. Tonon, J. Math. Stat. 1 (2005) 8-11.
"""

from __future__ import annotations

import hashlib
import weakref
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from fowtlib.language import ExternalFunction
from fowtlib.language.externals import with_interface
from fowtlib.language.handed_numbers import kept_file, load, problem
from fowtlib.language.native import compiler

Floats = NDArray[np.float64]

MAGIC = float.fromhex("0x1.5a17b0a7p+40")  # as in wetted.c
TRANSITION = 1e-3  # of the cube root of the whole volume: the thickness of the surface where none is given
NAME = "wetted_surface"


@dataclass(frozen=True, eq=False)
class Wetted:
    """What lies under a plane: volume [m^3], first moments (3,) [m^4], integral of the depth [m^4], Jacobian (4, 4).

    slopes: of (volume, moments) by u, which are less the moments of the waterplane.
    """

    volume: float
    moments: Floats
    depth: float
    slopes: Floats

    @property
    def centre(self) -> Floats:
        """Centre of the volume (3,) in the axes of the hull."""
        return self.moments / self.volume

    @property
    def area(self) -> float:
        """Area of the waterplane [m^2], for a normal of length 1."""
        return -float(self.slopes[0, 0])


@dataclass(frozen=True, eq=False)
class WettedSurface:
    """A closed surface of triangles (n, 3, 3) [m], counter-clockwise seen from outside, in the axes of a hull.

    transition [m]: thickness of the surface of the water; None: TRANSITION. It is what a run takes in at its start, see
    fowtlib.language.run_time.Source.
    """

    triangles: Floats
    transition: float | None = None

    @cached_property
    def half(self) -> float:
        """Half of the thickness of the surface of the water [m]."""
        whole = self.transition
        return 0.5 * (TRANSITION * float(np.cbrt(self.whole[0, 0])) if whole is None else whole)

    @cached_property
    def whole(self) -> Floats:
        """Moments (4, 4) of (1, x) of all that it encloses."""
        return _matrix(self._own.sum(axis=0))

    @cached_property
    def _own(self) -> Floats:
        return tetrahedra(self.triangles[:, 0], self.triangles[:, 1], self.triangles[:, 2])

    def under(self, u: ArrayLike) -> Wetted:
        """What lies under the plane u = (height of the origin over it, slopes of the height along x, y, z)."""
        u = np.asarray(u, dtype=float)
        heights, e = self.triangles @ u[1:] + u[0], self.half
        upper, lower = (_matrix(self._below(heights + step, u[0] + step, u[1:])) for step in (e, -e))
        slopes, mean = (upper - lower) / (2 * e), (upper + lower) / 2
        y = mean[0] + slopes @ u
        depth = -u @ mean[0] - u @ slopes @ u / 2 - e**2 * slopes[0, 0] / 2
        return Wetted(float(y[0]), y[1:], float(depth), slopes)

    def _below(self, heights: Floats, z: float, n: Floats) -> Floats:
        """The ten moments of what lies below the plane, with the heights (n, 3) of the corners over it."""
        wet = heights <= 0
        number = wet.sum(axis=1)
        total = self._own[number > 1].sum(axis=0)
        cut = np.flatnonzero((number == 1) | (number == 2))
        if not len(cut):
            return total
        one = number[cut] == 1
        odd = np.argmax(wet[cut] == one[:, None], axis=1)  # the corner on the one side by itself
        order = (odd[:, None] + [0, 1, 2]) % 3
        x, h = self.triangles[cut[:, None], order], heights[cut[:, None], order]
        t = h[:, :1] / (h[:, :1] - h[:, 1:])
        ends = x[:, :1] + t[:, :, None] * (x[:, 1:] - x[:, :1])
        foot = np.broadcast_to(-z * n / (n @ n), (len(cut), 3))
        parts = tetrahedra(x[:, 0], ends[:, 0], ends[:, 1]) + tetrahedra(foot, ends[:, 1], ends[:, 0])
        return total + np.where(one, 1.0, -1.0) @ parts

    # --- as data of a run ----------------------------------------------------------------------------------------

    @cached_property
    def block(self) -> Floats:
        """All of it as numbers, which is what the C code reads."""
        return np.concatenate([[MAGIC, len(self.triangles), self.half], self.triangles[_order(self.triangles)].ravel()])

    @cached_property
    def handle(self) -> float:
        """The number by which a model finds it; it comes from the contents alone."""
        digest = hashlib.sha256(self.block.tobytes()).digest()
        return float(int.from_bytes(digest[:6], "little") or 1)  # 48 bits: exact in a double

    @property
    def numbers(self) -> tuple[float]:
        """What the equations get."""
        return (self.handle,)

    def open_in(self, function: ExternalFunction) -> Any:
        """Make it known to the function; it is forgotten when what is returned here is."""
        held = _Held(self)
        _known[self.handle] = self
        if function.library is None:
            return held
        held.finalizer = load(function, self.handle, self.block, held)
        return held

    def file_for(self, function: ExternalFunction) -> tuple[Path, tuple[float | int, ...]]:
        """A file with its numbers for `<name>_open(handle, path)` of the function's library."""
        content = self.block.astype("<f8").tobytes()
        return kept_file(f"surface_{int(self.handle):012x}", "numbers", content), ()


class _Held:
    """Keeps a surface known."""

    def __init__(self, surface: WettedSurface):
        self.surface = surface
        self.finalizer: Any = None


_known: weakref.WeakValueDictionary[float, WettedSurface] = weakref.WeakValueDictionary()  # for NumPy, by handle


def tetrahedra(a: Floats, b: Floats, c: Floats) -> Floats:
    """Moments (n, 10) of 1, x, y, z, xx, xy, xz, yy, yz, zz of the tetrahedra of the origin and a, b, c (n, 3)."""
    volume = np.einsum("nk,nk->n", a, np.cross(b, c))[:, None] / 6
    s = a + b + c
    first, second = np.array([0, 0, 0, 1, 1, 2]), np.array([0, 1, 2, 1, 2, 2])
    squares = sum(p[:, first] * p[:, second] for p in (a, b, c, s))
    return np.hstack([volume, volume / 4 * s, volume / 20 * squares])


def _order(triangles: Floats) -> NDArray[np.int64]:
    """An order in which triangles of like size that are near each other are neighbours: C passes over whole groups."""
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    size = np.floor(np.log2(np.maximum((high - low).max(axis=1), 1e-6)))
    place = (low + high) / 2 - low.min(axis=0)
    cells = np.floor(place / max(float(place.max()), 1e-6) * 255).astype(np.int64)
    along = sum(((cells[:, i] >> bit & 1) << 3 * bit + i for bit in range(8) for i in range(3)), np.int64(0))
    return np.lexsort((along, size))


def _matrix(moments: Floats) -> Floats:
    return moments[np.array([[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]])]


def wetted_function() -> ExternalFunction:
    """The external function of a handle and u, see the module: volume, moments (3) and the integral of the depth."""
    return _function(compiler())


@lru_cache(maxsize=4)
def _function(command: tuple[str, ...]) -> ExternalFunction:
    text = (Path(__file__).parent / "wetted.c").read_text(encoding="utf-8")

    def evaluate(column: Floats) -> Floats:
        found = _of(column[0]).under(column[1:])
        return np.array([found.volume, *found.moments, found.depth])

    def slope(column: Floats) -> Floats:
        found = _of(column[0]).under(column[1:])
        matrix = np.zeros((5, 5))
        matrix[:4, 1:], matrix[4, 1:] = found.slopes, [-found.volume, *-found.moments]
        return matrix

    def explain() -> str:
        return problem(function) if function.library else ""

    pattern = ca.Sparsity(5, 5, [0, 0, 5, 10, 15, 20], list(range(5)) * 4)
    function = ExternalFunction(
        NAME, {"surface": 1, "plane": 4}, {"volume": 1, "moments": 3, "depth": 1},
        source=with_interface(NAME, pattern, text), python=evaluate, jacobian=slope, sparsity=pattern, explain=explain,
    )  # fmt: skip
    return function


def _of(handle: float) -> WettedSurface:
    if handle not in _known:
        raise RuntimeError("a surface of a hull is used that was not opened in this process; compile the model again.")
    return _known[handle]
