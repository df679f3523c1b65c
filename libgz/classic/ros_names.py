"""Plugins that worlds of the ROS era name: what stands for them, and what is lost without them.

Without ROS, ready plugins that read the same elements work over topics of Gazebo and interfaces of libgazebo. A
`Provider` has plugins that speak ROS; it comes first.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = [
    "STAND_INS",
    "WITHOUT_EFFECT",
    "Provider",
    "absence",
    "is_ros_name",
    "notice",
    "provided",
    "providers",
    "stand_in",
]

log = logging.getLogger("libgz.classic")

SENSOR = "_ros_sensor"  # the ready plugin that activates a sensor of any type; it publishes by itself

# File names -> ready plugins that stand for them. Those that have their own name are not here.
STAND_INS = dict.fromkeys(
    (
        "gazebo_ros_block_laser",
        "gazebo_ros_bumper",
        "gazebo_ros_camera",
        "gazebo_ros_depth_camera",
        "gazebo_ros_gps_sensor",
        "gazebo_ros_gpu_laser",
        "gazebo_ros_imu_sensor",
        "gazebo_ros_laser",
        "gazebo_ros_multicamera",
        "gazebo_ros_openni_kinect",
        "gazebo_ros_prosilica",
        "gazebo_ros_range",
        "gazebo_ros_ray_sensor",
        "gazebo_ros_thermal_camera",
        "gazebo_ros_thermal_depth_camera",
        "gazebo_ros_triggered_camera",
        "gazebo_ros_triggered_multicamera",
        "gazebo_ros_velodyne_gpu_laser",
        "gazebo_ros_velodyne_laser",
        "hector_gazebo_ros_sonar",
    ),
    SENSOR,
) | {
    "gazebo_link_attacher": "gazebo_ros_link_attacher",
    "gazebo_ros2_control": "gazebo_ros_control",
    "gazebo_ros_elevator": "elevatorplugin",
    "gazebo_ros_force_based_move": "gazebo_ros_planar_move",
    "gazebo_ros_harness": "harnessplugin",
    "gazebo_ros_wheel_slip": "wheelslipplugin",
    "hector_gazebo_ros_imu": "gazebo_ros_imu",
    "roboticsgroup_gazebo_disable_link_plugin": "gazebo_disable_link_plugin",
    "roboticsgroup_gazebo_mimic_joint_plugin": "gazebo_mimic_joint_plugin",
    "roboticsgroup_upatras_gazebo_disable_link_plugin": "gazebo_disable_link_plugin",
    "roboticsgroup_upatras_gazebo_mimic_joint_plugin": "gazebo_mimic_joint_plugin",
}

# File names of plugins that do nothing without ROS -> what is lost, or what to use instead.
WITHOUT_EFFECT = {
    "gazebo_ros_api_plugin": "services of ROS; use `libgz model`, `libgz joint` and `libgz topic`",
    "gazebo_ros_factory": "the services that insert and delete models; use `libgz model`",
    "gazebo_ros_force_system": "the services that apply efforts; use `libgz joint`",
    "gazebo_ros_init": "the clock of ROS, and services of the world; use `libgz stats` and the topic ~/world_control",
    "gazebo_ros_joint_pose_trajectory": "trajectories on a topic of ROS; use `libgz joint`",
    "gazebo_ros_logical_camera": "messages of ROS; the sensor publishes on its own topic",
    "gazebo_ros_paths_plugin": "paths of packages; set GAZEBO_MODEL_PATH",
    "gazebo_ros_projector": "the projector's topic of ROS",
    "gazebo_ros_properties": "the services that get and set properties; use `libgz model` and `libgz joint`",
    "gazebo_ros_state": "the services that get and set poses; use `libgz model`",
    "gazebo_ros_template": "nothing: it is an empty one",
    "gazebo_ros_video": "the video on a visual",
}

# Systems of the newer Gazebo, which Gazebo classic cannot load either.
NEWER = re.compile(r"(lib)?(gz|ignition)[-_](sim|gazebo|physics|sensors)[-\d]|libgz-|gz::|ignition::")


def _stem(filename: str) -> str:
    return PurePath(filename.strip()).stem.removeprefix("lib")


def is_ros_name(filename: str) -> bool:
    """Whether a plugin's file name is one of the ROS era."""
    stem = _stem(filename)
    return stem.startswith("gazebo_ros_") or stem in STAND_INS or stem in WITHOUT_EFFECT


class Provider(NamedTuple):
    """Plugins that speak ROS.

    Attributes:
        folder: where they are.
        names: of files that have no file of their own there -> the files that stand for them.
        notice: what is logged of a world with such plugins.
    """

    folder: Path
    names: Mapping[str, str]
    notice: str


providers: list[Provider] = []  # of this process; the last one comes first


def provided(filename: str) -> Path | None:
    """The file of the plugin that speaks ROS; None if there is none."""
    stem = _stem(filename)
    for provider in reversed(providers):
        path = provider.folder / f"{provider.names.get(stem, stem)}.py"
        if not stem.startswith("_") and path.exists():
            return path
    return None


def stand_in(filename: str) -> str | None:
    """The ready plugin that stands for one of the ROS era; None if there is none, or it has its own name."""
    return STAND_INS.get(_stem(filename))


def absence(filename: str) -> str | None:
    """Why there is no plugin of this name, where that is known."""
    lost = WITHOUT_EFFECT.get(_stem(filename))
    if lost is not None:
        return f"plugin {filename.strip()!r} has no effect without ROS. What is lost: {lost}"
    if NEWER.match(filename.strip()):
        return "plugins of the newer Gazebo (gz sim) are no plugins of Gazebo classic; those of this world are left out"
    return None


class _Notice:
    """Remembers that a world's notice was logged."""

    def __init__(self, _world: object) -> None:
        self.logged = False


def notice(world: World) -> None:
    """Log, once a world, whether its plugins for ROS speak ROS."""
    kept = world.extension(_Notice)
    if kept.logged:
        return
    kept.logged = True
    if providers:
        log.info("world %r has plugins for ROS; %s", world.name, providers[-1].notice)
    else:
        log.warning(
            "world %r has plugins for ROS; libgz runs them over its own topics (`libgz topic -l`) and interfaces: "
            "see docs/plugins.md; `gzserver --ros1` or `--ros2` connects them to ROS",
            world.name,
        )
