"""The options by which a server speaks ROS."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError

if TYPE_CHECKING:
    from libgz.ros.server import Ros1

__all__ = ["add_ros_options", "ros_wanted", "start_ros"]


def add_ros_options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    about = "connect the world and its plugins to ROS 1; the default if ROS_MASTER_URI is set"
    parser.add_argument("--ros1", action=argparse.BooleanOptionalAction, default=None, help=about)
    about = "address where ROS listens, and by which other computers find it (default: ROS_IP, or 127.0.0.1)"
    parser.add_argument("--ros-ip", metavar="ADDRESS", help=about)


def ros_wanted(options: argparse.Namespace) -> bool:
    """Whether the options, or else the environment, ask for ROS; False for a command without these options."""
    wanted = getattr(options, "ros1", False)
    if wanted is None:
        wanted = os.environ.get("ROS_MASTER_URI") and not _watch_only(options)
    return bool(wanted)


def _watch_only(options: argparse.Namespace) -> bool:
    """Whether the server is one that others only watch; not all commands have that option."""
    return getattr(options, "watch_only", False)


def start_ros(options: argparse.Namespace, words: Sequence[str]) -> AbstractContextManager[Ros1 | None]:
    """ROS for a `with` block, if the options or the environment ask for it.

    Args:
        options: of the command line.
        words: the whole command line, with names and remappings.

    Raises:
        ParameterError: the server is one that others only watch.
    """
    if not ros_wanted(options):
        return nullcontext()
    if _watch_only(options):
        raise ParameterError("--watch-only and --ros1 exclude each other: nodes of ROS command robots")
    from libgz.ros.server import Ros1

    return Ros1(words, options.ros_ip)
