"""position: the odometry of a robot, and its velocity commands."""

from __future__ import annotations

from libgz.base.geometry import pose_text
from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.physics.check import finite
from libgz.transport.interface import View
from libgz.transport.layout import CLIENT, SERVER, Array, double, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "Position",
    "PositionData",
    "gz_position_alloc",
    "gz_position_close",
    "gz_position_create",
    "gz_position_destroy",
    "gz_position_free",
    "gz_position_lock",
    "gz_position_open",
    "gz_position_post",
    "gz_position_unlock",
]


@layout
class PositionData(SampleData):
    """gz_position_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    pos: Array[float] = double(SERVER, "m", "x, y, z; on wheeled robots by odometry, zero at the start", 3)
    rot: Array[float] = double(SERVER, "rad", "roll, pitch, yaw; wheeled robots write yaw only", 3)
    vel_pos: Array[float] = double(SERVER, "m/s", "velocity in the robot's frame, forward first", 3)
    vel_rot: Array[float] = double(SERVER, "rad/s", "angular velocity; the third is the yaw rate, left positive", 3)
    stall: int = int32(SERVER, "", "1: the motors are stalled")
    cmd_enable_motors: int = int32(CLIENT, "", "1: motors on; 0 stops the wheels. The server sets 1 at the start")
    cmd_vel_pos: Array[float] = double(CLIENT, "m/s", "wanted velocity in the robot's frame, forward first", 3)
    cmd_vel_rot: Array[float] = double(CLIENT, "rad/s", "wanted angular velocity; the third is the yaw rate", 3)


class Position(SampleInterface[PositionData]):
    """A robot's odometry and velocity commands. A command holds until the next one."""

    type = "position"
    data_class = PositionData

    pos = View("pos")
    rot = View("rot")
    vel_pos = View("vel_pos")
    vel_rot = View("vel_rot")
    cmd_vel_pos = View("cmd_vel_pos")
    cmd_vel_rot = View("cmd_vel_rot")

    @property
    def pose(self) -> tuple[float, float, float]:
        """x [m], y [m] and yaw [rad], read together under the lock."""
        with self.locked() as data:
            return data.pos[0], data.pos[1], data.rot[2]

    def _place(self) -> str:
        return pose_text(self.data.pos, self.data.rot)

    def command(self, vx: float = 0.0, vyaw: float = 0.0, *, vy: float = 0.0, vz: float = 0.0) -> None:
        """Command a velocity; it holds until the next command.

        Args:
            vx: forward [m/s].
            vyaw: yaw rate [rad/s], left positive.
            vy: left [m/s].
            vz: up [m/s].

        Raises:
            ParameterError: a velocity is NaN or infinite.
        """
        linear = finite(vx, "vx [m/s]"), finite(vy, "vy [m/s]"), finite(vz, "vz [m/s]")
        yaw = finite(vyaw, "vyaw [rad/s]")
        with self.locked() as data:
            data.cmd_vel_pos[:] = linear
            data.cmd_vel_rot[2] = yaw

    def enable_motors(self, enable: bool = True) -> None:
        """Switch the motors on or off."""
        with self.locked() as data:
            data.cmd_enable_motors = int(enable)


_functions = LegacyFunctions(Position)
gz_position_alloc = _functions.alloc
gz_position_free = _functions.free
gz_position_create = _functions.create
gz_position_destroy = _functions.destroy
gz_position_open = _functions.open
gz_position_close = _functions.close
gz_position_lock = _functions.lock
gz_position_unlock = _functions.unlock
gz_position_post = _functions.post
