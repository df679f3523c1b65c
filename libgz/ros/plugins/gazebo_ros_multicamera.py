"""gazebo_ros_multicamera: images of several cameras of one sensor, such as a stereo pair."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, RosCamera
from libgz.ros.plugins._sensor import RosSensor, model_of

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class _One(RosCamera):
    """One of the cameras."""


class GazeboRosMultiCamera(RosSensor, SensorPlugin):
    """Publishes the images of all cameras: names with `left` and `right` are `/left` and `/right` of the namespace.

    The right one has the baseline of `<hackBaseline>`.
    """

    parameters = CAMERA
    endpoints = CAMERA_ENDPOINTS

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.parts: list[_One] = []
        for index in range(sensor.CameraCount()):
            camera = sensor.Camera(index)
            name = camera.Name()
            suffix, baseline = (
                ("/left", 0.0) if "left" in name else ("/right", None) if "right" in name else (f"/{index}", 0.0)
            )
            part = _One()
            part.open(sdf, model_of(sensor))
            part.open_sensor(sensor, sdf)
            part.match_activity = self.match_activity  # type: ignore[method-assign]
            part.open_camera(camera, suffix, baseline)
            self.parts.append(part)
            self.publications += part.publications
        self.begin()

    def send(self) -> None:
        """Publish all images."""
        for part in self.parts:
            part.send()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosMultiCamera)
