"""ODE's data of large meshes, whose trees are built in a thread, so that a signal ends the wait."""

import os
import signal
import threading

import numpy as np
import pytest

import libgz
from libgz.base.errors import Interrupted
from libgz.ode import mesh_data
from libgz.ode.lib import ode
from libgz.ode.mesh_data import LARGE, new_mesh_data
from libgz.physics.engine import Engine
from libgz.physics.meshes import grid_triangles
from libgz.physics.space import Space

ROWS = 120  # of a grid of more than LARGE triangles
BUILD = "dGeomTriMeshDataBuildSimple"


def grid():
    y, x = np.mgrid[0:ROWS, 0:ROWS] * 0.1
    points = np.stack([x.ravel(), y.ravel(), np.sin(x + 2.0 * y).ravel()], axis=1)
    return points, grid_triangles(ROWS, ROWS).astype(np.uint32)


def interrupt(_number, _frame):
    raise Interrupted(signal.SIGINT)


@pytest.fixture
def interrupting():
    before = signal.signal(signal.SIGINT, interrupt)
    yield
    signal.signal(signal.SIGINT, before)


def test_a_signal_ends_the_wait_for_a_large_mesh(monkeypatch, interrupting):
    begun, goes_on, destroyed = threading.Event(), threading.Event(), threading.Event()
    library = ode()
    build, destroy = library.without_lock(BUILD), library.dGeomTriMeshDataDestroy

    def slow(*arguments):
        begun.set()
        goes_on.wait()
        build(*arguments)

    def destroying(data):
        destroy(data)
        destroyed.set()

    def send():
        begun.wait()
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(library, "without_lock", lambda name: slow)
    monkeypatch.setattr(library, "dGeomTriMeshDataDestroy", destroying)
    points, triangles = grid()
    threading.Thread(target=send).start()
    with pytest.raises(Interrupted):
        new_mesh_data(np.pad(points, ((0, 0), (0, 1))), triangles)
    assert not destroyed.is_set()  # ODE still writes there
    goes_on.set()
    assert destroyed.wait(30.0)


def test_the_tree_of_a_large_mesh_is_built_without_the_interpreter_lock():
    """With it, neither the main thread nor the watchdog would run."""
    python_api = 4  # FUNCFLAG_PYTHONAPI of ctypes
    assert ode().dGeomTriMeshDataBuildSimple._flags_ & python_api
    assert not ode().without_lock(BUILD)._flags_ & python_api


def test_large_and_small_meshes_are_built_alike(monkeypatch):
    points, triangles = grid()
    assert len(triangles) >= LARGE
    states = []
    for limit in (LARGE, 10 * LARGE):
        monkeypatch.setattr(mesh_data, "LARGE", limit)
        engine = Engine()
        libgz.TriMeshGeom(libgz.Body(engine, dummy=True), Space(engine), points, triangles)
        ball = libgz.Body(engine)
        libgz.SphereGeom(ball, Space(engine), 0.3)
        ball.SetPosition((5.0, 6.0, 2.0))
        for _ in range(60):
            engine.step()
        states.append(engine.states.tobytes())
        assert ball.GetPosition().z > -1.0
        engine.close()
    assert states[0] == states[1]
