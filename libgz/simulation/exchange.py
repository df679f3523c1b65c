"""Exchange: what is done with an interface under its lock: conditions on what clients wrote, then a law."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError, nearest
from libgz.base.law import Number, Operation
from libgz.base.records import SwitchRecord, TextRecord
from libgz.simulation.recorder import Recorder
from libgz.transport.interface import Interface
from libgz.transport.layout import Struct, fields_of

__all__ = ["Exchange"]


class Exchange(Recorder):
    """Notes what native code does with an interface, under its lock.

    Where a condition is not met, nothing is written, and Python does all.

    Methods that name a field raise ParameterError if the interface has no such field, or the numbers do not fit in it.

    Args:
        interface: which is open on a server.
    """

    interface: Interface[Any]

    def __init__(self, interface: Interface[Any]) -> None:
        super().__init__(interface)

    def need(self, owner: object, name: str) -> None:
        """Condition: a `Number` of an object is not 0; otherwise Python does it, also while a client keeps the lock."""
        self.add(Operation.REQUIRE, one=self._number(owner, name))

    def expect(self, name: str, index: int, number: Any) -> None:
        """Condition: a number of the interface is equal to a double of ours, or both are NaN.

        Args:
            name: of the field; ``joints[2].angle`` is one of an element of an array.
            index: in the field.
            number: a ctypes double, or an array of one.
        """
        view = self.field(name)[index : index + 1]
        self.kept.append(number)
        offset, kind = view.ctypes.data - int(self.interface.link.memory), ord(view.dtype.char)
        found, ours = self._registers(1), ctypes.addressof(number)
        self.add(Operation.EXPECT, count=1, strides=(1, 0, 0), type=kind, one=ours, two=offset, result=found)

    def switch(self, name: str, record: SwitchRecord, count: int = 1) -> None:
        """Condition: an int that clients set to 1 is 0.

        Any other number is no command but overwritten memory, and is set to 0.

        Args:
            name: of the field.
            record: how often that may happen before Python has to warn, by `Guard.switch_record`.
            count: how many ints, from this one on, are set to 0 then.
        """
        self.kept.append(record)
        self.add(Operation.SWITCH, count=count, one=ctypes.addressof(record), two=self._place(name))

    def text(self, name: str, seen: ctypes.Array[ctypes.c_char], time: str) -> None:
        """Condition: there is no text, or one that clients may still be writing, for it has changed.

        Args:
            name: of the field.
            seen: the text at the last exchange that found one; zeros: none. It is updated.
            time: the field to which the sim time [s] is written when a text is found.
        """
        found = ctypes.create_string_buffer(len(seen))
        record = TextRecord(ctypes.addressof(seen), ctypes.addressof(found), len(seen), self._place(time))
        self.kept.append((seen, found, record))
        self.add(Operation.TEXT, one=ctypes.addressof(record), two=self._place(name))
        self.add(Operation.SEEN, one=ctypes.addressof(record))

    def real_time(self, name: str) -> None:
        """Write the real time since the start of the world [s]."""
        result = self._registers(1)
        self.add(Operation.REAL_TIME, result=result)
        self.add(Operation.STORE, count=1, type=ord("d"), one=result, two=self._place(name))

    def store(self, target: NDArray[Any], source: NDArray[np.float64]) -> None:
        """Write doubles to a view of the interface's memory, as numbers of its type."""
        self.assign(target, self.read(source))

    def fetch(self, target: NDArray[np.float64], source: NDArray[Any]) -> None:
        """Read a view of the interface's memory, as doubles."""
        self.assign(target, self.read(source))

    def field(self, name: str) -> NDArray[Any]:
        """The numbers of a field, of one dimension.

        Raises:
            ParameterError: there is no such field.
        """
        data: Any = self.interface.data
        *path, last = name.replace("[", ".").replace("]", "").split(".")
        for part in path:
            data = data[int(part)] if part.isdigit() else getattr(data, self._known(data, part, name))
        data = self._view(data, self._known(data, last, name))
        return np.atleast_1d(data)

    def _known(self, data: Any, part: str, name: str) -> str:
        known = fields_of(type(data)) if isinstance(data, Struct) else {}
        if part not in known:
            what = f"{self.interface.type}.{self.interface.id}"
            raise ParameterError(f"{what} has no field {name!r}; it has {', '.join(known)}{nearest(part, known)}")
        return part

    def _place(self, name: str) -> int:
        return int(self.field(name).ctypes.data) - int(self.interface.link.memory)

    def _number(self, owner: object, name: str) -> int:
        declared: Any = getattr(type(owner), name)
        cell = Number.cell(declared, owner)
        self.kept.append(cell)
        return ctypes.addressof(cell)
