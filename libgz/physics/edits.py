"""Edits: how often something was assigned that a state has of bodies, geoms, joints, spaces and looks."""

from __future__ import annotations

import itertools
from typing import Any, ClassVar

__all__ = ["Edited", "edits"]


class Edits:
    """A count of assignments, of all worlds, so that an unchanged count means that nothing was assigned.

    Attributes:
        last: differs after each assignment.
    """

    __slots__ = ("_numbers", "last")

    def __init__(self) -> None:
        self._numbers = itertools.count(1)
        self.last = 0

    def count(self) -> None:
        """Count an assignment; safe in every thread."""
        self.last = next(self._numbers)


edits = Edits()


class Edited:
    """Base of what counts the assignments of its attributes: its handle, its bodies, its end, and what KEPT names."""

    KEPT: ClassVar[tuple[str, ...]] = ()
    _counted: ClassVar[set[str]] = {"_id", "bodies", "_feedback", "_closed"}

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        Edited._counted.update(cls.KEPT)

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)
        if name in Edited._counted:
            edits.count()
