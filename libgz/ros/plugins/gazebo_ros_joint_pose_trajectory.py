"""gazebo_ros_joint_pose_trajectory: sets positions of joints along a trajectory."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, Any

from libgz.base.law import Number, law
from libgz.classic.physics import Link
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.ros.plugin import TICK_SLACK, Endpoint, Parameter, Periodic, Rate, Ticks
from libgz.ros.session import finite

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.ros")

WORLD = ("", "world", "map", "/world", "/map")  # names of the world's frame


class GazeboRosJointPoseTrajectory(Periodic, ModelPlugin):
    """Sets the positions of a JointTrajectory, point after point: each after the times of those before it.

    Where a message's frame is a link, that link stays where it is. In ROS 1, physics is disabled until the time of the
    last point is over, unless a request says otherwise.
    """

    STATE = ("points", "names", "due", "begin", "holds", "still")

    holds = False  # whether it has disabled physics

    due = Number(math.inf)  # sim time of the next point [s]
    begin = Number()  # the same, as the trajectory has it [s]

    parameters = (
        Parameter("topicName", "set_joint_trajectory", "trajectories"),
        Parameter("serviceName", "set_joint_trajectory", "sets a trajectory"),
        Parameter("updateRate", Rate(0.0), "in ROS 2: at most so many points a second [Hz]", ros2=Rate(100.0)),
    )
    endpoints = (
        Endpoint("subscribes", "<topicName>", "trajectory_msgs/JointTrajectory"),
        Endpoint("serves", "<serviceName>", "gazebo_msgs/SetJointTrajectory"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Subscribe and serve."""
        self.open(sdf, model.GetName())
        self.model, self.world, self.ticks = model, model.GetWorld(), Ticks(0.0)
        kind = "trajectory_msgs/JointTrajectory"
        self.trajectories = self.subscribe(self.given.topicName, kind, self.OnTrajectory, 1 if self.two else 100)
        self.service = self.serve(self.given.serviceName, "gazebo_msgs/SetJointTrajectory", self.OnSet)
        self.Reset()
        self.run()

    def Reset(self) -> None:
        """Forget the trajectory."""
        self._hold(False)
        self.points: list[tuple[float, list[float]]] = []
        self.names: list[str] = []
        self.due, self.still = math.inf, ""

    def OnSet(self, request: Any) -> Any:
        """A trajectory by the service."""
        good, text = self._take(request.joint_trajectory, request.disable_physics_updates)
        return self.service.kind.response(success=good, status_message=text)

    def OnTrajectory(self, message: Any) -> None:
        """A trajectory by the topic."""
        good, text = self._take(message, not self.two)
        if not good:
            log.error("%s: %s", self.handleName, text)

    def _hold(self, holds: bool) -> None:
        """Disable physics, or enable it again."""
        if holds != self.holds and (self.holds or self.world.PhysicsEnabled()):
            self.world.SetPhysicsEnabled(not holds)
            self.holds = holds

    def _link(self, name: str) -> Link | None:
        """A link of the world."""
        found = self.world.EntityByName(name) if name else None
        return found if isinstance(found, Link) else None

    def _model(self, frame: str) -> Model:
        """The model whose joints are set: that of the frame, if it is a link."""
        link = self._link(frame)
        return self.model if link is None else link.GetModel()

    def _take(self, message: Any, holds: bool) -> tuple[bool, str]:
        names, frame = list(message.joint_names), message.header.frame_id
        if frame in WORLD:
            frame = ""
        elif self._link(frame) is None:
            return False, f"frame_id is {frame!r}; it must be world, map or a link"
        model = self._model(frame)
        unknown = [name for name in names if model.GetJoint(name) is None]
        if unknown:
            return False, f"model {model.GetName()!r} has no joint {unknown[0]!r}"
        if not finite(message) or any(len(point.positions) != len(names) for point in message.points):
            return False, "a point has not one finite position for each joint"
        points = [(point.time_from_start.seconds, list(map(float, point.positions))) for point in message.points]
        self.points, self.names, self.still = points, names, frame
        self.begin = max(message.header.stamp.seconds, self.world.core.GetSimTime())
        self.due = self.begin if points else math.inf
        self._hold(holds and bool(points))
        return True, "trajectory set"

    @law
    def wanted(self) -> Any:
        """Whether it is time for the next point."""
        return self.world.core.clock.sim_time >= self.due

    def work(self, now: float) -> None:
        """Set the positions of the next point; after the last one, enable physics again."""
        if not self.points:
            self.due = math.inf
            self._hold(False)
            return
        wait, positions = self.points.pop(0)
        model, link = self._model(self.still), self._link(self.still)
        place = link.WorldPose() if link is not None else None
        for name, position in zip(self.names, positions, strict=True):
            joint = model.GetJoint(name)
            if joint is not None:
                joint.SetPosition(0, position, True)
        if link is not None and place is not None:
            model.SetLinkWorldPose(place, link)
        self.begin += wait
        period = 1.0 / self.given.updateRate if self.two and self.given.updateRate > 0.0 else 0.0
        self.due = max(self.begin, now + period - TICK_SLACK * period)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosJointPoseTrajectory)
