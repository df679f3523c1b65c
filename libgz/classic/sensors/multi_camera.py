"""MultiCameraSensor: several cameras that take their pictures together, such as a stereo pair."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.rendering.camera import Camera as CameraView, draw_frame
from libgz.classic.sensors.camera_sdf import CameraPlan, image_message
from libgz.classic.sensors.noise import Noise as NoiseModel, new_noise
from libgz.classic.sensors.read import wrong
from libgz.classic.sensors.sensor import Sensor, SensorCategory
from libgz.errors import NotFoundError
from libgz.geometry import GzCoordPoseAdd, GzPose

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.sdf.element import Element

__all__ = ["MultiCameraSensor"]


class MultiCameraSensor(Sensor):
    """Takes pictures with all its cameras at once; each looks along +x of its own pose in the sensor."""

    category: ClassVar[SensorCategory] = SensorCategory.IMAGE
    topic_suffix: ClassVar[str | None] = "images"
    message_type: ClassVar[str] = "ImagesStamped"
    draws: ClassVar[bool] = True

    def __init__(self, sensors: WorldSensors, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent
        elements = list(sdf.named("camera"))
        if not elements:
            raise wrong(sdf, "sensor", "a multicamera needs at least one <camera>")
        self._plans = [CameraPlan(element) for element in elements]
        self._in_sensor = [element.Get(GzPose, "pose") for element in elements]
        self._camera_noise = [self._noise(element, i) for i, element in enumerate(elements)]
        self._cameras: list[CameraView] = []

    def _noise(self, element: Element, index: int) -> NoiseModel | None:
        noise = next(element.named("noise"), None)
        return new_noise(noise, self.world.core.seed, self.ScopedName(), index) if noise is not None else None

    def Init(self) -> None:
        """Open all eyes."""
        base = f"{self.ParentName()}::{self.Name()}"
        for i, (plan, noise) in enumerate(zip(self._plans, self._camera_noise, strict=True)):
            name = plan.element.Get(str, "name").strip("_") if plan.element.HasAttribute("name") else str(i)
            self._cameras.append(plan.make(self.world, f"{base}::{name}", CameraView, noise))
        self._aim()

    def Fini(self) -> None:
        """Close them."""
        for camera in self._cameras:
            camera.close()
        super().Fini()

    def reset(self) -> None:
        """Clock and models were put back."""
        for noise in self._camera_noise:
            if noise is not None:
                noise.restart()
        super().reset()

    def _aim(self) -> None:
        frame = GzCoordPoseAdd(self._pose, self.link.pose())
        for camera, place in zip(self._cameras, self._in_sensor, strict=True):
            camera.SetWorldPose(GzCoordPoseAdd(place, frame))

    def measure(self, now: float) -> bool:
        """Take a picture with each camera."""
        if not all(camera.Initialized() for camera in self._cameras):
            return False
        self._measured = now
        self._aim()
        draw_frame(self.world, self._cameras)
        if self.listened():
            self.publish(self.images_message())
        return True

    def images_message(self) -> Any:
        """The last pictures as a msgs.ImagesStamped."""
        from libgz.classic import msgs

        msg = self.new_message(image=[image_message(camera) for camera in self._cameras])
        msgs.Set(msg.time, Time(self._measured))
        return msg

    def CameraCount(self) -> int:
        """How many cameras there are."""
        return len(self._plans)

    def Camera(self, index: int) -> CameraView:
        """A camera by number.

        Raises:
            NotFoundError: there is none of this number.
        """
        if not 0 <= index < len(self._cameras):
            raise NotFoundError(f"sensor {self.ScopedName()!r} has {len(self._cameras)} cameras, and no number {index}")
        return self._cameras[index]

    def ImageWidth(self, index: int) -> int:
        """[px]."""
        return self.Camera(index).ImageWidth()

    def ImageHeight(self, index: int) -> int:
        """[px]."""
        return self.Camera(index).ImageHeight()

    def ImageData(self, index: int) -> bytes:
        """The last picture of a camera, top row first."""
        return self.Camera(index).ImageData()

    def SaveFrame(self, filenames: Sequence[str]) -> bool:
        """Write the last pictures to files, one for each camera; whether that worked."""
        if len(filenames) != len(self._cameras):
            return False
        saved = [camera.SaveFrame(name) for camera, name in zip(self._cameras, filenames, strict=True)]
        return all(saved)

    GetCameraCount, GetCamera = CameraCount, Camera
    GetImageWidth, GetImageHeight, GetImageData = ImageWidth, ImageHeight, ImageData
