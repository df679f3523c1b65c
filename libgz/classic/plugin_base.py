"""PluginT: the base class of all plugins."""

from __future__ import annotations

import logging
from collections.abc import Callable, Set
from enum import IntEnum
from typing import ClassVar, TypeVar

from libgz.base.encoding import register
from libgz.classic.common import Color, NumericKeyFrame, PoseKeyFrame, Time
from libgz.classic.math import (
    Angle,
    AxisAlignedBox,
    Inertiald,
    MassMatrix3d,
    Matrix3d,
    Pose3d,
    Quaterniond,
    Vector2d,
    Vector2i,
    Vector3d,
)
from libgz.classic.names import takes_names
from libgz.sdf.element import Element

__all__ = ["PluginT", "PluginType"]

# What the state of a plugin may hold as a value, beside plain data and messages.
_VALUES: tuple[type, ...] = (Angle, AxisAlignedBox, Color, Inertiald, MassMatrix3d, Matrix3d, NumericKeyFrame, Pose3d)
for _value in (*_VALUES, PoseKeyFrame, Quaterniond, Time, Vector2d, Vector2i, Vector3d):
    register(_value)

console = logging.getLogger("libgz.classic.console")

T = TypeVar("T")


class PluginType(IntEnum):
    """The kinds of plugins, with Gazebo's numbers."""

    WORLD_PLUGIN = 0
    MODEL_PLUGIN = 1
    SENSOR_PLUGIN = 2
    SYSTEM_PLUGIN = 3
    VISUAL_PLUGIN = 4
    GUI_PLUGIN = 5


@takes_names
class PluginT:
    """Base of all plugins.

    A plugin with a memory of its own declares it, so that a snapshot of the world has it: the names of its attributes
    as `STATE`, or methods `SaveState()` and `LoadState(state)`, or both; `STATE = ()` if there is nothing. Values are
    plain data: numbers, strings, tuples, lists and dicts of them, arrays, vectors, times, messages, random generators,
    PIDs. What Load reads from the file, and views such as models and joints, are not part of it::

        class Patrol(ModelPlugin):
            STATE = ("goal", "since")

    Attributes:
        filename: The file name, as the world gives it; set after the constructor.
        handleName: The name of the plugin in the world, likewise.
    """

    kind: ClassVar[str] = ""
    filename = handleName = ""
    _watched: Set[str] = frozenset()  # the attributes that recorded laws depend on; see `Stepping`
    _law_changed: Callable[[], object] = staticmethod(lambda: None)

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute; a law that depends on it is recorded again."""
        object.__setattr__(self, name, value)
        if name in self._watched:
            self._law_changed()

    def GetFilename(self) -> str:
        """The file name, as the world gives it."""
        return self.filename

    def GetHandle(self) -> str:
        """The name of the plugin in the world."""
        return self.handleName

    def GetType(self) -> str:
        """The kind: World, Model, Sensor, System, Visual or GUI."""
        return self.kind

    def LoadParam(self, sdf: Element, name: str, default: T) -> T:
        """The value of a child of the plugin's element, or `default`; either is logged to the console."""
        value, found = sdf.Get(type(default), name, default)
        handle = self.handleName
        if found:
            console.info("%s Plugin <%s> set to <%s>", handle, name, value)
        else:
            console.info("%s Plugin missing <%s>, defaults to <%s>", handle, name, value)
        return value

    def Init(self) -> None:
        """Called right after Load."""

    def Reset(self) -> None:
        """Called when the world is reset."""
