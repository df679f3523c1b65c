"""Trajectory: positions of joints over time, by polynomials between points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from libgz.base.errors import ParameterError

__all__ = ["Trajectory"]


class _Point(NamedTuple):
    """Where the joints are at a time; velocities and accelerations may be missing."""

    time: float
    positions: Sequence[float]
    velocities: Sequence[float] | None
    accelerations: Sequence[float] | None


class Trajectory:
    """Points in order of their times; before the first and after the last the joints stand there.

    Between points, positions are linear; cubic if both have velocities; of the fifth degree with accelerations, too.
    """

    def __init__(self, points: Sequence[_Point]) -> None:
        self._points = points
        self.end = points[-1].time

    @classmethod
    def standing(cls, now: float, positions: Sequence[float]) -> Trajectory:
        """One that stays at positions."""
        return cls([_Point(now, list(positions), None, None)])

    @classmethod
    def of_message(
        cls,
        message: Any,
        names: Sequence[str],
        now: float,
        positions: Sequence[float],
        velocities: Sequence[float],
        turned: Callable[[int, float, float], float],
    ) -> Trajectory:
        """That of a message, from the present positions on; joints that it does not name stay there.

        Args:
            message: a trajectory_msgs/JointTrajectory.
            names: of the joints.
            now: sim time [s].
            positions, velocities: at present.
            turned: gives the position of a joint, by number, that follows another one.

        Raises:
            ParameterError: a point has not as many numbers as there are names, or the times do not grow.
        """
        begin = message.header.stamp.seconds or now
        places = [message.joint_names.index(name) if name in message.joint_names else None for name in names]
        count, points = len(message.joint_names), [_Point(now, list(positions), list(velocities), None)]
        for index, point in enumerate(message.points):
            if len(point.positions) != count or any(
                len(values) not in (0, count) for values in (point.velocities, point.accelerations)
            ):
                raise ParameterError(f"point {index} has not {count} positions, velocities and accelerations")
            at = begin + point.time_from_start.seconds
            if index and at <= points[-1].time and points[-1].time > now:
                raise ParameterError(f"point {index}: the times of points must grow")
            if at <= now and index + 1 < len(message.points):
                continue  # it is over
            last = points[-1].positions
            wanted = [
                turned(number, last[number], float(point.positions[place])) if place is not None else last[number]
                for number, place in enumerate(places)
            ]
            speeds = _picked(point.velocities, places)
            points.append(_Point(max(at, now), wanted, speeds, _picked(point.accelerations, places)))
        return cls(points)

    def at(self, now: float) -> tuple[list[float], list[float], list[float]]:
        """Positions, velocities and accelerations at a time."""
        points = self._points
        still = [0.0] * len(points[0].positions)
        if now >= self.end:
            return list(points[-1].positions), still, list(still)
        if now < points[0].time:
            return list(points[0].positions), still, list(still)
        index = next(i for i, point in enumerate(points) if point.time > now)
        a, b = points[index - 1], points[index]
        found = [_between(a, b, number, now) for number in range(len(still))]
        return [one[0] for one in found], [one[1] for one in found], [one[2] for one in found]


def _picked(values: Sequence[float], places: Sequence[int | None]) -> list[float] | None:
    if not len(values):
        return None
    return [float(values[place]) if place is not None else 0.0 for place in places]


def _between(a: _Point, b: _Point, number: int, now: float) -> tuple[float, float, float]:
    """Position, velocity and acceleration of a joint between two points, by a polynomial of the time."""
    span, t = b.time - a.time, now - a.time
    p, q = a.positions[number], b.positions[number]
    if b.velocities is None:
        slope = (q - p) / span
        return p + slope * t, slope, 0.0
    v = a.velocities[number] if a.velocities is not None else 0.0
    w = b.velocities[number]
    if b.accelerations is None:
        c2 = (3.0 * (q - p) / span - 2.0 * v - w) / span
        c3 = (2.0 * (p - q) / span + v + w) / span**2
        return p + v * t + c2 * t**2 + c3 * t**3, v + 2.0 * c2 * t + 3.0 * c3 * t**2, 2.0 * c2 + 6.0 * c3 * t
    x = a.accelerations[number] if a.accelerations is not None else 0.0
    y = b.accelerations[number]
    c3 = (20.0 * (q - p) - (8.0 * w + 12.0 * v) * span - (3.0 * x - y) * span**2) / (2.0 * span**3)
    c4 = (30.0 * (p - q) + (14.0 * w + 16.0 * v) * span + (3.0 * x - 2.0 * y) * span**2) / (2.0 * span**4)
    c5 = (12.0 * (q - p) - 6.0 * (w + v) * span - (x - y) * span**2) / (2.0 * span**5)
    position = p + v * t + x / 2.0 * t**2 + c3 * t**3 + c4 * t**4 + c5 * t**5
    velocity = v + x * t + 3.0 * c3 * t**2 + 4.0 * c4 * t**3 + 5.0 * c5 * t**4
    return position, velocity, x + 6.0 * c3 * t + 12.0 * c4 * t**2 + 20.0 * c5 * t**3
