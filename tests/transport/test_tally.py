"""Bounds on what clients cost a server: log lines and waits."""

import time

import pytest

from libgz.transport.guard import Guard
from libgz.transport.patience import MOST, SHARE, Patience
from libgz.transport.tally import Tally


def test_a_cause_is_logged_at_growing_counts():
    tally = Tally()
    logged = [number for number in range(1, 20001) if tally.due("cause")]
    assert logged == [1, 100, 1000, 10000]
    assert tally.times("cause") == " (20000 times so far)"
    assert tally.due("another")
    assert tally.times("another") == ""


def test_the_first_ones_can_be_logged_each():
    tally = Tally(first=3)
    assert [number for number in range(1, 2001) if tally.due("cause")] == [1, 2, 3, 100, 1000]


def test_counts_can_grow_by_more_than_one():
    tally = Tally()
    assert tally.due("cause", 5000)
    assert not tally.due("cause", 4999)
    assert tally.due("cause")


def test_waits_are_a_small_share_of_the_time():
    patience, now = Patience(), time.monotonic()
    assert patience.left(now) == pytest.approx(MOST)
    patience.spend(MOST)
    assert patience.left(now) == 0.0
    assert patience.left(now + 0.1) == pytest.approx(0.1 * SHARE)
    assert patience.left(now + 1000.0) == MOST


def test_switches_are_0_or_1(caplog):
    guard = Guard("guicam.o")
    assert guard.switch("roll_lock", 1, False)
    assert not guard.switch("roll_lock", 0, True)
    for number in (2, -1, 2**31 - 1):
        assert guard.switch("roll_lock", number, True)
        assert not guard.switch("roll_lock", number, False)
    assert caplog.messages == ["a client wrote guicam.o: roll_lock is 2, neither 0 nor 1, and is ignored"]
