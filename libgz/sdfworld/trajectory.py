"""Trajectory: a pose that moves smoothly through waypoints."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzPose, GzQuatern, GzVector

__all__ = ["Trajectory"]

Array = NDArray[np.float64]


class Trajectory:
    """Positions on Hermite curves with the slopes of Catmull and Rom, rotations on Shoemake's squad.

    Before the first waypoint the pose is that of the first, after the last that of the last. If these are equal, the
    curve is closed; else it begins and ends with half of the mean velocity to the neighbour.

    Args:
        waypoints: (time [s], pose), by growing time.
        tension: 0 to 1; with 1 the velocity at each waypoint is zero.
    """

    def __init__(self, waypoints: Sequence[tuple[float, GzPose]], tension: float = 0.0) -> None:
        self.times = [time for time, _ in waypoints]
        self.positions = [np.array([*pose.pos]) for _, pose in waypoints]
        self.turns = [np.array([*pose.rot]) / np.linalg.norm([*pose.rot]) for _, pose in waypoints]
        self._tension = tension
        self._pieces: dict[int, tuple[Array, Array, Array, Array]] = {}  # rotations of those that were asked for
        first, last = 0, len(self.times) - 1
        self._closed = last > 1 and bool(
            np.array_equal(self.positions[first], self.positions[last])
            and abs(float(self.turns[first] @ self.turns[last])) > 1.0 - 1e-12
        )

    @property
    def duration(self) -> float:
        """The time of the last waypoint [s]."""
        return self.times[-1]

    def at(self, time: float) -> GzPose:
        """The pose at a time [s]."""
        index = bisect_right(self.times, time) - 1
        if index < 0 or index == len(self.times) - 1:
            place = max(index, 0)
            return _pose(self.positions[place], self.turns[place])
        start, end = self.times[index], self.times[index + 1]
        u = (time - start) / (end - start)
        return _pose(self._position(index, u), self._turn(index, u))

    def _around(self, index: int) -> tuple[int, int, float]:
        """The waypoints before and after one, and the time between them [s]; at an end, itself and twice the time."""
        last = len(self.times) - 1
        if 0 < index < last:
            return index - 1, index + 1, self.times[index + 1] - self.times[index - 1]
        first_step, last_step = self.times[1] - self.times[0], self.times[last] - self.times[last - 1]
        if self._closed:
            return last - 1, 1, first_step + last_step
        return (0, 1, 2.0 * first_step) if index == 0 else (last - 1, last, 2.0 * last_step)

    def _velocity(self, index: int) -> Array:
        before, after, duration = self._around(index)
        found: Array = (1.0 - self._tension) * (self.positions[after] - self.positions[before]) / duration
        return found

    def _rate(self, index: int) -> Array:
        """The rotation per second at a waypoint, as half of a rotation vector in its own frame."""
        before, after, duration = self._around(index)
        here = self.turns[index]
        found: Array = (_log(here, self.turns[after]) - _log(here, self.turns[before])) / duration
        return (1.0 - self._tension) * found

    def _position(self, index: int, u: float) -> Array:
        duration = self.times[index + 1] - self.times[index]
        rise = u * u * (3.0 - 2.0 * u)
        found: Array = (
            self.positions[index] * (1.0 - rise)
            + self.positions[index + 1] * rise
            + self._velocity(index) * (duration * u * (1.0 - u) * (1.0 - u))
            - self._velocity(index + 1) * (duration * u * u * (1.0 - u))
        )
        return found

    def _turn(self, index: int, u: float) -> Array:
        """Squad whose inner points give the rates of `_rate` at both ends."""
        p, q, a, b = self._turns_along(index)
        return _slerp(_slerp(p, q, u), _slerp(a, b, u), 2.0 * u * (1.0 - u))

    def _turns_along(self, index: int) -> tuple[Array, Array, Array, Array]:
        """The rotations at both ends of a piece, and the inner points."""
        if index not in self._pieces:
            duration = self.times[index + 1] - self.times[index]
            p, q = self.turns[index], self.turns[index + 1]
            if float(p @ q) < 0.0:
                q = -q
            across = _log(p, q)
            a = _times(p, _exp(0.5 * (self._rate(index) * duration - across)))
            b = _times(q, _exp(0.5 * (across - self._rate(index + 1) * duration)))
            self._pieces[index] = p, q, a, b
        return self._pieces[index]


def _pose(position: Array, turn: Array) -> GzPose:
    return GzPose(GzVector(*position.tolist()), GzQuatern(*turn.tolist()))


def _times(a: Array, b: Array) -> Array:
    """The product of two quaternions."""
    au, ax, ay, az = a.tolist()
    bu, bx, by, bz = b.tolist()
    return np.array(
        [
            au * bu - float(a[1:] @ b[1:]),
            au * bx + bu * ax + (ay * bz - az * by),
            au * by + bu * ay + (az * bx - ax * bz),
            au * bz + bu * az + (ax * by - ay * bx),
        ]
    )


def _log(p: Array, q: Array) -> Array:
    """Half of the rotation vector of the shorter way from p to q, in p's frame."""
    turn = _times(np.array([p[0], *-p[1:]]), q)
    turn = -turn if turn[0] < 0.0 else turn
    length = float(np.linalg.norm(turn[1:]))
    found: Array = turn[1:] * (math.atan2(length, turn[0]) / length if length > 1e-12 else 1.0)
    return found


def _exp(half: Array) -> Array:
    """The quaternion of half of a rotation vector."""
    angle = float(np.linalg.norm(half))
    return np.array([math.cos(angle), *(half * (math.sin(angle) / angle if angle > 1e-12 else 1.0))])


def _slerp(p: Array, q: Array, u: float) -> Array:
    """Between two quaternions, along the way that their signs give."""
    angle = math.acos(min(max(float(p @ q), -1.0), 1.0))
    sine = math.sin(angle)
    found: Array = (1.0 - u) * p + u * q
    if sine > 1e-9:
        found = (math.sin((1.0 - u) * angle) * p + math.sin(u * angle) * q) / sine
    return found / np.linalg.norm(found)
