"""gazebo_ros_joint_pose_trajectory: sets positions of joints along a trajectory."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, Any

from libgz.base.law import Number, law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.ros.plugin import Endpoint, Parameter, Periodic, Ticks
from libgz.ros.session import finite

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.ros")


class GazeboRosJointPoseTrajectory(Periodic, ModelPlugin):
    """Sets the positions of a JointTrajectory, point after point: each after the times of those before it.

    In ROS 1, physics is disabled until the time of the last point is over, unless a request says otherwise.
    """

    STATE = ("points", "names", "due", "holds")

    holds = False  # whether it has disabled physics

    due = Number(math.inf)  # sim time of the next point [s]

    parameters = (
        Parameter("topicName", "set_joint_trajectory", "trajectories"),
        Parameter("serviceName", "set_joint_trajectory", "sets a trajectory"),
        Parameter("updateRate", 0.0, "accepted without effect, as in the original"),
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
        self.trajectories = self.subscribe(self.given.topicName, kind, self.OnTrajectory, 100)
        self.service = self.serve(self.given.serviceName, "gazebo_msgs/SetJointTrajectory", self.OnSet)
        self.Reset()
        self.run()

    def Reset(self) -> None:
        """Forget the trajectory."""
        self._hold(False)
        self.points: list[tuple[float, list[float]]] = []
        self.names: list[str] = []
        self.due = math.inf

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

    def _take(self, message: Any, holds: bool) -> tuple[bool, str]:
        names = list(message.joint_names)
        unknown = [name for name in names if self.model.GetJoint(name) is None]
        if unknown:
            return False, f"model {self.model.GetName()!r} has no joint {unknown[0]!r}"
        if not finite(message) or any(len(point.positions) != len(names) for point in message.points):
            return False, "a point has not one finite position for each joint"
        points = [(point.time_from_start.seconds, list(map(float, point.positions))) for point in message.points]
        self.points, self.names = points, names
        self.due = max(message.header.stamp.seconds, self.world.core.GetSimTime()) if points else math.inf
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
        for name, position in zip(self.names, positions, strict=True):
            joint = self.model.GetJoint(name)
            if joint is not None:
                joint.SetPosition(0, position, True)
        self.due += wait


GZ_REGISTER_MODEL_PLUGIN(GazeboRosJointPoseTrajectory)
