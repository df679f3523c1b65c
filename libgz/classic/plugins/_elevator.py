"""ElevatorPlugin: moves an elevator's car between floors, and its doors."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
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

CLOSED, OPEN = 0.0, 1.0  # target positions of the doors [m]
LIFT_TOLERANCE, DOOR_TOLERANCE = 0.15, 0.05  # [m] within which they have arrived
MOST_FLOORS = 1_000_000
TRIP = ("close", "move", "open", "wait", "close")
LIFT_GAIN, DOOR_GAINS = 100_000.0, (2.0, 1.0)  # p and d [N/m], [N s/m]; p, d


class ElevatorPlugin(ModelPlugin):
    """Brings an elevator to the floor whose number comes as a GzString on a topic.

    The doors close, the car moves, the doors open, stay so for a time, and close. Requests that come meanwhile are
    ignored. The car's joint stands at floor * floor_height, within 0.15 m; the doors' is 0 when closed, 1 m when open,
    or its limits where they are narrower.

    Elements:
        lift_joint, door_joint: names of prismatic joints.
        floor_height: between two floors [m] (3).
        door_wait_time: for which the doors stay open [s] (5).
        topic: of the requests (~/elevator).
        lift_pid, door_pid: `<p>`, `<i>`, `<d>`, `<i_max>`, `<i_min>`, `<cmd_max>`, `<cmd_min>` of the joints'
            controllers [N/m]; by default p 100000 and d 100000 of the car, p 2 of the doors.
    """

    STATE = ("floor", "door", "wanted", "steps", "begun", "since", "lift_pid", "door_pid", "before", "first")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and subscribe.

        Raises:
            NotFoundError: a joint is missing.
            ParameterError: a height or time is not positive.
        """
        self.lift, self.doors = named_joint(model, sdf, "lift_joint"), named_joint(model, sdf, "door_joint")
        topic = sdf.Get(str, "topic").strip() or "~/elevator"
        self.height, self.wait = sdf.Get(float, "floor_height", 3.0)[0], sdf.Get(float, "door_wait_time", 5.0)[0]
        if not (self.height > 0.0 and self.wait >= 0.0):
            raise ParameterError(f"{sdf.where}: <floor_height> must be positive, <door_wait_time> not negative")
        self.lift_pid = pid_of(sdf, "lift_pid", p=LIFT_GAIN, d=LIFT_GAIN)
        self.door_pid = pid_of(sdf, "door_pid", p=DOOR_GAINS[0], d=DOOR_GAINS[1])
        # As in Gazebo, whose time between two updates of the doors is that since the first: they are hardly damped.
        self.damped = sdf.HasElement("door_pid")
        self.steps: list[str] = []
        self.Reset()
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(topic, self.OnRequest, kind="GzString")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Forget the trip; car and doors keep their targets of floor 0 and closed doors."""
        self.floor, self.door, self.before, self.first = 0, CLOSED, -1.0, -1.0
        # Floor of the trip; whether the first of the steps has begun, and when [s].
        self.wanted, self.begun, self.since = 0, False, 0.0
        self.steps.clear()
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
        """Begin a trip to a floor, unless there is one already, or no such floor."""
        if abs(floor) <= MOST_FLOORS and not self.steps:
            self.steps = list(TRIP)
            self.wanted, self.begun = floor, False

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Decide what is next, and apply efforts."""
        now = info.simTime.Double()
        self._decide(now)
        if self.before >= 0.0:
            self._hold(self.lift, self.lift_pid, self.floor * self.height, now - self.before)
            self._hold(
                self.doors, self.door_pid, self._door_target(), now - (self.before if self.damped else self.first)
            )
        else:
            self.first = now
        self.before = now

    def _decide(self, now: float) -> None:
        if not self.steps:
            return
        step = self.steps[0]
        if not self.begun:
            self.begun, self.since = True, now
            if step == "move":
                self.floor = self.wanted
            elif step != "wait":
                self.door = OPEN if step == "open" else CLOSED
        elif self._done(step, now):
            self.steps.pop(0)
            self.begun = False

    def _done(self, step: str, now: float) -> bool:
        if step == "wait":
            return now - self.since >= self.wait
        if step == "move":
            return abs(self.lift.Position(0) - self.floor * self.height) < LIFT_TOLERANCE
        return abs(self.doors.Position(0) - self._door_target()) < DOOR_TOLERANCE

    def _door_target(self) -> float:
        return max(self.doors.LowerLimit(0), min(self.door, self.doors.UpperLimit(0)))

    @staticmethod
    def _hold(joint: Joint, pid: Any, target: float, passed: float) -> None:
        joint.SetForce(0, pid.Update(joint.Position(0) - target, passed))
