"""A frame: what a view shows of a scene and how it is submitted, natively and in Python, to the same bit."""

import ctypes
import math
from pathlib import Path

import numpy as np
import pytest
from camera_worlds import LIGHT, solid, world_of

import libgz
from libgz.base.geometry import GzPose, GzPosePointAt, GzQuatern, GzVector
from libgz.rendering import render_thread, selection
from libgz.rendering.camera import Camera
from libgz.rendering.context import open_context
from libgz.rendering.gl import Constant
from libgz.rendering.library import Library
from libgz.rendering.native import find_native
from libgz.rendering.selection import LEVELS, LocalLight, Rounds, Selector
from libgz.rendering.shot import Content, View
from libgz.rendering.submission import Submitter
from libgz.rendering.tape import Tape

ROOT = Path(__file__).parents[2]


def scene(seed, count=300):
    """A view, and items around it: states, radii, round geoms, lights."""
    random = np.random.default_rng(seed)
    turns = random.normal(size=(count + 1, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    states = np.concatenate([random.normal(size=(count, 3)) * 12.0, turns[1:]], axis=1)
    states[0] = (*random.normal(size=3), *turns[1])
    states[1, :3] = math.inf
    states[2] = math.nan
    rounds = Rounds(Content(()))
    rounds.items = np.sort(random.integers(0, count, count // 2))
    rounds.radii = random.uniform(0.01, 3.0, count // 2)
    rounds.centres, rounds.halves = random.normal(size=(2, count // 2, 3))
    rounds.halves[::2] = 0.0
    rounds.slacks = random.choice([1.0, 2.0], count // 2)
    rounds.finest = random.integers(9, len(LEVELS), count // 2)
    lights = [LocalLight(0x4000 + i, tuple(random.normal(size=3) * 5.0), 9.0 * i + 6.0) for i in range(3)]
    view = View(GzPose(GzVector(*random.normal(size=3)), GzQuatern(*turns[0])), 320, 240, 1.2, 0.3, 25.0)
    return view, states, random.uniform(0.0, 2.0, count), rounds, lights


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_both_forms_select_the_same(seed):
    view, states, radii, rounds, lights = scene(seed)
    native = find_native()
    assert native is not None, "libgz was installed without a C compiler"
    found, expected = (
        Selector(radii, rounds, form).select(view, view.eye(), states, lights) for form in (native, None)
    )
    for name, one, other in zip(found._fields, found, expected, strict=True):
        assert np.array_equal(one, other, equal_nan=name == "matrices"), name
    assert 0 < len(found.places) < len(radii)
    assert len(set(found.levels.tolist())) > 3
    assert len(set(found.dark.tolist())) > 1


def test_what_is_out_of_view_is_left_out_and_what_is_far_has_less_detail():
    places = [(5, 0, 0), (-5, 0, 0), (5, 9, 0), (5, 0, 9), (0.2, 0, 0), (60, 0, 0), (30, 0, 0), (11, 0, 0), (2, 0, 0)]
    states = np.array([(*place, 1, 0, 0, 0) for place in places], dtype=np.float64)
    view = View(GzPose(), 320, 240, math.radians(60.0), 0.5, 50.0)
    for native in (find_native(), None):
        found = Selector(np.full(len(places), 0.5), Rounds(Content(())), native).select(view, view.eye(), states, ())
        assert found.places.tolist() == [0, 4, 6, 7, 8]
        assert [LEVELS[level] for level in found.levels] == [12, 32, 8, 12, 32]


class Recorder:
    """Functions of OpenGL that note their calls."""

    SIGNATURES = {
        "glLoadMatrixd": (lambda place: tuple((ctypes.c_double * 16).from_address(place)), ctypes.c_void_p),
        "glCallList": (int, ctypes.c_uint),
        "glEnable": (int, ctypes.c_uint),
        "glDisable": (int, ctypes.c_uint),
        "glColor3ubv": (lambda place: tuple((ctypes.c_ubyte * 3).from_address(place)), ctypes.c_void_p),
    }
    ARRAYS = ("glLoadMatrixd", "glColor3ubv")

    def __init__(self):
        self.calls = []
        self._functions = {}
        for name, (read, kind) in self.SIGNATURES.items():
            function = ctypes.PYFUNCTYPE(None, kind)(lambda value, n=name, r=read: self.calls.append((n, r(value))))
            self._functions[name] = function
            given = (lambda array, call=function: call(array.ctypes.data)) if name in self.ARRAYS else function
            setattr(self, name, given)

    def address(self, name):
        return ctypes.cast(self._functions[name], ctypes.c_void_p).value

    def recorder(self, function, _form):
        """What calls a function at once, with the interpreter lock."""
        call = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)(function)
        return lambda record: call(ctypes.addressof(record))


@pytest.mark.parametrize("colors", [False, True])
@pytest.mark.parametrize("lights", [(), (0x4001, 0x4003)])
def test_both_forms_submit_the_same(colors, lights):
    random = np.random.default_rng(3)
    matrices, places = random.normal(size=(9, 16)), np.array([7, 0, 3, 8], dtype=np.int64)
    lists, dark = np.array([11, 12, 13, 14], dtype=np.uint32), np.array([0, 1, 3, 2], dtype=np.int64)
    shades = random.integers(0, 256, (9, 3), dtype=np.uint8) if colors else None
    calls = []
    for native in (find_native(), None):
        gl = Recorder()
        Submitter(gl, native).submit(matrices, places, lists, shades, dark, lights)
        calls.append(gl.calls)
    assert calls[0] == calls[1]
    assert [value for name, value in calls[0] if name == "glCallList"] == [11, 12, 13, 14]
    assert [value for name, value in calls[0] if name == "glLoadMatrixd"][2] == tuple(matrices[3])
    switches = [(name, value) for name, value in calls[0] if name in ("glEnable", "glDisable")]
    off, on = ("glDisable", 0x4001), ("glEnable", 0x4001)
    assert switches == ([off, ("glDisable", 0x4003), on, ("glEnable", 0x4003)] if lights else [])


def test_nothing_is_submitted_of_an_empty_view():
    for native in (find_native(), None):
        gl, nothing = Recorder(), np.empty(0, dtype=np.int64)
        Submitter(gl, native).submit(np.empty((0, 16)), nothing, nothing.astype(np.uint32))
        assert not gl.calls


SDF = "<sdf version='1.6'><world name='w'>{}</world></sdf>".format(
    "<scene><background>.6 .7 .8 1</background></scene>"
    + "".join(
        f"<light name='{name}' type='point'><pose>{place} 0 0 0</pose><diffuse>.9 .6 .4 1</diffuse>"
        "<attenuation><range>2</range></attenuation></light>"
        for name, place in (("a", "0 0 1"), ("b", "3 1 1"))
    )
    + "".join(
        f"<model name='m{i}'><static>1</static><pose>{i % 4} {i // 4} .3 0 .2 {i}</pose><link name='l'>"
        f"<visual name='v'><transparency>{.5 * (i % 3 == 2)}</transparency><geometry>{shape}</geometry></visual>"
        "</link></model>"
        for i, shape in enumerate(
            4 * ("<box><size>.4 .5 .6</size></box>", "<sphere><radius>.3</radius></sphere>",
                 "<cylinder><radius>.2</radius><length>.7</length></cylinder>")
        )
    )
)  # fmt: skip


@pytest.mark.parametrize("shadows", [False, True])
def test_images_of_both_forms_are_the_same_bit_for_bit(shadows, monkeypatch):
    images = []
    for _ in range(2):
        with libgz.World.from_string(SDF) as world, Camera(world, 120, 90, near=0.1) as camera:
            camera.options.shadows = shadows
            camera.SetPose(GzPosePointAt(GzVector(-3, -2, 2.5), GzVector(1.5, 1, 0.3), GzVector(0, 0, 1)))
            images.append((camera.Update().copy(), camera.depth, camera.segmentation))
        for module in (render_thread, selection):
            monkeypatch.setattr(module, "find_native", lambda: None)
    for native, plain in zip(*images, strict=True):
        assert np.array_equal(native, plain)
    assert len(np.unique(images[0][2])) > 10
    assert images[0][0].std() > 10


def test_lights_that_change_are_seen_at_once():
    with world_of(LIGHT + solid("3 0 0", "1 1 1")) as world, Camera(world, 32, 24) as camera:
        lamp = next(geom for geom in world.engine.geoms.values() if isinstance(geom, libgz.LightGeom))
        first, again = camera.Update().copy(), camera.Update().copy()
        assert np.array_equal(first, again)
        lamp.body.SetPose(GzPose(GzVector(-5, -9, -8)))
        moved = camera.Update().copy()
        lamp.appearance.diffuse.r = 0.0  # in place, without a new version
        assert len({image.tobytes() for image in (first, moved, camera.Update())}) == 3


def test_equal_materials_are_set_once_in_a_list():
    with world_of(LIGHT + "<model:Pioneer2AT><id>r</id></model:Pioneer2AT>") as world, Camera(world, 8, 8) as camera:
        gl = camera._scene.thread.renderer.gl
        known, calls = gl.glMaterialfv, []
        gl.glMaterialfv = lambda *values: (calls.append(1), known(*values))
        camera.Update()
        bodies = world.model("r").bodies
        assert any(len(body.geoms) == 1 for body in bodies), "a wheel of three meshes"
        assert len(calls) <= 4 * sum(len({id(geom) for geom in body.geoms}) for body in bodies)


# OpenGL ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(64, 32), (8, 8), (1, 1)])
def test_smaller_images_of_a_texture_are_those_of_opengl(size, monkeypatch):
    pixels = np.random.default_rng(5).integers(0, 256, (*size, 3), dtype=np.uint8)
    context = open_context("osmesa")

    def levels(tape):
        Library(tape)._upload(pixels, Constant.REPEAT, Constant.LINEAR, Constant.NEAREST_MIPMAP_NEAREST)
        tape.play().result()
        return context.run(read)

    def read():
        gl = context.gl
        found, width, height = [], *size[::-1]
        get = ctypes.PYFUNCTYPE(None, *(ctypes.c_uint, ctypes.c_int, ctypes.c_uint, ctypes.c_uint, ctypes.c_void_p))(
            gl.address("glGetTexImage")
        )
        gl.glPixelStorei(Constant.PACK_ALIGNMENT, 1)
        while True:
            image = np.empty((height, width, 3), dtype=np.uint8)
            get(Constant.TEXTURE_2D, len(found), Constant.RGB, Constant.UNSIGNED_BYTE, image.ctypes.data)
            found.append(image)
            if width == height == 1:
                return found
            width, height = max(width // 2, 1), max(height // 2, 1)

    def generated():
        gl = Tape(context, find_native())
        plain = gl.glTexImage2D

        def with_mipmaps(*values):
            gl.glTexParameteri(Constant.TEXTURE_2D, Constant.GENERATE_MIPMAP, 1)
            plain(*values)

        gl.glTexImage2D = with_mipmaps
        monkeypatch.setattr("libgz.rendering.library.pyramid", lambda image: [image])
        return levels(gl)

    try:
        own = levels(Tape(context, find_native()))
        expected = generated()
    finally:
        context.close()
    assert all(np.array_equal(one, other) for one, other in zip(own, expected, strict=True))
