"""DepthCamera: a camera that measures distances."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.classic.rendering.camera import Camera
from libgz.simulation.event import Connection, Event

__all__ = ["DepthCamera"]

Floats = NDArray[np.float32]


class DepthCamera(Camera):
    """A camera with depths: the distance ahead, along the camera's axis [m], of each pixel; +inf where nothing is seen.

    Nothing closer than its near clip distance or beyond its far one is seen. Arguments as for `Camera`.
    """

    STATE = ("_depths",)

    def __init__(self, *values: Any, **options: Any) -> None:
        super().__init__(*values, **options)
        self._depths = np.full((self.core.height, self.core.width), np.inf, dtype=np.float32)
        self._new_depths, self._new_cloud = Event("NewDepthFrame"), Event("NewRGBPointCloud")

    def close(self) -> None:
        """Close the camera. Can be called twice."""
        self._new_depths.clear()
        self._new_cloud.clear()
        super().close()

    Fini = close

    def SetImageSize(self, width: int, height: int) -> None:
        """Change the image's size [px]."""
        super().SetImageSize(width, height)
        self._depths = np.full((self.core.height, self.core.width), np.inf, dtype=np.float32)

    def _take_image(self) -> None:
        self.core.Update(self._depths)

    @property
    def depths(self) -> Floats:
        """Depths of the last image [m], shape (height, width), top row first."""
        return self._depths

    def DepthData(self) -> Floats:
        """The same, row after row, shape (height * width,)."""
        return self._depths.ravel()

    GetDepthData = DepthData

    def point_cloud(self) -> Floats:
        """The visible point at each pixel, shape (height, width, 4).

        x to the right, y down, z forward [m], in the camera's frame, +-inf where nothing is seen; then the colour: the
        bits of the float are 0x00RRGGBB.
        """
        height, width = self._depths.shape
        focal = self.core.view.focal
        cloud = np.empty((height, width, 4), dtype=np.float32)
        right = (np.arange(width) + 0.5 - width / 2.0) / focal
        down = (np.arange(height) + 0.5 - height / 2.0) / focal
        seen = np.isfinite(self._depths)
        for k, slope in ((0, np.broadcast_to(right, seen.shape)), (1, np.broadcast_to(down[:, None], seen.shape))):
            cloud[:, :, k] = np.where(seen, slope * np.where(seen, self._depths, 1.0), np.copysign(np.inf, slope))
        cloud[:, :, 2] = self._depths
        colors = self.pixels.astype(np.uint32) @ np.array((65536, 256, 1), dtype=np.uint32)
        cloud[:, :, 3] = colors.astype(np.uint32).view(np.float32)
        return cloud

    def _deliver(self) -> None:
        super()._deliver()
        width, height = self.ImageWidth(), self.ImageHeight()
        if self._new_depths:
            self._new_depths(self.DepthData(), width, height, 1, "FLOAT32")
        if self._new_cloud:
            self._new_cloud(self.point_cloud().ravel(), width, height, 1, "RGBPOINTS")

    def ConnectNewDepthFrame(self, callback: Callable[..., object]) -> Connection:
        """Call ``callback(depths, width, height, 1, "FLOAT32")`` with each image, as long as the result is kept."""
        return self._new_depths.Connect(callback)

    def DisconnectNewDepthFrame(self, connection: Connection) -> None:
        """End a connection."""
        connection.Disconnect()

    def ConnectNewRGBPointCloud(self, callback: Callable[..., object]) -> Connection:
        """Call ``callback(points, width, height, 1, "RGBPOINTS")`` with each image: `point_cloud`, row after row."""
        return self._new_cloud.Connect(callback)

    def DisconnectNewRGBPointCloud(self, connection: Connection) -> None:
        """End a connection."""
        connection.Disconnect()
