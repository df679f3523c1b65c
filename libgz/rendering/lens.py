"""Lens: what a camera's lens does to its image, as a map from the image to a plain one that is rendered."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError

__all__ = ["Distortion", "Intrinsics", "Lens"]

Array = NDArray[np.float64]

WIDEST = math.radians(160.0)  # of the plain image; what is outside of it stays black
LARGEST = 4096  # [px] a side of the plain image
LEAST_SHOWN = 1e-7  # share of an image to which a distortion may shrink it, to be stretched again
ROUNDS = 20  # of the search for the place that a distorted one comes from


class Intrinsics(NamedTuple):
    """The pinhole of a camera: focal lengths [px], principal point [px] from the upper left corner, and skew [px]."""

    fx: float
    fy: float
    cx: float
    cy: float
    s: float = 0.0


class Distortion(NamedTuple):
    """Radial and tangential distortion (Brown, 1966) about a centre, in shares of the image's sides, as in Gazebo 11.

    What a plain image shows at (x, y) from the centre, x in shares of its width and y of its height, with
    r^2 = x^2 + y^2, is shown at x (1 + k1 r^2 + k2 r^4 + k3 r^6) + p2 (r^2 + 2 x^2) + 2 p1 x y, and likewise for y with
    p1 and p2 exchanged. If k1 is below 0, the image is then stretched about its middle until the distorted corners
    (0, 0) and (1, 1) are as far from each other as its own.
    """

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    center: tuple[float, float] = (0.5, 0.5)

    def __bool__(self) -> bool:
        return any((self.k1, self.k2, self.k3, self.p1, self.p2))

    def forward(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Where points of a plain image are shown, all of them from the centre."""
        square = x * x + y * y
        radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
        return (
            x * radial + self.p2 * (square + 2.0 * x * x) + 2.0 * self.p1 * x * y,
            y * radial + self.p1 * (square + 2.0 * y * y) + 2.0 * self.p2 * x * y,
        )

    def backward(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The points that are shown at these places, by fixed-point iteration."""
        u, v = x.copy(), y.copy()
        for _ in range(ROUNDS):
            shown = self.forward(u, v)
            u, v = u + 0.8 * (x - shown[0]), v + 0.8 * (y - shown[1])
        lost = np.hypot(self.forward(u, v)[0] - x, self.forward(u, v)[1] - y) > 1e-3
        return np.where(lost, np.nan, u), np.where(lost, np.nan, v)

    @property
    def stretch(self) -> tuple[float, float]:
        """By how much the image is stretched, so that barrel distortion leaves no black border."""
        if self.k1 >= 0.0:
            return 1.0, 1.0
        near, far = (self.forward(*(np.array([end - middle]) for middle in self.center)) for end in (0.0, 1.0))
        width, height = (float(b[0] - a[0]) for a, b in zip(near, far, strict=True))
        return (1.0 / width, 1.0 / height) if min(width, height) > LEAST_SHOWN else (1.0, 1.0)


class Lens:
    """Turns a plain image, with square pixels and its axis in the middle, into that of a camera.

    Args:
        width, height: of the image [px].
        hfov: horizontal field of view without intrinsics [rad].
        intrinsics: the pinhole; None for a plain one.
        distortion: of the lens. As in Gazebo, what barrel distortion (k1 below 0) leaves empty is cropped.

    Attributes:
        width, height, hfov: of the plain image [px, rad].

    Raises:
        ParameterError: a number is not finite, or a focal length not above zero.
    """

    def __init__(
        self, width: int, height: int, hfov: float, intrinsics: Intrinsics | None, distortion: Distortion | None
    ) -> None:
        focal = width / (2.0 * math.tan(0.5 * hfov))
        pinhole = intrinsics or Intrinsics(focal, focal, 0.5 * width, 0.5 * height)
        numbers = (pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy, pinhole.s)
        if not all(map(math.isfinite, numbers)) or min(pinhole.fx, pinhole.fy) <= 0.0:
            raise ParameterError(f"intrinsics are {numbers}; they must be finite, and focal lengths above zero")
        column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        if distortion:
            column, row = _undistorted(column, row, (width, height), distortion)
        down = (row - pinhole.cy) / pinhole.fy
        right = (column - pinhole.cx - pinhole.s * down) / pinhole.fx
        most = math.tan(0.5 * WIDEST)
        known = (np.abs(right) <= most) & (np.abs(down) <= most)
        reach = [max(float(np.abs(side[known]).max(initial=0.0)), 1e-3) for side in (right, down)]
        focal = min(max(pinhole.fx, pinhole.fy), (LARGEST // 2 - 2) / max(reach))
        self.width, self.height = (2 * (math.ceil(side * focal) + 1) for side in reach)
        self.hfov = 2.0 * math.atan(self.width / (2.0 * focal))
        self._columns = np.where(known, right * focal + 0.5 * self.width - 0.5, 0.0)
        self._rows = np.where(known, down * focal + 0.5 * self.height - 0.5, 0.0)
        self._known = known

    def image(self, plain: NDArray[np.uint8], out: NDArray[np.uint8]) -> None:
        """Write the image that a plain one becomes; colours between pixels are mixed."""
        left = np.clip(np.floor(self._columns).astype(np.int64), 0, self.width - 2)
        top = np.clip(np.floor(self._rows).astype(np.int64), 0, self.height - 2)
        x, y = (self._columns - left)[..., None], (self._rows - top)[..., None]
        upper = plain[top, left] * (1.0 - x) + plain[top, left + 1] * x
        lower = plain[top + 1, left] * (1.0 - x) + plain[top + 1, left + 1] * x
        out[:] = np.where(self._known[..., None], np.rint(upper * (1.0 - y) + lower * y), 0.0)

    def nearest(self, plain: NDArray[np.generic], empty: float) -> NDArray[np.generic]:
        """What stands at each pixel: that of the nearest pixel of a plain array, shape (height, width)."""
        columns = np.clip(np.rint(self._columns).astype(np.int64), 0, self.width - 1)
        rows = np.clip(np.rint(self._rows).astype(np.int64), 0, self.height - 1)
        found = plain[rows, columns]
        found[~self._known] = empty
        return found


def _undistorted(column: Array, row: Array, size: tuple[int, int], distortion: Distortion) -> tuple[Array, Array]:
    """Where the pixels of an image are without the distortion [px]."""
    x, y = (
        (value / side - 0.5) / stretch + 0.5 - middle
        for value, side, stretch, middle in zip((column, row), size, distortion.stretch, distortion.center, strict=True)
    )
    x, y = distortion.backward(x, y)
    width, height = size
    return (x + distortion.center[0]) * width, (y + distortion.center[1]) * height
