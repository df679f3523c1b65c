"""ActionServer: the topics of an action, with one goal at a time; a new goal preempts the last one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from libgz.ros.plugin import Ticks
from libgz.ros.session import Later, Session, finite, set_stamp
from libgz.ros.types import Message, message_type, service_type

__all__ = ["ActionServer", "ActionServer2", "Goal"]

STATUS = message_type("actionlib_msgs/GoalStatus")
REJECTED = 5
STATUS_RATE = 5.0  # [Hz]
MOST_KEPT = 20  # goals that are over, in the status


class Goal:
    """A goal of a client: `message` is what it wants."""

    def __init__(self, server: ActionServer | ActionServer2, identity: Any, message: Any) -> None:
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
        self.feedback_type = message_type(f"{kind}Feedback")
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


# Statuses of goals in ROS 1 -> in ROS 2.
STATUSES = {1: 2, 2: 5, 3: 4, 4: 6, 5: 6}
KEPT = 900.0  # [s] that a client may ask for a result later
NONE_TO_CANCEL = 1  # of action_msgs/CancelGoal


class ActionServer2:
    """Serves an action of ROS 2, with one goal at a time; a new goal preempts the last one.

    Args:
        session: where.
        name: of the action.
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
        self.feedback_type = message_type(f"{kind}_Feedback", 2)
        self.goal: Goal | None = None
        self._over: dict[bytes, tuple[int, Any]] = {}  # statuses and results of goals that are over
        own = f"{name}/_action"
        self._feedback = session.publish(f"{own}/feedback", f"{kind}_FeedbackMessage", 10)
        self._states = session.publish(f"{own}/status", "action_msgs/GoalStatusArray", 1, latch=True)
        self._sent, self._result = (service_type(f"{kind}_{one}", 2) for one in ("SendGoal", "GetResult"))
        self._services = [
            session.serve(f"{own}/send_goal", f"{kind}_SendGoal", self._on_goal),
            session.serve(f"{own}/cancel_goal", "action_msgs/CancelGoal", self._on_cancel),
            session.serve(f"{own}/get_result", f"{kind}_GetResult", self._on_result),
        ]

    def _on_goal(self, request: Any) -> Message:
        goal = Goal(self, bytes(request.goal_id.uuid), request.goal)
        answer: Any = self._sent.response()
        set_stamp(answer.stamp, self._now())
        if not finite(request):
            return answer  # type: ignore[no-any-return]
        before = self.goal
        self.goal = goal
        if before is not None and before.active:
            self._cancel(before)
        self._accept(goal)
        answer.accepted = goal.status != REJECTED
        if not answer.accepted:
            self._over.pop(goal.identity, None)
        self.send_status()
        return answer  # type: ignore[no-any-return]

    def _on_cancel(self, request: Any) -> Message:
        answer: Any = service_type("action_msgs/CancelGoal", 2).response(return_code=NONE_TO_CANCEL)
        goal, wanted = self.goal, bytes(request.goal_info.goal_id.uuid)
        if goal is not None and goal.active and (not any(wanted) or wanted == goal.identity):
            answer.return_code, answer.goals_canceling = 0, [self._info(goal)]
            self._cancel(goal)
        return answer  # type: ignore[no-any-return]

    def _on_result(self, request: Any) -> Message | Later:
        identity = bytes(request.goal_id.uuid)
        known = identity in self._over or (self.goal is not None and self.goal.identity == identity)

        def poll() -> Message | None:
            if identity not in self._over:
                return None
            status, result = self._over[identity]
            return self._result.response(status=status, result=result)  # type: ignore[no-any-return]

        return Later(poll, KEPT, self._result.response()) if known else self._result.response()

    @property
    def watched(self) -> bool:
        """Whether something is to be done in each step without a goal: nothing."""
        return False

    def end(self) -> None:
        """Serve it no longer."""
        for service in self._services:
            service.end()

    def _info(self, goal: Goal) -> Any:
        info = message_type("action_msgs/GoalInfo", 2)()
        info.goal_id.uuid = list(goal.identity)
        return info

    def update(self) -> None:
        """Nothing: the status is published when it changes."""

    def send_status(self) -> None:
        """Publish the status of the goal."""
        if self.goal is not None:
            one = message_type("action_msgs/GoalStatus", 2)(
                goal_info=self._info(self.goal), status=STATUSES[self.goal.status]
            )
            self._states.publish(self._states.kind(status_list=[one]))

    def send_feedback(self, goal: Goal, feedback: Any) -> None:
        """Publish how far a goal is."""
        if self._feedback.listened:
            message = self._feedback.kind(feedback=feedback)
            message.goal_id.uuid = list(goal.identity)
            self._feedback.publish(message)

    def report(self, goal: Goal, _text: str, result: dict[str, Any]) -> None:
        """Keep the result of a goal."""
        while len(self._over) >= MOST_KEPT:
            del self._over[next(iter(self._over))]
        made = message_type(f"{self._result.name.removesuffix('_GetResult')}_Result", 2)(**result)
        self._over[goal.identity] = STATUSES[goal.status], made
        self.send_status()
