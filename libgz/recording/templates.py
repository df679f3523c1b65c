"""Templates: messages of protocol buffers whose texts stay the same, encoded once; only their numbers are filled in.

A message of the frames of sixty bodies takes half a millisecond to put together and encode, thirty times a second of
sim time; to fill in its numbers takes ten microseconds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from numpy.typing import NDArray

__all__ = ["Encoded", "Template", "joints_template", "packed_field", "transforms_template"]

# Times and numbers of the template, found again in its bytes: they are encoded in as many bytes as any other.
_SECONDS, _NANOS = 0x0ABCDEF1, 0x1BCDEF12  # both varints of 4 and 5 bytes
_LARGEST = 0x0FFFFFFF  # [s] that fit


class Encoded:
    """A message that is encoded already.

    Args:
        kind: the message's type.
        content: its bytes.
    """

    def __init__(self, kind: Any, content: bytes) -> None:
        self.DESCRIPTOR, self._content = kind.DESCRIPTOR, content

    def SerializeToString(self) -> bytes:
        """The bytes."""
        return self._content


class Template:
    """An encoded message with places for times and numbers.

    Args:
        message: with the time `_SECONDS`, `_NANOS` wherever a time is to be filled in, and `marks` as its numbers.
        marks: numbers that appear nowhere else in it, in the order in which they are filled in.
    """

    def __init__(self, message: Any, marks: NDArray[np.float64]) -> None:
        self._kind = type(message)
        content = message.SerializeToString()
        self._bytes = np.frombuffer(content, dtype=np.uint8).copy()
        self._seconds = _places(content, _varint(_SECONDS, 4))
        self._nanos = _places(content, _varint(_NANOS, 5))
        starts, at = [], 0
        for mark in marks.tolist():
            at = content.index(np.float64(mark).tobytes(), at)
            starts.append(at)
            at += 8
        self._numbers = np.array(starts, dtype=int)[:, None] + np.arange(8)

    def message(self, time: int, numbers: NDArray[np.float64]) -> Encoded:
        """The message of a time [ns]."""
        seconds, nanos = divmod(time, 1_000_000_000)
        content = self._bytes
        for places, value, length in ((self._seconds, min(seconds, _LARGEST), 4), (self._nanos, nanos, 5)):
            content[places[:, None] + np.arange(length)] = np.frombuffer(_varint(value, length), dtype=np.uint8)
        content[self._numbers] = np.ascontiguousarray(numbers, dtype=float).view(np.uint8).reshape(-1, 8)
        return Encoded(self._kind, content.tobytes())


def _varint(value: int, length: int) -> bytes:
    """A number in exactly so many bytes of seven bits."""
    parts = [(value >> (7 * i)) & 0x7F for i in range(length)]
    return bytes([part | 0x80 for part in parts[:-1]] + parts[-1:])


def _places(content: bytes, part: bytes) -> NDArray[np.int64]:
    found, at = [], content.find(part)
    while at >= 0:
        found.append(at)
        at = content.find(part, at + 1)
    return np.array(found, dtype=np.int64)


def _marks(count: int) -> NDArray[np.float64]:
    """Numbers that are found again."""
    return 1.2345678912345e-200 * (1.0 + np.arange(count, dtype=float))


def transforms_template(names: list[str]) -> Template:
    """Frames in the world: x, y, z [m] and the quaternion x, y, z, w of each."""
    message, marks = FrameTransforms(), _marks(7 * len(names))
    for name, values in zip(names, marks.reshape(-1, 7).tolist(), strict=True):
        made = message.transforms.add(parent_frame_id="world", child_frame_id=name)
        made.timestamp.seconds, made.timestamp.nanos = _SECONDS, _NANOS
        place, turn = made.translation, made.rotation
        place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = values
    return Template(message, marks)


def joints_template(names: list[str]) -> Template:
    """Joints: position [rad or m] and velocity of each."""
    message, marks = JointStates(), _marks(2 * len(names))
    message.timestamp.seconds, message.timestamp.nanos = _SECONDS, _NANOS
    for name, (position, velocity) in zip(names, marks.reshape(-1, 2).tolist(), strict=True):
        message.joints.add(name=name, position=position, velocity=velocity)
    return Template(message, marks)


def packed_field(kind: Any, name: str, numbers: NDArray[np.float64]) -> bytes:
    """A repeated field of numbers, to be appended to a message that lacks it."""
    size, head = 8 * len(numbers), bytes([kind.DESCRIPTOR.fields_by_name[name].number << 3 | 2])
    if not size:
        return b""
    while size > 0x7F:
        head += bytes([size & 0x7F | 0x80])
        size >>= 7
    return head + bytes([size]) + numbers.tobytes()
