"""InitialVelocityPlugin: sets the initial velocity of a model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class InitialVelocityPlugin(ModelPlugin):
    """Sets the velocity of all links of a model at the start and after each reset.

    Elements:
        linear: in the world frame [m/s].
        angular: in the world frame [rad/s].
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Set the velocities."""
        self.model, self.sdf = model, sdf
        self.Reset()

    def Reset(self) -> None:
        """Set the velocities again."""
        if self.sdf.HasElement("linear"):
            self.model.SetLinearVel(self.sdf.Get(Vector3d, "linear"))
        if self.sdf.HasElement("angular"):
            self.model.SetAngularVel(self.sdf.Get(Vector3d, "angular"))


GZ_REGISTER_MODEL_PLUGIN(InitialVelocityPlugin)
