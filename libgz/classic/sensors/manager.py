"""WorldSensors: the sensors of one world, their plugins and their schedule."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from libgz.classic.sensors.kinds import ABSENT, KINDS, ON_JOINTS, sensor_class
from libgz.classic.sensors.sensor import Sensor
from libgz.classic.transport import Node, TopicManager
from libgz.errors import Diagnostics, GazeboError, LibraryError, ParameterError, nearest

if TYPE_CHECKING:
    from libgz.classic.loading import LoadedPlugin
    from libgz.classic.physics import Joint, Link, Model, World
    from libgz.classic.transport.topic import Topic
    from libgz.sdf.element import Element

__all__ = ["WorldSensors"]

log = logging.getLogger("libgz.classic")


class WorldSensors:
    """Makes the sensors of a world, and lets them measure after each iteration, in the order of the file.

    Inactive sensors cost nothing.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self.sensors: dict[str, Sensor] = {}  # by full name
        self._new: list[Sensor] = []
        self._plugins: dict[Sensor, list[LoadedPlugin]] = {}
        self._active: dict[Sensor, None] = {}
        self._gathering: list[Sensor] = []  # active, and need every iteration
        self._idle: list[tuple[Topic, Sensor]] = []  # inactive until their topics have subscribers
        self._now = 0.0  # [s] of the last iteration
        self._next = -math.inf  # [s] sim time of the next measurement
        self._diagnostics = Diagnostics()
        self._started = False
        self._node: Node | None = None

    @property
    def renders(self) -> bool:
        """Whether there is a camera."""
        return any(sensor.renders for sensor in self.sensors.values())

    # Making ------------------------------------------------------------------------------------------------------

    def create(self, parent: Link | Joint, element: Element) -> Sensor | None:
        """Make the sensor of a `<sensor>`; None if its type is not simulated, or after an error, which is kept."""
        kind = element.Get(str, "type")
        if kind in ABSENT:
            log.warning("%s: <sensor>: type %r is not simulated; the sensor is left out", element.where, kind)
            return None
        try:
            if kind not in KINDS:
                raise ParameterError(
                    f"{element.where}: <sensor>: type is {kind!r}; allowed are {', '.join(KINDS)}{nearest(kind, KINDS)}"
                )
            if kind not in ON_JOINTS and not hasattr(parent, "pose"):
                raise ParameterError(
                    f"{element.where}: <sensor>: type is {kind!r}, which stands in a <link>; in a <joint>, "
                    f"{' and '.join(ON_JOINTS)} is allowed"
                )
            sensor = sensor_class(kind)(self, parent, element)
            if sensor.ScopedName() in self.sensors:
                raise ParameterError(f"{element.where}: <sensor>: there is a {sensor.ScopedName()!r} already")
        except Exception as error:  # noqa: BLE001 - an error of the file, whatever it met
            self._diagnostics.failure(element, error)
            return None
        self.sensors[sensor.ScopedName()] = sensor
        self._new.append(sensor)
        return sensor

    def start_new(self) -> None:
        """Start the sensors made since the last call, then load their plugins.

        Raises:
            WorldFileError: a sensor of the world's own file has an error; later such sensors are logged and left out.
        """
        diagnostics, self._diagnostics = self._diagnostics, Diagnostics()
        if not self._started:
            diagnostics.raise_errors()
        later, self._started = self._started, True
        for error in diagnostics.errors:
            log.error("%s", error)
        added, self._new = self._new, []
        for sensor in added:
            self._init(sensor, later)
        self._advertise()
        for sensor in (one for one in added if one.ScopedName() in self.sensors):
            for element in sensor.sdf.named("plugin"):
                self.load_plugin(sensor, element)

    def _init(self, sensor: Sensor, later: bool) -> None:
        try:
            sensor.Init()
        except Exception as error:
            found = Diagnostics()
            found.failure(sensor.sdf, error)
            if not later:
                if isinstance(error, LibraryError):  # of this computer, not of the file
                    raise
                found.raise_errors()
            log.error("%s", found.errors[0])
            self.remove(sensor)
        self.reschedule(sensor)

    def load_plugin(self, sensor: Sensor, element: Element) -> bool:
        """Load a plugin of a sensor; whether it runs."""
        filename, name = element.Get(str, "filename"), element.Get(str, "name")
        plugin = self.world.server.new_plugin("Sensor", filename, name, f"Sensor[{sensor.Name()}]")
        if plugin is None or not plugin.start(sensor, element):
            return False
        self._plugins.setdefault(sensor, []).append(plugin)
        return True

    # Measuring ---------------------------------------------------------------------------------------------------

    def reschedule(self, sensor: Sensor) -> None:
        """The activity or rate of a sensor may have changed: check whether it measures, and when."""
        if sensor in self._active:
            self._next = -math.inf
        elif self.sensors.get(sensor.ScopedName()) is sensor and sensor.IsActive():
            active = sorted([*self._active, sensor], key=lambda one: one.Id())
            self._active = dict.fromkeys(active)
            self._next = -math.inf
            sensor.activated()
            self._update_lists()

    def _deactivate(self, sensor: Sensor) -> None:
        del self._active[sensor]
        sensor.deactivated()
        self._update_lists()

    def _update_lists(self) -> None:
        """List the sensors to check in each iteration."""
        self._gathering = [sensor for sensor in self._active if sensor.gathers]
        topics, inactive = TopicManager.Instance(), (s for s in self.sensors.values() if s not in self._active)
        self._idle = [(topics.topic(one.publisher.GetTopic()), one) for one in inactive if one.publisher]

    def update(self) -> None:
        """Let the sensors that are due measure, after an iteration."""
        for topic, sensor in self._idle:
            if topic.subscribers or topic.remote:
                self.reschedule(sensor)
        now = self.world.core.GetSimTime()
        if now < self._now:
            self._restart()
        if self._gathering and now > self._now:
            for sensor in self._gathering:
                sensor.gather()
        self._now = now
        if now >= self._next:
            self._measure(now)

    def _restart(self) -> None:
        for sensor in self.sensors.values():
            sensor.ResetLastUpdateTime()

    def _measure(self, now: float) -> None:
        for sensor in list(self._active):
            if now < sensor.due or sensor not in self._active:  # a callback of one may have removed another
                continue
            if not sensor.IsActive():
                self._deactivate(sensor)
                continue
            try:
                sensor.Update(False)
            except GazeboError as error:
                log.error("sensor %s is removed, because it cannot measure: %s", sensor.ScopedName(), error)
                self.remove(sensor)
        self._next = min((sensor.due for sensor in self._active), default=math.inf)

    def _advertise(self) -> None:
        """Advertise the topics of new sensors."""
        if self._node is None:
            self._node = Node()
            self._node.Init(self.world.Name())
        for sensor in self.sensors.values():
            topic = sensor.Topic()
            if sensor.publisher is None and topic and sensor.message_type:
                try:
                    sensor.publisher = self._node.Advertise(sensor.message_type, topic, 100)
                except GazeboError as error:
                    log.error("%s: <sensor>: %s", sensor.sdf.where, error)
        self._update_lists()

    # Look up -----------------------------------------------------------------------------------------------------

    def names(self) -> list[str]:
        """Full names of all sensors, ``world::model::link::sensor``."""
        return list(self.sensors)

    def find(self, name: str) -> list[Sensor]:
        """The sensors of a name: full, without the world, or the plain one."""
        exact = self.sensors.get(name) or self.sensors.get(f"{self.world.Name()}::{name}")
        if exact is not None:
            return [exact]
        return [sensor for sensor in self.sensors.values() if sensor.ScopedName().endswith(f"::{name}")]

    def plugins(self) -> Iterator[LoadedPlugin]:
        """The plugins of all sensors."""
        for loaded in list(self._plugins.values()):
            yield from loaded

    # Ends --------------------------------------------------------------------------------------------------------

    def remove(self, sensor: Sensor) -> None:
        """Remove a sensor and its plugins."""
        for plugin in self._plugins.pop(sensor, ()):
            plugin.drop()
        if sensor in self._active:
            self._deactivate(sensor)
        self.sensors = {name: kept for name, kept in self.sensors.items() if kept is not sensor}
        self._new = [new for new in self._new if new is not sensor]
        sensor.Fini()
        self._update_lists()
        self.world.core.events["RemoveSensor"](sensor.ScopedName())

    def remove_of(self, model: Model) -> None:
        """Remove the sensors of a model that is being deleted."""
        for sensor in list(self.sensors.values()):
            if sensor.parent.GetParentModel() is model:
                self.remove(sensor)

    def remove_on(self, joint: Joint) -> None:
        """Remove the sensors of a joint that was deleted."""
        for sensor in list(self.sensors.values()):
            if sensor.parent is joint:
                self.remove(sensor)

    def reset(self) -> None:
        """Start all sensors again, because the clock was reset."""
        self._next, self._now = -math.inf, 0.0
        for sensor in self.sensors.values():
            sensor.reset()

    def close(self) -> None:
        """Remove all sensors."""
        for sensor in list(self.sensors.values()):
            self.remove(sensor)
