"""ActionServer: the topics of an action, with one goal at a time; a new goal preempts the last one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from libgz.ros.plugin import Ticks
from libgz.ros.session import Session, finite, set_stamp
from libgz.ros.types import message_type

__all__ = ["ActionServer", "Goal"]

STATUS = message_type("actionlib_msgs/GoalStatus")
REJECTED = 5
STATUS_RATE = 5.0  # [Hz]
MOST_KEPT = 20  # goals that are over, in the status


class Goal:
    """A goal of a client: `message` is what it wants."""

    def __init__(self, server: ActionServer, identity: Any, message: Any) -> None:
        self._server, self.identity, self.message = server, identity, message
        self.status = 1  # active

    @property
    def active(self) -> bool:
        """Whether it is not over."""
        return self.status == 1

    def end(self, status: int, text: str = "", **result: Any) -> None:
        """End it with a status of GoalStatus, and a result."""
        if self.active:
            self.status = status
            self._server.report(self, text, result)


class ActionServer:
    """Serves an action.

    Args:
        session: where.
        name: of the action, a namespace.
        kind: such as ``control_msgs/FollowJointTrajectory``.
        now: gives the sim time [s].
        accept: takes a goal; it ends the goal at once if it refuses it.
        cancel: the goal is cancelled, or another one came; it ends the goal.
    """

    def __init__(
        self,
        session: Session,
        name: str,
        kind: str,
        now: Callable[[], float],
        accept: Callable[[Goal], object],
        cancel: Callable[[Goal], object],
    ) -> None:
        self._now, self._accept, self._cancel = now, accept, cancel
        self.goal: Goal | None = None
        self._over: list[Goal] = []
        self._ticks = Ticks(STATUS_RATE)
        self._feedback = session.publish(f"{name}/feedback", f"{kind}ActionFeedback", 10)
        self._results = session.publish(f"{name}/result", f"{kind}ActionResult", 50)
        self._states = session.publish(f"{name}/status", "actionlib_msgs/GoalStatusArray", 50, latch=True)
        self._goals = session.subscribe(f"{name}/goal", f"{kind}ActionGoal", self._on_goal, 10)
        self._cancels = session.subscribe(f"{name}/cancel", "actionlib_msgs/GoalID", self._on_cancel, 10)

    @property
    def watched(self) -> bool:
        """Whether a client follows the status."""
        return self._states.subscribed

    def end(self) -> None:
        """Serve it no longer."""
        self._goals.end()
        self._cancels.end()

    def _on_goal(self, message: Any) -> None:
        identity = message.goal_id
        if not identity.id:
            identity.id = f"goal-{self._now():.9f}"
        goal = Goal(self, identity, message.goal)
        if not finite(message):
            goal.end(REJECTED, "a number is not finite")
            return
        if self.goal is not None and self.goal.active:
            self._cancel(self.goal)
        self.goal = goal
        self._accept(goal)
        self.send_status()

    def _on_cancel(self, message: Any) -> None:
        goal = self.goal
        if goal is not None and goal.active and message.id in ("", goal.identity.id):
            self._cancel(goal)

    def update(self) -> None:
        """Publish the status, if it is time."""
        if self._ticks.due(self._now()):
            self.send_status()

    def send_status(self) -> None:
        """Publish the status of the goals."""
        message = self._states.kind()
        set_stamp(message.header.stamp, self._now())
        goals = [*self._over, *([self.goal] if self.goal is not None and self.goal.active else [])]
        message.status_list = [STATUS(goal_id=one.identity, status=one.status) for one in goals]
        self._states.publish(message)

    def send_feedback(self, goal: Goal, feedback: Any) -> None:
        """Publish how far a goal is."""
        if self._feedback.listened:
            message = self._feedback.kind(feedback=feedback)
            message.status = STATUS(goal_id=goal.identity, status=goal.status)
            set_stamp(message.header.stamp, self._now())
            self._feedback.publish(message)

    def report(self, goal: Goal, text: str, result: dict[str, Any]) -> None:
        """Publish the result of a goal."""
        self._over = [*self._over, goal][-MOST_KEPT:]
        message = self._results.kind()
        message.status = STATUS(goal_id=goal.identity, status=goal.status, text=text)
        for name, value in result.items():
            setattr(message.result, name, value)
        set_stamp(message.header.stamp, self._now())
        self._results.publish(message)
        self.send_status()
