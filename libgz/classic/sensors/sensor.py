"""Sensor: the base of all sensors: names, rate, activity, noise, messages."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from libgz.base.errors import NotFoundError, ParameterError
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector, GzVectorAdd, place_of, rotate
from libgz.base.law import is_law, law
from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.sensors.noise import Noise as NoiseModel, SensorNoiseType, new_noise
from libgz.classic.sensors.read import custom_topic, first, number
from libgz.classic.sensors.schedule import Schedule
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Link, World
    from libgz.classic.rendering.camera import Camera as CameraView
    from libgz.classic.transport import Publisher
    from libgz.sdf.element import Element
    from libgz.simulation.plan import Plan

__all__ = ["LinkSensor", "Sensor", "SensorCategory", "SensorOwner"]

_ids = itertools.count(1 << 30)  # clients know sensors and entities by number, so that none may be equal


class SensorCategory(IntEnum):
    """How sensors measure."""

    IMAGE = 0
    RAY = 1
    OTHER = 2


class SensorOwner(Protocol):
    """The sensors of a world, as each of them uses it."""

    world: World
    sensors: dict[str, Sensor]

    def name_of(self, parent: Link | Joint) -> str:
        """The name of the parent of a new sensor."""

    def reschedule(self, sensor: Sensor) -> None:
        """The sensor's activity or rate may have changed."""

    def remove(self, sensor: Sensor) -> None:
        """Remove the sensor and its plugins."""


class Sensor:
    """Base of all sensors.

    A sensor measures while it is active: with `<always_on>`, after `SetActive(True)`, or while its topic has
    subscribers. Callbacks make it active, too, except after `SetActive(False)`. The rate is in sim time and does not
    drift; `update_rate` 0 is every iteration.

    Args:
        sensors: the sensors of the world.
        parent: the link that carries it, or the joint that it measures.
        sdf: its `<sensor>` element.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "_pose",
        "_active",
        *(f"schedule.{name}" for name in Schedule.STATE),
        "all_noises",
    )

    category: ClassVar[SensorCategory] = SensorCategory.OTHER
    topic_suffix: ClassVar[str | None] = None  # follows the sensor's name in its topic; None: it has no topic
    topic_appended: ClassVar[bool] = False  # whether its file's topic is appended to its own instead of replacing it
    topic_added: ClassVar[bool] = False  # whether it publishes beside its file's topic on its own, the one in Gazebo
    message_type: ClassVar[Any] = None  # of its topic
    renders: ClassVar[bool] = False  # whether it needs images
    gathers: ClassVar[bool] = False  # whether `gather` is called after each iteration while it is active

    def __init__(self, sensors: SensorOwner, parent: Link | Joint, sdf: Element) -> None:
        self.sensors, self.world, self.parent, self.sdf = sensors, sensors.world, parent, sdf
        self._name, self._parent_name = sdf.Get(str, "name"), sensors.name_of(parent)
        self._number = next(_ids)
        self._pose = sdf.Get(Pose3d, "pose")
        self._active: bool | None = True if sdf.Get(bool, "always_on") else None
        self.schedule = Schedule()
        self.SetUpdateRate(number(sdf, "update_rate"))
        self._update_event = Event(f"Updated of sensor {self.ScopedName()}")
        self._message_event = Event(f"Update of sensor {self.ScopedName()}")
        self.noises: dict[SensorNoiseType, NoiseModel] = {}
        self.publishers: list[Publisher] = []
        self.announcer: Publisher | None = None  # of what describes it
        self.source = ""  # the text of its element, if that is not in the element of its parent

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.ScopedName()!r}{place_of(self)}>"

    # Names -------------------------------------------------------------------------------------------------------

    def Name(self) -> str:
        """The name in its link or joint."""
        return self._name

    def ScopedName(self) -> str:
        """``world::model::link::sensor``."""
        return f"{self.world.Name()}::{self.ParentName()}::{self._name}"

    def ParentName(self) -> str:
        """``model::link``: as it was when the sensor was made, as in Gazebo, even if one of them was renamed."""
        return self._parent_name

    def WorldName(self) -> str:
        """The world's name."""
        return self.world.Name()

    def Type(self) -> str:
        """The type in its file: ray, imu, camera ..."""
        return self.sdf.Get(str, "type")

    def Category(self) -> SensorCategory:
        """IMAGE, RAY or OTHER."""
        return self.category

    def Id(self) -> int:
        """A unique number."""
        return self._number

    def ParentId(self) -> int:
        """The number of its link or joint."""
        return self.parent.GetId()

    def Topic(self) -> str:
        """The topic that it publishes on; an empty string for none."""
        given = self.custom_topic()
        if self.topic_appended:
            return self._own_topic(given)
        return given or (self._own_topic(self.topic_suffix) if self.topic_suffix is not None else "")

    def topics(self) -> list[str]:
        """All topics that it publishes on; `Topic` is the first one."""
        found = [self.Topic()]
        if self.topic_added and self.topic_suffix is not None and custom_topic(self.sdf) == found[0]:
            found.append(self._own_topic(self.topic_suffix))
        return [topic for topic in dict.fromkeys(found) if topic]

    def custom_topic(self) -> str:
        """The topic that its file names; an empty string for none."""
        return custom_topic(self.sdf)

    def _own_topic(self, suffix: str) -> str:
        """``~/model/link/sensor/suffix``."""
        path = f"~/{self.ParentName()}/{self._name}".replace("::", "/")
        return f"{path}/{suffix}" if suffix else path

    def Visualize(self) -> bool:
        """Whether viewers show its measurements."""
        return self.sdf.Get(bool, "visualize")

    def GetSDF(self) -> Element:
        """Its `<sensor>` element."""
        return self.sdf

    GetName, GetScopedName, GetParentName, GetWorldName = Name, ScopedName, ParentName, WorldName
    GetType, GetCategory, GetId, GetParentId, GetTopic, GetVisualize = Type, Category, Id, ParentId, Topic, Visualize

    def Pose(self) -> Pose3d:
        """Pose in its link [m]."""
        return Pose3d(self._pose)

    def SetPose(self, pose: GzPose) -> None:
        """Set the pose in its link [m]."""
        self._pose = Pose3d(pose)
        self.world.core.update_rows_changed()

    GetPose = Pose

    def world_pose(self) -> GzPose:
        """Global pose [m]."""
        raise NotImplementedError

    # Activity and rate -------------------------------------------------------------------------------------------

    def IsActive(self) -> bool:
        """Whether it measures."""
        return bool(self._active) or self.listened() or (self._active is None and self.connected())

    def SetActive(self, value: bool) -> None:
        """Let it measure always, or only while its topic has subscribers."""
        self._active = bool(value)
        self.sensors.reschedule(self)

    def wants_updates(self) -> bool:
        """Whether `Update` is called after iterations."""
        return self.IsActive()

    @property
    def events(self) -> tuple[Event, Event]:
        """The events of its measurements: of each, and of those that are published."""
        return self._update_event, self._message_event

    def connected(self) -> bool:
        """Whether there are callbacks for its measurements."""
        return any(self.events)

    def listened(self) -> bool:
        """Whether its topic has subscribers."""
        return any(publisher.HasConnections() for publisher in self.publishers)

    def UpdateRate(self) -> float:
        """Measurements a second of sim time [Hz]; 0: one in each iteration."""
        return 1.0 / self.schedule.period if self.schedule.period > 0.0 else 0.0

    def SetUpdateRate(self, hz: float) -> None:
        """Set the rate [Hz]; 0 or less: every iteration."""
        self.schedule.set_period(1.0 / hz if hz > 0.0 else 0.0)
        self.sensors.reschedule(self)

    def LastUpdateTime(self) -> Time:
        """Sim time of the last update."""
        return Time(self.schedule.updated)

    def LastMeasurementTime(self) -> Time:
        """Sim time of the last measurement."""
        return Time(self.schedule.measured)

    GetUpdateRate, GetLastUpdateTime, GetLastMeasurementTime = UpdateRate, LastUpdateTime, LastMeasurementTime

    def ResetLastUpdateTime(self) -> None:
        """Forget the times of its measurements, because the clock was set back."""
        self.schedule.forget()
        self.sensors.reschedule(self)

    def ConnectUpdated(self, callback: Callable[[], object]) -> Connection:
        """Call `callback` after each measurement, as long as the connection is kept."""
        return self.listen(self._update_event, callback)

    def DisconnectUpdated(self, connection: Connection) -> None:
        """End a connection."""
        connection.Disconnect()

    def listen(self, event: Event, callback: Callable[..., object]) -> Connection:
        """Connect to one of its events."""
        connection = event.Connect(callback)
        self.sensors.reschedule(self)
        return connection

    def Update(self, force: bool = False) -> None:
        """Measure, if it is active and due, or if forced."""
        now, schedule = self.world.core.GetSimTime(), self.schedule
        if not force and (now < schedule.due or not self.IsActive()):
            return
        elapsed = now - schedule.measured
        if not self.ready(elapsed):
            return
        schedule.measured = now
        self.measure(elapsed)
        self.disturb()
        self.deliver()
        schedule.settle(now)
        if self._update_event:
            self._update_event()

    @property
    def heard(self) -> bool:
        """Whether anybody gets its measurements."""
        return self.listened() or self.connected()

    @property
    def obeys_law(self) -> bool:
        """Whether native code may measure while nobody gets what it measures."""
        return is_law(type(self).measure) and not self.noises

    def plan(self, plan: Plan) -> None:
        """Add what it does after an iteration while nobody gets what it measures."""
        with plan.when(self.is_due):
            plan.call(self.sample)

    @law
    def is_due(self) -> Any:
        """Whether it is time to measure."""
        now, schedule = self.world.core.clock.sim_time, self.schedule
        return (now >= schedule.due) & (now > schedule.measured)

    @law
    def sample(self) -> None:
        """Measure, for nobody."""
        now, schedule = self.world.core.clock.sim_time, self.schedule
        elapsed = now - schedule.measured
        schedule.measured = now
        self.measure(elapsed)
        schedule.settle(now)

    def ready(self, elapsed: float) -> bool:
        """Whether it can measure now, `elapsed` seconds of sim time after its last measurement."""
        return True

    def measure(self, elapsed: float) -> None:
        """Take a measurement, `elapsed` seconds of sim time after the last one."""
        raise NotImplementedError(f"{type(self).__name__} cannot measure")

    def disturb(self) -> None:
        """Add noise to what a law has measured."""

    def deliver(self) -> None:
        """Pass the measurement to callbacks and to the topic's subscribers."""
        if self._message_event or self.listened():
            message = self.message()
            self._message_event(message)
            for publisher in self.publishers:
                publisher.Publish(message)

    def message(self) -> Any:
        """The last measurement as a message of `message_type`."""
        raise NotImplementedError(f"{type(self).__name__} has no messages")

    def stamped(self, **fields: Any) -> Any:
        """A message of `message_type` with the time of the last measurement."""
        msg = self.message_type(**fields)
        msgs.Set(msg.time, self.LastMeasurementTime())
        return msg

    # Noise -------------------------------------------------------------------------------------------------------

    def Noise(self, type: SensorNoiseType) -> NoiseModel:
        """The noise on one of its values.

        Raises:
            NotFoundError: there is none on that value.
        """
        try:
            return self.noises[SensorNoiseType(type)]
        except (KeyError, ValueError):
            has = ", ".join(kind.name for kind in self.noises) or "none"
            raise NotFoundError(f"sensor {self.ScopedName()!r} has no noise {type!r}; it has {has}") from None

    GetNoise = Noise

    def add_noise(self, kind: SensorNoiseType, holder: Element | None) -> None:
        """Add the `<noise>` of an element, if there is one."""
        element = first(holder, "noise")
        if element is not None:
            self.noises[kind] = new_noise(element, self.world.core.seed, self.ScopedName(), int(kind))

    @property
    def all_noises(self) -> list[NoiseModel]:
        """Its noises, in the order in which they were added."""
        return list(self.noises.values())

    @property
    def cameras(self) -> Sequence[CameraView]:
        """The cameras that take its images."""
        return ()

    @property
    def every_noise(self) -> list[NoiseModel]:
        """All that it has of noise."""
        return self.all_noises

    def noisy(self, kind: SensorNoiseType, value: float) -> float:
        """A value with its noise."""
        noise = self.noises.get(kind)
        return noise.Apply(value) if noise is not None else value

    def add_axis_noise(self, kinds: Sequence[SensorNoiseType], holder: Element | None, axes: Sequence[str]) -> None:
        """Add the `<noise>` of each axis, a child of an element."""
        for kind, axis in zip(kinds, axes, strict=True):
            self.add_noise(kind, first(holder, axis))

    def noisy_vector(self, kinds: Sequence[SensorNoiseType], value: Vector3d) -> Vector3d:
        """A vector with the noise of each axis."""
        if not self.noises:
            return value
        return Vector3d(*(self.noisy(kind, part) for kind, part in zip(kinds, value, strict=True)))

    # Life --------------------------------------------------------------------------------------------------------

    def Init(self) -> None:
        """Start; called when all models of the world exist, before the sensor's plugins are loaded."""

    def Fini(self) -> None:
        """End; there are no more measurements."""
        self._active = False
        self._update_event.clear()
        for noise in self.noises.values():
            noise.Fini()
        for publisher in self.publishers:
            publisher.Fini()
        self.publishers = []
        if self.announcer is not None:
            self.announcer.Fini()
            self.announcer = None

    def gather(self) -> None:
        """Collect data of an iteration that will be lost when it measures."""

    def activated(self) -> None:
        """Called when it becomes active."""

    def deactivated(self) -> None:
        """Called when it is no longer active."""

    def reset(self) -> None:
        """Start again, because clock and models were reset."""
        for noise in self.all_noises:
            noise.restart()
        self.ResetLastUpdateTime()

    # Messages ----------------------------------------------------------------------------------------------------

    def FillMsg(self, msg: Any) -> None:
        """Describe the sensor in a msgs.Sensor.

        Raises:
            ParameterError: the message is of another type.
        """
        if not isinstance(msg, msgs.Sensor):
            raise ParameterError(f"FillMsg of a sensor takes a msgs.Sensor, not {type(msg).__name__}")
        msg.name, msg.id, msg.type = self._name, self._number, self.Type()
        msg.parent, msg.parent_id = self.ParentName(), self.ParentId()
        msgs.Set(msg.pose, self._pose)
        msg.always_on, msg.update_rate = self.IsActive(), self.UpdateRate()
        msg.topic, msg.visualize = self.Topic(), self.Visualize()


class LinkSensor(Sensor):
    """A sensor that a link carries."""

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent

    def world_pose(self) -> GzPose:
        """Global pose [m]."""
        return GzCoordPoseAdd(self._pose, self.link.pose())

    @property
    def obeys_law(self) -> bool:
        """Whether native code may measure: it has no row for a link that is fixed."""
        return super().obeys_law and self.link.body.row >= 0

    @law
    def world_rotation(self) -> Quaterniond:
        """Global rotation."""
        return Quaterniond(self.link.body.GetPose().rot) * self._pose.rot

    @law
    def world_velocity(self) -> GzVector:
        """Global velocity of the sensor's position [m/s]."""
        pose = self.link.body.GetPose()
        return self.link.body.GetPointVel(GzVectorAdd(pose.pos, rotate(pose.rot, self._pose.pos)))
