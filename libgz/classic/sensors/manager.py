"""WorldSensors: the sensors of one world, their plugins, and when each measures."""

from __future__ import annotations

import logging
import math
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from libgz.classic.sensors.kinds import ABSENT, KINDS, sensor_class
from libgz.classic.sensors.sensor import Sensor
from libgz.errors import GazeboError, ParameterError, WorldFileError, nearest

if TYPE_CHECKING:
    from libgz.classic.loading import LoadedPlugin
    from libgz.classic.physics import Joint, Link, Model, World
    from libgz.classic.transport.topic import Topic
    from libgz.sdf.element import Element

__all__ = ["WorldSensors"]

log = logging.getLogger("libgz.classic")


class WorldSensors:
    """Makes the sensors of a world, and lets them measure after each iteration, in the order of the file.

    Sensors that nobody wants anything of cost nothing.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self.sensors: dict[str, Sensor] = {}  # by full name
        self._new: list[Sensor] = []
        self._plugins: dict[Sensor, list[LoadedPlugin]] = {}
        self._awake: dict[Sensor, None] = {}
        self._gathering: list[Sensor] = []  # awake, and want to see every iteration
        self._watched: list[tuple[Topic, Sensor]] = []  # asleep, until somebody listens
        self._now = 0.0  # [s] of the last iteration
        self._next = -math.inf  # [s] before this sim time nobody wants to measure
        self._diagnostics: list[str] = []
        self._started = False
        self._served = False

    @property
    def draws(self) -> bool:
        """Whether there is a camera."""
        return any(sensor.draws for sensor in self.sensors.values())

    # Making ------------------------------------------------------------------------------------------------------

    def create(self, parent: Link | Joint, element: Element) -> Sensor | None:
        """A sensor of a `<sensor>` element; None if there is none of its type, or it is wrong, which is told."""
        kind = element.Get(str, "type")
        if kind in ABSENT:
            log.warning("%s: <sensor>: type %r is not simulated; the sensor is left out", element.where, kind)
            return None
        try:
            if kind not in KINDS:
                raise ParameterError(
                    f"{element.where}: <sensor>: type is {kind!r}; allowed are {', '.join(KINDS)}{nearest(kind, KINDS)}"
                )
            sensor = sensor_class(KINDS[kind])(self, parent, element)
            if sensor.ScopedName() in self.sensors:
                raise ParameterError(f"{element.where}: <sensor>: there is a {sensor.ScopedName()!r} already")
        except ParameterError as error:
            self._diagnostics.append(str(error))
            return None
        self.sensors[sensor.ScopedName()] = sensor
        self._new.append(sensor)
        return sensor

    def start_new(self) -> None:
        """Begin with the sensors made since, then load their plugins.

        Raises:
            WorldFileError: a sensor of the world's own file is wrong; later such sensors are told of and left out.
        """
        diagnostics, self._diagnostics = self._diagnostics, []
        if diagnostics and not self._started:
            raise WorldFileError("\n".join(diagnostics))
        later, self._started = self._started, True
        for error in diagnostics:
            log.error("%s", error)
        added, self._new = self._new, []
        for sensor in added:
            self._init(sensor, later)
        self._served = False
        self.update_topics()
        for sensor in (one for one in added if one.ScopedName() in self.sensors):
            for element in sensor.sdf.named("plugin"):
                self.load_plugin(sensor, element)

    def _init(self, sensor: Sensor, later: bool) -> None:
        try:
            sensor.Init()
        except GazeboError as error:
            if not later:
                raise
            log.error("%s: <sensor>: %s", sensor.sdf.where, error)
            self.remove(sensor)
        self.wake(sensor)

    def load_plugin(self, sensor: Sensor, element: Element) -> bool:
        """Load a plugin of a sensor; whether it runs."""
        filename, name = element.Get(str, "filename"), element.Get(str, "name")
        plugin = self.world.server.new_plugin("Sensor", filename, name, f"Sensor[{sensor.Name()}]")
        if plugin is None or not plugin.start(sensor, element):
            return False
        self._plugins.setdefault(sensor, []).append(plugin)
        return True

    # Measuring ---------------------------------------------------------------------------------------------------

    def wake(self, sensor: Sensor) -> None:
        """Something about a sensor has changed: see whether it measures, and when."""
        if sensor in self._awake:
            self._next = -math.inf
        elif self.sensors.get(sensor.ScopedName()) is sensor and sensor.IsActive():
            awake = sorted([*self._awake, sensor], key=lambda one: one.Id())
            self._awake = dict.fromkeys(awake)
            self._next = -math.inf
            sensor.went_active()
            self._sort_out()

    def _sleep(self, sensor: Sensor) -> None:
        del self._awake[sensor]
        sensor.went_idle()
        self._sort_out()

    def _sort_out(self) -> None:
        """List who is to be looked after in each iteration."""
        self._gathering = [sensor for sensor in self._awake if sensor.gathers]
        idle = [sensor for sensor in self.sensors.values() if sensor not in self._awake and sensor.publisher]
        self._watched = []
        if idle:
            from libgz.classic.transport import TopicManager

            topics = TopicManager.Instance()
            self._watched = [(topics.topic(one.publisher.GetTopic()), one) for one in idle if one.publisher]

    def update(self) -> None:
        """Let those measure whose time has come; an iteration is over."""
        if not self._served:
            self.update_topics()
        for topic, sensor in self._watched:
            if topic.subscribers or topic.remote:
                self.wake(sensor)
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
        for sensor in list(self._awake):
            if now < sensor.due or sensor not in self._awake:  # one sensor's listener may have removed another
                continue
            if not sensor.IsActive():
                self._sleep(sensor)
                continue
            try:
                sensor.Update(False)
            except GazeboError as error:
                log.error("sensor %s is taken out, for it cannot measure: %s", sensor.ScopedName(), error)
                self.remove(sensor)
        self._next = min((sensor.due for sensor in self._awake), default=math.inf)

    def update_topics(self) -> None:
        """Offer the topics of all sensors, once somebody in this process listens or speaks."""
        if self._served or "libgz.classic.transport" not in sys.modules:
            return
        from libgz.classic.transport import Node

        self._served = True
        self._node = Node()
        self._node.Init(self.world.Name())
        for sensor in self.sensors.values():
            topic = sensor.Topic()
            if sensor.publisher is None and topic and sensor.message_type:
                try:
                    sensor.publisher = self._node.Advertise(sensor.message_type, topic, 100)
                except GazeboError as error:
                    log.error("%s: <sensor>: %s", sensor.sdf.where, error)
        self._sort_out()

    # Telling -----------------------------------------------------------------------------------------------------

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
        """Take a sensor out, with its plugins."""
        for plugin in self._plugins.pop(sensor, ()):
            plugin.drop()
        if sensor in self._awake:
            self._sleep(sensor)
        self.sensors = {name: kept for name, kept in self.sensors.items() if kept is not sensor}
        self._new = [new for new in self._new if new is not sensor]
        sensor.Fini()
        self._sort_out()
        self.world.core.events["RemoveSensor"](sensor.ScopedName())

    def remove_of(self, model: Model) -> None:
        """A model leaves, and so do its sensors."""
        for sensor in list(self.sensors.values()):
            if sensor.parent.GetParentModel() is model:
                self.remove(sensor)

    def remove_on(self, joint: Joint) -> None:
        """A joint is no more, and nor are its sensors."""
        for sensor in list(self.sensors.values()):
            if sensor.parent is joint:
                self.remove(sensor)

    def reset(self) -> None:
        """The clock was set back: sensors begin anew."""
        self._next, self._now = -math.inf, 0.0
        for sensor in self.sensors.values():
            sensor.reset()

    def close(self) -> None:
        """The world ends."""
        for sensor in list(self.sensors.values()):
            self.remove(sensor)
