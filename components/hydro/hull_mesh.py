"""Panels of a wetted hull as data: whether they are closed, what they displace, which symmetry they have, their lid.

Pure geometry (numpy, scipy), whatever the panels come from: the mesher of columns and pontoons, a file (gdf_files), or
other members. A mesh is an array (n, 4, 3) of quadrilaterals [m], corners in order, normal out of the hull into the
water; triangles repeat a corner. z is measured upwards from the still water level.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fowtlib.components.hydro.mesh_leaks import LeakError, check_closed, free_edges, joined
from fowtlib.language.errors import ParameterError

SAME = 1e-5  # of the extent of the mesh: what is nearer is the same point
CLOSED = 1e-6  # largest difference between the volumes by x, y and z of a closed mesh, relative
VOLUME_ERROR = 5e-3  # largest difference between a mesh and the formulas of its members, relative
ROUND = 12  # a body of this many equal wedges or more, each one panel wide, stands for a body of revolution


@dataclass(frozen=True)
class Symmetry:
    """What a mesh is made of: `rotation` equal wedges about the z axis, or its mirror images in `planes`.

    planes: of "xOz" (y = 0) and "yOz" (x = 0). round: a body of revolution, of which a wedge is one panel wide.
    """

    rotation: int = 1
    planes: tuple[str, ...] = ()
    round: bool = False

    @property
    def fold(self) -> int:
        """How many times the part that is computed lies in the whole."""
        return max(self.rotation, 2 ** len(self.planes))

    def __str__(self) -> str:
        if self.round:
            return f"body of revolution ({self.rotation} wedges)"
        if self.rotation > 1:
            return f"{self.rotation} equal parts about the z axis"
        names = {"xOz": "y = 0", "yOz": "x = 0"}
        return "planes " + " and ".join(names[plane] for plane in self.planes) if self.planes else "none"


@dataclass(frozen=True, eq=False)
class HullMesh:
    """Wetted panels (n, 4, 3) of a hull, and panels (m, 4, 3) on the water level inside of it (the lid).

    Made without a lid it gets one from its waterline: the lid takes away the irregular frequencies. `name` stands in
    messages. Corners nearer than `join` [m] become one point (meshes in files are rounded). Raises ParameterError for
    panels that leak, lie above the water, or whose normals point inwards; with `leaky` it is a warning as long as the
    three volumes, by x, y and z, agree within 0.5 %, and `watertight` is False.
    """

    panels: np.ndarray
    lid: np.ndarray | None = None
    name: str = "hull"
    join: float = 0.0
    leaky: bool = False

    watertight: bool = field(init=False, default=True)
    volume: float = field(init=False)
    centre_of_buoyancy: np.ndarray = field(init=False)
    stiffness: np.ndarray = field(init=False)

    def __post_init__(self):
        panels = np.array(self.panels, dtype=float)
        if panels.ndim != 3 or panels.shape[1:] != (4, 3) or not len(panels) or not np.isfinite(panels).all():
            raise ParameterError(f"{self.name}: a mesh is an array (n, 4, 3) of finite corners, not {panels.shape}")
        if (high := float(panels[:, :, 2].max())) > SAME * np.ptp(panels, axis=(0, 1)).max():
            raise ParameterError(f"{self.name}: the mesh reaches {high:.4g} m above the still water level; cut it at "
                                 "z = 0 (`clipped`), or move it down")
        panels = joined(panels, self.join) if self.join else panels
        panels = panels[_areas(panels) > SAME**2 * np.ptp(panels, axis=(0, 1)).max() ** 2]  # the rest are lines
        try:
            check_closed(panels, self.name, self.join)
        except ParameterError as error:
            if not self.leaky and isinstance(error, LeakError):
                raise LeakError(f"{error}. Small gaps are taken as they are with leaky=True (`fowt hydro`: "
                                "--leaky)") from None  # fmt: skip
            if not self.leaky:
                raise
            warnings.warn(f"{error}.", stacklevel=3)
            object.__setattr__(self, "watertight", False)
        object.__setattr__(self, "panels", panels)
        lid = lid_of(panels) if self.lid is None else np.array(self.lid, dtype=float).reshape(-1, 4, 3)
        object.__setattr__(self, "lid", lid)
        closed = VOLUME_ERROR if self.leaky else CLOSED - self.join / float(panels[:, :, 2].min())
        found = hydrostatics(panels, self.name, closed)
        for name, value in zip(("volume", "centre_of_buoyancy", "stiffness"), found, strict=True):
            object.__setattr__(self, name, value)

    @property
    def waterplane_area(self) -> float:
        """Area that the waterline encloses [m^2]."""
        return float(self.stiffness[2, 2])

    @property
    def draft(self) -> float:
        """Depth of its lowest point [m]."""
        return -float(self.panels[:, :, 2].min())

    @property
    def widths(self) -> np.ndarray:
        """Largest width (n,) of each panel [m]."""
        return widths_of(self.panels)

    @cached_property
    def symmetry(self) -> Symmetry:
        """The symmetry of hull and lid that saves most, found in the panels themselves."""
        return find_symmetry(self.panels, self.lid)

    def part(self, panels: np.ndarray) -> np.ndarray:
        """Those of the panels (n, 4, 3), of hull or lid, of which the whole is made by symmetry."""
        return part_of(panels, self.symmetry)

    def without_lid(self) -> HullMesh:
        """The same with no lid: irregular frequencies are left in."""
        return replace(self, lid=np.zeros((0, 4, 3)))

    def expect(self, volume: float | None = None, waterplane_area: float | None = None,
               tolerance: float = VOLUME_ERROR) -> None:
        """Compare the mesh with what it should displace [m^3] and the area of its waterplane [m^2].

        Raises ParameterError, with both numbers, where they differ by more than `tolerance`.
        """
        pairs = (("displaces", volume, self.volume, "m^3"), ("has a waterplane of", waterplane_area,
                                                              self.waterplane_area, "m^2"))  # fmt: skip
        for what, wanted, found, unit in pairs:
            if wanted is not None and abs(found - wanted) > tolerance * max(abs(wanted), 1e-9):
                off = f"{found / wanted - 1:+.2%}" if wanted else f"{found:+.4g} {unit}"
                raise ParameterError(f"{self.name}: the mesh {what} {found:.6g} {unit}, and {wanted:.6g} {unit} are "
                                     f"expected ({off}, allowed {tolerance:.2%}): do members overlap, are the panels "
                                     "too coarse, or are the units or the draft others?")


def widths_of(panels: np.ndarray) -> np.ndarray:
    """Largest width (n,) of each panel: the longer one of the two lines that join the middles of its sides [m]."""
    middle = (panels + np.roll(panels, -1, axis=1)) / 2
    return np.linalg.norm(middle[:, :2] - middle[:, 2:], axis=2).max(axis=1)


def hydrostatics(
    panels: np.ndarray, name: str = "hull", closed: float = CLOSED
) -> tuple[float, np.ndarray, np.ndarray]:
    """Volume [m^3], centre of buoyancy (3,) [m] and stiffness C / (rho g) (6, 6) without weight, about the origin.

    From the wetted panels by Gauss' theorem, exact for flat triangles. Raises ParameterError if the panels do not close
    below z = 0 (the volumes by x, y and z differ by more than `closed`, relative), or enclose nothing.
    """
    triangles = np.concatenate([panels[:, [0, 1, 2]], panels[:, [0, 2, 3]]])
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2  # times the area
    centre = triangles.mean(axis=1)
    volumes = np.einsum("nk,nk->k", centre, normal)
    volume = float(np.median(volumes))
    if volume < 0 and np.abs(volumes - volume).max() < 1e-3 * -volume:
        raise ParameterError(f"{name}: the normals of the panels point into the hull: turn the order of their corners")
    if volume <= 0 or np.abs(volumes - volume).max() > closed * abs(volume):
        raise ParameterError(f"{name}: the panels are not a closed hull: the volumes by x, y, z are {volumes} m^3")

    def integral(i: int, j: int) -> float:  # of x_i x_j n_z
        a, b = triangles[:, :, i], triangles[:, :, j]
        return float(((a * b).sum(1) + a.sum(1) * b.sum(1)) @ normal[:, 2]) / 12

    buoyancy = np.array([integral(0, 2), integral(1, 2), integral(2, 2) / 2]) / volume
    buoyancy[np.abs(buoyancy) < 1e-9 * np.abs(panels).max()] = 0.0
    area, mx, my = -normal[:, 2].sum(), -centre[:, 0] @ normal[:, 2], -centre[:, 1] @ normal[:, 2]
    C = np.zeros((6, 6))
    C[2, 2] = area
    C[2, 3] = C[3, 2] = my
    C[2, 4] = C[4, 2] = -mx
    C[3, 3] = -integral(1, 1) + volume * buoyancy[2]
    C[4, 4] = -integral(0, 0) + volume * buoyancy[2]
    C[3, 4] = C[4, 3] = integral(0, 1)
    C[3, 5], C[4, 5] = -volume * buoyancy[0], -volume * buoyancy[1]
    C[np.abs(C) < 1e-9 * np.abs(C).max()] = 0.0
    return volume, buoyancy, C


def clipped(panels: np.ndarray) -> np.ndarray:
    """What of the panels (n, 4, 3) lies below z = 0; a panel that crosses the water level is cut there."""
    kept = []
    for panel in panels:
        z = panel[:, 2]
        if (z <= 0).all():
            kept.append(panel)
        elif (z < 0).any():
            corners = []
            panel = panel[(panel != np.roll(panel, 1, axis=0)).any(axis=1)]  # the three of a triangle
            for a, b in zip(panel, np.roll(panel, -1, axis=0), strict=True):
                if a[2] <= 0:
                    corners.append(a)
                if a[2] * b[2] < 0:
                    corners.append(np.append((a + (b - a) * a[2] / (a[2] - b[2]))[:2], 0.0))
            if len(corners) == 5:  # one corner is cut off: the same pieces for a panel and its mirror image
                first = next(k for k in range(5) if corners[k][2] == 0 == corners[k - 1][2]) - 1
                p, q, r, opposite, s = (corners[(first + k) % 5] for k in range(5))
                kept += [np.array([p, q, r, s]), np.array([r, opposite, s, s])]
            else:
                kept.append(np.array(corners if len(corners) == 4 else [*corners, corners[-1]]))
    return np.array(kept).reshape(-1, 4, 3)


def lid_of(panels: np.ndarray) -> np.ndarray:
    """Panels (m, 4, 3) of the water level inside of the waterlines of a hull, normal downwards.

    Each closed waterline is filled with rings towards its centre, about as wide as its sides. Empty for a hull under
    water, and for a waterline that cannot be seen as a whole from its centre (an L, the two of a moon pool).
    """
    lids = [np.zeros((0, 4, 3))]
    for line in waterlines(panels):
        centre = line.mean(axis=0)
        ahead = np.roll(line, -1, axis=0)
        turns = np.cross(line - centre, ahead - centre)[:, 2]
        if (turns <= 0).any():
            return np.zeros((0, 4, 3))
        side = np.linalg.norm(ahead - line, axis=1).mean()
        reach = np.linalg.norm(line - centre, axis=1).mean()
        scale = np.linspace(0, 1, max(2, math.ceil(reach / side)) + 1)
        rings = centre + scale[:, None, None] * (line - centre)
        behind = np.roll(rings, -1, axis=1)
        lids.append(np.stack([rings[:-1], behind[:-1], behind[1:], rings[1:]], axis=2).reshape(-1, 4, 3))
    return np.concatenate(lids)


def waterlines(panels: np.ndarray) -> list[np.ndarray]:
    """Closed lines (k, 3) in which the hull meets z = 0, counter-clockwise seen from above around the hull."""
    points, edges = free_edges(panels)
    ahead = {b: a for a, b in edges}  # the free side of a wall runs clockwise
    lines = []
    while ahead:
        first, at = next(iter(ahead.items()))
        del ahead[first]
        line = [first]
        while at != first and at in ahead:
            line.append(at)
            at = ahead.pop(at)
        if at == first and len(line) > 2:
            lines.append(points[line])
    return lines


def find_symmetry(panels: np.ndarray, lid: np.ndarray) -> Symmetry:
    """The symmetry of both that makes the smallest part: mirror planes x = 0 and y = 0, or n equal wedges about z."""
    parts = [part for part in (panels, lid) if len(part)]
    planes = tuple(plane for plane, axis in (("xOz", 1), ("yOz", 0)) if all(_mirrors(part, axis) for part in parts))
    rotation = _rotation(parts)
    if rotation > 2 ** len(planes):
        return Symmetry(rotation, (), round=rotation >= ROUND and _one_panel_wide(panels, rotation))
    return Symmetry(planes=planes) if planes else Symmetry()


def part_of(panels: np.ndarray, symmetry: Symmetry) -> np.ndarray:
    """One panel of each set of panels that the symmetry makes the same."""
    from scipy.spatial import cKDTree

    centre = _centres(panels)
    if symmetry.rotation > 1:
        step = 2 * np.pi / symmetry.rotation
        taken = np.zeros(len(panels), dtype=bool)
        kept = []
        tree, near = cKDTree(centre), _near(panels)
        for k, place in enumerate(centre):
            if not taken[k]:
                kept.append(k)
                for turn in range(symmetry.rotation):
                    taken[tree.query_ball_point(_turned(place, turn * step), near)] = True
        return panels[kept]
    free = np.ones(len(panels), dtype=bool)
    for plane in symmetry.planes:
        free &= centre[:, 1 if plane == "xOz" else 0] > 0
    return panels[free]


def _mirrors(panels: np.ndarray, axis: int) -> bool:
    flip = np.ones(3)
    flip[axis] = -1
    return bool(np.abs(_centres(panels)[:, axis]).min() > _near(panels)) and _same(panels * flip, panels)


def _rotation(parts: list[np.ndarray]) -> int:
    """The largest n for which a turn by 2 pi / n about z leaves all parts as they are; none of them on the axis."""
    from scipy.spatial import cKDTree

    if any((np.linalg.norm(_centres(part)[:, :2], axis=1) < _near(part)).any() for part in parts):
        return 1
    counts = []
    for part in parts:
        centre = _centres(part)
        rings = np.stack([np.hypot(centre[:, 0], centre[:, 1]), centre[:, 2]], axis=1)
        pairs = cKDTree(rings).query_ball_point(rings, _near(part), return_length=True)
        counts.append(int(np.gcd.reduce(pairs)))
    most = math.gcd(*counts)
    for n in range(most, 1, -1):
        if most % n == 0 and all(_same(_turned(part, 2 * np.pi / n), part) for part in parts):
            return n
    return 1


def _one_panel_wide(panels: np.ndarray, rotation: int) -> bool:
    angle = np.arctan2(panels[:, :, 1], panels[:, :, 0])
    off_axis = np.hypot(panels[:, :, 0], panels[:, :, 1]) > _near(panels)
    middle = np.arctan2(*_centres(panels)[:, [1, 0]].T)
    aside = np.abs(np.mod(angle - middle[:, None] + np.pi, 2 * np.pi) - np.pi)
    return bool((np.abs(aside[off_axis] - np.pi / rotation) < 1e-4).all())


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two meshes have the same panels, whichever corner comes first and whichever way they turn.

    Told by their centres, the nearest and the farthest corner from them, and the lowest corner.
    """
    from scipy.spatial import cKDTree

    near = _near(other)

    def marks(panels: np.ndarray) -> np.ndarray:
        centre = _centres(panels)
        reach = np.sort(np.linalg.norm(panels - centre[:, None], axis=2), axis=1)[:, [0, 3]]
        return np.concatenate([centre, reach, panels[:, :, 2].min(axis=1)[:, None]], axis=1)

    distance, index = cKDTree(marks(other)).query(marks(one))
    return bool((distance < 3 * near).all()) and np.unique(index).size == len(other)


def _areas(panels: np.ndarray) -> np.ndarray:
    diagonals = panels[:, 2] - panels[:, 0], panels[:, 3] - panels[:, 1]
    return np.linalg.norm(np.cross(*diagonals), axis=1) / 2


def _centres(panels: np.ndarray) -> np.ndarray:
    """Mean (n, 3) of the corners of each panel, the one that a triangle repeats counted once."""
    counts = (panels != np.roll(panels, 1, axis=1)).any(axis=2)
    return (panels * counts[:, :, None]).sum(axis=1) / np.maximum(counts.sum(axis=1), 1)[:, None]


def _near(panels: np.ndarray) -> float:
    return SAME * float(np.ptp(panels[:, :, :2], axis=(0, 1)).max())


def _turned(points: np.ndarray, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    x, y = points[..., 0], points[..., 1]
    return np.stack([c * x - s * y, s * x + c * y, points[..., 2]], axis=-1)
