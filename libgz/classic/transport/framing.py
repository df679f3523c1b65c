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
        """Bytes that have not been taken."""
        return len(self._waiting)

    def add(self, data: bytes) -> None:
        """Add received bytes."""
        self._waiting += data

    def take(self) -> bytes | None:
        """Take the content of the next frame out; None if it is not complete.

        Raises:
            ParameterError: there is no size where one must be, or it is too large.
        """
        head = bytes(self._waiting[:_HEAD])
        if len(head) < _HEAD:
            return None
        if _DIGITS.fullmatch(head) is None:
            raise ParameterError(f"a message begins with {head!r} instead of its size")
        size = int(head, 16)
        if size > self._largest:
            raise ParameterError(f"a message has {size} bytes; {self._largest} are allowed")
        if len(self._waiting) < _HEAD + size:
            return None
        found = bytes(self._waiting[_HEAD : _HEAD + size])
        del self._waiting[: _HEAD + size]
        return found

    def give_back(self, most: int) -> int:
        """Forget the last bytes, at most so many, for they will be added again; how many that are."""
        count = min(most, len(self._waiting))
        del self._waiting[len(self._waiting) - count :]
        return count
