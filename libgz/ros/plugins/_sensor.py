"""What the sensor plugins have in common: the sensor measures while somebody listens."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.sensors.noise import GaussianNoiseModel, SensorNoiseType
from libgz.ros.plugin import RosPlugin, Ticks
from libgz.ros.session import Publication, set_stamp

if TYPE_CHECKING:
    from libgz.sdf.element import Element

__all__ = ["POINTS_DEPTH", "RosSensor", "model_of"]

SENSOR_DEPTH, POINTS_DEPTH = 5, 1  # of the queues in ROS 2


def model_of(sensor: Any) -> str:
    """The name of the model that has a sensor."""
    return str(sensor.ParentName()).partition("::")[0]


class RosSensor(RosPlugin):
    """Publishes what a sensor measures, as long as there are subscribers.

    Attributes:
        sensor: the sensor.
        publications: all that it publishes.
    """

    STATE: ClassVar[tuple[str, ...]] = ("ticks",)

    def open_sensor(self, sensor: Any, sdf: Element, rate: float = 0.0) -> None:
        """Read the parameters; at most `rate` measurements a second are published [Hz]."""
        self.sensor = sensor
        self.ticks = Ticks(rate)
        self.publications: list[Publication] = []

    def advertise(self, topic: str, kind: str, queue: int = 2, within: str = "") -> Publication:
        """Publish a topic; while it has subscribers, the sensor is active."""
        depth = SENSOR_DEPTH if self.two and queue != POINTS_DEPTH else queue
        found = self.publish(topic, kind, depth, within=within, changed=self.match_activity)
        self.publications.append(found)
        return found

    def frame_of(self, name: str) -> str:
        """A frame; that of the sensor's link where none is given."""
        return self.frame(name or str(self.sensor.ParentName()).rpartition("::")[2])

    def variance(self, kind: SensorNoiseType) -> float:
        """The variance of a noise of the sensor; 0 without one."""
        noise = self.sensor.noises.get(kind)
        return noise.GetStdDev() ** 2 if isinstance(noise, GaussianNoiseModel) else 0.0

    def begin(self) -> None:
        """Begin; all topics are advertised."""
        self.match_activity()
        self.connection = self.sensor.ConnectUpdated(self.OnUpdated)

    def match_activity(self) -> None:
        """Let the sensor measure if somebody listens."""
        self.sensor.SetActive(any(one.listened for one in self.publications))

    def OnUpdated(self) -> None:
        """The sensor has measured."""
        if any(one.listened for one in self.publications) and self.ticks.due(self.measured):
            self.send()

    @property
    def measured(self) -> float:
        """Sim time of the measurement [s]."""
        return float(self.sensor.LastMeasurementTime().Double())

    def stamp(self, message: Any) -> None:
        """Set the time of a message to that of the measurement."""
        set_stamp(message.header.stamp, self.measured)

    def send(self) -> None:
        """Publish the measurement."""
        raise NotImplementedError
