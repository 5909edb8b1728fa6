"""The linear model that `fowt eigen --linear` writes."""

from __future__ import annotations

import numpy as np
from scipy.io import loadmat

import fowtlib as fw
from fowtlib.cli.app import main
from fowtlib.solving import mean_linear_model, mean_state


def test_inputs_and_outputs_are_in_it_without_being_named(tmp_path, monkeypatch):
    """All matrices are those of Python with the same inputs."""
    monkeypatch.chdir(tmp_path)
    assert main(["eigen", "oc3_spar_rigid", "--wind", "steady:15", "--linear", "spar.mat"]) == 0
    found = loadmat("spar.mat", squeeze_me=True)
    model = fw.load("oc3_spar_rigid", set={"wind.kind": "steady", "wind.mean_speed": 15.0}).in_the_mean()
    plant = model.compile()
    inputs, outputs = found["inputs"].tolist(), found["outputs"].tolist()
    assert inputs[-1] == "wind.mean_speed" and "turbine.control.pitch.raised" in inputs
    assert found["B"].shape == (len(found["A"]), len(inputs)) and found["D"].shape == (len(outputs), len(inputs))
    state = mean_state(plant)
    linear = mean_linear_model(plant, state, inputs)
    assert linear.outputs == outputs
    for name in "ABCD":
        np.testing.assert_allclose(found[name], linear.matrices[name], rtol=1e-6, atol=1e-9)
    assert np.abs(found["B"][:, -1]).max() > 0

    assert main(["eigen", "oc3_spar_rigid", "--wind", "steady:15", "--linear", "spar.lin"]) == 0
    text = (tmp_path / "spar.lin").read_text()
    assert f"B: {len(found['A'])} x {len(inputs)}" in text and f"D: {len(outputs)} x {len(inputs)}" in text
    assert "wind.mean_speed, m/s" in text
