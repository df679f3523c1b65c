"""gazebo_ros_control: the controllers of ros_control for a robot."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from libgz.base.errors import GazeboError
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.ros.control.hardware import RobotHardware
from libgz.ros.control.manager import SERVICES, ControllerManager
from libgz.ros.plugin import Endpoint, Parameter, Ticks, bounded_rate
from libgz.ros.plugins._control import RobotControl

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.ros")

RETRY = 2.0  # [Hz] of looks for the robot description


class GazeboRosControl(RobotControl):
    """Serves a controller manager for the joints of the transmissions in the robot description.

    It waits for the robot description.
    """

    STATE = ()

    parameters = (
        Parameter("robotParam", "robot_description", "parameter with the URDF, in the namespace or one around it"),
        Parameter("robotSimType", "gazebo_ros_control/DefaultRobotHWSim", "accepted without effect: the default one"),
        Parameter("controlPeriod", 0.0, "of the controllers [s]; 0: each iteration"),
        Parameter("legacyModeNS", False, "accepted without effect"),
    )
    endpoints = tuple(
        Endpoint("serves", f"controller_manager/{name}", f"controller_manager_msgs/{kind}")
        for name, kind in SERVICES.items()
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the robot description, or wait for it."""
        self.begin(model, sdf)
        self.retry = Ticks(RETRY)
        self._try()
        if self.manager is None:
            log.warning("gazebo_ros_control waits for model URDF in parameter [%s]", self.given.robotParam)
        period = self.given.controlPeriod
        self.run(bounded_rate(1.0 / period, f"{sdf.where}: 1 / <controlPeriod>") if period > 0.0 else 0.0)

    def look(self, now: float) -> None:
        """Look for the robot description, if it is time."""
        if self.retry.due(now):
            self._try()

    def _try(self) -> None:
        """Begin, if the robot description is there."""
        text = self.ros.search_parameter(self.given.robotParam, self.space)
        if isinstance(text, str) and text:
            try:
                self.hardware = RobotHardware(self.model, text, self.ros, self.space)
                self.manager = ControllerManager(self.hardware, self.ros, self.space, self.world.core.GetSimTime)
            except GazeboError as error:
                log.error("gazebo_ros_control: %s", error)
                self.hardware = None


GZ_REGISTER_MODEL_PLUGIN(GazeboRosControl)
