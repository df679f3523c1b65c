"""StopWorldPlugin: ends a run after some time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element


class StopWorldPlugin(WorldPlugin):
    """Stops the world, which ends gzserver.

    Elements:
        time: the sim time at which it stops [s] (0: at the first iteration).
    """

    STATE = ()

    def Load(self, world: World, sdf: Element) -> None:
        """Read the time."""
        self.world = world
        self.time = sdf.Get(float, "time")
        if math.isnan(self.time):
            self.time = 0.0
        self.connection = Events.ConnectWorldUpdateEnd(self.OnUpdate)

    def OnUpdate(self) -> None:
        """Stop the world, if it is time."""
        if self.world.SimTime().Double() >= self.time:
            self.world.Stop()


GZ_REGISTER_WORLD_PLUGIN(StopWorldPlugin)
