"""The controllers of ros_controllers: what they read and command, by their names in parameters."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from libgz.base.errors import ParameterError
from libgz.ros.control.action import ActionServer, Goal, serve_action
from libgz.ros.control.hardware import EFFORT, POSITION, RobotHardware, SimJoint
from libgz.ros.control.pid import RosPid, number_of
from libgz.ros.control.trajectory import Trajectory
from libgz.ros.plugin import Ticks, bounded_rate
from libgz.ros.session import NodeSession, Service, Session, Subscription, finite, set_stamp

__all__ = [
    "Commands",
    "Controller",
    "Gripper",
    "GroupCommands",
    "GroupPositionCommands",
    "JointStates",
    "JointTrajectories",
    "PositionCommands",
    "VelocityCommands",
]

log = logging.getLogger("libgz.ros")

ABORTED, PREEMPTED, REJECTED, SUCCEEDED = 4, 2, 5, 3  # of actionlib_msgs/GoalStatus
COMMANDS = {1: "command", 2: "commands"}  # topics in ROS 1 and 2
TRAJECTORIES = {1: ("command", "state", 1), 2: ("joint_trajectory", "controller_state", 10)}  # and the depth of states


class Controller:
    """Base of all controllers.

    Args:
        name: full, such as ``/robot/arm_controller``.
        values: its parameters.
        hardware: the robot.
        session: for its topics; in ROS 2, of its node.
        now: gives the sim time [s].
        interface: what it commands its joints by; empty for nothing.

    Raises:
        ParameterError: a parameter is missing or invalid.
    """

    joints: Sequence[SimJoint] = ()
    listening: Sequence[Subscription | Service | ActionServer] = ()

    def __init__(
        self,
        name: str,
        values: Mapping[str, Any],
        hardware: RobotHardware,
        session: Session | NodeSession,
        now: Callable[[], float],
        interface: str = "",
    ) -> None:
        self.name, self.values, self.hardware, self.session = name, values, hardware, session
        self.now, self.interface, self.state = now, interface, "initialized"
        self.load()

    def load(self) -> None:
        """Read the parameters, find the joints, open topics."""

    def starting(self) -> None:
        """It begins to run."""

    def update(self, elapsed: float) -> None:
        """Command its joints, `elapsed` seconds after the last update."""

    def stopping(self) -> None:
        """It stops."""

    def end(self) -> None:
        """Subscribe and serve no longer: it is unloaded."""
        for one in self.listening:
            one.end()

    def find(self, names: Any) -> list[SimJoint]:
        """The joints of some names.

        Raises:
            ParameterError: there is none of a name, or its transmission has another interface.
        """
        if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
            raise ParameterError(f"controller {self.name}: its joints are {names!r}; they must be names")
        found = []
        for name in names:
            joint = self.hardware.claim(name, self.interface)
            if joint is None:
                known = [one.name for one in self.hardware.joints.values() if one.interface == self.interface]
                raise ParameterError(
                    f"controller {self.name}: there is no joint {name!r} with {self.interface}; "
                    f"there are {', '.join(known) or 'none'}"
                )
            found.append(joint)
        return found

    def pid(self, *keys: str) -> RosPid:
        """The gains below some keys of its parameters.

        Raises:
            ParameterError: there are none.
        """
        found: Any = self.values
        for key in keys:
            found = found.get(key) if isinstance(found, Mapping) else None
        where = "/".join([self.name, *keys])
        if not isinstance(found, Mapping):
            raise ParameterError(f"controller {self.name}: there are no gains {where}")
        return RosPid(found, where)


class JointStates(Controller):
    """Publishes the states of all joints.

    Attributes:
        space: the namespace of the topic: that of the controller.
    """

    space = ""

    @property
    def reported(self) -> list[SimJoint]:
        """The joints whose states are published."""
        return list(self.hardware.joints.values())

    def load(self) -> None:
        """Advertise."""
        rate = number_of(self.values, "publish_rate", math.nan, self.name)
        if not rate > 0.0:
            raise ParameterError(f"controller {self.name}: parameter publish_rate is missing or not positive")
        self._ticks = Ticks(bounded_rate(rate, f"parameter {self.name}/publish_rate"))
        self.space = self.space or self.name.rpartition("/")[0]
        self._extra = list(self._extra_joints())
        self._publication = self.session.publish(f"{self.space}/joint_states", "sensor_msgs/JointState", 4)

    def _extra_joints(self) -> Iterator[tuple[str, tuple[float, ...]]]:
        """Names, with position, velocity and effort, of joints that the robot does not have; wrong ones are left out,
        as in the original."""
        given = self.values.get("extra_joints", [])
        for one in given if isinstance(given, list) else [given]:
            name = one.get("name") if isinstance(one, Mapping) else None
            if not isinstance(name, str) or name in self.hardware.joints:
                log.warning("controller %s: extra joint %.200r has no name, or that of a joint", self.name, one)
                continue
            try:
                yield name, tuple(number_of(one, key, 0.0, self.name) for key in ("position", "velocity", "effort"))
            except ParameterError as error:
                log.warning("controller %s: extra joint %.200r is left out: %s", self.name, name, error)

    def update(self, elapsed: float) -> None:
        """Publish, if it is time."""
        if not self._ticks.due(self.now()) or not self._publication.listened:
            return
        joints = self.reported
        message = self._publication.kind(name=[*(one.name for one in joints), *(name for name, _ in self._extra)])
        set_stamp(message.header.stamp, self.now())
        for at, key in enumerate(("position", "velocity", "effort")):
            setattr(message, key, [*(getattr(one, key) for one in joints), *(values[at] for _, values in self._extra)])
        self._publication.publish(message)


class Commands(Controller):
    """Takes commands for its joint, or for all of its joints together, and passes them on or follows them by gains.

    Attributes:
        target: what it follows: position or velocity; empty: commands are passed on.
        group: whether the topic has a number for each of several joints.
    """

    target = ""
    group = False

    def load(self) -> None:
        """Find the joints, and subscribe."""
        names = self.values.get("joints") if self.group else [self.values.get("joint")]
        self.joints = self.find(names)
        self._pids = []
        if self.target and self.group:
            self._pids = [self.pid(joint.name, "pid") for joint in self.joints]
        elif self.target:
            self._pids = [self.pid("pid")]
        kind = "std_msgs/Float64MultiArray" if self.group else "std_msgs/Float64"
        self._wanted: list[float] | None = None
        topic = f"{self.name}/{COMMANDS[self.session.version]}"
        self.listening = [self.session.subscribe(topic, kind, self._on_command)]
        self._states = None
        if self.target and not self.group:
            self._states = self.session.publish(f"{self.name}/state", "control_msgs/JointControllerState", 1)
        self._count = 0

    def _on_command(self, message: Any) -> None:
        wanted = list(map(float, message.data)) if self.group else [message.data]
        if len(wanted) == len(self.joints) and finite(message):
            self._wanted = wanted

    def starting(self) -> None:
        """Hold the present positions."""
        self._wanted = None
        for pid in self._pids:
            pid.reset()
        if self.target == "position":
            self._wanted = [joint.position for joint in self.joints]
        for joint in self.joints:
            joint.hold()

    def stopping(self) -> None:
        """Hold the present positions."""
        for joint in self.joints:
            joint.hold()

    def update(self, elapsed: float) -> None:
        """Command the joints."""
        wanted = self._wanted
        if wanted is None:
            if not self.target:
                return
            wanted = [0.0] * len(self.joints)
        if not self.target:
            for joint, value in zip(self.joints, wanted, strict=True):
                joint.command = value
            return
        for joint, pid, value in zip(self.joints, self._pids, wanted, strict=True):
            error = joint.error_of(value) if self.target == "position" else value - joint.velocity
            joint.command = pid.command(error, elapsed)
            self._report(joint, pid, value, error, elapsed)

    def _report(self, joint: SimJoint, pid: RosPid, value: float, error: float, elapsed: float) -> None:
        self._count += 1
        if self._states is None or self._count % 10 or not self._states.listened:
            return
        message = self._states.kind(set_point=value, error=error, time_step=elapsed, command=joint.command)
        set_stamp(message.header.stamp, self.now())
        message.process_value = joint.position if self.target == "position" else joint.velocity
        message.process_value_dot = joint.velocity
        message.p, message.i, message.d, message.i_clamp = pid.p, pid.i, pid.d, pid.most
        self._states.publish(message)


class PositionCommands(Commands):
    """Follows a position by gains."""

    target = "position"


class VelocityCommands(Commands):
    """Follows a velocity by gains."""

    target = "velocity"


class GroupCommands(Commands):
    """Passes on commands of several joints."""

    group = True


class GroupPositionCommands(GroupCommands):
    """Follows positions of several joints by gains."""

    target = "position"


class Follower(Controller):
    """Moves joints to positions by their interface: sets them, or follows them by gains."""

    def prepare(self, names: Any) -> None:
        """Find the joints and their gains."""
        self.joints = self.find(names)
        self._pids = [] if self.interface == POSITION else [self.gains(joint) for joint in self.joints]

    def gains(self, joint: SimJoint) -> RosPid:
        """The gains of a joint."""
        return self.pid("gains", joint.name)

    def reset_pids(self) -> None:
        """Forget the past of the gains."""
        for pid in self._pids:
            pid.reset()

    def follow(self, positions: Sequence[float], velocities: Sequence[float], elapsed: float) -> None:
        """Command the joints."""
        if not self._pids:
            for joint, position in zip(self.joints, positions, strict=True):
                joint.command = position
            return
        for joint, pid, position, velocity in zip(self.joints, self._pids, positions, velocities, strict=True):
            error, rate = joint.error_of(position), velocity - joint.velocity
            ahead = number_of(self._ahead, joint.name, 0.0, f"{self.name}/velocity_ff") * velocity
            joint.command = ahead + pid.command_with_rate(error, rate, elapsed)

    @property
    def _ahead(self) -> Mapping[str, Any]:
        found = self.values.get("velocity_ff")
        return found if isinstance(found, Mapping) else {}


class JointTrajectories(Follower):
    """Follows trajectories of a topic or an action."""

    def load(self) -> None:
        """Find the joints, subscribe and serve."""
        self.prepare(self.values.get("joints"))
        constraints = self.values.get("constraints")
        self._constraints: Mapping[str, Any] = constraints if isinstance(constraints, Mapping) else {}
        self._trajectory: Trajectory | None = None
        rate = number_of(self.values, "state_publish_rate", 50.0, self.name)
        self._ticks = Ticks(bounded_rate(rate, f"parameter {self.name}/state_publish_rate"))
        session, name = self.session, self.name
        self._action = serve_action(
            session,
            f"{name}/follow_joint_trajectory",
            "control_msgs/FollowJointTrajectory",
            self.now,
            self._on_goal,
            self._on_cancel,
        )
        self._topic, states, depth = TRAJECTORIES[session.version]
        self._states = session.publish(f"{name}/{states}", "control_msgs/JointTrajectoryControllerState", depth)
        self._service = session.serve(f"{name}/query_state", "control_msgs/QueryTrajectoryState", self._on_query)
        commands = session.subscribe(f"{name}/{self._topic}", "trajectory_msgs/JointTrajectory", self._on_command)
        self.listening = [commands, self._service, self._action]

    def starting(self) -> None:
        """Hold the present positions."""
        self.reset_pids()
        self._hold()

    def stopping(self) -> None:
        """End the goal, and hold."""
        if self._action.running is not None:
            self._action.running.end(PREEMPTED, "the controller was stopped")
        for joint in self.joints:
            joint.hold()

    def _hold(self) -> None:
        self._trajectory = Trajectory.standing(self.now(), [joint.position for joint in self.joints])

    def _on_query(self, request: Any) -> Any:
        at = request.time.seconds
        positions, velocities, accelerations = self._at(at)
        answer = self._service.kind.response(name=[joint.name for joint in self.joints])
        answer.position, answer.velocity, answer.acceleration = positions, velocities, accelerations
        if self.session.version == 2:
            answer.success = True
        return answer

    def _at(self, now: float) -> tuple[list[float], list[float], list[float]]:
        if self._trajectory is None:
            return [joint.position for joint in self.joints], [0.0] * len(self.joints), [0.0] * len(self.joints)
        return self._trajectory.at(now)

    def _take(self, message: Any) -> str:
        """Begin a trajectory; why it cannot, or an empty text."""
        if self.state != "running":
            return "the controller does not run"
        if not message.points:
            self._hold()
            return ""
        names = [joint.name for joint in self.joints]
        partly = bool(self.values.get("allow_partial_joints_goal", False))
        if not set(message.joint_names) <= set(names) or (set(message.joint_names) != set(names) and not partly):
            return f"the joints are {', '.join(message.joint_names)}; they must be {', '.join(names)}"
        if not finite(message):
            return "a number is not finite"
        now = self.now()
        positions, velocities, _ = self._at(now)
        try:
            self._trajectory = Trajectory.of_message(message, names, now, positions, velocities, self._turned)
        except ParameterError as error:
            return str(error)
        return ""

    def _turned(self, index: int, before: float, wanted: float) -> float:
        """A position of a joint without limits, on the shorter way from another one."""
        joint = self.joints[index]
        return before + math.remainder(wanted - before, 2.0 * math.pi) if joint.turns else wanted

    def _on_command(self, message: Any) -> None:
        if self._action.running is not None:
            self._action.running.end(PREEMPTED, "a trajectory came by the topic")
        error = self._take(message)
        if error:
            self.session.log_refusal(f"{self.name}/{self._topic}", error)

    def _on_goal(self, goal: Goal) -> None:
        error = self._take(goal.message.trajectory)
        if error:
            code = -2 if error.startswith("the joints") else -1  # INVALID_JOINTS, INVALID_GOAL
            goal.end(REJECTED, error, error_code=code, error_string=error)

    def _on_cancel(self, goal: Goal) -> None:
        self._hold()
        goal.end(PREEMPTED)

    def update(self, elapsed: float) -> None:
        """Follow the trajectory."""
        now = self.now()
        positions, velocities, accelerations = self._at(now)
        self.follow(positions, velocities, elapsed)
        if self._action.running is not None:
            self._judge(self._action.running, now, positions)
        self._action.update()
        if self._ticks.due(now):
            self._report(now, positions, velocities, accelerations)

    def _judge(self, goal: Goal, now: float, positions: Sequence[float]) -> None:
        """Whether the goal is reached, or a tolerance was left."""
        errors = [joint.error_of(at) for joint, at in zip(self.joints, positions, strict=True)]
        end = self._trajectory.end if self._trajectory is not None else now
        if now < end:
            self._check(goal, "path_tolerance", "trajectory", errors, -4, "path error")
            return
        late = goal.message.goal_time_tolerance.seconds or number_of(
            self._constraints, "goal_time", 0.0, f"{self.name}/constraints"
        )
        slow = number_of(self._constraints, "stopped_velocity_tolerance", 0.01, f"{self.name}/constraints")
        still = slow <= 0.0 or all(abs(joint.velocity) <= slow for joint in self.joints)
        if still and self._within(goal, "goal_tolerance", "goal", errors):
            goal.end(SUCCEEDED, error_code=0)
        elif now >= end + late and not self._within(goal, "goal_tolerance", "goal", errors):
            goal.end(ABORTED, "goal tolerance violated", error_code=-5)
            self._hold()
        elif now >= end + late and late > 0.0:
            goal.end(ABORTED, "the joints do not stand still", error_code=-5)

    def _check(self, goal: Goal, field: str, key: str, errors: Sequence[float], code: int, text: str) -> None:
        if not self._within(goal, field, key, errors):
            goal.end(ABORTED, text, error_code=code, error_string=text)
            self._hold()

    def _within(self, goal: Goal, field: str, key: str, errors: Sequence[float]) -> bool:
        """Whether errors are within the tolerances of the goal, or else of the parameters; 0: there is none."""
        asked = {one.name: one.position for one in getattr(goal.message, field)}
        for joint, error in zip(self.joints, errors, strict=True):
            own = self._constraints.get(joint.name)
            default = number_of(own, key, 0.0, f"{self.name}/constraints") if isinstance(own, Mapping) else 0.0
            most = asked.get(joint.name, 0.0) or default
            if most > 0.0 and abs(error) > most:
                return False
        return True

    def _report(self, now: float, positions: list[float], velocities: list[float], accelerations: list[float]) -> None:
        goal = self._action.running
        if not self._states.listened and goal is None:
            return
        message: Any = self._states.kind(joint_names=[joint.name for joint in self.joints])
        set_stamp(message.header.stamp, now)
        message.desired.positions, message.desired.velocities = positions, velocities
        message.desired.accelerations = accelerations
        message.actual.positions = [joint.position for joint in self.joints]
        message.actual.velocities = [joint.velocity for joint in self.joints]
        if self.session.version == 2:
            message.reference, message.feedback = message.desired, message.actual  # their new names
        message.error.positions = [joint.error_of(at) for joint, at in zip(self.joints, positions, strict=True)]
        message.error.velocities = [
            speed - joint.velocity for joint, speed in zip(self.joints, velocities, strict=True)
        ]
        self._states.publish(message)
        if goal is not None:
            feedback = self._action.feedback_type(
                header=message.header,
                joint_names=message.joint_names,
                desired=message.desired,
                actual=message.actual,
                error=message.error,
            )
            self._action.send_feedback(goal, feedback)


class Gripper(Follower):
    """Closes and opens a gripper by an action."""

    def load(self) -> None:
        """Find the joint, and serve."""
        self.prepare([self.values.get("joint")])
        self._tolerance = number_of(self.values, "goal_tolerance", 0.01, self.name)
        self._slow = number_of(self.values, "stall_velocity_threshold", 0.001, self.name)
        self._patience = number_of(self.values, "stall_timeout", 1.0, self.name)
        self._effort = number_of(self.values, "max_effort", 0.0, self.name)
        self._wanted, self._moved = 0.0, 0.0
        kind = "control_msgs/GripperCommand"
        self._action = serve_action(
            self.session, f"{self.name}/gripper_cmd", kind, self.now, self._on_goal, self._on_cancel
        )
        self.listening = [self._action]

    def gains(self, joint: SimJoint) -> RosPid:
        """The gains of the joint."""
        return self.pid("gains", joint.name)

    def starting(self) -> None:
        """Hold the present position."""
        self.reset_pids()
        self._wanted, self._moved = self.joints[0].position, self.now()

    def stopping(self) -> None:
        """End the goal, and hold."""
        if self._action.running is not None:
            self._action.running.end(PREEMPTED, "the controller was stopped")
        self.joints[0].hold()

    def _on_goal(self, goal: Goal) -> None:
        if self.state != "running":
            goal.end(REJECTED, "the controller does not run")
            return
        self._wanted, self._moved = goal.message.command.position, self.now()
        self._effort = goal.message.command.max_effort or self._effort

    def _on_cancel(self, goal: Goal) -> None:
        self._wanted = self.joints[0].position
        goal.end(PREEMPTED)

    def update(self, elapsed: float) -> None:
        """Move, and end the goal when it is reached or the gripper stalls."""
        joint, now = self.joints[0], self.now()
        self.follow([self._wanted], [0.0], elapsed)
        if self.interface == EFFORT and self._effort > 0.0 and joint.command is not None:
            joint.command = max(-self._effort, min(self._effort, joint.command))
        if abs(joint.velocity) > self._slow:
            self._moved = now
        goal = self._action.running
        if goal is not None:
            reached = abs(joint.error_of(self._wanted)) < self._tolerance
            stalled = now - self._moved > self._patience
            if reached or stalled:
                result: dict[str, Any] = {"position": joint.position, "effort": joint.command or 0.0}
                good = reached or bool(self.values.get("allow_stalling", False))
                result |= {"reached_goal": reached, "stalled": not reached}
                goal.end(SUCCEEDED if good else ABORTED, "", **result)
        self._action.update()
