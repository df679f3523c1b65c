"""Ros1: what a server needs to speak ROS 1: the session, its plugins instead of the stand-ins, its worlds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from libgz.classic.ros_names import Provider, providers
from libgz.front import World
from libgz.ros.names import read_names
from libgz.ros.session import Session
from libgz.ros.world import RosWorld

__all__ = ["PLUGINS", "STAND_INS", "Ros1"]

PLUGINS = Path(__file__).parent / "plugins"

# Names of files that have no file of their own -> the plugins that stand for them.
STAND_INS = {
    "gazebo_ros2_control": "gazebo_ros_control",
    "gazebo_ros_api_plugin": "_part_of_server",
    "gazebo_ros_depth_camera": "gazebo_ros_openni_kinect",
    "gazebo_ros_force_based_move": "gazebo_ros_planar_move",
    "gazebo_ros_gpu_laser": "gazebo_ros_laser",
    "gazebo_ros_init": "_part_of_server",
    "gazebo_ros_factory": "_part_of_server",
    "gazebo_ros_paths_plugin": "_part_of_server",
    "gazebo_ros_prosilica": "gazebo_ros_camera",
    "gazebo_ros_ray_sensor": "gazebo_ros_laser",
    "gazebo_ros_thermal_camera": "gazebo_ros_camera",
    "gazebo_ros_thermal_depth_camera": "gazebo_ros_openni_kinect",
    "gazebo_ros_triggered_multicamera": "gazebo_ros_multicamera",
    "gazebo_ros_velodyne_gpu_laser": "gazebo_ros_velodyne_laser",
    "hector_gazebo_ros_sonar": "gazebo_ros_range",
}


class Ros1(Session):
    """ROS 1 of one server, from `with` to its end.

    Args:
        words: of the command line: ``__name:=``, ``__ns:=``, ``_parameter:=``, remappings ``a:=b``.
        address: where to listen, and what other computers call this one; None: as ROS_IP and ROS_HOSTNAME say, and if
            they say nothing, loopback.
    """

    def __init__(self, words: Sequence[str], address: str | None = None) -> None:
        super().__init__(read_names(words, address))
        notice = f"they speak ROS 1 with the master at {self.names.master}: see docs/ros.md"
        self._provider = Provider(PLUGINS, STAND_INS, notice)
        providers.append(self._provider)

    def attach(self, core: World) -> None:
        """Serve a world, before it is initialized."""
        RosWorld(self, core)

    def close(self) -> None:
        """Unregister, and end."""
        if self._provider in providers:
            providers.remove(self._provider)
        super().close()
