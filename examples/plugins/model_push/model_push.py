"""A Model plugin that keeps its model moving: it sets the velocity anew in every iteration.

Forces act for one step only, and velocities decay by contacts; for a constant one, set it in every step. The event
WorldUpdateBegin comes first in each iteration, so what is set there acts in the step that follows.
"""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.event import Events
from libgz.classic.math import Vector3d


class ModelPush(ModelPlugin):
    """Elements: `<velocity>` [m/s], global."""

    def Load(self, model, sdf):
        self.model = model
        self.velocity = self.LoadParam(sdf, "velocity", Vector3d(0.3, 0.0, 0.0))
        # Keep the connection: when it is dropped, the callback is called no more.
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self):
        # What falls and jumps is left to physics: only x and y are ours.
        falling = self.model.WorldLinearVel().Z()
        self.model.SetLinearVel(Vector3d(self.velocity.X(), self.velocity.Y(), falling))


GZ_REGISTER_MODEL_PLUGIN(ModelPush)
