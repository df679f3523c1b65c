"""Create message types from their declarations."""

from __future__ import annotations

import operator
import re
from typing import Any

from libgz.classic.msgs.fields import KINDS, VARINT, Field, Kind
from libgz.classic.msgs.message import Message
from libgz.classic.msgs.table import ENUMS, MESSAGES
from libgz.errors import NotFoundError, ParameterError, nearest
from libgz.simulation.state import plain

__all__ = ["declare", "known_types", "message_type", "restored"]

PREFIX = "gazebo.msgs."
_FIELD = re.compile(r"(?P<kind>[\w.]+)\s+(?P<name>[a-z_]\w*)\s*(?P<repeated>\[\])?\s*(?:=\s*(?P<default>\S+))?")

_types: dict[str, type[Message]] = {}
_enums: dict[str, Kind] = {}


def known_types() -> list[str]:
    """Return the full names of all message types."""
    return sorted({*(PREFIX + name for name in MESSAGES), *(kind.GetTypeName() for kind in _types.values())})


def message_type(name: str) -> type[Message]:
    """Return the type with a name such as `gazebo.msgs.Vector3d`, `Vector3d`, or one that was declared.

    Raises:
        NotFoundError: there is none.
    """
    short = name.removeprefix(PREFIX)
    found = _types.get(short)
    if found is None:
        if short not in MESSAGES:
            known = [*MESSAGES, *_types]
            raise NotFoundError(
                f"there is no message type {name!r}{nearest(short, known)}; msgs.declare makes new ones"
            )
        found = _make(short, PREFIX + short, MESSAGES[short])
    return found


def declare(name: str, fields: str, **enums: str) -> type[Message]:
    """Declare a message type.

    Both ends of a topic must declare it alike: a field's number on the wire is its position in `fields`.

    Args:
        name: Such as `my_robot.msgs.WheelSpeeds`.
        fields: Such as ``"double left, double right, Vector3d points[], int32 mode = 1"``. Kinds are double, float,
            bool, int32, int64, uint32, uint64, string, bytes, and the names of messages.
        enums: Enumerations by the names that `fields` use, such as ``Mode="IDLE DRIVING"``; values count from 1.

    Raises:
        ParameterError: the name is used by another declaration, or a field is invalid.
    """
    if not re.fullmatch(r"[A-Za-z_][\w.]*", name):
        raise ParameterError(f"a message type cannot be called {name!r}; it takes letters, digits, _ and dots")
    kinds = {key: _enum(key, values) for key, values in enums.items()}
    before = _types.get(name)
    if before is not None or name.removeprefix(PREFIX) in MESSAGES:
        if before is not None and before.__doc__ == _describe(name, fields):
            return before
        raise ParameterError(f"there is already a message type {name!r}")
    return _make(name, name, fields, kinds)


def restored(name: str, data: bytes) -> Message:
    """Return the message of a type and its encoding: what pickled messages are made of."""
    return message_type(name).FromString(data)


Message._restored = staticmethod(plain(restored, Message))


def _describe(name: str, fields: str) -> str:
    return f"{name}: {' '.join(fields.split())}"


def _enum(name: str, values: str) -> Kind:
    """Return the kind of an enumeration: values are set by number or by name."""
    numbers = {value: number for number, value in enumerate(values.split(), 1)}

    def check(value: Any) -> int:
        number = numbers.get(value, 0) if isinstance(value, str) else operator.index(value)
        if number not in numbers.values():
            raise ValueError(f"it must be one of {', '.join(f'{n} ({i})' for n, i in numbers.items())}")
        return number

    def read(value: int) -> int:
        return value if value in numbers.values() else 1

    return Kind(name, 1, VARINT, check, read, numbers)


def _kind(owner: str, word: str, local: dict[str, Kind]) -> Kind | type[Message]:
    if word in KINDS:
        return KINDS[word]
    if word in local:
        return local[word]
    if word in ENUMS:
        return _enums.setdefault(word, _enum(word, ENUMS[word]))
    try:
        return message_type(word)
    except NotFoundError:
        known = [*KINDS, *local, *MESSAGES, *_types]
        raise ParameterError(f"message {owner}: there is no type {word!r}{nearest(word, known)}") from None


def _make(short: str, name: str, fields: str, local: dict[str, Kind] | None = None) -> type[Message]:
    """Create the class of a declaration, and register it under its short name."""
    namespace = {"_name": name, "__doc__": _describe(name, fields)}
    made: type[Message] = type(short.rpartition(".")[2], (Message,), namespace)
    made.__module__, made.__qualname__ = "libgz.classic.msgs", short
    _types[short] = made  # before its fields: a Model contains Models
    try:
        table = dict(_read_fields(made, name, fields, local or {}))
    except ParameterError:
        del _types[short]
        raise
    made._fields = table
    made._numbers = {field.number: field for field in table.values()}
    made._parts = frozenset(n for n, field in table.items() if field.repeated or field.message is not None)
    for field in table.values():
        if field.kind is not None and not field.repeated:
            setattr(made, field.name, field.default)
        if field.kind is not None and field.kind.values is not None:
            for value, number in field.kind.values.items():
                setattr(made, value, number)
    if short in MESSAGES:
        for part in MESSAGES:
            if part.rpartition(".")[0] == short:
                setattr(made, part.rpartition(".")[2], message_type(part))
    return made


def _read_fields(made: type[Message], owner: str, fields: str, local: dict[str, Kind]) -> list[tuple[str, Field]]:
    found: list[tuple[str, Field]] = []
    for number, words in enumerate(fields.split(","), 1):
        match = _FIELD.fullmatch(words.strip())
        if match is None:
            raise ParameterError(f"message {owner}: field {words.strip()!r} is not like 'double x' or 'double x[]'")
        name, word = match["name"], match["default"]
        if name in dict(found):
            raise ParameterError(f"message {owner}: there are two fields {name!r}")
        kind = _kind(owner, match["kind"], local)
        default = None
        if word is not None:
            if not isinstance(kind, Kind) or match["repeated"]:
                raise ParameterError(f"message {owner}: field {name!r} cannot have a default")
            default = Field(owner, name, number, kind, False).check(_value(kind, word))
        found.append((name, Field(owner, name, number, kind, match["repeated"] is not None, default)))
    return found


def _value(kind: Kind, word: str) -> Any:
    """Return a default from its text."""
    if kind.name == "bool":
        return {"true": True, "false": False}.get(word, word)
    if kind.values is not None or kind.name == "string":
        return word.strip('"')
    try:
        return float(word) if kind.name in ("double", "float") else int(word)
    except ValueError:
        return word
