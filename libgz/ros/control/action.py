"""ActionServer: the topics and services of an action, with one goal at a time; a new goal preempts the last one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

from libgz.ros.plugin import Ticks
from libgz.ros.session import Later, NodeSession, Service, Session, Subscription, finite, set_stamp
from libgz.ros.types import Message, message_type, service_type

__all__ = ["ActionServer", "Goal", "serve_action"]

REJECTED = 5
MOST_KEPT = 20  # goals that are over
STATUS_RATE = 5.0  # [Hz] in ROS 1
STATUSES = {1: 2, 2: 5, 3: 4, 4: 6, 5: 6}  # of goals in ROS 1 -> in ROS 2
KEPT = 900.0  # [s] that a client of ROS 2 may ask for a result later
MOST_ASKING = 8  # that wait for results of one action at the same time: a client asks once for each goal
NONE_TO_CANCEL = 1  # of action_msgs/CancelGoal


class Goal:
    """A goal of a client: `message` is what it wants; `status` is one of actionlib_msgs/GoalStatus."""

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


def serve_action(
    session: Session | NodeSession,
    name: str,
    kind: str,
    now: Callable[[], float],
    accept: Callable[[Goal], object],
    cancel: Callable[[Goal], object],
) -> ActionServer:
    """Serve an action.

    Args:
        session: where.
        name: of the action, a namespace.
        kind: such as ``control_msgs/FollowJointTrajectory``.
        now: gives the sim time [s].
        accept: takes a goal; it ends the goal at once if it refuses it.
        cancel: the goal is cancelled, or another one came; it ends the goal.
    """
    made = _Services if session.version == 2 else _Topics
    return made(session, name, kind, now, accept, cancel)


class ActionServer(ABC):
    """An action that is served, as `serve_action` says.

    Attributes:
        goal: the last one.
        feedback_type: of what `send_feedback` takes.
    """

    feedback_type: Any

    def __init__(
        self,
        session: Session | NodeSession,
        name: str,
        kind: str,
        now: Callable[[], float],
        accept: Callable[[Goal], object],
        cancel: Callable[[Goal], object],
    ) -> None:
        self._now, self._accept, self._cancel = now, accept, cancel
        self.goal: Goal | None = None
        self._kept: Sequence[Subscription | Service] = self._open(session, name, kind)

    @property
    def watched(self) -> bool:
        """Whether `update` has something to do without a goal."""
        return False

    def end(self) -> None:
        """Serve it no longer."""
        for one in self._kept:
            one.end()

    @abstractmethod
    def update(self) -> None:
        """Publish what is due."""

    @abstractmethod
    def _open(self, session: Session | NodeSession, name: str, kind: str) -> Sequence[Subscription | Service]:
        """Publish, subscribe, serve; what is to be ended."""

    @abstractmethod
    def send_status(self) -> None:
        """Publish the status of goals."""

    @abstractmethod
    def send_feedback(self, goal: Goal, feedback: Any) -> None:
        """Publish how far a goal is."""

    @abstractmethod
    def report(self, goal: Goal, text: str, result: dict[str, Any]) -> None:
        """A goal is over: publish its result, or keep it for who asks."""

    @property
    def running(self) -> Goal | None:
        """The goal that is not over."""
        return self.goal if self.goal is not None and self.goal.active else None

    def _begin(self, goal: Goal) -> None:
        """Let a goal replace the last one."""
        if self.running is not None:
            self._cancel(self.running)
        self.goal = goal
        self._accept(goal)
        self.send_status()


class _Topics(ActionServer):
    """An action of ROS 1, as actionlib has it."""

    def _open(self, session: Session | NodeSession, name: str, kind: str) -> Sequence[Subscription]:
        self.feedback_type = message_type(f"{kind}Feedback")
        self._status = message_type("actionlib_msgs/GoalStatus")
        self._over: list[Goal] = []
        self._ticks = Ticks(STATUS_RATE)
        self._feedback = session.publish(f"{name}/feedback", f"{kind}ActionFeedback", 10)
        self._results = session.publish(f"{name}/result", f"{kind}ActionResult", 50)
        self._states = session.publish(f"{name}/status", "actionlib_msgs/GoalStatusArray", 50, latch=True)
        return [
            session.subscribe(f"{name}/goal", f"{kind}ActionGoal", self._on_goal, 10),
            session.subscribe(f"{name}/cancel", "actionlib_msgs/GoalID", self._on_cancel, 10),
        ]

    @property
    def watched(self) -> bool:
        """Whether a client follows the status."""
        return self._states.subscribed

    def _on_goal(self, message: Any) -> None:
        identity = message.goal_id
        if not identity.id:
            identity.id = f"goal-{self._now():.9f}"
        goal = Goal(self, identity, message.goal)
        if finite(message):
            self._begin(goal)
        else:
            goal.end(REJECTED, "a number is not finite")

    def _on_cancel(self, message: Any) -> None:
        goal = self.running
        if goal is not None and message.id in ("", goal.identity.id):
            self._cancel(goal)

    def update(self) -> None:
        """Publish the status, if it is time."""
        if self._ticks.due(self._now()):
            self.send_status()

    def send_status(self) -> None:
        """Publish the status of the goals."""
        message = self._states.kind()
        set_stamp(message.header.stamp, self._now())
        goals = [*self._over, *([self.running] if self.running is not None else [])]
        message.status_list = [self._status(goal_id=one.identity, status=one.status) for one in goals]
        self._states.publish(message)

    def send_feedback(self, goal: Goal, feedback: Any) -> None:
        """Publish how far a goal is."""
        if self._feedback.listened:
            message = self._feedback.kind(feedback=feedback)
            message.status = self._status(goal_id=goal.identity, status=goal.status)
            set_stamp(message.header.stamp, self._now())
            self._feedback.publish(message)

    def report(self, goal: Goal, text: str, result: dict[str, Any]) -> None:
        """Publish the result of a goal."""
        self._over = [*self._over, goal][-MOST_KEPT:]
        message = self._results.kind()
        message.status = self._status(goal_id=goal.identity, status=goal.status, text=text)
        for name, value in result.items():
            setattr(message.result, name, value)
        set_stamp(message.header.stamp, self._now())
        self._results.publish(message)
        self.send_status()


class _Services(ActionServer):
    """An action of ROS 2: its goals come, and are asked for, by services."""

    def _open(self, session: Session | NodeSession, name: str, kind: str) -> Sequence[Service]:
        self.feedback_type = message_type(f"{kind}_Feedback", 2)
        self._over: dict[bytes, tuple[int, Any]] = {}  # statuses and results of goals that are over
        self._made = message_type(f"{kind}_Result", 2)
        self._sent, self._asked = (service_type(f"{kind}_{one}", 2) for one in ("SendGoal", "GetResult"))
        own = f"{name}/_action"
        self._feedback = session.publish(f"{own}/feedback", f"{kind}_FeedbackMessage", 10)
        self._states = session.publish(f"{own}/status", "action_msgs/GoalStatusArray", 1, latch=True)
        return [
            session.serve(f"{own}/send_goal", f"{kind}_SendGoal", self._on_goal),
            session.serve(f"{own}/cancel_goal", "action_msgs/CancelGoal", self._on_cancel),
            session.serve(f"{own}/get_result", f"{kind}_GetResult", self._on_result),
        ]

    def _on_goal(self, request: Any) -> Message:
        answer: Any = self._sent.response()
        set_stamp(answer.stamp, self._now())
        if finite(request):
            goal = Goal(self, bytes(request.goal_id.uuid), request.goal)
            self._begin(goal)
            answer.accepted = goal.status != REJECTED
            if not answer.accepted:
                self._over.pop(goal.identity, None)
        return answer  # type: ignore[no-any-return]

    def _on_cancel(self, request: Any) -> Message:
        answer: Any = service_type("action_msgs/CancelGoal", 2).response(return_code=NONE_TO_CANCEL)
        goal, wanted = self.running, bytes(request.goal_info.goal_id.uuid)
        if goal is not None and (not any(wanted) or wanted == goal.identity):
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
            return self._asked.response(status=status, result=result)  # type: ignore[no-any-return]

        nothing = self._asked.response()
        return Later(poll, KEPT, nothing, MOST_ASKING) if known else nothing

    def _info(self, goal: Goal) -> Any:
        info = message_type("action_msgs/GoalInfo", 2)()
        info.goal_id.uuid = list(goal.identity)
        return info

    def update(self) -> None:
        """Nothing is due: the status is published when it changes."""

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
        self._over[goal.identity] = STATUSES[goal.status], self._made(**result)
        self.send_status()
