"""Falls: the bodies that fell out of a world, each of which is reported once."""

from __future__ import annotations

import logging

import numpy as np

from libgz.physics.engine import Engine
from libgz.transport.tally import Tally

__all__ = ["Falls"]

log = logging.getLogger("libgz.simulation")

LOWEST = -1000.0  # [m]; a body that falls further is reported
NAMED = 5  # bodies in one message
MOST_NAMES = 100  # that are counted apart


class Falls:
    """Looks for bodies that fell.

    Args:
        engine: whose bodies.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._reported: set[int] = set()  # numbers of bodies
        self._tally = Tally(MOST_NAMES)  # by names

    def report(self) -> None:
        """Warn once of each body that has fallen out of the world."""
        engine = self._engine
        if engine.lowest >= LOWEST:
            return
        below = np.flatnonzero(engine.states[:, 2] < LOWEST)
        fallen = [engine.bodies[row] for row in below.tolist() if row in engine.bodies]
        new = [body for body in fallen if body.number not in self._reported and body.GetLinearVel().z < 0.0]
        self._reported = {body.number for body in (*new, *fallen) if body in new or body.number in self._reported}
        due = [body.label for body in new if self._tally.due(body.label)]  # a world may be reset a thousand times
        if due:
            names = ", ".join(due[:NAMED])
            more = f" and {len(due) - NAMED} more bodies" if len(due) > NAMED else ""
            times = self._tally.times(due[0]) if len(due) == 1 else ""
            log.warning("%s%s fell below %g m%s: is there ground under it?", names, more, LOWEST, times)

    @property
    def rows(self) -> bytes:
        """The rows of the bodies that were reported, as the bytes of 64-bit integers."""
        if not self._reported:
            return b""
        rows = [row for row, body in self._engine.bodies.items() if body.number in self._reported]
        return np.sort(np.array(rows, np.int64)).tobytes()

    @rows.setter
    def rows(self, packed: bytes) -> None:
        rows, bodies = np.frombuffer(packed, np.int64).tolist(), self._engine.bodies
        self._reported = {bodies[row].number for row in rows if row in bodies}
