"""The public names of libgz.classic.common, and the one module that each comes from."""

from libgz.classic.common.animation import (
    Animation as Animation,
    NumericAnimation as NumericAnimation,
    PoseAnimation as PoseAnimation,
)
from libgz.classic.common.battery import Battery as Battery
from libgz.classic.common.console import (
    Console as Console,
    ConsoleFormatter as ConsoleFormatter,
    ConsoleHandler as ConsoleHandler,
    LogFormatter as LogFormatter,
    endl as endl,
    gzdbg as gzdbg,
    gzerr as gzerr,
    gzlog as gzlog,
    gzmsg as gzmsg,
    gzthrow as gzthrow,
    gzwarn as gzwarn,
)
from libgz.classic.common.errors import (
    AssertionInternalError as AssertionInternalError,
    InternalError as InternalError,
)
from libgz.classic.common.functions import (
    cwd as cwd,
    exists as exists,
    find_file as find_file,
    find_file_path as find_file_path,
    getEnv as getEnv,
    isDirectory as isDirectory,
    isFile as isFile,
)
from libgz.classic.common.image import Image as Image
from libgz.classic.common.key_frame import (
    KeyFrame as KeyFrame,
    NumericKeyFrame as NumericKeyFrame,
    PoseKeyFrame as PoseKeyFrame,
)
from libgz.classic.common.mesh import Mesh as Mesh, MeshManager as MeshManager, SubMesh as SubMesh
from libgz.classic.common.model_database import ModelDatabase as ModelDatabase
from libgz.classic.common.moving_window_filter import MovingWindowFilter as MovingWindowFilter
from libgz.classic.common.skeleton_animation import SkeletonAnimation as SkeletonAnimation
from libgz.classic.common.spherical_coordinates import SphericalCoordinates as SphericalCoordinates
from libgz.classic.common.system_paths import SystemPaths as SystemPaths
from libgz.classic.common.time import Time as Time
from libgz.classic.common.timer import Timer as Timer
from libgz.classic.common.update_info import UpdateInfo as UpdateInfo
from libgz.classic.math.color import Color as Color
from libgz.classic.math.pid import PID as PID

Exception = InternalError  # noqa: A001 - Gazebo's name
