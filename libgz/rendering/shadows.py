"""Shadow maps: depth as a light sees it, in textures. One sun and one lamp have two each: for what is near, for all.

A lamp is a spot, or, where no spot casts shadows, a point light, whose map covers what the camera sees.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError
from libgz.rendering.gl import Constant
from libgz.rendering.library import Table
from libgz.rendering.selection import LARGE, SMALL
from libgz.rendering.shot import Light, Shot, View, pose_matrices
from libgz.rendering.submission import Submitter
from libgz.rendering.tape import Tape

__all__ = ["FIRST_UNIT", "MAPS", "SIZE", "Balls", "Fit", "ShadowMaps", "lamp_fits", "pick", "sun_fits"]

MAPS = ("sun_near", "sun_far", "lamp_near", "lamp_far")
FIRST_UNIT = 1  # of the maps' texture units; unit 0 is the texture of the materials
SIZE = 2048  # [texels] of a side of a map
LEAST_SIDE = 6.0  # [m] covered by a map: edges of shadows are some 12 mm wide at least
SPLIT = 8.0  # [m] how far from the camera the near maps reach
MARGIN = 1.02  # of a map around what it has to cover
AROUND = 3.0  # [m] how far outside of the image a body may be for which a point light's map is aimed
WIDEST = math.radians(72.0)  # half of the angle that a lamp's map covers at most
FINE = 40.0  # [texels] radius above which a body is rendered in detail
NEAREST = 0.05  # [m] what is nearer to a lamp casts no shadow

Array = NDArray[np.float64]


class Balls(NamedTuple):
    """Balls that contain one item each: centres, shape (n, 3), and radii [m]; and which of the items cast shadows."""

    centres: Array
    radii: Array
    cast: NDArray[np.bool_]

    @classmethod
    def of(cls, shot: Shot, table: Table) -> Balls:
        """Those of a shot's items."""
        poses = pose_matrices(shot.states)
        centres = np.einsum("nij,nj->ni", poses[:, :3, :3], table.middles) + poses[:, :3, 3]
        cast = np.array([item.casts for item in shot.content.items], dtype=bool)
        return cls(centres, table.spreads, cast & (table.radii > 0.0))


class Fit(NamedTuple):
    """How a map is rendered: from the world into its clip coordinates, shape (4, 4); what is in it; its texels.

    Attributes:
        matrix: of the map; y points down, as in images, so that faces keep their sense.
        casters: the places of the items that are rendered into it.
        texel: the size of a texel where w is 1 [m].
    """

    matrix: Array
    casters: NDArray[np.int64]
    texel: float


def pick(lights: tuple[Light, ...]) -> tuple[int | None, int | None]:
    """The places of the sun and of the lamp that cast shadows: the brightest ones; None if there is none."""

    def brightest(kind: str) -> int | None:
        found = [i for i, light in enumerate(lights) if light.shadows and light.kind == kind]
        return max(found, key=lambda i: sum(tuple(lights[i].diffuse)[:3]), default=None)

    lamp = brightest("spot")
    return brightest("directional"), brightest("point") if lamp is None else lamp


def _axes(back: Array) -> Array:
    """Rows right, up and back of a frame that looks against `back`, shape (3, 3)."""
    up = np.array((0.0, 0.0, 1.0) if abs(back[2]) < 0.99 * float(np.linalg.norm(back)) else (0.0, 1.0, 0.0))
    back = back / np.linalg.norm(back)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    return np.array((right, np.cross(back, right), back))


def _corners(view: View, near: float, far: float) -> Array:
    """The corners of what a view sees between two distances [m], shape (8, 3)."""
    x, y = view.width / (2.0 * view.focal), view.height / (2.0 * view.focal)
    rays = np.array([(sx * x, sy * y, -1.0) for sx in (-1.0, 1.0) for sy in (-1.0, 1.0)])
    points = np.concatenate((near * rays, far * rays))
    eye = view.eye()
    return np.asarray((points - eye[:3, 3]) @ eye[:3, :3])


class Window(NamedTuple):
    """What a light sees through a window: the low and the high corner of each ball and of the window, shape (..., 2).

    A sun's are metres across its light, a lamp's tangents of angles from its axis.
    """

    low: Array
    high: Array

    def of(self, rows: NDArray[Any]) -> Window:
        """The window around some of the balls."""
        return Window(self.low[rows].min(axis=0), self.high[rows].max(axis=0))

    def overlap(self, other: Window) -> NDArray[np.bool_]:
        """Which balls another window shows."""
        return np.asarray((self.high >= other.low).all(axis=-1) & (self.low <= other.high).all(axis=-1))

    def cut(self, other: Window) -> Window:
        """What is in both."""
        return Window(np.maximum(self.low, other.low), np.minimum(self.high, other.high))

    def steady(self, least: float) -> tuple[Array, float]:
        """The middle and the side of a square that contains it; `least`: of the side.

        Steps in size and place keep the edges of shadows still while the camera moves.
        """
        side = max(MARGIN * float((self.high - self.low).max()), least)
        side = 2.0 ** (math.ceil(4.0 * math.log2(side)) / 4.0)
        return np.round((self.low + self.high) / 2.0 * SIZE / side) * side / SIZE, side


def sun_fits(view: View, light: Light, balls: Balls) -> list[Fit | None]:
    """The near and the far map of a sun; None for one that is not needed."""
    axes = _axes(-np.array(light.direction))
    centres = balls.centres @ axes.T
    shown = Window(centres[:, :2] - balls.radii[:, None], centres[:, :2] + balls.radii[:, None])

    def fit(near: float, far: float) -> tuple[float, Fit] | None:
        corners = (_corners(view, near, far) @ axes.T)[:, :2]
        image = Window(corners.min(axis=0), corners.max(axis=0))
        inside = balls.cast & shown.overlap(image)
        if not inside.any():
            return None
        middle, side = image.cut(shown.of(inside)).steady(LEAST_SIDE)
        front = float((centres[inside, 2] + balls.radii[inside]).max())
        back = float((centres[inside, 2] - balls.radii[inside]).min())
        into = np.eye(4)
        into[0, :3], into[1, :3] = axes[0] * 2.0 / side, axes[1] * -2.0 / side
        into[2, :3], into[2, 3] = axes[2] * -2.0 / (front - back), (front + back) / (front - back)
        into[:2, 3] = -middle[0] * 2.0 / side, middle[1] * 2.0 / side
        return side, Fit(into, np.flatnonzero(inside), side / SIZE)

    return _near_and_far(view, fit)


def lamp_fits(view: View, light: Light, balls: Balls) -> list[Fit | None]:
    """The near and the far map of a spot or a point light; None for one that is not needed."""
    place = np.array(light.position)
    offsets = balls.centres - place
    distances = np.linalg.norm(offsets, axis=1)
    lit = balls.cast & (distances - balls.radii <= light.range)
    if light.kind == "spot":
        aim, limit = np.array(light.direction), min(light.spot[1] / 2.0, WIDEST)
    else:
        seen = lit & _in_view(view, balls)
        outside = seen & (distances > balls.radii)
        aimed = outside if outside.any() else seen
        if not seen.any():
            return [None, None]
        low = (offsets - balls.radii[:, None])[aimed].min(axis=0)
        aim, limit = (low + (offsets + balls.radii[:, None])[aimed].max(axis=0)) / 2.0, WIDEST
    if float(np.linalg.norm(aim)) < 1e-9:
        aim = np.array((0.0, 0.0, -1.0))
    axes = _axes(-aim)
    whole = Window(np.full(2, -math.tan(limit)), np.full(2, math.tan(limit)))
    centres = offsets @ axes.T
    along = -centres[:, 2]
    angles = np.arctan2(centres[:, :2], along[:, None])
    sizes = np.hypot(centres[:, :2], along[:, None])
    widths = np.where(sizes > balls.radii[:, None], np.arcsin(np.minimum(balls.radii[:, None] / sizes, 1.0)), math.pi)
    shown = Window(np.tan(np.clip(angles - widths, -WIDEST, WIDEST)), np.tan(np.clip(angles + widths, -WIDEST, WIDEST)))

    def fit(near: float, far: float) -> tuple[float, Fit] | None:
        corners = (_corners(view, near, far) - place) @ axes.T
        image = whole
        if (corners[:, 2] < -NEAREST).all():
            slopes = corners[:, :2] / -corners[:, 2:]
            image = whole.cut(Window(slopes.min(axis=0), slopes.max(axis=0)))
        inside = lit & shown.overlap(image) & (along + balls.radii > NEAREST)
        if not inside.any() or (image.high <= image.low).any():
            return None
        start = max(float((along - balls.radii)[inside].min()), NEAREST)
        end = max(float((along + balls.radii)[inside].max()), 2.0 * start)
        middle, side = image.cut(shown.of(inside)).steady(LEAST_SIDE / end)
        into, lens = np.eye(4), np.zeros((4, 4))
        into[:3, :3], into[:3, 3] = axes, -axes @ place
        lens[0, 0], lens[1, 1], lens[3, 2] = 2.0 / side, -2.0 / side, -1.0
        lens[0, 2], lens[1, 2] = middle[0] * 2.0 / side, -middle[1] * 2.0 / side
        lens[2, 2], lens[2, 3] = -(end + start) / (end - start), -2.0 * end * start / (end - start)
        return side, Fit(lens @ into, np.flatnonzero(inside), side / SIZE)

    return _near_and_far(view, fit)


def _near_and_far(view: View, fit: Callable[[float, float], tuple[float, Fit] | None]) -> list[Fit | None]:
    """The maps for what is near and for all, or only the latter if it is no coarser.

    A point outside of the shadows of all balls is lit. So a map covers what is both in the image and behind a ball.
    """
    whole = fit(view.near, view.far)
    close = fit(view.near, SPLIT) if view.near < SPLIT < view.far else None
    if whole is None or close is None or close[0] >= whole[0]:
        return [whole[1] if whole is not None else None, None]
    return [close[1], whole[1]]


def _in_view(view: View, balls: Balls) -> NDArray[np.bool_]:
    """Which balls are in the image, or not far outside of it."""
    eye = view.eye()
    x, y, z = (balls.centres @ eye[:3, :3].T + eye[:3, 3]).T
    reach = balls.radii + AROUND
    tx, ty = view.width / (2.0 * view.focal), view.height / (2.0 * view.focal)
    seen = (reach - z >= view.near) & (-z - reach <= view.far)
    seen &= np.abs(x) + tx * z <= reach * math.hypot(1.0, tx)
    return np.asarray(seen & (np.abs(y) + ty * z <= reach * math.hypot(1.0, ty)))


class ShadowMaps:
    """The textures of the maps, and how they are rendered."""

    def __init__(self, gl: Tape, submitter: Submitter) -> None:
        self.gl, self._submitter = gl, submitter
        self._targets: dict[int, tuple[int, int]] = {}  # of each map: framebuffer, texture

    def render(self, shot: Shot, table: Table) -> tuple[tuple[int | None, int | None], list[Fit | None]]:
        """Render the maps of a shot: the places of its sun and its lamp, and the maps, in the order of `MAPS`.

        Args:
            shot: what to render.
            table: the plain lists of its items.
        """
        sun, lamp = pick(shot.lights)
        balls = Balls.of(shot, table)
        fits: list[Fit | None] = []
        for place, fitted in ((sun, sun_fits), (lamp, lamp_fits)):
            fits += [None, None] if place is None else fitted(shot.view, shot.lights[place], balls)
        for i, fit in enumerate(fits):
            if fit is not None:
                self._render(i, fit, shot, table, balls)
        return (sun, lamp), fits

    def _render(self, i: int, fit: Fit, shot: Shot, table: Table, balls: Balls) -> None:
        gl = self.gl
        gl.glBindFramebuffer(Constant.FRAMEBUFFER, self._target(i))
        gl.glViewport(0, 0, SIZE, SIZE)
        gl.glClear(Constant.DEPTH_BUFFER_BIT)
        gl.glMatrixMode(Constant.PROJECTION)
        gl.glLoadIdentity()
        gl.glMatrixMode(Constant.MODELVIEW)
        gl.glEnable(Constant.POLYGON_OFFSET_FILL)
        gl.glPolygonOffset(1.5, 4.0)
        poses = pose_matrices(shot.states[fit.casters])
        matrices = np.ascontiguousarray((fit.matrix @ poses).transpose(0, 2, 1))
        away = balls.centres[fit.casters] @ fit.matrix[3, :3] + fit.matrix[3, 3]
        fine = balls.radii[fit.casters] > FINE * fit.texel * np.maximum(away, NEAREST)
        lists = table.lists(fit.casters, np.where(fine, LARGE, SMALL))
        self._submitter.submit(matrices, np.arange(len(lists)), lists)
        gl.glDisable(Constant.POLYGON_OFFSET_FILL)

    def _target(self, i: int) -> int:
        """The framebuffer of a map; its texture stays bound to the map's unit."""
        if i in self._targets:
            return self._targets[i][0]
        gl, kind = self.gl, Constant.TEXTURE_2D
        texture, frame = ctypes.c_uint(), ctypes.c_uint()
        gl.glActiveTexture(Constant.TEXTURE0 + FIRST_UNIT + i)
        gl.glGenTextures(1, ctypes.byref(texture))
        gl.glBindTexture(kind, texture.value)
        for name, value in (
            (Constant.TEXTURE_WRAP_S, Constant.CLAMP_TO_EDGE),
            (Constant.TEXTURE_WRAP_T, Constant.CLAMP_TO_EDGE),
            (Constant.TEXTURE_MIN_FILTER, Constant.LINEAR),
            (Constant.TEXTURE_MAG_FILTER, Constant.LINEAR),
            (Constant.TEXTURE_COMPARE_MODE, Constant.COMPARE_R_TO_TEXTURE),
            (Constant.TEXTURE_COMPARE_FUNC, Constant.LEQUAL),
        ):
            gl.glTexParameteri(kind, name, value)
        depth = Constant.DEPTH_COMPONENT
        gl.glTexImage2D(kind, 0, Constant.DEPTH_COMPONENT24, SIZE, SIZE, 0, depth, Constant.UNSIGNED_INT, None)
        gl.glActiveTexture(Constant.TEXTURE0)
        gl.glGenFramebuffers(1, ctypes.byref(frame))
        gl.glBindFramebuffer(Constant.FRAMEBUFFER, frame.value)
        gl.glFramebufferTexture2D(Constant.FRAMEBUFFER, Constant.DEPTH_ATTACHMENT, kind, texture.value, 0)
        gl.glDrawBuffer(Constant.NONE)
        gl.glReadBuffer(Constant.NONE)
        if gl.glCheckFramebufferStatus(Constant.FRAMEBUFFER) != Constant.FRAMEBUFFER_COMPLETE:
            raise LibraryError(f"this OpenGL cannot render shadow maps of {SIZE} x {SIZE} texels")
        self._targets[i] = (int(frame.value), int(texture.value))
        return int(frame.value)
