"""SegwayRMP: a platform on two wheels side by side, which falls over unless it balances.

Its source is lost, but for the names of its bodies. Footprint, wheels and track are those published for the real RMP
200 (64 x 61 cm, 48 cm, 54 cm); the layout of bodies and the gains of the balance were chosen for libgz.
"""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.geometry import GzColor, GzQuaternInverse, GzQuaternToEuler, rotate
from libgz.interfaces.position import PositionData
from libgz.models.drive import DifferentialRobot
from libgz.models.parts import DARK, GREY, fit
from libgz.models.robot import RobotAttributes, clamp
from libgz.models.wheels import Tire
from libgz.ode.types import dParamHiStop, dParamLoStop
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.physics.joint import HingeJoint, SliderJoint

TIRE = Tire(0.24, 0.05, 5.0, DARK, hard=True)
TOP_PLATE = (0.0, 0.0, 0.70)  # [m]

# Torque of both wheels together [N m]: per metre of lag behind, per m/s too fast, per radian and rad/s of leaning.
PLACE_GAIN, SPEED_GAIN, PITCH_GAIN, PITCH_RATE_GAIN = 10.0, 33.0, 144.0, 29.0
# Difference of the wheels' torques: per rad/s of error, of its integral, of its derivative.
TURN_GAIN, TURN_INTEGRAL_GAIN, TURN_DERIVATIVE_GAIN = 2.0, 0.02, 0.1
MAX_TORQUE = 80.0  # [N m], both wheels together
MAX_SPEED, MAX_TURN = 1.5, 1.4  # [m/s], [rad/s]
MAX_LAG = 1.0  # [m]; held up longer than this it does not push harder
FALLEN = math.radians(60.0)  # leaning so far it gives up


class SegwayRMP(DifferentialRobot):
    """A base and a `topPlate` on two wheels; the origin is on the ground under the axle.

    Serves position, with the pitch in rot[1]. It balances from the first step on; with its motors off it falls.
    Dimensions as published for the real machine; layout chosen for libgz.
    """

    attributes: ClassVar[type[RobotAttributes]] = RobotAttributes
    wheelSep, wheelDiam = 0.54, 0.48
    maxTorque = MAX_TORQUE / 2.0

    def build(self) -> None:  # noqa: D102
        base = Body(self.world)
        self.AddBody(base, True)
        fit(BoxGeom(base, self.modelSpaceId, 0.22, 0.42, 0.22), (0.0, 0.0, 0.36), 22.0, GREY)
        plate = Body(self.world, "topPlate")
        self.AddBody(plate)
        fit(BoxGeom(plate, self.modelSpaceId, 0.45, 0.45, 0.02), (0.0, 0.0, 0.0), 8.0, GzColor(0.8, 0.8, 0.2))
        plate.SetPosition(TOP_PLATE)
        slider = SliderJoint(self.world, name="topPlate")
        slider.Attach(plate, base)
        slider.SetAxis(0.0, 0.0, 1.0)
        slider.SetParam(dParamLoStop, 0.0)
        slider.SetParam(dParamHiStop, 0.0)
        self.add_wheel("left", (0.0, 0.27, 0.24), TIRE)
        self.add_wheel("right", (0.0, -0.27, 0.24), TIRE)
        self.pitch = self.pitchRate = 0.0  # of the base [rad], [rad/s]; leaning forward positive
        self._lag = 0.0  # how far it is ahead of where its commands should have taken it [m]
        self._turn_error = self._turn_error_sum = 0.0

    def wheel_rates(self) -> tuple[float, float]:
        """How fast the wheels roll on the ground [rad/s]: as fast as they turn in the base, and the base itself."""
        left, right = super().wheel_rates()
        return left + self.pitchRate, right + self.pitchRate

    def measure(self, step: float) -> None:
        """Attitude, then odometry."""
        base = self.GetBody()
        rotation = base.GetRotation()
        self.pitch = GzQuaternToEuler(rotation).y
        self.pitchRate = rotate(GzQuaternInverse(rotation), base.GetAngularRate()).y
        super().measure(step)

    def publish(self, data: PositionData) -> None:
        """Odometry and pitch."""
        super().publish(data)
        data.rot[1], data.vel_rot[1] = self.pitch, self.pitchRate

    def run(self, speed: float, turn: float) -> None:
        """The wheels have no speed of their own: `act` drives them by torques."""

    def act(self, step: float) -> None:
        """Balance."""
        up = rotate(self.GetBody().GetRotation(), (0.0, 0.0, 1.0)).z
        if not self.enabled or up < math.cos(FALLEN):
            self._lag = self._turn_error = self._turn_error_sum = 0.0
            return
        forward, turn = self._torques(step)
        for wheels, torque in ((self.left, (forward - turn) / 2.0), (self.right, (forward + turn) / 2.0)):
            for wheel in wheels:
                if isinstance(wheel.joint, HingeJoint):
                    wheel.joint.SetTorque(torque)

    def _torques(self, step: float) -> tuple[float, float]:
        """What both wheels together, and one against the other, have to give [N m]."""
        speed, turn = self.wanted
        speed, turn = clamp(speed, MAX_SPEED), clamp(turn, MAX_TURN)
        excess = self.velocity[0] - speed
        self._lag = clamp(self._lag + excess * step, MAX_LAG)
        forward = (
            PLACE_GAIN * self._lag + SPEED_GAIN * excess + PITCH_GAIN * self.pitch + PITCH_RATE_GAIN * self.pitchRate
        )
        error = turn - self.velocity[1]
        self._turn_error_sum = clamp(self._turn_error_sum + error * step, 1.0 / TURN_INTEGRAL_GAIN)
        sideways = (
            TURN_GAIN * error
            + TURN_INTEGRAL_GAIN * self._turn_error_sum
            + TURN_DERIVATIVE_GAIN * (error - self._turn_error) / step
        )
        self._turn_error = error
        return clamp(forward, MAX_TORQUE), clamp(sideways, MAX_TORQUE)
