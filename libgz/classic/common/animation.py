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

    Positions lie on cubic Hermite curves with the slopes of Catmull and Rom, rotations on Shoemake's squad. As in
    Gazebo, the curves are those of evenly spaced key frames, whatever their times: where the spacing changes, so does
    the velocity. A curve whose ends are equal is closed; at other ends the slope is half of the way to the neighbour.
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

    def _neighbours(self, index: int, closed: bool) -> tuple[PoseKeyFrame, PoseKeyFrame]:
        """Return the neighbours of a key frame; at an end that is not closed, itself is one of them."""
        keys, last = self.keys, len(self.keys) - 1
        if closed and index in (0, last):
            return keys[last - 1], keys[1]
        return keys[max(index - 1, 0)], keys[min(index + 1, last)]

    def _slope(self, index: int) -> Vector3d:
        before, after = self._neighbours(index, self.keys[0].translation == self.keys[-1].translation)
        return (after.translation - before.translation) * (0.5 * (1.0 - self.tension))

    def _inner(self, index: int) -> Quaterniond:
        """Return the inner point of the squad at a key frame."""
        here = self.keys[index].rotation
        around = self._neighbours(index, self.keys[0].rotation == self.keys[-1].rotation)
        back, on = ((here.Inverse() * key.rotation).Log() for key in around)  # not the shorter way, as in Gazebo
        return here * ((back + on) * -0.25).Exp()

    def _translation(self, index: int, t: float) -> Vector3d:
        start, end = self.keys[index], self.keys[index + 1]
        rise = t * t * (3.0 - 2.0 * t)
        return (
            start.translation * (1.0 - rise)
            + end.translation * rise
            + self._slope(index) * (t * (1.0 - t) * (1.0 - t))
            - self._slope(index + 1) * (t * t * (1.0 - t))
        )

    def _rotation(self, index: int, t: float) -> Quaterniond:
        p, q = self.keys[index].rotation, self.keys[index + 1].rotation
        return Quaterniond.Squad(t, p, self._inner(index), self._inner(index + 1), q, True).Normalize()

    InterpolatedKeyFrame = GetInterpolatedKeyFrame
