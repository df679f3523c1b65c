"""MultiCameraSensor: several cameras that take their images together, such as a stereo pair."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import NotFoundError
from libgz.base.geometry import GzCoordPoseAdd
from libgz.classic import msgs
from libgz.classic.rendering.camera import Camera as CameraView, render_frame
from libgz.classic.sensors.camera_sdf import CameraPlan, image_message
from libgz.classic.sensors.noise import Noise as NoiseModel, new_noise
from libgz.classic.sensors.read import first
from libgz.classic.sensors.sensor import LinkSensor, SensorCategory, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["MultiCameraSensor"]


class MultiCameraSensor(LinkSensor):
    """Takes images with all its cameras at once; each looks along +x of its own pose in the sensor."""

    STATE = ("camera_noises",)

    category: ClassVar[SensorCategory] = SensorCategory.IMAGE
    topic_suffix: ClassVar[str | None] = "images"
    message_type: ClassVar[Any] = msgs.ImagesStamped
    renders: ClassVar[bool] = True

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        elements = list(sdf.named("camera")) or [sdf.child("camera")]  # as in Gazebo, a default one
        self._plans = [CameraPlan(element, self._noise(element, i)) for i, element in enumerate(elements)]
        self._cameras: list[CameraView] = []

    def _noise(self, element: Element, index: int) -> NoiseModel | None:
        noise = first(element, "noise")
        return new_noise(noise, self.world.core.seed, self.ScopedName(), index) if noise is not None else None

    @property
    def cameras(self) -> Sequence[CameraView]:
        """Its cameras, as far as they exist."""
        return self._cameras

    @property
    def camera_noises(self) -> list[NoiseModel]:
        """The noises of its cameras."""
        return [plan.noise for plan in self._plans if plan.noise is not None]

    @property
    def every_noise(self) -> list[NoiseModel]:
        """All that it has of noise, that of its cameras included."""
        return [*super().every_noise, *self.camera_noises]

    def Init(self) -> None:
        """Open all cameras."""
        base = f"{self.ParentName()}::{self.Name()}"
        for i, plan in enumerate(self._plans):
            name = plan.element.Get(str, "name").strip("_") if plan.element.HasAttribute("name") else str(i)
            self._cameras.append(plan.make(self.world, f"{base}::{name}", CameraView))
        self._aim()

    def Fini(self) -> None:
        """Close all cameras."""
        for camera in self._cameras:
            camera.close()
        super().Fini()

    def reset(self) -> None:
        """Start again, because clock and models were reset."""
        for plan in self._plans:
            if plan.noise is not None:
                plan.noise.restart()
        super().reset()

    def _aim(self) -> None:
        frame = self.world_pose()
        for camera, plan in zip(self._cameras, self._plans, strict=True):
            camera.SetWorldPose(GzCoordPoseAdd(plan.pose, frame))

    def ready(self, elapsed: float) -> bool:
        """Whether OpenGL is not switched off."""
        return all(camera.Initialized() for camera in self._cameras)

    def measure(self, elapsed: float) -> None:
        """Take an image with each camera."""
        self._aim()
        render_frame(self.world, self._cameras)

    def message(self) -> Any:
        """The last images as a msgs.ImagesStamped."""
        return self.stamped(image=[image_message(camera) for camera in self._cameras])

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
        """The last image of a camera, top row first."""
        return self.Camera(index).ImageData()

    def SaveFrame(self, filenames: Sequence[str]) -> bool:
        """Write the last images to files, one for each camera; whether that worked."""
        if len(filenames) != len(self._cameras):
            return False
        saved = [camera.SaveFrame(name) for camera, name in zip(self._cameras, filenames, strict=True)]
        return all(saved)

    GetCameraCount, GetCamera = CameraCount, Camera
    GetImageWidth, GetImageHeight, GetImageData = ImageWidth, ImageHeight, ImageData
