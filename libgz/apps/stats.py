"""libgz stats: how fast a running SDF world goes."""

from __future__ import annotations

import argparse
import contextlib
import time
from typing import Any

from libgz.apps.server_link import add_world, world_node
from libgz.classic.transport import TopicManager
from libgz.errors import GazeboError

__all__ = ["configure", "run"]

NAP = 0.01  # [s] between looks for messages


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_world(parser)
    parser.add_argument("-d", "--duration", type=float, default=None, metavar="S", help="end after so much wall time")
    parser.add_argument("-p", "--plot", action="store_true", help="comma-separated: factor, sim, real, paused")


def run(options: argparse.Namespace) -> int:
    """Print a line five times a second.

    Raises:
        ServerError: there is no server.
        GazeboError: the server ended.
    """
    if options.plot:
        print("# real-time factor (percent), simtime (sec), realtime (sec), paused (T or F)")
    with world_node(options) as (node, link), contextlib.suppress(KeyboardInterrupt):
        watch = _Watch(options.plot)
        subscriber = node.Subscribe("~/world_stats", watch.on_statistics)
        end = float("inf") if options.duration is None else time.monotonic() + options.duration
        while time.monotonic() < end:
            TopicManager.Instance().ProcessNodes()
            if not link.connected():
                raise GazeboError("the server ended")
            time.sleep(NAP)
        subscriber.Unsubscribe()
    return 0


class _Watch:
    """Turns statistics into lines; the factor is that since the last line."""

    def __init__(self, plot: bool) -> None:
        self._plot = plot
        self._last: tuple[float, float] | None = None

    def on_statistics(self, message: Any) -> None:
        """One message."""
        sim, real = (t.sec + 1e-9 * t.nsec for t in (message.sim_time, message.real_time))
        last, self._last = self._last, (sim, real)
        if last is None or real <= last[1]:
            return
        factor = (sim - last[0]) / (real - last[1])
        paused = "T" if message.paused else "F"
        if self._plot:
            print(f"{100.0 * factor:.2f}, {sim:.4f}, {real:.4f}, {paused}", flush=True)
        else:
            print(f"Factor[{factor:.2f}] SimTime[{sim:.2f}] RealTime[{real:.2f}] Paused[{paused}]", flush=True)
