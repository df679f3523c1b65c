"""Fixtures of tests of Gazebo classic's worlds."""

import pytest
from plugin_worlds import keep_to, worlds_of_elements


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Makes a world of some elements: (engine's world, view). Plugins are found in `tmp_path`, too."""
    keep_to(tmp_path, monkeypatch)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    yield from worlds_of_elements()
