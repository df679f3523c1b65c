"""Drivers: what each device of Player reads and writes in an interface of libgz.

A driver is one declaration: its name in configuration files, the interfaces of both sides, and a function for its data
and for each command and request that it takes. `messages.txt` says how these look in each version of the protocol; the
page of drivers in the documents follows from both.

Functions get the device, whose interface is locked. Quantities are in libgz's units: m, rad, s, V.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import numpy as np

from libgz.base.errors import GazeboError
from libgz.base.geometry import GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.player.records import Values

__all__ = ["DRIVERS", "FAMILY", "Driver", "Holder", "RefusedError", "check_finite", "drivers_of"]

Geometry = {"length": 0.53, "width": 0.38, "height": 0.31}  # [m] that Player's driver gave for each robot
RGB888, MONO16 = 5, 2  # formats of images
OPEN, CLOSE, STOP, LIFT_UP, LIFT_DOWN = 1, 2, 3, 4, 5  # orders of a gripper
MOST_TEXT = 4096  # [byte] of a model for the factory
CHANNELS, MESSAGES = 64, 10  # of mcom; messages of a channel, as in Player
DOUBLED = 16  # units of a pixel in an image of disparities

FAMILY = "gazebo"  # the name of all drivers in configuration files of Player 2


class RefusedError(GazeboError):
    """A request is answered with a NACK."""


def check_finite(values: Values) -> None:
    """Check the numbers of a command or request.

    Raises:
        RefusedError: one is not finite.
    """
    for name, value in values.items():
        numbers = value if isinstance(value, list) else [value]
        if not all(math.isfinite(number) for number in numbers if isinstance(number, float)):
            raise RefusedError(f"{name} is {value}; it must be finite")


class Holder(Protocol):
    """The device, as the functions of its driver use it."""

    interface: Any  # of libgz, locked
    memory: dict[str, Any]  # what the driver keeps


Read: TypeAlias = Callable[[Holder], "Values | None"]
Command: TypeAlias = Callable[[Holder, Values], None]
Reply: TypeAlias = Callable[[Holder, Values], "Values | None"]


@dataclass(frozen=True)
class Driver:
    """A declaration.

    Attributes:
        name: in configuration files of Player 1.6.
        kind: Player's interface.
        source: the type of libgz's interface; an empty string if it has none.
        about: one sentence.
        data: the name of its data; an empty string if it has none.
        read: gives its data; None if there are none yet.
        commands, requests: a function for each; what is missing is refused.
        slow: requests that another process answers.
        key: in `provides`, where a driver provides several devices.
    """

    name: str
    kind: str
    source: str
    about: str
    data: str = ""
    read: Read | None = None
    commands: Mapping[str, Command] = field(default_factory=dict)
    requests: Mapping[str, Reply] = field(default_factory=dict)
    slow: tuple[str, ...] = ()
    key: str = ""


def _granted(_device: Holder, _values: Values) -> None:
    """A request that has nothing to do."""


def _geometry(**values: float) -> Reply:
    """The reply to a request for a geometry that is always the same."""
    return lambda _device, _values: values


# Robots --------------------------------------------------------------------------------------------------------------


def _power(device: Holder) -> Values:
    return {"valid": 1, "volts": device.interface.data.levels[0]}


def _position2d(device: Holder) -> Values:
    data = device.interface.data
    px, py, pa = _odometry(device, (data.pos[0], data.pos[1], data.rot[2]))
    velocities = {"vx": data.vel_pos[0], "vy": data.vel_pos[1], "va": data.vel_rot[2]}
    return {"px": px, "py": py, "pa": pa, **velocities, "stall": data.stall}


def _odometry(device: Holder, pose: tuple[float, float, float]) -> tuple[float, float, float]:
    """A pose by the robot's odometry, in the frame that clients have set."""
    if "frame" not in device.memory:
        return pose
    (x, y, a), (left, up, turned) = device.memory["frame"], pose
    return (
        x + math.cos(a) * left - math.sin(a) * up,
        y + math.sin(a) * left + math.cos(a) * up,
        math.remainder(a + turned, math.tau),
    )


def _set_odometry(device: Holder, values: Values) -> None:
    """Choose the frame in which the pose of now is the given one."""
    data = device.interface.data
    x, y, yaw = data.pos[0], data.pos[1], data.rot[2]
    wanted = [float(values.get(name, 0.0)) for name in ("px", "py", "pa")]
    a = wanted[2] - yaw
    device.memory["frame"] = (
        wanted[0] - math.cos(a) * x + math.sin(a) * y,
        wanted[1] - math.sin(a) * x - math.cos(a) * y,
        a,
    )


def _drive(device: Holder, values: Values) -> None:
    data = device.interface.data
    data.cmd_vel_pos[0], data.cmd_vel_pos[1], data.cmd_vel_rot[2] = values["vx"], values["vy"], values["va"]


def _motors(device: Holder, values: Values) -> None:
    device.interface.data.cmd_enable_motors = int(bool(values["state"]))


_AXES = ("px", "py", "pz"), ("roll", "pitch", "yaw"), ("vx", "vy", "vz"), ("vroll", "vpitch", "vyaw")


def _position3d(device: Holder) -> Values:
    data = device.interface.data
    found: dict[str, Any] = {"stall": data.stall}
    for names, numbers in zip(_AXES, (data.pos, data.rot, data.vel_pos, data.vel_rot), strict=True):
        found.update(zip(names, numbers, strict=True))
    return found


def _fly(device: Holder, values: Values) -> None:
    data = device.interface.data
    data.cmd_vel_pos[:] = [values[name] for name in _AXES[2]]
    data.cmd_vel_rot[:] = [values[name] for name in _AXES[3]]


def _truth(device: Holder) -> Values:
    data = device.interface.data
    rotation = list(data.rot)
    angles = GzQuaternToEuler(rotation) if len(rotation) == 4 else GzVector(*rotation)
    return dict(zip((*_AXES[0], *_AXES[1]), (*data.pos, *angles), strict=True))


def _set_truth(device: Holder, values: Values) -> None:
    data = device.interface.data
    angles = [float(values[name]) for name in _AXES[1]]
    data.cmd_pos[:] = [values[name] for name in _AXES[0]]
    data.cmd_rot[:] = list(GzQuaternFromEuler(*angles)) if len(data.cmd_rot) == 4 else angles
    data.cmd_new = 1


# Sensors -------------------------------------------------------------------------------------------------------------


def _count(given: int, most: int) -> int:
    """How many elements of an array are valid; old servers and clients may have written any number."""
    return max(0, min(int(given), most))


def _sonar(device: Holder) -> Values:
    data = device.interface.data
    return {"ranges": list(data.sonar_ranges[: _count(data.sonar_count, len(data.sonar_ranges))])}


def _sonar_poses(device: Holder, _values: Values) -> Values:
    data = device.interface.data
    return {"poses": _poses(data.sonar_pos, data.sonar_rot, data.sonar_count)}


def _ir(device: Holder) -> Values:
    data = device.interface.data
    ranges = list(data.ir_ranges[: _count(data.ir_count, len(data.ir_ranges))])
    return {"ranges": ranges, "voltages": [0.0] * len(ranges)}


def _ir_poses(device: Holder, _values: Values) -> Values:
    data = device.interface.data
    return {"poses": _poses(data.ir_pos, data.ir_rot, data.ir_count)}


def _poses(positions: Any, rotations: Any, count: int) -> list[Values]:
    """Poses of sensors in the robot's frame."""
    return [
        {"px": p[0], "py": p[1], "pz": p[2], "roll": r[0], "pitch": r[1], "pa": r[2]}
        for p, r in zip(*(list(part[: _count(count, len(part))]) for part in (positions, rotations)), strict=True)
    ]


def _laser(device: Holder) -> Values:
    data = device.interface.data
    count = _count(data.range_count, len(data.ranges))
    ranges = np.array(data.ranges[:count])
    device.memory["scans"] = scans = (device.memory.get("scans", 0) + 1) & 0xFFFFFFFF
    config = _laser_config(device, {})
    units = ranges * (1000.0 / config["unit"])
    return {**config, "ranges": ranges, "units": units, "intensity": list(data.intensity[:count]), "id": scans}


def _laser_config(device: Holder, _values: Values) -> dict[str, Any]:
    data = device.interface.data
    unit = 1 if data.max_range <= 8.192 else 10 if data.max_range <= 81.92 else 100  # [mm] so that a range has 13 bits
    angles = {"min": data.min_angle, "max": data.max_angle, "resolution": data.res_angle}
    return {**angles, "max_range": data.max_range, "unit": unit, "range_resolution": unit / 1000.0, "intensity": 1}


def _set_laser(device: Holder, values: Values) -> Values:
    """Scan another sector; the reply is what was asked for."""
    data = device.interface.data
    low, high, step = (float(values[name]) for name in ("min", "max", "resolution"))
    if not (low < high and step > 0.0 and (high - low) / step < len(data.ranges) - 1):
        raise RefusedError(f"a scan from {low:g} to {high:g} rad in steps of {step:g} rad")
    data.cmd_min_angle, data.cmd_max_angle, data.cmd_max_range = low, high, float(values.get("max_range", 0.0))
    data.cmd_range_count = round((high - low) / step) + 1
    data.cmd_new_angle = 1
    return values


def _fiducial(device: Holder) -> Values:
    data = device.interface.data
    names = (*_AXES[0], *_AXES[1])
    return {
        "items": [
            {"id": fid.id, **dict(zip(names, (*fid.pos, *fid.rot), strict=True))}
            for fid in data.fids[: _count(data.fid_count, len(data.fids))]
        ]
    }


def _gps(device: Holder) -> Values:
    data = device.interface.data
    seconds = data.utc_time if math.isfinite(data.utc_time) else 0.0
    names = ("latitude", "longitude", "altitude", "utm_e", "utm_n", "quality", "satellites", "hdop", "vdop")
    found = {name: getattr(data, name) for name in (*names, "err_horz", "err_vert")}
    return {**found, "seconds": math.floor(seconds), "microseconds": math.floor(seconds % 1.0 * 1e6)}


def _wifi(device: Holder) -> Values:
    data = device.interface.data
    links = [
        {"ip": link.ip, "quality": link.qual, "level": link.level, "noise": link.noise}
        for link in data.links[: _count(data.link_count, len(data.links))]
    ]
    return {"links": links, "quality_type": 1}


# Heads, images, grippers, arms ---------------------------------------------------------------------------------------


def _ptz(device: Holder) -> Values:
    data = device.interface.data
    return {"pan": data.pan, "tilt": data.tilt, "zoom": data.zoom}


def _look(device: Holder, values: Values) -> None:
    data = device.interface.data
    data.cmd_pan, data.cmd_tilt, data.cmd_zoom = values["pan"], values["tilt"], values["zoom"]


def _control_mode(_device: Holder, values: Values) -> None:
    if values["mode"] != 1:
        raise RefusedError("heads are controlled by position only")


def _camera(image: str, size: str) -> Read:
    def read(device: Holder) -> Values | None:
        data = device.interface.data
        pixels = device.interface.array(image)[: getattr(data, size)]
        return _image(data, pixels.tobytes(), RGB888, 24) if len(pixels) else None

    return read


def _disparity(image: str, size: str) -> Read:
    def read(device: Holder) -> Values | None:
        data = device.interface.data
        pixels = device.interface.array(image)[: getattr(data, size)]
        shades = np.clip(np.nan_to_num(pixels) * DOUBLED, 0, 65535).astype(">u2")
        return {**_image(data, shades.tobytes(), MONO16, 16), "divisor": DOUBLED} if len(pixels) else None

    return read


def _image(data: Any, content: bytes, format: int, bits: int) -> dict[str, Any]:
    size = {"width": data.width, "height": data.height}
    return {**size, "bpp": bits, "format": format, "divisor": 1, "compression": 0, "image": content}


_BEAMS = (
    "grip_limit_reach",
    "lift_limit_reach",
    "outer_beam_obstruct",
    "inner_beam_obstruct",
    "left_paddle_open",
    "right_paddle_open",
)
_STATES = (
    "paddles_opened",
    "paddles_closed",
    "paddles_moving",
    "paddles_error",
    "lift_up",
    "lift_down",
    "lift_moving",
    "lift_error",
)


def _gripper(device: Holder) -> Values:
    """In 1.6 and 2.0 `state` has a bit for each of `_STATES`; in 2.1 `mode` is the number of the first that is set."""
    data = device.interface.data
    later = hasattr(data, "state")  # the struct of November 2006, which has one number for the paddles
    flags = {name: bool(getattr(data, name, False)) for name in (*_BEAMS, *_STATES)}
    if later:
        flags.update({name: data.state == number for number, name in enumerate(_STATES[:4], 1)})
    modes = (flags["paddles_moving"] and 3, flags["paddles_opened"] and 1, flags["paddles_closed"] and 2)
    bits = [sum(flags[name] << i for i, name in enumerate(names)) for names in (_STATES, _BEAMS)]
    mode = next((mode for mode in modes if mode), 4 if flags["paddles_error"] else 3)
    return {"state": bits[0], "beams": bits[1], "mode": mode, "stored": 0}


def _order(code: int | None = None) -> Command:
    def order(device: Holder, values: Values) -> None:
        device.interface.data.cmd = int(values["code"]) if code is None else code

    return order


_ACTUATOR_FLAGS = {3: 4, 4: 8}  # braked and stalled in 2.1


def _actarray(device: Holder) -> Values:
    data = device.interface.data
    found = data.actuators_data[: _count(data.actuators_count, len(data.actuators_data))]
    return {
        "actuators": [
            {"position": a.position, "speed": a.speed, "state": a.state, "flags": _ACTUATOR_FLAGS.get(a.state, a.state)}
            for a in found
        ],
        "motors": 1,
    }


def _actuators(device: Holder, _values: Values) -> Values:
    """What the interface does not say is that of a joint that turns freely."""
    actuator = {"type": 2, "min": -math.pi, "max": math.pi}
    return {"actuators": [actuator] * _count(device.interface.data.actuators_count, 16)}


def _move(mode: int, target: str, name: str) -> Command:
    """Command one joint, all (-1), or the first ones by a list.

    Args:
        mode: 0 position, 1 speed, 2 current.
        target: the field of the interface.
        name: the field of the message.
    """

    def move(device: Holder, values: Values) -> None:
        data = device.interface.data
        count = _count(data.actuators_count, len(data.actuators_data))
        given = values.get(name, 0.0)
        if isinstance(given, list):
            wanted = dict(enumerate(given[:count]))
        else:
            wanted = dict.fromkeys(range(count) if values["joint"] == -1 else (int(values["joint"]),), float(given))
        for joint, value in wanted.items():
            if not 0 <= joint < count:
                raise RefusedError(f"joint {joint} of {count}")
            getattr(data, target)[joint] = value
            data.joint_mode[joint] = mode
        data.new_cmd = (data.new_cmd + 1) & 0xFFFFFFFF or 1

    return move


def _joint_speed(device: Holder, values: Values) -> None:
    data, joint = device.interface.data, int(values["joint"])
    if not 0 <= joint < _count(data.actuators_count, 16):
        raise RefusedError(f"joint {joint}")
    data.cmd_speed[joint] = values["speed"]


def _already(value: int) -> Reply:
    """Grant a request for the state that a device always has."""

    def reply(_device: Holder, values: Values) -> Values | None:
        if int(bool(values["state"])) != value:
            raise RefusedError(f"the state {values['state']}")
        return None

    return reply


# The simulation, and what belongs to no model ------------------------------------------------------------------------


def _insert(device: Holder, values: Values) -> None:
    data = device.interface.data
    text = str(values["text"]).encode()[: min(MOST_TEXT, len(data.string)) - 1]
    data.string[: len(text) + 1] = list(text + b"\0")


def _pause(device: Holder, _values: Values) -> None:
    data = device.interface.data
    data.pause = int(not data.pause)


def _reset(device: Holder, _values: Values) -> None:
    device.interface.data.reset = 1


def _save(device: Holder, _values: Values) -> None:
    device.interface.data.save = 1


def _channel(device: Holder, values: Values) -> list[bytes]:
    """The messages of a channel of mcom, the last on top."""
    channels: dict[tuple[int, str], list[bytes]] = device.memory.setdefault("channels", {})
    name = int(values["type"]), str(values["channel"])[:32]
    if name not in channels and len(channels) >= CHANNELS:
        raise RefusedError(f"there are {CHANNELS} channels already")
    return channels.setdefault(name, [])


def _push(device: Holder, values: Values) -> None:
    channel, content = _channel(device, values), bytes(values["data"])[:128]
    channel.append(content)
    del channel[: -device.memory.get("capacity", MESSAGES)]


def _top(device: Holder, values: Values, *, remove: bool) -> Values:
    channel = _channel(device, values)
    if not channel:
        raise RefusedError("the channel is empty")
    content = channel.pop() if remove else channel[-1]
    return {"type": values["type"], "channel": values["channel"], "full": 1, "data": content}


def _capacity(device: Holder, values: Values) -> None:
    given = bytes(values["data"])[:1]
    device.memory["capacity"] = max(1, min(given[0] if given else MESSAGES, MESSAGES))


# The declarations ----------------------------------------------------------------------------------------------------

DRIVERS = (
    Driver("gz_power", "power", "power", "The voltage of the first battery.", "state", _power),
    Driver(
        "gz_position",
        "position2d",
        "position",
        "A robot's odometry, velocity and motors. Setting the odometry changes what Player's clients read only.",
        "state",
        _position2d,
        {"velocity": _drive},
        {
            "geometry": _geometry(**Geometry),
            "motors": _motors,
            "set_odometry": _set_odometry,
            "reset_odometry": _set_odometry,
        },
    ),
    Driver(
        "gz_position3d",
        "position3d",
        "position",
        "A robot that flies or swims: all components of pose and velocity.",
        "state",
        _position3d,
        {"velocity": _fly},
        {"geometry": _geometry(**Geometry), "motors": _motors},
    ),
    Driver(
        "gz_sonar",
        "sonar",
        "sonar",
        "Ranges and poses of sonars, which are always on.",
        "ranges",
        _sonar,
        requests={"geometry": _sonar_poses, "power": _granted},
    ),
    Driver(
        "gz_laser",
        "laser",
        "laser",
        "Scans of a laser range-finder.",
        "scan",
        _laser,
        requests={"geometry": _geometry(), "get_config": _laser_config, "set_config": _set_laser},
    ),
    Driver(
        "gz_ptz",
        "ptz",
        "ptz",
        "A head that pans, tilts (down positive) and zooms (the field of view).",
        "state",
        _ptz,
        {"state": _look},
        {"geometry": _geometry(), "control_mode": _control_mode},
    ),
    Driver("gz_camera", "camera", "camera", "Images, RGB, top row first.", "image", _camera("image", "image_size")),
    Driver(
        "gz_gripper",
        "gripper",
        "gripper",
        "Paddles, lift and beams of a gripper. In 2.1 and 3 `store` lifts and `retrieve` lowers what is gripped.",
        "state",
        _gripper,
        {
            "order": _order(),
            "open": _order(OPEN),
            "close": _order(CLOSE),
            "stop": _order(STOP),
            "store": _order(LIFT_UP),
            "retrieve": _order(LIFT_DOWN),
        },
        {"geometry": _geometry(beam_count=2)},
    ),
    Driver(
        "gz_fiducial",
        "fiducial",
        "fiducial",
        "Marked objects that a sensor recognises.",
        "scan",
        _fiducial,
        requests={"geometry": _geometry(mark_width=0.05, mark_length=0.5)},
    ),
    Driver("gz_gps", "gps", "gps", "A satellite navigation receiver.", "state", _gps),
    Driver(
        "gz_truth",
        "truth",
        "truth",
        "A model's true pose, which can be set.",
        "pose",
        _truth,
        requests={
            "get_pose": lambda device, _values: _truth(device),
            "set_pose": _set_truth,
            "set_root_pose": _set_truth,
        },
    ),
    Driver("gz_wifi", "wifi", "wifi", "A robot's wireless links.", "state", _wifi),
    Driver(
        "gz_ir",
        "ir",
        "ir",
        "Ranges and poses of infrared sensors.",
        "ranges",
        _ir,
        requests={"geometry": _ir_poses, "power": _granted},
    ),
    Driver(
        "gz_actarray",
        "actarray",
        "actarray",
        "An arm's joints: position, speed and current of each, or of all (joint -1).",
        "state",
        _actarray,
        {
            "position": _move(0, "cmd_pos", "position"),
            "positions": _move(0, "cmd_pos", "positions"),
            "home": _move(0, "cmd_pos", "home"),
            "speed": _move(1, "cmd_speed", "speed"),
            "speeds": _move(1, "cmd_speed", "speeds"),
            "current": _move(2, "cmd_current", "current"),
        },
        {"geometry": _actuators, "speed": _joint_speed, "power": _already(1), "brakes": _already(0)},
    ),
    *(
        Driver("gz_stereo", "camera", "stereo", f"The {words} of a stereo camera.", "image", read, key=key)
        for key, words, read in (
            ("left", "left image", _camera("left_image", "left_image_size")),
            ("right", "right image", _camera("right_image", "right_image_size")),
            ("left_disparity", "disparities of the left image", _disparity("left_disparity", "left_disparity_size")),
            (
                "right_disparity",
                "disparities of the right image",
                _disparity("right_disparity", "right_disparity_size"),
            ),
        )
    ),
    Driver(
        "gz_factory", "speech", "factory", "The text said is the XML of a model to insert.", commands={"say": _insert}
    ),
    Driver(
        "gz_sim",
        "simulation",
        "sim",
        "Poses of all models by their names; pause, reset and save.",
        commands={"pause": _pause, "reset": _reset, "save": _save},
        slow=("get_pose2d", "set_pose2d", "get_pose3d", "set_pose3d"),
    ),
    Driver(
        "lifomcom",
        "mcom",
        "",
        "Messages between programs: a stack of ten for each type and channel.",
        requests={
            "push": _push,
            "pop": lambda device, values: _top(device, values, remove=True),
            "read": lambda device, values: _top(device, values, remove=False),
            "clear": lambda device, values: _channel(device, values).clear(),
            "capacity": _capacity,
        },
    ),
)


def drivers_of(name: str) -> list[Driver]:
    """The declarations of a driver's name in a configuration file; of FAMILY those of all that libgz serves."""
    if name == FAMILY:
        return [driver for driver in DRIVERS if driver.source]
    return [driver for driver in DRIVERS if driver.name == _OLDER.get(name, name)]


_OLDER = {"gz_sonars": "gz_sonar"}  # by Player of Gazebo 0.4
