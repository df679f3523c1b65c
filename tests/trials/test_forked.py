"""The trials' own machinery: no failure is hidden."""

import os
import signal

from forked import run_trials

seen = []


def test_failures_that_pass_alone_are_counted():
    def trial(number):
        seen.append(number)
        if number == 3 and len(seen) > 1:
            return "wrong"
        if number == 7 and len(seen) > 1:
            os.kill(os.getpid(), signal.SIGKILL)
        if number == 9:
            raise ValueError("always")
        return ""

    found = {failure.number: failure for failure in run_trials(trial, range(12), 2)}
    assert sorted(found) == [3, 7, 9]
    assert (found[3].what, found[3].first) == ("after others: wrong", 0)
    assert (found[7].what, found[7].first) == ("after others: the process ended: SIGKILL", 0)
    assert "always" in found[9].what
    assert found[9].first is None
