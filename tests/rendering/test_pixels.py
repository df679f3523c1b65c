"""Images are read natively and by Mesa's own conversion, with the same result."""

import numpy as np
import pytest
from camera_worlds import LIGHT, solid, world_of

from libgz.base.geometry import GzPosePointAt, GzVector
from libgz.rendering.camera import Camera
from libgz.rendering.pixels import find_drop_alpha


@pytest.mark.parametrize("count", [0, 1, 7, 64, 1001])
def test_the_fourth_bytes_are_dropped_and_nothing_else_is_touched(count):
    drop_alpha = find_drop_alpha()
    assert drop_alpha is not None, "libgz was installed without a C compiler"
    pixels = np.random.default_rng(count).integers(0, 256, (count, 4), dtype=np.uint8)
    found = np.full(3 * count + 16, 77, dtype=np.uint8)
    drop_alpha(pixels.ctypes.data, found.ctypes.data, count)
    assert (found[: 3 * count].reshape(-1, 3) == pixels[:, :3]).all()
    assert (found[3 * count :] == 77).all()


@pytest.mark.parametrize("size", [(64, 48), (37, 23), (1, 1)])
def test_both_ways_give_the_same_image(size):
    with world_of(LIGHT + solid("3 0 0", "1 1 1")) as world, Camera(world, *size) as camera:
        camera.SetPose(GzPosePointAt(GzVector(0, 1, 1), GzVector(3, 0, 0), GzVector(0, 0, 1)))
        native = camera.Update().copy()
        reader = camera._scene.thread.renderer._pixels
        assert reader._drop_alpha is not None
        reader._drop_alpha = None
        assert (camera.Update() == native).all()
        assert native.any()
