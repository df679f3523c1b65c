"""The fields of messages: the values that each kind accepts, and their encoding.

The encoding is the public wire format of protocol buffers: a key, which is a field's number and a wire type, then a
varint, 4 bytes, 8 bytes, or a length and bytes. It is compact, a reader skips unknown fields, and reading it never
executes code from the sender.
"""

from __future__ import annotations

import operator
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol, Self

from libgz.errors import ParameterError

__all__ = [
    "BYTES",
    "FIXED32",
    "FIXED64",
    "KINDS",
    "VARINT",
    "AnyMessage",
    "Field",
    "Kind",
    "Repeated",
    "read_varint",
    "varint",
]

VARINT, FIXED64, BYTES, FIXED32 = 0, 1, 2, 5
_FORMATS = {FIXED64: "d", FIXED32: "f"}


def varint(value: int) -> bytes:
    """Encode a number with 7 bits per byte, the lowest first; negative ones as 64 bits in two's complement."""
    if 0 <= value < 0x80:
        return bytes((value,))
    value &= 0xFFFFFFFFFFFFFFFF
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def read_varint(data: bytes, at: int) -> tuple[int, int]:
    """Return the number at offset `at`, and the offset of its end.

    Raises:
        ParameterError: the data end within it, or it has more than ten bytes.
    """
    value = shift = 0
    for at_ in range(at, min(at + 10, len(data))):
        byte = data[at_]
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & 0xFFFFFFFFFFFFFFFF, at_ + 1
        shift += 7
    raise ParameterError("the message is damaged: a number has no end")


class Kind:
    """A kind of value: its default, its allowed values and its encoding.

    Args:
        name: As declarations spell it, such as `double`.
        default: The value of a field that is not set.
        wire: VARINT, FIXED64, FIXED32 or BYTES.
        check: Convert a value to the stored one; raise TypeError or ValueError for an invalid value.
        read: Convert the number (or bytes) on the wire to the value.
        values: For an enumeration, its names and numbers.
    """

    def __init__(
        self,
        name: str,
        default: Any,
        wire: int,
        check: Callable[[Any], Any],
        read: Callable[[Any], Any],
        values: Mapping[str, int] | None = None,
    ) -> None:
        self.name, self.default, self.wire = name, default, wire
        self.check, self.read, self.values = check, read, values

    def encode(self, value: Any) -> bytes:
        """Encode a value, without its key."""
        if self.wire == VARINT:
            return varint(int(value))
        if self.wire == BYTES:
            data = value.encode() if isinstance(value, str) else value
            return varint(len(data)) + data
        return struct.pack("<" + _FORMATS[self.wire], value)

    def decode(self, data: bytes, at: int) -> tuple[Any, int]:
        """Return the value at offset `at`, and the offset of its end."""
        if self.wire == VARINT:
            number, end = read_varint(data, at)
            return self.read(number), end
        if self.wire == BYTES:
            size, start = read_varint(data, at)
            end = start + size
            if end > len(data):
                raise ParameterError("the message is damaged: it ends within a field")
            return self.read(data[start:end]), end
        end = at + (8 if self.wire == FIXED64 else 4)
        if end > len(data):
            raise ParameterError("the message is damaged: it ends within a field")
        return struct.unpack_from("<" + _FORMATS[self.wire], data, at)[0], end

    def encode_all(self, values: Sequence[Any]) -> bytes:
        """Encode numbers as a packed field: their size in bytes, then one after the other."""
        if self.wire == VARINT:
            data = b"".join(varint(int(value)) for value in values)
        else:
            data = struct.pack(f"<{len(values)}{_FORMATS[self.wire]}", *values)
        return varint(len(data)) + data

    def decode_all(self, data: bytes) -> list[Any]:
        """Return the numbers of a packed field."""
        if self.wire != VARINT:
            size = 8 if self.wire == FIXED64 else 4
            if len(data) % size:
                raise ParameterError("the message is damaged: it ends within a number")
            return list(struct.unpack(f"<{len(data) // size}{_FORMATS[self.wire]}", data))
        values, at = [], 0
        while at < len(data):
            value, at = self.decode(data, at)
            values.append(value)
        return values


def _whole(low: int, high: int) -> Callable[[Any], int]:
    def check(value: Any) -> int:
        number = operator.index(value)
        if not low <= number <= high:
            raise ValueError(f"it must be {low} to {high}")
        return number

    return check


def _signed(bits: int) -> Callable[[int], int]:
    half = 1 << (bits - 1)
    return lambda number: ((number + half) & (2 * half - 1)) - half


def _real(value: Any) -> float:
    if isinstance(value, (str, bytes)):
        raise TypeError("it must be a number")
    return float(value)


def _single(value: Any) -> float:
    """Round a number to single precision, as a receiver will read it."""
    return float(struct.unpack("<f", struct.pack("<f", _real(value)))[0])


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("it must be a str")
    return value


def _raw(value: Any) -> bytes:
    if isinstance(value, (int, str)):
        raise TypeError("it must be bytes")
    return bytes(value)


def _read_text(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise ParameterError(f"the message is damaged: a text is not UTF-8: {error}") from None


_KINDS = (
    Kind("double", 0.0, FIXED64, _real, float),
    Kind("float", 0.0, FIXED32, _single, float),
    Kind("bool", False, VARINT, lambda value: bool(operator.index(value)), bool),
    Kind("int32", 0, VARINT, _whole(-(1 << 31), (1 << 31) - 1), _signed(32)),
    Kind("int64", 0, VARINT, _whole(-(1 << 63), (1 << 63) - 1), _signed(64)),
    Kind("uint32", 0, VARINT, _whole(0, (1 << 32) - 1), lambda number: number & 0xFFFFFFFF),
    Kind("uint64", 0, VARINT, _whole(0, (1 << 64) - 1), int),
    Kind("string", "", BYTES, _text, _read_text),
    Kind("bytes", b"", BYTES, _raw, bytes),
)
KINDS = {kind.name: kind for kind in _KINDS}


class AnyMessage(Protocol):
    """The part of a message's interface that fields and the text form use."""

    @classmethod
    def GetTypeName(cls) -> str:
        """Return the full name of the type."""

    def ListFields(self) -> list[tuple[Field, Any]]:
        """Return (field, value) of all fields that are set."""

    def SetInParent(self) -> None:
        """Mark it as set in the message that holds it."""

    def copy(self) -> Self:
        """Return a deep copy."""

    def _field(self, name: str) -> Field:
        """Return a field by name."""


class Field:
    """A declared field: its name, number, kind or message type, default, and whether it is repeated."""

    def __init__(
        self, owner: str, name: str, number: int, kind: Kind | type[AnyMessage], repeated: bool, default: Any = None
    ) -> None:
        self.owner, self.name, self.number, self.repeated = owner, name, number, repeated
        self.kind = kind if isinstance(kind, Kind) else None
        self.message = None if isinstance(kind, Kind) else kind
        self.default = self.kind.default if self.kind is not None and default is None else default
        self.packed = repeated and self.kind is not None and self.kind.wire != BYTES
        wire = BYTES if self.kind is None or self.packed else self.kind.wire
        self.key = varint(number << 3 | wire)

    def __str__(self) -> str:
        kind = self.kind.name if self.kind is not None else self.type_name
        return f"{kind} {self.name}{'[]' if self.repeated else ''}"

    @property
    def type_name(self) -> str:
        """The full name of the nested message's type."""
        return self.message.GetTypeName() if self.message is not None else ""

    def check(self, value: Any) -> Any:
        """Return a value as the field stores it; a message is copied.

        Raises:
            ParameterError: the value is of another type, or out of range.
        """
        if self.kind is None:
            if type(value) is self.message:
                return value.copy()
            why = f"it must be a {self.type_name}"
        else:
            try:
                return self.kind.check(value)
            except (TypeError, ValueError, OverflowError, struct.error) as error:
                why = str(error)
        raise ParameterError(f"{self.owner}.{self.name} cannot be {_short(value)}: {why}")

    def check_all(self, values: Any) -> Repeated:
        """Return a sequence of values as the field stores it.

        Raises:
            ParameterError: it is no sequence; or a value is of another type, or out of range.
        """
        if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
            raise ParameterError(f"{self.owner}.{self.name} is repeated; it takes a sequence, not {_short(values)}")
        tolist = getattr(values, "tolist", None)  # converts a numpy array at once
        return Repeated(self, (self.check(value) for value in (values if tolist is None else tolist())))


class Repeated(list[Any]):
    """The values of a repeated field: a list that checks each value, and whose `add` makes nested messages."""

    __slots__ = ("field",)

    def __init__(self, field: Field, values: Iterable[Any] = ()) -> None:
        super().__init__(values)
        self.field = field

    def __reduce__(self) -> tuple[Any, ...]:
        return list, (list(self),)

    def add(self, *value: Any, **values: Any) -> Any:
        """Append a nested message with these fields, or the given plain value, and return it."""
        if self.field.message is None:
            self.append(*value)
            return self[-1]
        item = self.field.check(*value) if value else self.field.message()
        for name, part in values.items():
            setattr(item, name, part)
        super().append(item)
        return item

    def append(self, value: Any) -> None:
        """Append a value; a message is copied."""
        super().append(self.field.check(value))

    def insert(self, index: Any, value: Any) -> None:
        """Insert a value; a message is copied."""
        super().insert(index, self.field.check(value))

    def extend(self, values: Iterable[Any]) -> None:
        """Append values; messages are copied."""
        super().extend(self.field.check_all(values))

    def __setitem__(self, index: Any, value: Any) -> None:
        super().__setitem__(index, self.field.check_all(value) if isinstance(index, slice) else self.field.check(value))

    def __iadd__(self, values: Iterable[Any]) -> Repeated:  # type: ignore[misc]
        self.extend(values)
        return self


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
