"""truth: the true pose of a model, and commands to move it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from libgz.base.geometry import GzPose, GzQuatern, GzQuaternFromEuler, GzQuaternToEuler, GzVector, pose_text
from libgz.base.law import law
from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.physics.check import finite_tuple, rotation_tuple
from libgz.transport.interface import View
from libgz.transport.layout import CLIENT, SERVER, Array, double, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "Truth",
    "TruthData",
    "TruthDataOld",
    "gz_truth_alloc",
    "gz_truth_close",
    "gz_truth_create",
    "gz_truth_destroy",
    "gz_truth_euler_from_quatern",
    "gz_truth_free",
    "gz_truth_lock",
    "gz_truth_open",
    "gz_truth_post",
    "gz_truth_quatern_from_euler",
    "gz_truth_unlock",
]


@layout
class TruthData(SampleData):
    """gz_truth_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    pos: Array[float] = double(SERVER, "m", "global x, y, z", 3)
    rot: Array[float] = double(SERVER, "", "global rotation as a quaternion: u, x, y, z", 4)
    cmd_new: int = int32(CLIENT, "", "1: move the model to the pose below; written last, cleared by the server")
    cmd_pos: Array[float] = double(CLIENT, "m", "wanted global x, y, z", 3)
    cmd_rot: Array[float] = double(CLIENT, "", "wanted global rotation: u, x, y, z", 4)


@layout
class TruthDataOld(SampleData):
    """gz_truth_data_t of version 0x050: rotations are roll, pitch, yaw."""

    time: float = double(SERVER, "s", "sim time of this sample")
    pos: Array[float] = double(SERVER, "m", "global x, y, z", 3)
    rot: Array[float] = double(SERVER, "rad", "global rotation: roll, pitch, yaw", 3)
    cmd_new: int = int32(CLIENT, "", "1: move the model to the pose below; written last, cleared by the server")
    cmd_pos: Array[float] = double(CLIENT, "m", "wanted global x, y, z", 3)
    cmd_rot: Array[float] = double(CLIENT, "rad", "wanted global rotation: roll, pitch, yaw", 3)


class Truth(SampleInterface[TruthData]):
    """A model's true pose."""

    type = "truth"
    data_class = TruthData
    older = {0x050: TruthDataOld}

    pos = View("pos")
    rot = View("rot")

    @property
    def pose(self) -> GzPose:
        """The global pose [m], read under the lock."""
        with self.locked() as data:
            return GzPose(GzVector(*data.pos), _quaternion(data.rot))

    def _place(self) -> str:
        return pose_text(self.data.pos, GzQuaternToEuler(_quaternion(self.data.rot)))

    def move(self, pose: GzPose) -> None:
        """Request that the server moves the model to a global pose [m], at rest.

        Raises:
            ParameterError: a number of the pose is NaN or infinite, or its rotation is zero.
        """
        position = finite_tuple(pose.pos, 3, "position [m]")
        rotation = GzQuatern(*rotation_tuple(pose.rot, "rotation"))
        with self.locked() as data:
            data.cmd_pos[:], data.cmd_rot[:] = position, self._rotation(GzPose(GzVector(*position), rotation))
            data.cmd_new = 1

    @law
    def publish(self, time: float, pose: GzPose) -> None:
        """Write the model's global pose [m] at a sim time [s]; for servers, which hold the lock."""
        data = self.data
        data.time = time
        data.pos[:], data.rot[:] = tuple(pose.pos), self._rotation(pose)

    def take_move(self) -> GzPose | None:
        """Take the pose [m] that a client requested, unchecked; None if there is no new request.

        For servers, which hold the lock.
        """
        data = self.data
        if not data.cmd_new:
            return None
        data.cmd_new = 0
        return GzPose(GzVector(*data.cmd_pos), _quaternion(data.cmd_rot))

    @law
    def _rotation(self, pose: GzPose) -> tuple[float, ...]:
        """The rotation in the form of this version of the struct: a quaternion, or Euler angles [rad]."""
        return tuple(pose.rot if len(self.data.rot) == 4 else GzQuaternToEuler(pose.rot))


def _quaternion(rotation: Array[float]) -> GzQuatern:
    if len(rotation) == 4:
        return GzQuatern(*rotation)
    if not all(map(math.isfinite, rotation)):  # their sine and cosine are not defined
        return GzQuatern(math.nan, math.nan, math.nan, math.nan)
    return GzQuaternFromEuler(*rotation)


def gz_truth_euler_from_quatern(truth: Truth | None, e: Array[float], q: Sequence[float]) -> None:
    """Fill `e` with roll, pitch, yaw [rad] of the quaternion `q`."""
    e[0], e[1], e[2] = GzQuaternToEuler(q)


def gz_truth_quatern_from_euler(truth: Truth | None, q: Array[float], e: Sequence[float]) -> None:
    """Fill `q` with the quaternion of roll, pitch, yaw [rad] in `e`."""
    q[0], q[1], q[2], q[3] = GzQuaternFromEuler(*e)


_functions = LegacyFunctions(Truth)
gz_truth_alloc = _functions.alloc
gz_truth_free = _functions.free
gz_truth_create = _functions.create
gz_truth_destroy = _functions.destroy
gz_truth_open = _functions.open
gz_truth_close = _functions.close
gz_truth_lock = _functions.lock
gz_truth_unlock = _functions.unlock
gz_truth_post = _functions.post
