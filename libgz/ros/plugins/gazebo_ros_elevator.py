"""gazebo_ros_elevator: brings an elevator to the floors that a topic names."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._elevator import ElevatorPlugin
from libgz.ros.plugin import Endpoint, Parameter, RosPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosElevator(RosPlugin, ElevatorPlugin):
    """An ElevatorPlugin, with its elements, that takes numbers of floors."""

    parameters = (
        Parameter("topic", "elevator", "floors"),
        Parameter("bottomFloor", -math.inf, "in ROS 2: the lowest one that is taken"),
        Parameter("topFloor", math.inf, "in ROS 2: the highest one"),
    )
    endpoints = (Endpoint("subscribes", "<topic>", "std_msgs/String"),)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and subscribe."""
        self.open(sdf, model.GetName())
        if not sdf.HasElement("topic"):
            sdf = sdf.Clone()
            sdf.AddElement("topic").Set(self.given.topic)
        super().Load(model, sdf)
        self.floors = self.subscribe(self.given.topic, "std_msgs/String", self.OnRequest)

    def MoveToFloor(self, floor: int) -> None:
        """Begin a trip to a floor; in ROS 2, not to one out of range."""
        if self.two and not self.given.bottomFloor <= floor <= self.given.topFloor:
            self.ros.log_refusal(self.given.topic, f"there is no floor {floor}")
            return
        super().MoveToFloor(floor)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosElevator)
