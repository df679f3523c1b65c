"""DepthScan: ranges along many directions, read from rendered depths."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.closing import Closing
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuatern, GzQuaternFromEuler, GzVector, rotate
from libgz.rendering.camera import LEAST_NEAR, LONGEST_SIDE
from libgz.rendering.scene import Scene, SceneWorld
from libgz.rendering.shot import RenderOptions, View

__all__ = ["DepthScan", "Face", "cover"]

Array = NDArray[np.float64]

STEEP = math.radians(50.0)  # directions above or below this are seen by faces that look up or down
WIDEST = math.radians(90.0)  # of a face
FINEST, COARSEST = 2048.0, 64.0  # [px] per unit of the tangent
SAME = 0.05  # of inverse depths of neighbouring pixels, up to which they are one surface
MARGIN = 2  # [px] around the outermost directions


@dataclass(frozen=True)
class Face:
    """A view that some of the directions are read from.

    Attributes:
        turn: of the view in the frame of the scan.
        which: numbers of its directions.
        columns, rows: where these cross the image [px]; pixel 0 has its centre at 0.
        stretch: ranges by depths.
        size: of the image [px].
        focal: [px].
    """

    turn: GzQuatern
    which: NDArray[np.int64]
    columns: Array
    rows: Array
    stretch: Array
    size: tuple[int, int]
    focal: float

    @property
    def hfov(self) -> float:
        """Its horizontal field of view [rad]."""
        return 2.0 * math.atan(self.size[0] / (2.0 * self.focal))


class DepthScan(Closing):
    """Looks from one place along many directions, and sees what images show: visuals, skins and grounds.

    Directions are covered by a few images; on a surface, the range of a direction is interpolated between pixels, where
    inverse depths are linear, so that planes are measured exactly. At an edge it is that of the nearest pixel, which is
    at most half as wide as the directions are apart, and 1/2048 rad at least.

    Args:
        world: the World; see `Camera`.
        directions: unit vectors in the frame of the scan, shape (n, 3).
        spacing: angle between neighbouring directions [rad].
        near, far: what is nearer or farther along the axis of an image is not seen [m].

    Raises:
        LibraryError: the chosen OpenGL does not work here.
    """

    def __init__(self, world: SceneWorld, directions: ArrayLike, spacing: float, near: float, far: float) -> None:
        self._directions = np.array(directions, dtype=np.float64).reshape(-1, 3)
        self._near, self._far = max(near, LEAST_NEAR), far
        self._options = RenderOptions(displayMaterials=False, displayTextures=False)
        focal = min(max(2.0 / max(spacing, 1e-6), COARSEST), FINEST)
        self._faces = list(cover(self._directions, focal))
        self._closed = False
        self._scene = world.extension(Scene)
        self._scene.join()

    @property
    def blind(self) -> bool:
        """Whether OpenGL is switched off, so that nothing is seen."""
        return self._scene.blind

    def ranges(self, pose: GzPose) -> Array:
        """The range along each direction from a global pose [m]; infinite where nothing is seen."""
        found = np.full(len(self._directions), np.inf)
        for face in self._faces:
            placed = GzCoordPoseAdd(GzPose(GzVector(), face.turn), pose)
            view = View(placed, *face.size, face.hfov, self._near, self._far, self._options)
            depth = self._scene.depth(self._scene.capture(view))
            found[face.which] = _sampled(depth, face.columns, face.rows) * face.stretch
        return found

    def close(self) -> None:
        """Release the scene. Can be called twice."""
        if not self._closed:
            self._closed = True
            self._scene.leave()


def cover(directions: Array, focal: float) -> list[Face]:
    """The views that cover all directions, unit vectors of shape (n, 3); `focal` [px] is that of each, or less."""
    steep = np.abs(directions[:, 2]) > math.sin(STEEP)
    found = []
    for up in (False, True):
        which = np.flatnonzero(steep & ((directions[:, 2] > 0.0) == up))
        if len(which):
            found.append(
                _face(directions, which, GzQuaternFromEuler(0.0, -math.pi / 2 if up else math.pi / 2, 0.0), focal)
            )
    level = np.flatnonzero(~steep)
    if not len(level):
        return found
    yaws = np.arctan2(directions[level, 1], directions[level, 0])
    # The widest gap between neighbouring yaws is where the views begin.
    order = np.sort(yaws)
    gaps = np.diff(np.append(order, order[0] + 2.0 * np.pi))
    start = order[(int(np.argmax(gaps)) + 1) % len(order)]
    along = np.mod(yaws - start + 1e-9, 2.0 * np.pi)
    count = max(1, math.ceil(float(along.max()) / WIDEST))
    width = max(float(along.max()) / count, 1e-6)
    sectors = np.minimum((along / width).astype(np.int64), count - 1)
    for sector in range(count):
        which = level[sectors == sector]
        if len(which):
            found.append(_face(directions, which, GzQuaternFromEuler(0.0, 0.0, start + (sector + 0.5) * width), focal))
    return found


def _face(directions: Array, which: NDArray[np.int64], turn: GzQuatern, focal: float) -> Face:
    axes = np.array([tuple(rotate(turn, axis)) for axis in np.eye(3)])  # rows: ahead, left, up
    local = directions[which] @ axes.T
    right, down = -local[:, 1] / local[:, 0], -local[:, 2] / local[:, 0]
    reach = max(float(np.abs(right).max()), float(np.abs(down).max()))
    focal = min(focal, (LONGEST_SIDE / 4 - MARGIN) / max(reach, 1e-6))
    width, height = (2 * (math.ceil(float(np.abs(side).max()) * focal) + MARGIN) for side in (right, down))
    return Face(
        turn,
        which,
        right * focal + 0.5 * width - 0.5,
        down * focal + 0.5 * height - 0.5,
        np.sqrt(1.0 + right**2 + down**2),
        (width, height),
        focal,
    )


def _sampled(depth: NDArray[np.float32], columns: Array, rows: Array) -> Array:
    """Depths between pixels: on one surface their inverses are linear, else the nearest pixel counts."""
    inverse = 1.0 / depth.astype(np.float64)  # 0 for infinite ones
    left, top = np.floor(columns).astype(np.int64), np.floor(rows).astype(np.int64)
    x, y = columns - left, rows - top
    corners = np.stack([inverse[top, left], inverse[top, left + 1], inverse[top + 1, left], inverse[top + 1, left + 1]])
    mixed = (corners * np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y])).sum(axis=0)
    one = np.ptp(corners, axis=0) <= SAME * corners.max(axis=0)
    nearest = inverse[np.rint(rows).astype(np.int64), np.rint(columns).astype(np.int64)]
    value = np.where(one, mixed, nearest)
    with np.errstate(divide="ignore"):
        found: Array = 1.0 / value
    return found
