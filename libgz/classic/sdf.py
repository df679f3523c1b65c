"""Gazebo classic's `sdf` names."""

from __future__ import annotations

import logging
from pathlib import Path

from libgz.base.errors import GazeboError, ParameterError, nearest
from libgz.classic.api import without
from libgz.classic.names import takes_names
from libgz.sdf.description import NEWEST, describe
from libgz.sdf.element import Element, Param
from libgz.sdf.reader import SdfFile

__all__ = ["SDF", "Element", "ElementPtr", "Param", "SdfFile", "init", "initFile", "readFile", "readString"]

__getattr__ = without(__name__)

log = logging.getLogger("libgz.classic")

ElementPtr = Element


@takes_names
class SDF:
    """An SDF document made from text: `SetFromString`, then `Root`."""

    def __init__(self) -> None:
        self._file = SdfFile()

    def SetFromString(self, text: str) -> None:
        """Read a document.

        Raises:
            WorldFileError: the text is not SDF, or has errors; the message lists them all.
        """
        self._file = SdfFile.from_string(text)
        self._file.diagnostics.raise_errors()

    def Root(self, element: Element | None = None) -> Element:
        """The `<sdf>` element; an argument replaces it."""
        if element is not None:
            self._file.root = element
        return self._file.root

    SetRoot = Root

    @property
    def root(self) -> Element:
        """The `<sdf>` element."""
        return self._file.root

    @property
    def version(self) -> str:
        """The version that is written."""
        return NEWEST

    @staticmethod
    def Version() -> str:
        """The version that is written."""
        return NEWEST

    def FilePath(self) -> str:
        """The file it was read from, or ``<string>``."""
        return self._file.label

    def OriginalVersion(self) -> str:
        """The version that the document was written in."""
        return self._file.version

    def Clear(self) -> None:
        """Remove everything."""
        self._file = SdfFile()

    def ToString(self) -> str:
        """The document as XML."""
        return self._file.root.ToString()

    def PrintValues(self, prefix: str = "") -> str:
        """The document as XML, each line after `prefix`."""
        return self._file.root.ToString(prefix)

    def Write(self, filename: str) -> None:
        """Write the document to a file.

        Raises:
            GazeboError: the file cannot be written.
        """
        try:
            Path(filename).write_text(self.ToString())
        except OSError as error:
            raise GazeboError(f"{filename}: cannot be written: {error.strerror}") from None


def init(target: SDF) -> bool:
    """Accepted: an `SDF` needs no preparation."""
    return True


def initFile(filename: str, target: SDF | Element) -> bool:
    """Give an element the description of a file of SDF's, such as ``"light.sdf"``: its tag and defaults.

    Raises:
        ParameterError: SDF describes no such element.
    """
    name, blocks = Path(filename).stem, describe(NEWEST)
    if isinstance(target, SDF) or name == "root":
        return True
    if name not in blocks:
        raise ParameterError(f"SDF describes no {name!r}; it describes {', '.join(blocks)}{nearest(name, blocks)}")
    target.describe(blocks[name])
    return True


@takes_names
def readString(text: str, target: SDF | Element) -> bool:
    """Read a document; for an element, the first one of its tag in it. False if it has errors, which are logged."""
    try:
        _read(text if isinstance(target, SDF) or "<sdf" in text else f"<sdf version='{NEWEST}'>{text}</sdf>", target)
    except GazeboError as error:
        log.error("%s", error)
        return False
    return True


def readFile(filename: str, target: SDF | Element) -> bool:
    """The same from a file."""
    try:
        file = SdfFile.load(filename)
        file.diagnostics.raise_errors()
        _take(file, target)
    except GazeboError as error:
        log.error("%s", error)
        return False
    return True


def _read(text: str, target: SDF | Element) -> None:
    file = SdfFile.from_string(text, parts=isinstance(target, Element))
    file.diagnostics.raise_errors()
    _take(file, target)


def _take(file: SdfFile, target: SDF | Element) -> None:
    if isinstance(target, SDF):
        target._file = file
        return
    found = file.root if target.name in ("", "sdf") else next(file.root.find(target.name), None)
    if found is None:
        raise ParameterError(f"{file.label}: there is no <{target.name}> in the document")
    target.Copy(found)
