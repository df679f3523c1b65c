"""State: what objects declare as theirs, so that a snapshot of a world can keep and restore it.

A class declares its state by names of attributes::

    class Counter(Model):
        STATE = ("count", "rate")

or by two methods, where names do not suffice; a class may have both::

    def SaveState(self) -> object: ...
    def LoadState(self, state: object) -> None: ...

A name with a dot, such as "clock.sim_time", is that of an attribute of a part that always is there.
An attribute holds plain data (numbers, strings, bytes, None, vectors, poses, numpy and ctypes arrays, and tuples,
lists, dicts, sets and deques of them), a random generator, or an object that declares its own state, alone or in one
of these. What a class inherits is added. `STATE = ()` says that there is nothing to keep.
"""

from __future__ import annotations

import ctypes
import random
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable, Sequence
from itertools import chain, zip_longest
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base import encoding
from libgz.base.encoding import DECLARED, ITEMS, SCALARS, TOO_DEEP, Declared, Generated, Items, decode, guarded, made
from libgz.base.errors import GazeboError, ParameterError, StateError

__all__ = [
    "Reader",
    "carry_state",
    "check",
    "declares",
    "decode",
    "encode",
    "fields",
    "get_state",
    "get_values",
    "reader",
    "restoring",
    "set_state",
    "set_values",
    "undeclared",
]
E = TypeVar("E", bound=GazeboError)
_EXACT = frozenset({int, bool, str, bytes, type(None)})  # whose equal values are the same in every respect


class Reader:
    """Reads and sets what a class declares.

    Args:
        names: of attributes.
        saves: whether SaveState and LoadState belong to it.
        ours: whether the class is one of libgz's.

    Attributes:
        fields: what the values are called: the names; an empty one for what SaveState returns.
        ours: whether the class is one of libgz's.
    """

    __slots__ = ("_read", "fields", "ours", "places", "saves")

    def __init__(self, names: Sequence[str], saves: bool, ours: bool) -> None:
        read: Callable[[Any], Any] = attrgetter(*names) if names else lambda _: ()
        self._read: Callable[[Any], tuple[Any, ...]] = (lambda thing: (read(thing),)) if len(names) == 1 else read
        self.ours = ours
        self.saves = saves
        self.fields = (*names, "") if saves else tuple(names)
        parts = [name.rpartition(".") for name in self.fields]
        self.places = tuple((attrgetter(part) if part else None, name) for part, _, name in parts)

    def get(self, thing: Any) -> list[Any]:
        """The values of an object, in the order of `fields`."""
        values = [*self._read(thing), thing.SaveState()] if self.saves else [*self._read(thing)]
        return values if self.ours or SCALARS.issuperset(map(type, values)) else [*map(guarded, values)]

    def set(self, thing: Any, values: Sequence[Any]) -> None:
        """Give an object the decoded values that `get` returned of it, or of one that was made in the same way.

        Raises:
            StateError: they do not fit it.
        """
        if type(values) is not list or len(values) != len(self.fields):
            raise StateError(f"the state is damaged: it has not the values of a {type(thing).__name__}")
        try:
            present: Sequence[Any] = self._read(thing)
        except AttributeError:
            present = ()
        same = 0  # how many at the front need no change; to set one of them may change what is behind it
        for value, before in zip(values, present, strict=False):
            if value is not before:
                kind = type(value)
                if type(before) is not kind or (kind not in _EXACT and kind is not float) or before != value:
                    break
                if kind is float and value == 0.0 and str(before) != str(value):  # zeros have signs
                    break
            same += 1
        for place, value in zip(self.places[same:], values[same:], strict=True):
            try:
                _set(thing, place, value, self.ours)
            except StateError as error:
                raise _of_attribute(StateError, place[1], error) from error
            except RecursionError as error:
                raise _of_attribute(StateError, place[1], TOO_DEEP) from error


def _of_attribute(kind: type[E], name: str, error: object) -> E:
    """An error about an attribute, or about what SaveState returned."""
    return kind(f"{f'its attribute {name!r}' if name else 'what SaveState returned'}: {error}")


def check(thing: Any) -> None:
    """Find out which attribute of an object keeps its state from being encoded.

    Raises:
        ParameterError: there is one, which is named.
    """
    for name in fields(type(thing)):
        try:
            encode(Reader([name] if name else [], not name, False).get(thing))
        except (ParameterError, RecursionError) as error:
            raise _of_attribute(
                ParameterError, name, TOO_DEEP if isinstance(error, RecursionError) else error
            ) from error


class _Class:
    """What a class declares.

    Attributes:
        reader: reads all attributes that the class and its bases declare, and what SaveState returns.
        declares: whether the class, or one of its bases, declares state.
        shared: whether users may have one object of it in two places, and it can be changed in place.
        undeclared: whether neither it nor a base declares any, those of libgz left aside; never of a class of libgz.
    """

    __slots__ = ("_alive", "declares", "reader", "shared", "undeclared")

    def __init__(self, kind: Any) -> None:
        bases = kind.__mro__
        own = [base for base in bases if base is not object and not base.__module__.startswith("libgz.")]
        names = tuple(dict.fromkeys(name for base in reversed(bases) for name in vars(base).get("STATE", ())))
        ours = kind.__module__.startswith("libgz.")
        self.reader = Reader(names, hasattr(kind, "SaveState"), ours)
        self.declares = any(map(_declares_itself, bases))
        self.undeclared = bool(own) and not any(map(_declares_itself, own))
        self.shared = kind in _CHANGED or (self.declares and not ours)
        identity = id(kind)
        self._alive = weakref.ref(kind, lambda _: _classes.pop(identity, None))  # those of plugins come and end


_CHANGED = frozenset({list, dict, deque, set, np.ndarray})  # in place
_classes: dict[int, _Class] = {}  # by the classes' ids, for a dictionary of weak keys takes ten times as long


def _class(kind: Any) -> _Class:
    return _classes.get(id(kind)) or _classes.setdefault(id(kind), _Class(kind))


def _declares_itself(kind: Any) -> bool:
    return "STATE" in vars(kind) or "SaveState" in vars(kind)


def fields(kind: Any) -> tuple[str, ...]:
    """What the values of an object of a class are called: its attributes; an empty name for what SaveState returns."""
    return _class(kind).reader.fields


def declares(kind: Any) -> bool:
    """Whether a class, or one of its bases, declares state."""
    return _class(kind).declares


def undeclared(kind: Any) -> bool:
    """Whether a class is not one of libgz's, and neither it nor another such class that it extends declares state."""
    return _class(kind).undeclared


def reader(kind: Any) -> Reader:
    """What reads all that a class declares."""
    return (_classes.get(id(kind)) or _class(kind)).reader


def get_values(thing: Any) -> list[Any]:
    """The declared state of an object, for `set_values`: values in the order of `fields`."""
    return reader(type(thing)).get(thing)


def set_values(thing: Any, values: Sequence[Any]) -> None:
    """Give an object the decoded values that `get_values` returned of it, or of one that was made in the same way.

    Containers, arrays and generators are changed in place, for others may hold them.
    """
    reader(type(thing)).set(thing, values)


def _set(thing: Any, place: tuple[Callable[[Any], Any] | None, str], value: Any, ours: bool = False) -> None:
    """Give an object, perhaps of a class of libgz, one of its values."""
    part, name = place
    if not name:
        thing.LoadState(made(value))
        return
    holder = thing if part is None else part(thing)
    before = getattr(holder, name, None)
    kind = type(value)
    if kind in _EXACT and type(before) is kind and before == value:
        return
    if ours:
        _require_objects(before, value)
    after = value if kind in SCALARS and type(before) in SCALARS else _loaded(before, value)
    if after is not before:
        setattr(holder, name, after)


def _require_objects(before: Any, value: Any) -> None:
    """Check that a value has objects and ctypes arrays where there are some, also in containers: Load makes them."""
    kind = type(before)
    if kind in SCALARS or type(value) is Declared:
        return
    if _class(kind).declares or (issubclass(kind, ctypes.Array) and type(value) is not Items):
        raise StateError(f"the state is damaged: it has something else in place of a {kind.__name__}")
    if kind is dict:
        for key, item in before.items():
            _require_objects(item, value.get(key) if type(value) is dict else None)
    elif kind in (list, tuple, deque) and not SCALARS.issuperset(map(type, before)):
        for item, other in zip_longest(before, value if type(value) is kind else ()):
            _require_objects(item, other)


def get_state(thing: Any) -> dict[str, Any]:
    """The declared state of an object by names, for `set_state`."""
    return dict(zip(fields(type(thing)), get_values(thing), strict=True))


def set_state(thing: Any, state: Any) -> None:
    """Give an object the decoded state that `get_state` returned of it, or of one that was made in the same way."""
    try:
        values = [state[name] for name in fields(type(thing))]
    except (TypeError, LookupError) as error:
        raise StateError(f"the state is damaged: it has not the values of a {type(thing).__name__}") from error
    set_values(thing, values)


def carry_state(thing: Any, state: Any) -> None:
    """Give an object the decoded state of one of an earlier form of its class: what both declare."""
    kind: Any = type(thing)
    for name, place in zip(fields(kind), reader(kind).places, strict=True):
        if name in state and (name or hasattr(kind, "LoadState")):
            _set(thing, place, state[name])


# Values -------------------------------------------------------------------------------------------------------------


def encode(value: Any) -> bytes:
    """Plain data, and objects that declare a state, as bytes: equal ones give equal bytes.

    Raises:
        ParameterError: something in them is neither.
    """
    return encoding.encode(value, _declared)


def _declared(value: Any) -> tuple[int, Any] | None:
    """What is written of an object that declares its state, and of a ctypes array; None for others."""
    kind: Any = type(value)
    declared = _classes.get(id(kind)) or _class(kind)
    if declared.declares:
        return DECLARED, [kind.__qualname__, declared.reader.get(value)]
    return (ITEMS, value[:]) if issubclass(kind, ctypes.Array) else None


_restoring = threading.local()


def restoring(on: bool) -> None:
    """What this thread sets from now on is of one state, until that ends: no object takes two values of it."""
    _restoring.loaded = {} if on else None


def _is_taken(before: Any, value: Any) -> bool:
    """Whether an object has taken another value of the state already."""
    loaded: dict[int, tuple[Any, Any]] | None = getattr(_restoring, "loaded", None)
    if loaded is None:
        return False
    _, first = loaded.setdefault(id(before), (before, value))
    return first is not value and encode(first) != encode(value)


def _loaded(before: Any, value: Any) -> Any:
    """`value`, put into the object that was there where that can be changed."""
    kind: Any = type(before)
    if kind in SCALARS:
        return made(value)
    declared = _classes.get(id(kind)) or _class(kind)
    if declared.shared and _is_taken(before, value):
        return made(value)
    load = _LOAD.get(kind)
    if load is not None:
        return load(before, value) if type(value) is kind else made(value)
    if type(value) is Declared and declared.declares and value.name == kind.__qualname__:
        declared.reader.set(before, value.values)
        return before
    if type(value) is Items and issubclass(kind, ctypes.Array):
        if len(value.values) != len(before):
            raise StateError(f"there is a ctypes array of {len(before)} numbers now, which the state has not there")
        before[:] = made(value.values)
        return before
    if type(value) is Generated and _puts(before, value):
        return before
    return made(value)


def _puts(before: Any, value: Generated) -> bool:
    """Put the state of a generator into the one that was there, if that is of the same kind."""
    if not value.numpy:
        same = isinstance(before, random.Random)
    elif "numpy.random" in sys.modules and isinstance(before, np.random.Generator):
        same = before.bit_generator.state["bit_generator"] == value.state["bit_generator"]
    else:
        same = False
    if same:
        value.put(before)
    return same


def _load_list(before: list[Any], value: list[Any]) -> Any:
    before[:] = made(value) if SCALARS.issuperset(map(type, before)) else _each_loaded(before, value)
    return before


def _load_tuple(before: tuple[Any, ...], value: tuple[Any, ...]) -> Any:
    return made(value) if SCALARS.issuperset(map(type, before)) else tuple(_each_loaded(before, value))


def _each_loaded(before: Sequence[Any], value: Sequence[Any]) -> list[Any]:
    """The values, put into those that were there; where there are more, into nothing."""
    there = [*before, *[None] * (len(value) - len(before))]
    return [*map(_loaded, there, value)]


def _load_dict(before: dict[Any, Any], value: dict[Any, Any]) -> Any:
    if not SCALARS.issuperset(map(type, chain(before.values(), value, value.values()))):
        keys = [*map(made, value)]
        items = [*map(_loaded, map(before.get, keys), value.values())]
        value = dict(zip(keys, items, strict=True))
    before.clear()
    before.update(value)
    return before


def _load_set(before: set[Any], value: set[Any]) -> Any:
    items = made(value)
    before.clear()
    before.update(items)
    return before


def _load_deque(before: deque[Any], value: deque[Any]) -> Any:
    if value.maxlen != before.maxlen:
        return made(value)
    items = _each_loaded(before, value)
    before.clear()
    before.extend(items)
    return before


def _load_array(before: NDArray[Any], value: NDArray[Any]) -> Any:
    if (before.shape, before.dtype.str) != (value.shape, value.dtype.str) or not before.flags.writeable:
        return made(value)
    before[...] = value
    return before


# How values are put into what is there, by its class, where both are of it.
_LOAD: dict[Any, Callable[[Any, Any], Any]] = {
    list: _load_list,
    tuple: _load_tuple,
    dict: _load_dict,
    set: _load_set,
    deque: _load_deque,
    np.ndarray: _load_array,
}
