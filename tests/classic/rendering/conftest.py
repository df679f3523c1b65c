"""Fixtures of the tests of classic's rendering."""

import pytest
from classic_scenes import keep_to, worlds_in


@pytest.fixture(autouse=True)
def own_folders(monkeypatch, tmp_path):
    """Plugins, models and materials are searched for in the test's folder only."""
    keep_to(tmp_path, monkeypatch)


@pytest.fixture
def world_of(tmp_path):
    """Makes a classic world of some elements."""
    yield from worlds_in(tmp_path)
