"""Types of ROS messages and services: their fields, constants, MD5 sums and values.

`definitions.txt` has those of ROS 1, most of which ROS 2 has, too; `definitions2.txt` those of ROS 2 that ROS 1 does
not have, or has with other fields.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator
from functools import cache, cached_property
from importlib.resources import files
from typing import Any, ClassVar, NamedTuple

import numpy as np

from libgz.base.errors import NotFoundError, ParameterError, nearest

__all__ = [
    "NUMBERS",
    "TIMES",
    "Constant",
    "Field",
    "Message",
    "MessageType",
    "ServiceType",
    "Stamp",
    "message_type",
    "parse_field",
    "service_type",
    "type_names",
]

# Kinds of numbers -> their letter in `struct`, which is also that of numpy. ROS 1's char is unsigned.
NUMBERS = {
    "bool": "?",
    "byte": "b",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
TIMES = ("time", "duration")

_FIELD = re.compile(r"([\w/]+)(?:\[(\d*)\])? (\w+)")
_RULE = "=" * 80 + "\n"  # between the texts of types in a definition


class Field(NamedTuple):
    """One field: `size` is None for a single value, 0 for any number of values, else their number."""

    name: str
    kind: str
    size: int | None


class Constant(NamedTuple):
    """One constant: `text` is its value as in the definition."""

    name: str
    kind: str
    text: str

    @property
    def value(self) -> int | float | str:
        """Its value."""
        if self.kind == "string":
            return self.text
        return float(self.text) if self.kind.startswith("float") else int(self.text)


class Stamp:
    """A time or a duration of ROS."""

    __slots__ = ("nsecs", "secs")

    def __init__(self, secs: int = 0, nsecs: int = 0) -> None:
        self.secs, self.nsecs = secs, nsecs

    def __repr__(self) -> str:
        return f"{self.secs}.{self.nsecs:09d}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Stamp) and (self.secs, self.nsecs) == (other.secs, other.nsecs)

    __hash__ = None  # type: ignore[assignment]

    @property
    def seconds(self) -> float:
        """[s]."""
        return self.secs + self.nsecs * 1e-9


class Message:
    """Base of all messages. The class of each type has its fields as attributes; what is not given is zero or empty.

    Raises:
        ParameterError: there is no such field.
    """

    __slots__ = ()

    kind: ClassVar[MessageType]

    def __init__(self, **values: Any) -> None:
        for name, make in self.kind.makers:
            setattr(self, name, values.pop(name) if name in values else make())
        if values:
            name, known = next(iter(values)), [field.name for field in self.kind.fields]
            raise ParameterError(f"{self.kind.name} has no field {name!r}{nearest(name, known)}")

    def __repr__(self) -> str:
        return f"{self.kind.name}({', '.join(f'{f.name}={getattr(self, f.name)!r}' for f in self.kind.fields)})"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Message)
            and self.kind is other.kind
            and all(_equal(getattr(self, field.name), getattr(other, field.name)) for field in self.kind.fields)
        )

    __hash__ = None  # type: ignore[assignment]


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return bool(np.array_equal(one, other, equal_nan=True))
    return bool(one == other)


class MessageType:
    """The type of a message. Calling it makes a message.

    Args:
        name: ``package/Name``.
        lines: its fields and constants, as in a definition.
        ros: whose types those of its fields are: 1 or 2.
    """

    def __init__(self, name: str, lines: list[str], ros: int = 1) -> None:
        self.name, self.ros = name, ros
        self.constants = [_constant(line) for line in lines if "=" in line]
        self.fields = [parse_field(line) for line in lines if "=" not in line]

    def __repr__(self) -> str:
        return f"<MessageType {self.name}>"

    def __call__(self, **values: Any) -> Any:
        """A new message."""
        return self._class(**values)

    def blank(self) -> Any:
        """A message whose fields are still to be set."""
        return self._class.__new__(self._class)

    @cached_property
    def _class(self) -> type[Message]:
        names: dict[str, Any] = {"__slots__": tuple(field.name for field in self.fields), "kind": self}
        names |= {constant.name: constant.value for constant in self.constants}
        return type(self.name.rpartition("/")[2], (Message,), names)

    @cached_property
    def makers(self) -> list[tuple[str, Callable[[], Any]]]:
        """(name, makes the default value) of each field."""
        return [(field.name, _maker(field, self.ros)) for field in self.fields]

    @cached_property
    def md5_text(self) -> str:
        """The text whose MD5 sum names this type: types of fields are replaced by their sums."""
        lines = [f"{constant.kind} {constant.name}={constant.text}" for constant in self.constants]
        for field in self.fields:
            if field.kind in NUMBERS or field.kind in (*TIMES, "string"):
                lines.append(f"{_with_size(field)} {field.name}")
            else:
                lines.append(f"{message_type(field.kind, self.ros).md5} {field.name}")
        return "\n".join(lines)

    @cached_property
    def md5(self) -> str:
        """The MD5 sum by which nodes compare types."""
        return _md5(self.md5_text)

    @cached_property
    def text(self) -> str:
        """The definition with those of all types in it, as in the headers of connections and in bags."""
        parts = [self.own_text]
        parts += [f"MSG: {other.name}\n{other.own_text}" for other in self.parts]
        return _RULE.join(parts)

    @property
    def own_text(self) -> str:
        """Its definition alone."""
        lines = [f"{constant.kind} {constant.name}={constant.text}" for constant in self.constants]
        return "".join(f"{line}\n" for line in [*lines, *(f"{_with_size(f)} {f.name}" for f in self.fields)])

    @property
    def parts(self) -> list[MessageType]:
        """The types of its fields, and of theirs."""
        return self._add_parts([])

    def _add_parts(self, found: list[MessageType]) -> list[MessageType]:
        for field in self.fields:
            if field.kind not in NUMBERS and field.kind not in (*TIMES, "string"):
                other = message_type(field.kind, self.ros)
                if other not in found:
                    found.append(other)
                    other._add_parts(found)
        return found


class ServiceType:
    """The type of a service: those of its request and its response.

    Args:
        name: ``package/Name``.
        request, response: lines of their definitions.
        ros: 1 or 2.
    """

    def __init__(self, name: str, request: list[str], response: list[str], ros: int = 1) -> None:
        self.name, self.ros = name, ros
        self.request = MessageType(f"{name}Request", request, ros)
        self.response = MessageType(f"{name}Response", response, ros)

    def __repr__(self) -> str:
        return f"<ServiceType {self.name}>"

    @cached_property
    def md5(self) -> str:
        """The MD5 sum by which clients and servers compare types."""
        return _md5(self.request.md5_text + self.response.md5_text)


def parse_field(line: str) -> Field:
    """The field that a line of a definition declares.

    Raises:
        ParameterError: it is none.
    """
    match = _FIELD.fullmatch(line)
    if match is None:
        raise ParameterError(f"{line!r} declares no field of a message")
    kind, size, name = match.groups()
    return Field(name, kind, None if size is None else int(size or 0))


def _constant(line: str) -> Constant:
    kind, rest = line.split(" ", 1)
    name, _, text = rest.partition("=")
    return Constant(name, kind, text)


def _with_size(field: Field) -> str:
    return field.kind if field.size is None else f"{field.kind}[{field.size or ''}]"


def _md5(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()


def _maker(field: Field, ros: int) -> Callable[[], Any]:
    if field.size:
        if field.kind in NUMBERS:
            kind, size = np.dtype(NUMBERS[field.kind]), field.size
            return lambda: np.zeros(size, kind)
        make, count = _maker(field._replace(size=None), ros), field.size
        return lambda: [make() for _ in range(count)]
    if field.size == 0:
        return list
    if field.kind in NUMBERS:
        zero = {"bool": False, "float32": 0.0, "float64": 0.0}.get(field.kind, 0)
        return lambda: zero
    if field.kind == "string":
        return str
    return Stamp if field.kind in TIMES else message_type(field.kind, ros)


@cache
def _types(ros: int) -> dict[str, MessageType | ServiceType]:
    if ros == 1:
        return _read("definitions.txt", 1)
    return _types(1) | _read("definitions2.txt", 2)


def _read(file: str, ros: int) -> dict[str, MessageType | ServiceType]:
    found: dict[str, MessageType | ServiceType] = {}
    for name, lines in _paragraphs((files("libgz.ros") / file).read_text()):
        if "---" in lines:
            at = lines.index("---")
            found[name] = ServiceType(name, lines[:at], lines[at + 1 :], ros)
        else:
            found[name] = MessageType(name, lines, ros)
    return found


def _paragraphs(text: str) -> Iterator[tuple[str, list[str]]]:
    """(name, lines) of each definition."""
    for paragraph in text.strip().split("\n\n"):
        name, *lines = paragraph.split("\n")
        yield name, [line.strip() for line in lines]


def type_names(ros: int = 1) -> list[str]:
    """All types of messages and services of ROS 1 or 2."""
    return list(_types(ros))


def message_type(name: str, ros: int = 1) -> MessageType:
    """A type of messages of ROS 1 or 2 by its name, ``package/Name``.

    Raises:
        NotFoundError: there is none.
    """
    found = _types(ros).get(name)
    if not isinstance(found, MessageType):
        raise NotFoundError(f"there is no message type {name!r}{nearest(name, _types(ros))}")
    return found


def service_type(name: str, ros: int = 1) -> ServiceType:
    """A type of services of ROS 1 or 2 by its name, ``package/Name``.

    Raises:
        NotFoundError: there is none.
    """
    found = _types(ros).get(name)
    if not isinstance(found, ServiceType):
        raise NotFoundError(f"there is no service type {name!r}{nearest(name, _types(ros))}")
    return found
