"""Bounds on what clients cost a server: log lines and waits."""

import time

import pytest

from libgz.transport.guard import Guard
from libgz.transport.patience import LEAST_WORK, MOST, SHARE, Patience
from libgz.transport.tally import Tally


def test_a_cause_is_logged_at_growing_counts():
    tally = Tally()
    logged = [number for number in range(1, 20001) if tally.due("cause")]
    assert logged == [1, 100, 1000, 10000]
    assert tally.times("cause") == " (20000 times so far)"
    assert tally.due("another")
    assert tally.times("another") == ""


def test_causes_that_clients_make_up_are_limited():
    tally = Tally(most=3)
    assert [number for number in range(1, 2001) if tally.due(number)] == [1, 2, 3, 4, 103, 1003]
    assert tally.times(2000) == " (1997 times so far)"
    assert tally.times(2) == ""
    assert not tally.due(2)


def test_counts_can_grow_by_more_than_one():
    tally = Tally()
    assert tally.due("cause", 5000)
    assert not tally.due("cause", 4999)
    assert tally.due("cause")


def test_waits_are_a_small_share_of_the_processor_time(monkeypatch):
    used = 0.0
    monkeypatch.setattr(time, "process_time", lambda: used)
    patience, now = Patience(), time.monotonic()
    assert patience.left(now) == pytest.approx(MOST)
    patience.spend(MOST)
    assert patience.left(now) == 0.0
    used = 0.3
    assert patience.left(now + 0.5) == pytest.approx(0.3 * SHARE)  # other processes have used the rest
    assert patience.left(now + 1.0) == pytest.approx((0.3 + 0.5 * LEAST_WORK) * SHARE)  # it slept, or had no processor
    assert patience.left(now + 1000.0) == MOST


def test_switches_are_0_or_1(caplog):
    guard = Guard("guicam.o")
    assert guard.switch("roll_lock", 1, False)
    assert not guard.switch("roll_lock", 0, True)
    for number in (2, -1, 2**31 - 1):
        assert guard.switch("roll_lock", number, True)
        assert not guard.switch("roll_lock", number, False)
    assert caplog.messages == ["a client wrote guicam.o: roll_lock is 2, neither 0 nor 1, and is ignored"]
