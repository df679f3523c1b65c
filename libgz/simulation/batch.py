"""Batch: the commands and readings of many interfaces as two arrays, for loops that learn."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Iterable, Sequence
from fnmatch import fnmatchcase
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.physics.engine import Engine
from libgz.physics.lock import WorldLock
from libgz.simulation.clock import Clock
from libgz.simulation.exchange import Exchange
from libgz.simulation.updates import UpdateRows, run_exchanges
from libgz.transport.interface import Interface
from libgz.transport.layout import SERVER, fields_of
from libgz.transport.server import LocalServer

__all__ = ["Batch", "Columns"]

# Fields of interfaces: a target such as ``position.robot1`` or ``laser.*``, and fields such as ``pos`` or ``rot[2]``.
Columns = Sequence[str]

_FIELD = re.compile(r"(\w+)((?:\[-?\d+\])*)")


class Batched(Protocol):
    """A world, as a batch uses it."""

    engine: Engine
    clock: Clock
    lock: WorldLock
    gz_server: LocalServer
    rows: UpdateRows

    def step(self, count: int = 1) -> None:
        """Run steps."""


class _Part(NamedTuple):
    """Numbers of one interface: views of its memory, and where they are in the array."""

    interface: Interface[Any]
    views: list[NDArray[Any]]
    places: list[slice]


class Batch:
    """Commands and readings of a world's interfaces as two arrays of numbers.

    Numbers are in the order of the entries, in each by interface, in each of these by field. Where a client of a served
    world holds the lock of an interface for long, its numbers stay as they were.

    Attributes:
        command_names, reading_names: what each number is, such as ``position.robot1.cmd_vel_pos[0]``.
        commands: what the next `step` writes, shape (n,); at first what is there. It may be changed in place.
        readings: what was read last, shape (m,); the same array each time.

    Args:
        world: which runs.
        commands: entries that clients write: a target and its fields.
        readings: entries to read, likewise.

    Raises:
        NotFoundError: nothing serves a target.
        ParameterError: an interface has no such field, or none of these numbers yet; or a command is a field that the
            server writes.
    """

    def __init__(self, world: Batched, commands: Iterable[Columns], readings: Iterable[Columns]) -> None:
        self.world = world
        parts, self.command_names = _find(world.gz_server, commands, writing=True)
        self.commands: NDArray[np.float64] = np.zeros(len(self.command_names))
        for part in parts:
            for view, place in zip(part.views, part.places, strict=True):
                self.commands[place] = view
        self._store = self._table(parts, self._exchange_of_commands, self._store_in_python)
        parts, self.reading_names = _find(world.gz_server, readings, writing=False)
        self.readings: NDArray[np.float64] = np.zeros(len(self.reading_names))
        self._fetch = self._table(parts, self._exchange_of_readings, self._fetch_in_python)
        self.read()

    def step(self, commands: ArrayLike | None = None, steps: int = 1) -> NDArray[np.float64]:
        """Write commands, run steps, and read.

        Args:
            commands: as many numbers as `command_names`, of any shape; None: `commands` as it is.
            steps: to run.

        Returns:
            `readings`, shape (m,).

        Raises:
            ParameterError: there are too many or too few commands, or one is not finite.
            ClosedError: an interface was destroyed.
        """
        if commands is not None:
            given = np.asarray(commands, dtype=np.float64)
            if given.size != self.commands.size:
                raise ParameterError(f"{given.size} commands were given; there are {self.commands.size}")
            self.commands[:] = given.reshape(-1)
        if not np.isfinite(self.commands).all():
            first = int(np.flatnonzero(~np.isfinite(self.commands))[0])
            raise ParameterError(f"command {self.command_names[first]} is {self.commands[first]}; it must be finite")
        with self.world.lock:
            self._store()
            self.world.step(steps)
            self._fetch()
        return self.readings

    def read(self) -> NDArray[np.float64]:
        """Read without a step; `readings`, shape (m,).

        Raises:
            ClosedError: an interface was destroyed.
        """
        with self.world.lock:
            self._fetch()
        return self.readings

    def _table(
        self,
        parts: list[_Part],
        exchange: Callable[[_Part], Exchange],
        twin: Callable[[_Part], None],
    ) -> Callable[[], None]:
        """A function that does all exchanges."""
        return run_exchanges(self.world, [(exchange(part), partial(twin, part)) for part in parts])

    def _exchange_of_commands(self, part: _Part) -> Exchange:
        exchange = Exchange(part.interface)
        for view, place in zip(part.views, part.places, strict=True):
            exchange.store(view, self.commands[place])
        return exchange

    def _exchange_of_readings(self, part: _Part) -> Exchange:
        exchange = Exchange(part.interface)
        for view, place in zip(part.views, part.places, strict=True):
            exchange.fetch(self.readings[place], view)
        return exchange

    def _store_in_python(self, part: _Part) -> None:
        if part.interface.lock():
            for view, place in zip(part.views, part.places, strict=True):
                view[:] = self.commands[place]
            part.interface.unlock()

    def _fetch_in_python(self, part: _Part) -> None:
        if part.interface.lock():
            for view, place in zip(part.views, part.places, strict=True):
                self.readings[place] = view
            part.interface.unlock()


def _find(server: LocalServer, entries: Iterable[Columns], *, writing: bool) -> tuple[list[_Part], list[str]]:
    """The interfaces and fields of entries, and the names of their numbers."""
    parts: list[_Part] = []
    names: list[str] = []
    for target, *fields in entries:
        if isinstance(target, str) and not fields:
            raise ParameterError(f"{target!r} comes without fields; an entry is a target and its fields")
        for interface in _interfaces(server, target):
            views, places = [], []
            for text in fields:
                view, label = _view(interface, text, writing=writing)
                places.append(slice(len(names), len(names) + len(view)))
                views.append(view)
                names += [f"{interface.type}.{interface.id}.{name}" for name in label]
            parts.append(_Part(interface, views, places))
    return parts, names


def _interfaces(server: LocalServer, target: str) -> list[Interface[Any]]:
    """The interfaces of a target, in order of construction."""
    served = {".".join(key): interface for key, interface in server.interfaces.items()}
    found = [interface for name, interface in served.items() if fnmatchcase(name, target)]
    if not found:
        raise NotFoundError(f"nothing serves {target!r}; there are {', '.join(served)}{nearest(target, served)}")
    return found


def _view(interface: Interface[Any], text: str, *, writing: bool) -> tuple[NDArray[Any], list[str]]:
    """The numbers of a field, of one dimension, on the interface's memory; and their names."""
    what = f"{interface.type}.{interface.id}"
    match = _FIELD.fullmatch(text)
    known = {name: field for name, field in fields_of(interface.layout).items() if field.ctype in _NUMERIC}
    name = match[1] if match else text
    shown = isinstance(getattr(type(interface), name, None), property)
    array: Any = getattr(interface, name) if shown else None  # such as the ranges of a laser, as many as there are
    if not isinstance(array, np.ndarray) and name in known:
        array = interface.array(name)
    if match is None or not isinstance(array, np.ndarray):
        raise ParameterError(f"{what} has no numbers {text!r}; it has {', '.join(known)}{nearest(name, known)}")
    if writing and (name not in known or known[name].writer == SERVER):
        allowed = [name for name, field in known.items() if field.writer != SERVER]
        raise ParameterError(f"{what}.{name} is no command; its commands are {', '.join(allowed) or 'none'}")
    try:
        for index in re.findall(r"-?\d+", match[2]):
            array = array[int(index) : int(index) + 1 or None][0, ...]
    except IndexError:
        raise ParameterError(f"{what}.{name} has the shape {interface.array(name).shape}, so no {text}") from None
    if not array.size:
        raise ParameterError(f"{what} has no {name} yet: let the world make steps first")
    labels = [text + "".join(f"[{i}]" for i in at) for at in np.ndindex(array.shape)]
    return _flat(array), labels


def _flat(array: NDArray[Any]) -> NDArray[Any]:
    """A view of one dimension."""
    if array.ndim == 0:
        return array.reshape(1)
    if array.ndim > 1 and not array.flags.c_contiguous:
        raise ParameterError(f"numbers of the shape {array.shape} are not next to each other; name single columns")
    return array if array.ndim == 1 else array.reshape(-1)


_NUMERIC = (ctypes.c_double, ctypes.c_float, ctypes.c_int32, ctypes.c_uint32, ctypes.c_uint16, ctypes.c_uint8)
