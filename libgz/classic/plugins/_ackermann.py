"""AckermannWheels: the wheels of a car with two steered wheels, and what turns them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.math import PID, Vector3d
from libgz.classic.plugins._ros import ros_joints
from libgz.classic.plugins._wheels import radius_of, separation

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

__all__ = ["AckermannWheels"]

PARTS = ("frontLeft", "frontRight", "rearLeft", "rearRight", "leftSteering", "rightSteering")


class AckermannWheels:
    """Turns the rear wheels, and steers the front wheels about one point, as torques of PID controllers.

    Args:
        model: the model.
        sdf: the plugin's element, with names as in ROS.

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

    Attributes:
        joints: of the rear wheels, of the front wheels, those that steer, and that of the steering wheel, if there is
            one.

    Raises:
        NotFoundError: there is no such joint.
        ParameterError: the wheels have no radius, or the axles are in one place.
    """

    STATE = ("command", "pids", "last")

    def __init__(self, model: Model, sdf: Element) -> None:
        names = {part: ros_joints(model, sdf, f"{part}Joint", f"{part}_joint")[0] for part in PARTS}
        self.rear = (names["rearLeft"], names["rearRight"])
        self.steered = (names["leftSteering"], names["rightSteering"])
        self.wheel = model.GetJoint(sdf.Get(str, "steeringWheelJoint").strip())
        front = (names["frontLeft"], names["frontRight"])
        self.joints = [*self.rear, *front, *self.steered, *([self.wheel] if self.wheel is not None else [])]
        self.radius = radius_of(names["rearRight"].GetChild())
        self.base = names["frontRight"].Anchor(0).Distance(names["rearRight"].Anchor(0))
        self.track = separation(*front)
        if not (self.radius > 0.0 and self.base > 0.0):
            raise ParameterError(
                f"{sdf.where}: wheels have radius {self.radius:g} m, axles a distance of {self.base:g} m"
            )
        self.most = sdf.Get(float, "maxSteer", 0.6)[0], sdf.Get(float, "maxSpeed", 20.0)[0]
        turn = sdf.Get(float, "maxSteeringAngle", 7.85)[0]
        self.ratio = turn / self.most[0] if self.most[0] else 0.0  # 0: a car that does not steer
        names_of_pids = ("leftSteering", "rightSteering", "linearVelocity")
        self.pids = [self._pid(sdf, name) for name in names_of_pids]
        self.stop(0.0)

    @staticmethod
    def _pid(sdf: Element, name: str) -> PID:
        p, i, d = sdf.Get(Vector3d, f"{name}PidGain")
        low, high, _ = sdf.Get(Vector3d, f"{name}IRange")
        return PID(p, i, d, max(low, high), min(low, high))

    def stop(self, now: float) -> None:
        """Stop, with the wheels straight, at sim time `now` [s]."""
        self.command: tuple[float, float] = (0.0, 0.0)  # speed [m/s] and angle [rad]
        self.last = now  # of the last efforts [s]
        for pid in self.pids:
            pid.Reset()

    def obey(self, speed: float, angle: float) -> None:
        """Take a command [m/s], [rad]; one that is not finite is left out."""
        if math.isfinite(speed) and math.isfinite(angle):
            steer, fast = self.most
            self.command = max(-fast, min(fast, speed)), max(-steer, min(steer, angle))

    def angles(self) -> tuple[float, float]:
        """The angles of the left and the right wheel that turn about the same point [rad]."""
        tangent, half = math.tan(self.command[1]), self.track / 2.0 / self.base
        return math.atan2(tangent, 1.0 - half * tangent), math.atan2(tangent, 1.0 + half * tangent)

    def angle(self) -> float:
        """The angle of a wheel in the middle of the front wheels now [rad]."""
        return sum(joint.Position(0) for joint in self.steered) / 2.0

    def drive(self, now: float) -> None:
        """Apply the efforts of sim time `now` [s], for one iteration."""
        step, self.last = now - self.last, now
        left, right, drive = self.pids
        rate = self.rear[1].GetVelocity(0)
        effort = drive.Update(rate - self.command[0] / self.radius, step)
        for joint, pid, angle in zip(self.steered, (left, right), self.angles(), strict=True):
            joint.SetForce(0, pid.Update(joint.Position(0) - angle, step))
        for joint in self.rear:
            joint.SetForce(0, effort)
        if self.wheel is not None:
            self.wheel.SetPosition(0, self.ratio * self.angle(), True)
