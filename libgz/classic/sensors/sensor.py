"""Sensor: what all sensors have in common: names, rate, when they measure, whom they tell."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.math import Pose3d
from libgz.classic.sensors.noise import Noise as NoiseModel, SensorNoiseType, new_noise
from libgz.classic.sensors.read import custom_topic, number
from libgz.errors import NotFoundError, ParameterError
from libgz.geometry import GzPose
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.msgs import Message
    from libgz.classic.physics import Joint, Link
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.classic.transport import Publisher
    from libgz.sdf.element import Element

__all__ = ["Sensor", "SensorCategory"]

HAIR = 1e-9  # [s] sim times are sums of steps, and may miss a due time by less than this

_ids = itertools.count(1)


class SensorCategory(IntEnum):
    """How sensors measure."""

    IMAGE = 0
    RAY = 1
    OTHER = 2


class Sensor:
    """Base of all sensors.

    A sensor measures while it is active: with `<always_on>`, after `SetActive(True)`, or while somebody listens to its
    topic or, unless it was told to be quiet by `SetActive(False)`, to its callbacks. Its rate is one of sim time, and
    does not drift; `update_rate` 0 is every iteration.

    Args:
        sensors: the sensors of the world.
        parent: the link that carries it, or the joint that it measures.
        sdf: its `<sensor>` element.
    """

    category: ClassVar[SensorCategory] = SensorCategory.OTHER
    topic_suffix: ClassVar[str | None] = None  # what follows the sensor's name in its topic's; None: it has no topic
    topic_behind: ClassVar[bool] = False  # whether the topic of its file stands behind its own, not instead
    message_type: ClassVar[str] = ""  # of its topic
    draws: ClassVar[bool] = False  # whether it needs pictures
    gathers: ClassVar[bool] = False  # whether `gather` is to be called after each iteration while it is active

    def __init__(self, sensors: WorldSensors, parent: Link | Joint, sdf: Element) -> None:
        self.sensors, self.world, self.parent, self.sdf = sensors, sensors.world, parent, sdf
        self._name = sdf.Get(str, "name")
        self._number = next(_ids)
        self._pose = sdf.Get(Pose3d, "pose")
        self._active: bool | None = True if sdf.Get(bool, "always_on") else None
        self._period = 0.0
        self._updated = self._measured = self._delay = 0.0
        self.SetUpdateRate(number(sdf, "update_rate"))
        self._update_event = Event(f"Updated of sensor {self.ScopedName()}")
        self.noises: dict[SensorNoiseType, NoiseModel] = {}
        self.publisher: Publisher | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.ScopedName()!r}>"

    # Names -------------------------------------------------------------------------------------------------------

    def Name(self) -> str:
        """The name in its link or joint."""
        return self._name

    def ScopedName(self) -> str:
        """``world::model::link::sensor``."""
        return f"{self.world.Name()}::{self.ParentName()}::{self._name}"

    def ParentName(self) -> str:
        """``model::link``."""
        return self.parent.GetScopedName()

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
        """A number that no other sensor has."""
        return self._number

    def ParentId(self) -> int:
        """The number of its link or joint."""
        return self.parent.GetId()

    def Topic(self) -> str:
        """The topic that it publishes on; an empty string for none."""
        given = custom_topic(self.sdf)
        if self.topic_behind:
            return self._own_topic(given)
        return given or (self._own_topic(self.topic_suffix) if self.topic_suffix is not None else "")

    def _own_topic(self, suffix: str) -> str:
        """``~/model/link/sensor/suffix``."""
        path = f"~/{self.ParentName()}/{self._name}".replace("::", "/")
        return f"{path}/{suffix}" if suffix else path

    def Visualize(self) -> bool:
        """Whether a viewer is to show what it measures."""
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

    GetPose = Pose

    # Activity and rate -------------------------------------------------------------------------------------------

    def IsActive(self) -> bool:
        """Whether it measures."""
        return bool(self._active) or self.listened() or (self._active is None and self.connected())

    def SetActive(self, value: bool) -> None:
        """Let it measure, or only as long as somebody listens to its topic."""
        self._active = bool(value)
        self.sensors.wake(self)

    def connected(self) -> bool:
        """Whether callbacks wait for its measurements."""
        return bool(self._update_event)

    def listened(self) -> bool:
        """Whether somebody listens to its topic."""
        return self.publisher is not None and self.publisher.HasConnections()

    def UpdateRate(self) -> float:
        """Measurements a second of sim time [Hz]; 0: one in each iteration."""
        return 1.0 / self._period if self._period > 0.0 else 0.0

    def SetUpdateRate(self, hz: float) -> None:
        """Set the rate [Hz]; 0 or less: every iteration."""
        self._period = 1.0 / hz if hz > 0.0 else 0.0
        self.sensors.wake(self)

    def LastUpdateTime(self) -> Time:
        """Sim time of the last update."""
        return Time(self._updated)

    def LastMeasurementTime(self) -> Time:
        """Sim time of the last measurement."""
        return Time(self._measured)

    GetUpdateRate, GetLastUpdateTime, GetLastMeasurementTime = UpdateRate, LastUpdateTime, LastMeasurementTime

    def ResetLastUpdateTime(self) -> None:
        """Forget when it measured; the clock was set back."""
        self._updated = self._measured = self._delay = 0.0
        self.sensors.wake(self)

    def ConnectUpdated(self, callback: Callable[[], object]) -> Connection:
        """Call `callback` after each measurement, as long as the connection is kept."""
        return self.listen(self._update_event, callback)

    def DisconnectUpdated(self, connection: Connection) -> None:
        """End such a connection."""
        connection.Disconnect()

    def listen(self, event: Event, callback: Callable[..., object]) -> Connection:
        """Connect to one of its events."""
        connection = event.Connect(callback)
        self.sensors.wake(self)
        return connection

    @property
    def due(self) -> float:
        """Sim time from which on it may measure again [s]."""
        return self._updated + max(self._period - self._delay - HAIR, HAIR)

    def Update(self, force: bool = False) -> None:
        """Measure, if it is active and it is time for it, or by force."""
        now = self.world.core.GetSimTime()
        if not force and (now < self.due or not self.IsActive()):
            return
        late = max(0.0, now - self._updated + self._delay - self._period)
        if self.measure(now):
            # Late by more than a period: it slept, or steps are longer than that. There is nothing to catch up with.
            self._delay = late if HAIR < late < self._period else 0.0
            self._updated = now
            if self._update_event:
                self._update_event()

    def measure(self, now: float) -> bool:
        """Take a measurement at a sim time [s], and publish it if somebody listens; whether there was one."""
        raise NotImplementedError(f"{type(self).__name__} cannot measure")

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
        """Take on the `<noise>` in an element, if there is one."""
        element = next(holder.named("noise"), None) if holder is not None else None
        if element is not None:
            self.noises[kind] = new_noise(element, self.world.core.seed, self.ScopedName(), int(kind))

    def noisy(self, kind: SensorNoiseType, value: float) -> float:
        """A value with its noise."""
        noise = self.noises.get(kind)
        return noise.Apply(value) if noise is not None else value

    # Life --------------------------------------------------------------------------------------------------------

    def Init(self) -> None:
        """Begin; called when all of the world's models are there, before the sensor's plugins are loaded."""

    def Fini(self) -> None:
        """End: no measurement from now on."""
        self._active = False
        self._update_event.clear()
        for noise in self.noises.values():
            noise.Fini()
        if self.publisher is not None:
            self.publisher.Fini()
            self.publisher = None

    def gather(self) -> None:
        """An iteration is over: note what will not be there any more when it measures."""

    def went_active(self) -> None:
        """It begins to measure."""

    def went_idle(self) -> None:
        """Nobody wants its measurements any more."""

    def reset(self) -> None:
        """Clock and models were put back."""
        for noise in self.noises.values():
            noise.restart()
        self.ResetLastUpdateTime()

    # Messages ----------------------------------------------------------------------------------------------------

    def new_message(self, **fields: Any) -> Any:
        """A message of the sensor's type."""
        from libgz.classic import msgs

        return getattr(msgs, self.message_type)(**fields)

    def publish(self, message: Message) -> None:
        """Send a message on the sensor's topic."""
        if self.publisher is not None:
            self.publisher.Publish(message)

    def FillMsg(self, msg: Any) -> None:
        """Describe the sensor in a msgs.Sensor.

        Raises:
            ParameterError: the message is of another type.
        """
        from libgz.classic import msgs

        if not isinstance(msg, msgs.Sensor):
            raise ParameterError(f"FillMsg of a sensor takes a msgs.Sensor, not {type(msg).__name__}")
        msg.name, msg.id, msg.type = self._name, self._number, self.Type()
        msg.parent, msg.parent_id = self.ParentName(), self.ParentId()
        msgs.Set(msg.pose, self._pose)
        msg.always_on, msg.update_rate = self.IsActive(), self.UpdateRate()
        msg.topic, msg.visualize = self.Topic(), self.Visualize()
