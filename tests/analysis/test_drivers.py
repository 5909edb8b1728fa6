"""Drivers of analyses on a small floating body whose answers are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from fowtlib.analysis import free_decay, linear_rao, simulated_rao, static_curve
from fowtlib.components.environment import Sea, WaveComponents, World
from fowtlib.language import Array, Assembly, Component, Scalar, der, eq, outer, param, var
from fowtlib.language import math as m
from fowtlib.language.errors import ModelError, SimulationError
from fowtlib.solving import Model, Output, Result

FREQUENCY = np.array([0.02, 0.05, 0.079577, 0.1, 0.2])  # the third is close to resonance


class Buoy(Component):
    """Mass on a spring in waves: m x'' + c x' + b x' |x'| + k x = force + first element of the wave load."""

    mass: Scalar = param(default=2.0, unit="kg", doc="mass")
    stiffness: Scalar = param(default=0.5, unit="N/m", doc="stiffness")
    damping: Scalar = param(default=0.08, unit="N*s/m", doc="linear damping")
    drag: Scalar = param(default=0.0, unit="N*s^2/m^2", doc="quadratic damping")
    force: Scalar = param(default=0.0, unit="N", doc="steady force")
    extra_load: Array = param(default=(0.0, 0.0), shape=(2,), unit="N", doc="load added to the wave load")

    sea: Sea = outer(Sea, optional=True)
    x: Scalar = var(unit="m", state="prefer", doc="position")
    v: Scalar = var(unit="m/s", state="prefer", doc="velocity")
    load: Scalar = var(unit="N", doc="load on the body")

    wave_inputs = ("extra_load",)

    def wave_transfer(self, omega: np.ndarray, heading: float) -> np.ndarray:
        """Load per unit amplitude: falls with frequency, and lags the crest."""
        first = np.cos(heading) * np.exp(-0.5 * omega) * np.exp(-0.3j * omega)
        return np.stack([first, 0 * first], axis=1)

    def equations(self):
        wave = self.sea.signal(_wave_load, 2, "wave load", of=self)[0] if self.sea is not None else 0.0
        resistance = self.damping * self.v + self.drag * self.v * m.smooth_abs(self.v, 1e-6)
        return [
            eq(der(self.x), self.v),
            eq(self.load, self.force + self.extra_load[0] + wave),
            eq(self.mass * der(self.v), self.load - resistance - self.stiffness * self.x),
        ]


def _wave_load(waves: WaveComponents, buoy: Buoy) -> np.ndarray:
    return buoy.wave_transfer(waves.omega, waves.heading)


def buoy_model(**parameters: float) -> Model:
    """The buoy alone, with its position also in millimetres."""
    outputs = {"surge": Output("x"), "speed": Output("v"), "load": Output("load", "kN"), "way": Output("x", "mm")}
    return Model(Buoy(**parameters), title="a buoy", outputs=outputs)


def buoy_at_sea(**parameters: float) -> Model:
    """The buoy in a world with a sea."""
    root = Assembly("a buoy at sea")
    root.world, root.sea, root.buoy = World(), Sea(), Buoy(**parameters)
    return Model(root, outputs={"surge": Output("buoy.x"), "wave_elevation": Output("sea.elevation")})


def exact_response(frequency: np.ndarray) -> np.ndarray:
    w = 2 * np.pi * frequency
    return Buoy().wave_transfer(w, 0.0)[:, 0] / (0.5 - 2.0 * w**2 + 0.08j * w)


# -- free decay -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("dof", "offset"), [("surge", 1.0), ("way", -300.0)])
def test_free_decay(dof, offset):
    decay = free_decay(buoy_model().compile(), dof, offset)
    assert decay.damping_ratio == pytest.approx(0.04, rel=2e-3)
    assert decay.period == pytest.approx(2 * np.pi / np.sqrt(0.25 * (1 - 0.04**2)), rel=1e-4)
    assert decay.result["surge"].attrs["units"] == "m"
    assert float(decay.result[dof][0]) == pytest.approx(offset)


def test_free_decay_starts_from_equilibrium():
    decay = free_decay(buoy_model().compile(), "surge", 0.5, parameters={"force": 1.0}, duration=100)
    assert decay.rest == pytest.approx(2.0)
    assert float(decay.result["surge"][0]) == pytest.approx(2.5)
    assert decay.damping_ratio == pytest.approx(0.04, rel=2e-3)


def test_free_decay_with_drag():
    decay = free_decay(buoy_model(drag=0.05).compile(), "surge", 2.0, duration=200, tolerance=1e-8)
    assert decay.damping_at_zero == pytest.approx(0.04, rel=0.02)
    assert decay.damping_slope == pytest.approx(4 * 0.05 / 2.0 / (3 * np.pi), rel=0.03)


def test_free_decay_takes_the_waves_away():
    model = buoy_at_sea()
    model.root.sea.spectrum, model.root.sea.wave_height, model.root.sea.wave_period = "regular", 4.0, 7.0
    assert free_decay(model, "surge", 1.0).damping_ratio == pytest.approx(0.04, rel=2e-3)


def test_free_decay_of_what_is_no_state():
    with pytest.raises(ModelError) as caught:
        free_decay(buoy_model().compile(), "load", 1.0)
    assert str(caught.value) == (
        "'load' cannot be given an offset: it depends on no state at all. Take a result that follows one state alone."
    )
    with pytest.raises(ModelError) as caught:
        free_decay(buoy_model().compile(), "surg", 1.0)
    assert str(caught.value) == "the model has no result 'surg'; did you mean 'surge'?"
    with pytest.raises(ModelError) as caught:
        free_decay(buoy_model().compile(), "surge", 1.0, duration=20.0)
    assert str(caught.value) == (
        "free decay of surge: in 20 s it passes its rest position 0 m 3 times, 5 are needed. Simulate longer; "
        "a motion that only creeps back is overdamped and has no period."
    )


# -- response operators -----------------------------------------------------------------------------------------------


def test_linear_response_is_exact():
    rao = linear_rao(buoy_model(), FREQUENCY, outputs=["surge", "way", "speed"])
    np.testing.assert_allclose(rao["surge"], exact_response(FREQUENCY), rtol=1e-12)
    np.testing.assert_allclose(rao["way"], 1000 * exact_response(FREQUENCY), rtol=1e-12)
    np.testing.assert_allclose(rao["speed"], 2j * np.pi * FREQUENCY * exact_response(FREQUENCY), rtol=1e-12)
    assert rao.units == ("m/m", "mm/m", "(m/s)/m")
    np.testing.assert_allclose(rao.amplitude("surge"), np.abs(exact_response(FREQUENCY)))
    oblique = linear_rao(buoy_model(), FREQUENCY, heading=np.pi / 3)
    assert oblique.outputs == ("surge",)
    np.testing.assert_allclose(oblique["surge"], 0.5 * rao["surge"])


def test_drag_does_not_enter_the_linear_response():
    rao = linear_rao(buoy_model(drag=5.0), FREQUENCY)
    np.testing.assert_allclose(rao["surge"], exact_response(FREQUENCY), rtol=2e-4)  # smooth |v|


def test_the_linear_response_of_a_plant_in_waves_is_that_in_still_water():
    still = linear_rao(buoy_at_sea(), [0.05, 0.1], outputs=["surge"])
    root = buoy_at_sea().root
    root.sea = Sea(spectrum="jonswap", significant_wave_height=3.0, peak_period=9.0)
    plant = Model(root, outputs={"surge": Output("buoy.x")}).compile()
    np.testing.assert_allclose(linear_rao(plant, [0.05, 0.1], outputs=["surge"]).response, still.response, rtol=1e-9)


def test_regular_waves_give_the_linear_response():
    rao = simulated_rao(buoy_at_sea(), [0.05, 0.1], outputs=["surge", "wave_elevation"], settle=300, tolerance=1e-8)
    np.testing.assert_allclose(rao["surge"], exact_response(np.array([0.05, 0.1])), rtol=1e-3)
    np.testing.assert_allclose(rao["wave_elevation"], 1.0, rtol=1e-6)
    assert rao.method == "regular waves, H = 2 m"
    with pytest.raises(ModelError, match="simulated_rao needs the model"):
        simulated_rao(buoy_at_sea().compile(), [0.1])


def test_response_as_a_table(tmp_path):
    rao = linear_rao(buoy_model(), FREQUENCY, outputs=["surge", "speed"])
    lines = rao.save(tmp_path / "rao.csv").read_text().splitlines()
    assert lines[0] == (
        "frequency [Hz],surge_amplitude [m/m],surge_phase [deg],speed_amplitude [(m/s)/m],speed_phase [deg]"
    )
    assert len(lines) == 6
    head, columns, *_ = repr(rao).splitlines()
    assert head == "<Rao, linear, heading 0 deg>" and columns.split() == [
        "[Hz]",
        "surge",
        "[m/m]",
        "speed",
        "[(m/s)/m]",
    ]


def test_response_errors():
    def message(action) -> str:
        with pytest.raises(ModelError) as caught:
            action()
        return str(caught.value)

    assert message(lambda: linear_rao(Model(World()), FREQUENCY)) == (
        "no part of this model feels the waves (such as a WaveExcitation), so there is no response to them."
    )
    assert (
        message(lambda: linear_rao(buoy_model(), [0.0, 0.1])) == "frequencies are positive numbers in Hz, at least one."
    )
    assert message(lambda: linear_rao(buoy_model(), FREQUENCY, outputs=["sureg"])) == (
        "the model has no result 'sureg'; did you mean 'surge'?"
    )
    with pytest.raises(SimulationError) as caught:
        linear_rao(buoy_model(damping=-0.08), FREQUENCY)
    assert str(caught.value).startswith("the state is unstable: a mode of 0.07951 Hz, in which v takes part most")
    assert "grows by a factor e in 50 s (pole +0.02 +0.4996i 1/s), so there is no steady" in str(caught.value)


# -- static curves, and results on a real model -----------------------------------------------------------------------


def test_static_curve(tmp_path):
    curve = static_curve(buoy_model().compile(), "force", [0.0, 0.5, 1.0], outputs=["surge", "way"])
    np.testing.assert_allclose(curve["surge"], [0.0, 1.0, 2.0], atol=1e-9)
    np.testing.assert_allclose(curve["way"], [0.0, 1000.0, 2000.0], atol=1e-6)
    assert curve.save(tmp_path / "c.csv").read_text().splitlines()[0] == "force,surge [m],way [mm]"
    assert curve.dataset["way"].attrs["units"] == "mm"


def test_a_run_goes_on_from_a_file(tmp_path):
    plant = buoy_model().compile()
    start = {"x": 1.0}
    whole = plant.simulate(20, output_step=0.1, start=start, tolerance=1e-8)
    path = plant.simulate(10, output_step=0.1, start=start, tolerance=1e-8).save(tmp_path / "first.nc")
    first = Result.open(path)
    joined = first.followed_by(plant.simulate(20, output_step=0.1, start=first, tolerance=1e-8))
    np.testing.assert_allclose(joined.time, whole.time)
    np.testing.assert_allclose(joined.array("surge"), whole.array("surge"), atol=1e-6)
    assert joined.unit("way") == "mm" and joined.attributes["title"] == "a buoy"
    other = buoy_model(mass=3.0).compile()
    with pytest.raises(SimulationError) as caught:
        other.simulate(20, start=first)
    assert str(caught.value) == (
        "the run to resume had other parameters: mass was 2.0, is 3.0. Give the same parameters, or start a new run."
    )
