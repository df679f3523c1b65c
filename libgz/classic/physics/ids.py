"""Ids: the numbers by which messages name views."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from libgz.classic.physics.base import Base
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.place import found_at, place_of

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["Ids"]


class Ids:
    """The ids of a world's views, given when they are first asked for, so that a state can repeat them."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._last = 0
        self._numbers: WeakKeyDictionary[Base, int] = WeakKeyDictionary()

    def of(self, view: Base) -> int:
        """The id of a view."""
        found = self._numbers.get(view)
        if found is None:
            self._last = self._numbers[view] = found = self._last + 1
        return found

    def save(self) -> tuple[Any, ...]:
        """The ids as plain data."""
        if not self._numbers:
            return self._last, []
        rows = ((self._place(view), number) for view, number in self._numbers.items())
        return self._last, sorted((row for row in rows if row[0] is not None), key=lambda row: row[1])

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned."""
        self._last, rows = state
        views = [(self._at(place), number) for place, number in rows]
        self._numbers = WeakKeyDictionary({view: number for view, number in views if view is not None})

    def _place(self, view: Any) -> tuple[Any, ...] | None:
        """Where a view stands; None if it, or its model, was removed."""
        if view is self._world:
            return ()
        if not isinstance(view, Joint):
            try:
                return place_of(view) if self._present(view) else None
            except ValueError:  # a link or collision that was removed since
                return None
        model = view.GetParentModel()
        return (model.core.GetId(), view.core.name) if model is not None and self._present(model) else None

    def _present(self, view: Any) -> bool:
        part = view
        while part._parent is not None:
            part = part._parent
        return part.core in self._world.core.entities

    def _at(self, place: Sequence[Any]) -> Any:
        if not place:
            return self._world
        if len(place) == 3:
            return found_at(self._world, (place[0], place[1], place[2]))
        model = self._world.ModelByName(place[0])
        joints: Iterable[Joint] = model.GetJoints() if model is not None else ()
        return next((joint for joint in joints if joint.core.name == place[1]), None)
