"""Elements, topics, joints, rates and noise as plugins of ROS and of ROS 2 have them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, nearest
from libgz.base.law import law, rarely
from libgz.classic.common.time import sim_nanoseconds
from libgz.classic.math import Rand, Vector3d
from libgz.classic.plugin import ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element
    from libgz.simulation.clock import Clock
    from libgz.simulation.rate import UpdateRate

__all__ = ["PeriodicPlugin", "noisy", "ros_elements", "ros_joints", "ros_rate", "ros_topic"]


class PeriodicPlugin(ModelPlugin, ABC):
    """A plugin that does its work at a rate of sim time; native code leaves only those steps to Python.

    Attributes:
        clock: the world's; `Load` sets it.
        rate: of the work; `Load` sets it.
    """

    clock: Clock
    rate: UpdateRate

    @law
    def OnUpdate(self) -> None:
        """Do the work, if it is time."""
        now = sim_nanoseconds(self.clock) / 1e9
        if rarely(self.rate.is_due(now)):
            self.rate.due(now)
            self.publish(now)

    @abstractmethod
    def publish(self, now: float) -> None:
        """Do the work at a sim time [s]."""


# Elements of ROS 2 whose name in ROS is another one than the same words in camel case.
RENAMED = {
    "cx": "Cx",
    "cy": "Cy",
    "max_depth": "pointCloudCutoffMax",
    "max_steering_angle_tolerance": "steeringAngleTolerance",
    "max_steering_speed": "steeringSpeed",
    "max_wheel_acceleration": "wheelAcceleration",
    "max_wheel_deceleration": "wheelDeceleration",
    "max_wheel_speed_tolerance": "wheelSpeedTolerance",
    "max_wheel_torque": "wheelTorque",
    "min_depth": "pointCloudCutoff",
    "publish_odom": "publishTf",
    "publish_odom_tf": "publishOdomTF",
    "publish_rate": "odometryRate",
    "publish_wheel_tf": "publishWheelTF",
}


def ros_elements(sdf: Element) -> Element:
    """The elements of a plugin under their names in ROS: `<left_joint>` of ROS 2 is `<leftJoint>`.

    A `<namespace>` in `<ros>` is the `<robotNamespace>`.
    """
    copy = sdf.Clone()
    for child in copy.children:
        first, *rest = child.name.split("_")
        child.name = RENAMED.get(child.name, first + "".join(map(str.capitalize, rest)))
    for ros in sdf.named("ros"):
        if ros.HasElement("namespace") and not copy.HasElement("robotNamespace"):
            copy.AddElement("robotNamespace").Set(ros.Get(str, "namespace"))
    return copy


def ros_topic(model: Model, sdf: Element, tag: str, default: str) -> str:
    """The topic that an element names: `/<robotNamespace>/<name>`; without a namespace, `~/<model>/<name>`.

    A `<remapping>` or `<argument>` of ROS 2, `name:=other`, gives it another name.
    """
    name = sdf.Get(str, tag, default)[0].strip()
    for ros in sdf.named("ros"):
        for remapping in (*ros.named("remapping"), *ros.named("argument")):  # the latter in the first of ROS 2
            before, found, after = remapping.Get(str).strip().partition(":=")
            if found and before.removeprefix("~/") == name:
                name = after.strip()
    if name.startswith(("/", "~")):
        return name
    space = sdf.Get(str, "robotNamespace").strip().strip("/")
    return f"/{space}/{name}" if space else f"~/{model.GetName()}/{name}"


def ros_joints(model: Model, sdf: Element, tag: str, default: str) -> list[Joint]:
    """The joints that elements of one tag name; without one, the joint of the default name.

    Raises:
        NotFoundError: there is no such joint.
    """
    names = [element.Get(str).strip() for element in sdf.named(tag)] or [default]
    joints = [model.GetJoint(name) for name in names]
    for name, joint in zip(names, joints, strict=True):
        if joint is None:
            known = [joint.GetName() for joint in model.all_joints()]
            raise NotFoundError(
                f"{sdf.where}: <{tag}> is {name!r}; model {model.GetName()!r} has {', '.join(known) or 'none'}"
                f"{nearest(name, known)}"
            )
    return joints


def ros_rate(model: Model, sdf: Element, default: float) -> float:
    """The rate that `<updateRate>` gives [Hz]; 0 or less: that of the iterations."""
    rate: float = sdf.Get(float, "updateRate", default)[0]
    return rate if rate > 0.0 else 1.0 / model.GetWorld().Physics().GetMaxStepSize()


def noisy(vector: Vector3d, deviation: float) -> Vector3d:
    """A vector with Gaussian noise on each component; without a deviation above 0, the vector itself."""
    if not deviation > 0.0:
        return vector
    return vector + Vector3d(*(Rand.DblNormal(0.0, deviation) for _ in range(3)))
