"""Convert between messages and the types that the rest of the classic API uses."""

from __future__ import annotations

import itertools
import random
import time as clock
from collections.abc import Callable
from typing import Any

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.classic.common.time import Time
from libgz.classic.math.color import Color
from libgz.classic.math.pose import Pose3d
from libgz.classic.math.quaternion import Quaterniond
from libgz.classic.math.vector2 import Vector2d
from libgz.classic.math.vector3 import Vector3d
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message

__all__ = ["Convert", "ConvertIgn", "CreateRequest", "Init", "Set", "Stamp"]

_LATEST = 2**31 - 1  # [s] that msgs.Time can hold

# Request numbers start at a random one, so that two programs do not accept each other's responses.
_request_ids = itertools.count(random.SystemRandom().randrange(1, 1 << 30))


def Set(msg: Message, value: Any) -> None:
    """Fill a message from a value of the classic API.

    - Vector3d, Vector2d: three or two numbers; Quaternion: scalar first; Pose: has `pos` and `rot`;
    - Color: r, g, b and, if there is a fourth, a; Time: has `sec` and `nsec`, or is a number [s];
    - PlaneGeom: has `normal`, `size`, `d` as attributes or functions; GzString, Int: the value.

    Raises:
        ParameterError: the message is of another type, or the value is invalid.
    """
    setter = _SETTERS.get(msg.GetTypeName().removeprefix("gazebo.msgs."))
    if setter is None:
        raise ParameterError(f"Set cannot fill a {msg.GetTypeName()}; it fills {', '.join(_SETTERS)}")
    try:
        setter(msg, value)
    except (TypeError, ValueError, AttributeError) as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError(f"a {msg.GetTypeName()} cannot be set from {value!r}: {error}") from None


def Convert(value: Any) -> Any:
    """Convert a message to a value of the classic API, or such a value to a message.

    Vectors, quaternions, poses, colours and times are converted in both directions; a float [s] becomes a Time.

    Raises:
        ParameterError: there is no counterpart.
    """
    if isinstance(value, Message):
        return ConvertIgn(value)
    for name, fits in _KINDS:
        if fits(value):
            msg = message_type(name)()
            Set(msg, value)
            return msg
    raise ParameterError(f"{value!r} has no counterpart among the messages")


def ConvertIgn(msg: Message) -> Any:
    """Convert a Vector3d, Vector2d, Quaternion, Pose, Color or Time message to a value of the classic API.

    Raises:
        ParameterError: there is no counterpart.
    """
    getter = _GETTERS.get(msg.GetTypeName().removeprefix("gazebo.msgs."))
    if getter is None:
        raise ParameterError(f"a {msg.GetTypeName()} has no counterpart; {', '.join(_GETTERS)} have")
    return getter(msg)


def Stamp(msg: Message) -> None:
    """Set a Time, or the `stamp` of a Header, to the wall time.

    Raises:
        ParameterError: the message is of another type.
    """
    if "stamp" in msg.DESCRIPTOR.fields_by_name:
        msg = msg.stamp
    if msg.GetTypeName() != "gazebo.msgs.Time":
        raise ParameterError(f"a {msg.GetTypeName()} has no time stamp")
    msg.sec, msg.nsec = divmod(clock.time_ns(), 1_000_000_000)


def Init(msg: Message, id: str = "") -> None:
    """Set the `header` of a message: its id, if one is given, and its stamp to the wall time.

    Raises:
        ParameterError: the message has no header.
    """
    if "header" not in msg.DESCRIPTOR.fields_by_name:
        raise ParameterError(f"a {msg.GetTypeName()} has no header")
    if id:
        msg.header.str_id = id
    Stamp(msg.header)


def CreateRequest(request: str, data: str = "") -> Any:
    """Return a Request with a new id, such as ``CreateRequest("entity_delete", "box")``."""
    return message_type("Request")(id=next(_request_ids), request=request, data=data)


def _set_vector3(msg: Any, value: Any) -> None:
    msg.x, msg.y, msg.z = value


def _set_vector2(msg: Any, value: Any) -> None:
    msg.x, msg.y = value


def _set_quaternion(msg: Any, value: Any) -> None:
    msg.w, msg.x, msg.y, msg.z = value


def _set_pose(msg: Any, value: Any) -> None:
    _set_vector3(msg.position, value.pos)
    _set_quaternion(msg.orientation, value.rot)


def _set_color(msg: Any, value: Any) -> None:
    msg.r, msg.g, msg.b, *alpha = value
    if alpha:
        (msg.a,) = alpha


def _set_time(msg: Any, value: Any) -> None:
    if isinstance(value, (int, float)):
        seconds, msg.nsec = divmod(round(value * 1e9), 1_000_000_000)
    else:
        seconds, msg.nsec = value.sec, value.nsec
    msg.sec = max(-_LATEST, min(_LATEST, seconds))  # sim time is beyond that where a client sets steps of 1e9 s


def _set_plane(msg: Any, value: Any) -> None:
    def part(*names: str) -> Any:  # by name, for planes of both generations of the API have their own
        found = next((getattr(value, name) for name in names if hasattr(value, name)), None)
        return found() if callable(found) else found

    _set_vector3(msg.normal, part("normal", "Normal"))
    _set_vector2(msg.size, part("size", "Size"))
    msg.d = part("d", "Offset")


def _set_data(msg: Any, value: Any) -> None:
    msg.data = value


_SETTERS: dict[str, Callable[[Any, Any], None]] = {
    "Vector3d": _set_vector3,
    "Vector2d": _set_vector2,
    "Quaternion": _set_quaternion,
    "Pose": _set_pose,
    "Color": _set_color,
    "Time": _set_time,
    "PlaneGeom": _set_plane,
    "GzString": _set_data,
    "Int": _set_data,
}

_GETTERS: dict[str, Callable[[Any], Any]] = {
    "Vector3d": lambda msg: Vector3d(msg.x, msg.y, msg.z),
    "Vector2d": lambda msg: Vector2d(msg.x, msg.y),
    "Quaternion": lambda msg: Quaterniond(msg.w, msg.x, msg.y, msg.z),
    "Pose": lambda msg: Pose3d(ConvertIgn(msg.position), ConvertIgn(msg.orientation)),
    "Color": lambda msg: Color(msg.r, msg.g, msg.b, msg.a),
    "Time": lambda msg: Time(msg.sec, msg.nsec),
}

_KINDS: tuple[tuple[str, Callable[[Any], bool]], ...] = (
    ("Vector3d", lambda value: isinstance(value, GzVector)),
    ("Vector2d", lambda value: isinstance(value, Vector2d)),
    ("Quaternion", lambda value: isinstance(value, GzQuatern)),
    ("Pose", lambda value: isinstance(value, GzPose)),
    ("Color", lambda value: isinstance(value, GzColor)),
    ("Time", lambda value: isinstance(value, (int, float, Time))),
)
