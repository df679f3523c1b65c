"""gazebo_ros_joint_state_publisher: positions and velocities of joints."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError
from libgz.base.law import law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import find_joint
from libgz.ros.packed import PackedMessage
from libgz.ros.plugin import Endpoint, Parameter, Publishing, Rate, Ticks
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.ros")


class GazeboRosJointStatePublisher(Publishing, ModelPlugin):
    """Publishes positions and velocities of joints, without efforts."""

    STATE = ("ticks",)

    own_namespace = True
    parameters = (
        Parameter("jointName", [], "names of joints, separated by commas; none: all that move"),
        Parameter("updateRate", Rate(100.0), "[Hz]; 0: each iteration"),
    )
    endpoints = (Endpoint("publishes", "joint_states", "sensor_msgs/JointState"),)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and advertise."""
        self.open(sdf, model.GetName())
        self.world = model.GetWorld()
        names = self.given.jointName
        self.joints = [joint for name in names if (joint := self._joint(model, name)) is not None]
        if not names:
            self.joints = [joint for joint in model.all_joints() if joint.DOF()]
        self.ticks = Ticks(self.given.updateRate)
        zeros = [0.0] * len(self.joints)
        message = message_type("sensor_msgs/JointState")(name=[joint.GetName() for joint in self.joints])
        message.position, message.velocity = zeros, zeros
        self.message = PackedMessage(self.advertise("joint_states", "sensor_msgs/JointState", 1000), message)
        self.lawful = not self.two
        self.run()

    def _joint(self, model: Model, name: str) -> Joint | None:
        """A joint; in ROS 2, None where there is none, with an error in the log.

        Raises:
            NotFoundError: there is none, in ROS 1.
        """
        try:
            return find_joint(model, name)
        except NotFoundError as error:
            if not self.two:
                raise
            log.error("%s: %s; the other joints are published", self.handleName, error)
            return None

    @law
    def work(self, now: Any) -> None:
        """Publish."""
        message = self.message
        message.stamp(now)
        message.put("position", [joint.Position(0) for joint in self.joints])
        message.put("velocity", [joint.GetVelocity(0) for joint in self.joints])
        message.send()


GZ_REGISTER_MODEL_PLUGIN(GazeboRosJointStatePublisher)
