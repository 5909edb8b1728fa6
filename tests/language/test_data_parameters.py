"""A data file is declared: given as a path or as an object, read again when it changes, named in results and FMUs."""

import hashlib
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.components.aero import BladeElementAerodynamics, read_blade, read_coefficients
from fowtlib.components.mechanics import BeamProperties
from fowtlib.components.support import FlexibleTower
from fowtlib.language import Data, RealOutput, Scalar, data, eq, param, port
from fowtlib.language.data_files import files_of, lines_of, remembered
from fowtlib.language.errors import ModelError, ParameterError
from fowtlib.modelfile import dump
from fowtlib.modelfile.files import data_path


@dataclass(frozen=True)
class Fluid:
    """Density by temperature."""

    temperature: tuple[float, ...]
    density: tuple[float, ...]


@remembered()
def read_fluid(path, factor=1.0):
    rows = [[float(cell) for cell in line.split(",")] for _, line in lines_of(path)]
    return Fluid(*(tuple(column) for column in zip(*((t, factor * d) for t, d in rows), strict=True)))


class Pipe(fw.Component):
    """Mass in a pipe: volume times the density at a temperature."""

    fluid: Data[Fluid] = data(read_fluid, using=("factor",), doc="CSV of temperature [K] and density [kg/m^3]")
    factor: Scalar = param(default=1.0, structural=True, doc="on the density")
    temperature: Scalar = param(default=300.0, structural=True, unit="K", doc="temperature")
    mass: RealOutput = port(unit="kg/m^3", doc="mass per volume")

    def equations(self):
        at = float(np.interp(self.temperature, self.fluid.temperature, self.fluid.density))
        return [eq(self.mass, at)]


@pytest.fixture
def csv(tmp_path):
    path = tmp_path / "water.csv"
    path.write_text("280,1000\n320,980\n")
    return path


def mass(pipe):
    return fw.load(pipe).compile().initial_state()["mass"]


def test_one_way_in_for_path_and_object(csv):
    for given in (str(csv), csv, Fluid((280.0, 320.0), (1000.0, 980.0))):
        pipe = Pipe(fluid=given)
        assert pipe.fluid.density == (1000.0, 980.0) and mass(pipe) == 990.0
    assert Pipe(fluid=str(csv), factor=2.0).fluid.density == (2000.0, 1960.0)
    pipe.fluid = str(csv)
    assert mass(pipe) == 990.0


def test_what_is_neither(csv):
    for wrong in (3.0, (1, 2), Pipe(fluid=str(csv))):
        with pytest.raises(ParameterError) as error:
            Pipe(fluid=wrong)
        assert str(error.value) == (
            f"Pipe.fluid is a {type(wrong).__name__}; the path of a file or a Fluid is expected "
            "(CSV of temperature [K] and density [kg/m^3])."
        )
    with pytest.raises(ParameterError, match="Pipe.fluid has no value: CSV of temperature"):
        mass(Pipe())
    with pytest.raises(ModelError, match="none.csv: cannot read the file: No such file or directory"):
        mass(Pipe(fluid="none.csv"))


def test_a_file_that_changes_between_two_compilations(csv):
    pipe = Pipe(fluid=str(csv))
    assert mass(pipe) == 990.0
    csv.write_text("280,1000\n320,900\n")
    assert mass(pipe) == 950.0


def test_results_name_files_and_their_content(csv, tmp_path):
    plant = fw.load(Pipe(fluid=str(csv))).compile()
    named = f"water.csv sha256:{hashlib.sha256(csv.read_bytes()).hexdigest()}"
    result = plant.simulate(1.0, outputs=["mass"])
    assert result.attributes["data"] == {"fluid": named} and result.attributes["structure"]["fluid"] == named
    result.save(tmp_path / "run.nc")
    assert type(result).open(tmp_path / "run.nc").attributes["data"] == {"fluid": named}


def test_results_of_a_shipped_model_name_its_tables():
    plant = fw.load("oc3_spar_rigid").compile()
    files = files_of(plant.root)
    assert {path.rpartition(".")[2] for path in files} >= {"coefficients", "database"}
    data_of = plant.simulate(0.1).attributes["data"]
    table = Path(files["turbine.rotor.coefficients"])
    digest = hashlib.sha256(table.read_bytes()).hexdigest()
    assert data_of["turbine.rotor.coefficients"] == f"{table.name} sha256:{digest}"


def test_fmus_bring_the_files(csv, tmp_path):
    root = fw.Assembly()
    root.pipe = Pipe(fluid=str(csv))
    from fowtlib.fmi.export import data_files

    files = data_files(root)
    index = json.loads(files["resources/data/data.json"])
    assert list(index) == ["pipe.fluid"]
    assert files[f"resources/data/{index['pipe.fluid']['file']}"] == csv.read_bytes()
    assert index["pipe.fluid"]["sha256"] == hashlib.sha256(csv.read_bytes()).hexdigest()
    path = fw.export_fmu(fw.load(root).compile(), tmp_path / "pipe.fmu")
    with zipfile.ZipFile(path) as archive:
        assert set(files) <= set(archive.namelist())


def test_a_rotor_from_a_table_and_from_its_file():
    rotor = fw.load("oc3_spar_rigid").root.turbine.rotor
    path = rotor.parameter_binding("coefficients")
    table = read_coefficients(path, rotor.extended)
    states = []
    for given in (path, table):
        model = fw.load("oc3_spar_rigid", set={"wind.kind": "steady", "wind.mean_speed": 12.0})
        model.root.turbine.rotor.coefficients = given
        states.append(model.compile().initial_state()["turbine.thrust"])
    assert states[0] == states[1]
    assert f"data:nrel5mw/{Path(path).name}" in dump(fw.load("oc3_spar_rigid"))


def test_a_blade_from_an_object():
    files = [str(data_path(f"nrel5mw/{name}.csv")) for name in ("blade_aerodynamics", "airfoils")]
    blade = read_blade(*files, 1.5, 63.0)
    air = BladeElementAerodynamics(blade=blade, tip_radius=63.0)
    same = BladeElementAerodynamics(blade=files[0], airfoils=files[1], hub_radius=1.5, tip_radius=63.0)
    assert air.rotor.blade is blade is same.rotor.blade
    with pytest.raises(ParameterError, match="tip_radius is 62 m, and that of the blade 63 m"):
        BladeElementAerodynamics(blade=blade, tip_radius=62.0).rotor  # noqa: B018
    with pytest.raises(ParameterError, match="airfoils: the blade that is given has airfoils of its own"):
        other = {"airfoils": files[1], "smooth_airfoils": False}
        BladeElementAerodynamics(blade=blade, tip_radius=63.0, **other).rotor  # noqa: B018
    with pytest.raises(ParameterError, match="airfoils has no value"):
        BladeElementAerodynamics(blade=files[0], hub_radius=1.5, tip_radius=63.0).rotor  # noqa: B018


def test_a_tower_from_an_object():
    beam = BeamProperties.uniform(80.0, 4000.0, 5e11)
    assert FlexibleTower(properties=beam, hinges=2).properties is beam
    assert FlexibleTower(table=beam, hinges=2).beam.properties is None
    with pytest.raises(ParameterError, match="give properties, the path of a CSV, or table"):
        FlexibleTower(properties=beam, table=beam, hinges=2)
