"""Gazebo classic's `sensors` names: the sensors of SDF worlds.

The module of each kind is imported at first use of its name.
"""

from __future__ import annotations

from typing import Any

from libgz.classic.sensors.kinds import CLASSES, sensor_class
from libgz.classic.sensors.noise import GaussianNoiseModel, Noise, NoiseFactory, SensorNoiseType
from libgz.classic.sensors.sensor import Sensor, SensorCategory
from libgz.classic.sensors.sensor_manager import SensorManager, get_sensor, remove_sensors, run_once, run_threads

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


def __getattr__(name: str) -> Any:
    if name in CLASSES:
        globals()[name] = found = sensor_class(CLASSES[name])
        return found
    raise AttributeError(f"module 'libgz.classic.sensors' has no attribute {name!r}")
