"""Records: layouts of Player's messages, written as text, and their bytes on the wire.

A layout lists fields, ``NAME:TYPE``, in the order of the wire. Types:

- ``i1 i2 i4`` and ``u1 u2 u4`` are whole numbers of that many bytes, ``f4`` and ``f8`` floating-point ones;
- ``i4*mm`` is a number in another unit than libgz's, which are m, rad, s and V (`UNITS`);
- ``u1[32]`` is an array of 32, filled with zeros; ``f4[]`` is as long as its count, which precedes it; ``u1[*]`` is
  what is left of the message;
- ``#ranges:u2`` is the number of elements that the field `ranges` has;
- ``s[64]`` and ``s[]`` are texts that end with a zero byte;
- ``poses{px:f8 py:f8}[]`` is an array of records; a record alone has no brackets.

Player 1.6 packs fields; Player 2 writes them in XDR (RFC 4506): each takes a multiple of four bytes. An array of bytes
is packed there, too, and what is as long as its count has that count twice, as Player's generator of XDR wrote it.
"""

from __future__ import annotations

import functools
import math
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError

__all__ = ["UNITS", "MalformedError", "Record", "Values", "record"]

Values: TypeAlias = Mapping[str, Any]  # by names of fields, in libgz's units

# How many of a unit libgz's own unit has.
UNITS = {
    "mm": 1000.0,
    "cm": 100.0,
    "deg": 180.0 / math.pi,
    "cdeg": 18000.0 / math.pi,
    "mrad": 1000.0,
    "dV": 10.0,
    "tenth": 10.0,
    "e7": 1e7,  # of a degree
}
MOST = 4096  # elements of an array that clients send

_FORMATS = {"i1": "b", "i2": "h", "i4": "i", "u1": "B", "u2": "H", "u4": "I", "f4": "f", "f8": "d"}
_FIELD = re.compile(r"\s*(#?\w+)(?::([a-z]\d?)(?:\*(\w+))?|\{)")
_SIZE = re.compile(r"\[(\d*|\*)\]")
_REST = -1
_LARGEST = float(np.finfo(np.float32).max)


class MalformedError(GazeboError):
    """A client's message is shorter than its layout, or states a length that cannot be."""


@dataclass(frozen=True)
class _Field:
    """One field; `size` is the number of elements, 0 if a count precedes, -1 for the rest, None for a single one."""

    name: str
    type: str
    scale: float
    size: int | None
    inner: Record | None


@dataclass(frozen=True)
class Record:
    """The layout of a message."""

    fields: tuple[_Field, ...]

    @property
    def names(self) -> list[str]:
        """The names of its fields, without counts."""
        return [field.name for field in self.fields if field.name[0] != "#"]

    @functools.cached_property
    def _plain(self) -> struct.Struct | None:
        """The layout in 1.6, if it consists of single numbers."""
        return self._struct(xdr=False)

    @functools.cached_property
    def _plain_xdr(self) -> struct.Struct | None:
        """The layout in XDR, if it consists of single numbers."""
        return self._struct(xdr=True)

    def _struct(self, *, xdr: bool) -> struct.Struct | None:
        if not all(f.type in _FORMATS and f.size is None and f.name[0] != "#" for f in self.fields):
            return None
        return struct.Struct(">" + "".join(_FORMATS[_wire_type(f.type, xdr)] for f in self.fields))

    def encode(self, values: Values, *, xdr: bool) -> bytes:
        """The bytes of a message. Fields without a value are zero; numbers that do not fit are limited."""
        plain = self._plain_xdr if xdr else self._plain
        if plain is not None:
            return plain.pack(*[_fitting(values.get(f.name) or 0, f.scale, f.type) for f in self.fields])
        parts: list[bytes] = []
        for field in self.fields:
            if field.name[0] == "#":
                given: Any = len(values.get(field.name[1:], ()))
            else:
                given = values.get(field.name)
            parts.append(_encoded(field, given, xdr))
        return b"".join(parts)

    def decode(self, data: bytes | memoryview, *, xdr: bool) -> dict[str, Any]:
        """The values of a message; what follows it is ignored.

        Raises:
            MalformedError: it is too short, or an array too long.
        """
        return self._decode(_Cursor(data), xdr)

    def _decode(self, cursor: _Cursor, xdr: bool) -> dict[str, Any]:
        plain = self._plain_xdr if xdr else self._plain
        if plain is not None:
            numbers = plain.unpack(cursor.take(plain.size))
            return {f.name: n if f.scale == 1.0 else n / f.scale for f, n in zip(self.fields, numbers, strict=True)}
        values: dict[str, Any] = {}
        for field in self.fields:
            values[field.name] = _decoded(field, cursor, xdr)
        for name in [name for name in values if name[0] == "#"]:
            count = int(values.pop(name))
            if name[1:] in values:
                values[name[1:]] = values[name[1:]][:count]
        return values

    def size(self, *, xdr: bool) -> int | None:
        """Its length [byte]; None if that depends on counts."""
        if any(
            field.size in (0, _REST) or (field.inner and field.inner.size(xdr=xdr) is None) for field in self.fields
        ):
            return None
        return len(self.encode({}, xdr=xdr))


class _Cursor:
    """Reads a message from its start to its end."""

    def __init__(self, data: bytes | memoryview) -> None:
        self.data = memoryview(data)
        self.at = 0

    def take(self, size: int) -> memoryview:
        if self.at + size > len(self.data):
            raise MalformedError(f"a message has {len(self.data)} bytes, {self.at + size} are needed")
        self.at += size
        return self.data[self.at - size : self.at]


@functools.cache
def record(text: str) -> Record:
    """The record of a layout.

    Raises:
        ParameterError: the text is no layout.
    """
    found, rest = _parsed(text)
    if rest.strip():
        raise ParameterError(f"the layout ends at {rest.strip()!r}")
    return found


def _parsed(text: str) -> tuple[Record, str]:
    fields: list[_Field] = []
    while (match := _FIELD.match(text)) is not None:
        text, inner = text[match.end() :], None
        if match[2] is None:
            inner, text = _parsed(text)
            text = text.lstrip().removeprefix("}")
        size = _SIZE.match(text)
        if size is not None:
            text = text[size.end() :]
        length = None if size is None else _REST if size[1] == "*" else int(size[1] or 0)
        kind = match[2] or ""
        if inner is None and kind not in _FORMATS and kind != "s":
            raise ParameterError(f"field {match[1]} has the type {kind!r}; there are s, {', '.join(_FORMATS)}")
        if match[3] and match[3] not in UNITS:
            raise ParameterError(f"field {match[1]} has the unit {match[3]!r}; there are {', '.join(UNITS)}")
        fields.append(_Field(match[1], kind, UNITS.get(match[3], 1.0), length, inner))
    return Record(tuple(fields)), text


# Bytes ---------------------------------------------------------------------------------------------------------------


def _wire_type(kind: str, xdr: bool) -> str:
    """A number's type on the wire: in XDR whole numbers have four bytes."""
    return kind[0] + "4" if xdr and kind[0] in "iu" else kind


def _encoded(field: _Field, value: Any, xdr: bool) -> bytes:
    if field.type == "s":
        return _encoded_text(field, value, xdr)
    if field.size is None:
        if field.inner is not None:
            return field.inner.encode(value or {}, xdr=xdr)
        kind = _wire_type(field.type, xdr)
        return struct.pack(">" + _FORMATS[kind], _fitting(0 if value is None else value, field.scale, field.type))
    if field.inner is not None:
        items: Sequence[Values] = () if value is None else value
        packed = [field.inner.encode(item, xdr=xdr) for item in (items[: field.size] if field.size else items)]
        if field.size:
            packed += [field.inner.encode({}, xdr=xdr)] * (field.size - len(packed))
            return b"".join(packed)
        return struct.pack(">II", len(items), len(items)) + b"".join(packed)
    return _encoded_array(field, value, xdr)


def _encoded_array(field: _Field, value: Any, xdr: bool) -> bytes:
    if isinstance(value, bytes | bytearray | memoryview):
        numbers: NDArray[Any] = np.frombuffer(value, dtype=np.uint8)
    else:
        numbers = np.asarray(() if value is None else value)
    if field.size and field.size != _REST:
        numbers = numbers[: field.size]
    opaque = xdr and field.type in ("u1", "i1")
    kind = field.type if opaque else _wire_type(field.type, xdr)
    content = _fitting_array(numbers, field.scale, field.type).astype(f">{kind}").tobytes()
    if field.size:
        content = content.ljust(max(field.size, 0) * int(kind[1]), b"\0")
    if opaque:
        content += bytes(-len(content) % 4)
    return content if field.size else struct.pack(">II", len(numbers), len(numbers)) + content


def _encoded_text(field: _Field, value: Any, xdr: bool) -> bytes:
    text = value if isinstance(value, bytes) else str(value or "").encode(errors="replace")
    if field.size:
        return text[: field.size - 1].ljust(field.size, b"\0")
    text += b"\0"
    return struct.pack(">II", len(text), len(text)) + text + bytes(-len(text) % 4)


def _limits(kind: str) -> tuple[int, int]:
    bits = 8 * int(kind[1])
    return (0, (1 << bits) - 1) if kind[0] == "u" else (-(1 << (bits - 1)), (1 << (bits - 1)) - 1)


def _fitting(value: Any, scale: float, kind: str) -> Any:
    number = value * scale if scale != 1.0 else value
    if kind[0] == "f":
        return max(-_LARGEST, min(float(number), _LARGEST)) if kind == "f4" and math.isfinite(number) else float(number)
    low, high = _limits(kind)
    if isinstance(number, float):
        number = (
            round(number) if math.isfinite(number) else (0 if math.isnan(number) else (high if number > 0 else low))
        )
    return max(low, min(int(number), high))


def _fitting_array(values: NDArray[Any], scale: float, kind: str) -> NDArray[Any]:
    if kind == "f4":
        return np.clip(values.astype(float) * scale, -_LARGEST, _LARGEST)
    if kind == "f8":
        return values.astype(float) * scale
    low, high = _limits(kind)
    if values.dtype.kind in "iu" and scale == 1.0:
        return values if values.dtype == np.uint8 and kind[0] == "u" else np.clip(values.astype(np.int64), low, high)
    return np.clip(np.rint(np.nan_to_num(values.astype(float) * scale, nan=0.0, posinf=high, neginf=low)), low, high)


def _decoded(field: _Field, cursor: _Cursor, xdr: bool) -> Any:
    if field.size is None:
        if field.inner is not None:
            return field.inner._decode(cursor, xdr)
        if field.type != "s":
            return _number(field, cursor, xdr)
    count = field.size or 0
    if count == _REST:
        return bytes(cursor.take(len(cursor.data) - cursor.at))
    if not count:
        count, again = struct.unpack(">II", cursor.take(8))
        if count != again or count > MOST:
            raise MalformedError(f"an array of {count} and {again} elements; at most {MOST} are allowed")
    if field.type in ("s", "u1", "i1") and (xdr or field.type != "i1"):
        content = bytes(cursor.take(count))
        if xdr:
            cursor.take(-count % 4)
        return content.partition(b"\0")[0].decode(errors="replace") if field.type == "s" else content
    if field.inner is not None:
        return [field.inner._decode(cursor, xdr) for _ in range(count)]
    return [_number(field, cursor, xdr) for _ in range(count)]


def _number(field: _Field, cursor: _Cursor, xdr: bool) -> Any:
    kind = _wire_type(field.type, xdr)
    number = struct.unpack(">" + _FORMATS[kind], cursor.take(int(kind[1])))[0]
    return number if field.scale == 1.0 else number / field.scale
