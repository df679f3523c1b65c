"""gazebo_ros_harness: lowers a model by a winch, and lets it loose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._harness import HarnessPlugin
from libgz.ros.plugin import Endpoint, RosPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosHarness(RosPlugin, HarnessPlugin):
    """A HarnessPlugin, with its elements, that takes the winch's velocity [m/s], and true to detach."""

    endpoints = (
        Endpoint("subscribes", "/<model>/harness/velocity", "std_msgs/Float32"),
        Endpoint("subscribes", "/<model>/harness/detach", "std_msgs/Bool"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Make the joints, and subscribe."""
        super().Load(model, sdf)
        self.open(sdf, model.GetName())
        topic = f"/{model.GetName()}/harness"
        self.velocities = self.subscribe(
            f"{topic}/velocity", "std_msgs/Float32", lambda message: self.SetWinchVelocity(message.data)
        )
        self.detachings = self.subscribe(
            f"{topic}/detach", "std_msgs/Bool", lambda message: self.Detach() if message.data else None
        )


GZ_REGISTER_MODEL_PLUGIN(GazeboRosHarness)
