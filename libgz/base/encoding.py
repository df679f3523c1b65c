"""Encoding: plain data as the bytes of a state, and back, by msgpack.

msgpack has None, booleans, integers of 64 bits, floats, texts, bytes, lists, and dicts. All else is an extension of it:
a number that says what it is, and bytes that are msgpack again. Equal data are equal bytes; what comes back has the
same types, to the bit.

Bytes are never trusted: decoding them makes values of the kinds below and nothing else, whatever they say; sizes, depth
and counts are checked before memory is taken, and each refusal is a `StateError`.
"""

from __future__ import annotations

import copy
import functools
import math
import random
import re
import struct
import sys
from collections import Counter, deque
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

import msgpack  # type: ignore[import-untyped]
import numpy as np
from numpy.typing import NDArray

from libgz.base.budget import VARIABLE, budget_limit
from libgz.base.errors import USER_ERRORS, ParameterError, StateError, pass_interrupt
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector

__all__ = [
    "DECLARED",
    "FORMAT",
    "ITEMS",
    "SCALARS",
    "TOO_DEEP",
    "Declared",
    "Generated",
    "Items",
    "decode",
    "encode",
    "guarded",
    "made",
    "register",
    "register_raw",
]

VERSION = 9
FORMAT = b"libgz state %d\n" % VERSION  # at the start of encoded data
MOST_ITEMS = 1 << 21  # in all lists and dicts of them
MOST_ALIKE = 100  # keys of one hash in a dict or set
MOST_NESTED = 100  # extensions within each other
MOST_DIMENSIONS = 32
TOO_DEEP = "it is nested too deeply, or contains itself"

Other = Callable[[Any], "tuple[int, Any] | None"]
SCALARS = frozenset({int, float, bool, str, bytes, type(None)})  # which msgpack writes as they are
FLOATS = frozenset({float})

# Numbers of extensions.
TUPLE, SET, FROZEN, DEQUE, INTEGER, COMPLEX, BYTEARRAY, ARRAY, OBJECTS, NUMBER, STRUCT, RAW = range(12)
VALUE, NUMPY, RANDOM, DECLARED, ITEMS = range(12, 17)


class Generated(NamedTuple):
    """What decoding makes of a random generator.

    Attributes:
        numpy: whether it is one of numpy's; else, Python's.
        state: what it returned as its state.
    """

    numpy: bool
    state: Any

    def put(self, generator: Any) -> None:
        """Give a generator of the same kind this state."""
        if self.numpy:
            generator.bit_generator.state = self.state
        else:
            generator.setstate(self.state)

    def make(self) -> Any:
        """A new generator in this state."""
        generator: Any = random.Random()
        if self.numpy:
            generator = np.random.Generator(getattr(np.random, self.state["bit_generator"])())
        self.put(generator)
        return generator


class Declared(NamedTuple):
    """What is written of an object whose class declares its state.

    Attributes:
        name: of the class.
        values: in the order in which the class declares them.
    """

    name: str
    values: list[Any]


class Items(NamedTuple):
    """What is written of a ctypes array."""

    values: list[Any]


class _Kind(NamedTuple):
    """How values of a class are written."""

    base: type
    name: str
    spell: Callable[[Any], Sequence[Any]]


_structs: dict[str, Callable[..., Any]] = {}  # what makes them, by name
_values: list[_Kind] = []  # of which there are subclasses
_makers: dict[str, Callable[..., Any]] = {}  # of these, by name
_raw: dict[type, tuple[bytes, Callable[[Any], bytes | None]]] = {}  # heads, and what makes bytes
_raw_makers: dict[bytes, Callable[[bytes], Any]] = {}  # by these heads


def register(
    kind: type,
    spell: Callable[[Any], Sequence[Any]] | None = None,
    make: Callable[..., Any] | None = None,
    *,
    name: str | None = None,
) -> None:
    """Let the objects of a class be values.

    Args:
        kind: the class; with its subclasses, if `make` is given.
        spell: the parts of an object as plain data; by default, its fields.
        make: makes one of these parts, which may be anything; by default, the fields are set.
        name: in the data; by default, that of the class.
    """
    name = name or kind.__qualname__
    if spell is not None and make is not None:
        _makers[name] = make
        _values.append(_Kind(kind, name, spell))
        return
    fields = getattr(kind, "__match_args__", ()) or tuple(
        slot for base in reversed(kind.__mro__) for slot in vars(base).get("__slots__", ())
    )
    numbers = issubclass(kind, (GzVector, GzQuatern, GzColor))
    _structs[name] = functools.partial(_struct, kind, fields, numbers)
    _PARTS[kind] = lambda value: (STRUCT, [name, *[getattr(value, field) for field in fields]])
    if numbers:
        _register_floats(kind, name, attrgetter(*fields), len(fields), _structs[name])
    elif issubclass(kind, GzPose):
        _register_pose(kind, name)


def register_raw(kind: type, raw: Callable[[Any], bytes | None], make: Callable[[bytes], Any]) -> None:
    """Let the objects of a class be values that are written as their bytes.

    Args:
        kind: the class.
        raw: the bytes of an object; None for one that is to be written as `register` says.
        make: makes an object of bytes, which may be any.
    """
    head = kind.__qualname__.encode() + b"\0"
    _raw[kind] = head, raw
    _raw_makers[head] = make


def _register_floats(
    kind: type, name: str, get: Callable[[Any], tuple[Any, ...]], count: int, make: Callable[..., Any]
) -> None:
    """Let objects that have nothing but floats be written as these: nearly all have."""
    numbers = struct.Struct(f"<{count}d")
    pack = numbers.pack

    def raw(value: Any) -> bytes | None:
        values = get(value)
        return pack(*values) if FLOATS.issuperset(map(type, values)) else None

    register_raw(kind, raw, lambda data: make(*numbers.unpack(data)))


def _register_pose(kind: Any, name: str) -> None:
    place, turn = type(kind().pos), type(kind().rot)  # a layer above has vectors of its own
    axes = (*(f"pos.{axis}" for axis in "xyz"), *(f"rot.{axis}" for axis in "uxyz"))
    get: Callable[[Any], tuple[Any, ...]] = attrgetter(*axes)

    def numbers(pose: Any) -> tuple[Any, ...]:
        return get(pose) if type(pose.pos) is place and type(pose.rot) is turn else (None,)

    def make(*values: float) -> Any:
        parts = _structs[place.__qualname__](*values[:3]), _structs[turn.__qualname__](*values[3:])
        return _structs[name](*parts)

    _register_floats(kind, name, numbers, len(axes), make)


def _struct(kind: Any, fields: tuple[str, ...], numbers: bool, *values: Any) -> Any:
    if len(values) != len(fields) or (numbers and not all(isinstance(value, _NUMBERS) for value in values)):
        raise StateError(f"the state is damaged: these are not the numbers of a {kind.__qualname__}")
    value = kind.__new__(kind)  # a constructor might convert
    for name, part in zip(fields, values, strict=True):
        setattr(value, name, part)
    return value


_NUMBERS = (int, float, np.number, np.bool_)


# To bytes -----------------------------------------------------------------------------------------------------------


def encode(value: Any, other: Other | None = None, *, exact: bool = True) -> bytes:
    """Plain data as bytes.

    Args:
        value: them; what users made must be `guarded`.
        other: of a value that is not plain, DECLARED or ITEMS and the parts of that; None for what it does not know.
        exact: whether all types are to come back; else tuples come back as lists, which takes less time.

    Raises:
        ParameterError: something in them is not plain, they are nested too deeply, or too large.
    """
    idle = _idle[exact]
    encoder = idle.pop() if idle else _Encoder(exact)
    encoder.other = other
    try:
        data = FORMAT + encoder.pack(value)
    except ParameterError:
        raise
    except (RecursionError, ValueError, TypeError) as error:  # msgpack counts levels, too
        deep = not isinstance(error, (TypeError, UnicodeError))
        raise ParameterError(f"a state must be plain data, and {TOO_DEEP if deep else error}") from error
    encoder.other = None
    idle.append(encoder)  # one that failed is dropped: there is something in its buffers
    if len(data) > budget_limit():
        raise ParameterError(f"a state has {_too_large(data)}")
    return data


class _Encoder:
    """Writes values; each kind that msgpack does not have becomes an extension.

    Attributes:
        other: see `encode`.
        pack: a value as msgpack.
    """

    def __init__(self, exact: bool) -> None:
        self.other: Other | None = None
        self._exact = exact
        self.pack = self._packer()
        self._inner: list[Callable[[Any], bytes]] = []  # by depth: none can be used while it works
        self._depth = 0

    def _packer(self) -> Callable[[Any], bytes]:
        packer: Any = msgpack.Packer(default=self._extension, strict_types=self._exact, unicode_errors="surrogatepass")
        pack: Callable[[Any], bytes] = packer.pack
        return pack

    def _extension(self, value: Any) -> Any:
        """What is written of a value that msgpack does not have."""
        kind = type(value)
        if kind in _raw:
            head, raw = _raw[kind]
            data = raw(value)
            if data is not None:
                return _new_extension(msgpack.ExtType, (RAW, head + data))
        code, parts = _PARTS[kind](value) if kind in _PARTS else self._of_other(value)
        if type(parts) is not bytes:
            depth = self._depth
            if depth == len(self._inner):
                if depth >= MOST_NESTED:
                    raise RecursionError
                self._inner.append(self._packer())
            self._depth = depth + 1
            parts = self._inner[depth](parts)
            self._depth = depth
        return _new_extension(msgpack.ExtType, (code, parts))

    def _of_other(self, value: Any) -> tuple[int, Any]:
        """The number of the extension, and the parts, of a value whose class is not known by itself."""
        kind = type(value)
        found = self.other(value) if self.other is not None else None
        if found is not None:
            return found
        if issubclass(kind, np.generic) and _DTYPE.fullmatch(value.dtype.str):
            return NUMBER, [value.dtype.str, value.tobytes()]
        if "numpy.random" in sys.modules and kind is np.random.Generator:
            return NUMPY, value.bit_generator.state
        for known in _values:
            if isinstance(value, known.base):
                return VALUE, [known.name, *known.spell(value)]
        raise ParameterError(
            f"a state must be plain data, and an object of class {kind.__module__}.{kind.__qualname__} is not"
        )


_idle: tuple[list[_Encoder], list[_Encoder]] = [], []  # not exact ones, exact ones
_new_extension: Any = tuple.__new__  # without its checks


def guarded(value: Any) -> Any:
    """Plain data that users made, in which nothing is left that msgpack takes for bytes and that is not.

    Raises:
        ParameterError: something is.
    """
    kind = type(value)
    if kind is bytearray:
        return _Bytes(bytes(value))
    if kind is memoryview:
        raise ParameterError("a state must be plain data, and an object of class builtins.memoryview is not")
    if kind in (list, tuple):
        return value if SCALARS.issuperset(map(type, value)) else kind(map(guarded, value))
    if kind is deque:
        return deque(map(guarded, value), value.maxlen)
    if kind is dict and not SCALARS.issuperset(map(type, value.values())):
        return {key: guarded(item) for key, item in value.items()}
    return value


class _Bytes(NamedTuple):
    """A bytearray."""

    content: bytes


def _parts_of_array(value: NDArray[Any]) -> tuple[int, Any]:
    if value.dtype.kind == "O":
        return OBJECTS, [list(value.shape), guarded(value.reshape(-1).tolist())]
    if _DTYPE.fullmatch(value.dtype.str) is None:
        raise ParameterError(f"a state must be plain data, and a numpy array of {value.dtype} is not")
    return ARRAY, [value.dtype.str, list(value.shape), value.tobytes()]


def _parts_of_set(code: int, value: Any) -> tuple[int, Any]:
    """A set in an order that depends on nothing else."""
    if len(kinds := {*map(type, value)}) == 1 and kinds <= _ORDERED:
        return code, sorted(value)
    return code, sorted(value, key=encode)


def _parts_of_integer(value: int) -> tuple[int, Any]:
    """One of more than 64 bits."""
    return INTEGER, value.to_bytes(value.bit_length() // 8 + 1, "little", signed=True)


_ORDERED = frozenset({int, str, bytes})  # whose values can be put in order
# The number of the extension, and the parts, of a value, by its class.
_PARTS: dict[type, Callable[[Any], tuple[int, Any]]] = {
    tuple: lambda value: (TUPLE, list(value)),
    set: functools.partial(_parts_of_set, SET),
    frozenset: functools.partial(_parts_of_set, FROZEN),
    deque: lambda value: (DEQUE, [value.maxlen, list(value)]),
    int: _parts_of_integer,
    complex: lambda value: (COMPLEX, struct.pack("<2d", value.real, value.imag)),
    _Bytes: lambda value: (BYTEARRAY, value.content),
    np.ndarray: _parts_of_array,
    random.Random: lambda value: (RANDOM, value.getstate()),
    Declared: lambda value: (DECLARED, [value.name, value.values]),
    Generated: lambda value: (NUMPY if value.numpy else RANDOM, value.state),
    Items: lambda value: (ITEMS, value.values),
}

for _kind in (GzVector, GzQuatern, GzColor):
    register(_kind)
register(GzPose)


# From bytes ---------------------------------------------------------------------------------------------------------

# Kinds of arrays that are bytes: no objects, and no records, which may have objects in them.
_DTYPE = re.compile(
    r"[<>|](?:b1|[iu][1248]|f(?:2|4|8|12|16)|c(?:8|16|24|32)|[SU]\d{1,9}|[mM]8(?:\[\d{0,9}[a-zA-Z]{1,7}\])?)"
)
_DAMAGES = (ValueError, TypeError, AttributeError, LookupError, OverflowError, MemoryError, RecursionError)
_LAST_LETTER = 0x10FFFF


def decode(data: bytes) -> Any:
    """The data that `encode` gave these bytes for; objects that declare a state are `Declared`, and so on.

    Raises:
        StateError: they are not such bytes.
    """
    if not data.startswith(FORMAT):
        before = re.match(rb"libgz state (\d{1,9})\n", data)
        if before is not None:
            number = int(before[1])
            raise StateError(f"this state has format {number}; this version of libgz has format {VERSION}")
        raise StateError(f"these {len(data)} bytes are no state of this version of libgz")
    if len(data) > budget_limit():
        raise StateError(f"the state has {_too_large(data)}")
    try:
        return _Decoder().read(memoryview(data)[len(FORMAT) :])
    except StateError:
        raise
    except _DAMAGES as error:
        raise _damaged(str(error) or type(error).__name__) from error
    except USER_ERRORS as error:  # of what makes values of a class
        pass_interrupt(error)
        raise _damaged(str(error)) from error


def _too_large(data: bytes) -> str:
    return f"{len(data) / (1 << 20):.1f} MiB; allowed are {budget_limit() >> 20} MiB, or what {VARIABLE} [MiB] says"


def _check_hashes(keys: Sequence[Any]) -> Sequence[Any]:
    """The keys, if few of them have the same hash: each of these is compared with all before it."""
    if len(keys) > MOST_ALIKE and not {*map(type, keys)} <= _ORDERED - {int}:
        ((_, times),) = Counter(map(hash, keys)).most_common(1)
        if times > MOST_ALIKE:
            raise StateError(f"the state is damaged: {times} keys have the same hash; allowed are {MOST_ALIKE}")
    return keys


def _damaged(what: str) -> StateError:
    return StateError(f"the state is damaged: {what}")


class _Decoder:
    """Reads one encoding, and counts what it has read."""

    def __init__(self) -> None:
        self._items = self._bytes = self._depth = 0
        self._most = budget_limit()
        self._kinds: tuple[Callable[[bytes], Any], ...] = (
            *(self._tuple, self._set, self._frozen, self._deque, self._integer, self._complex, bytearray),
            *(self._array, self._objects, self._number, self._struct, self._raw, self._value),
            *(self._numpy, self._random, self._declared, self._ctypes),
        )

    def read(self, data: Any) -> Any:
        """The value that is encoded."""
        most = min(MOST_ITEMS, len(data))
        return msgpack.unpackb(
            data,
            ext_hook=self._extension,
            list_hook=self._list,
            object_pairs_hook=self._map,
            strict_map_key=False,
            unicode_errors="surrogatepass",
            timestamp=2,  # msgpack's times, which are never written, are numbers
            max_array_len=most,
            max_map_len=most,
        )

    def _list(self, value: Any) -> Any:
        self._items += len(value) + 1
        if self._items > MOST_ITEMS:
            raise StateError(f"the state is damaged: it has more than {MOST_ITEMS} values")
        return value

    def _map(self, pairs: list[tuple[Any, Any]]) -> Any:
        self._list(pairs)
        _check_hashes([key for key, _ in pairs] if len(pairs) > MOST_ALIKE else ())
        return dict(pairs)

    def _extension(self, code: int, data: bytes) -> Any:
        if not 0 <= code < len(self._kinds):
            raise StateError(f"the state is damaged: there are no values of kind {code}")
        self._bytes += len(data)
        self._items += 1
        if self._depth >= MOST_NESTED:
            raise StateError(f"the state is damaged: {TOO_DEEP}")
        if self._bytes > self._most or self._items > MOST_ITEMS:
            raise StateError("the state is damaged: it is too large")
        self._depth += 1
        try:
            return self._kinds[code](data)
        finally:
            self._depth -= 1

    def _many(self, data: bytes, count: int | None = None) -> list[Any]:
        values = self.read(data)
        if type(values) is not list or (count is not None and len(values) != count):
            raise StateError("the state is damaged: a value has not the parts of its kind")
        return values

    def _tuple(self, data: bytes) -> Any:
        return tuple(self._many(data))

    def _set(self, data: bytes) -> Any:
        return set(_check_hashes(self._many(data)))

    def _frozen(self, data: bytes) -> Any:
        return frozenset(_check_hashes(self._many(data)))

    def _deque(self, data: bytes) -> Any:
        most, items = self._many(data, 2)
        if type(items) is not list or not (most is None or (type(most) is int and most >= len(items))):
            raise StateError("the state is damaged: a deque is longer than it may be")
        return deque(items, most)

    @staticmethod
    def _integer(data: bytes) -> Any:
        return int.from_bytes(data, "little", signed=True)

    @staticmethod
    def _complex(data: bytes) -> Any:
        return complex(*struct.unpack("<2d", data))

    def _array(self, data: bytes) -> Any:
        name, shape, content = self._many(data, 3)
        return _array(name, shape, content)

    def _objects(self, data: bytes) -> Any:
        shape, items = self._many(data, 2)
        count = _count(shape)
        if type(items) is not list or len(items) != count:
            raise StateError("the state is damaged: an array has another number of items than its shape")
        array = np.empty(count, object)
        for i, item in enumerate(items):  # numpy would look into those that are sequences
            array[i] = item
        return array.reshape(shape)

    def _number(self, data: bytes) -> Any:
        name, content = self._many(data, 2)
        return _array(name, [1], content)[0]

    def _struct(self, data: bytes) -> Any:
        name, *values = self._many(data)
        return _known(_structs, name)(*values)

    @staticmethod
    def _raw(data: bytes) -> Any:
        end = data.find(b"\0") + 1
        if data[:end] not in _raw_makers:
            raise StateError(f"the state is damaged: there are no values called {data[:40]!r}")
        return _raw_makers[data[:end]](data[end:])

    def _value(self, data: bytes) -> Any:
        name, *values = self._many(data)
        return _known(_makers, name)(*values)

    def _numpy(self, data: bytes) -> Any:
        state = self.read(data)
        if type(state) is not dict or not _is_generator(state):
            raise StateError("the state is damaged: this is no state of a random generator of numpy")
        return Generated(True, state)

    def _random(self, data: bytes) -> Any:
        state = self.read(data)
        if type(state) is not tuple or len(state) != 3 or type(state[2]) not in (float, type(None)):
            raise StateError("the state is damaged: this is no state of a random generator")
        random.Random(0).setstate(state)  # checks the rest
        return Generated(False, state)

    def _declared(self, data: bytes) -> Any:
        name, values = self._many(data, 2)
        if type(name) is not str or type(values) is not list:
            raise StateError("the state is damaged: an object has no name, or no values")
        return Declared(name, values)

    def _ctypes(self, data: bytes) -> Any:
        return Items(self._many(data))


def _known(kinds: dict[str, Callable[..., Any]], name: Any) -> Callable[..., Any]:
    if type(name) is not str or name not in kinds:
        raise StateError(f"the state is damaged: there are no values called {str(name)[:40]!r}")
    return kinds[name]


def _count(shape: Any) -> int:
    """How many items an array of this shape has."""
    whole = type(shape) is list and len(shape) <= MOST_DIMENSIONS
    if not whole or not all(type(size) is int and size >= 0 for size in shape):
        raise StateError("the state is damaged: an array has no such shape")
    return math.prod(shape)


def _array(name: Any, shape: Any, content: Any) -> Any:
    if type(name) is not str or _DTYPE.fullmatch(name) is None or type(content) is not bytes:
        raise StateError(f"the state is damaged: there are no arrays of {str(name)[:40]!r}")
    kind, count = np.dtype(name), _count(shape)
    if count * kind.itemsize != len(content) or count > max(len(content), MOST_ITEMS):
        raise StateError("the state is damaged: an array has another number of bytes than its shape")
    if kind.kind == "b" and content.translate(None, b"\0\1"):
        raise StateError("the state is damaged: a truth value is neither 0 nor 1")
    if kind.kind == "U" and content:
        letters = np.frombuffer(content, kind.byteorder.replace("|", "=") + "u4")
        if letters.max() > _LAST_LETTER:
            raise StateError("the state is damaged: an array of texts has what is no letter")
    if not content:
        return np.zeros(shape, kind)
    return np.frombuffer(content, kind).reshape(shape).copy()


_LARGEST_NUMBER = (1 << 128) - 1


def _is_generator(state: dict[Any, Any]) -> bool:
    """Whether this is a state that one of numpy's generators takes, which check little themselves."""

    def words(value: Any, count: int, kind: str) -> bool:
        return type(value) is np.ndarray and value.dtype == kind and value.shape == (count,)

    def whole(value: Any, most: int) -> bool:
        return type(value) is int and 0 <= value <= most

    name, inner = state.get("bit_generator"), state.get("state")
    if name not in _GENERATORS or type(inner) is not dict or state.keys() != _GENERATORS[name]:
        return False
    if name == "MT19937":
        return inner.keys() == {"key", "pos"} and words(inner["key"], 624, "u4") and whole(inner["pos"], 624)
    if not whole(state["has_uint32"], 1) or not whole(state["uinteger"], 0xFFFFFFFF):
        return False
    if name == "SFC64":
        return inner.keys() == {"state"} and words(inner["state"], 4, "u8")
    if name == "Philox":
        sound = inner.keys() == {"counter", "key"} and words(inner["counter"], 4, "u8") and words(inner["key"], 2, "u8")
        return sound and words(state["buffer"], 4, "u8") and whole(state["buffer_pos"], 4)
    return inner.keys() == {"state", "inc"} and all(whole(number, _LARGEST_NUMBER) for number in inner.values())


_USUAL = {"bit_generator", "state", "has_uint32", "uinteger"}
_GENERATORS: dict[Any, set[str]] = {
    "MT19937": {"bit_generator", "state"},
    "PCG64": _USUAL,
    "PCG64DXSM": _USUAL,
    "SFC64": _USUAL,
    "Philox": _USUAL | {"buffer", "buffer_pos"},
}


def made(value: Any) -> Any:
    """A copy of decoded data, which its owner may change, with new generators where there were some.

    Raises:
        StateError: there was an object that cannot be made anew.
    """
    kind = type(value)
    if kind in SCALARS:
        return value
    if kind in (list, tuple, set, frozenset):
        return kind(value) if SCALARS.issuperset(map(type, value)) else kind(map(made, value))
    if kind is dict:
        return {made(key): made(item) for key, item in value.items()}
    if kind is deque:
        return deque(map(made, value), value.maxlen)
    if kind is Generated:
        return value.make()
    if kind is Declared:
        raise StateError(
            f"there is no object of class {value.name} now, which the state has there; objects that declare a state "
            "are made in Load"
        )
    if kind is Items:
        raise StateError(f"there is no ctypes array of {len(value.values)} numbers now, which the state has there")
    return copy.deepcopy(value)
