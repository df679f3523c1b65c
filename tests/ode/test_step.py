"""The step: worlds beside each other, and a missing library."""

import math
import os
import subprocess
import sys
import zlib

import numpy as np
import pytest
from engine_parts import busy_world


def run_busy_world(solver, steps=400):
    engine = busy_world()
    engine.solver = solver
    contacts = 0
    for _ in range(steps):
        engine.step()
        contacts += engine.contact_count
    rays = np.array([[0, 0, 0.3, math.cos(a), math.sin(a), 0, 6.0] for a in np.linspace(0, 6, 50)])
    ranges, rows = np.empty(50), np.empty(50, dtype=np.int64)
    engine.scan(np.array([-2.0, 0, 0, 1, 0, 0, 0]), rays, 0, ranges, rows)
    joints = [j.GetAngleRate() for j in engine.joints.values()]
    return (engine.states.tobytes(), ranges.tobytes(), rows.tobytes(), tuple(joints), contacts)


def test_two_worlds_do_not_disturb_each_other():
    alone = run_busy_world("quick", 200)[0]
    first, second = busy_world(), busy_world()
    for _ in range(200):
        first.step()
        second.step()
        second.step()
    assert zlib.crc32(first.states.tobytes()) == zlib.crc32(alone)


@pytest.mark.parametrize(
    ("module", "arguments", "code"),
    [("gazebo", ["-n", "--steps", "1"], 1), ("gzserver", ["--iters", "1"], 255)],
)
def test_servers_say_that_the_step_was_not_built(module, arguments, code, tmp_path):
    world = tmp_path / "w.world"
    old = module == "gazebo"
    world.write_text("<gz:world xmlns:gz='g'/>" if old else "<sdf version='1.6'><world name='w'/></sdf>")
    script = (
        "import sys; from pathlib import Path; from libgz.ode import step; step.LIBRARY = Path('/nowhere/_step.so'); "
        f"from libgz.apps.{module} import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", script, *arguments, str(world)]
    env = os.environ | {"TMP": str(tmp_path)}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False, timeout=60)
    assert "the step was not built: install a C compiler (apt-get install gcc libc6-dev)" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.returncode == code
