"""The floating plate of Yago and Endo (1996) in head waves: measured, computed by others, and by the panel method here.

    python benchmarks/floating_plate.py [panels along] [panels across]

300 x 60 x 2 m, draft 0.5 m, depth 58.5 m, as a beam of EI 4.76e11 N m^2 with eight shapes of bending. Measured by
S. Yago and H. Endo, J. Soc. Naval Architects of Japan 180 (1996); computed in three dimensions by S. Fu, T. Moan,
X. Chen and W. Cui, Ocean Engineering 34 (2007). Both as digitised in public data.
"""

from __future__ import annotations

import math
import sys

import numpy as np

from fowtlib.components.hydro.deformation import Field, shape_stiffness
from fowtlib.components.hydro.hull_mesh import HullMesh
from fowtlib.components.hydro.panel_solver import PanelSolver

LENGTH, WIDTH, DRAFT, DEPTH, BENDING, MASS = 300.0, 60.0, 0.5, 58.5, 4.76e11, 256.25 * 2 * 60.0
RHO, G, SHAPES = 1025.0, 9.81, 8
PLACES = np.linspace(-1, 1, 9)  # 1: the end that the waves meet first
MEASURED = {
    0.4: [0.197, 0.074, 0.049, 0.116, 0.136, 0.189, 0.261, 0.414, 0.798],
    0.6: [0.557, 0.282, 0.222, 0.303, 0.347, 0.379, 0.474, 0.645, 1.071],
    0.8: [0.996, 0.530, 0.429, 0.515, 0.546, 0.471, 0.567, 0.730, 1.087],
    1.0: [1.232, 0.920, 0.827, 0.748, 0.732, 0.799, 0.819, 0.862, 1.256],
}
COMPUTED = {  # distance from the weather end over the length, amplitude
    0.4: [(0.0, 0.825), (0.176, 0.331), (0.368, 0.219), (0.558, 0.138), (0.749, 0.083), (0.94, 0.139)],
    0.6: [(0.005, 1.032), (0.19, 0.501), (0.381, 0.404), (0.569, 0.342), (0.755, 0.269), (0.941, 0.460)],
    0.8: [(0.0, 1.204), (0.196, 0.686), (0.389, 0.618), (0.579, 0.646), (0.769, 0.572), (0.956, 0.908)],
}


def roots() -> list[float]:
    """Cos x cosh x = 1: of a free beam."""
    found = []
    for k in range(1, SHAPES + 1):
        x = (2 * k + 1) * math.pi / 2
        for _ in range(30):
            x -= (math.cos(x) - 1 / math.cosh(x)) / (-math.sin(x) + math.sinh(x) / math.cosh(x) ** 2)
        found.append(x)
    return found


BETA = roots()


def bending(root: float, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shape of a free beam, 1 at its ends, and its slope; sinh and cosh without their difference."""
    s, rest = x / LENGTH + 0.5, math.sinh(root) - math.sin(root)
    small = (-math.exp(-root) - math.sin(root) + math.cos(root)) / rest  # 1 - ratio
    ratio = 1 - small
    moved = np.exp(-root * s) + small * np.sinh(root * s) + np.cos(root * s) - ratio * np.sin(root * s)
    slope = -np.exp(-root * s) + small * np.cosh(root * s) - np.sin(root * s) - ratio * np.cos(root * s)
    return moved / 2, root / LENGTH * slope / 2


def deformation(points: np.ndarray) -> Field:
    moved, gradient = np.zeros((SHAPES, len(points), 3)), np.zeros((SHAPES, len(points), 3, 3))
    for k, root in enumerate(BETA):
        moved[k, :, 2], gradient[k, :, 2, 0] = bending(root, points[:, 0])
    return Field(moved, gradient)


def panels(along: int, across: int) -> np.ndarray:
    """Those of the bottom and the sides, all of one size."""

    def places(count: int, size: float) -> np.ndarray:
        return np.linspace(-size / 2, size / 2, count + 1)

    x, y, z, found = places(along, LENGTH), places(across, WIDTH), np.array([-DRAFT, 0.0]), []

    def face(u, v, point) -> None:
        for a, b in zip(u[:-1], u[1:], strict=True):
            for c, d in zip(v[:-1], v[1:], strict=True):
                found.append([point(a, c), point(b, c), point(b, d), point(a, d)])

    face(x, y[::-1], lambda a, c: (a, c, -DRAFT))
    face(x, z, lambda a, c: (a, -WIDTH / 2, c))
    face(x[::-1], z, lambda a, c: (a, WIDTH / 2, c))
    face(y, z, lambda a, c: (LENGTH / 2, a, c))
    face(y[::-1], z, lambda a, c: (-LENGTH / 2, a, c))
    return np.array(found)


def motions(hull: HullMesh, ratio: float, solver: PanelSolver) -> np.ndarray:
    """Complex coordinates of heave, pitch and the shapes, per wave amplitude."""
    k = 2 * math.pi / (ratio * LENGTH)
    omega = math.sqrt(G * k * math.tanh(k * DEPTH))
    flow = solver.solve(omega, np.zeros(1))
    stiffness = shape_stiffness(hull.panels, deformation)
    kept = [2, 4, *range(6, 6 + SHAPES)]
    mass = np.diag([MASS * LENGTH, MASS * LENGTH**3 / 12, *[MASS * LENGTH / 4] * SHAPES])
    restoring = np.zeros((6 + SHAPES, 6 + SHAPES))
    restoring[:6, :6] = RHO * G * hull.stiffness
    restoring[6:, 6:] = RHO * G * (stiffness.among + stiffness.among.T) / 2
    restoring[6:, :6] = RHO * G * stiffness.with_rigid
    restoring[:6, 6:] = restoring[6:, :6].T
    restoring = restoring[np.ix_(kept, kept)]
    restoring[2:, 2:] += np.diag([MASS * LENGTH / 4 * BENDING / MASS * (root / LENGTH) ** 4 for root in BETA])
    A, B = ((matrix + matrix.T)[np.ix_(kept, kept)] / 2 * RHO for matrix in (flow.A, flow.B))
    return np.linalg.solve(-(omega**2) * (mass + A) + 1j * omega * B + restoring, RHO * flow.X[0, kept])


def deflection(q: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Amplitude at places -1 to 1; the waves travel along +x."""
    x = -np.asarray(places) * LENGTH / 2
    return np.abs(q @ np.stack([np.ones(len(x)), -x, *[bending(root, x)[0] for root in BETA]]))


def main() -> None:
    along, across = (int(word) for word in (sys.argv[1:3] or ("60", "12")))
    hull = HullMesh(panels(along, across))
    solver = PanelSolver(hull, DEPTH, G, deformation)
    print(f"{len(hull.panels)} panels; amplitude over that of the wave, at x / (L/2)")
    print("lambda/L          " + "".join(f"{x:7.2f}" for x in PLACES))
    for ratio, measured in MEASURED.items():
        q = motions(hull, ratio, solver)
        print(f"{ratio:5.1f}  here       " + "".join(f"{w:7.3f}" for w in deflection(q, PLACES)))
        print("       measured   " + "".join(f"{w:7.3f}" for w in measured))
        if ratio in COMPUTED:
            where, other = np.array(COMPUTED[ratio]).T
            pairs = zip(1 - 2 * where, deflection(q, 1 - 2 * where), other, strict=True)
            print("       Fu et al.  " + ", ".join(f"at {x:.2f}: {w:.3f} against {o:.3f}" for x, w, o in pairs))


if __name__ == "__main__":
    main()
