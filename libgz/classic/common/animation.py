"""Animation: poses and numbers interpolated between key frames."""

from __future__ import annotations

import math
from bisect import bisect_right, insort
from operator import attrgetter
from typing import ClassVar, Generic, TypeVar

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic.common.key_frame import KeyFrame, NumericKeyFrame, PoseKeyFrame
from libgz.classic.math.quaternion import Quaterniond
from libgz.classic.math.vector3 import Vector3d

__all__ = ["Animation", "NumericAnimation", "PoseAnimation"]

K = TypeVar("K", bound=KeyFrame)

_time_of = attrgetter("time")


class Animation(Generic[K]):
    """Key frames and a current time; the base of NumericAnimation and PoseAnimation.

    Before the first key frame the value is that of the first, after the last that of the last.
    """

    STATE: ClassVar[tuple[str, ...]] = ("name", "repeat", "time", "length", "keys")

    def __init__(self, name: str, length: float, repeat: bool) -> None:
        """An animation without key frames, at time 0.

        Args:
            name: any.
            length: duration [s].
            repeat: restart at the end, instead of stopping there.

        Raises:
            ParameterError: the length is not a positive finite number.
        """
        self.name = name
        self.repeat = repeat
        self.time = 0.0
        self.keys: list[K] = []
        self.SetLength(length)

    def GetLength(self) -> float:
        """The duration [s]."""
        return self.length

    def SetLength(self, length: float) -> None:
        """Set the duration [s].

        Raises:
            ParameterError: it is not a positive finite number.
        """
        if not 0.0 < length < math.inf:
            raise ParameterError(f"animation {self.name!r}: the length must be positive and finite, not {length!r} s")
        self.length = float(length)

    def GetTime(self) -> float:
        """The current time [s]."""
        return self.time

    def SetTime(self, time: float) -> None:
        """Set the current time [s]; outside of the length it wraps with `repeat`, else it is clamped."""
        time = float(time)
        if self.repeat:
            self.time = time if 0.0 <= time <= self.length else time % self.length
        else:
            self.time = min(max(time, 0.0), self.length)

    def AddTime(self, time: float) -> None:
        """Advance the current time [s]."""
        self.SetTime(self.time + float(time))

    def GetKeyFrameCount(self) -> int:
        """The number of key frames."""
        return len(self.keys)

    def GetKeyFrame(self, index: int) -> K:
        """A key frame by number, in the order of their times.

        Raises:
            NotFoundError: there is none with this number.
        """
        if not 0 <= index < len(self.keys):
            raise NotFoundError(f"animation {self.name!r} has {len(self.keys)} key frames, from 0 on; not {index}")
        return self.keys[index]

    def _insert(self, key: K) -> K:
        """Insert a key frame by time; one with the same time is replaced."""
        if not 0.0 <= key.time < math.inf:
            raise ParameterError(f"animation {self.name!r}: a key frame's time must be 0 s or later, not {key.time!r}")
        self.keys[:] = [other for other in self.keys if other.time != key.time]
        insort(self.keys, key, key=_time_of)
        return key

    def _segment(self) -> tuple[int, float]:
        """Return the key frame before the current time by number, and the passed fraction of the time to the next.

        Raises:
            NotFoundError: there are no key frames.
        """
        if not self.keys:
            raise NotFoundError(f"animation {self.name!r} has no key frames; CreateKeyFrame(time) makes them")
        index = bisect_right(self.keys, self.time, key=_time_of) - 1
        if index < 0:
            return 0, 0.0
        if index == len(self.keys) - 1:
            return index, 0.0
        start, end = self.keys[index].time, self.keys[index + 1].time
        return index, (self.time - start) / (end - start)

    KeyFrameCount, KeyFrame, Length, Time = GetKeyFrameCount, GetKeyFrame, GetLength, GetTime


class NumericAnimation(Animation[NumericKeyFrame]):
    """A number, linearly interpolated between key frames."""

    def CreateKeyFrame(self, time: float) -> NumericKeyFrame:
        """Create a key frame with value 0 at a time [s]; an existing one is replaced."""
        return self._insert(NumericKeyFrame(time))

    def GetInterpolatedKeyFrame(self, key: NumericKeyFrame | None = None) -> NumericKeyFrame:
        """The value at the current time, in a new key frame or in the given one.

        Raises:
            NotFoundError: there are no key frames.
        """
        index, t = self._segment()
        key = key or NumericKeyFrame()
        value = self.keys[index].value
        key.time = self.time
        key.value = value + t * (self.keys[index + 1].value - value) if t else value
        return key

    InterpolatedKeyFrame = GetInterpolatedKeyFrame


class PoseAnimation(Animation[PoseKeyFrame]):
    """A pose, smoothly interpolated between key frames.

    Positions lie on cubic Hermite curves with the slopes of Catmull and Rom, rotations on Shoemake's squad; the
    velocity at a key frame is the mean velocity between its neighbours. Classic's curves are the same for evenly spaced
    key frames; these have continuous velocities for uneven spacing, too. At both ends the velocity is half of the mean
    to the neighbour, unless the last key frame equals the first: then the curve is closed.
    """

    STATE: ClassVar[tuple[str, ...]] = (*Animation.STATE, "tension")

    def __init__(self, name: str, length: float, repeat: bool, tension: float = 0.0) -> None:
        """An animation without key frames, at time 0.

        Args:
            name: any.
            length: duration [s].
            repeat: restart at the end, instead of stopping there.
            tension: of the curve of positions; 0: as said above, 1: straight lines, with stops at the key frames.

        Raises:
            ParameterError: the length is not a positive finite number, or the tension is not between 0 and 1.
        """
        super().__init__(name, length, repeat)
        if not 0.0 <= tension <= 1.0:
            raise ParameterError(f"animation {name!r}: tension is {tension!r}; it must be 0 to 1")
        self.tension = float(tension)

    def CreateKeyFrame(self, time: float) -> PoseKeyFrame:
        """Create a key frame with the zero pose at a time [s]; an existing one is replaced."""
        return self._insert(PoseKeyFrame(time))

    def GetInterpolatedKeyFrame(self, key: PoseKeyFrame | None = None) -> PoseKeyFrame:
        """The value at the current time, in a new key frame or in the given one.

        Raises:
            NotFoundError: there are no key frames.
        """
        index, t = self._segment()
        key = key or PoseKeyFrame()
        key.time = self.time
        if t == 0.0:
            key.translation = Vector3d(self.keys[index].translation)
            key.rotation = Quaterniond(self.keys[index].rotation)
        else:
            key.translation = self._translation(index, t)
            key.rotation = self._rotation(index, t)
        return key

    def _neighbours(self, index: int) -> tuple[PoseKeyFrame, PoseKeyFrame, float]:
        """Return the neighbours of a key frame and the time between them [s]; at an end, itself and twice the time."""
        keys, last = self.keys, len(self.keys) - 1
        if 0 < index < last:
            return keys[index - 1], keys[index + 1], keys[index + 1].time - keys[index - 1].time
        first_step, last_step = keys[1].time - keys[0].time, keys[last].time - keys[last - 1].time
        if keys[0].translation == keys[last].translation and keys[0].rotation == keys[last].rotation:
            return keys[last - 1], keys[1], first_step + last_step
        if index == 0:
            return keys[0], keys[1], 2.0 * first_step
        return keys[last - 1], keys[last], 2.0 * last_step

    def _velocity(self, index: int) -> Vector3d:
        before, after, duration = self._neighbours(index)
        return (after.translation - before.translation) * ((1.0 - self.tension) / duration)

    def _turn_rate(self, index: int) -> Quaterniond:
        """Return the logarithm of the rotation per second at a key frame, in its own frame."""
        before, after, duration = self._neighbours(index)
        here = self.keys[index].rotation
        return (_log_between(here, after.rotation) - _log_between(here, before.rotation)) * (1.0 / duration)

    def _translation(self, index: int, t: float) -> Vector3d:
        start, end = self.keys[index], self.keys[index + 1]
        duration = end.time - start.time
        rise = t * t * (3.0 - 2.0 * t)
        return (
            start.translation * (1.0 - rise)
            + end.translation * rise
            + self._velocity(index) * (duration * t * (1.0 - t) * (1.0 - t))
            - self._velocity(index + 1) * (duration * t * t * (1.0 - t))
        )

    def _rotation(self, index: int, t: float) -> Quaterniond:
        """Return squad with inner points that give the rates of `_turn_rate` at both ends.

        With L the logarithm from p to q, squad's slope is L + 2 log(p^-1 a) at p and L - 2 log(q^-1 b) at q.
        """
        start, end = self.keys[index], self.keys[index + 1]
        duration = end.time - start.time
        p, q = start.rotation, end.rotation
        if p.Dot(q) < 0.0:
            q = -q
        across = _log_between(p, q)
        a = p * ((self._turn_rate(index) * duration - across) * 0.5).Exp()
        b = q * ((across - self._turn_rate(index + 1) * duration) * 0.5).Exp()
        return Quaterniond.Squad(t, p, a, b, q).Normalize()

    InterpolatedKeyFrame = GetInterpolatedKeyFrame


def _log_between(p: Quaterniond, q: Quaterniond) -> Quaterniond:
    """Return the logarithm of the shorter rotation from p to q."""
    turn = p.Inverse() * q
    return (-turn if turn.u < 0.0 else turn).Log()
