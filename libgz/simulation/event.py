"""Event: callbacks that are called together; a connection ends when its last reference is dropped."""

from __future__ import annotations

import contextlib
import inspect
import logging
import time
from collections.abc import Callable, Collection, Iterable, Iterator
from contextvars import ContextVar
from typing import Any, ClassVar, NamedTuple, Protocol
from weakref import WeakSet

from libgz.base.errors import USER_ERRORS, ParameterError, pass_interrupt
from libgz.base.law import is_law
from libgz.simulation.plugins import own_traceback
from libgz.simulation.problems import NOTED, note

__all__ = [
    "AtEnd",
    "Callback",
    "Connection",
    "Ends",
    "Event",
    "Owner",
    "UpdateInfo",
    "WorldEvents",
    "checked",
    "everywhere",
    "owner",
    "report_failure",
    "unowned",
]

log = logging.getLogger("libgz.simulation")

HASTE = 1e-3  # [s]; a connection dropped sooner was probably meant to be kept


class Ends(Protocol):
    """A connection to an event, a subscription to a topic, or a publication."""

    def disconnect(self) -> None:
        """Disconnect."""


class Owner(Protocol):
    """What connects callbacks: a plugin. `stop` is called when one of them raises."""

    events: WorldEvents | None  # of its world; None for those of all worlds
    connections: WeakSet[Ends]

    def stop(self, where: str, error: BaseException) -> None:
        """One of its callbacks raised."""


owner: ContextVar[Owner | None] = ContextVar("owner", default=None)  # of the code that is running


@contextlib.contextmanager
def unowned() -> Iterator[None]:
    """What is connected in the `with` belongs to no plugin: it is the library's, and outlives the plugin that asks."""
    token = owner.set(None)
    try:
        yield
    finally:
        owner.reset(token)


class _Entry:
    """One callback of an event."""

    __slots__ = ("callback", "connected", "owner", "parameters")

    def __init__(self, callback: Callable[..., object], parameters: int, by: Owner | None) -> None:
        self.callback, self.parameters, self.owner = callback, parameters, by
        self.connected = True


class Callback:
    """A function that is called later, on behalf of the plugin that gave it, until it fails once.

    Args:
        what: for messages, such as ``the update function of battery 'main'``.
        function: what to call.
        read: converts what the function returns; it may raise.

    Raises:
        ParameterError: it cannot be called.
    """

    def __init__(self, what: str, function: Callable[..., Any], read: Callable[[Any], Any] | None = None) -> None:
        self._what, self._function, self._read = what, checked(function, what), read
        self.owner = owner.get()
        self.connected = True
        if self.owner is not None:
            self.owner.connections.add(self)

    def disconnect(self) -> None:
        """Stop to call it."""
        self.connected = False

    def __call__(self, *values: Any, otherwise: Any = None) -> Any:
        """What the function returns; `otherwise` if it raises, which is reported, or is disconnected."""
        if not self.connected:
            return otherwise
        token = owner.set(self.owner)
        try:
            result = self._function(*values)
            return self._read(result) if self._read is not None else result
        except USER_ERRORS as error:
            pass_interrupt(error)
            self.connected = False
            report_failure(self.owner, self._what, error)
            return otherwise
        finally:
            owner.reset(token)


class AtEnd:
    """A function that is called once: when the plugin that makes this ends, or when nothing refers to this any more.

    A plugin that is dropped may live on until Python collects it; what it added to the world ends at once in this way.
    """

    def __init__(self, function: Callable[[], object]) -> None:
        self._functions = [function]
        by = owner.get()
        if by is not None:
            by.connections.add(self)

    def disconnect(self) -> None:
        """Call the function now, if it was not called before."""
        while self._functions:
            self._functions.pop()()

    def __del__(self) -> None:
        self.disconnect()


def report_failure(by: Owner | None, what: str, error: BaseException) -> None:
    """Report what a callback raised, and stop the plugin that gave it; the caller must not call it again.

    Args:
        by: the plugin; None for a callback of other code.
        what: what the callback is, such as ``a callback of event Pause``.
        error: what it raised.
    """
    if by is not None:
        by.stop(what, error)
    else:
        note(what, "it", error)
        log.error("%s failed and is not called any more:\n%s", what, own_traceback(error), extra=NOTED)


def checked(callback: Any, what: str) -> Callable[..., Any]:
    """The callback itself.

    Raises:
        ParameterError: it cannot be called.
    """
    if not callable(callback):
        raise ParameterError(f"{what} is {callback!r}, which cannot be called; give a function's name without ()")
    return callback  # type: ignore[no-any-return]


class Connection:
    """A callback of an event. `Disconnect` ends it, and so does dropping the last reference to it."""

    def __init__(self, event: Event, entry: _Entry) -> None:
        self._event, self._entry = event, entry
        self._made = time.monotonic()

    def Disconnect(self) -> None:
        """Remove the callback from the event. Can be called twice."""
        self._event.remove(self._entry)

    disconnect = Disconnect

    def precede(self, others: Collection[Owner]) -> None:
        """Have the callbacks of this one's plugin called before those of others, in this event."""
        self._event.move(self._entry.owner, others)

    @property
    def connected(self) -> bool:
        """Whether the callback is still called."""
        return self._entry.connected

    def __del__(self) -> None:
        if self._entry.connected:
            self.Disconnect()
            if time.monotonic() - self._made < HASTE:
                log.warning(
                    "Warning: Deleting a connection right after creation. "
                    "Make sure to save the ConnectionPtr from a Connect call"
                )


class Event:
    """Something that happens, and the callbacks that are called then.

    A callback may take fewer arguments than the event has. One that raises is reported with its traceback, and its
    plugin is stopped; outside plugins only that callback is.

    Args:
        name: for messages.
        above: an event whose callbacks are called before this one's own.

    Attributes:
        own: its own callbacks.
    """

    def __init__(self, name: str = "event", above: Event | None = None) -> None:
        self.name = name
        self.above = above
        self.own: tuple[_Entry, ...] = ()
        self._all: tuple[_Entry, ...] | None = None
        self._gives = False  # whether one of them takes arguments
        self._laws = True
        self._seen: tuple[_Entry, ...] = ()  # of the event above, when _all was put together

    def __bool__(self) -> bool:
        return bool(self.own or (self.above is not None and self.above.own))

    @property
    def entries(self) -> tuple[_Entry, ...]:
        """Its callbacks in the order in which they are called; the same tuple until they change."""
        above = self.above.own if self.above is not None else ()
        if self._all is None or above is not self._seen:
            self._seen, self._all = above, above + self.own
            self._gives = any(entry.parameters for entry in self._all)
            self._laws = not self._gives and all(is_law(getattr(e.callback, "__func__", None)) for e in self._all)
        return self._all

    @property
    def obeys_laws(self) -> bool:
        """Whether all callbacks are laws without arguments."""
        _ = self.entries
        return self._laws

    @property
    def gives(self) -> bool:
        """Whether a callback takes arguments."""
        _ = self.entries
        return self._gives

    def Connect(self, callback: Callable[..., object]) -> Connection:
        """Call `callback` at each signal, as long as the connection is kept.

        Raises:
            ParameterError: it cannot be called.
        """
        checked(callback, f"the callback of event {self.name}")
        by = owner.get()
        entry = _Entry(callback, _parameters(callback), by)
        self.own += (entry,)
        self._all = None
        connection = Connection(self, entry)
        if by is not None:
            by.connections.add(connection)
        return connection

    def Disconnect(self, connection: Connection) -> None:
        """End a connection."""
        connection.Disconnect()

    def ConnectionCount(self) -> int:
        """How many callbacks there are."""
        return len(self.entries)

    def remove(self, entry: _Entry) -> None:
        """Remove a callback; it is not called any more, not even in a signal that is under way."""
        entry.connected = False
        self.own = tuple(kept for kept in self.own if kept is not entry)
        self._all = None

    def move(self, by: Owner | None, others: Collection[Owner]) -> None:
        """Call the callbacks of one plugin before those of others."""
        moved = [entry for entry in self.own if entry.owner is by]
        rest = [entry for entry in self.own if entry.owner is not by]
        at = next((i for i, entry in enumerate(rest) if entry.owner is not None and entry.owner in others), len(rest))
        self.own, self._all = (*rest[:at], *moved, *rest[at:]), None

    def clear(self) -> None:
        """Remove all callbacks."""
        for entry in self.own:
            entry.connected = False
        self.own, self._all = (), None

    def Signal(self, *values: Any) -> None:
        """Call all callbacks, in the order of connection; new ones from the next signal on."""
        self.call(self.entries, *values)

    __call__ = Signal

    def call(self, entries: Iterable[_Entry], *values: Any) -> None:
        """Call some of the callbacks."""
        before = current = owner.get()
        given = len(values)
        for entry in entries:
            if not entry.connected:  # an earlier callback removed it, or stopped its plugin
                continue
            if entry.owner is not current:
                current = entry.owner
                owner.set(current)
            try:
                if entry.parameters >= given:
                    entry.callback(*values)
                else:
                    entry.callback(*values[: entry.parameters])
            except USER_ERRORS as error:
                pass_interrupt(error)
                self.failed(entry, error)
        if current is not before:
            owner.set(before)

    def failed(self, entry: _Entry, error: BaseException) -> None:
        """Report what a callback raised, and call it no more."""
        report_failure(entry.owner, f"a callback of event {self.name}", error)
        self.remove(entry)
        if self.above is not None:
            self.above.remove(entry)


def _parameters(callback: Callable[..., object]) -> int:
    """How many positional arguments a callback takes."""
    try:
        found = inspect.signature(callback).parameters.values()
    except (TypeError, ValueError):  # some built-in functions have no signature
        return 0
    if any(p.kind is p.VAR_POSITIONAL for p in found):
        return 9
    return sum(p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in found)


NAMES = (
    "WorldUpdateStart",
    "WorldUpdateBegin",
    "BeforePhysicsUpdate",
    "WorldUpdateEnd",
    "WorldCreated",
    "WorldReset",
    "TimeReset",
    "Pause",
    "Step",
    "Stop",
    "SigInt",
    "CreateEntity",
    "AddEntity",
    "DeleteEntity",
    "SetSelectedEntity",
    "CreateSensor",
    "RemoveSensor",
    "PreRender",
    "Render",
    "PostRender",
    "PreRenderEnded",
    "DiagTimerStart",
    "DiagTimerStop",
)


class UpdateInfo(NamedTuple):
    """What the callbacks of update events are given, unless an era has a type of its own for it."""

    world_name: str
    sim_time: float  # [s]
    real_time: float  # [s]


class WorldEvents(dict[str, Event]):
    """The events of one world, by Gazebo's names; `everywhere` are those of all worlds.

    Attributes:
        update_info: makes what callbacks of update events are given from the world's name, sim time [s] and real time
            [s]; Gazebo classic, whose callbacks expect a type of its own, registers that here.
    """

    update_info: ClassVar[Callable[[str, float, float], object]] = UpdateInfo

    def __init__(self, above: WorldEvents | None = None) -> None:
        super().__init__((name, Event(name, above[name] if above is not None else None)) for name in NAMES)

    def close(self) -> None:
        """Remove all callbacks."""
        for event in self.values():
            event.clear()


everywhere = WorldEvents()
