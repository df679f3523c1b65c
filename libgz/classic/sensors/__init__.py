"""Gazebo classic's `sensors` names: the sensors of SDF worlds.

The module of each kind is imported at first use of its name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.api import without
from libgz.classic.sensors.kinds import CLASSES, sensor_class
from libgz.classic.sensors.noise import GaussianNoiseModel, Noise, NoiseFactory, SensorNoiseType
from libgz.classic.sensors.sensor import Sensor, SensorCategory
from libgz.classic.sensors.sensor_manager import SensorManager, get_sensor, remove_sensors, run_once, run_threads

if TYPE_CHECKING:  # at run time each is imported when it is first used
    from libgz.classic.sensors.altimeter import AltimeterSensor as AltimeterSensor
    from libgz.classic.sensors.camera import CameraSensor as CameraSensor
    from libgz.classic.sensors.contact import ContactSensor as ContactSensor
    from libgz.classic.sensors.depth_camera import DepthCameraSensor as DepthCameraSensor
    from libgz.classic.sensors.force_torque import ForceTorqueSensor as ForceTorqueSensor
    from libgz.classic.sensors.gps import GpsSensor as GpsSensor
    from libgz.classic.sensors.gpu_ray import GpuRaySensor as GpuRaySensor
    from libgz.classic.sensors.imu import ImuSensor as ImuSensor
    from libgz.classic.sensors.logical_camera import LogicalCameraSensor as LogicalCameraSensor
    from libgz.classic.sensors.magnetometer import MagnetometerSensor as MagnetometerSensor
    from libgz.classic.sensors.multi_camera import MultiCameraSensor as MultiCameraSensor
    from libgz.classic.sensors.ray import RaySensor as RaySensor
    from libgz.classic.sensors.sonar import SonarSensor as SonarSensor
    from libgz.classic.sensors.wide_angle_camera import WideAngleCameraSensor as WideAngleCameraSensor
    from libgz.classic.sensors.wireless import (
        WirelessReceiver as WirelessReceiver,
        WirelessTransmitter as WirelessTransmitter,
    )

__all__ = [
    *CLASSES,
    *SensorNoiseType.__members__,
    "GaussianNoiseModel",
    "Noise",
    "NoiseFactory",
    "Sensor",
    "SensorCategory",
    "SensorManager",
    "SensorNoiseType",
    "get_sensor",
    "remove_sensors",
    "run_once",
    "run_threads",
]

globals().update(SensorNoiseType.__members__)
_missing = without(__name__)


def __getattr__(name: str) -> Any:
    if name in CLASSES:
        globals()[name] = found = sensor_class(CLASSES[name])
        return found
    return _missing(name)
