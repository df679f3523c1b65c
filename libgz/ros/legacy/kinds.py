"""Kinds of devices: what each interface of a legacy model is in ROS: messages, frames, commands, services.

A kind is one declaration: the type of the interface, a function that fills the messages of each topic, and one for each
command. Topics lie in a namespace of the interface's id. The table in the documents is made from the declarations.

A function that fills is a generator: it yields each time the message is complete, and not at all if there is nothing to
publish. One that obeys writes a command into the interface, which is locked; a text that it returns refuses it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from libgz.base.geometry import (
    GzPose,
    GzQuatern,
    GzQuaternFromEuler,
    GzQuaternInverse,
    GzQuaternToEuler,
    GzVector,
    rotate,
)
from libgz.interfaces.gripper import CLOSE, LIFT_DOWN, LIFT_STOP, LIFT_UP, OPEN, STOP
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.simulation.entity import Entity
    from libgz.transport.interface import Interface

__all__ = ["KINDS", "Frames", "Holder", "Kind", "Obey", "Order", "Stream", "Switch", "order", "paddles"]

OPTICAL = GzPose(GzVector(0.0, 0.0, 0.0), GzQuatern(0.5, -0.5, 0.5, -0.5))  # x right, y down, z ahead
SONAR_VIEW, IR_VIEW = math.radians(30.0), math.radians(5.0)  # fields of view in messages [rad]
UNKNOWN = math.nan


class Holder(Protocol):
    """A device, as the functions of its kind use it.

    Attributes:
        interface: of a model, open in this process.
        model: the model.
        id: of the interface.
        frame: of the device in TF.
    """

    interface: Interface[Any]
    model: Entity
    id: str
    frame: str


Fill: TypeAlias = "Callable[[Holder, Any], Iterator[None]]"
Obey: TypeAlias = "Callable[[Holder, Any], str | None]"
Frames: TypeAlias = "list[tuple[str, str, GzPose]]"  # parent, child, pose of the child in the parent


class Stream(NamedTuple):
    """A topic that a device publishes: `fill` yields for each message. Images are in the frame of the optics."""

    topic: str
    kind: str
    fill: Fill
    optical: bool = False


class Order(NamedTuple):
    """A topic by which a device is commanded."""

    topic: str
    kind: str
    obey: Obey


class Switch(NamedTuple):
    """A service of type std_srvs/Empty by which a device is commanded."""

    name: str
    obey: Obey


class Kind(NamedTuple):
    """What an interface is in ROS.

    Attributes:
        about: one phrase.
        streams, orders, switches: its topics and services.
        transforms: transforms besides that of its frame.
        place: the global pose of its frame; None: that of the model.
        grips: whether it serves the action `gripper_cmd`.
    """

    about: str
    streams: tuple[Stream, ...] = ()
    orders: tuple[Order, ...] = ()
    switches: tuple[Switch, ...] = ()
    transforms: Callable[[Holder], Frames] | None = None
    place: Callable[[Holder], GzPose] | None = None
    grips: bool = False


def _count(given: int, most: int) -> int:
    """How many elements of an array are valid; clients may have written any number."""
    return max(0, min(int(given), most))


def _turned(roll: float, pitch: float, yaw: float) -> GzQuatern:
    return GzQuatern(*GzQuaternFromEuler(roll, pitch, yaw))


def _set_pose(target: Any, place: Iterable[float], turn: GzQuatern) -> None:
    target.position.x, target.position.y, target.position.z = place
    target.orientation.w, target.orientation.x, target.orientation.y, target.orientation.z = turn


# Robots --------------------------------------------------------------------------------------------------------------


def _odometry(device: Holder, message: Any) -> Iterator[None]:
    data, twist = device.interface.data, message.twist.twist
    message.header.frame_id, message.child_frame_id = f"{device.id}/odom", device.frame
    _set_pose(message.pose.pose, data.pos, _turned(*data.rot))
    twist.linear.x, twist.linear.y, twist.linear.z = data.vel_pos
    twist.angular.x, twist.angular.y, twist.angular.z = data.vel_rot
    yield


def _odometry_frame(device: Holder) -> Frames:
    data = device.interface.data
    return [(f"{device.id}/odom", device.frame, GzPose(GzVector(*data.pos), _turned(*data.rot)))]


def _drive(device: Holder, message: Any) -> None:
    data, linear, angular = device.interface.data, message.linear, message.angular
    data.cmd_vel_pos[:] = linear.x, linear.y, linear.z
    data.cmd_vel_rot[:] = angular.x, angular.y, angular.z


def _enable(device: Holder, message: Any) -> None:
    device.interface.data.cmd_enable_motors = int(message.data)


def _battery(device: Holder, message: Any) -> Iterator[None]:
    message.voltage = device.interface.data.levels[0]
    message.temperature = message.current = message.charge = message.capacity = UNKNOWN
    message.design_capacity = message.percentage = UNKNOWN
    message.present, message.location = True, device.id
    message.power_supply_status = message.POWER_SUPPLY_STATUS_DISCHARGING
    yield


def _truth_turn(rotation: Sequence[float]) -> GzQuatern:
    """A rotation; that of version 0x050 consists of angles."""
    return GzQuatern(*rotation) if len(rotation) == 4 else _turned(*rotation)


def _moving_body(model: Entity) -> Body:
    """The body whose velocity is that of a model: of a dummy, that of what carries it."""
    body = model.GetBody()
    while body.dummy and (carried := model.parentBody) is not None and model.parent is not None:
        model, body = model.parent, carried
    return body


def _truth(device: Holder, message: Any) -> Iterator[None]:
    data, body, twist = device.interface.data, _moving_body(device.model), message.twist.twist
    message.header.frame_id, message.child_frame_id = "world", device.frame
    _set_pose(message.pose.pose, data.pos, _truth_turn(data.rot))
    back = GzQuaternInverse(body.GetRotation())
    twist.linear.x, twist.linear.y, twist.linear.z = rotate(back, body.GetPointVel(data.pos))
    twist.angular.x, twist.angular.y, twist.angular.z = rotate(back, body.GetAngularRate())
    yield


def _move(device: Holder, message: Any) -> str | None:
    data, turn = device.interface.data, message.orientation
    length = math.hypot(turn.w, turn.x, turn.y, turn.z)
    if length < 1e-6:
        return "its rotation has no length"
    unit = GzQuatern(turn.w / length, turn.x / length, turn.y / length, turn.z / length)
    data.cmd_pos[:] = message.position.x, message.position.y, message.position.z
    data.cmd_rot[:] = unit if len(data.cmd_rot) == 4 else GzQuaternToEuler(unit)
    data.cmd_new = 1
    return None


# Sensors -------------------------------------------------------------------------------------------------------------


def _scan(device: Holder, message: Any) -> Iterator[None]:
    data = device.interface.data
    count = _count(data.range_count, len(data.ranges))
    ranges = device.interface.array("ranges")[:count].astype(np.float32)
    ranges[ranges >= np.float32(data.max_range)] = math.inf  # nothing was hit
    message.angle_min, message.angle_max, message.angle_increment = data.min_angle, data.max_angle, data.res_angle
    message.range_min, message.range_max = 0.0, data.max_range
    message.ranges, message.intensities = ranges, device.interface.array("intensity")[:count]
    if count:
        yield


def _beam_place(device: Holder) -> GzPose:
    """Where the beams of a laser begin."""
    origin = getattr(device.model, "beam_origin", None)
    body = device.model.GetBody()
    return body.global_pose(origin) if isinstance(origin, GzPose) else body.GetPose()


def _ranges(name: str, view: float) -> Fill:
    """A Range for each sensor of a ring."""

    def fill(device: Holder, message: Any) -> Iterator[None]:
        data, readings = device.interface.data, device.interface.array(f"{name}_ranges")
        message.radiation_type = message.ULTRASOUND if name == "sonar" else message.INFRARED
        message.field_of_view, message.min_range = view, 0.0
        message.max_range = getattr(data, "max_range", 0.0)
        for index in range(_count(getattr(data, f"{name}_count"), len(readings))):
            message.header.frame_id, message.range = f"{device.id}/{name}_{index}", float(readings[index])
            yield

    return fill


def _ring(name: str) -> Callable[[Holder], Frames]:
    """The frames of the sensors of a ring, in that of the robot."""

    def transforms(device: Holder) -> Frames:
        interface = device.interface
        places, turns = interface.array(f"{name}_pos").tolist(), interface.array(f"{name}_rot").tolist()
        count = _count(getattr(interface.data, f"{name}_count"), len(places))
        return [
            (device.frame, f"{device.id}/{name}_{i}", GzPose(GzVector(*places[i]), _turned(*turns[i])))
            for i in range(count)
        ]

    return transforms


def _fix(device: Holder, message: Any) -> Iterator[None]:
    data, status = device.interface.data, message.status
    status.status = (status.STATUS_NO_FIX, status.STATUS_FIX, status.STATUS_GBAS_FIX)[_count(data.quality, 2)]
    status.service = status.SERVICE_GPS
    message.latitude, message.longitude, message.altitude = data.latitude, data.longitude, data.altitude
    flat, up = data.err_horz**2, data.err_vert**2
    message.position_covariance = [flat, 0.0, 0.0, 0.0, flat, 0.0, 0.0, 0.0, up]
    message.position_covariance_type = message.COVARIANCE_TYPE_DIAGONAL_KNOWN
    yield


def _marks(device: Holder, message: Any) -> Iterator[None]:
    message.poses = []
    for _, _, pose in _mark_frames(device):
        one = message_type("geometry_msgs/Pose")()
        _set_pose(one, pose.pos, pose.rot)
        message.poses.append(one)
    yield


def _mark_frames(device: Holder) -> Frames:
    """The frames of the objects that a sensor recognises, by their numbers."""
    data = device.interface.data
    found = data.fids[: _count(data.fid_count, len(data.fids))]
    poses = {one.id: GzPose(GzVector(*one.pos), _turned(*one.rot)) for one in found}
    return [(device.frame, f"{device.id}/fiducial_{number}", pose) for number, pose in poses.items()]


# Cameras -------------------------------------------------------------------------------------------------------------


def _eye(device: Holder, side: str = "") -> Any:
    """The rendering camera of a model; None for a model of a user that keeps it elsewhere."""
    if side:
        return (getattr(device.model, "eyes", None) or {}).get(side)
    return getattr(getattr(device.model, "camera", None), "eye", None)


def _eye_place(side: str = "") -> Callable[[Holder], GzPose]:
    def place(device: Holder) -> GzPose:
        eye = _eye(device, side)
        found: GzPose = eye.GetPose() if eye is not None else device.model.GetPose()
        return found

    return place


def _optical_frame(device: Holder) -> Frames:
    return [(device.frame, f"{device.frame}_optical", OPTICAL)]


def _image(pixels: str, size: str) -> Fill:
    def fill(device: Holder, message: Any) -> Iterator[None]:
        data, memory = device.interface.data, device.interface.array(pixels)
        width, height = int(data.width), int(data.height)
        count = 3 * width * height
        message.width, message.height, message.step, message.encoding = width, height, 3 * width, "rgb8"
        message.data = memory[:count]
        if 0 < count == getattr(data, size) <= len(memory):
            yield

    return fill


def _info(side: str = "") -> Fill:
    """The calibration of an image without distortion; that of a right eye has the baseline in its projection."""

    def fill(device: Holder, message: Any) -> Iterator[None]:
        eye = _eye(device, side)
        if eye is None:
            return
        width, height = eye.GetImageSize()
        focal = width / (2.0 * math.tan(float(eye.GetFOV()) / 2.0))
        cx, cy = (width + 1.0) / 2.0, (height + 1.0) / 2.0
        shift = -focal * _baseline(device) if side == "right" else 0.0
        message.width, message.height, message.distortion_model = width, height, "plumb_bob"
        message.D = [0.0] * 5
        message.K = [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]
        message.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        message.P = [focal, 0.0, cx, shift, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
        yield

    return fill


def _baseline(device: Holder) -> float:
    """The distance between the eyes of a stereo camera [m]."""
    return float(getattr(getattr(device.model, "values", None), "baseline", 0.0))


def _disparity(device: Holder, message: Any) -> Iterator[None]:
    data, memory, eye = device.interface.data, device.interface.array("left_disparity"), _eye(device, "left")
    width, height = int(data.width), int(data.height)
    count = width * height
    if eye is None or not 0 < count == data.left_disparity_size <= len(memory):
        return
    image = message.image
    image.header.stamp, image.header.frame_id = message.header.stamp, message.header.frame_id
    image.width, image.height, image.step, image.encoding = width, height, 4 * width, "32FC1"
    image.data = memory[:count].astype("<f4").view(np.uint8)
    message.f, message.T = width / (2.0 * math.tan(float(eye.GetFOV()) / 2.0)), _baseline(device)
    message.valid_window.width, message.valid_window.height = width, height
    message.min_disparity, message.max_disparity, message.delta_d = 0.0, float(width), 1.0 / 16.0
    yield


# Heads, arms, grippers -----------------------------------------------------------------------------------------------


def _head(device: Holder, message: Any) -> Iterator[None]:
    data = device.interface.data
    message.name = [f"{device.id}/{name}" for name in ("pan", "tilt", "zoom")]
    message.position = [data.pan, data.tilt, data.zoom]
    yield


def _look(field: str) -> Obey:
    def obey(device: Holder, message: Any) -> None:
        setattr(device.interface.data, field, message.data)

    return obey


def _joints(device: Holder, message: Any) -> Iterator[None]:
    data = device.interface.data
    found = data.joints[: _count(data.joint_count, len(data.joints))]
    names = [joint.name for joint in device.model.joints]
    message.name = [names[i] if i < len(names) and names[i] else f"joint_{i}" for i in range(len(found))]
    message.position, message.velocity = [one.angle for one in found], [one.angular_velocity for one in found]
    yield


def _bend(device: Holder, message: Any) -> str | None:
    data = device.interface.data
    most = _count(data.joint_count, len(data.joints))
    if len(message.data) > most:
        return f"it has {len(message.data)} angles for {most} joints"
    for joint, angle in zip(data.joints, message.data, strict=False):
        joint.cmd_angle = float(angle)
    return None


def _actuators(device: Holder, message: Any) -> Iterator[None]:
    data = device.interface.data
    found = data.actuators_data[: _count(data.actuators_count, len(data.actuators_data))]
    message.name = [f"{device.id}/{index}" for index in range(len(found))]
    message.position, message.velocity = [one.position for one in found], [one.speed for one in found]
    yield


def _act(mode: int, field: str) -> Obey:
    """Command the first actuators: by position (0), or by speed (1)."""

    def obey(device: Holder, message: Any) -> str | None:
        data = device.interface.data
        most = _count(data.actuators_count, len(data.actuators_data))
        if len(message.data) > most:
            return f"it has {len(message.data)} values for {most} actuators"
        for index, value in enumerate(message.data):
            getattr(data, field)[index], data.joint_mode[index] = float(value), mode
        data.new_cmd = (data.new_cmd + 1) & 0xFFFFFFFF or 1
        return None

    return obey


_PADDLES = {
    "opened": "paddles_opened",
    "closed": "paddles_closed",
    "moving": "paddles_moving",
    "stuck": "paddles_error",
}


def paddles(device: Holder) -> dict[str, bool]:
    """What the paddles of a gripper do; the struct of November 2006 has one number for that."""
    data = device.interface.data
    if hasattr(data, "state"):
        return {name: data.state == number for number, name in enumerate(_PADDLES, 1)}
    return {name: bool(getattr(data, field)) for name, field in _PADDLES.items()}


def _paddle(name: str) -> Fill:
    def fill(device: Holder, message: Any) -> Iterator[None]:
        message.data = paddles(device)[name]
        yield

    return fill


def _flag(field: str) -> Fill:
    def fill(device: Holder, message: Any) -> Iterator[None]:
        if hasattr(device.interface.data, field):
            message.data = bool(getattr(device.interface.data, field))
            yield

    return fill


def order(code: int) -> Obey:
    """What writes an order of a gripper."""

    def obey(device: Holder, _message: Any) -> None:
        device.interface.data.cmd = code

    return obey


# Types of interfaces -> what they are.
KINDS: dict[str, Kind] = {
    "position": Kind(
        "odometry and velocity commands",
        (Stream("odom", "nav_msgs/Odometry", _odometry),),
        (Order("cmd_vel", "geometry_msgs/Twist", _drive), Order("enable_motors", "std_msgs/Bool", _enable)),
        transforms=_odometry_frame,
    ),
    "power": Kind("the battery", (Stream("battery", "sensor_msgs/BatteryState", _battery),)),
    "truth": Kind(
        "the true pose",
        (Stream("ground_truth", "nav_msgs/Odometry", _truth),),
        (Order("set_pose", "geometry_msgs/Pose", _move),),
    ),
    "laser": Kind("scans", (Stream("scan", "sensor_msgs/LaserScan", _scan),), place=_beam_place),
    "sonar": Kind(
        "one message for each sonar",
        (Stream("sonar", "sensor_msgs/Range", _ranges("sonar", SONAR_VIEW)),),
        transforms=_ring("sonar"),
    ),
    "ir": Kind(
        "one message for each sensor",
        (Stream("ir", "sensor_msgs/Range", _ranges("ir", IR_VIEW)),),
        transforms=_ring("ir"),
    ),
    "fiducial": Kind(
        "marked objects in view",
        (Stream("fiducials", "geometry_msgs/PoseArray", _marks),),
        transforms=_mark_frames,
        place=_beam_place,
    ),
    "gps": Kind("positions", (Stream("fix", "sensor_msgs/NavSatFix", _fix),)),
    "camera": Kind(
        "images",
        (
            Stream("image_raw", "sensor_msgs/Image", _image("image", "image_size"), optical=True),
            Stream("camera_info", "sensor_msgs/CameraInfo", _info(), optical=True),
        ),
        transforms=_optical_frame,
        place=_eye_place(),
    ),
    "stereo": Kind(
        "a pair of images, and disparities",
        (
            Stream("left/image_raw", "sensor_msgs/Image", _image("left_image", "left_image_size"), optical=True),
            Stream("left/camera_info", "sensor_msgs/CameraInfo", _info("left"), optical=True),
            Stream("right/image_raw", "sensor_msgs/Image", _image("right_image", "right_image_size"), optical=True),
            Stream("right/camera_info", "sensor_msgs/CameraInfo", _info("right"), optical=True),
            Stream("disparity", "stereo_msgs/DisparityImage", _disparity, optical=True),
        ),
        transforms=_optical_frame,
        place=_eye_place("left"),
    ),
    "ptz": Kind(
        "angles and field of view [rad] of a head",
        (Stream("joint_states", "sensor_msgs/JointState", _head),),
        tuple(Order(f"{name}/command", "std_msgs/Float64", _look(f"cmd_{name}")) for name in ("pan", "tilt", "zoom")),
    ),
    "joint": Kind(
        "joints, and their wanted angles [rad]",
        (Stream("joint_states", "sensor_msgs/JointState", _joints),),
        (Order("command", "std_msgs/Float64MultiArray", _bend),),
    ),
    "actarray": Kind(
        "actuators, and their wanted positions or speeds",
        (Stream("joint_states", "sensor_msgs/JointState", _actuators),),
        (
            Order("command", "std_msgs/Float64MultiArray", _act(0, "cmd_pos")),
            Order("command_speed", "std_msgs/Float64MultiArray", _act(1, "cmd_speed")),
        ),
    ),
    "gripper": Kind(
        "paddles and lift; a position of the action is a share of the widest gap, 0 to 1",
        (
            *(Stream(f"gripper/{name}", "std_msgs/Bool", _paddle(name)) for name in ("opened", "closed", "moving")),
            Stream("gripper/inner_beam", "std_msgs/Bool", _flag("inner_beam_obstruct")),
            Stream("gripper/outer_beam", "std_msgs/Bool", _flag("outer_beam_obstruct")),
            Stream("lift/up", "std_msgs/Bool", _flag("lift_up")),
            Stream("lift/down", "std_msgs/Bool", _flag("lift_down")),
        ),
        switches=(
            Switch("gripper/open", order(OPEN)),
            Switch("gripper/close", order(CLOSE)),
            Switch("gripper/stop", order(STOP)),
            Switch("lift/raise", order(LIFT_UP)),
            Switch("lift/lower", order(LIFT_DOWN)),
            Switch("lift/stop", order(LIFT_STOP)),
        ),
        grips=True,
    ),
}
