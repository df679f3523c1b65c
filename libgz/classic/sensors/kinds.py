"""The class of each `<sensor type>`; a module is imported when its first sensor is made.

A world without cameras must not load OpenGL.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from libgz.classic.sensors.sensor import Sensor
from libgz.sdf.unsimulated import ABSENT_SENSORS

__all__ = ["ABSENT", "CLASSES", "KINDS", "ON_JOINTS", "OWN", "Make", "all_kinds", "sensor_class"]

Make = Callable[[Sensor], dict[str, Callable[..., Any]]]

# Type -> module:class.
KINDS = {
    "altimeter": "libgz.classic.sensors.altimeter:AltimeterSensor",
    "camera": "libgz.classic.sensors.camera:CameraSensor",
    "contact": "libgz.classic.sensors.contact:ContactSensor",
    "depth": "libgz.classic.sensors.depth_camera:DepthCameraSensor",
    "force_torque": "libgz.classic.sensors.force_torque:ForceTorqueSensor",
    "gps": "libgz.classic.sensors.gps:GpsSensor",
    "gpu_ray": "libgz.classic.sensors.gpu_ray:GpuRaySensor",
    "imu": "libgz.classic.sensors.imu:ImuSensor",
    "logical_camera": "libgz.classic.sensors.logical_camera:LogicalCameraSensor",
    "magnetometer": "libgz.classic.sensors.magnetometer:MagnetometerSensor",
    "multicamera": "libgz.classic.sensors.multi_camera:MultiCameraSensor",
    "ray": "libgz.classic.sensors.ray:RaySensor",
    "sonar": "libgz.classic.sensors.sonar:SonarSensor",
    "wideanglecamera": "libgz.classic.sensors.wide_angle_camera:WideAngleCameraSensor",
    "wireless_receiver": "libgz.classic.sensors.wireless:WirelessReceiver",
    "wireless_transmitter": "libgz.classic.sensors.wireless:WirelessTransmitter",
}
CLASSES = {target.partition(":")[2]: kind for kind, target in KINDS.items()}  # class -> type
OWN: dict[str, Make] = {}  # types whose class is a plugin's own; each makes an object, and returns its methods
ON_JOINTS = ("force_torque",)  # all others are carried by links
ABSENT = ABSENT_SENSORS  # known to Gazebo, and not simulated here


def all_kinds() -> list[str]:
    """The types that worlds can make now."""
    return [*KINDS, *(kind for kind in OWN if kind not in KINDS)]


def sensor_class(kind: str) -> type[Sensor]:
    """The class of a type: of a plugin, if that has registered one."""
    target = "libgz.classic.sensors.own:OwnSensor" if kind in OWN else KINDS[kind]
    module, _, name = target.partition(":")
    found: type[Sensor] = getattr(importlib.import_module(module), name)
    return found
