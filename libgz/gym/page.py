"""BrowserPage: the live view of an environment's world, in the pace of real time."""

from __future__ import annotations

import logging
import time

from libgz.base.errors import ParameterError
from libgz.front import World
from libgz.transport.observer import Observer
from libgz.view.viewer import Viewer

__all__ = ["BrowserPage"]

log = logging.getLogger("libgz.gym")


class BrowserPage:
    """A page that shows a world which has a server id; its address is logged.

    Args:
        world: the world.

    Raises:
        ParameterError: the world has no server id.
        GazeboError: no port is free.
    """

    def __init__(self, world: World) -> None:
        if world.server_id is None:
            raise ParameterError("only a world with a server id can be shown in a page")
        self._world = world
        self._observer = Observer(world.server_id)
        self._viewer = Viewer(self._observer)
        self._shown = world.GetSimTime(), time.monotonic()
        log.warning("open %s", self._viewer.watch_url)

    def show(self) -> None:
        """Show the present state, once as much real time has passed as sim time."""
        sim_time, now = self._world.GetSimTime(), time.monotonic()
        began, at = self._shown
        if sim_time < began or now - at > sim_time - began + 1.0:  # a reset, or a pause of the program
            self._shown = sim_time, now
        else:
            time.sleep(max(0.0, at + sim_time - began - now))
        self._viewer.tick()

    def close(self) -> None:
        """End the page. Can be called twice."""
        self._viewer.close()
        self._observer.close()
