"""Ros1, Ros2: what a server needs to speak ROS: the session, its plugins instead of the stand-ins, its worlds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from libgz.classic.ros_names import Provider, providers
from libgz.front import World
from libgz.ros.bridged import BridgedNode
from libgz.ros.environment import find_python
from libgz.ros.names import NodeNames, read_names, read_names_of_ros2
from libgz.ros.node import Node
from libgz.ros.packages import add_exported_folders
from libgz.ros.session import Session
from libgz.ros.world import RosWorld

__all__ = ["PLUGINS", "STAND_INS", "Ros1", "Ros2"]

PLUGINS = Path(__file__).parent / "plugins"

# Names of files that have no file of their own -> the plugins that stand for them.
STAND_INS = {
    "gazebo_ros_api_plugin": "_part_of_server",
    "gazebo_ros_force_based_move": "gazebo_ros_planar_move",
    "gazebo_ros_gpu_laser": "gazebo_ros_laser",
    "gazebo_ros_init": "_part_of_server",
    "gazebo_ros_factory": "_part_of_server",
    "gazebo_ros_force_system": "_part_of_server",
    "gazebo_ros_paths_plugin": "_part_of_server",
    "gazebo_ros_prosilica": "gazebo_ros_camera",
    "gazebo_ros_thermal_camera": "gazebo_ros_camera",
    "gazebo_ros_thermal_depth_camera": "gazebo_ros_openni_kinect",
    "gazebo_ros_triggered_multicamera": "gazebo_ros_multicamera",
    "gazebo_ros_velodyne_gpu_laser": "gazebo_ros_velodyne_laser",
    "hector_gazebo_ros_sonar": "gazebo_ros_range",
}


class _Ros(Session):
    """ROS of one server, from `with` to its end."""

    def __init__(self, names: NodeNames, node: Node | BridgedNode, notice: str) -> None:
        super().__init__(names, node)
        add_exported_folders()
        self._provider = Provider(PLUGINS, STAND_INS, f"they speak {notice}: see docs/ros.md")
        providers.append(self._provider)

    def attach(self, core: World) -> None:
        """Serve a world, before it is initialized."""
        RosWorld(self, core)

    def close(self) -> None:
        """Unregister, and end."""
        if self._provider in providers:
            providers.remove(self._provider)
        super().close()


class Ros1(_Ros):
    """ROS 1.

    Args:
        words: of the command line: ``__name:=``, ``__ns:=``, ``_parameter:=``, remappings ``a:=b``.
        address: where to listen, and what other computers call this one; None: as ROS_IP and ROS_HOSTNAME say, and if
            they say nothing, loopback.
    """

    def __init__(self, words: Sequence[str], address: str | None = None) -> None:
        names = read_names(words, address)
        super().__init__(names, Node(names), f"ROS 1 with the master at {names.master}")


class Ros2(_Ros):
    """ROS 2, by a bridge with the user's own rclpy.

    Args:
        words: of the command line; those after ``--ros-args`` are read as nodes of ROS 2 read them.
        python: that of ROS 2; None: as `libgz.ros.environment.find_python` finds it.

    Raises:
        LibraryError: there is none, or it has no rclpy.
    """

    def __init__(self, words: Sequence[str], python: Path | None = None) -> None:
        names = read_names_of_ros2(words)
        super().__init__(names, BridgedNode(names, python or find_python()), "ROS 2")
