"""gazebo_ros2_control: the controllers of ros2_control for a robot."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.ros.control.ros2 import SERVICES, ControllerManager2, RobotHardware2
from libgz.ros.own_node import remappings
from libgz.ros.parameters import Parameters
from libgz.ros.plugin import Endpoint, Parameter, bounded_rate
from libgz.ros.plugins._control import RobotControl

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.ros")

UPDATE_RATE = 100.0  # [Hz] unless the parameter update_rate of controller_manager is given


class GazeboRos2Control(RobotControl):
    """Serves a controller manager for the joints of `<ros2_control>` in the robot description.

    It waits for the robot description on the topic of robot_state_publisher.
    """

    STATE = ()

    parameters = (
        Parameter("robotParam", "robot_description", "topic with the URDF, as robot_state_publisher publishes it"),
        Parameter("robotParamNode", "robot_state_publisher", "accepted without effect"),
        Parameter("holdJoints", True, "joints that no controller commands stand"),
        Parameter("parameters", [], "files of parameters, of controller_manager and of its controllers"),
    )
    endpoints = (
        Endpoint("subscribes", "<robotParam>", "std_msgs/String"),
        *(
            Endpoint("in ROS 2 serves", f"controller_manager/{name}", f"controller_manager_msgs/{kind}")
            for name, kind in SERVICES.items()
        ),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the parameters, and wait for the robot description."""
        self.begin(model, sdf)
        self.values = Parameters()
        for name in self.given.parameters:
            self.values.read(Path(name))
        rate = self.values.of(f"{self.space}/controller_manager").get("update_rate", UPDATE_RATE)
        if not self.two:
            log.warning("gazebo_ros2_control needs ROS 2; its controllers are not there")
            return
        meaning = "joints that no controller commands stand; read when the robot description comes"
        self.node_parameters.declare("hold_joints", self.given.holdJoints, meaning)
        self.rules = tuple(remappings(sdf))
        topic = self.given.robotParam
        self.description = self.subscribe(topic, "std_msgs/String", self.OnDescription, durability="transient_local")
        what = f"parameter {self.space}/controller_manager/update_rate"
        self.run(bounded_rate(rate, what) if isinstance(rate, int | float) else UPDATE_RATE)

    @property
    def held(self) -> bool:
        """Whether joints that nothing commands stand."""
        return bool(self.node_parameters.value("hold_joints"))

    def look(self, _now: float) -> None:
        """Let all joints stand until the robot description says which are commanded: the original stops the world."""
        if self.held:
            for joint in self.model.GetJoints():
                for axis in range(joint.DOF()):
                    joint.SetVelocity(axis, 0.0)

    def OnDescription(self, message: Any) -> None:
        """The robot description has come."""
        if self.manager is not None:
            return
        try:
            gains = self.values.of(self.own_node.full_name if self.own_node else "").get("pid_gains")
            hardware = self.hardware = RobotHardware2(
                self.model, message.data, gains if isinstance(gains, Mapping) else {}, self.held
            )
            now = self.world.core.GetSimTime
            self.manager = ControllerManager2(hardware, self.ros, self.space, now, self.values, self.rules)
        except GazeboError as error:
            log.error("gazebo_ros2_control: %s", error)
            self.hardware = None


GZ_REGISTER_MODEL_PLUGIN(GazeboRos2Control)
