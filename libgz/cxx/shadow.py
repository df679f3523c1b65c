"""Shadow: the struct of an interface as a plugin has it, where the server's clients have another ABI."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from libgz.transport.interface import Interface
from libgz.transport.layout import SERVER, Struct, fields_of

__all__ = ["Shadow"]


@cache
def _moves(source: type[Any], target: type[Any]) -> tuple[tuple[int, int, int, bool], ...]:
    """Where the fields of a struct are in two ABIs: (offset here, offset there, bytes, whether clients write it)."""
    return tuple(_found(source, target, 0, 0))


def _found(source: type[Any], target: type[Any], here: int, there: int) -> list[tuple[int, int, int, bool]]:
    found = []
    for name, field in fields_of(source).items():
        a, b = getattr(source, name), getattr(target, name)
        if issubclass(field.ctype, Struct):
            one, other = field.ctype, fields_of(target)[name].ctype
            size, size_there = ctypes.sizeof(one), ctypes.sizeof(other)
            for i in range(a.size // size):
                found += _found(one, other, here + a.offset + i * size, there + b.offset + i * size_there)
        else:
            found.append((here + a.offset, there + b.offset, a.size, field.writer != SERVER))
    return found


class Shadow:
    """A copy of an interface's struct in a plugin's own layout.

    Args:
        interface: open, as its server has it.
        layout: the plugin's struct.
    """

    def __init__(self, interface: Interface[Any], layout: type[Any]) -> None:
        self.interface = interface
        self.struct = layout()
        head, own = interface.data.head, self.struct.head
        own.version, own.size = head.version, ctypes.sizeof(layout)
        own_layout: Any = layout
        self._moves = _moves(own_layout, interface.layout)
        self._last = bytes(self.struct)

    def pull(self) -> None:
        """Take what clients have written."""
        here, there = ctypes.addressof(self.struct), ctypes.addressof(self.interface.data)
        for own, other, size, by_client in self._moves:
            if by_client:
                ctypes.memmove(here + own, there + other, size)
        self._last = bytes(self.struct)

    def push(self) -> None:
        """Write what the plugin has changed."""
        now, last = bytes(self.struct), self._last
        if now == last:
            return
        there = ctypes.addressof(self.interface.data)
        for own, other, size, _ in self._moves:
            part = now[own : own + size]
            if part != last[own : own + size]:
                ctypes.memmove(there + other, part, size)
        self._last = now
