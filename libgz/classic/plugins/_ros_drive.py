"""RosDrive: base class of the drives of the ROS era."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.math import Pose3d, Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugins._position_drive import PositionDrive, positive
from libgz.classic.plugins._ros import ros_elements, ros_rate, ros_topic

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

__all__ = ["RosDrive"]


class RosDrive(PositionDrive):
    """Drives a model by a topic or its position interface, and publishes odometry."""

    STATE = ("present",)

    present = (0.0, 0.0)  # commanded speeds of the left and the right side [m/s]

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, create interface and topics."""
        sdf = ros_elements(sdf)
        left, right = self.wheels(model, sdf)
        torque = "wheelTorque" if sdf.HasElement("wheelTorque") else "torque"
        rate = ros_rate(model, sdf, 100.0)
        self.acceleration = sdf.Get(float, "wheelAcceleration", 0.0)[0]
        self.period = 1.0 / rate
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, ros_topic(model, sdf, "odometryTopic", "odom"))
        self.subscriber = self.node.Subscribe(
            ros_topic(model, sdf, "commandTopic", "cmd_vel"), self.OnVelMsg, kind="Pose"
        )
        self.serve(
            model,
            left,
            right,
            torque=positive(sdf, torque, 5.0),
            rate=rate,
            name=model.GetName(),
            diameter=positive(sdf, "wheelDiameter", 0.0) if sdf.HasElement("wheelDiameter") else None,
            distance=positive(sdf, "wheelSeparation", 0.0) if sdf.HasElement("wheelSeparation") else None,
        )

    def wheels(self, model: Model, sdf: Element) -> tuple[list[Joint], list[Joint]]:
        """The joints of the left and the right side."""
        raise NotImplementedError

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        speed, turn = message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw()
        if math.isfinite(speed) and math.isfinite(turn):
            self.order(speed, turn)

    def Reset(self) -> None:
        """Set odometry and command to zero."""
        super().Reset()
        self.present = (0.0, 0.0)

    def run_wheels(self) -> None:
        """Set the wheels' speeds, which change at most by the acceleration."""
        speed, turn = self.command
        half, most = turn * self.separation / 2.0, self.acceleration * self.period
        wanted = (speed - half, speed + half)
        if most > 0.0:
            left, right = (max(v - most, min(w, v + most)) for w, v in zip(wanted, self.present, strict=True))
            wanted = (left, right)
        self.present = wanted
        for side, at in zip((self.left, self.right), wanted, strict=True):
            for wheel in side:
                wheel.run(at)

    def exchange(self, now: float) -> None:
        """Publish odometry on the topic, too."""
        super().exchange(now)
        x, y, yaw = self.odometry
        message = msgs.PoseStamped()
        msgs.Set(message.time, now)
        msgs.Set(message.pose, Pose3d(x, y, 0.0, 0.0, 0.0, yaw))
        self.publisher.Publish(message)
