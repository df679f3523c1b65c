"""Ids: the numbers by which messages name views."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from libgz.classic.physics.base import Base
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.light import Light
from libgz.classic.physics.model import Model
from libgz.classic.physics.place import found_at, place_if_there

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["Ids"]


class Ids:
    """The ids of a world's views, given when they are first asked for, so that a state can repeat them.

    And the names of those that were renamed.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._last = 0
        self._numbers: WeakKeyDictionary[Base, int] = WeakKeyDictionary()
        self._names: WeakKeyDictionary[Base, str] = WeakKeyDictionary()  # of renamed views, before that

    def of(self, view: Base) -> int:
        """The id of a view."""
        found = self._numbers.get(view)
        if found is None:
            self._last = self._numbers[view] = found = self._last + 1
        return found

    def rename(self, view: Base, name: str) -> None:
        """Rename a view."""
        self._names.setdefault(view, view._name)
        view._name = name
        self._world.server.activity.renamed()

    @property
    def new_names(self) -> set[str]:
        """The names of models and lights, and of their parts, that were renamed."""
        return {view._name for view, before in self._names.items() if view._name != before and self._present(view)}

    def save(self) -> tuple[Any, ...]:
        """Ids and changed names as plain data."""
        if not (self._numbers or self._names):
            return self._last, [], []
        rows = ((self._place(view), number) for view, number in self._numbers.items())
        names = ((self._place(view), view._name) for view, before in self._names.items() if view._name != before)
        numbers = sorted((row for row in rows if row[0] is not None), key=lambda row: row[1])
        return self._last, numbers, sorted((row for row in names if row[0] is not None), key=repr)

    def load_names(self, state: Sequence[Any], *, of_models: bool = False) -> None:
        """Take the names of a state, or of models and lights alone; sensors and plugins are found by them."""
        _, _, names = state
        for view, name in [*self._names.items()]:
            self.rename(view, name)
        rows = [row for row in names if not of_models or row[0][1:] == (-1, -1)]
        for view, name in [(self._at(place), name) for place, name in rows]:
            if view is not None:
                self.rename(view, name)

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned."""
        self.load_names(state)
        self._last, rows, _ = state
        views = [(self._at(place), number) for place, number in rows]
        self._numbers = WeakKeyDictionary({view: number for view, number in views if view is not None})

    def _place(self, view: Any) -> tuple[Any, ...] | None:
        """Where a view stands; None if it, or its model, was removed."""
        if view is self._world:
            return ()
        if not isinstance(view, Joint):
            return place_if_there(view) if self._present(view) else None
        model = view.model_around()
        return (model.core.GetId(), view.core.name) if model is not None and self._present(model) else None

    def _present(self, view: Any) -> bool:
        """Whether the model or light that it is, or is a part of, is in the world."""
        part = view
        while not isinstance(part, (Model, Light)):
            part = part._parent
            if part is None:
                return False
        return part.core in self._world.core.entities

    def _at(self, place: Sequence[Any]) -> Any:
        if not place:
            return self._world
        if len(place) == 3:
            return found_at(self._world, (place[0], place[1], place[2]))
        model = self._world.model_of(place[0])
        joints: Iterable[Joint] = model.GetJoints() if model is not None else ()
        return next((joint for joint in joints if joint.core.name == place[1]), None)
