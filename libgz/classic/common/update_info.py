"""UpdateInfo: the argument of the callbacks of update events."""

from __future__ import annotations

from dataclasses import dataclass, field

from libgz.classic.common.time import Time

__all__ = ["UpdateInfo"]


@dataclass(slots=True)
class UpdateInfo:
    """The name of the world, its sim time and its real time in a step; a new object for each event."""

    worldName: str = ""
    simTime: Time = field(default_factory=Time)
    realTime: Time = field(default_factory=Time)
