"""Dry tests against their closed forms and against simulated bodies; swept forces against linear models."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.analysis.dry_tests import inclination_test, pull_test, swing_inertia, swing_test, tensile_test
from fowtlib.analysis.swept import linear_transfer, swept_transfer
from fowtlib.components.environment import World
from fowtlib.components.mechanics import (
    ConstantForce,
    FixedTranslation,
    PointMass,
    Prismatic,
    Revolute,
    RigidBody,
    SpringDamper,
    SweptForce,
)
from fowtlib.language.errors import ModelError

MASS, ARM, INERTIA = 186.0, 0.60, 135.0  # a spar at 1:45 on a pivot above its centre of gravity


def test_a_chain_is_pulled():
    """Serret (2019), section 5.8: 750 kN/m for 0.20 m of an equivalent diameter of 3.3 mm; E by these numbers."""
    extension = np.linspace(0, 2e-4, 9)
    force = 20.0 + 750e3 * extension + np.random.default_rng(2).normal(0, 0.5, 9)
    found = tensile_test(extension, force, 0.20, 0.0033)
    assert found.stiffness.holds(750e3, 0.999)
    assert found.axial_stiffness.value == pytest.approx(150e3, rel=0.02)
    assert found.modulus.value == pytest.approx(150e3 / (math.pi / 4 * 0.0033**2), rel=0.02)  # 1.75e10 Pa


def test_an_inclination_gives_the_arm():
    distance = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
    angle = np.arctan(0.5 * distance / (MASS * 0.032)) + 2e-4
    found = inclination_test(0.5, distance, angle, MASS)
    assert found.value == pytest.approx(0.032, rel=1e-3)
    with pytest.raises(ModelError, match="takes 3 pairs"):
        inclination_test(0.5, [0.1], [0.01], MASS)


def swung(weight: float, height: float) -> float:
    """Period [s] of a small swing of the body, hung at ARM, with a weight at a height below the pivot: simulated."""
    root = fw.Assembly("swing")
    root.world = World(gravity=9.81)
    root.pivot = Revolute(n=(0, 1, 0), phi_start=0.01)
    own = INERTIA - MASS * ARM**2
    root.body = RigidBody(mass=MASS, r_cm=(0, 0, -ARM), inertia=np.diag([own, own, 10.0]))
    root.rod, root.weight = FixedTranslation(r=(0, 0, -height)), PointMass(mass=weight)
    root.connect(root.world.frame, root.pivot.frame_a)
    root.connect(root.pivot.frame_b, root.body.frame_a)
    root.connect(root.pivot.frame_b, root.rod.frame_a)
    root.connect(root.rod.frame_b, root.weight.frame_a)
    run = (
        fw.Model(root, "swing", {"phi": fw.Output("pivot.phi")}, {})
        .compile()
        .simulate(30.0, output_step=0.01, tolerance=1e-10)
    )
    return fw.damped_sinusoid(run["phi"]).period.value


def test_swings_give_centre_and_inertia():
    heights = [0.2, 0.9, 1.4]
    found = swing_test([swung(10.0, height) for height in heights], 10.0, heights)
    assert found.arm(MASS).value == pytest.approx(ARM, rel=1e-4)
    assert found.inertia.value == pytest.approx(INERTIA, rel=1e-4)
    assert found.central(MASS) == pytest.approx(INERTIA - MASS * ARM**2, rel=1e-3)
    period = 2 * math.pi * math.sqrt(INERTIA / (MASS * 9.81 * ARM))
    assert swing_inertia(period, MASS, ARM) == pytest.approx(INERTIA)


def test_the_frame_is_taken_off():
    """T^2/(4 pi^2) g sum(m l) - I_f - sum(m r^2) - m l^2: Serret (2019), section 5.8."""
    heights = np.array([0.3, 0.8, 1.3])

    def periods(moment: float, inertia: float) -> np.ndarray:
        return 2 * math.pi * np.sqrt((inertia + 5 * heights**2) / (9.81 * (moment + 5 * heights)))

    frame = swing_test(periods(12.0, 9.0), 5.0, heights)
    both = swing_test(periods(12.0 + MASS * ARM, 9.0 + INERTIA), 5.0, heights)
    body = both.less(frame)
    assert body.arm(MASS).value == pytest.approx(ARM)
    assert body.central(MASS) == pytest.approx(INERTIA - MASS * ARM**2)


def test_heights_that_tell_nothing():
    with pytest.raises(ModelError, match="do not tell the arm from the inertia"):
        swing_test([2.0, 2.0], 5.0, [1.0, 1.0])


def spring_mass(load: fw.Component, damping: float = 60.0) -> fw.Model:
    root = fw.Assembly("a mass between springs")
    root.world = World(gravity=1e-3)
    root.slide, root.body = Prismatic(n=(1, 0, 0)), RigidBody(mass=392.9, inertia=np.eye(3))
    root.beside = FixedTranslation(r=(-10, 0, 0))
    root.spring = SpringDamper(stiffness=854.4, damping=damping, natural_length=10.0)
    root.load = load
    root.connect(root.world.frame, root.slide.frame_a)
    root.connect(root.world.frame, root.beside.frame_a)
    root.connect(root.beside.frame_b, root.spring.frame_a)
    for frame in (root.body.frame_a, root.spring.frame_b, root.load.frame):
        root.connect(root.slide.frame_b, frame)
    return fw.Model(root, "slide", {"surge": fw.Output("slide.s", "m")}, {})


def test_a_pull_gives_the_stiffness():
    found = pull_test(spring_mass(ConstantForce()), "load.force", [-20.0, 0.0, 20.0, 40.0])
    assert found.stiffness["surge"] == pytest.approx(854.4, rel=1e-6)
    np.testing.assert_allclose(found.tangent("surge"), 854.4, rtol=1e-6)
    with pytest.raises(ModelError, match="no tunable load 'load.torque'"):
        pull_test(spring_mass(ConstantForce()), "load.torque", [-1.0, 0.0, 1.0])
    with pytest.raises(ModelError, match="with 0 N within them"):
        pull_test(spring_mass(ConstantForce()), "load.force", [1.0, 2.0, 3.0])


def test_a_moored_spar_is_pulled():
    """The slope of its surge at rest is that of the linear model."""
    model = fw.load("oc3_spar_rigid", set={"wind.kind": "none"}).in_the_mean()
    model.root.pull = ConstantForce()
    model.root.connect(model.root.platform.frame, model.root.pull.frame)
    plant = fw.load(model.root).compile()
    found = pull_test(plant, "pull.force", np.linspace(-2e4, 2e4, 5), results=["surge"])
    linear = linear_transfer(plant, "pull.force", [1e-6], outputs=["surge"])
    assert found.stiffness["surge"] == pytest.approx(1 / abs(linear["surge"][0]), rel=2e-3)


@pytest.mark.parametrize("sweep", ["linear", "logarithmic"])
def test_a_swept_force_gives_the_transfer_function(sweep):
    """1 / (k - m w^2 + i w c), exactly, and as the linear model has it."""
    model = spring_mass(SweptForce(force=(10.0, 0, 0), f1=0.08, f2=0.6, duration=120.0, start_time=1.0, sweep=sweep))
    plant = model.compile()
    run = plant.simulate(220.0, output_step=0.05, tolerance=1e-8)
    found = swept_transfer(run["load.share"], {"surge": run["surge"]}, 10.0, low=0.12, high=0.5)
    w = 2 * np.pi * found.frequency
    exact = 1 / (854.4 - 392.9 * w**2 + 60j * w)
    np.testing.assert_allclose(found["surge"], exact, rtol=5e-3)
    assert found.units == ("m/N",)
    linear = linear_transfer(plant, "load.rest_force", found.frequency)
    np.testing.assert_allclose(linear["surge"], exact, rtol=1e-6)
    assert abs(np.asarray(run["load.share"]).max()) <= 1.0


def test_what_a_sweep_needs():
    model = spring_mass(SweptForce(force=(10.0, 0, 0), f1=0.1, f2=0.5, duration=60.0), damping=5.0)
    run = model.compile().simulate(65.0, output_step=0.05)
    records = run["load.share"], {"surge": run["surge"]}
    with pytest.raises(ModelError, match="is left at the end of the record"):
        swept_transfer(*records, 10.0, low=0.15, high=0.45)
    with pytest.raises(ModelError, match="no strength everywhere between 0.15 and 3 Hz"):
        swept_transfer(*records, 10.0, low=0.15, high=3.0)
