"""GravityCompensationPlugin: joints bear the weight of what they carry."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Link, Model
    from libgz.sdf.element import Element

KINDS = ("revolute", "prismatic", "universal", "revolute2")


class GravityCompensationPlugin(ModelPlugin):
    """Applies the efforts to the joints of a model that hold all links which they carry against gravity.

    The effort about an axis is the negative torque of the weights of these links about it, and along an axis their
    negative weight in its direction. Joints to the world, of loops, and other kinds than revolute, revolute2, universal
    and prismatic, are left as they are.

    Elements:
        uri: read and not used; Gazebo needs it to load the model into another physics engine.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find what each joint carries."""
        self.world = model.GetWorld()
        self.carried: list[tuple[Joint, list[Link]]] = []
        for joint in model.all_joints():
            child = joint.GetChild()
            if joint.core.kind in KINDS and child is not None and not child.IsStatic():
                links: dict[Link, None] = {}
                _collect(child, links)
                if joint.GetParent() not in links:
                    self.carried.append((joint, list(links)))
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self) -> None:
        """Apply the efforts."""
        gravity = self.world.Gravity()
        for joint, links in self.carried:
            weights = [(link.WorldCoGPose().Pos(), gravity * link.GetInertial().Mass()) for link in links]
            for index in range(joint.DOF()):
                axis = joint.GlobalAxis(index)
                if joint.core.kind == "prismatic":
                    effort = sum(weight.Dot(axis) for _, weight in weights)
                else:
                    anchor = joint.Anchor(index)
                    effort = sum((place - anchor).Cross(weight).Dot(axis) for place, weight in weights)
                joint.SetForce(index, -effort)


def _collect(link: Link, links: dict[Link, None]) -> None:
    """Add a link that has weight, and all links which it carries."""
    if link in links:
        return
    links[link] = None
    for joint in link.GetChildJoints():
        child = joint.GetChild()
        if child is not None:
            _collect(child, links)


GZ_REGISTER_MODEL_PLUGIN(GravityCompensationPlugin)
