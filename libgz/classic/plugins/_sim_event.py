"""SimEvents: messages about what happens in a world."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs

if TYPE_CHECKING:
    from libgz.classic.physics import World

__all__ = ["TOPIC", "sim_event"]

TOPIC = "/gazebo/sim_events"


def sim_event(world: World, number: int, kind: str, name: str, data: dict[str, Any]) -> Any:
    """A SimEvent with the statistics of a world, and data as a JSON text."""
    message = msgs.SimEvent(id=number, type=kind, name=name, data=json.dumps(data))
    statistics = message.world_statistics
    statistics.iterations, statistics.paused = world.Iterations(), world.IsPaused()
    msgs.Set(statistics.sim_time, world.SimTime())
    msgs.Set(statistics.real_time, world.RealTime())
    msgs.Set(statistics.pause_time, world.PauseTime())
    return message
