"""The ground: rings, and the level of its texture on each of them."""

import math

import numpy as np
import pytest
from camera_worlds import world_of
from PIL import Image

from libgz.base.geometry import GzPose, GzPosePointAt, GzVector
from libgz.rendering.camera import Camera
from libgz.rendering.ground import Sight, rings
from libgz.rendering.shot import View

LAMP = "<model:LightSource><xyz>0 0 30</xyz><ambientColor>4 4 4</ambientColor></model:LightSource>"


def view_of(height, hfov=60.0, far=50.0):
    return View(GzPose(GzVector(0.0, 0.0, height)), 320, 240, math.radians(hfov), 0.1, far)


def at(height):
    return GzPosePointAt(GzVector(0, 0, height), GzVector(10 * height, 0, 0), GzVector(0, 0, 1))


@pytest.mark.parametrize("height", [0.2, 1.0, 7.0])
@pytest.mark.parametrize("hfov", [10.0, 60.0])
def test_each_ring_has_the_level_that_opengl_would_choose(height, hfov):
    """Along the line through the image's middle, from how far apart on the plane neighbouring pixels look."""
    texel, view = 2.0 / 128, view_of(height, hfov)
    found = rings(Sight.of(view, height), texel, 8, (2.0, 2.0))
    reach = np.array([(level, np.hypot(*shape.vertices[:, :2].T).max()) for level, shape in found])
    for distance in np.geomspace(0.3 * height, 45.0, 60):
        slope = math.atan2(height, distance)
        step = height / math.tan(slope - 0.5 / view.focal) - height / math.tan(slope + 0.5 / view.focal)
        exact = min(max(math.log2(step / texel), 0.0), 7.0)
        level = reach[np.searchsorted(reach[:, 1], distance), 0]
        assert abs(level - exact) <= 0.5 + 0.2, distance  # the sight is rounded


@pytest.mark.parametrize(("height", "count"), [(0.001, 8), (0.4, 8), (3.0, 1), (3.0, 8), (400.0, 8)])
def test_rings_leave_no_gap_and_reach_as_far_as_the_view(height, count):
    view = view_of(height)
    found = rings(Sight.of(view, height), 2.0 / 128, count, (2.0, 2.0))
    edge, corner = 0.0, view.far * math.hypot(160, 120, view.focal) / view.focal
    for _, shape in found:
        radii = np.hypot(*shape.vertices[:, :2].T)
        assert radii.min() == pytest.approx(edge, abs=1e-5)
        edge = radii.max()
        a, b, c = (shape.vertices[shape.indices[k::3]] for k in range(3))
        areas = np.cross(b - a, c - a)[:, 2] / 2.0
        assert areas.min() >= -1e-6, "all face up"
        polygon = 16 / 2 * math.sin(2 * math.pi / 16)
        assert areas.sum() == pytest.approx(polygon * (edge**2 - radii.min() ** 2), rel=1e-4)
    assert edge * math.cos(math.pi / 16) >= corner
    assert [level for level, _ in found] == sorted({level for level, _ in found})


def checkered(tmp_path):
    """Ground of black and white squares of 1/16 m; in the image's smaller forms all is grey."""
    squares = np.kron(
        (np.add.outer(np.arange(32), np.arange(32)) % 2 * 255).astype(np.uint8), np.ones((4, 4), np.uint8)
    )
    Image.fromarray(np.repeat(squares[:, :, None], 3, axis=2)).save(tmp_path / "t.png")
    return LAMP + (
        f"<model:GroundPlane><color>1 1 1</color><textureFile>{tmp_path}/t.png</textureFile>"
        "<textureSize>2 2</textureSize></model:GroundPlane>"
    )


def test_what_is_finer_than_a_pixel_is_mixed_and_does_not_flicker(tmp_path):
    with world_of(checkered(tmp_path)) as world, Camera(world, 320, 240) as camera:
        camera.SetPose(at(1.0))
        image = camera.Update()[:, :, 0].astype(float)
        near, far = image[-20:], image[100:104]  # at 1.5 m, and beyond 15 m, where a pixel sees 1 m of ground
        assert near.min() < 20 < 235 < near.max()
        assert far.max() - far.min() < 20
        assert far.mean() == pytest.approx(127, abs=20)


def test_a_camera_that_rises_and_zooms_needs_few_lists(tmp_path):
    with world_of(checkered(tmp_path)) as world, Camera(world, 32, 24) as camera:
        library = camera._scene.thread.renderer.library
        for i in range(300):
            camera.SetPose(at(1.0 + 0.003 * i))
            camera.SetFOV(math.radians(60.0 - 0.1 * i))
            camera.Update()
        assert len(library._planes) <= 24
        for i in range(400):
            camera.SetPose(at(1.03**i))
            camera.Update()
        assert len(library._planes) <= 64


def test_a_plane_is_not_seen_from_below(tmp_path):
    with world_of(checkered(tmp_path)) as world, Camera(world, 32, 24) as camera:
        for height in (0.0, -1.0):
            camera.SetPose(GzPosePointAt(GzVector(0, 0, height), GzVector(1, 0, height - 0.5), GzVector(0, 0, 1)))
            image = camera.Update()
            assert (image == image[0, 0]).all(), "only sky"
