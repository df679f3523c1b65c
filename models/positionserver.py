"""PositionServer: a robot's position interface, which takes commands and publishes the pose."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import ClassVar

from libgz.interfaces.position import Position, PositionData
from libgz.legacy.model import Model
from libgz.models.serving import Seen, serve
from libgz.simulation.formula import Formula, Term
from libgz.simulation.updates import Exchange
from libgz.transport.guard import Guard

__all__ = ["PositionServer"]

LARGEST_COMMAND = 100.0  # [m/s] or [rad/s]; ten times what the fastest robot here reaches


MOST_FIELDS = 6  # of the interface


class _Expected(ctypes.Structure):
    """The switch as long as no client changes it, and what follows from the command; for native updates."""

    _fields_ = [
        ("switch", ctypes.c_int64),  # what a client wrote in cmd_enable_motors, valid or not
        ("enabled", ctypes.c_int64),
        ("wanted", ctypes.c_double * MOST_FIELDS),
    ]


class PositionServer:
    """The position interface of a robot.

    Args:
        model: the robot.
        fields: the command fields that the robot obeys: name and index.
    """

    STATE: ClassVar[tuple[str, ...]] = ("command", "enabled", "wanted", "seen")

    def __init__(self, model: Model, fields: tuple[tuple[str, int], ...]) -> None:
        self.model, self.fields = model, fields
        self.interface = Position()
        self._expected, self._seen = _Expected(), Seen(MOST_FIELDS)
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
    def enabled(self) -> bool:
        """Whether the client has the motors switched on."""
        return self._enabled

    @enabled.setter
    def enabled(self, value: bool) -> None:
        self._enabled = value
        self._expected.enabled = value
        self._seen.settled = False

    @property
    def wanted(self) -> tuple[float, ...]:
        """The command in force: `command`, or zeros while the motors are off."""
        return self._wanted

    @wanted.setter
    def wanted(self, value: tuple[float, ...]) -> None:
        self._wanted = value
        self._expected.wanted[: len(value)] = value
        self._seen.settled = False

    @property
    def seen(self) -> tuple[float, ...]:
        """What a client wrote when the other three followed from it: whether it is known, the switch, the fields."""
        return (int(self._seen.settled), self._expected.switch, *self._seen.numbers)

    @seen.setter
    def seen(self, value: tuple[float, ...]) -> None:
        self._expected.switch = int(value[1])
        self._seen.note(value[2:], bool(value[0]))

    def read_wanted(self, formula: Formula) -> list[Term]:
        """`wanted` as terms of a formula, for native updates."""
        return [formula.read((self._expected, "wanted", i)) for i in range(len(self.fields))]

    def require_enabled(self, formula: Formula) -> None:
        """Make it a condition of a formula that the motors are on."""
        formula.require((self._expected, "enabled"))

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
        new, intact = wishes != self.command or enabled != self.enabled, True
        if new:
            intact = self.interface.intact()
            if intact:
                self._take(enabled, wishes)
        wanted = self.command if self.enabled else self._zeros
        if wanted is not self._wanted:
            self.wanted = wanted
        if new or not self._seen.settled:
            self._seen.note(wishes, intact)
            self._expected.switch = enabled

    def unchanged(self) -> Exchange:
        """An exchange, for `UpdateRows.share`, as long as the command does not change; what is published is missing."""
        exchange, expected = Exchange(self.interface), self._expected
        self._seen.expect(exchange, self.fields)
        exchange.expect("cmd_enable_motors", (expected, "switch"))
        exchange.now()
        exchange.integer("stall", 0)
        return exchange

    def _take(self, enabled: int, wishes: tuple[float, ...]) -> None:
        """Check what the client wants, and take it; an unchanged command was checked before."""
        self.enabled = self._guard.switch("cmd_enable_motors", enabled, self.enabled)
        self.command = tuple(
            self._guard.number(f"{name}[{i}]", wish, old, LARGEST_COMMAND)
            for (name, i), wish, old in zip(self.fields, wishes, self.command, strict=True)
        )
