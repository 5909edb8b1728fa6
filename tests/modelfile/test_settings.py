"""Settings of a model file that make no run together: told by its check and by its run, after what a run asks for."""

from __future__ import annotations

import pytest

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.language.errors import ParameterError

MODEL = """fowtlib: 1
world: {{class: World}}
rail: {{class: Prismatic, n: [0, 0, 1]}}
body: {{class: PointMass, mass: 1}}
connect:
  - [world.frame, rail.frame_a]
  - [rail.frame_b, body.frame_a]
simulation:
{}"""
LONGER = "is longer than the output step, {} s. Give a shorter step (--step) or a longer output step (--output-step)."
FIXED = "the step of the solver 'fixed', {} s, " + LONGER
CASES = {  # settings, line, what is said, what a run may ask for instead
    "step_longer": ("  {solver: fixed, output_step: 50 ms, step: 60 ms, duration: 1 s}\n", "9: simulation.step",
                    FIXED.format(0.06, 0.05), {"step": 0.05}),
    "step_longer_than_that_not_given": ("  solver: fixed\n  duration: 1 s\n  step: 0.3 s\n", "11: simulation.step",
                                        FIXED.format(0.3, 0.1), {"output_step": 0.5}),
    "of_another_solver": ("  solver: fixed\n  duration: 1 s\n  step: 0.3 s\n", "11: simulation.step",
                          FIXED.format(0.3, 0.1), {"solver": "idas"}),
    "too_many_points": ("  duration: 1e6 s\n  output_step: 1 ms\n", "10: simulation.output_step",
                        "1e+06 s with an output step of 0.001 s are 1e+09 output points, and the limit is 2e+07; give "
                        "a longer output step, or run it in pieces that go on from each other.", {"t_end": 1.0}),
    "no_solver": ("  solver: fxed\n  duration: 1 s\n", "9: simulation.solver",
                  "there is no solver 'fxed'; did you mean 'fixed'?", {"solver": "fixed"}),
    "wide_tolerance": ("  duration: 1 s\n  tolerance: 3\n", "10: simulation.tolerance",
                       "the tolerance is 3; it must lie between 0 and 1, usually 1e-4 to 1e-9.", {"tolerance": 1e-5}),
    "growing": ("  {solver: fixed, duration: 1 s, rho_inf: 1.5}\n", "9: simulation.rho_inf",
                "rho_inf is 1.5; it must lie between 0 and 1, usually 0.7 to 0.9.", {"rho_inf": 0.8}),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_what_makes_no_run_is_told_by_check_and_run_unless_it_asks_for_something_else(name, tmp_path, monkeypatch):
    settings, line, said, instead = CASES[name]
    (tmp_path / "model.yaml").write_text(MODEL.format(settings))
    monkeypatch.chdir(tmp_path)
    model = fw.load("model.yaml")  # it is read, drawn, compiled
    wanted = f"model.yaml:{line}: {said}"
    report = model.check()
    assert report.faults == (wanted,) and not report.ok and wanted in str(report)
    plant = model.compile()
    with pytest.raises(ParameterError) as error:
        plant.simulate()
    assert str(error.value) == wanted
    assert plant.simulate(**instead).time.size


def test_a_fault_of_the_call_has_no_place_in_the_file(tmp_path):
    (tmp_path / "model.yaml").write_text(MODEL.format("  {solver: fixed, duration: 1 s, step: 5 ms}"))
    with pytest.raises(ParameterError) as error:
        fw.load(tmp_path / "model.yaml").compile().simulate(step=0.3)
    assert str(error.value) == FIXED.format(0.3, 0.1)


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "model.yaml").write_text(MODEL.format(CASES["step_longer"][0]))
    monkeypatch.chdir(tmp_path)
    assert main(["check", "model.yaml"]) == 1
    assert "  model.yaml:9: simulation.step: the step of the solver 'fixed'" in capsys.readouterr().out
    assert main(["tree", "model.yaml"]) == 0
    assert main(["run", "model.yaml"]) == 2
    assert main(["run", "model.yaml", "--step", "25 ms"]) == 0
    assert main(["run", "model.yaml", "--output-step", "0.1"]) == 0
