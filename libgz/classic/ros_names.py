"""Plugins of the ROS era: what stands for them.

Worlds of that era name plugins of the package gazebo_ros. libgz has no ROS: ready plugins that read the same elements
work over topics of Gazebo and interfaces of libgazebo. Those of sensors need no plugin of their own.
"""

from __future__ import annotations

import logging
from pathlib import PurePath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["SENSOR_PLUGINS", "is_ros_name", "notice", "stand_in"]

log = logging.getLogger("libgz.classic")

# Their sensors publish by themselves: file names of gazebo_ros -> ready plugins that activate a sensor.
SENSOR_PLUGINS = {
    "gazebo_ros_block_laser": "gpurayplugin",
    "gazebo_ros_bumper": "contactplugin",
    "gazebo_ros_camera": "cameraplugin",
    "gazebo_ros_depth_camera": "depthcameraplugin",
    "gazebo_ros_ft_sensor": "forcetorqueplugin",
    "gazebo_ros_gpu_laser": "gpurayplugin",
    "gazebo_ros_imu_sensor": "imusensorplugin",
    "gazebo_ros_laser": "rayplugin",
    "gazebo_ros_openni_kinect": "depthcameraplugin",
    "gazebo_ros_range": "rayplugin",
    "gazebo_ros_ray_sensor": "rayplugin",
}


def _stem(filename: str) -> str:
    return PurePath(filename.strip()).stem.removeprefix("lib")


def is_ros_name(filename: str) -> bool:
    """Whether a plugin's file name is one of the ROS era."""
    return _stem(filename).startswith("gazebo_ros_")


def stand_in(filename: str) -> str | None:
    """The ready plugin that stands for one of the ROS era; None if there is none, or it has its own name."""
    return SENSOR_PLUGINS.get(_stem(filename))


class _Notice:
    """Remembers that a world's notice was logged."""

    def __init__(self, _world: object) -> None:
        self.logged = False


def notice(world: World) -> None:
    """Log, once a world, that there is no ROS."""
    kept = world.extension(_Notice)
    if not kept.logged:
        kept.logged = True
        log.warning(
            "world %r has plugins for ROS; libgz runs them over its own topics (`libgz topic -l`) and interfaces: "
            "see docs/plugins.md",
            world.name,
        )
