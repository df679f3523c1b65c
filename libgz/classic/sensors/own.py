"""OwnSensor: a sensor whose class is a plugin's own, in C++: `SensorFactory::RegisterSensor` registers its type."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError, PluginError, StateError
from libgz.base.geometry import GzCoordPoseAdd, GzPose
from libgz.classic.common import Time
from libgz.classic.math import Pose3d
from libgz.classic.sensors.kinds import OWN, Make
from libgz.classic.sensors.noise import Noise as NoiseModel, SensorNoiseType
from libgz.classic.sensors.sensor import LinkSensor, SensorCategory, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["OwnSensor", "being_made", "register"]

log = logging.getLogger("libgz.classic")

NUMBERS = 18  # of a state

_made: list[OwnSensor] = []  # whose C++ object is being made, innermost last


class OwnSensor(LinkSensor):
    """Calls the methods of a C++ object, which has activity, rate, times, pose and noises, as in Gazebo.

    Its `Update` is called after each iteration, and decides whether it measures: `IsActive` may be a method of its
    own. States keep what the C++ class `Sensor` has, not the variables of classes that are derived from it.
    """

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        self._own: dict[str, Any] = {}
        super().__init__(sensors, parent, sdf)
        _made.append(self)
        try:
            self._own = OWN[sdf.Get(str, "type")](self)
        finally:
            _made.pop()

    def Init(self) -> None:
        """Call Load and Init."""
        self._own["Load"](self.ParentName(), self.ParentId(), self.sdf)

    def Fini(self) -> None:
        """Call Fini; an error in it is logged, for the sensor ends anyway."""
        try:
            self._own["Fini"]()
        except PluginError as error:
            log.error("Fini of sensor %s failed: %s", self.ScopedName(), str(error))  # its traceback has this object
        super().Fini()

    def __del__(self) -> None:
        """Delete the C++ object while this one is whole: its destructor may call methods of its base class."""
        own, self._own = self._own, {}  # its file stays in memory until it is deleted
        vars(self).pop("_cxx", None)
        del own

    def Update(self, force: bool = False) -> None:
        """Call Update."""
        self._own["Update"](force)

    def updated(self) -> None:
        """Notify those that wait for measurements; the C++ object has signalled its event."""
        self._update_event()

    def wants_updates(self) -> bool:
        """Always, for only its Update knows."""
        return True

    def IsActive(self) -> bool:
        """Whether it measures: with `<always_on>`, after `SetActive(True)`, or as its class decides."""
        return bool(self._own and self._own["IsActive"]())

    def SetActive(self, value: bool) -> None:
        """Let it measure, or not."""
        self._own["SetActive"](bool(value))

    def Category(self) -> SensorCategory:
        """What its constructor says: IMAGE, RAY or OTHER."""
        return SensorCategory(self._own["Category"]())

    def Topic(self) -> str:
        """The topic of its file, or what its class says."""
        return str(self._own["Topic"]())

    def Pose(self) -> Pose3d:
        """Pose in its link [m]."""
        return Pose3d(self._own["Pose"]())

    def SetPose(self, pose: GzPose) -> None:
        """Set the pose in its link [m]."""
        self._own["SetPose"](Pose3d(pose))

    def world_pose(self) -> GzPose:
        """Global pose [m]."""
        return GzCoordPoseAdd(self.Pose(), self.link.pose())

    def UpdateRate(self) -> float:
        """Measurements a second of sim time [Hz]; 0: one in each iteration."""
        return float(self._own["UpdateRate"]())

    def SetUpdateRate(self, hz: float) -> None:
        """Set the rate [Hz]; 0 or less: every iteration."""
        if self._own:  # else its element is read, as Init does again
            self._own["SetUpdateRate"](float(hz))

    def LastUpdateTime(self) -> Time:
        """Sim time of the last update that has measured."""
        return Time(self._own["LastUpdateTime"]())

    def LastMeasurementTime(self) -> Time:
        """Sim time of the last measurement, as its class has noted it."""
        return Time(self._own["LastMeasurementTime"]())

    def ResetLastUpdateTime(self) -> None:
        """Forget the times of its measurements, because the clock was set back."""
        self._own["ResetLastUpdateTime"]()

    @property
    def all_noises(self) -> list[NoiseModel]:
        """Its noises, by their types."""
        return list(self._own["noises"]().values()) if self._own else []

    def Noise(self, type: SensorNoiseType) -> NoiseModel:
        """The noise on one of its values.

        Raises:
            NotFoundError: there is none on that value.
        """
        noises: dict[int, NoiseModel] = self._own["noises"]()
        try:
            return noises[int(type)]
        except KeyError:
            has = ", ".join(SensorNoiseType(kind).name for kind in noises) or "none"
            raise NotFoundError(f"sensor {self.ScopedName()!r} has no noise {type!r}; it has {has}") from None

    GetCategory, GetTopic, GetPose, GetNoise, GetUpdateRate = Category, Topic, Pose, Noise, UpdateRate
    GetLastUpdateTime, GetLastMeasurementTime = LastUpdateTime, LastMeasurementTime

    def SaveState(self) -> tuple[float, ...]:
        """Activity, pose and times."""
        return tuple(self._own["save"]())

    def LoadState(self, state: Sequence[float]) -> None:
        """Take what `SaveState` returned.

        Raises:
            StateError: it is damaged.
        """
        whole = isinstance(state, tuple) and len(state) == NUMBERS and all(isinstance(one, float) for one in state)
        if not whole or not all(map(math.isfinite, state)):
            raise StateError("the state is damaged: it has not the numbers of a sensor")
        self._own["load"](list(state))


def being_made() -> OwnSensor:
    """The sensor of the C++ object whose constructor runs.

    Raises:
        ParameterError: a plugin makes one by itself.
    """
    if not _made:
        raise ParameterError("sensors of a plugin's own are made by worlds: SensorFactory::RegisterSensor")
    return _made[-1]


def register(kind: str, make: Make) -> None:
    """Let worlds make sensors of a type from now on."""
    OWN[kind] = make
