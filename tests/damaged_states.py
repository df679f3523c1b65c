"""States with something wrong in them, for trials and fuzzing: values dropped, doubled, exchanged or replaced."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from libgz.base.encoding import FORMAT, decode, encode
from libgz.base.errors import GazeboError

__all__ = ["damage"]

ODD = (
    *(None, True, -1, 0, 2**40, -(2**70), 1e308, -1e308, float("nan"), float("inf"), "", "x", b"", b"\xff" * 9, (), []),
    *({}, (1,)),
)


class Opened:
    """A value of a state that has others in it, opened up so that one of them can be replaced.

    Attributes:
        kind: a class; None for what is encoded within.
        items: what is in it; of a dict (key, value) one after the other.
    """

    def __init__(self, kind: Any, items: list[Any]) -> None:
        self.kind, self.items = kind, items

    def closed(self) -> Any:
        """The value again, with what was replaced."""
        items = [item.closed() if isinstance(item, Opened) else item for item in self.items]
        if self.kind is None:
            return encode(items[0])
        if self.kind is dict:
            return dict(zip(items[::2], items[1::2], strict=False))
        return self.kind(*items) if hasattr(self.kind, "_fields") else self.kind(items)

    def places(self) -> Iterator[tuple[Opened, int]]:
        """All places of values in it."""
        for i, item in enumerate(self.items):
            yield self, i
            if isinstance(item, Opened):
                yield from item.places()


def opened(value: Any) -> Any:
    """A value with all containers in it opened."""
    if isinstance(value, bytes):
        return Opened(None, [opened(decode(value))]) if value.startswith(FORMAT) else value
    if isinstance(value, dict):
        return Opened(dict, [opened(part) for pair in value.items() for part in pair])
    return Opened(type(value), list(map(opened, value))) if isinstance(value, (tuple, list)) else value


def damage(rng: random.Random, data: bytes) -> tuple[bytes, str]:
    """A state with something wrong in it, and what that is."""
    tree = opened(data)
    places = list(tree.places()) if isinstance(tree, Opened) else []
    if not places:
        return data, "nothing"
    holder, i = rng.choice(places)
    value = holder.items[i]
    if isinstance(value, Opened) and value.items and rng.random() < 0.7:
        items, at = value.items, rng.randrange(len(value.items))
        how = rng.choice(("drop", "double", "exchange"))
        if how == "drop":
            del items[at]
        elif how == "double":
            items.insert(at, items[at])
        else:
            items[at], items[-1] = items[-1], items[at]
    elif isinstance(value, bytes) and value and rng.random() < 0.8:
        at = rng.randrange(len(value))
        how = rng.choice(("flipped", "shorter", "longer"))
        flipped = value[:at] + bytes([value[at] ^ (1 << rng.randrange(8))]) + value[at + 1 :]
        holder.items[i] = {"flipped": flipped, "shorter": value[:at], "longer": value + value[at:]}[how]
    else:
        how = "replaced"
        holder.items[i] = rng.choice(ODD)
    try:
        return tree.closed(), f"{how} in {holder.kind}: {str(value)[:60]!r}"
    except (TypeError, ValueError, IndexError, GazeboError):  # no such dict, or not plain any more
        return data, "nothing"
