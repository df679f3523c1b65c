"""Lets worlds of Gazebo classic name C++ plugins."""

from __future__ import annotations

from pathlib import Path

from libgz.classic.loading import register_compiled
from libgz.simulation.plugins import Plugin

__all__ = ["register", "start_ignition"]


def _is_plugin(path: Path) -> bool:
    """Whether a file is a C++ plugin; what runs them is imported by worlds that name a shared object."""
    from libgz.classic_cxx.plugin import is_plugin

    return is_plugin(path)


def _load(path: Path) -> Plugin:
    from libgz.classic_cxx.plugin import load

    return load(path)


def register() -> None:
    """From now on, names of plugins may mean shared objects. Can be called twice."""
    register_compiled(_is_plugin, _load)


def start_ignition() -> None:
    """Obey joint commands of ignition-transport from now on; the library is built if it is not there.

    Raises:
        LibraryError: a package is missing, or building fails.
    """
    from libgz.classic_cxx.ignition import IgnitionTransport
    from libgz.classic_cxx.library import ignition_part

    IgnitionTransport.start(ignition_part())
