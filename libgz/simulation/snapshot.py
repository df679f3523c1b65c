"""Snapshots: the whole state of a world as bytes, and a world brought back to such a state.

A state is read when it is asked for: nothing notices what is assigned, nothing is kept from one state to the next.
`simulation/state.py` reads what classes declare, `base/encoding.py` writes it so that equal states are equal bytes.

`Snapshots.restore` acts in an order that matters:

1. Checks: the file's digest, and whether what has to be built again can be. Until here nothing has changed. Then the
   present state is taken.
2. Journal (`journal.py`): each entity has an `Origin`, a place in the file or in an inserted text. From the first one
   on that differs, by origin or by parent, all are removed and built again in the order of the state, because the order
   of bodies decides last bits. One that held others takes them with it. Interfaces keep files, locks and numbers
   meanwhile (`keep_released`).
3. The world's attributes, random numbers and the count of insertions.
4. Entities: of each the attributes of `STATE`, then `LoadState`. That may make and remove links. Then come the joints
   of models (`_entity_states_set`), for those hold links of other models.
5. Companions and extensions. Classic's companion (`classic/server.py`) has names first, by which others are found, then
   sensors, controllers, animations, what plugins changed of visuals, waiting messages, and plugins.
6. The engine: it overwrites whatever the phases before did, and closes bodies, geoms and joints that came since.
7. Interface bytes. So commands of clients that were waiting act again.

If the companions had to load or drop plugins, all phases run once more, since `Load` can change anything. What a
plugin added to the world ends with it, not when Python collects it (`AtEnd` in `event.py`).

If a phase fails, the state is damaged, and the state that was taken before the first phase is set in the same way.
`tests/trials/test_damaged_states.py` replaces values within states, `tests/simulation/test_state_attacks.py` attacks.

A reset is `set_state` of the state that `Initialize` kept at its end. Classic's plugins are not in that one: their
`Reset()` is called. `SdfWorld.start` sorts geoms once before it, since a fresh world's order depends on how it was
built. After it, callbacks are in the order of the start again, also of plugins that were loaded anew since. Plugins
of a state that do not run are loaded before its joints and links return. Where code made some, models are built again
from the first of these on, because a `Load` that makes a joint fails if it is there.

A clone has a name of its own for topics, `World.topic_space`: topics belong to the process and not to the world, so
that equal names would be equal topics. `Node.Init` translates the name of the world for the clone's plugins.
"""

from __future__ import annotations

import contextlib
import functools
import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from libgz.base.encoding import TOO_DEEP
from libgz.base.errors import (
    USER_ERRORS,
    GazeboError,
    ParameterError,
    PluginError,
    StateError,
    StrictError,
    pass_interrupt,
)
from libgz.base.trust import without_trust
from libgz.simulation import state
from libgz.simulation.journal import Journal, Origin, Source
from libgz.simulation.plugins import own_traceback

if TYPE_CHECKING:
    from libgz.simulation.entity import Entity
    from libgz.simulation.world import World
    from libgz.transport.interface import Interface

__all__ = ["Snapshots"]

log = logging.getLogger("libgz.simulation")

# What a state consists of, in order.
PARTS = ("list", "world", "random", "entities", "companions", "extensions", "engine", "interfaces")


class StoppedError(GazeboError):
    """What an entity had raised in the world that a state was saved of."""


class Snapshots:
    """Takes the states of a world, and brings it back to them.

    Args:
        world: the World.

    Attributes:
        failures: what code of users raised while a state was set, such as a LoadState; all else of the state was set.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self.failures: list[GazeboError] = []
        # The state that was set last, if no code of users had a part in it, and its parts.
        self._proven: tuple[bytes, dict[str, Any]] | None = None

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
        plain = {
            "list": self._list(),
            "world": state.get_values(world),
            "random": [world.spawned, world.journal.inserted, world.seed],
            "entities": [_own_state(entity) for entity in world.entities],
            "companions": {
                _name(companion): kept for companion in world.companions if (kept := companion.get_state()) is not None
            },
            "extensions": {name: state.get_values(extension) for name, extension in self._extensions()},
            "engine": world.engine.read_state(),
            "interfaces": [[*key, interface.get_bytes()] for key, interface in sorted(self._interfaces().items())],
        }
        try:
            return state.encode([world.era.digest, list(plain["companions"]), state.encode(plain)])
        except USER_ERRORS as error:  # also of objects within a state, whose SaveState is called as it is written
            pass_interrupt(error)
            for entity in world.entities:
                _check(entity, error)
            for companion in world.companions:
                companion.check_state()
            raise

    def restore(self, data: bytes, *, anew: bool = False, untrusted: bool = False) -> None:
        """Bring the world into a state that `save` returned, of itself or of another world of the same file.

        If the state turns out to be damaged, the world is brought back to what it was before.

        Args:
            data: the state.
            anew: whether all entities are built again, also those that are there.
            untrusted: whether a state that needs a plugin to be loaded is refused.

        Raises:
            UntrustedError: it needs one.
            StateError: these bytes are no state, or one of another file, or damaged, or something that cannot be built
                again is missing.
        """
        data = bytes(data)
        proven, self._proven = self._proven, None
        if proven is not None and data is proven[0] and not (anew or untrusted) and self._is_of_libgz(proven[1]):
            saved, before = proven[1], None  # it could be set once, so nothing will have to be undone
        else:
            saved, before = self._decoded(data), self._saved_before()
        try:
            with without_trust() if untrusted else contextlib.nullcontext():
                self._set(data, saved, anew)
            if self.failures:
                raise self.failures[0]
            self._proven = (data, saved) if self._is_of_libgz(saved) else None
        except USER_ERRORS as error:
            cause = self.failures[0] if self.failures else error
            left = self._undo(before) if before is not None else ""
            self._world.update_rows_changed()
            pass_interrupt(error)
            if isinstance(cause, (PluginError, StateError, StrictError)):
                raise type(cause)(f"{cause}{left}") from cause
            name = "" if isinstance(cause, GazeboError) else f"{type(cause).__name__}: "
            raise StateError(f"the state is damaged: {name}{cause}{left}") from cause

    def _is_of_libgz(self, saved: dict[str, Any]) -> bool:
        """Whether no code of users sets a part of a state: then one that could be set once can be set again."""
        extensions = [one for name, one in self._extensions() if name in saved["extensions"]]
        setters = [state.reader(type(one)) for one in (*self._world.entities, *extensions)]
        return not self._world.companions and all(setter.ours for setter in setters)

    def _undo(self, before: bytes) -> str:
        """Set the state from before; the end of a message about what that could not undo, which is mostly empty."""
        try:
            try:
                self._set(before, self._decoded(before), False, undoing=True)
            except USER_ERRORS as error:  # something was destroyed that only building anew brings back
                pass_interrupt(error)
                self._set(before, self._decoded(before), True, undoing=True)
        except USER_ERRORS as error:
            pass_interrupt(error)
            return f"\nwhat was set of it could not be undone: {error}"
        return "".join(f"\nthis could not be undone: {error}" for error in self.failures)

    def _saved_before(self) -> bytes | None:
        try:
            return self.save()
        except GazeboError as error:
            log.debug("a damaged state cannot be undone, as the world's state cannot be saved: %s", error)
            return None

    def _decoded(self, data: bytes) -> dict[str, Any]:
        """The parts of a state of this world, by their names; nothing is changed."""
        world, head = self._world, state.decode(data)
        if not isinstance(head, list) or len(head) != len(("file", "companions", "parts")):
            raise StateError("the state is damaged: it has not the parts of one")
        digest, names, parts = head
        if digest != world.era.digest:
            raise StateError("this state is of another world: its file has another text than this world's")
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise StateError("the state is damaged: it does not name its parts")
        present = set(map(_name, world.companions))
        if not present.issuperset(names):
            world.attach_era()
            for name in sorted({*names}.difference(map(_name, world.companions))):
                raise StateError(f"this state has a part that this world has not: {name}")
        saved = state.decode(parts) if isinstance(parts, bytes) else None
        if not isinstance(saved, dict) or saved.keys() != set(PARTS):
            raise StateError("the state is damaged: it has not the parts of one")
        if not isinstance(saved["companions"], dict) or list(saved["companions"]) != names:
            raise StateError("the state is damaged: it has not the parts of one")
        return saved

    def _set(self, data: bytes, saved: dict[str, Any], anew: bool, *, undoing: bool = False) -> None:
        """Set a state: twice if plugins came or went, for their Load may have changed what was set already."""
        self.failures.clear()
        try:
            state.restoring(True)
            again = self._set_once(saved, anew)
            if again and (undoing or not self.failures):
                self.failures.clear()
                state.restoring(True)
                self._set_once(self._decoded(data), False)
        finally:
            state.restoring(False)

    def _set_once(self, saved: dict[str, Any], anew: bool) -> bool:
        """Set a state; whether a companion asks for setting it once more."""
        world, listed = self._world, saved["list"]
        keep = 0 if anew else self._fit_for_plugins(saved)
        other = keep < len(world.entities) or listed != self._list()
        rows = [_Listed(*row) for row in listed["entities"]]
        if other:
            _restore_entities(world, listed, rows, keep)
            now = self._list()
            if (now["kinds"], now["fields"]) != (listed["kinds"], listed["fields"]):
                raise StateError(
                    "models of this state are of other classes now, or their classes declare another STATE"
                )
        for companion in world.companions:
            companion.entities_rebuilt(saved["companions"].get(_name(companion)))
        state.set_values(world, saved["world"])
        spawned, world.journal.inserted, seed = saved["random"]
        if seed != world.seed:
            world.begin_random(seed)
        world.restart_random(spawned)
        if other:
            for entity, row in zip(world.entities, rows, strict=True):
                _load_relatives(world, entity, row)
        self._load_entities(saved["entities"])
        if other:
            world.followers[:] = [world.entities[index] for index in listed["followers"]]
        again = False
        for companion in world.companions:
            again |= companion.set_state(saved["companions"].get(_name(companion)))
        for name, extension in self._extensions():
            if name in saved["extensions"]:
                state.set_values(extension, saved["extensions"][name])
        world.engine.set_state(saved["engine"])
        present = self._interfaces()
        for kind, name, content in saved["interfaces"]:
            interface = present.get((kind, name))
            if interface is not None:
                interface.set_bytes(content)
        # Classes of libgz report what their plans depend on when it is set; what laws have taken is looked at.
        if other or not (self._is_of_libgz(saved) and world.rows.laws_hold()):
            world.update_rows_changed()
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
        return [(_name(one), one) for one in self._world.extensions if state.declares(type(one))]

    def _interfaces(self) -> dict[tuple[str, str], Interface[Any]]:
        """The interfaces by their types and ids."""
        return self._world.gz_server.interfaces

    def _list(self) -> dict[str, Any]:
        """Which entities there are, where they come from, what is attached to what, and who has stopped."""
        world = self._world
        entities = world.entities
        kinds = list(dict.fromkeys(map(_type, entities)))
        number = {entity: index for index, entity in enumerate(entities)}
        origins = [entity.origin for entity in entities]
        sources = {source: i for i, source in enumerate(dict.fromkeys(o.source for o in origins if o is not None))}
        return {
            "sources": [list(source) for source in sources],
            "entities": [list(_listed_entity(entity, sources, number)) for entity in entities],
            "kinds": [kinds.index(type(entity)) for entity in entities],
            "fields": [list(state.fields(kind)) for kind in kinds],
            "followers": [number[entity] for entity in world.followers],
        }

    def _load_entities(self, rows: Sequence[Sequence[Any]]) -> None:
        """Set the states of all entities."""
        entities = list(self._world.entities)
        for entity, own in zip(entities, rows, strict=True):
            self._load_own_state(entity, own)
        for entity in entities:
            entity._entity_states_set()

    def _load_own_state(self, entity: Entity, own: Sequence[Any]) -> None:
        """Set the state of an entity; what fails is kept, and the other entities are set all the same."""
        try:
            state.set_values(entity, own)
        except GazeboError as error:
            named = error if _described(entity) in str(error) else type(error)(f"{_described(entity)}: {error}")
            self.failures.append(named)
        except USER_ERRORS as error:
            pass_interrupt(error)
            if state.reader(type(entity)).ours:
                self.failures.append(StateError(f"{_described(entity)}: the state is damaged: {error}"))
                return
            text = f"{_described(entity)}: its state cannot be set:\n{own_traceback(error)}"
            self.failures.append(PluginError(text))


_type: Any = type  # mypy takes a class for no key of a cache


def _name(thing: Any) -> str:
    return _name_of(_type(thing))


@functools.cache
def _name_of(kind: Any) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


# Entities -----------------------------------------------------------------------------------------------------------


class _Listed(NamedTuple):
    """How an entity is listed.

    Attributes:
        source: the number of the document that it is from; None if it was made by code.
        place: its place there.
        id: its name.
        parent, body: the numbers of the parent, and of the body there, that it is attached to; None for none.
        failed, plugin_error: what it, or its plugin, had raised.
    """

    source: int | None
    place: int
    id: str
    parent: int | None
    body: int | None
    failed: str | None
    plugin_error: str | None


def _listed_entity(entity: Entity, sources: dict[Source, int], number: dict[Entity, int]) -> _Listed:
    origin = entity.origin
    source, place = (sources[origin.source], origin.place) if origin is not None else (None, 0)
    stopped = _text_of(entity.failed), _text_of(entity.plugin_error)
    return _Listed(source, place, entity.GetId(), *_holder(entity, number), *stopped)


def _holder(entity: Entity, number: dict[Entity, int]) -> tuple[int | None, int | None]:
    """The numbers of the parent and of the body there that an entity is attached to; None for none."""
    parent, body = entity.parent, entity.parentBody
    if parent is None:
        return None, None
    return number.get(parent), parent.bodies.index(body) if body is not None else None


def _check(entity: Entity, cause: BaseException) -> None:
    """Raise an error that names an attribute of an entity, if that is what cannot be encoded."""
    try:
        state.check(entity)
    except ParameterError as error:
        raise ParameterError(f"{_described(entity)}: {error}") from cause
    except USER_ERRORS as error:
        pass_interrupt(error)
        raise PluginError(f"{_described(entity)}: its state cannot be saved:\n{own_traceback(error)}") from error


def _own_state(entity: Entity) -> Sequence[Any]:
    try:
        return state.get_values(entity)
    except (ParameterError, RecursionError) as error:
        _check(entity, error)
        text = TOO_DEEP if isinstance(error, RecursionError) else error
        raise ParameterError(f"{_described(entity)}: its state cannot be saved: {text}") from error
    except GazeboError:
        raise
    except USER_ERRORS as error:
        pass_interrupt(error)
        raise PluginError(f"{_described(entity)}: its state cannot be saved:\n{own_traceback(error)}") from error


def _described(entity: Entity) -> str:
    return f"model {entity.GetId()!r} ({type(entity).__name__})"


def _load_relatives(world: World, entity: Entity, row: _Listed) -> None:
    parent = world.entities[row.parent] if row.parent is not None else None
    body = parent.bodies[row.body] if parent is not None and row.body is not None else None
    if parent is not entity.parent or body is not entity.parentBody:
        entity._entity_attach(parent, body)
    for name, text in (("failed", row.failed), ("plugin_error", row.plugin_error)):
        if _text_of(getattr(entity, name)) != text:
            setattr(entity, name, StoppedError(text) if text is not None else None)


def _text_of(error: object) -> str | None:
    """An error as text; None for none, and for what models of users may keep under such a name."""
    if not isinstance(error, BaseException):
        return None
    return str(error) if isinstance(error, StoppedError) else f"{type(error).__name__}: {error}"


def _restore_entities(world: World, listed: dict[str, Any], rows: Sequence[_Listed], keep: int) -> None:
    """Make the world's entities those of a state: from the first one that differs, all are built again, in order.

    At most so many are kept.
    """
    sources = [Source(*fields) for fields in listed["sources"]]
    wanted = [Origin(sources[row.source], row.place) if row.source is not None else None for row in rows]
    number = {entity: index for index, entity in enumerate(world.entities)}
    present = [(entity.origin, *_holder(entity, number)) for entity in world.entities]
    then = [(origin, row.parent, row.body) for origin, row in zip(wanted, rows, strict=True)]
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
    for row, origin in zip(rows[same:], wanted[same:], strict=True):
        if origin is None:
            raise StateError(f"model {row.id!r} cannot be built again: it was made by code, not from a file")
        if origin.source.builder not in world.journal.builders:
            raise StateError(f"model {row.id!r} cannot be built again: this world has no {origin.source.builder}")
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
