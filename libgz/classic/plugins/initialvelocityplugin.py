"""InitialVelocityPlugin: lets a model begin with a velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class InitialVelocityPlugin(ModelPlugin):
    """Gives all links of a model a velocity at the start and after each reset.

    Elements:
        linear: global [m/s].
        angular: global [rad/s].
    """

    def Load(self, model: Model, sdf: Element) -> None:
        """Set the velocities."""
        self.model, self.sdf = model, sdf
        self.Reset()

    def Reset(self) -> None:
        """Set them again."""
        if self.sdf.HasElement("linear"):
            self.model.SetLinearVel(self.sdf.Get(Vector3d, "linear"))
        if self.sdf.HasElement("angular"):
            self.model.SetAngularVel(self.sdf.Get(Vector3d, "angular"))


GZ_REGISTER_MODEL_PLUGIN(InitialVelocityPlugin)
