"""Images are read natively and by Mesa's own conversion, with the same result."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest
from camera_worlds import LIGHT, solid, world_of

from libgz.base.geometry import GzPosePointAt, GzVector
from libgz.rendering.camera import Camera
from libgz.rendering.native import find_native

SOURCE = Path(__file__).parents[2] / "libgz" / "rendering" / "pixels.c"


def declared(library):
    """The function of a library."""
    function = library.gz_drop_alpha
    function.argtypes, function.restype = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t], None
    return function


@pytest.mark.parametrize("count", [0, 1, 7, 64, 1001])
def test_the_fourth_bytes_are_dropped_and_nothing_else_is_touched(count):
    assert find_native() is not None, "libgz was installed without a C compiler"
    drop_alpha = declared(find_native())
    pixels = np.random.default_rng(count).integers(0, 256, (count, 4), dtype=np.uint8)
    found = np.full(3 * count + 16, 77, dtype=np.uint8)
    drop_alpha(pixels.ctypes.data, found.ctypes.data, count)
    assert (found[: 3 * count].reshape(-1, 3) == pixels[:, :3]).all()
    assert (found[3 * count :] == 77).all()


@pytest.fixture(scope="module")
def portable(tmp_path_factory):
    """The function as it is built for processors without a vector form of their own."""
    library = tmp_path_factory.mktemp("portable") / "pixels.so"
    subprocess.run(["cc", "-O3", "-shared", "-fPIC", "-U__x86_64__", "-o", library, SOURCE], check=True)
    return declared(ctypes.CDLL(str(library)))


@pytest.mark.parametrize("count", [0, 1, 31, 32, 33, 4099])
def test_the_portable_form_gives_the_same_bytes(portable, count):
    pixels = np.random.default_rng(count).integers(0, 256, (count, 4), dtype=np.uint8)
    found = np.full((2, 3 * count + 16), 77, dtype=np.uint8)
    for drop_alpha, image in zip((declared(find_native()), portable), found, strict=True):
        drop_alpha(pixels.ctypes.data, image.ctypes.data, count)
    assert (found[0] == found[1]).all()
    assert (found[0, : 3 * count].reshape(-1, 3) == pixels[:, :3]).all()


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
