"""OpenGL contexts: their choice, messages when one is missing, and what remains after them."""

import gc
import logging
import os
from pathlib import Path

import pytest
from camera_worlds import ROBOT_WITH_CAMERA, world_of

import libgz
from libgz.base.files import installed_worlds


def test_cameras_can_be_left_blind(monkeypatch):
    monkeypatch.setenv("LIBGZ_GL", "none")
    cameras = "".join(
        f"<model:{kind}><id>{kind}</id></model:{kind}>" for kind in ("MonoCam", "ObserverCam", "StereoHead")
    )
    with world_of(cameras + ROBOT_WITH_CAMERA.format("")) as world:
        world.interface("ptz", "c").command(pan=0.3)
        world.run(2.0)
        assert world.interface("camera", "MonoCam").image.size == 0
        assert world.interface("camera", "MonoCam").data.width == 320
        assert world.interface("ptz", "c").pan == pytest.approx(0.3, abs=0.02)
        assert all(model.failed is None for model in world.models)
        with pytest.raises(libgz.base.errors.LibraryError, match="switched off"):
            _ = world.model("MonoCam").camera.eye.depth


def test_a_wrong_choice_is_answered_with_the_right_ones(monkeypatch):
    monkeypatch.setenv("LIBGZ_GL", "osmeas")
    with pytest.raises(libgz.PluginError, match=r"allowed are auto, osmesa, egl, none; did you mean 'osmesa'"):
        world_of("<model:MonoCam/>")


def test_what_does_not_work_says_why_and_auto_goes_on(monkeypatch, caplog):
    from libgz.rendering import context

    def absent(name, kind):
        raise libgz.base.errors.LibraryError(f"{name} cannot be loaded (gone)")

    real = context._library
    monkeypatch.setattr(context, "_library", lambda n, k: absent(n, k) if "OSMesa" in n else real(n, k))
    monkeypatch.setenv("LIBGZ_GL", "osmesa")
    with pytest.raises(libgz.PluginError, match=r"libOSMesa.so.8 cannot be loaded \(gone\)"):
        world_of("<model:MonoCam/>")
    monkeypatch.setenv("LIBGZ_GL", "auto")
    with caplog.at_level(logging.INFO), world_of("<model:MonoCam><id>c</id></model:MonoCam>") as world:
        world.step()
        assert world.interface("camera", "c").image.size
    assert "osmesa does not render: libOSMesa.so.8 cannot be loaded" in caplog.text
    assert "rendering with egl" in caplog.text
    monkeypatch.setattr(context, "_library", absent)
    with pytest.raises(
        libgz.PluginError, match=r"osmesa: .* egl: .* --gl none disables rendering, and so does LIBGZ_GL=none"
    ):
        world_of("<model:MonoCam/>")


def test_the_context_goes_with_its_world():
    import threading

    before = threading.active_count()
    with world_of("<model:MonoCam><id>a</id></model:MonoCam><model:MonoCam><id>b</id></model:MonoCam>") as world:
        scene = world.model("a").camera.eye._scene
        assert world.model("b").camera.eye._scene is scene  # one context a world
        assert threading.active_count() == before + 1
        world.step()
    assert scene.thread.closed
    assert threading.active_count() == before


def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def frames(count):
    with libgz.World.from_file(installed_worlds() / "ptz.world") as world:
        eye = world.model("cam1").camera.eye
        world.step(100)
        for _ in range(200):
            eye.Update()
        before = resident()
        for _ in range(count):
            eye.Update()
        return resident() - before


def test_frames_do_not_grow_memory():
    assert frames(300) < 2e6


@pytest.mark.trial
def test_ten_thousand_frames_do_not_grow_memory():
    assert frames(10_000) < 4e6


@pytest.mark.trial
def test_two_hundred_worlds_do_not_grow_memory():
    def one():
        with libgz.World.from_file(installed_worlds() / "ptz.world") as world:
            world.step(10)

    for _ in range(60):
        one()
    gc.collect()
    before = resident()
    for _ in range(200):
        one()
    gc.collect()
    # What the allocator keeps goes up and down by some MB; a scene that stayed would take more than 1 MB each time.
    assert resident() - before < 25e6
