"""The messages that libgz itself writes into a log: the states of a step, and files that the scene needs."""

from __future__ import annotations

import contextlib
import json
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.budget import Budget
from libgz.base.errors import GazeboError, ParameterError
from libgz.transport.tables import BODY_COLUMNS, HEADER, JOINT_COLUMNS

__all__ = [
    "FILE_SCHEMA",
    "SEPARATOR",
    "TABLES_SCHEMA",
    "States",
    "file_message",
    "read_file",
    "read_json",
    "read_tables",
    "tables_message",
    "understood",
]

SEPARATOR = "=" * 80 + "\n"  # between the messages of a schema of ROS 1

# The states of a step. The rows are those of the observer's tables.
TABLES_SCHEMA = f"""int64 revision
int64 steps
int64 paused
float64 sim_time
float64 pause_time
float64 real_time
float64 step_time
gz/Body[] bodies
gz/Joint[] joints
{SEPARATOR}MSG: gz/Body
float64[3] position
float64[4] rotation
float64[3] center
float64[3] velocity
float64[3] angular_velocity
{SEPARATOR}MSG: gz/Joint
float64[2] value
float64[2] rate
"""

FILE_SCHEMA = """string name
uint8[] content
"""

_NUMBERS = struct.Struct("<qqqdddd")
_NAMES = ("revision", "steps", "paused", "sim_time", "pause_time", "real_time", "step_time")
_COUNT = struct.Struct("<I")


class States(NamedTuple):
    """The states of a step.

    Attributes:
        numbers: of the header of the tables, by name: revision, steps, paused, and times [s].
        bodies, joints: rows of the tables as bytes.
    """

    numbers: dict[str, float]
    bodies: bytes
    joints: bytes

    @property
    def body_rows(self) -> NDArray[np.float64]:
        """The table of bodies, shape (rows, 16)."""
        return np.frombuffer(self.bodies).reshape(-1, BODY_COLUMNS)

    @property
    def joint_rows(self) -> NDArray[np.float64]:
        """The table of joints, shape (rows, 4)."""
        return np.frombuffer(self.joints).reshape(-1, JOINT_COLUMNS)


@contextlib.contextmanager
def understood(what: str) -> Iterator[None]:
    """For a `with` block that uses what a log says, such as "a scene": whatever that raises is an error of the log.

    Raises:
        ParameterError: the log is damaged.
    """
    try:
        yield
    except GazeboError:
        raise
    except (ArithmeticError, AttributeError, LookupError, OSError, RecursionError, TypeError, ValueError) as error:
        raise ParameterError(f"the log is damaged: {what} is not understood: {error}") from None


def tables_message(image: bytes | bytearray) -> bytes:
    """The states of a step as a message of TABLES_SCHEMA, from the observer's tables with their header."""
    head = np.frombuffer(image, dtype=HEADER, count=1)[0]
    middle, end = int(head["joints_offset"]), int(head["size"])
    bodies, joints = bytes(image[HEADER.itemsize : middle]), bytes(image[middle:end])
    return b"".join(
        (
            _NUMBERS.pack(*(head[name] for name in _NAMES)),
            _COUNT.pack(len(bodies) // (8 * BODY_COLUMNS)),
            bodies,
            _COUNT.pack(len(joints) // (8 * JOINT_COLUMNS)),
            joints,
        )
    )


def read_tables(message: bytes) -> States:
    """The states in such a message.

    Raises:
        ParameterError: it is damaged.
    """
    try:
        numbers = dict(zip(_NAMES, _NUMBERS.unpack_from(message), strict=True))
        start = _NUMBERS.size + _COUNT.size
        middle = start + 8 * BODY_COLUMNS * _COUNT.unpack_from(message, _NUMBERS.size)[0]
        end = middle + _COUNT.size + 8 * JOINT_COLUMNS * _COUNT.unpack_from(message, middle)[0]
    except struct.error:
        end = -1
    if end != len(message):
        raise ParameterError("the log is damaged: a message of /gz/tables has the wrong length")
    return States(numbers, message[start:middle], message[middle + _COUNT.size :])


def file_message(name: str, content: bytes) -> bytes:
    """A file as a message of FILE_SCHEMA."""
    label = name.encode()
    return struct.pack("<I", len(label)) + label + struct.pack("<I", len(content)) + content


def read_json(content: bytes) -> Any:
    """The values of a scene, or of another message that is JSON.

    Raises:
        ParameterError: it is damaged, or too large.
    """
    Budget().take_json(content)
    try:
        return json.loads(content)
    except (ValueError, RecursionError) as error:
        raise ParameterError(f"the log is damaged: a message is no JSON: {error}") from None


def read_file(message: bytes) -> tuple[str, bytes]:
    """Name and content of the file in such a message.

    Raises:
        ParameterError: it is damaged.
    """
    length = int.from_bytes(message[:4], "little")
    content = message[8 + length :]
    if len(message) < 8 + length or int.from_bytes(message[4 + length : 8 + length], "little") != len(content):
        raise ParameterError("the log is damaged: a message of /gz/files has the wrong length")
    return message[4 : 4 + length].decode(errors="replace"), content
