"""What plugins share: times, stopwatches, animations, messages, search paths, the globe."""

import copy
import logging
import math
import pickle
import sys
from datetime import datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from libgz.classic import common
from libgz.classic.common import PID, Time, Timer, UpdateInfo
from libgz.classic.math import PID as MATH_PID
from libgz.errors import ParameterError
from libgz.sdf.value import parse

# Times


def test_a_time_is_normalised_with_one_sign():
    assert (Time(1, 2_500_000_000).sec, Time(1, 2_500_000_000).nsec) == (3, 500_000_000)
    assert (Time(-0.5).sec, Time(-0.5).nsec) == (0, -500_000_000)
    assert (Time(1, -1).sec, Time(1, -1).nsec) == (0, 999_999_999)
    assert (Time(-1.25).sec, Time(-1.25).nsec) == (-1, -250_000_000)
    assert Time(1.5) == Time(1, 500_000_000) == Time(Time(1.5))
    assert Time() == Time.Zero == 0
    for wrong in (math.nan, math.inf):
        with pytest.raises(ParameterError, match="finite"):
            Time(wrong)


def test_a_time_as_numbers_and_texts():
    t = Time(3, 250_000_000)
    assert t.Double() == t.Float() == float(t) == 3.25
    assert str(t) == "3 250000000"
    assert repr(t) == "Time(3, 250000000)"
    assert parse(Time, "3 250000000") == parse(Time, "3.25") == t
    with pytest.raises(ParameterError, match="Time"):
        parse(Time, "1 2 3")
    t.sec = 5
    t.nsec = 1
    assert t == Time(5, 1)
    t.Set(2.0)
    assert t == 2
    assert not Time.Zero
    assert copy.copy(t) == pickle.loads(pickle.dumps(t)) == t


def test_times_add_up_exactly():
    step, now = Time(0.001), Time()
    for _ in range(10_000):
        now += step
    assert now == 10
    assert now.Double() == 10.0
    held = now
    now -= 0.5
    assert (held, now) == (Time(10), Time(9.5))
    assert 10.0 - now == 0.5 + Time.Zero
    assert -now == Time(-9.5)
    assert (Time(3) / Time(2)).Double() == 1.5
    assert Time(3) * 2 == 2 * Time(3) == 6
    assert 3.0 / Time(2) == 1.5
    assert np.float64(2.0) * Time(3) == 6
    assert type(np.float64(2.0) + Time(3)) is Time
    assert Time.Hour == 60 * Time.Minute == 3600 * Time.Second


def test_times_compare_with_numbers():
    t = Time(0.3)
    assert t == 0.1 + 0.2  # to the nanosecond
    assert 0.2 < t <= 0.3
    assert t > Time(0.2)
    assert t < math.inf
    assert t > -math.inf
    assert t != math.nan
    assert not t < math.nan
    assert t != "0.3"
    with pytest.raises(TypeError):
        _ = t < "1"


nanoseconds = st.integers(-(10**18), 10**18)


@given(nanoseconds, nanoseconds)
def test_times_are_whole_nanoseconds(a, b):
    s, t = Time.from_nanoseconds(a), Time.from_nanoseconds(b)
    assert (s + t).nanoseconds == a + b
    assert (s - t).nanoseconds == a - b
    assert (s < t, s == t, s >= t) == (a < b, a == b, a >= b)
    assert s.sec * 10**9 + s.nsec == a
    assert abs(s.nsec) < 10**9
    assert s.sec * s.nsec >= 0
    assert Time(s.sec, s.nsec) == s


@given(st.floats(-1e6, 1e6))
def test_seconds_come_back_to_half_a_nanosecond(seconds):
    assert abs(Time(seconds).Double() - seconds) <= 0.5e-9 + 1e-15 * abs(seconds)


def test_formatted_times():
    t = Time(2 * 86400 + 3 * 3600 + 4 * 60 + 5, 67_000_000)
    assert t.FormattedString() == "02 03:04:05.067"
    assert t.FormattedString(Time.HOURS, Time.SECONDS) == "51:04:05"
    assert t.FormattedString(Time.SECONDS) == "183845.067"
    with pytest.raises(ParameterError, match="FormattedString"):
        t.FormattedString(Time.SECONDS, Time.HOURS)


def test_the_clock_on_the_wall():
    before = Time.GetWallTime()
    later = Time()
    later.SetToWallTime()
    assert 0 <= later - before < 3600
    assert datetime.fromisoformat(Time.GetWallTimeAsISOString()[:26]).year >= 2024
    assert Time.NSleep(1000) == Time.MSleep(1) == Time.Sleep(Time(0.0005)) == 0
    assert (Time.SecToNano(2), Time.MilToNano(2), Time.MicToNano(2)) == (2e9, 2e6, 2e3)


def test_a_stopwatch():
    timer = Timer()
    assert not timer.GetRunning()
    assert timer.GetElapsed() == 0
    timer.Start()
    assert timer.Running()
    Time.MSleep(2)
    timer.Stop()
    halted = timer.GetElapsed()
    assert halted >= 0.002
    assert timer.GetElapsed() == halted
    timer.Start()
    assert timer.GetElapsed() >= halted
    timer.Reset()
    assert timer.GetElapsed() == 0


def test_what_a_callback_is_told():
    info = UpdateInfo("default", Time(1.0), Time(2.0))
    assert (info.worldName, info.simTime.Double(), info.realTime.sec) == ("default", 1.0, 2)
    assert UpdateInfo() == UpdateInfo("", Time.Zero, Time.Zero)


def test_a_pid_takes_a_time():
    assert PID is MATH_PID
    assert PID(1.0, 1.0, 0.0, 10.0, -10.0).Update(2.0, Time(0.5)) == -3.0


__all__ = ["common", "logging", "sys"]
