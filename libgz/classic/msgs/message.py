"""Message: the base of all message types."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar, Self

from libgz.classic.msgs import text
from libgz.classic.msgs.fields import BYTES, FIXED32, FIXED64, VARINT, Field, Repeated, read_varint, varint
from libgz.errors import ParameterError, nearest

__all__ = ["Message"]

DEEPEST = 100  # messages within messages, as in protocol buffers


# For error messages: the Python form of C++'s <word>_<field> and <field>_size.
_CPP = {
    "set": "message.{0} = value",
    "mutable": "message.{0}",
    "has": "message.HasField('{0}')",
    "clear": "message.ClearField('{0}')",
}
_CPP_REPEATED = {
    **_CPP,
    "set": "message.{0}[i] = value",
    "mutable": "message.{0}[i]",
    "add": "message.{0}.append(value) or message.{0}.add()",
    "size": "len(message.{0})",
}


class Message:
    """A message: fields are attributes.

    A field that is not set has its default; nested messages and lists of repeated fields are created at first access.
    Setting an unknown field raises AttributeError, an invalid value ParameterError. Messages and lists that are set are
    copied. For C++'s `msg.set_x(1)`, `msg.x()`, `msg.mutable_pose()->...`, `msg.add_ranges(v)`, write `msg.x = 1`,
    `msg.x`, `msg.pose...`, `msg.ranges.append(v)`.
    """

    _fields: ClassVar[dict[str, Field]] = {}
    _numbers: ClassVar[dict[int, Field]] = {}
    _parts: ClassVar[frozenset[str]] = frozenset()  # nested and repeated fields, for `copy`
    _name: ClassVar[str] = ""
    _restored: ClassVar[Callable[[str, bytes], Message]]  # makes a message again; set where types are declared

    def __init__(self, **values: Any) -> None:
        for name, value in values.items():
            setattr(self, name, value)

    @classmethod
    def GetTypeName(cls) -> str:
        """Return the full name of the type, such as `gazebo.msgs.Vector3d`."""
        return cls._name

    def __getattr__(self, name: str) -> Any:
        field = self._fields.get(name)
        if field is None:
            raise AttributeError(self._unknown(name))
        # First access to a nested or repeated field; the defaults of plain ones are attributes of the class.
        made = Repeated(field) if field.repeated else field.message() if field.message is not None else field.default
        self.__dict__[name] = made
        return made

    def __setattr__(self, name: str, value: Any) -> None:
        field = self._fields.get(name)
        if field is None:
            raise AttributeError(self._unknown(name))
        self.__dict__[name] = field.check_all(value) if field.repeated else field.check(value)

    def __delattr__(self, name: str) -> None:
        self.ClearField(name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self.SerializeToString() == other.SerializeToString()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        values = ", ".join(f"{field.name}={value!r}" for field, value in self.ListFields())
        return f"{type(self).__qualname__}({values})"

    def __str__(self) -> str:
        return self.DebugString()

    def __copy__(self) -> Self:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return Message._restored, (self._name, self.SerializeToString())

    # Presence and copies -----------------------------------------------------------------------------------------

    def _unknown(self, name: str) -> str:
        word, _, rest = name.partition("_")
        if name.endswith("_size"):
            word, rest = "size", name.removesuffix("_size")
        field = self._fields.get(rest)
        idioms = _CPP_REPEATED if field is not None and field.repeated else _CPP
        known = field is not None and word in idioms
        hint = f"; in Python that is {idioms[word].format(rest)}" if known else nearest(name, self._fields)
        return f"{self._name} has no field {name!r}{hint}"

    def _field(self, name: str) -> Field:
        try:
            return self._fields[name]
        except KeyError:
            raise ParameterError(self._unknown(name)) from None

    def HasField(self, name: str) -> bool:
        """Whether a field was set; a nested message is set when one of its fields is, or after SetInParent.

        Raises:
            ParameterError: there is no such field, or it is repeated: use its length.
        """
        field = self._field(name)
        if field.repeated:
            raise ParameterError(f"{self._name}.{name} is repeated: use len(message.{name})")
        value = self.__dict__.get(name)
        return value is not None if field.message is None else value is not None and value._is_set()

    def _is_set(self) -> bool:
        return "_present" in self.__dict__ or next(self._set_fields(), None) is not None

    def _set_fields(self) -> Iterator[tuple[Field, Any]]:
        for name, value in self.__dict__.items():
            field = self._fields.get(name)
            if field is None or (field.repeated and not value):
                continue
            if field.message is None or field.repeated or value._is_set():
                yield field, value

    def ListFields(self) -> list[tuple[Field, Any]]:
        """Return (field, value) of all fields that are set, in the order of their declaration."""
        return sorted(self._set_fields(), key=lambda pair: pair[0].number)

    def SetInParent(self) -> None:
        """Mark it as set in the message that holds it, even without a set field."""
        self.__dict__["_present"] = True

    def Clear(self) -> None:
        """Clear all fields."""
        self.__dict__.clear()

    def ClearField(self, name: str) -> None:
        """Set a field back to its default.

        Raises:
            ParameterError: there is no such field.
        """
        self._field(name)
        self.__dict__.pop(name, None)

    def CopyFrom(self, other: Message) -> None:
        """Replace all fields by those of another message of the same type.

        Raises:
            ParameterError: it is of another type.
        """
        if type(other) is not type(self):
            kind = other.GetTypeName() if isinstance(other, Message) else type(other).__name__
            raise ParameterError(f"a {self._name} cannot be copied from a {kind}")
        if other is not self:
            values = other.copy().__dict__
            self.__dict__.clear()
            self.__dict__.update(values)

    def copy(self) -> Self:
        """Return a deep copy."""
        new = object.__new__(type(self))
        values = new.__dict__
        values.update(self.__dict__)
        for name in self._parts:
            if (part := values.get(name)) is not None:
                if type(part) is not Repeated:
                    values[name] = part.copy()
                elif part.field.message is None:
                    values[name] = Repeated(part.field, part)
                else:
                    values[name] = Repeated(part.field, [item.copy() for item in part])
        return new

    # Forms -------------------------------------------------------------------------------------------------------

    def SerializeToString(self) -> bytes:
        """Return the message in the wire format of protocol buffers."""
        out: list[tuple[int, bytes]] = []
        for name, value in self.__dict__.items():
            field = self._fields.get(name)
            if field is not None:
                _write(out, field, value)
        out.sort(key=lambda part: part[0])
        return b"".join([data for _, data in out])

    def ParseFromString(self, data: bytes) -> int:
        """Replace all fields by those in `data`, and return its length. Unknown fields are skipped.

        Raises:
            ParameterError: the data are damaged; the message is then empty.
        """
        self.Clear()
        try:
            self._merge(bytes(data), 0)
        except ParameterError:
            self.Clear()
            raise
        return len(data)

    @classmethod
    def FromString(cls, data: bytes) -> Self:
        """Return the message encoded in `data`; see ParseFromString."""
        message = cls()
        message.ParseFromString(data)
        return message

    def _merge(self, data: bytes, depth: int) -> None:
        if depth > DEEPEST:
            raise ParameterError(f"the message is damaged: more than {DEEPEST} messages within each other")
        at, end = 0, len(data)
        while at < end:
            key, at = read_varint(data, at)
            field = self._numbers.get(key >> 3)
            wire = key & 7
            if field is None or not _fits(field, wire):
                at = _skip(data, at, wire)
            elif field.kind is not None and wire != BYTES:
                value, at = field.kind.decode(data, at)
                self._put(field, value)
            else:
                size, start = read_varint(data, at)
                at = start + size
                if at > end:
                    raise ParameterError("the message is damaged: it ends within a field")
                self._put_bytes(field, data[start:at], depth)

    def _put(self, field: Field, value: Any) -> None:
        if field.repeated:
            list.append(getattr(self, field.name), value)
        else:
            self.__dict__[field.name] = value

    def _put_bytes(self, field: Field, data: bytes, depth: int) -> None:
        if field.kind is None:
            part = getattr(self, field.name)
            if field.repeated:
                part = part.add()
            part._merge(data, depth + 1)
            part.SetInParent()
        elif field.packed:
            list.extend(getattr(self, field.name), field.kind.decode_all(data))
        else:
            self._put(field, field.kind.read(data))

    def DebugString(self) -> str:
        """Return the message as text, one field per line; msgs.Parse reads it."""
        return text.write(self)

    def ShortDebugString(self) -> str:
        """Return the message as text in one line."""
        return " ".join(line.strip() for line in text.write(self).splitlines())

    def ToDict(self) -> dict[str, Any]:
        """Return the set fields as JSON values: bytes as base64, enumerations by name."""
        found: dict[str, Any] = {}
        for field, value in self.ListFields():
            found[field.name] = [_plain(field, item) for item in value] if field.repeated else _plain(field, value)
        return found

    def FromDict(self, values: Mapping[str, Any]) -> Self:
        """Replace all fields by values in the form of ToDict, and return the message.

        Raises:
            ParameterError: a name is unknown, or a value is invalid.
        """
        self.Clear()
        if not isinstance(values, Mapping):
            raise ParameterError(f"{self._name} is made from a dict of its fields, not from {values!r}")
        for name, value in values.items():
            field = self._field(name)
            if not field.repeated:
                setattr(self, name, _from_plain(field, value))
            elif isinstance(value, list):
                setattr(self, name, [_from_plain(field, item) for item in value])
            else:
                raise ParameterError(f"{self._name}.{name} is repeated; it takes a list")
            if field.message is not None and not field.repeated:
                getattr(self, name).SetInParent()
        return self


def _write(out: list[tuple[int, bytes]], field: Field, value: Any) -> None:
    """Append a field's number and encoding."""
    if field.repeated:
        if not value:
            return
        if field.kind is None:
            parts = [item.SerializeToString() for item in value]
            data = b"".join([field.key + varint(len(part)) + part for part in parts])
        elif field.packed:
            data = field.key + field.kind.encode_all(value)
        else:
            data = b"".join([field.key + field.kind.encode(item) for item in value])
    elif field.kind is not None:
        data = field.key + field.kind.encode(value)
    else:
        part = value.SerializeToString()
        if not part and not value._is_set():
            return
        data = field.key + varint(len(part)) + part
    out.append((field.number, data))


def _fits(field: Field, wire: int) -> bool:
    """Whether a field can have this wire type; numbers of a repeated field may be packed or not."""
    if field.kind is None:
        return wire == BYTES
    return wire == field.kind.wire or (wire == BYTES and field.packed)


def _skip(data: bytes, at: int, wire: int) -> int:
    """Return the offset of the end of an unknown field."""
    if wire == VARINT:
        return read_varint(data, at)[1]
    if wire == BYTES:
        size, at = read_varint(data, at)
    elif wire in (FIXED32, FIXED64):
        size = 8 if wire == FIXED64 else 4
    else:
        raise ParameterError(f"the message is damaged: no field has the wire type {wire}")
    if at + size > len(data):
        raise ParameterError("the message is damaged: it ends within a field")
    return at + size


def _plain(field: Field, value: Any) -> Any:
    if field.kind is None:
        return value.ToDict()
    if field.kind.values is not None:
        return next(name for name, number in field.kind.values.items() if number == value)
    return base64.b64encode(value).decode() if isinstance(value, bytes) else value


def _from_plain(field: Field, value: Any) -> Any:
    if field.message is not None:
        part: Any = field.message()
        return part.FromDict(value)
    if field.kind is not None and field.kind.name == "bytes" and isinstance(value, str):
        try:
            return base64.b64decode(value, validate=True)
        except ValueError as error:
            raise ParameterError(f"{field.owner}.{field.name} is no base64: {error}") from None
    return value
