"""Fixtures of tests of the ready plugins."""

import pytest
from plugin_worlds import keep_to


@pytest.fixture(autouse=True)
def own_places(monkeypatch, tmp_path):
    """Only the plugins and models that come with libgz are found."""
    keep_to(tmp_path, monkeypatch)
