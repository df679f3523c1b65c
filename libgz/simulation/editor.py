"""Editor: what can be edited in a world, and the history of edits, which undo and redo go through.

An edit changes the text of the world's file first; then what the text describes is built again. So the text is always
that of the world, and saving, differences and resets follow from it. `LegacyEditor` and `SdfEditor` do that.
"""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import MutableSequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from libgz.base.errors import ParameterError
from libgz.simulation.entity import Entity
from libgz.simulation.world import World

__all__ = ["Editor", "History", "Moment", "Value", "numbers_of", "return_to"]

MOST_MOMENTS = 100
MOST_BYTES = 256 << 20  # of all moments of a history
LONGEST_TEXT = 1 << 16  # characters of a text value
LARGEST = sys.float_info.max


@dataclass
class Value:
    """One value that can be edited.

    Attributes:
        key: by which `Editor.edit` knows it.
        type: number, integer, vector, bool, choice, text or color; or include, for the file that the others are in.
        value: at present: a number, a list of numbers, a bool or a text.
        text: as the file has it; empty if it is not given there, and has its default.
        low, high, above: limits in the file's unit; None for none. `above` itself is excluded.
        options: the words that are allowed, for a choice.
        file, line: where it is, or its element.
        reason: why it cannot be edited; empty if it can.
    """

    key: str
    label: str
    group: str
    type: str
    value: Any
    text: str = ""
    unit: str = ""
    low: float | None = None
    high: float | None = None
    above: float | None = None
    options: list[str] = field(default_factory=list)
    help: str = ""
    file: str = ""
    line: int = 0
    reason: str = ""


class Editor(Protocol):
    """Edits the file of a world, and the world with it; an era has one."""

    def values(self, entity: Entity | None, part: str, kind: str) -> list[Value]:
        """What can be edited.

        Args:
            entity: of which; None for the world's settings.
            part: the name of one of its links, joints or sensors; empty for itself.
            kind: link, joint or sensor, for a part.

        Raises:
            NotFoundError: there is no such part.
        """

    def edit(self, entity: Entity | None, part: str, kind: str, key: str, value: Any) -> Entity | None:
        """Change a value; the entity that is there now. What fails may leave the world changed: see `return_to`.

        Raises:
            GazeboError: the value is not allowed, or the edited text cannot be built.
        """

    def embed(self, entity: Entity) -> Entity:
        """Write what the file of the world includes into it, so that all of it can be edited; the entity then.

        Raises:
            GazeboError: it is not included, or cannot be.
        """

    def copy_text(self, entity: Entity) -> str:
        """The text of a copy of an entity, for an insertion, with names of its own.

        Raises:
            GazeboError: it has no text.
        """


def numbers_of(value: Any, least: int, most: int) -> list[float]:
    """Finite numbers of a request.

    Raises:
        ParameterError: they are not numbers, not finite, or not that many.
    """
    values = value if isinstance(value, list) else [value]
    good = all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) <= LARGEST for v in values)
    if not good or not least <= len(values) <= most:
        count = f"{least}" if least == most else f"{least} to {most}"
        raise ParameterError(f"{value!r} is not allowed; it must be {count} finite number{'s' * (most > 1)}")
    return [float(v) for v in values]


class Moment(NamedTuple):
    """A world before a change: its state and the text of its file; `label` says what the change is."""

    label: str
    state: bytes
    text: bytes

    @classmethod
    def of(cls, world: World, label: str) -> Moment:
        """The present one.

        Raises:
            GazeboError: the state of the world cannot be saved.
        """
        with world.lock:
            return cls(label, world.snapshots.save(), world.era.text)


def return_to(world: World, moment: Moment) -> None:
    """Bring a world back to a moment, with the text of its file.

    Raises:
        GazeboError: a model of it cannot be built again.
    """
    edited = world.era.text != moment.text
    if edited:
        world.era.set_text(moment.text)
        world.forget_states()
    with world.hold():
        world.snapshots.restore(moment.state, anew=edited)


class History:
    """The moments before changes, and those before what was undone; the oldest are dropped where they are too many."""

    def __init__(self) -> None:
        self.done: deque[Moment] = deque()
        self.undone: list[Moment] = []

    def add(self, moment: Moment) -> None:
        """Add the moment before a change; what was undone cannot be redone any more."""
        self.undone.clear()
        self.done.append(moment)
        self._bound()

    def clear(self) -> None:
        """Drop all."""
        self.done.clear()
        self.undone.clear()

    def undo(self, world: World) -> str | None:
        """Undo the last change; what it was, or None if there is none.

        Raises:
            GazeboError: the world cannot be brought back; it stays as it is.
        """
        return self._go(world, self.done, self.undone)

    def redo(self, world: World) -> str | None:
        """Do the change again that was undone last; what it was, or None if there is none.

        Raises:
            GazeboError: the world cannot be brought there; it stays as it is.
        """
        return self._go(world, self.undone, self.done)

    def _go(self, world: World, moments: MutableSequence[Moment], others: MutableSequence[Moment]) -> str | None:
        """Go to the last of some moments; the present one joins the others."""
        if not moments:
            return None
        moment = moments[-1]
        before = Moment.of(world, moment.label)
        _exchange(world, before, moment)
        moments.pop()
        others.append(before)
        self._bound()
        return moment.label

    def _bound(self) -> None:
        while len(self.done) + len(self.undone) > 1 and (
            len(self.done) + len(self.undone) > MOST_MOMENTS or self._size > MOST_BYTES
        ):
            if self.done:
                self.done.popleft()
            else:
                del self.undone[0]

    @property
    def _size(self) -> int:
        return sum(len(moment.state) + len(moment.text) for moment in (*self.done, *self.undone))


def _exchange(world: World, before: Moment, moment: Moment) -> None:
    try:
        return_to(world, moment)
    except BaseException:
        return_to(world, before)
        raise
