"""Images of a world: those of its cameras, and that of a free camera at any pose."""

from __future__ import annotations

from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzPose
from libgz.classic.sensors import CameraSensor
from libgz.classic.server import attach
from libgz.front import World
from libgz.interfaces.camera import Camera
from libgz.interfaces.guicam import Guicam
from libgz.interfaces.stereo import Stereo
from libgz.models.camera import eye_of
from libgz.rendering.framing import free_camera

__all__ = ["FreeView", "ImageSource", "camera_sensors", "cameras_of"]

Image: TypeAlias = NDArray[np.uint8]
_EMPTY: Image = np.zeros((0, 0, 3), np.uint8)


class ImageSource(Protocol):
    """A source of images."""

    label: str  # its name in messages

    def image(self) -> Image:
        """The present image, shape (height, width, 3); empty if rendering is disabled."""


class FreeView:
    """A camera at a pose in a world.

    Args:
        world: the world.
        pose: of the camera, which looks along x [m].
        size: of its images: width, height [px].
        shadows: whether they are rendered with shadows, unless an SDF scene forbids them.
    """

    label = "a free camera"

    def __init__(self, world: World, pose: GzPose, size: tuple[int, int] = (640, 480), shadows: bool = False) -> None:
        self._camera = free_camera(world, pose, size, shadows)
        self._camera.options.displayGrid = world.sdf is not None  # as in classic's window

    def image(self) -> Image:
        """The present image, shape (height, width, 3); empty if rendering is disabled."""
        return _EMPTY if self._camera.blind else self._camera.Update()

    def close(self) -> None:
        """Close the camera. Can be called twice."""
        self._camera.close()


class _SensorCamera:
    """A camera sensor of an SDF world."""

    def __init__(self, sensor: CameraSensor, shadows: bool) -> None:
        self._sensor, self.label, self._shadows = sensor, repr(sensor.ScopedName()), shadows

    def image(self) -> Image:
        camera = self._sensor.Camera()
        if self._shadows:
            camera.core.options.shadows = True
        self._sensor.Update(True)
        return _EMPTY if camera.core.blind else camera.pixels


class _ModelCamera:
    """A camera model of a legacy world."""

    def __init__(self, world: World, interface: Camera | Guicam | Stereo, shadows: bool) -> None:
        self._interface, self.label = interface, repr(interface.id)
        self._eye = eye_of(world.model(interface.id)) if shadows else None

    def image(self) -> Image:
        interface = self._interface
        served = interface.left_image if isinstance(interface, Stereo) else interface.image
        return self._eye.shaded() if self._eye is not None and served.size else served


def cameras_of(world: World, shadows: bool = False) -> dict[str, ImageSource]:
    """The cameras of a world, by the ids of their models, or the full names of their sensors in a world of SDF.

    Args:
        world: the world.
        shadows: whether images are rendered again with shadows, unless an SDF scene forbids them; else they are those
            that the cameras serve.
    """
    if world.sdf is None:
        served = world.gz_server.interfaces.values()
        return {i.id: _ModelCamera(world, i, shadows) for i in served if isinstance(i, Camera | Guicam | Stereo)}
    return {sensor.ScopedName(): _SensorCamera(sensor, shadows) for sensor in camera_sensors(world)}


def camera_sensors(world: World) -> list[CameraSensor]:
    """The camera sensors of a world of SDF."""
    manager = attach(world).sensors
    return [s for s in (manager.sensors.values() if manager is not None else ()) if isinstance(s, CameraSensor)]
