"""The two forms of the step: they agree, and LIBGZ_STEP chooses one."""

import math
import os
import subprocess
import sys
import zlib

import numpy as np
import pytest
from engine_parts import box, busy_world, ground, in_both_forms, solid

from libgz.base.errors import LibraryError, ParameterError
from libgz.ode import step
from libgz.physics.engine import Engine


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
    return engine.step_form.name, (engine.states.tobytes(), ranges.tobytes(), rows.tobytes(), tuple(joints), contacts)


@pytest.mark.parametrize("solver", ["world", "quick"])
def test_native_and_python_step_agree_to_the_bit(solver, monkeypatch):
    native, python = in_both_forms(lambda: run_busy_world(solver), monkeypatch)
    assert (native[0], python[0]) == ("native", "python")
    assert native[1] == python[1]
    assert native[1][4] > 1000  # contacts there were


def test_two_worlds_do_not_disturb_each_other():
    alone = run_busy_world("quick", 200)[1][0]
    first, second = busy_world(), busy_world()
    for _ in range(200):
        first.step()
        second.step()
        second.step()
    assert zlib.crc32(first.states.tobytes()) == zlib.crc32(alone)


def test_python_step_raises_what_a_callback_raises(monkeypatch):
    monkeypatch.setenv("LIBGZ_STEP", "python")
    engine = Engine()
    ground(engine)
    solid(engine, box(1, 1, 1), position=(0, 0, 0.4))

    def broken(*_):
        raise RuntimeError("inside the callback")

    monkeypatch.setattr(engine.step_form, "_look_up_pair", broken)
    engine.step_form._near = engine.step_form._make_near()
    with pytest.raises(RuntimeError, match="inside the callback"):
        engine.step()


def test_unknown_step_form(monkeypatch):
    monkeypatch.setenv("LIBGZ_STEP", "fast")
    with pytest.raises(ParameterError, match="auto, native, python"):
        Engine()


@pytest.fixture
def without_native_step(monkeypatch):
    """As where there was no C compiler."""
    monkeypatch.setattr(step, "native_path", lambda: None)
    monkeypatch.delenv("LIBGZ_STEP", raising=False)
    step._warn_of_python.cache_clear()
    yield
    step._warn_of_python.cache_clear()


def test_without_the_native_step_a_process_warns_once(without_native_step, caplog):
    for _ in range(3):
        assert Engine().step_form.name == "python"
    (message,) = caplog.messages
    assert "apt-get install gcc libc6-dev" in message


def test_serving_without_the_native_step_must_be_asked_for(without_native_step, monkeypatch, caplog):
    with pytest.raises(LibraryError, match="set LIBGZ_STEP=python to serve all the same"):
        step.check_serving()
    assert not caplog.messages
    monkeypatch.setenv("LIBGZ_STEP", "python")
    step.check_serving()
    assert caplog.messages == [f"LIBGZ_STEP=python: the server is {step._DRAWBACKS}"]


@pytest.mark.parametrize(
    ("module", "arguments", "code"),
    [("gazebo", ["-n", "--steps", "1"], 1), ("gzserver", ["--iters", "1"], 255)],
)
def test_servers_refuse_to_run_without_the_native_step(module, arguments, code, tmp_path):
    world = tmp_path / "w.world"
    old = module == "gazebo"
    world.write_text("<gz:world xmlns:gz='g'/>" if old else "<sdf version='1.6'><world name='w'/></sdf>")
    script = (
        "import sys; from libgz.ode import step; step.native_path = lambda: None; "
        f"from libgz.apps.{module} import main; sys.exit(main(sys.argv[1:]))"
    )
    env = {name: value for name, value in os.environ.items() if name != "LIBGZ_STEP"} | {"TMP": str(tmp_path)}
    command = [sys.executable, "-c", script, *arguments, str(world)]
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False, timeout=60)
    assert "without it a server is slow" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.returncode == code
    env["LIBGZ_STEP"] = "python"
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False, timeout=60)
    assert "LIBGZ_STEP=python: the server is slow" in done.stderr
    assert done.returncode == 0
