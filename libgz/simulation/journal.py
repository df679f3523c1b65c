"""Journal: where the entities of a world come from, so that those of another moment can be built again."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol

__all__ = ["Builder", "Journal", "Origin", "Source"]


class Source(NamedTuple):
    """A document that entities were built from.

    Attributes:
        builder: the name of who builds from it, in `Journal.builders`.
        number: 0 for the world's own file; documents that were inserted count on from there.
        label: its name in messages.
        text: what was inserted; empty for the world's own file.
    """

    builder: str
    number: int
    label: str
    text: bytes


class Origin(NamedTuple):
    """Where an entity comes from: a place in a document.

    Attributes:
        source: the document.
        place: the number of its element there, counted as the builder likes.
    """

    source: Source
    place: int


class Builder(Protocol):
    """Builds entities from documents: an era."""

    def rebuild(self, source: Source, places: Sequence[int]) -> None:
        """Build the entities of these places again, and adopt them with their origins, in this order.

        They are initialized by the caller.

        Raises:
            GazeboError: one of them cannot be built.
        """


class Journal:
    """What was inserted into a world, counted.

    Attributes:
        builders: who can build entities again, by name; eras register here.
        inserted: how many documents were inserted since the world began.
    """

    def __init__(self) -> None:
        self.builders: dict[str, Builder] = {}
        self.inserted = 0

    def insertion(self, builder: str, label: str, text: bytes) -> Source:
        """A source for a document that is inserted now."""
        self.inserted += 1
        return Source(builder, self.inserted, label, text)

    @staticmethod
    def runs(origins: Iterable[Origin]) -> list[tuple[Source, list[int]]]:
        """Origins, grouped where several of one source follow each other."""
        return [
            (source, [origin.place for origin in group])
            for source, group in itertools.groupby(origins, lambda origin: origin.source)
        ]
