"""The installed commands: each launches its module."""

import gc
from importlib import import_module, metadata
from types import SimpleNamespace

import pytest

from libgz.apps import launch


@pytest.mark.parametrize("name", ["gazebo", "gzclient", "gzserver", "libgz"])
def test_a_command_is_imported_without_garbage_collection_and_runs_with_it(name, monkeypatch):
    seen = []

    def import_one(module):
        assert import_module(module).main
        seen.append((module, gc.isenabled()))
        return SimpleNamespace(main=lambda: seen.append(("main", gc.isenabled())) or 7)

    monkeypatch.setattr(launch, "import_module", import_one)
    (entry,) = metadata.entry_points(group="console_scripts", name=name)
    try:
        assert entry.load()() == 7
    finally:
        gc.unfreeze()
    assert seen == [(f"libgz.apps.{name}", False), ("main", True)]
