"""Device: a part of a robot with an interface of its own, such as a battery or a sonar ring."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from typing import Any

from libgz.legacy.model import Model
from libgz.simulation.plan import Plan
from libgz.transport.interface import Interface

__all__ = ["Device", "Devices"]


class Device:
    """Base of parts of robots that publish when their robot does.

    Attributes:
        model: the robot.
        interface: that it serves under the robot's id.
    """

    model: Model
    interface: Interface[Any]

    def Init(self) -> None:
        """Create the interface."""
        raise NotImplementedError

    def Fini(self) -> None:
        """Destroy the interface."""
        self.interface.destroy()

    def plan_update(self, plan: Plan) -> None:
        """Describe, line by line, what it does when it publishes."""
        raise NotImplementedError

    def Update(self, now: float) -> None:
        """Publish, at sim time `now` [s]."""
        plan = Plan()
        self.plan_update(plan)
        plan.run(self.model.world.engine.step_time, now)


class Devices(list[Any]):
    """The devices of a robot, which native code has: it finds them anew when one comes, goes or moves.

    Args:
        devices: the first ones.
        changed: called after each change.
    """

    def __init__(self, devices: Iterable[Any], changed: Callable[[], None]) -> None:
        super().__init__(devices)
        self.changed = changed


def _noticed(name: str) -> Callable[..., Any]:
    """A method of lists that changes them, noticed."""
    method = getattr(list, name)

    @functools.wraps(method)
    def change(devices: Devices, *arguments: Any, **options: Any) -> Any:
        try:
            return method(devices, *arguments, **options)
        finally:
            devices.changed()

    return change


for _name in (
    *("__setitem__", "__delitem__", "__iadd__", "__imul__", "append", "clear", "extend", "insert", "pop", "remove"),
    *("reverse", "sort"),
):
    setattr(Devices, _name, _noticed(_name))
