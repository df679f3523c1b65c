"""Renderer: records how shots are rendered into arrays."""

from __future__ import annotations

import ctypes
import logging
import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError
from libgz.base.geometry import GzColor
from libgz.physics.geom import Geom
from libgz.physics.geoms import PlaneGeom
from libgz.rendering.context import Context
from libgz.rendering.dome import dome_mesh
from libgz.rendering.gl import Constant, floats
from libgz.rendering.ground import Sight
from libgz.rendering.library import Library, Look
from libgz.rendering.pixels import PixelReader
from libgz.rendering.selection import LocalLight
from libgz.rendering.shading import Shading
from libgz.rendering.shadows import ShadowMaps
from libgz.rendering.shot import Light, Shot, View
from libgz.rendering.submission import Submitter
from libgz.rendering.tape import Tape

__all__ = ["Renderer"]

log = logging.getLogger("libgz.rendering")

LIGHTS = 8
SAMPLES = 4  # of a pixel of an image with shadows
MOST_SIZES = 16  # of images, whose buffers are kept
FOGS = {"exp": Constant.EXP, "exp2": Constant.EXP2, "linear": Constant.LINEAR}


class Renderer:
    """Renders shots with the lists and textures of one context.

    It reads the world, and records; whoever calls it has the tape played. Only one thread at a time may use it.

    Args:
        context: to render in.
        native: frame.c and what is beside; None for the forms in Python.
    """

    def __init__(self, context: Context, native: ctypes.CDLL | None) -> None:
        gl = self.gl = Tape(context, native)
        self.library = Library(gl)
        self._pixels = PixelReader(gl, native)
        self._submitter = Submitter(gl, native)
        self._maps = ShadowMaps(gl, self._submitter)
        self._shading: Shading | None = None  # made for the first image with shadows
        self._shades = True  # until that fails
        self._samples = 0  # of a pixel of an image with shadows
        self._buffers: dict[tuple[int, int, int], tuple[ctypes.c_uint, ctypes.Array[ctypes.c_uint]]] = {}
        self._light_list = int(gl.glGenLists(1))
        self._lit: object = None  # the lights and the ambient light that are in it
        for state in (Constant.CULL_FACE, Constant.DEPTH_TEST):
            gl.glEnable(state)
        gl.glDisable(Constant.DITHER)
        gl.glDepthFunc(Constant.LEQUAL)
        gl.glBlendFunc(Constant.SRC_ALPHA, Constant.ONE_MINUS_SRC_ALPHA)
        gl.glFrontFace(Constant.CW)  # images are rendered upside down, so that the top row is read first
        gl.glTexEnvi(Constant.TEXTURE_ENV, Constant.TEXTURE_ENV_MODE, Constant.MODULATE)
        gl.glPixelStorei(Constant.PACK_ALIGNMENT, 1)

    def _bind(self, width: int, height: int, samples: int = 0) -> int:
        """Render into a buffer of this size, with so many samples of a pixel; returns the framebuffer."""
        gl, frame, key = self.gl, Constant.FRAMEBUFFER, (width, height, samples)
        if key not in self._buffers:
            if len(self._buffers) >= MOST_SIZES:
                old, used = self._buffers.pop(next(iter(self._buffers)))
                gl.glDeleteFramebuffers(1, old)
                gl.glDeleteRenderbuffers(2, used)
            number, parts = ctypes.c_uint(), (ctypes.c_uint * 2)()
            gl.glGenFramebuffers(1, ctypes.byref(number))
            gl.glGenRenderbuffers(2, parts)
            gl.glBindFramebuffer(frame, number.value)
            roles = (
                (Constant.COLOR_ATTACHMENT0, Constant.RGBA8),
                (Constant.DEPTH_ATTACHMENT, Constant.DEPTH_COMPONENT24),
            )
            for part, (role, layout) in zip(parts, roles, strict=True):
                gl.glBindRenderbuffer(Constant.RENDERBUFFER, part)
                if samples:
                    gl.glRenderbufferStorageMultisample(Constant.RENDERBUFFER, samples, layout, width, height)
                else:
                    gl.glRenderbufferStorage(Constant.RENDERBUFFER, layout, width, height)
                gl.glFramebufferRenderbuffer(frame, role, Constant.RENDERBUFFER, part)
            if gl.glCheckFramebufferStatus(frame) != Constant.FRAMEBUFFER_COMPLETE:
                raise LibraryError(f"this OpenGL cannot render images of {width} x {height} px")
            self._buffers[key] = (number, parts)
        bound = int(self._buffers[key][0].value)
        gl.glBindFramebuffer(frame, bound)
        gl.glViewport(0, 0, width, height)
        return bound

    def render(self, shot: Shot, image: NDArray[np.uint8] | None, depth: NDArray[np.float32] | None = None) -> None:
        """Render a shot.

        Args:
            shot: what to render.
            image: out, shape (height, width, 3), top row first.
            depth: out, distance ahead, along the axis [m], shape (height, width); infinite where there is nothing. With
                it, the tape is played at once.
        """
        view = shot.view
        if shot.shadows and (image is None or not self._can_shade()):
            shot = replace(shot, shadows=False)
        samples = self._samples if shot.shadows and depth is None else 0
        if shot.shadows:
            self.library.use(shot.content)
            maps = self._maps.render(shot, self.library.table(shot.content, _look_of(shot), plain=True))
        sampled = self._bind(view.width, view.height, samples)
        eye = self._begin(shot)
        self._set_options(shot)
        self._dome(shot, eye)
        self._lights(shot, eye)
        self.gl.glEnable(Constant.LIGHTING)
        if shot.shadows and self._shading is not None:
            self._shading.begin(shot, eye, *maps)
        self._ground(shot, eye, plain=False)
        self._items(shot, eye, plain=False)
        if shot.shadows and self._shading is not None:
            self._shading.end()
        self.gl.glDisable(Constant.LIGHTING)
        self._lines(shot, eye)
        self.gl.glPolygonMode(Constant.FRONT_AND_BACK, Constant.FILL)
        self.gl.glDisable(Constant.FOG)
        if samples:
            self._resolve(sampled, view)
        self._read(view, image, depth)

    def _can_shade(self) -> bool:
        """Whether images can have shadows here; the first one with shadows compiles the program."""
        if self._shading is None and self._shades:
            try:
                self._shading = Shading(self.gl)
            except LibraryError as error:
                log.warning("images have no shadows: %s", error)
                self._shades = False
                return False
            most = ctypes.c_int()
            self.gl.glGetIntegerv(Constant.MAX_SAMPLES, ctypes.byref(most))
            self._samples = SAMPLES if most.value >= SAMPLES else 0
        return self._shades

    def _resolve(self, sampled: int, view: View) -> None:
        """Copy the mean of each pixel's samples into the buffer that is read."""
        gl, area = self.gl, (0, 0, view.width, view.height)
        self._bind(view.width, view.height)
        gl.glBindFramebuffer(Constant.READ_FRAMEBUFFER, sampled)
        gl.glBlitFramebuffer(*area, *area, Constant.COLOR_BUFFER_BIT, Constant.NEAREST)
        self._bind(view.width, view.height)

    def segment(self, shot: Shot, ids: NDArray[np.uint8]) -> None:
        """Render which model is where: red + 256 green + 65536 blue is its number, 0 for nothing."""
        self._bind(shot.view.width, shot.view.height)
        eye = self._begin(shot, black=True)
        self._ground(shot, eye, plain=True)
        self._items(shot, eye, plain=True)
        self.gl.glColor3f(1.0, 1.0, 1.0)
        self._read(shot.view, ids, None)

    def _begin(self, shot: Shot, black: bool = False) -> NDArray[np.float64]:
        """Clear, and set the projection; the eye matrix."""
        gl = self.gl
        sky = GzColor() if black else shot.sky
        gl.glClearColor(sky.r, sky.g, sky.b, 1.0)
        gl.glClear(Constant.COLOR_BUFFER_BIT | Constant.DEPTH_BUFFER_BIT)
        gl.glMatrixMode(Constant.PROJECTION)
        _load(gl, shot.view.projection())
        gl.glMatrixMode(Constant.MODELVIEW)
        gl.glShadeModel(Constant.FLAT if black or not shot.view.options.shadeSmooth else Constant.SMOOTH)
        self.library.use(shot.content)
        return shot.view.eye()

    def _set_options(self, shot: Shot) -> None:
        gl = self.gl
        mode = Constant.FILL if shot.view.options.polygonFill else Constant.LINE
        gl.glPolygonMode(Constant.FRONT_AND_BACK, mode)
        if shot.fog is not None:
            gl.glEnable(Constant.FOG)
            gl.glFogi(Constant.FOG_MODE, FOGS[shot.fog.kind])
            gl.glFogf(Constant.FOG_DENSITY, shot.fog.density)
            gl.glFogf(Constant.FOG_START, shot.fog.start)
            gl.glFogf(Constant.FOG_END, shot.fog.end)
            gl.glFogfv(Constant.FOG_COLOR, floats(*shot.fog.color))

    def _lights(self, shot: Shot, eye: NDArray[np.float64]) -> None:
        """Set all lights, by a list as long as they stay the same."""
        gl, wanted = self.gl, (shot.lights, (*shot.ambient,))
        _load(gl, eye)
        if wanted != self._lit:
            gl.glNewList(self._light_list, Constant.COMPILE)
            self._set_lights(shot)
            gl.glEndList()
            self._lit = wanted
        gl.glCallList(self._light_list)

    def _set_lights(self, shot: Shot) -> None:
        gl = self.gl
        gl.glLightModelfv(Constant.LIGHT_MODEL_AMBIENT, floats(*shot.ambient))
        for i in range(LIGHTS):
            number = Constant.LIGHT0 + i
            if i >= len(shot.lights):
                gl.glDisable(number)
                continue
            light = shot.lights[i]
            gl.glEnable(number)
            if light.kind == "directional":
                gl.glLightfv(number, Constant.POSITION, floats(*(-x for x in light.direction), 0.0))
            else:
                gl.glLightfv(number, Constant.POSITION, floats(*light.position, 1.0))
            self._spot(number, light)
            gl.glLightfv(number, Constant.AMBIENT, floats(*light.ambient))
            gl.glLightfv(number, Constant.DIFFUSE, floats(*light.diffuse))
            gl.glLightfv(number, Constant.SPECULAR, floats(*light.specular))
            for name, factor in zip(
                (Constant.CONSTANT_ATTENUATION, Constant.LINEAR_ATTENUATION, Constant.QUADRATIC_ATTENUATION),
                light.attenuation,
                strict=True,
            ):
                gl.glLightf(number, name, factor)

    def _spot(self, number: int, light: Light) -> None:
        """The cone of a spot; of others, none.

        Classic dims a spot by ((cos a - cos outer) / (cos inner - cos outer)) ^ falloff, of half the angles; OpenGL by
        cos(a) ^ exponent. The exponent is such that both agree in the middle between inner and outer.
        """
        gl = self.gl
        cutoff, exponent = 180.0, 0.0
        if light.kind == "spot":
            outer = min(max(light.spot[1] / 2.0, 0.0), math.pi / 2.0)
            inner = min(max(light.spot[0] / 2.0, 0.0), outer)
            middle, cutoff = (inner + outer) / 2.0, math.degrees(outer)
            if outer > inner and middle < math.pi / 2.0:
                share = (math.cos(middle) - math.cos(outer)) / (math.cos(inner) - math.cos(outer))
                exponent = min(light.spot[2] * math.log(share) / math.log(math.cos(middle)), 128.0)
            gl.glLightfv(number, Constant.SPOT_DIRECTION, floats(*light.direction))
        gl.glLightf(number, Constant.SPOT_CUTOFF, cutoff)
        gl.glLightf(number, Constant.SPOT_EXPONENT, exponent)

    def _items(self, shot: Shot, eye: NDArray[np.float64], plain: bool) -> None:
        """Opaque items, then what is transparent, from back to front."""
        table = self.library.table(shot.content, _look_of(shot), plain)
        local = _local_lights(shot, eye)
        found = table.selector.select(shot.view, eye, shot.states, local)
        matrices, places, dark = found.matrices, found.places, found.dark
        lists, numbers = table.lists(places, found.levels), [light.number for light in local]
        if plain:
            self._submitter.submit(matrices, places, lists, table.colors)
            return
        clear = table.clear[places]
        if not clear.any():
            self._submitter.submit(matrices, places, lists, None, dark, numbers)
            return
        solid, gl = ~clear, self.gl
        self._submitter.submit(matrices, places[solid], lists[solid], None, dark[solid], numbers)
        gl.glEnable(Constant.BLEND)
        gl.glDepthMask(0)
        middles = (
            np.einsum("nji,nj->ni", matrices.reshape(-1, 4, 4)[places[clear], :3, :3], table.middles[places[clear]])
            + matrices[places[clear], 12:15]
        )
        distances = np.einsum("ni,ni->n", middles, middles)
        order = np.flatnonzero(clear)[np.lexsort((places[clear], distances))[::-1]]
        self._submitter.submit(matrices, places[order], lists[order], None, dark[order], numbers)
        gl.glDepthMask(1)
        gl.glDisable(Constant.BLEND)

    def _id_color(self, number: int) -> None:
        self.gl.glColor3ub(number & 255, number >> 8 & 255, number >> 16 & 255)

    def _ground(self, shot: Shot, eye: NDArray[np.float64], plain: bool) -> None:
        """All planes: most of the pixels. Mesa's threads render them while this one submits the items."""
        if plain:
            self._id_color(0)
        for plane in shot.planes:
            self._plane(shot, eye, plane, plain)
        if shot.planes:
            self.gl.glFlush()

    def _plane(self, shot: Shot, eye: NDArray[np.float64], geom: Geom, plain: bool) -> None:
        """A plane as rings around the camera's foot; its texture stays fixed in the world."""
        if not isinstance(geom, PlaneGeom):
            return
        view = shot.view
        across, up, normal = axes = _plane_axes((*geom.normal,))
        camera, altitude = (*view.pose.pos,), geom.altitude
        x, y, z = (a * camera[0] + b * camera[1] + c * camera[2] for a, b, c in axes)
        height = z - altitude
        if height <= 0.0:
            return
        foot = [x * a + y * b + altitude * c for a, b, c in zip(across, up, normal, strict=True)]
        matrix = np.array([*zip(across, up, normal, foot, strict=True), (0.0, 0.0, 0.0, 1.0)])
        compiled = self.library.plane(geom, Sight.of(view, height), _look_of(shot), plain)
        size = geom.appearance.texture_size
        self._call_shifted(compiled.list, eye @ matrix, math.fmod(x / size.x, 1.0), math.fmod(y / size.y, 1.0))

    def _call_shifted(self, number: int, matrix: NDArray[np.float64], s: float, t: float) -> None:
        """Call a list in a frame, with its texture coordinates shifted."""
        gl = self.gl
        gl.glMatrixMode(Constant.TEXTURE)
        gl.glTranslated(s, t, 0.0)
        gl.glMatrixMode(Constant.MODELVIEW)
        _load(gl, matrix)
        gl.glCallList(number)
        gl.glMatrixMode(Constant.TEXTURE)
        gl.glLoadIdentity()
        gl.glMatrixMode(Constant.MODELVIEW)

    def _dome(self, shot: Shot, eye: NDArray[np.float64]) -> None:
        """The sky behind everything, unlit and without fog, from its tone map's column for the time of day."""
        if shot.dome is None:
            return
        geom, share = shot.dome
        texture = self.library.texture(geom.appearance.texture_file, repeat=False)
        if not texture or not shot.view.options.displayTextures:
            return
        gl, far, camera = self.gl, 0.8 * shot.view.far, shot.view.pose.pos
        matrix = np.diag([far, far, far, 1.0])
        matrix[:3, 3] = (camera.x, camera.y, -0.1)
        compiled = self.library.shape("dome", dome_mesh)
        gl.glDisable(Constant.FOG)
        gl.glDepthMask(0)
        gl.glEnable(Constant.TEXTURE_2D)
        gl.glTexEnvi(Constant.TEXTURE_ENV, Constant.TEXTURE_ENV_MODE, Constant.REPLACE)
        gl.glBindTexture(Constant.TEXTURE_2D, texture)
        self._call_shifted(compiled.list, eye @ matrix, share, 0.0)
        gl.glTexEnvi(Constant.TEXTURE_ENV, Constant.TEXTURE_ENV_MODE, Constant.MODULATE)
        gl.glDisable(Constant.TEXTURE_2D)
        gl.glDepthMask(1)
        if shot.fog is not None:
            gl.glEnable(Constant.FOG)

    def _lines(self, shot: Shot, eye: NDArray[np.float64]) -> None:
        gl = self.gl
        _load(gl, eye)
        for lines in shot.lines:
            gl.glColor3f(*lines.color)
            gl.glEnableClientState(Constant.VERTEX_ARRAY)
            gl.glVertexPointer(3, Constant.FLOAT, 0, lines.ends)
            gl.glDrawArrays(Constant.LINES, 0, len(lines.ends))
            gl.glDisableClientState(Constant.VERTEX_ARRAY)
        gl.glColor3f(1.0, 1.0, 1.0)

    def _read(self, view: View, image: NDArray[np.uint8] | None, depth: NDArray[np.float32] | None) -> None:
        gl, area = self.gl, (0, 0, view.width, view.height)
        gl.glFinish()
        if image is not None:
            self._pixels.read(image)
        if depth is not None:
            found = np.empty((view.height, view.width), dtype=np.float32)
            gl.glReadPixels(*area, Constant.DEPTH_COMPONENT, Constant.FLOAT, found)
            gl.play().result()
            near, far, nothing = view.near, view.far, found >= 1.0
            np.divide(far * near, far - found.astype(np.float64) * (far - near), out=depth, casting="same_kind")
            depth[nothing] = np.inf


def _local_lights(shot: Shot, eye: NDArray[np.float64]) -> list[LocalLight]:
    """The lights with a range, which are off for the items that are out of it."""
    found = []
    for i, light in enumerate(shot.lights):
        if light.kind != "directional" and math.isfinite(light.range):
            x, y, z, _ = (eye @ (*light.position, 1.0)).tolist()
            found.append(LocalLight(Constant.LIGHT0 + i, (x, y, z), light.range))
    return found


def _look_of(shot: Shot) -> Look:
    options = shot.view.options
    local = not shot.shadows and any(light.kind != "directional" for light in shot.lights)
    return Look(options.displaySkins, options.displayMaterials, options.displayTextures, local, shot.shadows)


@lru_cache
def _plane_axes(normal: tuple[float, float, float]) -> tuple[tuple[float, ...], ...]:
    """Of a frame on a plane: z along its normal, x along the world's x where possible, y."""
    z: NDArray[Any] = np.array(normal)
    x = np.array((1.0, 0.0, 0.0)) - z[0] * z
    if np.linalg.norm(x) < 1e-6:
        x = np.array((0.0, 1.0, 0.0)) - z[1] * z
    x /= np.linalg.norm(x)
    return tuple(tuple(axis.tolist()) for axis in (x, np.cross(z, x), z))


def _load(gl: Tape, matrix: NDArray[np.float64]) -> None:
    gl.glLoadTransposeMatrixd(matrix)
