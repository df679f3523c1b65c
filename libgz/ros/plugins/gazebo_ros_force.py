"""gazebo_ros_force: applies forces of a topic to a link."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.base.errors import ParameterError
from libgz.base.law import Number, ends, law
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, RosPlugin
from libgz.ros.session import finite

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosForce(RosPlugin, ModelPlugin):
    """Applies the last Wrench of a topic to a link in each iteration, until the next one comes."""

    STATE = ("wrench", "applied")

    applied = Number()  # 1: there is a wrench

    parameters = (
        Parameter("bodyName", "", "the link (in ROS 2 link_name)"),
        Parameter("linkName", "", "in ROS 2: the link"),
        Parameter("topicName", "gazebo_ros_force", "wrenches"),
        Parameter("forceFrame", "world", "frame of the wrench: world or link"),
    )
    endpoints = (Endpoint("subscribes", "<topicName>", "geometry_msgs/Wrench"),)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and subscribe."""
        self.open(sdf, model.GetName())
        given = self.given
        self.link = named_link(model, ros_elements(sdf), "linkName" if given.linkName else "bodyName")
        if given.forceFrame not in ("world", "link"):
            raise ParameterError(f"{sdf.where}: <force_frame> is {given.forceFrame!r}; it must be world or link")
        self.wrenches = self.subscribe(given.topicName, "geometry_msgs/Wrench", self.OnWrench)
        self.wrench = np.zeros(6)  # force [N], torque [N m]
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Apply nothing."""
        self._set(Vector3d(), Vector3d())

    def OnWrench(self, message: Any) -> None:
        """A new wrench [N], [N m]."""
        if finite(message):
            force, torque = message.force, message.torque
            self._set(Vector3d(force.x, force.y, force.z), Vector3d(torque.x, torque.y, torque.z))

    def _set(self, force: Vector3d, torque: Vector3d) -> None:
        self.wrench[:] = (*force, *torque)
        self.applied = float(any(self.wrench))

    @law
    def OnUpdate(self) -> None:
        """Apply the wrench, if there is one; else the link may sleep."""
        if ends(self.applied <= 0.0):
            return
        values = [self.wrench[i] for i in range(6)]
        force, torque = Vector3d(*values[:3]), Vector3d(*values[3:])
        if self.given.forceFrame == "link":
            self.link.AddRelativeForce(force)
            self.link.AddRelativeTorque(torque)
        else:
            self.link.AddForce(force)
            self.link.AddTorque(torque)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosForce)
