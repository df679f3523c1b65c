"""Received: what pages have sent that has not been acted on, such as parts of messages, and its bound."""

from __future__ import annotations

from typing import Protocol

__all__ = ["Received", "Sender", "wire_size"]

TOO_MUCH = "the one with the most of what pages have sent, which was too much together"
FRAME = 1 << 10  # [byte] that the frames of a large message have on average, at least


class Sender(Protocol):
    """A page, as far as its messages are counted."""

    received: int  # bytes that have not been acted on

    def abort(self, reason: str) -> None:
        """Close it at once."""


class Received:
    """Counts bytes from pages until their message has been acted on. Above the limit the page with the most is closed.

    Args:
        limit: of all pages together [byte].

    Attributes:
        size: of all pages [byte].
    """

    def __init__(self, limit: int) -> None:
        self.size = 0
        self._limit = limit
        self._pages: set[Sender] = set()

    def add(self, page: Sender, count: int) -> None:
        """Count bytes of a page."""
        self._pages.add(page)
        page.received += count
        self.size += count
        while self.size > self._limit:
            largest = max(self._pages, key=lambda one: one.received)
            self.forget(largest)
            largest.abort(TOO_MUCH)

    def remove(self, page: Sender, count: int) -> None:
        """Bytes of a page, or all that it has if these are fewer, have been acted on."""
        count = min(count, page.received)
        page.received -= count
        self.size -= count

    def forget(self, page: Sender) -> None:
        """Nothing of a page is held any more."""
        self.remove(page, page.received)
        self._pages.discard(page)


def wire_size(size: int) -> int:
    """The bytes that a message took on the wire, if its page did not cut it into small frames: else it counts more."""
    return size + (6 if size < 126 else 8 if size < 1 << 16 else 14 + size // FRAME)
