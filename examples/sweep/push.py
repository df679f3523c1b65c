"""The controller of push.toml, and one of its measures."""

from __future__ import annotations

import math

import libgz
from libgz import GzQuaternToEuler


class Push:
    """Drives ahead for four seconds, then stops; a new one is made for each run.

    Args:
        world: of the run.
        speed: [m/s], the parameter "controller/speed".
    """

    def __init__(self, world: libgz.World, speed: float = 0.3) -> None:
        self.robot, self.speed = world.interface("position", "robot1"), speed

    def __call__(self, world: libgz.World) -> None:
        """Called ten times a second of sim time."""
        self.robot.command(vx=self.speed if world.GetSimTime() < 4.0 else 0.0)


def turned(world: libgz.World) -> float:
    """How far the crate has turned [deg]; called at the end of a run."""
    return math.degrees(GzQuaternToEuler(world.model("crate").GetPose().rot).z)
