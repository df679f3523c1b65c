"""Numbers of clients: what is taken, clamped and ignored."""

import math

import pytest

from libgz.transport.guard import Guard


@pytest.mark.parametrize(
    ("value", "taken"),
    [
        (0.5, 0.5),
        (-2.0, -2.0),
        (2.0, 2.0),
        (2.1, 2.0),
        (-1e308, -2.0),
        (math.nan, 0.25),
        (math.inf, 0.25),
        (-math.inf, 0.25),
    ],
)
def test_numbers_are_clamped_or_ignored(value, taken, caplog):
    assert Guard("position.robot1").number("cmd", value, 0.25, 2.0) == taken
    assert len(caplog.messages) == (value != taken)


def test_switches_are_0_or_1(caplog):
    guard = Guard("laser.l")
    assert [guard.switch("cmd", value, True) for value in (0, 1, 2, -1)] == [False, True, True, True]
    assert "neither 0 nor 1" in caplog.messages[0]
