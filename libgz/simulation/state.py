"""State: what objects declare as theirs, so that a snapshot of a world can keep and restore it.

A class declares its state by names of attributes::

    class Counter(Model):
        STATE = ("count", "rate")

or by two methods, where names do not suffice; a class may have both::

    def SaveState(self) -> object: ...
    def LoadState(self, state: object) -> None: ...

A name with a dot, such as "clock.sim_time", is that of an attribute of a part that always is there.
An attribute holds plain data (numbers, strings, bytes, None, vectors, poses, numpy and ctypes arrays, and tuples,
lists, dicts and deques of them), a random generator, or an object that declares its own state, alone or in a tuple,
list or dict. What a class inherits is added. `STATE = ()` says that there is nothing to keep.
"""

from __future__ import annotations

import ctypes
import io
import pickle
import random
import sys
from collections import deque
from collections.abc import Callable, Sequence
from functools import wraps
from itertools import chain
from operator import attrgetter
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from libgz.errors import ParameterError
from libgz.geometry import GzColor, GzPose, GzQuatern, GzVector

__all__ = [
    "carry_state",
    "declares",
    "decode",
    "encode",
    "fields",
    "get_rows",
    "get_state",
    "get_values",
    "plain",
    "set_state",
    "set_values",
    "undeclared",
]

C = TypeVar("C", bound=Callable[..., Any])
T = TypeVar("T")

FORMAT = b"libgz state 2\n"  # at the start of encoded states

# What an encoded state may consist of besides the builtin types: decoding one never runs other code.
_ALLOWED = {
    ("builtins", "complex"),
    ("collections", "deque"),
    ("libgz.geometry", "GzColor"),
    ("libgz.ode.types", "ContactRule"),
    ("libgz.geometry", "GzPose"),
    ("libgz.geometry", "GzQuatern"),
    ("libgz.geometry", "GzVector"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    *((f"numpy.{core}.numeric", "_frombuffer") for core in ("core", "_core")),
    *((f"numpy.{core}.multiarray", name) for core in ("core", "_core") for name in ("_reconstruct", "scalar")),
}
_NUMBERS = (np.ndarray, np.generic, np.dtype, complex)
_WRITTEN: set[type] = set()  # classes of values that were found to be plain
_MADE: list[type] = []  # base classes of what allowed functions make
_PLAIN = frozenset({int, float, bool, str, bytes, type(None), complex})
_EXACT = frozenset({int, bool, str, bytes, type(None)})  # whose equal values are the same in every respect
# Written as their class and numbers: that is what their constructors take, and five times as quick as by default.
_STRUCTS: dict[type, Callable[[Any], tuple[Any, ...]]] = {
    **dict.fromkeys((GzVector, GzQuatern, GzColor), tuple),
    GzPose: attrgetter("pos", "rot"),
}


def plain(kind: C, of: type | None = None) -> C:
    """Let the objects of a class be values in states, kept by pickling. A layer above declares its vectors by this.

    Args:
        kind: the class, or a function that makes values, which is safe to call with any arguments.
        of: the base class of what that function makes.
    """
    _ALLOWED.add((kind.__module__, kind.__qualname__))
    if of is not None:
        _MADE.append(of)
    return kind


def _once_a_class(function: Callable[[Any], T]) -> Callable[[Any], T]:
    """Keep what a function returns for a class, as long as the class lives: those of plugins come and end."""
    kept: WeakKeyDictionary[Any, T] = WeakKeyDictionary()

    @wraps(function)
    def kept_of(kind: Any) -> T:
        try:
            return kept[kind]
        except KeyError:
            return kept.setdefault(kind, function(kind))

    return kept_of


@_once_a_class
def _names(kind: Any) -> tuple[str, ...]:
    """The attributes that a class and its bases declare, each once."""
    return tuple(dict.fromkeys(name for base in reversed(kind.__mro__) for name in vars(base).get("STATE", ())))


@_once_a_class
def _reader(kind: Any) -> tuple[Callable[[Any], tuple[Any, ...]], bool]:
    """A function that reads the values of those names of an object, and whether it has a SaveState."""
    names = _names(kind)
    read: Callable[[Any], Any] = attrgetter(*names) if names else lambda _: ()
    one = len(names) == 1
    return (lambda thing: (read(thing),)) if one else read, hasattr(kind, "SaveState")


@_once_a_class
def fields(kind: Any) -> tuple[str, ...]:
    """What the values of an object of a class are called: its attributes; an empty name for what SaveState returns."""
    return (*_names(kind), "") if hasattr(kind, "SaveState") else _names(kind)


@_once_a_class
def _places(kind: Any) -> tuple[tuple[Callable[[Any], Any] | None, str], ...]:
    """For each of those: what finds the part that has it, None for the object itself; and its name there."""
    names = [name.rpartition(".") for name in fields(kind)]
    return tuple((attrgetter(part) if part else None, name) for part, _, name in names)


@_once_a_class
def _is_ours(kind: Any) -> bool:
    return bool(kind.__module__.startswith("libgz."))


@_once_a_class
def declares(kind: Any) -> bool:
    """Whether a class, or one of its bases, declares state."""
    return any("STATE" in vars(base) or "SaveState" in vars(base) for base in kind.__mro__)


@_once_a_class
def undeclared(kind: Any) -> bool:
    """Whether a class is not one of libgz's, and neither it nor another such class that it extends declares state."""
    own = [base for base in kind.__mro__ if base is not object and not base.__module__.startswith("libgz.")]
    return bool(own) and not any("STATE" in vars(base) or "SaveState" in vars(base) for base in own)


def get_values(thing: Any) -> Sequence[Any]:
    """The declared state of an object, for `set_values`: values in the order of `fields`."""
    kind: Any = type(thing)
    read, saves = _reader(kind)
    values: Sequence[Any] = read(thing)
    if not _PLAIN.issuperset(map(type, values)):
        values = [value if type(value) in _PLAIN else _saved(value) for value in values]
    return (*values, thing.SaveState()) if saves else values


def get_rows(kind: Any, things: Sequence[Any]) -> list[Sequence[Any]]:
    """What `get_values` returns of each of these objects, which are all of one class."""
    read, saves = _reader(kind)
    if not saves:
        rows: list[Sequence[Any]] = list(map(read, things))
        if _PLAIN.issuperset(map(type, chain.from_iterable(rows))):
            return rows
    return [get_values(thing) for thing in things]


def set_values(thing: Any, values: Sequence[Any]) -> None:
    """Give an object the values that `get_values` returned of it, or of one that was made in the same way.

    Containers, arrays and generators are changed in place, for others may hold them.
    """
    kind: Any = type(thing)
    if _EXACT.issuperset(map(type, values)) and _is_now(thing, kind, values):
        return
    for place, value in zip(_places(kind), values, strict=True):
        _set(thing, place, value)


def _set(thing: Any, place: tuple[Callable[[Any], Any] | None, str], value: Any) -> None:
    """Give an object one of its values."""
    part, name = place
    if not name:
        thing.LoadState(value)
        return
    holder = thing if part is None else part(thing)
    before = getattr(holder, name, None)
    if type(value) in _EXACT and type(before) is type(value) and before == value:
        return
    after = _loaded(before, value)
    if after is not before:
        setattr(holder, name, after)


def _is_now(thing: Any, kind: Any, values: Sequence[Any]) -> bool:
    """Whether an object has these values, which are of `_EXACT` types."""
    read, saves = _reader(kind)
    try:
        now = () if saves else read(thing)
        return tuple(values) == now and tuple(map(type, values)) == tuple(map(type, now))
    except AttributeError:
        return False


def get_state(thing: Any) -> Any:
    """The declared state of an object by names, for `set_state`."""
    kind: Any = type(thing)
    return dict(zip(fields(kind), get_values(thing), strict=True))


def set_state(thing: Any, state: Any) -> None:
    """Give an object the state that `get_state` returned of it, or of one that was made in the same way."""
    kind: Any = type(thing)
    set_values(thing, [state[name] for name in fields(kind)])


def carry_state(thing: Any, state: Any) -> None:
    """Give an object the state of one of an earlier form of its class: what both declare."""
    kind: Any = type(thing)
    for name, place in zip(fields(kind), _places(kind), strict=True):
        if name in state and (name or hasattr(kind, "LoadState")):
            _set(thing, place, state[name])


def _is_generator(value: object) -> bool:
    """Whether a value is a generator of numpy, which loads them slowly; before that there are none."""
    return "numpy.random" in sys.modules and isinstance(value, np.random.Generator)


def _saved(value: Any) -> Any:
    kind: Any = type(value)
    if kind in _PLAIN:
        return value
    if kind is list or kind is tuple:
        return kind(value) if _PLAIN.issuperset(map(type, value)) else kind(map(_saved, value))
    if kind is dict:
        if _PLAIN.issuperset(map(type, value.values())):
            return value.copy()
        return {key: _saved(item) for key, item in value.items()}
    if isinstance(value, ctypes.Array):
        return value[:]
    if _is_generator(value):
        return value.bit_generator.state
    if isinstance(value, random.Random):
        return value.getstate()
    if not declares(kind):
        return value
    return [*get_values(value)] if _is_ours(kind) else get_state(value)


def _loaded(before: Any, value: Any) -> Any:
    """`value`, put into the object that was there where that can be changed."""
    kind: Any = type(before)
    if kind in _PLAIN:
        return value
    if _is_generator(before):
        before.bit_generator.state = value
    elif isinstance(before, random.Random):
        before.setstate(value)
    elif declares(kind):
        if value is None:
            return None
        (set_values if _is_ours(kind) else set_state)(before, value)
    elif isinstance(before, ctypes.Array):
        before[:] = value
    elif kind is list and type(value) is list:
        before[:] = _matched(before, value)
    elif kind is tuple and type(value) is tuple:
        return _matched(before, value)
    elif kind is dict and type(value) is dict:
        items = {key: _loaded(before.get(key), item) for key, item in value.items()}
        before.clear()
        before.update(items)
    elif kind is deque:
        kept = tuple(value)
        before.clear()
        before.extend(kept)
    elif kind is np.ndarray and before.shape == np.shape(value) and before.flags.writeable:
        before[...] = value
    else:
        return value
    return before


def _matched(before: Any, value: Any) -> Any:
    if _PLAIN.issuperset(map(type, before)):
        return value
    rest = [None] * (len(value) - len(before))
    return type(value)(_loaded(old, new) for old, new in zip([*before, *rest], value, strict=False))


# As bytes -----------------------------------------------------------------------------------------------------------


def encode(state: Any) -> bytes:
    """A state as bytes: equal states give equal bytes.

    Raises:
        ParameterError: something in it is not plain data.
    """
    buffer = io.BytesIO()
    buffer.write(FORMAT)
    pickler = _Writer(buffer, 5)
    pickler.fast = True  # no references within the data, which would depend on which objects are identical
    try:
        pickler.dump(state)
    except (pickle.PicklingError, TypeError, AttributeError, RecursionError) as error:
        raise ParameterError(f"a state must be plain data: {error}") from error
    return buffer.getvalue()


class _Writer(pickle.Pickler):
    """Writes plain data, and nothing else."""

    def reducer_override(self, thing: Any) -> Any:
        """Refuse what is not plain data; called for everything that is not of a simple builtin type."""
        kind: Any = type(thing)
        if kind in _STRUCTS:
            return kind, _STRUCTS[kind](thing)
        if kind in _WRITTEN or isinstance(thing, (*_NUMBERS, *_MADE)):
            return NotImplemented
        itself = hasattr(thing, "__qualname__")  # classes and functions stand for themselves
        named = thing if itself else kind
        if (named.__module__, named.__qualname__) not in _ALLOWED:
            raise pickle.PicklingError(f"{thing!r} is none")
        if not itself:
            _WRITTEN.add(kind)
        return NotImplemented


class _Reader(pickle.Unpickler):
    """Reads plain data, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) not in _ALLOWED:
            raise ParameterError(f"a state must be plain data; this one has a {module}.{name}")
        return super().find_class(module, name)


def decode(data: bytes) -> Any:
    """The state that `encode` gave these bytes for.

    Raises:
        ParameterError: they are not such bytes.
    """
    if not data.startswith(FORMAT):
        raise ParameterError(f"these {len(data)} bytes are no state of this version of libgz")
    try:
        return _Reader(io.BytesIO(data[len(FORMAT) :])).load()
    except (pickle.UnpicklingError, EOFError, ValueError, TypeError, AttributeError, IndexError, KeyError) as error:
        raise ParameterError(f"the state is damaged: {error}") from error
