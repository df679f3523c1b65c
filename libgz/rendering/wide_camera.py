"""WideCamera: images of a lens with a wide angle, such as a fisheye, put together of several plain ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector
from libgz.rendering.camera import LEAST_VIEW, Camera
from libgz.rendering.depth_scan import Face, cover
from libgz.rendering.shot import View

__all__ = ["PROJECTIONS", "Projection", "WideCamera"]

Array = NDArray[np.float64]

FUNCTIONS = ("tan", "sin", "id")
LEAST_PARAMETER = 1e-6
FINEST, COARSEST = 2048.0, 64.0  # [px] per unit of the tangent, of the plain images


@dataclass(frozen=True)
class Projection:
    """How far from the middle of the image a direction is shown: r = c1 f fun(angle / c2 + c3).

    `angle` is that between the direction and the optical axis [rad]; r is in halves of the image's width.
    """

    c1: float = 1.0
    c2: float = 1.0
    c3: float = 0.0
    f: float = 1.0
    fun: str = "tan"

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ParameterError: one is not finite, c1, c2 or f is 0, or there is no such function.
        """
        if self.fun not in FUNCTIONS:
            raise ParameterError(f"a lens has the function {self.fun!r}; it must be one of {', '.join(FUNCTIONS)}")
        numbers = (self.c1, self.c2, self.c3, self.f)
        if not all(map(math.isfinite, numbers)) or min(abs(self.c1), abs(self.c2), abs(self.f)) < LEAST_PARAMETER:
            raise ParameterError(f"a lens has c1, c2, c3 and f of {numbers}; they must be finite, and not 0 but for c3")

    def scaled(self, hfov: float) -> Projection:
        """The same with such an f that a horizontal field of view fills the width [rad].

        Raises:
            ParameterError: it cannot be shown.
        """
        reach = self.c1 * self._apply(0.5 * hfov / self.c2 + self.c3)
        if not (math.isfinite(reach) and reach > LEAST_PARAMETER):
            raise ParameterError(f"a lens cannot show {hfov:g} rad by {self.fun}")
        return Projection(self.c1, self.c2, self.c3, 1.0 / reach, self.fun)

    def radius(self, angle: float) -> float:
        """Where an angle is shown."""
        return self.c1 * self.f * self._apply(angle / self.c2 + self.c3)

    def angles(self, radius: Array) -> Array:
        """The angles that are shown at these distances from the middle; NaN where there is none."""
        given = radius / (self.c1 * self.f)
        with np.errstate(invalid="ignore"):
            inner = np.arctan(given) if self.fun == "tan" else np.arcsin(given) if self.fun == "sin" else given
        found: Array = (inner - self.c3) * self.c2
        return found

    def _apply(self, value: float) -> float:
        return math.tan(value) if self.fun == "tan" else math.sin(value) if self.fun == "sin" else value


PROJECTIONS = {
    "gnomonical": Projection(),
    "stereographic": Projection(c1=2.0, c2=2.0),
    "equidistant": Projection(fun="id"),
    "equisolid_angle": Projection(c1=2.0, c2=2.0, fun="sin"),
    "orthographic": Projection(fun="sin"),
}


class WideCamera(Camera):
    """A camera whose lens shows up to all directions; what is beyond its cutoff angle is black.

    Attributes:
        projection: of its lens.
        scale_to_hfov: whether the field of view fills the width, whatever f is.
        cutoff: largest angle to the optical axis that is shown [rad].
        texture_size: [px] of a plain image of 90 degrees, at least.
    """

    projection = PROJECTIONS["stereographic"]
    scale_to_hfov = True
    cutoff = math.pi / 2.0
    texture_size = 256
    _made_for: tuple[object, ...] = ()
    _faces: tuple[Face, ...] = ()

    def SetFOV(self, hfov: float) -> None:
        """Set the horizontal field of view [rad].

        Raises:
            ParameterError: it is not between 0.01 and 2 pi.
        """
        if not LEAST_VIEW <= hfov <= 2.0 * math.pi:
            raise ParameterError(f"bad field of view {hfov:g} rad; it must be at least {LEAST_VIEW} and at most 2 pi")
        self.hfov = hfov

    @property
    def shown(self) -> Projection:
        """The projection with the f that holds."""
        return self.projection.scaled(self.hfov) if self.scale_to_hfov else self.projection

    def Update(self, depth: NDArray[np.float32] | None = None) -> NDArray[np.uint8]:
        """Render an image of the world as it is now.

        Raises:
            ParameterError: a depth is asked for, which only plain cameras have.
        """
        if depth is not None:
            raise ParameterError("a camera with a wide angle measures no depth")
        self.image[:] = 0
        flat = self.image.reshape(-1, 3)
        for face in self._views():
            placed = GzCoordPoseAdd(GzPose(GzVector(), face.turn), self.pose)
            width, height = face.size
            view = View(placed, width, height, face.hfov, self.near, self.far, self.options)
            plain = np.zeros((height, width, 3), dtype=np.uint8)
            self._shot = self._scene.render(view, plain, None)
            flat[self._pixels[face.which]] = _mixed(plain, face.columns, face.rows)
        return self.image

    def Start(self) -> None:
        """Render an image at once: it takes several plain ones."""
        self.Update()

    def project(self, ahead: float, left: float, up: float) -> tuple[float, float] | None:
        """The pixel of a point in the camera's frame, from the upper left; None if it is not shown."""
        across = math.hypot(left, up)
        angle = math.atan2(across, ahead)
        if angle > self.cutoff:
            return None
        radius = self.shown.radius(angle) * 0.5 * self.width
        share = radius / across if across > 0.0 else 0.0
        return 0.5 * self.width - share * left, 0.5 * self.height - share * up

    def directions(self, columns: Array, rows: Array) -> Array:
        """Unit vectors in the camera's frame that are shown at places of the image [px], NaN where there are none."""
        right, down = (2.0 * columns - self.width) / self.width, (2.0 * rows - self.height) / self.width
        radius = np.hypot(right, down)
        angle = self.shown.angles(radius)
        angle = np.where((angle >= 0.0) & (angle <= min(self.cutoff, math.pi)), angle, np.nan)
        share = np.sin(angle) / np.maximum(radius, 1e-12)
        return np.stack([np.cos(angle), -right * share, -down * share], axis=-1)

    def _views(self) -> tuple[Face, ...]:
        """The plain images of which it is put together."""
        key = (self.width, self.height, self.hfov, self.projection, self.scale_to_hfov, self.cutoff, self.texture_size)
        if key != self._made_for:
            column, row = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
            found = self.directions(column.ravel(), row.ravel())
            self._pixels = np.flatnonzero(np.isfinite(found[:, 0]))
            focal = max(0.5 * self.texture_size, self.width / self.hfov)
            self._faces = tuple(cover(found[self._pixels], min(max(focal, COARSEST), FINEST)))
            self._made_for = key
        return self._faces


def _mixed(plain: NDArray[np.uint8], columns: Array, rows: Array) -> NDArray[np.uint8]:
    """Colours between the pixels of an image."""
    height, width = plain.shape[:2]
    left = np.clip(np.floor(columns).astype(np.int64), 0, width - 2)
    top = np.clip(np.floor(rows).astype(np.int64), 0, height - 2)
    x, y = (columns - left)[:, None], (rows - top)[:, None]
    upper = plain[top, left] * (1.0 - x) + plain[top, left + 1] * x
    lower = plain[top + 1, left] * (1.0 - x) + plain[top + 1, left + 1] * x
    return np.clip(np.rint(upper * (1.0 - y) + lower * y), 0.0, 255.0).astype(np.uint8)
