"""The messages of Player's protocols: for each interface its code, and of each message its number, name and layout.

A message has one name, and its fields have one name each, in all versions; number and layout of each version are rows
of `messages.txt`, of which section ``[2]`` is common to 2.0 and 2.1. The reply to a request has its layout, unless
there is a row for the reply. Version 3.0 has the messages of 2.1, as far as they are here, 3.1 those and another one.

Sources of the numbers: Player's manuals of 1.6, 2.0 and 2.1, chapters "interface specification" and "wire protocol".
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias

from libgz.player.records import Record, record

__all__ = ["ALIASES", "CODES", "VERSIONS", "Kind", "Message", "Messages", "messages_of"]

Kind: TypeAlias = Literal["data", "command", "request", "reply"]

VERSIONS = ("1.6", "2.0", "2.1", "3.1")

# Codes of interfaces, the same in all versions.
CODES = {
    "player": 1,
    "power": 2,
    "gripper": 3,
    "position2d": 4,
    "sonar": 5,
    "laser": 6,
    "ptz": 8,
    "fiducial": 10,
    "speech": 12,
    "gps": 13,
    "truth": 15,
    "ir": 22,
    "wifi": 23,
    "mcom": 26,
    "position3d": 30,
    "simulation": 31,
    "camera": 40,
    "actarray": 53,
}
# Other names of interfaces in configuration files, and the code that 1.6 has beside.
ALIASES = {"position": "position2d"}
CODE_OF_POSITION2D_IN_1_6 = 48


class Message(NamedTuple):
    """A message of one version.

    Attributes:
        number: its subtype.
        layout: of its payload, without the subtype.
    """

    interface: str
    kind: Kind
    number: int
    name: str
    layout: Record
    text: str


@dataclass(frozen=True)
class Messages:
    """The messages of one version."""

    version: str
    by_number: Mapping[tuple[str, Kind, int], Message]
    by_name: Mapping[tuple[str, Kind, str], Message]

    def reply(self, request: Message) -> Message:
        """The reply to a request."""
        return self.by_name.get((request.interface, "reply", request.name), request)

    def interfaces(self) -> set[str]:
        """The interfaces that this version has."""
        return {interface for interface, _, _ in self.by_number}


def _sections() -> dict[str, str]:
    """Version -> rows of the table."""
    text = Path(__file__).with_name("messages.txt").read_text()
    parts = re.split(r"^\[(.+)\]$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def _rows(text: str) -> Iterator[Message]:
    for line in filter(None, text.splitlines()):
        interface, kind, number, name, *layout = line.split(maxsplit=4)
        text = " ".join(layout)
        yield Message(interface, kind, int(number), name, record(text), text)  # type: ignore[arg-type]


@functools.cache
def messages_of(version: str) -> Messages:
    """The messages of a version."""
    sections = _sections()
    own = {"3.1": sections["2.1"] + sections["3.1"]}.get(version, sections[version])
    real = ":f4" if version == "2.0" else ":f8"
    text = own if version == "1.6" else sections["2"].replace(":real", real) + own
    rows = list(_rows(text))
    by_number = {(row.interface, row.kind, row.number): row for row in rows}
    by_name = {(row.interface, row.kind, row.name): row for row in rows}
    return Messages(version, by_number, by_name)
