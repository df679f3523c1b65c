"""Variant: a world whose file is read with other values of some of its elements."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar, Unpack

from libgz.base.errors import NotFoundError, ParameterError, WorldFileError, nearest
from libgz.base.files import exists
from libgz.front import World, WorldOptions
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.recognition import is_sdf, is_sdf_text
from libgz.sdf.upgrade import NEWEST, upgraded
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode
from libgz.worldfile.search import find_worldfile, why_missing

__all__ = ["Variant", "value_text"]

_STEP = re.compile(r"(?P<name>[^\[\]#]+?)(?:#(?P<number>\d{1,9}))?(?:\[(?P<index>\d{1,9})\])?")
MOST_NAMED = 8  # elements in one message


class _Node(Protocol):
    """What both kinds of elements have."""

    name: str
    line: int


N = TypeVar("N", bound=_Node)


class Variant:
    """A world, in the file's text or with other values for elements of it, each named by a path.

    A path is the names of elements from the outside to the inside, such as ``robot1/laser1/rangeMax`` in a legacy world
    or ``pendulum/upper/inertial/mass`` in one of SDF. A name is the id or `name` of an element, or its tag; the first
    one may lie anywhere in the file. ``SimpleSolid#2`` is the second of several; ``crate/xyz[0]`` the first number of a
    value; ``joint/@type`` an attribute of XML. An attribute that the file lacks is added.

    Args:
        world: a worldfile by its path or name, or the text of one, which begins with ``<``.

    Raises:
        WorldFileError: there is no such file, or it is not well-formed.
    """

    def __init__(self, world: str | os.PathLike[str]) -> None:
        if not isinstance(world, str | os.PathLike):
            raise ParameterError(f"world is {world!r}; it must be the path, the name or the text of a worldfile")
        self.world = world
        text = os.fspath(world)
        self._text = text if text.lstrip().startswith("<") else None
        self.path: Path | None = None
        if self._text is not None:
            self.sdf = is_sdf_text(self._text)
        else:
            self.path = find_worldfile(world).absolute()
            if not exists(self.path):
                raise WorldFileError(f"cannot read worldfile {text!r}: it does not exist{why_missing(text)}")
            self.sdf = is_sdf(self.path)
        self._read()

    def _read(self) -> _Legacy | _Sdf:
        if self.sdf:
            return _Sdf(SdfFile.load(self.path) if self.path is not None else SdfFile.from_string(self._text or ""))
        file = WorldFile()
        if self.path is not None:
            file.Load(self.path)
        else:
            file.LoadString(self._text or "")
        return _Legacy(file)

    def get(self, path: str) -> str:
        """The text of an element, or one number of it.

        Raises:
            NotFoundError: there is none.
            ParameterError: it is no path, or means several elements.
        """
        return self._read().get(path)

    def load(self, changes: Mapping[str, Any] | None = None, **options: Unpack[WorldOptions]) -> World:
        """A new world with changed values, ready to step.

        Args:
            changes: path -> value: a number, a text, a truth value, or a sequence of numbers.
            **options: those of World.

        Raises:
            NotFoundError: there is no such element.
            ParameterError: a path means several elements or is none, or nothing in the world reads the element.
            WorldFileError: the world has errors, with these values.
        """
        document = self._read()
        for path, value in (changes or {}).items():
            document.set(path, value)
        world = World(**options)
        try:
            document.load(world)
            world.Initialize()
            document.check_used(changes or {})
        except BaseException:
            world.close()
            raise
        return world


def value_text(value: Any) -> str:
    """A value as a world's file holds it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, Sequence) or hasattr(value, "tolist"):
        items = value.tolist() if hasattr(value, "tolist") else value
        return " ".join(map(value_text, items)) if isinstance(items, Sequence) else value_text(items)
    return repr(float(value)) if isinstance(value, float) else str(value)


class _Document(Generic[N]):
    """The elements of a file, found by paths."""

    def __init__(self, root: N, label: str) -> None:
        self.root, self.label = root, label

    def children(self, node: N) -> Sequence[N]:
        raise NotImplementedError

    def names(self, node: N) -> tuple[str, ...]:
        """Id or name, then the tag."""
        raise NotImplementedError

    def make(self, node: N, name: str) -> N | None:
        """An element that the format knows there, and the file has not; None if there is none."""
        return None

    def find(self, path: str) -> tuple[N, str, int | None]:
        """The element that holds a value, the value's name in it (empty: its own), and the number of the value."""
        words = [word.strip() for word in path.split("/")]
        steps = [match for word in words if (match := _STEP.fullmatch(word)) is not None]
        if len(steps) != len(words) or any(step["index"] for step in steps[:-1]):
            raise ParameterError(f"{path!r} is no path; write names with / between them, such as robot1/xyz[0]")
        node, places = self.root, self._all(self.root)
        for i, step in enumerate(steps):
            last = i == len(steps) - 1
            if last and step["name"].startswith("@"):
                return node, step["name"], _number(step["index"])
            found = self._matching(places, step["name"])
            missing = not found and i > 0 and step["number"] is None
            if missing and last:
                return node, step["name"], _number(step["index"])
            made = self.make(node, step["name"]) if missing else None
            node = made if made is not None else self._one(found, step, path, places)
            places = list(self.children(node))
        return node, "", _number(steps[-1]["index"])

    def _all(self, node: N) -> list[N]:
        """Every element, those near the root first."""
        found, level = [], list(self.children(node))
        while level:
            found += level
            level = [child for one in level for child in self.children(one)]
        return found

    def _matching(self, places: Sequence[N], name: str) -> list[N]:
        """The elements that have a name, or else a tag."""
        for kind in (0, 1):
            found = [place for place in places if name in self.names(place)[kind : kind + 1]]
            if found:
                return found
        return []

    def _one(self, found: Sequence[N], step: re.Match[str], path: str, places: Sequence[N]) -> N:
        name, number = step["name"], _number(step["number"])
        if not found:
            known = dict.fromkeys(word for place in places for word in self.names(place) if word)
            some = ", ".join(list(known)[:MOST_NAMED]) or "nothing"
            raise NotFoundError(f"{path!r}: {self.label} has no {name!r}; there are {some}{nearest(name, known)}")
        if number is None and len(found) > 1:
            lines = ", ".join(f"line {place.line}" for place in found[:MOST_NAMED])
            raise ParameterError(
                f"{path!r}: {self.label} has {len(found)} elements {name!r} ({lines}); "
                f"name them by their ids, or by their number: {name}#1 to {name}#{len(found)}"
            )
        if number is not None and not 1 <= number <= len(found):
            raise NotFoundError(f"{path!r}: {self.label} has {len(found)} elements {name!r}, counted from 1")
        return found[0 if number is None else number - 1]

    def read(self, node: N, name: str) -> str | None:
        """The text of a value; None if it is absent."""
        raise NotImplementedError

    def write(self, node: N, name: str, text: str, path: str) -> None:
        raise NotImplementedError

    def get(self, path: str) -> str:
        node, name, index = self.find(path)
        text = self.read(node, name)
        if text is None:
            raise NotFoundError(f"{path!r}: {self.label} does not give it")
        return text.strip() if index is None else self._numbers(text, index, path)[index]

    def set(self, path: str, value: Any) -> None:
        node, name, index = self.find(path)
        text = value_text(value)
        if index is not None:
            numbers = self._numbers(self.read(node, name), index, path)
            numbers[index] = text
            text = " ".join(numbers)
        self.write(node, name, text, path)

    def _numbers(self, text: str | None, index: int, path: str) -> list[str]:
        numbers = (text or "").split()
        if index >= len(numbers):
            given = f"has {len(numbers)} numbers" if numbers else "does not give it"
            raise ParameterError(f"{path!r}: {self.label} {given}; set the whole value")
        return numbers


def _number(text: str | None) -> int | None:
    return None if text is None else int(text)


class _Legacy(_Document[WorldFileNode]):
    """A legacy worldfile."""

    def __init__(self, file: WorldFile) -> None:
        super().__init__(file.GetRootNode(), file.label)
        self.file = file

    def children(self, node: WorldFileNode) -> Sequence[WorldFileNode]:
        return node.children

    def names(self, node: WorldFileNode) -> tuple[str, ...]:
        holder = node.GetChild("id") if node.prefix == "model" else None
        return (holder.content.strip() if holder is not None else node.attributes.get("id", "")), node.name

    def read(self, node: WorldFileNode, name: str) -> str | None:
        if name.startswith("@"):
            return node.attributes.get(name[1:])
        if not name:
            return node.content
        return node.attributes.get(name)

    def write(self, node: WorldFileNode, name: str, text: str, path: str) -> None:
        if name.startswith("@") and name[1:] not in node.attributes:
            known = ", ".join(node.attributes) or "none"
            raise NotFoundError(
                f"{path!r}: {node.place} has the attributes {known}{nearest(name[1:], node.attributes)}"
            )
        node.put(name.removeprefix("@") or node.name, text)

    def load(self, world: World) -> None:
        self.file = self.file.changed()
        self.root = self.file.GetRootNode()
        world.Load(self.file)

    def check_used(self, changes: Mapping[str, Any]) -> None:
        """Report a changed element that no model reads: the run would be as without it."""
        for path in changes:
            node, name, _ = self.find(path)
            if not name and not node.used:
                owner = node.parent
                asked = owner.asked if owner is not None else {}
                raise ParameterError(f"{path!r}: nothing in the world reads <{node.tag}>{nearest(node.name, asked)}")


class _Sdf(_Document[Element]):
    """An SDF document, with the models that it includes."""

    def __init__(self, file: SdfFile) -> None:
        super().__init__(file.root, file.label)
        self.file = file

    def children(self, node: Element) -> Sequence[Element]:
        return node.children

    def names(self, node: Element) -> tuple[str, ...]:
        named = node.attributes.get("name")
        return (named.text if named is not None else ""), node.name

    def make(self, node: Element, name: str) -> Element | None:
        described = node.description.children if node.description is not None else {}
        return node.AddElement(name) if name in described and name != "include" else None

    def read(self, node: Element, name: str) -> str | None:
        if name.startswith("@"):
            attribute = node.attributes.get(name[1:])
            return attribute.text if attribute is not None else None
        if not name:
            return node.value.text
        about = node.description.children.get(name) if node.description is not None else None
        return about.default if about is not None else None

    def write(self, node: Element, name: str, text: str, path: str) -> None:
        if name.startswith("@"):
            if node.description is not None and not node.description.open and name[1:] not in node.attributes:
                hint = nearest(name[1:], node.attributes)
                raise NotFoundError(f"{path!r}: {node.where}: <{node.name}> has no attribute {name[1:]!r}{hint}")
            node.set_attribute(name[1:], text)
            return
        target = node
        if name:
            known = node.description.children if node.description is not None and not node.description.open else None
            if known is not None and name not in known:
                hint = nearest(name, known)
                raise NotFoundError(f"{path!r}: {node.where}: SDF has no <{name}> in <{node.name}>{hint}")
            target = node.AddElement(name)
        about = target.description
        if about is not None and not about.type and about.children:
            inside = ", ".join(about.children)
            raise ParameterError(f"{path!r}: {target.where}: <{target.name}> has no value of its own, but {inside}")
        target.value.SetFromString(text)

    def load(self, world: World) -> None:
        self.file.diagnostics.raise_errors()
        self.root.set_attribute("version", NEWEST)
        folder = Path(self.label).parent if not self.label.startswith("<") else None
        text = upgraded(self.root).ToString()
        file = SdfFile.from_string(text, self.label, folder)
        world.load_sdf(file)

    def check_used(self, changes: Mapping[str, Any]) -> None:
        """SDF describes its elements: an unknown one was refused."""
