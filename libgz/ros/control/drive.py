"""DiffDrive: the diff_drive_controller of ros_controllers and of ros2_controllers."""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from lxml import etree

from libgz.base.errors import ParameterError
from libgz.ros.control.controllers import Controller
from libgz.ros.control.pid import number_of
from libgz.ros.plugin import Ticks, bounded_rate
from libgz.ros.session import finite, set_stamp
from libgz.ros.types import Stamp

__all__ = ["DiffDrive", "DiffDrive2"]

log = logging.getLogger("libgz.ros")

MOST_WINDOW = 10_000  # velocities whose mean is taken


class Limiter:
    """Limits of a velocity, its acceleration and its jerk, as the original's.

    Args:
        values: ``has_velocity_limits``, ``max_velocity``, ``min_velocity`` and the same of acceleration and jerk; a
            minimum that is not given is the negative maximum.
        where: the name of these parameters.
        missing: the maximum that is taken, with a warning, where none is given; the maximum holds, too, where it is
            below the minimum. None: neither is allowed.

    Raises:
        ParameterError: limits are wanted without a maximum, or the minimum is above it; or one allows no finite value.
    """

    def __init__(self, values: Mapping[str, Any], where: str, missing: float | None = None) -> None:
        self._velocity, self._acceleration, self._jerk = (
            _limits(values, name, where, missing) for name in ("velocity", "acceleration", "jerk")
        )
        self.reset()

    def reset(self) -> None:
        """Forget the last velocities: the robot stands."""
        self._last = self._before = 0.0

    def limit(self, wanted: float, elapsed: float) -> float:
        """The velocity of the next `elapsed` seconds, as near to the wanted one as limits allow."""
        last, change = self._last, self._last - self._before
        low, high = self._jerk
        wanted = last + change + _clamp(wanted - last - change, low * 2.0 * elapsed**2, high * 2.0 * elapsed**2)
        low, high = self._acceleration
        wanted = last + _clamp(wanted - last, low * elapsed, high * elapsed)
        wanted = _clamp(wanted, *self._velocity)
        self._last, self._before = wanted, last
        return wanted


def _clamp(value: float, low: float, high: float) -> float:
    return min(max(low, value), high)


def _limits(values: Mapping[str, Any], name: str, where: str, missing: float | None) -> tuple[float, float]:
    if not values.get(f"has_{name}_limits", False):
        return -math.inf, math.inf
    most = number_of(values, f"max_{name}", math.nan if missing is None else missing, where)
    least = number_of(values, f"min_{name}", -most, where)
    if missing is not None and f"max_{name}" not in values:
        log.warning("controller %s: has_%s_limits without max_%s; it is taken as %g", where, name, name, missing)
    text = f"parameters {where}/min_{name} and max_{name} are {least:g} and {most:g}: no limits"
    if not (least < math.inf and most > -math.inf) or (least > most and missing is None):  # NaN, too
        raise ParameterError(text)
    if least > most:
        log.warning("%s; the maximum is taken", text)
    return least, most


class DiffDrive(Controller):
    """Drives wheels on two sides by the topic ``cmd_vel``, and publishes odometry from their motion.

    Commands that are older than ``cmd_vel_timeout`` stop the robot. Without ``wheel_separation`` or ``wheel_radius``
    they are those of the robot description: between the joints of the first wheels, and of the first left wheel's
    collision.

    Attributes:
        limited: the parameter that asks for the topic ``cmd_vel_out``.
        missing: the maximum where limits have none.
    """

    limited = "publish_cmd"
    missing: float | None = 0.0

    def load(self) -> None:
        """Find the wheels, subscribe and advertise."""
        values, name, session = self.values, self.name, self.session
        self._left, self._right = (self.find(self.wheel_names(side)) for side in ("left", "right"))
        if len(self._left) != len(self._right):
            raise ParameterError(
                f"controller {name}: there are {len(self._left)} left wheels, {len(self._right)} right"
            )
        self.joints = [*self._left, *self._right]
        self._separation = self.wheel_separation() * self._number("wheel_separation_multiplier", 1.0)
        radius = self.wheel_radius()
        self._radii = [radius * self.radius_multiplier(side) for side in ("left", "right")]
        if not all(0.0 < one < math.inf for one in (self._separation, *self._radii)):
            raise ParameterError(f"controller {name}: wheel_separation and wheel_radius must be given and positive")
        self._patience = self._number("cmd_vel_timeout", 0.5)
        self._open_loop, self._by_position, self._transforms = (
            bool(values.get(key, default))
            for key, default in (("open_loop", False), ("position_feedback", True), ("enable_odom_tf", True))
        )
        self._frames = [str(values.get("odom_frame_id", "odom")), str(values.get("base_frame_id", "base_link"))]
        self._covariances = [_diagonal(values, f"{key}_covariance_diagonal", name) for key in ("pose", "twist")]
        self._limits = [
            Limiter(_nested(values, *keys), "/".join((name, *keys)), self.missing)
            for keys in (("linear", "x"), ("angular", "z"))
        ]
        window = int(_clamp(self._number("velocity_rolling_window_size", 10.0), 1.0, MOST_WINDOW))
        self._speeds: deque[tuple[float, float]] = deque(maxlen=window)
        self._ticks = Ticks(bounded_rate(self._number("publish_rate", 50.0), f"parameter {name}/publish_rate"))
        self._wanted, self._came = (0.0, 0.0), -math.inf
        self.applied = (0.0, 0.0)
        self._x = self._y = self._heading = 0.0
        self._before = [0.0, 0.0]
        self._odometry = session.publish(f"{name}/odom", "nav_msgs/Odometry", 10)
        self._limited = None
        if values.get(self.limited, False):
            self._limited = session.publish(f"{name}/cmd_vel_out", "geometry_msgs/TwistStamped", 10)
        first = session.version == 1
        states = first and values.get("publish_wheel_joint_controller_state", False)
        self._wheels = _WheelStates(self) if states else None
        self._alone = first and not values.get("allow_multiple_cmd_vel_publishers", True)
        topic, kind = self.command_topic()
        self._commands = session.subscribe(f"{name}/{topic}", f"geometry_msgs/{kind}", self._on_command)
        self.listening = [self._commands]

    # What the two eras do differently ----------------------------------------------------------------------------

    def wheel_names(self, side: str) -> Any:
        """The parameter that names the wheels of a side, as a list."""
        given = self.values.get(f"{side}_wheel")
        return [given] if isinstance(given, str) else given

    def wheel_separation(self) -> float:
        """The distance between left and right wheels [m]."""
        if "wheel_separation" in self.values:
            return self._number("wheel_separation")
        left, right = (self._described("joint", wheels[0].name) for wheels in (self._left, self._right))
        return math.dist(*(_numbers(joint, "origin", "xyz", 3) for joint in (left, right)))

    def wheel_radius(self) -> float:
        """The radius of all wheels [m]."""
        if "wheel_radius" in self.values:
            return self._number("wheel_radius")
        joint = self._described("joint", self._left[0].name)
        child = joint.find("child") if joint is not None else None
        link = self._described("link", child.get("link", "")) if child is not None else None
        return _numbers(link, "collision/geometry/*[@radius]", "radius", 1)[0]

    def radius_multiplier(self, side: str) -> float:
        """What the radius of a side's wheels is multiplied by."""
        if "wheel_radius_multiplier" in self.values:
            return self._number("wheel_radius_multiplier")
        return self._number(f"{side}_wheel_radius_multiplier", 1.0)

    def command_topic(self) -> tuple[str, str]:
        """(name of the topic of commands, type of its messages)."""
        return "cmd_vel", "Twist"

    def believed(self, _wanted: tuple[float, float]) -> tuple[float, float]:
        """The velocities of odometry in an open loop: those that were applied last."""
        return self.applied

    def _described(self, kind: str, name: str) -> etree._Element | None:
        """The joint or link of a name in the robot description."""
        return next((found for found in self.hardware.description.findall(kind) if found.get("name") == name), None)

    def _number(self, key: str, default: float = 0.0) -> float:
        return number_of(self.values, key, default, self.name)

    def _on_command(self, message: Any) -> None:
        if self._alone and self._commands.publishers > 1:
            self.session.log_refusal(
                f"{self.name}/cmd_vel", f"{self._commands.publishers} nodes publish commands; one may"
            )
            return
        if not finite(message):
            self.session.log_refusal(self.name, "a number is not finite")
            return
        stamped = hasattr(message, "header")
        stamp, twist = (message.header.stamp.seconds, message.twist) if stamped else (0.0, message)
        self._wanted, self._came = (twist.linear.x, twist.angular.z), stamp or self.now()

    def starting(self) -> None:
        """Stand, and count from the present positions of the wheels."""
        self._wanted, self._came = (0.0, 0.0), -math.inf
        self._before = self._travelled()
        self._speeds.clear()
        self.applied = (0.0, 0.0)
        for limiter in self._limits:
            limiter.reset()
        self.stopping()

    def stopping(self) -> None:
        """Stop the wheels."""
        for joint in self.joints:
            joint.command = 0.0

    def _travelled(self) -> list[float]:
        """How far each side has rolled [m]."""
        sides = zip((self._left, self._right), self._radii, strict=True)
        return [radius * _mean([joint.position for joint in joints]) for joints, radius in sides]

    def update(self, elapsed: float) -> None:
        """Command the wheels, and publish where they brought the robot."""
        now = self.now()
        wanted = self._wanted if now - self._came <= self._patience else (0.0, 0.0)
        self._move(wanted, elapsed)
        if self._ticks.due(now):
            self._send(now)
        linear, angular = (limiter.limit(one, elapsed) for limiter, one in zip(self._limits, wanted, strict=True))
        if self._limited is not None and self._limited.listened:
            message = self._limited.kind()
            set_stamp(message.header.stamp, now)
            message.twist.linear.x, message.twist.angular.z = linear, angular
            self._limited.publish(message)
        self.applied = linear, angular
        turn = 0.5 * angular * self._separation
        for joints, speed, radius in zip(
            (self._left, self._right), (linear - turn, linear + turn), self._radii, strict=True
        ):
            for joint in joints:
                joint.command = speed / radius
        if self._wheels is not None:
            self._wheels.update(now, elapsed)

    def _move(self, wanted: tuple[float, float], elapsed: float) -> None:
        """Integrate the motion of the wheels, or the commands, along an arc."""
        if elapsed <= 0.0:
            return
        if self._open_loop:
            linear, angular = self.believed(wanted)
        else:
            if self._by_position:
                present = self._travelled()
                left, right = ((b - a) / elapsed for a, b in zip(self._before, present, strict=True))
                self._before = present
            else:
                left, right = (
                    radius * _mean([joint.velocity for joint in joints])
                    for joints, radius in zip((self._left, self._right), self._radii, strict=True)
                )
            linear, angular = 0.5 * (left + right), (right - left) / self._separation
        turn = angular * elapsed
        middle = self._heading + 0.5 * turn
        chord = linear * elapsed * (math.sin(0.5 * turn) / (0.5 * turn) if abs(turn) > 1e-9 else 1.0)
        self._x += chord * math.cos(middle)
        self._y += chord * math.sin(middle)
        self._heading = math.remainder(self._heading + turn, 2.0 * math.pi)
        self._speeds.append((linear, angular))

    def _send(self, now: float) -> None:
        parent, child = self._frames
        turn = (0.0, 0.0, math.sin(0.5 * self._heading), math.cos(0.5 * self._heading))
        if self._odometry.listened:
            message = self._odometry.kind(child_frame_id=child)
            set_stamp(message.header.stamp, now)
            message.header.frame_id = parent
            pose, twist = message.pose, message.twist
            pose.pose.position.x, pose.pose.position.y = self._x, self._y
            part = pose.pose.orientation
            part.x, part.y, part.z, part.w = turn
            speeds = [self._speeds[-1]] if self._open_loop and self._speeds else self._speeds
            twist.twist.linear.x, twist.twist.angular.z = (_mean([one[at] for one in speeds]) for at in (0, 1))
            pose.covariance, twist.covariance = self._covariances
            self._odometry.publish(message)
        if self._transforms:
            stamp = Stamp()
            set_stamp(stamp, now)
            self.session.send_transform(stamp, parent, child, (self._x, self._y, 0.0), turn)


class _WheelStates:
    """Publishes what the wheels of a drive should do, and what they do: ``wheel_joint_controller_state``."""

    def __init__(self, drive: DiffDrive) -> None:
        self._joints = drive.joints
        self._publication = drive.session.publish(
            f"{drive.name}/wheel_joint_controller_state", "control_msgs/JointTrajectoryControllerState", 100
        )
        self._message = self._publication.kind(joint_names=[joint.name for joint in self._joints])
        count = len(self._joints)
        self._ways = [0.0] * count  # that the commands so far amount to [rad]
        self._before = [(0.0, 0.0)] * count  # speeds: commanded, measured [rad/s]

    def update(self, now: float, elapsed: float) -> None:
        """Publish; the commands are those of the next `elapsed` seconds."""
        if elapsed <= 0.0:
            return
        speeds = [(float(joint.command or 0.0), joint.velocity) for joint in self._joints]
        self._ways = [way + wanted * elapsed for way, (wanted, _) in zip(self._ways, speeds, strict=True)]
        changes = [
            ((wanted - one) * elapsed, (present - other) / elapsed)  # the original multiplies what is desired, too
            for (wanted, present), (one, other) in zip(speeds, self._before, strict=True)
        ]
        self._before = speeds
        if not self._publication.listened:
            return
        message = self._message
        set_stamp(message.header.stamp, now)
        desired, actual, error = message.desired, message.actual, message.error
        desired.positions, actual.positions = self._ways, [joint.position for joint in self._joints]
        desired.effort, actual.effort = [math.nan] * len(self._joints), [joint.effort for joint in self._joints]
        for at, part in enumerate((desired, actual)):
            part.velocities = [one[at] for one in speeds]
            part.accelerations = [one[at] for one in changes]
        for name in ("positions", "velocities", "accelerations", "effort"):
            pairs = zip(getattr(desired, name), getattr(actual, name), strict=True)
            setattr(error, name, [wanted - present for wanted, present in pairs])
        self._publication.publish(message)


class DiffDrive2(DiffDrive):
    """The controller of ros2_controllers: other names of parameters, and commands with a time."""

    limited = "publish_limited_velocity"
    missing = None

    def wheel_names(self, side: str) -> Any:
        """The parameter that names the wheels of a side."""
        return self.values.get(f"{side}_wheel_names")

    def wheel_separation(self) -> float:
        """The distance between left and right wheels [m]."""
        return self._number("wheel_separation")

    def wheel_radius(self) -> float:
        """The radius of all wheels [m]."""
        return self._number("wheel_radius")

    def radius_multiplier(self, side: str) -> float:
        """What the radius of a side's wheels is multiplied by."""
        return self._number(f"{side}_wheel_radius_multiplier", 1.0)

    def command_topic(self) -> tuple[str, str]:
        """(name of the topic of commands, type of its messages)."""
        stamped = bool(self.values.get("use_stamped_vel", True))
        return ("cmd_vel", "TwistStamped") if stamped else ("cmd_vel_unstamped", "Twist")

    def believed(self, wanted: tuple[float, float]) -> tuple[float, float]:
        """The velocities of odometry in an open loop: those that are wanted."""
        return wanted


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else 0.0


def _numbers(element: etree._Element | None, path: str, key: str, size: int) -> list[float]:
    """The numbers of an attribute in a robot description; zeros where there are none."""
    found = element.find(path) if element is not None else None
    try:
        numbers = [float(word) for word in found.get(key, "").split()] if found is not None else []
    except ValueError:
        numbers = []
    return numbers if len(numbers) == size else [0.0] * size


def _nested(values: Mapping[str, Any], *keys: str) -> Mapping[str, Any]:
    found: Any = values
    for key in keys:
        found = found.get(key) if isinstance(found, Mapping) else None
    return found if isinstance(found, Mapping) else {}


def _diagonal(values: Mapping[str, Any], key: str, where: str) -> list[float]:
    """A covariance of six values from those on its diagonal.

    Raises:
        ParameterError: there are not six numbers.
    """
    given = values.get(key, [0.0] * 6)
    if not isinstance(given, list) or len(given) != 6:
        raise ParameterError(f"parameter {where}/{key} is {given!r}; it must have six numbers")
    found = [0.0] * 36
    for at, value in enumerate(given):
        found[7 * at] = number_of({key: value}, key, 0.0, where)
    return found
