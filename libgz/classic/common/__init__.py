"""Common types of Gazebo classic: time, PID, animations, console, search paths, spherical coordinates."""

from __future__ import annotations

from libgz.base.errors import GazeboError
from libgz.classic.api import without
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
from libgz.classic.common.functions import cwd, exists, find_file, find_file_path, getEnv, isDirectory, isFile
from libgz.classic.common.image import Image
from libgz.classic.common.key_frame import KeyFrame, NumericKeyFrame, PoseKeyFrame
from libgz.classic.common.mesh import Mesh, MeshManager, SubMesh
from libgz.classic.common.model_database import ModelDatabase
from libgz.classic.common.moving_window_filter import MovingWindowFilter
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
    "AssertionInternalError",
    "Battery",
    "Color",
    "Console",
    "ConsoleFormatter",
    "ConsoleHandler",
    "Image",
    "InternalError",
    "KeyFrame",
    "LogFormatter",
    "Mesh",
    "MeshManager",
    "ModelDatabase",
    "MovingWindowFilter",
    "NumericAnimation",
    "NumericKeyFrame",
    "PoseAnimation",
    "PoseKeyFrame",
    "SkeletonAnimation",
    "SphericalCoordinates",
    "SubMesh",
    "SystemPaths",
    "Time",
    "Timer",
    "UpdateInfo",
    "cwd",
    "endl",
    "exists",
    "find_file",
    "find_file_path",
    "getEnv",
    "gzdbg",
    "gzerr",
    "gzlog",
    "gzmsg",
    "gzthrow",
    "gzwarn",
    "isDirectory",
    "isFile",
]

__getattr__ = without(__name__)

# What Gazebo throws is what libgz raises. `Exception` is no part of a star import: it would hide Python's own.
Exception = InternalError = AssertionInternalError = GazeboError  # noqa: A001 - Gazebo's name
