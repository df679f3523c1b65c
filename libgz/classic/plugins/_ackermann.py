"""AckermannDrive: drives a car with two steered wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import PID, Quaterniond, Vector3d
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import ModelPlugin
from libgz.classic.plugins._ros import ros_elements, ros_joints, ros_rate, ros_topic
from libgz.classic.plugins._wheels import radius_of, separation
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

__all__ = ["AckermannDrive"]

PARTS = ("frontLeft", "frontRight", "rearLeft", "rearRight", "leftSteering", "rightSteering")


class AckermannDrive(ModelPlugin):
    """Turns the rear wheels, and steers the front wheels about one point, as torques of PID controllers.

    The command topic takes a Pose: x of the position is the speed [m/s], yaw of the orientation the angle of a wheel in
    the middle between the front wheels, left positive [rad]. Odometry, the pose in the world, is a PoseStamped.

    Elements, as in ROS 2:
        front_left_joint, front_right_joint, rear_left_joint, rear_right_joint: of the wheels.
        left_steering_joint, right_steering_joint: turn about the first axis.
        steering_wheel_joint: turned in proportion, if it is there.
        max_steer: greatest angle of a front wheel [rad] (0.6).
        max_steering_angle: that of the steering wheel [rad] (7.85).
        max_speed: [m/s] (20).
        left_steering_pid_gain, right_steering_pid_gain, linear_velocity_pid_gain: p, i, d (0 0 0); of the speed, the
            error is a rate of wheels [rad/s].
        left_steering_i_range, right_steering_i_range, linear_velocity_i_range: limits of their integral terms (0 0).
        update_rate: of odometry [Hz] (100).
        `<ros>` with namespace and remapping of cmd_vel and odom.
    """

    STATE: tuple[str, ...] = ("command", "rate", "pids", "last")

    command: tuple[float, ...]

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: the wheels have no radius, or the axles are in one place.
        """
        sdf = ros_elements(sdf)
        self.find(model, sdf)
        self.rate = UpdateRate(ros_rate(model, sdf, 100.0))
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, ros_topic(model, sdf, "odometryTopic", "odom"))
        self.subscriber = self.node.Subscribe(ros_topic(model, sdf, "commandTopic", "cmd_vel"), self.OnCmd)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.Reset()

    def find(self, model: Model, sdf: Element) -> None:
        """Find the joints, and read the limits and gains.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: the wheels have no radius, or the axles are in one place.
        """
        self.model = model
        names = {part: ros_joints(model, sdf, f"{part}Joint", f"{part}_joint")[0] for part in PARTS}
        self.rear = (names["rearLeft"], names["rearRight"])
        self.steered = (names["leftSteering"], names["rightSteering"])
        self.wheel = model.GetJoint(sdf.Get(str, "steeringWheelJoint").strip())
        self.radius = radius_of(names["rearRight"].GetChild())
        front, rear = names["frontRight"].Anchor(0), names["rearRight"].Anchor(0)
        self.base, self.track = front.Distance(rear), separation(names["frontLeft"], names["frontRight"])
        if not (self.radius > 0.0 and self.base > 0.0):
            raise ParameterError(
                f"{sdf.where}: wheels have radius {self.radius:g} m, axles a distance of {self.base:g} m"
            )
        self.most = sdf.Get(float, "maxSteer", 0.6)[0], sdf.Get(float, "maxSpeed", 20.0)[0]
        turn = sdf.Get(float, "maxSteeringAngle", 7.85)[0]
        self.ratio = turn / self.most[0] if self.most[0] else 0.0  # 0: a car that does not steer
        names_of_pids = ("leftSteering", "rightSteering", "linearVelocity")
        self.pids = [self._pid(sdf, name) for name in names_of_pids]

    @staticmethod
    def _pid(sdf: Element, name: str) -> PID:
        p, i, d = sdf.Get(Vector3d, f"{name}PidGain")
        low, high, _ = sdf.Get(Vector3d, f"{name}IRange")
        return PID(p, i, d, max(low, high), min(low, high))

    def Reset(self) -> None:
        """Stop, with the wheels straight."""
        self.command, self.last = (0.0, 0.0), 0.0  # speed [m/s] and angle [rad]; time of the last update [s]
        self.rate.last = -math.inf
        for pid in self.pids:
            pid.Reset()

    def OnCmd(self, message: Any) -> None:
        """A new command."""
        self.obey(message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw())

    def obey(self, speed: float, angle: float) -> None:
        """Take a command [m/s], [rad]; one that is not finite is left out."""
        if math.isfinite(speed) and math.isfinite(angle):
            steer, fast = self.most
            self.command = max(-fast, min(fast, speed)), max(-steer, min(steer, angle))

    def angles(self) -> tuple[float, float]:
        """The angles of the left and the right wheel that turn about the same point [rad]."""
        tangent, half = math.tan(self.command[1]), self.track / 2.0 / self.base
        return math.atan2(tangent, 1.0 - half * tangent), math.atan2(tangent, 1.0 + half * tangent)

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the efforts; publish odometry, if it is time."""
        now = info.simTime.Double()
        self.drive(now)
        if self.rate.due(now):
            message = msgs.PoseStamped()
            msgs.Set(message.time, info.simTime)
            msgs.Set(message.pose, self.model.WorldPose())
            self.publisher.Publish(message)

    def drive(self, now: float) -> None:
        """Apply the efforts of sim time `now` [s]."""
        step, self.last = now - self.last, now
        left, right, drive = self.pids
        rate = sum(joint.GetVelocity(0) for joint in self.rear) / 2.0
        effort = drive.Update(rate - self.command[0] / self.radius, step)
        for joint in self.rear:
            joint.SetForce(0, effort)
        for joint, pid, angle in zip(self.steered, (left, right), self.angles(), strict=True):
            joint.SetForce(0, pid.Update(joint.Position(0) - angle, step))
        if self.wheel is not None:
            self._turn(self.wheel)

    def _turn(self, wheel: Joint) -> None:
        """Turn the steering wheel with the mean of the front wheels."""
        wheel.SetPosition(0, self.ratio * sum(joint.Position(0) for joint in self.steered) / 2.0, True)
