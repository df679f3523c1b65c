"""gazebo_ros_vacuum_gripper: a link that pulls links near it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from libgz.base.law import Number, law
from libgz.classic.math import Pose3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, Periodic, Ticks
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.ros")

STRONGEST = 20.0  # [N]
TOUCHING = 0.01  # [m]; nearer links are moved into the gripper


class GazeboRosVacuumGripper(Periodic, ModelPlugin):
    """While it is on, a force of 1 N m / distance, at most 20 N, pulls links of other models that are near.

    They move as the gripper does; one that touches it is held. In ROS 2, a force of 1 N pulls them, and nothing else.
    """

    STATE = ("enabled", "active")

    active = Number()  # 1: there is something to do

    parameters = (
        Parameter("bodyName", "", "the link (in ROS 2 link_name)"),
        Parameter("linkName", "", "in ROS 2: the link"),
        Parameter("topicName", "grasping", "whether a link is within reach"),
        Parameter("maxDistance", 0.05, "how near the origins of links must be [m]"),
        Parameter("fixed", [], "names of models that are left alone"),
    )
    endpoints = (
        Endpoint("publishes", "<topicName>", "std_msgs/Bool"),
        Endpoint("serves", "on", "std_srvs/Empty"),
        Endpoint("serves", "off", "std_srvs/Empty"),
        Endpoint("in ROS 2 serves", "switch", "std_srvs/SetBool"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, advertise and serve."""
        self.open(sdf, model.GetName())
        given, self.world, self.ticks = self.given, model.GetWorld(), Ticks(0.0)
        self.link = named_link(model, ros_elements(sdf), "linkName" if given.linkName else "bodyName")
        self.fixed, self.enabled = {model.GetName(), *given.fixed}, False
        self.publication = self.publish(given.topicName, "std_msgs/Bool", changed=self.match)
        if self.two:
            self.services = [self.serve("switch", "std_srvs/SetBool", self._switch_to)]
        else:
            self.services = [self.serve(name, "std_srvs/Empty", self._switch(name == "on")) for name in ("on", "off")]
        self.match()
        self.run()

    def _switch(self, value: bool) -> Any:
        def switch(_request: Any) -> Any:
            if self.enabled == value:
                log.warning("%s: already status is %r", self.handleName, "on" if value else "off")
            self.enabled = value
            self.match()
            return self.services[0].kind.response()

        return switch

    def _switch_to(self, request: Any) -> Any:
        same = self.enabled == bool(request.data)
        self.enabled = bool(request.data)
        self.match()
        return self.services[0].kind.response(success=not same, message="already so" if same else "")

    def Reset(self) -> None:
        """Switch off."""
        self.enabled = False
        self.match()

    @law
    def wanted(self) -> Any:
        """While it is on, or somebody listens."""
        return self.active > 0.0

    def match(self) -> None:
        """Note whether there is something to do."""
        self.active = float(self.enabled or self.publication.listened)

    def work(self, now: float) -> None:
        """Pull, and publish."""
        grasping = self.enabled and self._pull()
        if self.publication.listened:
            self.publication.publish(message_type("std_msgs/Bool")(data=grasping))

    def _pull(self) -> bool:
        """Pull all links within reach; whether there are any."""
        found, pose = False, self.link.WorldPose()
        for model in self.world.Models():
            if model.GetName() in self.fixed:
                continue
            for link in model.GetLinks():
                away = pose.Pos() - link.WorldPose().Pos()
                distance = away.Length()
                if distance >= self.given.maxDistance:
                    continue
                found = True
                if model.IsStatic():
                    continue
                if self.two:
                    link.AddForce(away.Normalized())
                    continue
                link.SetLinearVel(self.link.WorldLinearVel())
                link.SetAngularVel(self.link.WorldAngularVel())
                if distance < TOUCHING:
                    link.SetWorldPose(Pose3d(pose.Pos(), link.WorldPose().Rot()))
                if distance > 0.0:
                    link.AddForce(away / distance * min(1.0 / distance, STRONGEST))
        return found


GZ_REGISTER_MODEL_PLUGIN(GazeboRosVacuumGripper)
