"""Amounts that objects share."""

import re

import pytest

from libgz.base.errors import ParameterError
from libgz.base.quota import Quota


class Owner:
    """Anything."""


def test_all_objects_together_are_bounded():
    quota, first, second = Quota("rays", 100), Owner(), Owner()
    quota.set(first, 60)
    quota.set(second, 40)
    with pytest.raises(ParameterError, match=re.escape("with 70 more rays the world would have 110; at most 100")):
        quota.set(first, 70)
    assert quota.used == 100
    quota.set(second, 10)
    quota.set(first, 90)
    assert quota.used == 100


def test_what_is_closed_or_collected_has_nothing():
    quota, first, second = Quota("rays", 100), Owner(), Owner()
    quota.set(first, 60)
    quota.set(second, 40)
    quota.set(second, 0)
    del first
    assert quota.used == 0
    quota.set(second, 100)
