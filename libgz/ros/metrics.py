"""Metrics: how fast the simulation and its sensors are, as gazebo_msgs/PerformanceMetrics."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from libgz.ros.plugin import Ticks
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.sensors import Sensor
    from libgz.ros.session import Session

__all__ = ["Metrics"]

RATE = 5.0  # [Hz] of real time


class _Seen(NamedTuple):
    """What is known of a sensor.

    Attributes:
        measured, real: sim and real time of its last measurement [s].
        rates: measurements a second of sim and of real time [Hz]; None before the second one.
    """

    measured: float
    real: float
    rates: tuple[float, float] | None


class Metrics:
    """Publishes metrics while somebody listens.

    Args:
        session: publishes them.
        topic: its name.
        sensors: gives the sensors at present.
    """

    def __init__(self, session: Session, topic: str, sensors: Callable[[], Iterable[Sensor]]) -> None:
        self._publication = session.publish(topic, "gazebo_msgs/PerformanceMetrics", 10, changed=self._changed)
        self._sensors = sensors
        self._ticks = Ticks(RATE)
        self._kind = message_type("gazebo_msgs/SensorPerformanceMetric")
        self._last: tuple[float, float] | None = None  # sim and real time of the last message [s]
        self._seen: dict[Sensor, _Seen] = {}

    @property
    def listened(self) -> bool:
        """Whether there are subscribers."""
        return self._publication.listened

    def _changed(self) -> None:
        if not self.listened:  # times from before a pause would be in the first rates after it
            self._last, self._seen = None, {}

    def update(self, now: float) -> None:
        """Look at the sensors after a step to sim time `now` [s], and publish if it is time."""
        real = time.monotonic()
        known = self._seen
        self._seen = {sensor: _look(sensor.schedule.measured, real, known.get(sensor)) for sensor in self._sensors()}
        if not self._ticks.due(real):
            return
        if self._last is not None and now > self._last[0]:
            self._send(now, (now - self._last[0]) / (real - self._last[1]))
        self._last = now, real

    def _send(self, now: float, factor: float) -> None:
        message = self._publication.kind(real_time_factor=factor)
        set_stamp(message.header.stamp, now)
        for sensor, seen in self._seen.items():
            if seen.rates is not None:
                sim, real = seen.rates
                camera: Any = getattr(sensor, "Camera", lambda: None)()
                fps = camera.AvgFPS() if camera is not None else -1.0
                one = self._kind(name=sensor.ScopedName(), sim_update_rate=sim, real_update_rate=real, fps=fps)
                message.sensors.append(one)
        self._publication.publish(message)


def _look(measured: float, real: float, last: _Seen | None) -> _Seen:
    """What is known of a sensor with the last measurement at sim time `measured` [s], at real time `real` [s]."""
    if last is None:
        return _Seen(measured, real, None)
    if measured == last.measured:
        return last
    if measured < last.measured or real <= last.real:  # the world was reset
        return _Seen(measured, real, last.rates)
    return _Seen(measured, real, (1.0 / (measured - last.measured), 1.0 / (real - last.real)))
