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
import functools
import io
import marshal
import pickle
import random
import struct
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable, Sequence
from itertools import chain
from operator import attrgetter
from types import BuiltinFunctionType, FunctionType
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError, StateError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.physics.edits import Edits

__all__ = [
    "Encoder",
    "Kept",
    "Noted",
    "Reader",
    "carry_state",
    "changes",
    "check",
    "declares",
    "decode",
    "encode",
    "equal",
    "fields",
    "get_state",
    "get_values",
    "large",
    "plain",
    "readers",
    "restoring",
    "runs_code",
    "seldom",
    "set_state",
    "set_values",
    "undeclared",
    "whole",
]

C = TypeVar("C", bound=Callable[..., Any])
E = TypeVar("E", bound=GazeboError)

FORMAT = (
    b"libgz state 7\n"  # at the start of encoded states; the number and sizes of the large blocks at the end follow
)
LARGE = 16384  # [byte]; below that, two copies take less time than a block of its own
_COUNT = struct.Struct("<q")
_NO_BLOCKS = FORMAT + _COUNT.pack(0)
_DAMAGES = (
    *(pickle.UnpicklingError, struct.error, EOFError, ValueError, TypeError, AttributeError, IndexError, KeyError),
)

TOO_DEEP = "it is nested too deeply, or contains itself"

# What an encoded state may consist of besides the builtin types: decoding one never runs other code.
_ALLOWED = {
    ("builtins", "complex"),
    ("collections", "deque"),
    ("libgz.base.geometry", "GzColor"),
    ("libgz.ode.types", "ContactRule"),
    ("libgz.base.geometry", "GzPose"),
    ("libgz.base.geometry", "GzQuatern"),
    ("libgz.base.geometry", "GzVector"),
    ("libgz.simulation.state", "made"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    *((f"numpy.{core}.multiarray", name) for core in ("core", "_core") for name in ("_reconstruct", "scalar")),
}
_ARRAYS = "biufc?SUmM"  # kinds of arrays that are written as their bytes
_WITHOUT_BUFFER = "mM"  # of them those of which Python can see the bytes only as those of integers
_NUMBERS = (np.ndarray, np.generic, np.dtype, complex)
_WRITTEN: set[type] = set()  # classes of values that were found to be plain
_MADE: list[type] = []  # base classes of what allowed functions make
_PCG_PARTS = 4  # of what numpy returns as the state of its usual generator
_PLAIN = frozenset({int, float, bool, str, bytes, type(None), complex})
_EXACT = frozenset({int, bool, str, bytes, type(None)})  # whose equal values are the same in every respect
_COMPARED = _EXACT | {float}
_ORDERED = frozenset({int, str, bytes})  # whose values can be put in order


def _array(data: Any, kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    return np.frombuffer(data, kind).reshape(shape).copy()


def _save_array(value: NDArray[Any]) -> Any:
    """An array of numbers as its bytes; others as they are."""
    if value.dtype.kind not in _ARRAYS:
        return value
    if value.nbytes < LARGE:
        return _ARRAY, value.tobytes(), value.dtype.str, value.shape
    whole: Any = np.ascontiguousarray(value)
    whole = whole.view("i8") if value.dtype.kind in _WITHOUT_BUFFER else whole
    return _ARRAY, pickle.PickleBuffer(whole), value.dtype.str, value.shape


def large(data: bytes) -> Any:
    """Bytes for a state; many of them are written behind the rest, which saves copies, and read as a memoryview."""
    return data if len(data) < LARGE else pickle.PickleBuffer(data)


# Structs are tuples in a state: a mark with the name of their class, and their numbers. That takes a tenth of the time
# of pickling them. A tuple of users that begins with such a mark is put behind another one.
_MARK = "\0"
_TUPLE = "\0tuple"
_ARRAY = "\0array"
_SET = "\0set"
_FROZEN = "\0frozenset"
_DICT = "\0dict"  # whose keys are more than numbers and texts
_ITEMS = "\0items"  # of a ctypes array
_GENERATOR = "\0generator"  # of numpy
_RANDOM = "\0random"
_OBJECT = "\0object"  # the name of its class follows, and what it declares


def _new_set(*items: Any) -> set[Any]:
    return set(map(_made, items))


def _new_frozen_set(*items: Any) -> frozenset[Any]:
    return frozenset(map(_made, items))


def _new_dict(*items: Any) -> dict[Any, Any]:
    return {_made(key): _made(item) for key, item in zip(items[::2], items[1::2], strict=True)}


def _new_generator(state: Any) -> np.random.Generator:
    if isinstance(state, tuple):
        return _load_pcg(np.random.Generator(np.random.PCG64()), state)
    name = state["bit_generator"]
    if name not in _BIT_GENERATORS:
        raise StateError(f"the state is damaged: there is no random generator {name!r}")
    generator = np.random.Generator(getattr(np.random, name)())
    generator.bit_generator.state = state
    return generator


def _new_random(*state: Any) -> random.Random:
    generator = random.Random()
    generator.setstate(state)
    return generator


def _absent_object(name: str, *_values: Any) -> Any:
    raise StateError(
        f"there is no object of class {name} now, which the state has there; objects that declare a state are "
        "made in Load"
    )


def _absent_items(*items: Any) -> Any:
    raise StateError(f"there is no ctypes array of {len(items)} numbers now, which the state has there")


_BIT_GENERATORS = ("MT19937", "PCG64", "PCG64DXSM", "Philox", "SFC64")
_makers: dict[str, Callable[..., Any]] = {  # by those marks
    _ARRAY: _array,
    _SET: _new_set,
    _FROZEN: _new_frozen_set,
    _DICT: _new_dict,
    _ITEMS: _absent_items,
    _GENERATOR: _new_generator,
    _RANDOM: _new_random,
    _OBJECT: _absent_object,
}
_NUMBERS_OF_POSE = 7


def _add_struct(kind: Any) -> None:
    mark = _MARK + kind.__qualname__
    if issubclass(kind, GzPose):
        parts: tuple[Any, Any] = (GzVector, GzQuatern)
        if kind is not GzPose:  # a layer above has vectors of its own
            parts = (type(kind().pos), type(kind().rot))
        _makers[mark] = functools.partial(_pose, kind, *parts)
        _STRUCTS[kind] = functools.partial(_pose_parts, mark, parts)
    else:
        get: Callable[[Any], tuple[Any, ...]] = attrgetter(*kind.__match_args__)
        _makers[mark] = functools.partial(_struct, kind)
        _STRUCTS[kind] = lambda thing: (mark, *get(thing))


def _struct(kind: Any, *values: Any) -> Any:
    made = kind.__new__(kind)  # a constructor might convert
    for name, value in zip(kind.__match_args__, values, strict=True):
        setattr(made, name, value)
    return made


def _pose(kind: Any, place: Any, turn: Any, *numbers: Any) -> Any:
    if len(numbers) == _NUMBERS_OF_POSE:
        return _struct(kind, _struct(place, *numbers[:3]), _struct(turn, *numbers[3:]))
    return _struct(kind, *map(_made, numbers))


_pose_numbers = attrgetter("pos.x", "pos.y", "pos.z", "rot.u", "rot.x", "rot.y", "rot.z")


def _pose_parts(mark: str, parts: tuple[Any, Any], thing: Any) -> tuple[Any, ...]:
    if (type(thing.pos), type(thing.rot)) == parts:
        return mark, *_pose_numbers(thing)
    return mark, _saved(thing.pos), _saved(thing.rot)


_STRUCTS: dict[type, Callable[[Any], tuple[Any, ...]]] = {}  # by their classes


def plain(kind: C, of: type | None = None) -> C:
    """Let the objects of a class be values in states, kept by pickling. A layer above declares its vectors by this.

    Args:
        kind: the class, or a function that makes values, which is safe to call with any arguments.
        of: the base class of what that function makes.
    """
    _ALLOWED.add((kind.__module__, kind.__qualname__))
    if isinstance(kind, type) and issubclass(kind, (GzVector, GzQuatern, GzColor, GzPose)):
        _add_struct(kind)
    if of is not None:
        _MADE.append(of)
    return kind


changes = Edits()  # of `Seldom` attributes, in all worlds


class Seldom:
    """An attribute whose assignments are counted: what seldom changes is read again only after that.

    It holds what cannot be changed in place.
    """

    def __set_name__(self, _owner: type, name: str) -> None:
        self._name = name

    def __set__(self, thing: Any, value: Any) -> None:  # without a __get__, reading costs nothing more
        kept, name = vars(thing), self._name
        # A list that is set again may have been changed in place.
        if type(value) not in _PLAIN or name not in kept or kept[name] is not value:
            kept[name] = value
            changes.count()


def seldom() -> Any:
    """A `Seldom` attribute, which has the type of what it holds."""
    return Seldom()


class Noted:
    """Base of what seldom changes as a whole: all assignments of its attributes are counted.

    Whoever changes in place what one of them holds calls `noted.count`. What SaveState returns is read each time, and
    so is what a class with SELDOM does not name there.
    """

    noted: ClassVar[Edits] = Edits()

    def __setattr__(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)
        Noted.noted.count()


def _saved_by_ours(thing: Any) -> Any:
    return thing.SaveState()


def _saved_by_users(thing: Any) -> Any:
    return _in_order(thing.SaveState())


class Reader:
    """Reads and sets some of what a class declares.

    Args:
        names: of attributes.
        saves: whether SaveState and LoadState belong to it.
        ours: whether the class is one of libgz's.
    """

    __slots__ = ("_read", "_save", "fields", "places", "saves")

    def __init__(self, names: Sequence[str], saves: bool, ours: bool) -> None:
        self._save = _saved_by_ours if ours else _saved_by_users
        read: Callable[[Any], Any] = attrgetter(*names) if names else lambda _: ()
        self._read: Callable[[Any], tuple[Any, ...]] = (lambda thing: (read(thing),)) if len(names) == 1 else read
        self.saves = saves
        self.fields = (*names, "") if saves else tuple(names)
        parts = [name.rpartition(".") for name in self.fields]
        self.places = tuple((attrgetter(part) if part else None, name) for part, _, name in parts)

    def get(self, thing: Any) -> Sequence[Any]:
        """The values of an object as plain data, in the order of `fields`."""
        values: Sequence[Any] = self._read(thing)
        if not _PLAIN.issuperset(map(type, values)):
            values = [value if type(value) in _PLAIN else _saved(value) for value in values]
        return (*values, self._save(thing)) if self.saves else values

    def rows(self, things: Sequence[Any]) -> list[Sequence[Any]]:
        """What `get` returns of each of these objects."""
        if self.saves:
            return [*map(self.get, things)]
        rows: list[Sequence[Any]] = [*map(self._read, things)]
        if _PLAIN.issuperset(map(type, chain.from_iterable(rows))):
            return rows
        return [[value if type(value) in _PLAIN else _saved(value) for value in row] for row in rows]

    def set(self, thing: Any, values: Sequence[Any]) -> None:
        """Give an object the values that `get` returned of it, or of one that was made in the same way."""
        try:
            present: Sequence[Any] = self._read(thing)
        except AttributeError:
            present = ()
        same = 0  # how many at the front need no change; to set one of them may change what is behind it
        for value, before in zip(values, present, strict=False):
            if value is not before:
                kind = type(value)
                if kind not in _COMPARED or type(before) is not kind or before != value:
                    break
                if kind is float and value == 0.0 and str(before) != str(value):  # zeros have signs
                    break
            same += 1
        for place, value in zip(self.places[same:], values[same:], strict=True):
            try:
                _set(thing, place, value)
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
    whole = _class(type(thing)).whole
    for name in whole.fields:
        reader = Reader([name] if name else [], not name, False)
        try:
            encode(reader.get(thing))
        except (ParameterError, RecursionError) as error:
            raise _of_attribute(
                ParameterError, name, TOO_DEEP if isinstance(error, RecursionError) else error
            ) from error


class _Class:
    """What a class declares, and how its objects become plain data and take it again.

    Attributes:
        whole: reads all attributes that the class and its bases declare, and what SaveState returns.
        seldom, often: read those of them that are in the class's SELDOM, and all others.
        declares: whether the class, or one of its bases, declares state.
        shared: whether users may have one object of it in two places, and it can be changed in place.
        runs_code: whether it is a class of users whose LoadState, or a setter, runs when its state is set.
        undeclared: whether neither it nor a base declares any, those of libgz left aside; never of a class of libgz.
        ours: whether it is one of libgz's, whose states need no names.
        save: makes plain data of an object.
        load: puts plain data into an object; returns it, or what takes its place.
    """

    __slots__ = (
        *(
            "_alive",
            "declares",
            "load",
            "often",
            "ours",
            "runs_code",
            "save",
            "seldom",
            "shared",
            "undeclared",
            "whole",
        ),
    )

    def __init__(self, kind: Any) -> None:
        bases = kind.__mro__
        own = [base for base in bases if base is not object and not base.__module__.startswith("libgz.")]
        names = tuple(dict.fromkeys(name for base in reversed(bases) for name in vars(base).get("STATE", ())))
        saves = hasattr(kind, "SaveState")
        seldom = getattr(kind, "SELDOM", names if issubclass(kind, Noted) else ())
        ours = kind.__module__.startswith("libgz.")
        self.whole = Reader(names, saves, ours)
        self.seldom = Reader([name for name in names if name in seldom], False, ours)
        self.often = Reader([name for name in names if name not in seldom], saves, ours)
        self.declares = any(map(_declares_itself, bases))
        self.undeclared = bool(own) and not any(map(_declares_itself, own))
        self.ours = ours
        setters = (getattr(kind, name.partition(".")[0], None) for name in names)
        self.runs_code = not ours and (saves or any(isinstance(one, property) for one in setters))
        self.shared = kind in _CHANGED or (self.declares and not self.ours)
        self.save, self.load = _forms(kind, self)
        identity = id(kind)
        self._alive = weakref.ref(kind, lambda _: _classes.pop(identity, None))  # those of plugins come and end


_classes: dict[int, _Class] = {}  # by the classes' ids, for a dictionary of weak keys takes ten times as long


def _class(kind: Any) -> _Class:
    return _classes.get(id(kind)) or _classes.setdefault(id(kind), _Class(kind))


def _declares_itself(kind: Any) -> bool:
    return "STATE" in vars(kind) or "SaveState" in vars(kind)


def fields(kind: Any) -> tuple[str, ...]:
    """What the values of an object of a class are called: its attributes; an empty name for what SaveState returns."""
    return _class(kind).whole.fields


def declares(kind: Any) -> bool:
    """Whether a class, or one of its bases, declares state."""
    return _class(kind).declares


def undeclared(kind: Any) -> bool:
    """Whether a class is not one of libgz's, and neither it nor another such class that it extends declares state."""
    return _class(kind).undeclared


def runs_code(kind: Any) -> bool:
    """Whether a class is one of users whose LoadState, or a setter, runs when its state is set."""
    return _class(kind).runs_code


def readers(kind: Any) -> tuple[Reader, Reader]:
    """What read what seldom changes of a class, and all else of it."""
    declared = _class(kind)
    return declared.seldom, declared.often


def whole(kind: Any) -> Reader:
    """What reads all that a class declares."""
    return _class(kind).whole


def get_values(thing: Any) -> Sequence[Any]:
    """The declared state of an object, for `set_values`: values in the order of `fields`."""
    kind: Any = type(thing)
    return (_classes.get(id(kind)) or _class(kind)).whole.get(thing)


def set_values(thing: Any, values: Sequence[Any]) -> None:
    """Give an object the values that `get_values` returned of it, or of one that was made in the same way.

    Containers, arrays and generators are changed in place, for others may hold them.
    """
    kind: Any = type(thing)
    (_classes.get(id(kind)) or _class(kind)).whole.set(thing, values)


def _set(thing: Any, place: tuple[Callable[[Any], Any] | None, str], value: Any) -> None:
    """Give an object one of its values."""
    part, name = place
    if not name:
        thing.LoadState(value if _class(type(thing)).ours else _made(value))
        return
    holder = thing if part is None else part(thing)
    before = getattr(holder, name, None)
    kind = type(value)
    if kind in _EXACT and type(before) is kind and before == value:
        return
    after = value if kind in _PLAIN and type(before) in _PLAIN else _loaded(before, value)
    if after is not before:
        setattr(holder, name, after)


def get_state(thing: Any) -> Any:
    """The declared state of an object by names, for `set_state`."""
    return dict(zip(_class(type(thing)).whole.fields, get_values(thing), strict=True))


def set_state(thing: Any, state: Any) -> None:
    """Give an object the state that `get_state` returned of it, or of one that was made in the same way."""
    set_values(thing, [state[name] for name in _class(type(thing)).whole.fields])


def carry_state(thing: Any, state: Any) -> None:
    """Give an object the state of one of an earlier form of its class: what both declare."""
    kind: Any = type(thing)
    for name, place in zip(fields(kind), _class(kind).whole.places, strict=True):
        if name in state and (name or hasattr(kind, "LoadState")):
            _set(thing, place, state[name])


# Values -------------------------------------------------------------------------------------------------------------


def _saved(value: Any) -> Any:
    kind: Any = type(value)
    return value if kind in _PLAIN else (_classes.get(id(kind)) or _class(kind)).save(value)


def _in_order(value: Any) -> Any:
    """What a SaveState of users returned, with sets as their items in order."""
    kind = type(value)
    if kind is list:
        return [*map(_in_order, value)]
    if kind is tuple:
        return _marked((*map(_in_order, value),))
    if kind is dict:
        return (_DICT, *map(_in_order, chain.from_iterable(value.items())))
    if kind in (set, frozenset):
        return _save_set(_SET if kind is set else _FROZEN, value)
    return value


def _loaded(before: Any, value: Any) -> Any:
    """`value`, put into the object that was there where that can be changed."""
    kind: Any = type(before)
    if kind in _PLAIN:
        return _made(value)
    declared = _classes.get(id(kind)) or _class(kind)
    if declared.shared and _is_taken(before, value):
        return _made(value)
    return declared.load(before, value)


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


def made(mark: str, *parts: Any) -> Any:
    """A struct that is in a state."""
    return _makers[mark](*parts)


def _made(value: Any) -> Any:
    """A value of a state, with its structs."""
    kind = type(value)
    if kind is tuple:
        if value and type(value[0]) is str and value[0][:1] == _MARK:
            return tuple(map(_made, value[1:])) if value[0] == _TUPLE else _makers[value[0]](*value[1:])
        return value if _PLAIN.issuperset(map(type, value)) else tuple(map(_made, value))
    if kind is list:
        return value if _PLAIN.issuperset(map(type, value)) else [*map(_made, value)]
    if kind is deque:
        return deque(map(_made, value), value.maxlen)
    if kind is dict:
        plain_ = _PLAIN.issuperset(map(type, value.values()))
        return value if plain_ else {key: _made(item) for key, item in value.items()}
    return value


def _forms(kind: Any, declared: _Class) -> tuple[Callable[[Any], Any], Callable[[Any, Any], Any]]:
    """How values of a class become plain data, and take it."""
    if kind in _CONTAINERS:
        return _CONTAINERS[kind]
    if issubclass(kind, ctypes.Array):
        return (lambda value: (_ITEMS, *value[:])), _load_items
    if "numpy.random" in sys.modules and issubclass(kind, np.random.Generator):
        return (lambda value: (_GENERATOR, _generator_state(value))), _load_generator
    if issubclass(kind, random.Random):
        return (lambda value: (_RANDOM, *value.getstate())), _load_random
    if kind in _STRUCTS:
        return _STRUCTS[kind], (lambda _before, value: _made(value))
    if not declared.declares:
        return (lambda value: value), (lambda _before, value: _made(value))
    head = _OBJECT, kind.__qualname__
    if declared.ours:
        return (lambda value: (*head, *get_values(value))), functools.partial(_load_ours, head)
    return (lambda value: (*head, get_state(value))), functools.partial(_load_users, head)


def _save_dict(value: dict[Any, Any]) -> Any:
    if not _PLAIN.issuperset(map(type, value)):
        return (_DICT, *chain.from_iterable((_saved(key), _saved(item)) for key, item in value.items()))
    if _PLAIN.issuperset(map(type, value.values())):
        return value.copy()
    return {key: _saved(item) for key, item in value.items()}


def _save_set(mark: str, value: Any) -> tuple[Any, ...]:
    """The mark, and what is in a set, in an order that depends on nothing else."""
    if len(kinds := {*map(type, value)}) == 1 and kinds <= _ORDERED:
        return (mark, *sorted(value))
    return (mark, *sorted(map(_saved, value), key=encode))


def _is(mark: str, value: Any) -> bool:
    """Whether a value of a state begins with a mark."""
    return type(value) is tuple and len(value) > 0 and type(value[0]) is str and value[0] == mark


def _load_set(before: set[Any], value: Any) -> Any:
    if not _is(_SET, value):
        return _made(value)
    items = _made(value)
    before.clear()
    before.update(items)
    return before


def _generator_state(generator: np.random.Generator) -> Any:
    """The state of a generator: of numpy's usual one its numbers, of others what numpy returns."""
    state: Any = generator.bit_generator.state
    if len(state) != _PCG_PARTS or state["bit_generator"] != "PCG64":
        return state
    return state["state"]["state"], state["state"]["inc"], state["has_uint32"], state["uinteger"]


def _load_generator(before: np.random.Generator, value: Any) -> Any:
    if not _is(_GENERATOR, value):
        return _made(value)
    state, present = value[1], _generator_state(before)
    if isinstance(state, tuple) and isinstance(present, tuple):
        return before if state == present else _load_pcg(before, state)
    if type(state) is not type(present) or state["bit_generator"] != present["bit_generator"]:
        return _made(value)
    before.bit_generator.state = state
    return before


def _load_pcg(generator: np.random.Generator, state: Sequence[int]) -> np.random.Generator:
    number, inc, has, integer = state
    numbers = {"state": number, "inc": inc}
    generator.bit_generator.state = {
        **{"bit_generator": "PCG64", "state": numbers, "has_uint32": has, "uinteger": integer}
    }
    return generator


def _load_random(before: random.Random, value: Any) -> Any:
    if not _is(_RANDOM, value):
        return _made(value)
    before.setstate(value[1:])
    return before


def _load_ours(head: tuple[str, str], before: Any, value: Any) -> Any:
    if type(value) is not tuple or value[:2] != head:
        return _made(value)
    set_values(before, value[2:])
    return before


def _load_users(head: tuple[str, str], before: Any, value: Any) -> Any:
    if type(value) is not tuple or value[:2] != head:
        return _made(value)
    set_state(before, value[2])
    return before


def _load_items(before: Any, value: Any) -> Any:
    if not _is(_ITEMS, value):
        return _made(value)
    before[:] = value[1:]
    return before


def _load_list(before: list[Any], value: Any) -> Any:
    if type(value) is not list:
        return _made(value)
    before[:] = _made(value) if _PLAIN.issuperset(map(type, before)) else map(_loaded, _as_long(before, value), value)
    return before


def _load_tuple(before: tuple[Any, ...], value: Any) -> Any:
    if type(value) is not tuple or (value and type(value[0]) is str and value[0][:1] == _MARK):
        return _made(value)
    if _PLAIN.issuperset(map(type, before)):
        return _made(value)
    return (*map(_loaded, _as_long(before, value), value),)


def _as_long(before: Sequence[Any], value: Sequence[Any]) -> list[Any]:
    """What was there, with None where there is nothing yet."""
    return [*before, *[None] * (len(value) - len(before))]


def _load_dict(before: dict[Any, Any], value: Any) -> Any:
    if type(value) is not dict:
        if not _is(_DICT, value):
            return _made(value)
        value = dict(zip(map(_made, value[1::2]), value[2::2], strict=True))
    if _PLAIN.issuperset(map(type, (*before.values(), *value.values()))):
        before.clear()
        before.update(value)
    else:
        items = {key: _loaded(before.get(key), item) for key, item in value.items()}
        before.clear()
        before.update(items)
    return before


def _load_deque(before: deque[Any], value: Any) -> Any:
    if type(value) is not deque or value.maxlen != before.maxlen:
        return _made(value)
    kept = (*map(_loaded, _as_long(before, value), value),)
    before.clear()
    before.extend(kept)
    return before


def _load_array(before: NDArray[Any], value: Any) -> Any:
    if _is(_ARRAY, value):
        _, data, kind, shape = value
        if (before.shape, before.dtype.str) == (shape, kind) and before.flags.writeable:
            before[...] = np.frombuffer(data, kind).reshape(shape)
            return before
    return _made(value)


def _save_list(value: list[Any]) -> list[Any]:
    return value[:] if _PLAIN.issuperset(map(type, value)) else [*map(_saved, value)]


def _save_tuple(value: tuple[Any, ...]) -> tuple[Any, ...]:
    if _PLAIN.issuperset(map(type, value)):
        return _marked(value)
    saved = (*map(_saved, value),)
    return (_TUPLE, *saved) if type(value[0]) is str and value[0][:1] == _MARK else saved


def _marked(value: tuple[Any, ...]) -> tuple[Any, ...]:
    """A tuple of users, which may begin with a mark."""
    return (_TUPLE, *value) if value and type(value[0]) is str and value[0][:1] == _MARK else value


def _save_deque(value: deque[Any]) -> deque[Any]:
    return deque(map(_saved, value), value.maxlen)


_CONTAINERS: dict[Any, tuple[Callable[[Any], Any], Callable[[Any, Any], Any]]] = {
    list: (_save_list, _load_list),
    tuple: (_save_tuple, _load_tuple),
    dict: (_save_dict, _load_dict),
    deque: (_save_deque, _load_deque),
    set: (functools.partial(_save_set, _SET), _load_set),
    frozenset: (functools.partial(_save_set, _FROZEN), (lambda _before, value: _made(value))),
    np.ndarray: (_save_array, _load_array),
}


_CHANGED = frozenset({list, dict, deque, set, np.ndarray})  # in place

for _kind in (GzVector, GzQuatern, GzColor, GzPose):
    _add_struct(_kind)


# As bytes -----------------------------------------------------------------------------------------------------------


def encode(state: Any) -> bytes:
    """A state as bytes: equal states give equal bytes.

    Raises:
        ParameterError: something in it is not plain data.
    """
    return Encoder().encode(state)


class Encoder:
    """Encodes states one after another, in less time than as many calls of `encode`."""

    def __init__(self) -> None:
        self._begin()

    def _begin(self) -> None:
        self._buffer = io.BytesIO(_NO_BLOCKS)
        self._buffer.seek(len(_NO_BLOCKS))
        self._blocks: list[pickle.PickleBuffer] = []
        self._pickler = _Writer(self._buffer, 5, buffer_callback=self._blocks.append)
        self._pickler.fast = True  # no references within the data, which would depend on which objects are identical

    def encode(self, state: Any) -> bytes:
        """As the function `encode`."""
        try:
            return self._encoded(state)
        except ParameterError:
            self._begin()
            raise
        except (KeyError, ValueError):  # of a pickler's count of how deep it is, which frozensets and errors upset
            self._begin()
        except BaseException:
            self._begin()
            raise
        try:
            return self._encoded(state)
        except (KeyError, ValueError) as error:
            self._begin()
            raise ParameterError(f"a state must be plain data, and {TOO_DEEP}") from error

    def _encoded(self, state: Any) -> bytes:
        buffer, blocks = self._buffer, self._blocks
        try:
            self._pickler.dump(state)
        except (pickle.PicklingError, TypeError, AttributeError) as error:
            raise ParameterError(f"a state must be plain data, and {error}") from error
        except RecursionError as error:
            raise ParameterError(f"a state must be plain data, and {TOO_DEEP}") from error
        if blocks:
            contents = [*map(pickle.PickleBuffer.raw, blocks)]
            head = struct.pack(f"<{1 + len(blocks)}q", len(blocks), *map(len, contents))
            encoded = b"".join((FORMAT, head, buffer.getbuffer()[len(_NO_BLOCKS) :], *contents))
            blocks.clear()
        else:
            encoded = buffer.getvalue()
        buffer.truncate(buffer.seek(len(_NO_BLOCKS)))
        return encoded


class Kept:
    """The encoding of plain data that seldom changes: it is made anew only where they have changed, to the bit."""

    def __init__(self) -> None:
        self._key = self.encoded = b""

    def encode(self, plain_: Any) -> bytes:
        """Like the function `encode`, for data of builtin types."""
        try:
            key = marshal.dumps(plain_, 2)
        except ValueError:  # there is something in them that is not of a builtin type
            self._key, self.encoded = b"", encode(plain_)
            return self.encoded
        if key != self._key:
            self._key, self.encoded = key, encode(plain_)
        return self.encoded


def equal(one: Any, other: Any) -> bool:
    """Whether plain data are the same to the bit; those of other than builtin types never are."""
    try:
        return marshal.dumps(one, 2) == marshal.dumps(other, 2)
    except ValueError:
        return False


class _Writer(pickle.Pickler):
    """Writes plain data, and nothing else."""

    def reducer_override(self, thing: Any) -> Any:
        """Refuse what is not plain data; called for everything that is not of a simple builtin type."""
        kind: Any = type(thing)
        if kind in _STRUCTS:
            return made, _STRUCTS[kind](thing)
        if kind is np.ndarray and thing.dtype.kind in _ARRAYS:
            return made, _save_array(thing)
        if isinstance(thing, np.ndarray) and (kind is not np.ndarray or thing.dtype.kind == "V"):
            raise pickle.PicklingError(f"a numpy {kind.__name__} of {thing.dtype} is not")
        if kind in _WRITTEN or isinstance(thing, (*_NUMBERS, *_MADE)):
            return NotImplemented
        itself = isinstance(thing, (type, FunctionType, BuiltinFunctionType))  # they stand for themselves
        named = thing if itself else kind
        if (named.__module__, named.__qualname__) not in _ALLOWED:
            raise pickle.PicklingError(f"an object of class {kind.__module__}.{kind.__qualname__} is not")
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
        (count,) = _COUNT.unpack_from(data, len(FORMAT))
        begin, end = len(FORMAT) + 8 * (1 + count), len(data)
        blocks: list[memoryview] = []
        if count:
            view = memoryview(data)
            for size in reversed(struct.unpack_from(f"<{count}q", data, len(FORMAT) + 8)):
                end -= size
                if size < 0 or end < begin:
                    raise ValueError("its blocks are longer than it")
                blocks.append(view[end : end + size])
        stream = io.BytesIO(data[begin:end])
        state = _Reader(stream, buffers=reversed(blocks)).load()
        if stream.read(1):
            raise ValueError("there is more than a state")
    except _DAMAGES as error:
        raise ParameterError(f"the state is damaged: {error}") from error
    return state
