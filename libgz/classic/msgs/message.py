"""Message: what libgz adds to Google's messages."""

from __future__ import annotations

import base64
import functools
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, Self

from google.protobuf import message as google, message_factory
from google.protobuf.descriptor import Descriptor
from google.protobuf.descriptor_pb2 import FileDescriptorProto

from libgz.base.errors import ParameterError, nearest
from libgz.classic.msgs import text

__all__ = ["Message", "extend"]

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
# Google's own methods, beneath those of the same name below.
_GOOGLE: Any = FileDescriptorProto.__mro__[1]


class _MessageType(type):
    """Makes the classes of all messages of classic, and those that were declared, subclasses of Message."""

    def __instancecheck__(cls, instance: object) -> bool:
        return cls.__subclasscheck__(type(instance))

    def __subclasscheck__(cls, subclass: type) -> bool:
        return issubclass(subclass, google.Message) and "_restored" in vars(subclass)


class Message(google.Message, metaclass=_MessageType):
    """A message: fields are attributes. It is one of Google's messages, with some more methods.

    A field that is not set has its default; nested messages and lists of repeated fields are created at first access.
    Setting an unknown field raises AttributeError, an invalid value ParameterError. Messages and lists that are set are
    copied. For C++'s `msg.set_x(1)`, `msg.x()`, `msg.mutable_pose()->...`, `msg.add_ranges(v)`, write `msg.x = 1`,
    `msg.x`, `msg.pose...`, `msg.ranges.append(v)`. Required fields that are not set are sent with their defaults.
    """

    DESCRIPTOR: Any
    _restored: ClassVar[Callable[..., Message]]  # makes a message again; set where types are declared

    def __init__(self, **values: Any) -> None:
        for name, value in values.items():
            setattr(self, name, value)

    @classmethod
    def GetTypeName(cls) -> str:
        """Return the full name of the type, such as `gazebo.msgs.Vector3d`."""
        return str(cls.DESCRIPTOR.full_name)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(_unknown(self, name))

    def __setattr__(self, name: str, value: Any) -> None:
        try:
            _GOOGLE.__setattr__(self, name, value)
        except (AttributeError, TypeError, ValueError, OverflowError) as error:
            _assign(self, name, value, error)

    def __repr__(self) -> str:
        values = ", ".join(f"{field.name}={value!r}" for field, value in self.ListFields())
        return f"{type(self).__qualname__}({values})"

    def __str__(self) -> str:
        return text.write(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return Message._restored, (self.GetTypeName(), self.SerializePartialToString())

    # Presence and copies -----------------------------------------------------------------------------------------

    def HasField(self, name: str) -> bool:
        """Whether a field was set; a nested message is set when one of its fields is, or after SetInParent.

        Raises:
            ParameterError: there is no such field, or it is repeated: use its length.
        """
        try:
            return bool(_GOOGLE.HasField(self, name))
        except ValueError:
            if name in self.DESCRIPTOR.fields_by_name:
                raise ParameterError(f"{self.GetTypeName()}.{name} is repeated: use len(message.{name})") from None
            raise ParameterError(_unknown(self, name)) from None

    def ClearField(self, name: str) -> None:
        """Set a field back to its default.

        Raises:
            ParameterError: there is no such field.
        """
        try:
            _GOOGLE.ClearField(self, name)
        except ValueError:
            raise ParameterError(_unknown(self, name)) from None

    def CopyFrom(self, other: google.Message) -> None:
        """Replace all fields by those of another message of the same type.

        Raises:
            ParameterError: it is of another type.
        """
        _check_type(self, other, "copied")
        _GOOGLE.CopyFrom(self, other)

    def MergeFrom(self, other: google.Message) -> None:
        """Set the fields that another message of the same type has set; repeated fields are appended.

        Raises:
            ParameterError: it is of another type.
        """
        _check_type(self, other, "merged")
        _GOOGLE.MergeFrom(self, other)

    def copy(self) -> Self:
        """Return a deep copy."""
        new = type(self)()
        _GOOGLE.CopyFrom(new, self)
        return new

    # Forms -------------------------------------------------------------------------------------------------------

    def SerializeToString(self, **options: Any) -> bytes:
        """Return the message in the wire format of protocol buffers; required fields that are not set are added."""
        if self.IsInitialized():
            return bytes(_GOOGLE.SerializeToString(self, **options))
        whole = self.copy()
        _complete(whole)
        return bytes(_GOOGLE.SerializeToString(whole, **options))

    def ParseFromString(self, data: bytes) -> int:
        """Replace all fields by those in `data`, and return its length. Unknown fields are kept, but not shown.

        Raises:
            ParameterError: the data are damaged; the message is then empty.
        """
        try:
            _GOOGLE.ParseFromString(self, data)
        except google.DecodeError as error:
            self.Clear()
            raise ParameterError(f"the message is damaged: {error}") from None
        if not _is_text(self):
            self.Clear()
            raise ParameterError("the message is damaged: a text is not UTF-8")
        return len(data)

    @classmethod
    def FromString(cls, data: bytes) -> Self:
        """Return the message encoded in `data`; see ParseFromString."""
        message = cls()
        message.ParseFromString(data)
        return message

    def DebugString(self) -> str:
        """Return the message as text, one field per line; msgs.Parse reads it."""
        return text.write(self)

    def ShortDebugString(self) -> str:
        """Return the message as text in one line."""
        return " ".join(line.strip() for line in text.write(self).splitlines())

    def ToDict(self) -> dict[str, Any]:
        """Return the set fields as JSON values: bytes as base64, enumerations by name."""
        return {
            field.name: [_plain(field, item) for item in value] if field.is_repeated else _plain(field, value)
            for field, value in self.ListFields()
        }

    def FromDict(self, values: Mapping[str, Any]) -> Self:
        """Replace all fields by values in the form of ToDict, and return the message.

        Raises:
            ParameterError: a name is unknown, or a value is invalid.
        """
        self.Clear()
        if not isinstance(values, Mapping):
            raise ParameterError(f"{self.GetTypeName()} is made from a dict of its fields, not from {values!r}")
        for name, value in values.items():
            field = self.DESCRIPTOR.fields_by_name.get(name)
            if field is None:
                raise ParameterError(_unknown(self, name))
            if not field.is_repeated:
                setattr(self, name, _from_plain(field, value))
            elif isinstance(value, list):
                setattr(self, name, [_from_plain(field, item) for item in value])
            else:
                raise ParameterError(f"{self.GetTypeName()}.{name} is repeated; it takes a list")
        return self


_METHODS = {
    name: method
    for name, method in vars(Message).items()
    if callable(method) or isinstance(method, classmethod)
}  # fmt: skip


def extend(kind: Any) -> None:
    """Add the methods of Message to one of Google's classes."""
    for name, method in _METHODS.items():
        setattr(kind, name, method)
    kind._restored = staticmethod(Message._restored)


def _unknown(message: Message, name: str) -> str:
    word, _, rest = name.partition("_")
    if name.endswith("_size"):
        word, rest = "size", name.removesuffix("_size")
    fields = message.DESCRIPTOR.fields_by_name
    field = fields.get(rest)
    idioms = _CPP_REPEATED if field is not None and field.is_repeated else _CPP
    hint = f"; in Python that is {idioms[word].format(rest)}" if field and word in idioms else nearest(name, fields)
    return f"{message.GetTypeName()} has no field {name!r}{hint}"


def _assign(message: Message, name: str, value: Any, error: Exception) -> None:
    """Set a nested message or a repeated field, which Google's messages do not; else raise why it was not set."""
    field = message.DESCRIPTOR.fields_by_name.get(name)
    if field is None:
        raise AttributeError(_unknown(message, name)) from None
    if field.is_repeated:
        if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
            raise ParameterError(
                f"{message.GetTypeName()}.{name} is repeated; it takes a sequence, not {_short(value)}"
            ) from None
        tolist = getattr(value, "tolist", None)  # converts a numpy array at once
        items = tolist() if tolist is not None else list(value)
        before = list(getattr(message, name))
        message.ClearField(name)
        try:
            getattr(message, name).extend(items)
        except (TypeError, ValueError, OverflowError) as problem:
            message.ClearField(name)
            getattr(message, name).extend(before)
            wrong = next((item for item in items if not _fits(message, name, item)), value)
            raise ParameterError(f"{message.GetTypeName()}.{name} cannot be {_short(wrong)}: {problem}") from None
    elif field.message_type is not None:
        part = getattr(message, name)
        if type(value) is not type(part):
            wanted = field.message_type.full_name
            raise ParameterError(
                f"{message.GetTypeName()}.{name} cannot be {_short(value)}: it must be a {wanted}"
            ) from None
        part.CopyFrom(value)
        part.SetInParent()
    else:
        if field.enum_type is not None:
            allowed = ", ".join(f"{entry.name} ({entry.number})" for entry in field.enum_type.values)
            error = ValueError(f"it must be one of {allowed}")
        raise ParameterError(f"{message.GetTypeName()}.{name} cannot be {_short(value)}: {error}") from None


def _fits(message: Message, name: str, item: Any) -> bool:
    try:
        getattr(type(message)(), name).append(item)
    except (TypeError, ValueError, OverflowError):
        return False
    return True


def _check_type(message: Message, other: object, what: str) -> None:
    if type(other) is not type(message):
        kind = other.GetTypeName() if isinstance(other, Message) else type(other).__name__
        raise ParameterError(f"a {message.GetTypeName()} cannot be {what} from a {kind}")


def _complete(message: Any) -> None:
    """Set the required fields that are not set, in nested messages, too."""
    for field in message.DESCRIPTOR.fields:
        name = field.name
        if field.message_type is not None:
            if field.is_repeated:
                for item in getattr(message, name):
                    _complete(item)
            elif field.is_required or message.HasField(name):
                part = getattr(message, name)
                part.SetInParent()
                _complete(part)
        elif field.is_required and not message.HasField(name):
            setattr(message, name, field.default_value)


@functools.cache
def _texts(descriptor: Descriptor) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Names of the fields that are texts, of the nested messages, and of the repeated fields with texts."""
    texts = [field for field in descriptor.fields if field.type == field.TYPE_STRING]
    parts = [field for field in descriptor.fields if field.message_type is not None and _has_texts(field.message_type)]
    return (
        tuple(field.name for field in texts if not field.is_repeated),
        tuple(field.name for field in parts if not field.is_repeated),
        tuple(field.name for field in (*texts, *parts) if field.is_repeated),
    )


@functools.cache
def _has_texts(descriptor: Descriptor) -> bool:
    """Whether there are texts in a type, or in those that it contains."""
    found, waiting = {descriptor}, [descriptor]
    while waiting:
        for field in waiting.pop().fields:
            if field.type == field.TYPE_STRING:
                return True
            if field.message_type is not None and field.message_type not in found:
                found.add(field.message_type)
                waiting.append(field.message_type)
    return False


def _is_text(message: Any) -> bool:
    """Whether all texts of a message are UTF-8: Google's messages return those that are not as bytes."""
    texts, parts, lists = _texts(message.DESCRIPTOR)
    return (
        all(type(getattr(message, name)) is str for name in texts)
        and all(_is_text(getattr(message, name)) for name in parts if message.HasField(name))
        and all(
            type(item) is str or (type(item) is not bytes and _is_text(item))
            for name in lists
            for item in getattr(message, name)
        )
    )


def _plain(field: Any, value: Any) -> Any:
    if field.message_type is not None:
        return value.ToDict()
    if field.enum_type is not None:
        return field.enum_type.values_by_number[value].name
    return base64.b64encode(value).decode() if isinstance(value, bytes) else value


def _from_plain(field: Any, value: Any) -> Any:
    if field.message_type is not None:
        made: Any = message_factory.GetMessageClass(field.message_type)()
        return made.FromDict(value)
    if field.type == field.TYPE_BYTES and isinstance(value, str):
        try:
            return base64.b64decode(value, validate=True)
        except ValueError as error:
            raise ParameterError(f"{field.full_name} is no base64: {error}") from None
    return value


def _short(value: Any) -> str:
    found = repr(value)
    return found if len(found) <= 60 else found[:57] + "..."
