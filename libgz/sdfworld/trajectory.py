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

    After the last waypoint the pose is that of the last. As in Gazebo, the first one is at time 0, whatever it says; a
    slope is half of the way from the waypoint before to the one after, whatever their times, and at an end half of the
    way to the neighbour; positions, and rotations, whose first and last are equal make a closed curve.

    Args:
        waypoints: (time [s], pose), by growing time, from 0 s on.
        tension: of positions, 0 to 1; with 1 the velocity at each waypoint is zero.
    """

    def __init__(self, waypoints: Sequence[tuple[float, GzPose]], tension: float = 0.0) -> None:
        self.times = [0.0, *(time for time, _ in waypoints[1:])]
        self.duration = waypoints[-1][0]  # [s]; that of a single waypoint, too
        self.positions = [np.array([*pose.pos]) for _, pose in waypoints]
        self.turns = [np.array([*pose.rot]) / np.linalg.norm([*pose.rot]) for _, pose in waypoints]
        self._tension = tension
        self._pieces: dict[int, tuple[Array, Array, Array, Array]] = {}  # rotations and inner points
        last = len(self.times) - 1
        self._closed = last > 1 and bool(np.array_equal(self.positions[0], self.positions[last]))
        self._turns_closed = last > 1 and bool(np.allclose(self.turns[0], self.turns[last], rtol=0.0, atol=1e-3))

    def at(self, time: float) -> GzPose:
        """The pose at a time [s]."""
        index = bisect_right(self.times, time) - 1
        if index < 0 or index == len(self.times) - 1:
            place = max(index, 0)
            return _pose(self.positions[place], self.turns[place])
        start, end = self.times[index], self.times[index + 1]
        u = (time - start) / (end - start)
        return _pose(self._position(index, u), self._turn(index, u))

    def _around(self, index: int, closed: bool) -> tuple[int, int]:
        """The waypoints before and after one; at an end that is not closed, itself."""
        last = len(self.times) - 1
        if 0 < index < last:
            return index - 1, index + 1
        if closed:
            return last - 1, 1
        return (0, 1) if index == 0 else (last - 1, last)

    def _slope(self, index: int) -> Array:
        before, after = self._around(index, self._closed)
        found: Array = 0.5 * (1.0 - self._tension) * (self.positions[after] - self.positions[before])
        return found

    def _inner(self, index: int) -> Array:
        """The inner point of the squad at a waypoint."""
        here = self.turns[index]
        around = (_log(here, self.turns[other]) for other in self._around(index, self._turns_closed))
        return _times(here, _exp(-0.25 * sum(around, np.zeros(3))))

    def _position(self, index: int, u: float) -> Array:
        rise = u * u * (3.0 - 2.0 * u)
        found: Array = (
            self.positions[index] * (1.0 - rise)
            + self.positions[index + 1] * rise
            + self._slope(index) * (u * (1.0 - u) * (1.0 - u))
            - self._slope(index + 1) * (u * u * (1.0 - u))
        )
        return found

    def _turn(self, index: int, u: float) -> Array:
        p, q, a, b = self._turns_along(index)
        return _slerp(_slerp(p, q, u), _slerp(a, b, u), 2.0 * u * (1.0 - u))

    def _turns_along(self, index: int) -> tuple[Array, Array, Array, Array]:
        """The rotations at both ends of a piece, the shorter way, and the inner points."""
        if index not in self._pieces:
            p, q = self.turns[index], self.turns[index + 1]
            q = -q if float(p @ q) < 0.0 else q
            self._pieces[index] = p, q, self._inner(index), self._inner(index + 1)
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
    """Half of the rotation vector from p to q, in p's frame: the way that their signs give."""
    turn = _times(np.array([p[0], *-p[1:]]), q)
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
    return found / math.sqrt(found.dot(found))  # as `norm`, at a third of its cost
