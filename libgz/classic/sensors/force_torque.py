"""ForceTorqueSensor: what a joint carries."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.physics import Joint as JointView
from libgz.classic.sensors.read import choice, wrong
from libgz.classic.sensors.sensor import Sensor
from libgz.geometry import GzQuaternIdent, GzQuaternInverse, GzQuaternMul, GzVector, rotate
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.sdf.element import Element

__all__ = ["ForceTorqueSensor"]


class ForceTorqueSensor(Sensor):
    """Measures the force, and the torque about the joint's anchor, that the child puts on the parent, or the other
    way round, in the axes of the parent, of the child or of the sensor, which is placed in the joint's frame.
    """

    topic_suffix: ClassVar[str | None] = "wrench"
    message_type: ClassVar[str] = "WrenchStamped"

    def __init__(self, sensors: WorldSensors, parent: Link | JointView, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        if not isinstance(parent, JointView):
            raise wrong(sdf, "sensor", f"parent of a force torque sensor[{self._name}] must be a joint")
        self._joint = parent
        wrench = sdf.child("force_torque")
        self._frame = choice(wrench, "frame", ("parent", "child", "sensor"))
        self._to_child = False
        if wrench.HasElement("measure_direction"):
            directions = ("child_to_parent", "parent_to_child")
            self._to_child = choice(wrench, "measure_direction", directions) == "parent_to_child"
        self._force, self._torque = Vector3d(), Vector3d()
        self._heard = Event(f"Update of sensor {self.ScopedName()}")

    def Init(self) -> None:
        """Let the joint tell what it carries."""
        self._joint.SetProvideFeedback(True)
        element = self._joint.GetSDF()
        in_child = element.Get(Pose3d, "pose").rot if element is not None else GzQuaternIdent()
        # SDF's rotations go from the inner frame to the outer one: child <- joint <- sensor.
        self._in_child = GzQuaternMul(in_child, self._pose.rot)

    def connected(self) -> bool:
        """Whether callbacks wait for its measurements."""
        return super().connected() or bool(self._heard)

    def ConnectUpdate(self, callback: Callable[..., object]) -> Connection:
        """Call `callback` with a msgs.WrenchStamped after each measurement, as long as the connection is kept."""
        return self.listen(self._heard, callback)

    def measure(self, now: float) -> bool:
        """Read what the joint did in the last step."""
        self._measured = now
        on_parent, about_parent, on_child, about_child = self._joint.core.wrench
        force, torque = (on_child, about_child) if self._to_child else (on_parent, about_parent)
        self._force, self._torque = self._turned(force), self._turned(torque)
        if self._heard or self.listened():
            message = self.wrench_message()
            self._heard(message)
            self.publish(message)
        return True

    def _turned(self, value: GzVector) -> Vector3d:
        """A global vector along the axes of the chosen frame."""
        body = self._joint.core.parent if self._frame == "parent" else self._joint.core.child
        turn = body.GetRotation() if body is not None else GzQuaternIdent()
        if self._frame == "sensor":
            turn = GzQuaternMul(turn, self._in_child)
        return Vector3d(*rotate(GzQuaternInverse(turn), value))

    def wrench_message(self) -> Any:
        """The last measurement as a msgs.WrenchStamped."""
        from libgz.classic import msgs

        msg = self.new_message()
        msgs.Set(msg.time, Time(self._measured))
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
