"""DepthCameraSensor: a camera that measures distances."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.classic.common import Image
from libgz.classic.rendering.camera import Camera
from libgz.classic.rendering.depth_camera import DepthCamera as DepthCameraView
from libgz.classic.sensors.camera import CameraSensor

__all__ = ["DepthCameraSensor"]


class DepthCameraSensor(CameraSensor):
    """Takes images with depths; its topic has the depths [m] as an image of floats."""

    camera_type: ClassVar[type[Camera]] = DepthCameraView
    measures_depth: ClassVar[bool] = True

    def DepthCamera(self) -> DepthCameraView:
        """The camera."""
        return self.Camera()  # type: ignore[return-value]

    def DepthData(self) -> NDArray[np.float32]:
        """Depths of the last image [m], row after row from the top; +inf where nothing is seen."""
        return self.DepthCamera().DepthData()

    GetDepthCamera, GetDepthData = DepthCamera, DepthData

    def message(self) -> Any:
        """The last depths as a msgs.ImageStamped."""
        msg = super().message()
        msg.image.pixel_format = Image.ConvertPixelFormat("FLOAT32")
        msg.image.step = 4 * self.ImageWidth()
        msg.image.data = self.DepthData().astype(np.float32).tobytes()
        return msg
