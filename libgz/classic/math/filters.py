"""Filters of signals: low-pass filters of one and two poles, and rolling means."""

from __future__ import annotations

import math
from collections import deque
from typing import Generic, TypeVar

from libgz.base.errors import ParameterError
from libgz.base.geometry import QuaternLike, VectorLike
from libgz.classic.math.quaternion import Quaterniond
from libgz.classic.math.vector3 import Vector3d

__all__ = ["BiQuad", "BiQuadVector3", "OnePole", "OnePoleQuaternion", "OnePoleVector3", "RollingMean"]

T = TypeVar("T")


class Filter(Generic[T]):
    """Base of filters: the last output."""

    STATE: tuple[str, ...] = ("_value",)

    def __init__(self, zero: T) -> None:
        self._value = zero

    def Value(self) -> T:
        """The last output."""
        return self._value

    def Set(self, value: T) -> None:
        """Set the last output."""
        self._value = value


def _check(fc: float, fs: float) -> None:
    if not (fs > 0.0 and fc >= 0.0):
        raise ParameterError(f"a filter has a cutoff of 0 Hz or more and a rate above 0 Hz, not {fc!r} and {fs!r}")


class _Cutoff:
    """The share of a new sample in the output of a filter of one pole."""

    def __init__(self, fc: float, fs: float) -> None:
        self.SetFc(fc, fs)

    def SetFc(self, fc: float, fs: float) -> None:
        """Set the cutoff frequency and the rate of samples [Hz].

        Raises:
            ParameterError: one is negative, or the rate is 0.
        """
        _check(fc, fs)
        self._share = 1.0 - math.exp(-2.0 * math.pi * fc / fs)


class OnePole(_Cutoff, Filter[float]):
    """y += (1 - b) (x - y) with b = exp(-2 pi fc / fs)."""

    def __init__(self, fc: float = 0.0, fs: float = 1.0, zero: float = 0.0) -> None:
        Filter.__init__(self, zero)
        _Cutoff.__init__(self, fc, fs)

    def Process(self, x: float) -> float:
        """Take a sample, and return the output."""
        self._value += self._share * (x - self._value)
        return self._value


class OnePoleVector3(_Cutoff, Filter[Vector3d]):
    """The same for vectors."""

    def __init__(self, fc: float = 0.0, fs: float = 1.0) -> None:
        Filter.__init__(self, Vector3d())
        _Cutoff.__init__(self, fc, fs)

    def Process(self, x: VectorLike) -> Vector3d:
        """Take a sample, and return the output."""
        self._value = self._value + (Vector3d(x) - self._value) * self._share
        return self._value


class OnePoleQuaternion(_Cutoff, Filter[Quaterniond]):
    """The same for rotations, which are interpolated on the sphere."""

    def __init__(self, fc: float = 0.0, fs: float = 1.0) -> None:
        Filter.__init__(self, Quaterniond())
        _Cutoff.__init__(self, fc, fs)

    def Process(self, x: QuaternLike) -> Quaterniond:
        """Take a sample, and return the output."""
        self._value = Quaterniond.Slerp(self._share, self._value, Quaterniond(x), True)
        return self._value


S = TypeVar("S", float, Vector3d)


class _TwoPoles(Filter[S]):
    """A low-pass filter of second order, by the bilinear transform."""

    STATE = ("_value", "_x1", "_x2", "_y1", "_y2")

    def __init__(self, zero: S, fc: float, fs: float) -> None:
        self._value: S = zero
        self._x1: S = zero
        self._x2: S = zero
        self._y1: S = zero
        self._y2: S = zero
        self.SetFc(fc, fs)

    def SetFc(self, fc: float, fs: float, q: float = 0.5) -> None:
        """Set the cutoff frequency and the rate of samples [Hz], and the quality.

        Raises:
            ParameterError: one is negative, or the rate is 0.
        """
        _check(fc, fs)
        if not q > 0.0:
            raise ParameterError(f"the quality of a filter must be above 0, not {q!r}")
        k = math.tan(math.pi * min(fc / fs, 0.499))
        whole = k * k + k / q + 1.0
        self._a0 = k * k / whole
        self._b1, self._b2 = 2.0 * (k * k - 1.0) / whole, (k * k - k / q + 1.0) / whole

    def SetValue(self, value: S) -> None:
        """Set the output, as if the input had been this for long."""
        self._value = self._x1 = self._x2 = self._y1 = self._y2 = value

    def _next(self, x: S) -> S:
        y: S = (x + self._x1 * 2.0 + self._x2) * self._a0 - self._y1 * self._b1 - self._y2 * self._b2
        self._x2, self._x1, self._y2, self._y1 = self._x1, x, self._y1, y
        self._value = y
        return y


class BiQuad(_TwoPoles[float]):
    """A low-pass filter of second order."""

    def __init__(self, fc: float = 0.0, fs: float = 1.0) -> None:
        super().__init__(0.0, fc, fs)

    def Process(self, x: float) -> float:
        """Take a sample, and return the output."""
        return self._next(float(x))


class BiQuadVector3(_TwoPoles[Vector3d]):
    """The same for vectors."""

    def __init__(self, fc: float = 0.0, fs: float = 1.0) -> None:
        super().__init__(Vector3d(), fc, fs)

    def Process(self, x: VectorLike) -> Vector3d:
        """Take a sample, and return the output."""
        return self._next(Vector3d(x))


class RollingMean:
    """The mean of the last samples."""

    STATE = ("_samples",)

    def __init__(self, windowSize: int = 10) -> None:
        self._samples: deque[float] = deque(maxlen=max(1, int(windowSize)))

    def Push(self, value: float) -> None:
        """Take a sample."""
        self._samples.append(float(value))

    def Mean(self) -> float:
        """The mean; NaN without samples."""
        return math.fsum(self._samples) / len(self._samples) if self._samples else math.nan

    def Count(self) -> int:
        """The number of samples in the window."""
        return len(self._samples)

    def Clear(self) -> None:
        """Remove all samples."""
        self._samples.clear()

    def WindowSize(self) -> int:
        """The number of samples that count."""
        return self._samples.maxlen or 1

    def SetWindowSize(self, windowSize: int) -> None:
        """Set the number of samples that count, and remove all; 0 is ignored."""
        if windowSize > 0:
            self._samples = deque(maxlen=int(windowSize))
