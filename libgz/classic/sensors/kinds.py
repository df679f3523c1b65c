"""Which class is which `<sensor type>`; a module is imported when its first sensor is made."""

from __future__ import annotations

import importlib

from libgz.classic.sensors.sensor import Sensor

__all__ = ["CLASSES", "KINDS", "sensor_class"]

# Class -> its module in this package.
CLASSES = {
    "AltimeterSensor": "altimeter",
    "CameraSensor": "camera",
    "ContactSensor": "contact",
    "DepthCameraSensor": "depth_camera",
    "ForceTorqueSensor": "force_torque",
    "GpsSensor": "gps",
    "GpuRaySensor": "gpu_ray",
    "ImuSensor": "imu",
    "LogicalCameraSensor": "logical_camera",
    "MagnetometerSensor": "magnetometer",
    "MultiCameraSensor": "multi_camera",
    "RaySensor": "ray",
    "SonarSensor": "sonar",
}
KINDS = {
    "altimeter": "AltimeterSensor",
    "camera": "CameraSensor",
    "contact": "ContactSensor",
    "depth": "DepthCameraSensor",
    "force_torque": "ForceTorqueSensor",
    "gps": "GpsSensor",
    "gpu_ray": "GpuRaySensor",
    "imu": "ImuSensor",
    "logical_camera": "LogicalCameraSensor",
    "magnetometer": "MagnetometerSensor",
    "multicamera": "MultiCameraSensor",
    "ray": "RaySensor",
    "sonar": "SonarSensor",
}
# Known to Gazebo, and not simulated here.
ABSENT = ("rfid", "rfidtag", "wideanglecamera", "wireless_receiver", "wireless_transmitter")


def sensor_class(name: str) -> type[Sensor]:
    """A class of `CLASSES` by name."""
    found: type[Sensor] = getattr(importlib.import_module(f"libgz.classic.sensors.{CLASSES[name]}"), name)
    return found
