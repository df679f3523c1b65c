"""Snapshots: the whole state of a world as bytes, and a world brought back to such a state.

`World.get_state()` encodes plain data, without references within it, so that equal states are equal bytes
(`simulation/state.py`). Values are read by one getter for each class, and looked at one by one only where one is not a
number or text; a value that is there already is not set. Vectors, poses and arrays are tuples behind a mark, which
takes a
tenth of the time of pickling them. Large arrays and interfaces are blocks at the end of the bytes, which are copied
once.

`Snapshots.restore` (`snapshot.py`) acts in an order that matters:

1. Checks: the file's digest, and whether what has to be built again can be. Until here nothing has changed.
2. Journal (`journal.py`): each entity has an `Origin`, a place in the file or in an inserted text. From the first one
on
   that differs, by origin or by parent, all are removed and built again in the order of the state, because the order of
   bodies decides last bits. One that held others takes them with it. Interfaces keep files, locks and numbers meanwhile
   (`keep_released`).
3. The world's attributes, random numbers and the count of insertions.
4. Entities: of all of them what seldom changes, then the other attributes of `STATE`, then `LoadState`. That may make
   and remove links. Then come the joints of models (`MasterStatesSet`), for those hold links of other models.
5. Companions and extensions. Classic's companion (`classic/server.py`) has names first, by which others are found, then
sensors, controllers, animations, what
   plugins changed of visuals, waiting messages, and plugins.
6. The engine: it overwrites whatever the phases before did, and closes bodies, geoms and joints that came since.
7. Interface bytes. So commands of clients that were waiting act again.

If the companions had to load or drop plugins, all phases run once more, since `Load` can change anything. What a plugin
added to
the world ends with it, not when Python collects it (`AtEnd` in `event.py`).

If a phase fails, the state is damaged, and the state that was taken before the first phase is set in the same way. It
is not
taken where the same bytes were set without an error before. `tests/trials/test_damaged_states.py` replaces values
within states.

A reset is `set_state` of the state that `Initialize` kept at its end. Classic's plugins are not in that one: their
`Reset()` is called. `SdfWorld.start` sorts geoms once before it, since a fresh world's order depends on how it was
built.
After it, callbacks are in the order of the start again, also of plugins that were loaded anew since.
Plugins of a state that do not run are loaded before its joints and links return. Where code made some, models are built
again
from the first of these on, because a `Load` that makes a joint fails if it is there.
`rewind.py` keeps states in a ring; a step without one pays for one comparison.

A clone has a name of its own for topics, `World.topic_space`: topics belong to the process and not to the world, so
that
equal names would be equal topics. `Node.Init` translates the name of the world for the clone's plugins.

What other processes see (`publication.py`, docs/observer.md) are the engine's tables, copied behind a sequence counter
after each step; no second description of the world exists for them.
"""

from __future__ import annotations

import contextlib
import functools
import logging
from collections.abc import Iterable, Sequence
from itertools import chain
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from libgz.base.errors import USER_ERRORS, GazeboError, ParameterError, PluginError, StateError, pass_interrupt
from libgz.physics.edits import edits
from libgz.physics.state import PARTS as ENGINE_PARTS
from libgz.simulation import state
from libgz.simulation.journal import Journal, Origin, Source
from libgz.simulation.plugins import own_traceback
from libgz.simulation.state import Reader

if TYPE_CHECKING:
    from libgz.simulation.entity import Entity
    from libgz.simulation.world import World
    from libgz.transport.interface import Interface

__all__ = ["Snapshots"]

log = logging.getLogger("libgz.simulation")

# What a state consists of, in order.
PARTS = (
    *("file", "list", "seldom", "world", "random", "entities", "companions", "extensions", "engine", "interfaces"),
)

MOST_SOUND = 1024  # states whose hashes are kept


class StoppedError(GazeboError):
    """What an entity had raised in the world that a state was saved of."""


class Snapshots:
    """Takes the states of a world, and brings it back to them.

    Which entities there are, where they come from, what is attached to what, and most of what classes of libgz declare
    changes rarely, and each such change is counted: it is read and encoded again only after that count has changed.

    Args:
        world: the World.

    Attributes:
        failures: what code of users raised while a state was set, such as a LoadState; all else of the state was set.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._collected: list[Any] = []  # at the last encoding of the list of entities
        self._seen: tuple[int, int] | None = None  # the counts of changes then; None if some are not counted
        self._listed = b""  # that encoding
        self._seldom = b""  # the encoding of what seldom changes of the entities
        self._seldom_of_world = b""  # and of the world itself
        self._often_of_world = state.readers(_type(world))[1]
        self._often: list[tuple[Reader, list[Entity]]] = []  # the others, by their classes
        self._extended = 0  # how many extensions the world had
        self._declaring: list[tuple[str, Any]] = []  # those of them that declare state
        self._served: dict[tuple[str, str], Interface[Any]] = {}  # the interfaces in the last state
        self._sorted: list[Interface[Any]] = []  # in order of their types and ids
        self._names = b""  # the encoding of those
        self._encoder = state.Encoder()
        self._runs_code = False  # whether a class of users has code that runs when its state is set
        self._sound: dict[int, None] = {}  # hashes of the last states that were set without an error
        self.failures: list[GazeboError] = []

    def save(self) -> bytes:
        """The state between two steps; the caller holds the world's lock.

        Raises:
            ParameterError: an object declares something as its state that is not plain data, or cannot be read.
            PluginError: code of users failed, such as a SaveState.
        """
        agenda = self._world.agenda
        before, agenda.holding = agenda.holding, True  # what a SaveState asks for comes after it
        try:
            return self.read()
        finally:
            agenda.end_hold(before)

    def read(self) -> bytes:
        """`save`, for a caller that holds changes back."""
        world = self._world
        plain = (
            world.era.digest,
            self._list(),
            self._seldom,
            (self._seldom_of_world, self._often_of_world.get(world)),
            (world.spawned, world.journal.inserted, world.seed),
            [_own_states(reader, entities) for reader, entities in self._often],
            {_name(companion): kept for companion in world.companions if (kept := companion.get_state()) is not None},
            {name: state.get_values(extension) for name, extension in self._extensions()},
            world.engine.read_state(state.large),
            self._contents(),
        )
        try:
            return self._encoder.encode(plain)
        except ParameterError as error:
            for entity in world.entities:
                _check(entity, error)
            for companion in world.companions:
                companion.check_state()
            raise

    def restore(self, data: bytes, *, anew: bool = False) -> None:
        """Bring the world into a state that `save` returned, of itself or of another world of the same file.

        If the state turns out to be damaged, the world is brought back to what it was before.

        Args:
            data: the state.
            anew: whether all entities are built again, also those that are there.

        Raises:
            StateError: the state is of another file, or damaged, or something that cannot be built again is missing.
            ParameterError: these bytes are no state.
        """
        data = bytes(data)  # the same object, if it is that already
        saved = self._decoded(data)
        number = hash(data)
        before = None if number in self._sound and not self._calls_users(saved) else self._saved_before()
        self._sound.pop(number, None)
        try:
            self._set(saved, anew)
            if self.failures:
                raise self.failures[0]
        except USER_ERRORS as error:
            cause = self.failures[0] if self.failures else error
            left = self._undo(self._decoded(before)) if before is not None else ""
            pass_interrupt(error)
            kind = type(cause) if isinstance(cause, GazeboError) else StateError
            text = str(cause) if kind is type(cause) else f"the state is damaged: {type(cause).__name__}: {cause}"
            raise kind(text + left) from cause
        self._sound[number] = None
        if len(self._sound) > MOST_SOUND:
            del self._sound[next(iter(self._sound))]

    def _undo(self, before: dict[str, Any]) -> str:
        """Set the state from before; the end of a message about what that could not undo, which is mostly empty."""
        _count_changes()  # an error may have come before that of a change
        try:
            try:
                self._set(before, False, undoing=True)
            except USER_ERRORS as error:  # something was destroyed that only building anew brings back
                pass_interrupt(error)
                self._set(before, True, undoing=True)
        except USER_ERRORS as error:
            pass_interrupt(error)
            return f"\nwhat was set of it could not be undone: {error}"
        finally:
            _count_changes()
        return "".join(f"\nthis could not be undone: {error}" for error in self.failures)

    def _calls_users(self, saved: dict[str, Any]) -> bool:
        """Whether code of users runs when this state is set, which may raise in a state that could be set before."""
        if saved["list"] != self._list() or self._runs_code:
            return True
        kept = saved["companions"]
        return any(companion.calls_users(kept.get(_name(companion))) for companion in self._world.companions)

    def _saved_before(self) -> bytes | None:
        try:
            return self.save()
        except GazeboError as error:
            log.debug("a damaged state cannot be undone, as the world's state cannot be saved: %s", error)
            return None

    def _decoded(self, data: bytes) -> dict[str, Any]:
        """The parts of a state of this world, by their names; nothing is changed."""
        world, decoded = self._world, state.decode(data)
        if not isinstance(decoded, tuple) or len(decoded) != len(PARTS):
            raise ParameterError("the state is damaged: it has not the parts of one")
        saved = dict(zip(PARTS, decoded, strict=True))
        if saved["file"] != world.era.digest:
            raise StateError("this state is of another world: its file has another text than this world's")
        if not isinstance(saved["companions"], dict):
            raise StateError("the state is damaged: it does not name its parts")
        if saved["companions"] and not saved["companions"].keys() <= set(map(_name, world.companions)):
            world.attach_era()
            for name in saved["companions"].keys() - set(map(_name, world.companions)):
                raise StateError(f"this state has a part that this world has not: {name}")
        return saved

    def _set(self, saved: dict[str, Any], anew: bool, *, undoing: bool = False) -> None:
        """Set a state: twice if plugins came or went, for their Load may have changed what was set already."""
        self.failures.clear()
        try:
            state.restoring(True)
            again = self._set_once(saved, anew)
            if again and (undoing or not self.failures):
                self.failures.clear()
                state.restoring(True)
                self._set_once(saved, False)
        finally:
            state.restoring(False)

    def _set_once(self, saved: dict[str, Any], anew: bool) -> bool:
        """Set a state; whether a companion asks for setting it once more."""
        world = self._world
        keep = 0 if anew else self._fit_for_plugins(saved)
        listed = state.decode(saved["list"]) if keep < len(world.entities) or saved["list"] != self._list() else None
        if listed is not None:
            _restore_entities(world, listed, keep)
            now = state.decode(self._list())
            if (now["kinds"], now["fields"]) != (listed["kinds"], listed["fields"]):
                raise StateError(
                    "models of this state are of other classes now, or their classes declare another STATE"
                )
        for companion in world.companions:
            companion.entities_rebuilt(saved["companions"].get(_name(companion)))
        seldom, often = saved["world"]
        if seldom != self._seldom_of_world:
            state.readers(_type(world))[0].set(world, state.decode(seldom))
        self._often_of_world.set(world, often)
        spawned, world.journal.inserted, seed = saved["random"]
        if seed != world.seed:
            world.begin_random(seed)
        world.restart_random(spawned)
        if listed is not None:
            for index, entity in enumerate(world.entities):
                _load_relatives(world, entity, listed["entities"][index])
        self._load_entities(saved["seldom"], saved["entities"])
        world.update_rows_changed()
        if listed is not None:
            world.followers[:] = [world.entities[index] for index in listed["followers"]]
        again = False
        for companion in world.companions:
            again |= companion.set_state(saved["companions"].get(_name(companion)))
        for name, extension in self._extensions():
            if name in saved["extensions"]:
                state.set_values(extension, saved["extensions"][name])
        world.engine.set_state(dict(zip(ENGINE_PARTS, saved["engine"], strict=True)))
        names, contents = saved["interfaces"]
        present = self._interfaces()
        if names != self._names:
            found = world.gz_server.interfaces
            rows = [(found.get(key), content) for key, content in zip(state.decode(names), contents, strict=True)]
        else:
            rows = [*zip(present, contents, strict=True)]
        for interface, content in rows:
            if interface is not None:
                interface.set_bytes(content)
        return again

    def _fit_for_plugins(self, saved: dict[str, Any]) -> int:
        """How many entities may stay: a Load that makes a joint fails, or has none, where that joint is there."""
        world, kept = self._world, saved["companions"]
        if not any(companion.loads_plugins(kept.get(_name(companion))) for companion in world.companions):
            return len(world.entities)
        extended = (i for i, entity in enumerate(world.entities) if entity.is_extended)
        return next(extended, len(world.entities))

    def _extensions(self) -> list[tuple[str, Any]]:
        """The extensions of the world that declare state, and their names."""
        present = self._world.extensions
        if len(present) != self._extended:
            self._extended = len(present)
            self._declaring = [(_name(one), one) for one in present if state.declares(_type(one))]
        return self._declaring

    def _contents(self) -> tuple[bytes, list[Any]]:
        """The types and ids of all interfaces, encoded, and their bytes."""
        contents = [state.large(interface.get_bytes()) for interface in self._interfaces()]
        return self._names, contents

    def _interfaces(self) -> list[Interface[Any]]:
        """The interfaces in order of their types and ids."""
        found = self._world.gz_server.interfaces
        if found != self._served or not self._names:
            self._served = dict(found)
            self._names = state.encode(sorted(found))
            self._sorted = [found[key] for key in sorted(found)]
        return self._sorted

    def _list(self) -> bytes:
        """Which entities there are, where they come from, what is attached to what, and who has stopped; encoded."""
        world = self._world
        entities = world.entities
        counts = state.changes.last, edits.last
        if counts == self._seen and entities == self._collected[0] and world.followers == self._collected[3]:
            return self._listed
        rows = [*map(_relatives, entities)]
        places = [parent.bodies.index(body) for _, parent, body, *_ in rows if parent is not None and body is not None]
        collected = [entities, rows, places, world.followers]
        if collected != self._collected:
            kinds = list(dict.fromkeys(map(_type, entities)))
            number = {entity: index for index, entity in enumerate(entities)}
            origins = [entity.origin for entity in entities]
            sources = {source: i for i, source in enumerate(dict.fromkeys(o.source for o in origins if o is not None))}
            self._listed = state.encode(
                {
                    "sources": [tuple(source) for source in sources],
                    "entities": [_listed_entity(entity, sources, number) for entity in entities],
                    "kinds": [kinds.index(type(entity)) for entity in entities],
                    "fields": [state.fields(_type(entity)) for entity in entities],
                    "followers": [number[entity] for entity in world.followers],
                }
            )
            self._collected = [list(entities), rows, places, list(world.followers)]
        self._read_seldom()
        self._seen = counts if all(entity.SELDOM for entity in entities) else None
        return self._listed

    def _read_seldom(self) -> None:
        """Encode what seldom changes of entities, and find those of which something changes often."""
        entities = self._world.entities
        still = [entity.MasterIsStill() for entity in entities]
        rows = [_own_state(_reader(entity, whole), entity) for entity, whole in zip(entities, still, strict=True)]
        self._seldom = state.encode((still, rows))
        self._seldom_of_world = state.encode([*state.readers(_type(self._world))[0].get(self._world)])
        self._often = _changing(entities, still)
        self._runs_code = any(map(state.runs_code, {type(entity) for entity in entities}))

    def _load_entities(self, seldom: bytes, often: Sequence[Sequence[Sequence[Any]]]) -> None:
        """Set the states of all entities."""
        self._list()
        groups = self._often
        given: Iterable[Entity] = chain(*(members for _, members in groups))
        if seldom != self._seldom:
            given = entities = self._world.entities
            still, rows = state.decode(seldom)
            for entity, whole, row in zip(entities, still, rows, strict=True):
                self._load_own_state(_reader(entity, whole), entity, row)
            groups = _changing(entities, still)
        for (reader, members), rows in zip(groups, often, strict=True):
            for entity, row in zip(members, rows, strict=True):
                self._load_own_state(reader, entity, row)
        for entity in given:
            entity.MasterStatesSet()

    def _load_own_state(self, reader: Reader, entity: Entity, own: Sequence[Any]) -> None:
        """Set the state of an entity; what fails is kept, and the other entities are set all the same."""
        try:
            reader.set(entity, own)
        except GazeboError as error:
            named = error if _described(entity) in str(error) else type(error)(f"{_described(entity)}: {error}")
            self.failures.append(named)
        except USER_ERRORS as error:
            pass_interrupt(error)
            text = f"{_described(entity)}: its state cannot be set:\n{own_traceback(error)}"
            self.failures.append(PluginError(text))


_type: Any = type  # mypy takes a class for no key of a cache


def _count_changes() -> None:
    """Have all be read again that is kept while nothing changes."""
    state.changes.count()
    edits.count()


def _name(thing: Any) -> str:
    return _name_of(_type(thing))


@functools.cache
def _name_of(kind: Any) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


# Entities -----------------------------------------------------------------------------------------------------------


# What decides how an entity is listed.
_relatives = attrgetter("origin", "parent", "parentBody", "_id", "failed", "plugin_error")


def _listed_entity(entity: Entity, sources: dict[Source, int], number: dict[Entity, int]) -> dict[str, Any]:
    origin = entity.origin
    parent, body = _holder(entity, number)
    return {
        "origin": (sources[origin.source], origin.place) if origin is not None else None,
        "id": entity.GetId(),
        "parent": parent,
        "body": body,
        "failed": _text_of(entity.failed),
        "plugin_error": _text_of(entity.plugin_error),
    }


def _holder(entity: Entity, number: dict[Entity, int]) -> tuple[int | None, int | None]:
    """The numbers of the parent and of the body there that an entity is attached to; None for none."""
    parent, body = entity.parent, entity.parentBody
    if parent is None:
        return None, None
    return number.get(parent), parent.bodies.index(body) if body is not None else None


def _reader(entity: Entity, whole: bool) -> Reader:
    """What reads the state of an entity as a whole, or what of it seldom changes."""
    return state.whole(_type(entity)) if whole else state.readers(_type(entity))[0]


def _changing(entities: Sequence[Entity], still: Sequence[bool]) -> list[tuple[Reader, list[Entity]]]:
    """The entities of which more than what seldom changes is to be read, by their classes."""
    groups: dict[Reader, list[Entity]] = {}
    for entity, whole in zip(entities, still, strict=True):
        reader = state.readers(_type(entity))[1]
        if not whole and reader.fields:
            groups.setdefault(reader, []).append(entity)
    return list(groups.items())


def _own_states(reader: Reader, entities: Sequence[Entity]) -> Sequence[Any]:
    try:
        return reader.rows(entities)
    except (GazeboError, *USER_ERRORS):
        return [_own_state(reader, entity) for entity in entities]  # reports whose it is


def _check(entity: Entity, cause: Exception) -> None:
    """Raise an error that names an attribute of an entity, if that is what cannot be encoded."""
    try:
        state.check(entity)
    except ParameterError as error:
        raise ParameterError(f"{_described(entity)}: {error}") from cause


def _own_state(reader: Reader, entity: Entity) -> Sequence[Any]:
    try:
        return reader.get(entity)
    except GazeboError:
        raise
    except RecursionError as error:
        _check(entity, error)
        raise ParameterError(f"{_described(entity)}: its state cannot be saved: {state.TOO_DEEP}") from error
    except USER_ERRORS as error:
        pass_interrupt(error)
        raise PluginError(f"{_described(entity)}: its state cannot be saved:\n{own_traceback(error)}") from error


def _described(entity: Entity) -> str:
    return f"model {entity.GetId()!r} ({type(entity).__name__})"


def _load_relatives(world: World, entity: Entity, kept: dict[str, Any]) -> None:
    parent = world.entities[kept["parent"]] if kept["parent"] is not None else None
    body = parent.bodies[kept["body"]] if parent is not None and kept["body"] is not None else None
    if parent is not entity.parent or body is not entity.parentBody:
        entity.MasterAttach(parent, body)
    for name in ("failed", "plugin_error"):
        if _text_of(getattr(entity, name)) != kept[name]:
            setattr(entity, name, StoppedError(kept[name]) if kept[name] is not None else None)


def _text_of(error: object) -> str | None:
    """An error as text; None for none, and for what models of users may keep under such a name."""
    if not isinstance(error, BaseException):
        return None
    return str(error) if isinstance(error, StoppedError) else f"{type(error).__name__}: {error}"


def _restore_entities(world: World, listed: dict[str, Any], keep: int) -> None:
    """Make the world's entities those of a state: from the first one that differs, all are built again, in order.

    At most so many are kept.
    """
    sources = [Source(*fields) for fields in listed["sources"]]
    wanted = [
        Origin(sources[kept["origin"][0]], kept["origin"][1]) if kept["origin"] is not None else None
        for kept in listed["entities"]
    ]
    number = {entity: index for index, entity in enumerate(world.entities)}
    present = [(entity.origin, *_holder(entity, number)) for entity in world.entities]
    then = [(origin, kept["parent"], kept["body"]) for origin, kept in zip(wanted, listed["entities"], strict=True)]
    if present == then and keep >= len(present):
        return
    pairs = enumerate(zip(present, then, strict=False))
    same = min(keep, next((i for i, (old, new) in pairs if old != new), min(len(present), len(then))))
    # Whoever was attached to one of those that go is built again, too: the order of joints is part of the state.
    while (
        held := next((i for i, (_, at, _) in enumerate(present[:same]) if at is not None and at >= same), None)
    ) is not None:
        same = held
    missing: list[Origin] = []
    for kept, origin in zip(listed["entities"][same:], wanted[same:], strict=True):
        if origin is None:
            raise StateError(f"model {kept['id']!r} cannot be built again: it was made by code, not from a file")
        if origin.source.builder not in world.journal.builders:
            raise StateError(f"model {kept['id']!r} cannot be built again: this world has no {origin.source.builder}")
        missing.append(origin)
    with world.gz_server.keep_released() if missing else contextlib.nullcontext():
        world.remove(world.entities[same:])
        for source, places in Journal.runs(missing):
            count = len(world.entities)
            world.journal.builders[source.builder].rebuild(source, places)
            world.initialize(world.entities[count:])
        expected = set(missing)
        surplus = [entity for entity in world.entities[same:] if entity.origin not in expected]
        world.remove(surplus)  # what an Init inserted, and what was not there any more
    if [entity.origin for entity in world.entities] != wanted:
        raise StateError("the models of this state could not all be built again, or not in their order")
