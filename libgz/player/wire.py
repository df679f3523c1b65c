"""The framing of Player's protocols: from bytes to frames and back.

1.6 has a header of 32 bytes, which begins with 0x5878; the subtype, where there is one, is the first field of the
payload. 2.0 and later have a header of 40 bytes in XDR, with the subtype.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import ClassVar, Protocol

from libgz.player.messages import CODE_OF_POSITION2D_IN_1_6, CODES
from libgz.player.records import MalformedError

__all__ = ["ACK", "COMMAND", "DATA", "ERROR", "NACK", "REQUEST", "SYNCH", "Frame", "Wire", "Wire1", "Wire2", "detect"]

DATA, COMMAND, REQUEST, ACK, SYNCH, NACK, ERROR = 1, 2, 3, 4, 5, 6, 7

LONGEST = 64 << 10  # [byte] of a payload that clients send; longer ones are skipped
SKIPPED = 32 << 20  # [byte] of a payload, as in Player 2; longer ones end the connection
LOCALHOST = 0x0100007F  # the address of a device's host in Player 2

STX = b"\x58\x78"
_HEADER1 = struct.Struct(">2s3H6I")  # mark, type, interface, index, time and timestamp [s], [us], reserved, size
_HEADER2 = struct.Struct(">6IdII")  # host, robot, interface, index, type, subtype, timestamp, sequence, size

_NAMES = {code: name for name, code in CODES.items()}


@dataclass(frozen=True)
class Frame:
    """A message of a client.

    Attributes:
        type: REQUEST, COMMAND or another.
        code, interface: the interface; an empty name for those that are not served.
        index: of the device.
        number: the subtype; 0 where the version sends none.
        payload: without the subtype.
    """

    type: int
    code: int
    interface: str
    index: int
    number: int
    payload: bytes


class Wire(Protocol):
    """The framing of a version."""

    xdr: ClassVar[bool]

    def take(self, buffer: bytearray) -> Frame | None:
        """Remove the first frame from what was received; None if it is not complete.

        Raises:
            MalformedError: no frame can follow.
        """

    def pack(self, type: int, frame: Frame, payload: bytes, time: float) -> bytes:
        """The bytes of an answer to a frame, at a sim time [s]."""

    def pack_data(self, code: int, index: int, number: int, payload: bytes, time: float) -> bytes:
        """The bytes of a device's data, taken at a sim time [s]."""


def detect(buffer: bytearray) -> type[Wire1] | type[Wire2] | None:
    """The framing of what a client has sent first; None if more is needed.

    Raises:
        MalformedError: it is none of Player's protocols.
    """
    if buffer[:2] == STX[: len(buffer)] and (len(buffer) < 4 or 1 <= int.from_bytes(buffer[2:4]) <= ERROR):
        return Wire1 if len(buffer) >= 4 else None
    # Interface, index, type and subtype are small numbers in four bytes each.
    if any(buffer[8:10]) or any(buffer[12:14]) or any(buffer[16:19]) or any(buffer[20:23]):
        raise MalformedError("what the client sends is none of Player's protocols")
    if len(buffer) < _HEADER2.size:
        return None
    if not 1 <= buffer[19] <= NACK:
        raise MalformedError(f"the client's first message has the type {buffer[19]}")
    return Wire2


class Wire1:
    """The framing of 1.6."""

    xdr: ClassVar[bool] = False

    def take(self, buffer: bytearray) -> Frame | None:
        """See `Wire.take`. What is no header is skipped, as by Player."""
        while True:
            begin = buffer.find(STX)
            if begin != 0:
                keep = begin if begin > 0 else len(buffer) - buffer.endswith(STX[:1])
                del buffer[:keep]
            if len(buffer) < _HEADER1.size:
                return None
            _, kind, code, index, *_, size = _HEADER1.unpack_from(buffer)
            if not 0 < size <= LONGEST:
                del buffer[: _HEADER1.size]
                continue
            if len(buffer) < _HEADER1.size + size:
                return None
            payload = bytes(buffer[_HEADER1.size : _HEADER1.size + size])
            del buffer[: _HEADER1.size + size]
            interface = "position2d" if code == CODE_OF_POSITION2D_IN_1_6 else _NAMES.get(code, "")
            width = _width(interface) if kind == REQUEST else 0
            number = int.from_bytes(payload[:width]) if len(payload) >= width else -1
            return Frame(kind, code, interface, index, number, payload[width:])

    def pack(self, type: int, frame: Frame, payload: bytes, time: float) -> bytes:
        """See `Wire.pack`."""
        if payload and frame.interface != "mcom":
            payload = frame.number.to_bytes(_width(frame.interface)) + payload
        return self._bytes(type, frame.code, frame.index, payload, time)

    def pack_data(self, code: int, index: int, number: int, payload: bytes, time: float) -> bytes:
        """See `Wire.pack_data`."""
        return self._bytes(DATA, code, index, payload, time)

    def synch(self, time: float) -> bytes:
        """The message after a round of data."""
        return self._bytes(SYNCH, CODES["player"], 0, b"", time)

    def _bytes(self, type: int, code: int, index: int, payload: bytes, time: float) -> bytes:
        seconds = math.floor(time) & 0xFFFFFFFF if math.isfinite(time) else 0
        part = int(time % 1.0 * 1e6) if math.isfinite(time) else 0
        return _HEADER1.pack(STX, type, code, index, seconds, part, seconds, part, 0, len(payload)) + payload


def _width(interface: str) -> int:
    """The bytes of the subtype in a request of 1.6."""
    return 2 if interface == "player" else 1


class Wire2:
    """The framing of 2.0, 2.1 and 3; the port is part of the addresses of devices."""

    xdr: ClassVar[bool] = True

    def __init__(self, port: int) -> None:
        self._port = port
        self._skip = 0

    def take(self, buffer: bytearray) -> Frame | None:
        """See `Wire.take`. Payloads that are too long are skipped; the frame has none then."""
        skipped = min(self._skip, len(buffer))
        del buffer[:skipped]
        self._skip -= skipped
        if self._skip or len(buffer) < _HEADER2.size:
            return None
        _, _, code, index, kind, number, _, _, size = _HEADER2.unpack_from(buffer)
        if code > 0xFFFF or index > 0xFFFF or not 1 <= kind <= NACK or number > 0xFF or size > SKIPPED:
            raise MalformedError("the client has sent what is no header")
        if size > LONGEST:
            self._skip = size
            payload = b""
            del buffer[: _HEADER2.size]
        elif len(buffer) < _HEADER2.size + size:
            return None
        else:
            payload = bytes(buffer[_HEADER2.size : _HEADER2.size + size])
            del buffer[: _HEADER2.size + size]
        return Frame(kind, code, _NAMES.get(code, ""), index, number, payload)

    def pack(self, type: int, frame: Frame, payload: bytes, time: float) -> bytes:
        """See `Wire.pack`."""
        return self._bytes(type, frame.code, frame.index, frame.number, payload, time)

    def pack_data(self, code: int, index: int, number: int, payload: bytes, time: float) -> bytes:
        """See `Wire.pack_data`."""
        return self._bytes(DATA, code, index, number, payload, time)

    def synch(self, number: int, payload: bytes, time: float) -> bytes:
        """The message after a round of data."""
        return self._bytes(SYNCH, CODES["player"], 0, number, payload, time)

    def _bytes(self, type: int, code: int, index: int, number: int, payload: bytes, time: float) -> bytes:
        return _HEADER2.pack(LOCALHOST, self._port, code, index, type, number, time, 0, len(payload)) + payload
