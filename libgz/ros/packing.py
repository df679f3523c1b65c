"""Codec: packs and unpacks the messages of one type for one wire: that of ROS 1, or CDR, that of ROS 2."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from operator import attrgetter
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, NotFoundError, ParameterError
from libgz.ros.types import NUMBERS, TIMES, Field, MessageType, Stamp, message_type

__all__ = ["CDR_HEADER", "Buffer", "Codec", "FormatError", "Schema", "codec", "read_schema"]

CDR_HEADER = b"\0\1\0\0"  # little endian, plain CDR (XCDR1)
U32 = struct.Struct("<I")
MOST_NESTED = 16  # types in types
MOST_ITEMS = 100_000  # texts, times and messages in the lists of one message: each takes microseconds to read
MOST_READ = 1 << 20  # messages in one message, numbers and texts of theirs, and lists, each of numbers counted as one
MOST_VALUES = 1 << 16  # of a type whose fields a ROS 2 describes, a sequence counted as one item
MOST_FIELDS = 10_000  # that a ROS 2 describes, of a type and those in it

# Fields of types, by the types' names, where they differ from those of ROS 1: name, and its attribute in a message.
Schema = Mapping[str, Sequence[tuple[Field, str | None]]]

LARGE = 1 << 14  # [byte] from which the memory of numbers is sent as it is, not copied into the message
FEW = 64  # numbers that are packed without numpy: covariances have 36
SHORT = 256  # letters of a text whose bytes are kept

Buffer: TypeAlias = "bytes | memoryview"
Step: TypeAlias = "Callable[[Any, _Output], None]"
_Run: TypeAlias = list[tuple[str | None, str, int | None]]  # (attribute, letter, how many) of numbers in a row


class FormatError(GazeboError):
    """Bytes that are no message of the expected type."""


class Codec:
    """Packs and unpacks messages of a type.

    A message's fields with several values take lists, tuples and arrays; those of messages also a float64 array with a
    row for each, if the type consists of float64 numbers: the tables of the engine need no conversion.

    Args:
        kind: the type.
        cdr: for ROS 2.
        schema: the fields of types, if they are not those of ROS 1.
    """

    def __init__(self, kind: MessageType, cdr: bool = False, schema: Schema | None = None) -> None:
        self.kind, self._cdr, self._schema = kind, cdr, schema or {}
        self._elements: dict[str, list[Step]] = {}
        self._widths: dict[str, int | None] = {}
        self._measured: dict[str, tuple[int, int]] = {}
        self._blanks: dict[str, _Blank] = {}
        self._measure(kind.name, 0)
        self._steps = self._plan(kind.name)

    def pack(self, message: Any) -> bytes:
        """The bytes of a message.

        Raises:
            ParameterError: a value does not fit into its field.
        """
        return b"".join(self.pack_parts(message))

    def pack_parts(self, message: Any) -> list[Buffer]:
        """The bytes of a message in parts: large arrays of numbers are their own memory, which is not copied.

        Raises:
            ParameterError: a value does not fit into its field.
        """
        out = _Output(CDR_HEADER if self._cdr else b"")
        out.large = []
        try:
            for step in self._steps:
                step(message, out)
        except (struct.error, ValueError, TypeError, OverflowError, AttributeError) as error:
            raise ParameterError(f"a {self.kind.name} cannot be packed: {error}") from error
        if not out.large:
            return [bytes(out)]
        parts: list[Buffer] = []
        begin = 0
        for at, memory in out.large:
            parts += [bytes(out[begin:at]), memory]
            begin = at
        return [*parts, bytes(out[begin:])]

    def places(self, message: Any) -> dict[str, tuple[int, str, int]]:
        """Where the numbers of a message are in its bytes: by their paths, such as ``pose.position.x``, the place
        [byte], the letter of their type in `struct`, and how many there are."""
        found: dict[str, tuple[int, str, int]] = {}
        self._place(self.kind.name, message, "", len(CDR_HEADER) if self._cdr else 0, found)
        return found

    def unpack(self, data: bytes) -> Any:
        """The message of some bytes.

        Raises:
            FormatError: they are too few, or in ROS 1 too many, or a text or a number of values in them is invalid.
        """
        reader = _Reader(data, self._cdr)
        message = self._read(self.kind.name, reader)
        reader.end(self.kind.name)
        return message

    # Packing -----------------------------------------------------------------------------------------------------

    def _fields(self, name: str) -> Sequence[tuple[Field, str | None]]:
        known = self._schema.get(name)
        return (
            known if known is not None else [(field, field.name) for field in message_type_of(self.kind, name).fields]
        )

    def _measure(self, name: str, depth: int) -> tuple[int, int]:
        """How many values a type has wherever it occurs, and how many levels of types are in it.

        Raises:
            FormatError: they are too many, or there is nothing in it, so that a list of any length would take no bytes.
        """
        values, levels = self._measured.get(name, (0, 0))
        if depth + levels > MOST_NESTED:
            raise FormatError(f"{self.kind.name} has types in more than {MOST_NESTED} levels")
        if name in self._measured:
            return values, levels
        for field, _ in self._fields(name):
            plain = field.kind in NUMBERS or field.kind in TIMES or field.kind == "string"
            inner, below = (1, -1) if plain else self._measure(field.kind, depth + 1)
            values, levels = values + (field.size or 1) * inner, max(levels, below + 1)
            if values > MOST_VALUES:
                raise FormatError(f"{self.kind.name} has more than {MOST_VALUES} values")
        if self._schema and not values:
            raise FormatError(f"{name} has no fields")
        self._measured[name] = values, levels
        return values, levels

    def _plan(self, name: str) -> list[Step]:
        """What packs a message of a type: runs of numbers together, and all else one by one."""
        steps: list[Step] = []
        run: _Run = []
        self._collect(name, "", steps, run)
        self._close(run, steps)
        return steps

    def _collect(self, name: str, prefix: str, steps: list[Step], run: _Run) -> None:
        for field, attribute in self._fields(name):
            path = None if attribute is None else prefix + attribute
            if field.kind in NUMBERS and (field.size is None or (field.size and path is not None)):
                run.append((path, NUMBERS[field.kind], field.size))
            elif field.size is None and field.kind in TIMES:
                letter = "i" if self._cdr or field.kind == "duration" else "I"
                run.append((path and f"{path}.secs", letter, None))
                run.append((path and f"{path}.nsecs", "I" if self._cdr else letter, None))
            elif field.size is None and field.kind != "string" and path is not None:
                self._collect(field.kind, f"{path}.", steps, run)
            else:
                self._close(run, steps)
                steps.append(self._step(field, path))

    def _close(self, run: _Run, steps: list[Step]) -> None:
        if run:
            steps.append(_run(list(run), self._cdr))
            run.clear()

    def _step(self, field: Field, path: str | None) -> Step:
        absent = self._absent(field)
        get: Callable[[Any], Any] = attrgetter(path) if path is not None else lambda _: absent
        if field.kind in NUMBERS and field.size is not None:
            return _numbers(get, NUMBERS[field.kind], field.size, self._cdr)
        if field.kind == "string" and field.size is None:
            return _text(get, self._cdr)
        if field.kind == "string":
            return _texts(get, field.size or 0, self._cdr)
        if field.kind in TIMES:
            letter = "i" if self._cdr or field.kind == "duration" else "I"
            time: _Run = [("secs", letter, None), ("nsecs", "I" if self._cdr else letter, None)]
            return _several(get, [_run(time, self._cdr)], field.size or 0, self._cdr, None, None)
        if field.kind not in self._elements:
            self._elements[field.kind] = self._plan(field.kind)
        steps = self._elements[field.kind]
        if field.size is None:  # of a message that the type of ROS 1 does not have
            return lambda _, out: _all(steps, absent, out)
        kind = message_type_of(self.kind, field.kind)
        return _several(get, steps, field.size, self._cdr, self._width(field.kind), kind)

    def _absent(self, field: Field) -> Any:
        """A value for a field that the type of ROS 1 does not have."""
        if field.kind in NUMBERS:
            one: Any = 0
        elif field.kind == "string":
            one = ""
        else:
            one = Stamp() if field.kind in TIMES else message_type_of(self.kind, field.kind)()
        return one if field.size is None else [one] * field.size

    @property
    def width(self) -> int | None:
        """How many float64 numbers a message consists of; None if it has anything else."""
        return self._width(self.kind.name)

    def _width(self, name: str) -> int | None:
        """How many float64 numbers a type consists of; None if it has anything else."""
        if name not in self._widths:
            self._widths[name] = self._counted(name)
        return self._widths[name]

    def _counted(self, name: str) -> int | None:
        total = 0
        known = [field.name for field in message_type_of(self.kind, name).fields]
        if [attribute for _, attribute in self._fields(name)] != known:  # a table has our fields, in our order
            return None
        for field, _ in self._fields(name):
            if field.kind in NUMBERS:
                more: int | None = 1 if field.kind == "float64" and field.size is None else None
            elif field.size is None and field.kind not in (*TIMES, "string"):
                more = self._width(field.kind)
            else:
                more = None
            if more is None:
                return None
            total += more
        return total

    # Places ------------------------------------------------------------------------------------------------------

    def _place(self, name: str, message: Any, path: str, at: int, found: dict[str, tuple[int, str, int]]) -> int:
        """Note the numbers of a message that begins at a place; where it ends."""
        for field, attribute in self._fields(name):
            value = self._absent(field) if attribute is None else getattr(message, attribute)
            known = {} if attribute is None else found
            at = self._place_value(field.kind, field.size, value, f"{path}{field.name}", at, known)
        return at

    def _place_value(
        self, kind: str, size: int | None, value: Any, path: str, at: int, found: dict[str, tuple[int, str, int]]
    ) -> int:
        if size == 0:
            at = self._aligned(at, 4) + 4
        if kind in NUMBERS:
            letter, count = NUMBERS[kind], 1 if size is None else len(value)
            width = struct.calcsize(f"<{letter}")
            at = self._aligned(at, width) if count else at
            found[path] = at, letter, count
            return at + width * count
        if size is not None:
            for number, one in enumerate(value):
                at = self._place_value(kind, None, one, f"{path}.{number}", at, found)
            return at
        if kind in TIMES:
            letter = "i" if self._cdr or kind == "duration" else "I"
            at = self._aligned(at, 4)
            found[f"{path}.secs"], found[f"{path}.nsecs"] = (at, letter, 1), (at + 4, "I" if self._cdr else letter, 1)
            return at + 8
        if kind == "string":
            return self._aligned(at, 4) + len(_encoded.__wrapped__(value, self._cdr))
        return self._place(kind, value, f"{path}.", at, found)

    def _aligned(self, at: int, size: int) -> int:
        return at + -(at - len(CDR_HEADER)) % size if self._cdr else at

    # Unpacking ---------------------------------------------------------------------------------------------------

    def _read(self, name: str, reader: _Reader) -> Any:
        blank = self._blanks.get(name) or self._blank(name)
        reader.take(blank.cost)
        message = blank.kind.blank()
        for field, attribute in blank.fields:
            value = self._value(field, reader)
            if attribute is not None:
                setattr(message, attribute, value)
        for attribute, make in blank.absent:
            setattr(message, attribute, make())
        return message

    def _blank(self, name: str) -> _Blank:
        """How a message of a type is read."""
        kind, fields = message_type_of(self.kind, name), self._fields(name)
        given = {attribute for _, attribute in fields}
        absent = [(attribute, make) for attribute, make in kind.makers if attribute not in given]
        cost = 1 + (codec(kind)._measured[name][0] if absent else 0)
        found = self._blanks[name] = _Blank(kind, fields, absent, cost)
        return found

    def _value(self, field: Field, reader: _Reader) -> Any:
        if field.size is None:
            return self._single(field.kind, reader)
        count = field.size or reader.count()
        if field.kind in NUMBERS:
            return reader.numbers(NUMBERS[field.kind], count)
        reader.expect_items(count, self._least(field.kind))
        return [self._single(field.kind, reader) for _ in range(count)]

    def _least(self, kind: str) -> int:
        """A lower bound for the bytes of a value, so that numbers of values that cannot be are found at once."""
        if kind == "string":
            return 4
        return 8 if kind in TIMES else 1

    def _single(self, kind: str, reader: _Reader) -> Any:
        if kind in NUMBERS:
            return reader.number(NUMBERS[kind])
        if kind == "string":
            return reader.text()
        if kind in TIMES:
            letter = "i" if self._cdr or kind == "duration" else "I"
            return Stamp(reader.number(letter), reader.number("I" if self._cdr else letter))
        return self._read(kind, reader)


# Names of numbers in ROS 2 that differ from those in ROS 1.
_RENAMED = {
    "boolean": "bool",
    "octet": "uint8",
    "char": "uint8",
    "byte": "uint8",
    "float": "float32",
    "double": "float64",
}
_STAMPS = {"builtin_interfaces/Time": "time", "builtin_interfaces/Duration": "duration"}
_SEQUENCE = re.compile(r"sequence<([^<>,]+)(?:, *\d+)?>")
_ARRAY = re.compile(r"(.+)\[(\d{1,9})\]")
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
_KIND = re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*)?", re.ASCII)


def read_schema(
    types: Mapping[str, Mapping[str, str]], kind: MessageType | None = None
) -> dict[str, list[tuple[Field, str | None]]]:
    """The fields of types as a ROS 2 describes them, with the attributes of our messages that they stand for.

    Args:
        types: names of types -> names of fields -> their types, as `get_fields_and_field_types` of rclpy gives them.
        kind: a type of ours that has no name of its own in the table: the request or response of a service.

    Raises:
        FormatError: a name or a type is none, a field that we fill has another type than ours, or they are too many.
    """
    if sum(len(fields) + 1 for fields in types.values()) > MOST_FIELDS:
        raise FormatError(f"there are more than {MOST_FIELDS} fields")
    found: dict[str, list[tuple[Field, str | None]]] = {}
    for name, fields in types.items():
        try:
            own = message_type_of(kind, name) if kind is not None else message_type(name)
            known = {field.name.lower(): field for field in own.fields}
        except NotFoundError:
            known = {}
        found[name] = [_matched(_described(key, text), known.get(key.lower())) for key, text in fields.items()]
    return found


def _matched(given: Field, known: Field | None) -> tuple[Field, str | None]:
    """A field as it is described, and the attribute of our messages for it."""
    if known is None:
        return given, None
    if given.kind != known.kind or (given.size != known.size and (not known.size or given.size != 0)):
        raise FormatError(f"field {given.name!r} is a {_named(given)}; it must be a {_named(known)}")
    return given, known.name


def _named(field: Field) -> str:
    return field.kind if field.size is None else f"{field.kind}[{field.size or ''}]"


def _described(name: str, text: str) -> Field:
    size: int | None = None
    if (sequence := _SEQUENCE.fullmatch(text)) is not None:
        text, size = sequence.group(1), 0
    elif (array := _ARRAY.fullmatch(text)) is not None:
        text, size = array.group(1), int(array.group(2))
    kind = re.sub(r"<\d+>", "", text)  # a string with a bound
    kind = _STAMPS.get(kind, _RENAMED.get(kind, kind))
    if not (_NAME.fullmatch(name) and _KIND.fullmatch(kind)) or kind == "wstring":
        raise FormatError(f"field {name[:100]!r} has type {text[:100]!r}, which is not supported")
    return Field(name, kind, size)


def message_type_of(kind: MessageType, name: str) -> MessageType:
    """A type by its name, that of a service's request or response included."""
    return kind if name == kind.name else message_type(name, kind.ros)


@cache
def codec(kind: MessageType) -> Codec:
    """The codec of a type for ROS 1."""
    return Codec(kind)


class _Blank(NamedTuple):
    """How messages of a type are read.

    Attributes:
        kind: the type.
        fields: those that the data have.
        absent: the others, and what makes their values.
        cost: what one counts among what is read of a message, beside the fields that the data have.
    """

    kind: MessageType
    fields: Sequence[tuple[Field, str | None]]
    absent: list[tuple[str, Callable[[], Any]]]
    cost: int


class _Output(bytearray):
    """The bytes of a message so far.

    Attributes:
        large: where the memory of large arrays belongs, and the memory; its size is a multiple of 8, which no alignment
            depends on.
    """

    large: list[tuple[int, memoryview]]


def _align(out: _Output, size: int) -> None:
    """Pad the bytes of CDR to a multiple of a size, counted from the end of its header."""
    out += bytes(-(len(out) - len(CDR_HEADER)) % size)


def _run(run: _Run, cdr: bool) -> Step:
    """Packs numbers that follow each other: single ones, and arrays of a known size."""
    given = [path for path, _, _ in run if path is not None]
    layouts = [struct.Struct(_layout(run, offset if cdr else None)) for offset in (range(8) if cdr else (0,))]
    get: Any = attrgetter(*given) if given else None
    arrays = [(at, _kind(letter), size) for at, (_, letter, size) in enumerate(run) if size is not None]

    def full(message: Any) -> list[Any]:
        """The values, those of fields that the message does not have included."""
        values = get(message) if given else ()
        known = iter(values if len(given) > 1 else (values,))
        return [next(known) if path is not None else 0 for path, _, _ in run]

    whole = len(given) == len(run)
    several = whole and len(run) > 1  # then the getter returns a tuple of all
    if whole and not arrays and len(run) == 1:

        def one(message: Any, out: _Output) -> None:
            out += layouts[(len(out) - 4) % 8 if cdr else 0].pack(get(message))

        return one
    if whole and not arrays:

        def plain(message: Any, out: _Output) -> None:
            out += layouts[(len(out) - 4) % 8 if cdr else 0].pack(*get(message))

        return plain

    def some(message: Any, out: _Output) -> None:
        values = list(get(message)) if several else full(message)
        for at, kind, size in arrays:
            raw = _raw(values[at], kind)
            if len(raw) != size * kind.itemsize:
                raise ParameterError(f"a field has {len(raw) // kind.itemsize} values; it must have {size}")
            values[at] = raw
        out += layouts[(len(out) - 4) % 8 if cdr else 0].pack(*values)

    return some


def _layout(run: _Run, offset: int | None) -> str:
    """The format of numbers; with an offset, that of CDR from there on."""
    parts, at = ["<"], offset
    for _, letter, count in run:
        size = struct.calcsize(f"<{letter}")
        if at is not None:
            parts.append("x" * (-at % size))
            at += -at % size + size * (1 if count is None else count)
        parts.append(letter if count is None else f"{count * size}s")
    return "".join(parts)


@cache
def _kind(letter: str) -> np.dtype[Any]:
    return np.dtype(letter).newbyteorder("<")


@cache
def _few(letter: str, count: int) -> struct.Struct:
    return struct.Struct(f"<{count}{letter}")


def _raw(values: Any, kind: np.dtype[Any]) -> bytes | memoryview:
    """The bytes of numbers; of a large array, its memory."""
    if isinstance(values, bytes):
        return values if len(values) < LARGE else memoryview(values)
    if type(values) is list and len(values) <= FEW and kind.kind != "b":
        return _few(kind.char, len(values)).pack(*values)
    array = np.asarray(values, kind)
    if array.nbytes >= LARGE and array.flags.c_contiguous:
        return memoryview(array).cast("B")  # type: ignore[arg-type]
    return array.tobytes()


def _numbers(get: Callable[[Any], Any], letter: str, size: int, cdr: bool) -> Step:
    """Packs several numbers: exactly `size`, or any number after their count."""
    kind = _kind(letter)

    def numbers(message: Any, out: _Output) -> None:
        raw = _raw(get(message), kind)
        count = len(raw) // kind.itemsize
        if not size:
            if cdr:
                _align(out, 4)
            out += U32.pack(count)
        elif count != size:
            raise ParameterError(f"a field has {count} values; it must have {size}")
        if cdr and count:
            _align(out, kind.itemsize)
        if isinstance(raw, memoryview) and not len(raw) % 8:
            out.large.append((len(out), raw))
        else:
            out += raw

    return numbers


@lru_cache(4096)
def _encoded(text: str, cdr: bool) -> bytes:
    """A text with its length."""
    raw = text.encode()
    return U32.pack(len(raw) + 1) + raw + b"\0" if cdr else U32.pack(len(raw)) + raw


def _text(get: Callable[[Any], Any], cdr: bool) -> Step:
    """Packs a text."""

    def text(message: Any, out: _Output) -> None:
        if cdr:
            _align(out, 4)
        value = get(message)
        out += _encoded(value, cdr) if len(value) < SHORT else _encoded.__wrapped__(value, cdr)

    return text


def _texts(get: Callable[[Any], Any], size: int, cdr: bool) -> Step:
    """Packs several texts."""

    def texts(message: Any, out: _Output) -> None:
        values = get(message)
        if size and len(values) != size:
            raise ParameterError(f"a field has {len(values)} values; it must have {size}")
        if cdr:
            _align(out, 4)
        if not size:
            out += U32.pack(len(values))
        for value in values:
            if cdr:
                _align(out, 4)
            out += _encoded(value, cdr) if len(value) < SHORT else _encoded.__wrapped__(value, cdr)

    return texts


def _rows(values: NDArray[Any], kind: MessageType | None) -> list[Any]:
    """The messages of a table's rows, whose type a ROS 2 describes otherwise than we do.

    Raises:
        ParameterError: it is no table of them.
    """
    own = codec(kind) if kind is not None else None
    if own is None or values.ndim != 2 or own.width != values.shape[1]:
        raise ParameterError(f"an array of shape {values.shape} is no table of these messages")
    return [own.unpack(row.tobytes()) for row in np.asarray(values, "<f8")]


def _several(
    get: Callable[[Any], Any],
    steps: list[Step],
    size: int,
    cdr: bool,
    width: int | None,
    kind: MessageType | None,
) -> Step:
    """Packs several values, messages of a type of ours if that is given.

    `width` is the number of float64 numbers in each, if it has nothing else.
    """

    def several(message: Any, out: _Output) -> None:
        values = get(message)
        if size and len(values) != size:
            raise ParameterError(f"a field has {len(values)} values; it must have {size}")
        if not size:
            if cdr:
                _align(out, 4)
            out += U32.pack(len(values))
        if isinstance(values, np.ndarray) and (width is None or values.shape != (len(values), width)):
            values = _rows(values, kind)
        if isinstance(values, np.ndarray):
            if cdr and len(values):
                _align(out, 8)
            out += np.asarray(values, "<f8").tobytes()
            return
        for value in values:
            _all(steps, value, out)

    return several


def _all(steps: list[Step], value: Any, out: _Output) -> None:
    for step in steps:
        step(value, out)


class _Reader:
    """Takes values from bytes, none of them beyond their end."""

    def __init__(self, data: bytes, cdr: bool) -> None:
        self._data, self._cdr = data, cdr
        self._at = len(CDR_HEADER) if cdr else 0
        self._items = 0  # of lists so far
        self._taken = 0  # of all that was read
        if cdr and data[:4] != CDR_HEADER:
            raise FormatError(f"the data do not begin as plain little-endian CDR: {data[:4].hex()}")

    def _align(self, size: int) -> None:
        if self._cdr:
            self._at += -(self._at - len(CDR_HEADER)) % size

    def take(self, count: int) -> None:
        """Count what is read.

        Raises:
            FormatError: it is too much, which would take the time of many steps.
        """
        self._taken += count
        if self._taken > MOST_READ:
            raise FormatError(f"it has more than {MOST_READ} values")

    def expect(self, size: int) -> None:
        """Check that this many bytes are left for one more value.

        Raises:
            FormatError: they are not, or the message has too many values.
        """
        self.take(1)
        if size > len(self._data) - self._at:
            raise FormatError(f"the data end after {len(self._data)} bytes; {size} more are needed at {self._at}")

    def expect_items(self, count: int, least: int) -> None:
        """Check that a list of so many items, each of some bytes at least, may follow.

        Raises:
            FormatError: too few bytes are left, or the message has too many items.
        """
        self.expect(count * least)
        self._items += count
        if self._items > MOST_ITEMS:
            raise FormatError(f"its lists have more than {MOST_ITEMS} texts, times and messages")

    def number(self, letter: str) -> Any:
        """One number."""
        layout = _few(letter, 1)
        self._align(layout.size)
        self.expect(layout.size)
        (value,) = layout.unpack_from(self._data, self._at)
        self._at += layout.size
        return value

    def count(self) -> int:
        """The number of values that follow."""
        return int(self.number("I"))

    def numbers(self, letter: str, count: int) -> Any:
        """Several numbers as an array."""
        kind = _kind(letter)
        if count:
            self._align(kind.itemsize)
        self.expect(count * kind.itemsize)
        values = np.frombuffer(self._data, kind, count, self._at)
        self._at += count * kind.itemsize
        return values

    def text(self) -> str:
        """A text."""
        size = self.count()
        self.expect(size)
        raw = self._data[self._at : self._at + size]
        self._at += size
        if self._cdr:
            raw = raw.removesuffix(b"\0")
        try:
            return raw.decode()
        except UnicodeDecodeError as error:
            raise FormatError(f"a text is not in UTF-8: {error.reason} at byte {error.start}") from None

    def end(self, name: str) -> None:
        """Check that all was read; bytes of CDR may be followed by others, as Fast CDR estimates sizes.

        Raises:
            FormatError: more follows.
        """
        if self._at < len(self._data) and not self._cdr:
            raise FormatError(f"{len(self._data) - self._at} bytes follow a {name}")
