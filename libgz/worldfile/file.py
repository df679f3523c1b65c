"""WorldFile: a legacy worldfile, parsed safely, checked, and saved with its comments and layout."""

from __future__ import annotations

import codecs
import functools
import logging
import os
import re
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

from lxml import etree

from libgz.base.entities import Entities, check_attributes, encoded
from libgz.base.errors import Diagnostics, ParameterError, Place, WorldFileError
from libgz.base.files import check_size, expand, is_file, read_limited, save_file, write_whole, xml_parser
from libgz.worldfile.node import Changes, WorldFileNode
from libgz.worldfile.number import atof
from libgz.worldfile.spelling import DEFAULT_STEP, OLD_MODELS, OLD_ORIGIN_HEIGHT, OLD_TAGS

__all__ = ["WorldFile"]

log = logging.getLogger("libgz.worldfile")

# Roots of files that have a world's name now and then, and what those files are.
OTHER_ROOTS = {
    "launch": "a launch file of ROS (its world is another file, often its argument world_name)",
    "package": "the description of a ROS package",
    "COLLADA": "a mesh (COLLADA)",
    "X3D": "a scene of X3D",
    "svg": "an image (SVG)",
    "mujoco": "a model of MuJoCo",
    "gazebo": "an SDF world of Gazebo 1.0",
    "sdf": "an SDF world of Gazebo classic",
    "robot": "a robot description (URDF)",
    "html": "a web page",
    "rosparam": "a file of parameters of ROS",
}
OUTER_SDF = ("world", "model", "actor", "light")  # elements of SDF that stand inside <sdf>


class WorldFile:
    """A worldfile of Gazebo 0.3 - 0.7.

    `Load` reads it; `GetRootNode` gives its elements. Entities of the file itself are replaced where they are text;
    external files and the network are off.
    """

    def __init__(self) -> None:
        self.filename: str | None = None
        self.label = "<worldfile>"  # the file's name in messages
        self.diagnostics = Diagnostics()
        self.source = b""
        self.encoding = "utf-8"
        self.root: WorldFileNode | None = None
        self.changes = Changes()  # since the file was read

    @classmethod
    def from_file(cls, filename: str | os.PathLike[str]) -> WorldFile:
        """Read a worldfile.

        Raises:
            WorldFileError: it cannot be read or is not well-formed.
        """
        file = cls()
        file.Load(filename)
        return file

    @staticmethod
    def of(node: WorldFileNode) -> WorldFile:
        """The worldfile of an element.

        Raises:
            ParameterError: the element belongs to something else.
        """
        if not isinstance(node.file, WorldFile):
            raise ParameterError(f"{node!r} does not belong to a WorldFile")
        return node.file

    def Load(self, filename: str | os.PathLike[str]) -> int:
        """Read a worldfile; 0.

        Raises:
            WorldFileError: it cannot be read or is not well-formed, or this object holds a file already.
        """
        path = Path(filename)
        try:
            source = read_limited(path)
        except OSError as error:
            raise WorldFileError(f"cannot read worldfile {str(path)!r}: {error.strerror}") from None
        self._parse(source, str(path), str(path))
        return 0

    def LoadString(self, text: str | bytes, label: str = "<string>") -> int:
        """The same from text; `label` is its name in messages."""
        self._parse(encoded(text) if isinstance(text, str) else text, None, label)
        return 0

    def _parse(self, source: bytes, filename: str | None, label: str) -> None:
        if self.root is not None:
            raise WorldFileError(f"this WorldFile holds {self.label} already; use a new one for {label}")
        self.filename, self.label, self.source = filename, label, source
        parser = xml_parser(recover=True)  # files of those years have invalid namespace addresses
        try:
            root = etree.fromstring(source, parser)
        except etree.XMLSyntaxError as error:
            raise WorldFileError(f"{label}:{error.lineno or 1}: {error.msg}") from None
        fatal = [e for e in parser.error_log if e.level == etree.ErrorLevels.FATAL]
        if fatal:
            raise WorldFileError("\n".join(f"{label}:{e.line}: {e.message.strip()}" for e in fatal))
        if root is None:
            raise WorldFileError(f"{label}:1: the document is empty")
        check_attributes(root, label)
        self.encoding = _encoding(root)
        self._numbered = 0
        self._entities = Entities(root)
        self.root = self._node(root, None)
        for entry in parser.error_log:  # namespace addresses, which nothing uses
            log.info("%s:%d: %s", label, entry.line, entry.message.strip())
        self._refuse_other_formats()

    def _node(self, element: etree._Element, parent: WorldFileNode | None) -> WorldFileNode:
        """The node of an element, with all below it."""
        name, sourceline = str(element.tag).rpartition("}")[2], element.sourceline
        line = sourceline if isinstance(sourceline, int) else 0
        if element.prefix is None and ":" in name:
            prefix, _, local = name.partition(":")
            undeclared = f"prefix {prefix!r} is not declared, so this element is skipped; add xmlns:{prefix}='...'"
            self.diagnostics.warn(Place(self.label, line, f"{prefix}:{local}"), undeclared)
        attributes = {str(k): str(v) for k, v in element.attrib.items()}
        number = self._numbered
        self._numbered += 1
        node = WorldFileNode(self, parent, name, element.prefix, line, number, attributes)
        node.reported = element.prefix is None and ":" in name
        node.pieces.append(element.text or "")
        for child in element:
            if isinstance(child.tag, str):
                child_node = self._node(child, node)
                node.children.append(child_node)
                node.pieces.append(child_node)
            elif isinstance(child, etree._Entity):
                node.pieces.append(self._entity_text(child, node))
            node.pieces.append(child.tail or "")
        return node

    def _entity_text(self, entity: etree._Entity, node: WorldFileNode) -> str:
        try:
            return self._entities.text(str(entity.name))
        except ParameterError as error:
            node.error(str(error))
            return ""

    def _refuse_other_formats(self) -> None:
        """Raise an error for the formats of later Gazebos and of other programs, instead of an empty world."""
        root = self.GetRootNode()
        if root.prefix == "gazebo":
            raise WorldFileError(
                f"{self.label}:{root.line}: <{root.tag}>: this is a world of Gazebo 0.8 - 0.10, "
                "which libgz does not read; worlds of 0.3 - 0.7 have a root like <gz:world>"
            )
        other = OTHER_ROOTS.get(root.name) if root.prefix is None else None
        inside = {child.tag for child in root.children}
        if root.tag == "model" and "sdf" in inside:
            other = "the model.config of a model's folder"
        elif root.tag in OUTER_SDF and (root.tag != "world" or inside & {"model", "include"}):
            other = f"an SDF {root.tag} without <sdf version='1.6'> around it"
        if other is not None:
            raise WorldFileError(
                f"{self.label}:{root.line}: <{root.tag}>: this is {other}, "
                "not a worldfile of 0.3 - 0.7, whose root is like <gz:world>"
            )

    def note_foreign(self) -> None:
        """Warn of a file without any sign of a worldfile; the old server loaded it as an empty world."""
        root = self.GetRootNode()
        if root.prefix is None and not any(node.prefix == "model" for node in root.walk()):
            root.warn("there is no <model:...> element in this file, and its root is not like <gz:world>")

    def GetRootNode(self) -> WorldFileNode:
        """The root element.

        Raises:
            WorldFileError: nothing was loaded.
        """
        if self.root is None:
            raise WorldFileError("no worldfile was loaded")
        return self.root

    def ResolveFilename(self, name: str) -> str:
        """A file name made absolute: `~` is expanded, relative names lie in the worldfile's directory."""
        path = expand(name)
        if path.is_absolute():
            return str(path)
        folder = Path(self.filename).parent if self.filename else Path()
        return os.path.realpath(folder / path)

    def WarnUnused(self) -> bool:
        """Log a warning for each element that no getter read, with its line; whether there was one."""
        return self.GetRootNode().WarnUnused()

    # Older files -------------------------------------------------------------------------------------------------

    @functools.cached_property
    def step_time(self) -> float:
        """The world's stepTime [s], wherever it is in the file; older contact attributes depend on it."""
        found = next((node for node in self.GetRootNode().walk() if node.name == "stepTime"), None)
        return (atof(found.content) if found else 0.0) or DEFAULT_STEP

    @functools.cached_property
    def is_old(self) -> bool:
        """Whether this file was written for Gazebo 0.4, when some models had their origin higher.

        The root's `version` attribute decides; without one, tags and models that only 0.4 had.
        """
        version = self.GetRootNode().attributes.get("version")
        if version is not None:
            return atof(version) < 0.5
        models = [node for node in self.GetRootNode().walk() if node.prefix == "model"]
        return any(node.name in OLD_MODELS or any(c.name in OLD_TAGS for c in node.children) for node in models)

    def origin_height(self, node: WorldFileNode) -> float:
        """How far above its present origin a model of this file is meant to have it [m]; 0 from 0.5 on."""
        if not self.is_old:
            return 0.0
        if node.name == "SimpleSolid":
            size = node.GetChild("size")
            shape = (node.GetString("shape", "box") or "box").strip()
            index, default = {"box": (2, 0.5), "cylinder": (1, 0.5), "sphere": (0, 0.5)}.get(shape, (2, 0.5))
            tokens = size.content.split() if size else []
            return 0.5 * (atof(tokens[index]) if len(tokens) > index else default)
        return OLD_ORIGIN_HEIGHT.get(node.name, 0.0)

    def changed(self) -> WorldFile:
        """A new worldfile with the values that were changed in this one, as if it had been read so."""
        file = WorldFile()
        file.LoadString(self._changed_source(), self.label)
        file.filename = self.filename
        return file

    # Saving ------------------------------------------------------------------------------------------------------

    def Save(
        self,
        filename: str | os.PathLike[str] | None = None,
        *,
        removed: Collection[WorldFileNode] = (),
        added: Iterable[WorldFileNode] = (),
        backup: bool = False,
    ) -> int:
        """Write the file with its changed values; comments, order and layout stay. 0.

        Args:
            filename: where to write; None for the file that was loaded.
            removed: elements that are left out of what is written.
            added: elements of other worldfiles, which are written at the end.
            backup: keep the file that is there as ``NAME.bak``; a file that would stay as it is is not written.

        Raises:
            WorldFileError: the file cannot be written, or has no name.
        """
        target = filename or self.filename
        if target is None:
            raise WorldFileError("this worldfile was loaded from text: name a file to save it to")
        try:
            source = self.text(removed=removed, added=added)
            check_size(source, "it")
        except WorldFileError as error:
            raise WorldFileError(f"unable to save {str(target)!r}: {error}") from None
        log.info("saving: %s", target)
        try:
            if not backup:
                write_whole(Path(target), source)
                return 0
            before = Path(target).read_bytes() if is_file(Path(target)) else None
            if before != source:
                save_file(Path(target), source, before)
        except OSError as error:
            raise WorldFileError(f"unable to save {str(target)!r}: {error.strerror}") from None
        return 0

    def text(self, *, removed: Collection[WorldFileNode] = (), added: Iterable[WorldFileNode] = ()) -> bytes:
        """What `Save` writes, with the same arguments.

        Raises:
            WorldFileError: the document is in UTF-16 or UTF-32.
        """
        elements = [self._adopted(node, removed) for node in added]
        return self._changed_source({n.number for n in removed if n.file is self}, elements)

    def text_with(self, element: bytes) -> bytes:
        """The file's bytes with another element at the end.

        Raises:
            WorldFileError: the document is in UTF-16 or UTF-32.
        """
        return self._changed_source(appended=[element])

    def element_text(self, node: WorldFileNode) -> str:
        """The text of one element, with its changed values and the prefixes that it needs.

        Raises:
            WorldFileError: the document is in UTF-16 or UTF-32.
        """
        return self._changed_source(only=node.number).decode(self.encoding)

    @property
    def models(self) -> list[WorldFileNode]:
        """The elements of models, in order of the document."""
        return [node for node in self.GetRootNode().walk() if node.prefix == "model"]

    def _changed_source(self, removed: Collection[int] = (), appended: Sequence[bytes] = (), only: int = 0) -> bytes:
        """The file's bytes, or those of one element, with its changed values."""
        changes = self.changes
        if not (changes or removed or appended or only):
            return self.source
        from libgz.worldfile.source import splice  # most files stay as they are

        children = {number: [(child.name, child.content) for child in c] for number, c in changes.children.items()}
        return splice(
            self.source, changes.texts, changes.attributes, children, self.encoding,
            removed=removed, appended=appended, only=only,
        )  # fmt: skip

    def _adopted(self, node: WorldFileNode, removed: Collection[WorldFileNode]) -> bytes:
        """The bytes of an element of another worldfile, which declare the prefixes that this file's root does not."""
        from libgz.worldfile.source import element_spans

        other = WorldFile.of(node)
        gone = {n.number for n in removed if n.file is other}
        text = other._changed_source(gone, only=node.number).decode(other.encoding)
        head = self.source[: element_spans(self.source)[0].content].decode(self.encoding)
        tag = f"<{node.tag}"
        for prefix in sorted(set(re.findall(r"</?([\w-]+):", text))):
            if f"xmlns:{prefix}" not in head + text:
                text = text.replace(tag, f"{tag} xmlns:{prefix}='{prefix}'", 1)
        return text.encode(self.encoding, "xmlcharrefreplace")


def _encoding(root: etree._Element) -> str:
    """The document's encoding if Python has it, else UTF-8."""
    name = root.getroottree().docinfo.encoding or "utf-8"
    try:
        return codecs.lookup(name).name
    except LookupError:
        return "utf-8"
