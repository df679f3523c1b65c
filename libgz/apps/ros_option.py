"""The options by which a server speaks ROS."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import PurePath
from typing import TYPE_CHECKING

from libgz.base.errors import LibraryError, ParameterError

if TYPE_CHECKING:
    from libgz.ros.server import Ros1, Ros2
    from libgz.simulation.watchdog import Watchdog

__all__ = ["add_ros_options", "ros_wanted", "start_ros", "without_ros_words"]

SYSTEMS_OF_ROS2 = {"gazebo_ros_init", "gazebo_ros_factory", "gazebo_ros_force_system"}
ROS_WORDS, END = "--ros-args", "--"  # the words of ROS 2 are between them


def add_ros_options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    about = "connect the world and its plugins to ROS 1; the default if ROS_MASTER_URI is set"
    parser.add_argument("--ros1", action=argparse.BooleanOptionalAction, default=None, help=about)
    about = "connect the world and its plugins to ROS 2, by the rclpy of a sourced ROS 2 or of `libgz ros venv`; "
    about += "the default for -s libgazebo_ros_init.so and libgazebo_ros_factory.so, where there is a ROS 2"
    parser.add_argument("--ros2", action="store_true", help=about)
    about = "address where ROS 1 listens, and by which other computers find it (default: ROS_IP, or 127.0.0.1)"
    parser.add_argument("--ros-ip", metavar="ADDRESS", help=about)


def ros_wanted(options: argparse.Namespace) -> bool:
    """Whether the options, or else the environment, ask for ROS; False for a command without these options."""
    if _ros2_wanted(options):
        return True
    wanted = getattr(options, "ros1", False)
    if wanted is None:
        wanted = os.environ.get("ROS_MASTER_URI") and not _watch_only(options)
    return bool(wanted)


def _ros2_wanted(options: argparse.Namespace) -> bool:
    """Whether it is ROS 2: by its option, or by System plugins that only ROS 2 has, where there is a ROS 2."""
    if getattr(options, "ros2", False):
        return True
    stems = {PurePath(name).stem.removeprefix("lib") for name in getattr(options, "server_plugin", ())}
    if getattr(options, "ros1", False) is not None or not stems & SYSTEMS_OF_ROS2 or _watch_only(options):
        return False
    from libgz.ros.environment import find_python

    with suppress(LibraryError):
        return bool(find_python())
    return False


def _watch_only(options: argparse.Namespace) -> bool:
    """Whether the server is one that others only watch; not all commands have that option."""
    return getattr(options, "watch_only", False)


def start_ros(
    options: argparse.Namespace, words: Sequence[str], watchdog: Watchdog
) -> AbstractContextManager[Ros1 | Ros2 | None]:
    """ROS for a `with` block, if the options or the environment ask for it.

    Args:
        options: of the command line.
        words: the whole command line, with names and remappings.
        watchdog: handles signals, which end a start that takes long.

    Raises:
        Interrupted: there was a signal.
        ParameterError: the server is one that others only watch, or both ROS are asked for.
        LibraryError: there is no ROS 2.
    """
    if not ros_wanted(options):
        return nullcontext()
    if options.ros1 and options.ros2:
        raise ParameterError("--ros1 and --ros2 exclude each other: a server speaks one ROS")
    if _watch_only(options):
        option = "--ros2" if options.ros2 else "--ros1"
        raise ParameterError(f"--watch-only and {option} exclude each other: nodes of ROS command robots")
    from libgz.ros.server import Ros1, Ros2

    with watchdog.loading():
        return Ros2(words) if _ros2_wanted(options) else Ros1(words, options.ros_ip)


def without_ros_words(words: Sequence[str]) -> list[str]:
    """A command line without the words between ``--ros-args`` and ``--``, which are for ROS 2."""
    found: list[str] = []
    inside = False
    for word in words:
        if inside and word == END:
            inside = False
        elif word == ROS_WORDS:
            inside = True
        elif not inside:
            found.append(word)
    return found
