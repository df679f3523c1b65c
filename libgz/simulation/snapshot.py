"""Snapshots: the whole state of a world as bytes, and a world brought back to such a state."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from libgz.errors import USER_ERRORS, GazeboError, ParameterError, StateError, pass_interrupt
from libgz.simulation import state
from libgz.simulation.journal import Journal, Origin, Source
from libgz.simulation.plugins import own_traceback

if TYPE_CHECKING:
    from libgz.simulation.companion import Companion
    from libgz.simulation.entity import Entity
    from libgz.simulation.world import World
    from libgz.transport.interface import Interface

__all__ = ["restore", "save"]


class StoppedError(GazeboError):
    """What an entity had raised in the world that a state was saved of."""


def save(world: World) -> bytes:
    """The state of a world between two steps.

    Raises:
        ParameterError: an object declares something as its state that is not plain data, or cannot be read.
    """
    number = {entity: index for index, entity in enumerate(world.entities)}
    origins = [entity.origin for entity in world.entities]
    sources = {source: i for i, source in enumerate(dict.fromkeys(o.source for o in origins if o is not None))}
    plain = {
        "file": world.era.digest,
        "world": state.get_state(world),
        "spawned": world.spawned,
        "inserted": world.journal.inserted,
        "sources": [tuple(source) for source in sources],
        "entities": [_saved_entity(entity, sources, number) for entity in world.entities],
        "followers": [number[entity] for entity in world.followers],
        "companions": {name: kept for name, kept in map(_saved_companion, world.companions) if kept is not None},
        "extensions": {_name(e): state.get_state(e) for e in world.extensions if _declares(e)},
        "engine": world.engine.get_state(),
        "interfaces": {key: interface.get_bytes() for key, interface in _interfaces(world)},
    }
    try:
        return state.encode(plain)
    except ParameterError as error:
        for entity in world.entities:
            try:
                state.encode(entity.MasterSaveState())
            except ParameterError as own:
                raise ParameterError(f"{_described(entity)}: {own}") from error
        raise


def restore(world: World, data: bytes, *, anew: bool = False) -> None:
    """Bring a world into a state that `save` returned, of itself or of another world of the same file.

    Args:
        world: the world.
        data: the state.
        anew: whether all entities are built again, also those that are there.

    Raises:
        StateError: the state is of another file, or something that cannot be built again is missing.
        ParameterError: these bytes are no state.
    """
    saved = state.decode(data)
    if saved["file"] != world.era.digest:
        raise StateError("this state is of another world: its file has another text than this world's")
    if saved["companions"] and not saved["companions"].keys() <= set(map(_name, world.companions)):
        world.attach_era()
        for name in saved["companions"].keys() - set(map(_name, world.companions)):
            raise StateError(f"this state has a part that this world has not: {name}")
    _restore_entities(world, saved, anew)
    for companion in world.companions:
        companion.entities_rebuilt()
    state.set_state(world, saved["world"])
    world.restart_random(saved["spawned"])
    world.journal.inserted = saved["inserted"]
    for entity, kept in zip(world.entities, saved["entities"], strict=True):
        _load_entity(world, entity, kept)
    world.update_rows_changed()
    world.followers[:] = [world.entities[index] for index in saved["followers"]]
    for companion in world.companions:
        companion.set_state(saved["companions"].get(_name(companion)))
    for extension in world.extensions:
        if _name(extension) in saved["extensions"]:
            state.set_state(extension, saved["extensions"][_name(extension)])
    world.engine.set_state(saved["engine"])
    for key, interface in _interfaces(world):
        if key in saved["interfaces"]:
            interface.set_bytes(saved["interfaces"][key])


def _saved_companion(companion: Companion) -> tuple[str, object]:
    return _name(companion), companion.get_state()


def _declares(thing: Any) -> bool:
    kind: Any = type(thing)
    return state.declares(kind)


def _name(thing: Any) -> str:
    return f"{type(thing).__module__}.{type(thing).__qualname__}"


# Entities -----------------------------------------------------------------------------------------------------------


def _saved_entity(entity: Entity, sources: dict[Source, int], number: dict[Entity, int]) -> dict[str, Any]:
    origin = entity.origin
    parent, body = (None, None) if entity.parent is None else _holder(entity, number)
    failed, plugin_error = entity.failed, entity.plugin_error
    return {
        "origin": (sources[origin.source], origin.place) if origin is not None else None,
        "id": entity.GetId(),
        "parent": parent,
        "body": body,
        "failed": None if failed is None else _text_of(failed),
        "plugin_error": None if plugin_error is None else _text_of(plugin_error),
        "state": _own_state(entity),
    }


def _holder(entity: Entity, number: dict[Entity, int]) -> tuple[int | None, int | None]:
    """The numbers of the parent and of the body there that an entity is attached to; None for none."""
    parent, body = entity.parent, entity.parentBody
    if parent is None:
        return None, None
    return number.get(parent), parent.bodies.index(body) if body is not None else None


def _own_state(entity: Entity) -> object:
    try:
        return entity.MasterSaveState()
    except GazeboError:
        raise
    except USER_ERRORS as error:
        pass_interrupt(error)
        raise ParameterError(f"{_described(entity)}: its state cannot be saved:\n{own_traceback(error)}") from error


def _described(entity: Entity) -> str:
    return f"model {entity.GetId()!r} ({type(entity).__name__})"


def _load_entity(world: World, entity: Entity, kept: dict[str, Any]) -> None:
    parent = world.entities[kept["parent"]] if kept["parent"] is not None else None
    body = parent.bodies[kept["body"]] if parent is not None and kept["body"] is not None else None
    if parent is not entity.parent or body is not entity.parentBody:
        entity.MasterAttach(parent, body)
    for name in ("failed", "plugin_error"):
        if _text_of(getattr(entity, name)) != kept[name]:
            setattr(entity, name, StoppedError(kept[name]) if kept[name] is not None else None)
    try:
        entity.MasterLoadState(kept["state"])
    except GazeboError:
        raise
    except USER_ERRORS as error:
        pass_interrupt(error)
        raise StateError(f"{_described(entity)}: its state cannot be set:\n{own_traceback(error)}") from error


def _text_of(error: object) -> str | None:
    """An error as text; None for none, and for what models of users may keep under such a name."""
    if not isinstance(error, BaseException):
        return None
    return str(error) if isinstance(error, StoppedError) else f"{type(error).__name__}: {error}"


def _restore_entities(world: World, saved: dict[str, Any], anew: bool) -> None:
    """Make the world's entities those of a state: from the first one that differs, all are built again, in order."""
    sources = [Source(*fields) for fields in saved["sources"]]
    wanted = [
        Origin(sources[kept["origin"][0]], kept["origin"][1]) if kept["origin"] is not None else None
        for kept in saved["entities"]
    ]
    number = {entity: index for index, entity in enumerate(world.entities)}
    present = [(entity.origin, *_holder(entity, number)) for entity in world.entities]
    then = [(origin, kept["parent"], kept["body"]) for origin, kept in zip(wanted, saved["entities"], strict=True)]
    if present == then and not anew:
        return
    pairs = enumerate(zip(present, then, strict=False))
    same = 0 if anew else next((i for i, (old, new) in pairs if old != new), min(len(present), len(then)))
    # Whoever was attached to one of those that go is built again, too: the order of joints is part of the state.
    while (
        held := next((i for i, (_, at, _) in enumerate(present[:same]) if at is not None and at >= same), None)
    ) is not None:
        same = held
    missing: list[Origin] = []
    for kept, origin in zip(saved["entities"][same:], wanted[same:], strict=True):
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


# Interfaces ---------------------------------------------------------------------------------------------------------


def _interfaces(world: World) -> list[tuple[tuple[str, str], Interface[Any]]]:
    return sorted(world.gz_server.interfaces.items(), key=lambda item: item[0])
