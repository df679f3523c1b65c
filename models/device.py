"""Device: a part of a robot with an interface of its own, such as a battery or a sonar ring."""

from __future__ import annotations

from typing import Any

from libgz.legacy.model import Model
from libgz.simulation.plan import Plan
from libgz.transport.interface import Interface

__all__ = ["Device"]


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
