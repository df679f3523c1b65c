"""WorldSensors: the sensors of one world, their plugins and their schedule."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from libgz.base.errors import Diagnostics, GazeboError, LibraryError, StateError, nearest
from libgz.classic import msgs
from libgz.classic.sensors.kinds import ABSENT, ON_JOINTS, all_kinds, sensor_class
from libgz.classic.sensors.sensor import Sensor
from libgz.classic.transport import Node, TopicManager
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST
from libgz.simulation.event import unowned
from libgz.simulation.state import decode, encode, get_values, set_values

if TYPE_CHECKING:
    from libgz.classic.loading import LoadedPlugin
    from libgz.classic.physics import Joint, Link, Model, World
    from libgz.classic.transport.topic import Topic
    from libgz.sdf.element import Element
    from libgz.simulation.event import Event
    from libgz.simulation.plan import Plan

__all__ = ["WorldSensors"]

log = logging.getLogger("libgz.classic")

SENSOR = f"<sdf version='{NEWEST}'><model name='any'><link name='any'>%s</link></model></sdf>"


class WorldSensors:
    """Makes the sensors of a world, and lets them measure after each iteration, in the order of the file.

    Inactive sensors cost nothing.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self.sensors: dict[str, Sensor] = {}  # by full name
        self._new: list[Sensor] = []
        self._unknown: list[Sensor] = []  # whose description was not published yet
        self._plugins: dict[Sensor, list[LoadedPlugin]] = {}
        self._active: dict[Sensor, None] = {}
        self._gathering: list[Sensor] = []  # active, and need every iteration
        self._idle: list[tuple[Topic, Sensor]] = []  # inactive until their topics have subscribers
        self._now = 0.0  # [s] of the last iteration
        self._natively: list[Sensor] = []  # active, and measured by native code where it makes steps alone
        self._callbacks: list[Event] = []  # of these
        self._topics: list[Topic] = []  # of these
        self._next = -math.inf  # [s] sim time of the next measurement, or an earlier one
        self._next_here = -math.inf  # [s] that of the others
        self._diagnostics = Diagnostics()
        self._parent_name: str | None = None  # of a sensor that is made again
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
        known = all_kinds()
        if kind in ABSENT and kind not in known:
            return None  # a warning of the file
        if kind not in known:
            hint = f"; there are {', '.join(known)}{nearest(kind, known)}"
            log.warning("%s: <sensor>: type %r is not simulated; the sensor is left out%s", element.where, kind, hint)
            return None
        in_link = hasattr(parent, "pose")
        if in_link and kind in ON_JOINTS:  # in some worlds of Gazebo, which run there
            hint = f"type {kind!r} stands in a <joint>, not in a <link>; the sensor is left out"
            log.warning("%s: <sensor>: %s", element.where, hint)
            return None
        if not in_link and kind not in ON_JOINTS:
            hint = f"type {kind!r} stands in a <link>, not in a <joint>; the sensor is left out"
            log.warning("%s: <sensor>: %s", element.where, hint)
            return None
        try:
            sensor = sensor_class(kind)(self, parent, element)
        except Exception as error:  # noqa: BLE001 - an error of the file, whatever it met
            self._diagnostics.failure(element, error)
            return None
        if sensor.ScopedName() in self.sensors:  # as in robots whose lumped links had sensors of one name
            log.warning("%s: <sensor>: there is a %r already; this one is left out", element.where, sensor.ScopedName())
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
        plugin = self.world.server.plugins.new("Sensor", filename, name, f"Sensor[{sensor.Name()}]", element)
        if plugin is None or not plugin.start(sensor, element):
            return False
        self._plugins.setdefault(sensor, []).append(plugin)
        return True

    # Measuring ---------------------------------------------------------------------------------------------------

    def reschedule(self, sensor: Sensor) -> None:
        """The activity or rate of a sensor may have changed: check whether it measures, and when."""
        if sensor in self._active:
            self._next = self._next_here = -math.inf
        elif self.sensors.get(sensor.ScopedName()) is sensor and sensor.wants_updates():
            self._activate(sensor)
            self._update_lists()

    def _activate(self, sensor: Sensor) -> None:
        self._active = {one: None for one in self.sensors.values() if one in self._active or one is sensor}
        sensor.activated()
        self._plan_again()

    def _deactivate(self, sensor: Sensor) -> None:
        del self._active[sensor]
        sensor.deactivated()
        self._plan_again()
        self._update_lists()

    def _update_lists(self) -> None:
        """List the sensors to check in each iteration."""
        self._gathering = [sensor for sensor in self._active if sensor.gathers]
        topics, inactive = TopicManager.Instance(), (s for s in self.sensors.values() if s not in self._active)
        self._idle = [(topics.topic(each.GetTopic()), one) for one in inactive for each in one.publishers]

    def idle_until(self) -> float:
        """The sim time [s] of the next measurement; -inf if there is something to do in each iteration."""
        if not self.sensors:
            return -math.inf if self._now else math.inf
        if self._gathering or self.world.core.GetSimTime() < self._now or (self._unknown and self._asked()):
            return -math.inf
        if any(topic.subscribers or topic.remote for topic, _ in self._idle):
            return -math.inf
        if self._natively and self._heard():
            self._plan_again()
        return self._next_here

    def _heard(self) -> bool:
        """Whether anybody gets what native code measures; asked at each stop of it."""
        for event in self._callbacks:
            if event.own:
                return True
        for topic in self._topics:  # noqa: SIM110 -- a generator would take as long again
            if topic.subscribers or topic.remote:
                return True
        return False

    def plan_end(self, plan: Plan) -> None:
        """Add the measurements that nobody reads."""
        self._natively = [sensor for sensor in self._active if sensor.obeys_law and not sensor.heard]
        for sensor in self._natively:
            sensor.plan(plan)
        topics = TopicManager.Instance()
        self._callbacks = [event for sensor in self._natively for event in sensor.events]
        self._topics = [topics.topic(one.GetTopic()) for sensor in self._natively for one in sensor.publishers]
        self._set_next()

    def _plan_again(self) -> None:
        """What native code measures has changed."""
        self._natively, self._next, self._next_here = [], -math.inf, -math.inf
        self.world.core.update_rows_changed()

    def _set_next(self) -> None:
        self._next = min((sensor.schedule.due for sensor in self._active), default=math.inf)
        others = (sensor for sensor in self._active if sensor not in self._natively)
        self._next_here = min((sensor.schedule.due for sensor in others), default=math.inf)

    def skipped(self) -> None:
        """Iterations have passed without `update`."""
        if self.sensors:
            self._now = self.world.core.GetSimTime()

    def update(self) -> None:
        """Let the sensors that are due measure, after an iteration."""
        if not self.sensors:
            self._now = 0.0  # as in a world that never had one
            return
        for topic, sensor in self._idle:
            if topic.subscribers or topic.remote:
                self.reschedule(sensor)
        if self._unknown and self._asked():
            self._announce()
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
            if now < sensor.schedule.due or sensor not in self._active:  # a callback of one may have removed another
                continue
            if not sensor.wants_updates():
                self._deactivate(sensor)
                continue
            try:
                sensor.Update(False)
            except GazeboError as error:
                log.error("sensor %s is removed, because it cannot measure: %s", sensor.ScopedName(), error)
                self.remove(sensor)
        if any(sensor.obeys_law and not sensor.heard for sensor in self._active if sensor not in self._natively):
            self._plan_again()
        else:
            self._set_next()

    def _advertise(self) -> None:
        """Advertise the topics of new sensors, and the one on which all are described."""
        if self._node is None:
            self._node = Node()
            self._node.Init(self.world.core.topic_space)
        for sensor in self.sensors.values():
            for topic in sensor.topics() if sensor.message_type and not sensor.publishers else ():
                try:
                    with unowned():  # a plugin may have made the sensor's joint
                        sensor.publishers.append(self._node.Advertise(sensor.message_type, topic, 100))
                except GazeboError as error:
                    log.error("%s: <sensor>: %s", sensor.sdf.where, error)
            if sensor.announcer is None:
                with unowned():
                    sensor.announcer = self._node.Advertise(msgs.Sensor, "~/sensor")
                self._unknown.append(sensor)
        self._update_lists()

    def _asked(self) -> bool:
        """Whether somebody may want to know of new sensors; to describe them gives their links numbers."""
        announcer = self._unknown[0].announcer
        return TopicManager.Instance().remote is not None or (announcer is not None and announcer.HasConnections())

    def _announce(self) -> None:
        """Publish what describes new sensors."""
        unknown, self._unknown = self._unknown, []
        for sensor in unknown:
            if sensor.announcer is not None:
                message = msgs.Sensor()
                sensor.FillMsg(message)
                sensor.announcer.Publish(message)

    # State -------------------------------------------------------------------------------------------------------

    def save(self) -> tuple[Any, ...] | None:
        """The state of all sensors, as plain data; None without any."""
        if not self.sensors:
            return None
        return self._now, self._rows()

    def _rows(self) -> list[Any]:
        """Of each sensor how it is made, whether it is active, and the states of itself and of its cameras, encoded."""
        return [
            [
                name,
                one.Type(),
                one.parent.GetScopedName(),
                one.source,
                one in self._active,
                list(map(_state, _parts(one))),
            ]
            for name, one in self.sensors.items()
        ]

    def load(self, state: Sequence[Any] | None) -> None:
        """Take what `save` returned: sensors that came since go, those that were removed since are made again."""
        now, rows = state if state is not None else (0.0, [])
        if [(name, kind, active) for name, kind, _, _, active, _ in rows] != [
            (name, one.Type(), one in self._active) for name, one in self.sensors.items()
        ]:
            self._match(rows)
        for name, *_, states in rows:
            for part, encoded in zip(_parts(self.sensors[name]), states, strict=True):
                if encoded != _state(part):
                    set_values(part, decode(encoded))
        self._now = now
        self._plan_again()

    def _match(self, rows: Sequence[Any]) -> None:
        """Make the sensors those of a state."""
        kinds = {name: kind for name, kind, *_ in rows}
        for sensor in [s for name, s in self.sensors.items() if kinds.get(name) != s.Type()]:
            self.remove(sensor)
        for name, _, parent, source, *_ in rows:
            if name not in self.sensors:
                self._make_again(name, parent, source)
        self.start_new()
        missing = [name for name, *_ in rows if name not in self.sensors]
        if missing:
            raise StateError(f"sensors of this state cannot be made again: {', '.join(missing)}")
        self.sensors = {name: self.sensors[name] for name, *_ in rows}
        self._active = {sensor: None for sensor in self.sensors.values() if sensor in self._active}
        for name, *_, active, (encoded, *_) in rows:
            sensor = self.sensors[name]
            set_values(sensor, decode(encoded))
            if active and sensor not in self._active:
                self._activate(sensor)
            elif not active and sensor in self._active:
                self._deactivate(sensor)
        self._update_lists()

    def _make_again(self, name: str, parent: str, source: str) -> None:
        holder = self.world.BaseByName(parent)
        if holder is None:
            return
        element = next(SdfFile.from_string(SENSOR % source).root.find("sensor")) if source else None
        sdf = holder.GetSDF()
        for own in sdf.named("sensor") if element is None and sdf is not None else ():
            if name.endswith(f"::{own.Get(str, 'name')}"):
                element = own
        if element is None:
            return
        # It has the name that its parent had when it was first made.
        self._parent_name = name.removeprefix(f"{self.world.Name()}::").removesuffix(f"::{element.Get(str, 'name')}")
        try:
            made = self.create(holder, element)  # type: ignore[arg-type]
        finally:
            self._parent_name = None
        if made is not None:
            made.source = source

    def name_of(self, parent: Link | Joint) -> str:
        """The name of the parent of a new sensor."""
        return parent.GetScopedName() if self._parent_name is None else self._parent_name

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

    def plugins_by_holder(self) -> Iterator[tuple[str, str, list[LoadedPlugin]]]:
        """("Sensor", name of the sensor, its plugins) of all sensors that have any."""
        for sensor in self.sensors.values():
            if sensor in self._plugins:
                yield "Sensor", sensor.ScopedName(), self._plugins[sensor]

    def elements(self) -> Iterator[tuple[str, Element]]:
        """(name of the sensor, `<plugin>`) of all sensors."""
        for sensor in self.sensors.values():
            for element in sensor.sdf.named("plugin"):
                yield sensor.ScopedName(), element

    def holder(self, name: str) -> tuple[Sensor | None, Callable[[str, str, Element | None], object]]:
        """A sensor by its full name, and a function that loads one more plugin for it."""
        sensor = self.sensors.get(name)
        return sensor, lambda *values: self.load_plugin(sensor, values[2]) if sensor and values[2] else None

    # Ends --------------------------------------------------------------------------------------------------------

    def remove(self, sensor: Sensor) -> None:
        """Remove a sensor and its plugins."""
        for plugin in self._plugins.pop(sensor, ()):
            plugin.drop()
        if sensor in self._active:
            self._deactivate(sensor)
        self.sensors = {name: kept for name, kept in self.sensors.items() if kept is not sensor}
        self._new = [new for new in self._new if new is not sensor]
        self._unknown = [one for one in self._unknown if one is not sensor]
        sensor.Fini()
        self._update_lists()
        self.world.core.events["RemoveSensor"](sensor.ScopedName())

    def remove_of(self, model: Model) -> None:
        """Remove the sensors of a model that is being deleted."""
        for sensor in list(self.sensors.values()):
            if sensor.parent.model_around() is model:
                self.remove(sensor)

    def remove_on(self, joint: Joint) -> None:
        """Remove the sensors of a joint that was deleted."""
        for sensor in list(self.sensors.values()):
            if sensor.parent is joint:
                self.remove(sensor)

    def reset(self) -> None:
        """Start all sensors again, because the clock was reset."""
        self._now = 0.0
        self._plan_again()
        for sensor in self.sensors.values():
            sensor.reset()

    def reseed(self, seed: int) -> None:
        """Begin the noise of a world that was made with this seed."""
        for sensor in self.sensors.values():
            for noise in sensor.every_noise:
                noise.reseed(seed)

    def close(self) -> None:
        """Remove all sensors."""
        for sensor in list(self.sensors.values()):
            self.remove(sensor)


def _parts(sensor: Sensor) -> tuple[Any, ...]:
    """What declares a state of a sensor: itself, and its cameras."""
    return sensor, *sensor.cameras


def _state(part: Any) -> bytes:
    return encode(get_values(part))
