"""gazebo_ros_harness: lowers a model by a winch, and lets it loose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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
        Endpoint("subscribes", "/<model>/harness/detach", "std_msgs/Bool; in ROS 2 std_msgs/Empty, in the namespace"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Make the joints, and subscribe."""
        super().Load(model, sdf)
        self.open(sdf, model.GetName())
        topic = f"{model.GetName()}/harness" if self.two else f"/{model.GetName()}/harness"
        self.velocities = self.subscribe(
            f"{topic}/velocity", "std_msgs/Float32", lambda message: self.SetWinchVelocity(message.data)
        )
        kind = "std_msgs/Empty" if self.two else "std_msgs/Bool"
        self.detachings = self.subscribe(f"{topic}/detach", kind, self.OnDetach)

    def OnDetach(self, message: Any) -> None:
        """Let the model loose; in ROS 1, if the message says so."""
        if self.two or message.data:
            self.Detach()


GZ_REGISTER_MODEL_PLUGIN(GazeboRosHarness)
