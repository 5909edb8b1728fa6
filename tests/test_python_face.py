"""What a user of the Python package finds: names, versions, short reprs, tables for notebooks, pictures and files."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest
from scipy.io import loadmat

import fowtlib as fw
from fowtlib.components.environment import World
from fowtlib.components.mechanics import FixedFlange, FixedTranslation, PointMass, Revolute, TorsionSpringDamper
from fowtlib.language.errors import ModelError, SimulationError


def pendulum() -> fw.Model:
    """One of 1 m and 2 kg, damped, with a drive that may be opened."""
    root = fw.Assembly("pendulum")
    root.world = World(gravity=9.81)
    root.hinge = Revolute(n=(0, 1, 0), phi_start="20 deg")
    root.rod, root.bob = FixedTranslation(r=(0, 0, -1.0)), PointMass(mass=2.0)
    root.damper, root.ground = TorsionSpringDamper(stiffness=0.0, damping=0.5), FixedFlange()
    root.connect(root.world.frame, root.hinge.frame_a)
    root.connect(root.hinge.frame_b, root.rod.frame_a)
    root.connect(root.rod.frame_b, root.bob.frame_a)
    root.connect(root.hinge.flange, root.damper.flange_b)
    root.connect(root.damper.flange_a, root.ground.flange)
    outputs = {"pitch": fw.Output("hinge.phi", "deg", "angle of the rod")}
    return fw.Model(root, "a pendulum", outputs, {"duration": 3.0, "output_step": 0.05}, name="pendulum")


@pytest.fixture(scope="module")
def plant():
    return pendulum().compile()


def test_the_names_are_those_that_are_there():
    assert sorted(dir(fw)) == sorted([*fw.__all__, "__version__"])
    assert all(getattr(fw, name) is not None for name in dir(fw))
    assert set(fw.analysis.__all__) - set(dir(fw)) <= {
        "Campbell", "Decay", "DecayFit", "HarmonicFit", "ParameterMap", "PullTest", "Rao",
        "RegularTest", "Sheet", "SpectralRao", "Spectrum", "StaticCurve", "Transfer"
    }  # what the functions give  # fmt: skip
    assert fw.__version__ == version("fowtlib")
    with pytest.raises(AttributeError, match="module 'fowtlib' has no attribute 'lod'"):
        fw.lod  # noqa: B018


def test_the_packages_of_parts():
    assert fw.components.mooring.CatenaryLine.__name__ == "CatenaryLine"
    for name in dir(fw.components):
        assert getattr(fw.components, name).__name__ == f"fowtlib.components.{name}"
    with pytest.raises(AttributeError, match=r"no attribute 'moring'; there are aero, .*mooring"):
        fw.components.moring  # noqa: B018


def test_nothing_is_imported_before_it_is_used():
    text = "import sys, fowtlib; dir(fowtlib); print(sorted(m for m in sys.modules if m.startswith('fowtlib.')))"
    loaded = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True).stdout
    assert "fowtlib.analysis" not in loaded and "fowtlib.components" not in loaded and "fowtlib.solving" not in loaded


def test_short_reprs(plant):
    assert repr(pendulum()) == "<Model pendulum: a pendulum; 6 parts, 1 outputs>"
    assert repr(plant.initial_state()) == "<State of a pendulum: t = 0 s, 2 states, 0 unknowns>"
    spar = fw.load("oc3_spar_rigid")
    assert len(repr(spar)) < 150 and repr(spar).startswith("<Model oc3_spar_rigid: OC3-Hywind spar")


def test_tables_for_a_notebook(plant):
    state, result = plant.initial_state(), plant.simulate()
    linear = plant.linearize(state)
    for item in (pendulum(), plant, state, result, result.statistics(), linear):
        text = item._repr_html_()
        assert text.count("<table>") == text.count("</table>") == 1 and "object at 0x" not in text
    assert '<td style="text-align: right">20</td><td>deg</td>' in state._repr_html_()
    assert "<td>angle of the rod</td>" in pendulum()._repr_html_()


def test_pictures_of_what_can_be_drawn(plant, tmp_path):
    result = plant.simulate(10.0)
    assert result.plot(tmp_path / "run.png").axes and (tmp_path / "run.png").stat().st_size > 5000
    assert [axis.get_title(loc="left") for axis in result.plot(None, "pitch", "hinge.w").axes] != []
    decay = fw.analyse_decay(result["pitch"])
    assert decay.plot(tmp_path / "decay.svg").axes
    assert fw.power_spectrum(result["pitch"]).plot().axes


def test_files_of_what_can_be_saved(plant, tmp_path):
    result = plant.simulate(10.0)
    path = result.statistics().save(tmp_path / "statistics.csv")
    head, row = path.read_text().splitlines()
    assert head == "name,unit,mean,std,min,max,rms" and row.startswith("pitch,deg,")
    spectrum = fw.power_spectrum(result["pitch"])
    saved = np.loadtxt(spectrum.save(tmp_path / "spectrum.csv"), delimiter=",", skiprows=1)
    np.testing.assert_allclose(saved, np.column_stack([spectrum.frequency, spectrum.density]), rtol=1e-9)
    decay = fw.analyse_decay(result["pitch"])
    saved = np.loadtxt(decay.save(tmp_path / "decay.csv"), delimiter=",", skiprows=1)
    np.testing.assert_allclose(saved, np.column_stack([decay.amplitude, decay.damping]), rtol=1e-9)
    linear = plant.linearize(plant.equilibrium(), inputs=["bob.mass"])
    back = loadmat(linear.save(tmp_path / "linear.mat"))
    np.testing.assert_array_equal(back["A"], linear.matrices["A"])
    assert [str(name[0]) for name in back["outputs"].ravel()] == ["pitch"]
    back = np.load(linear.save(tmp_path / "linear.npz"))
    assert back["states"].tolist() == linear.states and back["output_units"].tolist() == ["deg"]
    for item in (result.statistics(), spectrum, decay, linear, plant.initial_state()):
        with pytest.raises(ModelError, match=r"x\.txt: .*saved as "):
            item.save(tmp_path / "x.txt")


def test_a_state_is_saved_and_read_again(plant, tmp_path):
    state = plant.initial_state(start={"hinge.phi": "0.3 rad", "hinge.w": 0.2})
    path = state.save(tmp_path / "state.json")
    back = fw.State.open(path, plant)
    np.testing.assert_array_equal(back.x, state.x)
    assert back["pitch"] == pytest.approx(np.degrees(0.3))
    content = json.loads(path.read_text())
    del content["states"]["hinge.w"]
    path.write_text(json.dumps(content))
    with pytest.raises(SimulationError, match=r"the state is of another model: it has no hinge\.w"):
        fw.State.open(path, plant)
    path.write_text("[]")
    with pytest.raises(ModelError, match="this is not a state"):
        fw.State.open(path, plant)


def test_inputs_with_names_of_their_own():
    """The plant takes the name wherever it takes the path, and the linear model is labelled with it."""
    path = "turbine.blade_pitch"
    model = fw.load("oc3_spar_rigid", set={"wind.kind": "steady", "wind.mean_speed": "16 m/s", "sea.spectrum": "still"})
    named, plain = model.compile(inputs={"pitch": path}), model.compile(inputs=[path])
    one = named.simulate(2.0, 0.5, inputs={"pitch": "12 deg"})
    two = plain.simulate(2.0, 0.5, inputs={path: "12 deg"})
    np.testing.assert_array_equal(one["surge"], two["surge"])
    linear = named.linearize(named.initial_state(), inputs=["pitch", "wind.mean_speed"], outputs=["thrust"])
    assert linear.inputs == ["pitch", "wind.mean_speed"]
    other = plain.linearize(plain.initial_state(), inputs=[path, "wind.mean_speed"], outputs=["thrust"])
    np.testing.assert_array_equal(linear.matrices["D"], other.matrices["D"])


def test_the_root_of_a_model_knows_its_outputs():
    model = fw.load("oc3_spar_rigid")
    again = fw.load(model.root)
    assert (again.title, again.outputs, again.settings, again.name) == (
        model.title, model.outputs, model.settings, model.name
    )  # fmt: skip
    changed = fw.load(model.root, set={"platform.hull.mass": "7500 t"})
    assert list(changed.outputs) == list(model.outputs) and changed.root.platform.hull.parameter_value("mass") == 7.5e6
    alone = fw.load(fw.Assembly("nothing"))
    assert alone.outputs == {} and alone.settings == {}


@pytest.mark.parametrize("start", [3.0, [0.1, 0.2]])
def test_a_start_of_another_kind_is_refused(plant, start):
    with pytest.raises(ModelError, match=r"^start: .* is no State, no Result, no start values by path and no word; w"):
        plant.simulate(1.0, start=start)


def test_a_start_by_an_unknown_word_is_refused(plant):
    with pytest.raises(ModelError, match=r"^start: 'equilibrum' is not 'equilibrium', 'turning', 'stationary', 'rest'"):
        plant.simulate(1.0, start="equilibrum")


def test_a_mode_shows_itself_in_a_line(plant):
    mode = fw.natural_modes(plant, plant.equilibrium())[0]
    assert repr(mode) == "<NaturalMode 1 pitch: 0.4985 Hz, 2.006 s, damping ratio 0.0399>"
