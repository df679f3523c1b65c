"""Base classes for sensor plugins: each activates its sensor and calls a method with every measurement.

A plugin overrides the method::

    from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN
    from libgz.classic.plugins.hooks import RayPlugin

    class Nearest(RayPlugin):
        def OnNewLaserScans(self):
            print(min(self.sensor.Ranges()))

    GZ_REGISTER_SENSOR_PLUGIN(Nearest)

The ready plugins libCameraPlugin.so, libRayPlugin.so and so on are these classes themselves: they activate the sensor,
so that it measures and publishes, and do nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import ParameterError
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
    """Stores the sensor as `sensor`, and activates it."""

    STATE: ClassVar[tuple[str, ...]] = ()

    types: ClassVar[tuple[str, ...]] = ()  # types of sensors that it accepts
    sensor: Any

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Connect to the sensor's events, and activate it.

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
        """Return connections to the sensor's events."""
        raise NotImplementedError

    def overrides(self, name: str) -> bool:
        """Whether a derived class overrides a method of this module."""
        return any(name in vars(kind) for kind in type(self).__mro__ if kind.__module__ != __name__)


class CameraPlugin(_Hook):
    """Plugin of a camera."""

    types = ("camera", "depth")

    def connect(self) -> list[Any]:
        """Connect to images."""
        self.camera = self.sensor.Camera()
        return [self.camera.ConnectNewImageFrame(self.OnNewFrame)]

    def OnNewFrame(self, data: bytes, width: int, height: int, depth: int, image_format: str) -> None:
        """A new image: `width` times `height` pixels of `depth` bytes, top row first."""


class DepthCameraPlugin(_Hook):
    """Plugin of a depth camera."""

    types = ("depth",)

    def connect(self) -> list[Any]:
        """Connect to depths and images; to point clouds only if they are used."""
        self.camera = self.sensor.DepthCamera()
        connections = [
            self.camera.ConnectNewDepthFrame(self.OnNewDepthFrame),
            self.camera.ConnectNewImageFrame(self.OnNewImageFrame),
        ]
        if self.overrides("OnNewRGBPointCloud"):  # expensive
            connections.append(self.camera.ConnectNewRGBPointCloud(self.OnNewRGBPointCloud))
        return connections

    def OnNewDepthFrame(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """New depths [m], `width` times `height` of them, top row first."""

    def OnNewImageFrame(self, data: bytes, width: int, height: int, depth: int, image_format: str) -> None:
        """The image that belongs to the depths."""

    def OnNewRGBPointCloud(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """The visible points, four numbers each: x right, y down, z forward [m], colour."""


class RayPlugin(_Hook):
    """Plugin of a ray sensor; `sensor.Ranges()` returns the ranges."""

    types = ("ray", "gpu_ray")

    def connect(self) -> list[Any]:
        """Connect to scans."""
        return [self.sensor.ConnectUpdated(self.OnNewLaserScans)]

    def OnNewLaserScans(self) -> None:
        """A new scan."""


class ContactPlugin(_Hook):
    """Plugin of a contact sensor; `sensor.Contacts()` returns the contacts."""

    types = ("contact",)

    def connect(self) -> list[Any]:
        """Connect to measurements."""
        return [self.sensor.ConnectUpdated(self.OnUpdate)]

    def OnUpdate(self) -> None:
        """New contacts; there may be none."""


class GpuRayPlugin(_Hook):
    """Plugin of a gpu_ray sensor, which libgz simulates as a ray sensor."""

    types = ("gpu_ray",)

    def connect(self) -> list[Any]:
        """Connect to scans; to laser frames only if they are used."""
        connections = [self.sensor.ConnectUpdated(self.OnUpdate)]
        if self.overrides("OnNewLaserFrame"):
            connections.append(self.sensor.ConnectNewLaserFrame(self.OnNewLaserFrame))
        return connections

    def OnUpdate(self) -> None:
        """A new scan."""

    def OnNewLaserFrame(self, data: Any, width: int, height: int, depth: int, image_format: str) -> None:
        """The scan as `width` times `height` readings of `depth` numbers: range [m], intensity, 0."""


class ImuSensorPlugin(_Hook):
    """Plugin of an imu; `sensor.LinearAcceleration()` and other getters return the measurement."""

    types = ("imu",)

    def connect(self) -> list[Any]:
        """Connect to measurements."""
        return [self.sensor.ConnectUpdated(self.OnUpdate)]

    def OnUpdate(self) -> None:
        """A new measurement."""


class SonarPlugin(_Hook):
    """Plugin of a sonar."""

    types = ("sonar",)

    def connect(self) -> list[Any]:
        """Connect to measurements."""
        return [self.sensor.ConnectUpdate(self.OnUpdate)]

    def OnUpdate(self, message: Any) -> None:
        """A new measurement, as a msgs.SonarStamped."""


class ForceTorquePlugin(_Hook):
    """Plugin of a force_torque sensor."""

    types = ("force_torque",)

    def connect(self) -> list[Any]:
        """Connect to measurements."""
        return [self.sensor.ConnectUpdate(self.OnUpdate)]

    def OnUpdate(self, message: Any) -> None:
        """A new measurement, as a msgs.WrenchStamped."""
