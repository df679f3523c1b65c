"""PositionServer: a robot's position interface, which takes commands and publishes the pose."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from libgz.base.law import Number, law
from libgz.base.records import numbers
from libgz.interfaces.position import Position, PositionData
from libgz.legacy.model import Model
from libgz.models.serving import Seen, serve
from libgz.simulation.exchange import Exchange
from libgz.simulation.plan import Plan, handler
from libgz.transport.guard import Guard

__all__ = ["PositionServer"]

LARGEST_COMMAND = 100.0  # [m/s] or [rad/s]; ten times what the fastest robot here reaches


class PositionServer:
    """The position interface of a robot.

    Args:
        model: the robot.
        fields: the command fields that the robot obeys: name and index.
    """

    STATE: ClassVar[tuple[str, ...]] = ("command", "enabled", "wanted", "seen")

    _on = Number()  # 1: the motors are

    def __init__(self, model: Model, fields: tuple[tuple[str, int], ...]) -> None:
        self.model, self.fields = model, fields
        self.interface = Position()
        self._wanted, self._seen = numbers(len(fields))(), Seen(len(fields) + 1)
        self._zeros = (0.0,) * len(fields)
        self.enabled = True
        self.wanted = self.command = self._zeros

    @property
    def command(self) -> tuple[float, ...]:
        """The client's last command, in the order of `fields` [m/s], [rad/s]."""
        return self._command

    @command.setter
    def command(self, value: tuple[float, ...]) -> None:
        self._command = value
        self._seen.settled = False

    @property
    @law
    def enabled(self) -> bool:
        """Whether the client has the motors switched on."""
        return self._on != 0.0

    @enabled.setter
    def enabled(self, value: bool) -> None:
        self._on = float(value)
        self._seen.settled = False

    @property
    @law
    def wanted(self) -> tuple[float, ...]:
        """The command in force: `command`, or zeros while the motors are off."""
        return tuple(self._wanted[:])

    @wanted.setter
    def wanted(self, value: tuple[float, ...]) -> None:
        self._wanted[:] = value
        self._seen.settled = False

    @property
    def seen(self) -> tuple[float, ...]:
        """What a client wrote when the other three followed from it: whether it is known, the switch, the fields."""
        return (int(self._seen.settled), *self._seen.numbers)

    @seen.setter
    def seen(self, value: tuple[float, ...]) -> None:
        self._seen.note(value[1:], bool(value[0]))

    def Init(self) -> None:
        """Create the interface under the model's id."""
        self._guard = Guard(f"position.{self.model.GetId()}")
        serve(self.model, self.interface)
        self.interface.data.cmd_enable_motors = 1

    def Fini(self) -> None:
        """Destroy the interface."""
        self.interface.destroy()

    def plan(self, plan: Plan, publish: Callable[[PositionData], None]) -> None:
        """Add to a robot's plan that it publishes, and takes the client's command.

        Args:
            plan: of the robot.
            publish: writes the pose and velocity of the robot.
        """
        self._publish = publish
        plan.exchange(self.interface, self.write, publish, unless=self._expect, otherwise=self.exchange)

    @law
    def write(self, data: PositionData, publish: Callable[[PositionData], None]) -> None:
        """Write what the server publishes."""
        data.time = self.model.world.GetSimTime()
        data.stall = 0
        publish(data)

    def _expect(self, exchange: Exchange) -> None:
        """The condition that the command does not change."""
        self._seen.expect(exchange, (("cmd_enable_motors", 0), *self.fields))

    @handler
    def exchange(self) -> None:
        """Publish, and take the client's command."""
        if not self.interface.lock():
            return
        data = self.interface.data
        enabled, wishes = data.cmd_enable_motors, tuple([getattr(data, name)[i] for name, i in self.fields])
        self.write(data, self._publish)
        self.interface.unlock()
        new, intact = wishes != self.command or enabled != self.enabled, True
        if new:
            intact = self.interface.intact()
            if intact:
                self._take(enabled, wishes)
        wanted = self.command if self.enabled else self._zeros
        if wanted != self.wanted:
            self.wanted = wanted
        if new or not self._seen.settled:
            self._seen.note((enabled, *wishes), intact)

    def _take(self, enabled: int, wishes: tuple[float, ...]) -> None:
        """Check what the client wants, and take it; an unchanged command was checked before."""
        self.enabled = self._guard.switch("cmd_enable_motors", enabled, self.enabled)
        self.command = tuple(
            self._guard.number(f"{name}[{i}]", wish, old, LARGEST_COMMAND)
            for (name, i), wish, old in zip(self.fields, wishes, self.command, strict=True)
        )
