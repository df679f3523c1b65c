"""actarray: an array of actuators, such as an arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import filled
from libgz.transport.interface import View
from libgz.transport.layout import CLIENT, SERVER, Array, Element, byte, double, elements, float32, layout, uint32
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_ACTARRAY_ACTSTATE_BRAKED",
    "GAZEBO_ACTARRAY_ACTSTATE_IDLE",
    "GAZEBO_ACTARRAY_ACTSTATE_MOVING",
    "GAZEBO_ACTARRAY_ACTSTATE_STALLED",
    "GAZEBO_ACTARRAY_JOINT_CURRENT_MODE",
    "GAZEBO_ACTARRAY_JOINT_POSITION_MODE",
    "GAZEBO_ACTARRAY_JOINT_SPEED_MODE",
    "GAZEBO_ACTARRAY_NUM_ACTUATORS",
    "Actarray",
    "ActarrayActuator",
    "ActarrayData",
    "gz_actarray_alloc",
    "gz_actarray_close",
    "gz_actarray_create",
    "gz_actarray_destroy",
    "gz_actarray_free",
    "gz_actarray_lock",
    "gz_actarray_open",
    "gz_actarray_post",
    "gz_actarray_unlock",
]


GAZEBO_ACTARRAY_NUM_ACTUATORS = 16
GAZEBO_ACTARRAY_JOINT_POSITION_MODE = 0
GAZEBO_ACTARRAY_JOINT_SPEED_MODE = 1
GAZEBO_ACTARRAY_JOINT_CURRENT_MODE = 2
GAZEBO_ACTARRAY_ACTSTATE_IDLE = 1
GAZEBO_ACTARRAY_ACTSTATE_MOVING = 2
GAZEBO_ACTARRAY_ACTSTATE_BRAKED = 3
GAZEBO_ACTARRAY_ACTSTATE_STALLED = 4


@layout
class ActarrayActuator(Element):
    """gazebo_actarray_actuator_t: one actuator."""

    position: float = float32(SERVER, "m or rad", "measured position")
    speed: float = float32(SERVER, "m/s or rad/s", "measured speed")
    state: int = byte(SERVER, "", "GAZEBO_ACTARRAY_ACTSTATE_*")


@layout
class ActarrayData(SampleData):
    """gz_actarray_data_t; only in the repository of November 2006, after the release."""

    time: float = double(SERVER, "s", "sim time of this sample")
    new_cmd: int = uint32(CLIENT, "", "set to another value with each command")
    actuators_count: int = uint32(SERVER, "", "number of actuators, at most 16")
    actuators_data: Array[ActarrayActuator] = elements(
        ActarrayActuator, SERVER, "the actuators", GAZEBO_ACTARRAY_NUM_ACTUATORS
    )
    cmd_pos: Array[float] = float32(CLIENT, "m or rad", "wanted positions", GAZEBO_ACTARRAY_NUM_ACTUATORS)
    cmd_speed: Array[float] = float32(CLIENT, "m/s or rad/s", "wanted speeds", GAZEBO_ACTARRAY_NUM_ACTUATORS)
    cmd_current: Array[float] = float32(CLIENT, "A", "wanted currents", GAZEBO_ACTARRAY_NUM_ACTUATORS)
    joint_mode: Array[int] = uint32(CLIENT, "", "0 position, 1 speed, 2 current", GAZEBO_ACTARRAY_NUM_ACTUATORS)


class Actarray(SampleInterface[ActarrayData]):
    """An array of actuators."""

    type = "actarray"
    data_class = ActarrayData

    all_actuators = View("actuators_data")
    cmd_pos = View("cmd_pos")
    cmd_speed = View("cmd_speed")
    joint_mode = View("joint_mode")

    @property
    def actuators(self) -> NDArray[np.void]:
        """Records of `position`, `speed` and `state`, shape (actuators_count,); a view of the shared memory."""
        return filled(self.all_actuators, self.data.actuators_count)


_functions = LegacyFunctions(Actarray)
gz_actarray_alloc = _functions.alloc
gz_actarray_free = _functions.free
gz_actarray_create = _functions.create
gz_actarray_destroy = _functions.destroy
gz_actarray_open = _functions.open
gz_actarray_close = _functions.close
gz_actarray_lock = _functions.lock
gz_actarray_unlock = _functions.unlock
gz_actarray_post = _functions.post
