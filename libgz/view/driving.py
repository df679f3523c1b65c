"""Driving: velocity commands to robots of both eras, by interface or by topic."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

from libgz.view.source import Controls

__all__ = ["Driver", "Robot", "robots_of"]

STALE = 2.0  # [s] after which a robot stops whose page is silent
SPEED, TURN = 0.4, 0.8  # [m/s], [rad/s] at full deflection, unless the user chooses others


@dataclass(frozen=True)
class Robot:
    """What can be driven.

    Attributes:
        label: for the user.
        entity: id of its model.
        interface: id of its position interface; empty for one that is driven by the topic ``~/MODEL/vel_cmd``.
    """

    label: str
    entity: str
    interface: str = ""


def robots_of(scene: dict[str, Any], drives: list[str]) -> list[Robot]:
    """The robots of a scene; `drives` are the models that listen to ``vel_cmd``."""
    found = []
    for entity in scene["entities"]:
        served = [one["id"] for one in entity["interfaces"] if one["type"] == "position"]
        found += [Robot(f"{name} (position)", entity["id"], name) for name in served]
    return found + [Robot(f"{name} (vel_cmd)", name) for name in drives]


class Driver:
    """Passes on what the pages want, and stops a robot whose page is silent.

    Args:
        controls: of the server.
    """

    def __init__(self, controls: Controls) -> None:
        self._controls = controls
        self.robot: Robot | None = None
        self.speed, self.turn = SPEED, TURN
        self._pages: dict[int, tuple[float, tuple[float, float, float]]] = {}
        self._sent: tuple[Any, ...] = ()

    def want(self, page: int, way: Any) -> None:
        """What a page wants: forward, left turn and up, each from -1 to 1."""
        try:
            forward, left, up = (min(max(float(part), -1.0), 1.0) for part in way)
        except (TypeError, ValueError):
            return
        if all(map(math.isfinite, (forward, left, up))):
            self._pages[page] = time.monotonic(), (forward, left, up)

    def leave(self, page: int) -> None:
        """A page was closed."""
        if page in self._pages:
            self._pages[page] = time.monotonic(), (0.0, 0.0, 0.0)

    def choose(self, robot: Robot | None) -> None:
        """Drive another robot; the one before stops."""
        if robot != self.robot:
            self._send((0.0, 0.0, 0.0))
            self.robot, self._sent, self._pages = robot, (), {}

    def act(self) -> None:
        """Send the sum of what all pages want, if that is new.

        Raises:
            GazeboError: the robot cannot be reached.
        """
        if self.robot is None or not self._pages:
            return
        now = time.monotonic()
        total = [0.0, 0.0, 0.0]
        for moment, way in self._pages.values():
            if now - moment < STALE:
                total = [a + b for a, b in zip(total, way, strict=True)]
        still = not any(total)
        self._send(tuple(min(max(part, -1.0), 1.0) for part in total))
        if still:
            self._pages = {}

    def _send(self, way: tuple[float, ...]) -> None:
        robot = self.robot
        command = (robot, *way, self.speed, self.turn)
        if robot is None or command == self._sent or (not self._sent and not any(way)):
            return
        vx, vyaw, vz = way[0] * self.speed, way[1] * self.turn, way[2] * self.speed
        if robot.interface:
            position = self._controls.interface("position", robot.interface)
            position.command(vx=vx, vyaw=vyaw, vz=vz)
        else:
            half = vyaw / 2.0
            turn = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
            message = {"position": {"x": vx, "y": 0.0, "z": 0.0}, "orientation": turn}
            self._controls.ask("publish", f"~/{robot.entity}/vel_cmd", type="gazebo.msgs.Pose", message=message)
        self._sent = command
