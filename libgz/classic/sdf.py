"""Gazebo classic's `sdf` names."""

from __future__ import annotations

from libgz.sdf.element import Element, Param
from libgz.sdf.reader import SdfFile

__all__ = ["SDF", "Element", "ElementPtr", "Param", "SdfFile"]

ElementPtr = Element


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

    @property
    def root(self) -> Element:
        """The `<sdf>` element."""
        return self._file.root

    def ToString(self) -> str:
        """The document as XML."""
        return self._file.root.ToString()
