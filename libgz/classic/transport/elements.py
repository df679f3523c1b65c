"""Elements: how many messages a message has in it, and texts in lists, counted before it is decoded.

In its bytes an empty element takes two, decoded a hundred times as many, and each costs its handler up to 0.1 ms.
"""

from __future__ import annotations

import functools
from typing import Any

from libgz.base.errors import ParameterError

__all__ = ["MOST", "MOST_OF_COMMANDS", "check_elements"]

MOST = 100_000  # messages, and texts in lists, in a message
MOST_OF_COMMANDS = 10_000  # the same in one that a world's own handlers take
FIELDS = 10  # that are looked at, for each of those
_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5  # types on the wire


def check_elements(kind: Any, data: bytes, most: int = MOST) -> None:
    """Raise ParameterError if the bytes of a message of some type (its descriptor) have more than `most` elements.

    Damaged bytes are not refused: who decodes them does that.
    """
    if len(data) > 2 * most and _lists(kind):
        try:
            _count(kind, data, most)
        except IndexError:
            return


def _count(kind: Any, data: bytes, most: int) -> None:
    elements = fields = 0
    waiting = [(kind, 0, len(data))]
    while waiting:
        kind, at, end = waiting.pop()
        known = _fields(kind)
        while at < end:
            tag, at = _varint(data, at)
            size, wire = 0, tag & 7
            if wire == _VARINT:
                _, at = _varint(data, at)
            elif wire == _BYTES:
                size, at = _varint(data, at)
                counted, inner = known.get(tag >> 3, (False, None))
                elements += counted
                if inner is not None:
                    waiting.append((inner, at, min(at + size, end)))
            at += {_FIXED64: 8, _FIXED32: 4}.get(wire, size)
            fields += 1
            if elements > most or fields > FIELDS * most:
                raise ParameterError(f"it has more than {most} messages and texts in lists in it, or too many fields")


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """A number, and where it ends."""
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 127) << shift
        at += 1
        if byte < 128 or shift > 63:
            return value, at
        shift += 7


@functools.lru_cache(1000)
def _fields(kind: Any) -> dict[int, tuple[bool, Any]]:
    """The fields that matter, by number: whether they are counted, and the type of messages with more of them."""
    found = {}
    for field in kind.fields:
        inner = field.message_type
        more = inner is not None and any(map(_is_counted, inner.fields))
        found[field.number] = _is_counted(field), inner if more else None
    return {number: one for number, one in found.items() if any(one)}


def _is_counted(field: Any) -> bool:
    return field.message_type is not None or (field.is_repeated and field.type == field.TYPE_STRING)


@functools.lru_cache(1000)
def _lists(kind: Any) -> bool:
    """Whether messages of a type have lists of texts or messages, or messages in them do."""
    seen, waiting = set(), [kind]
    while waiting:
        one = waiting.pop()
        if one.full_name in seen:
            continue
        seen.add(one.full_name)
        for field in one.fields:
            inner = field.message_type
            if field.is_repeated and (inner is not None or field.type == field.TYPE_STRING):
                return True
            if inner is not None:
                waiting.append(inner)
    return False
