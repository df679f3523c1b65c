"""Sensor plugins to derive from: each switches its sensor on and calls a function with every measurement.

A plugin of one's own says what to do::

    from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN
    from libgz.classic.plugins.hooks import RayPlugin

    class Nearest(RayPlugin):
        def OnNewLaserScans(self):
            print(min(self.sensor.Ranges()))

    GZ_REGISTER_SENSOR_PLUGIN(Nearest)

The ready plugins libCameraPlugin.so, libRayPlugin.so and so on are these as they stand: they switch the sensor on, so
that it measures and publishes, and do nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import SensorPlugin

if TYPE_CHECKING:
    from libgz.sdf.element import Element

__all__ = [
    "CameraPlugin",
    "ContactPlugin",
    "DepthCameraPlugin",
    "ForceTorquePlugin",
    "GpuRayPlugin",
    "ImuSensorPlugin",
    "RayPlugin",
    "SonarPlugin",
]


class _Hook(SensorPlugin):
    """Keeps the sensor as `sensor`, and switches it on."""

    sensor: Any

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Connect, and switch the sensor on."""
        self.sensor = sensor
        self.connections = self.connect()
        sensor.SetActive(True)

    def connect(self) -> list[Any]:
        """Connections to the sensor's events."""
        raise NotImplementedError


class CameraPlugin(_Hook):
    """Of a camera."""

    def connect(self) -> list[Any]:
        """To pictures."""
        self.camera = self.sensor.Camera()
        return [self.camera.ConnectNewImageFrame(self.OnNewFrame)]

    def OnNewFrame(self, data: bytes, width: int, height: int, depth: int, image_format: str) -> None:
        """A picture: `depth` bytes a pixel, `width` times `height` of them [px], top row first."""


class DepthCameraPlugin(_Hook):
    """Of a depth camera."""

    def connect(self) -> list[Any]:
        """To depths and pictures."""
        self.camera = self.sensor.DepthCamera()
        return [
            self.camera.ConnectNewDepthFrame(self.OnNewDepthFrame),
            self.camera.ConnectNewImageFrame(self.OnNewImageFrame),
        ]

    def OnNewDepthFrame(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """Depths [m], `width` times `height` of them, top row first."""

    def OnNewImageFrame(self, data: bytes, width: int, height: int, depth: int, image_format: str) -> None:
        """The picture that belongs to them."""


class RayPlugin(_Hook):
    """Of a ray sensor; `sensor.Ranges()` has the ranges."""

    def connect(self) -> list[Any]:
        """To scans that the sensor has taken over."""
        return [self.sensor.ConnectUpdated(self.OnNewLaserScans)]

    def OnNewLaserScans(self) -> None:
        """There is a new scan."""


class ContactPlugin(_Hook):
    """Of a contact sensor; `sensor.Contacts()` has the contacts."""

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdated(self.OnUpdate)]

    def OnUpdate(self) -> None:
        """Contacts were gathered; there may be none."""


class GpuRayPlugin(_Hook):
    """Of a gpu_ray sensor, which is a ray sensor here."""

    def connect(self) -> list[Any]:
        """To scans."""
        return [self.sensor.ConnectUpdated(self.OnUpdate)]

    def OnUpdate(self) -> None:
        """There is a new scan."""


class ImuSensorPlugin(_Hook):
    """Of an imu; `sensor.LinearAcceleration()` and the like have what it measured."""

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdated(self.OnUpdate)]

    def OnUpdate(self) -> None:
        """There is a new measurement."""


class SonarPlugin(_Hook):
    """Of a sonar."""

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdate(self.OnUpdate)]

    def OnUpdate(self, message: Any) -> None:
        """A msgs.SonarStamped."""


class ForceTorquePlugin(_Hook):
    """Of a force_torque sensor."""

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdate(self.OnUpdate)]

    def OnUpdate(self, message: Any) -> None:
        """A msgs.WrenchStamped."""
