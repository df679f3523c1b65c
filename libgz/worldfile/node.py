"""WorldFileNode: one element of a worldfile, with the getters of the old API.

Degrees become radians here and nowhere else: files are in degrees, the API is in radians.
"""

from __future__ import annotations

import functools
import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TypeVar

from libgz.base.errors import Diagnostics, Place, nearest
from libgz.base.files import expand, is_file
from libgz.base.geometry import (
    DTOR,
    RTOD,
    GzColor,
    GzQuatern,
    GzQuaternFromEuler,
    GzQuaternToEuler,
    GzVector,
    QuaternLike,
    VectorLike,
)
from libgz.base.visible import one_line
from libgz.worldfile.number import atof, atoi, malformed
from libgz.worldfile.spelling import IMPLIED, ignored_tags, renamed_tags

__all__ = ["LARGEST", "Changes", "Document", "WorldFileNode"]

log = logging.getLogger("libgz.worldfile")

T = TypeVar("T")
_BLANK = " \t\r\n"
LARGEST = 1e30  # no quantity of a world is near, and products of several numbers are still finite
SAME = 1e-9  # [m], and of a quaternion's numbers: two places that differ by less are one
MANY = 64  # children, from which on they are looked up by an index


class Document(Protocol):
    """What an element needs of the file it belongs to; `WorldFile` is one."""

    label: str
    filename: str | None
    diagnostics: Diagnostics
    changes: Changes

    @property
    def step_time(self) -> float:
        """The world's stepTime [s]."""

    @property
    def is_old(self) -> bool:
        """Whether the file was written for Gazebo 0.4."""

    def origin_height(self, node: WorldFileNode) -> float:
        """How far above its present origin a model of this file is meant to have it [m]."""

    def ResolveFilename(self, name: str) -> str:
        """A file name made absolute."""


@dataclass(eq=False, repr=False)
class Changes:
    """Values that differ from the file's text, by the number of their element in document order."""

    texts: dict[int, str] = field(default_factory=dict)
    attributes: dict[tuple[int, str], str] = field(default_factory=dict)  # (element, XML attribute) -> value
    children: dict[int, list[WorldFileNode]] = field(default_factory=dict)  # added at the beginning

    def __bool__(self) -> bool:
        return bool(self.texts or self.attributes or self.children)


class WorldFileNode:
    """One element: tag `name` with namespace `prefix`, its children, and its text.

    An attribute of a model is a child element; its text is the value. Each getter looks for `key` among (1) the XML
    attributes of this element, (2) this element's own name, (3) its children, first come first served, then (4) among
    the older spellings of the key. A value that is absent gives the default.
    """

    def __init__(
        self,
        file: Document,
        parent: WorldFileNode | None,
        name: str,
        prefix: str | None,
        line: int,
        number: int,
        attributes: dict[str, str],
    ) -> None:
        self.file = file
        self.parent = parent
        self.name = name
        self.prefix = prefix
        self.line = line
        self.number = number  # of this element in document order
        self.attributes = attributes
        self.children: list[WorldFileNode] = []
        self.pieces: list[str | WorldFileNode] = []  # text and children in order
        self._index: dict[str, WorldFileNode] = {}  # the first child of each name, where there are many
        self._indexed = 0
        self.used = False
        self.reported = False  # whether a warning says already that it is not used
        self.asked: dict[str, None] = {}  # keys that getters looked for

    def __repr__(self) -> str:
        return f"<WorldFileNode {self.tag} at {self.file.label}:{self.line}>"

    @property
    def tag(self) -> str:
        """The name with its prefix, as written."""
        return f"{self.prefix}:{self.name}" if self.prefix else self.name

    @property
    def content(self) -> str:
        """The text of this element and everything in it, untrimmed."""
        return "".join(piece if isinstance(piece, str) else piece.content for piece in self.pieces)

    # Errors ------------------------------------------------------------------------------------------------------

    @property
    def place(self) -> Place:
        """File, line and tag, for messages."""
        return Place(self.file.label, self.line, self.tag)

    def error(self, message: str) -> None:
        """Add an error: the world does not load; all errors are reported together."""
        self.file.diagnostics.error(self.place, message)

    def warn(self, message: str) -> None:
        """Add a warning: the world still loads."""
        self.file.diagnostics.warn(self.place, message)

    # Structure ---------------------------------------------------------------------------------------------------

    def GetName(self) -> str:
        """The local tag name."""
        return self.name

    def GetNSPrefix(self) -> str | None:
        """The namespace prefix; asking an element that has one marks it as used."""
        self.used = self.used or self.prefix is not None
        return self.prefix

    def GetNext(self) -> WorldFileNode | None:
        """The next element beside this one."""
        if self.parent is None:
            return None
        beside = self.parent.children
        index = beside.index(self) + 1
        return beside[index] if index < len(beside) else None

    def GetChild(self, name: str | None = None) -> WorldFileNode | None:
        """The first child, or the first with this local name."""
        return next((child for child in self.children if name is None or child.name == name), None)

    def GetChildByNSPrefix(self, prefix: str) -> WorldFileNode | None:
        """The first child with this prefix."""
        return next((child for child in self.children if child.prefix == prefix), None)

    def along(self, path: tuple[str, ...]) -> list[WorldFileNode]:
        """The first elements on a path of local names below this one, as far as it exists."""
        found: list[WorldFileNode] = []
        for step in path:
            node = (found[-1] if found else self).GetChild(step)
            if node is None:
                break
            found.append(node)
        return found

    def at(self, path: tuple[str, ...]) -> WorldFileNode | None:
        """The element at the end of such a path; None if there is none."""
        found = self.along(path)
        return found[-1] if len(found) == len(path) else None

    def walk(self) -> Iterator[WorldFileNode]:
        """This element and all below it, in document order."""
        yield self
        for child in self.children:
            yield from child.walk()

    # Look-up -----------------------------------------------------------------------------------------------------

    def _find(self, key: str) -> tuple[WorldFileNode, str] | None:
        """(element, text) of an attribute, marked as used; None if it is absent."""
        self.asked.setdefault(key)
        if key in self.attributes:
            return self, self.attributes[key]
        if key == self.name:
            self.used = True
            return self, self.content
        old = self._find_old(key)
        child = self._attribute_child(key)
        if child is not None:
            child.used = True
            return child, child.content
        implied = IMPLIED.get(self.name, {}).get(key) if old is None else None
        return (self, implied) if implied is not None and self.file.is_old else old

    def _attribute_child(self, key: str) -> WorldFileNode | None:
        """The child that holds an attribute; a model of that name does not count."""
        if len(self.children) < MANY:
            return next((child for child in self.children if child.name == key and child.prefix != "model"), None)
        if self._indexed != len(self.children):
            self._indexed = len(self.children)
            self._index = {child.name: child for child in reversed(self.children) if child.prefix != "model"}
        return self._index.get(key)

    def _find_old(self, key: str) -> tuple[WorldFileNode, str] | None:
        """The same under an older spelling."""
        found = None
        for renamed in renamed_tags(self.name, key):
            for node in self.along(renamed.path):
                node.used = True
            old = self.at(renamed.path)
            if old is not None and found is None:
                found = old, renamed.convert(old.content, self.file.step_time)
        return found

    def _absent(self, key: str, require: int, default: T) -> T:
        if require:
            self.error(f"attribute <{key}> is missing and must be given{nearest(key, self._unused_names())}")
        return default

    def _unused_names(self) -> list[str]:
        return [child.name for child in self.children if not child.used]

    def IsDefined(self, key: str) -> bool:
        """Whether the attribute is present; marks it as used."""
        return self._find(key) is not None

    def _number(self, node: WorldFileNode, text: str) -> float:
        """A number as atof reads it, with a warning where that ignores something."""
        value = atof(text)
        if malformed(text):
            node.warn(f"{text.strip()!r} is not a number, and is read as {value:g}")
        if math.isnan(value):
            node.error("'nan' is not allowed here")
            return 0.0
        return value

    def _finite(self, node: WorldFileNode, text: str) -> float:
        """A number that must not be infinite."""
        value = self._number(node, text)
        if abs(value) > LARGEST:
            kind = "infinite numbers" if math.isinf(value) else f"numbers above {LARGEST:g}"
            node.error(f"{kind} are not allowed here")
            return 0.0
        return value

    # Getters -----------------------------------------------------------------------------------------------------

    def GetString(self, key: str, default: str | None = None, require: int = 0) -> str | None:
        """The text as written, blanks included."""
        found = self._find(key)
        return found[1] if found else self._absent(key, require, default)

    def GetInt(self, key: str, default: int = 0, require: int = 0) -> int:
        """A whole number."""
        found = self._find(key)
        if not found:
            return self._absent(key, require, default)
        self._number(*found)
        return atoi(found[1])

    def GetDouble(self, key: str, default: float = 0.0, require: int = 0) -> float:
        """A number."""
        found = self._find(key)
        return self._number(*found) if found else self._absent(key, require, default)

    def GetLength(self, key: str, default: float = 0.0, require: int = 0) -> float:
        """A length [m]."""
        return self.GetDouble(key, default, require)

    def GetTime(self, key: str, default: float = 0.0, require: int = 0) -> float:
        """A time [s]."""
        return self.GetDouble(key, default, require)

    def GetAngle(self, key: str, default: float = 0.0, require: int = 0) -> float:
        """An angle: degrees in the file, [rad] here and in `default`."""
        found = self._find(key)
        return DTOR(self._finite(*found)) if found else self._absent(key, require, default)

    def GetBool(self, key: str, default: bool = False, require: int = 0) -> bool:
        """`true` or `false` in any case, or a number; anything else is false, with a warning."""
        found = self._find(key)
        if not found:
            return self._absent(key, require, default)
        node, text = found[0], found[1].strip().lower()
        if text in ("true", "false"):
            return text == "true"
        if malformed(text):
            node.warn(f"{text!r} is neither true, false nor a number, and is read as false")
            return False
        return atoi(text) != 0

    def GetPosition(self, key: str, default: VectorLike = (0.0, 0.0, 0.0)) -> GzVector:
        """Three lengths [m]; missing ones are 0."""
        values = self._tuple(key, 3)
        return GzVector(*default) if values is None else GzVector(*values)

    def GetRotation(self, key: str, default: QuaternLike = (1.0, 0.0, 0.0, 0.0)) -> GzQuatern:
        """Roll, pitch, yaw in degrees, as a quaternion; missing ones are 0."""
        values = self._tuple(key, 3)
        return GzQuatern(*default) if values is None else GzQuaternFromEuler(*map(DTOR, values))

    def GetColor(self, key: str, default: GzColor | None = None) -> GzColor:
        """Red, green, blue and perhaps alpha; missing ones are 0, alpha 1."""
        found = self._find(key)
        if not found:
            return default if default is not None else GzColor()
        node, text = found
        values = [self._number(node, token) for token in text.split()[:4]]
        if len(values) < 3:
            node.warn(f"has {len(values)} of 3 numbers; those that are missing are read as 0")
        r, g, b = [*values, 0.0, 0.0, 0.0][:3]
        return GzColor(r, g, b, values[3] if len(values) > 3 else 1.0)

    def _tuple(self, key: str, count: int) -> list[float] | None:
        """`count` numbers, padded with 0; None if the attribute is absent or blank."""
        found = self._find(key)
        tokens = found[1].split() if found else []
        if found is None or not tokens:
            return None
        values = [self._finite(found[0], token) for token in tokens]
        if len(values) > count:
            found[0].warn(f"has {len(values)} numbers; {count} are allowed, and the rest is ignored")
        if len(values) < count:
            found[0].warn(f"has {len(values)} of {count} numbers; those that are missing are read as 0")
        return (values + [0.0] * count)[:count]

    def token_count(self, key: str) -> int:
        """How many blank-separated tokens the attribute has; 0 if it is absent."""
        found = self._find(key)
        return len(found[1].split()) if found else 0

    def GetTupleString(self, key: str, index: int, default: str | None = None) -> str | None:
        """The token number `index`; the default if the attribute is absent, None if it has fewer tokens."""
        found = self._find(key)
        if not found:
            return default
        tokens = found[1].split()
        return tokens[index] if index < len(tokens) else None

    def GetTupleDouble(self, key: str, index: int, default: float = 0.0) -> float:
        """A number of a tuple."""
        found = self._find(key)
        tokens = found[1].split() if found else []
        return self._number(found[0], tokens[index]) if found and index < len(tokens) else default

    def GetTupleInt(self, key: str, index: int, default: int = 0) -> int:
        """A whole number of a tuple."""
        token = self.GetTupleString(key, index)
        return default if token is None else atoi(token)

    def GetTupleLength(self, key: str, index: int, default: float = 0.0) -> float:
        """A length of a tuple [m]."""
        return self.GetTupleDouble(key, index, default)

    def GetTupleAngle(self, key: str, index: int, default: float = 0.0) -> float:
        """An angle of a tuple: degrees in the file, [rad] here and in `default`."""
        found = self._find(key)
        tokens = found[1].split() if found else []
        return DTOR(self._finite(found[0], tokens[index])) if found and index < len(tokens) else default

    # Files -------------------------------------------------------------------------------------------------------

    def ResolveFilename(self, name: str) -> str:
        """A file name made absolute: relative ones lie in the worldfile's directory."""
        return self.file.ResolveFilename(name)

    def GetFilename(self, key: str, default: str | None = None, require: int = 0) -> str | None:
        """A file name made absolute; whether the file exists is not checked."""
        text = self.GetString(key, None, require)
        return default if text is None or not text.strip() else self.ResolveFilename(text.strip())

    def SearchFilename(
        self, key: str, path: str | None = None, default: str | None = None, require: int = 0
    ) -> str | None:
        """A file searched in the current directory, the worldfile's, and `path`; a miss is a warning."""
        found = self._find(key)
        if not found or not found[1].strip():
            return self._absent(key, require, default) if not found else default
        name = found[1].strip()
        if name[0] in "/~":
            places = [expand(name)]
        else:
            places = [Path.cwd() / name, Path(self.ResolveFilename(name))]
            places += [Path(path) / name] if path else []
        for place in places:
            if is_file(place):
                return str(place)
        tried = ", ".join(dict.fromkeys(str(place) for place in places))
        found[0].warn(one_line(f"file {name!r} was not found; looked for {tried}"))
        return default

    # Setters -----------------------------------------------------------------------------------------------------

    def SetString(self, key: str, value: str) -> None:
        """Change the text of an attribute that is present; `WorldFile.Save` writes it."""
        if key in self.attributes:
            if self.attributes[key] != value:
                self.attributes[key] = self.file.changes.attributes[self.number, key] = value
            return
        node = self if key == self.name else self._attribute_child(key)
        if node is not None:
            node._set_content(value)

    def put(self, key: str, value: str) -> None:
        """Change the text of an attribute, or add the attribute if it is missing; `WorldFile.Save` writes it."""
        if key in self.attributes or key == self.name or self._attribute_child(key) is not None:
            self.SetString(key, value)
        else:
            self._add_child(key, value)

    def _set_content(self, value: str) -> None:
        if self.content.strip(_BLANK) != value:
            self.pieces = [value]
            if self.number >= 0:  # else it was added, and is not in the file yet
                self.file.changes.texts[self.number] = value

    def SetPosition(self, key: str, value: VectorLike, *, add: bool = False) -> None:
        """Write three lengths [m] with three decimals; `add` creates the attribute if it is missing."""
        self._set(key, " ".join(f"{_no_minus_zero(v, 3):.3f}" for v in value), add)

    def SetRotation(self, key: str, value: QuaternLike, *, add: bool = False) -> None:
        """Write roll, pitch, yaw in degrees: whole ones plain, others with three decimals."""
        degrees = [_no_minus_zero(RTOD(angle), 3) for angle in GzQuaternToEuler(value)]
        self._set(key, " ".join(f"{d:.0f}" if d == round(d) else f"{d:.3f}" for d in degrees), add)

    def put_pose(self, position: VectorLike, rotation: QuaternLike) -> None:
        """Write `xyz` and `rpy` with all digits, each only if it differs from the file's by more than 1e-9."""
        if max(abs(a - b) for a, b in zip(self.GetPosition("xyz"), position, strict=True)) > SAME:
            self._set("xyz", " ".join(repr(value + 0.0).removesuffix(".0") for value in position), add=True)
        given = self.GetRotation("rpy")
        if min(max(abs(a - s * b) for a, b in zip(given, rotation, strict=True)) for s in (1.0, -1.0)) > SAME:
            degrees = (RTOD(angle) for angle in GzQuaternToEuler(rotation))
            self._set("rpy", " ".join(f"{_no_minus_zero(value, 12):.15g}" for value in degrees), add=True)

    def _set(self, key: str, text: str, add: bool) -> None:
        old = self._find_old(key)
        if key in self.attributes or self._attribute_child(key) is not None:
            self.SetString(key, text)
        elif old is not None:  # `pos` and `rot` of 0.3 are in the form of xyz and rpy
            old[0]._set_content(text)
        elif add and any(atof(token) for token in text.split()):  # an absent one reads as zeros
            self._add_child(key, text)

    def _add_child(self, tag: str, text: str) -> None:
        """Add a new child in front of those of the file."""
        child = WorldFileNode(self.file, self, tag, None, self.line, -1, {})
        child.pieces, child.used = [text], True
        added = self.file.changes.children.setdefault(self.number, [])
        self.children.insert(len(added), child)
        added.append(child)

    # Unused attributes -------------------------------------------------------------------------------------------

    def note_unused(self) -> bool:
        """Add a warning for each element below this one that no getter read; whether there was one."""
        for path in ignored_tags(self.name) if self.children else ():
            node = self.at(path)
            if node is not None and not node.used:
                node.used = True
                log.info("%s:%d: <%s> has no effect since Gazebo 0.5", self.file.label, node.line, node.tag)
        found = False
        for child in self.children:
            if not child.used:
                found = True
                # Else this element's own warning covers it.
                if (self.used or self.parent is None) and not child.reported:
                    self.file.diagnostics.no_effect(child.place, functools.partial(self._unused, child))
            found = child.note_unused() or found
        return found

    def _unused(self, child: WorldFileNode) -> str:
        """The warning about a child that no getter read."""
        first = self._attribute_child(child.name)
        if child.name in self.asked and child.name in self.attributes:
            return f"is not used: the attribute {child.name}= counts"
        if child.name in self.asked and first is not None and first is not child:
            return f"is not used: the first one counts, line {first.line}"
        owner = f" by <{self.tag}>" if self.used else ""
        return f"is not used{owner}{nearest(child.name, self.asked)}"

    def WarnUnused(self) -> bool:
        """Log a warning for each element below this one that no getter read; whether there was one."""
        before = set(self.file.diagnostics.found)
        found = self.note_unused()
        for warning in self.file.diagnostics.warnings:
            if warning not in before:
                log.warning("%s", warning)
        return found

    def Print(self) -> str:
        """The element and all in it, one line each, for debugging."""
        lines = [f"{self.tag}: {self.content.strip()!r}" if not self.children else f"{self.tag}:"]
        for child in self.children:
            lines += ["  " + line for line in child.Print().splitlines()]
        return "\n".join(lines)


def _no_minus_zero(value: float, digits: int) -> float:
    """Rounded, and 0 where that gives -0."""
    return round(value, digits) + 0.0
