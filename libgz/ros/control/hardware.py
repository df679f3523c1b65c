"""RobotHardware: the joints of a model's transmissions, as controllers read and command them."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from lxml import etree

from libgz.base.errors import Diagnostics, ParameterError
from libgz.ros.control.pid import RosPid
from libgz.ros.session import Session
from libgz.sdf.xml import parse_document

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model

__all__ = ["RobotHardware", "SimJoint", "shortest_angle"]

log = logging.getLogger("libgz.ros")

INTERFACES = ("EffortJointInterface", "PositionJointInterface", "VelocityJointInterface")
EFFORT, POSITION, VELOCITY = (f"hardware_interface/{name}" for name in INTERFACES)
SHORT_NAMES = {"position": POSITION, "velocity": VELOCITY, "effort": EFFORT}
SIMPLE = "transmission_interface/SimpleTransmission"


def shortest_angle(begin: float, end: float) -> float:
    """From one angle to another, the shorter way round [rad]."""
    return math.remainder(end - begin, 2.0 * math.pi)


class SoftLimits(NamedTuple):
    """A `<safety_controller>`: the velocity becomes smaller towards two positions inside the limits.

    The formulas are those of joint_limits_interface.

    Attributes:
        lower, upper: where the velocity towards the limits has become zero [rad] or [m].
        k_position: allowed velocity per distance [1/s].
        k_velocity: allowed effort per velocity [N m s/rad] or [N s/m].
    """

    lower: float
    upper: float
    k_position: float
    k_velocity: float

    def velocities(self, position: float, most: float) -> tuple[float, float]:
        """The least and the largest velocity at a position, within a limit."""
        low, high = (_within(-self.k_position * (position - end), -most, most) for end in (self.lower, self.upper))
        return low, high

    def efforts(self, position: float, velocity: float, most_velocity: float, most: float) -> tuple[float, float]:
        """The least and the largest effort at a position and a velocity, within a limit."""
        band = self.velocities(position, most_velocity)
        low, high = (_within(-self.k_velocity * (velocity - end), -most, most) for end in band)
        return low, high


class SimJoint:
    """A joint that a transmission drives.

    Attributes:
        name: its name.
        interface: what commands it: EFFORT, POSITION or VELOCITY.
        position, velocity, effort: as read before the last update.
        command: what controllers want; None as long as none has commanded it.
    """

    def __init__(self, joint: Joint, interface: str, described: etree._Element | None, pid: RosPid | None) -> None:
        self.joint, self.name, self.interface, self._pid = joint, joint.GetName(), interface, pid
        limit = described.find("limit") if described is not None else None
        self.kind = described.get("type", "") if described is not None else ""
        self.lower, self.upper = -math.inf, math.inf
        if limit is not None and self.kind in ("revolute", "prismatic"):
            self.lower, self.upper = _number(limit, "lower", -math.inf), _number(limit, "upper", math.inf)
        self.most_effort = _number(limit, "effort", math.inf) if limit is not None else math.inf
        self.most_velocity = _number(limit, "velocity", math.inf) if limit is not None else math.inf
        self.soft = _soft_limits(described) if math.isfinite(self.lower) else None
        self.position, self.velocity, self.effort = joint.Position(0), 0.0, 0.0
        self.command: float | None = None
        self._wanted: float | None = None  # position of the last step, where the velocity is limited
        if interface == VELOCITY and pid is None:
            joint.SetParam("fmax", 0, self.most_effort if math.isfinite(self.most_effort) else 1e6)

    @property
    def turns(self) -> bool:
        """Whether its position is an angle without limits."""
        return self.kind == "continuous"

    def read(self) -> None:
        """Read the state."""
        at = self.joint.Position(0)
        self.position = at if self.kind == "prismatic" else self.position + shortest_angle(self.position, at)
        self.velocity, self.effort = self.joint.GetVelocity(0), self.joint.GetForce(0)

    def error_of(self, wanted: float) -> float:
        """What is missing from the position to another one."""
        if self.turns:
            return shortest_angle(self.position, wanted)
        return max(self.lower, min(self.upper, wanted)) - self.position

    def hold(self) -> None:
        """Command the present state: no motion."""
        self.command = self.position if self.interface == POSITION else 0.0

    def write(self, elapsed: float) -> None:
        """Apply the command, within the limits, for a step of `elapsed` seconds."""
        command = self.command
        if command is None:
            return
        if self.interface == EFFORT:
            self.joint.SetForce(0, self._effort(command))
        elif self.interface == POSITION:
            self._move(max(self.lower, min(self.upper, command)), elapsed)
        else:
            command = _within(command, *self._velocities(self.position))
            if self._pid is None:
                self.joint.SetParam("vel", 0, command)
            else:
                self.joint.SetForce(0, self._effort(self._pid.command(command - self.velocity, elapsed)))

    def _velocities(self, position: float) -> tuple[float, float]:
        """The least and the largest velocity at a position."""
        if self.soft is not None:
            return self.soft.velocities(position, self.most_velocity)
        return -self.most_velocity, self.most_velocity

    def _effort(self, effort: float) -> float:
        """An effort within its limit, that pushes beyond no limit of position or velocity."""
        least, most = -self.most_effort, self.most_effort
        if self.soft is not None and self.interface == EFFORT:
            return _within(effort, *self.soft.efforts(self.position, self.velocity, self.most_velocity, most))
        if self.position < self.lower or self.velocity < -self.most_velocity:
            least = 0.0
        if self.position > self.upper or self.velocity > self.most_velocity:
            most = 0.0
        return _within(effort, least, most)

    def _move(self, wanted: float, elapsed: float) -> None:
        """Set the position, or move to it by the PID gains."""
        if math.isfinite(self.most_velocity) or self.soft is not None:
            before = self.position if self._wanted is None else self._wanted
            slowest, fastest = self._velocities(before)
            wanted = _within(wanted, before + slowest * elapsed, before + fastest * elapsed)
            wanted = _within(wanted, self.lower, self.upper)
        self._wanted = wanted
        if self._pid is None:
            self.joint.SetPosition(0, wanted, True)
        else:
            self.joint.SetForce(0, self._effort(self._pid.command(self.error_of(wanted), elapsed)))


class RobotHardware:
    """The joints of a model that have a transmission.

    Args:
        model: the model.
        description: the text of its URDF.
        session: for gains of joints.
        space: the namespace of the robot.

    Attributes:
        description: the root of the URDF.
        joints: by name.

    Raises:
        ParameterError: it names a joint or an interface that does not exist.
        WorldFileError: the text is no XML.
    """

    def __init__(self, model: Model, description: str, session: Session, space: str) -> None:
        diagnostics = Diagnostics()
        root = parse_document(description.encode(), "robot_description", diagnostics)
        diagnostics.raise_errors()
        self.description = root
        described = {one.get("name", ""): one for one in root.findall("joint")}
        gains = session.parameter(f"{space}/gazebo_ros_control/pid_gains", {})
        self.joints: dict[str, SimJoint] = {}
        for transmission in root.findall("transmission"):
            found = _driven(transmission)
            if found is None:
                continue
            name, interface = found
            joint = model.GetJoint(name)
            if joint is None:
                raise ParameterError(f'This robot has a joint named "{name}" which is not in the gazebo model.')
            pid = _pid(gains, name, f"{space}/gazebo_ros_control/pid_gains/{name}") if interface != EFFORT else None
            self.joints[name] = SimJoint(joint, interface, described.get(name), pid)

    def claim(self, name: str, interface: str) -> SimJoint | None:
        """The joint of a name, for a controller that commands it by an interface; None if there is none."""
        joint = self.joints.get(name)
        return joint if joint is not None and joint.interface == interface else None

    def read(self) -> None:
        """Read the states of all joints."""
        for joint in self.joints.values():
            joint.read()

    def write(self, elapsed: float) -> None:
        """Apply the commands of all joints."""
        for joint in self.joints.values():
            joint.write(elapsed)


def _driven(transmission: etree._Element) -> tuple[str, str] | None:
    """(joint, interface) of a transmission; None for one that drives nothing here.

    Raises:
        ParameterError: the interface does not exist.
    """
    kind = (transmission.findtext("type") or transmission.get("type") or SIMPLE).strip()
    joint = transmission.find("joint")
    if joint is None or kind != SIMPLE:
        log.warning("transmission %r of type %s is left out", transmission.get("name"), kind)
        return None
    places = (joint, *transmission.findall("actuator"))
    given = [text for place in places if (text := place.findtext("hardwareInterface"))]
    if not given:
        log.warning("joint %r of a transmission has no hardwareInterface", joint.get("name"))
        return None
    name = given[0].strip().removeprefix("hardware_interface/")
    if name not in INTERFACES:
        raise ParameterError(f"No matching hardware interface found for {name!r} of joint {joint.get('name')!r}")
    return joint.get("name", ""), f"hardware_interface/{name}"


def _pid(gains: Any, name: str, where: str) -> RosPid | None:
    found = gains.get(name) if isinstance(gains, Mapping) else None
    return RosPid(found, where) if isinstance(found, Mapping) else None


def _soft_limits(described: etree._Element | None) -> SoftLimits | None:
    """The `<safety_controller>` of a joint; None if it has none."""
    found = described.find("safety_controller") if described is not None else None
    if found is None:
        return None
    names = ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
    return SoftLimits(*(_number(found, name, 0.0) for name in names))


def _within(value: float, low: float, high: float) -> float:
    """A value within two bounds; where they cross, the upper one, as the original has it."""
    return min(max(value, low), high)


def _number(element: etree._Element, key: str, default: float) -> float:
    try:
        return float(element.get(key, default))
    except ValueError:
        return default
