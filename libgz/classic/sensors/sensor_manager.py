"""SensorManager: the sensors of all worlds of this process, by Gazebo's names."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, overload

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic.names import takes_names
from libgz.classic.physics import get_world, worlds
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.link import Link
from libgz.classic.physics.registry import own_world
from libgz.classic.sensors.kinds import all_kinds
from libgz.sdf.upgrade import upgraded

if TYPE_CHECKING:
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.classic.sensors.sensor import Sensor
    from libgz.sdf.element import Element

__all__ = ["SensorManager", "get_sensor", "remove_sensors", "run_once", "run_threads"]

log = logging.getLogger("libgz.classic")


S = TypeVar("S", bound="Sensor")


@takes_names
class SensorManager:
    """All sensors; the only instance is `SensorManager.Instance()`.

    Sensors measure after each iteration of their world, in its thread; there are no threads to run.
    """

    _instance: ClassVar[SensorManager | None] = None

    @classmethod
    def Instance(cls) -> SensorManager:
        """The instance of this process."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    def _all(self) -> list[WorldSensors]:
        return [world.server.sensors for world in worlds() if world.server.sensors is not None]

    @overload
    def GetSensor(self, name: str) -> Sensor | Any: ...

    @overload
    def GetSensor(self, name: str, kind: type[S]) -> S | Any: ...

    def GetSensor(self, name: str, kind: type[Any] = object) -> Any:
        """A sensor by its full name, its name from the model on, or the plain one if that is unique; else None.

        A plugin gets the sensor of its own world, if there is one of this name.

        Args:
            name: of the sensor.
            kind: its class, such as `RaySensor`; None is returned for a sensor of another one, as by C++'s
                dynamic_pointer_cast.
        """
        own = own_world()
        found = own.server.sensors.find(name) if own is not None and own.server.sensors is not None else []
        found = found or [sensor for sensors in self._all() for sensor in sensors.find(name)]
        if len(found) > 1:
            names = ", ".join(sensor.ScopedName() for sensor in found)
            log.warning("Unable to get a sensor, multiple sensors are called %s: %s. Use a scoped name.", name, names)
        return found[0] if len(found) == 1 and isinstance(found[0], kind) else None

    def GetSensors(self) -> list[Sensor]:
        """All sensors."""
        return [sensor for sensors in self._all() for sensor in sensors.sensors.values()]

    def GetSensorTypes(self) -> list[str]:
        """The allowed types of a `<sensor>`."""
        return all_kinds()

    def SensorsInitialized(self) -> bool:
        """Whether all sensors are ready: always, because they are made with their models."""
        return True

    def CreateSensor(self, sdf: Element, worldName: str, parentName: str, parentId: int = 0) -> str:
        """Add a sensor to a link or joint; returns its full name.

        Raises:
            NotFoundError: there is no such world, link or joint.
            ParameterError: the element has an error.
        """
        world = get_world(worldName)
        parent = world.BaseByName(parentName)
        if not isinstance(parent, Link | Joint):
            names = [part.GetScopedName() for part in world.tree() if isinstance(part, Link | Joint)]
            raise NotFoundError(f"world {worldName!r} has no link or joint {parentName!r}{nearest(parentName, names)}")
        sensors: WorldSensors = world.server.all_sensors()
        sensor = sensors.create(parent, sdf)
        sensors.start_new()
        if sensor is None:
            raise ParameterError(f"{sdf.where}: this sensor could not be made")
        sensor.source = upgraded(sdf).ToString()
        return sensor.ScopedName()

    def RemoveSensor(self, name: str) -> None:
        """Remove a sensor and its plugins; the name is as for GetSensor.

        Raises:
            NotFoundError: there is none of this name.
        """
        sensor = self.GetSensor(name)
        if sensor is None:
            names = [known.ScopedName() for known in self.GetSensors()]
            raise NotFoundError(f"Unable to remove sensor[{name}] because it does not exist.{nearest(name, names)}")
        sensor.sensors.remove(sensor)

    def RemoveSensors(self) -> None:
        """Remove all sensors."""
        for sensor in self.GetSensors():
            sensor.sensors.remove(sensor)

    def Update(self, force: bool = False) -> None:
        """Let the sensors that are due measure, or all of them if forced."""
        for sensors in self._all():
            sensors.update()
            for sensor in list(sensors.sensors.values()) if force else ():
                sensor.Update(True)

    def ResetLastUpdateTimes(self) -> None:
        """Forget the times of all measurements."""
        for sensor in self.GetSensors():
            sensor.ResetLastUpdateTime()

    def Init(self) -> None:
        """Nothing to do: sensors start with their models."""

    def RunThreads(self) -> None:
        """Nothing to do: sensors measure after each iteration."""

    def Stop(self) -> None:
        """Nothing to do: there are no threads."""

    def Fini(self) -> None:
        """Nothing to do: sensors end with their worlds."""


@overload
def get_sensor(name: str) -> Sensor | Any: ...


@overload
def get_sensor(name: str, kind: type[S]) -> S | Any: ...


@takes_names
def get_sensor(name: str, kind: type[Any] = object) -> Any:
    """`SensorManager.Instance().GetSensor(name, kind)`."""
    return SensorManager.Instance().GetSensor(name, kind)


def remove_sensors() -> None:
    """Remove all sensors of all worlds."""
    SensorManager.Instance().RemoveSensors()


def run_once(force: bool = False) -> None:
    """`SensorManager.Instance().Update(force)`."""
    SensorManager.Instance().Update(force)


def run_threads() -> None:
    """Nothing to do: sensors measure after each iteration, in the world's thread."""
