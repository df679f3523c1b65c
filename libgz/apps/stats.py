"""libgz stats: print the real-time factor of a running SDF world."""

from __future__ import annotations

import argparse
import contextlib
import json
from typing import Any

from libgz.apps.console import say
from libgz.apps.server_link import add_duration, add_world, receive, world_node

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_world(parser)
    add_duration(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object per line, times in [s]")
    parser.add_argument(
        "-p", "--plot", action="store_true", help="print comma-separated values: factor, sim time, real time, paused"
    )


def run(options: argparse.Namespace) -> int:
    """Print a line five times a second.

    Raises:
        ServerError: there is no server.
        GazeboError: the server ended.
    """
    if options.plot:
        say("# real-time factor (percent), simtime (sec), realtime (sec), paused (T or F)")
    with world_node(options) as (node, link), contextlib.suppress(KeyboardInterrupt):
        printer = _Printer(options.plot, options.json)
        subscriber = node.Subscribe("~/world_stats", printer.on_statistics)
        for _ in receive(link, options.duration):
            pass
        subscriber.Unsubscribe()
    return 0


class _Printer:
    """Prints statistics; the factor is the mean since the previous line."""

    def __init__(self, plot: bool, as_json: bool) -> None:
        self._plot, self._json = plot, as_json
        self._last: tuple[float, float] | None = None

    def on_statistics(self, message: Any) -> None:
        """Print the line of a message."""
        sim, real = (t.sec + 1e-9 * t.nsec for t in (message.sim_time, message.real_time))
        last, self._last = self._last, (sim, real)
        if last is None or real <= last[1]:
            return
        factor = (sim - last[0]) / (real - last[1])
        paused = "T" if message.paused else "F"
        if self._json:
            row = {"factor": factor, "sim_time": sim, "real_time": real, "paused": bool(message.paused)}
            say(json.dumps(row), flush=True)
        elif self._plot:
            say(f"{factor:4.2f}, {sim:16.6f}, {real:16.6f}, {paused}", flush=True)  # as of Gazebo's `gz stats -p`
        else:
            say(f"Factor[{factor:.2f}] SimTime[{sim:.2f}] RealTime[{real:.2f}] Paused[{paused}]", flush=True)
