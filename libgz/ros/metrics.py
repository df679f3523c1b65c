"""Metrics: how fast the simulation and its sensors are, as gazebo_msgs/PerformanceMetrics."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from libgz.ros.plugin import Ticks
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.sensors import Sensor
    from libgz.ros.session import Publication

__all__ = ["Metrics"]

RATE = 5.0  # [Hz] of real time


class Metrics:
    """Publishes metrics while somebody listens.

    Args:
        publication: of gazebo_msgs/PerformanceMetrics.
        sensors: gives the sensors at present.
    """

    def __init__(self, publication: Publication, sensors: Callable[[], Iterable[Sensor]]) -> None:
        self.publication, self._sensors = publication, sensors
        self._ticks = Ticks(RATE)
        self._kind = message_type("gazebo_msgs/SensorPerformanceMetric")
        self._last: tuple[float, float] | None = None  # sim and real time of the last message [s]
        self._measured: dict[str, tuple[float, float]] = {}  # of the last measurement of each sensor
        self._rates: dict[str, tuple[float, float]] = {}  # a second of sim and of real time [Hz]

    def update(self, now: float) -> None:
        """Look at the sensors after a step to sim time `now` [s], and publish if it is time."""
        real = time.monotonic()
        sensors = list(self._sensors())
        for sensor in sensors:
            name, measured = sensor.ScopedName(), sensor.schedule.measured
            before, seen = self._measured.get(name, (measured, real))
            if measured > before and real > seen:
                self._rates[name] = 1.0 / (measured - before), 1.0 / (real - seen)
            if measured != before or name not in self._measured:
                self._measured[name] = measured, real
        if not self._ticks.due(real):
            return
        if self._last is not None and now > self._last[0]:
            self._send(now, (now - self._last[0]) / (real - self._last[1]), sensors)
        self._last = now, real

    def _send(self, now: float, factor: float, sensors: Iterable[Sensor]) -> None:
        message = self.publication.kind(real_time_factor=factor)
        set_stamp(message.header.stamp, now)
        for sensor in sensors:
            name = sensor.ScopedName()
            if name in self._rates:
                sim, real = self._rates[name]
                camera: Any = getattr(sensor, "Camera", lambda: None)()
                fps = camera.AvgFPS() if camera is not None else -1.0
                one = self._kind(name=name, sim_update_rate=sim, real_update_rate=real, fps=fps)
                message.sensors.append(one)
        self.publication.publish(message)
