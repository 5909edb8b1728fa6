"""Compiled code leaves the process with the plant that it was made for."""

from __future__ import annotations

from pathlib import Path

import pytest

import fowtlib as fw
from fowtlib.language import Component, Scalar, der, eq, var
from fowtlib.language.native import compiler

MAPS = Path("/proc/self/maps")
pytestmark = pytest.mark.skipif(not MAPS.exists() or not compiler(), reason="needs /proc and a C compiler")


def decaying(rate: float) -> Component:
    class Decaying(Component):
        """A quantity that decays."""

        x: Scalar = var(start=1.0, doc="quantity")

        def equations(self):
            return [eq(der(self.x), -rate * self.x)]

    return Decaying()


def mapped(folder: Path) -> set[str]:
    return {line.split("/")[-1].strip() for line in MAPS.read_text().splitlines() if str(folder) in line}


def test_many_plants_leave_no_libraries_behind(tmp_path, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path))
    most = 0
    for k in range(100):
        plant = fw.load(decaying(1 + k)).compile()
        result = plant.simulate(0.5, output_step=0.1, solver="fixed", step=0.05)
        assert result.time[-1] == 0.5
        most = max(most, len(mapped(tmp_path)))
    assert len(list(tmp_path.glob("model_*.so"))) == 100
    assert 1 <= most <= 75  # plants wait for the collection of garbage, for which many libraries are a reason


def test_two_plants_at_once_keep_their_own(tmp_path, monkeypatch):
    monkeypatch.setenv("FOWTLIB_CACHE", str(tmp_path))
    plants = [fw.load(decaying(rate)).compile() for rate in (1.0, 2.0)]
    for _ in range(2):
        ends = [plant.simulate(1.0, output_step=0.5, solver="fixed", step=0.001)["x"][-1] for plant in plants]
        assert ends == pytest.approx([0.36788, 0.13534], abs=1e-5)
