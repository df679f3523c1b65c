"""PackedMessage: a message that is packed once. To publish it again costs its new numbers, in laws no Python at all."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import ParameterError
from libgz.base.law import LeftToPython, Number, floor, largest, law, least, where, wrong
from libgz.ros.packing import Codec, codec
from libgz.ros.types import MessageType
from libgz.simulation.recorder import Recorder, recorded_as

__all__ = ["LATEST", "MOST_NUMBER", "Outbox", "PackedMessage"]

FRAME = struct.Struct("<I")
LATEST = 2.0**31 - 1.0  # [s] of a stamp
MOST_NUMBER = 2.0**32 - 1.0  # of a message
OUTBOX_SIZE = 1 << 16  # [byte]

Places: TypeAlias = dict[str, tuple[int, str, int]]


class Outbox:
    """Messages of a topic that native code has published, with their lengths, until the node takes them.

    Attributes:
        used: how many bytes they have.
    """

    used = Number()

    def __init__(self) -> None:
        self.memory: NDArray[np.uint8] = np.empty(OUTBOX_SIZE, np.uint8)

    def take(self) -> bytes:
        """The messages; there are none then."""
        found = self.memory[: int(self.used)].tobytes()
        self.used = 0.0
        return found


class Topic(Protocol):
    """A publication, as its messages use it."""

    kind: MessageType
    stamped: bool
    number: float
    gatherer: tuple[Any, Outbox | None]

    @property
    def codec(self) -> Codec:
        """The codec of its messages."""

    @property
    def listened(self) -> bool:
        """Whether there are subscribers."""

    def send_body(self, body: bytes) -> None:
        """Send the bytes of a message."""


class _Slot(NamedTuple):
    """Numbers that follow each other.

    Attributes:
        begin: where [byte].
        layout: packs them.
        whole: whether they are integers.
        places: (where, letter) of each.
    """

    begin: int
    layout: struct.Struct
    whole: bool
    places: list[tuple[int, str]]


NOTHING = _Slot(0, struct.Struct(""), False, [])  # of numbers that the other side does not have


def _has(value: Any, path: str) -> bool:
    """Whether a message has a field, in a message or list of its own."""
    for part in path.split("."):
        if part.isdigit():
            value = value[int(part)] if int(part) < len(value) else None
        else:
            value = getattr(value, part, None)
    return value is not None


def _below(places: Places, path: str) -> tuple[list[tuple[str, int]], list[tuple[int, str, int]]]:
    """Of the numbers of a field, or of all fields in it: (name, how many) of each, and their places."""
    found = {name: place for name, place in places.items() if name == path or name.startswith(f"{path}.")}
    return [(name, count) for name, (_, _, count) in found.items()], [*found.values()]


def _put(recorder: Recorder, message: PackedMessage, path: str, values: Iterable[Any]) -> None:
    slot, numbers = message.slot(path), tuple(values)
    if slot is NOTHING:
        return
    places = slot.places
    if len(places) != len(numbers):
        raise wrong(f"sets {path}, which has {len(places)} numbers, to {len(numbers)}")
    memory = recorder.get(message, "memory")  # it is recorded again where there is another one
    for (at, letter), number in zip(places, numbers, strict=True):
        recorder.put(memory, at, letter, number)


def _hand_over(recorder: Recorder, message: PackedMessage) -> None:
    publication = message.publication
    session, box = publication.gatherer
    if box is None:
        raise LeftToPython("send")
    memory, used = recorder.get(message, "memory"), recorder.get(box, "used")
    recorder.append(memory, box.memory, used)
    recorder.set(box, "used", used + memory.size)
    recorder.set(session, "gathered", 1.0)


class PackedMessage:
    """A message whose texts, and numbers of values, stay: its numbers are set in place.

    Args:
        publication: the topic.
        message: as it is at first.

    Attributes:
        memory: its bytes, with their number before them, once a number was set.
    """

    def __init__(self, publication: Topic, message: Any) -> None:
        self.publication, self._message = publication, message
        self.numbered = publication.stamped and publication.gatherer[0].version == 1
        self.memory: NDArray[np.uint8] = np.empty(0, np.uint8)
        self._codec: Codec | None = None
        self._places: Places = {}
        self._slots: dict[str, _Slot] = {}

    def _pack(self) -> None:
        """Pack it with the present codec: that of a bridge is known when it is there, and another one's may differ."""
        self._codec = present = self.publication.codec
        body = present.pack(self._message)
        self.memory = np.frombuffer(bytearray(FRAME.pack(len(body)) + body), np.uint8)
        self._places, self._slots = present.places(self._message), {}

    def slot(self, path: str) -> _Slot:
        """The numbers of a field, or of all fields in it.

        Raises:
            ParameterError: there is no such field, or its numbers do not follow each other.
        """
        if self._codec is not self.publication.codec:
            self._pack()
        if path not in self._slots:
            found_names, fields = _below(self._places, path)
            # A bridge may describe the type without some of ours, or in another order.
            known_names, _ = _below(codec(self.publication.kind).places(self._message), path)
            found = [
                (FRAME.size + at + i * struct.calcsize(letter), letter)
                for at, letter, count in fields
                for i in range(count)
            ]
            ends = [at + struct.calcsize(letter) for at, letter in found]
            gaps = [after - end for end, (after, _) in zip(ends, found[1:], strict=False)]
            if not fields or any(gaps) or found_names != known_names:
                what = f"{self.publication.kind.name} has no numbers {path!r} that follow each other"
                if self.publication.gatherer[0].version == 1 or not _has(self._message, path):
                    raise ParameterError(what)
                # As the bridge describes it: no reason to end.
                self.publication.gatherer[0].log_refusal(path, f"{what}; they are left out", "ROS 2:")
                return self._slots.setdefault(path, NOTHING)
            letters = "".join(letter for _, letter in found)
            begin, layout = FRAME.size + fields[0][0], struct.Struct(f"<{letters}")
            self._slots[path] = _Slot(begin, layout, not set(letters) & set("df"), found)
        return self._slots[path]

    @recorded_as(_put)
    def put(self, path: str, values: Iterable[Any]) -> None:
        """Set all numbers of a field, such as ``pose.pose.position``, in their order; for laws, too.

        Raises:
            ParameterError: it has others, or the values do not fit.
        """
        slot = self.slot(path)
        if slot is NOTHING:
            return
        begin, layout, whole, _ = slot
        try:
            layout.pack_into(self.memory.data, begin, *(map(int, values) if whole else values))
        except (struct.error, OverflowError, TypeError, ValueError) as error:
            raise ParameterError(f"{self.publication.kind.name} cannot be packed: {path}: {error}") from error

    def put_array(self, path: str, values: ArrayLike) -> None:
        """Set an array of numbers, such as the ranges of a scan, as one block.

        Raises:
            ParameterError: it has another length.
        """
        slot = self.slot(path)
        if slot is NOTHING:
            return
        begin, _, _, places = slot
        letter, count = places[0][1] if places else "B", len(places)
        data = np.ascontiguousarray(values, np.dtype(letter).newbyteorder("<")).view(np.uint8)
        if len(data) != count * struct.calcsize(letter):
            raise ParameterError(f"{self.publication.kind.name}: {path} has {count} numbers")
        self.memory[begin : begin + len(data)] = data

    @law
    def stamp(self, now: Any, path: str = "header.stamp") -> None:
        """Set a time [s], to the nanosecond, or the nearest one that stamps can hold."""
        now = least(largest(now, 0.0), LATEST)
        whole = floor(now)
        nanoseconds = floor((now - whole) * 1e9 + 0.5)
        carried = nanoseconds >= 1e9
        self.put(path, (where(carried, whole + 1.0, whole), where(carried, 0.0, nanoseconds)))

    @law
    def send(self) -> None:
        """Publish it as it is now, with its number; nothing is sent without subscribers."""
        publication = self.publication
        if self.numbered:
            self.put("header.seq", (publication.number,))
        publication.number = where(publication.number >= MOST_NUMBER, 0.0, publication.number + 1.0)
        self._hand_over()

    @recorded_as(_hand_over)
    def _hand_over(self) -> None:
        self.publication.send_body(self.memory[FRAME.size :].tobytes())
