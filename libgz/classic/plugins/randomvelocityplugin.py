"""RandomVelocityPlugin: moves a link at a velocity that changes at random."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.classic.event import Events
from libgz.classic.math import Rand, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class RandomVelocityPlugin(ModelPlugin):
    """Sets the velocity of a link in every iteration, and chooses a new one after each period.

    Elements:
        link: the name of the link.
        initial_velocity: until the first period is over [m/s] (0 0 0).
        velocity_factor: the length of the velocities that are chosen [m/s] (1); their directions are random.
        update_period: between two of them [s] (10).
        min_x, max_x, min_y, max_y, min_z, max_z: limits of the components [m/s]; none by default.
    """

    STATE = ("velocity", "chosen")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and read the elements."""
        self.link = named_link(model, sdf, "link")
        self.factor = sdf.Get(float, "velocity_factor", 1.0)[0]
        self.period = sdf.Get(float, "update_period", 10.0)[0]
        self.initial = sdf.Get(Vector3d, "initial_velocity")
        self.low = [sdf.Get(float, f"min_{axis}", -math.inf)[0] for axis in "xyz"]
        self.high = [sdf.Get(float, f"max_{axis}", math.inf)[0] for axis in "xyz"]
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Return to the initial velocity."""
        self.velocity = self._limited(self.initial)
        self.chosen = 0.0  # [s] of sim time

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Set the velocity, after the period a new one."""
        now = info.simTime.Double()
        if now - self.chosen > self.period:
            self.chosen = now
            direction = Vector3d(*(Rand.DblUniform(-1.0, 1.0) for _ in range(3)))
            self.velocity = self._limited(direction.Normalize() * self.factor)
        self.link.SetLinearVel(self.velocity)

    def _limited(self, velocity: Vector3d) -> Vector3d:
        return Vector3d(*(max(a, min(v, b)) for a, v, b in zip(self.low, velocity, self.high, strict=True)))


GZ_REGISTER_MODEL_PLUGIN(RandomVelocityPlugin)
