"""Grip: the action `gripper_cmd` of a legacy gripper, control_msgs/GripperCommand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from libgz.interfaces.gripper import CLOSE, OPEN, STOP
from libgz.ros.control.action import Goal, serve_action
from libgz.ros.legacy.kinds import Holder, Obey, order, paddles

if TYPE_CHECKING:
    from libgz.ros.session import Session

__all__ = ["Grip"]

HALF = 0.5  # a wanted position below this share of the widest gap closes the paddles
PREEMPTED, SUCCEEDED, ABORTED = 2, 3, 4
PATIENCE = 10.0  # [s] of sim time
SETTLING = 0.3  # [s] of sim time in which the flags may still be those from before


class Gripping(Holder, Protocol):
    """The device of a gripper."""

    session: Session

    def command(self, topic: str, obey: Obey, message: Any) -> None:
        """Write a command into its interface."""


class Grip:
    """Opens or closes the paddles, and ends the goal when they have arrived, or hold something.

    A position is a share of the widest gap: 0 is shut, 1 is open.
    """

    def __init__(self, device: Gripping) -> None:
        self._device, self._now = device, device.model.world.GetSimTime
        self._begin, self._opens = 0.0, False
        session = device.session
        name = session.resolve("gripper_cmd", device.id)
        kind = "control_msgs/GripperCommand"
        self._action = serve_action(session, name, kind, self._now, self._accept, self._cancel)

    @property
    def busy(self) -> bool:
        """Whether there is something to do in each step."""
        return self._action.running is not None or self._action.watched

    def end(self) -> None:
        """Serve the action no longer."""
        self._action.end()

    def _accept(self, goal: Goal) -> None:
        self._begin, self._opens = self._now(), goal.message.command.position >= HALF
        self._device.command("gripper_cmd", order(OPEN if self._opens else CLOSE), None)

    def _cancel(self, goal: Goal) -> None:
        self._device.command("gripper_cmd", order(STOP), None)
        goal.end(PREEMPTED, **self._state(paddles(self._device)))

    @staticmethod
    def _state(flags: dict[str, bool]) -> dict[str, Any]:
        gap = 1.0 if flags["opened"] else 0.0 if flags["closed"] else HALF
        return {"position": gap, "effort": 0.0, "stalled": flags["stuck"], "reached_goal": False}

    def update(self) -> None:
        """End the goal when the paddles have arrived, and publish status and feedback."""
        goal, elapsed = self._action.running, self._now() - self._begin
        if goal is not None:
            flags = paddles(self._device)
            state = self._state(flags)
            if elapsed > SETTLING and not flags["moving"] and flags["opened" if self._opens else "closed"]:
                goal.end(SUCCEEDED, **{**state, "reached_goal": True})
            elif flags["stuck"] or elapsed > PATIENCE or elapsed < 0.0:
                goal.end(ABORTED, "the paddles do not arrive", **{**state, "stalled": True})
        self._action.update()
