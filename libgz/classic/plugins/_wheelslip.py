"""WheelSlipPlugin: lets wheels slip in proportion to force, as tires do."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.plugin import ModelPlugin
from libgz.classic.plugins._wheels import radius_of
from libgz.physics.check import not_negative

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Link, Model
    from libgz.sdf.element import Element

__all__ = ["Tire", "WheelSlipPlugin"]

log = logging.getLogger("libgz.classic")

MOST_SLIP = 1e10  # [m/(N s)]; such a wheel has no friction


@dataclass
class Tire:
    """A wheel that slips.

    Attributes:
        joint: it spins about the joint's last axis.
        link: of the wheel.
        name: of its link.
        surfaces: of its collisions.
        radius: [m].
        force: that presses it on the ground [N].
        lateral, longitudinal: slip per force, each divided by that force [1].
        publisher: of how it slips.
    """

    joint: Joint
    link: Link
    name: str
    surfaces: list[Any]
    radius: float
    force: float
    lateral: float
    longitudinal: float
    publisher: Any

    def slip(self, turn: Quaterniond, down: Vector3d) -> Vector3d:
        """How it slips longitudinally and laterally, and the speed of its rim [m/s].

        Args:
            turn: of the model.
            down: direction of gravity in the model's frame.
        """
        velocity = turn.RotateVectorReverse(self.link.WorldLinearVel())
        axle = turn.RotateVectorReverse(self.joint.GlobalAxis(0).Normalized())
        rim = self.radius * self.joint.GetVelocity(0)
        return Vector3d(down.Cross(axle).Dot(velocity) - rim, axle.Dot(velocity), rim)


class WheelSlipPlugin(ModelPlugin):
    """Sets the slip of wheels, which ODE takes as velocity per tangential force, from their speed.

    slip = compliance * radius * abs(spin) / force: so a wheel that is driven or braked by a tangential force F rolls
    with the slip ratio compliance * F / force, whatever its speed. The friction direction `<fdir1>` of the wheel's
    surface must be along its axle: slip1 is lateral, slip2 longitudinal.

    Publishes how each wheel slips on ~/MODEL/wheel_slip/LINK, a msgs.Vector3d as in `GetSlips`, and obeys
    ~/MODEL/wheel_slip/lateral_compliance and .../longitudinal_compliance, msgs.GzString with a number for all wheels.

    Elements:
        wheel: one a wheel, with an attribute `link_name`.
            slip_compliance_lateral, slip_compliance_longitudinal: [1] (0).
            wheel_normal_force: the force that presses the wheel on the ground [N].
            wheel_radius: [m]; by default that of its shape.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the wheels.

        Raises:
            NotFoundError: there is no such link, or it has no parent joint.
            ParameterError: a force or radius is not positive.
        """
        self.model, world = model, model.GetWorld()
        gravity = world.Gravity()
        self.down = model.WorldPose().Rot().RotateVectorReverse(gravity.Normalized())  # of the model when it was loaded
        self.node = transport.Node()
        self.node.Init(world.Name())
        topic = f"~/{model.GetName()}/wheel_slip"
        self.tires = [self._tire(model, element, topic) for element in sdf.named("wheel")]
        if not self.tires:
            raise NotFoundError(f"{sdf.where}: <wheel> is missing; there must be one for each wheel that slips")
        setters = {"lateral": self.SetSlipComplianceLateral, "longitudinal": self.SetSlipComplianceLongitudinal}
        self.subscribers = [
            self.node.Subscribe(f"{topic}/{way}_compliance", partial(self._on_compliance, way, setter), kind="GzString")
            for way, setter in setters.items()
        ]
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _tire(self, model: Model, element: Element, topic: str) -> Tire:
        name = element.Get(str, "link_name").strip()
        link: Link | None = model.GetLink(name) if name else None
        if link is None:
            names = [link.GetName() for link in model.family_links()]
            raise NotFoundError(
                f"{element.where}: <wheel> has link_name {name!r}; model {model.GetName()!r} has {', '.join(names)}"
                + nearest(name, names)
            )
        joints = link.GetParentJoints()
        if not joints:
            raise NotFoundError(f"{element.where}: link {name!r} has no parent joint that it could spin about")
        radius = element.Get(float, "wheel_radius", radius_of(link))[0]
        force = element.Get(float, "wheel_normal_force")
        for tag, value in (("wheel_radius", radius), ("wheel_normal_force", force)):
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(f"{element.where}: <{tag}> is {value:g}; it must be positive")
        surfaces = [collision.GetSurface() for collision in link.GetCollisions()]
        compliances = [max(element.Get(float, f"slip_compliance_{way}"), 0.0) for way in ("lateral", "longitudinal")]
        publisher = self.node.Advertise(msgs.Vector3d, f"{topic}/{link.GetName()}")
        return Tire(joints[0], link, name, surfaces, radius, force, compliances[0], compliances[1], publisher)

    def _on_compliance(self, way: str, setter: Callable[[str, float], None], message: Any) -> None:
        try:
            setter("", float(message.data))
        except (ValueError, ParameterError):
            log.error("WheelSlipPlugin: the %s compliance %.200r is no number that is not negative", way, message.data)

    def GetSlips(self) -> dict[str, Vector3d]:
        """How each wheel slips, by its link [m/s]: x longitudinally, y laterally; z is the speed of its rim."""
        turn = self.model.WorldPose().Rot()
        return {tire.link.GetName(): tire.slip(turn, self.down) for tire in self.tires}

    def SetSlipComplianceLateral(self, wheel: str, compliance: float) -> None:
        """Set the lateral slip compliance [1] of the wheel with this link; of all wheels if the name is empty."""
        for tire in self._named(wheel, compliance):
            tire.lateral = compliance

    def SetSlipComplianceLongitudinal(self, wheel: str, compliance: float) -> None:
        """Set the longitudinal slip compliance [1] of the wheel with this link; of all wheels if the name is empty."""
        for tire in self._named(wheel, compliance):
            tire.longitudinal = compliance

    def _named(self, wheel: str, compliance: float) -> list[Tire]:
        not_negative(compliance, "slip compliance")
        found = [tire for tire in self.tires if wheel in ("", tire.name)]
        if not found:
            names = [tire.name for tire in self.tires]
            raise NotFoundError(f"there is no wheel {wheel!r}; there are {', '.join(names)}{nearest(wheel, names)}")
        return found

    def OnUpdate(self) -> None:
        """Set the slips of the next step, and publish those of the last one."""
        for tire in self.tires:
            if tire.publisher.HasConnections():
                slip = tire.slip(self.model.WorldPose().Rot(), self.down)
                tire.publisher.Publish(msgs.Vector3d(x=slip.X(), y=slip.Y(), z=slip.Z()))
            rate = tire.radius * abs(tire.joint.GetVelocity(tire.joint.DOF() - 1)) / tire.force
            for surface in tire.surfaces:
                surface.slip1, surface.slip2 = _slip(rate * tire.lateral), _slip(rate * tire.longitudinal)


def _slip(value: float) -> float:
    """A slip that ODE can use: also of a wheel at rest whose compliance is infinite, which is 0 times infinity."""
    return min(value, MOST_SLIP) if value > 0.0 else 0.0
