"""gazebo_ros_wheel_slip: lets wheels slip as tires do, and says how much they slip."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._wheelslip import WheelSlipPlugin
from libgz.ros.plugin import Endpoint, Parameter, Rate, RosPlugin, Ticks
from libgz.ros.reconfigure import Knob
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WAYS = ("lateral", "longitudinal")
KNOBS = tuple(
    Knob(f"slip_compliance_unitless_{way}", -1.0, -1.0, 20.0, f"{way} slip compliance of all wheels; below 0: as it is")
    for way in WAYS
)


class GazeboRosWheelSlip(RosPlugin, WheelSlipPlugin):
    """A WheelSlipPlugin, with its elements, that publishes the slips in ROS 2.

    In ROS 1, tools of dynamic_reconfigure set the slip compliances below `/<model>/wheel_slip`, or
    `/<model>/<robotNamespace>`.
    In ROS 2, its node has the parameters ``slip_compliance_unitless_lateral/WHEEL`` and ``..._longitudinal/WHEEL``, and
    without a wheel those for all wheels. Wheels are named by their links.
    """

    parameters = (
        Parameter("publisherUpdateRate", Rate(100.0), "of the slips [Hz]"),
        Parameter("wheelSpinTolerance", 1e-3, "speed of a wheel below which its slips are zero [m/s]"),
    )
    endpoints = (
        Endpoint("in ROS 1 serves", "/<model>/wheel_slip/set_parameters", "dynamic_reconfigure/Reconfigure"),
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
        compliances = {tire.name: (tire.lateral, tire.longitudinal) for tire in self.tires}
        for at, setter in enumerate((self.SetSlipComplianceLateral, self.SetSlipComplianceLongitudinal)):
            self._declare(WAYS[at], {name: both[at] for name, both in compliances.items()}, setter)
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

    def _declare(self, way: str, compliances: dict[str, float], setter: Callable[[str, float], None]) -> None:
        """Declare the parameters of one way, with the compliances of the wheels."""
        own, name = self.node_parameters, f"slip_compliance_unitless_{way}"

        def set_all(value: float) -> None:
            for wheel in compliances:
                setter(wheel, value)
                own.set(f"{name}/{wheel}", value)

        meaning = f"{way} slip ratio for a force as large as that on the ground"
        every = own.declare(name, float, f"{meaning}, of all wheels", _check_compliance, set_all)
        for wheel, compliance in compliances.items():
            default = compliance if every is None else every
            value = own.declare(f"{name}/{wheel}", default, meaning, _check_compliance, partial(setter, wheel))
            if value != compliance:
                _check_compliance(value)
                setter(wheel, value)

    def OnPublish(self, info: UpdateInfo) -> None:
        """Publish the slips, if it is time."""
        if not self.slips.listened or not self.ticks.due(self.world.core.GetSimTime()):
            return
        message = message_type("gazebo_msgs/WheelSlip", 2)()
        for name, slip in sorted(self.GetSlips().items()):
            rim, turns = slip.Z(), abs(slip.Z()) >= self.given.wheelSpinTolerance and slip.Z() != 0.0
            message.name.append(name)
            message.lateral_slip.append(math.atan2(slip.Y(), slip.X() + rim) if turns else 0.0)
            message.longitudinal_slip.append(-slip.X() / rim if turns else 0.0)
        self.slips.publish(message)


def _check_compliance(value: float) -> None:
    if not value >= 0.0:
        raise ParameterError("Slip compliance values cannot be negative")


GZ_REGISTER_MODEL_PLUGIN(GazeboRosWheelSlip)
