"""A Model plugin that keeps its model moving: it sets the velocity in every iteration.

Forces act for one step only, and velocities change by contacts, so both have to be set in every step. The event
WorldUpdateBegin is the first one of an iteration; settings in its callbacks act in the step that follows.
"""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.event import Events
from libgz.classic.math import Vector3d


class ModelPush(ModelPlugin):
    """Elements: `<velocity>` [m/s], global."""

    STATE = ()  # nothing of its own to remember

    def Load(self, model, sdf):
        self.model = model
        self.velocity = self.LoadParam(sdf, "velocity", Vector3d(0.3, 0.0, 0.0))
        # Keep a reference to the connection: dropping it disconnects the callback.
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self):
        # Sets x and y only; physics determines z.
        falling = self.model.WorldLinearVel().Z()
        self.model.SetLinearVel(Vector3d(self.velocity.X(), self.velocity.Y(), falling))


GZ_REGISTER_MODEL_PLUGIN(ModelPush)
