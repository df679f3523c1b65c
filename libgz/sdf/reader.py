"""Reading SDF files: parsed safely, checked against the description of their version, includes resolved."""

from __future__ import annotations

import functools
import os
from io import BytesIO
from pathlib import Path
from typing import IO

from lxml import etree

from libgz.errors import Diagnostics, NotFoundError, Place, WorldFileError, nearest
from libgz.files import read_limited, xml_parser
from libgz.sdf.description import UNSET, VERSIONS, Description, describe
from libgz.sdf.element import Element, Param
from libgz.sdf.paths import find_model
from libgz.sdf.unsimulated import warn_of_unsimulated
from libgz.sdf.value import check

__all__ = ["SdfFile", "is_sdf", "is_sdf_text"]

DEEPEST_INCLUDE = 20
UNIQUE = ("model", "actor", "light", "collision", "visual")  # whose names must differ; models check links and joints
# (parent, child): all that occur have an effect, though the description of SDF allows one.
REPEATED = {
    ("contact", "collision"),
    ("geometry", "polyline"),
    ("multicamera", "camera"),
    ("script", "uri"),
    ("world", "physics"),
}
LATER = ("frame", "relative_to")  # SDF 1.7's frames


class SdfFile:
    """An SDF document, read and checked.

    ``SdfFile.load(path)`` reads a file; `root` is its `<sdf>` element, `diagnostics` its errors and warnings, `label`
    its name in messages. Unknown attributes are ignored and unknown elements kept, both with a warning.
    """

    def __init__(self) -> None:
        self.root = Element("sdf")
        self.diagnostics = Diagnostics()
        self.version = VERSIONS[-1]
        self.label = "<string>"
        self._folder: Path | None = None
        self._text = b""
        self._depth = 0

    @classmethod
    def load(cls, filename: str | os.PathLike[str]) -> SdfFile:
        """Read a file; its errors are in `diagnostics`.

        Raises:
            WorldFileError: it cannot be read, is not well-formed, or is not SDF.
        """
        file = cls()
        file._read_file(Path(filename))
        return file

    @classmethod
    def from_string(cls, text: str | bytes, label: str = "<string>", folder: Path | None = None) -> SdfFile:
        """The same from text; `label` is its name in messages, `folder` the base of its relative paths."""
        file = cls()
        file.label, file._folder = label, folder
        file._read(text.encode() if isinstance(text, str) else text)
        return file

    def _read_file(self, path: Path) -> None:
        try:
            data = read_limited(path)
        except OSError as error:
            raise WorldFileError(f"Unable to read sdf file[{path}]: {error.strerror}") from None
        self.label, self._folder = str(path), path.parent
        self._read(data)

    def read_again(self) -> SdfFile:
        """The document as it was read, without what has been changed in its elements since."""
        return SdfFile.from_string(self._text, self.label, self._folder)

    @property
    def busy(self) -> bool:
        """Whether it has plugins or sensors."""
        return any(True for name in ("plugin", "sensor") for _ in self.root.find(name))

    def _read(self, data: bytes) -> None:
        self._text = data
        try:
            xml = etree.fromstring(data, xml_parser())
        except etree.XMLSyntaxError as error:
            raise WorldFileError(f"{self.label}:{error.lineno or 1}: {error.msg}") from None
        if _local(xml) != "sdf":
            raise WorldFileError(
                f"{self.label}:{_line(xml)}: <{_local(xml)}>: the root of an SDF file must be <sdf version='...'>"
            )
        self.version = self._described_version(xml)
        blocks = describe(self.version)
        self.root = self._element(xml, blocks["sdf"])
        self._check_names()
        if not self._depth:
            warn_of_unsimulated(self.root, self.diagnostics)

    def _described_version(self, xml: etree._Element) -> str:
        """The version whose description applies: the file's, or the nearest one, with a warning."""
        given = xml.get("version")
        if given is None:
            self._error(xml, "version is missing and must be given")
            return VERSIONS[-1]
        if given in VERSIONS:
            return given
        try:
            number = tuple(map(int, given.split(".")))
        except ValueError:
            self._error(xml, f"version {given!r} is not allowed; {', '.join(VERSIONS)} are")
            return VERSIONS[-1]
        nearest_version = VERSIONS[0] if number < (1, 4) else VERSIONS[-1]
        self._warn(xml, f"version {given} is read as {nearest_version}; {', '.join(VERSIONS)} are known")
        return nearest_version

    def _error(self, xml: etree._Element, message: str) -> None:
        self.diagnostics.error(self._place(xml), message)

    def _warn(self, xml: etree._Element, message: str) -> None:
        self.diagnostics.warn(self._place(xml), message)

    def _place(self, xml: etree._Element) -> Place:
        return Place(self.label, _line(xml), _local(xml))

    # Elements ----------------------------------------------------------------------------------------------------

    def _element(self, xml: etree._Element, description: Description | None) -> Element:
        """An element and all in it, checked against its description."""
        name = _local(xml) if description is not None or not xml.prefix else f"{xml.prefix}:{_local(xml)}"
        element = Element(name, description, file=self.label, line=_line(xml))
        self._read_attributes(xml, element)
        self._read_value(xml, element)
        for child in xml:
            if isinstance(child.tag, str):
                self._read_child(child, element)
        if description is not None:
            self._check_required(xml, element, description)
        return element

    def _read_attributes(self, xml: etree._Element, element: Element) -> None:
        description = element.description
        for key, text in xml.attrib.items():
            name = str(key).rpartition("}")[2]
            if name in LATER:
                self._error(xml, f"{name} is part of SDF 1.7 and later, which libgz does not read")
            elif description is not None and not description.open and name not in element.attributes:
                self.diagnostics.no_effect(self._place(xml), functools.partial(self._unknown_attribute, name, element))
                continue
            param = element.attributes.setdefault(name, Param(name, "string", "", given=True))
            param.SetFromString(str(text))
            allowed = check(param.kind, param.text)
            if allowed:
                self._error(xml, f"{name} is {param.text!r}; it must be {allowed}")
        for about in description.all_attributes.values() if description is not None else ():
            if about.required and about.default == UNSET and not element.attributes[about.name].given:
                self._error(xml, f"attribute {about.name!r} is missing and must be given")

    def _unknown_attribute(self, name: str, element: Element) -> str:
        known = nearest(name, element.attributes)
        return f"attribute {name!r} is not part of SDF {self.version} and is ignored{known}"

    def _read_value(self, xml: etree._Element, element: Element) -> None:
        pieces = [xml.text or "", *(child.tail or "" for child in xml)]
        text = "".join(pieces)
        if not text.strip():
            return
        element.value.SetFromString(text)
        allowed = check(element.value.kind, text)
        if allowed:
            self._error(xml, f"{text.strip()!r} is not allowed; it must be {allowed}")

    def _read_child(self, xml: etree._Element, parent: Element) -> None:
        name, description = _local(xml), parent.description
        if name == "include" and description is not None and "include" in description.children:
            self._include(xml, parent, description.children["include"])
            return
        known = description.children.get(name) if description is not None and not description.open else None
        if name == "frame" and known is None and description is not None and not description.open:
            self._error(xml, "frames are part of SDF 1.7 and later, which libgz does not read")
            return
        if known is not None and known.count in ("0", "1") and parent.HasElement(name) and not _repeated(parent, name):
            again = f"occurs more than once in <{parent.name}>; only the first one has an effect"
            self.diagnostics.no_effect(self._place(xml), lambda: again)
        elif known is None and description is not None and not description.open and description.children:
            names = description.children
            self.diagnostics.no_effect(
                self._place(xml),
                lambda: f"is not part of SDF {self.version} in <{parent.name}> and has no effect{nearest(name, names)}",
            )
        parent.InsertElement(self._element(xml, known))

    def _check_required(self, xml: etree._Element, element: Element, description: Description) -> None:
        """Create missing required children with their defaults; a missing one without a default is an error."""
        for name, about in description.children.items():
            if not about.required or element.HasElement(name):
                continue
            if element.name == "script" and "uri" in description.children:
                element.AddElement(name)  # of a material: many files have only one of both, or plain text
            elif about.default == UNSET:
                self._error(xml, f"<{name}> is missing and must be given")
            elif element.name == "joint" and name == "axis" and element.attributes["type"].text in ("ball", "fixed"):
                continue
            elif element.name == "joint" and name == "axis":
                self._error(xml, "<axis> is missing and must be given")
            else:
                element.AddElement(name)

    def _check_names(self) -> None:
        """Warn of two elements of one kind and name in one parent: only the first is found by its name."""
        for holder in (*self.root.find("world"), *self.root.find("link")):
            first: dict[tuple[str, str], Element] = {}
            for element in holder.children:
                name = element.Get(str, "name") if element.name in UNIQUE else ""
                before = first.setdefault((element.name, name), element)
                if name and before is not element:
                    message = f"{name!r} is the name of another <{element.name}>, at {before.where}; names must differ"
                    self.diagnostics.warn(element, message)

    # Includes ----------------------------------------------------------------------------------------------------

    def _include(self, xml: etree._Element, parent: Element, description: Description) -> None:
        """Replace an include by its model, actor or light, with the name and pose that the include sets."""
        given = {_local(child): (child.text or "").strip() for child in xml if isinstance(child.tag, str)}
        uri = given.get("uri", "")
        if not uri:
            self._error(xml, "<uri> is missing and must be given")
            return
        if self._depth >= DEEPEST_INCLUDE:
            self._error(xml, f"includes are nested deeper than {DEEPEST_INCLUDE}: does {uri} include itself?")
            return
        try:
            path = find_model(uri, self._folder)
            included = SdfFile()
            included._depth = self._depth + 1
            included._read_file(path)
        except (NotFoundError, WorldFileError) as error:
            self._error(xml, str(error))
            return
        self.diagnostics.include(included.diagnostics)
        entity = next((e for e in included.root.children if e.name in ("model", "light", "actor")), None)
        if entity is None:
            self._error(xml, f"{path} has no model, light or actor")
            return
        self._apply_include(xml, entity, given)
        included.root.RemoveChild(entity)
        parent.InsertElement(entity)

    def _apply_include(self, xml: etree._Element, entity: Element, given: dict[str, str]) -> None:
        """Apply name, pose, static and plugins of an include to the included entity."""
        if given.get("name"):
            entity.set_attribute("name", given["name"])
        for key in ("pose", "static"):
            if key in given:
                target = entity.GetElement(key)
                if target is not None:
                    target.value.SetFromString(given[key])
                    allowed = check(target.value.kind, given[key])
                    if allowed:
                        self._error(xml, f"<{key}> is {given[key]!r}; it must be {allowed}")
        plugin = describe(self.version)["plugin"]
        for child in xml:
            if isinstance(child.tag, str) and _local(child) == "plugin":
                entity.InsertElement(self._element(child, plugin))


def _repeated(parent: Element, name: str) -> bool:
    """Whether further elements of this name have an effect."""
    what = parent.attributes["type"].text if parent.name == "sensor" else parent.name
    return (what, name) in REPEATED


def is_sdf(filename: str | os.PathLike[str]) -> bool:
    """Whether the root element of a file is `<sdf>`; false for what cannot be read or is not XML."""
    try:
        with Path(filename).open("rb") as stream:
            return _root_is_sdf(stream)
    except OSError:
        return False


def is_sdf_text(text: str) -> bool:
    """The same for a text."""
    return _root_is_sdf(BytesIO(text.encode()))


def _root_is_sdf(stream: IO[bytes]) -> bool:
    try:
        events = etree.iterparse(stream, events=("start",), resolve_entities=False, no_network=True, recover=True)
        _, root = next(iter(events))
        return _local(root) == "sdf"
    except (StopIteration, etree.XMLSyntaxError):
        return False


def _local(xml: etree._Element) -> str:
    """The tag without its namespace."""
    return str(xml.tag).rpartition("}")[2]


def _line(xml: etree._Element) -> int:
    line = xml.sourceline
    return line if isinstance(line, int) else 0
