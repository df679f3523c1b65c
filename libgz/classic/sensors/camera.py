"""CameraSensor: a camera on a link."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.rendering.camera import Camera as CameraView, draw_frame
from libgz.classic.sensors.camera_sdf import CameraPlan, image_message
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.sensor import Sensor, SensorCategory
from libgz.geometry import GzCoordPoseAdd, GzPose

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.sdf.element import Element

__all__ = ["CameraSensor"]


class CameraSensor(Sensor):
    """Takes pictures along +x of its pose.

    The camera itself is there when the world has begun; its callbacks get every picture, but do not make the sensor
    active.
    """

    category: ClassVar[SensorCategory] = SensorCategory.IMAGE
    topic_suffix: ClassVar[str | None] = "image"
    message_type: ClassVar[str] = "ImageStamped"
    draws: ClassVar[bool] = True
    camera_type: ClassVar[type[CameraView]] = CameraView
    measures_depth: ClassVar[bool] = False

    def __init__(self, sensors: WorldSensors, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent
        camera = sdf.child("camera")
        self._plan = CameraPlan(camera, self.measures_depth)
        self._in_sensor = camera.Get(GzPose, "pose")
        self.add_noise(SensorNoiseType.CAMERA_NOISE, camera)
        self._camera: CameraView | None = None

    def Init(self) -> None:
        """Open the camera's eye."""
        noise = self.noises.get(SensorNoiseType.CAMERA_NOISE)
        name = f"{self.ParentName()}::{self.Name()}"
        self._camera = self._plan.make(self.world, name, self.camera_type, noise)
        self._aim(self._camera)

    def Fini(self) -> None:
        """Close it."""
        if self._camera is not None:
            self._camera.close()
        super().Fini()

    def _aim(self, camera: CameraView) -> None:
        in_link = GzCoordPoseAdd(self._in_sensor, self._pose)
        camera.SetWorldPose(GzCoordPoseAdd(in_link, self.link.pose()))

    def measure(self, now: float) -> bool:
        """Take a picture."""
        camera = self.Camera()
        if not camera.Initialized():
            return False
        self._measured = now
        self._aim(camera)
        draw_frame(self.world, [camera])
        if self.listened():
            self.publish(self.image_message())
        return True

    def image_message(self) -> Any:
        """The last picture as a msgs.ImageStamped."""
        from libgz.classic import msgs

        msg = self.new_message(image=image_message(self.Camera()))
        msgs.Set(msg.time, Time(self._measured))
        return msg

    def Camera(self) -> CameraView:
        """The camera."""
        if self._camera is None:
            self.Init()
        return self._camera  # type: ignore[return-value]

    def ImageWidth(self) -> int:
        """[px]."""
        return self._plan.width if self._camera is None else self._camera.ImageWidth()

    def ImageHeight(self) -> int:
        """[px]."""
        return self._plan.height if self._camera is None else self._camera.ImageHeight()

    def ImageData(self) -> bytes:
        """The last picture, top row first, in the format of its file."""
        return self.Camera().ImageData()

    def SaveFrame(self, filename: str) -> bool:
        """Write the last picture to a file, in the format of its name; whether that worked."""
        return self.Camera().SaveFrame(filename)

    GetCamera, GetImageWidth, GetImageHeight, GetImageData = Camera, ImageWidth, ImageHeight, ImageData
