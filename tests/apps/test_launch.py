"""The installed commands: each launches its module."""

import gc
from importlib import import_module, metadata

import pytest

from libgz.apps.launch import importing


@pytest.mark.parametrize("name", ["gazebo", "gzclient", "gzserver", "libgz"])
def test_an_installed_command_runs_its_module_with_garbage_collection(name, monkeypatch):
    seen = []
    module = import_module(f"libgz.apps.{name}")
    monkeypatch.setattr(module, "main", lambda: seen.append(gc.isenabled()) or 7)
    (entry,) = metadata.entry_points(group="console_scripts", name=name)
    try:
        assert entry.load()() == 7
    finally:
        gc.unfreeze()
    assert seen == [True]


def test_imports_are_not_searched_for_garbage():
    with importing():
        assert not gc.isenabled()
    try:
        assert gc.isenabled()
        assert gc.get_freeze_count() > 1000
    finally:
        gc.unfreeze()
