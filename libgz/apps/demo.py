"""libgz demo: start a server with a robot, and drive the robot in a circle from this process."""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import math
import os
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from libgz.apps.console import number_above_zero, number_from_zero, say
from libgz.apps.view_process import add_view_options
from libgz.base.errors import GazeboError, ServerError
from libgz.base.files import installed_worlds
from libgz.base.python import start_module
from libgz.base.waiting import PERIOD
from libgz.interfaces.client import Client

__all__ = ["configure", "run"]

SPEED, TURN = 0.3, 0.4  # [m/s], [rad/s]
PLAIN = 16.0  # [s] of sim time that it drives if no page shows it
LINES = 10
PATIENCE = 20.0  # [s] to wait for the server
PAGE_PATIENCE = 30.0  # [s] to wait for the page
NOT_YET = "-"  # instead of a value that the server has not posted
HEADER = "   sim [s]     x [m]     y [m]  yaw [deg]  sonar min [m]  laser min [m]  battery [V]  real-time factor"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--seconds",
        type=number_above_zero("number of seconds"),
        metavar="S",
        help="duration of the drive in sim time [s] (default 16; with a page until Ctrl-C)",
    )
    parser.add_argument(
        "--rate",
        type=number_from_zero("rate"),
        default=2.0,
        metavar="R",
        help="simulated seconds per second of real time (default 2)",
    )
    parser.add_argument("--no-open", action="store_true", help="print the page's address, and open no browser")
    add_view_options(parser, optional=False)


def run(options: argparse.Namespace) -> int:
    """Run the server, drive its robot, and print what the client reads; on a terminal, show it in a browser, too.

    Raises:
        ServerError: the server did not start.
    """
    rate = options.rate
    world = installed_worlds() / "pioneer2at.world"
    words = ["-s", "auto", "-d", "0", "--rate", str(rate), str(world)]
    shown = sys.stdout.isatty() and importlib.util.find_spec("aiohttp") is not None
    stopped = False
    with start_module("libgz.apps.gazebo", *words, stdout=subprocess.PIPE, text=True) as server:
        try:
            words = (server.stdout.readline() if server.stdout else "").split()
            if not words:
                raise ServerError("the server did not start; its messages are above")
            server_id = int(words[-1])
            with _viewer(server_id, options) if shown else contextlib.nullcontext():
                _drive(server_id, world, options.seconds or (math.inf if shown else PLAIN), shown)
                if shown:
                    say("the page stays until Ctrl-C")
                    while server.poll() is None:
                        time.sleep(PERIOD)
        except KeyboardInterrupt:
            stopped = True
            say()
        finally:
            server.terminate()
        code = server.wait(PATIENCE)
        return 0 if stopped else code  # the server of a user who pressed Ctrl-C may get two signals


@contextlib.contextmanager
def _viewer(server_id: int, options: argparse.Namespace) -> Iterator[None]:
    """A viewer in a process of its own. Its address is printed first, and opened; the page is waited for."""
    words = ["view", "-s", str(server_id), "--parent", str(os.getpid())]
    words += ["--report-opened", "--view-port", str(options.view_port), "--view-host", options.view_host]
    words += [] if options.no_open else ["--open"]
    with start_module("libgz", *words, stdout=subprocess.PIPE, text=True, start_new_session=True) as viewer:
        try:
            line = (viewer.stdout.readline() if viewer.stdout else "").strip()
            say(line, flush=True)
            say(f"the robot waits for the page, at most {PAGE_PATIENCE:g} s", flush=True)
            _wait_for_line(viewer, PAGE_PATIENCE)
            yield
        finally:
            viewer.terminate()


def _wait_for_line(process: subprocess.Popen[str], timeout: float) -> None:
    """Wait until a process prints something, for a time [s] at most."""
    if process.stdout is not None:
        select.select([process.stdout], [], [], timeout)


def _drive(server_id: int, world: Path, seconds: float, shown: bool) -> None:
    """Drive in a circle and print ten lines in all. Whoever drives by the page meanwhile takes over."""
    say(f"server {server_id} runs {world}; this client drives robot1 at {SPEED} m/s, turning {TURN} rad/s\n")
    say(HEADER)
    with Client(server_id, timeout=PATIENCE) as client:
        sim, robot = client.sim(), client.position("robot1")
        sonar, laser, power = client.sonar("robot1"), client.laser("laser1"), client.power("robot1")
        robot.command(vx=SPEED, vyaw=TURN)
        begin = sim.sim_time if shown else 0.0  # the world runs while the page is made
        next_line, lines, distance, last = begin, 0, 0.0, robot.pose
        while sim.sim_time < begin + seconds:
            if not client.wait(timeout=PATIENCE):
                raise GazeboError(f"the server sent no data for {PATIENCE:g} s")
            x, y, yaw = robot.pose
            distance += math.hypot(x - last[0], y - last[1])
            last = (x, y, yaw)
            if sim.sim_time < next_line:
                continue
            if lines == LINES and seconds == math.inf:
                say("it drives on until Ctrl-C; W A S D in the page take over", flush=True)
                next_line = math.inf
                continue
            next_line += min(seconds, PLAIN) / LINES
            lines += 1
            nearest_sonar = f"{sonar.ranges.min():.3f}" if len(sonar.ranges) else NOT_YET
            nearest_beam = f"{laser.ranges.min():.3f}" if len(laser.ranges) else NOT_YET
            factor = f"{sim.sim_time / sim.real_time:.3f}" if sim.real_time > 0.0 else NOT_YET
            say(
                f"{sim.sim_time:10.2f}{x:10.3f}{y:10.3f}{math.degrees(yaw):11.1f}{nearest_sonar:>15}"
                f"{nearest_beam:>15}{power.level:13.4f}{factor:>18}",
                flush=True,
            )
        robot.command()
        say(f"\ndriven {distance:.2f} m by odometry; the robot has stopped")
