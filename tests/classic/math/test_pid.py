"""The PID controllers of classic plugins."""

import math as pymath

import pytest

from libgz.classic.math import (
    PID,
)


def test_the_signs_and_terms_of_a_pid():
    pid = PID(2.0, 3.0, 0.5, 100.0, -100.0)
    assert pid.Update(1.0, 0.5) == -(2.0 * 1.0 + 3.0 * 0.5 + 0.5 * (1.0 / 0.5))
    assert pid.Update(3.0, 0.5) == -(2.0 * 3.0 + 3.0 * (0.5 + 1.5) + 0.5 * (2.0 / 0.5))
    assert pid.GetErrors() == (3.0, 2.0, 4.0)
    assert pid.GetCmd() == pid.cmd == -14.0
    pid.Reset()
    assert pid.GetErrors() == (0.0, 0.0, 0.0)
    assert (pid.GetPGain(), pid.IGain(), pid.GetDGain(), pid.IMax(), pid.GetCmdMax()) == (2.0, 3.0, 0.5, 100.0, -1.0)


def test_the_limits_of_a_pid():
    assert PID(0.0, 5.0, 0.0).Update(1.0, 1.0) == 0.0  # as classic's: limits of 0 switch the integral term off
    assert PID(0.0, 5.0, 0.0, -1.0, 0.0).Update(1.0, 1.0) == -5.0  # no limits
    pid = PID(0.0, 2.0, 0.0, 1.0, -1.0)
    for _ in range(50):
        assert pid.Update(10.0, 0.1) == -1.0
    assert pid.Update(-10.0, 0.1) == 1.0  # it has not wound up
    assert PID(0.0, 0.0, 0.0, -1.0, -2.0).Update(1.0, 1.0) == 1.0
    limited = PID(10.0, 0.0, 0.0, 0.0, 0.0, 4.0, -3.0)
    assert limited.Update(1.0, 0.1) == -3.0
    assert limited.Update(-1.0, 0.1) == 4.0
    assert PID(10.0).Update(1.0, 0.1) == -10.0


def test_a_pid_bears_odd_errors_and_no_time():
    pid = PID(1.0, 1.0, 1.0, 10.0, -10.0)
    assert pid.Update(1.0, 0.0) == pid.Update(pymath.nan, 0.1) == pid.Update(pymath.inf, 0.1) == 0.0
    assert pid.Update(1.0, 0.1) == pytest.approx(-(1.0 + 0.1 + 10.0))


def test_pids_are_keys_of_tables():
    one, other = PID(1.0), PID(1.0)
    assert {one: "one", other: "other"}[one] == "one"
