"""Stiffness by the pressure on a deforming hull, against closed forms and a moved mesh."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.components.hydro.deformation import Field, pressure_stiffness, rigid_field, together


def _places(count):
    """Shares 0 to 1, closer at both ends, where the flow turns about an edge."""
    return (1 - np.cos(np.pi * np.linspace(0, 1, count + 1))) / 2


def box(length=80.0, width=10.0, draft=5.0, pieces=(32, 4, 4)):
    """Wetted panels of a barge, normals into the water."""
    x, y, z = (a + (b - a) * _places(n) for a, b, n in
               zip((-length / 2, -width / 2, -draft), (length / 2, width / 2, 0.0), pieces, strict=True))  # fmt: skip
    found = []

    def face(u, v, point):
        for a, b in zip(u[:-1], u[1:], strict=True):
            for c, d in zip(v[:-1], v[1:], strict=True):
                found.append([point(a, c), point(b, c), point(b, d), point(a, d)])

    face(x, y[::-1], lambda a, c: (a, c, -draft))
    face(x, z, lambda a, c: (a, -width / 2, c))
    face(x[::-1], z, lambda a, c: (a, width / 2, c))
    face(y, z, lambda a, c: (length / 2, a, c))
    face(y[::-1], z, lambda a, c: (-length / 2, a, c))
    return np.array(found)


def vertical(shapes, slopes):
    """Vertical displacement that depends on x alone."""

    def field(points):
        x = points[:, 0]
        moved, gradient = np.zeros((len(shapes), len(x), 3)), np.zeros((len(shapes), len(x), 3, 3))
        for k, (shape, slope) in enumerate(zip(shapes, slopes, strict=True)):
            moved[k, :, 2], gradient[k, :, 2, 0] = shape(x), slope(x)
        return Field(moved, gradient)

    return field


def test_rigid_motions_by_the_pressure_alone():
    """Heave S, roll int (y^2 + z^2) dS: moments by the arms at rest, so without a part of the buoyancy's."""
    C = pressure_stiffness(box(), rigid_field)
    expected = np.diag([0, 0, 800.0, 80 * 10.0**3 / 12 + 800 * 25.0, 10 * 80.0**3 / 12 + 800 * 25.0])
    np.testing.assert_allclose(C[:5, :5], expected, atol=1e-6 * expected[4, 4])


def test_vertical_bending_lies_on_the_water_as_on_springs():
    """Only the bottom counts: int w_i w_j dS, as the walls stand on and are not pressed up."""
    shapes, slopes = [lambda x: (x / 40) ** 2, lambda x: (x / 40) ** 3], [lambda x: x / 800, lambda x: 3 * x**2 / 64e3]
    deform = vertical(shapes, slopes)
    C = pressure_stiffness(box(), lambda points: together(rigid_field(points), deform(points)))
    x = np.linspace(-40, 40, 20001)
    for i in range(2):
        for j in range(2):
            expected = 10.0 * np.trapezoid(shapes[i](x) * shapes[j](x), x)
            assert C[6 + i, 6 + j] == pytest.approx(expected, rel=2e-3, abs=0.1)
    assert C[2, 6] == pytest.approx(10.0 * np.trapezoid(shapes[0](x), x), rel=2e-3)


def test_the_stiffness_is_the_change_of_the_pressure_load():
    """The same as loads of a mesh that is moved a little, for a field in all directions."""

    def deform(points):
        x, y, z = points.T
        moved = np.stack([0.02 * x * z, 0.3 * np.sin(x / 30) + 0.01 * y * z, 1.0 + 0.02 * x - 1e-4 * x**2], axis=1)
        gradient = np.zeros((len(x), 3, 3))
        gradient[:, 0, 0], gradient[:, 0, 2] = 0.02 * z, 0.02 * x
        gradient[:, 1, 0], gradient[:, 1, 1], gradient[:, 1, 2] = 0.01 * np.cos(x / 30), 0.01 * z, 0.01 * y
        gradient[:, 2, 0] = 0.02 - 2e-4 * x
        return Field(moved[None], gradient[None])

    panels = box(pieces=(160, 20, 20))

    def load(step):
        there = (panels.reshape(-1, 3) + step * deform(panels.reshape(-1, 3)).displacement[0]).reshape(panels.shape)
        triangles, first = (np.concatenate([p[:, [0, 1, 2]], p[:, [0, 2, 3]]]) for p in (there, panels))
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2
        shape = rigid_field(first.mean(axis=1)).displacement  # virtual motion of the material points
        return np.einsum("mka,ka,k->m", shape, normal, triangles.mean(axis=1)[:, 2])

    found = pressure_stiffness(panels, lambda points: together(rigid_field(points), deform(points)))[:6, 6]
    expected = -(load(1e-4) - load(-1e-4)) / 2e-4
    np.testing.assert_allclose(found, expected, rtol=5e-3, atol=5e-3 * np.abs(expected[:3]).max())
