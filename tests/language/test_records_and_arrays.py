"""Parameters that several classes share are declared once; arrays of parts have a number."""

import math

import pytest

import fowtlib as fw
from fowtlib.components.mechanics import Beam, BeamProperties
from fowtlib.components.mechanics.beam_settings import BeamSettings
from fowtlib.components.mechanics.tube_beam import TubeBeam
from fowtlib.components.support import Arm, FlexibleTower
from fowtlib.components.turbine import FlexibleBlade, Hub, RotorNacelleAssembly
from fowtlib.language import Scalar, der, eq, like, param, part, parts, port, var
from fowtlib.language.connectors import RealInput, RealOutput
from fowtlib.language.errors import ModelError, ParameterError


class Cell(fw.Component):
    """A store of heat in a row: C T' = what comes in."""

    capacity: Scalar = param(default=1.0, doc="capacity")
    T_start: Scalar = param(default=0.0, doc="start")
    u: RealInput = port(default=0.0, doc="heat that comes in")
    y: RealOutput = port(doc="temperature")
    T: Scalar = var(start=T_start, fixed=True, doc="temperature")

    def equations(self):
        return [eq(self.capacity * der(self.T), self.u), eq(self.y, self.T)]


class Heavy(Cell):
    """Ten times the capacity."""

    def equations(self):
        return [eq(10 * self.capacity * der(self.T), self.u), eq(self.y, self.T)]


class Row(fw.Component):
    """So many cells that all get the same heat."""

    count: int = param(default=3, min=0, doc="number of cells")
    capacity: Scalar = param(default=2.0, doc="of each cell")
    u: RealInput = port(default=6.0, doc="heat into each")
    cells: list[Cell] = parts(
        Cell, size="count", name="cell", capacity=capacity, each=lambda self, k: {"T_start": 10.0 * k}
    )

    def build(self):
        for cell in self.cells:
            self.connect(self.u, cell.u)


def temperatures(row, **parameters):
    result = fw.load(row).compile().simulate(1.0, output_step=1.0, parameters=parameters)
    return [float(result[f"{cell.path}.T"][-1]) for cell in row.cells]


def test_an_array_of_parts():
    row = Row()
    assert list(row.parts) == ["cell_1", "cell_2", "cell_3"] and len(row.cells) == 3
    assert row.cells[1] is row.cell_2 and row.cells[-1] is row.cell_3 and row.cells[:2] == [row.cell_1, row.cell_2]
    assert temperatures(row) == pytest.approx([3.0, 13.0, 23.0])
    assert temperatures(row, capacity=6.0) == pytest.approx([1.0, 11.0, 21.0])
    row.count = 1
    assert temperatures(row) == pytest.approx([3.0])
    assert len(Row(count=0).cells) == 0


def test_one_of_them_is_replaced():
    row = Row()
    row.cells[1] = Heavy(T_start=1.0)
    assert temperatures(row) == pytest.approx([3.0, 1.6, 23.0])
    row.cell_3 = Heavy()
    row.count = 4
    assert [type(cell).__name__ for cell in row.cells] == ["Cell", "Heavy", "Heavy", "Cell"]
    with pytest.raises(ParameterError, match="Row cannot take the place of Row.cell_1, a Cell"):
        row.cells[0] = Row()
    with pytest.raises(ParameterError, match="Row.cells is an array of parts; assign to one of them"):
        row.cells = [Cell()]


def test_all_of_them_by_the_constructor():
    row = Row(count=2, cells=[Heavy(), Cell(T_start=5.0)])
    assert temperatures(row) == pytest.approx([0.6, 11.0])
    with pytest.raises(ParameterError, match="Row makes no part 'cell_2' that a Cell could take the place of"):
        Row(count=1, cells=[Cell(), Cell()])
    with pytest.raises(ParameterError, match="Row.cells is an array of parts; give a list of components"):
        Row(cells=Cell())


def test_an_array_within_a_declared_part():
    class Building(fw.Component):
        """Two rows."""

        row: Row = part(Row, count=2)
        others: list[Row] = parts(Row, size=2, name="other", count=1)

    building = Building()
    building.others[1].cells[0].T_start = 7.0
    building.others[1].count = 2
    assert [cell.parameter_value("T_start") for cell in building.others[1].cells] == [7.0, 10.0]
    assert sum(1 for _ in building.walk()) == 1 + 1 + 2 + 2 + 3


class Sizes(fw.Component):
    """Partial: a record."""

    length: Scalar = param(default=1.0, unit="m", doc="length")
    count: int = param(default=2, doc="count")


class Colour(fw.Component):
    """Partial: another one."""

    shade: Scalar = param(default=0.5, doc="shade")


class Inner(Sizes, Colour):
    """Has both."""

    area: Scalar = var(unit="m^2", doc="area")

    def equations(self):
        return [eq(self.area, self.shade * self.length**2)]


class Outer(Sizes, Colour):
    """Has both too, with another default, and hands them on."""

    count: int = param(default=5, doc="count")

    def build(self):
        self.inner = Inner(**self.values_of(Sizes), **self.values_of(Colour))


def test_records():
    assert set(Inner.parameters) == {"length", "count", "shade"}
    outer = Outer(length="3 m")
    assert outer.inner.count == 5 and Inner().count == 2
    plant = fw.load(outer).compile()
    assert plant.initial_state()["inner.area"] == 4.5
    assert plant.initial_state({"shade": 1.0})["inner.area"] == 9.0


@pytest.mark.parametrize("kind", [FlexibleTower, Arm, FlexibleBlade])
def test_the_settings_of_a_beam_reach_it(kind):
    table = BeamProperties.uniform(60.0, 300.0, 1e9, torsional_stiffness=1e8)
    more = {"to": (0, 60, 0)} if kind is Arm else {}
    given = {"hinges": 3, "quadrature": "plain", "torsion": True, "cuts": [10.0, 20.0], "stiffness_factor": 1.5}
    owner = kind(table=table, **given, **more)
    assert set(BeamSettings.parameters) == {*given, "n_cuts"}
    for name in given:
        assert owner.beam.parameter_value(name) == pytest.approx(given[name])
    assert owner.beam.parameter_value("n_cuts") == 2


def test_the_hub_has_arrays():
    hub = Hub(radius=1.5, blades=2, rotation=-1)
    assert [mount.parameter_value("azimuth") for mount in hub.mounts] == pytest.approx([0.0, -math.pi])
    assert [bearing.path for bearing in hub.bearings] == ["bearing_1", "bearing_2"]


class Doubled(Sizes):
    """Another default for one of a record, and one of its parts' parameters under another name."""

    length: Scalar = like(Sizes.length, default="4 m")
    shade_of_inner: Scalar = like(Inner.shade, doc="shade of the part")
    inner: Inner = part(Inner, length=length, shade=shade_of_inner)


def test_a_parameter_like_another():
    length, shade = Doubled.parameters["length"], Doubled.parameters["shade_of_inner"]
    assert (length.unit, length.doc, length.owner, length.name) == ("m", "length", Doubled, "length")
    assert (shade.default, shade.doc, Colour.parameters["shade"].doc) == (0.5, "shade of the part", "shade")
    assert Sizes.parameters["length"].default == 1.0 and Sizes.parameters["length"].owner is Sizes
    plant = fw.load(Doubled()).compile()
    assert plant.initial_state()["inner.area"] == 8.0
    assert plant.initial_state({"shade_of_inner": 2.0, "length": 3.0})["inner.area"] == 18.0
    with pytest.raises(ModelError, match="Doubled.length: got .3 kg., which is a mass"):
        Doubled(length="3 kg")
    with pytest.raises(TypeError, match="takes a parameter of a class"):
        like(Inner.area)


def test_the_settings_of_a_beam_are_declared_once():
    """The same bounds, choices and units wherever they are handed on; only names, defaults and sentences differ."""
    handed_on = {(RotorNacelleAssembly, f"blade_{name}"): name for name in ("hinges", "quadrature", "torsion", "cuts")}
    for kind in (Beam, TubeBeam, FlexibleTower, Arm, FlexibleBlade):
        handed_on |= {(kind, name): name for name in BeamSettings.parameters}
    facts = ("annotation", "unit", "min", "max", "choices", "shape")
    for (kind, name), declared in handed_on.items():
        here, there = kind.parameters[name], BeamSettings.parameters[declared]
        moving = declared == "cuts" and kind is TubeBeam  # with its stations
        assert not (moving and here.structural)
        for fact in facts if moving else (*facts, "structural", "why_structural"):
            assert getattr(here, fact) == getattr(there, fact), (kind, name, fact)
    table = BeamProperties.uniform(60.0, 300.0, 1e9)
    for name, wrong, message in (
        ("blade_quadrature", "gauss", "quadrature of a beam: .*, not 'gauss'"),
        ("blade_hinges", -1, "RotorNacelleAssembly.blade_hinges = -1 is below its minimum 0"),
    ):
        with pytest.raises(ModelError, match=message):
            RotorNacelleAssembly(blade_table=table, **{name: wrong})


def test_damping_of_the_blades_of_an_assembly():
    table = BeamProperties.uniform(60.0, 300.0, 1e9)
    assembly = RotorNacelleAssembly(blade_table=table, blade_hinges=2, damping_flapwise=0.01, node_points=[30.0])
    for blade in assembly.rotor_blades:
        assert blade.parameter_value("damping_flapwise") == blade.parameter_value("damping_edgewise") == 0.01
        assert blade.parameter_value("hinges") == 2 and blade.n_nodes == 1
