"""gazebo_ros_control: holds a robot's joints, where there is no controller of ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosControl(ModelPlugin):
    """Stands for the controllers of ROS: joints are commanded by JointCmd messages.

    `libgz joint -m MODEL -j JOINT --pos-t 0.5` sends one. Elements have no effect.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Make the joint controller, which subscribes."""
        self.controller = model.GetJointController()


GZ_REGISTER_MODEL_PLUGIN(GazeboRosControl)
