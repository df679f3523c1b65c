"""The step repeats recorded motion: to the bit where ODE, machine and libm are known, nearly everywhere else."""

import json

import numpy as np
import pytest
import step_scenes

RECORDED = json.loads(step_scenes.RECORDED.read_text())
KNOWN = RECORDED["digests"].get(step_scenes.key())
AGAIN = "if the motion is meant to change, run `python tests/step_scenes.py` and say why in the commit"


@pytest.mark.parametrize("name", step_scenes.SCENES)
def test_a_scene_moves_as_recorded(name, tmp_path):
    values, digest = step_scenes.run_scene(name, tmp_path)
    difference = np.abs(np.array(values) - np.array(RECORDED["values"][name])).max(initial=0.0)
    assert difference <= step_scenes.TOLERANCE, f"{name}: differs by {difference}; {AGAIN}"
    if KNOWN is not None:
        assert digest == KNOWN[name], f"{name}: other bits; {AGAIN}"
