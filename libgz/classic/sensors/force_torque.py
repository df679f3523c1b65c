"""ForceTorqueSensor: force and torque in a joint."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, cast

from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzPose,
    GzQuatern,
    GzQuaternIdent,
    GzQuaternInverse,
    GzQuaternMul,
    rotate,
)
from libgz.classic import msgs
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.physics import Joint as JointView
from libgz.classic.sensors.read import choice
from libgz.classic.sensors.sensor import Sensor, SensorOwner
from libgz.simulation.event import Connection

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["ForceTorqueSensor"]


class ForceTorqueSensor(Sensor):
    """Measures the force, and the torque about the joint's anchor, of the child on the parent or of the parent on the
    child, along the axes of the parent, of the child, or of the sensor, whose pose is in the joint's frame.
    """

    STATE = (
        "_force",
        "_torque",
    )

    topic_suffix: ClassVar[str | None] = "wrench"
    message_type: ClassVar[Any] = msgs.WrenchStamped

    def __init__(self, sensors: SensorOwner, parent: Link | JointView, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._joint = cast(JointView, parent)  # in a link, none is made
        wrench = sdf.child("force_torque")
        self._frame = choice(wrench, "frame", ("parent", "child", "sensor"), "child")
        self._to_child = False
        if wrench.HasElement("measure_direction"):
            directions = ("child_to_parent", "parent_to_child")
            self._to_child = choice(wrench, "measure_direction", directions, directions[0]) == "parent_to_child"
        self._force, self._torque = Vector3d(), Vector3d()

    def Init(self) -> None:
        """Switch the joint's force feedback on."""
        self._joint.SetProvideFeedback(True)
        self._in_child = self._pose_in_child().rot

    def _pose_in_child(self) -> GzPose:
        element = self._joint.GetSDF()
        joint = element.Get(Pose3d, "pose") if element is not None else GzPose()
        return GzCoordPoseAdd(self._pose, joint)

    def world_pose(self) -> GzPose:
        """Global pose [m]."""
        child = self._joint.core.child
        return GzCoordPoseAdd(self._pose_in_child(), child.GetPose() if child is not None else GzPose())

    def ConnectUpdate(self, callback: Callable[..., object]) -> Connection:
        """Call `callback` with a msgs.WrenchStamped after each measurement, as long as the connection is kept."""
        return self.listen(self._message_event, callback)

    def measure(self, elapsed: float) -> None:
        """Read the joint's wrench in the last step."""
        on_parent, about_parent, on_child, about_child = self._joint.core.wrench
        force, torque = (on_child, about_child) if self._to_child else (on_parent, about_parent)
        turn = self._from_global()
        self._force, self._torque = Vector3d(*rotate(turn, force)), Vector3d(*rotate(turn, torque))

    def _from_global(self) -> GzQuatern:
        """The rotation of global vectors into the chosen frame."""
        body = self._joint.core.parent if self._frame == "parent" else self._joint.core.child
        turn = body.GetRotation() if body is not None else GzQuaternIdent()
        if self._frame == "sensor":
            turn = GzQuaternMul(turn, self._in_child)
        return GzQuaternInverse(turn)

    def message(self) -> Any:
        """The last measurement as a msgs.WrenchStamped."""
        msg = self.stamped()
        msgs.Set(msg.wrench.force, self._force)
        msgs.Set(msg.wrench.torque, self._torque)
        return msg

    def Joint(self) -> JointView:
        """The joint."""
        return self._joint

    def Force(self) -> Vector3d:
        """[N]."""
        return Vector3d(*self._force)

    def Torque(self) -> Vector3d:
        """[N m]."""
        return Vector3d(*self._torque)

    GetJoint, GetForce, GetTorque = Joint, Force, Torque
