"""ElevatorPlugin: moves an elevator's car between floors, and its doors."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic import transport
from libgz.classic.event import Events
from libgz.classic.plugin import ModelPlugin
from libgz.classic.plugins._names import named_joint
from libgz.classic.plugins._pids import pid_of

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

__all__ = ["ElevatorPlugin"]

log = logging.getLogger("libgz.classic")

NEAR, CLOSED, OPEN = 0.01, 0.0, 1.0  # [m]; doors: target positions [m]
DOOR_TOLERANCE = 0.05  # [m]
MOST_REQUESTS, MOST_FLOORS = 1000, 1_000_000


class ElevatorPlugin(ModelPlugin):
    """Brings an elevator to the floor whose number comes as a GzString on a topic.

    The doors close, the car moves, the doors open, stay so for a time, and close. Requests that come meanwhile are
    served afterwards, in order. The car's joint stands at floor * floor_height; the doors' is 0 when closed, 1 m when
    open, or its limits where they are narrower.

    Elements:
        lift_joint, door_joint: names of prismatic joints.
        floor_height: between two floors [m] (3).
        door_wait_time: for which the doors stay open [s] (5).
        topic: of the requests.
        lift_pid, door_pid: `<p>`, `<i>`, `<d>`, `<i_max>`, `<i_min>`, `<cmd_max>`, `<cmd_min>` of the joints'
            controllers [N/m]; by default p 1000, i 0, d 500.
    """

    STATE = ("floor", "door", "waiting", "requests", "lift_pid", "door_pid", "before")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and subscribe.

        Raises:
            NotFoundError: an element or joint is missing.
            ParameterError: a height or time is not positive.
        """
        self.lift, self.doors = named_joint(model, sdf, "lift_joint"), named_joint(model, sdf, "door_joint")
        topic = sdf.Get(str, "topic").strip()
        if not topic:
            raise NotFoundError(f"{sdf.where}: <topic> is missing; it names the topic of the requests")
        self.height, self.wait = sdf.Get(float, "floor_height", 3.0)[0], sdf.Get(float, "door_wait_time", 5.0)[0]
        if not (self.height > 0.0 and self.wait >= 0.0):
            raise ParameterError(f"{sdf.where}: <floor_height> must be positive, <door_wait_time> not negative")
        self.lift_pid, self.door_pid = (pid_of(sdf, tag, p=1000.0, d=500.0) for tag in ("lift_pid", "door_pid"))
        self.requests: list[int] = []
        self.Reset()
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(topic, self.OnRequest)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Stand at floor 0 with closed doors."""
        self.floor, self.door, self.before = 0, CLOSED, -1.0
        self.waiting: float | None = None  # since when the doors are open [s]
        self.requests.clear()
        for pid in (self.lift_pid, self.door_pid):
            pid.Reset()

    def OnRequest(self, message: Any) -> None:
        """Keep the request of a message."""
        try:
            floor = int(message.data)
        except ValueError:
            log.error("ElevatorPlugin: the request %.200r is no number of a floor", message.data)
            return
        self.MoveToFloor(floor)

    def MoveToFloor(self, floor: int) -> None:
        """Keep a request for a floor, unless there are too many, or it is none."""
        if abs(floor) <= MOST_FLOORS and len(self.requests) < MOST_REQUESTS:
            self.requests.append(floor)

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Decide what is next, and apply efforts."""
        now = info.simTime.Double()
        passed = now - self.before if self.before >= 0.0 else 0.0
        self.before = now
        self._decide(now)
        self._hold(self.lift, self.lift_pid, self.floor * self.height, passed)
        self._hold(self.doors, self.door_pid, self._door_target(), passed)

    def _decide(self, now: float) -> None:
        if self.waiting is not None:
            if now - self.waiting >= self.wait:
                self.waiting, self.door = None, CLOSED
        elif self.door == OPEN:
            if abs(self.doors.Position(0) - self._door_target()) < DOOR_TOLERANCE:
                self.waiting = now
        elif abs(self.doors.Position(0) - self._door_target()) < DOOR_TOLERANCE and self.requests:
            self.floor = self.requests[0]
            if abs(self.lift.Position(0) - self.floor * self.height) < NEAR:
                self.requests.pop(0)
                self.door = OPEN

    def _door_target(self) -> float:
        return max(self.doors.LowerLimit(0), min(self.door, self.doors.UpperLimit(0)))

    @staticmethod
    def _hold(joint: Joint, pid: Any, target: float, passed: float) -> None:
        joint.SetForce(0, pid.Update(joint.Position(0) - target, passed))
