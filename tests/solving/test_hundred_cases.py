"""A hundred cases of one model, mixed: one flattening, one C text, one compilation, and a mean for each wind."""

from __future__ import annotations

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cases import Case
from fowtlib.components.environment import generate_field
from fowtlib.language.native import compiler
from fowtlib.solving import starts

SPEEDS = (7.0, 9.0, 11.0, 13.0, 15.0)
GUST = {"wind.kind": "gust", "wind.start_time": 0.1}
STEP = {"wind.kind": "step", "wind.step_speed": 12.0}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    generate_field(folder / "field.bts", mean_speed=10, width=160, height=160, columns=5, rows=5, duration=60,
                   time_step=0.25)  # fmt: skip
    t = np.arange(0, 200.1, 0.5)
    np.savetxt(folder / "wind.csv", np.column_stack([t, 11 + np.sin(0.05 * t)]), delimiter=",")
    np.savetxt(folder / "waves.csv", np.column_stack([t, np.sin(0.6 * t)]), delimiter=",")
    return folder


def hundred(files):
    """Every kind of wind with every kind of sea, four times, and something else in each."""
    kinds = [
        {"wind.kind": "none"},
        {"wind.kind": "steady"},
        STEP,
        GUST,
        {"wind.kind": "kaimal"},
        {"wind.kind": "file", "wind.file": str(files / "wind.csv")},
        {"wind.kind": "field", "wind.file": str(files / "field.bts")},
    ]
    for k in range(100):
        wind, speed = dict(kinds[k % len(kinds)]), SPEEDS[(k // len(kinds)) % len(SPEEDS)]
        if wind["wind.kind"] in ("steady", "step", "gust", "kaimal"):
            wind["wind.mean_speed"] = speed
        if wind["wind.kind"] == "kaimal":
            wind |= {"wind.seed": k, "wind.turbulence_class": "ABC"[k % 3]}
        sea = (
            {"sea.spectrum": "still"},
            {"sea.spectrum": "regular", "sea.wave_height": 1 + 0.1 * k, "sea.wave_period": 9 + 0.05 * k},
            {"sea.spectrum": "record", "sea.file": str(files / "waves.csv")},
            {"sea.spectrum": "jonswap", "sea.significant_wave_height": 1 + 0.05 * k, "sea.peak_period": 9 + 0.05 * k,
             "sea.seed": k, "sea.gamma": 1 + 0.02 * k},
        )[k % 4 if k < 50 else 3]  # fmt: skip
        sea |= {"sea.heading": 0.03 * k} if sea["sea.spectrum"] != "still" else {}
        own = {"platform.hull.mass": 7.4e6 + 1e3 * k} if k % 20 == 19 else {}
        yield Case(f"{k}", "oc3_spar_rigid", {**wind, **sea, **own}, duration=0.1, output_step=0.05)


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_hundred_mixed_cases(files, counted, monkeypatch):
    monkeypatch.setenv("FOWTLIB_KEEP_FLAT", "no")  # means of other processes do not count
    sought, found = [], starts._found
    monkeypatch.setattr(starts, "_found", lambda *given: sought.append(given[2]) or found(*given))
    plant = fw.load("oc3_spar_rigid").compile()
    cases = list(hundred(files))
    results = [plant.simulate(conditions=case.conditions(), solver="fixed") for case in cases]
    assert counted == {"flattened": 1, "written": 1, "compiled": 1}
    ends = {np.concatenate([np.ravel(result[name]) for name in result]).tobytes() for result in results}
    assert len(ends) == len({case.digest() for case in cases}) > 95
    # five speeds, no wind, the means of a series and of a field, and five hulls
    assert len(sought) == len(plant.kept_starts) == len(SPEEDS) + 3 + 5
