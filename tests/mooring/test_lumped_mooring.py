"""Mooring systems of lines with dynamics: the shipped platforms by one parameter, linear models, files."""

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.language.errors import ModelError

LUMPED = {"platform.mooring.dynamics": "lumped", "platform.mooring.elements": 8}


@pytest.fixture(scope="module")
def spar():
    """The OC3 spar with eight elements a line, and the same with catenaries."""
    return fw.load("oc3_spar_rigid", set=LUMPED).compile(), fw.load("oc3_spar_rigid").compile()


def test_the_mean_position_is_that_of_the_catenaries(spar):
    """Eight elements a line; surge within a per cent, tensions as well."""
    calm = {"wind.kind": "steady", "wind.mean_speed": 11.4, "sea.spectrum": "still"}
    lumped, quasi_static = (plant.equilibrium(calm) for plant in spar)
    assert lumped["surge"] == pytest.approx(quasi_static["surge"], rel=0.01)
    for name in ("fairlead_tension_1", "fairlead_tension_2", "fairlead_tension_3"):
        assert lumped[name] == pytest.approx(quasi_static[name], rel=0.01), name


def test_modes_of_the_platform_stay_and_those_of_the_lines_are_added(spar):
    """Heave, pitch, roll and yaw; each line has seven nodes, which move in three directions."""
    still = {"wind.kind": "none", "sea.spectrum": "still"}
    lumped, quasi_static = (
        [mode for mode in plant.linearize(plant.equilibrium(still), outputs=[]).modes() if mode.frequency_hz > 1e-4]
        for plant in spar
    )
    found = np.array([mode.frequency_hz for mode in lumped])
    for name in ("heave", "angle_rates[0]", "angle_rates[1]", "yaw"):
        own = next(mode.frequency_hz for mode in quasi_static if mode.label.endswith(name))
        assert np.min(np.abs(found / own - 1)) < 0.02, name
    assert len(lumped) == len(quasi_static) + 3 * 7 * 3


def test_a_run_in_waves_starts_where_the_platform_is_and_moves_as_it_does(spar):
    calm = {"wind.kind": "none", "sea.spectrum": "regular", "sea.wave_height": 4.0, "sea.wave_period": 9.0,
            "sea.build_up": 20.0, "platform.motion.surge_start": 6.0}  # fmt: skip
    lumped, quasi_static = (plant.simulate(60.0, output_step=0.2, parameters=calm, solver="fixed", step=0.0125)
                            for plant in spar)  # fmt: skip
    first = [float(result["fairlead_tension_2"][0]) for result in (lumped, quasi_static)]
    assert first[0] == pytest.approx(first[1], rel=0.01)
    begin = lumped.time < 25  # later drag of the lines damps what is left of the start
    assert np.asarray(lumped["surge"])[begin] == pytest.approx(np.asarray(quasi_static["surge"])[begin], abs=0.3)
    dynamic, static = (np.std(np.asarray(result["fairlead_tension_2"])[-90:]) for result in (lumped, quasi_static))
    assert dynamic > 1.2 * static  # drag holds the shape of a line, which stretches instead


def test_a_model_with_them_is_written_and_read_again(tmp_path):
    path = tmp_path / "again.yaml"
    path.write_text(fw.dump(fw.load("oc3_spar_rigid", set=LUMPED)), encoding="utf-8")
    again = fw.load(path).root.find("platform.mooring")
    assert again.parameter_value("elements") == 8
    assert type(again.lines[1]).__name__ == "DynamicLine"


@pytest.mark.parametrize(
    ("name", "value", "dynamics"), [("elements", 20, "none"), ("axial_drag_coefficient", 0.1, "coupled"),
                                    ("seabed_stiffness", 1e4, "uncoupled")]
)  # fmt: skip
def test_what_only_lumped_lines_have_is_refused_for_others(name, value, dynamics):
    given = {f"platform.mooring.{name}": value, "platform.mooring.dynamics": dynamics}
    said = rf"MooringSystem.{name} is given and would do nothing.* here {dynamics}\)"
    with pytest.raises(ModelError, match=said):
        fw.load("oc3_spar_rigid", set=given)
