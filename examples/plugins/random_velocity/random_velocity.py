"""A Model plugin that periodically gives a link a velocity in a random direction.

Random numbers come from libgz.classic.math.Rand; with `gzserver --seed` they are the same in each run.
"""

import math

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.event import Events
from libgz.classic.math import Rand, Vector3d


class RandomVelocity(ModelPlugin):
    """Elements: `<link>`, its name; `<speed>` [m/s]; `<period>` [s] between new directions."""

    STATE = ("due", "velocity")  # what a snapshot of the world keeps of it

    def Load(self, model, sdf):
        self.link = model.GetLink(sdf.Get(str, "link"))
        self.speed = self.LoadParam(sdf, "speed", 1.0)
        self.period = self.LoadParam(sdf, "period", 2.0)
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self):
        # A reset sets sim time to 0, so stored times are reset, too.
        self.due = 0.0
        self.velocity = Vector3d()

    def OnUpdate(self, info):
        # A callback with an argument gets the world's name, sim time and real time.
        now = info.simTime.Double()
        if now >= self.due:
            self.due = now + self.period
            heading = Rand.DblUniform(-math.pi, math.pi)
            self.velocity = Vector3d(self.speed * math.cos(heading), self.speed * math.sin(heading), 0.0)
        # Physics determines z; otherwise the link would float.
        self.velocity.Z(self.link.WorldCoGLinearVel().Z())
        self.link.SetLinearVel(self.velocity)


GZ_REGISTER_MODEL_PLUGIN(RandomVelocity)
