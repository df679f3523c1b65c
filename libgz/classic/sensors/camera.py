"""CameraSensor: a camera on a link."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.geometry import GzCoordPoseAdd
from libgz.classic import msgs
from libgz.classic.rendering.camera import Camera as CameraView, render_frame
from libgz.classic.sensors.camera_sdf import WIDEST, CameraPlan, image_message
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.sensor import LinkSensor, SensorCategory, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["CameraSensor"]


class CameraSensor(LinkSensor):
    """Takes images along +x of its pose.

    The camera itself exists once the world has started. Its callbacks get every image, but do not make the sensor
    active.
    """

    category: ClassVar[SensorCategory] = SensorCategory.IMAGE
    topic_suffix: ClassVar[str | None] = "image"
    topic_added = True
    message_type: ClassVar[Any] = msgs.ImageStamped
    renders: ClassVar[bool] = True
    camera_type: ClassVar[type[CameraView]] = CameraView
    measures_depth: ClassVar[bool] = False
    widest: ClassVar[float] = WIDEST  # horizontal field of view [rad]

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        camera = sdf.child("camera")
        self.add_noise(SensorNoiseType.CAMERA_NOISE, camera)
        self._plan = CameraPlan(camera, self.noises.get(SensorNoiseType.CAMERA_NOISE), self.measures_depth, self.widest)
        self._camera: CameraView | None = None

    def Init(self) -> None:
        """Open the camera."""
        name = f"{self.ParentName()}::{self.Name()}"
        self._camera = self._plan.make(self.world, name, self.camera_type)
        self._aim(self._camera)

    def Fini(self) -> None:
        """Close the camera."""
        if self._camera is not None:
            self._camera.close()
        super().Fini()

    def _aim(self, camera: CameraView) -> None:
        in_link = GzCoordPoseAdd(self._plan.pose, self._pose)
        camera.SetWorldPose(GzCoordPoseAdd(in_link, self.link.pose()))

    def ready(self, elapsed: float) -> bool:
        """Whether OpenGL is not switched off."""
        return self.Camera().Initialized()

    def measure(self, elapsed: float) -> None:
        """Take an image."""
        camera = self.Camera()
        self._aim(camera)
        render_frame(self.world, [camera])

    def message(self) -> Any:
        """The last image as a msgs.ImageStamped."""
        return self.stamped(image=image_message(self.Camera()))

    def FillMsg(self, msg: Any) -> None:
        """Describe the sensor and its camera in a msgs.Sensor."""
        super().FillMsg(msg)
        about, camera = msg.camera, self.Camera()
        about.horizontal_fov = float(camera.HFOV())
        about.image_size.x, about.image_size.y = self.ImageWidth(), self.ImageHeight()
        about.image_format = camera.ImageFormat()
        about.near_clip, about.far_clip = camera.NearClip(), camera.FarClip()

    def Camera(self) -> CameraView:
        """The camera."""
        if self._camera is None:
            self.Init()
        return self._camera  # type: ignore[return-value]

    @property
    def cameras(self) -> Sequence[CameraView]:
        """The camera, as far as it exists."""
        return [self._camera] if self._camera is not None else []

    def ImageWidth(self) -> int:
        """[px]."""
        return self._plan.width if self._camera is None else self._camera.ImageWidth()

    def ImageHeight(self) -> int:
        """[px]."""
        return self._plan.height if self._camera is None else self._camera.ImageHeight()

    def ImageData(self) -> bytes:
        """The last image, top row first, in the format of its file."""
        return self.Camera().ImageData()

    def SaveFrame(self, filename: str) -> bool:
        """Write the last image to a file, in the format of its name; whether that worked."""
        return self.Camera().SaveFrame(filename)

    GetCamera, GetImageWidth, GetImageHeight, GetImageData = Camera, ImageWidth, ImageHeight, ImageData
