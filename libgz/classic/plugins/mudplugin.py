"""MudPlugin: slows down links that touch a model, as mud does."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element


class MudPlugin(ModelPlugin):
    """Damps the velocity of links while they touch this model, and pulls them back to where they came to rest.

    A link feels the force -damping * velocity - stiffness * displacement at the mean of its contact points, both
    without their component along gravity; the displacement is that since the contact began. It is computed as by an
    implicit Euler step, so that no damping is too large for the step size.

    Elements:
        link_name: a link that the mud acts on, by scoped name, such as `robot::wheel`; several. None: all links.
        damping: [N s/m] (100).
        stiffness: [N/m] (0).
        contact_sensor_name: read, and not needed: all contacts of the model count.
    """

    STATE = ("anchors",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the elements.

        Raises:
            ParameterError: damping or stiffness is negative.
        """
        self.model, self.world = model, model.GetWorld()
        self.names = {element.Get(str).strip() for element in sdf.named("link_name")}
        self.damping, self.stiffness = sdf.Get(float, "damping", 100.0)[0], sdf.Get(float, "stiffness", 0.0)[0]
        for tag, value in (("damping", self.damping), ("stiffness", self.stiffness)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ParameterError(f"{sdf.where}: <{tag}> is {value:g}; it must be a number of at least 0")
        self.contacts = self.world.Physics().GetContactManager()
        self.contacts.SetNeverDropContacts(True)
        self.anchors: dict[str, tuple[float, ...]] = {}  # scoped name of a link -> where it touched first [m]
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Forget where links touched."""
        self.anchors.clear()

    def OnUpdate(self) -> None:
        """Apply forces to the links that touched the model in the last step."""
        touching: dict[str, tuple[Link, list[Vector3d]]] = {}
        for contact in self.contacts.GetContacts():
            one, two = contact.collision1.GetLink(), contact.collision2.GetLink()
            if (one.model is self.model) == (two.model is self.model):
                continue
            link = two if one.model is self.model else one
            name = link.GetScopedName()
            if not self.names or name in self.names:
                touching.setdefault(name, (link, []))[1].extend(contact.positions)
        for name in [name for name in self.anchors if name not in touching]:
            del self.anchors[name]
        step = self.world.Physics().GetMaxStepSize()
        for name, (link, points) in touching.items():
            if points and not link.IsStatic():
                self._damp(name, link, points, step)

    def _damp(self, name: str, link: Link, points: list[Vector3d], step: float) -> None:
        place = link.WorldCoGPose().Pos()
        anchor = Vector3d(*self.anchors.setdefault(name, tuple(place)))
        mean: Any = sum(points, Vector3d()) / len(points)
        velocity = self._level(
            link.WorldLinearVel(link.WorldPose().Rot().RotateVectorReverse(mean - link.WorldPose().Pos()))
        )
        displacement = self._level(place - anchor)
        # Implicit: the force that the velocity and place at the end of the step call for.
        mass = link.GetInertial().Mass()
        resistance = 1.0 + step * self.damping / mass + step * step * self.stiffness / mass
        force = (velocity * (self.damping + step * self.stiffness) + displacement * self.stiffness) * (
            -1.0 / resistance
        )
        link.AddForceAtWorldPosition(force, mean)

    def _level(self, vector: Vector3d) -> Vector3d:
        """A vector without its component along gravity."""
        up = Vector3d(*self.world.Gravity())
        if not up.Length():
            return vector
        up.Normalize()
        return vector - up * vector.Dot(up)


GZ_REGISTER_MODEL_PLUGIN(MudPlugin)
