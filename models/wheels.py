"""Wheels: their bodies, joints, motors and steering.

A wheel turns on a hinge, or on the second axis of a Hinge2 whose first axis has the suspension and the steering. With
both, positive rates roll the wheel forward and positive angles steer it left.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from libgz.base.geometry import GzColor, GzQuaternFromAxis, VectorLike
from libgz.legacy.model import Model
from libgz.models.motors import Axis, Servo
from libgz.models.parts import GREY, add_body, fit
from libgz.ode.types import dParamHiStop, dParamLoStop, dParamSuspensionCFM, dParamSuspensionERP
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, SphereGeom, WheelGeom
from libgz.physics.joint import BallJoint, HingeJoint
from libgz.physics.two_axes import Hinge2Joint

__all__ = [
    "HARD",
    "Tire",
    "Wheel",
    "add_caster",
    "add_hinge",
    "add_steered_wheel",
    "add_tire",
    "on_hinge",
    "on_hinge2",
]

HARD = (1e5, 0.0)  # [N/m], [N s/m]: ten times the default, with which heavy robots sink by centimetres
SUSPENSION_ERP, SUSPENSION_CFM = 0.4, 1e-4


class Tire(NamedTuple):
    """A kind of wheel: radius and width [m], mass [kg], colour, and whether its contacts have the hardness `HARD`."""

    radius: float
    width: float
    mass: float
    color: GzColor
    hard: bool = False


class Wheel:
    """A driven wheel.

    Attributes:
        axis: that it turns about.
        rate: a function, how fast the wheel rolls [rad/s], forward positive.
    """

    def __init__(self, axis: Axis) -> None:
        self.axis = axis
        self.joint, self.rate = axis.joint, axis.rate
        self._velocity, self._torque = axis.velocity, axis.force

    def run(self, rate: float, torque: float) -> None:
        """Roll at a rate [rad/s], with a motor of a maximum torque [N m]."""
        self.joint.SetParam(self._velocity, rate)
        self.joint.SetParam(self._torque, torque)


def add_tire(model: Model, name: str, position: VectorLike, tire: Tire) -> Body:
    """The body of a wheel at `position` in the model's frame [m], with its outer side away from the centre line."""
    body = add_body(model, name)
    geom = WheelGeom(body, model.modelSpaceId, tire.radius, tire.width)
    geom.SetMass(tire.mass)
    geom.SetColor(tire.color)
    if tire.hard:
        geom.SetHardness(*HARD)
    body.SetPosition(position)
    _, y, _ = position
    body.SetRotation(GzQuaternFromAxis(1.0, 0.0, 0.0, -math.pi / 2.0 if y > 0.0 else math.pi / 2.0))
    return body


def on_hinge(model: Model, wheel: Body, base: Body) -> HingeJoint:
    """Attach a wheel to a base by a hinge along y."""
    return add_hinge(model, wheel, base, wheel.GetPosition(), (0.0, 1.0, 0.0), wheel.bodyName)


def on_hinge2(model: Model, wheel: Body, chassis: Body, stop: float | None = 0.0) -> Hinge2Joint:
    """Attach a wheel to a chassis by a Hinge2 with suspension.

    Args:
        model: the robot.
        wheel: rolls about the second axis of the joint.
        chassis: the body that the first axis, steering and suspension, is fixed to.
        stop: the wheel steers within +-stop [rad]; None: without stops.
    """
    joint = Hinge2Joint(model.world, name=wheel.bodyName)
    joint.Attach(chassis, wheel)
    joint.SetAnchor(wheel.GetPosition())
    # A Hinge2 needs the chassis as its first body; that reverses all signs.
    joint.SetAxis1((0.0, 0.0, -1.0))
    joint.SetAxis2((0.0, -1.0, 0.0))
    joint.SetParam(dParamSuspensionERP, SUSPENSION_ERP)
    joint.SetParam(dParamSuspensionCFM, SUSPENSION_CFM)
    if stop is not None:
        joint.SetParam(dParamLoStop, -stop)
        joint.SetParam(dParamHiStop, stop)
    return joint


def add_hinge(
    model: Model, moving: Body, base: Body, anchor: VectorLike, axis: VectorLike, name: str | None = None
) -> HingeJoint:
    """A hinge between two bodies, at an anchor [m] and about an axis in the model's frame."""
    hinge = HingeJoint(model.world, name=name)
    hinge.Attach(moving, base)
    hinge.SetAnchor(anchor)
    hinge.SetAxis(axis)
    return hinge


def add_steered_wheel(
    model: Model, name: str, position: VectorLike, tire: Tire, base: Body, stop: float, gain: float, torque: float
) -> tuple[Wheel, Servo]:
    """A wheel on a stub, which a servo turns about a vertical hinge of a base; see `Servo` for the numbers."""
    stub = add_body(model, f"{name}_stub")
    fit(BoxGeom(stub, model.modelSpaceId, 0.03, 0.03, 0.03), (0.0, 0.0, 0.0), 0.1, GREY)
    stub.SetPosition(position)
    hinge = add_hinge(model, stub, base, position, (0.0, 0.0, 1.0), f"{name}_steering")
    wheel = Wheel(Axis(on_hinge(model, add_tire(model, name, position, tire), stub)))
    return wheel, Servo(Axis(hinge), gain, torque, stop=stop)


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
    """A caster: a ball with a radius [m] and mass [kg] at a position in the model's frame [m], on a ball joint."""
    caster = add_body(model, name)
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
