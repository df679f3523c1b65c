"""Wheels: their bodies, what they turn on, their motors, and how they are steered.

A wheel turns on a hinge, or on the second axis of a Hinge2 that carries suspension and steering in its first. Positive
rates roll it forward and positive angles steer it left, whatever it turns on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from libgz.geometry import GzColor, GzQuaternFromAxis, VectorLike
from libgz.legacy.model import Model
from libgz.models.parts import GREY, fit
from libgz.ode.types import (
    dParamFMax,
    dParamFMax2,
    dParamHiStop,
    dParamLoStop,
    dParamSuspensionCFM,
    dParamSuspensionERP,
    dParamVel,
    dParamVel2,
)
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, SphereGeom, WheelGeom
from libgz.physics.joint import BallJoint, HingeJoint
from libgz.physics.two_axes import Hinge2Joint

__all__ = [
    "HARD",
    "Steering",
    "Tire",
    "Wheel",
    "add_caster",
    "add_hinge",
    "add_steered_wheel",
    "add_tire",
    "on_hinge",
    "on_hinge2",
]

HARD = (1e5, 0.0)  # [N/m], [N s/m]: with the default tenth of it heavy robots sink by centimetres
SUSPENSION_ERP, SUSPENSION_CFM = 0.4, 1e-4


@dataclass(frozen=True)
class Tire:
    """What the wheels of a robot are like: radius and width of the tire [m], mass [kg], colour; hard or not."""

    radius: float
    width: float
    mass: float
    color: GzColor
    hard: bool = False


class Wheel:
    """The motor and the rate of a wheel."""

    def __init__(self, joint: HingeJoint | Hinge2Joint) -> None:
        self.joint = joint
        if isinstance(joint, Hinge2Joint):
            self.rate = joint.GetAngle2Rate  # rolling [rad/s], forward positive
            self._velocity, self._torque = dParamVel2, dParamFMax2
        else:
            self.rate = joint.GetAngleRate
            self._velocity, self._torque = dParamVel, dParamFMax

    def run(self, rate: float, torque: float) -> None:
        """Roll at a rate [rad/s], with a motor of so much torque [N m]."""
        self.joint.SetParam(self._velocity, rate)
        self.joint.SetParam(self._torque, torque)


class Steering:
    """Keeps the angle of a hinge, or of the first axis of a Hinge2, by a velocity in proportion to the error.

    Args:
        joint: what to turn.
        limit: the stops, +-[rad].
        gain: velocity per radian of error [1/s].
        torque: of the motor [N m].
        damping: share of the present rate that is taken off the velocity.
    """

    def __init__(
        self, joint: HingeJoint | Hinge2Joint, limit: float, gain: float, torque: float, damping: float = 0.0
    ) -> None:
        self.joint, self.gain, self.damping = joint, gain, damping
        if isinstance(joint, Hinge2Joint):
            self.angle, self._rate = joint.GetAngle1, joint.GetAngle1Rate  # [rad], left positive
        else:
            self.angle, self._rate = joint.GetAngle, joint.GetAngleRate
        joint.SetParam(dParamLoStop, -limit)
        joint.SetParam(dParamHiStop, limit)
        joint.SetParam(dParamFMax, torque)

    def turn_to(self, angle: float) -> None:
        """Turn towards an angle [rad]; to be called each step."""
        self.joint.SetParam(dParamVel, self.gain * (angle - self.angle()) - self.damping * self._rate())


def add_tire(model: Model, name: str, position: VectorLike, tire: Tire) -> Body:
    """A wheel's body at `position` in the model's frame [m], its outer side away from the middle."""
    body = Body(model.world, name)
    model.AddBody(body)
    geom = WheelGeom(body, model.modelSpaceId, tire.radius, tire.width)
    geom.SetMass(tire.mass)
    geom.SetColor(tire.color)
    if tire.hard:
        geom.SetHardness(*HARD)
    body.SetPosition(position)
    _, y, _ = position
    body.SetRotation(GzQuaternFromAxis(1.0, 0.0, 0.0, -math.pi / 2.0 if y > 0.0 else math.pi / 2.0))
    return body


def on_hinge(model: Model, wheel: Body, base: Body) -> Wheel:
    """Let a wheel roll on a hinge of a base."""
    return Wheel(add_hinge(model, wheel, base, wheel.GetPosition(), (0.0, 1.0, 0.0), wheel.bodyName))


def on_hinge2(model: Model, wheel: Body, chassis: Body, limit: float | None = 0.0) -> Wheel:
    """Let a wheel roll, and steer within +-limit [rad] or freely (None), on a sprung Hinge2 of a chassis."""
    joint = Hinge2Joint(model.world, name=wheel.bodyName)
    joint.Attach(chassis, wheel)
    joint.SetAnchor(wheel.GetPosition())
    # The chassis has to come first, which turns all signs about.
    joint.SetAxis1((0.0, 0.0, -1.0))
    joint.SetAxis2((0.0, -1.0, 0.0))
    joint.SetParam(dParamSuspensionERP, SUSPENSION_ERP)
    joint.SetParam(dParamSuspensionCFM, SUSPENSION_CFM)
    if limit is not None:
        joint.SetParam(dParamLoStop, -limit)
        joint.SetParam(dParamHiStop, limit)
    return Wheel(joint)


def add_hinge(
    model: Model, moving: Body, base: Body, anchor: VectorLike, axis: VectorLike, name: str | None = None
) -> HingeJoint:
    """A hinge between two bodies, at a point and about an axis of the model's frame."""
    hinge = HingeJoint(model.world, name=name)
    hinge.Attach(moving, base)
    hinge.SetAnchor(anchor)
    hinge.SetAxis(axis)
    return hinge


def add_steered_wheel(
    model: Model, name: str, position: VectorLike, tire: Tire, base: Body, limit: float, gain: float, torque: float
) -> tuple[Wheel, Steering]:
    """A wheel on a hinge of a stub that turns about a vertical hinge of a base; the numbers are those of `Steering`."""
    stub = Body(model.world, f"{name}_stub")
    model.AddBody(stub)
    fit(BoxGeom(stub, model.modelSpaceId, 0.03, 0.03, 0.03), (0.0, 0.0, 0.0), 0.1, GREY)
    stub.SetPosition(position)
    hinge = add_hinge(model, stub, base, position, (0.0, 0.0, 1.0), f"{name}_steering")
    wheel = on_hinge(model, add_tire(model, name, position, tire), stub)
    return wheel, Steering(hinge, limit, gain, torque)


def add_caster(
    model: Model,
    name: str,
    base: Body,
    position: VectorLike,
    radius: float,
    mass: float,
    color: GzColor,
    *,
    hard: bool = False,
    friction: float | None = None,
) -> Body:
    """A ball of radius [m] and mass [kg] in a ball joint under a base; it rolls every way."""
    caster = Body(model.world, name)
    model.AddBody(caster)
    ball = SphereGeom(caster, model.modelSpaceId, radius)
    ball.SetMass(mass)
    ball.SetColor(color)
    if hard:
        ball.SetHardness(*HARD)
    if friction is not None:
        ball.SetFriction(friction)
    caster.SetPosition(position)
    caster.SetRotation(GzQuaternFromAxis(1.0, 0.0, 0.0, math.pi / 2.0))
    joint = BallJoint(model.world, name=name)
    joint.Attach(caster, base)
    joint.SetAnchor(position)
    return caster
