"""libgz demo: start a server with a robot, and drive the robot in a circle from this process."""

from __future__ import annotations

import argparse
import math
import subprocess
import sys
from pathlib import Path

from libgz.errors import GazeboError, ServerError
from libgz.files import installed_worlds
from libgz.interfaces.client import Client

__all__ = ["configure", "run"]

SPEED, TURN = 0.3, 0.4  # [m/s], [rad/s]
PATIENCE = 20.0  # [s] to wait for the server

HEADER = "   sim [s]     x [m]     y [m]  yaw [deg]  sonar min [m]  laser min [m]  battery [V]  real-time factor"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--seconds", type=float, default=16.0, metavar="S", help="duration in sim time [s] (default 16)"
    )
    parser.add_argument(
        "--rate", type=float, default=2.0, metavar="R", help="simulated seconds per second of real time (default 2)"
    )


def run(options: argparse.Namespace) -> int:
    """Run the server, drive its robot, and print what the client reads.

    Raises:
        ServerError: the server did not start.
    """
    seconds, rate = options.seconds, options.rate
    world = installed_worlds() / "pioneer2at.world"
    command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", "auto", "-d", "0", "--rate", str(rate), str(world)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            words = (server.stdout.readline() if server.stdout else "").split()
            if not words:
                raise ServerError("the server did not start; its messages are above")
            _drive(int(words[-1]), world, seconds)
        except KeyboardInterrupt:
            print()
        finally:
            server.terminate()
        return server.wait(PATIENCE)


def _drive(server_id: int, world: Path, seconds: float) -> None:
    """Drive in a circle and print ten lines in all."""
    print(f"server {server_id} runs {world}; this client drives robot1 at {SPEED} m/s, turning {TURN} rad/s\n")
    print(HEADER)
    with Client(server_id, timeout=PATIENCE) as client:
        sim, robot = client.sim(), client.position("robot1")
        sonar, laser, power = client.sonar("robot1"), client.laser("laser1"), client.power("robot1")
        robot.command(vx=SPEED, vyaw=TURN)
        next_line, distance, last = 0.0, 0.0, robot.pose
        while sim.sim_time < seconds:
            if not client.wait(timeout=PATIENCE):
                raise GazeboError(f"the server sent no data for {PATIENCE:g} s")
            x, y, yaw = robot.pose
            distance += math.hypot(x - last[0], y - last[1])
            last = (x, y, yaw)
            if sim.sim_time < next_line:
                continue
            next_line += seconds / 10.0
            factor = sim.sim_time / sim.real_time if sim.real_time > 0.0 else math.nan
            nearest_sonar = float(sonar.ranges.min()) if len(sonar.ranges) else math.nan
            nearest_beam = float(laser.ranges.min()) if len(laser.ranges) else math.nan
            print(
                f"{sim.sim_time:10.2f}{x:10.3f}{y:10.3f}{math.degrees(yaw):11.1f}{nearest_sonar:15.3f}"
                f"{nearest_beam:15.3f}{power.level:13.4f}{factor:18.3f}",
                flush=True,
            )
        robot.command()
        print(f"\ndriven {distance:.2f} m by odometry; the robot has stopped")
