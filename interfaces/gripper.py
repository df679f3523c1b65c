"""gripper: two paddles that grip, and a lift that raises them."""

from __future__ import annotations

import ctypes
import operator

from libgz.base.errors import ParameterError
from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.transport.interface import DataClass
from libgz.transport.layout import ABIS, CLIENT, SERVER, double, fields_of, for_abi, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_GRIPPER_CMD_CLOSE",
    "GAZEBO_GRIPPER_CMD_OPEN",
    "GAZEBO_GRIPPER_CMD_RETRIEVE",
    "GAZEBO_GRIPPER_CMD_STOP",
    "GAZEBO_GRIPPER_CMD_STORE",
    "GAZEBO_GRIPPER_STATE_CLOSED",
    "GAZEBO_GRIPPER_STATE_ERROR",
    "GAZEBO_GRIPPER_STATE_MOVING",
    "GAZEBO_GRIPPER_STATE_OPEN",
    "Gripper",
    "GripperData",
    "GripperDataCvs",
    "gz_gripper_alloc",
    "gz_gripper_close",
    "gz_gripper_create",
    "gz_gripper_destroy",
    "gz_gripper_free",
    "gz_gripper_lock",
    "gz_gripper_open",
    "gz_gripper_unlock",
]


GAZEBO_GRIPPER_STATE_OPEN = 1
GAZEBO_GRIPPER_STATE_CLOSED = 2
GAZEBO_GRIPPER_STATE_MOVING = 3
GAZEBO_GRIPPER_STATE_ERROR = 4

# The names in the C header. Servers do not use the last two: on the wire 4 lifts and 5 lowers, as below.
GAZEBO_GRIPPER_CMD_OPEN = 1
GAZEBO_GRIPPER_CMD_CLOSE = 2
GAZEBO_GRIPPER_CMD_STOP = 3
GAZEBO_GRIPPER_CMD_STORE = 4
GAZEBO_GRIPPER_CMD_RETRIEVE = 5

# The values of `cmd` on the wire are those of Player.
OPEN, CLOSE, STOP, LIFT_UP, LIFT_DOWN, LIFT_STOP, STORE, DEPLOY, HALT = 1, 2, 3, 4, 5, 6, 7, 8, 15


@layout
class GripperData(SampleData):
    """gz_gripper_data_t of the 0.7.0 release."""

    time: float = double(SERVER, "s", "sim time of this sample")
    cmd: int = int32(
        CLIENT,
        "",
        "1 open, 2 close, 3 stop, 4 lift up, 5 lift down, 6 lift stop, 7 close and lift, 8 open and lower, 15 halt",
    )
    lift_limit_reach: int = int32(SERVER, "", "1: the lift is at an end of its range")
    grip_limit_reach: int = int32(SERVER, "", "1: both paddles are at an end of their range")
    outer_beam_obstruct: int = int32(SERVER, "", "1: an object interrupts the outer beam")
    inner_beam_obstruct: int = int32(SERVER, "", "1: an object interrupts the inner beam")
    left_paddle_open: int = int32(SERVER, "", "1: the left paddle is open")
    right_paddle_open: int = int32(SERVER, "", "1: the right paddle is open")
    paddles_opened: int = int32(SERVER, "", "1: both paddles are open")
    paddles_closed: int = int32(SERVER, "", "1: the paddles are closed, or hold an object")
    paddles_moving: int = int32(SERVER, "", "1: the paddles are moving")
    paddles_error: int = int32(SERVER, "", "1: the paddles are stuck")
    lift_up: int = int32(SERVER, "", "1: the lift is up")
    lift_down: int = int32(SERVER, "", "1: the lift is down")
    lift_moving: int = int32(SERVER, "", "1: the lift is moving")
    lift_error: int = int32(SERVER, "", "1: the lift is stuck")


@layout
class GripperDataCvs(SampleData):
    """gz_gripper_data_t of the repository in November 2006, after the release."""

    time: float = double(SERVER, "s", "sim time of this sample")
    cmd: int = int32(CLIENT, "", "as in the release")
    state: int = int32(SERVER, "", "GAZEBO_GRIPPER_STATE_*")
    grip_limit_reach: int = int32(SERVER, "", "1: both paddles are at an end of their range")
    lift_limit_reach: int = int32(SERVER, "", "1: the lift is at an end of its range")
    outer_beam_obstruct: int = int32(SERVER, "", "1: an object interrupts the outer beam")
    inner_beam_obstruct: int = int32(SERVER, "", "1: an object interrupts the inner beam")
    left_paddle_open: int = int32(SERVER, "", "1: the left paddle is open")
    right_paddle_open: int = int32(SERVER, "", "1: the right paddle is open")
    lift_up: int = int32(SERVER, "", "1: the lift is up")
    lift_down: int = int32(SERVER, "", "1: the lift is down")


class Gripper(SampleInterface[GripperData]):
    """A gripper's state and command. A command holds until the next one.

    Args:
        later: create it with the struct of November 2006. A client recognises the struct by the size of the file.
    """

    type = "gripper"
    data_class = GripperData
    has_post = False

    def __init__(self, later: bool = False) -> None:
        super().__init__()
        self.later = later

    def layout_for(self, version: int, length: int | None) -> DataClass:
        """The struct of the release, or the smaller one of November 2006."""
        if length is None:
            return GripperDataCvs if self.later else super().layout_for(version, length)
        later = (ctypes.sizeof(for_abi(GripperDataCvs, abi)) for abi in ABIS)
        return GripperDataCvs if length in later else super().layout_for(version, length)

    def command(self, code: int) -> None:
        """Command the gripper with a code of this module: OPEN, CLOSE, STOP, LIFT_UP, LIFT_DOWN and so on.

        Raises:
            ParameterError: the code is no integer.
        """
        try:
            number = operator.index(code)
        except TypeError:
            raise ParameterError(f"code is {code!r}; it must be one of GAZEBO_GRIPPER_CMD_...") from None
        with self.locked() as data:
            data.cmd = number

    @property
    def opened(self) -> bool:
        """Whether both paddles are open."""
        data = self.data
        if _is_later(data):
            return bool(data.state == GAZEBO_GRIPPER_STATE_OPEN)
        return bool(data.paddles_opened)

    @property
    def closed(self) -> bool:
        """Whether the paddles are closed, or hold an object."""
        data = self.data
        if _is_later(data):
            return bool(data.state == GAZEBO_GRIPPER_STATE_CLOSED)
        return bool(data.paddles_closed)


def _is_later(data: GripperData | GripperDataCvs) -> bool:
    return "state" in fields_of(type(data))


_functions = LegacyFunctions(Gripper)
gz_gripper_alloc = _functions.alloc
gz_gripper_free = _functions.free
gz_gripper_create = _functions.create
gz_gripper_destroy = _functions.destroy
gz_gripper_open = _functions.open
gz_gripper_close = _functions.close
gz_gripper_lock = _functions.lock
gz_gripper_unlock = _functions.unlock
