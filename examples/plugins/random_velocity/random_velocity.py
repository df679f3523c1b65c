"""A Model plugin that gives a link a new velocity in a random direction from time to time.

Random numbers come from libgz.classic.math.Rand, which `gzserver --seed` makes the same in each run.
"""

import math

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.event import Events
from libgz.classic.math import Rand, Vector3d


class RandomVelocity(ModelPlugin):
    """Elements: `<link>`, its name; `<speed>` [m/s]; `<period>` [s] between new directions."""

    def Load(self, model, sdf):
        self.link = model.GetLink(sdf.Get(str, "link"))
        self.speed = self.LoadParam(sdf, "speed", 1.0)
        self.period = self.LoadParam(sdf, "period", 2.0)
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self):
        # Sim time is 0 again after a reset.
        self.due = 0.0

    def OnUpdate(self, info):
        # A callback that takes an argument gets the world's name, the sim time and the real time.
        now = info.simTime.Double()
        if now >= self.due:
            self.due = now + self.period
            heading = Rand.DblUniform(-math.pi, math.pi)
            self.velocity = Vector3d(self.speed * math.cos(heading), self.speed * math.sin(heading), 0.0)
        # Up and down is left to physics, or the link would float.
        self.velocity.Z(self.link.WorldCoGLinearVel().Z())
        self.link.SetLinearVel(self.velocity)


GZ_REGISTER_MODEL_PLUGIN(RandomVelocity)
