"""OwnSensor: a sensor whose class is a plugin's own, in C++: `SensorFactory::RegisterSensor` registers its type."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError, PluginError
from libgz.classic.sensors.kinds import OWN, Act
from libgz.classic.sensors.sensor import LinkSensor, Sensor, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["OwnSensor", "being_made", "register"]

log = logging.getLogger("libgz.classic")

_made: list[OwnSensor] = []  # whose C++ object is being made, innermost last


class OwnSensor(LinkSensor):
    """Calls the methods of a C++ object, which calls those of this object as its base class.

    It is active at all times unless `SetActive(False)` is called: `IsActive` of its class decides whether it measures.
    """

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        self._act: Act = _nothing
        self._running: set[str] = set()
        super().__init__(sensors, parent, sdf)
        self._act = OWN[sdf.Get(str, "type")]
        _made.append(self)
        try:
            self._act(self, "new")
        finally:
            _made.pop()

    def _call(self, method: str) -> bool:
        """Call a method, unless its own one calls that of the base class; what it returns."""
        if method in self._running:
            return False
        self._running.add(method)
        try:
            return self._act(self, method)
        finally:
            self._running.remove(method)

    def Init(self) -> None:
        """Call Load and Init."""
        self._call("Init")

    def Fini(self) -> None:
        """Call Fini; an error in it is logged, for the sensor ends anyway."""
        try:
            self._call("Fini")
        except PluginError as error:
            log.error("Fini of sensor %s failed: %s", self.ScopedName(), str(error))  # its traceback has this object
        super().Fini()

    def __del__(self) -> None:
        """Delete the C++ object while this one is whole: its destructor may call methods of its base class."""
        act, self._act = self._act, _nothing  # its file stays in memory until it is deleted
        vars(self).pop("_cxx", None)
        del act

    def IsActive(self) -> bool:
        """Whether it may measure."""
        return self._active is not False

    def ready(self, elapsed: float) -> bool:
        """Call UpdateImpl: whether there is a measurement."""
        return self._call("UpdateImpl")

    def measure(self, elapsed: float) -> None:
        """Nothing: UpdateImpl has measured."""


def _nothing(_sensor: Sensor, _method: str) -> bool:
    return False


def being_made() -> OwnSensor:
    """The sensor of the C++ object whose constructor runs.

    Raises:
        ParameterError: a plugin makes one by itself.
    """
    if not _made:
        raise ParameterError("sensors of a plugin's own are made by worlds: SensorFactory::RegisterSensor")
    return _made[-1]


def register(kind: str, act: Act) -> None:
    """Let worlds make sensors of a type from now on."""
    OWN[kind] = act
