"""Common types of Gazebo classic: time, PID, animations, console, search paths, spherical coordinates."""

from __future__ import annotations

from libgz.classic.common.animation import Animation, NumericAnimation, PoseAnimation
from libgz.classic.common.battery import Battery
from libgz.classic.common.console import (
    Console,
    ConsoleFormatter,
    ConsoleHandler,
    LogFormatter,
    endl,
    gzdbg,
    gzerr,
    gzlog,
    gzmsg,
    gzthrow,
    gzwarn,
)
from libgz.classic.common.key_frame import KeyFrame, NumericKeyFrame, PoseKeyFrame
from libgz.classic.common.skeleton_animation import SkeletonAnimation
from libgz.classic.common.spherical_coordinates import SphericalCoordinates
from libgz.classic.common.system_paths import SystemPaths
from libgz.classic.common.time import Time
from libgz.classic.common.timer import Timer
from libgz.classic.common.update_info import UpdateInfo
from libgz.classic.math.color import Color
from libgz.classic.math.pid import PID

__all__ = [
    "PID",
    "Animation",
    "Battery",
    "Color",
    "Console",
    "ConsoleFormatter",
    "ConsoleHandler",
    "KeyFrame",
    "LogFormatter",
    "NumericAnimation",
    "NumericKeyFrame",
    "PoseAnimation",
    "PoseKeyFrame",
    "SkeletonAnimation",
    "SphericalCoordinates",
    "SystemPaths",
    "Time",
    "Timer",
    "UpdateInfo",
    "endl",
    "gzdbg",
    "gzerr",
    "gzlog",
    "gzmsg",
    "gzthrow",
    "gzwarn",
]
