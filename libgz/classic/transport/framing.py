"""The frames of classic's protocol: eight hexadecimal digits, which are a size, and so many bytes."""

from __future__ import annotations

import re
import time

from libgz.base.errors import ParameterError
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message

__all__ = ["Frames", "frame", "packet", "read_packet"]

_HEAD = 8
_DIGITS = re.compile(rb"[0-9a-fA-F]{8}")


def frame(data: bytes) -> bytes:
    """Return data with their size before them."""
    return b"%08x" % len(data) + data


def packet(kind: str, message: Message) -> bytes:
    """Return a framed Packet with a message, as masters and their clients send it."""
    made = message_type("Packet")(type=kind, serialized_data=message.SerializeToString())
    made.stamp.sec, made.stamp.nsec = divmod(time.time_ns(), 1_000_000_000)
    return frame(made.SerializeToString())


def read_packet(data: bytes) -> tuple[str, bytes]:
    """Return the kind of a Packet, and the message in it, still encoded.

    Raises:
        ParameterError: the data are damaged.
    """
    found = message_type("Packet").FromString(data)
    return found.type, found.serialized_data


class Frames:
    """Takes the contents of frames out of a stream of bytes.

    Args:
        largest: The size of the largest content that is accepted [bytes].
    """

    def __init__(self, largest: int) -> None:
        self._largest = largest
        self._waiting = bytearray()

    @property
    def waiting(self) -> int:
        """Bytes of a frame that is not complete yet."""
        return len(self._waiting)

    def add(self, data: bytes) -> list[bytes]:
        """Add received bytes, and return the contents of the frames that are complete now.

        Raises:
            ParameterError: there is no size where one must be, or it is too large.
        """
        waiting = self._waiting
        waiting += data
        found, at = [], 0
        while len(waiting) - at >= _HEAD:
            head = bytes(waiting[at : at + _HEAD])
            if _DIGITS.fullmatch(head) is None:
                raise ParameterError(f"a message begins with {head!r} instead of its size")
            size = int(head, 16)
            if size > self._largest:
                raise ParameterError(f"a message has {size} bytes; {self._largest} are allowed")
            if len(waiting) - at < _HEAD + size:
                break
            found.append(bytes(waiting[at + _HEAD : at + _HEAD + size]))
            at += _HEAD + size
        del waiting[:at]
        return found
