"""Configuration files of Player, in the syntax of 1.6 and of 2: which devices a server has.

    driver ( name "gz_position" provides ["position:0"] gz_id "robot1" )      # 1.6
    driver ( name "gazebo" provides ["6666:position2d:0"] gz_id "robot1" )    # 2
    position:0 ( driver "gz_position" gz_id "robot1" )                        # 1.4

All errors of a file are reported together, each with its line. What Player accepted is accepted here: drivers of other
devices are named in a warning and left out, and so are fields without an effect.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from libgz.base.errors import Diagnostics, GazeboError, Place, explain, nearest
from libgz.base.files import exists, read_limited
from libgz.base.numbers import whole_number
from libgz.player.drivers import DRIVERS, FAMILY, Driver, drivers_of
from libgz.player.messages import ALIASES, CODES
from libgz.transport.paths import check_id

__all__ = ["Configuration", "Device", "Simulation", "read_configuration"]

PORT = 6665
LARGEST_PORT, LARGEST_SERVER = 65535, (1 << 15) - 1
MOST_INCLUDES = 20  # in each other
MOST_DEVICES = 256  # of a port, as in Player
MOST_TOKENS = 200_000  # of a file and those that it includes
MOST_CHARACTERS = 16 << 20  # of these
MOST_INHERITED = 200_000  # fields that sections have from macros, all together
MOST_SECTIONS = 100  # in each other

# The fields of a driver; those with False are known, and have no effect here.
FIELDS = {
    "name": True,
    "provides": True,
    "devices": True,  # `provides` in 1.5
    "gz_id": True,
    "model_name": True,  # `gz_id` in later versions of Gazebo
    "laser_name": True,
    "camera_name": True,
    "robotname": True,
    "server_id": True,
    "worldfile": True,
    "plugin": False,
    "world_name": False,
    "requires": False,
    "alwayson": False,
    "save": False,
    "home_on_subscribe": False,
}
IDS = ("gz_id", "model_name", "laser_name", "camera_name")

_TOKEN = re.compile(
    r"""(?P<space>[ \t\r\f\v]+|\#[^\n]*)
      | (?P<line>\n)
      | (?P<word>[A-Za-z][A-Za-z0-9._:\-]*(?:\[[^\[\]\s"()]*\])*)
      | (?P<number>[+\-.0-9][+\-.0-9A-Za-z]*)
      | "(?P<string>[^"\n]*)"
      | (?P<mark>[()\[\]])
      | (?P<open>"[^"\n]*)
      | (?P<other>.)""",
    re.VERBOSE,
)


class _Token(NamedTuple):
    kind: str  # word, value or mark
    text: str
    file: str
    line: int


@dataclass
class _Section:
    """``TYPE ( FIELD VALUE ... )``, with the place of its type."""

    type: str
    place: Place
    fields: dict[str, tuple[list[str], Place]] = field(default_factory=dict)

    def text(self, name: str) -> str:
        """The first value of a field; an empty string without one."""
        values = self.fields.get(name, ([], self.place))[0]
        return values[0] if values else ""


@dataclass(frozen=True)
class Device:
    """A device that a configuration file declares.

    Attributes:
        driver: its declaration.
        label: the driver's name in the file.
        port, index: of its address; its interface is that of the driver.
        id: of libgz's interface.
        robot: the name of the robot it belongs to, for those who look up ports by names.
    """

    driver: Driver
    label: str
    port: int
    index: int
    id: str
    robot: str
    place: Place


class Simulation(NamedTuple):
    """Which simulation a file names: a worldfile to run, an empty string without one; or the id of a running server."""

    worldfile: str
    server_id: int


@dataclass
class Configuration:
    """What a configuration file says.

    Attributes:
        addresses: the devices by port, interface and index.
        counts: of the devices of each port.
    """

    file: str
    devices: list[Device] = field(default_factory=list)
    addresses: dict[tuple[int, str, int], Device] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)
    simulation: Simulation = Simulation("", 0)
    diagnostics: Diagnostics = field(default_factory=Diagnostics)

    @property
    def ports(self) -> list[int]:
        """The ports of all devices."""
        return sorted({device.port for device in self.devices})


def read_configuration(path: str | os.PathLike[str], port: int = PORT) -> Configuration:
    """Read a configuration file.

    Args:
        path: of the file.
        port: of devices whose address names none.

    Raises:
        WorldFileError: the file has errors; the message lists all, one line each.
        GazeboError: the file cannot be read.
    """
    result = Configuration(os.fspath(path))
    tokens = list(_tokens(Path(path), result.diagnostics, _Size()))
    sections = _Parser(tokens, result.diagnostics).sections()
    drivers = [driver for section in sections if (driver := _as_driver(section, result.diagnostics)) is not None]
    for driver in drivers:
        _add(result, driver, port)
    if not result.devices and not result.diagnostics.errors:
        result.diagnostics.error(Place(result.file, 1, "file"), "declares no device of a simulation")
    result.diagnostics.raise_errors()
    return result


# Text to tokens ------------------------------------------------------------------------------------------------------


@dataclass
class _Size:
    """What was read of all files."""

    tokens: int = 0
    characters: int = 0


def _tokens(path: Path, diagnostics: Diagnostics, size: _Size, depth: int = 0) -> Iterator[_Token]:
    """The tokens of a file, with those of the files it includes."""
    text = read_limited(path).decode(errors="replace")
    size.characters += len(text)
    line, includes = 1, False
    for match in _TOKEN.finditer(text):
        kind, place = match.lastgroup, Place(str(path), line, "include" if includes else "file")
        size.tokens += 1
        if size.tokens > MOST_TOKENS or size.characters > MOST_CHARACTERS:
            most = f"{MOST_TOKENS} words, or {MOST_CHARACTERS >> 20} Mi characters"
            diagnostics.error(place, f"has more than {most}, with the files that it includes")
            return
        if kind == "line":
            line += 1
        elif kind == "open":
            diagnostics.error(place, f"the text {match[0]} has no closing quotation mark on its line")
            yield _Token("value", match[0][1:], str(path), line)
        elif kind == "other":
            diagnostics.error(place, f"the character {match[0]!r} has no meaning here")
        elif kind == "string" and includes:
            includes = False
            yield from _included(path.parent / match["string"], place, diagnostics, size, depth)
        elif kind == "word" and match[0] == "include":
            includes = True
        elif kind == "mark":
            yield _Token("mark", match[0], str(path), line)
        elif kind == "word":
            yield _Token("word", match[0], str(path), line)
        elif kind in ("string", "number"):
            yield _Token("value", match[kind], str(path), line)


def _included(path: Path, place: Place, diagnostics: Diagnostics, size: _Size, depth: int) -> Iterator[_Token]:
    if depth >= MOST_INCLUDES:
        diagnostics.error(place, f"files include each other more than {MOST_INCLUDES} deep")
        return
    try:
        yield from _tokens(path, diagnostics, size, depth + 1)
    except (GazeboError, OSError) as error:
        diagnostics.error(place, f"cannot include {str(path)!r}: {explain(error)}")


# Tokens to sections --------------------------------------------------------------------------------------------------


class _Parser:
    """Reads sections and macros (``define NAME TYPE ( ... )``)."""

    def __init__(self, tokens: list[_Token], diagnostics: Diagnostics) -> None:
        self._tokens, self._at = tokens, 0
        self._diagnostics = diagnostics
        self._macros: dict[str, _Section] = {}
        self._inherited = self._depth = 0

    def sections(self) -> list[_Section]:
        """All sections of the file; fields outside sections have no meaning."""
        found: list[_Section] = []
        while (token := self._next()) is not None:
            if token.kind == "word" and token.text == "define":
                self._define(token)
            elif token.kind == "word" and token.text == "plugin":
                self._values()  # a plugin of all drivers
            elif token.kind == "word":
                section = self._entry(token, None)
                found += [section] if section is not None else []
            else:
                self._error(token, f"{token.text!r} stands outside a section; write driver ( ... )")
        return found

    def _peek(self) -> _Token | None:
        return self._tokens[self._at] if self._at < len(self._tokens) else None

    def _next(self) -> _Token | None:
        token = self._peek()
        self._at += token is not None
        return token

    def _error(self, token: _Token, message: str) -> None:
        self._diagnostics.error(Place(token.file, token.line, "file"), message)

    def _define(self, start: _Token) -> None:
        name, kind = self._next(), self._next()
        if name is None or kind is None or name.kind != "word" or kind.kind != "word":
            self._error(start, "a macro is written define NAME TYPE ( ... )")
            return
        section = self._entry(kind, None)
        if section is not None:
            self._macros[name.text] = section

    def _entry(self, name: _Token, owner: _Section | None) -> _Section | None:
        """A section, which is returned, or a field, which is added to its owner."""
        if self._opens():
            self._depth += 1
            section = self._section(name)
            self._depth -= 1
            return section
        values = self._values()
        if not values:
            self._error(name, f"{name.text!r} has no value, and no section in ( ) follows")
        elif owner is not None:
            place = Place(name.file, name.line, owner.type)
            if name.text in owner.fields:
                self._diagnostics.warn(place, f"{name.text!r} is given again; the last one holds")
            owner.fields[name.text] = values, place
        return None

    def _section(self, name: _Token) -> _Section:
        self._at += 1
        if self._depth > MOST_SECTIONS:
            self._error(name, f"sections are more than {MOST_SECTIONS} deep in each other")
            self._at = len(self._tokens)
        macro = self._macros.get(name.text)
        if macro:
            self._inherited += len(macro.fields)
            if self._inherited > MOST_INHERITED:
                self._error(
                    name, f"sections have more than {MOST_INHERITED} fields of macros; those of this one are left out"
                )
                macro = None
        section = _Section(macro.type if macro else name.text, Place(name.file, name.line, name.text))
        if macro:
            section.fields.update(macro.fields)
            inherited = set(macro.fields)
        else:
            inherited = set()
        while (token := self._next()) is not None and token.text != ")":
            if token.kind != "word":
                self._error(token, f"{token.text!r} stands where the name of a field is expected")
                continue
            if token.text == "driver" and self._opens():
                self._at -= 1  # the next driver: this one was not closed
                token = None
                break
            if token.text in inherited:  # a field of the macro may be given again
                inherited.discard(token.text)
                del section.fields[token.text]
            if token.text == "define":
                self._define(token)
            elif self._entry(token, section) is not None:
                place = Place(token.file, token.line, section.type)
                self._diagnostics.warn(place, f"the section {token.text!r} inside it has no effect")
        if token is None:
            self._error(name, f"the section {name.text!r} has no closing )")
        return section

    def _opens(self) -> bool:
        """Whether a section opens here."""
        following = self._peek()
        return following is not None and following.kind == "mark" and following.text == "("

    def _values(self) -> list[str]:
        """The value of a field: a text, a number, or several in [ ]."""
        token = self._peek()
        if token is None:
            return []
        if token.kind == "value" or (token.kind == "word" and token.text in ("true", "false")):
            self._at += 1
            return [token.text]
        if token.text != "[" or token.kind != "mark":
            return []
        self._at += 1
        values = []
        while (following := self._next()) is not None and following.text != "]":
            if following.kind == "mark":
                self._error(token, "the list has no closing ]")
                self._at -= 1
                break
            values.append(following.text)
        return values


# Sections to devices -------------------------------------------------------------------------------------------------


def _as_driver(section: _Section, diagnostics: Diagnostics) -> _Section | None:
    """The section of a driver; one of 1.4, ``position:0 ( driver "gz_position" ... )``, in the later form."""
    if section.type == "driver":
        return section
    kind = section.type.partition(":")[0]
    if _kind(kind) is not None and "driver" in section.fields:
        index = section.type.partition(":")[2] or section.text("index") or "0"
        port = section.text("port")
        address = f"{port}:{kind}:{index}" if port else f"{kind}:{index}"
        section.fields["name"] = section.fields.pop("driver")
        section.fields["provides"] = [address], section.place
        for name in ("index", "port"):
            section.fields.pop(name, None)
        section.type = "driver"
        return section
    if section.type in ("interface", "device"):
        diagnostics.warn(section.place, "has no effect")
    else:
        known = ("driver", "define", "include", "plugin", *CODES, *ALIASES)
        diagnostics.warn(section.place, f"the section {section.type!r} has no effect{nearest(section.type, known)}")
    return None


def _kind(name: str) -> str | None:
    """The interface of a name; None if there is none."""
    found = ALIASES.get(name, name)
    return found if found in CODES and found != "player" else None


def _add(result: Configuration, section: _Section, port: int) -> None:
    """Add the devices of a driver."""
    diagnostics, name = result.diagnostics, section.text("name")
    known = [FAMILY, *dict.fromkeys(driver.name for driver in DRIVERS)]
    declared = drivers_of(name)
    if not name:
        diagnostics.error(section.place, 'a driver must have a name, such as name "gz_position"')
    elif not declared:
        similar = nearest(name, known)
        if name.startswith("gz") or similar:
            diagnostics.error(section.fields["name"][1], f"there is no driver {name!r} of Gazebo{similar}")
        else:
            diagnostics.warn(
                section.fields["name"][1],
                f"the driver {name!r} is no driver of Gazebo; its devices {_listed(section)} are left out",
            )
    if not declared:
        return
    for unknown, (_, place) in section.fields.items():
        if unknown not in FIELDS:
            diagnostics.warn(place, f"the field {unknown!r} has no effect{nearest(unknown, FIELDS)}")
    if "provides" not in section.fields and "devices" not in section.fields:
        diagnostics.error(section.place, f'{name!r} must say what it provides, such as provides ["position:0"]')
        return
    addresses, place = section.fields.get("provides") or section.fields["devices"]
    known_kinds = {driver.kind for driver in declared}
    kinds = [_kind(address.split(":")[-2]) if ":" in address else None for address in addresses]
    some = any(kind in known_kinds for kind in kinds)
    for address, kind in zip(addresses, kinds, strict=True):
        if some and kind not in known_kinds:
            diagnostics.warn(place, f"{name!r} does not provide {address!r}, which is left out")
            continue
        device = _device(declared, section, address, place, port, diagnostics)
        if device is not None:
            _add_device(result, device)
    _note_simulation(result, section)


def _listed(section: _Section) -> str:
    addresses = section.fields.get("provides", ([], None))[0]
    return ", ".join(addresses[:10]) or "(none)"


def _device(
    declared: list[Driver], section: _Section, address: str, place: Place, port: int, diagnostics: Diagnostics
) -> Device | None:
    """The device of an address ``[KEY:[HOST:]][PORT:]INTERFACE:INDEX``."""
    parts, label = address.split(":"), section.text("name")
    if not 2 <= len(parts) <= 5:
        diagnostics.error(place, f"{address!r} is no address; write INTERFACE:INDEX or PORT:INTERFACE:INDEX")
        return None
    kind, number = _kind(parts[-2]), parts[-1]
    given = parts[-3] if len(parts) > 2 else ""
    key = parts[0] if len(parts) > 3 else ""
    if kind is None:
        offered = [*CODES, *ALIASES]
        diagnostics.error(place, f"there is no interface {parts[-2]!r} here{nearest(parts[-2], offered)}")
        return None
    index = whole_number(number, LARGEST_PORT)
    if index is None:
        diagnostics.warn(place, f"{address!r} has the index {number!r}, and no number from 0 to 65535; it is 0 here")
        index = 0
    if given and not whole_number(given, LARGEST_PORT):
        diagnostics.error(place, f"{address!r} has the port {given!r}; it must be a number from 1 to 65535")
        return None
    fitting = [driver for driver in declared if driver.kind == kind]
    if not fitting:
        kinds = ", ".join(dict.fromkeys(driver.kind for driver in declared))
        diagnostics.error(place, f"{label!r} provides {kinds}, and no {parts[-2]}")
        return None
    keyed = [driver for driver in fitting if driver.key == key] or [driver for driver in fitting if not driver.key]
    if not keyed:
        keys = [driver.key for driver in fitting]
        diagnostics.error(
            place, f"{address!r} must say which one, such as {keys[0]}::{kind}:{index}; there are {', '.join(keys)}"
        )
        return None
    driver = keyed[0]
    gz_id = next((section.text(name) for name in IDS if section.text(name)), "")
    if driver.source and driver.source != "sim" and not gz_id:
        message = f"{label!r} has no gz_id, the id of its {driver.source} interface; {address} is left out"
        diagnostics.warn(section.place, message)
        return None
    try:
        check_id(driver.source or driver.kind, gz_id)
    except GazeboError as error:
        diagnostics.error(section.place, str(error))
        return None
    gz_id = "default" if driver.source == "sim" else gz_id
    return Device(driver, label, int(given or port), index, gz_id, section.text("robotname"), place)


def _add_device(result: Configuration, device: Device) -> None:
    address = device.port, device.driver.kind, device.index
    other = result.addresses.get(address)
    if other is not None:
        provided = ":".join(map(str, address))
        result.diagnostics.error(device.place, f"{provided} is provided in line {other.place.line} already")
    elif result.counts[device.port] >= MOST_DEVICES:
        result.diagnostics.error(device.place, f"port {device.port} has more than {MOST_DEVICES} devices")
    else:
        result.addresses[address] = device
        result.counts[device.port] += 1
        result.devices.append(device)


def _note_simulation(result: Configuration, section: _Section) -> None:
    """What a driver says of the simulation: a worldfile beside the configuration file, or a server's id."""
    worldfile, server_id = section.text("worldfile"), section.text("server_id")
    if "\0" in worldfile:  # it becomes a word of a command
        result.diagnostics.error(section.fields["worldfile"][1], f"{worldfile!r} is no name of a file")
    elif worldfile:
        beside = Path(result.file).parent / worldfile
        result.simulation = result.simulation._replace(worldfile=str(beside) if exists(beside) else worldfile)
    if server_id and server_id != "default":
        number = whole_number(server_id, LARGEST_SERVER)
        if number is not None:
            result.simulation = result.simulation._replace(server_id=number)
        else:
            place = section.fields["server_id"][1]
            result.diagnostics.warn(place, f"server_id is {server_id!r}, and no number; server 0 is used")
