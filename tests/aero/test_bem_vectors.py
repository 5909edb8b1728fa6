"""The blade elements in vectors, at every width this machine has, against one node after the other by bem.c.

Bound everywhere: 1e-10 of the largest number of each unit, of outputs and of their slopes by all inputs of a unit.
"""

import ctypes
import platform
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from fowtlib.components.aero import AIRFOIL_MODELS, Airfoil, BladeElementRotor, RigidRotor, bem_numpy
from fowtlib.components.aero.vectors import WIDTHS, only_lanes
from fowtlib.language.native import compiler, load_library
from fowtlib.language.processor import lanes_here

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
OPTIONS = {
    "all": {},
    "two blades, mirrored, without skew": {"blades": 2, "rotation": -1, "skew": 0.0},
    "without drag and loss": {"axial_drag": False, "hub_loss": False, "tip_loss": False, "tangential_drag": False},
    "straight lines": {"line_loads": "straight_lines"},
    "dynamic inflow": {"dynamic_inflow": True},
    "attached": {"airfoil_model": AIRFOIL_MODELS["attached"]},
    "beddoes": {"airfoil_model": AIRFOIL_MODELS["beddoes_leishman"], "dynamic_inflow": True},
    "oye": {"airfoil_model": AIRFOIL_MODELS["oye"], "skew": 0.0},
}
UNITS = {
    "position": "m", "hub_position": "m", "chord": "m", "orientation": "1", "hub_orientation": "1", "velocity": "m/s",
    "wind": "m/s", "hub_velocity": "m/s", "disk_wind": "m/s", "induced": "m/s",
}  # fmt: skip
MOMENTS = ("parked", "idling", "starting", "turning", "fast", "backwards", "from behind", "calm")


def moment(rotor, kind, g):
    """Inputs of a rotor in a moment of its life, its nodes in uneven wind, shaken and turned."""
    n, stations = rotor.nodes, len(rotor.blade.radius)
    speed = {"parked": 0.0, "idling": 0.05, "starting": 0.4, "fast": 2.0, "backwards": -0.5}.get(
        kind, g.uniform(0.6, 1.5)
    )
    along = {"from behind": -9.0, "calm": 0.05}.get(kind, g.uniform(3, 25))
    wind = np.array([along, 0, 0]) + g.normal(size=(n, 3)) * g.choice([0.02, 0.3, 2.0])
    pitch = g.uniform(1.3, 1.6) if kind in ("parked", "idling") else g.uniform(-0.1, 0.5)
    rigid = RigidRotor(rotor, np.radians(2.5), np.radians(5.0), g.uniform(-0.7, 0.7))
    u = rigid.inputs(wind, speed, pitch, azimuth=g.uniform(0, 7), induced=g.uniform(-1, 6, stations))
    u[: 3 * n] += g.normal(size=3 * n) * 0.3
    u[12 * n : 15 * n] += g.normal(size=3 * n) * 0.3
    for axes in u[3 * n : 12 * n].reshape(n, 3, 3):
        turn, triangle = np.linalg.qr(np.eye(3) + 0.03 * g.normal(size=(3, 3)))
        axes[:] = (axes.T @ (turn * np.sign(np.diag(triangle)))).T
    u[18 * n + 12 : 18 * n + 15] = g.normal(size=3)
    if states := rotor.airfoil_model.states:
        scale = [{"m/s": 8.0, "1": 1.0}[unit] for unit in rotor.airfoil_model.state_units]
        u[-1 - (1 + states) * n : -1 - states * n] = g.normal(size=n)
        u[-1 - states * n : -1] = (g.normal(size=(n, states)) * scale).ravel()
        u[-1] = g.choice([0.0, 0.01])
    return u


@pytest.fixture
def all_widths(monkeypatch):
    """Rotors of the text that an FMU has, in which each width is compiled."""
    monkeypatch.setattr("fowtlib.components.aero.bem.only_lanes", lambda nodes: "")


def lanes_of(rotor):
    """The function of its library that says how many nodes go at once."""
    external = rotor.external
    assert external.library is not None
    return getattr(ctypes.CDLL(str(external.library)), f"{external.name}_lanes", lambda most: 1)


def widths(rotor):
    """Those that this machine has and the rotor is large enough for."""
    lanes = lanes_of(rotor)
    return [width for width in WIDTHS if lanes(width) == width]


def worst_differences(rotor, states):
    """Of loads and of Jacobian between one node and several at once, as parts of the largest of each unit."""
    lanes, function = lanes_of(rotor), rotor.external.function
    jacobian = function.jacobian()
    outputs = np.split(np.arange(sum(rotor.outputs.values())), np.cumsum(list(rotor.outputs.values()))[:-1])
    unit = np.repeat([UNITS.get(name, name) for name in rotor.inputs], list(rotor.inputs.values()))
    worst = [0.0, 0.0]
    for u in states:
        lanes(1)
        loads, slopes = function(u).full().ravel(), jacobian(u, 0).full()
        assert np.all(np.isfinite(loads)) and np.all(np.isfinite(slopes))
        for width in widths(rotor):
            assert lanes(width) == width
            change, turned = function(u).full().ravel() - loads, jacobian(u, 0).full() - slopes
            for rows in outputs:
                worst[0] = max(worst[0], np.abs(change[rows]).max() / max(np.abs(loads[rows]).max(), 1e-300))
                for one in set(unit) - {"stage_step"}:
                    place = np.ix_(rows, np.flatnonzero(unit == one))
                    worst[1] = max(worst[1], np.abs(turned[place]).max() / max(np.abs(slopes[place]).max(), 1e-300))
        lanes(max(WIDTHS))
    return worst


@pytest.mark.parametrize("name", OPTIONS)
def test_nodes_at_once_are_nodes_alone(all_widths, blade, name):
    rotor, g = BladeElementRotor(blade, **OPTIONS[name]), np.random.default_rng(5)
    states = [moment(rotor, kind, g) for kind in MOMENTS for _ in range(3)]
    loads, slopes = worst_differences(rotor, states)
    assert loads < 1e-10 and slopes < 1e-10
    assert loads > 0 or not widths(rotor)  # other operations are rounded otherwise: it is not the same code


def test_what_is_compiled_for_this_machine_is_one_width(blade, monkeypatch):
    """The widest, or none; the same numbers to the last digit as where all widths are there, by the same function."""
    rotor = BladeElementRotor(blade)
    lanes, widest = lanes_of(rotor), lanes_here()
    assert widest in (1, *WIDTHS)
    assert [width for width in (1, *WIDTHS) if lanes(width) == width] == ([1, widest] if widest > 1 else [1])
    assert lanes(max(WIDTHS)) == widest
    monkeypatch.setattr("fowtlib.components.aero.bem.only_lanes", lambda nodes: "")
    every = BladeElementRotor(blade)
    assert every.external.library != rotor.external.library
    assert every.external.function.source == rotor.external.function.source  # what an FMU is made of
    assert "ONLY_LANES 8" not in every.external.function.source
    for u in (moment(rotor, kind, np.random.default_rng(11)) for kind in MOMENTS):
        one, other = (r.external.function for r in (rotor, every))
        assert np.array_equal(one(u).full(), other(u).full())
        assert np.array_equal(one.jacobian()(u, 0).full(), other.jacobian()(u, 0).full())


def test_a_node_alone_is_compiled_without_vectors(blade):
    names = ("radius", "length", "chord", "twist", "airfoil", "curve", "sweep")
    alone = {name: getattr(blade, name)[9:10] for name in names}
    rotor = BladeElementRotor(replace(blade, **alone | {"length": [61.5]}), blades=1)
    assert rotor.nodes == 1 and only_lanes(1) == "#define ONLY_LANES 1\n"
    assert not hasattr(ctypes.CDLL(str(rotor.external.library)), f"{rotor.external.name}_lanes")
    u = moment(rotor, "turning", np.random.default_rng(12))
    assert rotor.external.function(u).full().ravel() == pytest.approx(bem_numpy.loads(rotor, u), rel=1e-9)


@pytest.mark.parametrize("smooth", [True, False])
def test_dense_and_uneven_polars(all_widths, blade, smooth):
    """200 angles within a degree, and others far apart."""
    g = np.random.default_rng(6)
    angle = np.sort(np.concatenate([[-np.pi, np.pi, -2.0], g.uniform(-0.02, 0.3, 60), g.uniform(0.1, 0.117, 200)]))
    values = np.column_stack([1.1 * np.sin(2 * angle + 0.1), 0.01 + 1.2 * np.sin(angle) ** 2, -0.2 * np.sin(angle)])
    foil = Airfoil("uneven", angle, values, smooth)
    rotor = BladeElementRotor(replace(blade, airfoil=["uneven"] * 17, airfoils={"uneven": foil}))
    loads, slopes = worst_differences(rotor, [moment(rotor, kind, g) for kind in MOMENTS for _ in range(2)])
    assert loads < 1e-10 and slopes < 1e-10


def test_a_rotor_with_fewer_nodes_than_lanes(all_widths, blade):
    names = ("radius", "length", "chord", "twist", "airfoil", "curve", "sweep")
    few = {name: getattr(blade, name)[3::6] for name in names}
    g, rotor = np.random.default_rng(7), BladeElementRotor(replace(blade, **few | {"length": [20.5] * 3}), blades=1)
    assert lanes_of(rotor)(8) in (1, 2)
    loads, slopes = worst_differences(rotor, [moment(rotor, kind, g) for kind in MOMENTS])
    assert loads < 1e-10 and slopes < 1e-10


def test_the_result_of_a_node_does_not_depend_on_its_neighbours(blade):
    """Turned by a blade, the nodes lie in other lanes; the numbers are the same to the last digit."""
    rotor, g = BladeElementRotor(blade), np.random.default_rng(8)
    n, function = rotor.nodes, rotor.external.function
    for kind in MOMENTS:
        u = moment(rotor, kind, g)
        other = u.copy()
        for begin, size in ((0, 3), (3 * n, 9), (12 * n, 3), (15 * n, 3)):
            nodes = u[begin : begin + size * n].reshape(n, size)
            other[begin : begin + size * n] = np.roll(nodes, 17, axis=0).ravel()
        loads, rolled = (function(x).full().reshape(n, 6) for x in (u, other))
        assert np.array_equal(np.roll(loads, 17, axis=0), rolled)


def test_a_node_without_a_number_is_alone(blade):
    rotor = BladeElementRotor(blade)
    u, function = moment(rotor, "turning", np.random.default_rng(9)), rotor.external.function
    good = function(u).full().reshape(-1, 6)
    for place in (20, 50):
        bad = u.copy()
        bad[15 * rotor.nodes + 3 * place] = np.nan
        loads = function(bad).full().reshape(-1, 6)
        assert np.all(np.isnan(loads[place])) and np.array_equal(np.delete(loads, place, 0), np.delete(good, place, 0))


CONTROL = """
EXPORT unsigned long long control(void) {
    unsigned long long word = 0;
#ifdef __x86_64__
    unsigned sse;
    unsigned short x87;
    __asm__ volatile("stmxcsr %0" : "=m"(sse));
    __asm__ volatile("fnstcw %0" : "=m"(x87));
    word = (sse & 0xffc0) | (unsigned long long)x87 << 32; /* without the flags of what has happened */
#else
    __asm__ volatile("mrs %0, fpcr" : "=r"(word));
#endif
    return word;
}
"""


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64", "aarch64", "arm64"), reason="words of this processor")
def test_loading_does_not_change_how_the_processor_computes(blade, tmp_path):
    """Its rounding and what becomes of the smallest numbers, before loading, after it and after a call."""
    rotor = BladeElementRotor(blade)
    control, _ = load_library(CONTROL, "control_word")
    text = f"""
import ctypes
import numpy as np
word = ctypes.CDLL({str(control)!r}).control
word.restype = ctypes.c_ulonglong
before = word()
library = ctypes.CDLL({str(rotor.external.library)!r})
loaded = word()
u, f = np.load(input()), np.zeros({sum(rotor.outputs.values())})
arguments = (ctypes.c_void_p * 1)(u.ctypes.data), (ctypes.c_void_p * 1)(f.ctypes.data), None, None, 0
assert getattr(library, {rotor.external.name!r})(*arguments) == 0 and np.abs(f).max() > 100
print(before, loaded, word(), np.float64(5e-324) / 1 > 0)
"""
    np.save(tmp_path / "u.npy", moment(rotor, "turning", np.random.default_rng(10)))
    run = subprocess.run([sys.executable, "-c", text], input=str(tmp_path / "u.npy"), capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    before, loaded, called, small = run.stdout.split()
    assert before == loaded == called and small == "True"
