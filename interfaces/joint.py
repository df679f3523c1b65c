"""joint: the joints of a model, and the angles wanted for them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import filled
from libgz.physics.check import finite
from libgz.transport.interface import View
from libgz.transport.layout import CLIENT, SERVER, Array, Element, double, elements, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_JOINT_MAX_JOINTS",
    "JointData",
    "Joints",
    "JointsData",
    "gz_joint_alloc",
    "gz_joint_close",
    "gz_joint_create",
    "gz_joint_destroy",
    "gz_joint_free",
    "gz_joint_lock",
    "gz_joint_open",
    "gz_joint_post",
    "gz_joint_unlock",
]


GAZEBO_JOINT_MAX_JOINTS = 20


@layout
class JointData(Element):
    """gz_joint_data_t: one joint."""

    type: int = int32(SERVER, "", "ODE's number of the joint type")
    anchor: Array[float] = double(SERVER, "m", "global anchor", 3)
    axis: Array[float] = double(SERVER, "", "global axis", 3)
    axis2: Array[float] = double(SERVER, "", "global second axis of universal and hinge2 joints", 3)
    angular_velocity: float = double(SERVER, "rad/s", "about the axis")
    angular_velocity2: float = double(SERVER, "rad/s", "about the second axis")
    angle: float = double(SERVER, "rad", "about the axis")
    angle2: float = double(SERVER, "rad", "about the second axis")
    cmd_angle: float = double(CLIENT, "rad", "wanted angle about the axis")
    cmd_angle2: float = double(CLIENT, "rad", "wanted angle about the second axis")


@layout
class JointsData(SampleData):
    """gz_joints_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    joints: Array[JointData] = elements(JointData, SERVER, "the joints", GAZEBO_JOINT_MAX_JOINTS)
    joint_count: int = int32(SERVER, "", "number of joints, at most 20")


class Joints(SampleInterface[JointsData]):
    """A model's joints."""

    type = "joint"
    data_class = JointsData

    all_joints = View("joints")

    @property
    def joints(self) -> NDArray[np.void]:
        """The joints: records of the fields of `JointData`, shape (joint_count,); a view of the shared memory."""
        return filled(self.all_joints, self.data.joint_count)

    def command(self, index: int, angle: float, angle2: float = 0.0) -> None:
        """Command the angles of a joint.

        Args:
            index: of the joint, from 0.
            angle: about the axis [rad].
            angle2: about the second axis [rad].

        Raises:
            IndexError: the index is not below 20.
            ParameterError: an angle is NaN or infinite.
        """
        angles = finite(angle, "angle [rad]"), finite(angle2, "angle2 [rad]")
        with self.locked() as data:
            data.joints[index].cmd_angle, data.joints[index].cmd_angle2 = angles


_functions = LegacyFunctions(Joints)
gz_joint_alloc = _functions.alloc
gz_joint_free = _functions.free
gz_joint_create = _functions.create
gz_joint_destroy = _functions.destroy
gz_joint_open = _functions.open
gz_joint_close = _functions.close
gz_joint_lock = _functions.lock
gz_joint_unlock = _functions.unlock
gz_joint_post = _functions.post
