"""A linear operator is stepped by its realization and answers at frequencies by its transfer function."""

import numpy as np
import pytest
from scipy.special import erfcx

import fowtlib as fw
from fowtlib.language import Array, Scalar, StateSpace, der, eq, linear_operator, param, var
from fowtlib.language.errors import SimulationError, StructureError

EFFUSIVITY, CAPACITY = 3.0, 20.0  # of the rod [W s^0.5/(m^2 K)], of the plate on it [J/(m^2 K)]


def half_integral(lowest=1e-6, highest=1e6, states=28):
    """1/sqrt(s) by first-order lags: (2/pi) integral dx / (s + x^2), by the trapezoidal rule in ln(x).

    G. Montseny, Diffusive representation of pseudo-differential time-operators, ESAIM Proc. 5 (1998).
    """
    x = np.geomspace(np.sqrt(lowest), np.sqrt(highest), states)
    weight = 2 / np.pi * x * np.log(x[1] / x[0])
    return StateSpace(np.diag(-(x**2)), np.ones((states, 1)), weight[None, :])


def half_integral_at(omega):
    return (1 / np.sqrt(1j * omega))[:, None, None]


class HalfSpace(fw.Component):
    """A plate on a half space: C T' = power - q, and the heat q goes into the ground, T = q / (e sqrt(i omega))."""

    states: int = param(default=28, doc="states of the memory")
    power: Scalar = param(default=1.0, unit="W/m^2", doc="power on the plate")

    T: Scalar = var(unit="K", start=0.0, fixed=True, doc="temperature of the plate")
    q: Scalar = var(unit="W/m^2", doc="heat into the ground")
    x: Array = var(shape="states", start=0.0, fixed=True, doc="memory of the ground")

    def equations(self):
        memory = half_integral(states=self.states)
        return [
            eq(CAPACITY * der(self.T), self.power - self.q),
            linear_operator(self.T, self.q, half_integral_at, memory, self.x, scale=1 / EFFUSIVITY),
        ]


def test_at_frequencies_the_operator_itself():
    """T/power = 1 / (i omega C + e sqrt(i omega)), exactly, however coarse the realization."""
    omega = np.geomspace(1e-4, 1e2, 25)
    exact = 1 / (1j * omega * CAPACITY + EFFUSIVITY * np.sqrt(1j * omega))
    for states in (5, 28):
        plant = fw.load(HalfSpace(states=states)).compile()
        linear = plant.linearize(plant.initial_state(), inputs=["power"], outputs=["T"])
        response = linear.frequency_response(omega)[:, 0, 0]
        assert np.max(np.abs(response / exact - 1)) < 1e-10
        realized = np.max(np.abs(linear.frequency_response(omega, realized=True)[:, 0, 0] / exact - 1))
        # what the integral leaves out below its lowest x is 2/pi x/sqrt(omega) of the whole
        assert 1e-3 < realized < (1.0 if states == 5 else 2 / np.pi * 1e-3 / np.sqrt(omega[0])), realized


@pytest.mark.parametrize("solver", ["idas", "fixed"])
def test_in_time_the_realization(solver):
    """Step of the power: T = C/e^2 (exp(a) erfc(sqrt(a)) - 1) + 2/e sqrt(t/pi), a = e^2 t / C^2.

    H.S. Carslaw and J.C. Jaeger, Conduction of Heat in Solids (1959), section 12.4.
    """
    plant = fw.load(HalfSpace()).compile()
    result = plant.simulate(200.0, output_step=10.0, solver=solver, **({"step": 0.05} if solver == "fixed" else {}))
    time = np.asarray(result.time)[1:]
    a = EFFUSIVITY**2 * time / CAPACITY**2
    exact = CAPACITY / EFFUSIVITY**2 * (erfcx(np.sqrt(a)) - 1) + 2 / EFFUSIVITY * np.sqrt(time / np.pi)
    assert np.max(np.abs(np.asarray(result["T"])[1:] / exact - 1)) < 0.01


class Springpot(fw.Component):
    """Two masses on viscoelastic rubber between them and the ground: m v' = force - R v with a 2 x 2 operator R.

    Each rubber has the complex stiffness K (i omega)^alpha, alpha = 0.5: R = K (i omega)^-0.5 on the velocities.
    """

    push: Scalar = param(default=0.0, unit="N", doc="force on the first mass")
    v: Array = var(shape=(2,), unit="m/s", start=0.0, fixed=True, doc="velocities")
    load: Array = var(shape=(2,), unit="N", doc="loads of the rubber")
    x: Array = var(shape=(24,), start=0.0, fixed=True, doc="memory of the rubbers")

    def equations(self):
        one = half_integral(1e-3, 1e5, 12)
        zero = np.zeros
        A = np.block([[one.A, zero((12, 12))], [zero((12, 12)), one.A]])
        B = np.block([[one.B, zero((12, 1))], [zero((12, 1)), one.B]])
        C = STIFFNESS @ np.block([[one.C, zero((1, 12))], [zero((1, 12)), one.C]])
        return [
            eq(2.0 * der(self.v[0]), self.push - self.load[0]),
            eq(5.0 * der(self.v[1]), -self.load[1]),
            linear_operator(self.load, self.v, rubber, StateSpace(A, B, C), self.x),
        ]


STIFFNESS = np.array([[30.0, -10.0], [-10.0, 25.0]])


def rubber(omega):
    return STIFFNESS / np.sqrt(1j * omega)[:, None, None]


def test_an_operator_with_several_inputs_and_outputs():
    plant = fw.load(Springpot()).compile()
    linear = plant.linearize(plant.initial_state(), inputs=["push"], outputs=["v", "load"])
    omega = np.geomspace(0.05, 50, 20)
    mass = np.diag([2.0, 5.0])
    for w, response in zip(omega, linear.frequency_response(omega)[:, :, 0], strict=True):
        H = STIFFNESS / np.sqrt(1j * w)
        v = np.linalg.solve(1j * w * mass + H, [1, 0])
        assert response == pytest.approx(np.concatenate([v, H @ v]), rel=1e-9, abs=1e-12)


class Twice(fw.Component):
    """Two operators, one of them without states: y1 = 3 u, y2 = H y1 - y2 / 2."""

    u: Scalar = param(default=0.0, doc="input")
    y1: Scalar = var(doc="three times the input")
    y2: Scalar = var(doc="lag of it, in a loop")
    x: Scalar = var(start=0.0, fixed=True, doc="state")

    def equations(self):
        gain = StateSpace(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), [[3.0]])
        lag = StateSpace([[-1.0]], [[1.0]], [[1.0]])
        return [
            linear_operator(self.y1, self.u, lambda omega: np.full((omega.size, 1, 1), 3.5), gain, [], name="gain"),
            linear_operator(self.y2, self.y1 - self.y2 / 2, lambda omega: np.exp(-1j * omega)[:, None, None], lag,
                            self.x, name="lag"),
        ]  # fmt: skip


def test_two_operators_in_one_part():
    plant = fw.load(Twice()).compile()
    assert [item.path for item in plant.dae.operators] == ["", ""]
    linear = plant.linearize(plant.initial_state(), inputs=["u"], outputs=["y2"])
    omega = np.array([0.3, 2.0])
    H = np.exp(-1j * omega)
    assert linear.frequency_response(omega)[:, 0, 0] == pytest.approx(3.5 * H / (1 + H / 2), rel=1e-12)
    H = 1 / (1 + 1j * omega)
    assert linear.frequency_response(omega, realized=True)[:, 0, 0] == pytest.approx(3 * H / (1 + H / 2), rel=1e-12)


def test_the_correction_is_no_parameter_of_the_model():
    plant = fw.load(HalfSpace()).compile()
    assert list(plant.dae.parameters) == ["power"] and plant.dae.p.numel() == 4
    assert plant.binding().p.tolist() == [1.0, 0.0, 0.0, 0.0]


def test_what_does_not_fit():
    class Wrong(HalfSpace):
        """Two states too few."""

        def equations(self):
            memory = half_integral(states=self.states + 2)
            return [linear_operator(self.T, self.q, half_integral_at, memory, self.x)]

    with pytest.raises(StructureError, match="from 1 inputs to 1 outputs with 28 states does not fit a realization"):
        fw.load(Wrong()).compile()
    with pytest.raises(StructureError, match="a state space with A, B, C, D of the shapes"):
        StateSpace(np.eye(2), np.ones((3, 1)), np.ones((1, 2)))

    class Odd(HalfSpace):
        """A transfer function of the wrong shape."""

        def equations(self):
            cooling = eq(CAPACITY * der(self.T), self.power - self.q)
            return [cooling, linear_operator(self.T, self.q, np.cos, half_integral(), self.x)]

    plant = fw.load(Odd()).compile()
    linear = plant.linearize(plant.initial_state(), inputs=["power"], outputs=["T"])
    with pytest.raises(SimulationError, match="the transfer function gives"):
        linear.frequency_response([1.0, 2.0])
