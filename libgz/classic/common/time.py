"""Time: a time or duration in integer nanoseconds."""

from __future__ import annotations

import math
import time
from datetime import datetime
from enum import IntEnum
from numbers import Real
from typing import TYPE_CHECKING, SupportsFloat

from libgz.base.errors import ParameterError
from libgz.base.law import floor
from libgz.classic.math.constant import Constant

if TYPE_CHECKING:
    from libgz.simulation.clock import Clock

__all__ = ["Time", "sim_nanoseconds"]

_SECOND = 10**9
_ROUNDING = 2.0**52  # what is added to it has no digits after the point; ties go to even, as in round()


def sim_nanoseconds(clock: Clock) -> float:
    """The sim time of a world as `Time` has it [ns], a whole number; for laws."""
    seconds = clock.sim_time
    whole = floor(seconds)
    return whole * 1e9 + ((seconds - whole) * 1e9 + _ROUNDING - _ROUNDING)  # type: ignore[no-any-return]


def _nanoseconds(seconds: float) -> int:
    """A number of seconds in nanoseconds, to the nearest.

    Raises:
        ParameterError: it is infinite or NaN.
    """
    if not math.isfinite(seconds):
        raise ParameterError(f"a Time takes a finite number of seconds, not {seconds!r}")
    whole = math.floor(seconds)
    return whole * _SECOND + round((seconds - whole) * 1e9)


class _Format(IntEnum):
    DAYS = 0
    HOURS = 1
    MINUTES = 2
    SECONDS = 3
    MILLISECONDS = 4


class Time:
    """A time or a duration: `sec` whole seconds and `nsec` nanoseconds, both negative if it is.

    - `Time()`, `Time(1.5)`, `Time(1, 500000000)`, `Time(other)`; too many nanoseconds become seconds.
    - `t.Double()` and `float(t)` are the seconds as a number.
    - Sums, differences and comparisons are exact, and accept numbers [s]. `*` and `/` accept times and numbers and give
      a Time, as in C++: `(a / b).Double()` is the ratio of two times.
    - Operators make new times; `t += dt` does not change other references to the old one.
    """

    __slots__ = ("nanoseconds",)
    __hash__ = None  # type: ignore[assignment]
    __array_priority__ = 1000.0

    nanoseconds: int

    FormatOption = _Format
    DAYS, HOURS, MINUTES, SECONDS, MILLISECONDS = _Format

    Zero = Constant(lambda: Time(0, 0))
    Second = Constant(lambda: Time(1, 0))
    Minute = Constant(lambda: Time(60, 0))
    Hour = Constant(lambda: Time(3600, 0))
    Maximum = Constant(lambda: Time(2**31 - 1, _SECOND - 1))

    def __init__(self, sec: float | Time = 0, nsec: int | None = None) -> None:
        """From seconds; from whole seconds and nanoseconds; or from another time.

        Raises:
            ParameterError: it is infinite or NaN.
        """
        self.Set(sec, nsec)

    def Set(self, sec: float | Time, nsec: int | None = None) -> None:
        """Set it, with the arguments of the constructor.

        Raises:
            ParameterError: it is infinite or NaN.
        """
        if nsec is not None:
            self.nanoseconds = int(float(sec)) * _SECOND + int(nsec)
        elif isinstance(sec, Time):
            self.nanoseconds = sec.nanoseconds
        else:
            self.nanoseconds = _nanoseconds(sec)

    @classmethod
    def from_nanoseconds(cls, nanoseconds: int) -> Time:
        """Return the time of a number of nanoseconds, faster than the constructor."""
        made = _new(Time)
        made.nanoseconds = nanoseconds
        return made

    @classmethod
    def from_sdf(cls, text: str) -> Time:
        """From the text of an SDF element: seconds and nanoseconds, or seconds alone.

        Raises:
            ParameterError: there are neither two whole numbers nor one number.
        """
        words = text.split() or ["0"]
        try:
            if len(words) <= 2:
                return cls(int(words[0]), int(words[1])) if len(words) == 2 else cls(float(words[0]))
        except ValueError:
            pass
        raise ParameterError(f"{text.strip()!r} is not seconds and nanoseconds")

    @property
    def sec(self) -> int:
        """Integer seconds, truncated towards zero; setting them keeps the nanoseconds."""
        ns = self.nanoseconds
        return ns // _SECOND if ns >= 0 else -(-ns // _SECOND)

    @sec.setter
    def sec(self, value: int) -> None:
        self.nanoseconds = value * _SECOND + self.nsec

    @property
    def nsec(self) -> int:
        """The nanoseconds beside the seconds [ns]; setting them keeps the seconds."""
        ns = self.nanoseconds
        return ns % _SECOND if ns >= 0 else -(-ns % _SECOND)

    @nsec.setter
    def nsec(self, value: int) -> None:
        self.nanoseconds = self.sec * _SECOND + value

    def Double(self) -> float:
        """The time [s]."""
        return self.nanoseconds / _SECOND

    def __bool__(self) -> bool:
        return self.nanoseconds != 0

    def __repr__(self) -> str:
        return f"Time({self.sec}, {self.nsec})"

    def __str__(self) -> str:
        return f"{self.sec} {self.nsec}"

    # Arithmetic and comparison ---------------------------------------------------------------------------------------

    def __add__(self, other: object) -> Time:
        if isinstance(other, Time):
            return Time.from_nanoseconds(self.nanoseconds + other.nanoseconds)
        if isinstance(other, Real):
            return Time.from_nanoseconds(self.nanoseconds + _nanoseconds(float(other)))
        return NotImplemented

    __radd__ = __add__

    def __sub__(self, other: object) -> Time:
        if isinstance(other, Time):
            return Time.from_nanoseconds(self.nanoseconds - other.nanoseconds)
        if isinstance(other, Real):
            return Time.from_nanoseconds(self.nanoseconds - _nanoseconds(float(other)))
        return NotImplemented

    def __rsub__(self, other: object) -> Time:
        return Time(float(other)) - self if isinstance(other, Real) else NotImplemented

    def __mul__(self, other: object) -> Time:
        return Time(self.Double() * float(other)) if isinstance(other, Time | Real) else NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Time:
        return Time(self.Double() / float(other)) if isinstance(other, Time | Real) else NotImplemented

    def __rtruediv__(self, other: object) -> Time:
        return Time(float(other) / self.Double()) if isinstance(other, Real) else NotImplemented

    def __neg__(self) -> Time:
        return Time.from_nanoseconds(-self.nanoseconds)

    def __abs__(self) -> Time:
        return Time.from_nanoseconds(abs(self.nanoseconds))

    def _difference(self, other: object) -> float | None:
        """Return this time minus another [ns]; None if the other is no time."""
        if isinstance(other, Time):
            return self.nanoseconds - other.nanoseconds
        if isinstance(other, Real):
            seconds = float(other)
            return self.nanoseconds - _nanoseconds(seconds) if math.isfinite(seconds) else -seconds
        return None

    def __eq__(self, other: object) -> bool:
        d = self._difference(other)
        return NotImplemented if d is None else d == 0

    def __lt__(self, other: object) -> bool:
        d = self._difference(other)
        return NotImplemented if d is None else d < 0

    def __le__(self, other: object) -> bool:
        d = self._difference(other)
        return NotImplemented if d is None else d <= 0

    def __gt__(self, other: object) -> bool:
        d = self._difference(other)
        return NotImplemented if d is None else d > 0

    def __ge__(self, other: object) -> bool:
        d = self._difference(other)
        return NotImplemented if d is None else d >= 0

    # Wall time --------------------------------------------------------------------------------------------------------

    @staticmethod
    def GetWallTime() -> Time:
        """The wall time, since 1970."""
        return Time.from_nanoseconds(time.time_ns())

    def SetToWallTime(self) -> None:
        """Set it to the wall time, since 1970."""
        self.nanoseconds = time.time_ns()

    @staticmethod
    def GetWallTimeAsISOString() -> str:
        """Date and local time as YYYY-MM-DDTHH:MM:SS.nnnnnnnnn."""
        now = time.time_ns()
        return f"{datetime.fromtimestamp(now // _SECOND):%Y-%m-%dT%H:%M:%S}.{now % _SECOND:09d}"

    @staticmethod
    def Sleep(duration: SupportsFloat) -> Time:
        """Sleep for a time [s]; the remaining time is always 0. The simulation waits meanwhile."""
        time.sleep(max(0.0, float(duration)))
        return Time.from_nanoseconds(0)

    @staticmethod
    def MSleep(milliseconds: int) -> Time:
        """Sleep for a number of milliseconds."""
        return Time.Sleep(milliseconds * 1e-3)

    @staticmethod
    def NSleep(duration: int | Time) -> Time:
        """Sleep for a number of nanoseconds, or for a time."""
        return Time.Sleep(duration if isinstance(duration, Time) else duration * 1e-9)

    @staticmethod
    def SecToNano(seconds: float) -> float:
        """Seconds in nanoseconds."""
        return seconds * 1e9

    @staticmethod
    def MilToNano(milliseconds: float) -> float:
        """Milliseconds in nanoseconds."""
        return milliseconds * 1e6

    @staticmethod
    def MicToNano(microseconds: float) -> float:
        """Microseconds in nanoseconds."""
        return microseconds * 1e3

    def FormattedString(self, start: int = _Format.DAYS, end: int = _Format.MILLISECONDS) -> str:
        """The time as `DD HH:MM:SS.mmm`, or its part from `start` to `end`; units above `start` are converted to it.

        Raises:
            ParameterError: `start` lies below `end`, or they are no format options.
        """
        if not _Format.DAYS <= start <= end <= _Format.MILLISECONDS:
            raise ParameterError(f"FormattedString goes from Time.DAYS down to Time.MILLISECONDS, not {start} to {end}")
        rest, text = abs(self.nanoseconds) // 10**6, "-" if self.nanoseconds < 0 else ""
        units = ((86_400_000, 2, ""), (3_600_000, 2, " "), (60_000, 2, ":"), (1000, 2, ":"), (1, 3, "."))
        for option in range(start, end + 1):
            size, digits, before = units[option]
            count, rest = divmod(rest, size)
            text += f"{before if option > start else ''}{count:0{digits}d}"
        return text

    Float = Double
    __float__ = Double
    GetWallTimeAsString = GetWallTimeAsISOString


_new = object.__new__
