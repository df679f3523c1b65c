"""Wheels: joints that drive a model, commanded by their speed on the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.base.law import law
from libgz.classic.physics import CylinderShape, SphereShape

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Link

__all__ = ["Wheel", "radius_of", "separation"]


def radius_of(link: Link | None) -> float:
    """The radius of a wheel [m]: that of its cylinder or sphere, else half the longest side of its bounding box."""
    collisions = link.GetCollisions() if link is not None else []
    for collision in collisions:
        shape = collision.GetShape()
        if isinstance(shape, CylinderShape | SphereShape):
            return shape.GetRadius()
    return link.BoundingBox().Size().Max() / 2.0 if link is not None and collisions else 0.0


def separation(left: Joint, right: Joint) -> float:
    """The distance between the anchors of two wheels [m]."""
    return left.Anchor(0).Distance(right.Anchor(0))


class Wheel:
    """A driven joint.

    Args:
        joint: of the wheel, which is its child.
        torque: maximum torque of its motor [N m]; 0 or less: the velocity is set directly.
        radius: of the wheel [m]; by default that of its shape.

    Raises:
        ParameterError: the radius is not given, and the wheel has no shape with a radius.
    """

    def __init__(self, joint: Joint, torque: float = 0.0, radius: float | None = None) -> None:
        self.joint, self.torque = joint, torque
        self.radius = radius_of(joint.GetChild()) if radius is None else radius
        if not self.radius > 0.0:
            raise ParameterError(f"joint {joint.GetScopedName()!r}: its child has no shape with a radius")

    @law
    def run(self, speed: float) -> None:
        """Set the speed on the ground [m/s]: for the next step, or with a motor until the next call."""
        rate = speed / self.radius
        if self.torque > 0.0:
            self.joint.SetParam("fmax", 0, self.torque)
            self.joint.SetParam("vel", 0, rate)
        else:
            self.joint.core.set_velocity(rate)

    @law
    def speed(self) -> float:
        """The speed on the ground [m/s]."""
        return self.joint.GetVelocity(0) * self.radius
