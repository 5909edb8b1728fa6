"""Which hulls a model has, and the meshes of floaters of members, columns, and of what cannot be meshed."""

from types import SimpleNamespace

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.hydro import Hydrostatics, MorisonDrag
from fowtlib.components.hydro.model_hulls import hulls
from fowtlib.components.hydro.panel_mesh import Column, Pontoon, floater_mesh, hydrostatics, lid_panels
from fowtlib.components.mechanics import VisualTube
from fowtlib.components.mechanics.connectors import Frame
from fowtlib.language import Component, port
from fowtlib.language.errors import ParameterError


class MadeOfMembers(Component):
    """What a Floater promises: a hull that meshes itself."""

    wrong = 1.0
    frame: Frame = port(doc="reference point")

    def hull(self):
        columns = [Column(((-12.0, 8.0), (2.0, 8.0)), x=x) for x in (-14.0, 14.0)]
        pontoons = [Pontoon((-14, 0, -9), (14, 0, -9), width=4, height=3)]
        volume, _, C = hydrostatics(floater_mesh(columns, pontoons, 1.0))

        def skewed(panels):  # cut along one diagonal: the panels are no mirror images
            return np.concatenate([panels[:, [0, 1, 2, 2]], panels[:, [0, 2, 3, 3]]])

        return SimpleNamespace(
            panels=lambda size: skewed(floater_mesh(columns, pontoons, size)),
            lids=lambda size: lid_panels(columns, pontoons, size),
            buoyancy=SimpleNamespace(volume=volume * self.wrong, waterplane=C),
        )  # fmt: skip


class Wrong(MadeOfMembers):
    """The same, of another volume than its mesh."""

    wrong = 1.02


def model(**parts):
    root = fw.Assembly("model")
    root.world = World(water_depth=100.0)
    for name, part in parts.items():
        root.add(name, part)
    return root


def tube(cls=VisualTube, points=((0, 0, -20), (0, 0, 5)), diameters=(6.0, 6.0), **more):
    more |= {"material": "hull"} if cls is VisualTube else {"drag_coefficient": 0.6}
    return cls(points=points, diameters=diameters, **more)


def test_a_floater_of_members_meshes_itself():
    found = hulls(model(floater=MadeOfMembers()))
    assert list(found) == ["floater"]
    mesh = found["floater"].mesh(3.0)
    assert mesh.symmetry.planes == ("xOz", "yOz")
    assert mesh.name == "floater"
    assert mesh.volume == pytest.approx(1450.6, rel=5e-3)


def test_a_mesh_of_another_volume_than_the_members_is_refused():
    with pytest.raises(ParameterError, match=r"floater: the mesh displaces .* are expected \(-1.9"):
        hulls(model(floater=Wrong()))["floater"].mesh(2.0)


def test_columns_of_one_composite_are_one_hull():
    """From the top or from the bottom; drag goes before pictures; a tower is no hull."""
    three = {f"column_{k}": tube(points=((10 * k, 0, 5), (10 * k, 0, -20)), diameters=(5.0, 6.0)) for k in range(3)}
    tower = VisualTube(points=((0, 0, 10), (0, 0, 90)), diameters=(6.0, 4.0))
    (hull,) = hulls(model(tower=tower, **three)).values()
    volume = 3 * np.pi / 12 * 20 * (36 + 6 * 5.2 + 5.2**2)  # 5.2 m at the water
    assert hull.mesh(2.0).volume == pytest.approx(volume, rel=1e-6)
    (hull,) = hulls(model(drag=tube(MorisonDrag, position=(0, 0, -1)), picture=tube(diameters=(9.0, 9.0)))).values()
    assert hull.mesh(2.0).volume == pytest.approx(np.pi * 9 * 21)
    assert hull.volume is None
    water = Hydrostatics(volume=594.0, centre_of_buoyancy=(0, 0, -10.5), stiffness=np.zeros((6, 6)))
    (hull,) = hulls(model(drag=tube(MorisonDrag), water=water)).values()
    assert hull.volume == 594
    assert not hulls(model(tower=VisualTube(points=((0, 0, 10), (0, 0, 90)), diameters=(6.0, 4.0))))


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (((0, 0, -20), (9, 0, -20)), "hull is no upright column: the panel method meshes upright round columns"),
        (((0, 0, -20), (0.5, 0, 5)), "hull is no upright column"),
        (((0, 0, 5), (0, 0, 9)), "hull: column: sections must be .* lies below the water"),
    ],
)
def test_what_cannot_be_meshed_is_said(points, message):
    (hull,) = hulls(model(hull=tube(points=points))).values()
    with pytest.raises(ParameterError, match=message):
        hull.mesh(2.0)


@pytest.mark.parametrize("size", [1.9, 2.0, 2.05])
def test_members_that_nearly_touch(size):
    """The round ends of the OO-Star's pontoons are as wide as these: their surfaces cut in edges of 0.1 mm."""
    floater = hulls(fw.load("oo_star_rigid").root)["platform.hull"]
    assert floater.mesh(size).volume == pytest.approx(floater.volume, rel=1e-5)
