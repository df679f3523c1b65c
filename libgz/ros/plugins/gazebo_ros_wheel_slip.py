"""gazebo_ros_wheel_slip: lets wheels slip as tires do, and says how much they slip."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._wheelslip import Tire, WheelSlipPlugin
from libgz.ros.plugin import Endpoint, Parameter, Rate, RosPlugin, Ticks
from libgz.ros.reconfigure import Knob
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from collections.abc import Mapping

    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

KNOBS = tuple(
    Knob(f"slip_compliance_unitless_{way}", -1.0, -1.0, 20.0, f"{way} slip compliance of all wheels; below 0: as it is")
    for way in ("lateral", "longitudinal")
)


class GazeboRosWheelSlip(RosPlugin, WheelSlipPlugin):
    """A WheelSlipPlugin, with its elements, that publishes the slips in ROS 2.

    In ROS 1, tools of dynamic_reconfigure set the slip compliances below `/<model>/wheel_slip`, or
    `/<model>/<robotNamespace>`.
    """

    parameters = (
        Parameter("publisherUpdateRate", Rate(100.0), "of the slips [Hz]"),
        Parameter("wheelSpinTolerance", 1e-3, "speed of a wheel below which its slips are zero [m/s]"),
    )
    endpoints = (
        Endpoint("serves", "/<model>/wheel_slip/set_parameters", "dynamic_reconfigure/Reconfigure"),
        Endpoint("in ROS 2 publishes", "wheel_slip", "gazebo_msgs/WheelSlip"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the wheels, and advertise."""
        super().Load(model, sdf)
        self.open(sdf, model.GetName())
        if not self.two:
            self.space = f"/{model.GetName()}/{self.space.strip('/') or 'wheel_slip'}"
            self.knobs = self.offer(KNOBS, self.OnReconfigure)
            self.OnReconfigure(self.knobs.values)
            return
        self.world, self.ticks = model.GetWorld(), Ticks(self.given.publisherUpdateRate)
        self.slips = self.publish("wheel_slip", "gazebo_msgs/WheelSlip", 10)
        self.publishing = Events.ConnectWorldUpdateBegin(self.OnPublish)

    def OnReconfigure(self, values: Mapping[str, Any]) -> None:
        """A tool has set the compliances."""
        lateral, longitudinal = (values[knob.name] for knob in KNOBS)
        if lateral >= 0.0:
            self.SetSlipComplianceLateral("", lateral)
        if longitudinal >= 0.0:
            self.SetSlipComplianceLongitudinal("", longitudinal)

    def OnPublish(self, info: UpdateInfo) -> None:
        """Publish the slips, if it is time."""
        if not self.slips.listened or not self.ticks.due(self.world.core.GetSimTime()):
            return
        message = message_type("gazebo_msgs/WheelSlip", 2)()
        for tire in sorted(self.tires, key=lambda one: one.name):
            lateral, longitudinal = self._slip(tire)
            message.name.append(tire.name)
            message.lateral_slip.append(lateral)
            message.longitudinal_slip.append(longitudinal)
        self.slips.publish(message)

    def _slip(self, tire: Tire) -> tuple[float, float]:
        """The angle between where a wheel goes and where it points [rad], and its slip ratio; 0 while it rests."""
        link, axis = tire.joint.GetChild(), tire.joint.DOF() - 1
        axle: Vector3d = tire.joint.GlobalAxis(axis)
        velocity = link.WorldLinearVel()
        ahead = axle.Cross(Vector3d(0.0, 0.0, 1.0))
        ahead = ahead.Normalized() if ahead.Length() > 0.0 else Vector3d(1.0, 0.0, 0.0)
        spin, along = tire.joint.GetVelocity(axis) * tire.radius, velocity.Dot(ahead)
        if spin == 0.0 or abs(spin) < self.given.wheelSpinTolerance:
            return 0.0, 0.0
        return math.atan2(velocity.Dot(axle), along), (spin - along) / spin


GZ_REGISTER_MODEL_PLUGIN(GazeboRosWheelSlip)
