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

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.plugin import SensorPlugin
from libgz.errors import ParameterError

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

    types: ClassVar[tuple[str, ...]] = ()  # of sensors that it is for
    sensor: Any

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Connect, and switch the sensor on.

        Raises:
            ParameterError: the sensor is of another type.
        """
        if sensor.Type() not in self.types:
            raise ParameterError(
                f"{sdf.where}: {type(self).__name__} is for sensors of type {' and '.join(self.types)}; "
                f"{sensor.ScopedName()} is of type {sensor.Type()}"
            )
        self.sensor = sensor
        self.connections = self.connect()
        sensor.SetActive(True)

    def connect(self) -> list[Any]:
        """Connections to the sensor's events."""
        raise NotImplementedError

    def asks_for(self, name: str) -> bool:
        """Whether a class derived from this has a callback of its own."""
        return any(name in vars(kind) for kind in type(self).__mro__ if kind.__module__ != __name__)


class CameraPlugin(_Hook):
    """Of a camera."""

    types = ("camera", "depth")

    def connect(self) -> list[Any]:
        """To pictures."""
        self.camera = self.sensor.Camera()
        return [self.camera.ConnectNewImageFrame(self.OnNewFrame)]

    def OnNewFrame(self, data: bytes, width: int, height: int, depth: int, image_format: str) -> None:
        """A picture: `depth` bytes a pixel, `width` times `height` of them [px], top row first."""


class DepthCameraPlugin(_Hook):
    """Of a depth camera."""

    types = ("depth",)

    def connect(self) -> list[Any]:
        """To depths and pictures."""
        self.camera = self.sensor.DepthCamera()
        connections = [
            self.camera.ConnectNewDepthFrame(self.OnNewDepthFrame),
            self.camera.ConnectNewImageFrame(self.OnNewImageFrame),
        ]
        if self.asks_for("OnNewRGBPointCloud"):  # a cloud takes time to make
            connections.append(self.camera.ConnectNewRGBPointCloud(self.OnNewRGBPointCloud))
        return connections

    def OnNewDepthFrame(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """Depths [m], `width` times `height` of them, top row first."""

    def OnNewImageFrame(self, data: bytes, width: int, height: int, depth: int, image_format: str) -> None:
        """The picture that belongs to them."""

    def OnNewRGBPointCloud(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """The points that are seen, four numbers each: x right, y down, z forward [m], colour."""


class RayPlugin(_Hook):
    """Of a ray sensor; `sensor.Ranges()` has the ranges."""

    types = ("ray", "gpu_ray")

    def connect(self) -> list[Any]:
        """To scans that the sensor has taken over."""
        return [self.sensor.ConnectUpdated(self.OnNewLaserScans)]

    def OnNewLaserScans(self) -> None:
        """There is a new scan."""


class ContactPlugin(_Hook):
    """Of a contact sensor; `sensor.Contacts()` has the contacts."""

    types = ("contact",)

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdated(self.OnUpdate)]

    def OnUpdate(self) -> None:
        """Contacts were gathered; there may be none."""


class GpuRayPlugin(_Hook):
    """Of a gpu_ray sensor, which is a ray sensor here."""

    types = ("gpu_ray",)

    def connect(self) -> list[Any]:
        """To scans."""
        connections = [self.sensor.ConnectUpdated(self.OnUpdate)]
        if self.asks_for("OnNewLaserFrame"):
            connections.append(self.sensor.ConnectNewLaserFrame(self.OnNewLaserFrame))
        return connections

    def OnUpdate(self) -> None:
        """There is a new scan."""

    def OnNewLaserFrame(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """The scan as `width` times `height` readings of `depth` numbers: range [m], how much came back, 0."""


class ImuSensorPlugin(_Hook):
    """Of an imu; `sensor.LinearAcceleration()` and the like have what it measured."""

    types = ("imu",)

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdated(self.OnUpdate)]

    def OnUpdate(self) -> None:
        """There is a new measurement."""


class SonarPlugin(_Hook):
    """Of a sonar."""

    types = ("sonar",)

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdate(self.OnUpdate)]

    def OnUpdate(self, message: Any) -> None:
        """A msgs.SonarStamped."""


class ForceTorquePlugin(_Hook):
    """Of a force_torque sensor."""

    types = ("force_torque",)

    def connect(self) -> list[Any]:
        """To measurements."""
        return [self.sensor.ConnectUpdate(self.OnUpdate)]

    def OnUpdate(self, message: Any) -> None:
        """A msgs.WrenchStamped."""
