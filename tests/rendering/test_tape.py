"""A tape records calls of OpenGL, and plays them in the context's thread, natively and in Python."""

import ctypes
import threading

import numpy as np
import pytest
from camera_worlds import LIGHT, solid, world_of

from libgz.base.errors import LibraryError
from libgz.base.geometry import GzColor, GzPosePointAt, GzVector
from libgz.rendering.camera import Camera
from libgz.rendering.context import open_context
from libgz.rendering.gl import Constant
from libgz.rendering.native import find_native
from libgz.rendering.tape import Tape

MATRIX = np.arange(16.0)


@pytest.fixture(params=["native", "python"])
def tape(request):
    context = open_context("osmesa")
    yield Tape(context, find_native() if request.param == "native" else None)
    context.close()


def modelview(tape):
    """The matrix that the context has."""
    found = np.zeros(16)
    function = ctypes.PYFUNCTYPE(None, ctypes.c_uint, ctypes.c_void_p)(tape.address("glGetDoublev"))
    tape._context.run(function, 0x0BA6, found.ctypes.data)
    return found


def test_calls_are_played_in_their_order_with_what_they_were_given(tape):
    tape.glLoadMatrixd(MATRIX.copy())  # nothing but the tape keeps it
    tape.glTranslated(1.0, 2.0, 3.0)
    assert not np.array_equal(modelview(tape)[:12], MATRIX[:12]), "nothing is played before it has to be"
    tape.play().result()
    moved = MATRIX.reshape(4, 4).T @ np.array([1.0, 2.0, 3.0, 1.0])
    assert np.array_equal(modelview(tape), [*MATRIX[:12], *moved])


def test_a_function_with_a_result_is_called_after_all_before_it(tape):
    number = tape.glGenLists(1)
    tape.glNewList(number, Constant.COMPILE)
    tape.glLoadMatrixd(MATRIX)
    tape.glEndList()
    tape.glCallList(number)
    assert tape.glGenLists(1) != number
    assert np.array_equal(modelview(tape), MATRIX)


def test_errors_of_opengl_are_raised_by_what_waits(tape):
    tape.glEnable(0xFFFF)
    with pytest.raises(LibraryError, match="OpenGL reports error 0x0500"):
        tape.play().result()
    tape.play().result()


def test_arrays_have_to_be_contiguous(tape):
    with pytest.raises((TypeError, ValueError), match="contiguous"):
        tape.glLoadMatrixd(np.zeros((16, 2))[:, 0])


def test_an_image_that_was_not_recorded_to_its_end_leaves_no_trace(monkeypatch):
    view = GzPosePointAt(GzVector(0, 1, 1), GzVector(3, 0, 0), GzVector(0, 0, 1))
    with world_of(LIGHT + solid("3 0 0", "1 1 1")) as world, Camera(world, 64, 48) as camera:
        camera.SetPose(view)
        expected = camera.Update().copy()
    for part in ("glNewList", "glEnableClientState", "glCallList", "glReadPixels"):
        with world_of(LIGHT + solid("3 0 0", "1 1 1")) as world, Camera(world, 64, 48) as camera:
            camera.SetPose(view)

            def stop(*_values):
                raise KeyboardInterrupt

            monkeypatch.setattr(camera._scene.thread.renderer.gl, part, stop, raising=False)
            with pytest.raises(KeyboardInterrupt):
                camera.Update()
            assert np.array_equal(camera.Update(), expected), part


def test_an_image_that_was_begun_shows_the_world_of_that_moment():
    view = GzPosePointAt(GzVector(0, 1, 1), GzVector(3, 0, 0), GzVector(0, 0, 1))
    with world_of(LIGHT + solid("3 0 0", "1 1 1")) as world, Camera(world, 64, 48) as camera:
        camera.SetPose(view)
        expected = camera.Update().copy()
    with world_of(LIGHT + solid("3 0 0", "1 1 1")) as world, Camera(world, 64, 48) as camera:
        camera.SetPose(view)
        free = threading.Event()
        blocked = camera._scene.thread.context.submit(free.wait)
        threading.Timer(0.05, free.set).start()  # in case that it is waited for
        camera.Start()
        world.body("s").geoms[0].SetColor(GzColor(0, 1, 0))
        world.body("s").SetPose(GzPosePointAt(GzVector(9, 9, 9), GzVector(), GzVector(0, 0, 1)))
        free.set()
        assert np.array_equal(camera.image, expected), "`image` waits for it"
        assert blocked.done()
        assert not np.array_equal(camera.Update(), expected)
