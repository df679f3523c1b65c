"""PositionServer: a robot's position interface, which takes commands and publishes the pose."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from libgz.interfaces.position import Position, PositionData
from libgz.legacy.model import Model
from libgz.models.serving import serve
from libgz.transport.guard import Guard

__all__ = ["PositionServer"]

LARGEST_COMMAND = 100.0  # [m/s] or [rad/s]; ten times what the fastest robot here reaches


class PositionServer:
    """The position interface of a robot.

    Args:
        model: the robot.
        fields: the command fields that the robot obeys: name and index.

    Attributes:
        command: the client's last command, in the order of `fields` [m/s], [rad/s].
        enabled: whether the client has the motors switched on.
        wanted: the command in force: `command`, or zeros while the motors are off.
    """

    STATE: ClassVar[tuple[str, ...]] = ("command", "enabled", "wanted")

    def __init__(self, model: Model, fields: tuple[tuple[str, int], ...]) -> None:
        self.model, self.fields = model, fields
        self.interface = Position()
        self.enabled = True
        self._zeros = (0.0,) * len(fields)
        self.wanted = self.command = self._zeros

    def Init(self) -> None:
        """Create the interface under the model's id."""
        self._guard = Guard(f"position.{self.model.GetId()}")
        serve(self.model, self.interface)
        self.interface.data.cmd_enable_motors = 1

    def Fini(self) -> None:
        """Destroy the interface."""
        self.interface.destroy()

    def exchange(self, now: float, publish: Callable[[PositionData], None]) -> None:
        """Publish at sim time `now` [s], and take the client's command.

        Args:
            now: sim time [s].
            publish: writes the pose and velocity of the robot.
        """
        if not self.interface.lock():
            return
        data = self.interface.data
        enabled, wishes = data.cmd_enable_motors, tuple([getattr(data, name)[i] for name, i in self.fields])
        data.time = now
        data.stall = 0
        publish(data)
        self.interface.unlock()
        if (wishes != self.command or enabled != self.enabled) and self.interface.intact():
            self._take(enabled, wishes)
        self.wanted = self.command if self.enabled else self._zeros

    def _take(self, enabled: int, wishes: tuple[float, ...]) -> None:
        """Check what the client wants, and take it; an unchanged command was checked before."""
        self.enabled = self._guard.switch("cmd_enable_motors", enabled, self.enabled)
        self.command = tuple(
            self._guard.number(f"{name}[{i}]", wish, old, LARGEST_COMMAND)
            for (name, i), wish, old in zip(self.fields, wishes, self.command, strict=True)
        )
