"""PluginT: the base class of all plugins."""

from __future__ import annotations

import logging
from typing import ClassVar, TypeVar

from libgz.sdf.element import Element

__all__ = ["PluginT"]

console = logging.getLogger("libgz.classic.console")

T = TypeVar("T")


class PluginT:
    """Base of all plugins."""

    kind: ClassVar[str] = ""
    _handle = ""
    _filename = ""

    def GetFilename(self) -> str:
        """The file name, as the world gives it."""
        return self._filename

    def GetHandle(self) -> str:
        """The name of the plugin in the world."""
        return self._handle

    def GetType(self) -> str:
        """The kind: World, Model, Sensor, System, Visual or GUI."""
        return self.kind

    def LoadParam(self, sdf: Element, name: str, default: T) -> T:
        """The value of a child of the plugin's element, or `default`; either is logged to the console."""
        value, found = sdf.Get(type(default), name, default)
        handle = self._handle
        if found:
            console.info("%s Plugin <%s> set to <%s>", handle, name, value)
        else:
            console.info("%s Plugin missing <%s>, defaults to <%s>", handle, name, value)
        return value

    def Init(self) -> None:
        """Called right after Load."""

    def Reset(self) -> None:
        """Called when the world is reset."""
