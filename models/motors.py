"""The axes of joints with their motors, and servos that hold an axis at an angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from libgz.base.law import law
from libgz.ode.types import dParamFMax, dParamFMax2, dParamHiStop, dParamLoStop, dParamVel, dParamVel2
from libgz.physics.joint import HingeJoint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint

__all__ = ["Axis", "Servo", "mean"]


class Axis:
    """One axis of a hinge, a Hinge2 or a universal joint, with its motor.

    Args:
        joint: the joint.
        number: 1 or 2; 2 only of joints with two axes.

    Attributes:
        angle: a function, the angle of the axis [rad].
        rate: a function, its rate [rad/s].
        velocity, force: numbers of the joint parameters of its motor, `dParamVel` and `dParamFMax` or those of axis 2.
    """

    angle: Callable[[], float]
    rate: Callable[[], float]

    def __init__(self, joint: HingeJoint | Hinge2Joint | UniversalJoint, number: int = 1) -> None:
        self.joint = joint
        self.velocity, self.force = (dParamVel, dParamFMax) if number == 1 else (dParamVel2, dParamFMax2)
        if isinstance(joint, HingeJoint):
            self.angle, self.rate = joint.GetAngle, joint.GetAngleRate
        elif isinstance(joint, Hinge2Joint):
            first, second = (joint.GetAngle1, joint.GetAngle1Rate), (joint.GetAngle2, joint.GetAngle2Rate)
            self.angle, self.rate = first if number == 1 else second
        else:
            first, second = (joint.GetAngle1, joint.GetAngleRate1), (joint.GetAngle2, joint.GetAngleRate2)
            self.angle, self.rate = first if number == 1 else second


class Servo:
    """Moves an axis to an angle: the motor's velocity is proportional to the error.

    Args:
        axis: the axis to turn.
        gain: velocity per radian of error [1/s].
        torque: maximum torque of the motor [N m].
        damping: share of the present rate that is subtracted from the velocity.
        stop: joint stops at +-stop [rad]; without it the joint's stops stay as they are.
    """

    def __init__(self, axis: Axis, gain: float, torque: float, damping: float = 0.0, stop: float | None = None) -> None:
        self.axis, self.gain, self.damping = axis, gain, damping
        self.angle = axis.angle
        self._set, self._velocity = axis.joint.SetParam, axis.velocity
        if stop is not None:
            axis.joint.SetParam(dParamLoStop, -stop)
            axis.joint.SetParam(dParamHiStop, stop)
        axis.joint.SetParam(axis.force, torque)

    @law
    def turn_to(self, angle: float) -> None:
        """Set the motor's velocity towards an angle [rad]; call it every step."""
        velocity = self.gain * (angle - self.angle())
        if self.damping:
            velocity -= self.damping * self.axis.rate()
        self._set(self._velocity, velocity)


def mean(values: Sequence[float]) -> float:
    """The mean of numbers, added in their order."""
    total = 0.0
    for value in values:
        total += value
    return total / len(values)
