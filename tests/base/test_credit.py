"""What may be spent of the time that passes."""

import pytest

from libgz.base.credit import Credit


def test_a_share_of_the_time_that_passes_may_be_spent_and_no_more_than_the_most_is_kept():
    credit = Credit(0.5, 2.0)
    assert credit.left == 2.0
    credit.earn(100.0)
    assert credit.left == 2.0
    credit.spend(1.5)
    credit.earn(1.0)
    assert credit.left == pytest.approx(1.0)


def test_a_debt_is_bounded_and_waits_for_its_share():
    credit = Credit(0.5, 2.0, debt=1.0)
    assert credit.wait == 0.0
    credit.spend(50.0)
    assert credit.left == -1.0
    assert credit.wait == pytest.approx(2.0)
    credit.earn(credit.wait)
    assert credit.left == pytest.approx(0.0)


def test_a_clock_that_goes_back_takes_nothing():
    credit = Credit(0.5, 2.0)
    credit.earn(-10.0)
    assert credit.left == 2.0
